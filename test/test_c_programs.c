/* What C programs do with the C interface: callbacks, threads, handles made and freed many times. Each function returns 0,
 * or the line of the first check that fails. */
#include "../include/nutate.h"
#include <math.h>
#include <pthread.h>
#include <string.h>

int test_c_own_gravity(int with_hessian, double *worst);
int test_c_own_damping(double *worst);
int test_c_account_of_a_new_state(void);
int test_c_uncertified_steps(void);
int test_c_exact_motion(void);
int test_c_threads(void);
int test_c_many_handles(int times);

#define EXPECT(status, call) \
    do { \
        if ((call) != (status)) return __LINE__; \
    } while (0)
#define CHECK(condition) \
    do { \
        if (!(condition)) return __LINE__; \
    } while (0)

static const double tilted[4] = {0.9, 0.3, 0.3, 0.1}, omega[3] = {0.5, -0.4, 6.0}, moments[3] = {3.0, 4.0, 2.0},
                    center[3] = {0.1, 0.0, 0.5}, down[3] = {0.0, 0.0, -9.81};

/* V = -m c.gamma + k (c.gamma)^4: user points to m and k. */
static int own_potential(const double gamma[3], void *user, double *energy, double gradient[3])
{
    const double *mk = user;
    double z = center[0] * gamma[0] + center[1] * gamma[1] + center[2] * gamma[2];
    int i;
    *energy = -mk[0] * z + mk[1] * z * z * z * z;
    for (i = 0; i < 3; ++i) gradient[i] = (-mk[0] + 4 * mk[1] * z * z * z) * center[i];
    return 0;
}

static int own_hessian(const double gamma[3], void *user, double hessian[3][3])
{
    const double *mk = user;
    double z = center[0] * gamma[0] + center[1] * gamma[1] + center[2] * gamma[2];
    int i, j;
    for (i = 0; i < 3; ++i)
        for (j = 0; j < 3; ++j) hessian[i][j] = 12 * mk[1] * z * z * center[i] * center[j];
    return 0;
}

static int own_damping(double t, const double q[4], const double rate[3], void *user, double tau[3])
{
    const double *c = user;
    int i;
    (void)t;
    (void)q;
    for (i = 0; i < 3; ++i) tau[i] = -c[i] * rate[i];
    return 0;
}

static int start(const nutate_system *system, const char *solver, nutate_stepper **stepper)
{
    double q[4];
    EXPECT(NUTATE_OK, nutate_quat_normalized(tilted, q));
    EXPECT(NUTATE_OK, nutate_stepper_create(system, stepper, NULL, 0));
    EXPECT(NUTATE_OK, nutate_stepper_set(*stepper, "formulation", solver));
    EXPECT(NUTATE_OK, nutate_stepper_set_state(*stepper, 0.0, q, omega));
    return 0;
}

/* Steps two steppers together; the largest difference of their attitudes. The first keeps its energy balance. */
static int compare(nutate_stepper *a, nutate_stepper *b, double *worst)
{
    double qa[4], qb[4], energy[5], angle;
    int i;
    *worst = 0.0;
    for (i = 0; i < 500; ++i) {
        EXPECT(NUTATE_OK, nutate_stepper_step(a, 0.01));
        EXPECT(NUTATE_OK, nutate_stepper_step(b, 0.01));
        EXPECT(NUTATE_OK, nutate_stepper_quaternion(a, qa));
        EXPECT(NUTATE_OK, nutate_stepper_quaternion(b, qb));
        EXPECT(NUTATE_OK, nutate_attitude_distance(qa, qb, &angle));
        if (angle > *worst) *worst = angle;
    }
    EXPECT(NUTATE_OK, nutate_stepper_energy(a, energy));
    CHECK(fabs(energy[4]) < 1e-13 * fabs(energy[0]));
    return 0;
}

/* Gravity as a callback against gravity of the library; then a quartic in it, which has curvature, by both solvers. */
int test_c_own_gravity(int with_hessian, double *worst)
{
    double mk[2] = {2.5, 0.0}, l0[3], l[3], axis[3];
    nutate_system *own = NULL, *built_in = NULL;
    nutate_stepper *a = NULL, *b = NULL;
    int line, components;
    EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 2.5, center, 0, &own, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 2.5, center, 0, &built_in, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_add_potential(own, down, own_potential, with_hessian ? own_hessian : NULL, mk));
    EXPECT(NUTATE_OK, nutate_system_add_gravity(built_in, down));
    EXPECT(0, start(own, "reduced", &a));
    EXPECT(0, start(built_in, "reduced", &b));
    line = compare(a, b, worst);
    if (line) return line;
    CHECK(*worst < 1e-12);
    nutate_stepper_destroy(&a);
    nutate_stepper_destroy(&b);
    mk[1] = 1e-2;
    EXPECT(0, start(own, "reduced", &a));
    EXPECT(0, start(own, "full", &b));
    EXPECT(NUTATE_OK, nutate_stepper_conserved(a, &components, axis));
    CHECK(components == 1 && axis[2] == -1.0);
    EXPECT(NUTATE_OK, nutate_stepper_angular_momentum_space(a, l0));
    line = compare(a, b, worst);
    if (line) return line;
    CHECK(*worst < 1e-12);
    EXPECT(NUTATE_OK, nutate_stepper_angular_momentum_space(a, l));
    CHECK(fabs(l[2] - l0[2]) < 1e-13 && fabs(l[0] - l0[0]) > 0.1);
    nutate_stepper_destroy(&a);
    nutate_stepper_destroy(&b);
    nutate_system_destroy(&own);
    nutate_system_destroy(&built_in);
    return 0;
}

/* Work and energy residual count from the state that was set, whatever was run before: by nominal steps, to a time, by
 * adaptive steps, one by one. What is run afterwards has the bits of a stepper that was never used. */
static int check_new_state(const nutate_system *system, int way, int canonical)
{
    double q[4], p[4], ea[5], eb[5];
    nutate_stepper *used = NULL, *fresh = NULL;
    EXPECT(0, start(system, "reduced", &used));
    EXPECT(0, start(system, "reduced", &fresh));
    EXPECT(NUTATE_OK, nutate_stepper_conjugate_momentum(fresh, p));
    EXPECT(NUTATE_OK, nutate_stepper_quaternion(fresh, q));
    EXPECT(NUTATE_OK, nutate_stepper_set(used, way == 2 ? "local_tolerance" : "time_step", "0.01"));
    if (way == 0) EXPECT(NUTATE_OK, nutate_stepper_run(used, 50, 1, NULL, 0, NULL));
    if (way == 1) EXPECT(NUTATE_OK, nutate_stepper_run_to(used, 0.505, 1, 0.0, NULL, 0, NULL));
    if (way == 2) EXPECT(NUTATE_OK, nutate_stepper_run_to(used, 0.505, 1, 0.0, NULL, 0, NULL));
    if (way == 3) EXPECT(NUTATE_OK, nutate_stepper_steps(used, 0.01, 50, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_energy(used, ea));
    CHECK(ea[3] < -1.0 && fabs(ea[4]) < 1e-12 * fabs(ea[0]));
    if (canonical) EXPECT(NUTATE_OK, nutate_stepper_set_canonical(used, 0.0, q, p));
    else EXPECT(NUTATE_OK, nutate_stepper_set_state(used, 0.0, q, omega));
    EXPECT(NUTATE_OK, nutate_stepper_energy(used, ea));
    CHECK(ea[3] == 0.0 && ea[4] == 0.0);
    EXPECT(NUTATE_OK, nutate_stepper_set(used, "time_step", "0.01"));
    EXPECT(NUTATE_OK, nutate_stepper_set(fresh, "time_step", "0.01"));
    EXPECT(NUTATE_OK, nutate_stepper_run(used, 50, 1, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_run(fresh, 50, 1, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_energy(used, ea));
    EXPECT(NUTATE_OK, nutate_stepper_energy(fresh, eb));
    CHECK(memcmp(ea, eb, sizeof ea) == 0);
    nutate_stepper_destroy(&used);
    nutate_stepper_destroy(&fresh);
    return 0;
}

int test_c_account_of_a_new_state(void)
{
    double c[3] = {0.3, 0.1, 0.2};
    nutate_system *system = NULL;
    int way, canonical;
    EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 2.5, center, 0, &system, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_add_gravity(system, down));
    EXPECT(NUTATE_OK, nutate_system_add_damping(system, c));
    for (way = 0; way < 4; ++way) {
        for (canonical = 0; canonical < 2; ++canonical) {
            int line = check_new_state(system, way, canonical);
            if (line) return line;
        }
    }
    nutate_system_destroy(&system);
    return 0;
}

/* Damping as a callback against damping of the library. */
int test_c_own_damping(double *worst)
{
    double c[3] = {0.3, 0.1, 0.2}, ea[5], eb[5];
    nutate_system *own = NULL, *built_in = NULL;
    nutate_stepper *a = NULL, *b = NULL;
    int line;
    EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 2.5, center, 0, &own, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 2.5, center, 0, &built_in, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_add_user_torque(own, own_damping, c));
    EXPECT(NUTATE_OK, nutate_system_add_damping(built_in, c));
    EXPECT(0, start(own, "full", &a));
    EXPECT(0, start(built_in, "full", &b));
    line = compare(a, b, worst);
    if (line) return line;
    EXPECT(NUTATE_OK, nutate_stepper_energy(a, ea));
    EXPECT(NUTATE_OK, nutate_stepper_energy(b, eb));
    CHECK(ea[3] < -1.0 && fabs(ea[3] - eb[3]) < 1e-12);
    nutate_stepper_destroy(&a);
    nutate_stepper_destroy(&b);
    nutate_system_destroy(&own);
    nutate_system_destroy(&built_in);
    return 0;
}

/* The exact motion against steps of order 8, forward and back; a tensor with axes of its own. */
int test_c_exact_motion(void)
{
    static const double tensor[6] = {4.0, 5.0, 6.0, 0.5, -0.25, 0.75}, t[2] = {1.5, -0.5};
    double q0[4], q[2][4], rate[2][3], stepped[4], stepped_rate[3], angle;
    nutate_system *system = NULL;
    nutate_stepper *stepper = NULL;
    int i, k;
    EXPECT(NUTATE_OK, nutate_system_create_tensor(tensor, 0.0, NULL, 0, &system, NULL, 0));
    EXPECT(0, start(system, "reduced", &stepper));
    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "order", "8"));
    EXPECT(NUTATE_OK, nutate_quat_normalized(tilted, q0));
    EXPECT(NUTATE_OK, nutate_exact_free_body(system, q0, omega, 2, t, &q[0][0], &rate[0][0]));
    for (i = 0; i < 2; ++i) {
        EXPECT(NUTATE_OK, nutate_stepper_set_state(stepper, 0.0, q0, omega));
        EXPECT(NUTATE_OK, nutate_stepper_steps(stepper, t[i] / 100, 100, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_quaternion(stepper, stepped));
        EXPECT(NUTATE_OK, nutate_stepper_angular_velocity(stepper, stepped_rate));
        EXPECT(NUTATE_OK, nutate_attitude_distance(stepped, q[i], &angle));
        CHECK(angle < 1e-12);
        for (k = 0; k < 3; ++k) CHECK(fabs(stepped_rate[k] - rate[i][k]) < 1e-11);
    }
    nutate_stepper_destroy(&stepper);
    nutate_system_destroy(&system);
    return 0;
}

enum { THREADS = 8, ROUNDS = 5, STEPS = 200 };

/* What one thread does, with a system that all share and a scene that all share. */
struct task {
    const nutate_system *system;
    const nutate_scene *scene;
    int number, failed;
    double q[4], rows[8];
};

static int work(struct task *task)
{
    double shifted[3];
    int i;
    size_t n;
    memcpy(shifted, omega, sizeof shifted);
    shifted[0] += 0.1 * task->number;
    for (i = 0; i < ROUNDS; ++i) {
        nutate_stepper *stepper = NULL;
        nutate_history *history = NULL;
        const double one[4] = {1.0, 0.0, 0.0, 0.0};
        EXPECT(NUTATE_OK, nutate_stepper_create(task->system, &stepper, NULL, 0));
        EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "formulation", task->number % 2 ? "reduced" : "full"));
        EXPECT(NUTATE_OK, nutate_stepper_set_time_step(stepper, 0.01));
        EXPECT(NUTATE_OK, nutate_stepper_set_state(stepper, 0.0, one, shifted));
        EXPECT(NUTATE_OK, nutate_stepper_run(stepper, STEPS, 1, NULL, 0, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_quaternion(stepper, task->q));
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
        EXPECT(NUTATE_OK, nutate_scene_run(task->scene, &history, NULL, 0));
        EXPECT(NUTATE_OK, nutate_history_size(history, &n, NULL));
        CHECK(n == 8);
        EXPECT(NUTATE_OK, nutate_history_column(history, "omega1", task->rows, 8));
        EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    }
    return 0;
}

static void *work_in_thread(void *argument)
{
    struct task *task = argument;
    task->failed = work(task);
    return NULL;
}

/* Steps under a user-defined potential, of which nothing is known, are counted as not certified: single ones, several,
 * nominal ones, those chosen by their error; not those before a new state, nor those of a free body. */
int test_c_uncertified_steps(void)
{
    static const char text[] =
        "&body inertia = 3, 4, 2 / &initial angular_velocity = 0.5, -0.4, 6 / &integrator time_step = 0.01, end_time = 0.2 /";
    double mk[2] = {2.5, 1e-2}, t, q[4], w[3];
    nutate_system *own = NULL, *free_body = NULL;
    nutate_stepper *stepper = NULL, *other = NULL;
    nutate_scene *scene = NULL;
    nutate_history *history = NULL;
    int64_t steps = -1, before;
    EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 2.5, center, 0, &own, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 2.5, center, 0, &free_body, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_add_potential(own, down, own_potential, own_hessian, mk));
    EXPECT(0, start(own, "reduced", &stepper));
    EXPECT(NUTATE_OK, nutate_stepper_uncertified(stepper, &steps));
    EXPECT(0, steps);
    EXPECT(NUTATE_OK, nutate_stepper_step(stepper, 0.01));
    EXPECT(NUTATE_OK, nutate_stepper_steps(stepper, 0.01, 4, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_set_time_step(stepper, 0.01));
    EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 7, 1, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_step(stepper, 0.02));
    EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 2, 1, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_uncertified(stepper, &before));
    EXPECT(15, before);
    EXPECT(NUTATE_OK, nutate_stepper_time(stepper, &t));
    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "local_tolerance", "1e-4"));
    EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, t + 0.5, 1, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_uncertified(stepper, &steps));
    CHECK(steps > before);
    EXPECT(NUTATE_OK, nutate_stepper_quaternion(stepper, q));
    EXPECT(NUTATE_OK, nutate_stepper_angular_velocity(stepper, w));
    EXPECT(NUTATE_OK, nutate_stepper_set_state(stepper, 0.0, q, w));
    EXPECT(NUTATE_OK, nutate_stepper_uncertified(stepper, &steps));
    EXPECT(0, steps);
    EXPECT(0, start(free_body, "full", &other));
    EXPECT(NUTATE_OK, nutate_stepper_steps(other, 0.01, 9, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_uncertified(other, &steps));
    EXPECT(0, steps);
    EXPECT(NUTATE_OK, nutate_scene_parse(text, NULL, NULL, 0, &scene, NULL, 0));
    EXPECT(NUTATE_OK, nutate_scene_run(scene, &history, NULL, 0));
    EXPECT(NUTATE_OK, nutate_history_uncertified(history, &steps));
    EXPECT(0, steps);
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_OK, nutate_scene_add_potential(scene, down, own_potential, own_hessian, mk));
    EXPECT(NUTATE_OK, nutate_scene_run(scene, &history, NULL, 0));
    EXPECT(NUTATE_OK, nutate_history_uncertified(history, &steps));
    EXPECT(20, steps);
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&other));
    EXPECT(NUTATE_OK, nutate_system_destroy(&own));
    EXPECT(NUTATE_OK, nutate_system_destroy(&free_body));
    return 0;
}

/* Eight threads with handles of their own give the same bits as one after the other. */
int test_c_threads(void)
{
    static const char text[] =
        "&body inertia = 3, 4, 2, mass = 2, center_of_mass = 0, 0, 0.5 / &gravity / &damping coefficient = 0, 0, 0.1 /\n"
        "&initial angular_velocity = 0.5, -0.4, 6 / &integrator time_step = 0.01, end_time = 0.7 /\n"
        "&output every = 10, columns = 'angular_velocity', 'euler' /";
    struct task alone[THREADS], together[THREADS];
    pthread_t threads[THREADS];
    nutate_system *system = NULL;
    nutate_scene *scene = NULL;
    double mk[2] = {2.5, 1e-2};
    int i;
    EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 2.5, center, 0, &system, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_add_potential(system, down, own_potential, NULL, mk));
    EXPECT(NUTATE_OK, nutate_scene_parse(text, NULL, NULL, 0, &scene, NULL, 0));
    for (i = 0; i < THREADS; ++i) {
        memset(&alone[i], 0, sizeof alone[i]);
        alone[i].system = system;
        alone[i].scene = scene;
        alone[i].number = i;
        together[i] = alone[i];
        EXPECT(0, work(&alone[i]));
    }
    for (i = 0; i < THREADS; ++i) EXPECT(0, pthread_create(&threads[i], NULL, work_in_thread, &together[i]));
    for (i = 0; i < THREADS; ++i) EXPECT(0, pthread_join(threads[i], NULL));
    for (i = 0; i < THREADS; ++i) {
        EXPECT(0, together[i].failed);
        CHECK(memcmp(together[i].q, alone[i].q, sizeof alone[i].q) == 0);
        CHECK(memcmp(together[i].rows, alone[i].rows, sizeof alone[i].rows) == 0);
    }
    CHECK(memcmp(alone[0].q, alone[2].q, sizeof alone[0].q) != 0);
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    return 0;
}

/* Handles of every kind, made, used and freed, also where making one fails: for valgrind. */
int test_c_many_handles(int times)
{
    static const char *const overrides[2] = {"integrator.end_time=0.2", "integrator.method=exact"};
    static const char *const methods[3] = {"nielsen_krenk", "dop853", "rk4"};
    static const double one[4] = {1.0, 0.0, 0.0, 0.0};
    double mk[2] = {2.5, 1e-2}, rows[300], t[2] = {0.5, 1.0}, q[8];
    char text[300];
    int i;
    for (i = 0; i < times; ++i) {
        nutate_system *system = NULL, *other = NULL;
        nutate_scene *scene = NULL;
        nutate_stepper *stepper = NULL;
        nutate_history *history = NULL;
        EXPECT(NUTATE_BAD_BODY, nutate_system_create_moments(omega, 2.5, center, 0, &system, text, sizeof text));
        EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 2.5, center, 0, &system, text, sizeof text));
        EXPECT(NUTATE_OK, nutate_exact_free_body(system, one, omega, 2, t, q, NULL));
        EXPECT(NUTATE_OK, nutate_system_add_potential(system, down, own_potential, own_hessian, mk));
        EXPECT(NUTATE_OK, nutate_system_add_spring(system, omega, down, 1.0, 0.5));
        EXPECT(NUTATE_OK, nutate_system_add_damping(system, moments));
        EXPECT(NUTATE_OK, nutate_stepper_create(system, &stepper, text, sizeof text));
        EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "method", methods[i % 3]));
        if (i % 3 == 0) EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "order", "4"));
        EXPECT(NUTATE_OK, nutate_stepper_set_time_step(stepper, 0.001));
        EXPECT(NUTATE_OK, nutate_stepper_set_state(stepper, 0.0, one, omega));
        EXPECT(NUTATE_OK, nutate_stepper_set_columns(stepper, "euler,energy"));
        EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 20, 1, rows, 30, NULL));
        EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set(stepper, "method", "none"));
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
        EXPECT(NUTATE_OK, nutate_system_destroy(&system));
        EXPECT(NUTATE_BAD_SCENE, nutate_scene_read("scenes/all_effects.nml", overrides, 2, &scene, text, sizeof text));
        EXPECT(NUTATE_OK, nutate_scene_read("scenes/all_effects.nml", overrides, 1, &scene, text, sizeof text));
        EXPECT(NUTATE_OK, nutate_scene_run(scene, &history, text, sizeof text));
        EXPECT(NUTATE_OK, nutate_scene_system(scene, &other, text, sizeof text));
        EXPECT(NUTATE_OK, nutate_stepper_create_scene(scene, &stepper, text, sizeof text));
        EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
        EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "accuracy", "1e-6"));
        EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, 0.2, 1, 0.0, NULL, 0, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_accuracy(stepper, rows));
        EXPECT(1, rows[0] > 0.0 && rows[0] <= 1e-6 && rows[1] <= rows[0]);
        EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "accuracy", "1e-18"));
        EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, 0.4, 1, 0.0, NULL, 0, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_accuracy(stepper, rows));
        EXPECT(1, rows[1] > 1e-18 && rows[0] >= rows[1]);
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
        EXPECT(NUTATE_OK, nutate_system_destroy(&other));
        EXPECT(NUTATE_OK, nutate_history_destroy(&history));
        EXPECT(NUTATE_BAD_SCENE, nutate_scene_parse("&body /", NULL, NULL, 0, &scene, text, sizeof text));
        EXPECT(NUTATE_BAD_SCENE, nutate_system_parse("&body /", &other, text, sizeof text));
    }
    return 0;
}
