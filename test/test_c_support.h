/* What the tests of the C interface from C share. Each test returns 0, or the line of the first check that fails. */
#ifndef TEST_C_SUPPORT_H
#define TEST_C_SUPPORT_H

#include "../include/nutate.h"
#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define EXPECT(status, call) \
    do { \
        if ((call) != (status)) return __LINE__; \
    } while (0)
#define CHECK(condition) \
    do { \
        if (!(condition)) return __LINE__; \
    } while (0)

static const double one[4] = {1.0, 0.0, 0.0, 0.0}, vector[3] = {0.1, 0.2, 10.0}, moments[3] = {5.0, 20.0, 17.0},
                    tensor[6] = {5.0, 20.0, 17.0, 0.0, 0.0, 0.0};

static const char scene_text[] =
    "&body inertia = 5, 20, 17 / &initial angular_velocity = 0.1, 0, 10 /\n"
    "&integrator time_step = 0.01, end_time = 1 /\n";

static const char accurate_text[] =
    "&body inertia = 5, 20, 17 / &initial angular_velocity = 0.1, 0, 10 /\n"
    "&integrator order = 4, formulation = 'reduced', accuracy = 1e-6, end_time = 1 /\n";

/* Returns what `user` says, and gives what it says. */
struct answer {
    double from_time; /* torques answer so from this time on */
    int from_call;    /* potentials from this call on */
    int calls;
    int returned;
    double value;
};

static inline int answer_torque(double t, const double q[4], const double omega[3], void *user, double tau[3])
{
    struct answer *answer = user;
    (void)q;
    ++answer->calls;
    tau[0] = -0.1 * omega[0];
    tau[1] = tau[2] = 0.0;
    if (t < answer->from_time) return 0;
    tau[1] = answer->value;
    return answer->returned;
}

static inline int answer_potential(const double gamma[3], void *user, double *energy, double gradient[3])
{
    struct answer *answer = user;
    ++answer->calls;
    *energy = gamma[2];
    gradient[0] = gradient[1] = 0.0;
    gradient[2] = 1.0;
    if (answer->calls < answer->from_call) return 0;
    *energy = answer->value;
    return answer->returned;
}

static inline int flat_hessian(const double gamma[3], void *user, double hessian[3][3])
{
    (void)gamma;
    (void)user;
    memset(hessian, 0, 9 * sizeof(double));
    return 0;
}

static inline int make_box(nutate_system **system)
{
    return nutate_system_create_moments(moments, 12.0, NULL, 0, system, NULL, 0);
}

static inline int make_stepper(nutate_stepper **stepper)
{
    nutate_system *system = NULL;
    int status = make_box(&system);
    if (!status) status = nutate_stepper_create(system, stepper, NULL, 0);
    if (!status) status = nutate_stepper_set_state(*stepper, 0.0, one, vector);
    nutate_system_destroy(&system);
    return status;
}

static inline int make_scene(const char *text, nutate_scene **scene)
{
    return nutate_scene_parse(text, NULL, NULL, 0, scene, NULL, 0);
}

#endif
