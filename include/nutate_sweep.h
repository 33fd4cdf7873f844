/* nutate: members of an ensemble. Included by nutate.h, which explains the notation; docs/how-to/sweeps.md describes
 * ensembles and their result rows.
 *
 *    int64_t members;
 *    size_t fields;
 *    nutate_sweep_size(scene, &members, &fields);
 *    double *rows = malloc(members * fields * 8);
 *    nutate_sweep_members(scene, 1, members, 1, rows, members * fields * 8, NULL, 0);
 *
 * A row has fields of 8 bytes, each an int64_t or a double, and depends on scene, seed and member alone: its bytes
 * equal those of the file that `nutate sweep` writes, whichever call runs the member. */
#ifndef NUTATE_SWEEP_H
#define NUTATE_SWEEP_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Returns the size of an ensemble.
 *   ==>  scene
 *   <==  members  0: the scene has no ensemble; or NULL        <==  fields   of a row; or NULL */
int nutate_sweep_size(const nutate_scene *scene, int64_t *members, size_t *fields);

/* Returns name and type of a field of a row.
 *   ==>  scene, field   0 is "member"
 *   <==  is_integer     true: an int64_t, else a double; or NULL
 *   <==  name           such as "omega1"    ==>  size   of name, bytes; 96 suffice
 * Status: NUTATE_BAD_ARGUMENT if field is out of range. */
int nutate_sweep_field(const nutate_scene *scene, size_t field, int *is_integer, char *name, size_t size);

/* Sets the table of cases of an ensemble, one line per member; a scene without an ensemble gets one with that many members.
 *   <=>  scene
 *   ==>  names     [n_names], such as "initial.angular_velocity.3", one number each   ==>  n_names   1 to 200
 *   ==>  numbers   [lines][n_names], in the units of the scene                          ==>  lines     1 or more
 *   <==  message   what is wrong; or NULL    ==>  size   of message, bytes
 * Status: NUTATE_BAD_SCENE for invalid names, for fewer lines than members, and for a second table. */
int nutate_sweep_table(nutate_scene *scene, const char *const *names, size_t n_names, const double *numbers,
                       size_t lines, char *message, size_t size);

/* Runs members and returns their rows. The status of a member that fails is in its row.
 *   ==>  first, last   members, counted from 1
 *   ==>  threads       1: the calling thread, without a parallel region, so that forked processes may call it; more than 1
 *                      requires a library built with OpenMP
 *   <==  rows          [last - first + 1][fields]; on failure filled in part
 *   ==>  bytes         of rows: 8 for each field
 *   <==  message       what is wrong; or NULL    ==>  size   of message, bytes
 * Callbacks of the scene act on every member, and all threads call them simultaneously; the row of a member in which one fails
 * has status NUTATE_CALLBACK or NUTATE_NOT_FINITE and no values.
 * Status: NUTATE_BAD_ARGUMENT if first, last, threads or bytes is out of range; NUTATE_STOPPED if
 * the poll callback of the scene, called by the calling thread, stops the sweep. */
int nutate_sweep_members(const nutate_scene *scene, int64_t first, int64_t last, int threads, void *rows, size_t bytes,
                         char *message, size_t size);

#ifdef __cplusplus
}
#endif

#endif
