/* nutate: systems, each a rigid body with the effects that act on it. Included by nutate.h, which explains the
 * notation. */
#ifndef NUTATE_SYSTEM_H
#define NUTATE_SYSTEM_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Bodies and effects ------------------------------------------------------------------------------------------ */

/* Creates a body from principal moments along its body axes.
 *   ==>  moments         [3], about the reference point (or the centre of mass, see below), kg m2
 *   ==>  mass            kg; 0: unknown, if no effect needs it
 *   ==>  center_of_mass  [3], from the reference point, body axes, m; or NULL: the reference point
 *   ==>  about_center    true: the moments refer to the centre of mass and are moved by the parallel-axis theorem
 * Status: NUTATE_BAD_BODY for moments that no rigid body has, NUTATE_BAD_ARGUMENT. */
int nutate_system_create_moments(const double moments[3], double mass, const double *center_of_mass, int about_center,
                                 nutate_system **system, char *message, size_t size);

/* Creates a body from an inertia tensor.
 *   ==>  tensor          [6]: Jxx, Jyy, Jzz, Jxy, Jxz, Jyz, entries of the symmetric tensor, body axes, kg m2
 *   Other arguments and status as above. */
int nutate_system_create_tensor(const double tensor[6], double mass, const double *center_of_mass, int about_center,
                                nutate_system **system, char *message, size_t size);

/* Creates a homogeneous body.
 *   ==>  shape           "box" (full edges a, b, c), "cylinder" (radius, height; axis 3), "cone" (radius, height; axis
 *                        3, apex towards -3), "sphere" (radius), "ellipsoid" (semi-axes)
 *   ==>  lengths         [n_lengths], m
 *   ==>  n_lengths       how many lengths the shape has
 *   ==>  mass, density   kg, kg m-3: one of the two, the other 0
 *   ==>  center_of_mass  [3], from the reference point, body axes, m; or NULL: the reference point */
int nutate_system_create_shape(const char *shape, const double *lengths, size_t n_lengths, double mass, double density,
                               const double *center_of_mass, nutate_system **system, char *message, size_t size);

/* Creates a body with effects from groups of a scene file: &body, and those of effects.
 *   ==>  text            such as "&body inertia = 5, 20, 17 / &rotor momentum = 0, 0, 60 /"
 * Status: NUTATE_BAD_SCENE. */
int nutate_system_parse(const char *text, nutate_system **system, char *message, size_t size);

int nutate_system_destroy(nutate_system **system); /* Frees a system.   <=>  system */

/* Returns inertia, mass and centre of mass.
 *   <==  inertia         about the reference point, body axes, kg m2; or NULL
 *   <==  mass            kg; 0: unknown; or NULL
 *   <==  center_of_mass  [3], body axes, m; or NULL */
int nutate_system_body(const nutate_system *system, double inertia[3][3], double *mass, double *center_of_mass);

/* The functions below add effects to those already present. Status: NUTATE_BAD_ARGUMENT for numbers outside the limits of
 * the scene keys, NUTATE_BAD_BODY if the effect needs the mass of the body and it is unknown. */
/* Adds uniform gravity on the centre of mass: V = -m g.(R c).   ==>  acceleration [3], space axes, m/s2 */
int nutate_system_add_gravity(nutate_system *system, const double acceleration[3]);
/* Adds a dipole in a uniform field: V = -m.(R'b).   ==>  moment [3], body axes, A m2   ==>  field [3], space axes, T */
int nutate_system_add_dipole(nutate_system *system, const double moment[3], const double field[3]);

/* Adds the gravity gradient of a central field: V = (3/2) strength g'Jg, g = R'n.
 *   ==>  direction  [3], n: to the centre, space axes, of any length but zero
 *   ==>  strength   mu/r3, s-2 */
int nutate_system_add_gravity_gradient(nutate_system *system, const double direction[3], double strength);

/* Adds a spring: V = k (|R x - a| - l)^2 / 2.
 *   ==>  body_point [3], x, body axes, m      ==>  anchor [3], a, space axes, m
 *   ==>  stiffness  k, N/m                    ==>  rest_length  l >= 0, m */
int nutate_system_add_spring(nutate_system *system, const double body_point[3], const double anchor[3],
                             double stiffness, double rest_length);
/* Adds viscous damping: tau = -diag(c) omega.   ==>  coefficient [3], c, body axes, N m s; negative values drive the body */
int nutate_system_add_damping(nutate_system *system, const double coefficient[3]);

/* Adds a torque tau = torque cos(2 pi frequency t + phase), from start to stop.
 *   ==>  torque       [3], N m
 *   ==>  in_space     true: the torque is in space axes; false: in body axes
 *   ==>  frequency    Hz, may be 0            ==>  phase  rad
 *   ==>  start, stop  s, start < stop; -INFINITY and INFINITY: always. Runs end steps at these times. */
int nutate_system_add_torque(nutate_system *system, const double torque[3], int in_space, double frequency,
                             double phase, double start, double stop);
/* Adds a rotor of constant momentum (gyrostat): L = J omega + h.   ==>  momentum [3], h, body axes, N m s */
int nutate_system_add_rotor(nutate_system *system, const double momentum[3]);

/* Adds effects from one or several groups of a scene file.
 *   ==>  text         such as "&gravity / &damping coefficient = 0, 0, 1e-3 /"
 * Status: NUTATE_BAD_SCENE, also for a second &gravity. */
int nutate_system_add_groups(nutate_system *system, const char *text);

/* ---- User-defined potentials and torques ------------------------------------------------------------------------- */

/* Adds a user-defined potential.
 *   ==>  direction  [3], n, space axes, not zero, of the unit that the potential is written in
 *   ==>  potential  called with gamma; must stay callable as long as the system, its copies and steppers are used
 *   ==>  hessian    or NULL: by differences of the gradient
 *   ==>  user       passed through; or NULL */
int nutate_system_add_potential(nutate_system *system, const double direction[3], nutate_potential potential,
                                nutate_hessian hessian, void *user);

/* Adds a user-defined torque.   ==>  torque, called with t, q, omega; user, passed through or NULL */
int nutate_system_add_user_torque(nutate_system *system, nutate_torque torque, void *user);

/* Sets bounds of the callback that was added last: with them the root of a step can be certified to be that of the true
 * motion; without them every step is reported as uncertified (nutate_stepper_uncertified). They are not verified; the
 * larger they are, the shorter the steps that can be certified.
 * Status: NUTATE_BAD_ARGUMENT without a callback, or unless each is 0 or 1e-300 to 1e100.
 * The bounds of a potential hold for all |gamma| <= |n|, in J over powers of the unit of gamma.
 *   ==>  gradient, hessian, third   of |dU/dgamma|, of the eigenvalues of d2U/dgamma2, of the third derivative along a
 *                                   unit vector */
int nutate_system_bound_potential(nutate_system *system, double gradient, double hessian, double third);

/* Sets bounds of a torque that does not depend on omega, at all attitudes and times, N m.
 *   ==>  torque       of |tau|
 *   ==>  by_rotation, second   of |d tau/d theta|, |d2 tau/d theta2| as the body rotates by theta, rad, about any axis
 *   ==>  rate         1/s: the bounds times rate, and times rate squared, bound the time derivatives; 0: constant in time */
int nutate_system_bound_torque(nutate_system *system, double torque, double by_rotation, double second, double rate);

#ifdef __cplusplus
}
#endif

#endif
