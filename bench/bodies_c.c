/* Steps of many bodies by the C interface, for bodies_cost.f90. */
#include <nutate.h>

/* A handle of bodies with these moments. */
nutate_bodies *bench_bodies_create(const double moments[3])
{
    nutate_system *system = NULL;
    nutate_bodies *bodies = NULL;
    if (!nutate_system_create_moments(moments, 0, NULL, 0, &system, NULL, 0)) {
        const nutate_system *classes[1] = {system};
        nutate_bodies_create(classes, 1, NUTATE_SPACE_MOMENTUM, &bodies, NULL, 0);
    }
    nutate_system_destroy(&system);
    return bodies;
}

/* A step; the status. */
int bench_bodies_step(nutate_bodies *bodies, int n, double dt, double *q, double *l, const double *torque)
{
    return nutate_bodies_step(bodies, (size_t)n, NULL, dt, q, l, torque);
}
