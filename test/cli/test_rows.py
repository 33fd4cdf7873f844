"""Rows at given times, digits and degrees."""
import math
import unittest

from support import METHODS, TOP, CommandLineTest, all_columns

# A torque that starts and stops inside steps, so that some steps are cut.
FORCED = TOP + "&torque body = 1.0, 0.0, -2.0, frequency = 0.7, start = 0.1234, stop = 0.3711 /\n"
TIMES = (0.0, 0.0012, 0.003, 0.005, 0.1, 0.1227, 0.1241, 0.3701, 0.372, 0.99999, 1.0)
STEPS = ["--set", "output.columns='quaternion','angular_velocity','euler','energy'"]


class Rows(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("forced.nml", FORCED)

    def rows(self, name, *settings):
        self.succeed("run", "forced.nml", "--quiet", "--output", name, *settings)
        return self.history(name)

    def method(self, name, solver, order):
        settings = ["--set", f"integrator.method='{name}'"]
        return settings + (["--set", f"integrator.formulation='{solver}'", "--set", f"integrator.order={order}"] if solver else [])

    def test_rows_stand_at_the_times_given_and_nowhere_else(self):
        times = ",".join(map(str, TIMES))
        for name, solver, order, _ in METHODS:
            if name == "exact":
                continue
            with self.subTest(name, solver=solver, order=order):
                settings = self.method(name, solver, order) + STEPS
                header, every = self.rows("every.csv", *settings)
                _, given = self.rows("given.csv", *settings, "--set", f"output.times={times}")
                self.assertEqual([row[0] for row in given], list(TIMES))
                # Where a step ends, the row is the step's: the steps are what they were.
                at = {row[0]: row for row in every}
                for row in given:
                    if row[0] in (0.0, 0.005, 0.1, 1.0):
                        self.assertEqual(row, at[row[0]])
                    if name != "rk4":
                        self.assertLess(abs(row[header.index("energy_residual")]), 1e-11)

    def test_rows_inside_steps_are_those_of_shorter_steps(self):
        for name, solver, order in (("nielsen_krenk", "reduced", 8), ("dop853", "", 8), ("taylor", "", 0)):
            settings = self.method(name, solver, order) + ["--set", "output.columns='quaternion','angular_velocity','euler'"]
            _, fine = self.rows("fine.csv", *settings, "--set", "integrator.time_step=0.001", "--set", "output.every=13")
            times = ",".join(repr(row[0]) for row in fine)
            for control in ("integrator.time_step=0.005", "integrator.time_step=0.02"):
                _, given = self.rows("given.csv", *settings, "--set", control, "--set", f"output.times={times}")
                self.assertEqual(len(given), len(fine))
                for row, expected in zip(given, fine):
                    for value, other in zip(row, expected):
                        self.assertAlmostEqual(value, other, delta=2e-7 * (1 + abs(other)))

    def test_adaptive_steps_have_a_thousand_and_one_rows_by_default(self):
        for name in ("nielsen_krenk", "rk4", "dop853", "rk8", "taylor", "auto"):
            for goal in ("local_tolerance", "accuracy"):
                with self.subTest(name, goal=goal):
                    settings = ["--set", f"integrator.method='{name}'", "--set", f"integrator.{goal}=1e-5"]
                    # The limit is one of steps, not of rows.
                    _, history = self.rows("usual.csv", *settings, "--max-steps", "990")
                    self.assertEqual(len(history), 1001)
                    for i, row in enumerate(history):
                        self.assertAlmostEqual(row[0], i / 1000, delta=1e-15)
                    _, steps = self.rows("steps.csv", *settings, "--set", "output.every=1")
                    self.assertLess(len(steps), 1000)
                    for value, other in zip(history[-1], steps[-1]):
                        self.assertAlmostEqual(value, other, delta=1e-12 * (1 + abs(other)))

    def test_the_closed_solution_needs_no_steps_between_times(self):
        self.write("spin.nml", "&body inertia = 1, 1.2, 1.5 /\n&initial angular_velocity = 0, 0, 0.1 /\n"
                   "&integrator accuracy = 1e-6, end_time = 1e8 /\n&output columns = 'quaternion', times = 0.0, 1e8 /\n")
        self.succeed("run", "spin.nml", "--quiet", "--output", "ends.csv", "--max-steps", "20")
        self.succeed("run", "spin.nml", "--quiet", "--output", "same.csv", "--unset", "output.times", "--set", "output.interval=1e8")
        self.assertEqual(self.history("ends.csv"), self.history("same.csv"))
        times = ",".join(str(1e6 * i) for i in range(101))
        self.succeed("run", "spin.nml", "--quiet", "--output", "all.csv", "--max-steps", "20", "--set", "output.times=" + times)
        self.assertEqual(len(self.history("all.csv")[1]), 101)

    def test_times_come_from_a_file_and_with_chosen_steps(self):
        self.write("when.csv", "t (s)\r\n" + "".join(f"{t}\r\n" for t in TIMES))
        chosen = FORCED.replace("time_step = 0.005", "local_tolerance = 1e-10")
        self.write("forced.nml", chosen)
        for name, solver, order in (("nielsen_krenk", "reduced", 4), ("dop853", "", 8), ("taylor", "", 0)):
            settings = self.method(name, solver, order) + STEPS
            _, listed = self.rows("listed.csv", *settings, "--set", "output.times=" + ",".join(map(str, TIMES)))
            _, given = self.rows("given.csv", *settings, "--set", "output.times_file='when.csv'")
            self.assertEqual(given, listed)
            self.assertEqual([row[0] for row in given], list(TIMES))
            _, last = self.rows("every.csv", *settings)
            self.assertEqual(given[-1], last[-1])

    def test_euler_angles_inside_of_steps_are_those_of_the_attitude(self):
        self.write("forced.nml", FORCED.replace("time_step = 0.005", "local_tolerance = 1e-9"))
        for rows in ("output.interval=0.013", "output.times=0.1,0.2,0.3,0.5,0.9"):
            _, history = self.rows("rows.csv", "--set", "integrator.method='taylor'", "--set", rows, "--set",
                                   "output.columns='quaternion','euler'")
            for _, q0, q1, q2, q3, phi, theta, psi in history:
                cosine, sine = math.cos(theta / 2), math.sin(theta / 2)
                product = (q0 * cosine * math.cos((phi + psi) / 2) + q1 * sine * math.cos((phi - psi) / 2)
                           + q2 * sine * math.sin((phi - psi) / 2) + q3 * cosine * math.sin((phi + psi) / 2))
                self.assertAlmostEqual(abs(product), 1, delta=1e-12)

    def test_an_interrupted_run_goes_on_with_its_rows(self):
        times = ",".join(f"{0.0033 * i:.4f}" for i in range(300))
        self.write("when.csv", "t (s)\n" + times.replace(",", "\n") + "\n")
        for steps in ("integrator.time_step=0.005", "integrator.local_tolerance=1e-6"):
            scene = FORCED if "step" in steps else FORCED.replace("time_step = 0.005, ", "")
            self.write("forced.nml", scene)
            settings = ["--set", steps, "--set", "integrator.order=2", "--set", "output.times_file='when.csv'", "--set", f"output.columns={all_columns()}"]
            self.succeed("run", "forced.nml", "--quiet", "--output", "whole.csv", *settings)
            self.fail_with(3, "run", "forced.nml", "--quiet", "--output", "part.csv", "--checkpoint", "ck", "--max-steps",
                           "37", *settings)
            self.succeed("run", "forced.nml", "--quiet", "--resume", "ck", *settings)
            self.assertEqual(self.read("part.csv"), self.read("whole.csv"))
        self.fail_with(3, "run", "forced.nml", "--quiet", "--output", "part.csv", "--checkpoint", "ck", "--max-steps", "37",
                       *settings)
        self.write("when.csv", self.read("when.csv") + "0.9901\n")
        self.fail_with(2, "run", "forced.nml", "--resume", "ck", *settings, says=["another scene (&output is not the same)"])

    def test_times_outside_of_the_run_or_out_of_order_are_refused(self):
        for times, says in (("-0.1", "outside of the run"), ("0.5,1.1", "outside of the run"), ("0.2,0.2", "out of order"),
                            ("0.3,0.2", "out of order")):
            self.fail_with(2, "check", "forced.nml", "--set", f"output.times={times}", says=[says])
        self.write("when.csv", "t (s)\n0.1\n0.05\n")
        self.fail_with(2, "run", "forced.nml", "--set", "output.times_file='when.csv'", says=["when.csv:3: output times"])
        self.write("when.csv", "t (s)\n")
        self.fail_with(2, "run", "forced.nml", "--set", "output.times_file='when.csv'", says=["when.csv:2: there are no times"])
        self.write("when.csv", "t\n0.1\n")
        self.fail_with(2, "run", "forced.nml", "--set", "output.times_file='when.csv'", says=["when.csv:1: 't' lacks the unit"])
        self.fail_with(2, "run", "forced.nml", "--set", "output.times=0.1", "--set", "output.every=2", says=["exclude each other"])

    def test_back_in_time(self):
        _, rows = self.rows("back.csv", "--set", "integrator.time_step=-0.01", "--set", "integrator.end_time=-0.1", "--set",
                            "output.times=-0.005,-0.01,-0.0999")
        self.assertEqual([row[0] for row in rows], [-0.005, -0.01, -0.0999])

    def test_digits_are_those_asked_for(self):
        _, exact = self.rows("exact.csv")
        for digits in (1, 5, 17):
            _, rounded = self.rows("rounded.csv", "--set", f"output.precision={digits}")
            for row, other in zip(rounded, exact):
                for value, number in zip(row, other):
                    self.assertAlmostEqual(value, number, delta=0.5000001 * 10.0 ** (1 - digits) * abs(number))
                    self.assertEqual(float(f"{number:.{digits - 1}e}"), value)
        self.fail_with(2, "check", "forced.nml", "--set", "output.precision=18", says=["precision is too large (expected 1 to 17"])

    def test_degrees_have_names_of_their_own(self):
        columns = ["--set", "output.columns='euler','angular_velocity','angular_velocity_space','energy'"]
        header, radians = self.rows("radians.csv", *columns)
        names, degrees = self.rows("degrees.csv", *columns, "--set", "output.degrees=.true.")
        self.assertEqual(names[1:10], [name + "_deg" for name in header[1:10]])
        self.assertEqual(names[10:], header[10:])
        for row, other in zip(degrees, radians):
            self.assertEqual(row[10:], other[10:])
            for value, number in zip(row[1:10], other[1:10]):
                self.assertAlmostEqual(value, math.degrees(number), delta=1e-12 * (1 + abs(value)))

    def test_check_tells_the_rows(self):
        text = self.succeed("check", "forced.nml", "--set", "output.times=0.1,0.2,0.3").stdout
        self.assertIn("  rows                3, at the times given\n", text)
        self.assertIn("phi_deg", self.succeed("check", "forced.nml", "--set", "output.columns='euler'", "--set",
                                              "output.degrees=.true.").stdout)


if __name__ == "__main__":
    unittest.main()
