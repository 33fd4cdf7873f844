/* nutate: rotation of rigid bodies, integrated with quaternions so that energy, momentum and the unit norm hold to
 * round-off at any step size (Nielsen & Krenk 2012).  C interface; usable from C++.
 *
 * A system is a body and what acts on it. A stepper moves the state of one system by steps. A scene is a file that
 * says all of this; it can be run as a whole, or give a system or a stepper. A history is what a run leaves in memory.
 *
 *    #include <nutate.h>
 *    #include <stdio.h>
 *
 *    int main(void)
 *    {
 *        const double edges[3] = {4, 1, 2}, q[4] = {1, 0, 0, 0}, omega[3] = {0.1, 0, 10};
 *        double energy[5];
 *        nutate_system *box = NULL;
 *        nutate_stepper *stepper = NULL;
 *        int status = nutate_system_create_shape("box", edges, 3, 12.0, 0.0, NULL, &box, NULL, 0);
 *        if (!status) status = nutate_stepper_create(box, &stepper, NULL, 0);
 *        if (!status) status = nutate_stepper_set_state(stepper, 0.0, q, omega);
 *        for (int i = 0; i < 1000 && !status; ++i) status = nutate_stepper_step(stepper, 0.01);
 *        if (!status) status = nutate_stepper_energy(stepper, energy);
 *        if (!status) printf("%.15g J, off by %.1e J\n", energy[2], energy[4]);
 *        nutate_stepper_destroy(&stepper);
 *        nutate_system_destroy(&box);
 *        return status;
 *    }
 *
 * Conventions
 *    ==>  the library reads this argument        <==  it writes it        <=>  both
 *    A handle of which nothing more is to be said is not listed: const says whether the function changes it.
 *    Every function returns NUTATE_OK (0) or another status; on failure nothing has changed, and what a function would
 *    have written is untouched unless it says otherwise. No argument may be NULL unless it says "or NULL"; a NULL is
 *    reported, never followed.
 *    SI units; angles in radians. Space axes are inertial, body axes fixed in the body; both start at the reference
 *    point of the body, which stays at rest. Quaternions are unit quaternions, scalar first, and take body components
 *    to space components. Arrays are contiguous; [3][3] is row by row.
 *    Numbers that are set keep to the limits of the keys of scene files, and are refused in the same words:
 *    finite, zero or 1e-300 to 1e100 in size; positive ones at least 1e-100; steps 1e-50 to 1e50 s in size. Times and
 *    states, which a program may carry from call to call, may be as small as they have become.
 *    Truth values are int: 0 or another number. Strings end with NUL; UTF-8 passes through unchanged. Texts are handed
 *    back as (buffer, size): they are cut to size - 1 bytes and always end with NUL; a text that was cut gives
 *    NUTATE_TRUNCATED. Functions without a handle to ask for a message hand it back as (message, size): why they failed.
 *    A message may be NULL (with any size), and cutting it is no failure.
 *
 * Handles
 *    A create function sets *handle, to NULL where it fails; the destroy function frees it and sets *handle to NULL
 *    (a NULL in *handle is fine). A handle that is NULL, of another kind or destroyed gives NUTATE_BAD_HANDLE, as far as
 *    that can be seen in the memory it points to. A stepper has a copy of its system: the system may be changed or
 *    destroyed afterwards without effect on it.
 *
 * Threads
 *    The library has no state of its own. A handle that a function takes as const may be used by several threads at
 *    once; a handle that is not const by one at a time. Different handles are independent.
 *
 * Nothing is printed, and the program is never stopped. */
#ifndef NUTATE_H
#define NUTATE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define NUTATE_VERSION_MAJOR 0
#define NUTATE_VERSION_MINOR 1
#define NUTATE_VERSION_PATCH 0

/* What a function returns. */
enum nutate_status {
    NUTATE_OK = 0,
    NUTATE_NOT_CONVERGED = 1, /* the iteration of a step did not converge */
    NUTATE_OFF_BRANCH = 2,    /* the step is too long to follow the motion */
    NUTATE_SINGULAR = 3,      /* the linear system of a step is singular */
    NUTATE_NOT_FINITE = 4,    /* a number is not finite or exceeds 1e100, in a step or from a callback */
    NUTATE_BAD_ARGUMENT = 5,  /* an argument is out of its range */
    NUTATE_BAD_BODY = 6,      /* the inertia is not that of a rigid body */
    NUTATE_BAD_SCENE = 7,     /* a scene says something that cannot be understood or simulated */
    NUTATE_IO = 8,            /* a file cannot be read or written */
    NUTATE_STEP_LIMIT = 9,    /* the run needs more steps than were allowed */
    NUTATE_BAD_HANDLE = 10,   /* not a handle of this kind: NULL, another kind, destroyed */
    NUTATE_CALLBACK = 11,     /* a callback reported a failure */
    NUTATE_TRUNCATED = 12,    /* a text did not fit into its buffer and was cut */
    NUTATE_NO_MEMORY = 13,    /* memory ran out */
    NUTATE_STOPPED = 14       /* the run was asked to stop */
};

/* A rigid body and the effects that act on it. */
typedef struct nutate_system nutate_system;
/* A scene file, read and checked. */
typedef struct nutate_scene nutate_scene;
/* A method with its settings, its system and the present state. */
typedef struct nutate_stepper nutate_stepper;
/* The rows of a run. */
typedef struct nutate_history nutate_history;

/* ---- General ---------------------------------------------------------------------------------------------------- */

/* Version of the library, such as "0.1.0". */
int nutate_get_version(char *buffer, size_t size);

/* One line for a person about a status.
 *   ==>  status   what a function returned; numbers that are no status have a text too */
int nutate_status_text(int status, char *buffer, size_t size);

/* Why the last call with this handle (not const) failed; empty after a call that succeeded.
 *   ==>  handle   any handle */
int nutate_last_message(const void *handle, char *buffer, size_t size);

/* ---- Systems ---------------------------------------------------------------------------------------------------- */

/* A body from principal moments along its body axes.
 *   ==>  moments         [3], about the reference point (or the centre of mass, see below), kg m2
 *   ==>  mass            kg; 0: not known, for bodies without effects that need it
 *   ==>  center_of_mass  [3], from the reference point, body axes, m; or NULL: the reference point
 *   ==>  about_center    true: the moments refer to the centre of mass and are moved by the parallel-axis rule
 * Status: NUTATE_BAD_BODY for moments that no rigid body has, NUTATE_BAD_ARGUMENT. */
int nutate_system_create_moments(const double moments[3], double mass, const double *center_of_mass, int about_center,
                                 nutate_system **system, char *message, size_t size);

/* The same from an inertia tensor.
 *   ==>  tensor          [6]: Jxx, Jyy, Jzz, Jxy, Jxz, Jyz, entries of the symmetric tensor, body axes, kg m2 */
int nutate_system_create_tensor(const double tensor[6], double mass, const double *center_of_mass, int about_center,
                                nutate_system **system, char *message, size_t size);

/* A homogeneous body.
 *   ==>  shape           "box" (full edges a, b, c), "cylinder" (radius, height; axis 3), "cone" (radius, height; axis
 *                        3, apex towards -3), "sphere" (radius), "ellipsoid" (semi-axes)
 *   ==>  lengths         [n_lengths], m
 *   ==>  n_lengths       how many lengths the shape has
 *   ==>  mass, density   kg, kg m-3: one of the two, the other 0
 *   ==>  center_of_mass  [3], from the reference point, body axes, m; or NULL: the reference point */
int nutate_system_create_shape(const char *shape, const double *lengths, size_t n_lengths, double mass, double density,
                               const double *center_of_mass, nutate_system **system, char *message, size_t size);

/* A body and effects as a scene file says them: the group &body, and those of effects.
 *   ==>  text            such as "&body inertia = 5, 20, 17 / &rotor momentum = 0, 0, 60 /"
 * Status: NUTATE_BAD_SCENE. */
int nutate_system_parse(const char *text, nutate_system **system, char *message, size_t size);

int nutate_system_destroy(nutate_system **system); /* frees it   <=>  system */

/* Inertia, mass and centre of mass.
 *   <==  inertia         about the reference point, body axes, kg m2; or NULL
 *   <==  mass            kg, 0 where it is not known; or NULL
 *   <==  center_of_mass  [3], body axes, m; or NULL */
int nutate_system_body(const nutate_system *system, double inertia[3][3], double *mass, double *center_of_mass);

/* The effects below act in addition to those that are there. Status: NUTATE_BAD_ARGUMENT for numbers that the keys of
 * their groups do not admit, NUTATE_BAD_BODY where the mass of the body is needed and not known. */
/* Uniform gravity on the centre of mass: V = -m g.(R c).   ==>  acceleration [3], space axes, m/s2 */
int nutate_system_add_gravity(nutate_system *system, const double acceleration[3]);
/* A dipole in a uniform field: V = -m.(R'b).   ==>  moment [3], body axes, A m2   ==>  field [3], space axes, T */
int nutate_system_add_dipole(nutate_system *system, const double moment[3], const double field[3]);

/* The gradient of a central field: V = (3/2) strength g'Jg, g = R'n.
 *   ==>  direction  [3], n: to the centre, space axes, of any length but zero
 *   ==>  strength   mu/r3, s-2 */
int nutate_system_add_gravity_gradient(nutate_system *system, const double direction[3], double strength);

/* A spring: V = k (|R x - a| - l)^2 / 2.
 *   ==>  body_point [3], x, body axes, m      ==>  anchor [3], a, space axes, m
 *   ==>  stiffness  k, N/m                    ==>  rest_length  l >= 0, m */
int nutate_system_add_spring(nutate_system *system, const double body_point[3], const double anchor[3],
                             double stiffness, double rest_length);
/* Viscous damping: tau = -diag(c) omega.   ==>  coefficient [3], c, body axes, N m s; negative ones drive */
int nutate_system_add_damping(nutate_system *system, const double coefficient[3]);

/* A torque tau = torque cos(2 pi frequency t + phase), from start to stop.
 *   ==>  torque       [3], N m
 *   ==>  in_space     true: the torque stands in space axes; else in body axes
 *   ==>  frequency    Hz, may be 0            ==>  phase  rad
 *   ==>  start, stop  s, start < stop; -INFINITY and INFINITY: always. Runs of nominal steps end steps on them. */
int nutate_system_add_torque(nutate_system *system, const double torque[3], int in_space, double frequency,
                             double phase, double start, double stop);
/* A rotor of constant momentum (gyrostat): L = J omega + h.   ==>  momentum [3], h, body axes, N m s */
int nutate_system_add_rotor(nutate_system *system, const double momentum[3]);

/* Effects as a scene file says them: one or several groups of effects.
 *   ==>  text         such as "&gravity / &damping coefficient = 0, 0, 1e-3 /"
 * Status: NUTATE_BAD_SCENE, also for a second &gravity. */
int nutate_system_add_groups(nutate_system *system, const char *text);

/* ---- Callbacks -------------------------------------------------------------------------------------------------- */

/* A callback returns 0, or another number to report a failure: the call that needed it then gives NUTATE_CALLBACK, and
 * the number stands in its message. Results that are not finite or exceed 1e100 give NUTATE_NOT_FINITE. In both cases
 * the state is the one before the step.
 *
 * Potentials are called when a state is set, in steps, and where energy is asked for; torques in steps. A callback is
 * called several times in a step, and at trial states that are not kept: what it returns must depend on
 * its arguments alone (and on data that stay the same during a step), or the step does not converge and energy is not
 * kept. It must return: no longjmp, no C++ exception may leave it; and it must not call functions with the handle that
 * called it. It needs to be safe for several threads if it is used in several. */

/* A potential V = U(gamma), gamma = R'n the body components of a vector n fixed in space. With the exact gradient,
 * energy is kept to round-off, and so is the momentum about n.
 *   ==>  gamma     [3], body axes; |gamma| = |n| at the ends of steps, a little less inside
 *   <=>  user      as given to the add function
 *   <==  energy    U, J
 *   <==  gradient  [3], dU/dgamma, body axes */
typedef int (*nutate_potential)(const double gamma[3], void *user, double *energy, double gradient[3]);

/* Its second derivatives.
 *   <==  hessian   d2U/dgamma2, symmetric, body axes */
typedef int (*nutate_hessian)(const double gamma[3], void *user, double hessian[3][3]);

/* A torque. Its work is accounted for to round-off.
 *   ==>  t         s
 *   ==>  q         [4], attitude, body to space
 *   ==>  omega     [3], angular velocity, body axes, rad/s
 *   <=>  user      as given to the add function
 *   <==  tau       [3], body axes, N m */
typedef int (*nutate_torque)(double t, const double q[4], const double omega[3], void *user, double tau[3]);

/* A potential of your own.
 *   ==>  direction  [3], n, space axes, not zero, of the unit that the potential is written in
 *   ==>  potential  called with gamma; must stay callable as long as the system, its copies and steppers are used
 *   ==>  hessian    or NULL: by differences of the gradient
 *   ==>  user       passed through; or NULL */
int nutate_system_add_potential(nutate_system *system, const double direction[3], nutate_potential potential,
                                nutate_hessian hessian, void *user);

/* A torque of your own.   ==>  torque, called with t, q, omega; user, passed through or NULL */
int nutate_system_add_user_torque(nutate_system *system, nutate_torque torque, void *user);

/* Bounds of the callback that was added last: with them the root of a step can be proved to be that of the true motion;
 * else each step counts as not proved (nutate_stepper_unproved). They are promised, not tested, and may be generous;
 * wide ones prove shorter steps only. Status: NUTATE_BAD_ARGUMENT for none of 0 and 1e-300 to 1e100, or no callback.
 * Of a potential, for all gamma up to |n| long, in J over powers of the unit of gamma.
 *   ==>  gradient, hessian, third   of |dU/dgamma|, of the eigenvalues of d2U/dgamma2, of the third derivative along a
 *                                   unit vector */
int nutate_system_bound_potential(nutate_system *system, double gradient, double hessian, double third);

/* Of a torque that does not depend on omega, at all attitudes and times, N m.
 *   ==>  torque       of |tau|
 *   ==>  by_rotation, second   of |d tau/d theta|, |d2 tau/d theta2| as the body turns by theta, rad, about any axis
 *   ==>  rate         1/s: times this, once and twice, they bound the derivatives by time; 0: constant in time */
int nutate_system_bound_torque(nutate_system *system, double torque, double by_rotation, double second, double rate);

/* ---- Scenes ----------------------------------------------------------------------------------------------------- */

/* Reads a scene file.
 *   ==>  path         file
 *   ==>  overrides    [n_overrides] "GROUP.KEY=VALUE", or "-GROUP.KEY" to unset it; NULL with n_overrides 0
 *   ==>  n_overrides  how many
 *   <==  message      what is wrong, one line "FILE:LINE: ..."; or NULL
 *   ==>  size         of message, bytes
 * Status: NUTATE_IO, NUTATE_BAD_SCENE. */
int nutate_scene_read(const char *path, const char *const *overrides, size_t n_overrides, nutate_scene **scene,
                      char *message, size_t size);

/* The same from memory.
 *   ==>  text         what would stand in the file
 *   ==>  name         what to call it in messages and for the default name of its CSV file; or NULL: "scene" */
int nutate_scene_parse(const char *text, const char *name, const char *const *overrides, size_t n_overrides,
                       nutate_scene **scene, char *message, size_t size);

int nutate_scene_destroy(nutate_scene **scene); /* frees it   <=>  scene */
/* Title of a scene.   ==>  scene   <==  buffer   ==>  size */
int nutate_scene_get_title(const nutate_scene *scene, char *buffer, size_t size);

/* Times of a scene.
 *   <==  time_step  s; 0 where steps are chosen by their error; or NULL
 *   <==  end_time   s; or NULL
 *   <==  every      nominal steps between rows; or NULL */
int nutate_scene_get_plan(const nutate_scene *scene, double *time_step, double *end_time, int64_t *every);

/* Initial state of a scene.
 *   <==  q          [4], attitude; or NULL
 *   <==  omega      [3], body axes, rad/s; or NULL */
int nutate_scene_get_initial(const nutate_scene *scene, double *q, double *omega);

/* A potential or torque of your own in a scene, and bounds, as in a system: nutate_system_...   <=>  scene */
int nutate_scene_add_potential(nutate_scene *scene, const double direction[3], nutate_potential potential,
                               nutate_hessian hessian, void *user);
int nutate_scene_add_user_torque(nutate_scene *scene, nutate_torque torque, void *user);
int nutate_scene_bound_potential(nutate_scene *scene, double gradient, double hessian, double third);
int nutate_scene_bound_torque(nutate_scene *scene, double torque, double by_rotation, double second, double rate);
/* The body and effects of a scene, a copy. */
int nutate_scene_system(const nutate_scene *scene, nutate_system **system, char *message, size_t size);

/* Runs a scene and keeps the columns it asks for in memory.
 *   <==  history       the new handle, also where the run fails half-way: it then has all complete rows */
int nutate_scene_run(const nutate_scene *scene, nutate_history **history, char *message, size_t size);

/* Runs a scene and writes its CSV file, as `nutate run` does.
 *   ==>  path          file to write; or NULL: the one that the scene names
 * Status: NUTATE_IO, and why a step failed; complete rows are then in PATH.partial. */
int nutate_scene_write(const nutate_scene *scene, const char *path, char *message, size_t size);

/* ---- Histories -------------------------------------------------------------------------------------------------- */

/* Size of a history.   ==>  history   <==  rows; or NULL   <==  columns, that of t included; or NULL */
int nutate_history_size(const nutate_history *history, size_t *rows, size_t *columns);
/* Name of a column.   ==>  history   ==>  column, 0 is "t"   <==  buffer   ==>  size */
int nutate_history_name(const nutate_history *history, size_t column, char *buffer, size_t size);

/* Values of a column.
 *   ==>  name     such as "t", "q0", "omega1", "total"
 *   <==  values   [rows]
 *   ==>  size     numbers that fit into values, at least rows */
int nutate_history_column(const nutate_history *history, const char *name, double *values, size_t size);

/* All values, row by row.
 *   <==  values   [rows][columns]
 *   ==>  size     numbers that fit into values, at least rows*columns */
int nutate_history_values(const nutate_history *history, double *values, size_t size);
/* Steps with a root that is taken for that of the true motion without a proof (docs/stability.md).   <==  steps */
int nutate_history_unproved(const nutate_history *history, int64_t *steps);

int nutate_history_destroy(nutate_history **history); /* frees it   <=>  history */
/* ---- Steppers --------------------------------------------------------------------------------------------------- */

/* A stepper for a system: second order, 8x8, at t = 0 with attitude 1 at rest.
 *   ==>  system        is copied */
int nutate_stepper_create(const nutate_system *system, nutate_stepper **stepper, char *message, size_t size);

/* A stepper for a scene: its system, initial state, method, time step and columns. nutate_stepper_run_to its end time
 * gives bit for bit the numbers of `nutate run`. A scene none of whose columns depends on the attitude may be integrated
 * without it: functions that read the attitude, l or p then give NUTATE_BAD_ARGUMENT (see nutate_stepper_set_columns).
 *   ==>  scene         is copied */
int nutate_stepper_create_scene(const nutate_scene *scene, nutate_stepper **stepper, char *message, size_t size);

int nutate_stepper_destroy(nutate_stepper **stepper); /* frees it   <=>  stepper */
/* Sets what the group &integrator of a scene would say: method, order, linear_solver, time_step (or accuracy, or
 * local_tolerance), auxiliary_inertia, projection, conserve, series_order, tolerance, max_iterations. The method "auto"
 * needs accuracy or local_tolerance and is their default (docs/scenes.md); each run to a time chooses anew. What is set takes
 * effect with the next step, which reports errors that only show in combination, unless nutate_stepper_prepare did.
 *   ==>  key      name, such as "method"         ==>  value    text, such as "dop853", "4", "1e-3", ".false." */
int nutate_stepper_set(nutate_stepper *stepper, const char *key, const char *value);

/* Sets the nominal step of nutate_stepper_run and ..._run_to.
 *   ==>  time_step  s; negative to go back in time; not 0 */
int nutate_stepper_set_time_step(nutate_stepper *stepper, double time_step);

/* Makes the method ready: tests the settings and allocates, so that the steps after it need not. Without this call the
 * first step does it.   <=>  stepper */
int nutate_stepper_prepare(nutate_stepper *stepper);

/* Sets the state; energy_residual and work count from here.
 *   ==>  t, s; q [4], attitude, body to space, unit to 1e-6, is normalised; omega [3], body axes, rad/s */
int nutate_stepper_set_state(nutate_stepper *stepper, double t, const double q[4], const double omega[3]);

/* The same with the conjugate momentum, taken as it is.
 *   ==>  q [4], attitude, unit to 1e-6, is not normalised; p [4], p = 2 q o [0, L], kg m2/s */
int nutate_stepper_set_canonical(nutate_stepper *stepper, double t, const double q[4], const double p[4]);

/* One step of the method, of any length: no more and no less than the method's step.
 *   <=>  stepper  on failure the state is as it was
 *   ==>  dt       s; negative to go back in time; not 0
 * Status: NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH, NUTATE_SINGULAR: try a shorter step. NUTATE_NOT_FINITE,
 * NUTATE_CALLBACK, NUTATE_BAD_ARGUMENT. */
int nutate_stepper_step(nutate_stepper *stepper, double dt);

/* Steps of the same length, as many calls of nutate_stepper_step would make.
 *   <=>  stepper  on failure at the state before the step that failed
 *   ==>  dt, s; n, number of steps, >= 0   <==  done, steps done, also on failure; or NULL */
int nutate_stepper_steps(nutate_stepper *stepper, double dt, int64_t n, int64_t *done);

/* Keeps the starts of steps from now on, for nutate_stepper_state_at.   <=>  stepper */
int nutate_stepper_keep_steps(nutate_stepper *stepper);
/* The state at a time inside the last step that was kept, as good as the method; later steps do not notice.
 *   ==>  t, s   <==  q [4], attitude; omega [3], body axes, rad/s.   Status: NUTATE_BAD_ARGUMENT for other times. */
int nutate_stepper_state_at(nutate_stepper *stepper, double t, double q[4], double omega[3]);

/* Nominal steps of the time_step set: as `nutate run` makes them. The k-th ends at t0 + k time_step; steps end where
 * torques start and stop; a step that fails is cut into parts. Calls in a row, of nutate_stepper_run_to too, continue the
 * count of steps.
 *   <=>  stepper   on failure at the last state reached: where a callback failed, that before the step
 *   ==>  n         number of nominal steps, >= 0
 *   ==>  every     a row after each `every` steps of this call, >= 1
 *   <==  rows      [capacity][width] of the columns chosen, n/every of them; or NULL: none
 *   ==>  capacity  rows that fit into rows, at least n/every; 0 with NULL
 *   <==  n_rows    rows written, also on failure; or NULL */
int nutate_stepper_run(nutate_stepper *stepper, int64_t n, int64_t every, double *rows, size_t capacity,
                       size_t *n_rows);

/* Runs to a time: with nominal steps, the last one shortened to end there; or, where accuracy or local_tolerance is
 * set, with steps chosen by their error.
 *   <=>  stepper   on failure at the last state reached
 *   ==>  end_time  s
 *   ==>  every     steps between rows, >= 1; where steps are chosen by their error and interval > 0 it does not count
 *   ==>  interval  time between rows, s, where steps are chosen by their error; else 0
 *   <==  rows      [capacity][width] of the columns chosen: the first state, those every so often, and the last; or NULL
 *   ==>  capacity  rows that fit into rows; a run that has more stops with NUTATE_STEP_LIMIT. 0 with NULL
 *   <==  n_rows    rows written, also on failure; or NULL */
int nutate_stepper_run_to(nutate_stepper *stepper, double end_time, int64_t every, double interval, double *rows,
                          size_t capacity, size_t *n_rows);

/* Number of rows that nutate_stepper_run_to would have, with nominal steps.   ==>  stepper, end_time, every   <==  n_rows */
int nutate_stepper_count_rows(const nutate_stepper *stepper, double end_time, int64_t every, size_t *n_rows);

/* Chooses the columns of rows, t being always the first.
 *   ==>  sets     comma separated: quaternion, conjugate_momentum, angular_velocity, angular_velocity_space,
 *                 angular_momentum, angular_momentum_space, euler, energy, constraints, solver */
int nutate_stepper_set_columns(nutate_stepper *stepper, const char *sets);
/* Number of columns of a row.   ==>  stepper   <==  width */
int nutate_stepper_width(const nutate_stepper *stepper, size_t *width);
/* Name of a column.   ==>  stepper   ==>  column, 0 is "t"   <==  buffer   ==>  size */
int nutate_stepper_column(const nutate_stepper *stepper, size_t column, char *buffer, size_t size);

/* The present state as a row.
 *   <==  row      [width]
 *   ==>  size     numbers that fit into row, at least width */
int nutate_stepper_row(nutate_stepper *stepper, double *row, size_t size);

/* ---- Reading a stepper ------------------------------------------------------------------------------------------ */
/*   ==>  stepper */

int nutate_stepper_time(const nutate_stepper *stepper, double *t);                      /* <== s */
int nutate_stepper_quaternion(const nutate_stepper *stepper, double q[4]);              /* <== attitude */
int nutate_stepper_conjugate_momentum(const nutate_stepper *stepper, double p[4]);      /* <== kg m2/s */
int nutate_stepper_angular_velocity(const nutate_stepper *stepper, double omega[3]);    /* <== body axes, rad/s */
int nutate_stepper_angular_velocity_space(const nutate_stepper *stepper, double omega[3]); /* <== space axes, rad/s */
int nutate_stepper_angular_momentum(const nutate_stepper *stepper, double L[3]);        /* <== body axes, N m s */
int nutate_stepper_angular_momentum_space(const nutate_stepper *stepper, double l[3]);  /* <== space axes, N m s */
int nutate_stepper_matrix(const nutate_stepper *stepper, double r[3][3]);               /* <== body to space */
int nutate_stepper_euler(const nutate_stepper *stepper, double angles[3]); /* <== phi, theta, psi (z-x-z), rad, +-pi */

/* Energies, J; calls potentials of your own.
 *   <==  energy [5]: kinetic, potential, total, work of all torques since the state was set, and the change of total (of the
 *                    Jacobi integral where the space axes turn) less that work and the world's
 * Status: NUTATE_CALLBACK, NUTATE_NOT_FINITE from callbacks. */
int nutate_stepper_energy(nutate_stepper *stepper, double energy[5]);
int nutate_stepper_constraints(const nutate_stepper *stepper, double constraints[2]); /* <== q.q - 1, q.p (kg m2/s) */

/* Which components of the angular momentum in space the effects leave alone.
 *   <==  components  0 none, 1 the one along axis, 3 all
 *   <==  axis        [3], unit vector, space axes; zero unless components is 1; or NULL */
int nutate_stepper_conserved(const nutate_stepper *stepper, int *components, double *axis);

/* What the last nutate_stepper_run_to with accuracy came to; zeros where there was none.
 *   <==  error  [2]: an estimate of the error of the attitude at its end, rad, and the part of it that round-off makes
 *               whatever the steps. The accuracy is out of reach where the first is above it. */
int nutate_stepper_accuracy(const nutate_stepper *stepper, double error[2]);

/* The last step.
 *   <==  iterations  Newton iterations; or NULL
 *   <==  residual    last increment over that of the step; or NULL */
int nutate_stepper_solver(const nutate_stepper *stepper, int *iterations, double *residual);
/* Steps since the state was set with a root that is taken for the true one without a proof.   <==  steps */
int nutate_stepper_unproved(const nutate_stepper *stepper, int64_t *steps);

/* ---- Attitudes -------------------------------------------------------------------------------------------------- */

/* Quaternions that are read need not have unit length, and their sign does not matter. All numbers must be finite:
 * NUTATE_BAD_ARGUMENT otherwise. */

/* Rotation matrix, body to space: v_space = r v_body.   ==>  q [4]   <==  r */
int nutate_matrix_from_quat(const double q[4], double r[3][3]);
/* And back; q[0] >= 0.   ==>  r, orthogonal of determinant 1, to 1e-6   <==  q [4] */
int nutate_quat_from_matrix(const double r[3][3], double q[4]);
/* Euler angles z-x-z: precession phi, nutation theta in [0, pi], spin psi, rad.   ==>  q [4]   <==  angles [3] */
int nutate_euler_from_quat(const double q[4], double angles[3]);
/* The same, phi and psi continued beyond +-pi from earlier ones, if the body turns by less than pi in between.
 *   ==>  q [4]   <=>  angles [3] */
int nutate_follow_euler(const double q[4], double angles[3]);
int nutate_quat_from_euler(const double angles[3], double q[4]); /* ==>  angles [3]   <==  q [4] */
/* Angular velocity, body axes, of rates of the angles.   ==>  angles [3], rates [3], rad/s   <==  omega [3], rad/s */
int nutate_omega_from_euler_rates(const double angles[3], const double rates[3], double omega[3]);
/* Rotation about an axis.   ==>  axis [3], of any length but zero   ==>  angle, rad   <==  q [4] */
int nutate_quat_from_axis_angle(const double axis[3], double angle, double q[4]);
/* ==>  q [4]   <==  axis [3], unit vector   <==  angle, in [0, pi] */
int nutate_axis_angle_from_quat(const double q[4], double axis[3], double *angle);
/* Axis times angle.   ==>  v [3], rad   <==  q [4] */
int nutate_quat_from_rotation_vector(const double v[3], double q[4]);
int nutate_rotation_vector_from_quat(const double q[4], double v[3]); /* ==>  q [4]   <==  v [3], rad, |v| <= pi */
/* Product: first b, then a.   ==>  a [4], b [4]   <==  c [4], may be a or b */
int nutate_quat_product(const double a[4], const double b[4], double c[4]);
/* Of unit length.   ==>  q [4], not zero   <==  unit [4], may be q */
int nutate_quat_normalized(const double q[4], double unit[4]);
/* Body components to space components.   ==>  q [4], v [3]   <==  r [3], may be v */
int nutate_rotate_to_space(const double q[4], const double v[3], double r[3]);
/* Space components to body components.   ==>  q [4], v [3]   <==  r [3], may be v */
int nutate_rotate_to_body(const double q[4], const double v[3], double r[3]);
/* Angle of the rotation between two attitudes, rad, in [0, pi].   ==>  a [4], b [4]   <==  angle */
int nutate_attitude_distance(const double a[4], const double b[4], double *angle);

/* ---- Exact solution --------------------------------------------------------------------------------------------- */

/* The exact motion of a free body.
 *   ==>  system   without effects
 *   ==>  q0       [4], attitude at t = 0
 *   ==>  omega0   [3], angular velocity at t = 0, body axes, rad/s
 *   ==>  n, t     number of times; [n], s, of either sign
 *   <==  q        [n][4], attitudes; or NULL
 *   <==  omega    [n][3], angular velocities, body axes, rad/s; or NULL
 * Status: NUTATE_BAD_ARGUMENT for effects, an attitude or numbers that have no solution. */
int nutate_exact_free_body(const nutate_system *system, const double q0[4], const double omega0[3], size_t n,
                      const double *t, double *q, double *omega);

#ifdef __cplusplus
}
#endif
#include "nutate_events.h"
#include "nutate_runs.h"
#include "nutate_satellites.h"
#include "nutate_sweep.h"

#endif
