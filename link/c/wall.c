/* A top that falls over, and that a soft wall throws back: gravity from the library, the wall a potential of this program.
 * Checks that energy and the momentum about the vertical stay put: exit status 1 if they do not. */
#include <math.h>
#include <nutate.h>
#include <stdio.h>

/* The wall: U = height exp(-gamma_3 / width), gamma the body components of the vertical. */
struct wall {
    double height, width; /* J, 1 */
};

static int wall_energy(const double gamma[3], void *user, double *energy, double gradient[3])
{
    const struct wall *wall = user;
    *energy = wall->height * exp(-gamma[2] / wall->width);
    gradient[0] = gradient[1] = 0.0;
    gradient[2] = -*energy / wall->width;
    return 0;
}

/* Prints why a call failed, and returns its status. */
static int explain(int status, const nutate_stepper *stepper, const char *message)
{
    char text[256] = "";
    if (!message) {
        nutate_last_message(stepper, text, sizeof text);
        message = text;
    }
    fprintf(stderr, "wall: %s\n", message);
    return status;
}

int main(void)
{
    const double cone[2] = {0.05, 0.1}, center[3] = {0.0, 0.0, 0.075};  /* radius and height, m */
    const double gravity[3] = {0.0, 0.0, -9.81}, up[3] = {0.0, 0.0, 1.0};
    const double angles[3] = {0.0, 0.3, 0.0}, omega[3] = {0.0, 0.0, 10.0};
    struct wall wall = {0.02, 0.05};
    nutate_system *top = NULL;
    nutate_stepper *stepper = NULL;
    char message[256] = "";
    double q[4], l_start[3], l[3], energy[5], axis[3], t, lowest = 1.0, worst_energy = 0.0, worst_l = 0.0;
    int status, i;

    status = nutate_system_create_shape("cone", cone, 2, 0.0, 2700.0, center, &top, message, sizeof message);
    if (!status) status = nutate_system_add_gravity(top, gravity);
    if (!status) status = nutate_system_add_potential(top, up, wall_energy, NULL, &wall);
    if (!status) status = nutate_stepper_create(top, &stepper, message, sizeof message);
    nutate_system_destroy(&top); /* the stepper has its own */
    if (status) return explain(status, NULL, message);

    status = nutate_quat_from_euler(angles, q);
    if (!status) status = nutate_stepper_set(stepper, "formulation", "reduced");
    if (!status) status = nutate_stepper_set_state(stepper, 0.0, q, omega);
    if (!status) status = nutate_stepper_angular_momentum_space(stepper, l_start);

    printf("     t   height of the axis   energy error   l_z error\n");
    for (i = 1; i <= 2000 && !status; ++i) {
        status = nutate_stepper_step(stepper, 0.002);
        if (!status) status = nutate_stepper_energy(stepper, energy);
        if (!status) status = nutate_stepper_angular_momentum_space(stepper, l);
        if (!status) status = nutate_stepper_time(stepper, &t);
        if (!status) status = nutate_stepper_quaternion(stepper, q);
        if (!status) status = nutate_rotate_to_space(q, up, axis);
        if (status) break;
        worst_energy = fmax(worst_energy, fabs(energy[4] / energy[2]));
        worst_l = fmax(worst_l, fabs((l[2] - l_start[2]) / l_start[2]));
        lowest = fmin(lowest, axis[2]);
        if (i % 200 == 0) printf("%6.2f%21.5f%15.2e%12.2e\n", t, axis[2], energy[4] / energy[2], l[2] / l_start[2] - 1.0);
    }
    if (status) explain(status, stepper, NULL);
    nutate_stepper_destroy(&stepper);
    if (status) return status;

    if (!(worst_energy < 1e-12 && worst_l < 1e-12 && lowest < 0.0 && lowest > -0.5)) {
        fprintf(stderr, "wall: energy off by %.1e, l_z by %.1e, lowest %.3f\n", worst_energy, worst_l, lowest);
        return 1;
    }
    printf("energy and l_z kept to %.1e and %.1e\n", worst_energy, worst_l);
    return 0;
}
