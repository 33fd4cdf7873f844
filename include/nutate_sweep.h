/* nutate: members of an ensemble. Included by nutate.h, which says what the words and arrows mean; docs/how-to/sweeps.md says
 * what a scene's ensemble is, and what stands in a row.
 *
 *    int64_t members;
 *    size_t fields;
 *    nutate_sweep_size(scene, &members, &fields);
 *    double *rows = malloc(members * fields * 8);
 *    nutate_sweep_members(scene, 1, members, 1, rows, members * fields * 8, NULL, 0);
 *
 * A row has fields of 8 bytes, each an int64_t or a double, and depends on scene, seed and member alone: the bytes are
 * those of the file that `nutate sweep` writes, whoever runs what. */
#ifndef NUTATE_SWEEP_H
#define NUTATE_SWEEP_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Size of an ensemble.
 *   ==>  scene
 *   <==  members  0: the scene has no ensemble; or NULL        <==  fields   of a row; or NULL */
int nutate_sweep_size(const nutate_scene *scene, int64_t *members, size_t *fields);

/* A field of a row.
 *   ==>  scene, field   0 is "member"
 *   <==  is_whole       true: an int64_t, else a double; or NULL
 *   <==  name           such as "omega1"    ==>  size   of name, bytes; 96 do
 * Status: NUTATE_BAD_ARGUMENT if field is out of range. */
int nutate_sweep_field(const nutate_scene *scene, size_t field, int *is_whole, char *name, size_t size);

/* Gives an ensemble a table of cases, a line for each member; a scene without an ensemble gets one of as many members.
 *   <=>  scene
 *   ==>  names     [n_names] such as "initial.angular_velocity.3": of one number each   ==>  n_names   1 to 200
 *   ==>  numbers   [lines][n_names], in the units of the scene                          ==>  lines     1 or more
 *   <==  message   what is wrong; or NULL    ==>  size   of message, bytes
 * Status: NUTATE_BAD_SCENE for names of no number, for fewer lines than members, and for a second table. */
int nutate_sweep_table(nutate_scene *scene, const char *const *names, size_t n_names, const double *numbers,
                       size_t lines, char *message, size_t size);

/* Runs members to their rows. What goes wrong with a member stands in its row, as its status.
 *   ==>  first, last   members, counted from 1
 *   ==>  threads       1: the one that calls, and no parallel region is entered, so that a process that was forked may
 *                      call; more need a library that was built with OpenMP
 *   <==  rows          [last - first + 1][fields]; on failure filled in part
 *   ==>  bytes         of rows: 8 for each field
 *   <==  message       what is wrong; or NULL    ==>  size   of message, bytes
 * Status: NUTATE_BAD_ARGUMENT for members that there are not, for threads that the library lacks, for rows of another
 * size, and for a scene with callbacks; NUTATE_STOPPED by the poll of the scene, which the
 * thread that calls asks. */
int nutate_sweep_members(const nutate_scene *scene, int64_t first, int64_t last, int threads, void *rows, size_t bytes,
                         char *message, size_t size);

#ifdef __cplusplus
}
#endif

#endif
