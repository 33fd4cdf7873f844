/* N steps of the box through the C interface: for `interface_cost.sh`.   c_steps N full|reduced one|batch|run */
#include <nutate.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int argc, char **argv)
{
    const double edges[3] = {4.0, 1.0, 2.0}, q[4] = {1.0, 0.0, 0.0, 0.0}, omega[3] = {0.1, 0.0, 10.0};
    nutate_system *box = NULL;
    nutate_stepper *stepper = NULL;
    double attitude[4] = {0.0, 0.0, 0.0, 0.0};
    long i, n;
    int status;
    if (argc != 4) return 2;
    n = atol(argv[1]);
    status = nutate_system_create_shape("box", edges, 3, 12.0, 0.0, NULL, &box, NULL, 0);
    if (!status) status = nutate_stepper_create(box, &stepper, NULL, 0);
    if (!status) status = nutate_stepper_set(stepper, "formulation", argv[2]);
    if (!status) status = nutate_stepper_set_time_step(stepper, 0.01);
    if (!status) status = nutate_stepper_set_state(stepper, 0.0, q, omega);
    if (strcmp(argv[3], "one") == 0)
        for (i = 0; i < n && !status; ++i) status = nutate_stepper_step(stepper, 0.01);
    else if (strcmp(argv[3], "batch") == 0)
        status = nutate_stepper_steps(stepper, 0.01, n, NULL);
    else
        status = nutate_stepper_run(stepper, n, n, NULL, 0, NULL);
    if (!status) status = nutate_stepper_quaternion(stepper, attitude);
    printf("%24.16e\n", attitude[0]);
    nutate_stepper_destroy(&stepper);
    nutate_system_destroy(&box);
    return status;
}
