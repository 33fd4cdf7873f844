"""A long satellite swings about the direction to the Earth: its period against the exact one, then how damping calms it.

The direction stands still here, as for a satellite that is held at its place: J2 a'' = -(3/2) k (J1 - J3) sin 2a, a pendulum in 2a.
"""

import sys

import numpy as np

import nutate

MOMENTS, STRENGTH, TILT = (50.0, 50.0, 5.0), 1.2e-6, 0.5  # kg m2; mu/r3, s-2; rad


def agm(a, b):
    """The arithmetic-geometric mean."""
    while abs(a - b) > 1e-15 * a:
        a, b = (a + b) / 2, np.sqrt(a * b)
    return a


def passes(t, q, omega):
    """0 where the long axis points to the Earth."""
    return nutate.matrix_from_quat(q)[0, 2]


def make(damping=0.0):
    """The satellite, its long axis 3 towards the Earth, which is below."""
    system = nutate.System(moments=MOMENTS)
    system.add("gravity_gradient", direction=(0, 0, -1), strength=STRENGTH)
    if damping:
        system.add("damping", coefficient=(damping, damping, 0.0))
    return system


start = nutate.quat_from_axis_angle((0, 1, 0), TILT)
passes.direction = -1  # type: ignore[attr-defined]
swinging = nutate.solve(make(), start, (0, 0, 0), t_span=(0, 40000), accuracy=1e-9, events=passes)
period = np.diff(swinging.t_events[0]).mean()
rate = np.sqrt(3 * STRENGTH * (MOMENTS[0] - MOMENTS[2]) / MOMENTS[1])
exact = 2 * np.pi / rate / agm(1.0, np.cos(TILT))
print(f"period {period:.6f} s, exact {exact:.6f} s; small swings take {2 * np.pi / rate:.1f} s")

calmed = nutate.solve(make(damping=0.005), start, (0, 0, 0), t_span=(0, 100000), accuracy=1e-7, t_eval=np.linspace(0, 1e5, 11))
for t, q in zip(calmed.t, calmed.q):
    print(f"{t:9.0f} s  {np.degrees(np.arccos(nutate.matrix_from_quat(q)[2, 2])):8.3f} degrees from the vertical")
print(f"work of the damping {calmed.energy['work'][-1]:.3e} J; the balance is off by {calmed.errors['energy']:.1e} of the energy")
sys.exit(int(abs(period - exact) > 1e-8 * exact))
