/* Satellites of C programs: frames, orbits, wheels, controllers. Each function returns 0, or the line of the first check that
 * fails. */
#include "test_c_support.h"
#include <stdio.h>

int test_c_satellites_batches(void);
int test_c_satellites_by_functions(void);
int test_c_satellites_motor(void);
int test_c_satellites_reading(void);
int test_c_satellites_refused(void);

static const char *const methods[] = {"method = 'nielsen_krenk', order = 4", "formulation = 'reduced'", "method = 'taylor'",
                                      "method = 'dop853', conserve = .true.", "method = 'rk8'"};

/* Every new kind of effect and of state, each with an event but for the last. */
static const char *const scenes[] = {
    "&body inertia = 90, 100, 40 / &orbit altitude = 500e3 / &gravity_gradient /\n"
    "&initial roll_pitch_yaw = 5, -8, 10, angular_velocity = 3*0, attitude_from = 'lvlh', rate_from = 'lvlh',\n"
    "degrees = .true. / &event when = 'roll', crosses = 0 / &event when = 'omega2', extremum = 'both' /\n"
    "&output every = 7, columns = 'quaternion', 'lvlh_attitude', 'orbit', 'angular_velocity', 'energy', 'jacobi' /\n"
    "&integrator time_step = 40, end_time = 8400, ",
    "&body inertia = 90, 100, 40 / &orbit semi_major_axis = 1e7, eccentricity = 0.3, inclination = 1, raan = 0.5 /\n"
    "&gravity_gradient / &initial angular_velocity = 1e-3, -5e-4, 8e-4 / &damping coefficient = 1e-3, 0, 2e-3 /\n"
    "&event when = 'true_anomaly', crosses = 1 / &event when = 'orbit_radius', extremum = 'both' /\n"
    "&output every = 7, columns = 'quaternion', 'conjugate_momentum', 'orbit', 'energy', 'time_dependent_work' /\n"
    "&integrator time_step = 40, end_time = 8400, ",
    "&body inertia = 90, 100, 40 / &initial angular_velocity = 0.02, -0.01, 0.03 / &rotating_frame rate = 0.01, 0, 0.02 /\n"
    "&wheel axis = 1, 2, 2, inertia = 0.05, torque = 0.2, start = 1.03, stop = 7.7, friction = 1e-3, speed_limit = 15 /\n"
    "&wheel axis = 1, 0, 0, inertia = 0.05, speed = 100, friction = 2e-3 / &event when = 'wheel2_speed', crosses = 90 /\n"
    "&output every = 7, columns = 'quaternion', 'angular_velocity', 'energy', 'wheel1', 'wheel2' /\n"
    "&integrator time_step = 0.1, end_time = 21, ",
    "&body inertia = 90, 100, 40 / &initial angular_velocity = 0.02, -0.01, 0.03, axis = 1, 1, 0, angle = 0.5 /\n"
    "&wheel axis = 1, 0, 0, inertia = 0.05, torque_limit = 0.4, speed_limit = 20 / &wheel axis = 0, 1, 0, inertia = 0.05 /\n"
    "&wheel axis = 0, 0, 1, inertia = 0.05, friction = 1e-4 /\n"
    "&controller law = 'quaternion', by = 'wheels', attitude_gain = 0.01, rate_gain = 0.12, sample = 0.37 /\n"
    "&event when = 'q1', crosses = 0.2 /\n"
    "&output every = 7, columns = 'quaternion', 'angular_velocity', 'energy', 'wheel1', 'wheel3' /\n"
    "&integrator time_step = 0.1, end_time = 21, ",
    "&body inertia = 0.02, 0.03, 0.04 / &initial angular_velocity = 0.2, -0.1, 0.3 / &orbit altitude = 500e3 /\n"
    "&controller law = 'bdot', gain = 1e4, field = 2e-5, 1e-5, -3e-5, sample = 1.5, limit = 0.1 / &gravity_gradient /\n"
    "&output every = 7, columns = 'quaternion', 'angular_velocity', 'energy' /\n"
    "&integrator time_step = 0.5, end_time = 105, ",
    "&body inertia = 40, 90, 100 / &orbit periapsis_distance = 7e6, periapsis_time = 4000, eccentricity = 1.5, inclination = 1 /\n"
    "&gravity_gradient / &third_degree points = 100, 1, 0, 0, 50, 0, 2, 0, 30, 0, -1, 3 / &initial tumbling = 'sam',\n"
    "energy_ratio = 1.05, precession_period = 5000, period_axis = 'short', pole = 1, 0.5 /\n"
    "&event when = 'energy_ratio', extremum = 'both' / &event when = 'orbit_radius', extremum = 'both' /\n"
    "&output every = 7, columns = 'quaternion', 'tumbling', 'orbit', 'energy', 'time_dependent_work' /\n"
    "&integrator time_step = 40, end_time = 8400, "};

#define MOST_ROWS 40
#define MOST_WIDTH 40

static int count_events(const nutate_history *history, nutate_stepper *stepper, size_t *n, double last[7])
{
    EXPECT(NUTATE_OK, history ? nutate_history_event_count(history, n) : nutate_stepper_event_count(stepper, n));
    memset(last, 0, 7 * sizeof(double));
    if (*n == 0) return 0;
    EXPECT(NUTATE_OK, history ? nutate_history_event(history, *n - 1, NULL, 0, NULL, last, last, last + 4)
                              : nutate_stepper_event(stepper, *n - 1, NULL, 0, NULL, last, last, last + 4));
    return 0;
}

/* A scene as a whole, and by steppers in batches of one row each, saved and restored into the other one after each. */
static int compare_batches(const char *text)
{
    nutate_scene *scene = NULL;
    nutate_history *history = NULL;
    nutate_stepper *each[2] = {NULL, NULL};
    static double whole[MOST_ROWS * MOST_WIDTH], batches[MOST_ROWS * MOST_WIDTH];
    static char bytes[60000];
    double time_step, end_time, last[7], found_last[7];
    size_t rows, columns, needed, n, found = 0, i;
    int64_t every;
    int line;
    EXPECT(NUTATE_OK, nutate_scene_parse(text, NULL, NULL, 0, &scene, NULL, 0));
    EXPECT(NUTATE_OK, nutate_scene_run(scene, &history, NULL, 0));
    EXPECT(NUTATE_OK, nutate_scene_get_plan(scene, &time_step, &end_time, &every));
    EXPECT(NUTATE_OK, nutate_history_size(history, &rows, &columns));
    CHECK(rows > 25 && rows <= MOST_ROWS && columns <= MOST_WIDTH);
    EXPECT(NUTATE_OK, nutate_history_values(history, whole, MOST_ROWS * MOST_WIDTH));
    for (i = 0; i < 2; ++i) EXPECT(NUTATE_OK, nutate_stepper_create_scene(scene, &each[i], NULL, 0));
    EXPECT(NUTATE_OK, nutate_stepper_row(each[0], batches, columns));
    for (i = 1; i < rows; ++i) {
        nutate_stepper *here = each[(i / 3) % 2], *there = each[1 - (i / 3) % 2];
        EXPECT(NUTATE_OK, nutate_stepper_run(here, every, every, batches + i * columns, 1, NULL));
        line = count_events(NULL, here, &n, last);
        CHECK(line == 0);
        if (n > 0) memcpy(found_last, last, sizeof last);
        found += n;
        if (i % 3 != 2) continue;
        EXPECT(NUTATE_OK, nutate_stepper_save(here, bytes, sizeof bytes, &needed));
        EXPECT(NUTATE_OK, nutate_stepper_restore(there, bytes, needed));
    }
    for (i = 0; i < rows * columns; ++i) CHECK(whole[i] == batches[i]);
    line = count_events(history, NULL, &n, last);
    CHECK(line == 0);
    CHECK(n == found && (n == 0 || memcmp(last, found_last, sizeof last) == 0));
    for (i = 0; i < 2; ++i) EXPECT(NUTATE_OK, nutate_stepper_destroy(&each[i]));
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    return 0;
}

/* The bits are those of the whole run, with events, wheels at limits and controllers between samples, and so are the events. */
int test_c_satellites_batches(void)
{
    char text[2000];
    size_t i, k;
    int line;
    for (i = 0; i < sizeof scenes / sizeof *scenes; ++i) {
        for (k = 0; k < sizeof methods / sizeof *methods; ++k) {
            strcpy(text, scenes[i]);
            strcat(text, methods[k]);
            strcat(text, " /\n");
            line = compare_batches(text);
            if (line != 0) return 10000 * (int)(10 * i + k + 1) + line;
        }
    }
    return 0;
}

/* Makes a stepper of a body of moments 90, 100, 40 and what a text or functions add, in a state of its own. */
static int start_stepper(nutate_system *system, nutate_stepper **stepper)
{
    static const double q[4] = {0.8, 0.36, 0.48, 0.0}, omega[3] = {0.02, -0.01, 0.03};
    EXPECT(NUTATE_OK, nutate_stepper_create(system, stepper, NULL, 0));
    EXPECT(NUTATE_OK, nutate_stepper_set(*stepper, "time_step", "0.1"));
    EXPECT(NUTATE_OK, nutate_stepper_set(*stepper, "order", "4"));
    EXPECT(NUTATE_OK, nutate_stepper_set_state(*stepper, 0.0, q, omega));
    return 0;
}

static const double body[3] = {90.0, 100.0, 40.0}, skew[3] = {1.0, 2.0, 2.0}, third[3] = {0.0, 0.0, 1.0},
                    field[3] = {2e-5, 1e-5, -3e-5};

/* Adds by functions what the text number `which` adds by groups. */
static int add_by_functions(nutate_system *system, int which)
{
    static const double rate[3] = {0.01, 0.0, 0.02}, angles[4] = {0.5, 1.0, 0.3, 0.7}, target[4] = {0.6, 0.0, 0.0, 0.8},
                        t[3] = {0.5, 2.0, 3.5}, u[3] = {0.0, 0.3, -0.2};
    switch (which) {
    case 0:
        EXPECT(NUTATE_OK, nutate_system_add_rotating_frame(system, rate));
        EXPECT(NUTATE_OK, nutate_system_add_wheel(system, skew, 0.05, 30.0, 1e-3, 0.5, INFINITY));
        EXPECT(NUTATE_OK, nutate_system_add_motor(system, 1, 0.2, 0.3, 0.1, 0.55, 3.0));
        break;
    case 1:
        EXPECT(NUTATE_OK, nutate_system_add_latitude(system, 0.85));
        EXPECT(NUTATE_OK, nutate_system_add_wheel(system, skew, 0.05, 0.0, 0.0, 0.25, 7.0));
        EXPECT(NUTATE_OK, nutate_system_add_motor_table(system, 1, 3, t, u, "outside = 'zero', start = 0.7"));
        break;
    case 2:
        EXPECT(NUTATE_OK, nutate_system_add_orbit(system, 7e6, 0.1, angles, 0.0, 0));
        EXPECT(NUTATE_OK, nutate_system_add_orbital_gradient(system));
        EXPECT(NUTATE_OK, nutate_system_add_pointing(system, "torque", target, 0.5, 2.0, 0, NULL, 0.25, 1.0));
        break;
    case 3:
        EXPECT(NUTATE_OK, nutate_system_add_orbit(system, 7e6, 0.0, NULL, 4e14, 0));
        EXPECT(NUTATE_OK, nutate_system_add_orbital_gradient(system));
        EXPECT(NUTATE_OK, nutate_system_add_pointing(system, "magnetorquers", NULL, 0.01, 0.1, 1, field, 0.0, INFINITY));
        break;
    case 4:
        EXPECT(NUTATE_OK, nutate_system_add_orbit(system, 7e6, 0.1, angles, 0.0, 0));
        EXPECT(NUTATE_OK, nutate_system_add_earth_field(system, skew, 0.4, field));
        EXPECT(NUTATE_OK, nutate_system_add_force(system, third, field, "lvlh", -INFINITY, INFINITY));
        EXPECT(NUTATE_OK, nutate_system_add_force(system, skew, third, "body", 0.35, 3.0));
        break;
    case 5:
        EXPECT(NUTATE_OK, nutate_system_add_orbit(system, 7e6, 0.0, NULL, 0.0, 0));
        EXPECT(NUTATE_OK, nutate_system_add_earth_field(system, NULL, 0.0, NULL));
        EXPECT(NUTATE_OK, nutate_system_add_force(system, skew, third, "space", -INFINITY, INFINITY));
        EXPECT(NUTATE_OK, nutate_system_add_detumbling(system, 1e6, NULL, 0.5, 10.0));
        break;
    default:
        EXPECT(NUTATE_OK, nutate_system_add_orbit(system, 7e6, 0.0, NULL, 0.0, 1));
        EXPECT(NUTATE_OK, nutate_system_add_detumbling(system, 1e6, field, 0.5, 10.0));
    }
    return 0;
}

int test_c_satellites_by_functions(void)
{
    static const char *const groups[] = {
        "&rotating_frame rate = 0.01, 0, 0.02 / &wheel axis = 1, 2, 2, inertia = 0.05, speed = 30, friction = 1e-3, "
        "torque_limit = 0.5, torque = 0.2, frequency = 0.3, phase = 0.1, start = 0.55, stop = 3 /",
        NULL, "&orbit semi_major_axis = 7e6, eccentricity = 0.1, inclination = 0.5, raan = 1, argument_of_periapsis = 0.3, "
        "mean_anomaly = 0.7 / &gravity_gradient / &controller law = 'quaternion', by = 'torque', gains = 'scalar', "
        "target = 0.6, 0, 0, 0.8, attitude_gain = 0.5, rate_gain = 2, sample = 0.25, limit = 1 /",
        "&orbit semi_major_axis = 7e6, mu = 4e14, frame = 'lvlh' / &gravity_gradient / &controller law = 'quaternion', by = 'magnetorquers', "
        "attitude_gain = 0.01, rate_gain = 0.1, field = 2e-5, 1e-5, -3e-5 /",
        "&orbit semi_major_axis = 7e6, eccentricity = 0.1, inclination = 0.5, raan = 1, argument_of_periapsis = 0.3, "
        "mean_anomaly = 0.7 / &earth_field moment = 1, 2, 2, epoch_angle = 0.4, coefficients = 2e-5, 1e-5, -3e-5 / "
        "&force body_point = 0, 0, 1, force = 2e-5, 1e-5, -3e-5, axes = 'lvlh' / "
        "&force body_point = 1, 2, 2, force = 0, 0, 1, axes = 'body', start = 0.35, stop = 3 /",
        "&orbit semi_major_axis = 7e6, frame = 'lvlh' / &earth_field / &force body_point = 1, 2, 2, force = 0, 0, 1, axes = 'space' / "
        "&controller law = 'bdot', gain = 1e6, sample = 0.5, limit = 10 /",
        "&orbit semi_major_axis = 7e6, frame = 'inertial' / "
        "&controller law = 'bdot', gain = 1e6, field = 2e-5, 1e-5, -3e-5, sample = 0.5, limit = 10 /"};
    /* The table by its lines: cut off at 0.25, nothing before 0.7. */
    static const char table[] = "&rotating_frame latitude = 0.85 / &wheel axis = 1, 2, 2, inertia = 0.05, torque_limit = 0.25, "
                                "speed_limit = 7, table = 'motor_table_of_a_test.csv', start = 0.7 /";
    nutate_system *system = NULL;
    nutate_stepper *stepper = NULL;
    double rows[2][17 * 50];
    size_t n_rows[2];
    FILE *file;
    int i, k, line;
    file = fopen("motor_table_of_a_test.csv", "w");
    CHECK(file);
    CHECK(fputs("t (s),u (N m)\n0.5,0\n2,0.3\n3.5,-0.2\n", file) >= 0 && fclose(file) == 0);
    for (i = 0; i < 7; ++i) {
        for (k = 0; k < 2; ++k) {
            EXPECT(NUTATE_OK, nutate_system_create_moments(body, 0.0, NULL, 0, &system, NULL, 0));
            line = 0;
            if (k == 0) line = add_by_functions(system, i);
            else EXPECT(NUTATE_OK, nutate_system_add_groups(system, groups[i] ? groups[i] : table));
            CHECK(line == 0);
            line = start_stepper(system, &stepper);
            CHECK(line == 0);
            EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 40, 1, rows[k], 50, &n_rows[k]));
            EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
            EXPECT(NUTATE_OK, nutate_system_destroy(&system));
        }
        CHECK(n_rows[0] == 40 && n_rows[1] == 40);
        if (memcmp(rows[0], rows[1], 40 * 15 * sizeof(double)) != 0) return 10000 * (i + 1) + __LINE__;
    }
    CHECK(remove("motor_table_of_a_test.csv") == 0);
    return 0;
}

/* Torques that the program sets between runs are those of a table with jumps, whether it steps by hand, runs, looks for
 * events, or goes on in another stepper; they are gone when a state is set. */
int test_c_satellites_motor(void)
{
    static const double t[6] = {0.0, 1.0, 1.0, 2.0, 2.0, 3.0}, u[6] = {0.2, 0.2, -0.3, -0.3, 0.1, 0.1}, torques[3] = {0.2, -0.3, 0.1};
    nutate_system *system = NULL;
    nutate_stepper *table = NULL, *each[4] = {NULL, NULL, NULL, NULL}, *other = NULL;
    double speed[2], momentum[2], work[2][2], energy[5], omega[2][3];
    char bytes[20000];
    size_t needed, n;
    int i, k, line;
    EXPECT(NUTATE_OK, nutate_system_create_moments(body, 0.0, NULL, 0, &system, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_add_wheel(system, skew, 0.05, 30.0, 1e-3, INFINITY, INFINITY));
    for (k = 0; k < 4; ++k) {
        line = start_stepper(system, &each[k]);
        CHECK(line == 0);
    }
    EXPECT(NUTATE_OK, nutate_stepper_add_events(each[2], "&event when = 'wheel1_speed', crosses = 31 /"));
    line = start_stepper(system, &other);
    CHECK(line == 0);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_motor_table(system, 1, (size_t)-1, t, u, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_motor_table(system, 1, (size_t)1 << 40, t, u, NULL));
    EXPECT(NUTATE_OK, nutate_system_add_motor_table(system, 1, 6, t, u, NULL));
    line = start_stepper(system, &table);
    CHECK(line == 0);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_motor(table, 1, 0.1));
    EXPECT(NUTATE_OK, nutate_stepper_run(table, 30, 1, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_wheel(table, 1, &speed[0], &momentum[0], work[0]));
    EXPECT(NUTATE_OK, nutate_stepper_angular_velocity(table, omega[0]));
    for (k = 0; k < 4; ++k) {
        for (i = 0; i < 3; ++i) {
            EXPECT(NUTATE_OK, nutate_stepper_set_motor(each[k], 1, torques[i]));
            if (k == 0) EXPECT(NUTATE_OK, nutate_stepper_steps(each[k], 0.1, 10, NULL));
            else EXPECT(NUTATE_OK, nutate_stepper_run(each[k], 5, 1, NULL, 0, NULL));
            if (k == 2) {
                EXPECT(NUTATE_OK, nutate_stepper_event_count(each[k], &n));
                CHECK(n == (i < 2 ? 1 : 0));
            }
            if (k == 3) {
                EXPECT(NUTATE_OK, nutate_stepper_save(each[k], bytes, sizeof bytes, &needed));
                EXPECT(NUTATE_OK, nutate_stepper_restore(other, bytes, needed));
                EXPECT(NUTATE_OK, nutate_stepper_run(other, 5, 1, NULL, 0, NULL));
                EXPECT(NUTATE_OK, nutate_stepper_save(other, bytes, sizeof bytes, &needed));
                EXPECT(NUTATE_OK, nutate_stepper_restore(each[k], bytes, needed));
            } else if (k > 0) EXPECT(NUTATE_OK, nutate_stepper_run(each[k], 5, 1, NULL, 0, NULL));
        }
        EXPECT(NUTATE_OK, nutate_stepper_wheel(each[k], 1, &speed[1], &momentum[1], work[1]));
        EXPECT(NUTATE_OK, nutate_stepper_angular_velocity(each[k], omega[1]));
        CHECK(fabs(speed[1] - speed[0]) < 1e-12 && fabs(momentum[1] - momentum[0]) < 1e-14);
        for (i = 0; i < 2; ++i) CHECK(fabs(work[1][i] - work[0][i]) < 1e-12 && fabs(work[0][i]) > 0.05);
        for (i = 0; i < 3; ++i) CHECK(fabs(omega[1][i] - omega[0][i]) < 1e-15);
        EXPECT(NUTATE_OK, nutate_stepper_energy(each[k], energy));
        CHECK(fabs(energy[4]) < 1e-13 && fabs(energy[3] - work[1][0] - work[1][1]) < 1e-13);
        EXPECT(NUTATE_OK, nutate_stepper_set_state(each[k], 0.0, one, third));
        EXPECT(NUTATE_OK, nutate_stepper_run(each[k], 20, 1, NULL, 0, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_wheel(each[k], 1, NULL, NULL, work[1]));
        CHECK(work[1][0] == 0.0 && work[1][1] < 0.0);
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&each[k]));
    }
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&table));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&other));
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    return 0;
}

/* What functions read is what columns show. */
int test_c_satellites_reading(void)
{
    static const char *const frames[] = {"&rotating_frame rate = 0.01, 0, 0.02 /",
                                         "&orbit semi_major_axis = 7e6, frame = 'lvlh' / &gravity_gradient /",
                                         "&orbit semi_major_axis = 1e7, eccentricity = 0.3 / &gravity_gradient /",
                                         "&orbit name = 'a', periapsis_distance = 7e6, periapsis_time = 60, eccentricity = 2 /\n"
                                         "&orbit name = 'b', mu = 1.3e20, semi_major_axis = 1.5e11, frame = 'inertial' /\n"
                                         "&gravity_gradient / &third_degree third_moments = 1, 2, -1, 0, 0.5, 4*0, 1 /"};
    nutate_system *system = NULL;
    nutate_stepper *stepper = NULL;
    double row[24], speed, momentum, work[2], moving, jacobi, position[3], anomaly, q[4], angles[3], energy[5];
    size_t n;
    int i, k, line;
    for (k = 0; k < 4; ++k) {
        EXPECT(NUTATE_OK, nutate_system_create_moments(body, 0.0, NULL, 0, &system, NULL, 0));
        EXPECT(NUTATE_OK, nutate_system_add_groups(system, frames[k]));
        EXPECT(NUTATE_OK, nutate_system_add_wheel(system, third, 0.05, 30.0, 1e-3, INFINITY, INFINITY));
        EXPECT(NUTATE_OK, nutate_system_add_motor(system, 1, 0.2, 0.0, 0.0, -INFINITY, INFINITY));
        line = start_stepper(system, &stepper);
        CHECK(line == 0);
        EXPECT(NUTATE_OK, nutate_stepper_set_columns(stepper, k == 0 ? "jacobi,wheel1,time_dependent_work,energy"
                                                                     : "jacobi,wheel1,time_dependent_work,energy,orbit,lvlh_attitude"));
        EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "time_step", "10"));
        EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 20, 1, NULL, 0, NULL));
        EXPECT(NUTATE_OK, nutate_stepper_row(stepper, row, 24));
        EXPECT(NUTATE_OK, nutate_stepper_wheel_count(stepper, &n));
        CHECK(n == 1);
        EXPECT(NUTATE_OK, nutate_stepper_wheel(stepper, 1, &speed, &momentum, work));
        EXPECT(NUTATE_OK, nutate_stepper_jacobi(stepper, &jacobi));
        EXPECT(NUTATE_OK, nutate_stepper_time_dependent_work(stepper, &moving));
        EXPECT(NUTATE_OK, nutate_stepper_energy(stepper, energy));
        EXPECT(k == 0 ? NUTATE_BAD_ARGUMENT : NUTATE_OK, nutate_stepper_orbit(stepper, position, &anomaly));
        EXPECT(k == 0 ? NUTATE_BAD_ARGUMENT : NUTATE_OK, nutate_stepper_lvlh_attitude(stepper, q, angles));
        /* t, energy, jacobi, lvlh_attitude, orbit, time_dependent_work, wheel1 */
        for (i = 0; i < 5; ++i) CHECK(row[1 + i] == energy[i]);
        CHECK(fabs(energy[4]) < 1e-10 && row[6] == jacobi);
        if (k > 0) {
            for (i = 0; i < 3; ++i) CHECK(row[7 + i] == angles[i] && row[14 + i] == position[i]);
            for (i = 0; i < 4; ++i) CHECK(row[10 + i] == q[i]);
            CHECK(row[18] == anomaly);
        }
        n = k == 0 ? 7 : 19;
        CHECK(row[n] == moving && row[n + 1] == speed && row[n + 2] == momentum && row[n + 3] == work[0] && row[n + 4] == work[1]);
        CHECK((fabs(moving) > 0.0) == (k >= 2) && speed > 100.0 && work[0] > 0.0 && work[1] < 0.0);
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
        EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    }
    return 0;
}

/* Stores the first rate that a callback receives. */
struct seen {
    int calls;
    double omega[3];
};

static int see_torque(double t, const double q[4], const double omega[3], void *user, double tau[3])
{
    struct seen *seen = user;
    (void)t, (void)q;
    if (seen->calls++ == 0) memcpy(seen->omega, omega, sizeof seen->omega);
    tau[0] = tau[1] = tau[2] = 0.0;
    return 0;
}

static int see_event(double t, const double q[4], const double omega[3], void *user, double *g)
{
    double unused[3];
    *g = 1.0;
    return see_torque(t, q, omega, user, unused);
}

/* Torques, events and steppers have the absolute rate: a body at rest in rotating axes has theirs. */
int test_c_satellites_rates(void)
{
    static const char *const frames[] = {"&rotating_frame rate = 0, -0.02, 0 /",
                                         "&orbit semi_major_axis = 7e6, frame = 'lvlh' / &gravity_gradient /"};
    static const double q[4] = {1.0, 0.0, 0.0, 0.0};
    struct seen torque, event;
    nutate_system *system = NULL;
    nutate_stepper *stepper = NULL;
    double rate[3], omega[3];
    int i, k;
    for (k = 0; k < 2; ++k) {
        torque.calls = event.calls = 0;
        EXPECT(NUTATE_OK, nutate_system_create_moments(body, 0.0, NULL, 0, &system, NULL, 0));
        EXPECT(NUTATE_OK, nutate_system_add_user_torque(system, see_torque, &torque));
        EXPECT(NUTATE_OK, nutate_system_add_groups(system, frames[k]));
        EXPECT(NUTATE_OK, nutate_system_frame_rate(system, rate));
        CHECK(rate[1] < -1e-3);
        EXPECT(NUTATE_OK, nutate_stepper_create(system, &stepper, NULL, 0));
        EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "method", "rk4"));
        EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "time_step", "1"));
        EXPECT(NUTATE_OK, nutate_stepper_add_event(stepper, see_event, &event, "&event name = 'none', crosses = 0 /"));
        EXPECT(NUTATE_OK, nutate_stepper_set_state(stepper, 0.0, q, rate));
        EXPECT(NUTATE_OK, nutate_stepper_angular_velocity(stepper, omega));
        EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, 1.0, 1, 0.0, NULL, 0, NULL));
        CHECK(torque.calls > 0 && event.calls > 0);
        for (i = 0; i < 3; ++i) {
            CHECK(fabs(omega[i] - rate[i]) < 1e-17);
            CHECK(fabs(torque.omega[i] - rate[i]) < 1e-17);
            CHECK(fabs(event.omega[i] - rate[i]) < 1e-17);
        }
        EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
        EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    }
    return 0;
}

/* Null pointers, wheels that there are not, frames beside frames, what only runs watch over. */
int test_c_satellites_refused(void)
{
    static const double times[2] = {0.0, 1.0};
    nutate_system *system = NULL, *none = NULL;
    nutate_stepper *stepper = NULL;
    double number, three[3], q[4];
    size_t n;
    char message[200];
    int line;
    EXPECT(NUTATE_OK, nutate_system_create_moments(body, 0.0, NULL, 0, &system, NULL, 0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_rotating_frame(none, third));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_latitude(none, 0.5));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_earth_field(none, third, 0.0, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_force(none, third, third, "space", 0.0, 1.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_earth_field(system, third, 0.0, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_force(system, NULL, third, "space", 0.0, 1.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_force(system, third, NULL, "space", 0.0, 1.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_force(system, third, third, NULL, 0.0, 1.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_force(system, third, third, "lvlh", 0.0, 1.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_force(system, third, third, "space", 1.0, 1.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_force(system, third, third, "space", NAN, 1.0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_orbit(none, 7e6, 0.0, NULL, 0.0, 0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_orbital_gradient(none));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_wheel(none, third, 1.0, 0.0, 0.0, INFINITY, INFINITY));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_wheel_count(none, &n));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_motor(none, 1, 1.0, 0.0, 0.0, 0.0, 1.0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_motor_table(none, 1, 2, times, times, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_pointing(none, "torque", NULL, 1.0, 1.0, 1, NULL, 0.0, INFINITY));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_detumbling(none, 1.0, field, 0.0, INFINITY));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_wheel_count(stepper, &n));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_wheel(stepper, 1, NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_sphere_count(stepper, &n));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_sphere(stepper, 1, NULL, NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_set_motor(stepper, 1, 0.0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_jacobi(stepper, &number));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_time_dependent_work(stepper, &number));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_orbit(stepper, three, &number));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_lvlh_attitude(stepper, q, three));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_rotating_frame(system, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_latitude(system, 2.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_orbital_gradient(system));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_orbit(system, 7e6, 1.0, NULL, 0.0, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_orbit(system, 7e6, 0.0, NULL, -1.0, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_orbit(system, NAN, 0.0, NULL, 0.0, 0));
    EXPECT(NUTATE_OK, nutate_system_add_rotating_frame(system, third));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_rotating_frame(system, third));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_latitude(system, 0.5));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_orbit(system, 7e6, 0.0, NULL, 0.0, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_wheel(system, NULL, 1.0, 0.0, 0.0, INFINITY, INFINITY));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_wheel(system, third, -1.0, 0.0, 0.0, INFINITY, INFINITY));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_wheel(system, third, 1.0, 8.0, 0.0, INFINITY, 7.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_wheel(system, third, 1.0, 0.0, 0.0, NAN, INFINITY));
    EXPECT(NUTATE_BAD_BODY, nutate_system_add_wheel(system, third, 41.0, 0.0, 0.0, INFINITY, INFINITY));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_pointing(system, "wheels", NULL, 1.0, 1.0, 1, NULL, 0.5, INFINITY));
    EXPECT(NUTATE_OK, nutate_system_add_wheel(system, third, 1.0, 0.0, 0.0, 5.0, 70.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_wheel_count(system, NULL));
    EXPECT(NUTATE_OK, nutate_system_wheel_count(system, &n));
    CHECK(n == 1);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_motor(system, 0, 1.0, 0.0, 0.0, 0.0, 1.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_motor(system, 2, 1.0, 0.0, 0.0, 0.0, 1.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_motor(system, 1, 6.0, 0.0, 0.0, 0.0, 1.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_motor(system, 1, 1.0, 0.0, 0.0, 1.0, 0.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_motor(system, 1, 1.0, 0.1, 0.0, 0.0, 1.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_motor_table(system, 1, 2, NULL, times, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_motor_table(system, 1, 0, times, times, NULL));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_add_motor_table(system, 1, 2, times, times, "torque = 1"));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_add_motor_table(system, 1, 2, times, times, "/ &gravity"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_pointing(system, NULL, NULL, 1.0, 1.0, 1, NULL, 0.0, INFINITY));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_pointing(system, "wishes", NULL, 1.0, 1.0, 1, NULL, 0.0, INFINITY));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_pointing(system, "torque", NULL, 1.0, 1.0, 1, field, 0.0, INFINITY));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_detumbling(system, 1.0, NULL, 0.0, INFINITY));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_detumbling(system, 1.0, field, 0.0, -1.0));
    line = start_stepper(system, &stepper);
    CHECK(line == 0);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_step(stepper, 0.1));
    EXPECT(NUTATE_OK, nutate_last_message(stepper, message, sizeof message));
    CHECK(strstr(message, "nutate_stepper_run"));
    EXPECT(NUTATE_OK, nutate_stepper_keep_steps(stepper));
    EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 2, 1, NULL, 0, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_state_at(stepper, 0.15, q, three));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_wheel(stepper, 0, NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_wheel(stepper, 2, NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_sphere(stepper, 1, NULL, NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_sphere_count(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_motor(stepper, 2, 0.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_motor(stepper, 1, 5.5));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_motor(stepper, 1, NAN));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_jacobi(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_time_dependent_work(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_wheel_count(stepper, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    EXPECT(NUTATE_OK, nutate_system_add_pointing(system, "wheels", NULL, 1.0, 1.0, 1, NULL, 0.5, INFINITY));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_motor(system, 1, 1.0, 0.0, 0.0, 0.0, 1.0));
    line = start_stepper(system, &stepper);
    CHECK(line == 0);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_motor(stepper, 1, 0.1));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    return 0;
}
