/* NULL for each argument of each function of the C interface. Each function returns 0, or the line of the first check that fails. */
#include "test_c_support.h"

int test_c_null_handles(void);
int test_c_null_arguments(void);

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
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_bound_potential(NULL, 1.0, 1.0, 1.0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_bound_torque(NULL, 1.0, 1.0, 1.0, 0.0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_bound_potential(NULL, 1.0, 1.0, 1.0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_bound_torque(NULL, 1.0, 1.0, 1.0, 0.0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_get_title(NULL, text, sizeof text));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_get_plan(NULL, x, x, &n));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_get_initial(NULL, x, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_add_potential(NULL, vector, answer_potential, NULL, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_add_user_torque(NULL, answer_torque, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_system(NULL, &system, text, sizeof text));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_equilibria(NULL, text, sizeof text, NULL, 0));
    EXPECT(NUTATE_BAD_HANDLE, nutate_scene_linearize(NULL, 0.0, text, sizeof text, NULL, 0));
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
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_keep_steps(NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_state_at(NULL, 0.1, x, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_history_chaos(NULL, NULL, x, x, x, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_dense_output(NULL, 0.0, x, x, NULL, 0.1, 1, x, x));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_run(NULL, 1, 1, x, 1, &size));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_run_to(NULL, 1.0, 1, 0.0, x, 1, &size));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_count_rows(NULL, 1.0, 1, &size));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_set_columns(NULL, "energy"));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_width(NULL, &size));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_column(NULL, 0, text, sizeof text));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_column_names(NULL, text, sizeof text));
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
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_uncertified(NULL, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_history_uncertified(NULL, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_history_accuracy(NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_history_summary(NULL, NULL, NULL));
    EXPECT(NUTATE_BAD_HANDLE, nutate_stepper_accuracy(NULL, x));
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
    EXPECT(NUTATE_BAD_HANDLE, nutate_system_copy(NULL, &system, NULL, 0));
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
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_equilibria(scene, NULL, 9, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_linearize(scene, 1.0, NULL, 9, NULL, 0));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_scene_linearize(scene, 1e300, (char *)one, 1, NULL, 0));
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
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_state_at(stepper, 0.005, NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_state_at(stepper, 0.005, x, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_dense_output(stepper, 0.0, NULL, x, NULL, 0.1, 1, x, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_dense_output(stepper, 0.0, x, NULL, NULL, 0.1, 1, x, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_dense_output(stepper, 0.0, x, x, NULL, 0.1, 1, NULL, x));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_dense_output(stepper, 0.0, x, x, NULL, 0.1, 1, x, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_run(stepper, 2, 1, NULL, 0, NULL));
    EXPECT(NUTATE_OK, nutate_stepper_run_to(stepper, 0.1, 1, 0.0, NULL, 0, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_count_rows(stepper, 1.0, 1, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_set_columns(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_width(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_column(stepper, 0, NULL, 10));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_column_names(stepper, NULL, 10));
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
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_uncertified(stepper, NULL));
    EXPECT(NUTATE_BAD_ARGUMENT, nutate_stepper_accuracy(stepper, NULL));
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
