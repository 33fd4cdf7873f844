"""&tangent: what run prints, what sweep writes, and what is refused."""
import re

from support import CommandLineTest
from test_sweep import read_npy

TOP = """&body inertia = 3, 2, 1 /
&initial quaternion = 0.8, 0.4, -0.4, 0.2, angular_velocity = 0.4, -0.3, 0.5 /
&dipole moment = 1, 0.3, 0.5, field = 0, 0, -1 /
&integrator formulation = 'reduced', time_step = 0.1, end_time = 200 /
&output columns = 'quaternion', 'angular_velocity', every = 100 /
"""
TANGENT = "&tangent exponents = 6, every = 3 /\n"
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

    def test_check_refuses_what_run_refuses(self):
        self.write("both.nml", TOP + TANGENT + "&free key = 'initial.angular_velocity' /\n")
        shown = ("--set", "output.columns='sensitivities'")
        self.assertEqual(self.fail_with(2, "check", "both.nml", *shown).stderr, self.fail_with(2, "run", "both.nml", *shown).stderr)

    def test_an_accuracy_gets_a_method_with_columns(self):
        self.write("chaos.nml", TOP + "&tangent /\n")
        page = self.succeed("run", "chaos.nml", "--set", "integrator.accuracy=1e-6", "--set", "integrator.formulation='reduced'",
                            "--set", "integrator.end_time=50", "--set", "output.interval=10").stderr
        self.assertGreater(number(page, "FLI"), 2)

    def test_rows_of_a_sweep_have_fields_whatever_way_they_came_about(self):
        self.write("map.nml", TOP.replace("200 /", "20 /") + "&tangent momentum_scale = 1 /\n" + GRID +
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
        self.write("one.nml", TOP.replace("200 /", "20 /") + "&tangent momentum_scale = 1 /\n")
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
                ("&tangent exponents = 2 /", "chaos.nml:6: exponents is neither 1 nor 6 (expected 1, the largest"),
                ("&tangent every = 101 /", "chaos.nml:6: every is too large (expected 1 to 100 steps)"),
                ("&tangent vector = 0, 0, 0, 0, 0, 0 /", "chaos.nml:6: vector"),
                ("&damping coefficient = 1, 1, 1 /\n&tangent /", "chaos.nml:7: method = 'taylor' has tangent columns of free bodies")):
            with self.subTest(change=change):
                method = "method = 'taylor'" if "taylor" in says else "formulation = 'reduced'"
                self.write("chaos.nml", TOP.replace("formulation = 'reduced'", method) + change + "\n")
                self.fail_with(2, "run", "chaos.nml", says=[says])
        self.write("chaos.nml", TOP.replace("0.4, -0.3, 0.5 /", "0, 0, 0 /") + "&tangent /\n")
        self.fail_with(2, "run", "chaos.nml", says=["a body at rest has no scale of momentum (expected momentum_scale in &tangent)"])
        self.succeed("run", "chaos.nml", "--set", "tangent.momentum_scale=1")
        self.write("chaos.nml", TOP + "&tangent /\n&free key = 'body.inertia.1' /\n")
        self.fail_with(2, "run", "chaos.nml", "--set", "output.columns='sensitivities'", says=["(expected &tangent without &free)"])
