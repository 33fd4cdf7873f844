"""nutate plot HISTORY.csv, and nutate run --plot: pictures of histories."""
import os
import shutil
import stat
import unittest

from support import CommandLineTest, all_columns


def legend(svg):
    """The names in the legends of a picture."""
    names = ("omega1", "omega_x", "phi", "theta", "kinetic", "total", "residual", "norm_error", "L1", "l_x",
             "commanded1", "applied1", "error1", "B1")
    return [name for name in names if f">{name}<" in svg]


class Pictures(CommandLineTest):
    def setUp(self):
        super().setUp()
        if not shutil.which("gnuplot"):
            self.skipTest("gnuplot is not here")

    def test_a_history_is_drawn_beside_itself(self):
        self.succeed("run", "box.nml", "--quiet")
        self.assertEqual(self.succeed("plot", "box.csv").stdout, "")
        picture = self.read("box.svg")
        self.assertTrue(picture.rstrip().endswith("</svg>"))
        self.assertEqual(legend(picture), ["omega1", "phi", "theta", "kinetic", "total", "residual", "norm_error"])
        self.assertIn("box.csv", picture)
        self.assertEqual(self.names(), ["box.csv", "box.nml", "box.svg", "top.nml"])

    def test_what_is_drawn_is_what_the_history_has(self):
        self.succeed("run", "top.nml", "--quiet", "--set", "output.columns=" + all_columns(), "--plot", "it's all.svg")
        self.assertEqual(len(legend(self.read("it's all.svg"))), 10)
        self.succeed("run", "top.nml", "--quiet", "--set", "output.columns=angular_momentum_space", "--plot", "top.svg")
        self.assertEqual(legend(self.read("top.svg")), ["l_x"])

    def test_controllers_and_their_field_are_drawn(self):
        self.write("point.nml", "&body inertia = 5.0, 20.0, 17.0 /\n&initial angular_velocity = 0.1, 0.0, 1.0 /\n"
                   "&integrator time_step = 0.1, end_time = 1.0 /\n&regulator law = 'quaternion', by = 'magnets', "
                   "field = 1, 0, 0, attitude_gain = 1, rate_gain = 1, sample = 0.5 /\n"
                   "&output columns = 'regulator1', 'pointing_error1', 'magnetic_field' /\n")
        self.succeed("run", "point.nml", "--quiet", "--plot", "point.svg")
        drawn = legend(self.read("point.svg"))
        self.assertEqual(drawn, ["commanded1", "applied1", "error1", "B1"])

    def test_names_in_quotes_may_hold_commas(self):
        self.write("sheet.csv", '"t","x, seen from above","omega1","omega2",omega3\r\n0,"1",2,3,4\r\n1,"1",3,"3",5\r\n')
        self.succeed("plot", "sheet.csv")
        self.assertEqual(legend(self.read("sheet.svg")), ["omega1"])

    def test_png_under_another_name(self):
        self.succeed("run", "box.nml", "--quiet", "--output", "<box>.csv")
        self.succeed("plot", "<box>.csv", "--output", "a.png")
        with open(self.path("a.png"), "rb") as file:
            self.assertEqual(file.read(8), b"\x89PNG\r\n\x1a\n")

    def test_a_long_history_is_thinned_without_loss_of_extremes(self):
        rows = [f"{i},0,{2 if i == 12345 else 0},0\n" for i in range(20000)]
        self.write("long.csv", "t,omega1,omega2,omega3\n" + "".join(rows))
        self.succeed("plot", "long.csv")
        picture = self.read("long.svg")
        self.assertLess(len(picture), 200000)
        self.assertIn(">2<", picture)

    def test_a_failed_run_leaves_no_picture(self):
        self.fail_with(3, "run", "box.nml", "--max-steps", "10", "--plot", "box.svg", says=["box.csv.partial"])
        self.assertEqual(self.names(), ["box.csv.partial", "box.nml", "top.nml"])

    def test_a_gnuplot_that_fails_leaves_the_history(self):
        os.mkdir(self.path("bin"))
        self.write("bin/gnuplot", "#!/bin/sh\nexit 1\n")
        os.chmod(self.path("bin/gnuplot"), stat.S_IRWXU)
        self.fail_with(4, "run", "box.nml", "--quiet", "--plot", "a.svg", says=("a.svg", "gnuplot failed"),
                       env={**os.environ, "PATH": self.path("bin") + os.pathsep + os.environ["PATH"]})
        self.assertEqual(self.names(), ["bin", "box.csv", "box.nml", "top.nml"])

    def test_what_is_no_history_is_refused(self):
        bad = {"no.csv": ("a,b\n1,2\n", "no.csv:1: this is no history"), "empty.csv": ("", "cannot be read"),
               "word.csv": ("t,L1,L2,L3\n0,1,x,3\n", "word.csv:2: 'x' is not a number"),
               "short.csv": ("t,L1,L2,L3\n0,1,2,3\n1,2\n", "short.csv:3: 2 fields (expected 4)"),
               "wide.csv": ("t,L1,L2,L3\n0,1,2,3\n1,2,3,4,5\n", "wide.csv:3: more than 4 fields"),
               "row.csv": ("t,L1,L2,L3\n0,1,2,3\n", "no rows to draw"),
               "else.csv": ("t,iterations\n0,1\n1,1\n", "none of its columns is drawn")}
        for name, (text, says) in bad.items():
            self.write(name, text)
            self.fail_with(2, "plot", name, says=(says,))
        self.fail_with(2, "plot", "absent.csv", says=("absent.csv: cannot be read",))
        self.assertEqual([name for name in self.names() if not name.endswith((".csv", ".nml"))], [])


class Refusals(CommandLineTest):
    def test_before_the_run(self):
        for arguments, says in ((("--plot", "a.pdf"), "a.pdf"), (("--plot", "a.svg", "--output", "-"), "--plot needs rows"),
                                (("--plot", "a.svg", "--output", "/dev/null"), "--plot needs rows")):
            self.fail_with(2, "run", "box.nml", *arguments, says=(says,))
        self.fail_with(2, "check", "box.nml", "--plot", "a.svg", says=("has no option --plot",))
        os.mkdir(self.path("bin"))
        self.fail_with(4, "run", "box.nml", "--plot", "a.svg", says=("a.svg", "gnuplot is not installed"),
                       env={**os.environ, "PATH": self.path("bin")})
        self.assertEqual(self.names(), ["bin", "box.nml", "top.nml"])

    def test_of_plot(self):
        self.fail_with(2, "plot", says=("there is no history (expected nutate plot HISTORY.csv)",))
        self.fail_with(2, "plot", "a.csv", "b.csv", says=("unexpected argument 'b.csv' (expected one history)",))
        self.fail_with(2, "plot", "a.csv", "--output", "a.pdf", says=("a.pdf is no picture",))
        self.fail_with(2, "plot", "a.csv", "--quiet", says=("nutate plot has no option --quiet",))
        self.succeed("run", "box.nml", "--quiet")
        os.rename(self.path("box.csv"), self.path("box.svg"))
        self.fail_with(2, "plot", "box.svg", "--output", "box.svg", says=("will not be written over",))

    def test_help(self):
        text = self.succeed("help", "plot").stdout
        for words in ("nutate plot HISTORY.csv [options]", "--output FILE", "--help", "norm error"):
            self.assertIn(words, text)
        self.assertTrue(all(len(line) <= 110 for line in text.splitlines()))


if __name__ == "__main__":
    unittest.main()
