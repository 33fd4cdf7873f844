/**
 * @file nutate_exchange.h
 * @brief Calendar time, and attitudes for other programs. Included by nutate.h, which explains the notation;
 * docs/how-to/exchange.md describes the files.
 *
 * @code{.c}
 * const char *facts = "&scene epoch = '2029-04-13T21:46:12.7', time_system = 'TDB', object = 'APOPHIS', "
 *                     "space_frame = 'ICRF' /";
 * nutate_write_aem("apophis.aem", facts, n, t, q, omega, NULL, 0.0, message, sizeof message);
 * @endcode
 *
 * Facts are groups &scene and &body as those of scene files, either of which may be missing: epoch and names for an
 * AEM, the body for glTF. */
#ifndef NUTATE_EXCHANGE_H
#define NUTATE_EXCHANGE_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Returns a value of the group &scene.
 * @param[in]  scene   handle
 * @param[in]  key     "title", "epoch", "time_system", "object", "object_id", "space_frame" or "body_frame"
 * @param[out] buffer  the value; empty if the scene gives none
 * @param[in]  size    size of buffer, bytes
 * @return status: NUTATE_BAD_ARGUMENT for another key. */
int nutate_scene_get(const nutate_scene *scene, const char *key, char *buffer, size_t size);

/** Returns the date of a time.
 * @param[in]  epoch        date of t = 0
 * @param[in]  time_system  time system of both dates: "TDB", "TT", "TAI" or "UTC"
 * @param[in]  t            time, s
 * @param[out] buffer       date, such as "2029-04-13T21:46:12.7"; 40 bytes suffice
 * @param[in]  size         size of buffer, bytes
 * @return status: NUTATE_BAD_ARGUMENT for an invalid date, and for times outside of the years 1583 to 9999 (UTC:
 *         from 1972). */
int nutate_date(const char *epoch, const char *time_system, double t, char *buffer, size_t size);

/** Returns barycentric dynamical time (TDB) past J2000, the ephemeris time of SPICE.
 * @param[in]  epoch        date of t = 0, as for nutate_date
 * @param[in]  time_system  time system of epoch, as for nutate_date
 * @param[in]  n            number of times
 * @param[in]  t            [n], times, s
 * @param[out] tdb          [n], TDB past J2000, s */
int nutate_tdb(const char *epoch, const char *time_system, size_t n, const double *t, double *tdb);

/** Returns the rate at which the space axes rotate.
 * @param[in]  system  handle
 * @param[out] rate    [3], space axes, rad/s; zero unless there is a rotating frame or an orbit with LVLH axes */
int nutate_system_frame_rate(const nutate_system *system, double rate[3]);

/** Returns the attitude of the space axes in inertial axes: that of the LVLH frame, or the identity. The product of a
 * returned q and an attitude of the stepper is the attitude in inertial axes.
 * @param[in]  system  handle
 * @param[in]  n       number of times
 * @param[in]  t       [n], times, s
 * @param[out] q       [n][4], attitudes, space to inertial
 * @return status: NUTATE_BAD_ARGUMENT for a rotating frame, whose attitude is not known. */
int nutate_system_space_axes(const nutate_system *system, size_t n, const double *t, double *q);

/** Writes attitudes as an Attitude Ephemeris Message (CCSDS 504.0-B). Space axes are REF_FRAME_A, body axes
 * REF_FRAME_B.
 * @param[in]  path     file to write
 * @param[in]  facts    epoch, time_system, object and space_frame are needed
 * @param[in]  n        number of attitudes
 * @param[in]  t        [n], times, s, ascending
 * @param[in]  q        [n][4], attitudes, in the axes that space_frame names: for LVLH axes see
 *                      nutate_system_space_axes
 * @param[in]  omega    [n][3], angular velocities relative to these axes, body axes, rad/s; or NULL
 * @param[in]  version  "2.0" or "1.0", which has no rates; or NULL: "2.0"
 * @param[in]  error    bound of the attitude error of a constant rate between rows, rad, written as a comment; 0:
 *                      unknown
 * @param[out] message  error message; or NULL
 * @param[in]  size     size of message, bytes
 * @return status: NUTATE_BAD_SCENE for the facts, NUTATE_BAD_ARGUMENT, NUTATE_IO. */
int nutate_write_aem(const char *path, const char *facts, size_t n, const double *t, const double *q,
                     const double *omega, const char *version, double error, char *message, size_t size);

/** Writes a moving body as glTF 2.0, in single precision.
 * @param[in]  path     file to write
 * @param[in]  facts    &body is needed
 * @param[in]  n        number of attitudes
 * @param[in]  t        [n], times, s, ascending
 * @param[in]  q        [n][4], attitudes, body to space
 * @param[in]  speed    simulated seconds per second of animation
 * @param[out] message  error message; or NULL
 * @param[in]  size     size of message, bytes */
int nutate_write_gltf(const char *path, const char *facts, size_t n, const double *t, const double *q, double speed,
                      char *message, size_t size);

/** Reads an Attitude Ephemeris Message. The columns of the history are t, since the first record, q0 to q3, body to
 * space, and omega1 to omega3 if the message has angular velocities; then segment, its number, if there are several
 * segments, between which there is no attitude.
 * @param[in]  path        file to read
 * @param[out] history     handle of the new history; NULL on failure
 * @param[out] facts       epoch and names, in a group &scene of a scene file; or NULL
 * @param[in]  facts_size  size of facts, bytes
 * @param[out] message     error message, "FILE:LINE: ..."; or NULL
 * @param[in]  size        size of message, bytes
 * @return status: NUTATE_IO, NUTATE_BAD_SCENE, NUTATE_TRUNCATED for facts that do not fit (1200 bytes suffice), with
 *         the history. */
int nutate_read_aem(const char *path, nutate_history **history, char *facts, size_t facts_size, char *message,
                    size_t size);

#ifdef __cplusplus
}
#endif

#endif
