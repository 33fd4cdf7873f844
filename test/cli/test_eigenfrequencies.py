"""Small motions about equilibria: their eigenfrequencies, known to 14 digits and more, by samples of histories."""
import cmath
import math
import sys
import unittest

from support import CommandLineTest

# Circular orbit at 500 km: its rate, rad/s.
ORBIT_RATE = 0.001106783446334940580568
# Gyrocompass: its axis above the horizon at rest, rad.
TILT = 0.0017058357338493677566
# Its nutation, the swing of its weight and its way about north, as s of exp(st), rad/s.
NUTATION, SWING, COMPASS = 253.56562123029690127j, 2.8591936121212783004j, 0.0012388334515157991101j
# The turn of the Earth about the north of the place, rad/s.
NORTHWARD = 7.292115e-5 * math.cos(math.radians(50.0))
AXIS, UP = (0.0, math.cos(TILT), math.sin(TILT)), (0.0, -math.sin(TILT), math.cos(TILT))


def product(p, q):
    """p q of quaternions."""
    return [p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
            p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1], p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]]


def column(q, k):
    """Where body axis k + 1 points to."""
    unit = [0.0] + [float(i == k) for i in range(3)]
    return product(product(q, unit), [q[0], -q[1], -q[2], -q[3]])[1:]


def rotated(q, vector):
    """q after a turn by a rotation vector, space axes."""
    angle = math.sqrt(sum(x * x for x in vector))
    part = math.sin(angle / 2) / angle if angle else 0.5
    return product([math.cos(angle / 2)] + [part * x for x in vector], q)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def across(axis):
    """Two directions across one that has no part along x and z both, and across each other."""
    first = [axis[1], -axis[0], 0.0] if axis[0] else [1.0, 0.0, 0.0]
    return first, [axis[1] * first[2] - axis[2] * first[1], axis[2] * first[0] - axis[0] * first[2],
                   axis[0] * first[1] - axis[1] * first[0]]


def two_cosines(motions):
    """cos(w h) of the two pairs of frequencies of motions sampled at h: x[k+2] + x[k-2] = a (x[k+1] + x[k-1]) - b x[k],
    a = 2 (c1 + c2), b = 2 + 4 c1 c2; a and b by least squares."""
    rows = [(x[k + 1] + x[k - 1], -x[k], x[k + 2] + x[k - 2]) for x in motions for k in range(2, len(x) - 2)]
    uu, uv, vv = (sum(f(u, v) for u, v, _ in rows) for f in
                  (lambda u, v: u * u, lambda u, v: u * v, lambda u, v: v * v))
    uw, vw = sum(u * w for u, _, w in rows), sum(v * w for _, v, w in rows)
    a, b = (uw * vv - vw * uv) / (uu * vv - uv * uv), (vw * uu - uw * uv) / (uu * vv - uv * uv)
    root = cmath.sqrt(a * a / 4 - (b - 2))
    return [(a / 2 - root) / 2, (a / 2 + root) / 2]


def one_cosine(x):
    """The same of one pair: x[k+1] + x[k-1] = 2 c x[k]."""
    rows = [(x[k], x[k + 1] + x[k - 1]) for k in range(1, len(x) - 1)]
    return sum(u * w for u, w in rows) / (2 * sum(u * u for u, _ in rows))


def changes(x):
    """Second differences, which leave out what does not change and what changes in proportion to time."""
    return [a - 2 * b + c for a, b, c in zip(x, x[1:], x[2:])]


class Eigenfrequencies(CommandLineTest):
    # Size of the motions, rad, and the rounding of the samples over that. What is left of their nonlinearity, the size to
    # the fourth, is less.
    SIZE = 1e-4
    ALLOWED = sys.float_info.epsilon / SIZE

    def motion(self, scene, columns, interval, n):
        """Columns of n samples at an interval, s."""
        self.write("small.nml", f"{scene}&integrator method = 'taylor', local_tolerance = 1e-15, end_time = "
                   f"{interval * (n - 1)!r} /\n&output columns = {columns}, interval = {interval!r} /\n")
        self.succeed("run", "small.nml", "--quiet")
        rows = self.history("small.csv")[1]
        self.assertEqual(len(rows), n)
        return list(zip(*rows))[1:]

    def linear(self, motions, size=SIZE):
        """What is linear in their size of motions, which are given for a size: odd parts at two sizes, without their
        cubes."""
        parts = [motions(s) for s in (size, -size, 2 * size, -2 * size)]
        return [[(8 * (a - b) - (c - d)) / (12 * size) for a, b, c, d in zip(*rows)] for rows in zip(*parts)]

    def check_cosines(self, found, roots, interval, allowed=ALLOWED):
        """That cosines are those of frequencies, as s of exp(st), rad/s, in any order."""
        expected = [cmath.cosh(s * interval) for s in roots]
        far = min(max(abs(x - y) for x, y in zip(found, order)) for order in (expected, expected[::-1]))
        self.assertLessEqual(far, allowed, f"{found} for {expected}")

    def test_satellites_at_rest_on_the_orbit(self):
        h, n = 400.0, 7

        def angles(inertia, start):
            return self.motion(f"&body inertia = {inertia} /\n&orbit semi_major_axis = 6878137.0, frame = 'lvlh' /\n&gravity_gradient /\n"
                               "&initial attitude_from = 'lvlh', rate_from = 'lvlh', angular_velocity = 0.0, 0.0, 0.0, "
                               f"roll_pitch_yaw = {start} /\n", "'lvlh_attitude'", h, n)[:3]

        for inertia, roll_yaw, pitch in (
                ("90.0, 100.0, 40.0", (0.00052704854599149512696j, 0.0018977065687099530571j), 0.001355527349639826501449j),
                ("100.0, 90.0, 40.0", (0.00048822076332878697892, 0.0017741652422513617521j), 0.001565228160416907587427j),
                ("40.0, 100.0, 90.0", (0.00074787792769128820868j, 0.0013373619553724140739j), 0.001355527349639826501449)):
            roll, none, yaw = self.linear(lambda s, j=inertia: angles(j, f"{s!r}, 0.0, {s!r}"))
            self.assertLessEqual(max(abs(x) for x in none), self.ALLOWED)
            self.check_cosines(two_cosines([roll, yaw]), roll_yaw, h)
            swing = self.linear(lambda s, j=inertia: angles(j, f"0.0, {s!r}, 0.0"))[1]
            self.check_cosines([one_cosine(swing)], [pitch], h)

    def axis_motion(self, moments, momentum, axis, about, interval):
        """Of a body that spins about its axis 3 on the orbit: components of that axis across where it could rest, after a
        turn by a rotation vector from there."""
        half = math.sqrt(2 * (1 + axis[2]))
        q = rotated([0.0, axis[0] / half, axis[1] / half, (axis[2] + 1) / half], about)
        rate = [-ORBIT_RATE * column(q, k)[1] for k in range(2)] + [momentum / moments[1]]
        scene = f"&body inertia = {moments[0]}, {moments[0]}, {moments[1]} /\n&orbit semi_major_axis = 6878137.0, frame = 'lvlh' /\n" \
            f"&gravity_gradient /\n&initial quaternion = {str(q)[1:-1]}, angular_velocity = {str(rate)[1:-1]} /\n"
        places = [column(q, 2) for q in zip(*self.motion(scene, "'quaternion'", interval, 7))]
        return [[dot(place, side) for place in places] for side in across(axis)]

    def test_spinning_satellites_of_likins_and_pringle(self):
        h = 400.0
        for moments, axis, momentum, roots in (
                # Cylindrical fast rod and slow rod, hyperbolic disk and rod, conical rod; the roots in units of the orbit's
                # rate.
                ((100.0, 40.0), (0.0, -1.0, 0.0), 0.44271337853397623223, (0.68223429327669j, 2.7811070402049j)),
                ((100.0, 40.0), (0.0, -1.0, 0.0), 0.088542675706795246445,
                 (-0.71149684891561 + 0.35528547115923j, 0.71149684891561 + 0.35528547115923j)),
                ((60.0, 100.0), (0.6, -0.8, 0.0), 0.053125605424077147867, (0.51290185446604j, 1.6543674584823j)),
                ((100.0, 40.0), (0.6, -0.8, 0.0), 0.088542675706795246445, (0.70632018388955j, 1.1396877652102)),
                ((100.0, 40.0), (0.0, -0.8, 0.6), 0.24791949197902669005, (0.85388505926406j, 1.577491776703j))):
            motions = []
            for side in across(axis):
                motions += self.linear(lambda s, m=moments, l=momentum, a=axis, v=side:
                                       self.axis_motion(m, l, a, [s * x for x in v], h))
            # A fit of two pairs to so short a motion makes more of the rounding.
            self.check_cosines(two_cosines(motions), [ORBIT_RATE * s for s in roots], h, 16 * self.ALLOWED)

    def compass(self, about, rate, interval, n=7):
        """Of a gyrocompass without damping, from a turn by a rotation vector from its rest and a rate against the Earth:
        azimuth of axis 2, to the east, and the part of axis 1 across where axis 2 rests, downwards."""
        q = rotated([math.cos(TILT / 2), math.sin(TILT / 2), 0.0, 0.0], about)
        scene = "&body inertia = 0.05, 0.06, 0.07, mass = 5.0, center_of_mass = 0.0, 0.0, -0.01 /\n" \
            "&rotor momentum = 0.0, 15.0, 0.0 /\n&rotating_frame latitude = 50.0, degrees = .true. /\n" \
            f"&gravity acceleration = 0.0, 0.0, -9.81 /\n&initial rate_from = 'frame', quaternion = {str(q)[1:-1]}, " \
            f"angular_velocity = {str(rate)[1:-1]} /\n"
        attitudes = list(zip(*self.motion(scene, "'quaternion'", interval, n)))
        return [[math.atan2(*column(q, 1)[:2]) for q in attitudes], [-dot(column(q, 0), UP) for q in attitudes]]

    def test_gyrocompass(self):
        # The axis is pushed aside and nutates; what the Earth does to it meanwhile is all but linear in time.
        still, h = [0.0, 0.0, 0.0], 0.004
        azimuth = self.linear(lambda s: self.compass(still, [0.0, 0.0, 250.0 * s], h))[0]
        self.check_cosines([one_cosine(changes(azimuth))], [NUTATION], h)
        # The weight swings about the axis, which comes to rest a little aside. Digits of the momentum, of which the rotor
        # has the most, are lost of the rate.
        size, h = 1e-3, 0.4
        swing = self.linear(lambda s: self.compass([s * x for x in AXIS], still, h), size)[1]
        digits = sys.float_info.epsilon * 15.0 / (0.06 * abs(SWING) * size)
        self.check_cosines([one_cosine(changes(swing))], [SWING], h, 4 * digits)
        # The axis goes about north; it starts without nutation, with no rate about axis 1 against the stars. Rounding in the
        # 1e4 to 1e5 steps that the nutation asks for leaves some 1e-12 rad.
        size, h = 1e-2, 600.0
        azimuth = self.linear(lambda s: self.compass([0.0, 0.0, -s], [NORTHWARD * math.sin(s), 0.0, 0.0], h, 3), size)[0]
        self.check_cosines([one_cosine(azimuth)], [COMPASS], h, 5e-12 / size)


if __name__ == "__main__":
    unittest.main()
