/* The C interface: members of ensembles. Each function returns 0, or the line of the first check that fails. */
#include "test_c_support.h"
#include <stdio.h>

int test_c_sweep_rows(void);
int test_c_sweep_table(void);
int test_c_sweep_refused(void);
int test_c_sweep_callbacks(void);
int test_c_sweep_stopped(void);

enum { MEMBERS = 40, MOST_FIELDS = 40 };

static const char ensemble[] =
    "&body inertia = 5, 16, 13 / &initial angular_velocity = 0.1, 0, 10 /\n"
    "&integrator time_step = 0.01, end_time = 0.2 / &output columns = 'angular_velocity' /\n"
    "&event name = 'low', when = 'omega3', crosses = 9 /\n"
    "&ensemble members = 40 / &vary key = 'body.inertia.1', distribution = 'uniform', low = 2, high = 7 /\n";

/* Rows have the numbers of scenes by hand, whoever runs them; a member that a scene refuses says so. */
int test_c_sweep_rows(void)
{
    static const char *const names[] = {"member", "status", "body.inertia.1", "t", "omega1", "omega2", "omega3",
                                        "largest_energy_residual", "largest_momentum_error", "low_count", "low_first"};
    nutate_scene *scene = NULL;
    double whole[MEMBERS][11], part[MEMBERS][11];
    int64_t members, member, code;
    size_t fields, i;
    int is_whole, k, refused = 0;
    char text[96];
    EXPECT(NUTATE_OK, make_scene(ensemble, &scene));
    EXPECT(NUTATE_OK, nutate_sweep_size(scene, &members, &fields));
    CHECK(members == MEMBERS && fields == 11);
    EXPECT(NUTATE_OK, nutate_sweep_size(scene, NULL, NULL));
    for (i = 0; i < fields; ++i) {
        EXPECT(NUTATE_OK, nutate_sweep_field(scene, i, &is_whole, text, sizeof text));
        CHECK(strcmp(text, names[i]) == 0 && is_whole == (i < 2 || i == 9));
    }
    EXPECT(NUTATE_OK, nutate_sweep_members(scene, 1, MEMBERS, 1, whole, sizeof whole, NULL, 0));
    for (k = 0; k < MEMBERS; k += 10) EXPECT(NUTATE_OK, nutate_sweep_members(scene, k + 1, k + 10, 1, part[k], 10 * sizeof part[0], NULL, 0));
    CHECK(memcmp(whole, part, sizeof whole) == 0);
    if (nutate_sweep_members(scene, 1, MEMBERS, 2, part, sizeof part, text, sizeof text)) CHECK(strstr(text, "without threads"));
    CHECK(memcmp(whole, part, sizeof whole) == 0);
    for (k = 0; k < MEMBERS; ++k) {
        char setting[60];
        const char *settings[1] = {setting};
        nutate_scene *single = NULL;
        nutate_history *history = NULL;
        double *column;
        memcpy(&member, &whole[k][0], 8);
        memcpy(&code, &whole[k][1], 8);
        CHECK(member == k + 1);
        snprintf(setting, sizeof setting, "body.inertia=%.17g,16,13", whole[k][2]);
        EXPECT((int)(code ? NUTATE_BAD_SCENE : NUTATE_OK), nutate_scene_parse(ensemble, NULL, settings, 1, &single, NULL, 0));
        refused += code != 0;
        CHECK(code == 0 || (code == NUTATE_BAD_BODY && whole[k][6] != whole[k][6]));
        if (code) continue;
        EXPECT(NUTATE_OK, nutate_scene_run(single, &history, NULL, 0));
        EXPECT(NUTATE_OK, nutate_history_size(history, &i, NULL));
        column = malloc(i * sizeof *column);
        CHECK(i > 1 && column);
        EXPECT(NUTATE_OK, nutate_history_column(history, "omega3", column, i));
        CHECK(column[i - 1] == whole[k][6]);
        free(column);
        EXPECT(NUTATE_OK, nutate_history_destroy(&history));
        EXPECT(NUTATE_OK, nutate_scene_destroy(&single));
    }
    CHECK(refused > 0 && refused < MEMBERS);
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    return 0;
}

/* A table makes an ensemble of a scene, once. */
int test_c_sweep_table(void)
{
    static const char *const names[2] = {"body.inertia.1", "initial.angular_velocity.3"}, *const bad[1] = {"body.shape"};
    static const double numbers[3][2] = {{5.0, 9.0}, {6.0, 10.0}, {7.0, 11.0}};
    nutate_scene *scene = NULL;
    double rows[3 * MOST_FIELDS];
    int64_t members;
    size_t fields;
    char message[200];
    EXPECT(NUTATE_OK, make_scene(scene_text, &scene));
    EXPECT(NUTATE_OK, nutate_sweep_size(scene, &members, &fields));
    CHECK(members == 0 && fields == 0);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_members(scene, 1, 1, 1, rows, sizeof rows, message, sizeof message));
    CHECK(strstr(message, "no ensemble"));
    EXPECT(NUTATE_BAD_SCENE, nutate_sweep_table(scene, bad, 1, numbers[0], 3, message, sizeof message));
    EXPECT(NUTATE_OK, nutate_sweep_size(scene, &members, NULL));
    CHECK(members == 0 && strstr(message, "not numeric"));
    EXPECT(NUTATE_OK, nutate_sweep_table(scene, names, 2, numbers[0], 3, message, sizeof message));
    EXPECT(NUTATE_OK, nutate_sweep_size(scene, &members, &fields));
    CHECK(members == 3 && fields > 6 && fields <= MOST_FIELDS);
    EXPECT(NUTATE_OK, nutate_sweep_members(scene, 1, 3, 1, rows, 3 * fields * sizeof(double), NULL, 0));
    CHECK(rows[2] == 5.0 && rows[3] == 9.0 && rows[2 * fields + 2] == 7.0 && rows[2 * fields + 3] == 11.0);
    EXPECT(NUTATE_BAD_SCENE, nutate_sweep_table(scene, names, 2, numbers[0], 3, message, sizeof message));
    CHECK(strstr(message, "has a table"));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    return 0;
}

/* What is wrong is reported, and nothing is written. */
int test_c_sweep_refused(void)
{
    static const char *const names[1] = {"body.inertia.2"}, *const none[1] = {NULL};
    nutate_scene *scene = NULL;
    nutate_stepper *stepper = NULL;
    double rows[2][11];
    const double number[2] = {16.0, HUGE_VAL};
    char text[200];
    memset(rows, 7, sizeof rows);
    EXPECT(NUTATE_OK, make_scene(ensemble, &scene));
    EXPECT(NUTATE_OK, make_stepper(&stepper));
    EXPECT(NUTATE_BAD_HANDLE, nutate_sweep_size(NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_sweep_size((nutate_scene *)stepper, NULL, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_sweep_field(NULL, 0, NULL, text, sizeof text));
    EXPECT(NUTATE_BAD_HANDLE, nutate_sweep_table(NULL, names, 1, number, 1, NULL, 0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_sweep_members(NULL, 1, 1, 1, rows, sizeof rows, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_field(scene, 11, NULL, text, sizeof text));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_field(scene, 0, NULL, NULL, 9));
    EXPECT(NUTATE_TRUNCATED, nutate_sweep_field(scene, 0, NULL, text, 4));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_table(scene, NULL, 1, number, 1, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_table(scene, names, 1, NULL, 1, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_table(scene, none, 1, number, 1, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_table(scene, names, 0, number, 1, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_table(scene, names, 201, number, 1, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_table(scene, names, 1, number, 0, NULL, 0));
    EXPECT(NUTATE_BAD_SCENE, nutate_sweep_table(scene, names, 1, number, 1, text, sizeof text));
    CHECK(strstr(text, "more members than lines"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_members(scene, 1, 2, 1, NULL, sizeof rows, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_members(scene, 0, 1, 1, rows, sizeof rows, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_members(scene, 2, 1, 1, rows, 0, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_members(scene, 40, 41, 1, rows, sizeof rows, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_members(scene, 1, 2, 0, rows, sizeof rows, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_members(scene, 1, 2, 5000, rows, sizeof rows, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_sweep_members(scene, 1, 2, 1, rows, sizeof rows - 8, NULL, 0));
    CHECK(((char *)rows)[0] == 7 && ((char *)rows)[sizeof rows - 1] == 7);
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    EXPECT(NUTATE_OK, make_scene(scene_text, &scene));
    EXPECT(NUTATE_BAD_SCENE, nutate_sweep_table(scene, names, 1, number + 1, 1, text, sizeof text));
    CHECK(strstr(text, "not finite"));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    return 0;
}

/* A torque that damps the rotation about axis 1, and fails where that about axis 2 exceeds a limit. */
static int damp(double t, const double q[4], const double omega[3], void *limit, double tau[3])
{
    (void)t;
    (void)q;
    tau[0] = -0.1 * omega[0];
    tau[1] = tau[2] = 0.0;
    return omega[1] > *(const double *)limit ? 3 : 0;
}

/* Callbacks act on every member as a named effect does; where one fails, the row says so, whichever thread runs it. */
int test_c_sweep_callbacks(void)
{
    static const char *const damping[1] = {"damping.coefficient=0.1,0,0"};
    nutate_scene *scene = NULL, *named = NULL;
    double limit = 1e9, rows[MEMBERS][11], expected[MEMBERS][11], other[MEMBERS][11], highest = 0.0;
    int64_t code, without;
    int i, k, failed = 0;
    char text[96];
    EXPECT(NUTATE_OK, make_scene(ensemble, &scene));
    EXPECT(NUTATE_OK, nutate_scene_add_user_torque(scene, damp, &limit));
    EXPECT(NUTATE_OK, nutate_scene_parse(ensemble, NULL, damping, 1, &named, NULL, 0));
    EXPECT(NUTATE_OK, nutate_sweep_members(scene, 1, MEMBERS, 1, rows, sizeof rows, NULL, 0));
    EXPECT(NUTATE_OK, nutate_sweep_members(named, 1, MEMBERS, 1, expected, sizeof expected, NULL, 0));
    for (k = 0; k < MEMBERS; ++k) {
        CHECK(memcmp(rows[k], expected[k], 4 * sizeof(double)) == 0);
        for (i = 4; i < 7; ++i) CHECK(rows[k][1] != 0.0 || fabs(rows[k][i] - expected[k][i]) < 1e-13 * 10);
        if (!isnan(rows[k][5]) && rows[k][5] > highest) highest = rows[k][5];
    }
    limit = highest / 2;
    EXPECT(NUTATE_OK, nutate_sweep_members(scene, 1, MEMBERS, 1, expected, sizeof expected, NULL, 0));
    for (k = 0; k < MEMBERS; ++k) {
        memcpy(&without, &rows[k][1], 8);
        memcpy(&code, &expected[k][1], 8);
        CHECK(code == without || (without == 0 && code == NUTATE_CALLBACK && expected[k][6] != expected[k][6]));
        CHECK(code != 0 || memcmp(rows[k], expected[k], sizeof rows[k]) == 0);
        failed += code == NUTATE_CALLBACK;
    }
    CHECK(failed > 0 && failed < MEMBERS - 10);
    if (nutate_sweep_members(scene, 1, MEMBERS, 2, other, sizeof other, text, sizeof text)) {
        CHECK(strstr(text, "without threads"));
    } else
        CHECK(memcmp(expected, other, sizeof other) == 0);
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&named));
    return 0;
}

static int stop_at_third(void *user)
{
    return ++*(int *)user == 3;
}

/* The poll of a scene ends a sweep, between two members or within one. */
int test_c_sweep_stopped(void)
{
    static const char *const longer[1] = {"integrator.end_time=1e5"};
    nutate_scene *scene = NULL;
    double rows[MEMBERS][11];
    int calls = 0;
    EXPECT(NUTATE_OK, nutate_scene_parse(ensemble, NULL, longer, 1, &scene, NULL, 0));
    EXPECT(NUTATE_OK, nutate_scene_set_poll(scene, stop_at_third, &calls));
    EXPECT(NUTATE_STOPPED, nutate_sweep_members(scene, 1, MEMBERS, 1, rows, sizeof rows, NULL, 0));
    CHECK(calls == 3);
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    return 0;
}
