/**
 * @file nutate_runs.h
 * @brief Runs of steppers into histories, poll callbacks, and copies of steppers. Included by nutate.h,
 * which explains the notation. */
#ifndef NUTATE_RUNS_H
#define NUTATE_RUNS_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Runs to a time, as nutate_stepper_run_to does, and returns a history of all rows, or of rows at user-defined times.
 * @param[in,out] stepper   handle; on failure at the last state reached
 * @param[in]     end_time  end of the run, s
 * @param[in]     every     steps between rows, >= 1
 * @param[in]     interval  time between rows, s, or 0: see nutate_stepper_run_to
 * @param[in]     times     [n_times], times of the rows, s, in the order of the run: rows at exactly these times,
 *                          between steps to the accuracy of the method; or NULL
 * @param[in]     n_times   number of times
 * @param[out]    history   handle of the new history, also if the run fails: it then has all rows so far */
int nutate_stepper_run_history(nutate_stepper *stepper, double end_time, int64_t every, double interval,
                               const double *times, size_t n_times, nutate_history **history);

/** A run whose rows go to an array: all but the last three members are for the caller to set. */
typedef struct nutate_row_run {
    double end_time;         /**< end of the run, s */
    int64_t every;           /**< steps between rows, >= 1 */
    double interval;         /**< time between rows, s, or 0: see nutate_stepper_run_to */
    const double *times;     /**< [n_times], times of the rows, s, as for nutate_stepper_run_history; or NULL */
    size_t n_times;          /**< number of times */
    double *rows;            /**< [capacity][width], receives the rows; or NULL */
    size_t capacity;         /**< number of rows that the array can hold */
    int64_t counts[5];       /**< results as by nutate_history_summary */
    double errors[3];        /**< results as by nutate_history_summary */
    nutate_history *history; /**< handle of a new history; NULL if the array has all rows */
} nutate_row_run;

/** Runs to a time, as nutate_stepper_run_history does, and writes the rows into an array, also if the run fails. A
 * history is made only if the array has no room for all rows, or if there are events or indicators of chaos: it then has
 * all rows.
 * @param[in,out] stepper  handle; on failure at the last state reached
 * @param[in,out] run      the run */
int nutate_stepper_run_rows(nutate_stepper *stepper, nutate_row_run *run);

/** Makes subsequent runs compute sensitivities to the parameters in &free of a scene, starting at the beginning of each
 * run: the columns of the set "sensitivities" then show them, those of "standard_deviations" and "covariance" if &free
 * has sigma. A stepper that was made from a scene with &free has the parameters of that scene.
 * @param[in,out] stepper  handle of a stepper of the body and the effects of the scene
 * @param[in]     scene    handle of a scene with &free
 * @return status: NUTATE_BAD_SCENE if the motion has no derivative with respect to a parameter, NUTATE_BAD_ARGUMENT
 *         without &free. */
int nutate_stepper_differentiate(nutate_stepper *stepper, const nutate_scene *scene);

/** Makes subsequent runs compute indicators of chaos, starting at the beginning of each run: nutate_history_chaos
 * returns them, and the columns of the sets "lyapunov", "megno" and "fli" show them. A stepper that was made from a
 * scene with &chaos computes its indicators.
 * @param[in,out] stepper  handle
 * @param[in]     scene    handle of a scene; without &chaos in it, runs compute none */
int nutate_stepper_follow_chaos(nutate_stepper *stepper, const nutate_scene *scene);

/** Computes rows inside a step of an earlier run by repeating the step: with dense output if the method has it, else
 * with one step to each row. Torques that start or stop inside, and failures, shorten it; further steps continue from
 * its end. The stepper and its runs are unaffected.
 * @param[in,out] stepper      handle
 * @param[in]     t            time at the start of the step, s, from a row: work and energy_residual are counted from
 *                             there
 * @param[in]     q            [4], attitude at the start of the step, from the same row
 * @param[in]     p            [4], conjugate momentum at the start of the step, kg m2/s, from the same row
 * @param[in]     derivatives  [parameters][6], from the same row: d_rotation1 to d_omega3 for each parameter; or NULL
 *                             if the columns have none
 * @param[in]     dt           length of the step, s; if local_tolerance is set, taylor and exact choose shorter ones
 * @param[in]     n            number of rows
 * @param[in]     times        [n], times of the rows, s, in order from t on
 * @param[out]    rows         [n][width], rows of the columns chosen
 * @return status: NUTATE_BAD_ARGUMENT, also with n = 0, if q and p are not the whole state: with wheels, and
 *         controllers that have a sample or limits. */
int nutate_stepper_dense_output(nutate_stepper *stepper, double t, const double q[4], const double p[4],
                                const double *derivatives, double dt, size_t n, const double *times, double *rows);

/** Returns the error estimates of a run with accuracy; zeros for any other. The accuracy was not attained if error[0]
 * exceeds accuracy.
 * @param[in]  history   handle
 * @param[out] error     [2], estimated attitude error at the end of the run, rad, and the part of it due to round-off;
 *                       or NULL
 * @param[out] accuracy  the requested accuracy, rad; or NULL */
int nutate_history_accuracy(const nutate_history *history, double error[2], double *accuracy);

/** Returns the indicators of chaos of a run that computed them (docs/explanation/chaos.md); n is 0 for other runs.
 * @param[in]  history    handle
 * @param[out] n          number of exponents: 0, 1 or 6; or NULL
 * @param[out] exponents  [6], Lyapunov exponents, 1/s, the first n; or NULL
 * @param[out] megno      mean MEGNO; or NULL
 * @param[out] fli        fast Lyapunov indicator; or NULL
 * @param[out] time       time that they span, s; or NULL */
int nutate_history_chaos(const nutate_history *history, size_t *n, double exponents[6], double *megno, double *fli,
                         double *time);

/** Returns the value in force for a setting; prepares the method.
 * @param[in,out] stepper  handle
 * @param[in]     key      method, choice (why the method was chosen; empty if it was given), formulation, order,
 *                         series_order (0: chosen by the tolerance), conserve, time_step, accuracy, or local_tolerance
 *                         (with an accuracy: the value found by the trial runs of the last run)
 * @param[out]    buffer   the value in the notation of scene files, strings without quotes
 * @param[in]     size     size of buffer, bytes */
int nutate_stepper_get(nutate_stepper *stepper, const char *key, char *buffer, size_t size);

/* ---- Poll callbacks ---------------------------------------------------------------------------------------------- */

/** A poll callback, called about fifty times a second between two steps of a run, trial runs included. The thread of
 * the run calls it; it must return.
 * @param[in,out] user  as given to the set function
 * @return 0, or another number to end the run with NUTATE_STOPPED, at the last state reached and with the rows so far
 */
typedef int (*nutate_poll)(void *user);

/** Sets the poll callback of a stepper's runs. Copies do not inherit it.
 * @param[in,out] stepper  handle
 * @param[in]     poll     poll callback; NULL for none
 * @param[in,out] user     passed through; or NULL */
int nutate_stepper_set_poll(nutate_stepper *stepper, nutate_poll poll, void *user);

/** Sets the poll callback of runs and fits of a scene.
 * @param[in,out] scene  handle
 * @param[in]     poll   poll callback; NULL for none
 * @param[in,out] user   passed through; or NULL */
int nutate_scene_set_poll(nutate_scene *scene, nutate_poll poll, void *user);

/* ---- Copies ------------------------------------------------------------------------------------------------------ */

/** Copies a stepper. The copy is independent and continues with identical results; callbacks are shared.
 * @param[in]  stepper  handle; the stepper is unchanged
 * @param[out] copy     handle of the copy; NULL on failure
 * @param[out] message  error message; or NULL
 * @param[in]  size     size of message, bytes */
int nutate_stepper_copy(nutate_stepper *stepper, nutate_stepper **copy, char *message, size_t size);

/** Saves the state of a stepper as bytes, which this version on this kind of machine can restore.
 * @param[in]  stepper  handle; the stepper is unchanged
 * @param[out] bytes    [size], the state; or NULL, to query how many are needed
 * @param[in]  size     size of bytes
 * @param[out] needed   number of bytes needed; or NULL
 * @return status: NUTATE_TRUNCATED if size is too small. */
int nutate_stepper_save(nutate_stepper *stepper, char *bytes, size_t size, size_t *needed);

/** Restores saved bytes into another stepper of the same system, with the same settings, columns and events (in the
 * same order): it then continues with identical results. The step that was kept for nutate_stepper_state_at is not
 * saved.
 * @param[in,out] stepper  handle
 * @param[in]     bytes    [size], bytes of nutate_stepper_save
 * @param[in]     size     number of bytes
 * @return status: NUTATE_BAD_ARGUMENT for bytes of another stepper, of other settings or of another version, and for
 *         damaged ones whose state is impossible; the stepper is then unchanged. */
int nutate_stepper_restore(nutate_stepper *stepper, const char *bytes, size_t size);

#ifdef __cplusplus
}
#endif

#endif
