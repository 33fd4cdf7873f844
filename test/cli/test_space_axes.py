"""Space axes of satellites: the same motion in inertial and in LVLH axes, by random scenes, with a conversion of its own."""
import math
import random
import unittest

from support import CommandLineTest, share_of

MU = 3.986004418e14
SEED = 20
CASES = share_of(100)
METHODS = ("method = 'nielsen_krenk', order = 8", "method = 'nielsen_krenk', order = 8, formulation = 'reduced'",
           "method = 'rk8'", "method = 'rk8', conserve = .false.", "method = 'dop853'", "method = 'dop853', conserve = .true.",
           "method = 'taylor', series_order = 18", "method = 'taylor', conserve = .true., series_order = 18")


def product(p, q):
    return (p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
            p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1], p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0])


def about(axis, angle):
    q = [math.cos(angle / 2), 0.0, 0.0, 0.0]
    q[axis] = math.sin(angle / 2)
    return q


def rotated(q, v):
    return product(product(q, (0.0, *v)), (q[0], -q[1], -q[2], -q[3]))[1:]


def numbers(values):
    return ", ".join(map(repr, values))


class Orbit:
    """A circular orbit by its elements."""

    def __init__(self, draw):
        self.a = 6.6e6 * 10 ** draw.uniform(0, 0.9)
        self.inclination, self.raan = draw.uniform(0, math.pi), draw.uniform(-3, 3)
        self.periapsis, self.anomaly = draw.uniform(-3, 3), draw.uniform(-3, 3)
        self.rate = math.sqrt(MU / self.a ** 3)

    def group(self, frame):
        return (f"&orbit semi_major_axis = {self.a!r}, inclination = {self.inclination!r}, raan = {self.raan!r}, "
                f"argument_of_periapsis = {self.periapsis!r}, mean_anomaly = {self.anomaly!r}{frame} /\n")

    def axes(self, t):
        """LVLH axes in inertial ones: z-x-z to the radius, then x forward, y against the normal, z to the centre."""
        q = product(product(about(3, self.raan), about(1, self.inclination)), about(3, self.periapsis + self.anomaly + self.rate * t))
        return product(q, (0.5, -0.5, -0.5, 0.5))

    def normal(self):
        return rotated(self.axes(0.0), (0.0, -1.0, 0.0))


def body_of(draw):
    """Inertia of a random solid, with products."""
    sides = sorted(draw.uniform(0.5, 2.0) ** 2 for _ in range(3))
    moments = [sides[1] + sides[2], sides[0] + sides[2], sides[0] + sides[1]]
    draw.shuffle(moments)
    small = [0.1 * min(moments) * draw.uniform(-1, 1) for _ in range(3)]
    return f"&body inertia_tensor = {numbers([10 * x for x in moments + small])}, check_triangle = .false. /\n"


def effects_of(draw, rate):
    """Effects that are constant in the LVLH frame, and some that are not; whether all are."""
    text = ""
    if draw.random() < 0.4:
        text += f"&third_degree third_moments = {numbers([draw.uniform(-5, 5) for _ in range(10)])} /\n"
    if draw.random() < 0.4:
        text += f"&rotor momentum = {numbers([20 * rate * draw.uniform(-1, 1) for _ in range(3)])} /\n"
    if draw.random() < 0.4:
        axis = [draw.uniform(-1, 1) for _ in range(3)]
        text += (f"&wheel axis = {numbers(axis)}, inertia = 0.01, speed = {draw.uniform(-0.5, 0.5)!r}, "
                 f"torque = {1e-2 * rate ** 2 * draw.uniform(-1, 1)!r}, friction = {1e-3 * rate!r} /\n")
    if draw.random() < 0.7:
        return text, True
    if draw.random() < 0.5:
        text += f"&torque body = {numbers([5 * rate ** 2 * draw.uniform(-1, 1) for _ in range(3)])} /\n"
    else:
        text += ("&controller law = 'quaternion', target_from = 'lvlh', "
                 f"attitude_gain = {rate ** 2!r}, rate_gain = {rate!r}, sample = {0.2 / rate!r} /\n")
    return text, False


class SpaceAxes(CommandLineTest):
    def run_case(self, number, frame, columns):
        """The history of a random satellite, its orbit, and whether all of its effects are constant in the LVLH frame."""
        draw = random.Random(SEED * 1000 + number)
        orbit = Orbit(draw)
        effects, constant = effects_of(draw, orbit.rate)
        method = draw.choice(METHODS[:6] if "controller" in effects else METHODS)
        start = (f"&initial roll_pitch_yaw = {numbers([draw.uniform(-1, 1) for _ in range(3)])}, attitude_from = 'lvlh', "
                 f"rate_from = '{draw.choice(('lvlh', 'inertial'))}', "
                 f"angular_velocity = {numbers([orbit.rate * draw.uniform(-3, 3) for _ in range(3)])} /\n")
        step = draw.uniform(0.01, 0.02) / orbit.rate
        self.write(f"{frame or 'none'}.nml", body_of(draw) + orbit.group(frame and f", frame = '{frame}'") + "&gravity_gradient /\n" + effects
                   + start + f"&integrator {method}, time_step = {step!r}, end_time = {200 * step!r} /\n"
                   f"&output columns = {columns}, every = 20 /\n")
        self.succeed("run", f"{frame or 'none'}.nml", "--quiet")
        return self.history(f"{frame or 'none'}.csv"), orbit, constant

    def test_random_satellites_move_alike_in_both_axes(self):
        columns = "'quaternion', 'angular_velocity', 'angular_momentum_space', 'energy', 'time_dependent_work'"
        for number in range(CASES):
            with self.subTest(case=number):
                (header, inertial), orbit, constant = self.run_case(number, "", columns)
                (names, lvlh), _, _ = self.run_case(number, "lvlh", columns)
                # Steps in the LVLH frame are the same steps; others have errors of order 8.
                bound = 2e-12 if constant else 1e-9
                first, rate = inertial[0], orbit.normal()
                for row, other in zip(inertial, lvlh):
                    at, there = dict(zip(header, row)), dict(zip(names, other))
                    q = product(orbit.axes(at["t"]), [there[f"q{i}"] for i in range(4)])
                    sign = math.copysign(1, sum(a * at[f"q{i}"] for i, a in enumerate(q)))
                    for i in range(4):
                        self.assertAlmostEqual(at[f"q{i}"], sign * q[i], delta=bound)
                    for i in (1, 2, 3):
                        self.assertAlmostEqual(at[f"omega{i}"], there[f"omega{i}"], delta=bound * 10 * orbit.rate)
                    seen = rotated(orbit.axes(at["t"]), [there[f"l_{x}"] for x in "xyz"])
                    size = 500 * orbit.rate
                    for x, l in zip("xyz", seen):
                        self.assertAlmostEqual(at[f"l_{x}"], l, delta=bound * size)
                    self.assertAlmostEqual(at["total"], there["total"], delta=bound * size * orbit.rate)
                    # The balance closes in both axes, by the work of the potential in inertial ones: the change of ω·l.
                    for one in (at, there):
                        self.assertLess(abs(one["energy_residual"]), bound * size * orbit.rate)
                    if constant:
                        moved = sum(orbit.rate * rate[i] * (at[f"l_{x}"] - first[header.index(f"l_{x}")]) for i, x in enumerate("xyz"))
                        self.assertAlmostEqual(at["time_dependent_work"], moved, delta=bound * size * orbit.rate)

    def test_the_default_is_inertial(self):
        columns = "'quaternion', 'energy', 'time_dependent_work'"
        for number in range(3):
            default, explicit = self.run_case(number, "", columns), self.run_case(number, "inertial", columns)
            self.assertEqual(default[0], explicit[0])

    def write_both(self, text):
        """A satellite in both axes; `text` follows its groups."""
        for frame in ("inertial", "lvlh"):
            self.write(f"{frame}.nml", "&body inertia = 90, 100, 40 /\n&gravity_gradient /\n"
                       f"&orbit altitude = 500e3, inclination = 1.2, raan = 0.4, frame = '{frame}' /\n"
                       "&initial roll_pitch_yaw = 0.1, -0.2, 0.3, attitude_from = 'lvlh', rate_from = 'lvlh', angular_velocity = 3*0 /\n" + text)

    def test_derivatives_are_the_same(self):
        for method in METHODS:
            with self.subTest(method=method):
                self.write_both("&free key = 'initial.attitude' /\n&free key = 'initial.angular_velocity' /\n&free key = 'body.inertia.2' /\n"
                                f"&integrator {method}, time_step = 40, end_time = 4000 /\n"
                                "&output columns = 'angular_velocity', 'sensitivities', every = 50 /\n")
                found = []
                for frame in ("inertial", "lvlh"):
                    self.succeed("run", f"{frame}.nml", "--quiet")
                    found.append(self.history(f"{frame}.csv"))
                self.assertEqual(found[0][0], found[1][0])
                for k, name in enumerate(found[0][0]):
                    largest = max(abs(row[k]) for row in found[0][1])
                    for row, other in zip(found[0][1], found[1][1]):
                        self.assertAlmostEqual(row[k], other[k], delta=1e-11 * largest, msg=name)

    def test_derivatives_by_the_orbit_are_differences(self):
        """The path is the same in both axes; its derivatives with respect to the elements are taken in inertial axes."""
        self.write_both("&integrator order = 8, time_step = 40, end_time = 4000 /\n&output columns = 'angular_velocity', every = 100 /\n")
        step, ends = 1e-5, []
        for shift in (-step, step):
            self.succeed("run", "inertial.nml", "--quiet", "--set", f"orbit.inclination={1.2 + shift!r}", "--set", "initial.attitude_from=space",
                         "--set", "initial.roll_pitch_yaw=0.1,-0.2,0.3", "--set", "initial.rate_from=inertial", "--output", "moved.csv")
            ends.append(self.history("moved.csv")[1][-1])
        self.succeed("run", "inertial.nml", "--quiet", "--set", "initial.attitude_from=space", "--set", "initial.rate_from=inertial",
                     "--set", "free.key=orbit.inclination", "--set", "output.columns=sensitivities", "--output", "free.csv")
        header, rows = self.history("free.csv")
        for i in (1, 2, 3):
            value = rows[-1][header.index(f"d_omega{i}/d_orbit.inclination")]
            difference = (ends[1][i] - ends[0][i]) / (2 * step)
            self.assertAlmostEqual(value, difference, delta=1e-6 * abs(difference) + 1e-12)

    def test_sweeps_and_exponents_are_the_same(self):
        self.write_both("&ensemble members = 5, seed = 3 /\n&vary key = 'initial.angular_velocity', distribution = 'normal', sigma = 3*2e-4 /\n"
                        "&chaos exponents = 1 /\n&integrator order = 6, time_step = 40, end_time = 8000 /\n"
                        "&output columns = 'angular_velocity' /\n")
        found = []
        for frame in ("inertial", "lvlh"):
            self.succeed("sweep", f"{frame}.nml", "--quiet", "--csv", f"{frame}.csv")
            found.append(self.history(f"{frame}.csv"))
        self.assertEqual(found[0][0], found[1][0])
        for row, other in zip(found[0][1], found[1][1]):
            for name, a, b in zip(found[0][0], row, other):
                self.assertAlmostEqual(a, b, delta=1e-9 * max(abs(a), 1e-6), msg=name)

    def test_the_same_steps_are_certified(self):
        for step, some in ((40, False), (1500, True)):
            self.write_both(f"&integrator order = 2, time_step = {step}, end_time = 60000 /\n")
            lines = [[line.split(None, 2)[2] for line in self.succeed("run", f"{frame}.nml").stderr.splitlines() if "not certified" in line]
                     for frame in ("inertial", "lvlh")]
            self.assertEqual(lines[0], lines[1])
            self.assertEqual(bool(lines[0]), some)


if __name__ == "__main__":
    unittest.main()
