/**
 * @file nutate_events.h
 * @brief Events, and tabulated torques from memory. Included by nutate.h, which explains the notation.
 *
 * An event occurs where a quantity of the motion crosses a value, or has an extremum. Events are located inside the
 * steps of nutate_stepper_run, ..._run_to and ..._run_history, as in scenes (docs/reference/scenes/event.md); single
 * steps locate none. Consecutive runs form one run: their steps, rows and events are those of a single run, bit for
 * bit. A run that an event ends leaves the state at the event; the next run continues from there and counts its fixed
 * steps from there. Counts of events continue too, and effects stay switched, until a state is set. The last row of
 * such a run is that of the event: nutate_stepper_run needs capacity for one more row. */
#ifndef NUTATE_EVENTS_H
#define NUTATE_EVENTS_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A user-defined quantity g of the motion, a smooth function of its arguments.
 * @param[in]     t      time, s
 * @param[in]     q      [4], attitude, body to space; its length may differ from 1 by 1e-4
 * @param[in]     omega  [3], absolute angular velocity, relative to the stars, body axes, rad/s
 * @param[in,out] user   as given to the add function
 * @param[out]    g      value of the quantity
 * @return 0, or another number to report a failure */
typedef int (*nutate_quantity)(double t, const double q[4], const double omega[3], void *user, double *g);

/** Adds events by groups &event of a scene.
 * @param[in,out] stepper  handle; a stepper of a scene has the events of the scene
 * @param[in]     groups   such as "&event when = 'omega3', crosses = 0, stop = .true. /"
 * @return status: NUTATE_BAD_SCENE for groups that a scene would reject; NUTATE_BAD_ARGUMENT for NULL. */
int nutate_stepper_add_events(nutate_stepper *stepper, const char *groups);

/** Adds an event of a user-defined quantity.
 * @param[in,out] stepper   handle
 * @param[in]     quantity  must stay callable as long as the stepper is used
 * @param[in,out] user      passed through; or NULL
 * @param[in]     group     one group &event, with the key name and without when and weights: "&event name = 'up',
 *                          crosses = 0.5 /"
 * @return status: as nutate_stepper_add_events. */
int nutate_stepper_add_event(nutate_stepper *stepper, nutate_quantity quantity, void *user, const char *group);

/** Returns the number of events that the last run has located.
 * @param[in]  stepper  handle
 * @param[out] n        number of events */
int nutate_stepper_event_count(const nutate_stepper *stepper, size_t *n);

/** Returns the number of events that the run of a history has located.
 * @param[in]  history  handle
 * @param[out] n        number of events */
int nutate_history_event_count(const nutate_history *history, size_t *n);

/** Returns one event of the last run, in the order of time.
 * @param[in]  stepper  handle
 * @param[in]  i        index of the event, counted from 0
 * @param[out] name     [size], name of the event; or NULL with size 0
 * @param[in]  size     size of name, bytes
 * @param[out] number   1 for the first occurrence of this event, 2, ...; or NULL
 * @param[out] t        time, s; or NULL
 * @param[out] q        [4], attitude, body to space; or NULL
 * @param[out] omega    [3], angular velocity, body axes, rad/s; or NULL
 * @return status: NUTATE_BAD_ARGUMENT for an i beyond the last. */
int nutate_stepper_event(const nutate_stepper *stepper, size_t i, char *name, size_t size, int64_t *number, double *t,
                         double q[4], double omega[3]);

/** Returns one event of the run of a history, in the order of time.
 * @param[in]  history  handle
 * @param[in]  i        index of the event, counted from 0
 * @param[out] name     [size], name of the event; or NULL with size 0
 * @param[in]  size     size of name, bytes
 * @param[out] number   1 for the first occurrence of this event, 2, ...; or NULL
 * @param[out] t        time, s; or NULL
 * @param[out] q        [4], attitude, body to space; or NULL
 * @param[out] omega    [3], angular velocity, body axes, rad/s; or NULL
 * @return status: NUTATE_BAD_ARGUMENT for an i beyond the last. */
int nutate_history_event(const nutate_history *history, size_t i, char *name, size_t size, int64_t *number, double *t,
                         double q[4], double omega[3]);

/** Adds a tabulated torque from memory; &torque table = '...' reads one from a file.
 * @param[in,out] system  handle
 * @param[in]     n       number of lines
 * @param[in]     t       [n], times, s, increasing; for linear interpolation two may be equal, which makes a jump
 * @param[in]     torque  [n][3], N m, body axes, or those of the key axes in keys
 * @param[in]     keys    keys of &torque that go with a table, "interpolation = 'cubic', outside = 'periodic'"; or NULL
 * @return status: NUTATE_BAD_ARGUMENT for an invalid table, NUTATE_BAD_SCENE for invalid keys. */
int nutate_system_add_table(nutate_system *system, size_t n, const double *t, const double *torque, const char *keys);

#ifdef __cplusplus
}
#endif
#endif
