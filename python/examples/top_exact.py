"""A heavy top that nods: its nutation against the solution in elliptic functions.

With u the cosine of the nutation, conserved momentum and energy leave u'^2 = f(u), a cubic with the roots u1 < u2 < u3; released
at u2 without nodding, u(t) = u1 + (u2 - u1) sn^2(w t + K | m), K the quarter of a period.
"""

import sys

import numpy as np

import nutate

# Moments across and along the axis, kg m2; weight times distance of the centre of mass, N m; spin, rad/s; angle at the start, rad.
ACROSS, ALONG, PULL, SPIN, TILT = 1.0, 0.4, 9.81, 12.0, 0.6


def agm(a, b):
    """The arithmetic-geometric mean."""
    while abs(a - b) > 1e-15 * a:
        a, b = (a + b) / 2, np.sqrt(a * b)
    return a


def sn(x, m):
    """The elliptic function sn(x | m), by the arithmetic-geometric mean (Abramowitz and Stegun 16.4)."""
    a, c = [1.0], [np.sqrt(m)]
    b = np.sqrt(1 - m)
    while abs(c[-1]) > 1e-16:
        a, b, c = [*a, (a[-1] + b) / 2], np.sqrt(a[-1] * b), [*c, (a[-1] - b) / 2]
    angle = 2 ** (len(a) - 1) * a[-1] * x
    for n in range(len(a) - 1, 0, -1):
        angle = (angle + np.arcsin(c[n] / a[n] * np.sin(angle))) / 2
    return np.sin(angle)


top = nutate.System(moments=(ACROSS, ACROSS, ALONG), mass=1.0, center_of_mass=(0, 0, 1))
top.add("gravity", acceleration=(0, 0, -PULL))
start = nutate.quat_from_euler((0.0, TILT, 0.0))
solution = nutate.solve(top, start, (0, 0, SPIN), t_span=(0, 10), accuracy=1e-10)

# The roots: u2 is that of the start; u1 and u3 belong to u^2 - 2 g u - 1 + 2 g u2 = 0.
u2, g = np.cos(TILT), (ALONG * SPIN) ** 2 / (4 * ACROSS * PULL)
u1, u3 = g - np.sqrt(g * g + 1 - 2 * g * u2), g + np.sqrt(g * g + 1 - 2 * g * u2)
frequency, m = np.sqrt(PULL / (2 * ACROSS) * (u3 - u1)), (u2 - u1) / (u3 - u1)
quarter = np.pi / 2 / agm(1.0, np.sqrt(1 - m))

times = np.linspace(0, 10, 1001)
q, _ = solution.sol(times)
u = 1 - 2 * (q[:, 1] ** 2 + q[:, 2] ** 2)
error = np.abs(u - (u1 + (u2 - u1) * sn(frequency * times + quarter, m) ** 2)).max()
print(f"nods between {np.degrees(np.arccos(u2)):.3f} and {np.degrees(np.arccos(u1)):.3f} degrees")
print(f"{solution.n_steps} steps of {solution.method}; cosine of the nutation off by {error:.1e} at most")
print(f"relative errors: energy {solution.errors['energy']:.1e}, vertical momentum {solution.errors['momentum']:.1e}")
sys.exit(int(error > 1e-9))
