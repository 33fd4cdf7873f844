/* nutate: runs of steppers into histories, poll callbacks, and copies of steppers. Included by nutate.h,
 * which explains the notation. */
#ifndef NUTATE_RUNS_H
#define NUTATE_RUNS_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Runs to a time, as nutate_stepper_run_to does, and returns a history of all rows, or of rows at user-defined times.
 *   <=>  stepper   on failure at the last state reached
 *   ==>  end_time  s
 *   ==>  every     steps between rows, >= 1        ==>  interval  time between rows, s, or 0: see nutate_stepper_run_to
 *   ==>  times     [n_times], s, in the order of the run: rows at exactly these times, between steps to the accuracy of the
 *                  method; or NULL
 *   <==  history   the new handle, also if the run fails: it then has all rows so far */
int nutate_stepper_run_history(nutate_stepper *stepper, double end_time, int64_t every, double interval,
                               const double *times, size_t n_times, nutate_history **history);

/* Makes subsequent runs compute sensitivities to the parameters in &free of a scene, starting at the beginning of each run:
 * the columns of the set "sensitivities" then show them, those of "standard_deviations" and "covariance" if &free has sigma.
 * A stepper that was made from a scene with &free has the parameters of that scene.
 *   <=>  stepper   of the body and the effects of the scene
 *   ==>  scene     with &free
 * Status: NUTATE_BAD_SCENE if the motion has no derivative with respect to a parameter, NUTATE_BAD_ARGUMENT without &free. */
int nutate_stepper_differentiate(nutate_stepper *stepper, const nutate_scene *scene);
/* Makes subsequent runs compute indicators of chaos, starting at the beginning of each run:
 * nutate_history_chaos returns them, and the columns of the sets "lyapunov", "megno" and "fli" show them. A stepper that was made from a scene with &chaos computes its indicators.
 *   <=>  stepper   ==>  scene, with &chaos; without it, runs compute none */
int nutate_stepper_follow_chaos(nutate_stepper *stepper, const nutate_scene *scene);

/* Computes rows inside a step of an earlier run by repeating the step: with dense output if the method has it, else with
 * one step to each row. Torques that start or stop inside, and failures, shorten it; further steps continue from its end. The
 * stepper and its runs are unaffected.
 *   ==>  t, s; q [4]; p [4]   at the start of the step, from a row: work and energy_residual are counted from there
 *   ==>  derivatives          [parameters][6], from the same row: d_rotation1 to d_omega3 for each parameter; or NULL if the
 *                             columns have none
 *   ==>  dt     the step, s; if local_tolerance is set, taylor and exact choose shorter ones
 *   ==>  times  [n], s, in order from t on   <==  rows  [n][width] of the columns chosen
 * Status: NUTATE_BAD_ARGUMENT, also with n = 0, if q and p are not the whole state: with wheels, and controllers that
 * have a sample or limits. */
int nutate_stepper_dense_output(nutate_stepper *stepper, double t, const double q[4], const double p[4],
                                const double *derivatives, double dt, size_t n, const double *times, double *rows);

/* Returns the error estimates of a run with accuracy; zeros for any other. The accuracy was not attained if error[0] >
 * accuracy.
 *   <==  error     [2]: estimated attitude error at the end of the run, rad, and the part of it due to round-off; or NULL
 *   <==  accuracy  the requested accuracy, rad; or NULL */
int nutate_history_accuracy(const nutate_history *history, double error[2], double *accuracy);

/* Returns the indicators of chaos of a run that computed them (docs/explanation/chaos.md); n is 0 for other runs.
 *   <==  n          number of exponents: 0, 1 or 6; or NULL
 *   <==  exponents  [6], Lyapunov exponents, 1/s, the first n; or NULL
 *   <==  megno      mean MEGNO; or NULL              <==  fli   fast Lyapunov indicator; or NULL
 *   <==  time       time that they span, s; or NULL */
int nutate_history_chaos(const nutate_history *history, size_t *n, double exponents[6], double *megno, double *fli,
                         double *time);

/* Returns the value in force for a setting; prepares the method.
 *   ==>  key     method, choice (why the method was chosen; empty if it was given), formulation, order, series_order (0:
 *                chosen by the tolerance), conserve, time_step, accuracy, or local_tolerance (with an accuracy: the value
 *                found by the trial runs of the last run)
 *   <==  buffer  the value in the notation of scene files, strings without quotes   ==>  size */
int nutate_stepper_get(nutate_stepper *stepper, const char *key, char *buffer, size_t size);

/* ---- Poll callbacks ---------------------------------------------------------------------------------------------- */

/* A poll callback, called about fifty times a second between two steps of a run, trial runs included. A value other than 0
 * ends the run with NUTATE_STOPPED, at the last state reached and with the rows so far. The thread of the run calls it; it
 * must return.
 *   <=>  user, as given */
typedef int (*nutate_poll)(void *user);

/* Sets the poll callback of a stepper's runs; NULL for none. Copies do not inherit it.   <=>  stepper   ==>  poll, user */
int nutate_stepper_set_poll(nutate_stepper *stepper, nutate_poll poll, void *user);
/* Sets the poll callback of runs of a scene.   <=>  scene   ==>  poll, user */
int nutate_scene_set_poll(nutate_scene *scene, nutate_poll poll, void *user);

/* ---- Copies ------------------------------------------------------------------------------------------------------ */

/* Copies a stepper. The copy is independent and continues with identical results; callbacks are shared.
 *   ==>  stepper   is unchanged   <==  copy, the new handle   <==  message, or NULL   ==>  size */
int nutate_stepper_copy(nutate_stepper *stepper, nutate_stepper **copy, char *message, size_t size);

/* Saves the state of a stepper as bytes, which this version on this kind of machine can restore.
 *   ==>  stepper   is unchanged
 *   <==  bytes     [size]; or NULL, to query how many are needed
 *   <==  needed    number of bytes needed; or NULL
 * Status: NUTATE_TRUNCATED if size is too small. */
int nutate_stepper_save(nutate_stepper *stepper, char *bytes, size_t size, size_t *needed);

/* Restores saved bytes into another stepper of the same system, with the same settings, columns and events (in the same
 * order): it then continues with identical results. The step that was kept for nutate_stepper_state_at is not saved.
 *   ==>  bytes   [size]
 * Status: NUTATE_BAD_ARGUMENT for bytes of another stepper or version. */
int nutate_stepper_restore(nutate_stepper *stepper, const char *bytes, size_t size);

#ifdef __cplusplus
}
#endif

#endif
