/* nutate: conversions of attitudes, and the exact motion of a torque-free body. Included by nutate.h, which explains
 * the notation. */
#ifndef NUTATE_ATTITUDE_H
#define NUTATE_ATTITUDE_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Conversions ------------------------------------------------------------------------------------------------- */

/* Quaternions that are read need not have unit length, and their sign does not matter. All numbers must be finite:
 * NUTATE_BAD_ARGUMENT otherwise. Attitudes convert body components to space components. */

/* Returns the rotation matrix, body to space: v_space = r v_body.   ==>  q [4]   <==  r */
int nutate_matrix_from_quat(const double q[4], double r[3][3]);
/* Returns the unit quaternion of a rotation matrix, with q[0] >= 0.   ==>  r, orthogonal of determinant 1, to 1e-6   <==  q [4] */
int nutate_quat_from_matrix(const double r[3][3], double q[4]);
/* Returns the Euler angles z-x-z: precession phi, nutation theta in [0, pi], spin psi, rad.   ==>  q [4]   <==  angles [3] */
int nutate_euler_from_quat(const double q[4], double angles[3]);
/* Updates Euler angles; phi and psi continue beyond +-pi if the body turns by less than pi since the earlier ones.
 *   ==>  q [4]   <=>  angles [3] */
int nutate_follow_euler(const double q[4], double angles[3]);
/* Returns the unit quaternion of Euler angles z-x-z, rad.   ==>  angles [3]   <==  q [4] */
int nutate_quat_from_euler(const double angles[3], double q[4]);
/* Returns the angular velocity, body axes, for Euler rates.   ==>  angles [3], rates [3], rad/s   <==  omega [3], rad/s */
int nutate_omega_from_euler_rates(const double angles[3], const double rates[3], double omega[3]);
/* Returns the quaternion of a rotation about an axis.   ==>  axis [3], of any length but zero   ==>  angle, rad   <==  q [4] */
int nutate_quat_from_axis_angle(const double axis[3], double angle, double q[4]);
/* Returns axis and angle of a rotation.   ==>  q [4]   <==  axis [3], unit vector   <==  angle, rad, in [0, pi] */
int nutate_axis_angle_from_quat(const double q[4], double axis[3], double *angle);
/* Returns the unit quaternion of a rotation vector (axis times angle).   ==>  v [3], rad   <==  q [4] */
int nutate_quat_from_rotation_vector(const double v[3], double q[4]);
/* Returns the rotation vector of a quaternion.   ==>  q [4]   <==  v [3], rad, |v| <= pi */
int nutate_rotation_vector_from_quat(const double q[4], double v[3]);
/* Returns the product a b: first the rotation b, then a.   ==>  a [4], b [4]   <==  c [4], may be a or b */
int nutate_quat_product(const double a[4], const double b[4], double c[4]);
/* Normalizes a quaternion.   ==>  q [4], not zero   <==  unit [4], may be q */
int nutate_quat_normalized(const double q[4], double unit[4]);
/* Converts body components to space components.   ==>  q [4], v [3]   <==  r [3], may be v */
int nutate_rotate_to_space(const double q[4], const double v[3], double r[3]);
/* Converts space components to body components.   ==>  q [4], v [3]   <==  r [3], may be v */
int nutate_rotate_to_body(const double q[4], const double v[3], double r[3]);
/* Returns the angle of the rotation between two attitudes.   ==>  a [4], b [4]   <==  angle, rad, in [0, pi] */
int nutate_attitude_distance(const double a[4], const double b[4], double *angle);

/* ---- Exact solution ---------------------------------------------------------------------------------------------- */

/* Computes the exact motion of a torque-free rigid body.
 *   ==>  system   without effects
 *   ==>  q0       [4], attitude at t = 0
 *   ==>  omega0   [3], angular velocity at t = 0, body axes, rad/s
 *   ==>  n, t     number of times; [n], s, of either sign
 *   <==  q        [n][4], attitudes; or NULL
 *   <==  omega    [n][3], angular velocities, body axes, rad/s; or NULL
 * Status: NUTATE_BAD_ARGUMENT if the system has effects, or q0 or a number is out of range. */
int nutate_exact_free_body(const nutate_system *system, const double q0[4], const double omega0[3], size_t n,
                      const double *t, double *q, double *omega);

#ifdef __cplusplus
}
#endif

#endif
