/**
 * @file nutate_scene.h
 * @brief Scenes, and the histories of runs. Included by nutate.h, which explains the
 * notation. */
#ifndef NUTATE_SCENE_H
#define NUTATE_SCENE_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Reading and running a scene --------------------------------------------------------------------------------- */

/** Reads and checks a scene file.
 * @param[in]  path         path of the file
 * @param[in]  overrides    [n_overrides], "GROUP.KEY=VALUE", or "-GROUP.KEY" to unset it; NULL with n_overrides 0
 * @param[in]  n_overrides  number of overrides
 * @param[out] scene        handle of the new scene; NULL on failure
 * @param[out] message      error message, one line "FILE:LINE: ..."; or NULL
 * @param[in]  size         size of message, bytes
 * @return status: NUTATE_IO, NUTATE_BAD_SCENE. */
int nutate_scene_read(const char *path, const char *const *overrides, size_t n_overrides, nutate_scene **scene,
                      char *message, size_t size);

/** Reads and checks a scene from memory.
 * @param[in]  text         contents of the file
 * @param[in]  name         name of the scene in messages and of its default CSV file; or NULL: "scene"
 * @param[in]  overrides    [n_overrides], "GROUP.KEY=VALUE", or "-GROUP.KEY" to unset it; NULL with n_overrides 0
 * @param[in]  n_overrides  number of overrides
 * @param[out] scene        handle of the new scene; NULL on failure
 * @param[out] message      error message, one line "FILE:LINE: ..."; or NULL
 * @param[in]  size         size of message, bytes
 * @return status: as nutate_scene_read. */
int nutate_scene_parse(const char *text, const char *name, const char *const *overrides, size_t n_overrides,
                       nutate_scene **scene, char *message, size_t size);

/** Frees a scene. @param[in,out] scene handle; NULL afterwards */
int nutate_scene_destroy(nutate_scene **scene);

/** Returns the title of a scene.
 * @param[in]  scene   handle
 * @param[out] buffer  title
 * @param[in]  size    size of buffer, bytes */
int nutate_scene_get_title(const nutate_scene *scene, char *buffer, size_t size);

/** Returns the times of a scene.
 * @param[in]  scene      handle
 * @param[out] time_step  fixed step, s; 0 if steps are adaptive; or NULL
 * @param[out] end_time   end of the run, s; or NULL
 * @param[out] every      steps between rows; or NULL */
int nutate_scene_get_plan(const nutate_scene *scene, double *time_step, double *end_time, int64_t *every);

/** Returns the initial state of a scene.
 * @param[in]  scene  handle
 * @param[out] q      [4], attitude, body to space; or NULL
 * @param[out] omega  [3], angular velocity, body axes, rad/s; or NULL */
int nutate_scene_get_initial(const nutate_scene *scene, double *q, double *omega);

/** Adds a user-defined potential to a scene, as nutate_system_add_potential adds it to a system.
 * @param[in,out] scene      handle
 * @param[in]     direction  [3], n, space axes, not zero, of the unit that the potential is written in
 * @param[in]     potential  called with gamma; must stay callable as long as the scene, its systems and steppers are
 *                           used
 * @param[in]     hessian    second derivatives; or NULL: by differences of the gradient
 * @param[in,out] user       passed through; or NULL */
int nutate_scene_add_potential(nutate_scene *scene, const double direction[3], nutate_potential potential,
                               nutate_hessian hessian, void *user);

/** Adds a user-defined torque to a scene, as nutate_system_add_user_torque adds it to a system.
 * @param[in,out] scene   handle
 * @param[in]     torque  called with t, q, omega; must stay callable as long as the scene, its systems and steppers are
 *                        used
 * @param[in,out] user    passed through; or NULL */
int nutate_scene_add_user_torque(nutate_scene *scene, nutate_torque torque, void *user);

/** Sets bounds of the user-defined potential that was added last to a scene, as nutate_system_bound_potential does for
 * a system.
 * @param[in,out] scene     handle
 * @param[in]     gradient  bound of |dU/dgamma|, J over the unit of gamma
 * @param[in]     hessian   bound of the eigenvalues of d2U/dgamma2, J over the unit of gamma squared
 * @param[in]     third     bound of the third derivative along a unit vector, J over the unit of gamma cubed */
int nutate_scene_bound_potential(nutate_scene *scene, double gradient, double hessian, double third);

/** Sets bounds of the user-defined torque that was added last to a scene, as nutate_system_bound_torque does for a
 * system.
 * @param[in,out] scene        handle
 * @param[in]     torque       bound of |tau|, N m
 * @param[in]     by_rotation  bound of |d tau/d theta| as the body rotates by theta, rad, about any axis, N m
 * @param[in]     second       bound of |d2 tau/d theta2|, N m
 * @param[in]     rate         rate, 1/s: the bounds times rate, and times rate squared, bound the time derivatives; 0:
 *                             constant in time */
int nutate_scene_bound_torque(nutate_scene *scene, double torque, double by_rotation, double second, double rate);

/** Returns a copy of the body and effects of a scene.
 * @param[in]  scene    handle
 * @param[out] system   handle of the new system; NULL on failure
 * @param[out] message  error message; or NULL
 * @param[in]  size     size of message, bytes */
int nutate_scene_system(const nutate_scene *scene, nutate_system **system, char *message, size_t size);

/** Linearises the motion of a scene, as `nutate linearize` does: matrices, eigenvalues, names and units as JSON.
 * @param[in]  scene      handle
 * @param[in]  period     period, s; 0: about the initial state, an equilibrium; negative: the period of the orbit
 * @param[out] json       the result as a string; 32768 bytes suffice
 * @param[in]  json_size  size of json, bytes
 * @param[out] message    error message; or NULL
 * @param[in]  size       size of message, bytes
 * @return status: NUTATE_BAD_ARGUMENT if the initial state is not an equilibrium, NUTATE_TRUNCATED, or that of a failed
 *         step. */
int nutate_scene_linearize(const nutate_scene *scene, double period, char *json, size_t json_size, char *message,
                           size_t size);

/** Finds all equilibria of a scene, as `nutate linearize --equilibria` does: attitude, energy, index, growth as JSON.
 * @param[in]  scene      handle
 * @param[out] json       the result as a string; 32768 bytes suffice
 * @param[in]  json_size  size of json, bytes
 * @param[out] message    error message; or NULL
 * @param[in]  size       size of message, bytes
 * @return status: NUTATE_BAD_ARGUMENT if equilibria are not isolated or effects other than potentials, rotors and
 *         wheels act, NUTATE_TRUNCATED. */
int nutate_scene_equilibria(const nutate_scene *scene, char *json, size_t json_size, char *message, size_t size);

/** Runs a scene and keeps the columns of its &output in memory.
 * @param[in]  scene    handle
 * @param[out] history  handle of the new history, also if the run fails: it then has all complete rows
 * @param[out] message  error message; or NULL
 * @param[in]  size     size of message, bytes */
int nutate_scene_run(const nutate_scene *scene, nutate_history **history, char *message, size_t size);

/** Runs a scene and writes its CSV file, as `nutate run` does.
 * @param[in]  scene    handle
 * @param[in]  path     file to write; or NULL: the file given in the scene
 * @param[out] message  error message; or NULL
 * @param[in]  size     size of message, bytes
 * @return status: NUTATE_IO, or that of a failed step; complete rows are then in PATH.partial. */
int nutate_scene_write(const nutate_scene *scene, const char *path, char *message, size_t size);

/* ---- Fits -------------------------------------------------------------------------------------------------------- */

/* The functions below are for scenes with &free and &measurement. Parameters x are those of &free in the order of the
 * scene, then the biases. An attitude is a rotation vector from that of the scene, body axes, in its unit of angles.
 * NUTATE_BAD_ARGUMENT if the scene has nothing to fit. */

/** Returns the size of a fit.
 * @param[in,out] scene       handle
 * @param[out]    parameters  number of parameters; or NULL
 * @param[out]    residuals   number of residuals; or NULL */
int nutate_fit_size(nutate_scene *scene, size_t *parameters, size_t *residuals);

/** Returns the name of a parameter.
 * @param[in,out] scene      handle
 * @param[in]     parameter  index of the parameter, from 0
 * @param[out]    buffer     name
 * @param[in]     size       size of buffer, bytes */
int nutate_fit_name(nutate_scene *scene, size_t parameter, char *buffer, size_t size);

/** Returns the values of the scene and the bounds, without them -DBL_MAX and DBL_MAX.
 * @param[in,out] scene  handle
 * @param[out]    x      [parameters], values, each in the unit of the scene; or NULL
 * @param[out]    low    [parameters], lower bounds; or NULL
 * @param[out]    high   [parameters], upper bounds; or NULL */
int nutate_fit_start(nutate_scene *scene, double *x, double *low, double *high);

/** Computes residuals, (model - measured)/sigma, and their derivatives; then those of parameters with a known sigma.
 * @param[in,out] scene      handle
 * @param[in]     x          [parameters], values of the parameters
 * @param[out]    residuals  [residuals], without unit; or NULL
 * @param[out]    jacobian   [residuals][parameters], derivatives of the residuals; or NULL
 * @return status: NUTATE_BAD_SCENE for values that the scene rejects, or that of a failed step. */
int nutate_fit_evaluate(nutate_scene *scene, const double *x, double *residuals, double *jacobian);

/** Computes the cost that a fit minimises: half the sum of the squares of the residuals, with the losses of the
 * measurements.
 * @param[in,out] scene  handle
 * @param[in]     x      [parameters], values of the parameters
 * @param[out]    cost   cost, without unit; or NULL
 * @return status: as nutate_fit_evaluate. */
int nutate_fit_cost(nutate_scene *scene, const double *x, double *cost);

/** Fits the parameters, as `nutate fit` does.
 * @param[in]  scene       handle
 * @param[out] x           [parameters], fitted values; or NULL
 * @param[out] covariance  [parameters][parameters]; zero for parameters that the data do not determine; or NULL
 * @param[out] converged   1; or 0 if the fit ended early or leaves residuals that noise of the given sigma does not
 *                         explain; or NULL
 * @param[out] message     why converged is 0, or the error message; or NULL
 * @param[in]  size        size of message, bytes */
int nutate_fit_solve(const nutate_scene *scene, double *x, double *covariance, int *converged, char *message,
                     size_t size);

/* ---- Histories --------------------------------------------------------------------------------------------------- */

/** Returns the size of a history.
 * @param[in]  history  handle
 * @param[out] rows     number of rows; or NULL
 * @param[out] columns  number of columns, that of t included; or NULL */
int nutate_history_size(const nutate_history *history, size_t *rows, size_t *columns);

/** Returns the name of a column.
 * @param[in]  history  handle
 * @param[in]  column   index of the column; 0 is "t"
 * @param[out] buffer   name
 * @param[in]  size     size of buffer, bytes */
int nutate_history_name(const nutate_history *history, size_t column, char *buffer, size_t size);

/** Returns the values of a column.
 * @param[in]  history  handle
 * @param[in]  name     name of the column, such as "t", "q0", "omega1", "total"
 * @param[out] values   [rows], in the unit of the column
 * @param[in]  size     numbers that fit into values, at least rows */
int nutate_history_column(const nutate_history *history, const char *name, double *values, size_t size);

/** Returns all values, row by row.
 * @param[in]  history  handle
 * @param[out] values   [rows][columns], each in the unit of its column
 * @param[in]  size     numbers that fit into values, at least rows*columns */
int nutate_history_values(const nutate_history *history, double *values, size_t size);

/** Returns the number of uncertified steps (docs/explanation/certified-steps.md).
 * @param[in]  history  handle
 * @param[out] steps    number of steps */
int nutate_history_uncertified(const nutate_history *history, int64_t *steps);

/** Returns all numbers of a history that are not in its rows.
 * @param[in]  history  handle
 * @param[out] counts   [5]: rows, columns, located events, Lyapunov exponents (nutate_history_chaos), uncertified steps;
 *                      or NULL
 * @param[out] errors   [3], rad: estimated attitude error at the end, the part of it due to round-off, the requested
 *                      accuracy; zeros after a run without one; or NULL */
int nutate_history_summary(const nutate_history *history, int64_t counts[5], double errors[3]);

/** Frees a history. @param[in,out] history handle; NULL afterwards */
int nutate_history_destroy(nutate_history **history);

#ifdef __cplusplus
}
#endif

#endif
