/* Misuse of the C interface. Each function returns 0, or the line of the first check that fails. */
#include "test_c_support.h"

int test_c_foreign_handles(void);
int test_c_sizes(void);
int test_c_bad_steps(void);
int test_c_bad_numbers(void);
int test_c_unknown_names(void);
int test_c_unprepared(void);

/* A handle of another kind, memory that is no handle, one that was destroyed. */
int test_c_foreign_handles(void)
{
    int64_t nothing[300] = {0};
    nutate_system *system = NULL;
    nutate_stepper *stepper = NULL, *copy;
    double x[4];
    size_t n;
    EXPECT(NUTATE_OK, make_box(&system));
    EXPECT(NUTATE_OK, make_stepper(&stepper));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_step((nutate_stepper *)system, 0.1));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_step((nutate_stepper *)(void *)nothing, 0.1));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_rotor((nutate_system *)stepper, vector));
    EXPECT(NUTATE_BAD_HANDLE, nutate_history_size((nutate_history *)stepper, &n, &n));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_get_plan((nutate_scene *)stepper, x, NULL, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_last_message(nothing, (char *)x, sizeof x));
    copy = (nutate_stepper *)system;
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_destroy(&copy));
    CHECK(copy == (nutate_stepper *)system);
    copy = stepper;
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    CHECK(stepper == NULL);
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_step(stepper, 0.1));
    /* Memory that was freed is read here, which tools that watch memory report. */
    if (!getenv("NUTATE_SLOW_BUILD")) EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_quaternion(copy, x));
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    return 0;
}

int test_c_sizes(void)
{
    nutate_stepper *stepper = NULL;
    nutate_system *system = NULL;
    nutate_scene *scene = NULL;
    nutate_history *history = NULL;
    double rows[40], values[4];
    char text[16];
    size_t n = 99, width, columns;
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_shape("box", moments, 2, 1.0, 0.0, NULL, &system, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_shape("sphere", moments, 3, 1.0, 0.0, NULL, &system, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_shape("box", moments, 0, 1.0, 0.0, NULL, &system, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_shape("box", one, (size_t)-1, 1.0, 0.0, NULL, &system, NULL, 0));
    EXPECT(NUTATE_OK, make_stepper(&stepper));
    EXPECT(NUTATE_OK, nutate_stepper_set_time_step(stepper, 0.01));
    EXPECT(NUTATE_OK, nutate_stepper_set_columns(stepper, "angular_velocity"));
    EXPECT(NUTATE_OK, nutate_stepper_width(stepper, &width));
    CHECK(width == 4);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_row(stepper, rows, 3));
    EXPECT(NUTATE_OK, nutate_stepper_row(stepper, rows, 4));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_column(stepper, 4, text, sizeof text));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_column(stepper, (size_t)-1, text, sizeof text));
    EXPECT(NUTATE_TRUNCATED, nutate_stepper_column_names(stepper, text, sizeof text));
    CHECK(!strcmp(text, "t,omega1,omega2"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run(stepper, 10, 1, rows, 9, &n));
    CHECK(n == 0);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run(stepper, -1, 1, rows, 10, &n));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run(stepper, 1, 0, rows, 10, &n));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_steps(stepper, 0.1, -1, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_to(stepper, 0.1, 1, 0.0, rows, 10, &n));
    EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 10, 3, rows, 3, &n));
    CHECK(n == 3 && fabs(rows[8] - 0.09) < 1e-15);
    EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 0, 1, rows, 0, &n));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    EXPECT(NUTATE_OK, make_scene(scene_text, &scene));
    EXPECT(NUTATE_OK, nutate_scene_run(scene, &history, NULL, 0));
    EXPECT(NUTATE_OK, nutate_history_size(history, &n, &columns));
    CHECK(n == 101 && columns == 15);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_history_column(history, "t", values, 100));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_history_values(history, values, 101 * 15 - 1));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_history_name(history, 15, text, sizeof text));
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    return 0;
}

int test_c_bad_steps(void)
{
    static const double bad[] = {0.0, -0.0, NAN, INFINITY, -INFINITY, 1e300, -1e300, 1e-300, 5e-324, DBL_MAX};
    static const double spin[3] = {0.0, 0.0, 10.0};
    nutate_stepper *stepper = NULL;
    double before[4], after[4], energy[5];
    size_t i, n;
    EXPECT(NUTATE_OK, make_stepper(&stepper));
    EXPECT(NUTATE_OK, nutate_stepper_step(stepper, 0.01));
    EXPECT(NUTATE_OK, nutate_stepper_quaternion(stepper, before));
    for (i = 0; i < sizeof bad / sizeof *bad; ++i) {
        EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_step(stepper, bad[i]));
        EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_steps(stepper, bad[i], 3, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "order", "2"));
        CHECK(nutate_stepper_set_time_step(stepper, bad[i]) == NUTATE_BAD_ARGUMENT ||
              nutate_stepper_run(stepper, 1, 1, NULL, 0, NULL) == NUTATE_BAD_ARGUMENT);
    }
    EXPECT(NUTATE_OK, nutate_stepper_quaternion(stepper, after));
    CHECK(memcmp(before, after, sizeof before) == 0);
    EXPECT(NUTATE_OK, nutate_stepper_step(stepper, -0.01));
    EXPECT(NUTATE_OK, nutate_stepper_quaternion(stepper, after));
    for (i = 0; i < 4; ++i) CHECK(fabs(after[i] - one[i]) < 4 * DBL_EPSILON);
    /* A step that is too long for the motion, here a spin about the intermediate axis, fails. */
    EXPECT(NUTATE_OK, nutate_stepper_set_state(stepper, 0.0, one, spin));
    EXPECT(NUTATE_OFF_BRANCH, nutate_stepper_step(stepper, 0.5));
    EXPECT(NUTATE_OK, nutate_stepper_quaternion(stepper, after));
    CHECK(memcmp(one, after, sizeof one) == 0);
    EXPECT(NUTATE_OK, nutate_stepper_set_state(stepper, 0.0, one, vector));
    EXPECT(NUTATE_OK, nutate_stepper_set_time_step(stepper, 0.01));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_to(stepper, -1.0, 1, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_to(stepper, NAN, 1, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_to(stepper, 1.0, 0, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_to(stepper, 1.0, 1, 0.1, NULL, 0, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run_to(stepper, 1.0, 1, NAN, NULL, 0, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_count_rows(stepper, NAN, 1, &n));
    EXPECT(NUTATE_OK, nutate_stepper_set_time_step(stepper, -0.01));
    EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, -1.0, 1, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_energy(stepper, energy));
    CHECK(fabs(energy[4]) < 1e-12 * energy[2]);
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    return 0;
}

/* Each argument in turn a number that no physics has. */
int test_c_bad_numbers(void)
{
    static const double bad[] = {NAN, INFINITY, -INFINITY, 1e300, -1e300, DBL_MAX};
    nutate_system *system = NULL, *none = NULL;
    nutate_stepper *stepper = NULL;
    double x[6], q[4], p[4] = {0.0, 1.0, 0.0, 0.0};
    size_t i, k;
    EXPECT(NUTATE_OK, make_box(&system));
    EXPECT(NUTATE_OK, make_stepper(&stepper));
    for (i = 0; i < sizeof bad / sizeof *bad; ++i)
        for (k = 0; k < 3; ++k) {
            memcpy(x, moments, sizeof moments);
            x[3] = x[4] = x[5] = 0.0;
            x[k] = bad[i];
            CHECK(nutate_system_create_moments(x, 0.0, NULL, 0, &none, NULL, 0) != NUTATE_OK && !none);
            CHECK(nutate_system_create_tensor(x, 0.0, NULL, 0, &none, NULL, 0) != NUTATE_OK && !none);
            CHECK(nutate_system_create_moments(moments, 1.0, x, 0, &none, NULL, 0) != NUTATE_OK && !none);
            CHECK(nutate_system_create_moments(moments, bad[i], NULL, 0, &none, NULL, 0) != NUTATE_OK && !none);
            CHECK(nutate_system_create_shape("box", x, 3, 1.0, 0.0, NULL, &none, NULL, 0) != NUTATE_OK && !none);
            CHECK(nutate_system_create_shape("box", moments, 3, 0.0, bad[i], NULL, &none, NULL, 0) != NUTATE_OK && !none);
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_gravity(system, x));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_dipole(system, x, vector));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_dipole(system, vector, x));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_gravity_gradient(system, x, 1.0));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_gravity_gradient(system, vector, bad[i]));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_spring(system, x, vector, 1.0, 0.0));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_spring(system, vector, x, 1.0, 0.0));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_spring(system, vector, vector, bad[i], 0.0));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_spring(system, vector, vector, 1.0, bad[i]));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_damping(system, x));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_torque(system, x, 0, 0.0, 0.0, 0.0, 1.0));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_torque(system, vector, 1, bad[i], 0.0, 0.0, 1.0));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_torque(system, vector, 1, 0.0, bad[i], 0.0, 1.0));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_rotor(system, x));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_potential(system, x, answer_potential, NULL, NULL));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_state(stepper, bad[i], one, vector));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_state(stepper, 0.0, one, x));
            memcpy(q, one, sizeof q);
            q[k] = bad[i];
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_state(stepper, 0.0, q, vector));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_canonical(stepper, 0.0, q, p));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_canonical(stepper, 0.0, one, q));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_exact_free_body(system, q, vector, 0, NULL, NULL, NULL));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_exact_free_body(system, one, x, 0, NULL, NULL, NULL));
            EXPECT(NUTATE_BAD_ARGUMENT, nutate_exact_free_body(system, one, vector, 1, &bad[i], NULL, NULL));
        }
    EXPECT(NUTATE_BAD_BODY, nutate_system_create_moments(vector, 0.0, NULL, 0, &none, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_shape("box", moments, 3, 1.0, 1.0, NULL, &none, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_shape("box", moments, 3, 0.0, 0.0, NULL, &none, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_torque(system, vector, 0, 0.0, 0.0, 2.0, 1.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_torque(system, vector, 0, 0.0, 0.0, NAN, 1.0));
    EXPECT(NUTATE_OK, nutate_system_add_torque(system, vector, 0, 0.0, 0.0, -INFINITY, INFINITY));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_spring(system, vector, vector, 1.0, -1.0));
    q[0] = q[1] = q[2] = q[3] = 0.0;
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_gravity_gradient(system, q, 1.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_potential(system, q, answer_potential, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_state(stepper, 0.0, q, vector));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_exact_free_body(system, one, vector, 0, NULL, NULL, NULL)); /* not free */
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 0.0, NULL, 0, &system, NULL, 0));
    EXPECT(NUTATE_BAD_BODY, nutate_system_add_gravity(system, vector)); /* no mass */
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    return 0;
}

int test_c_unknown_names(void)
{
    nutate_system *system = NULL;
    nutate_scene *scene = NULL;
    nutate_stepper *stepper = NULL;
    nutate_history *history = NULL;
    const char *const overrides[2] = {"output.every=2", "integrator.tim_step=2"};
    double x[200];
    char text[600], whole[1000];
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_shape("bax", moments, 3, 1.0, 0.0, NULL, &system, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_shape("", moments, 3, 1.0, 0.0, NULL, &system, NULL, 0));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_parse("&bodi inertia = 1, 1, 1 /", &system, text, sizeof text));
    CHECK(strstr(text, "nearest: body"));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_parse("&body inertia = 1, 1, 1 / &gravty /", &system, whole, sizeof whole));
    CHECK(strstr(whole, "rotating_frame") && !strstr(whole, "..."));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_parse("&gravity /", &system, NULL, 0));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_parse("&body inertia = 1, 1, 1 / &spring /", &system, NULL, 0));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_parse("&body inertia = 1, 1, 1 / &output /", &system, NULL, 0));
    CHECK(system == NULL);
    EXPECT(NUTATE_OK, nutate_system_parse("&body inertia = 1, 1, 1, mass = 1 / &gravity /", &system, NULL, 0));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_add_groups(system, "&gravty /"));
    EXPECT(NUTATE_OK, nutate_last_message(system, whole, sizeof whole));
    CHECK(strstr(whole, "rotating_frame") && strstr(whole, "nearest: gravity)") && !strstr(whole, "..."));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_add_groups(system, "&body inertia = 1, 1, 1 /"));
    EXPECT(NUTATE_OK, nutate_system_add_groups(system, "&rotor momentum = 0, 0, 1 /"));
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    EXPECT(NUTATE_IO, nutate_scene_read("no/such/scene.nml", NULL, 0, &scene, text, sizeof text));
    CHECK(strstr(text, "no/such/scene.nml"));
    EXPECT(NUTATE_BAD_SCENE, nutate_scene_parse("&body /", NULL, NULL, 0, &scene, NULL, 0));
    EXPECT(NUTATE_BAD_SCENE, nutate_scene_parse(scene_text, NULL, overrides, 2, &scene, text, sizeof text));
    CHECK(strstr(text, "nearest: time_step") && scene == NULL);
    EXPECT(NUTATE_OK, nutate_scene_parse(scene_text, NULL, overrides, 1, &scene, NULL, 0));
    EXPECT(NUTATE_IO, nutate_scene_write(scene, "no/such/folder.csv", NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_write(scene, "", NULL, 0));
    EXPECT(NUTATE_OK, nutate_scene_run(scene, &history, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_history_column(history, "omega", x, 200));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_history_column(history, "", x, 200));
    EXPECT(NUTATE_OK, nutate_history_column(history, "omega1", x, 200));
    CHECK(fabs(x[0] - 0.1) < 1e-15);
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    EXPECT(NUTATE_OK, make_stepper(&stepper));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set(stepper, "metod", "rk4"));
    EXPECT(NUTATE_OK, nutate_last_message(stepper, text, sizeof text));
    CHECK(strstr(text, "nearest: method"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set(stepper, "method", "rk5"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set(stepper, "order", "two"));
    EXPECT(NUTATE_BAD_SCENE, nutate_stepper_add_events(stepper, "&event when = 'omega4', crosses = 0 /"));
    EXPECT(NUTATE_OK, nutate_last_message(stepper, text, sizeof text));
    CHECK(strstr(text, "a name that the reference lists; nearest: omega1") && !strstr(text, " ... "));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set(stepper, "order", "2, time_step = 3"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set(stepper, "end_time", "2"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set(stepper, "", ""));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_columns(stepper, "quaternion,energie"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_columns(stepper, "quaternion,,energy"));
    EXPECT(NUTATE_OK, nutate_stepper_set_columns(stepper, " quaternion, energy "));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    return 0;
}

/* Settings that do not fit together show when the method is prepared, by call or by the first step. */
int test_c_unprepared(void)
{
    nutate_stepper *stepper = NULL;
    char text[300];
    double t;
    EXPECT(NUTATE_OK, make_stepper(&stepper));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run(stepper, 1, 1, NULL, 0, NULL)); /* no time_step */
    EXPECT(NUTATE_OK, nutate_stepper_step(stepper, 0.01));
    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "order", "3"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_prepare(stepper));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_step(stepper, 0.01));
    EXPECT(NUTATE_OK, nutate_last_message(stepper, text, sizeof text));
    CHECK(strstr(text, "order 3"));
    EXPECT(NUTATE_OK, nutate_stepper_time(stepper, &t));
    CHECK(fabs(t - 0.01) < 1e-17);
    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "order", "6"));
    EXPECT(NUTATE_OK, nutate_stepper_step(stepper, 0.01));
    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "accuracy", "1e-6"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_run(stepper, 1, 1, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, 0.5, 1, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_step(stepper, 0.01));
    EXPECT(NUTATE_OK, nutate_stepper_time(stepper, &t));
    CHECK(fabs(t - 0.51) < 1e-15);
    /* The automatic choice takes an accuracy, and no order. */
    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "method", "auto"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_prepare(stepper));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    EXPECT(NUTATE_OK, make_stepper(&stepper));
    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "method", "auto"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_prepare(stepper));
    EXPECT(NUTATE_OK, nutate_last_message(stepper, text, sizeof text));
    CHECK(strstr(text, "accuracy or local_tolerance"));
    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "accuracy", "1e-6"));
    EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, 0.5, 1, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_step(stepper, 0.01));
    EXPECT(NUTATE_OK, nutate_stepper_time(stepper, &t));
    CHECK(fabs(t - 0.51) < 1e-15);
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    return 0;
}
