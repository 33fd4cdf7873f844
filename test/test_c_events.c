/* Events and tables of C programs. Each function returns 0, or the line of the first check that fails. */
#include "test_c_support.h"

int test_c_events_found(void);
int test_c_events_stop(void);
int test_c_events_switch(void);
int test_c_events_restart(void);
int test_c_events_refused(void);
int test_c_table(void);

/* K/lambda of the box: the first zero of omega3 is there, the others at its odd multiples. */
static const double quarter = 0.9664094834075236, spin[3] = {0.1, 0.0, 10.0};

static int rate_about_axis_3(double t, const double q[4], const double omega[3], void *user, double *g)
{
    (void)t;
    (void)q;
    ++*(int *)user;
    *g = omega[2];
    return 0;
}

/* Fails in call `from_call`, by what it returns or by what it gives. */
static int bad_quantity(double t, const double q[4], const double omega[3], void *user, double *g)
{
    struct answer *answer = user;
    (void)t;
    (void)q;
    *g = omega[2];
    if (++answer->calls < answer->from_call) return 0;
    *g = answer->value;
    return answer->returned;
}

static int make_tumbling(const char *method, const char *step, nutate_stepper **stepper)
{
    nutate_system *system = NULL;
    EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 0.0, NULL, 0, &system, NULL, 0));
    EXPECT(NUTATE_OK, nutate_stepper_create(system, stepper, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    EXPECT(NUTATE_OK, nutate_stepper_set(*stepper, "method", method));
    EXPECT(NUTATE_OK, nutate_stepper_set(*stepper, "time_step", step));
    EXPECT(NUTATE_OK, nutate_stepper_set_state(*stepper, 0.0, one, spin));
    return 0;
}

/* By a column and by a function of the program: the same times, good to 1e-12 and 1e-10, and the rows of a run without. */
int test_c_events_found(void)
{
    nutate_stepper *stepper = NULL, *plain = NULL;
    double rows[1001 * 17], without[1001 * 17], t, q[4], omega[3];
    size_t i, k, n, n_rows, width;
    int64_t number;
    int calls = 0, line = make_tumbling("taylor", "0.01", &stepper);
    char name[16];
    const char *const names[] = {"flip", "mine"};
    CHECK(line == 0);
    line = make_tumbling("taylor", "0.01", &plain);
    CHECK(line == 0);
    EXPECT(NUTATE_OK, nutate_stepper_width(stepper, &width));
    CHECK(width <= 17);
    EXPECT(NUTATE_OK, nutate_stepper_add_events(stepper, "&event name = 'flip', when = 'omega3', crosses = 0 /"));
    EXPECT(NUTATE_OK, nutate_stepper_add_event(stepper, rate_about_axis_3, &calls, "&event name = 'mine', crosses = 0 /"));
    EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, 10.0, 1, 0.0, rows, 1001, &n_rows));
    CHECK(n_rows == 1001 && calls > 0);
    EXPECT(NUTATE_OK, nutate_stepper_run_to(plain, 10.0, 1, 0.0, without, 1001, &n_rows));
    CHECK(memcmp(rows, without, sizeof(double) * 1001 * width) == 0);
    EXPECT(NUTATE_OK, nutate_stepper_event_count(stepper, &n));
    CHECK(n == 10);
    for (i = 0; i < n; ++i) {
        EXPECT(NUTATE_OK, nutate_stepper_event(stepper, i, name, sizeof name, &number, &t, q, omega));
        k = strcmp(name, names[0]) == 0 ? 0 : 1;
        CHECK(strcmp(name, names[k]) == 0 && number == (int64_t)(i / 2 + 1));
        CHECK(fabs(t - (2.0 * (double)(i / 2) + 1.0) * quarter) < (i < 2 ? 1e-12 : 1e-11));
        CHECK(fabs(omega[2]) < 1e-11 && fabs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0) < 1e-14);
    }
    EXPECT(NUTATE_OK, nutate_stepper_event(stepper, 0, NULL, 0, NULL, NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_event(stepper, n, NULL, 0, NULL, NULL, NULL, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&plain));
    return 0;
}

/* A run ends at the event; the next one goes on behind it, with its count, by fixed steps or by their error. */
int test_c_events_stop(void)
{
    nutate_stepper *stepper = NULL;
    double rows[1001 * 17], t;
    size_t n, n_rows, width;
    int64_t number;
    int i, k, line;
    for (k = 0; k < 2; ++k) {
        line = make_tumbling("taylor", "0.01", &stepper);
        CHECK(line == 0);
        if (k == 1) EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "local_tolerance", "1e-12"));
        EXPECT(NUTATE_OK, nutate_stepper_width(stepper, &width));
        EXPECT(NUTATE_OK, nutate_stepper_add_events(stepper, "&event when = 'omega3', crosses = 0, stop = .true. /"));
        for (i = 0; i < 4; ++i) {
            EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, 10.0, 1, 0.0, rows, 1001, &n_rows));
            EXPECT(NUTATE_OK, nutate_stepper_event_count(stepper, &n));
            CHECK(n == 1);
            EXPECT(NUTATE_OK, nutate_stepper_event(stepper, 0, NULL, 0, &number, &t, NULL, NULL));
            CHECK(number == i + 1 && fabs(t - (2 * i + 1) * quarter) < 1e-9);
            CHECK(rows[(n_rows - 1) * width] == t);
            EXPECT(NUTATE_OK, nutate_stepper_time(stepper, &t));
            CHECK(rows[(n_rows - 1) * width] == t);
        }
        EXPECT(NUTATE_OK, nutate_stepper_set_state(stepper, 0.0, one, spin));
        if (k == 0) {
            EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 200, 50, rows, 1001, &n_rows));
            CHECK(n_rows == 2 && rows[0] == 0.5 && fabs(rows[width] - quarter) < 1e-12);
            EXPECT(NUTATE_OK, nutate_stepper_event(stepper, 0, NULL, 0, &number, NULL, NULL, NULL));
            CHECK(number == 1);
            EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 110, 50, rows, 1001, &n_rows));
            CHECK(n_rows == 2);
        }
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    }
    return 0;
}

/* A torque that an event switches off stays off in the next run; its work is accounted for. */
int test_c_events_switch(void)
{
    static const char groups[] = "&torque name = 'burn', body = 0, 0, 34 /";
    nutate_system *system = NULL;
    nutate_stepper *stepper = NULL;
    double omega[3], energy[5];
    static const double rest[3] = {0.0, 0.0, 0.0};
    size_t n;
    EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 0.0, NULL, 0, &system, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_add_groups(system, groups));
    EXPECT(NUTATE_OK, nutate_stepper_create(system, &stepper, NULL, 0));
    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "time_step", "0.1"));
    EXPECT(NUTATE_OK, nutate_stepper_set_state(stepper, 0.0, one, rest));
    EXPECT(NUTATE_BAD_SCENE, nutate_stepper_add_events(stepper, "&event when = 'omega3', crosses = 1, switch = 'brake off' /"));
    EXPECT(NUTATE_OK, nutate_stepper_add_events(stepper, "&event when = 'omega3', crosses = 1.11, switch = 'burn off' /"));
    EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, 1.0, 1, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, 3.0, 1, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_event_count(stepper, &n));
    CHECK(n == 0);
    EXPECT(NUTATE_OK, nutate_stepper_angular_velocity(stepper, omega));
    CHECK(fabs(omega[2] - 1.11) < 1e-14);
    EXPECT(NUTATE_OK, nutate_stepper_energy(stepper, energy));
    CHECK(fabs(energy[3] - 0.5 * 17 * 1.11 * 1.11) < 1e-13 && fabs(energy[4]) < 1e-13);
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    return 0;
}

/* Put into another stepper at any row, a run with events, switches and a wheel goes on to the same bits; so does its account. */
int test_c_events_restart(void)
{
    static const char groups[] = "&torque name = 'jet', body = 0, 0, 34 / &wheel axis = 0, 1, 0, inertia = 0.1, speed = 20, friction = 0.1 /",
                      events[] = "&event name = 'fast', when = 'omega3', crosses = 1.1, switch = 'jet toggle' /"
                                 "&event name = 'slow', when = 'omega3', crosses = 0.9, switch = 'jet toggle' /";
    nutate_system *system = NULL;
    nutate_stepper *each[3] = {NULL, NULL, NULL};
    double omega[3][3], energy[3][5], t[2];
    char bytes[20000];
    size_t needed, n[2], found = 0;
    int64_t number[2];
    int i, k;
    EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 0.0, NULL, 0, &system, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_add_groups(system, groups));
    for (k = 0; k < 3; ++k) {
        EXPECT(NUTATE_OK, nutate_stepper_create(system, &each[k], NULL, 0));
        EXPECT(NUTATE_OK, nutate_stepper_set(each[k], "time_step", "0.03"));
        EXPECT(NUTATE_OK, nutate_stepper_set_state(each[k], 0.0, one, spin));
        EXPECT(NUTATE_OK, nutate_stepper_add_events(each[k], k < 2 ? events : "&event name = 'other', when = 'q0', crosses = 0 /"));
    }
    for (i = 0; i < 40; ++i) {
        EXPECT(NUTATE_OK, nutate_stepper_run(each[i % 2], 5, 5, NULL, 0, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_save(each[i % 2], bytes, sizeof bytes, &needed));
        EXPECT(NUTATE_OK, nutate_stepper_restore(each[1 - i % 2], bytes, needed));
        for (k = 0; k < 2; ++k) {
            EXPECT(NUTATE_OK, nutate_stepper_event_count(each[k], &n[k]));
            if (n[k] > 0) EXPECT(NUTATE_OK, nutate_stepper_event(each[k], n[k] - 1, NULL, 0, &number[k], &t[k], NULL, NULL));
        }
        CHECK(n[0] == n[1]);
        if (n[0] > 0) CHECK(number[0] == number[1] && t[0] == t[1]);
        found += n[0];
    }
    CHECK(found > 4);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_restore(each[2], bytes, needed));
    /* All that in one stepper. */
    EXPECT(NUTATE_OK, nutate_stepper_add_events(each[2], events));
    for (i = 0; i < 40; ++i) EXPECT(NUTATE_OK, nutate_stepper_run(each[2], 5, 5, NULL, 0, NULL));
    for (k = 0; k < 3; ++k) {
        EXPECT(NUTATE_OK, nutate_stepper_angular_velocity(each[k], omega[k]));
        EXPECT(NUTATE_OK, nutate_stepper_energy(each[k], energy[k]));
        CHECK(memcmp(omega[0], omega[k], sizeof omega[0]) == 0 && memcmp(energy[0], energy[k], sizeof energy[0]) == 0);
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&each[k]));
    }
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    return 0;
}

/* What no scene could say, and what callbacks do wrong: the state is then that before the run. */
int test_c_events_refused(void)
{
    struct answer answer = {0.0, 4, 0, 3, 0.0};
    nutate_stepper *stepper = NULL;
    double t, q[4];
    size_t n;
    int k, line = make_tumbling("nielsen_krenk", "0.1", &stepper);
    CHECK(line == 0);
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_add_events(NULL, "&event when = 'q0', crosses = 0 /"));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_add_event(NULL, bad_quantity, &answer, "&event name = 'a', crosses = 0 /"));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_event_count(NULL, &n));
    EXPECT(NUTATE_BAD_HANDLE, nutate_history_event_count(NULL, &n));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_event(NULL, 0, NULL, 0, NULL, NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_history_event(NULL, 0, NULL, 0, NULL, NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_event_count(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_add_events(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_add_event(stepper, NULL, NULL, "&event name = 'a', crosses = 0 /"));
    EXPECT(NUTATE_BAD_SCENE, nutate_stepper_add_events(stepper, "&event when = 'q9', crosses = 0 /"));
    EXPECT(NUTATE_BAD_SCENE, nutate_stepper_add_events(stepper, "&event crosses = 0 /"));
    EXPECT(NUTATE_BAD_SCENE, nutate_stepper_add_events(stepper, "&gravity /"));
    EXPECT(NUTATE_BAD_SCENE, nutate_stepper_add_event(stepper, bad_quantity, &answer, "&event crosses = 0 /"));
    EXPECT(NUTATE_BAD_SCENE, nutate_stepper_add_event(stepper, bad_quantity, &answer, ""));
    EXPECT(NUTATE_BAD_SCENE, nutate_stepper_add_event(stepper, bad_quantity, &answer, "&event when = 'q0', name = 'a', crosses = 0 /"));
    EXPECT(NUTATE_OK, nutate_stepper_add_event(stepper, bad_quantity, &answer, "&event name = 'a', crosses = 0 /"));
    for (k = 0; k < 2; ++k) {
        answer.calls = 0;
        answer.returned = k == 0 ? 3 : 0;
        answer.value = k == 0 ? 0.0 : HUGE_VAL;
        EXPECT(k == 0 ? NUTATE_CALLBACK : NUTATE_NOT_FINITE, nutate_stepper_run_to(stepper, 2.0, 1, 0.0, NULL, 0, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_time(stepper, &t));
        EXPECT(NUTATE_OK, nutate_stepper_quaternion(stepper, q));
        CHECK(t == 0.0 && q[0] == 1.0);
        EXPECT(NUTATE_OK, nutate_stepper_event_count(stepper, &n));
        CHECK(n == 0);
    }
    answer.from_call = 1000000;
    EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, 2.0, 1, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    return 0;
}

/* A table in memory is that of a torque in pieces; what is none is refused. */
int test_c_table(void)
{
    static const double t[3] = {0.0, 0.25, 1.0}, line[9] = {0, 0, 17, 0, 0, 17, 0, 0, 17},
                        back[3] = {0.0, 1.0, 0.5}, rest[3] = {0.0, 0.0, 0.0};
    nutate_system *system = NULL;
    nutate_stepper *stepper = NULL;
    double omega[3];
    char message[200];
    EXPECT(NUTATE_OK, nutate_system_create_moments(moments, 0.0, NULL, 0, &system, NULL, 0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_table(NULL, 3, t, line, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_table(system, 3, NULL, line, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_table(system, 3, t, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_table(system, 0, t, line, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_table(system, 3, back, line, NULL));
    EXPECT(NUTATE_OK, nutate_last_message(system, message, sizeof message));
    CHECK(strstr(message, "line 3 of the table: the time decreases"));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_add_table(system, 3, t, line, "frequency = 1"));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_add_table(system, 3, t, line, "/ &gravity"));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_add_table(system, 3, t, line, "interpolation = 'quartic'"));
    EXPECT(NUTATE_OK, nutate_system_add_table(system, 3, t, line, "interpolation = 'cubic', axes = 'body'"));
    EXPECT(NUTATE_OK, nutate_stepper_create(system, &stepper, NULL, 0));
    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "time_step", "0.3"));
    EXPECT(NUTATE_OK, nutate_stepper_set_state(stepper, 0.0, one, rest));
    EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, 2.0, 1, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_angular_velocity(stepper, omega));
    CHECK(fabs(omega[2] - 1.0) < 1e-14);
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    return 0;
}
