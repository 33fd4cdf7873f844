"""nutate fit: what it prints and writes, and what it refuses."""
import csv
import math
import os
import re
import shutil

from support import ROOT, CommandLineTest

GYRO = """&body inertia = 5.4, 19.5, 17.0 /
&initial angular_velocity = 3.0, 1.0, 5.0 /
&integrator local_tolerance = 1e-10, end_time = 1.0 /
&free key = 'initial.angular_velocity' /
&free key = 'body.inertia.1', 'body.inertia.2' /
&measurement file = 'gyro.csv', columns = 'omega1', 'omega2', 'omega3', sigma = 0.01 /
"""
# By a method whose steps are as long as the motion permits.
STEPS = GYRO.replace("local_tolerance", "method = 'nielsen_krenk', order = 8, formulation = 'reduced', local_tolerance")


class Fit(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("truth.nml", "&body inertia = 5, 20, 17 /\n&initial angular_velocity = 3, 1, 5 /\n"
                   "&integrator time_step = 0.001, end_time = 1.0 /\n&output every = 50, columns = 'angular_velocity', 'euler' /\n")
        self.succeed("run", "truth.nml", "--quiet", "--output", "gyro.csv")
        self.write("gyro.nml", GYRO)

    def test_a_history_is_a_file_of_measurements(self):
        page = self.succeed("fit", "gyro.nml").stdout
        for text in ("gyro.nml: gyro", "63 residuals in 1 measurement, 5 parameters", "58 degrees of freedom", "body.inertia.1",
                     "±"):
            self.assertIn(text, page)

    def test_the_fitted_scene_has_the_fitted_numbers_and_is_a_scene(self):
        self.succeed("fit", "gyro.nml", "--quiet")
        self.succeed("check", "gyro.fit.nml")
        with open(self.path("gyro.fit.nml"), encoding="utf-8") as file:
            line = next(line for line in file if "inertia" in line)
        j = [float(word) for word in line.split("=")[1].split(",")]
        self.assertAlmostEqual(j[0], 5.0, delta=1e-3)
        self.assertAlmostEqual(j[1], 20.0, delta=1e-3)
        self.assertEqual(j[2], 17.0)
        again = self.succeed("fit", "gyro.fit.nml", "--set", "fit.start=scene").stdout
        self.assertIn("fit                 0 iterations from start 1 of 1", again)

    def test_zero_has_no_sign(self):
        self.write("still.nml", "&body inertia = 5, 20, 17 /\n&initial angular_velocity = 0.1, 0, 10 /\n"
                   "&integrator accuracy = 1e-8, end_time = 2 /\n&output columns = 'roll_pitch_yaw', interval = 0.02 /\n")
        self.succeed("run", "still.nml", "--quiet")
        self.write("still.fit.nml", "&body inertia = 5, 20, 17 /\n&initial angular_velocity = 0.11, 0, 10.01 /\n"
                   "&integrator accuracy = 1e-8, end_time = 2 /\n&free key = 'initial.angular_velocity' /\n"
                   "&measurement file = 'still.csv', columns = 'roll', 'yaw', sigma = 0.01 /\n")
        self.assertRegex(self.succeed("fit", "still.fit.nml", "--output", "found.nml").stdout, r" 0\.0+ ±")

    def test_when_a_thruster_fired(self):
        burn = "&torque body = 0.4, -0.3, 0.8, start = {}, stop = {} /\n"
        body = "&body inertia = 2.0, 3.0, 4.0 /\n&initial angular_velocity = 0.3, 0.2, 0.1 /\n"
        run = "&integrator method = 'rk8', time_step = 0.02, end_time = 3.0 /\n"
        self.write("truth.nml", body + burn.format(0.713, 1.871) + run + "&output every = 5, columns = 'angular_velocity' /\n")
        self.succeed("run", "truth.nml", "--quiet", "--output", "burn.csv")
        self.write("burn.nml", body + burn.format(0.5, 2.2) + run + "&free key = 'torque.start', 'torque.stop' /\n"
                   "&measurement file = 'burn.csv', columns = 'omega1', 'omega2', 'omega3', sigma = 0.01 /\n")
        page = self.succeed("fit", "burn.nml").stdout
        values = {name: float(value) for name, value in re.findall(r"(torque\.\w+) +(\S+) ±", page)}
        self.assertAlmostEqual(values["torque.start"], 0.713, delta=1e-6)
        self.assertAlmostEqual(values["torque.stop"], 1.871, delta=1e-6)

    def test_a_number_that_its_key_limits_ends_at_the_limit(self):
        wheel = "&body inertia = 5, 20, 17 /\n&initial angular_velocity = 3, 1, 5 /\n&wheel axis = 1, 0, 0, inertia = 1, speed = 5, {} /\n"
        run = "&integrator local_tolerance = 1e-9, end_time = 4 /\n"
        # A motor that accelerates the wheel looks like friction below zero.
        self.write("motor.nml", wheel.format("torque = 0.1") + run + "&output interval = 0.1, columns = 'angular_velocity' /\n")
        self.write("friction.nml", wheel.format("friction = 0.3") + run + "&free key = 'wheel.friction', 'initial.angular_velocity' /\n"
                   "&measurement file = 'motor.csv', columns = 'omega1', 'omega2', 'omega3', sigma = 0.1 /\n")
        # The same attitude has a pole 0.02 beyond the right angle.
        tumbling = ("&body inertia = 1, 2, 2.5 /\n&initial tumbling = 'sam', precession_period = 30, period_axis = 'short', rotation_period = 100,"
                    " pole = {}, {}, precession_angle = {} /\n&integrator method = 'exact', time_step = 1, end_time = 20 /\n")
        self.write("beyond.nml", tumbling.format(0.2 + math.pi, math.pi / 2 - 0.02, math.pi))
        self.write("pole.nml", tumbling.format(0.2, 1.5, 0) + "&free key = 'initial.pole' /\n"
                   "&measurement file = 'beyond.csv', columns = 'q0', 'q1', 'q2', 'q3', sigma = 0.1 /\n")
        for truth, name, key, limit in (("motor", "friction", r"friction = (\S+)", 0.0), ("beyond", "pole", r"pole = \S+, (\S+)", math.pi / 2)):
            self.succeed("run", truth + ".nml", "--quiet")
            self.succeed("fit", name + ".nml", "--quiet")
            self.succeed("check", name + ".fit.nml")
            self.assertEqual(float(re.search(key, self.read(name + ".fit.nml")).group(1).rstrip(",")), limit)

    def test_the_fitted_scene_reads_its_files_from_any_folder(self):
        for folder in ("one", "one/two", "other"):
            os.mkdir(self.path(folder))
        shutil.copy(self.path("gyro.csv"), self.path("other/gyro.csv"))
        shutil.copy(self.path("gyro.nml"), self.path("other/gyro.nml"))
        for scene, output in (("gyro.nml", "one/two/fit.nml"), ("gyro.nml", self.path("one/fit.nml")), ("other/gyro.nml", "fit.nml"),
                              ("other/gyro.nml", "other/fit.nml"), ("other/gyro.nml", "one/two/../fit.nml")):
            with self.subTest(scene=scene, output=output):
                self.succeed("fit", scene, "--quiet", "--output", output)
                self.succeed("check", output)
        with open(self.path("other/fit.nml"), encoding="utf-8") as file:
            self.assertIn("file = 'gyro.csv'", file.read())
        self.write("other/boom.csv", "t (s),J1 (kg m2),J2 (kg m2),J3 (kg m2)\n0,5,20,17\n1,5,21,18\n")
        self.write("other/boom.nml", "&body inertia_table = 'boom.csv', inertia_scale = 1.0 /\n&initial angular_velocity = 0.5, 0.0, 5.0 /\n"
                   "&torque body = 0.0, 0.0, 1.0 /\n&integrator accuracy = 1e-8, end_time = 1 /\n&output interval = 0.1 /\n")
        self.succeed("run", "other/boom.nml", "--output", "other/rates.csv")
        with open(self.path("other/boom.nml"), "a", encoding="utf-8") as file:
            file.write("&free key = 'body.inertia_scale' /\n&measurement file = 'rates.csv', columns = 'omega3', sigma = 0.1 /\n")
        self.succeed("fit", "other/boom.nml", "--quiet", "--output", "one/boom.nml", "--csv", "residuals.csv")
        self.succeed("check", "one/boom.nml")

    def rewrite(self, header, change=lambda row: row, end=""):
        """Writes the measured rates to other.csv, as another logger has them, and a scene other.nml that reads them."""
        with open(self.path("gyro.csv"), encoding="utf-8", newline="") as file:
            rows = [[float(row[name]) for name in ("t", "omega1", "omega2", "omega3")] for row in csv.DictReader(file)]
        self.write("other.csv", header + "\n" + "".join(",".join(map(repr, change(row))) + "\n" for row in rows) + end)
        self.write("other.nml", GYRO.replace("gyro.csv", "other.csv"))

    def test_units_of_headers_are_converted(self):
        plain = self.values("gyro")
        degree = math.pi / 180
        for header, factors in (("t (ms),omega1 (deg/s),omega2 (rpm),omega3 [rad/s]", (1e3, 1 / degree, 30 / math.pi, 1)),
                                ("t(min),omega1 (mrad/s),omega2 (deg/h),omega3 (deg/d)",
                                 (1 / 60, 1e3, 3600 / degree, 86400 / degree)),
                                ("t (s),omega1,omega2,omega3", (1, 1, 1, 1))):
            with self.subTest(header):
                self.rewrite(header, lambda row: [factor * number for factor, number in zip(factors, row)])
                for one, other in zip(plain, self.values("other")):
                    self.assertAlmostEqual(one, other, delta=1e-7 * max(abs(one), 1))

    def test_headers_that_say_something_else_are_rejected(self):
        for header, says in (
                ("t (s),omega1 (deg),omega2,omega3", "other.csv:1: 'omega1 (deg)' has an unknown unit (expected rad/s, mrad/s, deg/s"),
                ("t (year),omega1,omega2,omega3", "other.csv:1: 't (year)' has an unknown unit (expected s, ms, us, ns, min, h, d)"),
                ("t,omega1,omega1,omega3", "other.csv:1: there are two columns 'omega1' (expected one)")):
            with self.subTest(header):
                self.rewrite(header)
                self.fail_with(2, "fit", "other.nml", says=(says,))
        self.rewrite("t,omega1,omega2,omega3", end="1.0,inf,0,0\n")
        self.fail_with(2, "fit", "other.nml", says=("other.csv:23: 'inf' is not finite (expected a number)",))
        self.write("axis.csv", "t,x (m),y,z\n0,1,0,0\n")
        self.write("axis.nml", GYRO.replace("gyro.csv", "axis.csv").replace("'omega1', 'omega2', 'omega3'", "'x', 'y', 'z', direction = 3*1"))
        self.fail_with(2, "fit", "axis.nml", says=("axis.csv:1: 'x (m)' has a unit (expected none)",))

    def test_logs_may_repeat_a_time_and_end_in_blank_lines(self):
        plain = self.values("gyro")
        self.rewrite("t,omega1,omega2,omega3", end="1.0,{!r},{!r},{!r}\n\n \n".format(*self.last_rates()))
        for one, other in zip(plain, self.values("other")):
            self.assertAlmostEqual(one, other, delta=1e-7 * max(abs(one), 1))
        self.assertIn("66 residuals", self.succeed("fit", "other.nml").stdout)

    def last_rates(self):
        with open(self.path("gyro.csv"), encoding="utf-8", newline="") as file:
            row = list(csv.DictReader(file))[-1]
        return [float(row[name]) for name in ("omega1", "omega2", "omega3")]

    def test_a_message_of_another_program_is_a_file_of_measurements(self):
        dates = "&scene epoch = '2029-04-13T21:46:12.7', time_system = 'TDB', object = 'box', space_frame = 'ECLIPJ2000' /\n"
        self.write("dated.nml", dates + self.read("truth.nml").replace("'euler'", "'quaternion'"))
        self.succeed("run", "dated.nml", "--quiet", "--output", "dated.csv")
        self.succeed("export", "dated.csv", "--scene", "dated.nml", "--aem", "dated.aem")
        for columns in ("'omega1', 'omega2', 'omega3'", "'q0', 'q1', 'q2', 'q3'"):
            scene = GYRO.replace("'omega1', 'omega2', 'omega3'", columns)
            if "q0" in columns:
                scene = scene.replace("&free key = 'initial.angular_velocity' /", "&free key = 'initial.angular_velocity', 'initial.attitude' /")
            # Before the first record.
            earlier = dates.replace("21:46:12.7", "21:46:12.5")
            for name, head, file in (("rows", dates, "dated.csv"), ("message", dates, "dated.aem"), ("early", earlier, "dated.aem")):
                self.write(name + ".nml", head + scene.replace("gyro.csv", file).replace("end_time = 1.0", "end_time = 3.0"))
            found = [self.values(name) for name in ("rows", "message")]
            for one, other in zip(*found):
                self.assertAlmostEqual(one, other, delta=1e-9 * max(abs(one), 1))
            self.succeed("fit", "early.nml", "--quiet", "--csv", "early.csv")
            with open(self.path("early.csv"), encoding="utf-8", newline="") as file:
                self.assertAlmostEqual(float(next(csv.DictReader(file))["t"]), 0.2, delta=1e-6)

    def values(self, name):
        """The numbers that a fit finds."""
        self.succeed("fit", name + ".nml", "--quiet", "--output", "fitted.nml", "--csv", "fitted.csv")
        text = self.read("fitted.nml")
        return [float(word) for key in ("inertia", "angular_velocity") for word in
                re.search(rf"{key} *=(.*)", text)[1].strip(" /").split(",")]

    def test_a_message_that_does_not_fit_the_scene_is_refused(self):
        dates = "&scene epoch = '2029-04-13T21:46:12.7', time_system = 'TDB', object = 'box', space_frame = 'ICRF' /\n"
        self.write("dated.nml", dates + self.read("truth.nml").replace("'euler'", "'quaternion'"))
        self.succeed("run", "dated.nml", "--quiet", "--output", "dated.csv")
        self.succeed("export", "dated.csv", "--scene", "dated.nml", "--aem", "dated.aem")
        scene = GYRO.replace("gyro.csv", "dated.aem")
        line = scene[:scene.index("dated.aem")].count("\n") + 1
        for head, text, says in (
                ("", scene, f"m.nml:{line}: the records of dated.aem have dates, t = 0 of the scene has none (expected epoch"),
                (dates.replace("ICRF", "EME2000"), scene, "REF_FRAME_A of dated.aem is 'ICRF', not the space_frame of &scene"),
                (dates.replace("12.7", "13.2"), scene, "record 1 of dated.aem: the time of a measurement is outside of the run"),
                (dates, scene.replace("'omega3'", "'phi'"), "dated.aem has no column 'phi' (expected q0 to q3, or omega1 to omega3)"),
                (dates, scene + "&rotating_frame rate = 0, 0, 0.1 /\n", "the space axes rotate, and REF_FRAME_A of dated.aem, 'ICRF', names")):
            with self.subTest(says):
                self.write("m.nml", head + text)
                self.fail_with(2, "fit", "m.nml", says=(says,))
        self.write("dated.aem", self.read("dated.aem").replace("ICRF", "LAB"))
        self.write("m.nml", dates.replace("ICRF", "LAB") + scene + "&rotating_frame rate = 0, 0, 0.1 /\n")
        self.fail_with(2, "fit", "m.nml", says=("the rates of an AEM belong to axes that do not rotate",))
        self.write("dated.aem", self.read("dated.aem").replace("META_STOP", "META_END", 1))
        self.write("m.nml", dates + scene)
        self.fail_with(2, "fit", "m.nml", says=("dated.aem:", "META_END"))

    def test_residuals_are_model_less_measured_over_sigma(self):
        self.succeed("fit", "gyro.nml", "--quiet", "--csv", "r.csv")
        with open(self.path("r.csv"), encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 63)
        self.assertEqual(list(rows[0]), ["measurement", "t", "column", "measured", "model", "residual"])
        for row in rows:
            self.assertAlmostEqual((float(row["model"]) - float(row["measured"])) / 0.01, float(row["residual"]), delta=1e-9)
            self.assertLess(abs(float(row["residual"])), 1e-2)

    def test_toutatis(self):
        for name in ("toutatis.nml", "toutatis_radar.csv"):
            shutil.copy(ROOT / "scenes" / name, self.path(name))
        page = self.succeed("fit", "toutatis.nml").stdout
        for text in ("34.247025 for 43 degrees of freedom", "2.98 ± 0.21", "3.22 ± 0.25"):
            self.assertIn(text, page)

    def test_what_cannot_be_known_is_named(self):
        page = self.succeed("fit", "gyro.nml", "--set", "free.2.key=body.inertia").stdout
        self.assertRegex(page, r"body\.inertia\.3 +\S+ +not identifiable")
        self.assertRegex(page, r"not identifiable +body\.inertia\.1 1, body\.inertia\.2 1, body\.inertia\.3 1")

    def test_a_rate_of_zero_is_known_as_well_as_others(self):
        scene = ("&body inertia = 1, 1.2, 1.5 /\n&initial angular_velocity = 0, 0, {} /\n"
                 "&integrator local_tolerance = 1e-11, end_time = 20 /\n&output interval = 2, columns = 'quaternion' /\n")
        self.write("truth.nml", scene.format(0.0785398))
        self.succeed("run", "truth.nml", "--quiet", "--output", "tracker.csv")
        self.write("tracker.nml", scene.format(0.07) + "&free key = 'initial.attitude', 'initial.angular_velocity' /\n"
                   "&measurement file = 'tracker.csv', columns = 'q0', 'q1', 'q2', 'q3', sigma = 0.001 /\n")
        page = self.succeed("fit", "tracker.nml").stdout
        self.assertIn("27 degrees of freedom", page)
        for key, error in (("initial.attitude", 5.5e-4), ("initial.angular_velocity", 5.2e-5)):
            for axis in (1, 2):
                power = re.search(rf"{key}\.{axis} .* ± (\S+?)\)?(E\S+)?$", page, re.MULTILINE)
                self.assertAlmostEqual(float(power[1] + (power[2] or "")), error, delta=0.03*error)

    def test_moments_and_torques_are_known_up_to_one_factor(self):
        body = "&body inertia = 5, 20, {} /\n&initial angular_velocity = 3, 1, 5 /\n&dipole moment = 2, -3, 1, field = 0, 0, 1 /\n"
        run = "&integrator local_tolerance = 1e-10, end_time = 3 /\n&output interval = 0.1, columns = 'angular_velocity' /\n"
        self.write("truth.nml", body.format(17) + run)
        self.succeed("run", "truth.nml", "--quiet", "--output", "field.csv")
        self.write("field.nml", body.format(17.1) + run + "&free key = 'body.inertia', 'dipole.moment' /\n"
                   "&measurement file = 'field.csv', columns = 'omega1', 'omega2', 'omega3', sigma = 0.01 /\n")
        self.assertIn("not identifiable    body.inertia.1 1, body.inertia.2 1, body.inertia.3 1, dipole.moment.1 1, "
                      "dipole.moment.2 1, dipole.moment.3 1 (", self.succeed("fit", "field.nml").stdout)

    def test_without_sigma_the_residuals_give_it(self):
        self.write("free.nml", GYRO.replace(", sigma = 0.01", ""))
        self.assertIn("from the residuals", self.succeed("fit", "free.nml").stdout)
        if shutil.which("gnuplot") is not None:
            self.succeed("fit", "free.nml", "--quiet", "--plot", "free.svg")
            with open(self.path("free.svg"), encoding="utf-8") as file:
                self.assertNotIn("standard deviations", file.read())

    def test_without_sigma_data_without_noise_are_fitted(self):
        run = "&integrator accuracy = 1e-11, end_time = 4 /\n&output interval = 0.2 /\n"
        self.write("exact.nml", "&body inertia = 5.5, 19, 17 /\n&initial angular_velocity = 0.3, 0.1, 0.5 /\n" + run)
        self.succeed("run", "exact.nml", "--quiet")
        for columns, more in (("'q0', 'q1', 'q2', 'q3'", ""), ("'omega1', 'omega2', 'omega3'", ", bias = 'constant'")):
            for first in ("0.3", "0.31"):
                with self.subTest(columns, first=first):
                    self.write("guess.nml", self.read("exact.nml").replace("= 0.3,", f"= {first},") + "&free key = 'initial.angular_velocity' /\n"
                               f"&measurement file = 'exact.csv', columns = {columns}{more} /\n")
                    self.succeed("fit", "guess.nml", "--quiet")
                    values = re.search("angular_velocity = ([^/\n]*)", self.read("guess.fit.nml"))[1].split(",")
                    for value, wanted in zip(values, (0.3, 0.1, 0.5)):
                        self.assertAlmostEqual(float(value), wanted, delta=1e-12)

    def test_residuals_beyond_noise_are_reported(self):
        self.assertEqual(self.succeed("fit", "gyro.nml").stderr, "")
        self.rewrite("t,omega1,omega2,omega3", lambda row: row if row[0] != 0.5 else [row[0], row[1], row[2] + 10, row[3]])
        done = self.succeed("fit", "other.nml", "--quiet")
        for says in ("nutate: other.nml: chi-squared per degree of freedom is", "exceeds in less than 1 of 10000 cases",
                     " sigma at t = 0.5 s of other.csv, "):
            self.assertIn(says, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)

    def test_random_starts_have_something_to_draw(self):
        self.write("rates.nml", GYRO.replace("&free key = 'body.inertia.1', 'body.inertia.2' /\n", "") + "&fit starts = 30 /\n")
        self.fail_with(2, "fit", "rates.nml", says=("rates.nml:6: random starts have nothing to draw (expected free moments",))
        self.succeed("fit", "gyro.nml", "--set", "fit.starts=3")

    def test_directions_and_angles(self):
        self.write("axis.csv", "t,x,y,z\n" + "".join(f"{t},{math.sin(2 * t)!r},{math.cos(2 * t)!r},0\n" for t in (0.1, 0.2, 0.5)))
        self.write("spin.nml", "&body inertia = 1, 1, 0.5 /\n&initial angular_velocity = 0, 0, 1.8 /\n"
                   "&integrator local_tolerance = 1e-10, end_time = 1 /\n&free key = 'initial.angular_velocity' /\n"
                   "&measurement file = 'axis.csv', columns = 'x', 'y', 'z', direction = 0, 3, 0, sigma = 0.01 /\n")
        page = self.succeed("fit", "spin.nml").stdout
        self.assertRegex(page, r"angular_velocity\.3 +2\.000 ± 0\.01")
        # Three unit vectors have six degrees of freedom, and the fit has three parameters.
        self.assertRegex(page, "9 residuals in 1 measurement, 3 parameters\n.*\n.* for 3 degrees of freedom")
        self.write("angle.nml", GYRO.replace("'omega1', 'omega2', 'omega3'", "'phi', 'theta', 'psi'"))
        self.assertRegex(self.succeed("fit", "angle.nml", "--csv", "a.csv", "--output", "a.fit.nml").stdout,
                         r"body\.inertia\.2 +20\.0")

    def test_a_free_body_is_fitted_by_its_closed_solution(self):
        by_steps = self.succeed("fit", "gyro.nml", "--csv", "a.csv", "--set", "integrator.method=nielsen_krenk", "--set", "integrator.order=8")
        by_default = self.succeed("fit", "gyro.nml", "--csv", "b.csv")
        self.assertEqual(by_default.stdout, self.succeed("fit", "gyro.nml", "--csv", "c.csv", "--set", "integrator.method=exact").stdout)
        results = [[line for line in done.stdout.splitlines() if "±" in line] for done in (by_default, by_steps)]
        self.assertEqual(results[0], results[1])
        self.assertEqual(len(results[0]), 5)
        self.assertEqual(self.read("b.csv"), self.read("c.csv"))
        self.assertNotEqual(self.read("b.csv"), self.read("a.csv"))

    def test_a_limit_of_steps_ends_the_fit_with_the_best_found(self):
        self.fail_with(3, "fit", "gyro.nml", "--max-steps", "3", says=["gyro.nml: the fit needs more steps than allowed"])
        self.assertFalse(os.path.exists(self.path("gyro.fit.nml")))
        # Enough for some iterations on the whole of the data.
        self.write("crude.nml", STEPS.replace("3.0, 1.0, 5.0", "3.3, 0.5, 5.5") + "&fit arcs = 'whole', start = 'scene' /\n")
        self.fail_with(3, "fit", "crude.nml", "--quiet", "--max-steps", "20",
                       says=["the fit did not converge: the fit needs more steps than allowed"])
        self.succeed("check", "crude.fit.nml")
        self.succeed("fit", "gyro.nml", "--quiet", "--max-steps", "100000")

    def test_a_limit_inside_of_a_short_arc_gives_no_fit_of_it(self):
        self.write("gyro.nml", STEPS)
        page = self.succeed("fit", "gyro.nml").stdout
        statuses = []
        for limit in range(5, 105, 5):
            done = self.nutate("fit", "gyro.nml", "--max-steps", str(limit))
            statuses.append((done.returncode, done.stdout != ""))
            if done.stdout:
                self.assertIn("63 residuals in 1 measurement", done.stdout)
                self.assertIn("58 degrees of freedom", done.stdout)
        self.assertEqual(done.stdout, page)
        self.assertEqual(sorted(set(statuses)), [(0, True), (3, False), (3, True)])

    def test_a_picture(self):
        if shutil.which("gnuplot") is None:
            self.skipTest("no gnuplot")
        self.succeed("fit", "gyro.nml", "--quiet", "--plot", "fit.svg")
        with open(self.path("fit.svg"), encoding="utf-8") as file:
            picture = file.read()
        for text in ("gyro.csv, and the model", "residuals (standard deviations)", "Ω3"):
            self.assertIn(text, picture)

    def test_files_that_cannot_be_written_are_rejected_before_the_fit(self):
        for options in (("--output", "no/x.fit.nml"), ("--csv", "no/x.csv"), ("--csv", "no/x.csv", "--output", "-")):
            done = self.fail_with(4, "fit", "gyro.nml", *options, says=["cannot write no/x"])
            self.assertEqual(done.stdout, "")
        self.assertEqual([name for name in self.names() if "fit" in name or "residual" in name or "partial" in name], [])

    def test_refusals(self):
        self.fail_with(2, "fit", "box.nml", says=["there is nothing to fit (expected &free and &measurement)"])
        self.fail_with(2, "fit", "gyro.nml", "--set", "integrator.formulation=full", "--set", "integrator.projection=.false.",
                       "--set", "integrator.auxiliary_inertia=10", "--unset", "integrator.local_tolerance",
                       "--set", "integrator.time_step=0.01", says=["sensitivities need"])
        self.write("sampled.nml", GYRO + "&controller law = 'quaternion', attitude_gain = 1, rate_gain = 1, sample = 0.1 /\n")
        self.fail_with(2, "fit", "sampled.nml", says=["a controller that samples has no derivative (expected one without sample)"])
        self.fail_with(2, "fit", "gyro.nml", "--output", "gyro.nml", says=["gyro.nml is the scene itself"])
        self.fail_with(2, "fit", "gyro.nml", "--csv", "gyro.csv", says=["gyro.csv is a file of measurements"])
        self.fail_with(2, "fit", "gyro.nml", "--member", "1", says=["nutate fit has no option --member"])
        self.assertEqual(sorted(name for name in os.listdir(self.path(".")) if "fit" in name or "residual" in name), [])

    def test_the_command_explains_itself(self):
        self.assertIn("SCENE.fit.nml", self.succeed("fit", "--help").stdout)
