"""Reference for the tests: B-dot stops the rotation of a satellite relative to the field of the Earth on a circular orbit.

    python3 tools/docs/references/bdot.py      prints the final rate, mrad/s, of sampled and continuous control; wants numpy; a minute

Nothing is shared with the library: Euler's equations in inertial axes by the classical Runge-Kutta method. The sampled moment is the
difference of two samples of the field in body axes, the continuous one the derivative of that field, whose rate in inertial axes comes
from a difference of fourth order.
"""

import math

import numpy as np

INERTIA = np.array([0.12, 0.1, 0.04])
MU, EARTH_RATE, RADIUS, SIZE = 3.986004418e14, 7.292115e-5, 6371.2e3, 6378137.0 + 500e3
COEFFICIENTS = np.array([-1410.3e-9, 4545.5e-9, -29350.0e-9])
INCLINATION, NODE = math.radians(97.4), math.radians(30)
GAIN, LIMIT, END = 1e5, 0.2, 20000
MOTION = math.sqrt(MU / SIZE**3)
# Unit vectors to the ascending node and a quarter of a revolution ahead of it.
AT_NODE = np.array([math.cos(NODE), math.sin(NODE), 0.0])
AHEAD = np.array([-math.sin(NODE) * math.cos(INCLINATION), math.cos(NODE) * math.cos(INCLINATION), math.sin(INCLINATION)])


def cross(a, b):
    """The vector product."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def direction(t):
    """Unit vector from the centre of the Earth."""
    return AT_NODE * math.cos(MOTION * t) + AHEAD * math.sin(MOTION * t)


def field(t):
    """The field, inertial axes, T."""
    c, s = math.cos(EARTH_RATE * t), math.sin(EARTH_RATE * t)
    g, r = np.array([COEFFICIENTS[0] * c - COEFFICIENTS[1] * s, COEFFICIENTS[0] * s + COEFFICIENTS[1] * c, COEFFICIENTS[2]]), direction(t)
    return (RADIUS / SIZE)**3 * (3 * g.dot(r) * r - g)


def field_rate(t, h=1.0):
    """The derivative of the field in inertial axes, T/s."""
    return (field(t - 2 * h) - 8 * field(t - h) + 8 * field(t + h) - field(t + 2 * h)) / (12 * h)


def rotation(q):
    """The matrix from body to inertial axes."""
    w, x, y, z = q / math.sqrt(q @ q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def rates(t, y, moment):
    """The derivative of quaternion and rate under a moment, A m², or under continuous control."""
    q, omega, turned = y[:4], y[4:], rotation(y[:4]).T
    b, down = turned @ field(t), -(turned @ direction(t))
    if moment is None:
        moment = np.clip(-GAIN * (cross(b, omega) + turned @ field_rate(t)), -LIMIT, LIMIT)
    torque = 3 * MOTION**2 * cross(down, INERTIA * down) + cross(moment, b)
    return np.array([*(0.5 * np.array([-q[1:] @ omega, *(q[0] * omega + cross(q[1:], omega))])),
                     *((torque - cross(omega, INERTIA * omega)) / INERTIA)])


def step(t, y, h, moment):
    """One step of the classical Runge-Kutta method."""
    k1 = rates(t, y, moment)
    k2 = rates(t + h / 2, y + h / 2 * k1, moment)
    k3 = rates(t + h / 2, y + h / 2 * k2, moment)
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rates(t + h, y + h * k3, moment))


def start():
    """At rest in inertial axes, with the attitude of the LVLH frame."""
    axes = np.column_stack([AHEAD, -cross(AT_NODE, AHEAD), -AT_NODE])
    w = 0.5 * math.sqrt(1 + np.trace(axes))
    return np.array([w, (axes[2, 1] - axes[1, 2]) / (4 * w), (axes[0, 2] - axes[2, 0]) / (4 * w),
                     (axes[1, 0] - axes[0, 1]) / (4 * w), 0, 0, 0])


def final_rate(sampled):
    """The rate at the end, mrad/s; samples are 1 s apart."""
    y, last = start(), None
    for t in range(END):
        b, moment = rotation(y[:4]).T @ field(float(t)), None
        if sampled:
            moment = np.zeros(3) if last is None else np.clip(-GAIN * (b - last), -LIMIT, LIMIT)
        y, last = step(float(t), y, 1.0, moment), b
    return 1e3 * math.sqrt(y[4:] @ y[4:])


for sampled in (True, False):
    print("sampled" if sampled else "continuous", f"{final_rate(sampled):.8f}")
