/**
 * @file nutate_stepper.h
 * @brief Steppers, and reading their state. Included by nutate.h, which explains the notation. */
#ifndef NUTATE_STEPPER_H
#define NUTATE_STEPPER_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Creating and running ---------------------------------------------------------------------------------------- */

/** Creates a stepper for a system: method nielsen_krenk of order 2; state at t = 0, attitude 1, at rest.
 * @param[in]  system   handle; the system is copied
 * @param[out] stepper  handle of the new stepper; NULL on failure
 * @param[out] message  error message; or NULL
 * @param[in]  size     size of message, bytes */
int nutate_stepper_create(const nutate_system *system, nutate_stepper **stepper, char *message, size_t size);

/** Creates a stepper for a scene: its system, initial state, method, time step and columns. nutate_stepper_run_to its
 * end time gives bit for bit the numbers of `nutate run`. A scene none of whose columns depends on the attitude may be
 * integrated without it: functions that read the attitude, l or p then give NUTATE_BAD_ARGUMENT (see
 * nutate_stepper_set_columns).
 * @param[in]  scene    handle; the scene is copied
 * @param[out] stepper  handle of the new stepper; NULL on failure
 * @param[out] message  error message; or NULL
 * @param[in]  size     size of message, bytes */
int nutate_stepper_create_scene(const nutate_scene *scene, nutate_stepper **stepper, char *message, size_t size);

/** Frees a stepper. @param[in,out] stepper handle; NULL afterwards */
int nutate_stepper_destroy(nutate_stepper **stepper);

/** Sets a key of the group &integrator: method, order, formulation, time_step (or accuracy, or local_tolerance),
 * max_step, auxiliary_inertia, projection, conserve, series_order, tolerance, max_iterations. "auto" requires accuracy
 * or local_tolerance, and is the default with them (docs/reference/scenes/integrator.md); each run to a time chooses
 * anew. Settings take effect with the next step, or with nutate_stepper_prepare, which reports conflicts between
 * settings.
 * @param[in,out] stepper  handle
 * @param[in]     key      name of the key, such as "method"
 * @param[in]     value    its value as text, such as "dop853", "4", "1e-3", ".false." */
int nutate_stepper_set(nutate_stepper *stepper, const char *key, const char *value);

/** Sets the fixed step of nutate_stepper_run and ..._run_to.
 * @param[in,out] stepper    handle
 * @param[in]     time_step  length of a step, s; negative to integrate backward; not 0 */
int nutate_stepper_set_time_step(nutate_stepper *stepper, double time_step);

/** Prepares the method: checks the settings together and allocates memory, so that later steps do not. Without this
 * call the first step prepares.
 * @param[in,out] stepper  handle */
int nutate_stepper_prepare(nutate_stepper *stepper);

/** Sets the state; energy_residual and work are counted from here.
 * @param[in,out] stepper  handle
 * @param[in]     t        time, s
 * @param[in]     q        [4], attitude, body to space, unit to 1e-6, is normalised
 * @param[in]     omega    [3], angular velocity, body axes, rad/s */
int nutate_stepper_set_state(nutate_stepper *stepper, double t, const double q[4], const double omega[3]);

/** Sets the state by attitude and conjugate momentum, without normalizing.
 * @param[in,out] stepper  handle
 * @param[in]     t        time, s
 * @param[in]     q        [4], attitude, body to space, unit to 1e-6, is not normalised
 * @param[in]     p        [4], conjugate momentum, p = 2 q o [0, L], kg m2/s */
int nutate_stepper_set_canonical(nutate_stepper *stepper, double t, const double q[4], const double p[4]);

/** Performs one step of the method, of any length, without subdividing it: where a torque starts or stops in it, or a
 * table has a line, its order is lost (nutate_stepper_run_to ends steps there).
 * @param[in,out] stepper  handle; on failure the state is as it was
 * @param[in]     dt       length of the step, s; negative to integrate backward; not 0
 * @return status: NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH, NUTATE_SINGULAR: try a shorter step. NUTATE_NOT_FINITE,
 *         NUTATE_CALLBACK, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY: an inertia that varies is that of no rigid body. */
int nutate_stepper_step(nutate_stepper *stepper, double dt);

/** Performs n steps of the same length, as n calls of nutate_stepper_step would.
 * @param[in,out] stepper  handle; on failure at the state before the step that failed
 * @param[in]     dt       length of the step, s; negative to integrate backward; not 0
 * @param[in]     n        number of steps, >= 0
 * @param[out]    done     steps done, also on failure; or NULL */
int nutate_stepper_steps(nutate_stepper *stepper, double dt, int64_t n, int64_t *done);

/** Stores the start of each step from now on, for nutate_stepper_state_at. @param[in,out] stepper handle */
int nutate_stepper_keep_steps(nutate_stepper *stepper);

/** Returns the state at a time inside the last step that was kept, to the accuracy of the method; later steps are
 * unaffected.
 * @param[in,out] stepper  handle
 * @param[in]     t        time, s
 * @param[out]    q        [4], attitude, body to space
 * @param[out]    omega    [3], angular velocity, body axes, rad/s
 * @return status: NUTATE_BAD_ARGUMENT for other times. */
int nutate_stepper_state_at(nutate_stepper *stepper, double t, double q[4], double omega[3]);

/** Performs fixed steps of length time_step, as `nutate run` does. The k-th ends at t0 + k time_step; steps end where
 * torques start and stop; a step that fails is subdivided. Consecutive calls, also of nutate_stepper_run_to, continue
 * the count of steps.
 * @param[in,out] stepper   handle; on failure at the last state reached; if a callback failed, the state before the
 *                          step
 * @param[in]     n         number of steps, >= 0
 * @param[in]     every     steps of this call between rows, >= 1
 * @param[out]    rows      [capacity][width], rows of the columns chosen, n/every of them; or NULL: none
 * @param[in]     capacity  rows that fit into rows, at least n/every; 0 with NULL
 * @param[out]    n_rows    rows written, also on failure; or NULL */
int nutate_stepper_run(nutate_stepper *stepper, int64_t n, int64_t every, double *rows, size_t capacity,
                       size_t *n_rows);

/** Runs to a time: with fixed steps, the last one shortened to end there; or, if accuracy or local_tolerance is set,
 * with adaptive steps.
 * @param[in,out] stepper   handle; on failure at the last state reached
 * @param[in]     end_time  end of the run, s
 * @param[in]     every     steps between rows, >= 1; ignored if steps are adaptive and interval > 0
 * @param[in]     interval  time between rows, s, if steps are adaptive; else 0
 * @param[out]    rows      [capacity][width], rows of the columns chosen: first state, output points, last state; or
 *                          NULL
 * @param[in]     capacity  rows that fit into rows; a run that has more stops with NUTATE_STEP_LIMIT. 0 with NULL
 * @param[out]    n_rows    rows written, also on failure; or NULL */
int nutate_stepper_run_to(nutate_stepper *stepper, double end_time, int64_t every, double interval, double *rows,
                          size_t capacity, size_t *n_rows);

/** Returns the number of rows of nutate_stepper_run_to with fixed steps.
 * @param[in]  stepper   handle; after nutate_stepper_set, prepared by nutate_stepper_prepare or a step
 * @param[in]  end_time  end of the run, s
 * @param[in]  every     steps between rows, >= 1
 * @param[out] n_rows    number of rows */
int nutate_stepper_count_rows(const nutate_stepper *stepper, double end_time, int64_t every, size_t *n_rows);

/** Chooses the columns of rows; t is always the first.
 * @param[in,out] stepper  handle
 * @param[in]     sets     names separated by commas, as in columns of the group &output of a scene: quaternion,
 *                         angular_velocity, euler, energy, jacobi, orbit, wheel1, ... (docs/reference/columns.md lists
 *                         all) */
int nutate_stepper_set_columns(nutate_stepper *stepper, const char *sets);

/** Returns the number of columns of a row. @param[in] stepper handle @param[out] width number of columns */
int nutate_stepper_width(const nutate_stepper *stepper, size_t *width);

/** Returns the name of a column.
 * @param[in]  stepper  handle
 * @param[in]  column   index of the column; 0 is "t"
 * @param[out] buffer   name
 * @param[in]  size     size of buffer, bytes */
int nutate_stepper_column(const nutate_stepper *stepper, size_t column, char *buffer, size_t size);

/** Returns the names of all columns.
 * @param[in]  stepper  handle
 * @param[out] buffer   names, separated by commas
 * @param[in]  size     size of buffer, bytes
 * @return status: NUTATE_TRUNCATED if size is too small. */
int nutate_stepper_column_names(const nutate_stepper *stepper, char *buffer, size_t size);

/** Returns the current state as a row.
 * @param[in,out] stepper  handle
 * @param[out]    row      [width], each number in the unit of its column
 * @param[in]     size     numbers that fit into row, at least width */
int nutate_stepper_row(nutate_stepper *stepper, double *row, size_t size);

/* ---- Reading a stepper ------------------------------------------------------------------------------------------- */

/** Returns the current time. @param[in] stepper handle @param[out] t time, s */
int nutate_stepper_time(const nutate_stepper *stepper, double *t);

/** Returns the current attitude. @param[in] stepper handle @param[out] q [4], body to space */
int nutate_stepper_quaternion(const nutate_stepper *stepper, double q[4]);

/** Returns the current conjugate momentum. @param[in] stepper handle @param[out] p [4], kg m2/s */
int nutate_stepper_conjugate_momentum(const nutate_stepper *stepper, double p[4]);

/** Returns the current angular velocity. @param[in] stepper handle @param[out] omega [3], body axes, rad/s */
int nutate_stepper_angular_velocity(const nutate_stepper *stepper, double omega[3]);

/** Returns the current angular velocity. @param[in] stepper handle @param[out] omega [3], space axes, rad/s */
int nutate_stepper_angular_velocity_space(const nutate_stepper *stepper, double omega[3]);

/** Returns the current angular momentum. @param[in] stepper handle @param[out] L [3], body axes, N m s */
int nutate_stepper_angular_momentum(const nutate_stepper *stepper, double L[3]);

/** Returns the current angular momentum. @param[in] stepper handle @param[out] l [3], space axes, N m s */
int nutate_stepper_angular_momentum_space(const nutate_stepper *stepper, double l[3]);

/** Returns the current rotation matrix. @param[in] stepper handle @param[out] r [3][3], body to space */
int nutate_stepper_matrix(const nutate_stepper *stepper, double r[3][3]);

/** Returns the current Euler angles.
 * @param[in]  stepper  handle
 * @param[out] angles   [3], phi, theta, psi (z-x-z), rad, +-pi */
int nutate_stepper_euler(const nutate_stepper *stepper, double angles[3]);

/** Returns energies; calls user-defined potentials.
 * @param[in,out] stepper  handle
 * @param[out]    energy   [5], J: kinetic, potential, total, work of all torques since the state was set, and the
 *                         change of total (of the Jacobi integral if the space axes rotate) less that work and that of
 *                         time-dependent potentials
 * @return status: NUTATE_CALLBACK, NUTATE_NOT_FINITE from callbacks. */
int nutate_stepper_energy(nutate_stepper *stepper, double energy[5]);

/** Returns the current residuals of the constraints.
 * @param[in]  stepper      handle
 * @param[out] constraints  [2], q.q - 1, q.p (kg m2/s) */
int nutate_stepper_constraints(const nutate_stepper *stepper, double constraints[2]);

/** Returns which components of the inertial angular momentum are conserved.
 * @param[in]  stepper     handle
 * @param[out] components  number of conserved components: 0 none, 1 the one along axis, 3 all
 * @param[out] axis        [3], unit vector, space axes; zero unless components is 1; or NULL */
int nutate_stepper_conserved(const nutate_stepper *stepper, int *components, double *axis);

/** Returns the error estimates of the last nutate_stepper_run_to with accuracy; zeros if there was none. The accuracy
 * was not attained if error[0] exceeds it.
 * @param[in]  stepper  handle
 * @param[out] error    [2], an estimate of the attitude error at its end, rad, and the part of it due to round-off,
 *                      whatever the steps */
int nutate_stepper_accuracy(const nutate_stepper *stepper, double error[2]);

/** Returns the Newton iterations and the residual of the last step.
 * @param[in]  stepper     handle
 * @param[out] iterations  Newton iterations; or NULL
 * @param[out] residual    last increment over that of the step; or NULL */
int nutate_stepper_solver(const nutate_stepper *stepper, int *iterations, double *residual);

/** Returns the number of uncertified steps since the state was set.
 * @param[in]  stepper  handle
 * @param[out] steps    number of steps */
int nutate_stepper_uncertified(const nutate_stepper *stepper, int64_t *steps);

#ifdef __cplusplus
}
#endif

#endif
