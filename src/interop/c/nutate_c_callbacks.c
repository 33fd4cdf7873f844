/* Calls the callbacks of a C program for Fortran procedures that must be pure, and records their failures.
 *
 * `failure` belongs to the run: [0] its status, [1] the value that the callback returned. After a failure, and for
 * results that are not finite or exceed 1e100, the step receives zeros. The caller of the step then tests `failure` and
 * undoes the step. No result that could raise a floating-point exception reaches the arithmetic. */
#include "../../../include/nutate.h"

/* Returns nonzero if all numbers are finite and within the limits of the library. Defined in nutate_c_effects.f90. */
int nutate_c_are_moderate(int n, const double *numbers);

void nutate_c_call_potential(nutate_potential potential, const double *gamma, void *user, int *failure, double *energy,
                             double *gradient);
void nutate_c_call_hessian(nutate_hessian hessian, const double *gamma, void *user, int *failure, double *matrix);
void nutate_c_call_torque(nutate_torque torque, double t, const double *q, const double *omega, void *user,
                          int *failure, double *tau);

void nutate_c_call_quantity(nutate_quantity quantity, double t, const double *q, const double *omega, void *user,
                            int *failure, double *g);

/* Records the first failure, and replaces invalid results by zeros. */
static void check_results(int returned, int *failure, int n, double *results)
{
    int i;
    if (returned == 0 && nutate_c_are_moderate(n, results)) return;
    for (i = 0; i < n; ++i) results[i] = 0.0;
    if (!failure || failure[0] != NUTATE_OK) return;
    failure[0] = returned != 0 ? NUTATE_CALLBACK : NUTATE_NOT_FINITE;
    failure[1] = returned;
}

static int has_failed(const int *failure) { return failure && failure[0] != NUTATE_OK; }

void nutate_c_call_potential(nutate_potential potential, const double *gamma, void *user, int *failure, double *energy,
                             double *gradient)
{
    double results[4] = {0.0, 0.0, 0.0, 0.0};
    if (!has_failed(failure)) check_results(potential(gamma, user, &results[0], &results[1]), failure, 4, results);
    *energy = results[0];
    gradient[0] = results[1];
    gradient[1] = results[2];
    gradient[2] = results[3];
}

void nutate_c_call_hessian(nutate_hessian hessian, const double *gamma, void *user, int *failure, double *matrix)
{
    double rows[3][3] = {{0.0}};
    int i, returned;
    if (!has_failed(failure)) {
        returned = hessian(gamma, user, rows);
        check_results(returned, failure, 9, &rows[0][0]);
    }
    /* The matrix is symmetric: rows are columns. */
    for (i = 0; i < 9; ++i) matrix[i] = rows[i / 3][i % 3];
}

void nutate_c_call_torque(nutate_torque torque, double t, const double *q, const double *omega, void *user,
                          int *failure, double *tau)
{
    tau[0] = tau[1] = tau[2] = 0.0;
    if (!has_failed(failure)) check_results(torque(t, q, omega, user, tau), failure, 3, tau);
}

void nutate_c_call_quantity(nutate_quantity quantity, double t, const double *q, const double *omega, void *user,
                            int *failure, double *g)
{
    *g = 0.0;
    if (!has_failed(failure)) check_results(quantity(t, q, omega, user, g), failure, 1, g);
}
