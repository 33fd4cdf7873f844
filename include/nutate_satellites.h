/* nutate: satellites. Rotating frames, orbits, the Earth's field, forces, wheels and controllers, added to a system or
 * read from a stepper. Included by nutate.h, which explains the notation; docs/reference/scenes/ has the
 * formulas, under the groups named here.
 *
 *    nutate_system_add_wheel(system, axis, 0.05, 0.0, 0.0, INFINITY, INFINITY);
 *    nutate_stepper_create(system, &stepper, NULL, 0);
 *    ...
 *    nutate_stepper_set_motor(stepper, 1, 0.2);
 *    nutate_stepper_run(stepper, 100, 1, NULL, 0, NULL);
 *    nutate_stepper_wheel(stepper, 1, &speed, &momentum, work);
 *
 * Wheels count from 1, as in the columns wheel1, wheel2, ... A limit that does not exist is INFINITY.
 *
 * Only runs support sampled controllers and speed limits: nutate_stepper_run, ..._run_to and ..._run_history, where calls
 * in a row continue one run. Single steps and nutate_stepper_state_at reject them. */
#ifndef NUTATE_SATELLITES_H
#define NUTATE_SATELLITES_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Adding to a system ------------------------------------------------------------------------------------------ */

/* Makes the space axes rotate in inertial space: &rotating_frame. A system has at most one frame or orbit.
 *   ==>  rate [3], angular velocity of the axes, in these axes, rad/s */
int nutate_system_add_rotating_frame(nutate_system *system, const double rate[3]);
/* Makes the space axes east, north and up at a place on the Earth.   ==>  latitude, rad, north positive */
int nutate_system_add_latitude(nutate_system *system, double latitude);

/* Puts the body on an orbit: &orbit.
 *   ==>  semi_major_axis  m              ==>  eccentricity  >= 0 and < 1
 *   ==>  angles    [4], inclination, right ascension of the node, argument of periapsis, mean anomaly at t = 0, rad; or NULL: 0
 *   ==>  mu        of the centre of attraction, m3/s2; 0: the Earth
 *   ==>  inertial  true: the space axes are inertial, as those of an eccentric orbit always are; false: the LVLH frame */
int nutate_system_add_orbit(nutate_system *system, double semi_major_axis, double eccentricity, const double *angles,
                            double mu, int inertial);
/* Adds the gravity gradient along the orbit.   Status: NUTATE_BAD_ARGUMENT without an orbit. */
int nutate_system_add_orbital_gradient(nutate_system *system);

/* Adds a magnetic moment in the field of the Earth along the orbit: &earth_field.
 *   ==>  moment       [3], body axes, A m2; or NULL: 0, a field for magnetorquers only
 *   ==>  epoch_angle  of Greenwich at t = 0 from the equinox, rad
 *   ==>  coefficients [3], g11, h11, g10 of the dipole, T; or NULL: those of 2025
 * Status: NUTATE_BAD_ARGUMENT without an orbit. */
int nutate_system_add_earth_field(nutate_system *system, const double *moment, double epoch_angle, const double *coefficients);
/* Adds a constant force at a point of the body: &force.
 *   ==>  body_point  [3], body axes, m         ==>  force  [3], N, in its axes
 *   ==>  axes        "space" or "body"; with an orbit "lvlh" or "inertial"
 *   ==>  start, stop s; -INFINITY and INFINITY: always */
int nutate_system_add_force(nutate_system *system, const double body_point[3], const double force[3], const char *axes,
                            double start, double stop);

/* Adds a reaction wheel without a motor: &wheel. The inertia of the body includes its wheels, locked.
 *   ==>  axis          [3], body axes, of any length but zero
 *   ==>  inertia       about the axis, kg m2      ==>  speed        at the start, relative to the body, rad/s
 *   ==>  friction      N m s, >= 0
 *   ==>  torque_limit  of the motor, N m          ==>  speed_limit  rad/s; INFINITY: none
 * Status: NUTATE_BAD_BODY if the inertia of the wheels is not below that of the body with them. */
int nutate_system_add_wheel(nutate_system *system, const double axis[3], double inertia, double speed, double friction,
                            double torque_limit, double speed_limit);

/* Returns the number of wheels, which is the number of the wheel added last.   ==>  system   <==  n */
int nutate_system_wheel_count(const nutate_system *system, size_t *n);

/* Adds a motor to a wheel that has none: torque cos(2 pi frequency t + phase), from start to stop.
 *   ==>  wheel        1, 2, ...
 *   ==>  torque, N m; frequency, Hz; phase, rad; start, stop, s, -INFINITY and INFINITY: always
 * Status: NUTATE_BAD_ARGUMENT also if a controller drives the wheels, or the torque exceeds the limit. */
int nutate_system_add_motor(nutate_system *system, size_t wheel, double torque, double frequency, double phase,
                            double start, double stop);
/* Adds a motor with a tabulated torque to a wheel that has none.
 *   ==>  n, t [n], s, increasing; torque [n], N m
 *   ==>  keys   keys of &wheel that go with a table, "interpolation = 'cubic', outside = 'periodic', start = 1"; or NULL */
int nutate_system_add_motor_table(nutate_system *system, size_t wheel, size_t n, const double *t, const double *torque,
                                  const char *keys);

/* Adds a controller that points the body: &controller law = 'quaternion', after all wheels that it uses.
 *   ==>  by          "torque", "wheels" or "magnetorquers"
 *   ==>  target      [4], attitude, body to space; or NULL: the identity
 *   ==>  attitude_gain, rate_gain   >= 0; with by_inertia times the inertia of the body, 1/s2 and 1/s, else as they are,
 *                                   N m and N m s; a nominal inertia, and gain matrices: nutate_system_add_groups
 *   ==>  field       [3], space axes, T, for magnetorquers; or NULL: with magnetorquers that of the Earth
 *   ==>  sample      sampling period, s; 0: continuous
 *   ==>  limit       of each component of the torque, N m, or of the moment of the magnetorquers, A m2; INFINITY: none */
int nutate_system_add_pointing(nutate_system *system, const char *by, const double *target, double attitude_gain,
                               double rate_gain, int by_inertia, const double *field, double sample, double limit);
/* Adds a controller that stops tumbling by magnetorquers: law = 'bdot'.
 *   ==>  gain, A m2 s/T; field [3], space axes, T, or NULL: that of the Earth; sample, limit: as above */
int nutate_system_add_detumbling(nutate_system *system, double gain, const double field[3], double sample, double limit);

/* ---- Reading a stepper with wheels or an orbit ------------------------------------------------------------------- */

/* Returns the number of wheels.   ==>  stepper   <==  n */
int nutate_stepper_wheel_count(const nutate_stepper *stepper, size_t *n);
/* Returns the current state of a wheel.
 *   ==>  wheel     1, 2, ...
 *   <==  speed     relative to the body, rad/s; or NULL      <==  momentum  absolute, about the axis, N m s; or NULL
 *   <==  work      [2], of motor and friction since the state was set, J; or NULL
 * Status: NUTATE_BAD_ARGUMENT for a wheel that does not exist. */
int nutate_stepper_wheel(const nutate_stepper *stepper, size_t wheel, double *speed, double *momentum, double work[2]);

/* Sets the motor torque of a wheel, held until it is set again or a state is set: for control by the calling program.
 *   ==>  wheel     one without a motor, of a system without a controller by wheels
 *   ==>  torque    N m, up to the limit of the wheel */
int nutate_stepper_set_motor(nutate_stepper *stepper, size_t wheel, double torque);

/* Returns the number of inner spheres, which groups of a scene add.   ==>  stepper   <==  n */
int nutate_stepper_sphere_count(const nutate_stepper *stepper, size_t *n);
/* Returns the current state of an inner sphere.
 *   ==>  sphere    1, 2, ...
 *   <==  rate      [3], relative to the body, body axes, rad/s; or NULL
 *   <==  momentum  [3], space axes, N m s; or NULL           <==  energy  kinetic, J; or NULL
 *   <==  work      of friction since the state was set, J; or NULL
 * Status: NUTATE_BAD_ARGUMENT for a sphere that does not exist. */
int nutate_stepper_sphere(const nutate_stepper *stepper, size_t sphere, double rate[3], double momentum[3],
                          double *energy, double *work);

/* Returns the Jacobi integral T + V - omega.l, J; T + V if the space axes do not rotate. Calls user-defined potentials.
 *   <==  jacobi  J */
int nutate_stepper_jacobi(nutate_stepper *stepper, double *jacobi);
/* Returns the work of time-dependent potentials since the state was set, J.   ==>  stepper   <==  work */
int nutate_stepper_time_dependent_work(const nutate_stepper *stepper, double *work);

/* Returns the position on the orbit.
 *   <==  position      [3], from the centre of attraction, inertial axes, m; or NULL
 *   <==  true_anomaly  rad, which grows by 2 pi in each revolution; or NULL
 * Status: NUTATE_BAD_ARGUMENT without an orbit. */
int nutate_stepper_orbit(const nutate_stepper *stepper, double position[3], double *true_anomaly);
/* Returns the attitude in the LVLH frame.
 *   <==  q       [4], body to LVLH; or NULL
 *   <==  angles  [3], roll, pitch, yaw, rad; or NULL */
int nutate_stepper_lvlh_attitude(const nutate_stepper *stepper, double q[4], double angles[3]);

#ifdef __cplusplus
}
#endif

#endif
