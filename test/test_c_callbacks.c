/* Callbacks, texts and attitudes of the C interface. Each function returns 0, or the line of the first check that fails. */
#include "test_c_support.h"

int test_c_bad_callbacks(void);
int test_c_bad_callbacks_in_runs(void);
int test_c_jumping_torque(void);
int test_c_texts(void);
int test_c_attitudes(void);

/* A stepper with a callback that answers as it should until t = 0.05. */
static int make_answering(struct answer *answer, int as_torque, nutate_stepper **stepper)
{
    nutate_system *system = NULL;
    static const double up[3] = {0.0, 0.0, 1.0};
    int status = make_box(&system);
    if (!status && as_torque) status = nutate_system_add_user_torque(system, answer_torque, answer);
    if (!status && !as_torque) status = nutate_system_add_potential(system, up, answer_potential, flat_hessian, answer);
    if (!status) status = nutate_stepper_create(system, stepper, NULL, 0);
    if (!status) status = nutate_stepper_set_state(*stepper, 0.0, one, vector);
    if (!status) status = nutate_stepper_set_time_step(*stepper, 0.01);
    nutate_system_destroy(&system);
    return status;
}

static const struct {
    int returned, status;
    double value;
} answers[] = {{7, NUTATE_CALLBACK, 0.0},   {-1, NUTATE_CALLBACK, NAN},        {0, NUTATE_NOT_FINITE, NAN},
               {0, NUTATE_NOT_FINITE, INFINITY}, {0, NUTATE_NOT_FINITE, -DBL_MAX}, {0, NUTATE_NOT_FINITE, 1.0001e100}};

/* After a failure the state is that of before the step, and when the callback answers again the motion goes on. */
static int fail_and_go_on(nutate_stepper *stepper, struct answer *answer, int expected, int way)
{
    double before[4], after[4], t, energy[5];
    size_t rows = 99;
    int64_t done = 99;
    int i, status = 0;
    for (i = 0; i < 100 && !status; ++i) {
        EXPECT(NUTATE_OK, nutate_stepper_conjugate_momentum(stepper, before));
        if (way == 0) status = nutate_stepper_step(stepper, 0.01);
        if (way == 1) status = nutate_stepper_steps(stepper, 0.01, 1, &done);
        if (way == 2) status = nutate_stepper_run(stepper, 1, 1, NULL, 0, &rows);
    }
    EXPECT(expected, status);
    CHECK(i > 1 && i < 100);
    EXPECT(NUTATE_OK, nutate_stepper_conjugate_momentum(stepper, after));
    CHECK(memcmp(before, after, sizeof before) == 0);
    EXPECT(NUTATE_OK, nutate_stepper_time(stepper, &t));
    CHECK(fabs(t - 0.01 * (i - 1)) < 1e-12);
    EXPECT(expected, nutate_stepper_step(stepper, 0.01));
    answer->from_time = 1e9;
    answer->from_call = 1000000000;
    for (i = 0; i < 10; ++i) EXPECT(NUTATE_OK, nutate_stepper_step(stepper, 0.01));
    EXPECT(NUTATE_OK, nutate_stepper_energy(stepper, energy));
    CHECK(fabs(energy[4]) < 1e-12 * energy[2]);
    return 0;
}

int test_c_bad_callbacks(void)
{
    static const char *const solvers[2] = {"full", "reduced"};
    nutate_stepper *stepper = NULL;
    struct answer answer;
    double energy[5];
    int line, way, as_torque, k;
    size_t i;
    for (i = 0; i < sizeof answers / sizeof *answers; ++i)
        for (as_torque = 0; as_torque < 2; ++as_torque)
            for (way = 0; way < 3; ++way)
                for (k = 0; k < 2; ++k) {
                    answer.from_time = 0.05;
                    answer.from_call = 100;
                    answer.calls = 0;
                    answer.returned = answers[i].returned;
                    answer.value = answers[i].value;
                    EXPECT(NUTATE_OK, make_answering(&answer, as_torque, &stepper));
                    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "formulation", solvers[k]));
                    line = fail_and_go_on(stepper, &answer, answers[i].status, way);
                    if (line) return line;
                    if (!as_torque) {
                        answer.from_call = 0;
                        EXPECT(answers[i].status, nutate_stepper_energy(stepper, energy));
                        EXPECT(answers[i].status, nutate_stepper_set_state(stepper, 0.0, one, vector));
                    }
                    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
                }
    return 0;
}

/* Runs of scenes and to a time stop soon after the callback fails, with the rows before it. */
int test_c_bad_callbacks_in_runs(void)
{
    static const char *const texts[2] = {scene_text, accurate_text};
    nutate_stepper *stepper = NULL;
    nutate_scene *scene = NULL;
    nutate_history *history = NULL;
    struct answer answer = {0.5, 0, 0, 7, 0.0};
    char text[100];
    double rows[1000], t;
    size_t n;
    int k;
    for (k = 0; k < 2; ++k) {
        EXPECT(NUTATE_OK, make_scene(texts[k], &scene));
        EXPECT(NUTATE_OK, nutate_scene_add_user_torque(scene, answer_torque, &answer));
        EXPECT(NUTATE_CALLBACK, nutate_scene_run(scene, &history, text, sizeof text));
        CHECK(strstr(text, "7"));
        EXPECT(NUTATE_OK, nutate_history_size(history, &n, NULL));
        CHECK(n < 60 && (k == 1 || n > 40));
        EXPECT(NUTATE_OK, nutate_history_destroy(&history));
        EXPECT(NUTATE_OK, nutate_stepper_create_scene(scene, &stepper, NULL, 0));
        EXPECT(NUTATE_OK, nutate_stepper_set_columns(stepper, "angular_velocity"));
        EXPECT(NUTATE_CALLBACK, nutate_stepper_run_to(stepper, 1.0, 1, 0.0, rows, 250, &n));
        CHECK(n < 60 && (k == 1 || n > 40));
        EXPECT(NUTATE_OK, nutate_stepper_time(stepper, &t));
        CHECK(t <= 0.5);
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
        EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    }
    return 0;
}

static int rub(double t, const double q[4], const double omega[3], void *user, double tau[3])
{
    (void)t, (void)q, (void)user;
    for (int i = 0; i < 3; ++i) tau[i] = omega[i] > 0.0 ? -20.0 : omega[i] < 0.0 ? 20.0 : 0.0;
    return 0;
}

/* A torque that jumps ends steps, runs and scenes of the implicit method with words on what may be wrong and what runs:
 * that it does, from the same state on. */
int test_c_jumping_torque(void)
{
    nutate_scene *scene = NULL;
    nutate_history *history = NULL;
    nutate_stepper *stepper = NULL;
    char text[256];
    double t, before;
    int way;
    EXPECT(NUTATE_OK, make_scene(scene_text, &scene));
    EXPECT(NUTATE_OK, nutate_scene_add_user_torque(scene, rub, NULL));
    EXPECT(NUTATE_NOT_CONVERGED, nutate_scene_run(scene, &history, text, sizeof text));
    CHECK(strstr(text, "'callback' jumps") && strstr(text, "'dop853'"));
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_OK, nutate_stepper_create_scene(scene, &stepper, NULL, 0));
    for (way = 0; way < 2; ++way) {
        if (way == 0) EXPECT(NUTATE_NOT_CONVERGED, nutate_stepper_run(stepper, 100, 1, NULL, 0, NULL));
        else EXPECT(NUTATE_NOT_CONVERGED, nutate_stepper_step(stepper, 0.01));
        EXPECT(NUTATE_OK, nutate_last_message(stepper, text, sizeof text));
        CHECK(strstr(text, "'callback' jumps") && strstr(text, "'dop853'"));
    }
    EXPECT(NUTATE_OK, nutate_stepper_time(stepper, &before));
    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "method", "dop853"));
    EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 100, 1, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_time(stepper, &t));
    CHECK(fabs(t - before - 1.0) < 1e-12);
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    return 0;
}

int test_c_texts(void)
{
    char text[8], longer[64];
    nutate_scene *scene = NULL;
    int i;
    EXPECT(NUTATE_OK, nutate_get_version(longer, sizeof longer));
    i = NUTATE_VERSION_MAJOR;
    CHECK(longer[0] == '0' + i && longer[1] == '.' && longer[2] == '0' + NUTATE_VERSION_MINOR);
    CHECK(longer[4] == '0' + NUTATE_VERSION_PATCH && longer[5] == '\0');
    EXPECT(NUTATE_OK, nutate_get_version(text, 6));
    EXPECT(NUTATE_TRUNCATED, nutate_get_version(text, 5));
    CHECK(strcmp(text, "0.1.") == 0);
    EXPECT(NUTATE_TRUNCATED, nutate_get_version(text, 1));
    CHECK(text[0] == '\0');
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_get_version(text, 0));
    for (i = -3; i < 20; ++i) {
        EXPECT(NUTATE_OK, nutate_status_text(i, longer, sizeof longer));
        CHECK(strlen(longer) > 5);
    }
    memset(text, 'x', sizeof text);
    EXPECT(NUTATE_BAD_SCENE, nutate_scene_parse("&bdy /", NULL, NULL, 0, &scene, text, 7));
    CHECK(strlen(text) == 6 && text[7] == 'x');
    EXPECT(NUTATE_OK, nutate_scene_parse(scene_text, "folder/name.nml", NULL, 0, &scene, NULL, 0));
    EXPECT(NUTATE_OK, nutate_scene_get_title(scene, longer, sizeof longer));
    CHECK(strcmp(longer, "name") == 0);
    EXPECT(NUTATE_OK, nutate_last_message(scene, longer, sizeof longer));
    CHECK(longer[0] == '\0');
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    return 0;
}

static int near(double a, double b) { return fabs(a - b) <= 8 * DBL_EPSILON; }

/* Each form there and back, the matrix row by row, bad numbers in each. */
int test_c_attitudes(void)
{
    static const double bad[] = {NAN, INFINITY, 1e300};
    const double angles[3] = {0.4, 1.1, -0.7};
    double q[4], r[3][3], v[4], w[4], back[4], angle, zero[4] = {0.0, 0.0, 0.0, 0.0};
    int i, k;
    EXPECT(NUTATE_OK, nutate_quat_from_euler(angles, q));
    EXPECT(NUTATE_OK, nutate_matrix_from_quat(q, r));
    CHECK(near(r[2][0], sin(1.1) * sin(-0.7)) && near(r[0][2], sin(1.1) * sin(0.4)) && near(r[2][2], cos(1.1)));
    EXPECT(NUTATE_OK, nutate_quat_from_matrix((const double(*)[3])r, back));
    for (i = 0; i < 4; ++i) CHECK(near(back[i], q[i]));
    EXPECT(NUTATE_OK, nutate_euler_from_quat(q, v));
    for (i = 0; i < 3; ++i) CHECK(near(v[i], angles[i]));
    v[0] += 12.0;
    EXPECT(NUTATE_OK, nutate_follow_euler(q, v));
    CHECK(fabs(v[0] - 0.4 - 4 * acos(-1.0)) < 1e-14);
    EXPECT(NUTATE_OK, nutate_axis_angle_from_quat(q, v, &angle));
    EXPECT(NUTATE_OK, nutate_quat_from_axis_angle(v, angle, back));
    for (i = 0; i < 4; ++i) CHECK(near(back[i], q[i]));
    EXPECT(NUTATE_OK, nutate_rotation_vector_from_quat(q, v));
    EXPECT(NUTATE_OK, nutate_quat_from_rotation_vector(v, back));
    for (i = 0; i < 4; ++i) CHECK(near(back[i], q[i]));
    EXPECT(NUTATE_OK, nutate_rotate_to_space(q, vector, v));
    for (i = 0; i < 3; ++i)
        CHECK(fabs(v[i] - (r[i][0] * vector[0] + r[i][1] * vector[1] + r[i][2] * vector[2])) < 1e-14);
    EXPECT(NUTATE_OK, nutate_rotate_to_body(q, v, v));
    for (i = 0; i < 3; ++i) CHECK(fabs(v[i] - vector[i]) < 1e-14);
    EXPECT(NUTATE_OK, nutate_omega_from_euler_rates(angles, vector, w));
    CHECK(near(w[0], 0.1 * sin(1.1) * sin(-0.7) + 0.2 * cos(-0.7)));
    EXPECT(NUTATE_OK, nutate_quat_product(q, one, back));
    EXPECT(NUTATE_OK, nutate_attitude_distance(q, back, &angle));
    CHECK(angle == 0.0);
    back[0] *= 3.0, back[1] *= 3.0, back[2] *= 3.0, back[3] *= 3.0;
    EXPECT(NUTATE_OK, nutate_quat_normalized(back, back));
    for (i = 0; i < 4; ++i) CHECK(near(back[i], q[i]));

    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_normalized(zero, back));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_axis_angle(zero, 1.0, back));
    for (i = 0; i < 3; ++i)
        for (k = 0; k < 3; ++k) {
            memcpy(back, q, sizeof back);
            back[k] = bad[i];
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_matrix_from_quat(back, r));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_euler_from_quat(back, v));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_follow_euler(q, back));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_euler(back, w));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_omega_from_euler_rates(back, vector, v));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_omega_from_euler_rates(vector, back, v));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_axis_angle(back, 1.0, w));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_axis_angle(vector, bad[i], w));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_axis_angle_from_quat(back, v, &angle));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_rotation_vector(back, w));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_rotation_vector_from_quat(back, v));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_product(back, q, w));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_normalized(back, w));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_rotate_to_space(q, back, v));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_rotate_to_body(back, vector, v));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_attitude_distance(q, back, &angle));
            EXPECT(NUTATE_OK, nutate_matrix_from_quat(q, r));
            r[i][k] = bad[i];
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_matrix((const double(*)[3])r, back));
            EXPECT(NUTATE_OK, nutate_matrix_from_quat(q, r));
            r[i][k] += 0.01;
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_matrix((const double(*)[3])r, back));
        }
    return 0;
}
