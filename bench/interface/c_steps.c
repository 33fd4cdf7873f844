/* N steps of a body through the C interface: for `interface_cost.sh` and `tools/docs/costs.py`. A top has its centre of mass at
 * 0.5 m from the pivot; a damped body loses 0.01 N m s on each axis.
 *    c_steps N full|reduced|METHOD one|batch|run [box|top|damped] */
#include <nutate.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int argc, char **argv)
{
    const double moments[3] = {5.0, 20.0, 17.0}, center[3] = {0.0, 0.0, 0.5};
    const double q[4] = {1.0, 0.0, 0.0, 0.0}, omega[3] = {0.1, 0.0, 10.0};
    const char *scene;
    nutate_system *body = NULL;
    nutate_stepper *stepper = NULL;
    double attitude[4] = {0.0, 0.0, 0.0, 0.0};
    long i, n;
    int status, implicit;
    if (argc < 4) return 2;
    n = atol(argv[1]);
    scene = argc > 4 ? argv[4] : "box";
    implicit = !strcmp(argv[2], "full") || !strcmp(argv[2], "reduced");
    status = nutate_system_create_moments(moments, 1.0, center, 0, &body, NULL, 0);
    if (!status && !strcmp(scene, "top")) status = nutate_system_add_groups(body, "&gravity acceleration = 0, 0, -9.81 /");
    if (!status && !strcmp(scene, "damped"))
        status = nutate_system_add_groups(body, "&damping coefficient = 0.01, 0.01, 0.01 /");
    if (!status) status = nutate_stepper_create(body, &stepper, NULL, 0);
    if (!status) status = nutate_stepper_set(stepper, "method", implicit ? "nielsen_krenk" : argv[2]);
    if (!status && implicit) status = nutate_stepper_set(stepper, "formulation", argv[2]);
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
    nutate_system_destroy(&body);
    return status;
}
