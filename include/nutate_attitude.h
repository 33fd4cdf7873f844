/**
 * @file nutate_attitude.h
 * @brief Conversions of attitudes, and the exact motion of a torque-free body. Included by nutate.h, which explains
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

/** Returns the rotation matrix of a quaternion.
 * @param[in]  q  [4], attitude
 * @param[out] r  [3][3], rotation matrix, body to space: v_space = r v_body */
int nutate_matrix_from_quat(const double q[4], double r[3][3]);

/** Returns the unit quaternion of a rotation matrix.
 * @param[in]  r  [3][3], body to space, orthogonal of determinant 1, to 1e-6
 * @param[out] q  [4], attitude, with q[0] >= 0 */
int nutate_quat_from_matrix(const double r[3][3], double q[4]);

/** Returns the Euler angles z-x-z of a quaternion.
 * @param[in]  q       [4], attitude
 * @param[out] angles  [3], precession phi, nutation theta in [0, pi], spin psi, rad */
int nutate_euler_from_quat(const double q[4], double angles[3]);

/** Updates Euler angles z-x-z; phi and psi continue beyond +-pi if the body turns by less than pi since the earlier
 * ones.
 * @param[in]     q       [4], attitude
 * @param[in,out] angles  [3], phi, theta, psi, rad: the earlier ones, then those of q */
int nutate_follow_euler(const double q[4], double angles[3]);

/** Returns the unit quaternion of Euler angles z-x-z.
 * @param[in]  angles  [3], phi, theta, psi, rad
 * @param[out] q       [4], attitude */
int nutate_quat_from_euler(const double angles[3], double q[4]);

/** Returns the angular velocity for Euler rates.
 * @param[in]  angles  [3], phi, theta, psi (z-x-z), rad
 * @param[in]  rates   [3], their time derivatives, rad/s
 * @param[out] omega   [3], angular velocity, body axes, rad/s */
int nutate_omega_from_euler_rates(const double angles[3], const double rates[3], double omega[3]);

/** Returns the quaternion of a rotation about an axis.
 * @param[in]  axis   [3], axis of the rotation, of any length but zero
 * @param[in]  angle  angle of the rotation, rad
 * @param[out] q      [4], unit quaternion */
int nutate_quat_from_axis_angle(const double axis[3], double angle, double q[4]);

/** Returns axis and angle of a rotation.
 * @param[in]  q      [4], attitude
 * @param[out] axis   [3], axis of the rotation, unit vector
 * @param[out] angle  angle of the rotation, rad, in [0, pi] */
int nutate_axis_angle_from_quat(const double q[4], double axis[3], double *angle);

/** Returns the unit quaternion of a rotation vector (axis times angle).
 * @param[in]  v  [3], rotation vector, rad
 * @param[out] q  [4], unit quaternion */
int nutate_quat_from_rotation_vector(const double v[3], double q[4]);

/** Returns the rotation vector of a quaternion.
 * @param[in]  q  [4], attitude
 * @param[out] v  [3], rotation vector, rad, |v| <= pi */
int nutate_rotation_vector_from_quat(const double q[4], double v[3]);

/** Returns the product a b of two quaternions: first the rotation b, then a.
 * @param[in]  a  [4], first factor
 * @param[in]  b  [4], second factor
 * @param[out] c  [4], product; may be a or b */
int nutate_quat_product(const double a[4], const double b[4], double c[4]);

/** Normalizes a quaternion. @param[in] q [4], not zero @param[out] unit [4], unit quaternion; may be q */
int nutate_quat_normalized(const double q[4], double unit[4]);

/** Converts body components to space components.
 * @param[in]  q  [4], attitude
 * @param[in]  v  [3], body axes
 * @param[out] r  [3], space axes, in the unit of v; may be v */
int nutate_rotate_to_space(const double q[4], const double v[3], double r[3]);

/** Converts space components to body components.
 * @param[in]  q  [4], attitude
 * @param[in]  v  [3], space axes
 * @param[out] r  [3], body axes, in the unit of v; may be v */
int nutate_rotate_to_body(const double q[4], const double v[3], double r[3]);

/** Returns the angle of the rotation between two attitudes.
 * @param[in]  a      [4], attitude
 * @param[in]  b      [4], attitude
 * @param[out] angle  angle of the rotation, rad, in [0, pi] */
int nutate_attitude_distance(const double a[4], const double b[4], double *angle);

/* ---- Exact solution ---------------------------------------------------------------------------------------------- */

/** Computes the exact motion of a torque-free rigid body.
 * @param[in]  system  handle of a system without effects
 * @param[in]  q0      [4], attitude at t = 0
 * @param[in]  omega0  [3], angular velocity at t = 0, body axes, rad/s
 * @param[in]  n       number of times
 * @param[in]  t       [n], times, s, of either sign
 * @param[out] q       [n][4], attitudes; or NULL
 * @param[out] omega   [n][3], angular velocities, body axes, rad/s; or NULL
 * @return status: NUTATE_BAD_ARGUMENT if the system has effects, or q0 or a number is out of range. */
int nutate_exact_free_body(const nutate_system *system, const double q0[4], const double omega0[3], size_t n,
                      const double *t, double *q, double *omega);

#ifdef __cplusplus
}
#endif

#endif
