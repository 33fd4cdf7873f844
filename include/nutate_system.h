/**
 * @file nutate_system.h
 * @brief Systems, each a rigid body with the effects that act on it. Included by nutate.h, which explains the
 * notation. */
#ifndef NUTATE_SYSTEM_H
#define NUTATE_SYSTEM_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Bodies and effects ------------------------------------------------------------------------------------------ */

/** Creates a body from principal moments along its body axes.
 * @param[in]  moments         [3], about the reference point (or the centre of mass, see about_center), kg m2
 * @param[in]  mass            mass, kg; 0: unknown, if no effect needs it
 * @param[in]  center_of_mass  [3], from the reference point, body axes, m; or NULL: the reference point
 * @param[in]  about_center    true: the moments refer to the centre of mass and are moved by the parallel-axis theorem
 * @param[out] system          handle of the new system; NULL on failure
 * @param[out] message         error message; or NULL
 * @param[in]  size            size of message, bytes
 * @return status: NUTATE_BAD_BODY for moments that no rigid body has, NUTATE_BAD_ARGUMENT. */
int nutate_system_create_moments(const double moments[3], double mass, const double *center_of_mass, int about_center,
                                 nutate_system **system, char *message, size_t size);

/** Creates a body from an inertia tensor.
 * @param[in]  tensor          [6], Jxx, Jyy, Jzz, Jxy, Jxz, Jyz, entries of the symmetric tensor (Jxy = -sum m x y),
 *                             body axes, kg m2
 * @param[in]  mass            mass, kg; 0: unknown, if no effect needs it
 * @param[in]  center_of_mass  [3], from the reference point, body axes, m; or NULL: the reference point
 * @param[in]  about_center    true: the tensor refers to the centre of mass and is moved by the parallel-axis theorem
 * @param[out] system          handle of the new system; NULL on failure
 * @param[out] message         error message; or NULL
 * @param[in]  size            size of message, bytes
 * @return status: as nutate_system_create_moments. */
int nutate_system_create_tensor(const double tensor[6], double mass, const double *center_of_mass, int about_center,
                                nutate_system **system, char *message, size_t size);

/** Creates a homogeneous body.
 * @param[in]  shape           "box" (full edges a, b, c), "cylinder" (radius, height; axis 3), "cone" (radius, height;
 *                             axis 3, apex towards -3), "sphere" (radius), "ellipsoid" (semi-axes)
 * @param[in]  lengths         [n_lengths], lengths of the shape, m
 * @param[in]  n_lengths       number of lengths that the shape has
 * @param[in]  mass            mass, kg; 0 if density is given
 * @param[in]  density         density, kg m-3; 0 if mass is given
 * @param[in]  center_of_mass  [3], from the reference point, body axes, m; or NULL: the reference point
 * @param[out] system          handle of the new system; NULL on failure
 * @param[out] message         error message; or NULL
 * @param[in]  size            size of message, bytes */
int nutate_system_create_shape(const char *shape, const double *lengths, size_t n_lengths, double mass, double density,
                               const double *center_of_mass, nutate_system **system, char *message, size_t size);

/** Creates a body with effects from groups of a scene file: &body, and those of effects.
 * @param[in]  text     groups, such as "&body inertia = 5, 20, 17 / &rotor momentum = 0, 0, 60 /"
 * @param[out] system   handle of the new system; NULL on failure
 * @param[out] message  error message; or NULL
 * @param[in]  size     size of message, bytes
 * @return status: NUTATE_BAD_SCENE. */
int nutate_system_parse(const char *text, nutate_system **system, char *message, size_t size);

/** Copies a system. Both are independent; callbacks are called with the same user pointers.
 * @param[in]  system   system
 * @param[out] copy     handle of the new system; NULL on failure
 * @param[out] message  error message; or NULL
 * @param[in]  size     size of message, bytes
 * @return status: NUTATE_NO_MEMORY. */
int nutate_system_copy(nutate_system *system, nutate_system **copy, char *message, size_t size);

/** Frees a system. @param[in,out] system handle; NULL afterwards */
int nutate_system_destroy(nutate_system **system);

/** Returns inertia, mass and centre of mass.
 * @param[in]  system          handle
 * @param[out] inertia         [3][3], about the reference point, body axes, kg m2; or NULL
 * @param[out] mass            mass, kg; 0: unknown; or NULL
 * @param[out] center_of_mass  [3], from the reference point, body axes, m; or NULL */
int nutate_system_body(const nutate_system *system, double inertia[3][3], double *mass, double *center_of_mass);

/* The functions below add effects to those already present. Status: NUTATE_BAD_ARGUMENT for numbers outside the limits
 * of the scene keys, NUTATE_BAD_BODY if the effect needs the mass of the body and it is unknown. */

/** Adds uniform gravity on the centre of mass: V = -m g.(R c).
 * @param[in,out] system        handle
 * @param[in]     acceleration  [3], g, space axes, m/s2 */
int nutate_system_add_gravity(nutate_system *system, const double acceleration[3]);

/** Adds a dipole in a uniform field: V = -m.(R'b).
 * @param[in,out] system  handle
 * @param[in]     moment  [3], m, body axes, A m2
 * @param[in]     field   [3], b, space axes, T */
int nutate_system_add_dipole(nutate_system *system, const double moment[3], const double field[3]);

/** Adds the gravity gradient of a central field: V = (3/2) strength g'Jg, g = R'n.
 * @param[in,out] system     handle
 * @param[in]     direction  [3], n: to the centre, space axes, of any length but zero
 * @param[in]     strength   mu/r3, s-2 */
int nutate_system_add_gravity_gradient(nutate_system *system, const double direction[3], double strength);

/** Adds a spring: V = k (|R x - a| - l)^2 / 2.
 * @param[in,out] system       handle
 * @param[in]     body_point   [3], x, body axes, m
 * @param[in]     anchor       [3], a, space axes, m
 * @param[in]     stiffness    stiffness k, N/m
 * @param[in]     rest_length  length at rest l >= 0, m */
int nutate_system_add_spring(nutate_system *system, const double body_point[3], const double anchor[3],
                             double stiffness, double rest_length);

/** Adds viscous damping: tau = -diag(c) omega.
 * @param[in,out] system       handle
 * @param[in]     coefficient  [3], c, body axes, N m s; negative values drive the body */
int nutate_system_add_damping(nutate_system *system, const double coefficient[3]);

/** Adds a torque tau = torque cos(2 pi frequency t + phase), from start to stop. Runs end steps at these times.
 * @param[in,out] system     handle
 * @param[in]     torque     [3], N m, in the axes of in_space
 * @param[in]     in_space   true: the torque is in space axes; false: in body axes
 * @param[in]     frequency  frequency, Hz, may be 0
 * @param[in]     phase      phase, rad
 * @param[in]     start      start, s, start < stop; -INFINITY: always
 * @param[in]     stop       end, s; INFINITY: always */
int nutate_system_add_torque(nutate_system *system, const double torque[3], int in_space, double frequency,
                             double phase, double start, double stop);

/** Adds a rotor of constant momentum (gyrostat): L = J omega + h.
 * @param[in,out] system    handle
 * @param[in]     momentum  [3], h, body axes, N m s */
int nutate_system_add_rotor(nutate_system *system, const double momentum[3]);

/** Adds effects from one or several groups of a scene file.
 * @param[in,out] system  handle
 * @param[in]     text    groups, such as "&gravity / &damping coefficient = 0, 0, 1e-3 /"
 * @return status: NUTATE_BAD_SCENE, also for a second &gravity. */
int nutate_system_add_groups(nutate_system *system, const char *text);

/* ---- User-defined potentials and torques ------------------------------------------------------------------------- */

/** Adds a user-defined potential.
 * @param[in,out] system     handle
 * @param[in]     direction  [3], n, space axes, not zero, of the unit that the potential is written in
 * @param[in]     potential  called with gamma; must stay callable as long as the system, its copies and steppers are
 *                           used
 * @param[in]     hessian    second derivatives; or NULL: by differences of the gradient
 * @param[in,out] user       passed through; or NULL */
int nutate_system_add_potential(nutate_system *system, const double direction[3], nutate_potential potential,
                                nutate_hessian hessian, void *user);

/** Adds a user-defined torque.
 * @param[in,out] system  handle
 * @param[in]     torque  called with t, q, omega; must stay callable as long as the system, its copies and steppers are
 *                        used
 * @param[in,out] user    passed through; or NULL */
int nutate_system_add_user_torque(nutate_system *system, nutate_torque torque, void *user);

/* The functions below set bounds of user-defined potentials and torques: with them the root of a step can be certified
 * to be that of the true motion; without them every step is reported as uncertified (nutate_stepper_uncertified). They
 * are not verified; the larger they are, the shorter the steps that can be certified. */

/** Sets bounds of the user-defined potential that was added last. The bounds hold for all |gamma| <= |n|.
 * @param[in,out] system    handle
 * @param[in]     gradient  bound of |dU/dgamma|, J over the unit of gamma
 * @param[in]     hessian   bound of the eigenvalues of d2U/dgamma2, J over the unit of gamma squared
 * @param[in]     third     bound of the third derivative along a unit vector, J over the unit of gamma cubed
 * @return status: NUTATE_BAD_ARGUMENT without a user-defined potential, or unless each is 0 or 1e-300 to 1e100. */
int nutate_system_bound_potential(nutate_system *system, double gradient, double hessian, double third);

/** Sets bounds of the user-defined torque that was added last, which does not depend on omega, at all attitudes and
 * times.
 * @param[in,out] system       handle
 * @param[in]     torque       bound of |tau|, N m
 * @param[in]     by_rotation  bound of |d tau/d theta| as the body rotates by theta, rad, about any axis, N m
 * @param[in]     second       bound of |d2 tau/d theta2|, N m
 * @param[in]     rate         rate, 1/s: the bounds times rate, and times rate squared, bound the time derivatives; 0:
 *                             constant in time
 * @return status: NUTATE_BAD_ARGUMENT without a user-defined torque, or unless each is 0 or 1e-300 to 1e100. */
int nutate_system_bound_torque(nutate_system *system, double torque, double by_rotation, double second, double rate);

#ifdef __cplusplus
}
#endif

#endif
