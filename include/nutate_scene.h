/* nutate: scenes, and the histories of runs. Included by nutate.h, which explains the
 * notation. */
#ifndef NUTATE_SCENE_H
#define NUTATE_SCENE_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Reading and running a scene --------------------------------------------------------------------------------- */

/* Reads and checks a scene file.
 *   ==>  path         of the file
 *   ==>  overrides    [n_overrides] "GROUP.KEY=VALUE", or "-GROUP.KEY" to unset it; NULL with n_overrides 0
 *   ==>  n_overrides  how many
 *   <==  message      what is wrong, one line "FILE:LINE: ..."; or NULL
 *   ==>  size         of message, bytes
 * Status: NUTATE_IO, NUTATE_BAD_SCENE. */
int nutate_scene_read(const char *path, const char *const *overrides, size_t n_overrides, nutate_scene **scene,
                      char *message, size_t size);

/* Reads and checks a scene from memory.
 *   ==>  text         contents of the file
 *   ==>  name         name of the scene in messages and of its default CSV file; or NULL: "scene"
 *   Overrides, message and status as above. */
int nutate_scene_parse(const char *text, const char *name, const char *const *overrides, size_t n_overrides,
                       nutate_scene **scene, char *message, size_t size);

int nutate_scene_destroy(nutate_scene **scene); /* Frees a scene.   <=>  scene */
/* Returns the title of a scene.   ==>  scene   <==  buffer   ==>  size */
int nutate_scene_get_title(const nutate_scene *scene, char *buffer, size_t size);

/* Returns the times of a scene.
 *   <==  time_step  s; 0 if steps are adaptive; or NULL
 *   <==  end_time   s; or NULL
 *   <==  every      steps between rows; or NULL */
int nutate_scene_get_plan(const nutate_scene *scene, double *time_step, double *end_time, int64_t *every);

/* Returns the initial state of a scene.
 *   <==  q          [4], attitude; or NULL
 *   <==  omega      [3], body axes, rad/s; or NULL */
int nutate_scene_get_initial(const nutate_scene *scene, double *q, double *omega);

/* Add user-defined potentials, torques and bounds to a scene, as to a system: nutate_system_...   <=>  scene */
int nutate_scene_add_potential(nutate_scene *scene, const double direction[3], nutate_potential potential,
                               nutate_hessian hessian, void *user);
int nutate_scene_add_user_torque(nutate_scene *scene, nutate_torque torque, void *user);
int nutate_scene_bound_potential(nutate_scene *scene, double gradient, double hessian, double third);
int nutate_scene_bound_torque(nutate_scene *scene, double torque, double by_rotation, double second, double rate);
/* Returns a copy of the body and effects of a scene. */
int nutate_scene_system(const nutate_scene *scene, nutate_system **system, char *message, size_t size);

/* Linearises the motion of a scene, as `nutate linearize` does: matrices, eigenvalues, names and units as JSON.
 *   ==>  period        s; 0: about the initial state, an equilibrium; negative: the period of the orbit
 *   <==  json          string; 32768 bytes suffice
 *   ==>  json_size     of json, bytes
 * Status: NUTATE_BAD_ARGUMENT if the initial state is not an equilibrium, NUTATE_TRUNCATED, or that of a failed step. */
int nutate_scene_linearize(const nutate_scene *scene, double period, char *json, size_t json_size, char *message,
                           size_t size);

/* Finds all equilibria of a scene, as `nutate linearize --equilibria` does: attitude, energy, index, growth as JSON.
 *   <==  json          string; 32768 bytes suffice
 *   ==>  json_size     of json, bytes
 * Status: NUTATE_BAD_ARGUMENT if equilibria are not isolated or effects other than potentials, rotors
 * and wheels act, NUTATE_TRUNCATED. */
int nutate_scene_equilibria(const nutate_scene *scene, char *json, size_t json_size, char *message, size_t size);

/* Runs a scene and keeps the columns of its &output in memory.
 *   <==  history       the new handle, also if the run fails: it then has all complete rows */
int nutate_scene_run(const nutate_scene *scene, nutate_history **history, char *message, size_t size);

/* Runs a scene and writes its CSV file, as `nutate run` does.
 *   ==>  path          file to write; or NULL: the file given in the scene
 * Status: NUTATE_IO, or that of a failed step; complete rows are then in PATH.partial. */
int nutate_scene_write(const nutate_scene *scene, const char *path, char *message, size_t size);

/* ---- Fits -------------------------------------------------------------------------------------------------------- */

/* The functions below are for scenes with &free and &measurement. Parameters x are those of &free in the order of the
 * scene, then the biases. An attitude is a rotation vector from that of the scene, body axes, in its unit of angles.
 * NUTATE_BAD_ARGUMENT if the scene has nothing to fit. */

/* Returns the size of a fit.   ==>  scene   <==  parameters; or NULL   <==  residuals; or NULL */
int nutate_fit_size(nutate_scene *scene, size_t *parameters, size_t *residuals);
/* Returns the name of a parameter.   ==>  parameter, from 0   <==  buffer   ==>  size */
int nutate_fit_name(nutate_scene *scene, size_t parameter, char *buffer, size_t size);

/* Returns the values of the scene and the bounds, without them -DBL_MAX and DBL_MAX.
 *   <==  x, low, high  [parameters]; or NULL */
int nutate_fit_start(nutate_scene *scene, double *x, double *low, double *high);

/* Computes residuals, (model - measured)/sigma, and their derivatives; then those of parameters with a known sigma.
 *   ==>  x          [parameters]
 *   <==  residuals  [residuals]; or NULL
 *   <==  jacobian   [residuals][parameters]; or NULL
 * Status: NUTATE_BAD_SCENE for values that the scene rejects, or that of a failed step. */
int nutate_fit_evaluate(nutate_scene *scene, const double *x, double *residuals, double *jacobian);

/* Computes the cost that a fit minimises: half the sum of the squares of the residuals, with the losses of the measurements.
 *   ==>  x     [parameters]
 *   <==  cost  or NULL
 * Status: as nutate_fit_evaluate. */
int nutate_fit_cost(nutate_scene *scene, const double *x, double *cost);

/* Fits the parameters, as `nutate fit` does.
 *   <==  x           [parameters]; or NULL
 *   <==  covariance  [parameters][parameters]; zero for parameters that the data do not determine; or NULL
 *   <==  converged   1; or 0 if the fit ended early or leaves residuals that noise of the given sigma does not explain;
 *                    or NULL
 *   <==  message     why it is 0, or what failed; or NULL */
int nutate_fit_solve(const nutate_scene *scene, double *x, double *covariance, int *converged, char *message,
                     size_t size);

/* ---- Histories --------------------------------------------------------------------------------------------------- */

/* Returns the size of a history.   ==>  history   <==  rows; or NULL   <==  columns, that of t included; or NULL */
int nutate_history_size(const nutate_history *history, size_t *rows, size_t *columns);
/* Returns the name of a column.   ==>  history   ==>  column, 0 is "t"   <==  buffer   ==>  size */
int nutate_history_name(const nutate_history *history, size_t column, char *buffer, size_t size);

/* Returns the values of a column.
 *   ==>  name     such as "t", "q0", "omega1", "total"
 *   <==  values   [rows]
 *   ==>  size     numbers that fit into values, at least rows */
int nutate_history_column(const nutate_history *history, const char *name, double *values, size_t size);

/* Returns all values, row by row.
 *   <==  values   [rows][columns]
 *   ==>  size     numbers that fit into values, at least rows*columns */
int nutate_history_values(const nutate_history *history, double *values, size_t size);
/* Returns the number of uncertified steps (docs/explanation/certified-steps.md).   ==>  history   <==  steps */
int nutate_history_uncertified(const nutate_history *history, int64_t *steps);

int nutate_history_destroy(nutate_history **history); /* Frees a history.   <=>  history */

#ifdef __cplusplus
}
#endif

#endif
