/**
 * @file nutate.h
 * @brief Rotation of rigid bodies, integrated with quaternions so that energy, momentum and the unit norm hold to
 * round-off at any step size (Nielsen & Krenk 2012). C interface; usable from C++.
 *
 * A system is a rigid body with the effects that act on it. A stepper integrates the motion of one system. A scene is
 * an input file that describes both; it can be run as a whole, or be turned into a system or a stepper. A history holds
 * the output points of a run.
 *
 * @code{.c}
 * #include <nutate.h>
 * #include <stdio.h>
 *
 * int main(void)
 * {
 *     const double edges[3] = {4, 1, 2}, q[4] = {1, 0, 0, 0}, omega[3] = {0.1, 0, 10};
 *     double energy[5];
 *     nutate_system *box = NULL;
 *     nutate_stepper *stepper = NULL;
 *     int status = nutate_system_create_shape("box", edges, 3, 12.0, 0.0, NULL, &box, NULL, 0);
 *     if (!status) status = nutate_stepper_create(box, &stepper, NULL, 0);
 *     if (!status) status = nutate_stepper_set_state(stepper, 0.0, q, omega);
 *     for (int i = 0; i < 1000 && !status; ++i) status = nutate_stepper_step(stepper, 0.01);
 *     if (!status) status = nutate_stepper_energy(stepper, energy);
 *     if (!status) printf("%.15g J, off by %.1e J\n", energy[2], energy[4]);
 *     nutate_stepper_destroy(&stepper);
 *     nutate_system_destroy(&box);
 *     return status;
 * }
 * @endcode
 *
 * @par Conventions
 * The library reads an argument marked [in], writes one marked [out], and reads and changes one marked [in,out]. The
 * shape of an array stands in brackets. Every function returns NUTATE_OK (0) or another status; on failure nothing has
 * changed, and outputs are untouched unless stated otherwise. No argument may be NULL unless marked "or NULL"; a NULL
 * is reported, never dereferenced.
 *
 * SI units; angles in radians. Space axes are inertial, unless the system has a rotating frame or an orbit with frame =
 * 'lvlh': then they are the axes of that frame, or the LVLH frame. Body axes are fixed in the body. The origin of both
 * is the reference point of the body, which stays at rest. Quaternions are unit quaternions, scalar first, and convert
 * body components to space components. Arrays are contiguous; [3][3] is row by row.
 *
 * Numeric arguments obey the limits of the scene keys, and are rejected with the same messages: finite, zero or 1e-300
 * to 1e100 in size; positive ones at least 1e-100; steps 1e-50 to 1e50 s in size. Times and states, which a program may
 * pass from call to call, may be smaller.
 *
 * Booleans are int: 0 or another number. Strings end with NUL; UTF-8 passes through unchanged. Strings are returned
 * through (buffer, size): they are truncated to size - 1 bytes and always end with NUL; a truncated string gives
 * NUTATE_TRUNCATED. Functions that have no handle yet return the error message through (message, size). message may be
 * NULL (with any size); truncating it is not an error.
 *
 * @par Handles
 * A create function sets *handle, to NULL if it fails; the destroy function frees it and sets *handle to NULL (a NULL
 * in *handle is fine). A handle that is NULL, of another kind or destroyed gives NUTATE_BAD_HANDLE, as far as the
 * memory it points to shows this. A stepper has a copy of its system: the system may be changed or destroyed afterwards
 * without effect on it.
 *
 * @par Threads
 * The library has no global state. Several threads may use a handle simultaneously in functions that receive it as
 * const; otherwise one thread at a time. Different handles are independent.
 *
 * Nothing is printed, and the program is never stopped. */
#ifndef NUTATE_H
#define NUTATE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Major version of the headers. */
#define NUTATE_VERSION_MAJOR 0
/** Minor version of the headers. */
#define NUTATE_VERSION_MINOR 1
/** Patch version of the headers. */
#define NUTATE_VERSION_PATCH 0

/** Status that every function returns. */
enum nutate_status {
    NUTATE_OK = 0,            /**< success */
    NUTATE_NOT_CONVERGED = 1, /**< the iteration of a step did not converge */
    NUTATE_OFF_BRANCH = 2,    /**< the step is too long to follow the motion */
    NUTATE_SINGULAR = 3,      /**< the linear system of a step is singular */
    NUTATE_NOT_FINITE = 4,    /**< a number is not finite or exceeds 1e100, in a step or from a callback */
    NUTATE_BAD_ARGUMENT = 5,  /**< an argument is out of its range */
    NUTATE_BAD_BODY = 6,      /**< the inertia is not that of a rigid body */
    NUTATE_BAD_SCENE = 7,     /**< a scene contains an error */
    NUTATE_IO = 8,            /**< a file cannot be read or written */
    NUTATE_STEP_LIMIT = 9,    /**< the run needs more steps than allowed */
    NUTATE_BAD_HANDLE = 10,   /**< not a handle of this kind: NULL, another kind, destroyed */
    NUTATE_CALLBACK = 11,     /**< a callback reported a failure */
    NUTATE_TRUNCATED = 12,    /**< a string did not fit into its buffer and was truncated */
    NUTATE_NO_MEMORY = 13,    /**< memory ran out */
    NUTATE_STOPPED = 14       /**< an observer or the poll callback ended the run */
};

/** A rigid body and the effects that act on it. */
typedef struct nutate_system nutate_system;

/** A scene file, read and checked. */
typedef struct nutate_scene nutate_scene;

/** A method with its settings, its system and the current state. */
typedef struct nutate_stepper nutate_stepper;

/** The output points of a run. */
typedef struct nutate_history nutate_history;

/** Classes of many bodies that the program moves. */
typedef struct nutate_bodies nutate_bodies;

/* ---- General ----------------------------------------------------------------------------------------------------- */

/** Returns the version of the library.
 * @param[out] buffer  version, such as "0.1.0"
 * @param[in]  size    size of buffer, bytes */
int nutate_get_version(char *buffer, size_t size);

/** Returns a human-readable description of a status code.
 * @param[in]  status  status of any function; unknown codes have a description too
 * @param[out] buffer  description
 * @param[in]  size    size of buffer, bytes */
int nutate_status_text(int status, char *buffer, size_t size);

/** Returns why the last call with this handle (not const) failed.
 * @param[in]  handle  any handle
 * @param[out] buffer  error message; empty after a success
 * @param[in]  size    size of buffer, bytes */
int nutate_last_message(const void *handle, char *buffer, size_t size);

/* ---- Callbacks --------------------------------------------------------------------------------------------------- */

/* A callback returns 0, or another number to report a failure: the calling function then returns NUTATE_CALLBACK with
 * that number in its message. Results that are not finite or exceed 1e100 give NUTATE_NOT_FINITE. In both cases the
 * state is the one before the step.
 *
 * Potentials are called when a state is set, in steps, and when energy is read; torques in steps. A callback is called
 * several times in a step, also at trial states that are discarded. Its result must depend on its arguments alone (and
 * on data that do not change during a step): otherwise the step does not converge, or energy is not conserved. It must
 * return: neither longjmp nor a C++ exception may leave it. It must not call functions with the handle that called it.
 * It must be thread-safe if several threads use it. */

/** A potential V = U(gamma), gamma = R'n the body components of a vector n fixed in space. With the exact gradient,
 * energy and the angular momentum about n are conserved to round-off.
 * @param[in]     gamma     [3], body axes; |gamma| = |n| at the ends of steps, a little less inside
 * @param[in,out] user      as given to the add function
 * @param[out]    energy    U, J
 * @param[out]    gradient  [3], dU/dgamma, body axes, J over the unit of gamma
 * @return 0, or another number to report a failure */
typedef int (*nutate_potential)(const double gamma[3], void *user, double *energy, double gradient[3]);

/** The second derivatives of a potential.
 * @param[in]     gamma    [3], body axes, as for the potential
 * @param[in,out] user     as for the potential
 * @param[out]    hessian  [3][3], d2U/dgamma2, symmetric, body axes, J over the unit of gamma squared
 * @return 0, or another number to report a failure */
typedef int (*nutate_hessian)(const double gamma[3], void *user, double hessian[3][3]);

/** A torque. Its work enters the energy balance, which closes to round-off.
 * @param[in]     t      time, s
 * @param[in]     q      [4], attitude, body to space
 * @param[in]     omega  [3], absolute angular velocity, relative to the stars, body axes, rad/s; relative to the space
 *                       axes it is omega - R'w, with the rate w of these axes from nutate_system_frame_rate
 * @param[in,out] user   as given to the add function
 * @param[out]    tau    [3], torque, body axes, N m
 * @return 0, or another number to report a failure */
typedef int (*nutate_torque)(double t, const double q[4], const double omega[3], void *user, double tau[3]);

#ifdef __cplusplus
}
#endif

#include "nutate_system.h"
#include "nutate_scene.h"
#include "nutate_stepper.h"
#include "nutate_attitude.h"
#include "nutate_events.h"
#include "nutate_runs.h"
#include "nutate_satellites.h"
#include "nutate_sweep.h"
#include "nutate_bodies.h"
#include "nutate_exchange.h"

#endif
