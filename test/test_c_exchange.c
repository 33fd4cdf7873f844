/* The C interface: calendar time, and attitudes for other programs. Each function returns 0, or the line of the first check
 * that fails. */
#include "test_c_support.h"
#include <stdio.h>

int test_c_exchange_calendar(void);
int test_c_exchange_files(void);
int test_c_exchange_refused(void);

static const char labelled[] =
    "&scene epoch = '2016-12-31T23:59:59.5', time_system = 'UTC', object = 'it''s', space_frame = 'ICRF' /\n"
    "&body inertia = 5, 20, 17 / &initial angular_velocity = 0.1, 0, 10 /\n"
    "&integrator time_step = 0.01, end_time = 1 /\n";
static const char facts[] =
    "&scene epoch = '2016-12-31T23:59:59.5', time_system = 'UTC', object = 'it''s', space_frame = 'ICRF' /\n"
    "&body shape = 'box', size = 1, 2, 3, mass = 1 /\n";
static const double t[3] = {0.0, 0.25, 1.5},
                    q[12] = {1, 0, 0, 0, 0.8, 0, 0.6, 0, 0.6, 0, 0, 0.8}, omega[9] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};

/* Dates of a scene, and of any epoch. */
int test_c_exchange_calendar(void)
{
    nutate_scene *scene = NULL;
    nutate_system *system = NULL;
    char text[64];
    double tdb[3], rate[3];
    EXPECT(NUTATE_OK, make_scene(labelled, &scene));
    EXPECT(NUTATE_OK, nutate_scene_get(scene, "object", text, sizeof text));
    CHECK(strcmp(text, "it's") == 0);
    EXPECT(NUTATE_OK, nutate_scene_get(scene, "epoch", text, sizeof text));
    CHECK(strcmp(text, "2016-12-31T23:59:59.5") == 0);
    EXPECT(NUTATE_OK, nutate_scene_get(scene, "time_system", text, sizeof text));
    CHECK(strcmp(text, "UTC") == 0);
    EXPECT(NUTATE_OK, nutate_scene_get(scene, "body_frame", text, sizeof text));
    CHECK(text[0] == 0);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_get(scene, "colour", text, sizeof text));
    EXPECT(NUTATE_OK, nutate_date("2016-12-31T23:59:59.5", "UTC", 1.25, text, sizeof text));
    CHECK(strcmp(text, "2016-12-31T23:59:60.75") == 0);
    EXPECT(NUTATE_TRUNCATED, nutate_date("2016-12-31T23:59:59.5", "UTC", 1.25, text, 8));
    EXPECT(NUTATE_OK, nutate_tdb("2000-01-01T12:00:01", "TDB", 3, t, tdb));
    CHECK(tdb[0] == 1.0 && tdb[1] == 1.25 && tdb[2] == 2.5);
    EXPECT(NUTATE_OK, nutate_system_parse("&body inertia = 1, 2, 2.5 / &rotating_frame rate = 0, 0, 0.5 /", &system, NULL, 0));
    EXPECT(NUTATE_OK, nutate_system_frame_rate(system, rate));
    CHECK(rate[0] == 0.0 && rate[1] == 0.0 && rate[2] == 0.5);
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    return 0;
}

/* The axes of a circular orbit have an attitude in inertial axes, inertial ones the identity, a rotating frame none; those
 * of a copy are the same. */
int test_c_exchange_axes(void)
{
    static const char *const texts[] = {"&body inertia = 1, 2, 2.5 / &orbit altitude = 5e5, inclination = 97.4, raan = 30, "
                                        "degrees = .true., frame = 'lvlh' /",
                                        "&body inertia = 1, 2, 2.5 / &orbit altitude = 5e5, frame = 'inertial' /",
                                        "&body inertia = 1, 2, 2.5 /", "&body inertia = 1, 2, 2.5 / &rotating_frame latitude = 1 /"};
    static const double expected[4] = {0.693399, 0.226708, -0.669779, 0.138555}, times[2] = {0.0, 100.0}, never = NAN;
    nutate_system *system = NULL, *copy = NULL;
    double axes[8], again[8];
    int i, k;
    for (k = 0; k < 4; ++k) {
        EXPECT(NUTATE_OK, nutate_system_parse(texts[k], &system, NULL, 0));
        EXPECT(k == 3 ? NUTATE_BAD_ARGUMENT : NUTATE_OK, nutate_system_space_axes(system, 2, times, axes));
        for (i = 0; i < 4 && k < 3; ++i) CHECK(fabs(axes[i] - (k == 0 ? expected[i] : i == 0)) < 1e-6);
        for (i = 0; i < 4 && k < 3; ++i) CHECK((fabs(axes[4 + i] - axes[i]) > 1e-3) == (k == 0));
        EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_space_axes(system, 2, NULL, axes));
        EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_space_axes(system, (size_t)-1, times, axes));
        EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_space_axes(system, 1, &never, axes));
        EXPECT(NUTATE_OK, nutate_system_copy(system, &copy, NULL, 0));
        EXPECT(NUTATE_OK, nutate_system_destroy(&system));
        EXPECT(k == 3 ? NUTATE_BAD_ARGUMENT : NUTATE_OK, nutate_system_space_axes(copy, 2, times, again));
        CHECK(k == 3 || !memcmp(axes, again, sizeof axes));
        EXPECT(NUTATE_OK, nutate_system_destroy(&copy));
    }
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_space_axes(system, 2, times, axes));
    return 0;
}

/* What is written as AEM is read back. */
int test_c_exchange_files(void)
{
    nutate_history *history = NULL;
    char text[1000], message[200];
    double values[24];
    size_t rows, columns;
    int i, k;
    EXPECT(NUTATE_OK, nutate_write_aem("c_exchange.aem", facts, 3, t, q, omega, NULL, 0.0, message, sizeof message));
    EXPECT(NUTATE_OK, nutate_read_aem("c_exchange.aem", &history, text, sizeof text, message, sizeof message));
    CHECK(strcmp(text, "&scene epoch = '2016-12-31T23:59:59.5', time_system = 'UTC', object = 'it''s', object_id = 'it''s', "
                       "space_frame = 'ICRF', body_frame = 'SC_BODY_1' /") == 0);
    EXPECT(NUTATE_OK, nutate_history_size(history, &rows, &columns));
    CHECK(rows == 3 && columns == 8);
    EXPECT(NUTATE_OK, nutate_history_values(history, values, 24));
    for (i = 0; i < 3; ++i) {
        CHECK(values[8 * i] == t[i]);
        for (k = 0; k < 4; ++k) CHECK(fabs(values[8 * i + 1 + k] - q[4 * i + k]) < 2 * DBL_EPSILON);
        for (k = 0; k < 3; ++k) CHECK(fabs(values[8 * i + 5 + k] - omega[3 * i + k]) < 4 * DBL_EPSILON);
    }
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_OK, nutate_write_aem("c_exchange.aem", facts, 3, t, q, omega, "1.0", 1e-3, NULL, 0));
    EXPECT(NUTATE_TRUNCATED, nutate_read_aem("c_exchange.aem", &history, text, 8, NULL, 0));
    EXPECT(NUTATE_OK, nutate_history_size(history, &rows, &columns));
    CHECK(rows == 3 && columns == 5);
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    EXPECT(NUTATE_OK, nutate_write_gltf("c_exchange.gltf", facts, 3, t, q, 1.0, message, sizeof message));
    CHECK(remove("c_exchange.aem") == 0 && remove("c_exchange.gltf") == 0);
    return 0;
}

/* What cannot be is refused, with the reason, and leaves no file. */
int test_c_exchange_refused(void)
{
    nutate_history *history = NULL;
    nutate_scene *scene = NULL;
    nutate_system *system = NULL;
    char text[300];
    double x[3];
    const double down[3] = {0.0, 2.0, 1.0}, nan_t[3] = {0.0, NAN, 1.0}, zero[12] = {0};
    const size_t size = sizeof text;
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_get(NULL, "object", text, size));
    EXPECT(NUTATE_OK, make_scene(labelled, &scene));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_get(scene, NULL, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_get(scene, "object", NULL, size));
    EXPECT(NUTATE_OK, nutate_scene_destroy(&scene));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_frame_rate(NULL, x));
    EXPECT(NUTATE_OK, make_box(&system));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_frame_rate(system, NULL));
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_date(NULL, "UTC", 0.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_date("2016-12-31", NULL, 0.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_date("2016-12-31", "UTC", 0.0, NULL, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_date("2016-12-31", "GPS", 0.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_date("2016-12-31", "UTC", NAN, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_date("2016-12-31", "UTC", 1e300, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_tdb("2016-12-31", "UTC", 3, NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_tdb("2016-12-31", "UTC", 3, t, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_tdb("2016-12-31", "UTC", 3, nan_t, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_aem(NULL, facts, 3, t, q, omega, NULL, 0.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_aem("", facts, 3, t, q, omega, NULL, 0.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_aem("never.aem", NULL, 3, t, q, omega, NULL, 0.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_aem("never.aem", facts, 0, t, q, omega, NULL, 0.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_aem("never.aem", facts, (size_t)-1, t, q, omega, NULL, 0.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_aem("never.aem", facts, 3, NULL, q, omega, NULL, 0.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_aem("never.aem", facts, 3, t, NULL, omega, NULL, 0.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_aem("never.aem", facts, 3, down, q, omega, NULL, 0.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_aem("never.aem", facts, 3, nan_t, q, omega, NULL, 0.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_aem("never.aem", facts, 3, t, zero, omega, NULL, 0.0, text, size));
    CHECK(strstr(text, "unit quaternion"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_aem("never.aem", facts, 3, t, q, omega, "3.0", 0.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_aem("never.aem", facts, 3, t, q, omega, NULL, -1.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_aem("never.aem", "", 3, t, q, omega, NULL, 0.0, text, size));
    CHECK(strstr(text, "epoch"));
    EXPECT(NUTATE_BAD_SCENE, nutate_write_aem("never.aem", "&gravity /", 3, t, q, omega, NULL, 0.0, text, size));
    CHECK(strstr(text, "facts:1: "));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_gltf("never.gltf", "&scene /", 3, t, q, 1.0, text, size));
    CHECK(strstr(text, "body"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_write_gltf("never.gltf", facts, 3, t, q, 0.0, text, size));
    EXPECT(NUTATE_IO, nutate_write_gltf("no_folder/never.gltf", facts, 3, t, q, 1.0, text, size));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_read_aem(NULL, &history, text, size, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_read_aem("never.aem", NULL, NULL, 0, text, size));
    EXPECT(NUTATE_IO, nutate_read_aem("never.aem", &history, NULL, 0, text, size));
    CHECK(history == NULL && strstr(text, "never.aem: cannot be read"));
    return 0;
}
