/* Memory of a C stepper that has made a step, and the time of a step of one stepper and of 10,000 in turn.   c_handles */
#include <nutate.h>
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { MANY = 10000 };

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static size_t in_use(void)
{
    struct mallinfo2 heap = mallinfo2();
    return heap.uordblks + heap.hblkhd;
}

/* Seconds of a step, the best of some rounds. */
static double time_of_step(nutate_stepper **steppers, int n, int *status)
{
    double best = 1e9;
    int round, i, k;
    for (round = 0; round < 7; ++round) {
        double start = now();
        for (k = 0; k < 5 * MANY / n; ++k)
            for (i = 0; i < n; ++i) *status |= nutate_stepper_step(steppers[i], 0.01);
        start = (now() - start) / (5.0 * MANY);
        if (start < best) best = start;
    }
    return best;
}

static int measure(const char *name, const char *group, const char *method, const char *formulation)
{
    static nutate_stepper *steppers[MANY];
    const double moments[3] = {5.0, 20.0, 17.0}, center[3] = {0.0, 0.0, 0.5};
    const double q[4] = {1.0, 0.0, 0.0, 0.0}, omega[3] = {0.1, 0.0, 10.0};
    nutate_system *body = NULL;
    size_t before;
    double one, many, bytes;
    int i, status = nutate_system_create_moments(moments, 1.0, center, 0, &body, NULL, 0);
    if (!status && *group) status = nutate_system_add_groups(body, group);
    before = in_use();
    for (i = 0; i < MANY && !status; ++i) {
        status = nutate_stepper_create(body, &steppers[i], NULL, 0);
        if (!status) status = nutate_stepper_set(steppers[i], "method", method);
        if (!status && *formulation) status = nutate_stepper_set(steppers[i], "formulation", formulation);
        if (!status) status = nutate_stepper_set_state(steppers[i], 0.0, q, omega);
        if (!status) status = nutate_stepper_step(steppers[i], 0.01);
    }
    bytes = (double)(in_use() - before) / MANY;
    one = time_of_step(steppers, 1, &status);
    many = time_of_step(steppers, MANY, &status);
    printf("%-28s%10.0f%10.0f%10.0f\n", name, bytes, 1e9 * one, 1e9 * many);
    for (i = 0; i < MANY; ++i) nutate_stepper_destroy(&steppers[i]);
    nutate_system_destroy(&body);
    return status;
}

int main(void)
{
    const char *weight = "&gravity acceleration = 0, 0, -9.81 /", *damping = "&damping coefficient = 0.01, 0.01, 0.01 /";
    int status;
    printf("%-28s%10s%10s%10s\n", "stepper", "bytes", "one, ns", "many, ns");
    status = measure("free body, reduced", "", "nielsen_krenk", "reduced");
    status |= measure("free body, full", "", "nielsen_krenk", "full");
    status |= measure("free body, rk4", "", "rk4", "");
    status |= measure("free body, rk8", "", "rk8", "");
    status |= measure("free body, taylor", "", "taylor", "");
    status |= measure("top, reduced", weight, "nielsen_krenk", "reduced");
    status |= measure("damped, reduced", damping, "nielsen_krenk", "reduced");
    return status;
}
