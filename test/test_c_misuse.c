/* Misuse of the C interface, and callbacks, from C. Each function returns 0, or the line of the first check that fails. */
#include "../include/nutate.h"
#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

int test_c_null_handles(void);
int test_c_null_arguments(void);
int test_c_foreign_handles(void);
int test_c_sizes(void);
int test_c_bad_steps(void);
int test_c_bad_numbers(void);
int test_c_unknown_names(void);
int test_c_unprepared(void);
int test_c_bad_callbacks(void);
int test_c_bad_callbacks_in_runs(void);
int test_c_texts(void);
int test_c_attitudes(void);

#define EXPECT(status, call) \
    do { \
        if ((call) != (status)) return __LINE__; \
    } while (0)
#define CHECK(condition) \
    do { \
        if (!(condition)) return __LINE__; \
    } while (0)

static const double one[4] = {1.0, 0.0, 0.0, 0.0}, vector[3] = {0.1, 0.2, 10.0}, moments[3] = {5.0, 20.0, 17.0},
                    tensor[6] = {5.0, 20.0, 17.0, 0.0, 0.0, 0.0};

static const char scene_text[] =
    "&body inertia = 5, 20, 17 / &initial angular_velocity = 0.1, 0, 10 /\n"
    "&integrator time_step = 0.01, end_time = 1 /\n";

static const char accurate_text[] =
    "&body inertia = 5, 20, 17 / &initial angular_velocity = 0.1, 0, 10 /\n"
    "&integrator order = 4, linear_solver = 'reduced', accuracy = 1e-6, end_time = 1 /\n";

/* Returns what `user` says, and gives what it says. */
struct answer {
    double from_time; /* torques answer so from this time on */
    int from_call;    /* potentials from this call on */
    int calls;
    int returned;
    double value;
};

static int answer_torque(double t, const double q[4], const double omega[3], void *user, double tau[3])
{
    struct answer *answer = user;
    (void)q;
    ++answer->calls;
    tau[0] = -0.1 * omega[0];
    tau[1] = tau[2] = 0.0;
    if (t < answer->from_time) return 0;
    tau[1] = answer->value;
    return answer->returned;
}

static int answer_potential(const double gamma[3], void *user, double *energy, double gradient[3])
{
    struct answer *answer = user;
    ++answer->calls;
    *energy = gamma[2];
    gradient[0] = gradient[1] = 0.0;
    gradient[2] = 1.0;
    if (answer->calls < answer->from_call) return 0;
    *energy = answer->value;
    return answer->returned;
}

static int flat_hessian(const double gamma[3], void *user, double hessian[3][3])
{
    (void)gamma;
    (void)user;
    memset(hessian, 0, 9 * sizeof(double));
    return 0;
}

static int make_box(nutate_system **system)
{
    return nutate_system_create_moments(moments, 12.0, NULL, 0, system, NULL, 0);
}

static int make_stepper(nutate_stepper **stepper)
{
    nutate_system *system = NULL;
    int status = make_box(&system);
    if (!status) status = nutate_stepper_create(system, stepper, NULL, 0);
    if (!status) status = nutate_stepper_set_state(*stepper, 0.0, one, vector);
    nutate_system_destroy(&system);
    return status;
}

static int make_scene(const char *text, nutate_scene **scene)
{
    return nutate_scene_parse(text, NULL, NULL, 0, scene, NULL, 0);
}

int test_c_null_handles(void)
{
    char text[64];
    double x[16], r[3][3];
    int i;
    int64_t n;
    size_t size;
    nutate_system *system = NULL;
    nutate_stepper *stepper = NULL;
    nutate_history *history = NULL;

    EXPECT(NUTATE_BAD_HANDLE, nutate_last_message(NULL, text, sizeof text));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_body(NULL, r, x, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_gravity(NULL, vector));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_dipole(NULL, vector, vector));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_gravity_gradient(NULL, vector, 1.0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_spring(NULL, vector, vector, 1.0, 0.0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_damping(NULL, vector));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_torque(NULL, vector, 0, 0.0, 0.0, 0.0, 1.0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_rotor(NULL, vector));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_groups(NULL, "&gravity /"));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_potential(NULL, vector, answer_potential, NULL, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_add_user_torque(NULL, answer_torque, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_get_title(NULL, text, sizeof text));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_get_plan(NULL, x, x, &n));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_get_initial(NULL, x, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_add_potential(NULL, vector, answer_potential, NULL, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_add_user_torque(NULL, answer_torque, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_system(NULL, &system, text, sizeof text));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_run(NULL, &history, text, sizeof text));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_write(NULL, "never.csv", text, sizeof text));
    EXPECT(NUTATE_BAD_HANDLE, nutate_history_size(NULL, &size, &size));
    EXPECT(NUTATE_BAD_HANDLE, nutate_history_name(NULL, 0, text, sizeof text));
    EXPECT(NUTATE_BAD_HANDLE, nutate_history_column(NULL, "t", x, 16));
    EXPECT(NUTATE_BAD_HANDLE, nutate_history_values(NULL, x, 16));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_create(NULL, &stepper, text, sizeof text));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_create_scene(NULL, &stepper, text, sizeof text));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_set(NULL, "order", "2"));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_set_time_step(NULL, 0.1));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_prepare(NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_set_state(NULL, 0.0, one, vector));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_set_canonical(NULL, 0.0, one, one));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_step(NULL, 0.1));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_steps(NULL, 0.1, 1, &n));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_run(NULL, 1, 1, x, 1, &size));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_run_to(NULL, 1.0, 1, 0.0, x, 1, &size));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_count_rows(NULL, 1.0, 1, &size));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_set_columns(NULL, "energy"));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_width(NULL, &size));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_column(NULL, 0, text, sizeof text));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_row(NULL, x, 16));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_time(NULL, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_quaternion(NULL, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_conjugate_momentum(NULL, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_angular_velocity(NULL, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_angular_velocity_space(NULL, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_angular_momentum(NULL, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_angular_momentum_space(NULL, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_matrix(NULL, r));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_euler(NULL, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_energy(NULL, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_constraints(NULL, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_conserved(NULL, &i, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_solver(NULL, &i, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_exact_free_body(NULL, one, vector, 1, x, x, x));
    EXPECT(NUTATE_OK, nutate_system_destroy(&system));
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    return 0;
}

/* NULL for each argument in turn; arguments that may be NULL are so here. */
static int null_creation(void)
{
    nutate_system *system = (nutate_system *)moments;
    nutate_scene *scene = (nutate_scene *)moments;
    char text[100] = "";
    const char *const with_null[2] = {"output.every=2", NULL};

    EXPECT(NUTATE_BAD_ARGUMENT, nutate_get_version(NULL, 10));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_status_text(0, NULL, 10));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_moments(NULL, 0.0, NULL, 0, &system, text, sizeof text));
    CHECK(system == NULL && strstr(text, "moments"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_moments(moments, 0.0, NULL, 0, NULL, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_tensor(NULL, 0.0, NULL, 0, &system, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_tensor(tensor, 0.0, NULL, 0, NULL, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_shape(NULL, moments, 3, 1.0, 0.0, NULL, &system, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_shape("box", NULL, 3, 1.0, 0.0, NULL, &system, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_shape("box", moments, 3, 1.0, 0.0, NULL, NULL, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_parse(NULL, &system, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_parse("&body inertia = 5, 20, 17 /", NULL, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_destroy(NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_read(NULL, NULL, 0, &scene, NULL, 0));
    CHECK(scene == NULL);
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_read("scenes/box.nml", NULL, 0, NULL, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_read("scenes/box.nml", NULL, 1, &scene, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_parse(NULL, NULL, NULL, 0, &scene, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_parse(scene_text, NULL, NULL, 0, NULL, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_parse(scene_text, NULL, with_null, 2, &scene, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_destroy(NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_history_destroy(NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_destroy(NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_create(NULL, NULL, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_create_scene(NULL, NULL, NULL, 0));
    return 0;
}

static int null_in_system(nutate_system *system)
{
    double x[4] = {0.0, 0.0, 0.0, 0.0};
    char text[100];
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_gravity(system, NULL));
    EXPECT(NUTATE_OK, nutate_last_message(system, text, sizeof text));
    CHECK(strstr(text, "gravity"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_last_message(system, NULL, 10));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_dipole(system, NULL, vector));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_dipole(system, vector, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_gravity_gradient(system, NULL, 1.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_spring(system, NULL, vector, 1.0, 0.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_spring(system, vector, NULL, 1.0, 0.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_damping(system, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_torque(system, NULL, 0, 0.0, 0.0, 0.0, 1.0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_rotor(system, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_groups(system, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_potential(system, NULL, answer_potential, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_potential(system, vector, NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_add_user_torque(system, NULL, NULL));
    EXPECT(NUTATE_OK, nutate_system_body(system, NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_exact_free_body(system, NULL, vector, 1, x, x, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_exact_free_body(system, one, NULL, 1, x, x, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_exact_free_body(system, one, vector, 1, NULL, x, x));
    EXPECT(NUTATE_OK, nutate_exact_free_body(system, one, vector, 1, x, NULL, NULL));
    EXPECT(NUTATE_OK, nutate_exact_free_body(system, one, vector, 0, NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_create(system, NULL, NULL, 0));
    return 0;
}

static int null_in_scene(nutate_scene *scene)
{
    nutate_history *history = NULL;
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_get_title(scene, NULL, 10));
    EXPECT(NUTATE_OK, nutate_scene_get_plan(scene, NULL, NULL, NULL));
    EXPECT(NUTATE_OK, nutate_scene_get_initial(scene, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_add_potential(scene, NULL, answer_potential, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_add_potential(scene, vector, NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_add_user_torque(scene, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_system(scene, NULL, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_create_scene(scene, NULL, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_run(scene, NULL, NULL, 0));
    EXPECT(NUTATE_OK, nutate_scene_run(scene, &history, NULL, 0));
    EXPECT(NUTATE_OK, nutate_history_size(history, NULL, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_history_name(history, 0, NULL, 10));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_history_column(history, NULL, (double *)one, 1000000));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_history_column(history, "t", NULL, 1000000));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_history_values(history, NULL, 1000000));
    EXPECT(NUTATE_OK, nutate_history_destroy(&history));
    return 0;
}

static int null_in_stepper(nutate_stepper *stepper)
{
    double x[5];
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set(stepper, NULL, "2"));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set(stepper, "order", NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_state(stepper, 0.0, NULL, vector));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_state(stepper, 0.0, one, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_canonical(stepper, 0.0, NULL, one));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_canonical(stepper, 0.0, one, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_set_time_step(stepper, 0.01));
    EXPECT(NUTATE_OK, nutate_stepper_steps(stepper, 0.01, 1, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 2, 1, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, 0.1, 1, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_count_rows(stepper, 1.0, 1, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_columns(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_width(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_column(stepper, 0, NULL, 10));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_row(stepper, NULL, 100));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_time(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_quaternion(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_conjugate_momentum(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_angular_velocity(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_angular_velocity_space(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_angular_momentum(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_angular_momentum_space(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_matrix(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_euler(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_energy(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_constraints(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_conserved(stepper, NULL, x));
    EXPECT(NUTATE_OK, nutate_stepper_solver(stepper, NULL, NULL));
    return 0;
}

static int null_in_attitudes(void)
{
    double x[4], r[3][3];
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_matrix_from_quat(NULL, r));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_matrix_from_quat(one, NULL));
    EXPECT(NUTATE_OK, nutate_matrix_from_quat(one, r));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_matrix(NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_matrix((const double(*)[3])r, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_euler_from_quat(NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_euler_from_quat(one, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_follow_euler(NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_follow_euler(one, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_euler(NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_euler(vector, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_omega_from_euler_rates(NULL, vector, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_omega_from_euler_rates(vector, NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_omega_from_euler_rates(vector, vector, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_axis_angle(NULL, 1.0, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_axis_angle(vector, 1.0, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_axis_angle_from_quat(NULL, x, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_axis_angle_from_quat(one, NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_axis_angle_from_quat(one, x, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_rotation_vector(NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_from_rotation_vector(vector, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_rotation_vector_from_quat(NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_rotation_vector_from_quat(one, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_product(NULL, one, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_product(one, NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_product(one, one, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_normalized(NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_quat_normalized(one, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_rotate_to_space(NULL, vector, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_rotate_to_space(one, NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_rotate_to_space(one, vector, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_rotate_to_body(NULL, vector, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_rotate_to_body(one, NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_rotate_to_body(one, vector, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_attitude_distance(NULL, one, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_attitude_distance(one, NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_attitude_distance(one, one, NULL));
    return 0;
}

int test_c_null_arguments(void)
{
    nutate_system *system = NULL;
    nutate_scene *scene = NULL;
    nutate_stepper *stepper = NULL;
    int line = null_creation();
    if (!line) line = null_in_attitudes();
    EXPECT(NUTATE_OK, make_box(&system));
    EXPECT(NUTATE_OK, make_scene(scene_text, &scene));
    EXPECT(NUTATE_OK, make_stepper(&stepper));
    if (!line) line = null_in_system(system);
    if (!line) line = null_in_scene(scene);
    if (!line) line = null_in_stepper(stepper);
    nutate_system_destroy(&system);
    nutate_scene_destroy(&scene);
    nutate_stepper_destroy(&stepper);
    return line;
}

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
    char text[600];
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_shape("bax", moments, 3, 1.0, 0.0, NULL, &system, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_system_create_shape("", moments, 3, 1.0, 0.0, NULL, &system, NULL, 0));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_parse("&bodi inertia = 1, 1, 1 /", &system, text, sizeof text));
    CHECK(strstr(text, "nearest: body"));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_parse("&gravity /", &system, NULL, 0));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_parse("&body inertia = 1, 1, 1 / &spring /", &system, NULL, 0));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_parse("&body inertia = 1, 1, 1 / &output /", &system, NULL, 0));
    CHECK(system == NULL);
    EXPECT(NUTATE_OK, nutate_system_parse("&body inertia = 1, 1, 1, mass = 1 / &gravity /", &system, NULL, 0));
    EXPECT(NUTATE_BAD_SCENE, nutate_system_add_groups(system, "&gravty /"));
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
    EXPECT(NUTATE_OK, nutate_stepper_destroy(&stepper));
    return 0;
}

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
    static const char *const solvers[2] = {"lapack", "reduced"};
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
                    EXPECT(NUTATE_OK, nutate_stepper_set(stepper, "linear_solver", solvers[k]));
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
