"""nutate cost: the table, the answer, the files and the budget."""
import csv
import math
import os
import re
import shutil
import stat
import unittest

from support import METHODS, ROOT, TOP, CommandLineTest

# How the table calls the methods that have an order.
LABELS = [f"{name} order {order} ({solver})" if solver else name + ("+conserve" if projected else "")
          for name, solver, order, projected in METHODS if order != "0"]
# Budgets in work: what a study runs does not depend on the machine.
SHORT = ("--evaluations", "300000")
BRIEF = ("--evaluations", "100000")
QUICK = ("--evaluations", "30000")
# Each step of higher order is subdivided into a thousand parts.
SUBDIVIDED = """
&body inertia = 4.2e-5, 4.2e-5, 1.1e-5, mass = 0.0148 /
&orbit altitude = 184324, argument_of_periapsis = 56.8, frame = 'inertial' /
&earth_field moment = 4354.5, 0.016, 1.058, epoch_angle = -30.9, coefficients = 0.5256, 4.7e-52, 1702.37, degrees = .true. /
&initial rate_from = 'inertial', attitude_from = 'lvlh', roll_pitch_yaw = -2.56, 1.0, 0.0055
   angular_velocity = 2.82, 0.079, 0.0207 /
&integrator time_step = 614.3, end_time = 1843, auxiliary_inertia = 3.53e-8 /
"""

# Hyperion, for some hundred periods: two methods lose each other.
CHAOS = """
&body inertia = 0.5, 0.764, 1.0 /
&orbit semi_major_axis = 1.0, mu = 1.0, eccentricity = 0.1 /
&gravity_gradient /
&initial angular_velocity = 0.0, 0.0, 1.0, roll_pitch_yaw = 0.1, 0.2, 0.3 /
&integrator time_step = 0.25, end_time = 1000.0 /
"""


class Study(CommandLineTest):
    studies = {}

    def study(self, scene, *options):
        """What `cost` prints of a scene of `CommandLineTest`; each study is made once."""
        if (scene, *options) not in self.studies:
            done = self.succeed("cost", scene, *options)
            self.assertEqual(done.stderr, "")
            self.studies[(scene, *options)] = done.stdout
        return self.studies[(scene, *options)]

    def answer(self, text):
        """The rows for each accuracy: accuracy, time, energy, mark, settings."""
        blocks = []
        for line in text[text.index("accuracy  "):].splitlines()[2:]:
            row = re.match(r" *(1E-\d+)? +([-.E\d]+) +([-.E\d]+) +([*]?(?: *auto)?) *(.*)", line).groups(default="")
            if row[0]:
                blocks.append([])
            blocks[-1].append(row)
        return blocks

    def rows(self, name):
        return list(csv.DictReader(self.read(name).splitlines()))

    def test_table_has_every_method_and_answers(self):
        text = self.study("box.nml", *SHORT)
        lines = text.splitlines()
        for method in LABELS:
            self.assertEqual(sum(line.startswith(method + ",") for line in lines), 1, method)
        for words in ("box.nml: Free box", "exact motion of a free body", "exact, the closed solution", "time_step="):
            self.assertIn(words, text)
        self.assertLessEqual(max(map(len, lines)), 110)
        # The answer is the last table, and nothing stands below it.
        self.assertEqual([rows[0][0] for rows in self.answer(text)], ["1E-4", "1E-6", "1E-8", "1E-10"])
        self.assertEqual(self.names(), ["box.nml", "top.nml"])

    def test_settings_for_each_accuracy_are_cheapest_first_and_can_be_pasted(self):
        tried = 0
        for rows in self.answer(self.study("top.nml", *SHORT)):
            rows = [row for row in rows if row[1] != "-"]
            times = [float(row[1]) for row in rows]
            self.assertEqual(times, sorted(times))
            if rows:
                self.write("pasted.nml", TOP.replace("time_step = 0.005", rows[0][4]))
                self.succeed("run", "pasted.nml", "--quiet")
                tried += 1
        self.assertGreaterEqual(tried, 2)

    def test_settings_reach_the_accuracy_that_they_stand_under(self):
        scene = TOP + "&output columns = 'quaternion', every = 1000000 /\n"

        def end(settings):
            self.write("pasted.nml", scene.replace("time_step = 0.005", settings))
            self.succeed("run", "pasted.nml", "--quiet", "--output", "pasted.csv")
            return [float(self.rows("pasted.csv")[-1][f"q{i}"]) for i in range(4)]

        exact, tried = end("method = 'dop853', local_tolerance = 1e-14"), 0
        for rows in self.answer(self.study("top.nml", *SHORT)):
            for row in rows:
                if row[1] == "-" or "accuracy" in row[4]:
                    continue
                q = end(row[4])
                # The rotation from one attitude to the other.
                w = [exact[0]*q[i] - exact[i]*q[0] + s*(exact[j]*q[k] - exact[k]*q[j])
                     for i, j, k, s in ((1, 2, 3, -1), (2, 3, 1, -1), (3, 1, 2, -1))]
                self.assertLess(2*math.dist(w, (0, 0, 0)), float(rows[0][0]), row)
                tried += 1
        self.assertGreater(tried, 12)

    def test_the_cheapest_that_keeps_the_invariants_and_the_choice_of_auto_are_marked(self):
        for rows in self.answer(self.study("top.nml", *SHORT)):
            keeping = [row for row in rows if row[1] != "-" and float(row[2]) < 1e-11 and "conserve=.false." not in row[4]
                       and ("conserve=.true." in row[4] or not re.match("method='(rk4|dop853)'", row[4]))]
            self.assertEqual([row for row in rows if "*" in row[3]], keeping[:1])
            self.write("auto.nml", TOP.replace("time_step = 0.005", f"method = 'auto', accuracy = {rows[0][0]}"))
            method = re.search(r"method +(\w+) of order", self.succeed("check", "auto.nml").stdout)[1]
            if any(row[1] != "-" for row in rows):
                chosen = [row[4] for row in rows if "auto" in row[3]]
                self.assertEqual([re.match("method='([a-z0-9_]+)'", text)[1] for text in chosen], [method])

    def test_a_choice_of_auto_that_the_budget_does_not_allow_is_not_measured(self):
        text = self.study("top.nml", "--evaluations", "20000", "--set", "integrator.end_time=10")
        self.assertIn("method='rk8', not measured within the budget", text)
        self.assertNotIn("not measured", self.study("top.nml", *SHORT))

    def test_methods_that_do_not_agree_are_named_with_their_distance(self):
        self.write("chaos.nml", CHAOS)
        text = self.study("chaos.nml", *BRIEF, "--set", "integrator.end_time=200")
        self.assertRegex(text, r"reference +none: nielsen_krenk order 8 \(reduced\) and dop853\n +"
                               r"agree only to \S+ rad at t = \S+ s; attitude errors are not shown\n")

    def test_auto_takes_the_closed_solution_where_there_is_one(self):
        for rows in self.answer(self.study("box.nml", *BRIEF)):
            # The study of so short a motion finds steps that cost no more.
            chosen = [row[4] for row in rows if "auto" in row[3]]
            self.assertEqual(chosen, [f"method='exact', accuracy={rows[0][0]}"])
        self.assertNotIn("exact, ", self.study("top.nml", *BRIEF))

    def test_numbers_stand_in_one_notation_under_each_other(self):
        lines = self.study("top.nml", *SHORT).splitlines()
        rows = [line for line in lines if re.match(r" *[0-9.E-]+ +\d+ .*E-1\d", line)]
        self.assertGreater(len(rows), 10)
        self.assertEqual(len({re.search(r"[.E][^ ]*$", row).start() for row in rows}), 1)
        for column in (0, -1, -2):
            self.assertEqual(len({"E" in row.split()[column] for row in rows if row.split()[column] != "0"}), 1)

    def test_reference_is_named(self):
        self.assertIn("exact motion of Lagrange's top", self.study("top.nml", *BRIEF))
        self.write("damped.nml", TOP + "&damping coefficient = 1, 1, 1 /")
        text = self.succeed("cost", "damped.nml", *BRIEF).stdout
        self.assertIn("nielsen_krenk order 8 (reduced) and dop853", text)
        self.assertRegex(text, r"agree to \S+ rad: 1\d digits")

    def test_csv_has_a_row_for_each_run(self):
        self.succeed("cost", "top.nml", *SHORT, "--csv", "runs.csv", "--set", "integrator.end_time=0.5")
        rows = self.rows("runs.csv")
        self.assertNotIn("\r", self.read("runs.csv"))
        self.assertEqual(self.names(), ["box.nml", "runs.csv", "top.nml"])
        best, at_step = {}, {}
        self.assertNotIn("exact", {row["method"] for row in rows})
        for row in rows:
            at = {key: float(value) for key, value in row.items() if key not in ("method", "formulation")}
            if not row["method"].startswith("taylor"):
                self.assertEqual(at["steps"], -(-0.5 // at["time_step"]))
            self.assertAlmostEqual(at["ns_per_step"], 1e9 * at["wall_time"] / at["steps"], delta=1e-6 * at["ns_per_step"])
            self.assertGreaterEqual(at["samples"], 3)
            if row["method"] == "nielsen_krenk" or row["method"].endswith("+conserve"):
                self.assertLess(max(at["energy_error"], at["momentum_error"], at["norm_error"]), 1e-12)
            if row["method"] != "nielsen_krenk":
                self.assertEqual(at["iterations"], 0)
            key = (row["method"], row["formulation"], int(row["order"]))
            best[key] = min(best.get(key, 9.0), at["attitude_error"])
            at_step[key, row["time_step"]] = at["attitude_error"]
        self.assertEqual(len(best), len(LABELS))
        for solver in ("full", "reduced"):
            # How short the shortest steps are depends on the budget: the same step is compared.
            second, fourth = (("nielsen_krenk", solver, order) for order in (2, 4))
            step = min((step for key, step in at_step if key == second and (fourth, step) in at_step), key=float)
            self.assertLess(at_step[fourth, step], 0.01 * at_step[second, step])
            self.assertLess(best["nielsen_krenk", solver, 8], 1e-9)

    def test_series_goes_on_to_round_off_although_coarse_tolerances_give_the_same_steps(self):
        self.succeed("cost", str(ROOT / "scenes/precessing_top.nml"), *BRIEF, "--csv", "runs.csv")
        for method in ("taylor", "taylor+conserve"):
            errors = [float(row["attitude_error"]) for row in self.rows("runs.csv") if row["method"] == method]
            self.assertLess(errors[1] / errors[0], 1.5)
            self.assertGreater(errors[1] / errors[0], 0.7)
            self.assertLess(min(errors), 1e-11)

    def test_csv_on_standard_output_leaves_the_table_to_standard_error(self):
        done = self.succeed("cost", "box.nml", *QUICK, "--csv", "-")
        self.assertTrue(done.stdout.startswith("method,order,formulation,time_step,steps,"))
        self.assertTrue(all(line.count(",") == done.stdout.splitlines()[0].count(",")
                            for line in done.stdout.splitlines()))
        self.assertIn("cheapest first", done.stderr)

    def test_a_budget_in_evaluations_is_kept_and_repeats_the_runs(self):
        tables = []
        for _ in range(2):
            text = self.succeed("cost", "top.nml", *BRIEF, "--csv", "runs.csv").stdout
            spent = int(re.search(r"measured for +\S+ s, (\d+) evaluations", text)[1])
            # The least that a run of a method takes is one step; none has more than 17 stages.
            self.assertLessEqual(spent, 100000 + 17*len(METHODS))
            self.assertGreater(spent, 50000)
            tables.append([{key: value for key, value in row.items() if key not in ("wall_time", "ns_per_step")}
                           for row in self.rows("runs.csv")])
        self.assertEqual(*tables)

    def test_why_no_step_is_possible_is_said(self):
        """Each step is subdivided into a thousand parts, which fail."""
        self.write("subdivided.nml", SUBDIVIDED)
        self.fail_with(3, "cost", "subdivided.nml", "--evaluations", "30000", says=(
            "no run was completed: nielsen_krenk order 2 (full):", "even subdivided into 1024 parts"))

    def test_a_motion_too_long_for_a_reference_still_shows_invariants(self):
        self.write("chaos.nml", TOP.replace("0.0, 0.0, 1.0 /", "0.3, 0.5, 1.0 /").replace("5.0, 5.0", "5.0, 4.0")
                   .replace("50.0", "2.0"))
        done = self.succeed("cost", "chaos.nml", *BRIEF, "--set", "integrator.end_time=200")
        self.assertIn("none:", done.stdout)
        self.assertIn("attitude errors are not shown", done.stdout)
        self.assertRegex(done.stdout, r"agree only to [0-9]|do not reach t = 200 s")
        self.assertNotIn("cheapest first", done.stdout)

    def test_a_scene_without_a_time_step_and_one_that_goes_back(self):
        self.write("control.nml", TOP.replace("time_step = 0.005", "accuracy = 1e-6"))
        self.assertIn("time_step=", self.succeed("cost", "control.nml", *BRIEF).stdout)
        back = self.succeed("cost", "top.nml", *BRIEF, "--set", "integrator.time_step=-0.01",
                            "--set", "integrator.end_time=-1").stdout
        self.assertIn("time_step=-", back)

    def test_columns_without_an_attitude_do_not_matter(self):
        text = self.succeed("cost", "box.nml", *QUICK, "--set", "output.columns='angular_momentum'").stdout
        self.assertIn("time_step=", text)

    def test_without_projection_only_what_can_run_is_run(self):
        text = self.succeed("cost", "top.nml", *QUICK, "--set", "integrator.projection=.false.",
                            "--set", "integrator.auxiliary_inertia=10").stdout
        self.assertIn("(reduced): not applicable to this scene", text)


class Plot(CommandLineTest):
    def setUp(self):
        super().setUp()
        if not shutil.which("gnuplot"):
            self.skipTest("gnuplot is not here")

    def test_svg(self):
        self.succeed("cost", "box.nml", *QUICK, "--plot", "it's a.svg")
        text = self.read("it's a.svg")
        self.assertIn("<svg", text)
        self.assertTrue(text.rstrip().endswith("</svg>"))
        for words in ("Free box", "Nielsen-Krenk, order ", ", reduced", ", full", "Runge-Kutta rk4, projected", "attitude error",
                      "energy residual"):
            self.assertIn(words, text)
        self.assertEqual(self.names(), ["box.nml", "it's a.svg", "top.nml"])

    def test_methods_without_a_run_stay_in_the_legend(self):
        self.succeed("cost", "top.nml", *QUICK, "--plot", "a.svg", "--all", "--set", "integrator.projection=.false.",
                     "--set", "integrator.auxiliary_inertia=10")
        text = self.read("a.svg")
        for words in ("Nielsen-Krenk, order 8, reduced: not here", "Nielsen-Krenk, order 2, full", "Runge-Kutta rk4",
                      "Dormand-Prince dop853, projected", "Taylor series"):
            self.assertIn(words, text)

    def test_png(self):
        self.succeed("cost", "box.nml", *QUICK, "--plot", "a.png")
        with open(self.path("a.png"), "rb") as file:
            self.assertEqual(file.read(8), b"\x89PNG\r\n\x1a\n")

    def test_a_gnuplot_that_fails_leaves_the_earlier_picture(self):
        os.mkdir(self.path("bin"))
        self.write("bin/gnuplot", "#!/bin/sh\nexit 1\n")
        os.chmod(self.path("bin/gnuplot"), stat.S_IRWXU)
        self.write("a.svg", "<svg>earlier</svg>")
        self.fail_with(4, "cost", "box.nml", *QUICK, "--plot", "a.svg", says=("a.svg", "gnuplot"),
                       env={**os.environ, "PATH": self.path("bin") + os.pathsep + os.environ["PATH"]})
        self.assertEqual(self.read("a.svg"), "<svg>earlier</svg>")
        self.assertEqual(self.names(), ["a.svg", "bin", "box.nml", "top.nml"])

    scripts = {}

    def script(self, *options):
        """The script that gnuplot gets; each is made once."""
        if options not in self.scripts:
            self.scripts[options] = self.make_script(*options)
        return self.scripts[options]

    def make_script(self, *options):
        os.mkdir(self.path("bin"))
        self.write("bin/gnuplot", '#!/bin/sh\ncp "$2" kept.gp && echo "<svg></svg>" >"$3"\n')
        os.chmod(self.path("bin/gnuplot"), stat.S_IRWXU)
        self.succeed("cost", "box.nml", *QUICK, "--plot", "a.svg", *options,
                     env={**os.environ, "PATH": self.path("bin") + os.pathsep + os.environ["PATH"]})
        return self.read("kept.gp")

    def test_no_curve_turns_back(self):
        lines = self.script("--all").splitlines()
        curves = [lines[i + 1:lines.index("EOD", i)] for i, line in enumerate(lines) if line.endswith("<< EOD")]
        self.assertGreater(sum(map(bool, curves)), 5)
        for curve in curves:
            times, errors, _ = zip(*[map(float, line.split()) for line in curve if "NaN" not in line] or [(0, 0, 0)])
            self.assertEqual(list(times), sorted(times))
            self.assertEqual(list(errors), sorted(errors, reverse=True))

    def test_no_two_curves_look_alike(self):
        for options, least, most in (((), 6, 6), (("--all",), 13, 20)):
            panels = [line for line in self.script(*options).splitlines() if line.startswith("plot ")]
            self.assertEqual(len(panels), 2)
            for panel in panels:
                styles = re.findall(r"with linespoints (.*?) title", panel)
                self.assertTrue(least <= len(styles) <= most, styles)
                self.assertEqual(len(set(styles)), len(styles), styles)

    def test_no_curve_goes_on_behind_its_minimum(self):
        blocks = re.findall(r"<< EOD\n(.*?)EOD", self.script("--all"), re.DOTALL)
        errors = [[float(row.split()[1]) for row in block.splitlines() if "NaN" not in row] for block in blocks]
        self.assertGreater(sum(len(block) for block in errors), 20)
        for block in errors:
            if block:
                self.assertEqual(block.index(min(block)), len(block) - 1)


class Refusals(CommandLineTest):
    def test_a_missing_gnuplot_is_said_at_once(self):
        os.mkdir(self.path("bin"))
        done = self.fail_with(4, "cost", "box.nml", "--plot", "a.svg", says=("a.svg", "gnuplot is not installed"),
                              env={**os.environ, "PATH": self.path("bin")})
        self.assertEqual(done.stdout, "")
        self.assertEqual(self.names(), ["bin", "box.nml", "top.nml"])

    def test_options(self):
        for arguments, words in ((("--plot", "a.gif"), "a.gif"), (("--plot", ".svg"), ".svg"), (("--csv", ""), "--csv"),
                                 *((("--evaluations", text), f"--evaluations '{text}'") for text in ("0", "-1", "1.5", "many", "nan")),
                                 (("--evaluations",), "needs a value"),
                                 (("--evaluations", "1", "--evaluations", "2"), "given twice"),
                                 (("--output", "a.csv"), "has no option --output"), (("--quiet",), "has no option")):
            done = self.fail_with(2, "cost", "box.nml", *arguments, says=(words,))
            self.assertEqual(done.stdout, "")
        self.fail_with(2, "run", "box.nml", "--csv", "1.svg", says=("nutate run has no option",))
        self.fail_with(2, "run", "box.nml", "--evaluations", "1", says=("nutate run has no option",))

    def test_the_scene_is_not_written_over(self):
        before = self.read("box.nml")
        self.fail_with(2, "cost", "box.nml", "--csv", "./box.nml", says=("is the scene itself",))
        self.assertEqual(self.read("box.nml"), before)

    def test_bad_scenes_and_folders(self):
        self.fail_with(2, "cost", "none.nml", says=("none.nml",))
        self.fail_with(2, "cost", "box.nml", "--set", "body.size=1", says=("--set",))
        self.fail_with(4, "cost", "box.nml", "--csv", "absent/a.csv", says=("absent/a.csv",))
        os.mkdir(self.path("a.svg"))
        if shutil.which("gnuplot"):
            self.fail_with(4, "cost", "box.nml", "--csv", "a.csv", "--plot", "a.svg", says=("a.svg", "folder"))
            self.assertEqual(self.names(), ["a.svg", "box.nml", "top.nml"])

    def test_no_run_within_the_budget(self):
        done = self.fail_with(3, "cost", "top.nml", "--evaluations", "10000", "--csv", "a.csv", "--set",
                              "integrator.end_time=1e6", says=("no run was completed within 10000 evaluations", "--evaluations"))
        self.assertEqual(done.stdout, "")
        self.assertEqual(self.names(), ["box.nml", "top.nml"])

    def test_help(self):
        text = self.succeed("cost", "--help").stdout
        for words in ("--plot FILE.svg|png", "--csv FILE", "--evaluations N", "--set GROUP.KEY=VALUE"):
            self.assertIn(words, text)
        self.assertTrue(all(len(line) <= 110 for line in text.splitlines()))
        self.assertIn("nutate cost SCENE", self.succeed("--help").stdout)


if __name__ == "__main__":
    unittest.main()
