"""&free in a scene that nutate runs: derivatives, standard deviations and covariances in the columns of the history."""
import math
import os
import shutil
import unittest

from support import CommandLineTest, in_turn

# A top with a wheel, and a magnet whose field is skew, at rows inside of steps.
SYSTEM = """&body inertia_tensor = 3.0, 2.0, 1.5, 0.1, -0.05, 0.2, mass = 2.0, center_of_mass = 0.1, 0.05, 0.2 /
&initial quaternion = 0.8, 0.4, -0.4, 0.2, angular_velocity = 0.4, -0.3, 2.0 /
&gravity acceleration = 0.0, 1.0, -9.8, name = 'weight' /
&damping coefficient = 0.1, 0.2, 0.05 /
"""
WHEEL = "&wheel axis = 0.0, 0.6, 0.8, inertia = 0.1, speed = 3.0, friction = 0.01 /\n"
STEPS = "&integrator method = 'nielsen_krenk', order = 4, time_step = 0.05, end_time = 1.0 /\n"
FREE = "&free key = 'initial.attitude', 'initial.angular_velocity', sigma = 0.01, 0.02, 0.03, 0.1, 0.2, 0.3 /\n" \
       "&free key = 'body.inertia_tensor.1', 'body.mass', sigma = 0.02, 0.05 /\n" \
       "&free key = 'gravity.acceleration.2', 'damping.coefficient.3' /\n"
# Rows at ends of steps and inside of them.
OUTPUT = "&output times = 0.0, 0.033, 0.5, 0.72, 1.0 /\n"
STATE = ("rotation1", "rotation2", "rotation3", "omega1", "omega2", "omega3")


def product(p, q):
    (a, *u), (b, *v) = p, q
    return [a * b - sum(x * y for x, y in zip(u, v))] + \
        [a * v[i] + b * u[i] + u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3] for i in range(3)]


def rotation(q, r):
    """The rotation vector, body axes, from the attitude q to r."""
    s, *v = product([q[0], *(-x for x in q[1:])], r)
    length = math.sqrt(sum(x * x for x in v))
    return [x * (2 * math.atan2(length, s) / length if length else 2.0) for x in v]


def rotated(q, axis, angle):
    return product(q, [math.cos(angle / 2)] + [math.sin(angle / 2) if i == axis else 0.0 for i in range(3)])


class Sensitivities(CommandLineTest):
    def rows(self, scene, *settings):
        """The rows of a run, each as a dictionary."""
        self.succeed("run", scene, "--quiet", "--output", "rows.csv", *settings)
        header, rows = self.history("rows.csv")
        return [dict(zip(header, row)) for row in rows]

    def differences(self, scene, changed, step, *settings):
        """Central differences of attitude, angular velocity and momenta of wheels in the rows of runs, extrapolated."""
        def slope(h):
            more, less = (self.rows(scene, "--set", changed(sign * h), *settings) for sign in (1, -1))
            return [[x / (2 * h) for x in rotation(*([row[f"q{i}"] for i in range(4)] for row in (b, a)))]
                    + [(a[name] - b[name]) / (2 * h) for name in a if name.startswith("omega") or name.endswith("momentum")]
                    for a, b in zip(more, less)]
        return [[(4 * x - y) / 3 for x, y in zip(*rows)] for rows in zip(slope(step), slope(2 * step))]

    def compare(self, scene, key, changed, step, *settings):
        """Rounding of differences is some 1e-13 over the step, their error step^4: below 1e-9 of the size of the numbers."""
        found = self.rows("free.nml", *settings)
        wanted = self.differences(scene, changed, step, *settings)
        names = [f"d_{name}/d_{key}" for name in (*STATE, "wheel1_momentum") if f"d_{name}/d_{key}" in found[0]]
        size = max(abs(x) for row in wanted for x in row)
        self.assertGreater(size, 1e-3)
        for row, numbers in zip(found, wanted):
            self.assertEqual(len(names), len(numbers))
            for name, number in zip(names, numbers):
                self.assertAlmostEqual(row[name] / size, number / size, delta=2e-9, msg=f"{name} at {row['t']}")

    @unittest.skipIf(os.environ.get("NUTATE_SLOW_BUILD"), "a build with floating-point traps ends at an overflow")
    def test_a_derivative_that_overflows_is_named(self):
        # Exactly about the intermediate axis: derivatives grow without end.
        self.write("unstable.nml", """
&body inertia = 1.0, 2.0, 3.0 /
&initial angular_velocity = 0.0, 1.0, 0.0 /
&integrator method = 'rk8', time_step = 0.25, end_time = 3000.0 /
&free key = 'initial.angular_velocity' /
&output columns = 'quaternion', 'sensitivities', every = 40 /
""")
        self.fail_with(3, "run", "unstable.nml", "--quiet",
                       says=("a value of the history, d_rotation1/d_initial.angular_velocity.1, is not finite",))

    def test_columns_are_derivatives_by_the_numbers_of_the_scene(self):
        columns = "&output times = 0.0, 0.033, 0.5, 0.72, 1.0, columns = 'quaternion', 'angular_velocity', 'wheel1'"
        self.write("plain.nml", SYSTEM + WHEEL + STEPS + columns + " /\n")
        self.write("free.nml", SYSTEM + WHEEL + STEPS + FREE + "&free key = 'wheel.speed' /\n" + columns + ", 'sensitivities' /\n")
        q = [0.8, 0.4, -0.4, 0.2]
        values = {"initial.attitude.2": lambda h: "initial.quaternion=" + ",".join(map(repr, rotated(q, 1, h))),
                  "initial.angular_velocity.1": lambda h: f"initial.angular_velocity={0.4 + h!r},-0.3,2.0",
                  "body.inertia_tensor.1": lambda h: f"body.inertia_tensor={3 + h!r},2.0,1.5,0.1,-0.05,0.2",
                  "body.mass": lambda h: f"body.mass={2 + h!r}",
                  "gravity.acceleration.2": lambda h: f"gravity.acceleration=0,{1 + h!r},-9.8",
                  "damping.coefficient.3": lambda h: f"damping.coefficient=0.1,0.2,{0.05 + h!r}",
                  "wheel.speed": lambda h: f"wheel.speed={3 + h!r}"}
        for key, changed in values.items():
            with self.subTest(key=key):
                self.compare("plain.nml", key, changed, 2e-3)

    def test_every_method_has_them(self):
        self.write("plain.nml", SYSTEM + STEPS + OUTPUT)
        self.write("free.nml", SYSTEM + STEPS + FREE + OUTPUT)
        free = "&body inertia = 3.0, 2.0, 1.5 /\n&initial quaternion = 0.8, 0.4, -0.4, 0.2, angular_velocity = 0.4, -0.3, 2.0 /\n"
        self.write("alone.nml", free + STEPS + OUTPUT)
        self.write("alone_free.nml", free + STEPS + OUTPUT + "&free key = 'body.inertia', 'initial.angular_velocity' /\n")
        for method, key in (("rk8", "body.mass"), ("rk4", "body.mass"), ("dop853", "initial.angular_velocity.1")):
            with self.subTest(method=method):
                changed = {"body.mass": lambda h: f"body.mass={2 + h!r}",
                           "initial.angular_velocity.1": lambda h: f"initial.angular_velocity={0.4 + h!r},-0.3,2.0"}[key]
                self.compare("plain.nml", key, changed, 2e-3, "--set", f"integrator.method={method}", "--unset",
                             "integrator.order")
        self.write("free.nml", self.read("alone_free.nml"))
        for method in ("exact", "taylor"):
            with self.subTest(method=method):
                self.compare("alone.nml", "body.inertia.2", lambda h: f"body.inertia=3,{2 + h!r},1.5", 2e-3,
                             "--set", f"integrator.method={method}", "--unset", "integrator.order")

    def test_derivatives_cross_switches(self):
        # The weight is switched off, and the wheel comes to the limit of its speed, before row 3.
        steps = "&integrator method = 'rk8', time_step = 0.02, end_time = 1.0 /\n"
        wheel = WHEEL.replace("friction = 0.01", "torque = 0.5, speed_limit = 6.0")
        event = "&event when = 'omega1', crosses = 0.5, switch = 'weight off' /\n"
        output = "&output times = 0.0, 0.033, 0.5, 0.72, 1.0, columns = 'quaternion', 'angular_velocity', 'wheel1'"
        self.write("plain.nml", SYSTEM + wheel + steps + event + output + " /\n")
        self.write("free.nml", SYSTEM + wheel + steps + event + FREE + output + ", 'sensitivities' /\n")
        page = self.succeed("run", "plain.nml").stderr
        for text in (r"'omega1' +once, at t = 0\.165", r"upper limit of wheel 1 +once, at t = 0\.493"):
            self.assertRegex(page, text)
        for key, changed in (("body.mass", lambda h: f"body.mass={2 + h!r}"),
                             ("damping.coefficient.3", lambda h: f"damping.coefficient=0.1,0.2,{0.05 + h!r}")):
            with self.subTest(key=key):
                self.compare("plain.nml", key, changed, 2e-4)

    def test_rows_inside_of_long_adaptive_steps(self):
        free = "&body inertia = 3.0, 2.0, 1.5 /\n&initial quaternion = 0.8, 0.4, -0.4, 0.2, angular_velocity = 0.4, -0.3, 2.0 /\n" \
            "&free key = 'body.inertia', 'initial.angular_velocity' /\n" + OUTPUT
        self.write("free.nml", free + STEPS.replace("'nielsen_krenk', order = 4", "'exact'"))
        wanted = self.rows("free.nml")
        # Rounding, the local tolerance of some steps.
        for steps, bound in (("method = 'exact', accuracy = 1e-9", 1e-13), ("method = 'taylor', local_tolerance = 1e-13", 1e-11),
                             ("method = 'nielsen_krenk', order = 8, formulation = 'reduced', local_tolerance = 1e-12", 1e-9)):
            with self.subTest(steps=steps):
                self.write("free.nml", free + f"&integrator {steps}, end_time = 1.0 /\n")
                for row, other in zip(self.rows("free.nml"), wanted):
                    for name in other:
                        if name.startswith("d_"):
                            self.assertAlmostEqual(row[name], other[name], delta=bound, msg=f"{name} at {row['t']}")

    def test_all_other_columns_keep_their_bytes(self):
        for steps in (STEPS, STEPS.replace("time_step = 0.05", "local_tolerance = 1e-9"),
                      STEPS.replace("time_step = 0.05", "accuracy = 1e-7"), "&integrator accuracy = 1e-9, end_time = 1.0 /\n"):
            system = SYSTEM if "method" in steps else "&body inertia = 3, 2, 1 /\n&initial angular_velocity = 1, 2, 3 /\n"
            free = FREE if "method" in steps else "&free key = 'body.inertia', sigma = 0.1, 0.1, 0.1 /\n"
            with self.subTest(steps=steps):
                self.write("plain.nml", system + steps)
                self.write("free.nml", system + steps + free)
                self.succeed("run", "plain.nml", "--quiet")
                self.succeed("run", "free.nml", "--quiet")
                plain, wide = (self.read(name).splitlines() for name in ("plain.csv", "free.csv"))
                self.assertEqual(plain, [",".join(line.split(",")[:plain[0].count(",") + 1]) for line in wide])
                self.assertGreater(wide[0].count(","), plain[0].count(","))

    def test_deviations_and_covariances_are_those_of_the_linear_motion(self):
        self.write("free.nml", SYSTEM + STEPS + FREE +
                   "&output every = 5, columns = 'sensitivities', 'standard_deviations', 'covariance' /\n")
        sigmas = dict(zip([f"initial.attitude.{i}" for i in (1, 2, 3)] + [f"initial.angular_velocity.{i}" for i in (1, 2, 3)]
                          + ["body.inertia_tensor.1", "body.mass"], (0.01, 0.02, 0.03, 0.1, 0.2, 0.3, 0.02, 0.05)))
        for row in self.rows("free.nml"):
            for i, first in enumerate(STATE):
                for second in STATE[i:]:
                    parts = [sigma ** 2 * row[f"d_{first}/d_{key}"] * row[f"d_{second}/d_{key}"] for key, sigma in sigmas.items()]
                    # Rounding of the sum, and that of the numbers in it.
                    self.assertAlmostEqual(row[f"covariance_{first}_{second}"], sum(parts), delta=4e-15 * sum(map(abs, parts)))
                self.assertAlmostEqual(row[f"sigma_{first}"], math.sqrt(row[f"covariance_{first}_{first}"]),
                                       delta=4e-15 * row[f"sigma_{first}"])
        self.assertAlmostEqual(self.rows("free.nml")[0]["sigma_rotation2"], 0.02, delta=1e-15)

    def test_the_deviation_is_the_scatter_of_disturbed_runs(self):
        # All corners of the cube of three deviations: their scatter is that of the linear motion, but for terms of sigma^3.
        self.write("free.nml", SYSTEM + STEPS + OUTPUT + "&free key = 'initial.angular_velocity', sigma = 1e-4, 2e-4, 3e-4 /\n")
        self.write("plain.nml", SYSTEM + STEPS + OUTPUT)
        corners = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        runs = [self.rows("plain.nml", "--set", "initial.angular_velocity=" + ",".join(
            repr(w + s * c) for w, s, c in zip((0.4, -0.3, 2.0), (1e-4, 2e-4, 3e-4), corner)))[-1] for corner in corners]
        last = self.rows("free.nml")[-1]
        q = [last[f"q{i}"] for i in range(4)]
        for i in range(3):
            scatter = math.sqrt(sum(rotation(q, [run[f"q{k}"] for k in range(4)])[i] ** 2 for run in runs) / 8)
            self.assertAlmostEqual(last[f"sigma_rotation{i + 1}"] / scatter, 1.0, delta=1e-5)
            scatter = math.sqrt(sum((run[f"omega{i + 1}"] - last[f"omega{i + 1}"]) ** 2 for run in runs) / 8)
            self.assertAlmostEqual(last[f"sigma_omega{i + 1}"] / scatter, 1.0, delta=1e-5)

    def test_a_resumed_run_has_the_same_bytes(self):
        for steps in ("time_step = 0.05", "local_tolerance = 1e-8"):
            with self.subTest(steps=steps):
                self.write("free.nml", SYSTEM + WHEEL + STEPS.replace("time_step = 0.05", steps) + FREE)
                self.succeed("run", "free.nml", "--quiet", "--output", "whole.csv")
                self.fail_with(3, "run", "free.nml", "--quiet", "--output", "part.csv", "--checkpoint", "ck", "--max-steps", "4")
                self.succeed("run", "free.nml", "--quiet", "--resume", "ck")
                self.assertEqual(self.read("part.csv"), self.read("whole.csv"))

    def test_what_is_free_by_an_override_is_as_in_the_scene(self):
        self.write("free.nml", SYSTEM + STEPS + OUTPUT + "&free key = 'initial.attitude' /\n")
        self.write("plain.nml", SYSTEM + STEPS + OUTPUT)
        self.assertEqual(self.rows("plain.nml", "--set", "free.key='initial.attitude'"), self.rows("free.nml"))

    def test_degrees(self):
        self.write("free.nml", SYSTEM + STEPS + FREE + OUTPUT)
        plain = self.rows("free.nml")[-1]
        turned_ = self.rows("free.nml", "--set", "output.degrees=true")[-1]
        for name in STATE:
            self.assertAlmostEqual(turned_[f"sigma_{name}_deg"], math.degrees(plain[f"sigma_{name}"]), delta=1e-13)
            key = "body.mass"
            self.assertAlmostEqual(turned_[f"d_{name}_deg/d_{key}"], math.degrees(plain[f"d_{name}/d_{key}"]), delta=1e-12)

    def test_which_columns_there_are(self):
        self.write("free.nml", SYSTEM + STEPS + "&free key = 'body.mass' /\n")
        self.write("rates.csv", "t,omega1\n0.5,1\n")
        usual = "t,q0,q1,q2,q3,omega1,omega2,omega3,kinetic,potential,total,work,energy_residual,norm_error,orthogonality"
        derivatives = "".join(f",d_{name}/d_body.mass" for name in STATE)
        deviations = "".join(f",sigma_{name}" for name in STATE)
        measured = ["--set", "measurement.file=rates.csv", "--set", "measurement.columns=omega1"]
        for settings, header in (([], usual + derivatives), (["--set", "free.sigma=0.1"], usual + derivatives + deviations),
                                 (["--set", "output.columns=quaternion"], "t,q0,q1,q2,q3"),
                                 (["--set", "free.sigma=0.1", "--set", "output.columns=standard_deviations"], "t" + deviations),
                                 (measured, usual),
                                 (measured + ["--set", "output.columns=sensitivities"], "t" + derivatives)):
            with self.subTest(settings=settings):
                self.succeed("run", "free.nml", "--quiet", *settings)
                self.assertEqual(self.read("free.csv").splitlines()[0], header)
                self.assertIn(" " + header + "\n", self.succeed("check", "free.nml", *settings).stdout)

    def test_files_of_events_have_all_columns_but_these(self):
        self.write("free.nml", SYSTEM + STEPS + FREE + "&event when = 'omega1', crosses = 0.0 /\n")
        self.succeed("run", "free.nml", "--quiet")
        header, rows = self.history_of_events("free.events.csv")
        self.assertEqual(header[-1], "orthogonality")
        self.assertTrue(rows)
        self.assertTrue(all(len(row) == len(header) for row in rows))

    def history_of_events(self, name):
        lines = [line.split(",") for line in self.read(name).splitlines()]
        return lines[0], lines[1:]

    def test_check_names_what_is_free(self):
        self.write("free.nml", SYSTEM + STEPS + FREE)
        page = self.succeed("check", "free.nml").stdout
        for text in (r"\nfree\n", r"  initial\.attitude\.1 +0, sigma = 0\.01\n", r"  body\.mass +2, sigma = 0\.05\n",
                     r"  gravity\.acceleration\.2 +1\n"):
            self.assertRegex(page, text)
        self.assertNotIn("no column shows them", page)
        page = self.succeed("check", "free.nml", "--set", "output.columns=quaternion").stdout
        self.assertRegex(page, r"\n  derivatives +none: no column shows them\n")

    def compare_scene(self, text, values):
        """All derivatives of a scene by keys, whose settings at a distance from their value are given with the step."""
        wheel = ", 'wheel1'" if "&wheel" in text else ""
        self.write("plain.nml", text + f"&output times = 0.0, 1.0, 3.0, columns = 'quaternion', 'angular_velocity'{wheel} /\n")
        for key, (changed, step) in values.items():
            self.write("free.nml", text + f"&output times = 0.0, 1.0, 3.0, columns = 'sensitivities' /\n&free key = '{key}' /\n")
            with self.subTest(key=key):
                self.compare("plain.nml", key, changed, step)

    def test_orbits_and_what_follows_them(self):
        points = "1.0, 0.9, 0.1, 0.2, 2.0, -0.3, 0.5, 0.1, 1.5, 0.1, -0.4, -0.6"
        start = "&initial roll_pitch_yaw = 10, -20, 30, attitude_from = 'lvlh', angular_velocity = 0.2, -0.1, 0.3, " \
                "rate_from = 'lvlh', frame = 'space', degrees = .true. /\n"
        text = ("&body inertia = 4.0, 5.0, 6.0 /\n" + start + "&gravity_gradient /\n&third_degree points = " + points + " /\n"
                "&orbit semi_major_axis = 2.0, eccentricity = 0.3, inclination = 40, mean_anomaly = 25, mu = 3.0, degrees = .true. /\n"
                "&integrator method = 'rk8', time_step = 0.05, end_time = 3.0 /\n")
        moved = [float(x) for x in points.split(", ")]
        self.compare_scene(text, {
            "orbit.semi_major_axis": (lambda h: f"orbit.semi_major_axis={2 + h!r}", 1e-3),
            "orbit.eccentricity": (lambda h: f"orbit.eccentricity={0.3 + h!r}", 1e-3),
            "orbit.inclination": (lambda h: f"orbit.inclination={40 + h!r}", 0.1),
            "orbit.mean_anomaly": (lambda h: f"orbit.mean_anomaly={25 + h!r}", 0.1),
            "orbit.mu": (lambda h: f"orbit.mu={3 + h!r}", 1e-3),
            "third_degree.points.5": (lambda h: "third_degree.points=" + ",".join(
                repr(x + h * (i == 4)) for i, x in enumerate(moved)), 1e-3),
            "third_degree.points.8": (lambda h: "third_degree.points=" + ",".join(
                repr(x + h * (i == 7)) for i, x in enumerate(moved)), 1e-3)})
        # Effects whose directions move with the orbit, by series too.
        lines = ("&force axes = 'lvlh', body_point = -0.2, 0.5, 0.3, force = 0.5, -0.4, 0.7 /\n"
                 "&earth_field moment = 0.4, -0.3, 0.5, coefficients = 3e-20, -1e-20, 5e-20 /\n")
        self.compare_scene((text + lines).replace("'rk8', time_step = 0.05", "'taylor', time_step = 0.1"), {
            "orbit.inclination": (lambda h: f"orbit.inclination={40 + h!r}", 0.1),
            "orbit.eccentricity": (lambda h: f"orbit.eccentricity={0.3 + h!r}", 1e-3),
            "orbit.mu": (lambda h: f"orbit.mu={3 + h!r}", 1e-3)})
        # A circular orbit in its own axes, whose rate is that of the start too.
        circle = text.replace(", eccentricity = 0.3", "").replace("'rk8'", "'nielsen_krenk', order = 8").replace("'space'", "'body'")
        self.compare_scene(circle, {
            "orbit.semi_major_axis": (lambda h: f"orbit.semi_major_axis={2 + h!r}", 1e-3),
            "orbit.mu": (lambda h: f"orbit.mu={3 + h!r}", 1e-3)})
        rows = []
        for size in ("altitude = 1.5e6", "semi_major_axis = 7878137.0"):
            self.write("free.nml", circle.replace("semi_major_axis = 2.0", size).replace("mu = 3.0", "mu = 1e20")
                       + f"&free key = 'orbit.{size.split()[0]}' /\n&output columns = 'sensitivities' /\n")
            rows.append([list(row.values()) for row in self.rows("free.nml")])
        self.assertEqual(*rows)
        self.assertGreater(abs(rows[0][-1][4]), 1e-9)

    def test_gains_and_forces(self):
        text = ("&body inertia_tensor = 4.0, 5.0, 6.0, 0.1, -0.05, 0.2 /\n"
                "&initial quaternion = 0.8, 0.4, -0.4, 0.2, angular_velocity = 0.4, -0.3, 0.6 /\n"
                "&controller law = 'quaternion', attitude_gain = 0.3, rate_gain = 0.2, start = 0.72, limit = 1.1 /\n"
                "&torque space = 0.5, -0.2, 0.8, frequency = 0.2, start = 0.513, stop = 2.031 /\n"
                "&force axes = 'space', body_point = 0.5, 0.2, -0.4, force = -0.3, 0.8, 0.6, stop = 1.517 /\n"
                "&force axes = 'space', body_point = 0.1, -0.3, 0.2, force = 1.0, 0.4, -0.5 /\n"
                "&wheel axis = 0.0, 0.6, 0.8, inertia = 0.1, speed = 3.0, torque = 0.2, start = 0.41, stop = 2.2, friction = 0.01 /\n")
        values = {
            "controller.attitude_gain": (lambda h: f"controller.attitude_gain={0.3 + h!r}", 1e-3),
            "controller.rate_gain": (lambda h: f"controller.rate_gain={0.2 + h!r}", 1e-3),
            "controller.limit": (lambda h: f"controller.limit={1.1 + h!r}", 1e-3),
            "force.1.force.2": (lambda h: f"force.1.force=-0.3,{0.8 + h!r},0.6", 1e-3),
            "force.2.force.2": (lambda h: f"force.2.force=1.0,{0.4 + h!r},-0.5", 1e-3),
            "controller.start": (lambda h: f"controller.start={0.72 + h!r}", 1e-3),
            "torque.start": (lambda h: f"torque.start={0.513 + h!r}", 1e-3),
            "torque.stop": (lambda h: f"torque.stop={2.031 + h!r}", 1e-3),
            "force.1.stop": (lambda h: f"force.1.stop={1.517 + h!r}", 1e-3),
            "wheel.start": (lambda h: f"wheel.start={0.41 + h!r}", 1e-3),
            "wheel.stop": (lambda h: f"wheel.stop={2.2 + h!r}", 1e-3)}
        for turn, method in enumerate(("'rk8'", "'nielsen_krenk', order = 8", "'dop853'")):
            some = {name: value for number, (name, value) in enumerate(values.items()) if in_turn(number + turn)}
            with self.subTest(method=method):
                self.compare_scene(text + f"&integrator method = {method}, time_step = 0.02, end_time = 3.0 /\n", some)

    def test_what_has_no_derivative_is_refused(self):
        self.write("free.nml", SYSTEM + STEPS + FREE)
        lines = self.read("free.nml").splitlines()
        last = len(lines) + 1
        for line, at, text in (
                ("&free key = 'event.crosses' /", last, "no group that 'event.crosses' means"),
                ("&free key = 'integrator.end_time' /", last, "no derivative with respect to 'integrator.end_time'"),
                ("&orbit altitude = 5e5, sun = 1, 0, 0 /\n&free key = 'orbit.sun' /", last + 1, "no derivative with respect to orbit.sun"),
                ("&orbit altitude = 5e5, eccentricity = 0, frame = 'lvlh' /\n&free key = 'orbit.eccentricity' /", last + 1,
                 "no derivative with respect to orbit.eccentricity"),
                ("&controller law = 'quaternion', attitude_gain = 0.1, rate_gain = 0.1, target = 1, 0, 0, 0 /\n"
                 "&free key = 'controller.target' /", last + 1, "no derivative with respect to controller.target"),
                ("&controller law = 'quaternion', attitude_gain = 0.1, rate_gain = 0.1, sample = 0.1 /", last, "controller that samples"),
                ("&output columns = 'covarance' /", last, "covariance")):
            with self.subTest(line=line):
                self.write("bad.nml", "\n".join([*lines, line]) + "\n")
                for command in ("run", "check"):
                    self.fail_with(2, command, "bad.nml", says=[f"bad.nml:{at}: ", text])
        self.assertEqual(self.names(), ["bad.nml", "box.nml", "free.nml", "top.nml"])
        spring = "&spring body_point = 0.1, 0.2, 0.3, anchor = 1, 0, 0, stiffness = 2, rest_length = 0 /\n&free key = 'spring.rest_length' /\n"
        self.write("bad.nml", SYSTEM + spring + STEPS.replace("'nielsen_krenk', order = 4", "'taylor'"))
        self.fail_with(2, "run", "bad.nml", says=["bad.nml:7: method = 'taylor' has no sensitivities of spring (expected"])
        self.write("bad.nml", SYSTEM + STEPS + "&output columns = 'sensitivities' /\n")
        self.fail_with(2, "run", "bad.nml", says=["bad.nml:6: ", "need free parameters (expected &free)"])
        self.write("bad.nml", SYSTEM + STEPS + "&free key = 'body.mass' /\n&output columns = 'covariance' /\n")
        self.fail_with(2, "run", "bad.nml", says=["bad.nml:7: ", "need standard deviations (expected sigma in &free)"])

    def test_only_run_writes_them(self):
        ensemble = "&ensemble members = 2 /\n&vary key = 'body.mass', distribution = 'normal', mean = 2.0, sigma = 0.1 /\n"
        self.write("free.nml", SYSTEM + STEPS + FREE + ensemble)
        self.succeed("sweep", "free.nml", "--quiet", "--csv", "rows.csv")
        self.assertNotIn("d_", self.read("rows.csv").replace("end_", ""))
        for command in ("sweep", "cost"):
            self.fail_with(2, command, "free.nml", "--set", "output.columns=sensitivities",
                           says=["only nutate run writes sensitivities, covariances and indicators of chaos"])

    def test_panels_of_a_picture(self):
        if shutil.which("gnuplot") is None:
            self.skipTest("no gnuplot")
        self.write("free.nml", SYSTEM + WHEEL + STEPS + "&free key = 'body.mass', sigma = 0.1 /\n")
        self.succeed("run", "free.nml", "--quiet")
        self.succeed("plot", "free.csv", "--output", "free.svg", "--columns", "sensitivities,standard_deviations")
        picture = self.read("free.svg")
        for text in ("rotation by body.mass (rad per unit)", "Ω by body.mass (rad/s per unit)", "σ of the rotation (rad)"):
            self.assertIn(text, picture)
