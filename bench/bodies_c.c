/* Steps of many bodies by the C interface, for bodies_cost.f90. */
#include <nutate.h>

/* There in a library with threads. */
void omp_set_num_threads(int) __attribute__((weak));

/* A handle of bodies with these moments, by one thread; F77 then has one too. */
nutate_bodies *bench_bodies_create(const double moments[3])
{
    if (omp_set_num_threads) omp_set_num_threads(1);
    nutate_system *system = NULL;
    nutate_bodies *bodies = NULL;
    if (!nutate_system_create_moments(moments, 0, NULL, 0, &system, NULL, 0)) {
        const nutate_system *classes[1] = {system};
        if (!nutate_bodies_create(classes, 1, NUTATE_SPACE_MOMENTUM, &bodies, NULL, 0)) nutate_bodies_set_threads(bodies, 1);
    }
    nutate_system_destroy(&system);
    return bodies;
}

/* A step; the status. */
int bench_bodies_step(nutate_bodies *bodies, int n, double dt, double *q, double *l, const double *torque)
{
    return nutate_bodies_step(bodies, (size_t)n, NULL, dt, q, l, torque);
}
