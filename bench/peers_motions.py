"""Motions of `bench_peers`: the equations, for heyoka, Python and C alike, and the same systems for nutate.

An equation is a function rate(t, y, cos, sqrt) of numbers, of symbols of heyoka or of `Symbol`, which writes C.
"""

import ctypes
import math
import subprocess

END = 20.0
START = (0.8, 0.6, 0.0, 0.0, 0.3, 1.0, 5.0)
MOMENTS = (2.0, 3.0, 4.0)


def cross(a, b):
    """Returns a x b."""
    return [a[1]*b[2] - a[2]*b[1], a[2]*b[0] - a[0]*b[2], a[0]*b[1] - a[1]*b[0]]


def to_body(q, n):
    """Returns the transposed rotation matrix of q times the constant vector n of space axes, without the terms of zeros."""
    rows = ([1 - 2*(q[2]*q[2] + q[3]*q[3]), 2*(q[1]*q[2] - q[0]*q[3]), 2*(q[1]*q[3] + q[0]*q[2])],
            [2*(q[1]*q[2] + q[0]*q[3]), 1 - 2*(q[1]*q[1] + q[3]*q[3]), 2*(q[2]*q[3] - q[0]*q[1])],
            [2*(q[1]*q[3] - q[0]*q[2]), 2*(q[2]*q[3] + q[0]*q[1]), 1 - 2*(q[1]*q[1] + q[2]*q[2])])
    used = [i for i in range(3) if not (isinstance(n[i], float) and n[i] == 0.0)]
    return [total([rows[i][k] if isinstance(n[i], float) and n[i] == 1.0 else n[i]*rows[i][k] for i in used]) for k in range(3)]


def total(terms):
    """Returns the sum of terms."""
    value = terms[0]
    for term in terms[1:]:
        value = value + term
    return value


def body(y, torque=None, moments=MOMENTS, rotor=None, frame=None):
    """Returns the rates of attitude and angular velocity for a torque in body axes, a rotor, and rotating space axes."""
    q, w = y[:4], y[4:7]
    rates = [-0.5*(q[1]*w[0] + q[2]*w[1] + q[3]*w[2]), 0.5*(q[0]*w[0] + q[2]*w[2] - q[3]*w[1]),
             0.5*(q[0]*w[1] + q[3]*w[0] - q[1]*w[2]), 0.5*(q[0]*w[2] + q[1]*w[1] - q[2]*w[0])]
    if frame:
        f = [0.5*rate for rate in frame]
        rates = [rates[0] + (f[0]*q[1] + f[1]*q[2] + f[2]*q[3]), rates[1] - (f[0]*q[0] + f[1]*q[3] - f[2]*q[2]),
                 rates[2] - (f[1]*q[0] + f[2]*q[1] - f[0]*q[3]), rates[3] - (f[2]*q[0] + f[0]*q[2] - f[1]*q[1])]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        rate = (moments[j] - moments[k])/moments[i]*(w[j]*w[k]) if moments[j] != moments[k] else 0.0*w[i]
        if rotor:
            rate = rate + (rotor[j]/moments[i]*w[k] - rotor[k]/moments[i]*w[j])
        if torque and torque[i] is not None:
            rate = rate + torque[i]/moments[i]
        rates.append(rate)
    return rates


def free(_t, y, _cos, _sqrt):
    """A torque-free body."""
    return body(y)


def heavy(moments):
    """Returns the equations of a top whose centre of mass is on axis 3."""
    def rate(_t, y, _cos, _sqrt):
        q, weight = y[:4], 0.3*9.81
        return body(y, [weight*2*(q[2]*q[3] + q[0]*q[1]), -weight*2*(q[1]*q[3] - q[0]*q[2]), None], moments)
    return rate


def damped(t, y, cos, _sqrt):
    """A damped body with a harmonic torque."""
    wave = cos(2*math.pi*0.3*t + 0.4)
    return body(y, [0.5*wave - 0.05*y[4], 0.2*wave - 0.05*y[5], 0.1*wave - 0.02*y[6]])


def sprung(_t, y, _cos, sqrt):
    """A spring in a rotating frame."""
    point = [0.4, 0.1, -0.6]
    anchor = to_body(y[:4], [0.5, 1.0, -0.8])
    reach = [point[i] - anchor[i] for i in range(3)]
    pull = 5.0 - 5.0*0.7/sqrt(reach[0]*reach[0] + reach[1]*reach[1] + reach[2]*reach[2])
    return body(y, [pull*part for part in cross(point, anchor)], frame=(0.3, -0.2, 0.5))


def gyrostat(_t, y, _cos, _sqrt):
    """A body with a rotor."""
    return body(y, rotor=(0.3, -0.4, 0.7))


MU, AXIS, ECCENTRICITY, INCLINATION = 3.0, 2.0, 0.2, 0.5


def satellite(_t, y, _cos, sqrt):
    """A satellite with its gravity gradient; four more states are position and velocity in the plane of the orbit."""
    x, z = y[7], y[8]
    square = x*x + z*z
    pull = MU/(square*sqrt(square))
    along = to_body(y[:4], [x, math.cos(INCLINATION)*z, math.sin(INCLINATION)*z])
    strength = 3.0*pull/square
    torque = [strength*part for part in cross(along, [MOMENTS[i]*along[i] for i in range(3)])]
    return body(y, torque) + [y[9], y[10], -(pull*x), -(pull*z)]


WHEEL = 0.02


def wheels(t, y, cos, _sqrt):
    """Two reaction wheels on the axes 1 and 2 with motors; two more states are their momenta."""
    w, h = y[4:7], y[7:9]
    motors = [0.05, 0.03*cos(2*math.pi*0.2*t) - 0.001*(h[1]/WHEEL - w[1])]
    rest = [MOMENTS[0] - WHEEL, MOMENTS[1] - WHEEL, MOMENTS[2]]
    momentum = [rest[0]*w[0] + h[0], rest[1]*w[1] + h[1], rest[2]*w[2]]
    turning = cross(momentum, w)
    rates = body(y)[:4]
    return rates + [(turning[0] - motors[0])/rest[0], (turning[1] - motors[1])/rest[1], turning[2]/rest[2], motors[0] + 0.0*h[0],
                    motors[1]]


SPEED = math.sqrt(MU/AXIS*(1 + ECCENTRICITY)/(1 - ECCENTRICITY))
BODY, GRAVITY = "&body inertia = {}, {}, 4.0, mass = 1.0, center_of_mass = 0.0, 0.0, 0.3 /", "&gravity acceleration = 0.0, 0.0, -9.81 /"
PLAIN = BODY.format(2.0, 3.0)

# Names, equations, initial states beside attitude and rate, groups of the scene.
MOTIONS = {
    "torque-free": (free, (), PLAIN),
    "symmetric top": (heavy((3.0, 3.0, 4.0)), (), BODY.format(3.0, 3.0) + GRAVITY),
    "asymmetric top": (heavy(MOMENTS), (), PLAIN + GRAVITY),
    "damped": (damped, (), PLAIN + "&damping coefficient = 0.05, 0.05, 0.02 /"
               "&torque body = 0.5, 0.2, 0.1, frequency = 0.3, phase = 0.4 /"),
    "spring, rotating": (sprung, (), PLAIN + "&rotating_frame rate = 0.3, -0.2, 0.5 /"
                         "&spring body_point = 0.4, 0.1, -0.6, anchor = 0.5, 1.0, -0.8, stiffness = 5.0, rest_length = 0.7 /"),
    "gyrostat": (gyrostat, (), PLAIN + "&rotor momentum = 0.3, -0.4, 0.7 /"),
    "satellite": (satellite, (AXIS*(1 - ECCENTRICITY), 0.0, 0.0, SPEED), PLAIN + f"&orbit semi_major_axis = {AXIS}, eccentricity = "
                  f"{ECCENTRICITY}, inclination = {INCLINATION}, mu = {MU} / &gravity_gradient /"),
    "wheels": (wheels, (WHEEL*START[4], WHEEL*START[5]), PLAIN + f"&wheel axis = 1.0, 0.0, 0.0, inertia = {WHEEL}, torque = 0.05 /"
               f"&wheel axis = 0.0, 1.0, 0.0, inertia = {WHEEL}, torque = 0.03, frequency = 0.2, friction = 0.001 /"),
}


class Symbol:
    """A number in the C code of an equation: operations append statements to `lines`."""

    def __init__(self, lines, text):
        self.lines, self.text = lines, text

    def _put(self, expression):
        self.lines.append(f"const double v{len(self.lines)} = {expression};")
        return Symbol(self.lines, f"v{len(self.lines) - 1}")

    def __neg__(self):
        return self._put(f"-{self.text}")


def operation(sign, swapped):
    """Returns the operator of two symbols, or of a symbol and a number."""
    def apply(self, other):
        terms = [self.text, other.text if isinstance(other, Symbol) else repr(float(other))]
        if swapped:
            terms.reverse()
        return self._put(f"{terms[0]} {sign} ({terms[1]})")
    return apply


for name, sign in (("add", "+"), ("sub", "-"), ("mul", "*"), ("truediv", "/")):
    setattr(Symbol, f"__{name}__", operation(sign, False))
    setattr(Symbol, f"__r{name}__", operation(sign, True))


def steps_in_c(name, a, b, c, size):
    """Returns a C function of n fixed steps by an explicit Runge-Kutta method, all stages written out; q is normalised in each."""
    lines = [f"void {name}(double end, long n, double *restrict y) {{", "double h = end/n;", "for (long s = 0; s < n; s++) {",
             "double t = s*h, z[N];" + "".join(f" double k{i}[N];" for i in range(len(b)))]
    for i, row in enumerate(a):
        used = " + ".join(f"{row[j]!r}*k{j}[m]" for j in range(i) if row[j] != 0.0)
        if used:
            lines.append(f"for (int m = 0; m < N; m++) z[m] = y[m] + h*({used});")
        lines.append(f"rate(t + {c[i]!r}*h, {'z' if used else 'y'}, k{i});")
    used = " + ".join(f"{b[j]!r}*k{j}[m]" for j in range(len(b)) if b[j] != 0.0)
    lines += [f"for (int m = 0; m < N; m++) y[m] += h*({used});",
              "double f = 1/sqrt(y[0]*y[0] + y[1]*y[1] + y[2]*y[2] + y[3]*y[3]);", "for (int m = 0; m < 4; m++) y[m] *= f;", "}", "}"]
    return "\n".join(lines).replace("[N]", f"[{size}]").replace("< N", f"< {size}")


def compiled(rate, extra, path):
    """Compiles the equations with loops of RK8 (the method of DOP853) and RK4 as PATH.so, and returns the library."""
    from scipy.integrate._ivp import dop853_coefficients as dop853
    lines, size = [], 7 + len(extra)

    def call(function):
        return lambda x: x._put(f"{function}({x.text})")

    values = rate(Symbol(lines, "t"), [Symbol(lines, f"y[{i}]") for i in range(size)], call("cos"), call("sqrt"))
    lines += [f"f[{i}] = {value.text};" for i, value in enumerate(values)]
    eight = [row[:12].tolist() for row in dop853.A[:12]], dop853.B.tolist(), dop853.C[:12].tolist()
    four = [[0.0]*4, [0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]], [1/6, 1/3, 1/3, 1/6], [0.0, 0.5, 0.5, 1.0]
    text = ["#include <math.h>", f"static inline void rate(double t, const double *restrict y, double *restrict f) {{ (void) t;", *lines, "}",
            steps_in_c("rk8", *eight, size), steps_in_c("rk4", *four, size)]
    with open(f"{path}.c", "w", encoding="utf-8") as file:
        file.write("\n".join(text) + "\n")
    subprocess.run(["cc", "-O3", "-march=native", "-shared", "-fPIC", f"{path}.c", "-o", f"{path}.so", "-lm"], check=True)
    library = ctypes.CDLL(f"{path}.so")
    for loop in (library.rk8, library.rk4):
        loop.argtypes, loop.restype = (ctypes.c_double, ctypes.c_long, ctypes.c_void_p), None
    return library
