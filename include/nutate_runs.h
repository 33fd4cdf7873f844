/* nutate: runs of steppers into histories, runs that can be asked to stop, and copies of steppers. Included by nutate.h,
 * which says what the words and arrows mean. */
#ifndef NUTATE_RUNS_H
#define NUTATE_RUNS_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* As nutate_stepper_run_to, with its rows in a history that has room for all of them, and at user-defined times if there
 * are any.
 *   <=>  stepper   on failure at the last state reached
 *   ==>  end_time  s
 *   ==>  every     steps between rows, >= 1        ==>  interval  time between rows, s, or 0: see nutate_stepper_run_to
 *   ==>  times     [n_times] times of the rows, s, in the order in which the run comes to them, and no others: rows between
 *                  steps are as good as the method; or NULL
 *   <==  history   the new handle, also where the run fails: it then has all rows so far */
int nutate_stepper_run_history(nutate_stepper *stepper, double end_time, int64_t every, double interval,
                               const double *times, size_t n_times, nutate_history **history);

/* Rows inside a step of an earlier run, taken again from its start: each row from there on, unless the method knows the
 * states inside. Torques that start or stop there, and what fails, make it shorter; after its end others follow. The stepper
 * and its runs do not notice.
 *   ==>  t, s; q [4]; p [4]   the start of the step, as a row had them: work and energy_residual count from there
 *   ==>  dt     the step, s; where local_tolerance is set, taylor and exact choose shorter ones
 *   ==>  times  [n], s, in order from t on   <==  rows  [n][width] of the columns chosen
 * Status: NUTATE_BAD_ARGUMENT, with n = 0 too, where a state has more to it than q and p: with wheels, and controllers that
 * sample or have limits. */
int nutate_stepper_look(nutate_stepper *stepper, double t, const double q[4], const double p[4], double dt, size_t n,
                        const double *times, double *rows);

/* What a run with accuracy came to; zeros for any other. Out of reach: error[0] > accuracy.
 *   <==  error     [2]: an estimate of the attitude error at its end, rad, and the part of it that is round-off; or NULL
 *   <==  accuracy  what was asked for, rad; or NULL */
int nutate_history_accuracy(const nutate_history *history, double error[2], double *accuracy);

/* What is in force, once a method is chosen: prepares it.
 *   ==>  key     method, choice (why it was chosen; empty where it was named), formulation, order, series_order (0: as the
 *                tolerance asks for), conserve, time_step, accuracy, or local_tolerance: with an accuracy that which pilot
 *                runs of the last run have found
 *   <==  buffer  the value as a scene file has it, a text without quotes   ==>  size */
int nutate_stepper_get(nutate_stepper *stepper, const char *key, char *buffer, size_t size);

/* ---- Runs that can be asked to stop ------------------------------------------------------------------------------ */

/* Asked some fifty times a second while a run or a row of steps goes on, trial runs included, between two steps. An answer
 * other than 0 ends it with NUTATE_STOPPED, at the last state reached and with the rows so far. It is called by the thread
 * that runs, and must return.   <=>  user, as given */
typedef int (*nutate_poll)(void *user);

/* Sets the poll callback of a stepper's runs; NULL for none. Copies do not inherit it.   <=>  stepper   ==>  poll, user */
int nutate_stepper_set_poll(nutate_stepper *stepper, nutate_poll poll, void *user);
/* The same for runs of a scene.   <=>  scene   ==>  poll, user */
int nutate_scene_set_poll(nutate_scene *scene, nutate_poll poll, void *user);

/* ---- Copies ------------------------------------------------------------------------------------------------------ */

/* A stepper that goes on as the first would, to the last digit, and is independent of it; callbacks are shared.
 *   ==>  stepper   is as it was   <==  copy, the new handle   <==  message, or NULL   ==>  size */
int nutate_stepper_copy(nutate_stepper *stepper, nutate_stepper **copy, char *message, size_t size);

/* All that changes in a stepper, as bytes that this version on this kind of machine can restore.
 *   ==>  stepper   is as it was
 *   <==  bytes     [size]; or NULL, to ask how many are needed
 *   <==  needed    bytes of the whole; or NULL
 * Status: NUTATE_TRUNCATED for too small a size. */
int nutate_stepper_save(nutate_stepper *stepper, char *bytes, size_t size, size_t *needed);

/* Puts them into another stepper of the same system, with the same settings and columns: it then goes on in the place of
 * the first, to the last digit, its events in the same order among them. The step that was kept for nutate_stepper_state_at
 * is not saved.
 *   ==>  bytes   [size]
 * Status: NUTATE_BAD_ARGUMENT for bytes of another stepper or version. */
int nutate_stepper_restore(nutate_stepper *stepper, const char *bytes, size_t size);

#ifdef __cplusplus
}
#endif

#endif
