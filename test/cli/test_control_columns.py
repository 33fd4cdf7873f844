"""Columns of controllers and of the magnetic field, against what other columns give: attitude, rate, momenta of wheels."""
import math
import unittest

from support import CommandLineTest

INERTIA = (90.0, 100.0, 40.0)
TARGET = (0.5, 0.5, 0.5, 0.5)
K, D = 0.1, 0.12
FIELD = (0.3, -0.2, 0.4)
LIMIT = 3.0
BODY = """&body inertia = 90.0, 100.0, 40.0 /
&initial angular_velocity = 0.02, -0.01, 0.03 /
"""
# Powers of two, so that the times of rows are exact.
RUN = """&integrator local_tolerance = 1e-8, end_time = 64.0, method = '{}' /
&output columns = 'quaternion', 'angular_velocity', 'angular_momentum_space', {}, interval = 0.125 /
"""
WHEELS = "".join(f"&wheel axis = {axis}, inertia = 0.05, torque_limit = 2.0, speed_limit = 9000.0 /\n"
                 for axis in ("1, 1, 1", "-1, 1, 1", "1, -1, 1", "1, 1, -1"))
AXES = [tuple(c / math.sqrt(3) for c in axis) for axis in ((1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1))]
LAW = f"&controller law = 'quaternion', attitude_gain = {K}, rate_gain = {D}, target = 0.5, 0.5, 0.5, 0.5"
MAGNETORQUERS = f", by = 'magnetorquers', field = {FIELD[0]}, {FIELD[1]}, {FIELD[2]}"


def product(a, b):
    return (a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0])


def conjugate(q):
    return (q[0], -q[1], -q[2], -q[3])


def to_body(q, v):
    return product(product(conjugate(q), (0.0, *v)), q)[1:]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def error_of(q, target=TARGET):
    """The attitude seen from the target, the short way, and its angle."""
    e = product(conjugate(target), q)
    e = tuple(-x for x in e) if e[0] < 0 else e
    return e, 2 * math.atan2(math.sqrt(dot(e[1:], e[1:])), e[0])


def pointing(row, inertia=INERTIA):
    """The torque that the quaternion law asks for."""
    e = error_of(row["q"])[0]
    return tuple(j * (-K * x - D * w) for j, x, w in zip(inertia, e[1:], row["omega"]))


def clipped(values, limit=LIMIT):
    return tuple(max(-limit, min(limit, value)) for value in values)


def sides(values, limit=LIMIT):
    return [(value >= limit) - (value <= -limit) for value in values]


class ControlColumns(CommandLineTest):
    def rows(self, name, text, *options):
        """Rows by the names of columns; q, omega, momentum, commanded, applied and saturations by shorter ones."""
        self.write(f"{name}.nml", text)
        self.succeed("run", f"{name}.nml", "--quiet", *options)
        header, values = self.history(f"{name}.csv")
        rows = []
        for line in values:
            row = dict(zip(header, line))
            row["q"] = tuple(row[f"q{i}"] for i in range(4))
            row["omega"] = tuple(row[f"omega{i}"] for i in (1, 2, 3))
            row["momentum"] = tuple(row[f"l_{i}"] for i in "xyz")
            for kind in ("commanded", "applied"):
                for n in (1, 2):
                    if f"controller{n}_{kind}1" in row:
                        row[f"{kind}{n}"] = tuple(row[f"controller{n}_{kind}{i}"] for i in (1, 2, 3))
            rows.append(row)
        return rows

    def equal(self, actual, expected, scale=1.0):
        """Equal to round-off: each is some dozens of products and sums of numbers of that size."""
        for a, b in zip(actual, expected):
            self.assertAlmostEqual(a, b, delta=1e-13 * scale)

    def check_field(self, rows):
        for row in rows:
            self.equal([row[f"B{i}"] for i in (1, 2, 3)], to_body(row["q"], FIELD))

    def check_samples(self, rows, law, sample):
        """Commands are what the law asked for at the last sample before a row, cut off; saturations are counted."""
        held = law(rows[0])
        before, count = [0, 0, 0], 0
        self.assertLess(min(max(abs(x) for x in law(row)) for row in rows), LIMIT)
        for row in rows:
            # The sample of time 0 is taken before the first row; others behind the row of their time.
            if row is rows[0]:
                count += sum(side != 0 for side in sides(held))
                before = sides(held)
            self.equal(row["commanded1"], held, 10.0)
            self.equal(row["applied1"], clipped(held), 10.0)
            self.assertEqual(row["controller1_saturations"], count)
            if row["t"] % sample == 0 and row is not rows[0]:
                held = law(row)
                count += sum(a != 0 and a != b for a, b in zip(sides(held), before))
                before = sides(held)
        self.assertGreater(count, 1)

    def test_samples_of_a_torque_are_those_of_the_law(self):
        for method in ("taylor", "nielsen_krenk", "rk8", "dop853"):
            rows = self.rows("sampled", LAW + f", sample = 0.5, limit = {LIMIT} /\n" + BODY +
                             RUN.format(method, "'controller1', 'pointing_error1'"))
            self.check_samples(rows, pointing, 0.5)
            for row in rows:
                self.assertAlmostEqual(row["pointing_error1"], error_of(row["q"])[1], delta=1e-13)
            # The torque, constant in the body, turns the momentum: by Simpson's rule over two rows, of the fourth order.
            for a, b, c in zip(rows[:-2:4], rows[1:-1:4], rows[2::4]):
                rates = [to_body(conjugate(row["q"]), c["applied1"]) for row in (a, b, c)]
                for i in range(3):
                    self.assertAlmostEqual(c["momentum"][i] - a["momentum"][i],
                                           0.25 / 6 * (rates[0][i] + 4 * rates[1][i] + rates[2][i]), delta=1e-6)

    def test_samples_of_magnets_are_moments(self):
        def moment(row):
            b = to_body(row["q"], FIELD)
            return tuple(x / dot(b, b) for x in cross(b, pointing(row)))

        rows = self.rows("magnetorquers", LAW + MAGNETORQUERS + f", sample = 0.25, limit = {LIMIT} /\n" + BODY +
                         RUN.format("taylor", "'controller1', 'magnetic_field'"))
        self.check_samples(rows, moment, 0.25)
        self.check_field(rows)

    def test_motors_give_what_is_applied(self):
        # The momentum of a wheel without friction changes by the torque of its motor alone; two controllers share them.
        second = LAW.replace("0.5, 0.5, 0.5, 0.5", "1, 0, 0, 0").replace(str(K), "0.02")
        columns = "'controller1', 'controller2', " + ", ".join(f"'wheel{i}'" for i in (1, 2, 3, 4))
        for laws, names in (([LAW], "'controller1', " + columns[len("'controller1', 'controller2', "):]), ([LAW, second], columns)):
            text = WHEELS + "".join(law + ", by = 'wheels', sample = 0.5 /\n" for law in laws) + BODY
            rows = self.rows("wheels", text + RUN.format("taylor", names))
            limited = False
            for a, b in zip(rows, rows[1:]):
                motors = [(b[f"wheel{i}_momentum"] - a[f"wheel{i}_momentum"]) / 0.125 for i in (1, 2, 3, 4)]
                limited = limited or max(map(abs, motors)) > 1.999
                given = [-sum(u * axis[i] for u, axis in zip(motors, AXES)) for i in range(3)]
                shown = [sum(b[f"applied{n}"][i] for n in range(1, len(laws) + 1)) for i in range(3)]
                for i in range(3):
                    self.assertAlmostEqual(shown[i], given[i], delta=1e-11)
            self.assertTrue(limited)
            held = pointing(rows[0])
            for row in rows:
                self.equal(row["commanded1"], held, 10.0)
                if row["t"] % 0.5 == 0:
                    held = pointing(row) if row is not rows[0] else held
            if len(laws) == 1:
                self.check_motor_counts(rows)

    def check_motor_counts(self, rows):
        """Each time a motor comes to its limit counts: u = -S⁺τ, here S⁺ = 3/4 Sᵀ."""
        count, before = 0, [0] * 4
        for row in rows[:1] + [row for row in rows if (row["t"] - 0.125) % 0.5 == 0]:
            now = sides([-0.75 * dot(axis, row["commanded1"]) for axis in AXES], 2.0)
            count += sum(a != 0 and a != b for a, b in zip(now, before))
            before = now
            self.assertEqual(row["controller1_saturations"], count)
        self.assertGreater(count, 2)

    def test_laws_at_all_times_are_cut_off_at_their_limits(self):
        for method in ("dop853", "nielsen_krenk"):
            rows = self.rows("always", LAW + f", limit = {LIMIT}, start = 4.0, stop = 60.0 /\n" + BODY +
                             RUN.format(method, "'controller1', 'pointing_error1'"))
            before, count = [0, 0, 0], 0
            for row in rows:
                acts = 4 <= row["t"] <= 60
                asked = pointing(row) if acts else (0.0, 0.0, 0.0)
                self.equal(row["commanded1"], asked, 10.0)
                # Within rounding of the event a component may be on either side of its limit.
                self.equal(row["applied1"], clipped(asked), 10.0 if method == "dop853" else 1e6)
                now = sides(asked)
                count += sum(a != 0 and a != b for a, b in zip(now, before))
                before = now
                self.assertEqual(row["controller1_saturations"], count, row["t"])
            self.assertGreater(count, 2)

    def test_motors_at_all_times_give_what_is_applied(self):
        columns = "'controller1', " + ", ".join(f"'wheel{i}'" for i in (1, 2, 3, 4))
        rows = self.rows("motors", WHEELS + LAW + ", by = 'wheels' /\n" + BODY + RUN.format("dop853", columns))
        before, count = [0] * 4, 0
        for row in rows:
            self.equal(row["commanded1"], pointing(row), 10.0)
            motors = [-0.75 * dot(axis, row["commanded1"]) for axis in AXES]
            given = [-sum(u * axis[i] for u, axis in zip(clipped(motors, 2.0), AXES)) for i in range(3)]
            self.equal(row["applied1"], given, 100.0)
            now = sides(motors, 2.0)
            count += sum(a != 0 and a != b for a, b in zip(now, before))
            before = now
            self.assertEqual(row["controller1_saturations"], count)
        self.assertGreater(count, 2)
        # And the wheels turn by it: the middle of three rows, by Simpson's rule.
        for a, b, c in zip(rows, rows[1:], rows[2:]):
            if any(sides([-0.75 * dot(axis, row["commanded1"]) for axis in AXES], 1.9) != [0] * 4 for row in (a, b, c)):
                continue
            for i, axis in enumerate(AXES, 1):
                u = [-0.75 * dot(axis, row["commanded1"]) for row in (a, b, c)]
                self.assertAlmostEqual(c[f"wheel{i}_momentum"] - a[f"wheel{i}_momentum"],
                                       0.25 / 6 * (u[0] + 4 * u[1] + u[2]), delta=1e-5)

    def test_b_dot_opposes_the_change_of_the_field(self):
        rows = self.rows("bdot", f"&controller law = 'bdot', gain = 30, field = {FIELD[0]}, {FIELD[1]}, {FIELD[2]} /\n" + BODY +
                         RUN.format("dop853", "'controller1', 'magnetic_field'"))
        self.check_field(rows)
        for row in rows:
            b = to_body(row["q"], FIELD)
            self.equal(row["commanded1"], [-30 * x for x in cross(b, row["omega"])], 10.0)
            self.assertEqual(row["applied1"], row["commanded1"])
            self.assertEqual(row["controller1_saturations"], 0)

    def test_gain_matrices_are_given_row_by_row(self):
        rows = self.rows("matrix", "&controller law = 'quaternion', attitude_gain_matrix = 2, 3, 4, 0.5, -1, 0.7,\n"
                         "rate_gain_matrix = 45, 9, -9, -4, 50, 1, 3, 1, 20 /\n" + BODY + RUN.format("dop853", "'controller1'"))
        k, d = ((2, 0.5, -1), (0.5, 3, 0.7), (-1, 0.7, 4)), ((45, 9, -9), (-4, 50, 1), (3, 1, 20))
        for row in rows:
            e = error_of(row["q"], (1.0, 0.0, 0.0, 0.0))[0]
            self.equal(row["commanded1"], [-dot(a, e[1:]) - dot(b, row["omega"]) for a, b in zip(k, d)], 10.0)

    def test_the_field_of_the_earth_is_a_tilted_dipole(self):
        g = (-1410.3e-9, 4545.5e-9, -29350.0e-9)
        for frame in ("inertial", "lvlh"):
            rows = self.rows("earth", f"&orbit altitude = 500e3, inclination = 1.2, frame = '{frame}' /\n"
                             "&earth_field moment = 0, 0, 0, epoch_angle = 0.7 /\n" + BODY +
                             RUN.format("dop853", "'magnetic_field', 'orbit', 'lvlh_attitude'").replace("64.0", "512.0")
                             .replace("0.125", "64.0"))
            for row in rows:
                place = [row[f"orbit_{i}"] for i in "xyz"]
                r = math.sqrt(dot(place, place))
                up = [x / r for x in place]
                rotated = 0.7 + 7.292115e-5 * row["t"]
                moment = (g[0] * math.cos(rotated) - g[1] * math.sin(rotated), g[0] * math.sin(rotated) + g[1] * math.cos(rotated), g[2])
                b = [(6371.2e3 / r)**3 * (3 * dot(moment, up) * u - m) for u, m in zip(up, moment)]
                shown = [row[f"B{i}"] for i in (1, 2, 3)]
                if frame == "inertial":
                    self.equal(shown, to_body(row["q"], b), 1e-4)
                else:
                    # The axes of a circular orbit: z down, y against the normal.
                    down = [-u for u in up]
                    normal = (0.0, -math.sin(1.2), math.cos(1.2))
                    across = [-n for n in normal]
                    ahead = cross(across, down)
                    self.equal(shown, to_body(row["q"], [dot(b, axis) for axis in (ahead, across, down)]), 1e-4)

    def test_switches_and_interruptions_keep_the_counts(self):
        scene = LAW + ", {}, name = 'law' /\n" + BODY + "&event when = 'q1', crosses = 0.2, switch = 'law off' /\n" \
            "&event when = 'q1', crosses = 0.25, switch = 'law on' /\n" + RUN.format("dop853", "'controller1', 'pointing_error1'")
        for kind in (f"sample = 0.5, limit = {LIMIT}", f"limit = {LIMIT}"):
            rows = self.rows("whole", scene.format(kind))
            off = [row for row in rows if row["commanded1"] == (0, 0, 0)]
            self.assertTrue(all(row["applied1"] == (0, 0, 0) for row in off))
            self.assertGreater(len(off), 1)
            self.assertGreater(rows[-1]["controller1_saturations"], 2)
            whole = self.read("whole.csv")
            for steps in ("9", "14", "21"):
                self.fail_with(3, "run", "whole.nml", "--quiet", "--output", "part.csv", "--checkpoint", "a.ck", "--max-steps", steps)
                self.succeed("run", "whole.nml", "--quiet", "--output", "part.csv", "--resume", "a.ck")
                self.assertEqual(self.read("part.csv"), whole)

    def test_sweeps_have_the_last_row_of_runs(self):
        columns = "'controller1', 'pointing_error1', 'magnetic_field'"
        scene = LAW + MAGNETORQUERS + f", sample = 0.5, limit = {LIMIT} /\n" + BODY + \
            RUN.format("taylor", columns) + "&ensemble members = 4, histories = 1, 2, 3, 4 /\n" \
            "&vary key = 'initial.angular_velocity', distribution = 'normal', sigma = 0.01, 0.01, 0.01 /\n"
        self.write("many.nml", scene)
        self.succeed("sweep", "many.nml", "--quiet", "--csv", "rows.csv")
        header, rows = self.history("rows.csv")
        first = header.index("t")
        for member, row in enumerate(rows, 1):
            names, history = self.history(f"many.member{member}.csv")
            self.assertEqual(header[first:first + len(names)], names)
            self.assertEqual(row[first:first + len(names)], history[-1])

    def test_angles_in_degrees(self):
        text = LAW + ", sample = 0.5 /\n" + BODY + RUN.format("taylor", "'pointing_error1'").replace(
            "'quaternion', 'angular_velocity', 'angular_momentum_space', ", "")
        self.write("degrees.nml", text)
        self.succeed("run", "degrees.nml", "--quiet", "--set", "output.degrees=.true.")
        header, rows = self.history("degrees.csv")
        self.assertEqual(header, ["t", "pointing_error1_deg"])
        self.assertAlmostEqual(rows[0][1], 120.0, delta=1e-12)


if __name__ == "__main__":
    unittest.main()
