/* The C interface: many bodies. Each function returns 0, or the line of the first check that fails. */
#include "test_c_support.h"

int test_c_bodies_steps(void);
int test_c_bodies_failures(void);
int test_c_bodies_refused(void);

enum { N = 40 };

static const double cone[3] = {1.0, 1.0, 0.5};

/* A box and a cone. */
static int make_bodies(int frame, nutate_bodies **bodies)
{
    nutate_system *system[2] = {NULL, NULL};
    int status = nutate_system_create_moments(moments, 0.0, NULL, 0, &system[0], NULL, 0);
    if (!status) status = nutate_system_create_moments(cone, 0.0, NULL, 0, &system[1], NULL, 0);
    if (!status) status = nutate_bodies_create((const nutate_system *const *)system, 2, frame, bodies, NULL, 0);
    nutate_system_destroy(&system[0]);
    nutate_system_destroy(&system[1]);
    return status;
}

static void start(double q[N][4], double l[N][3], double torque[N][3])
{
    int i, k;
    for (i = 0; i < N; ++i) {
        double norm = 0.0;
        for (k = 0; k < 4; ++k) {
            q[i][k] = sin(1.0 + 7 * i + 3 * k);
            norm += q[i][k] * q[i][k];
        }
        for (k = 0; k < 4; ++k) q[i][k] /= sqrt(norm);
        for (k = 0; k < 3; ++k) l[i][k] = cos(2.0 * i + k), torque[i][k] = sin(3.0 * i + k);
    }
}

/* A step is a kick and a drift; momenta change by their impulses; one body of the box follows its exact motion. */
int test_c_bodies_steps(void)
{
    static double q[N][4], l[N][3], torque[N][3], q1[N][4], l1[N][3];
    int class_of[N], i, k;
    double t = 0.4, exact[4], angle, omega[3] = {0.1, 0.2, 10.0}, rate[3], rotated[4];
    nutate_bodies *bodies = NULL;
    nutate_system *box = NULL;
    EXPECT(NUTATE_OK, make_bodies(NUTATE_SPACE_MOMENTUM, &bodies));
    start(q, l, torque);
    memcpy(q1, q, sizeof q);
    memcpy(l1, l, sizeof l);
    for (i = 0; i < N; ++i) class_of[i] = i % 2;
    EXPECT(NUTATE_OK, nutate_bodies_step(bodies, N, class_of, 0.1, q[0], l[0], torque[0]));
    for (i = 0; i < N; ++i)
        for (k = 0; k < 3; ++k) CHECK(l[i][k] == l1[i][k] + 0.1 * torque[i][k]);
    EXPECT(NUTATE_OK, nutate_bodies_set_threads(bodies, 2));
    EXPECT(NUTATE_OK, nutate_bodies_kick(bodies, N, class_of, 0.1, q1[0], l1[0], torque[0]));
    EXPECT(NUTATE_OK, nutate_bodies_drift(bodies, N, class_of, 0.1, q1[0], l1[0]));
    CHECK(memcmp(q, q1, sizeof q) == 0 && memcmp(l, l1, sizeof l) == 0);
    EXPECT(NUTATE_OK, nutate_bodies_destroy(&bodies));
    CHECK(bodies == NULL);

    EXPECT(NUTATE_OK, make_bodies(NUTATE_BODY_RATE, &bodies));
    EXPECT(NUTATE_OK, make_box(&box));
    EXPECT(NUTATE_OK, nutate_exact_free_body(box, one, omega, 1, &t, exact, rate));
    memcpy(rotated, one, sizeof rotated);
    for (i = 0; i < 100; ++i) EXPECT(NUTATE_OK, nutate_bodies_drift(bodies, 1, NULL, t / 100, rotated, omega));
    EXPECT(NUTATE_OK, nutate_attitude_distance(rotated, exact, &angle));
    CHECK(angle < 1e-6);
    for (k = 0; k < 3; ++k) CHECK(fabs(omega[k] - rate[k]) < 1e-5);
    EXPECT(NUTATE_OK, nutate_system_destroy(&box));
    EXPECT(NUTATE_OK, nutate_bodies_destroy(&bodies));
    return 0;
}

/* Bodies that fail keep their state and are listed by their indices in C. */
int test_c_bodies_failures(void)
{
    static double q[N][4], l[N][3], torque[N][3], q1[N][4];
    size_t failed[4] = {99, 99, 99, 99}, n_failed = 99;
    int class_of[N] = {0}, i;
    char text[256];
    nutate_bodies *bodies = NULL;
    EXPECT(NUTATE_OK, make_bodies(NUTATE_SPACE_MOMENTUM, &bodies));
    EXPECT(NUTATE_OK, nutate_bodies_failed(bodies, 0, NULL, &n_failed));
    CHECK(n_failed == 0);
    start(q, l, torque);
    memcpy(q1, q, sizeof q);
    torque[0][1] = NAN;
    l[17][2] = INFINITY;
    class_of[20] = 2;
    class_of[39] = -1;
    EXPECT(NUTATE_NOT_FINITE, nutate_bodies_step(bodies, N, class_of, 0.1, q[0], l[0], torque[0]));
    EXPECT(NUTATE_OK, nutate_last_message(bodies, text, sizeof text));
    CHECK(strstr(text, "4 of 40 bodies kept their state, the first is 0 (expected"));
    EXPECT(NUTATE_OK, nutate_bodies_failed(bodies, 3, failed, &n_failed));
    CHECK(n_failed == 4 && failed[0] == 0 && failed[1] == 17 && failed[2] == 20 && failed[3] == 99);
    for (i = 0; i < N; ++i)
        CHECK((memcmp(q[i], q1[i], sizeof q[i]) == 0) == (i == 0 || i == 17 || i == 20 || i == 39));
    EXPECT(NUTATE_OK, nutate_bodies_drift(bodies, 10, NULL, 0.1, q[1], l[1]));
    EXPECT(NUTATE_OK, nutate_bodies_failed(bodies, 3, failed, &n_failed));
    CHECK(n_failed == 0);
    EXPECT(NUTATE_OK, nutate_bodies_destroy(&bodies));
    return 0;
}

/* Wrong arguments are reported and change nothing. */
int test_c_bodies_refused(void)
{
    double q[4] = {1.0, 0.0, 0.0, 0.0}, l[3] = {0.1, 0.2, 0.3}, torque[3] = {0.0, 0.0, 0.0};
    const double gravity[3] = {0.0, 0.0, -9.8}, center[3] = {0.0, 0.0, 0.1};
    nutate_bodies *bodies = NULL;
    nutate_system *box = NULL, *top = NULL;
    size_t failed;
    char text[256];
    EXPECT(NUTATE_OK, make_box(&box));
    EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 12.0, center, 0, &top, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_add_gravity(top, gravity));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_create((const nutate_system *const *)&box, 1, 0, NULL, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_create(NULL, 1, 0, &bodies, text, sizeof text));
    CHECK(strstr(text, "classes"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_create((const nutate_system *const *)&box, 0, 0, &bodies, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_create((const nutate_system *const *)&box, 1, 3, &bodies, text, sizeof text));
    CHECK(strstr(text, "frame") && bodies == NULL);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_create((const nutate_system *const *)&top, 1, 0, &bodies, text, sizeof text));
    CHECK(strstr(text, "effects"));
    EXPECT(NUTATE_OK, nutate_system_destroy(&top));
    EXPECT(NUTATE_BAD_HANDLE, nutate_bodies_create((const nutate_system *const *)&top, 1, 0, &bodies, NULL, 0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_bodies_step(NULL, 1, NULL, 0.1, q, l, torque));
    EXPECT(NUTATE_BAD_HANDLE, nutate_bodies_step((nutate_bodies *)box, 1, NULL, 0.1, q, l, torque));
    EXPECT(NUTATE_BAD_HANDLE, nutate_bodies_set_threads(NULL, 1));
    EXPECT(NUTATE_BAD_HANDLE, nutate_bodies_failed(NULL, 0, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_destroy(NULL));
    EXPECT(NUTATE_OK, nutate_bodies_create((const nutate_system *const *)&box, 1, 0, &bodies, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_step(bodies, 1, NULL, 0.0, q, l, torque));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_step(bodies, 1, NULL, NAN, q, l, torque));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_step(bodies, 1, NULL, 0.1, NULL, l, torque));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_kick(bodies, 1, NULL, 0.1, q, NULL, torque));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_step(bodies, 1, NULL, 0.1, q, l, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_drift(bodies, (size_t)1 << 40, NULL, 0.1, q, l));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_set_threads(bodies, -1));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_failed(bodies, 1, NULL, &failed));
    CHECK(q[0] == 1.0 && l[2] == 0.3);
    EXPECT(NUTATE_OK, nutate_bodies_step(bodies, 0, NULL, 0.1, NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_bodies_step(bodies, 0, NULL, 0.0, NULL, NULL, NULL));
    EXPECT(NUTATE_OK, nutate_bodies_destroy(&bodies));
    EXPECT(NUTATE_OK, nutate_bodies_destroy(&bodies));
    EXPECT(NUTATE_OK, nutate_system_destroy(&box));
    return 0;
}
