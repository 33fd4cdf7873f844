/* nutate_events.h: events and tables of programs; included by nutate.h, which explains the words and arrows.
 *
 * Events are moments at which a quantity of the motion crosses a value, or has an extremum. They are found inside the
 * steps of nutate_stepper_run and nutate_stepper_run_to, as docs/reference/scenes/event.md says of scenes; steps by hand
 * look for none.
 * Runs in a row are one: their steps, rows and events are those of a single run, to the last bit. One that an event ends
 * leaves the state there, and the next one goes on behind it, its nominal steps counted from there: counts of events go on
 * too, and effects stay as they were switched, until a state is set. Its rows end with one at the event, for which
 * nutate_stepper_run needs room beside the others. */
#ifndef NUTATE_EVENTS_H
#define NUTATE_EVENTS_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A quantity g of the motion, a smooth function of its arguments. It returns 0, or another number to report a failure.
 *   ==>  t         s
 *   ==>  q         [4], attitude, body to space; its length may differ from 1 by 1e-4
 *   ==>  omega     [3], angular velocity, body axes, rad/s
 *   <=>  user      as given to the add function
 *   <==  g */
typedef int (*nutate_quantity)(double t, const double q[4], const double omega[3], void *user, double *g);

/* Adds events by groups &event of a scene: "&event when = 'omega3', crosses = 0, stop = .true. /".
 *   <=>  stepper; one of a scene has those of the scene   ==>  groups
 * Status: NUTATE_BAD_SCENE for groups that a scene would reject; NUTATE_BAD_ARGUMENT for NULL. */
int nutate_stepper_add_events(nutate_stepper *stepper, const char *groups);

/* Adds an event of a user-defined quantity.
 *   ==>  quantity  must stay callable as long as the stepper is used
 *   ==>  user      passed through; or NULL
 *   ==>  group     one group &event, with name and without when and weights: "&event name = 'up', crosses = 0.5 /"
 * Status: as above. */
int nutate_stepper_add_event(nutate_stepper *stepper, nutate_quantity quantity, void *user, const char *group);

/* Returns how many events the last run has found, in the order of time.   ==>  stepper, history   <==  n */
int nutate_stepper_event_count(const nutate_stepper *stepper, size_t *n);
int nutate_history_event_count(const nutate_history *history, size_t *n);

/* Returns one event of the last run.
 *   ==>  i         from 0
 *   <==  name      of the event, [size] with its 0; or NULL with size 0
 *   <==  number    1 for the first of the event, 2, ...
 *   <==  t, s; q [4], omega [3] (body axes, rad/s); each may be NULL
 * Status: NUTATE_BAD_ARGUMENT for an i beyond the last. */
int nutate_stepper_event(const nutate_stepper *stepper, size_t i, char *name, size_t size, int64_t *number, double *t,
                         double q[4], double omega[3]);
int nutate_history_event(const nutate_history *history, size_t i, char *name, size_t size, int64_t *number, double *t,
                         double q[4], double omega[3]);

/* Adds a tabulated torque from memory, as &torque table = '...' reads one from a file.
 *   ==>  n         lines
 *   ==>  t         [n], s, increasing; two of linear interpolation may be the same, for a jump
 *   ==>  torque    [n][3], N m
 *   ==>  keys      keys of &torque that go with a table, "interpolation = 'cubic', outside = 'periodic'"; or NULL
 * Status: NUTATE_BAD_ARGUMENT for an invalid table, NUTATE_BAD_SCENE for invalid keys. */
int nutate_system_add_table(nutate_system *system, size_t n, const double *t, const double *torque, const char *keys);

#ifdef __cplusplus
}
#endif
#endif
