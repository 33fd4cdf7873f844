/* A free box tumbles about its intermediate axis; its energy must not change. */
#include <math.h>
#include <nutate.h>
#include <stdio.h>

int main(void)
{
    const double edges[3] = {4, 1, 2}, q[4] = {1, 0, 0, 0}, omega[3] = {0.1, 0, 10};
    double energy[5];
    char why[256] = "";
    nutate_system *box = NULL;
    nutate_stepper *stepper = NULL;

    int status = nutate_system_create_shape("box", edges, 3, 12.0, 0.0, NULL, &box, why, sizeof why);
    if (!status) status = nutate_stepper_create(box, &stepper, why, sizeof why);
    if (!status) status = nutate_stepper_set_state(stepper, 0.0, q, omega);
    if (!status) status = nutate_stepper_steps(stepper, 0.01, 1000, NULL);
    if (!status) status = nutate_stepper_energy(stepper, energy);
    if (status) {
        fprintf(stderr, "tumble: %s\n", why);
    } else {
        printf("%.15g J, off by %.1e J\n", energy[2], energy[4]);
        status = fabs(energy[4]) > 1e-13 * energy[2];
    }
    nutate_stepper_destroy(&stepper);
    nutate_system_destroy(&box);
    return status;
}
