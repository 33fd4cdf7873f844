/* nutate: many bodies whose torques the calling program computes. Included by nutate.h, which explains the notation;
 * docs/how-to/many-bodies.md describes the steps, the first and the last half kick.
 *
 *    nutate_bodies_create((const nutate_system *const *)&rod, 1, NUTATE_SPACE_MOMENTUM, &bodies, NULL, 0);
 *    find_torques(q, torque);
 *    nutate_bodies_kick(bodies, n, NULL, -0.5 * dt, q, l, torque);     l goes half a step behind q, once
 *    for (i = 0; i < steps; ++i) {
 *        nutate_bodies_step(bodies, n, NULL, dt, q, l, torque);
 *        find_torques(q, torque);
 *    }
 *    nutate_bodies_kick(bodies, n, NULL, 0.5 * dt, q, l, torque);      l catches up with q
 *
 * The arrays belong to the program and are changed in place: q[n][4], l[n][3], torque[n][3]. A body with invalid numbers
 * keeps its state; all others move, the function returns NUTATE_NOT_FINITE, and nutate_bodies_failed lists the bodies that
 * failed. A body fails if any of its numbers is not finite or exceeds 1e100, |q| differs from 1 by more than 5e-10, it has
 * no class, or it rotates by more than 1e8 rad. */
#ifndef NUTATE_BODIES_H
#define NUTATE_BODIES_H

#include "nutate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What l is. */
enum nutate_bodies_frame {
    NUTATE_SPACE_MOMENTUM = 0, /* angular momentum in space axes, kg m2/s; torques in space axes */
    NUTATE_BODY_MOMENTUM = 1,  /* angular momentum in body axes, kg m2/s; torques in body axes */
    NUTATE_BODY_RATE = 2       /* angular velocity in body axes, rad/s; torques in body axes */
};

/* Creates classes of bodies.
 *   ==>  classes    [n_classes], systems without effects: their bodies are copied   ==>  n_classes   1 or more
 *   ==>  frame      an enum nutate_bodies_frame
 *   <==  bodies     handle
 *   <==  message    what is wrong; or NULL    ==>  size   of message, bytes */
int nutate_bodies_create(const nutate_system *const *classes, size_t n_classes, int frame, nutate_bodies **bodies,
                         char *message, size_t size);
int nutate_bodies_destroy(nutate_bodies **bodies); /* <=> bodies; frees it */

/* Sets the number of threads that share the bodies of a call. The results are bitwise identical for any number.
 *   ==>  threads   1 unless set; 0: as many as OpenMP gives (OMP_NUM_THREADS); libraries without OpenMP have one */
int nutate_bodies_set_threads(nutate_bodies *bodies, int threads);

/* Moves bodies by a step: l by dt torque, then q without torque.
 *   ==>  n          number of bodies; with 0 the arrays may be NULL
 *   ==>  class_of   [n], class of each body, counted from 0; or NULL: all belong to the first
 *   ==>  dt         s, of either sign, not zero
 *   <=>  q          [n][4], attitudes, unit quaternions, body to space
 *   <=>  l          [n][3], momenta or angular velocities, half a step behind q
 *   ==>  torque     [n][3], torques at q, N m
 * Status: NUTATE_NOT_FINITE if bodies failed, see above. */
int nutate_bodies_step(nutate_bodies *bodies, size_t n, const int *class_of, double dt, double *q, double *l,
                       const double *torque);
/* Changes the momenta only; q is tested and unchanged. Arguments and status are those of nutate_bodies_step. */
int nutate_bodies_kick(nutate_bodies *bodies, size_t n, const int *class_of, double dt, double *q, double *l,
                       const double *torque);
/* Moves bodies without torques. Arguments and status are those of nutate_bodies_step. */
int nutate_bodies_drift(nutate_bodies *bodies, size_t n, const int *class_of, double dt, double *q, double *l);

/* Returns the bodies that failed in the last call.
 *   ==>  most       how many to list, 0 or more
 *   <==  failed     [most], their indices, counted from 0, ascending; or NULL with most = 0
 *   <==  n_failed   number of all; or NULL */
int nutate_bodies_failed(const nutate_bodies *bodies, size_t most, size_t *failed, size_t *n_failed);

#ifdef __cplusplus
}
#endif

#endif
