"""nutate plot HISTORY.csv, and nutate run --plot: pictures of histories."""
import os
import re
import shutil
import stat
import unittest

from support import COLUMNS, CommandLineTest, all_columns


def legend(svg):
    """The curves of a picture, by their names in the legends."""
    return re.findall(r"<title>([^<]+)</title>\s*<g fill", svg)


def labels(svg):
    """All text of a picture."""
    return [text.strip() for text in re.findall(r"<(?:tspan|text)[^>]*>([^<]*)</", svg)]


def colour(svg, curve):
    """The colour of a curve."""
    part = svg[svg.index(f"<title>{curve}</title>"):]
    return re.search(r"<path stroke='rgb\(([ \d,]+)\)'", part)[1].replace(" ", "")


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
        self.assertEqual(legend(picture)[:8], ["omega1", "omega2", "omega3", "q0", "q1", "q2", "q3", "kinetic"])
        self.assertIn("box.csv", labels(picture))
        self.assertEqual(self.names(), ["box.csv", "box.nml", "box.svg", "top.nml"])

    def test_every_column_can_be_drawn(self):
        self.succeed("run", "top.nml", "--quiet", "--set", "output.columns=" + all_columns(), "--plot", "it's all.svg")
        picture = self.read("it's all.svg")
        self.assertEqual(sorted(legend(picture)), sorted(sum(COLUMNS.values(), [])))
        self.assertIn("energy (J)", labels(picture))
        self.succeed("run", "top.nml", "--quiet", "--set", "output.columns=angular_momentum_space", "--plot", "top.svg")
        self.assertEqual(legend(self.read("top.svg")), ["l_x", "l_y", "l_z"])
        for name in ("x", "y", "z"):
            self.assertEqual(colour(picture, f"l_{name}"), colour(self.read("top.svg"), f"l_{name}"))
            self.assertEqual(colour(picture, f"l_{name}"), colour(picture, f"omega_{name}"))
        self.assertNotEqual(colour(picture, "l_x"), colour(picture, "l_y"))

    def test_degrees_are_drawn(self):
        self.succeed("run", "box.nml", "--quiet", "--set", "output.degrees=.true.", "--set",
                     "output.columns='angular_velocity','euler'", "--plot", "box.svg")
        picture = self.read("box.svg")
        self.assertEqual(legend(picture), ["omega1_deg", "omega2_deg", "omega3_deg", "phi_deg", "psi_deg", "theta_deg"])
        self.assertIn("Ω (°/s)", labels(picture))
        self.assertFalse([label for label in labels(picture) if "rad" in label])

    def test_orbits_and_wheels_are_drawn(self):
        self.write("orbit.nml", "&body inertia = 90.0, 100.0, 40.0 /\n&orbit altitude = 500e3 /\n&wheel axis = 0, 1, 0, "
                   "inertia = 0.1, speed = 10 /\n&initial angular_velocity = 0, 0, 0, rate_from = 'lvlh' /\n"
                   "&integrator time_step = 20, end_time = 200 /\n")
        for columns, curves in (("'lvlh_attitude'", ["lvlh_q0", "lvlh_q1", "lvlh_q2", "lvlh_q3", "roll", "pitch", "yaw"]),
                                ("'wheel1'", ["wheel1_speed", "wheel1_momentum", "wheel1_motor_work", "wheel1_friction_work"]),
                                ("'orbit'", ["orbit_x", "orbit_y", "orbit_z", "orbit_radius", "true_anomaly"])):
            self.succeed("run", "orbit.nml", "--quiet", "--set", f"output.columns={columns}", "--plot", "orbit.svg")
            self.assertEqual(legend(self.read("orbit.svg")), curves)

    def test_the_title_is_that_of_the_scene(self):
        self.succeed("run", "box.nml", "--quiet", "--plot", "box.svg")
        self.assertIn("Free box", labels(self.read("box.svg")))
        self.assertNotIn("box.csv", labels(self.read("box.svg")))
        self.succeed("plot", "box.csv", "--title", "Its 2nd_flip")
        self.assertIn("Its 2nd_flip", labels(self.read("box.svg")))

    def test_columns_are_chosen(self):
        self.succeed("run", "box.nml", "--quiet")
        self.succeed("plot", "box.csv", "--columns", "total,omega3")
        self.assertEqual(legend(self.read("box.svg")), ["omega3", "total"])
        self.succeed("plot", "box.csv", "--columns=energy, omega1")
        self.assertEqual(legend(self.read("box.svg")), ["omega1", "kinetic", "potential", "total", "work", "energy_residual"])
        self.fail_with(2, "plot", "box.csv", "--columns", "omega4", says=("box.csv: there is no column 'omega4' (expected q0, q1, q2, q3, omega1, ", "; nearest: omega"))
        self.fail_with(2, "plot", "box.csv", "--columns", "", says=("--columns",))
        self.write("other.csv", "t,omega1,depth of water\n0,1,2\n1,2,3\n")
        self.succeed("plot", "other.csv", "--columns", "depth of water")
        self.assertEqual(legend(self.read("other.svg")), ["depth of water"])

    def test_pdf(self):
        self.succeed("run", "box.nml", "--quiet", "--plot", "box.pdf")
        with open(self.path("box.pdf"), "rb") as file:
            self.assertEqual(file.read(5), b"%PDF-")
        self.succeed("plot", "box.csv", "--output", "box.pdf")

    def test_controllers_and_their_field_are_drawn(self):
        self.write("point.nml", "&body inertia = 5.0, 20.0, 17.0 /\n&initial angular_velocity = 0.1, 0.0, 1.0 /\n"
                   "&integrator time_step = 0.1, end_time = 1.0 /\n&controller law = 'quaternion', by = 'magnetorquers', "
                   "field = 1, 0, 0, attitude_gain = 1, rate_gain = 1, sample = 0.5 /\n"
                   "&output columns = 'controller1', 'pointing_error1', 'magnetic_field' /\n")
        self.succeed("run", "point.nml", "--quiet", "--plot", "point.svg")
        drawn = legend(self.read("point.svg"))
        self.assertEqual(sorted(drawn), sorted([f"controller1_{kind}{k}" for kind in ("commanded", "applied") for k in (1, 2, 3)]
                                               + ["controller1_saturations", "pointing_error1", "B1", "B2", "B3"]))

    def test_attitudes_relative_to_frames_are_drawn(self):
        self.write("seen.csv", "t,frame1_q0,frame1_q1,frame1_q2,frame1_q3,frame1_angle_deg\n0,1,0,0,0,0\n1,0.8,0.6,0,0,73.7\n")
        self.assertEqual(self.succeed("plot", "seen.csv").stderr, "")
        picture = self.read("seen.svg")
        self.assertEqual(legend(picture), ["frame1_q0", "frame1_q1", "frame1_q2", "frame1_q3", "frame1_angle_deg"])
        self.assertIn("angle from frame 1 (°)", picture)
        self.assertIn("q from frame 1", picture)

    def test_names_in_quotes_may_hold_commas(self):
        self.write("sheet.csv", '"t","x, seen from above","omega1","omega2",omega3\r\n0,"1",2,3,4\r\n1,"1",3,"3",5\r\n')
        self.succeed("plot", "sheet.csv")
        self.assertEqual(legend(self.read("sheet.svg")), ["omega1", "omega2", "omega3"])

    def test_rows_half_a_turn_apart_are_noted(self):
        for end, rate, noted in (("", 3.0, False), ("", 3.2, True), ("_deg", 170, False), ("_deg", 190, True)):
            with self.subTest(end=end, rate=rate):
                names = ",".join(f"omega{k}{end}" for k in (1, 2, 3))
                self.write("rows.csv", f"t,total,{names}\n0,1,0,0,{rate}\n1,1,0,0,{rate}\n2,1,0,0,{rate}\n")
                said = self.succeed("plot", "rows.csv", "--columns", "total").stderr
                self.assertEqual("rows.csv: the body turns by half a revolution or more between rows, from t = 0 s on" in said, noted)
                self.assertEqual("expected rows less than" in said, noted)

    def test_each_wheel_and_controller_has_its_colour(self):
        self.write("wheels.csv", "t," + ",".join(f"{name}{k}{end}" for name, end in (("wheel", "_speed"), ("pointing_error", ""))
                                                 for k in range(1, 7)) + "\n" + "".join(f"{t}" + f",{t}" * 12 + "\n" for t in (0, 1)))
        self.succeed("plot", "wheels.csv")
        picture = self.read("wheels.svg")
        for colour in ("d55e00", "009e73", "0b3c5d", "e69f00", "56b4e9", "cc79a7"):
            red, green, blue = (int(colour[i:i + 2], 16) for i in (0, 2, 4))
            self.assertEqual(len(re.findall(rf"<path stroke='rgb\({red:3d}, *{green}, *{blue}\)' *d=", picture)), 2, colour)

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

    def test_blank_lines_at_the_end_of_a_history_are_no_rows(self):
        self.write("h.csv", "t,L1,L2,L3\n0,1,2,3\n1,1,2,4\n\n \n")
        self.succeed("plot", "h.csv", "--output", "h.svg")
        self.write("h.csv", "t,L1,L2,L3\n0,1,2,3\n\n1,1,2,4\n")
        self.fail_with(2, "plot", "h.csv", "--output", "h.svg", says=("h.csv:3:",))

    def test_what_is_no_history_is_refused(self):
        bad = {"no.csv": ("a,b\n1,2\n", "no.csv:1: not a history"), "empty.csv": ("", "cannot be read"),
               "word.csv": ("t,L1,L2,L3\n0,1,x,3\n", "word.csv:2: 'x' is not a number"),
               "short.csv": ("t,L1,L2,L3\n0,1,2,3\n1,2\n", "short.csv:3: 2 fields (expected 4)"),
               "wide.csv": ("t,L1,L2,L3\n0,1,2,3\n1,2,3,4,5\n", "wide.csv:3: more than 4 fields"),
               "head.csv": ("t,L1,L2,L3", "head.csv: no rows to plot"),
               "row.csv": ("t,L1,L2,L3\n0,1,2,3\n", "no rows to plot"),
               "else.csv": ("t,depth\n0,1\n1,1\n", "else.csv: none of its columns is a column of nutate (expected --columns NAME")}
        for name, (text, says) in bad.items():
            self.write(name, text)
            self.fail_with(2, "plot", name, says=(says,))
        self.fail_with(2, "plot", "absent.csv", says=("absent.csv: cannot be read",))
        self.assertEqual([name for name in self.names() if not name.endswith((".csv", ".nml"))], [])


class Refusals(CommandLineTest):
    def test_before_the_run(self):
        for arguments, says in ((("--plot", "a.gif"), "a.gif"), (("--plot", "a.svg", "--output", "-"), "--plot needs rows"),
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
        self.fail_with(2, "plot", "a.csv", "--output", "a.gif", says=("a.gif is not a picture file",))
        self.fail_with(2, "plot", "a.csv", "--quiet", says=("nutate plot has no option --quiet",))
        self.succeed("run", "box.nml", "--quiet")
        os.rename(self.path("box.csv"), self.path("box.svg"))
        self.fail_with(2, "plot", "box.svg", "--output", "box.svg", says=("would be overwritten",))

    def test_help(self):
        text = self.succeed("help", "plot").stdout
        for words in ("nutate plot HISTORY.csv [options]", "--output FILE", "--columns", "--title", "--help"):
            self.assertIn(words, text)
        self.assertTrue(all(len(line) <= 110 for line in text.splitlines()))


if __name__ == "__main__":
    unittest.main()
