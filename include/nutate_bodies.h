/**
 * @file nutate_bodies.h
 * @brief Many bodies whose torques the calling program computes. Included by nutate.h, which explains the notation;
 * docs/how-to/many-bodies.md describes the steps, the first and the last half kick.
 *
 * @code{.c}
 * nutate_bodies_create((const nutate_system *const *)&rod, 1, NUTATE_SPACE_MOMENTUM, &bodies, NULL, 0);
 * find_torques(q, torque);
 * nutate_bodies_kick(bodies, n, NULL, -0.5 * dt, q, l, torque);  // l goes half a step behind q, once
 * for (i = 0; i < steps; ++i) {
 *     nutate_bodies_step(bodies, n, NULL, dt, q, l, torque);
 *     find_torques(q, torque);
 * }
 * nutate_bodies_kick(bodies, n, NULL, 0.5 * dt, q, l, torque);   // l catches up with q
 * @endcode
 *
 * The arrays belong to the program and are changed in place: q[n][4], l[n][3], torque[n][3]. A body with invalid
 * numbers keeps its state; all others move, the function returns NUTATE_NOT_FINITE, and nutate_bodies_failed lists the
 * bodies that failed. A body fails if any of its numbers is not finite or exceeds 1e100, |q| differs from 1 by more
 * than 5e-10, it has no class, or it rotates by more than 1e8 rad. */
#ifndef NUTATE_BODIES_H
#define NUTATE_BODIES_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Quantity and axes of the array l. */
enum nutate_bodies_frame {
    NUTATE_SPACE_MOMENTUM = 0, /**< angular momentum in space axes, kg m2/s; torques in space axes */
    NUTATE_BODY_MOMENTUM = 1,  /**< angular momentum in body axes, kg m2/s; torques in body axes */
    NUTATE_BODY_RATE = 2       /**< angular velocity in body axes, rad/s; torques in body axes */
};

/** Creates classes of bodies.
 * @param[in]  classes    [n_classes], handles of systems without effects: their bodies are copied
 * @param[in]  n_classes  number of classes, 1 or more
 * @param[in]  frame      an enum nutate_bodies_frame
 * @param[out] bodies     new handle; NULL on failure
 * @param[out] message    error message; or NULL
 * @param[in]  size       size of message, bytes */
int nutate_bodies_create(const nutate_system *const *classes, size_t n_classes, int frame, nutate_bodies **bodies,
                         char *message, size_t size);

/** Frees classes of bodies. @param[in,out] bodies handle; NULL afterwards */
int nutate_bodies_destroy(nutate_bodies **bodies);

/** Sets the number of threads that share the bodies of a call. The results are bitwise identical for any number.
 * A process forked from one that has used threads has one.
 * @param[in,out] bodies   handle
 * @param[in]     threads  1 unless set; 0: as many as OpenMP gives (OMP_NUM_THREADS); libraries without OpenMP have one
 */
int nutate_bodies_set_threads(nutate_bodies *bodies, int threads);

/** Moves bodies by a step: l by dt torque, then q without torque.
 * @param[in,out] bodies    handle
 * @param[in]     n         number of bodies; with 0 the arrays may be NULL
 * @param[in]     class_of  [n], class of each body, counted from 0; or NULL: all belong to the first
 * @param[in]     dt        step, s, of either sign, not zero
 * @param[in,out] q         [n][4], attitudes, unit quaternions, body to space
 * @param[in,out] l         [n][3], momenta or angular velocities, in the axes and unit of frame, half a step behind q
 * @param[in]     torque    [n][3], torques at q, in the axes of frame, N m
 * @return status: NUTATE_NOT_FINITE if bodies failed, see the head of this file. */
int nutate_bodies_step(nutate_bodies *bodies, size_t n, const int *class_of, double dt, double *q, double *l,
                       const double *torque);

/** Changes the momenta only.
 * @param[in,out] bodies    handle
 * @param[in]     n         number of bodies; with 0 the arrays may be NULL
 * @param[in]     class_of  [n], class of each body, counted from 0; or NULL: all belong to the first
 * @param[in]     dt        step, s, of either sign, not zero
 * @param[in,out] q         [n][4], attitudes, unit quaternions, body to space; tested and unchanged
 * @param[in,out] l         [n][3], momenta or angular velocities, in the axes and unit of frame
 * @param[in]     torque    [n][3], torques at q, in the axes of frame, N m
 * @return status: as nutate_bodies_step. */
int nutate_bodies_kick(nutate_bodies *bodies, size_t n, const int *class_of, double dt, double *q, double *l,
                       const double *torque);

/** Moves bodies without torques.
 * @param[in,out] bodies    handle
 * @param[in]     n         number of bodies; with 0 the arrays may be NULL
 * @param[in]     class_of  [n], class of each body, counted from 0; or NULL: all belong to the first
 * @param[in]     dt        step, s, of either sign, not zero
 * @param[in,out] q         [n][4], attitudes, unit quaternions, body to space
 * @param[in,out] l         [n][3], momenta or angular velocities, in the axes and unit of frame, half a step behind q
 * @return status: as nutate_bodies_step. */
int nutate_bodies_drift(nutate_bodies *bodies, size_t n, const int *class_of, double dt, double *q, double *l);

/** Returns the bodies that failed in the last call.
 * @param[in]  bodies    handle
 * @param[in]  most      number of bodies to list, 0 or more
 * @param[out] failed    [most], their indices, counted from 0, ascending; or NULL with most = 0
 * @param[out] n_failed  number of all; or NULL */
int nutate_bodies_failed(const nutate_bodies *bodies, size_t most, size_t *failed, size_t *n_failed);

#ifdef __cplusplus
}
#endif

#endif
