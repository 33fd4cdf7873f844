"""1000 dipoles in a ring, each in the field of its two neighbours: the torques are those of NumPy, the steps those of nutate."""

import sys

import numpy as np

import nutate

N, DT, STEPS = 1000, 0.02, 2000
MOMENTS = np.array([1.0, 1.0, 0.1])


def directions(q):
    """The dipoles along body axis 3, in space axes."""
    w, x, y, z = q.T
    return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)


def field(d):
    """That of the neighbours along x: 3 (m.e) e - m of each."""
    near = np.roll(d, 1, axis=0) + np.roll(d, -1, axis=0)
    return near * np.array([2.0, -1.0, -1.0])


def energy(q, l, torque):
    """With the momenta half a step on, at the time of q."""
    d, whole = directions(q), l + 0.5 * DT * torque
    along = (whole * d).sum(axis=1) ** 2
    kinetic = 0.5 * (((whole ** 2).sum(axis=1) - along) / MOMENTS[0] + along / MOMENTS[2]).sum()
    return kinetic - 0.5 * (d * field(d)).sum()


random = np.random.default_rng(1)
q = random.normal(size=(N, 4))
q /= np.linalg.norm(q, axis=1, keepdims=True)
l = np.zeros((N, 3))
bodies = nutate.Bodies(nutate.System(moments=MOMENTS))

torque = np.cross(directions(q), field(directions(q)))
start = energy(q, l - 0.5 * DT * torque, torque)
bodies.kick(-0.5 * DT, q, l, torque)
errors = np.empty(STEPS)
for i in range(STEPS):
    bodies.step(DT, q, l, torque)
    torque = np.cross(directions(q), field(directions(q)))
    errors[i] = energy(q, l, torque) - start
scale = abs(start) + N
early, late = np.abs(errors[:STEPS // 2]).max() / scale, np.abs(errors[STEPS // 2:]).max() / scale
print(f"{N} dipoles, {STEPS} steps: energy off by {early:.0e} in the first half, by {late:.0e} in the second")
print(f"|q| off by {np.abs(np.linalg.norm(q, axis=1) - 1).max():.0e}")
sys.exit(int(not late < 2 * early < 4e-3))
