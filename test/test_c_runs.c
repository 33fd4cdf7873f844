/* Runs into histories, runs that are asked to stop, and copies of steppers. Each function returns 0, or the line of the
 * first check that fails. */
#include "test_c_support.h"

int test_c_run_histories(void);
int test_c_polls(void);
int test_c_copies(void);
int test_c_saved_steppers(void);
int test_c_chaos(void);
int test_c_sensitivities(void);
int test_c_misused_runs(void);

/* Ends a run when it has been asked so often. */
static int stop_later(void *user)
{
    int *asked = user;
    return --*asked <= 0;
}

static int same_state(nutate_stepper *a, nutate_stepper *b)
{
    double p[4], q[4], pb[4], qb[4], t, tb, e[5], eb[5];
    nutate_stepper_time(a, &t), nutate_stepper_time(b, &tb);
    nutate_stepper_quaternion(a, q), nutate_stepper_quaternion(b, qb);
    nutate_stepper_conjugate_momentum(a, p), nutate_stepper_conjugate_momentum(b, pb);
    nutate_stepper_energy(a, e), nutate_stepper_energy(b, eb);
    return !memcmp(&t, &tb, sizeof t) && !memcmp(q, qb, sizeof q) && !memcmp(p, pb, sizeof p) && !memcmp(e, eb, sizeof e);
}

/* The rows of nutate_stepper_run_to, with nominal steps, an accuracy and a tolerance, in a history and in an array with and
 * without room for them; rows at user-defined times. */
int test_c_run_histories(void)
{
    static const char *const ways[3][2] = {
        {"time_step", "0.01"}, {"accuracy", "1e-6"}, {"local_tolerance", "1e-6"}};
    static const double times[4] = {0.0, 0.123, 0.5, 1.0};
    double rows[2000], kept[2000], t[4], error[2], asked[2], errors[3], accuracy;
    int64_t counts[5];
    nutate_row_run run = {1.0, 1, 0.0, NULL, 0, kept, 0, {0}, {0.0}, NULL};
    nutate_stepper *a = NULL, *b = NULL;
    nutate_history *history = NULL;
    size_t n, m, width;
    char method[128];
    int way;
    for (way = 0; way < 3; ++way) {
        EXPECT(NUTATE_OK, make_stepper(&a));
        EXPECT(NUTATE_OK, make_stepper(&b));
        EXPECT(NUTATE_OK, nutate_stepper_set_columns(a, "quaternion,energy"));
        EXPECT(NUTATE_OK, nutate_stepper_set_columns(b, "quaternion,energy"));
        EXPECT(NUTATE_OK, nutate_stepper_set(a, ways[way][0], ways[way][1]));
        EXPECT(NUTATE_OK, nutate_stepper_set(b, ways[way][0], ways[way][1]));
        EXPECT(NUTATE_OK, nutate_stepper_run_to(a, 1.0, 1, 0.0, rows, 200, &n));
        EXPECT(NUTATE_OK, nutate_stepper_run_history(b, 1.0, 1, 0.0, NULL, 0, &history));
        EXPECT(NUTATE_OK, nutate_history_size(history, &m, &width));
        CHECK(m == n && n > 10 && width == 10);
        EXPECT(NUTATE_OK, nutate_history_values(history, kept, 2000));
        CHECK(!memcmp(rows, kept, n * width * sizeof(double)));
        CHECK(same_state(a, b));
        EXPECT(NUTATE_OK, nutate_history_accuracy(history, error, &accuracy));
        EXPECT(NUTATE_OK, nutate_stepper_accuracy(b, asked));
        CHECK(accuracy == (way == 1 ? 1e-6 : 0.0) && !memcmp(error, asked, sizeof error));
        EXPECT(NUTATE_OK, nutate_history_accuracy(history, NULL, NULL));
        EXPECT(NUTATE_OK, nutate_history_summary(history, counts, errors));
        CHECK((size_t)counts[0] == m && (size_t)counts[1] == width && counts[2] == 0 && counts[3] == 0 && counts[4] == 0);
        CHECK(errors[0] == error[0] && errors[1] == error[1] && errors[2] == accuracy);
        EXPECT(NUTATE_OK, nutate_history_destroy(&history));
        for (run.capacity = n - 1; run.capacity <= n; ++run.capacity) {
            EXPECT(NUTATE_OK, nutate_stepper_set_state(b, 0.0, one, vector));
            memset(kept, 0, sizeof kept);
            EXPECT(NUTATE_OK, nutate_stepper_run_rows(b, &run));
            CHECK(!memcmp(counts, run.counts, sizeof counts) && !memcmp(errors, run.errors, sizeof errors));
            CHECK((run.history == NULL) == (run.capacity == n) && same_state(a, b));
            if (run.history) EXPECT(NUTATE_OK, nutate_history_values(run.history, kept, 2000));
            CHECK(!memcmp(rows, kept, n * width * sizeof(double)));
            EXPECT(NUTATE_OK, nutate_history_destroy(&run.history));
        }
        EXPECT(NUTATE_OK, nutate_stepper_set_state(b, 0.0, one, vector));
        EXPECT(NUTATE_OK, nutate_stepper_run_history(b, 1.0, 1, 0.0, times, 4, &history));
        EXPECT(NUTATE_OK, nutate_history_column(history, "t", t, 4));
        CHECK(!memcmp(t, times, sizeof t));
        CHECK(same_state(a, b));
        EXPECT(NUTATE_OK, nutate_history_destroy(&history));
        EXPECT(NUTATE_OK, nutate_stepper_get(b, "method", method, sizeof method));
        CHECK(!strcmp(method, way == 0 ? "nielsen_krenk" : "exact"));
        EXPECT(NUTATE_OK, nutate_stepper_get(b, "choice", method, sizeof method));
        CHECK(!strcmp(method, way == 0 ? "" : "the motion of a free body has a closed solution"));
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&a));
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&b));
    }
    return 0;
}

/* Every kind of run ends between two steps, with its rows, and can go on. */
int test_c_polls(void)
{
    nutate_stepper *stepper = NULL;
    nutate_scene *scene = NULL;
    nutate_history *history = NULL;
    double t;
    int64_t done;
    size_t n;
    int asked = 1;
    EXPECT(NUTATE_OK, make_stepper(&stepper));
    EXPECT(NUTATE_OK, nutate_stepper_set_poll(stepper, stop_later, &asked));
    EXPECT(NUTATE_STOPPED, nutate_stepper_steps(stepper, 0.01, 1000000000, &done));
    CHECK(done == 64);
    EXPECT(NUTATE_OK, nutate_stepper_set_time_step(stepper, 0.01));
    asked = 2;
    EXPECT(NUTATE_STOPPED, nutate_stepper_run_history(stepper, 1e7, 1, 0.0, NULL, 0, &history));
    EXPECT(NUTATE_OK, nutate_history_size(history, &n, NULL));
    CHECK(n > 64);
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "method", "taylor"));
    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "accuracy", "1e-8"));
    asked = 1;
    EXPECT(NUTATE_OK, nutate_stepper_time(stepper, &t));
    EXPECT(NUTATE_STOPPED, nutate_stepper_run_to(stepper, t + 1e6, 1000, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_set_poll(stepper, NULL, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, t + 1.0, 1, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_scene_parse(scene_text, NULL, (const char *[]){"integrator.end_time=1e6"}, 1, &scene, NULL, 0));
    asked = 1;
    EXPECT(NUTATE_OK, nutate_scene_set_poll(scene, stop_later, &asked));
    EXPECT(NUTATE_STOPPED, nutate_scene_run(scene, &history, NULL, 0));
    EXPECT(NUTATE_OK, nutate_history_size(history, &n, NULL));
    CHECK(n == 1025);
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    return 0;
}

/* A stepper of a top with a torque of its own, between two batches of nominal steps. */
static int make_top(const char *method, struct answer *answer, nutate_stepper **stepper)
{
    static const double start[4] = {0.96, 0.28, 0.0, 0.0}, spin[3] = {0.0, 0.2, 9.0};
    nutate_system *system = NULL;
    EXPECT(NUTATE_OK, nutate_system_parse("&body inertia = 1, 1, 0.5, mass = 1, center_of_mass = 0, 0, 1 / &gravity /",
                                          &system, NULL, 0));
    if (answer) EXPECT(NUTATE_OK, nutate_system_add_user_torque(system, answer_torque, answer));
    EXPECT(NUTATE_OK, nutate_stepper_create(system, stepper, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    EXPECT(NUTATE_OK, nutate_stepper_set_columns(*stepper, "euler,energy"));
    EXPECT(NUTATE_OK, nutate_stepper_set(*stepper, "method", method));
    EXPECT(NUTATE_OK, nutate_stepper_set_time_step(*stepper, 0.02));
    EXPECT(NUTATE_OK, nutate_stepper_set_state(*stepper, 0.0, start, spin));
    return 0;
}

/* A step taken again from its start leads to the same rows, and its stepper does not notice. */
static int steps_taken_again(void)
{
    static const char *const methods[] = {"nielsen_krenk", "rk4", "dop853", "rk8", "taylor"};
    static const double times[2] = {0.41, 0.42};
    struct answer answer = {1e9, 0, 0, 0, 0.0};
    nutate_stepper *stepper = NULL, *copy = NULL;
    nutate_system *system = NULL;
    double rows[16], row[2][9], q[4], p[4], inside[4], omega[3];
    size_t i, j;
    for (i = 0; i < 5; ++i) {
        CHECK(!make_top(methods[i], i == 4 ? NULL : &answer, &stepper));
        EXPECT(NUTATE_OK, nutate_stepper_set_columns(stepper, "quaternion,angular_velocity"));
        EXPECT(NUTATE_OK, nutate_stepper_keep_steps(stepper));
        EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 20, 1, NULL, 0, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_quaternion(stepper, q));
        EXPECT(NUTATE_OK, nutate_stepper_conjugate_momentum(stepper, p));
        EXPECT(NUTATE_OK, nutate_stepper_step(stepper, 0.02));
        EXPECT(NUTATE_OK, nutate_stepper_copy(stepper, &copy, NULL, 0));
        EXPECT(NUTATE_OK, nutate_stepper_dense_output(stepper, 0.4, q, p, NULL, 0.02, 2, times, rows));
        EXPECT(NUTATE_OK, nutate_stepper_row(stepper, row[0], 9));
        EXPECT(NUTATE_OK, nutate_stepper_state_at(stepper, 0.41, inside, omega));
        for (j = 0; j < 4; ++j) CHECK(fabs(rows[1 + j] - inside[j]) < 1e-13);
        for (j = 0; j < 8; ++j) CHECK(fabs(rows[8 + j] - row[0][j]) < 1e-12);
        EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_dense_output(stepper, 0.4, q, p, NULL, -0.02, 2, times, rows));
        EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_dense_output(stepper, 0.4, q, p, NULL, 0.0, 2, times, rows));
        /* Steps that do not change the time would never reach the rows. */
        EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_dense_output(stepper, 0.4, q, p, NULL, 1e-20, 2, times, rows));
        EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 30, 30, row[0], 1, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_run(copy, 30, 30, row[1], 1, NULL));
        for (j = 0; j < 8; ++j) CHECK(row[0][j] == row[1][j]);
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&copy));
    }
    EXPECT(NUTATE_OK, nutate_system_parse("&body inertia = 1, 1, 0.5 / &wheel axis = 0, 0, 1, inertia = 0.1 /", &system, NULL, 0));
    EXPECT(NUTATE_OK, nutate_stepper_create(system, &stepper, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_dense_output(stepper, 0.4, q, p, NULL, 0.02, 0, times, rows));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    return 0;
}

int test_c_copies(void)
{
    static const char *const methods[] = {"nielsen_krenk", "rk4", "dop853", "rk8", "taylor"};
    struct answer answer = {1e9, 0, 0, 0, 0.0};
    nutate_stepper *stepper = NULL, *copy = NULL;
    double row[2][9], q[2][4], omega[3];
    size_t i;
    CHECK(!steps_taken_again());
    for (i = 0; i < 5; ++i) {
        CHECK(!make_top(methods[i], i == 4 ? NULL : &answer, &stepper));
        EXPECT(NUTATE_OK, nutate_stepper_keep_steps(stepper));
        EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 20, 1, NULL, 0, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_step(stepper, 0.02));
        EXPECT(NUTATE_OK, nutate_stepper_copy(stepper, &copy, NULL, 0));
        EXPECT(NUTATE_OK, nutate_stepper_state_at(stepper, 0.41, q[0], omega));
        EXPECT(NUTATE_OK, nutate_stepper_state_at(copy, 0.41, q[1], omega));
        CHECK(!memcmp(q[0], q[1], sizeof q[0]));
        EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 30, 30, row[0], 1, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
        EXPECT(NUTATE_OK, nutate_stepper_run(copy, 30, 30, row[1], 1, NULL));
        CHECK(!memcmp(row[0], row[1], sizeof row[0]));
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&copy));
    }
    return 0;
}

/* What fails in a callback is reported to the copy that called it, and to no other. */
static int failures_of_copies(void)
{
    struct answer answer = {0.5, 0, 0, 7, 0.0};
    nutate_stepper *stepper = NULL, *copy = NULL;
    CHECK(!make_top("nielsen_krenk", &answer, &stepper));
    EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 5, 1, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_copy(stepper, &copy, NULL, 0));
    EXPECT(NUTATE_CALLBACK, nutate_stepper_run(copy, 100, 1, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 5, 1, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&copy));
    return 0;
}

/* Bytes with an error in them: if they are rejected, the stepper is as it was. */
static int damaged_bytes(nutate_stepper *stepper, char *bytes, size_t size)
{
    nutate_stepper *other = NULL;
    size_t i;
    EXPECT(NUTATE_OK, nutate_stepper_copy(stepper, &other, NULL, 0));
    for (i = 0; i < size; i += 3) {
        bytes[i] ^= 64;
        if (nutate_stepper_restore(other, bytes, size) == NUTATE_OK) {
            bytes[i] ^= 64;
            EXPECT(NUTATE_OK, nutate_stepper_restore(other, bytes, size));
            bytes[i] ^= 64;
            EXPECT(NUTATE_OK, nutate_stepper_destroy(&other));
            EXPECT(NUTATE_OK, nutate_stepper_copy(stepper, &other, NULL, 0));
        }
        bytes[i] ^= 64;
        CHECK(same_state(stepper, other));
        EXPECT(NUTATE_OK, nutate_stepper_step(stepper, 1e-3));
        EXPECT(NUTATE_OK, nutate_stepper_step(other, 1e-3));
        CHECK(same_state(stepper, other));
    }
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&other));
    return 0;
}

int test_c_saved_steppers(void)
{
    static const char *const methods[] = {"nielsen_krenk", "rk4", "dop853", "rk8", "taylor"};
    struct answer answer = {1e9, 0, 0, 0, 0.0};
    nutate_stepper *stepper = NULL, *other = NULL;
    double row[2][9];
    char *bytes;
    size_t i, size, again;
    CHECK(!failures_of_copies());
    for (i = 0; i < 5; ++i) {
        CHECK(!make_top(methods[i], i == 4 ? NULL : &answer, &stepper));
        EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 20, 1, NULL, 0, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_save(stepper, NULL, 0, &size));
        CHECK(size > 200 && (bytes = malloc(size)));
        EXPECT(NUTATE_TRUNCATED, nutate_stepper_save(stepper, bytes, size - 1, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_save(stepper, bytes, size, &again));
        CHECK(size == again);
        EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 30, 30, row[0], 1, NULL));
        CHECK(!damaged_bytes(stepper, bytes, size));
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
        CHECK(!make_top(methods[i], i == 4 ? NULL : &answer, &other));
        EXPECT(NUTATE_OK, nutate_stepper_restore(other, bytes, size));
        EXPECT(NUTATE_OK, nutate_stepper_run(other, 30, 30, row[1], 1, NULL));
        CHECK(!memcmp(row[0], row[1], sizeof row[0]));
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&other));
        /* Bytes of another stepper, or cut: the stepper is as it was. */
        CHECK(!make_top(methods[i], i == 4 ? NULL : &answer, &other));
        CHECK(!make_top(methods[i], i == 4 ? NULL : &answer, &stepper));
        EXPECT(NUTATE_OK, nutate_stepper_run(other, 3, 1, NULL, 0, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 3, 1, NULL, 0, NULL));
        for (again = 0; again < size; again += size / 17) EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_restore(other, bytes, again));
        CHECK(same_state(stepper, other));
        EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 5, 5, row[0], 1, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_run(other, 5, 5, row[1], 1, NULL));
        CHECK(!memcmp(row[0], row[1], sizeof row[0]));
        /* Bytes of other settings or columns. */
        EXPECT(NUTATE_OK, nutate_stepper_set(other, "time_step", "0.003"));
        EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_restore(other, bytes, size));
        EXPECT(NUTATE_OK, nutate_stepper_set(other, "time_step", "0.02"));
        EXPECT(NUTATE_OK, nutate_stepper_restore(other, bytes, size));
        EXPECT(NUTATE_OK, nutate_stepper_set(other, "method", i == 0 ? "rk4" : "nielsen_krenk"));
        EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_restore(other, bytes, size));
        EXPECT(NUTATE_OK, nutate_stepper_set(other, "method", methods[i]));
        EXPECT(NUTATE_OK, nutate_stepper_set_columns(other, "energy"));
        EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_restore(other, bytes, size));
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&other));
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
        free(bytes);
    }
    return 0;
}

/* The derivatives of a run by the numbers of a scene, beside the same run without them; and inside of a step. */
int test_c_sensitivities(void)
{
    static const char *const text = "&body inertia = 5, 20, 17 /\n&initial angular_velocity = 3, 1, 5 /\n"
                                    "&integrator time_step = 0.01, end_time = 1 /\n";
    static const char *const free_key = "free.key='initial.attitude','initial.angular_velocity'";
    static const double times[2] = {0.0, 0.123};
    nutate_scene *scene = NULL, *plain = NULL;
    nutate_stepper *a = NULL, *b = NULL;
    nutate_history *history = NULL;
    double rows[2 * 37], inside[45], q[4], p[4];
    size_t n, width;
    char name[64];
    EXPECT(NUTATE_OK, nutate_scene_parse(text, NULL, &free_key, 1, &scene, NULL, 0));
    EXPECT(NUTATE_OK, nutate_scene_parse(text, NULL, NULL, 0, &plain, NULL, 0));
    EXPECT(NUTATE_OK, nutate_stepper_create_scene(plain, &a, NULL, 0));
    EXPECT(NUTATE_OK, nutate_stepper_create_scene(plain, &b, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_columns(a, "sensitivities"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_differentiate(a, plain));
    EXPECT(NUTATE_OK, nutate_stepper_differentiate(a, scene));
    EXPECT(NUTATE_OK, nutate_stepper_set_columns(a, "sensitivities"));
    EXPECT(NUTATE_OK, nutate_stepper_width(a, &width));
    CHECK(width == 37);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_row(a, rows, 37));
    EXPECT(NUTATE_OK, nutate_stepper_run_history(a, 1.0, 1, 0.0, times, 2, &history));
    EXPECT(NUTATE_OK, nutate_history_size(history, &n, &width));
    CHECK(n == 2 && width == 37);
    EXPECT(NUTATE_OK, nutate_history_name(history, 28, name, sizeof name));
    CHECK(!strcmp(name, "d_omega1/d_initial.angular_velocity.2"));
    EXPECT(NUTATE_OK, nutate_history_values(history, rows, 2 * 37));
    /* Attitude and rates of the start, but for the rounding of differences. */
    for (n = 0; n < 36; ++n)
        CHECK(fabs(rows[1 + n] - (n % 7 == 0)) < 1e-11);
    CHECK(rows[37] == 0.123 && fabs(rows[37 + 19] - 0.123) < 0.05 && rows[37 + 23] != 0.0);
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_OK, nutate_stepper_run_to(b, 1.0, 1, 0.0, NULL, 0, NULL));
    CHECK(same_state(a, b));
    /* A run without length has those of its start. */
    EXPECT(NUTATE_OK, nutate_stepper_run_history(a, 1.0, 1, 0.0, NULL, 0, &history));
    EXPECT(NUTATE_OK, nutate_history_values(history, rows, 37));
    CHECK(rows[0] == 1.0 && fabs(rows[1] - 1.0) < 1e-11 && fabs(rows[36] - 1.0) < 1e-11);
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    /* Inside of a step, from those at its start. */
    EXPECT(NUTATE_OK, nutate_stepper_set_columns(a, "quaternion,conjugate_momentum,sensitivities"));
    EXPECT(NUTATE_OK, nutate_stepper_quaternion(a, q));
    EXPECT(NUTATE_OK, nutate_stepper_conjugate_momentum(a, p));
    EXPECT(NUTATE_OK, nutate_stepper_dense_output(a, 1.0, q, p, rows + 1, 0.01, 1, &(const double){1.007}, inside));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_dense_output(a, 1.0, q, p, NULL, 0.01, 1, &(const double){1.007}, inside));
    EXPECT(NUTATE_OK, nutate_stepper_run_history(a, 2.0, 1, 0.0, &(const double){1.007}, 1, &history));
    EXPECT(NUTATE_OK, nutate_history_size(history, &n, &width));
    CHECK(n == 1 && width == 45);
    {
        double row[45];
        EXPECT(NUTATE_OK, nutate_history_values(history, row, 45));
        for (n = 0; n < 45; ++n)
            CHECK(fabs(row[n] - inside[n]) < 1e-13 * (1.0 + fabs(row[n])));
    }
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_differentiate(a, plain));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_differentiate(NULL, scene));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_differentiate(a, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&a));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&b));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&plain));
    return 0;
}

int test_c_misused_runs(void)
{
    static const double back[2] = {0.5, 0.4}, late[1] = {1.5}, twice[2] = {0.5, 0.5}, no_number[1] = {NAN};
    nutate_stepper *stepper = NULL, *copy = NULL;
    nutate_history *history = NULL;
    char bytes[16] = "", text[64];
    size_t n = 9;
    nutate_row_run run = {1.0, 1, 0.0, back, 2, NULL, 0, {9}, {0.0}, NULL};
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_run_history(NULL, 1.0, 1, 0.0, NULL, 0, &history));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_run_rows(NULL, &run));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_get(NULL, "method", text, sizeof text));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_set_poll(NULL, stop_later, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_set_poll(NULL, stop_later, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_copy(NULL, &copy, text, sizeof text));
    CHECK(strstr(text, "stepper"));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_save(NULL, bytes, sizeof bytes, &n));
    CHECK(n == 0);
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_restore(NULL, bytes, sizeof bytes));
    EXPECT(NUTATE_OK, make_stepper(&stepper));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_copy(stepper, NULL, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_history(stepper, 1.0, 1, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_history(stepper, 1.0, 1, 0.0, NULL, 0, &history)); /* no time_step */
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_OK, nutate_stepper_set_time_step(stepper, 0.1));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_rows(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_rows(stepper, &run));
    CHECK(run.counts[0] == 0 && run.history == NULL);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_history(stepper, 1.0, 1, 0.0, back, 2, &history));
    CHECK(history == NULL);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_history(stepper, 1.0, 1, 0.0, late, 1, &history));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_history(stepper, 1.0, 1, 0.0, twice, 2, &history));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_history(stepper, 1.0, 1, 0.0, no_number, 1, &history));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_history(stepper, 1.0, 1, 0.0, back, (size_t)-1, &history));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_get(stepper, NULL, text, sizeof text));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_get(stepper, "methods", text, sizeof text));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_get(stepper, "method", NULL, 9));
    EXPECT(NUTATE_TRUNCATED, nutate_stepper_get(stepper, "method", text, 4));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_restore(stepper, NULL, 9));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_restore(stepper, bytes, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_restore(stepper, bytes, (size_t)-1));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_restore(stepper, bytes, sizeof bytes));
    EXPECT(NUTATE_OK, nutate_status_text(NUTATE_STOPPED, text, sizeof text));
    CHECK(strstr(text, "stop"));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    return 0;
}

/* Indicators of chaos of scenes and of steppers; a copy of a stepper goes on with the same bits. */
int test_c_chaos(void)
{
    static const char *const text = "&body inertia = 3, 2, 1 /\n"
                                    "&initial quaternion = 0.8, 0.4, -0.4, 0.2, angular_velocity = 0.4, -0.3, 0.5 /\n"
                                    "&dipole moment = 1, 0.3, 0.5, field = 0, 0, -1 /\n"
                                    "&integrator time_step = 0.1, end_time = 40 /\n"
                                    "&output columns = 'quaternion', 'lyapunov', 'megno', 'fli' /\n&chaos exponents = 6 /\n";
    static const char *const plain_text = "&body inertia = 3, 2, 1 /\n&dipole moment = 1, 0.3, 0.5, field = 0, 0, -1 /\n"
                                          "&initial angular_velocity = 1, 0, 0 /\n&integrator time_step = 0.1, end_time = 40 /\n";
    nutate_scene *scene = NULL, *plain = NULL;
    nutate_stepper *a = NULL, *b = NULL, *twin = NULL;
    nutate_history *history = NULL;
    double exponents[6], megno, fli, time, row[13], q[4], omega[3];
    int64_t counts[5];
    size_t n, rows, width;
    EXPECT(NUTATE_OK, nutate_scene_parse(text, NULL, NULL, 0, &scene, NULL, 0));
    EXPECT(NUTATE_OK, nutate_scene_run(scene, &history, NULL, 0));
    EXPECT(NUTATE_OK, nutate_history_chaos(history, &n, exponents, &megno, &fli, &time));
    CHECK(n == 6 && exponents[0] > 0.1 && exponents[5] < -0.1 && fabs(time - 40.0) < 1e-12 && fli > 4.0);
    EXPECT(NUTATE_OK, nutate_history_chaos(history, NULL, NULL, NULL, NULL, NULL));
    EXPECT(NUTATE_OK, nutate_history_summary(history, counts, NULL));
    CHECK(counts[3] == 6);
    EXPECT(NUTATE_OK, nutate_history_size(history, &rows, &width));
    CHECK(rows == 401 && width == 13);
    {
        double *values = malloc(rows * width * sizeof *values);
        CHECK(values != NULL);
        EXPECT(NUTATE_OK, nutate_history_values(history, values, rows * width));
        memcpy(row, values + 400 * 13, sizeof row);
        free(values);
    }
    for (n = 0; n < 6; ++n)
        CHECK(row[5 + n] == exponents[n]);
    CHECK(row[11] == megno && row[12] == fli);
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    /* A stepper of the scene follows them too, in each run from its start. */
    EXPECT(NUTATE_OK, nutate_stepper_create_scene(scene, &a, NULL, 0));
    EXPECT(NUTATE_OK, nutate_stepper_run_history(a, 40.0, 400, 0.0, NULL, 0, &history));
    EXPECT(NUTATE_OK, nutate_history_chaos(history, &n, exponents, NULL, NULL, &time));
    CHECK(n == 6 && exponents[0] == row[5] && exponents[5] == row[10]);
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_row(a, row, 13));
    EXPECT(NUTATE_OK, nutate_stepper_copy(a, &twin, NULL, 0));
    EXPECT(NUTATE_OK, nutate_stepper_run_history(a, 50.0, 1, 0.0, NULL, 0, &history));
    EXPECT(NUTATE_OK, nutate_history_chaos(history, &n, exponents, &megno, NULL, &time));
    CHECK(n == 6 && fabs(time - 10.0) < 1e-12);
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_OK, nutate_stepper_run_history(twin, 50.0, 1, 0.0, NULL, 0, &history));
    EXPECT(NUTATE_OK, nutate_history_chaos(history, &n, row, &fli, NULL, NULL));
    CHECK(n == 6 && row[0] == exponents[0] && row[5] == exponents[5] && fli == megno);
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    /* Any stepper of the body does, where it is told to, until it is told not to. */
    EXPECT(NUTATE_OK, nutate_scene_parse(plain_text, NULL, NULL, 0, &plain, NULL, 0));
    EXPECT(NUTATE_OK, nutate_stepper_create_scene(plain, &b, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_columns(b, "megno"));
    EXPECT(NUTATE_OK, nutate_stepper_follow_chaos(b, scene));
    EXPECT(NUTATE_OK, nutate_stepper_set_columns(b, "megno"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_dense_output(b, 0.0, (const double[4]){1.0, 0.0, 0.0, 0.0}, row, NULL, 0.1, 1,
                                                            &(const double){0.05}, exponents));
    EXPECT(NUTATE_OK, nutate_scene_get_initial(scene, q, omega));
    EXPECT(NUTATE_OK, nutate_stepper_set_state(b, 0.0, q, omega));
    EXPECT(NUTATE_OK, nutate_stepper_run_history(b, 40.0, 400, 0.0, NULL, 0, &history));
    EXPECT(NUTATE_OK, nutate_history_chaos(history, &n, exponents, NULL, NULL, NULL));
    CHECK(n == 6);
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_follow_chaos(b, plain));
    EXPECT(NUTATE_OK, nutate_stepper_set_columns(b, "quaternion"));
    EXPECT(NUTATE_OK, nutate_stepper_follow_chaos(b, plain));
    EXPECT(NUTATE_OK, nutate_stepper_run_history(b, 41.0, 1, 0.0, NULL, 0, &history));
    EXPECT(NUTATE_OK, nutate_history_chaos(history, &n, NULL, NULL, NULL, NULL));
    CHECK(n == 0);
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_follow_chaos(NULL, scene));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&a));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&b));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&twin));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&plain));
    return 0;
}
