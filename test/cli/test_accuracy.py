"""Steps from an accuracy, and the methods beside the conserving step, through the command line."""
import math
import os
import re

from support import ONE_IN, CommandLineTest

BRUELS = """&body inertia = 0.234375, 0.46875, 0.234375, mass = 15, center_of_mass = 0, 1, 0, inertia_about = 'center_of_mass' /
&initial angular_velocity = 0, 150, -4.61538 /
&gravity acceleration = 0, 0, -9.81 /
&integrator accuracy = 1e-8, order = 8, formulation = 'reduced', end_time = 1 /
&output interval = 0.125 /
"""
FREE = """&body inertia = 5, 20, 17 /
&initial angular_velocity = 1, 2, 3 /
&integrator method = 'auto', accuracy = 1e-8, end_time = 3 /
&output interval = 0.5 /
"""
# Attitude of the heavy top of Bruels, Cardona and Arnold after 1 s, exact.
EXACT = (0.732943980679663718, -0.278285719337612679, 0.531824611334162618, -0.320176142736249281)


def distance(row):
    """Angle in rad between the attitude of a row and the exact one, for small ones."""
    return 2 * math.sqrt(sum((row[f"q{i}"] - q) ** 2 for i, q in enumerate(EXACT)))


class Accuracy(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("bruels.nml", BRUELS)

    def rows(self, name):
        """The rows of a history, each by the names of its columns."""
        header, rows = self.history(name)
        return [dict(zip(header, row)) for row in rows]

    def test_accuracy_asked_for_is_met(self):
        for accuracy in (1e-4, 1e-8, 1e-12):
            summary = self.succeed("run", "bruels.nml", "--set", f"integrator.accuracy={accuracy}").stderr
            said = float(re.search(r"estimated error +(\S+) rad", summary)[1])
            error = distance(self.rows("bruels.csv")[-1])
            self.assertLess(error, max(accuracy, said))
            self.assertEqual("is not attainable" in summary, said > accuracy)
            self.assertTrue(said <= accuracy or accuracy == 1e-12, summary)

    def test_rows_come_at_the_interval_and_keep_the_invariants(self):
        self.succeed("run", "bruels.nml")
        rows = self.rows("bruels.csv")
        self.assertEqual([row["t"] for row in rows], [k / 8 for k in range(9)])
        for row in rows:
            self.assertLess(abs(row["norm_error"]), 1e-14)
            self.assertLess(abs(row["energy_residual"]), 1e-12 * 5436)

    def test_summary_states_the_estimated_error(self):
        summary = self.succeed("run", "bruels.nml").stderr
        self.assertRegex(summary, r"estimated error +\S+E-9 rad of attitude at the end time, 1E-8 requested")
        summary = self.succeed("run", "bruels.nml", "--set", "integrator.accuracy=1e-16").stderr
        self.assertIn("is not attainable", summary)

    def test_baselines_reach_the_accuracy_but_keep_no_energy(self):
        self.write("free.nml", BRUELS.replace("order = 8, formulation = 'reduced'", "method = 'dop853'"))
        self.succeed("run", "free.nml")
        last = self.rows("free.csv")[-1]
        self.assertLess(distance(last), 1e-8)
        self.assertGreater(abs(last["energy_residual"]), 1e-13 * 5436)

    def test_an_accuracy_alone_is_auto(self):
        self.write("alone.nml", BRUELS.replace("order = 8, formulation = 'reduced', ", ""))
        summary = self.succeed("run", "alone.nml").stderr
        self.assertRegex(summary, r"alone.nml: \d+ steps, 9 rows, about \d+ kB to expect\n")
        self.assertIn("chosen by auto", summary)
        self.assertLess(distance(self.rows("alone.csv")[-1]), 1e-8)
        self.assertRegex(self.succeed("check", "alone.nml").stdout, r"\n  steps +about \d+\n  rows +9, one every 0.125 s\n")
        for accuracy, order in ((1e-2, 4), (1e-4, 6), (1e-6, 8)):
            text = self.succeed("check", "alone.nml", "--set", "integrator.method='nielsen_krenk'", "--set",
                                f"integrator.accuracy={accuracy}").stdout
            self.assertIn(f"nielsen_krenk of order {order}\n", text)

    def test_a_history_that_nobody_asked_for_is_refused(self):
        long = ("--set", "integrator.end_time=1e6")
        self.fail_with(2, "run", "box.nml", *long, says=["100000001 rows, about 29 GB", "expected every = 100000",
                                                         "every = 1 for all"])
        self.fail_with(2, "check", "box.nml", *long, says=["100000001 rows, about 29 GB", "expected every = 100000"])
        self.assertNotIn("refused", self.succeed("check", "box.nml", *long, "--set", "output.every=1").stdout)
        self.assertEqual([name for name in os.listdir(self.folder) if name.startswith("box.csv")], [])
        self.succeed("run", "box.nml", "--set", "integrator.end_time=20", "--set", "output.every=1")

    def test_taylor_reaches_the_accuracy_with_every_invariant_in_every_row(self):
        self.write("series.nml", BRUELS.replace("order = 8, formulation = 'reduced'", "method = 'taylor'"))
        summary = self.succeed("run", "series.nml", "--set", "output.interval=0.0123").stderr
        self.assertIn("0 rejected", summary)
        rows = self.rows("series.csv")
        self.assertEqual(len(rows), 83)
        self.assertLess(distance(rows[-1]), 1e-8)
        for row in rows:
            self.assertLess(abs(row["norm_error"]), 1e-14)
            self.assertLess(abs(row["energy_residual"]), 1e-13 * 5436)

    def test_one_way_to_choose_steps(self):
        for others in ("time_step=0.1", "local_tolerance=0.1"):
            self.fail_with(2, "run", "bruels.nml", "--set", "integrator.accuracy=1e-3", "--set", "integrator." + others,
                           says=["accuracy", others.split("=", maxsplit=1)[0], "exclude each other"])
        self.fail_with(2, "run", "bruels.nml", "--set", "integrator.accuracy=2", says=["is too large (expected 1e-100 to below 1 for accuracy)"])

    def test_exact_method_agrees_with_converged_steps(self):
        self.succeed("run", "box.nml", "--set", "integrator.method='exact'")
        exact = self.rows("box.csv")[-1]
        self.succeed("run", "box.nml", "--set", "integrator.order=8")
        steps = self.rows("box.csv")[-1]
        for name in ("q0", "q1", "q2", "q3", "omega1", "omega2", "omega3"):
            self.assertAlmostEqual(exact[name], steps[name], delta=1e-10)

    def test_exact_method_refuses_what_it_cannot_solve(self):
        self.fail_with(2, "run", "top.nml", "--set", "integrator.method='exact'", says=["free bodies only"])

    def test_auto_says_what_it_chose_and_meets_the_accuracy(self):
        self.write("auto.nml", BRUELS.replace("order = 8, formulation = 'reduced'", "method = 'auto'"))
        # By a ten-millionth of its moment the second body is not symmetric.
        for accuracy, method, why, inertia in ((1e-6, "rk8", "equal steps are cheapest", 0.234375),
                                               (5e-10, "taylor", "the Taylor series costs least under linear effects", 0.234375),
                                               (0.05, "taylor", "the Taylor series costs least under linear effects", 0.23437502)):
            override = ("--set", f"integrator.accuracy={accuracy}",
                        "--set", f"body.inertia=0.234375, 0.46875, {inertia}")
            text = self.succeed("check", "auto.nml", *override).stdout
            self.assertRegex(text, f"  method +{method}.*\n    chosen by auto +{why}")
            summary = self.succeed("run", "auto.nml", *override).stderr
            self.assertRegex(summary, f"  method +{method}, chosen by auto: {why}")
            rows = self.rows("auto.csv")
            self.assertLess(distance(rows[-1]), accuracy)
            for row in rows:
                self.assertLess(abs(row["energy_residual"]), 1e-13 * 5436)

    def test_the_closed_solution_has_an_estimated_error(self):
        long = ("--set", "integrator.end_time=1e5", "--set", "output.interval=1e4")
        self.write("free.nml", FREE)
        self.assertRegex(self.succeed("run", "free.nml", *long).stderr,
                         r"\n  estimated error +[\d.]+E-1[0-2] rad of attitude at the end time, 1E-8 requested\n")
        fine = (*long, "--set", "integrator.accuracy=1e-14")
        self.assertRegex(self.succeed("run", "free.nml", *fine).stderr, r"at the end time; the requested 1E-14 is not attainable: "
                         r"round-off alone contributes [\d.]+E-1[0-2]\n")
        self.assertRegex(self.succeed("check", "free.nml", *fine).stdout, r"\n  accuracy +not attainable; best: [\d.]+E-1[0-2] rad")

    def test_a_tolerance_of_steps_alone_is_auto(self):
        self.write("alone.nml", BRUELS.replace("accuracy = 1e-8, order = 8, formulation = 'reduced'",
                                                "local_tolerance = 1e-8"))
        chosen = self.succeed("check", "alone.nml").stdout
        self.assertRegex(chosen, "  method +taylor.*\n    chosen by auto +the Taylor series costs least")
        self.assertRegex(self.succeed("run", "alone.nml").stderr, "  method +taylor, chosen by auto: the Taylor series costs least")
        named = self.succeed("check", "alone.nml", "--set", "integrator.formulation='reduced'").stdout
        self.assertIn("nielsen_krenk of order 2\n", named)
        self.assertNotIn("chosen by auto", named)

    def test_auto_solves_a_free_body(self):
        self.write("free.nml", FREE)
        text = self.succeed("check", "free.nml").stdout
        self.assertRegex(text, "  method +exact\n    chosen by auto +the motion of a free body")
        self.assertIn("  steps               none between output times, to t = 3 s\n", text)
        self.write("events.nml", FREE + "&event when = 'omega1', crosses = 0 /\n")
        self.assertIn("up to a radian of rotation each, to t = 3 s", self.succeed("check", "events.nml").stdout)
        summary = self.succeed("run", "free.nml").stderr
        self.assertIn("of the closed solution, to t = 3 s", summary)
        auto = self.rows("free.csv")
        self.succeed("run", "free.nml", "--set", "integrator.method='taylor'", "--set", "integrator.accuracy=1e-11")
        series = self.rows("free.csv")
        self.assertEqual([row["t"] for row in auto], [row["t"] for row in series])
        for one, other in zip(auto, series):
            self.assertAlmostEqual(one["q2"], other["q2"], delta=1e-10)

    def test_auto_takes_an_accuracy_and_nothing_of_one_method(self):
        self.write("free.nml", FREE)
        for key, value in (("order", "4"), ("series_order", "8"), ("formulation", "'reduced'"), ("conserve", "T"),
                           ("projection", "F")):
            self.fail_with(2, "check", "free.nml", "--set", f"integrator.{key}={value}",
                           says=[f"{key} with the method auto", "a method by name"])
        self.write("steps.nml", FREE.replace("accuracy = 1e-8", "time_step = 0.1").replace("interval = 0.5", ""))
        self.fail_with(2, "check", "steps.nml", says=["steps.nml:3:", "time_step with the method auto", "accuracy or"])

    def test_accuracy_counts_where_no_column_shows_the_attitude(self):
        self.write("plate.nml", FREE.replace("'auto'", "'dop853'") + "&damping coefficient = 0.1, 0.2, 0.3 /\n")
        override = ("--set", "output.columns='angular_velocity'")
        with_attitude = self.succeed("run", "plate.nml").stderr
        self.assertIn(with_attitude.split("estimated error")[1].split(" rad")[0],
                      self.succeed("run", "plate.nml", *override).stderr)

    def test_orders_and_solvers_of_a_method_are_checked(self):
        self.fail_with(2, "run", "box.nml", "--set", "integrator.order=3", says=["order 3", "2, 4, 6, 8"])
        self.fail_with(2, "run", "box.nml", "--set", "integrator.method='rk4'", "--set", "integrator.order=2",
                       says=["expected 4"])


class Needles(CommandLineTest):
    """A thin body that rotates slowly about its axis: the rounding of q and p is a large error of that rate."""

    def test_the_estimate_contains_the_rounding_of_the_momentum(self):
        q, omega, end = (0.5, 0.1, -0.7, 0.5), (0.3, -0.2, 0.5), 10.0
        cases = [("taylor", 6), ("taylor", 8), ("taylor", 10), ("dop853", 8)]
        # Steps of order 8 of so thin a body take four seconds.
        if ONE_IN <= 3:
            cases.append(("nielsen_krenk", 8))
        for method, exponent in cases:
            least = float(f"1e-{exponent}")
            with self.subTest(method=method, least=least):
                self.write("needle.nml", f"&body inertia = 1, 1, {least} /\n&initial quaternion = {str(q)[1:-1]}, "
                           f"angular_velocity = {str(omega)[1:-1]} /\n&integrator method = '{method}', accuracy = 1e-8, end_time = {end} /\n"
                           "&output columns = 'quaternion', every = 1000000, precision = 17 /\n")
                text = self.succeed("run", "needle.nml").stderr
                estimate = float(re.search(r"estimated error +(\S+) rad", text)[1])
                _, rows = self.history("needle.csv")
                # Precession about l at |l|/J1, spin about the axis at (1 - J3/J1) omega3.
                momentum = multiply(multiply(q, (0.0, omega[0], omega[1], least * omega[2])), conjugate(q))[1:]
                exact = multiply(multiply(turn(momentum, end), q), turn((0.0, 0.0, (1 - least) * omega[2]), end))
                error = 2 * math.hypot(*multiply(conjugate(exact), rows[-1][1:5])[1:])
                self.assertLess(error, estimate)
                self.assertLess(estimate, max(1e-8, 1e3 * error))


def conjugate(q):
    return (q[0], -q[1], -q[2], -q[3])


def multiply(a, b):
    """Product of two quaternions."""
    return (a[0]*b[0] - a[1]*b[1] - a[2]*b[2] - a[3]*b[3], a[0]*b[1] + a[1]*b[0] + a[2]*b[3] - a[3]*b[2],
            a[0]*b[2] - a[1]*b[3] + a[2]*b[0] + a[3]*b[1], a[0]*b[3] + a[1]*b[2] - a[2]*b[1] + a[3]*b[0])


def turn(rate, t):
    """Quaternion of a rotation at a constant rate for a time."""
    size = math.hypot(*rate)
    return (math.cos(size * t / 2), *(math.sin(size * t / 2) * x / size for x in rate))
