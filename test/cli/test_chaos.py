"""&chaos: what run prints, what sweep writes, and what is refused."""
import os
import re
import stat

from support import CommandLineTest
from test_sweep import read_npy

TOP = """&body inertia = 3, 2, 1 /
&initial quaternion = 0.8, 0.4, -0.4, 0.2, angular_velocity = 0.4, -0.3, 0.5 /
&dipole moment = 1, 0.3, 0.5, field = 0, 0, -1 /
&integrator formulation = 'reduced', time_step = 0.1, end_time = 200 /
&output columns = 'quaternion', 'angular_velocity', every = 100 /
"""
TANGENT = "&chaos exponents = 6, every = 3 /\n"
GRID = """&ensemble file = 'map.npy' /
&vary key = 'initial.angular_velocity.1', distribution = 'grid', low = 0, high = 1, points = 3 /
&vary key = 'initial.angular_velocity.3', distribution = 'grid', low = 0, high = 2, points = 4 /
"""


def number(page, name):
    """The first number of an item of a summary."""
    return float(re.search(rf"{name}\s+(-?[\d.]+(?:[Ee][-+]\d+)?)", page)[1])


class Chaos(CommandLineTest):
    def bytes_of(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def test_the_summary_has_indicators_and_states_keep_their_bits(self):
        self.write("plain.nml", TOP)
        self.write("chaos.nml", TOP + TANGENT)
        self.succeed("run", "plain.nml", "--quiet")
        page = self.succeed("run", "chaos.nml").stderr
        self.assertEqual(self.bytes_of("plain.csv"), self.bytes_of("chaos.csv"))
        self.assertGreater(number(page, "Lyapunov exponents"), 0.1)
        self.assertIn("over 199.8 s", page)
        self.assertGreater(number(page, "MEGNO"), 4)
        self.assertGreater(number(page, "FLI"), 10)
        self.assertNotIn("MEGNO", self.succeed("run", "plain.nml").stderr)
        self.assertRegex(self.succeed("check", "chaos.nml").stdout, r"\n  summary +all Lyapunov exponents, MEGNO, FLI\n")
        self.assertNotIn("MEGNO", self.succeed("check", "plain.nml").stdout)

    def rows_of(self, name):
        lines = self.read(name).splitlines()
        return [dict(zip(lines[0].split(","), map(float, line.split(",")))) for line in lines[1:]]

    def test_columns_are_the_indicators_so_far(self):
        text = TOP.replace("'angular_velocity'", "'lyapunov', 'megno', 'fli'")
        self.write("chaos.nml", text + TANGENT)
        page = self.succeed("run", "chaos.nml").stderr
        rows = self.rows_of("chaos.csv")
        names = [*(f"lyapunov{i}" for i in range(1, 7)), "megno", "fli"]
        self.assertEqual(list(rows[0])[5:], names)
        self.assertEqual([rows[0][name] for name in names], [0] * 8)
        for name, item in (("lyapunov1", "Lyapunov exponents"), ("megno", "MEGNO"), ("fli", "FLI")):
            self.assertAlmostEqual(rows[-1][name] / number(page, item), 1, delta=5e-6)
        # A row is what a run to there comes to.
        self.succeed("run", "chaos.nml", "--quiet", "--set", "integrator.end_time=50", "--output", "short.csv")
        self.assertEqual(self.rows_of("short.csv")[-1], rows[5])
        self.write("chaos.nml", text + "&chaos /\n")
        self.succeed("run", "chaos.nml", "--quiet")
        self.assertEqual(list(self.rows_of("chaos.csv")[0])[5:], ["lyapunov", "megno", "fli"])

    def test_rows_inside_steps_have_the_last_sample_before_them(self):
        text = TOP.replace("'angular_velocity', every = 100", "'megno', 'fli', ")
        names = ("megno", "fli")
        self.write("ends.nml", text + TANGENT)
        self.succeed("run", "ends.nml", "--quiet", "--set", "integrator.end_time=5")
        ends = self.rows_of("ends.csv")
        self.write("inside.nml", text.replace("'fli', ", "'fli', times = 0.05, 1.25, 3.0, 3.05, 4.99") + TANGENT)
        self.succeed("run", "inside.nml", "--quiet", "--set", "integrator.end_time=5")
        for row, steps in zip(self.rows_of("inside.csv"), (0, 12, 30, 30, 49)):
            self.assertEqual([row[name] for name in names], [ends[steps][name] for name in names])
        adaptive = text.replace("'fli', ", "'fli', interval = 0.7").replace("formulation = 'reduced', time_step = 0.1",
                                                                            "method = 'rk8', local_tolerance = 1e-6") + "&chaos /\n"
        self.write("adaptive.nml", adaptive)
        self.succeed("run", "adaptive.nml", "--quiet", "--set", "integrator.end_time=5")
        self.write("steps.nml", adaptive.replace(", interval = 0.7", ""))
        self.succeed("run", "steps.nml", "--quiet", "--set", "integrator.end_time=5")
        ends = self.rows_of("steps.csv")
        for row in self.rows_of("adaptive.csv")[:-1]:
            last = [end for end in ends if end["t"] <= row["t"]][-1]
            self.assertEqual([row[name] for name in names], [last[name] for name in names])

    def test_free_numbers_stand_beside_them(self):
        columns = ("'angular_velocity', every = 100", "'angular_velocity', 'sensitivities', 'standard_deviations', every = 100")
        free = "&free key = 'initial.angular_velocity', 'body.mass', sigma = 0.1, 0.1, 0.1, 0.2 /\n"
        top = TOP.replace("3, 2, 1 /", "3, 2, 1, mass = 2, center_of_mass = 0.1, 0.05, 0.2 /\n&gravity acceleration = 0, 1, -2 /")
        self.write("free.nml", top.replace(*columns) + free)
        self.write("both.nml", top.replace(*columns).replace("deviations'", "deviations', 'lyapunov', 'megno', 'fli'") + TANGENT + free)
        self.write("chaos.nml", top.replace("'angular_velocity', ", "'angular_velocity', 'lyapunov', 'megno', 'fli', ") + TANGENT)
        pages = {}
        for name in ("free", "both", "chaos"):
            self.succeed("check", f"{name}.nml")
            pages[name] = self.succeed("run", f"{name}.nml").stderr
        plain, both, chaos = (self.rows_of(f"{name}.csv") for name in ("free", "both", "chaos"))
        self.assertEqual(list(both[0]), [*plain[0], *list(chaos[0])[-8:]])
        for row, other, third in zip(both, plain, chaos):
            for name, value in other.items():
                # Columns side by side may be summed in another order.
                group = name.split("rotation")[0].split("omega")[0]
                largest = max(abs(v) for k, v in other.items() if k.startswith(group)) if group else 0.0
                self.assertAlmostEqual(row[name], value, delta=1e-11 * largest if "_" in name else 0.0)
            for name in list(third)[-8:]:
                self.assertAlmostEqual(row[name], third[name], delta=1e-12 * max(1.0, abs(third[name])))
        for item in ("Lyapunov exponents", "MEGNO", "FLI"):
            self.assertEqual(number(pages["both"], item), number(pages["chaos"], item))

    def test_a_resumed_run_has_the_same_columns(self):
        self.write("both.nml", TOP.replace("'quaternion', 'angular_velocity', every = 100", "'sensitivities', 'lyapunov', 'megno', 'fli'")
                   .replace("200 /", "20 /") + TANGENT + "&free key = 'initial.angular_velocity' /\n")
        for steps in ("time_step=0.1", "local_tolerance=1e-8"):
            with self.subTest(steps=steps):
                settings = ["--unset", "integrator.time_step", "--set", f"integrator.{steps}"]
                whole = self.succeed("run", "both.nml", "--output", "whole.csv", *settings).stderr
                self.fail_with(3, "run", "both.nml", "--quiet", "--output", "part.csv", "--checkpoint", "ck", "--max-steps", "70", *settings)
                page = self.succeed("run", "both.nml", "--resume", "ck", *settings).stderr
                self.assertEqual(self.read("part.csv"), self.read("whole.csv"))
                self.assertEqual(number(page, "MEGNO"), number(whole, "MEGNO"))

    def test_a_picture_has_panels_of_them(self):
        os.makedirs(self.path("bin"))
        self.write("bin/gnuplot", '#!/bin/sh\ncp "$2" kept.gp && echo "<svg></svg>" >"$3"\n')
        os.chmod(self.path("bin/gnuplot"), stat.S_IRWXU)
        self.write("chaos.nml", TOP.replace("'quaternion', 'angular_velocity'", "'lyapunov', 'megno', 'fli'") + TANGENT)
        environment = {**os.environ, "PATH": self.path("bin") + os.pathsep + os.environ["PATH"]}
        self.succeed("run", "chaos.nml", "--quiet", "--plot", "chaos.svg", env=environment)
        script = self.read("kept.gp")
        for label in ("'Lyapunov exponents (1/s)'", "'mean MEGNO'", "'FLI'"):
            self.assertIn(f"set label 1 {label}", script)
        colours = re.findall(r"linecolor rgb '(#\w+)' title 'lyapunov", script)
        self.assertEqual((len(colours), len(set(colours))), (6, 6))
        self.succeed("plot", "chaos.csv", "--columns", "lyapunov", "--output", "one.svg", env=environment)
        self.assertEqual(self.read("kept.gp").count("set label 1 "), 1)

    def test_an_accuracy_gets_a_method_with_columns(self):
        self.write("chaos.nml", TOP + "&chaos /\n")
        page = self.succeed("run", "chaos.nml", "--set", "integrator.accuracy=1e-6", "--set", "integrator.formulation='reduced'",
                            "--set", "integrator.end_time=50", "--set", "output.interval=10").stderr
        self.assertGreater(number(page, "FLI"), 2)

    def test_rows_of_a_sweep_have_fields_whatever_way_they_came_about(self):
        self.write("map.nml", TOP.replace("200 /", "20 /") + "&chaos momentum_scale = 1 /\n" + GRID +
                   "&event name = 'flip', when = 'q0', crosses = 0.0 /\n")
        self.succeed("sweep", "map.nml", "--quiet", "--csv", "map.csv")
        whole = self.bytes_of("map.npy")
        names, rows = read_npy(whole)
        self.assertEqual(names[-5:], ["flip_count", "flip_first", "lyapunov", "megno", "fli"])
        self.assertEqual([row[1] for row in rows], [0]*12)
        self.assertEqual(len({row[-3] for row in rows}), 12)
        for chunk in ("1", "5"):
            self.succeed("sweep", "map.nml", "--quiet", "--output", "again.npy", "--set", f"ensemble.chunk={chunk}",
                         *(("--threads", "2") if "threads" in self.succeed("--version").stdout else ()))
            self.assertEqual(self.bytes_of("again.npy"), whole)
        self.write("one.nml", TOP.replace("200 /", "20 /") + "&chaos momentum_scale = 1 /\n")
        page = self.succeed("run", "one.nml", "--set", "initial.angular_velocity=0.5,-0.3,2").stderr
        self.assertAlmostEqual(rows[7][-3], number(page, "Lyapunov exponent"), delta=1e-5)
        self.assertAlmostEqual(rows[7][-1], number(page, "FLI"), delta=1e-4)

    def test_six_exponents_are_six_fields(self):
        self.write("map.nml", TOP.replace("200 /", "2 /") + TANGENT + GRID)
        self.succeed("sweep", "map.nml", "--quiet")
        names, rows = read_npy(self.bytes_of("map.npy"))
        self.assertEqual(names[-8:], [*(f"lyapunov{i}" for i in range(1, 7)), "megno", "fli"])
        # At rest there is a scale of momentum only where the scene gives one.
        self.assertNotEqual(rows[0][1], -1)
        for row in rows:
            self.assertLess(abs(sum(row[-8:-2])), 1e-2)

    def test_a_checkpoint_holds_the_sums(self):
        self.write("chaos.nml", TOP.replace("200 /", "2000 /") + TANGENT)
        page = self.succeed("run", "chaos.nml").stderr
        whole = self.bytes_of("chaos.csv")
        self.fail_with(3, "run", "chaos.nml", "--checkpoint", "c", "--max-steps", "12345", "--output", "chaos.csv")
        again = self.succeed("run", "chaos.nml", "--resume", "c").stderr
        self.assertEqual(self.bytes_of("chaos.csv"), whole)
        for name in ("Lyapunov exponents", "MEGNO", "FLI"):
            self.assertEqual(number(again, name), number(page, name))

    def test_what_has_no_columns_is_refused_with_the_line(self):
        for change, says in (
                ("&chaos exponents = 2 /", "chaos.nml:6: exponents is neither 1 nor 6 (expected 1, the largest"),
                ("&chaos every = 101 /", "chaos.nml:6: every is too large (expected 1 to 100 steps)"),
                ("&chaos vector = 0, 0, 0, 0, 0, 0 /", "chaos.nml:6: vector")):
            with self.subTest(change=change):
                self.write("chaos.nml", TOP + change + "\n")
                self.fail_with(2, "run", "chaos.nml", says=[says])
        self.write("chaos.nml", TOP + "&tangent exponents = 6 /\n")
        self.fail_with(2, "run", "chaos.nml", says=["chaos.nml:6: &tangent is now &chaos"])
        self.write("chaos.nml", TOP.replace("0.4, -0.3, 0.5 /", "0, 0, 0 /") + "&chaos /\n")
        self.fail_with(2, "run", "chaos.nml", says=["a body at rest has no scale of momentum (expected momentum_scale in &chaos)"])
        self.succeed("run", "chaos.nml", "--set", "chaos.momentum_scale=1")
        self.write("plain.nml", TOP.replace("'angular_velocity'", "'megno'"))
        self.fail_with(2, "run", "plain.nml", says=["plain.nml:5: columns 'megno' need indicators of chaos (expected &chaos)"])
        self.write("chaos.nml", TOP.replace("'angular_velocity'", "'megno'") + "&chaos /\n" + GRID)
        for command in ("sweep", "cost"):
            self.fail_with(2, command, "chaos.nml", says=["chaos.nml:5: only nutate run writes sensitivities, covariances and indicators"])
        self.write("chaos.nml", TOP + "&chaos /\n&event when = 'megno', crosses = 3 /\n")
        self.fail_with(2, "run", "chaos.nml", says=["chaos.nml:7: "])
