/**
 * @file nutate_sweep.h
 * @brief Members of an ensemble. Included by nutate.h, which explains the notation; docs/how-to/sweeps.md describes
 * ensembles and their result rows.
 *
 * @code{.c}
 * int64_t members;
 * size_t fields;
 * nutate_sweep_size(scene, &members, &fields);
 * double *rows = malloc(members * fields * 8);
 * nutate_sweep_members(scene, 1, members, 1, rows, members * fields * 8, NULL, 0);
 * @endcode
 *
 * A row has fields of 8 bytes, each an int64_t or a double, and depends on scene, seed and member alone: its bytes
 * equal those of the file that `nutate sweep` writes, whichever call runs the member. */
#ifndef NUTATE_SWEEP_H
#define NUTATE_SWEEP_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Returns the size of an ensemble.
 * @param[in]  scene    handle
 * @param[out] members  number of members; 0: the scene has no ensemble; or NULL
 * @param[out] fields   number of fields of a row; or NULL */
int nutate_sweep_size(const nutate_scene *scene, int64_t *members, size_t *fields);

/** Returns name and type of a field of a row.
 * @param[in]  scene       handle
 * @param[in]  field       index of the field; 0 is "member"
 * @param[out] is_integer  true if the field is an int64_t, false if it is a double; or NULL
 * @param[out] name        name of the field, such as "omega1"
 * @param[in]  size        size of name, bytes; 96 suffice
 * @return status: NUTATE_BAD_ARGUMENT if field is out of range. */
int nutate_sweep_field(const nutate_scene *scene, size_t field, int *is_integer, char *name, size_t size);

/** Sets the table of cases of an ensemble, one line per member; a scene without an ensemble gets one with that many
 * members.
 * @param[in,out] scene    handle
 * @param[in]     names    [n_names], such as "initial.angular_velocity.3", one number each
 * @param[in]     n_names  number of names, 1 to 200
 * @param[in]     numbers  [lines][n_names], in the units of the scene
 * @param[in]     lines    number of lines, 1 or more
 * @param[out]    message  error message; or NULL
 * @param[in]     size     size of message, bytes
 * @return status: NUTATE_BAD_SCENE for invalid names, for fewer lines than members, and for a second table. */
int nutate_sweep_table(nutate_scene *scene, const char *const *names, size_t n_names, const double *numbers,
                       size_t lines, char *message, size_t size);

/** Runs members and returns their rows. The status of a member that fails is in its row. Callbacks of the scene act on
 * every member, and all threads call them simultaneously; the row of a member in which one fails has status
 * NUTATE_CALLBACK or NUTATE_NOT_FINITE and no values.
 * @param[in]  scene    handle
 * @param[in]  first    first member, counted from 1
 * @param[in]  last     last member, counted from 1
 * @param[in]  threads  1: the calling thread, without a parallel region, so that forked processes may call it; more
 *                      than 1 requires a library built with OpenMP, and is treated as 1 in a process forked from one
 *                      that has used threads
 * @param[out] rows     [last - first + 1][fields], rows of the members; on failure filled in part
 * @param[in]  bytes    size of rows: 8 for each field
 * @param[out] message  error message; or NULL
 * @param[in]  size     size of message, bytes
 * @return status: NUTATE_BAD_ARGUMENT if first, last, threads or bytes is out of range; NUTATE_STOPPED if the poll
 *         callback of the scene, called by the calling thread, stops the sweep. */
int nutate_sweep_members(const nutate_scene *scene, int64_t first, int64_t last, int threads, void *rows, size_t bytes,
                         char *message, size_t size);

#ifdef __cplusplus
}
#endif

#endif
