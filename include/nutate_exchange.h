/* nutate: calendar time, and attitudes for other programs. Included by nutate.h, which explains the notation;
 * docs/how-to/exchange.md describes the files.
 *
 *    const char *facts = "&scene epoch = '2029-04-13T21:46:12.7', time_system = 'TDB', object = 'APOPHIS', "
 *                        "space_frame = 'ICRF' /";
 *    nutate_write_aem("apophis.aem", facts, n, t, q, omega, NULL, 0.0, message, sizeof message);
 *
 * Facts are groups &scene and &body as those of scene files, either of which may be missing: epoch and names for an AEM,
 * the body for glTF. */
#ifndef NUTATE_EXCHANGE_H
#define NUTATE_EXCHANGE_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Returns a value of the group &scene.
 *   ==>  key     "title", "epoch", "time_system", "object", "object_id", "space_frame" or "body_frame"
 *   <==  buffer  the value; empty if the scene gives none        ==>  size
 * Status: NUTATE_BAD_ARGUMENT for another key. */
int nutate_scene_get(const nutate_scene *scene, const char *key, char *buffer, size_t size);

/* Returns the date of a time, such as "2029-04-13T21:46:12.7".
 *   ==>  epoch        date of t = 0
 *   ==>  time_system  of both dates: "TDB", "TT", "TAI" or "UTC"
 *   ==>  t            s
 *   <==  buffer       40 bytes suffice==>  size
 * Status: NUTATE_BAD_ARGUMENT for an invalid date, and for times outside of the years 1583 to 9999 (UTC: from 1972). */
int nutate_date(const char *epoch, const char *time_system, double t, char *buffer, size_t size);

/* Returns barycentric dynamical time (TDB) past J2000, s, the ephemeris time of SPICE.
 *   ==>  epoch, time_system   as for nutate_date
 *   ==>  n, t                 [n], s
 *   <==  tdb                  [n], s */
int nutate_tdb(const char *epoch, const char *time_system, size_t n, const double *t, double *tdb);

/* Returns the rate at which the space axes rotate.
 *   <==  rate   [3], space axes, rad/s; zero unless there is a rotating frame or an orbit with LVLH axes */
int nutate_system_frame_rate(const nutate_system *system, double rate[3]);

/* Returns the attitude of the space axes in inertial axes: that of the LVLH frame, or the identity. The product of a returned
 * q and an attitude of the stepper is the attitude in inertial axes.
 *   ==>  n, t   [n], s
 *   <==  q      [n][4], space to inertial
 * Status: NUTATE_BAD_ARGUMENT for a rotating frame, whose attitude is not known. */
int nutate_system_space_axes(const nutate_system *system, size_t n, const double *t, double *q);

/* Writes attitudes as an Attitude Ephemeris Message (CCSDS 504.0-B). Space axes are REF_FRAME_A, body axes REF_FRAME_B.
 *   ==>  facts    epoch, time_system, object and space_frame are needed
 *   ==>  n, t     [n], s, ascending
 *   ==>  q        [n][4], in the axes that space_frame names: for LVLH axes see nutate_system_space_axes
 *   ==>  omega    [n][3], relative to these axes, body axes, rad/s; or NULL
 *   ==>  version  "2.0" or "1.0", which has no rates; or NULL: "2.0"
 *   ==>  error    bound of the attitude error of a constant rate between rows, rad, written as a comment; 0: unknown
 *   <==  message  what is wrong; or NULL     ==>  size
 * Status: NUTATE_BAD_SCENE for the facts, NUTATE_BAD_ARGUMENT, NUTATE_IO. */
int nutate_write_aem(const char *path, const char *facts, size_t n, const double *t, const double *q,
                     const double *omega, const char *version, double error, char *message, size_t size);

/* Writes a moving body as glTF 2.0, in single precision.
 *   ==>  facts    &body is needed
 *   ==>  n, t, q  as above
 *   ==>  speed    simulated seconds per second of animation */
int nutate_write_gltf(const char *path, const char *facts, size_t n, const double *t, const double *q, double speed,
                      char *message, size_t size);

/* Reads an Attitude Ephemeris Message. The columns of the history are t, since the first record, q0 to q3, body to space, and
 * omega1 to omega3 if the message has angular velocities; then segment, its number, if there are several segments, between
 * which there is no attitude.
 *   <==  history     a new handle; NULL on failure
 *   <==  facts       epoch and names as a group &scene; or NULL       ==>  facts_size
 *   <==  message     what is wrong, "FILE:LINE: ..."; or NULL         ==>  size
 * Status: NUTATE_IO, NUTATE_BAD_SCENE, NUTATE_TRUNCATED for facts that do not fit (1200 bytes suffice), with the history. */
int nutate_read_aem(const char *path, nutate_history **history, char *facts, size_t facts_size, char *message,
                    size_t size);

#ifdef __cplusplus
}
#endif

#endif
