/* Dipoles in a box: 10,000 magnetic rods on a lattice of 25 x 20 x 20 places, periodic, each in the field of its six
 * neighbours. The torques are computed here; nutate moves the rods. Lengths are in units of the lattice; mu0/4pi and the
 * moment of a rod are 1. dipoles.f is the same in FORTRAN 77. */
#include <nutate.h>
#include <math.h>
#include <stdio.h>

enum { NX = 25, NY = 20, NZ = 20, N = NX * NY * NZ };
static double q[N][4], l[N][3], torque[N][3], d[N][3];
static const double moments[3] = {1.0, 1.0, 0.1};

static int place(int x, int y, int z) { return (x + NX) % NX + NX * ((y + NY) % NY + NY * ((z + NZ) % NZ)); }

/* Directions of the dipoles, torques m x B, and the potential energy. */
static double find_torques(void)
{
    double energy = 0.0;
    for (int i = 0; i < N; ++i) {
        d[i][0] = 2 * (q[i][1] * q[i][3] + q[i][0] * q[i][2]);
        d[i][1] = 2 * (q[i][2] * q[i][3] - q[i][0] * q[i][1]);
        d[i][2] = 1 - 2 * (q[i][1] * q[i][1] + q[i][2] * q[i][2]);
    }
    for (int z = 0; z < NZ; ++z)
        for (int y = 0; y < NY; ++y)
            for (int x = 0; x < NX; ++x) {
                const int near[3][2] = {{place(x + 1, y, z), place(x - 1, y, z)},
                                        {place(x, y + 1, z), place(x, y - 1, z)},
                                        {place(x, y, z + 1), place(x, y, z - 1)}};
                const double *m = d[place(x, y, z)];
                double *t = torque[place(x, y, z)], b[3] = {0, 0, 0};
                for (int k = 0; k < 3; ++k)
                    for (int s = 0; s < 2; ++s) {
                        const double *other = d[near[k][s]]; /* a neighbour along axis k adds 3 (m.e) e - m */
                        for (int j = 0; j < 3; ++j) b[j] -= other[j];
                        b[k] += 3 * other[k];
                    }
                energy -= 0.5 * (m[0] * b[0] + m[1] * b[1] + m[2] * b[2]);
                t[0] = m[1] * b[2] - m[2] * b[1];
                t[1] = m[2] * b[0] - m[0] * b[2];
                t[2] = m[0] * b[1] - m[1] * b[0];
            }
    return energy;
}

/* Kinetic energy, with the momenta half a step on, at the time of q. */
static double kinetic(double dt)
{
    double energy = 0.0;
    for (int i = 0; i < N; ++i) {
        double square = 0.0, along = 0.0;
        for (int k = 0; k < 3; ++k) {
            const double x = l[i][k] + 0.5 * dt * torque[i][k];
            square += x * x;
            along += x * d[i][k];
        }
        energy += 0.5 * ((square - along * along) / moments[0] + along * along / moments[2]);
    }
    return energy;
}

int main(void)
{
    const double dt = 0.01, turn = 6.283185307179586;
    double first = 0.0, worst = 0.0;
    size_t n_failed = 0, failed[1] = {0};
    nutate_system *rod = NULL;
    nutate_bodies *bodies = NULL;
    int status = nutate_system_create_moments(moments, 0, NULL, 0, &rod, NULL, 0);
    const nutate_system *classes[1] = {rod};
    if (!status) status = nutate_bodies_create(classes, 1, NUTATE_SPACE_MOMENTUM, &bodies, NULL, 0);
    for (int i = 0; i < N; ++i) { /* some attitudes that follow no pattern; at rest */
        const double a = fmod((i + 1) * 0.6180339887, 1.0), u = fmod((i + 1) * 0.7548776662, 1.0);
        q[i][0] = sqrt(1 - u) * cos(turn * a), q[i][1] = sqrt(1 - u) * sin(turn * a), q[i][2] = sqrt(u);
    }
    find_torques();
    if (!status) status = nutate_bodies_kick(bodies, N, NULL, -0.5 * dt, q[0], l[0], torque[0]);
    for (int i = 1; i <= 200 && !status; ++i) {
        status = nutate_bodies_step(bodies, N, NULL, dt, q[0], l[0], torque[0]);
        const double potential = find_torques(), motion = kinetic(dt);
        if (i == 1) first = potential + motion;
        worst = fmax(worst, fabs(potential + motion - first));
        if (i % 50 == 0) printf("t = %.2f  potential %.6f  kinetic %.6f  sum %.6f\n", i * dt, potential, motion, potential + motion);
    }
    if (status) {
        nutate_bodies_failed(bodies, 1, failed, &n_failed);
        fprintf(stderr, "dipoles: status %d, %zu bodies failed, the first is %zu\n", status, n_failed, failed[0]);
    }
    printf("largest change of the energy %.1e\n", worst / fabs(first));
    nutate_bodies_destroy(&bodies);
    nutate_system_destroy(&rod);
    return status || !(worst < 1e-3 * fabs(first));
}
