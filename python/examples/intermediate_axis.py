"""A box that spins about its intermediate axis turns over again and again: when, and against the exact motion.

    python3 intermediate_axis.py [PAGE.html]       with a name it writes a page that shows the box
"""

import sys

import numpy as np

import nutate

box = nutate.System(shape="box", size=(4, 1, 2), mass=12)  # moments 5, 20, 17: axis 3 is the one between
q0, omega0 = (1, 0, 0, 0), (0.1, 0, 10)


def turns_over(t, q, omega):
    """0 where the spin about axis 3 changes its sense."""
    return omega[2]


solution = nutate.solve(box, q0, omega0, t_span=(0, 20), method="taylor", accuracy=1e-10, events=turns_over)
flips = solution.t_events[0]
print(f"{len(flips)} times in 20 s, the first at {flips[0]:.12f} s, then every {np.diff(flips).mean():.12f} s")

times = np.linspace(0, 20, 401)
q, omega = solution.sol(times)
exact_q, exact_omega = nutate.exact_free_body(box, q0, omega0, times)
errors = [nutate.attitude_distance(a, b) for a, b in zip(q, exact_q)]
print(f"{solution.n_steps} steps; attitude off by {errors[-1]:.1e} rad at the end, {max(errors):.1e} rad at most, "
      f"energy by {solution.errors['energy']:.1e} of itself")

for t, rate in zip(times[:40:4], omega[:40:4, 2]):
    print(f"{t:5.2f} s  {'#' * int(round(2 * (rate + 10)))}")
if sys.argv[1:]:
    solution.view(title="Intermediate axis").save(sys.argv[1])
# The accuracy is that of the end; between two flips errors can be several times as large.
sys.exit(int(errors[-1] > 1e-10 or max(errors) > 5e-10 or not np.allclose(np.diff(flips), 2 * flips[0], rtol=1e-9)))
