/* nutate: scenes, and the histories that their runs leave. Included by nutate.h, which says what the words and arrows
 * mean. */
#ifndef NUTATE_SCENE_H
#define NUTATE_SCENE_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

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
 *   <==  time_step  s; 0 where steps are adaptive; or NULL
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
/* Steps whose root is not certified (docs/explanation/certified-steps.md).   <==  steps */
int nutate_history_uncertified(const nutate_history *history, int64_t *steps);

int nutate_history_destroy(nutate_history **history); /* frees it   <=>  history */

#ifdef __cplusplus
}
#endif

#endif
