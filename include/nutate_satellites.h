/**
 * @file nutate_satellites.h
 * @brief Satellites. Rotating frames, orbits, the Earth's field, forces, wheels and controllers, added to a system or
 * read from a stepper. Included by nutate.h, which explains the notation; docs/reference/scenes/ has the
 * formulas, under the groups named here.
 *
 * @code{.c}
 * nutate_system_add_wheel(system, axis, 0.05, 0.0, 0.0, INFINITY, INFINITY);
 * nutate_stepper_create(system, &stepper, NULL, 0);
 * ...
 * nutate_stepper_set_motor(stepper, 1, 0.2);
 * nutate_stepper_run(stepper, 100, 1, NULL, 0, NULL);
 * nutate_stepper_wheel(stepper, 1, &speed, &momentum, work);
 * @endcode
 *
 * Wheels count from 1, as in the columns wheel1, wheel2, ... A limit that does not exist is INFINITY.
 *
 * Only runs support sampled controllers and speed limits: nutate_stepper_run, ..._run_to and ..._run_history, where
 * calls in a row continue one run. Single steps and nutate_stepper_state_at reject them. */
#ifndef NUTATE_SATELLITES_H
#define NUTATE_SATELLITES_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Adding to a system ------------------------------------------------------------------------------------------ */

/** Makes the space axes rotate in inertial space: &rotating_frame. A system has at most one frame or orbit.
 * @param[in,out] system  handle
 * @param[in]     rate    [3], angular velocity of the axes, in these axes, rad/s */
int nutate_system_add_rotating_frame(nutate_system *system, const double rate[3]);

/** Makes the space axes east, north and up at a place on the Earth.
 * @param[in,out] system    handle
 * @param[in]     latitude  latitude, rad, north positive */
int nutate_system_add_latitude(nutate_system *system, double latitude);

/** Puts the body on an orbit: &orbit.
 * @param[in,out] system           handle
 * @param[in]     semi_major_axis  semi-major axis, m
 * @param[in]     eccentricity     eccentricity, >= 0 and < 1
 * @param[in]     angles           [4], inclination, right ascension of the node, argument of periapsis, mean anomaly at
 *                                 t = 0, rad; or NULL: 0
 * @param[in]     mu               gravitational parameter of the centre of attraction, m3/s2; 0: the Earth
 * @param[in]     inertial         true: the space axes are inertial, as those of an eccentric orbit always are; false:
 *                                 the LVLH frame */
int nutate_system_add_orbit(nutate_system *system, double semi_major_axis, double eccentricity, const double *angles,
                            double mu, int inertial);

/** Adds the gravity gradient along the orbit.
 * @param[in,out] system  handle
 * @return status: NUTATE_BAD_ARGUMENT without an orbit. */
int nutate_system_add_orbital_gradient(nutate_system *system);

/** Adds a magnetic moment in the field of the Earth along the orbit: &earth_field.
 * @param[in,out] system        handle
 * @param[in]     moment        [3], body axes, A m2; or NULL: 0, a field for magnetorquers only
 * @param[in]     epoch_angle   angle of Greenwich at t = 0 from the equinox, rad
 * @param[in]     coefficients  [3], g11, h11, g10 of the dipole, T; or NULL: those of 2025
 * @return status: NUTATE_BAD_ARGUMENT without an orbit. */
int nutate_system_add_earth_field(nutate_system *system, const double *moment, double epoch_angle, const double *coefficients);

/** Adds a constant force at a point of the body: &force.
 * @param[in,out] system      handle
 * @param[in]     body_point  [3], body axes, m
 * @param[in]     force       [3], N, in the axes that axes names
 * @param[in]     axes        axes of the force, "space" or "body"; with an orbit "lvlh" or "inertial"
 * @param[in]     start       start, s; -INFINITY: always
 * @param[in]     stop        end, s; INFINITY: always */
int nutate_system_add_force(nutate_system *system, const double body_point[3], const double force[3], const char *axes,
                            double start, double stop);

/** Adds a reaction wheel without a motor: &wheel. The inertia of the body includes its wheels, locked.
 * @param[in,out] system        handle
 * @param[in]     axis          [3], body axes, of any length but zero
 * @param[in]     inertia       moment of inertia about the axis, kg m2
 * @param[in]     speed         initial speed, relative to the body, rad/s
 * @param[in]     friction      coefficient of viscous friction, N m s, >= 0
 * @param[in]     torque_limit  limit of the motor torque, N m; INFINITY: none
 * @param[in]     speed_limit   limit of the speed, rad/s; INFINITY: none
 * @return status: NUTATE_BAD_BODY if the inertia of the wheels is not below that of the body with them. */
int nutate_system_add_wheel(nutate_system *system, const double axis[3], double inertia, double speed, double friction,
                            double torque_limit, double speed_limit);

/** Returns the number of wheels, which is the number of the wheel added last.
 * @param[in]  system  handle
 * @param[out] n       number of wheels */
int nutate_system_wheel_count(const nutate_system *system, size_t *n);

/** Adds a motor to a wheel that has none: torque cos(2 pi frequency t + phase), from start to stop.
 * @param[in,out] system     handle
 * @param[in]     wheel      number of the wheel, 1, 2, ...
 * @param[in]     torque     amplitude of the motor torque about the axis, N m
 * @param[in]     frequency  frequency, Hz
 * @param[in]     phase      phase, rad
 * @param[in]     start      start, s; -INFINITY: always
 * @param[in]     stop       end, s; INFINITY: always
 * @return status: NUTATE_BAD_ARGUMENT also if a controller drives the wheels, or the torque exceeds the limit. */
int nutate_system_add_motor(nutate_system *system, size_t wheel, double torque, double frequency, double phase,
                            double start, double stop);

/** Adds a motor with a tabulated torque to a wheel that has none.
 * @param[in,out] system  handle
 * @param[in]     wheel   number of the wheel, 1, 2, ...
 * @param[in]     n       number of lines
 * @param[in]     t       [n], times, s, increasing
 * @param[in]     torque  [n], motor torques about the axis, N m
 * @param[in]     keys    keys of &wheel that go with a table, "interpolation = 'cubic', outside = 'periodic', start =
 *                        1"; or NULL */
int nutate_system_add_motor_table(nutate_system *system, size_t wheel, size_t n, const double *t, const double *torque,
                                  const char *keys);

/** Adds a controller that points the body: &controller law = 'quaternion', after all wheels that it uses. A nominal
 * inertia, and gain matrices: nutate_system_add_groups.
 * @param[in,out] system         handle
 * @param[in]     by             actuators, "torque", "wheels" or "magnetorquers"
 * @param[in]     target         [4], attitude, body to space; or NULL: the identity
 * @param[in]     attitude_gain  gain >= 0, N m; 1/s2 with by_inertia
 * @param[in]     rate_gain      gain >= 0, N m s; 1/s with by_inertia
 * @param[in]     by_inertia     true: the gains are multiplied by the inertia of the body; false: the gains are used as
 *                               they are
 * @param[in]     field          [3], space axes, T, for magnetorquers; or NULL: with magnetorquers that of the Earth
 * @param[in]     sample         sampling period, s; 0: continuous
 * @param[in]     limit          limit of each component of the torque, N m, or of the moment of the magnetorquers,
 *                               A m2; INFINITY: none */
int nutate_system_add_pointing(nutate_system *system, const char *by, const double *target, double attitude_gain,
                               double rate_gain, int by_inertia, const double *field, double sample, double limit);

/** Adds a controller that stops tumbling by magnetorquers: law = 'bdot'.
 * @param[in,out] system  handle
 * @param[in]     gain    gain, A m2 s/T
 * @param[in]     field   [3], space axes, T; or NULL: that of the Earth
 * @param[in]     sample  sampling period, s; 0: continuous
 * @param[in]     limit   limit of each component of the moment of the magnetorquers, A m2; INFINITY: none */
int nutate_system_add_detumbling(nutate_system *system, double gain, const double field[3], double sample, double limit);

/* ---- Reading a stepper with wheels or an orbit ------------------------------------------------------------------- */

/** Returns the number of wheels. @param[in] stepper handle @param[out] n number of wheels */
int nutate_stepper_wheel_count(const nutate_stepper *stepper, size_t *n);

/** Returns the current state of a wheel.
 * @param[in]  stepper   handle
 * @param[in]  wheel     number of the wheel, 1, 2, ...
 * @param[out] speed     speed of the wheel, relative to the body, rad/s; or NULL
 * @param[out] momentum  angular momentum, absolute, about the axis, N m s; or NULL
 * @param[out] work      [2], work of motor and friction since the state was set, J; or NULL
 * @return status: NUTATE_BAD_ARGUMENT for a wheel that does not exist. */
int nutate_stepper_wheel(const nutate_stepper *stepper, size_t wheel, double *speed, double *momentum, double work[2]);

/** Sets the motor torque of a wheel, held until it is set again or a state is set: for control by the calling program.
 * @param[in,out] stepper  handle
 * @param[in]     wheel    number of the wheel, 1, 2, ...; a wheel without a motor, of a system without a controller by
 *                         wheels
 * @param[in]     torque   motor torque about the axis, N m, up to the limit of the wheel */
int nutate_stepper_set_motor(nutate_stepper *stepper, size_t wheel, double torque);

/** Returns the number of inner spheres, which groups of a scene add.
 * @param[in]  stepper  handle
 * @param[out] n        number of inner spheres */
int nutate_stepper_sphere_count(const nutate_stepper *stepper, size_t *n);

/** Returns the current state of an inner sphere.
 * @param[in]  stepper   handle
 * @param[in]  sphere    number of the sphere, 1, 2, ...
 * @param[out] rate      [3], angular velocity relative to the body, body axes, rad/s; or NULL
 * @param[out] momentum  [3], angular momentum, space axes, N m s; or NULL
 * @param[out] energy    kinetic energy, J; or NULL
 * @param[out] work      work of the friction since the state was set, J; or NULL
 * @return status: NUTATE_BAD_ARGUMENT for a sphere that does not exist. */
int nutate_stepper_sphere(const nutate_stepper *stepper, size_t sphere, double rate[3], double momentum[3],
                          double *energy, double *work);

/** Returns the Jacobi integral T + V - omega.l; T + V if the space axes do not rotate. Calls user-defined potentials.
 * @param[in,out] stepper  handle
 * @param[out]    jacobi   Jacobi integral, J */
int nutate_stepper_jacobi(nutate_stepper *stepper, double *jacobi);

/** Returns the work of potentials and of an inertia that depend on time since the state was set.
 * @param[in]  stepper  handle
 * @param[out] work     work, J */
int nutate_stepper_time_dependent_work(const nutate_stepper *stepper, double *work);

/** Returns the position on the orbit.
 * @param[in]  stepper       handle
 * @param[out] position      [3], from the centre of attraction, inertial axes, m; or NULL
 * @param[out] true_anomaly  true anomaly, rad, which grows by 2 pi in each revolution; or NULL
 * @return status: NUTATE_BAD_ARGUMENT without an orbit. */
int nutate_stepper_orbit(const nutate_stepper *stepper, double position[3], double *true_anomaly);

/** Returns the attitude in the LVLH frame.
 * @param[in]  stepper  handle
 * @param[out] q        [4], attitude, body to LVLH; or NULL
 * @param[out] angles   [3], roll, pitch, yaw, rad; or NULL */
int nutate_stepper_lvlh_attitude(const nutate_stepper *stepper, double q[4], double angles[3]);

#ifdef __cplusplus
}
#endif

#endif
