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


RATES = ["Ω1", "Ω2", "Ω3"]
ATTITUDE = ["q0", "q1", "q2", "q3"]


class Pictures(CommandLineTest):
    def setUp(self):
        super().setUp()
        if not shutil.which("gnuplot"):
            self.skipTest("gnuplot is not here")

    def without_drawing(self):
        """Environment in which gnuplot draws nothing, for what the program prints about rows."""
        os.mkdir(self.path("bin"))
        self.write("bin/gnuplot", '#!/bin/sh\necho "<svg></svg>" >"$3"\n')
        os.chmod(self.path("bin/gnuplot"), stat.S_IRWXU)
        return {**os.environ, "PATH": self.path("bin") + os.pathsep + os.environ["PATH"]}

    def numbers_of_the_axis(self, text):
        """The number of values along the vertical axis of a history with one panel that gnuplot writes in its picture."""
        self.write("axis.csv", text)
        self.succeed("plot", "axis.csv")
        return len(re.findall(r"text-anchor=.end", self.read("axis.svg")))

    def test_a_history_is_drawn_beside_itself(self):
        self.succeed("run", "box.nml", "--quiet")
        self.assertEqual(self.succeed("plot", "box.csv").stdout, "")
        picture = self.read("box.svg")
        self.assertTrue(picture.rstrip().endswith("</svg>"))
        self.assertEqual(legend(picture), RATES + ATTITUDE)
        self.assertIn("box.csv: angular velocity Ω, attitude quaternion q", labels(picture))
        self.assertEqual(self.names(), ["box.csv", "box.nml", "box.svg", "top.nml"])

    def test_a_column_that_is_there_twice_is_rejected(self):
        self.write("twice.csv", "t,omega1,omega1\n0,1,2\n1,2,3\n")
        self.fail_with(2, "plot", "twice.csv", says=["twice.csv:1: there are two columns 'omega1' (expected one)"])
        for names in ("t,t", "t (s),t (s)", "t (s),t", "t,t (min)"):
            self.write("twice.csv", names + ",omega1\n0,0,1\n1,1,2\n")
            self.fail_with(2, "plot", "twice.csv", says=["twice.csv:1: there are two columns 't' (expected one)"])
        self.assertNotIn("twice.svg", self.names())
        # Long names that differ only at their ends are different columns.
        names = [f"d_sphere1_momentum1/d_rotating_frame.2.gravitational_parameter.{i}" for i in (1, 2)]
        self.write("long.csv", f"t,{names[0]},{names[1]}\n0,1,2\n1,2,4\n")
        self.succeed("plot", "long.csv")

    def test_every_column_can_be_drawn(self):
        self.succeed("run", "top.nml", "--quiet", "--set", "output.columns=" + all_columns(), "--set", "output.every=10")
        self.succeed("plot", "top.csv", "--output", "it's all.svg", "--columns", ",".join(sum(COLUMNS.values(), [])))
        picture = self.read("it's all.svg")
        self.assertEqual(len(legend(picture)), len(sum(COLUMNS.values(), [])))
        for symbol in (*RATES, *ATTITUDE, "p0", "ωx", "|Ω|", "L1", "lx", "φ", "θ", "ψ", "T", "V", "T + V", "W", "q·q − 1"):
            self.assertIn(symbol, legend(picture))
        for label in ("energy (J)", "precession angle φ (rad)", "nutation angle θ (rad)", "spin angle ψ (rad)"):
            self.assertIn(label, labels(picture))
        self.succeed("run", "top.nml", "--quiet", "--set", "output.columns=angular_momentum_space", "--plot", "top.svg",
                     "--set", "integrator.end_time=0.1")
        self.assertEqual(legend(self.read("top.svg")), ["lx", "ly", "lz"])
        for name in ("x", "y", "z"):
            self.assertEqual(colour(picture, f"l{name}"), colour(self.read("top.svg"), f"l{name}"))
            self.assertEqual(colour(picture, f"l{name}"), colour(picture, f"ω{name}"))
        self.assertNotEqual(colour(picture, "lx"), colour(picture, "ly"))

    def test_degrees_are_drawn(self):
        self.succeed("run", "box.nml", "--quiet", "--set", "output.degrees=.true.", "--set",
                     "output.columns='angular_velocity','euler'", "--plot", "box.svg")
        picture = self.read("box.svg")
        self.assertEqual(legend(picture), [*RATES, "φ", "θ", "ψ"])
        self.assertIn("angular velocity Ω (°/s)", labels(picture))
        self.assertFalse([label for label in labels(picture) if "rad" in label])

    def test_orbits_and_wheels_are_drawn(self):
        self.write("orbit.nml", "&body inertia = 90.0, 100.0, 40.0 /\n&orbit altitude = 500e3 /\n&wheel axis = 0, 1, 0, "
                   "inertia = 0.1, speed = 10 /\n&initial angular_velocity = 0, 0, 0, rate_from = 'lvlh' /\n"
                   "&integrator time_step = 20, end_time = 200 /\n")
        for columns, curves in (("'lvlh_attitude'", [*ATTITUDE, "roll", "pitch", "yaw"]),
                                ("'wheel1'", ["wheel 1", "wheel 1", "motor", "friction"]),
                                ("'orbit'", ["x", "y", "z", "r", "ν"])):
            self.succeed("run", "orbit.nml", "--quiet", "--set", f"output.columns={columns}", "--plot", "orbit.svg")
            self.assertEqual(legend(self.read("orbit.svg")), curves)

    def test_the_title_is_that_of_the_scene(self):
        self.succeed("run", "box.nml", "--quiet", "--plot", "box.svg")
        self.assertIn("Free box: angular velocity Ω, attitude quaternion q", labels(self.read("box.svg")))
        self.assertNotIn("box.csv", labels(self.read("box.svg")))
        self.succeed("plot", "box.csv", "--title", "Its 2nd_flip")
        self.assertIn("Its 2nd_flip: angular velocity Ω, attitude quaternion q", labels(self.read("box.svg")))
        self.succeed("run", "box.nml", "--quiet", "--plot", "box.svg", "--title", "Mine", "--columns", "omega1")
        self.assertIn("Mine: angular velocity Ω", labels(self.read("box.svg")))

    def test_columns_are_chosen(self):
        self.succeed("run", "box.nml", "--quiet")
        self.succeed("plot", "box.csv", "--columns", "total,omega3")
        self.assertEqual(legend(self.read("box.svg")), ["Ω3", "T + V"])
        self.succeed("plot", "box.csv", "--columns=energy, omega1")
        self.assertEqual(legend(self.read("box.svg")), ["Ω1"])
        self.succeed("plot", "box.csv", "--columns=constraints, omega1")
        self.assertEqual(legend(self.read("box.svg")), ["Ω1", "q·q − 1", "q·p"])
        self.fail_with(2, "plot", "box.csv", "--columns", "omega4", says=("box.csv: there is no column 'omega4' (expected q0, q1, q2, q3, omega1, ", "; nearest: omega"))
        self.fail_with(2, "plot", "box.csv", "--columns", "", says=("--columns",))
        self.write("other.csv", "t,omega1,depth of water\n0,1,2\n1,2,3\n")
        self.succeed("plot", "other.csv", "--columns", "depth of water")
        self.assertEqual(legend(self.read("other.svg")), ["depth of water"])

    def test_energies_are_drawn_where_they_tell_something(self):
        self.write("fall.csv", "t,kinetic,potential,total,work\n0,1,0,1,0\n1,1,0,1,0\n")
        self.succeed("plot", "fall.csv")
        self.assertEqual(legend(self.read("fall.svg")), ["T", "V", "T + V", "W"])
        for rows, drawn in (("0,1,0,1,0,2\n1,1,0,1,0,3", ["ω"]), ("0,1,0,1,0,2\n1,0.5,0,0.5,-0.5,3", ["ω", "T", "W"]),
                            ("0,1,1,2,0,2\n1,1,1,2,1e-16,3", ["ω", "T", "V", "T + V"])):
            self.write("fall.csv", f"t,kinetic,potential,total,work,angular_speed\n{rows}\n")
            self.succeed("plot", "fall.csv")
            self.assertEqual([name.replace("|Ω|", "ω") for name in legend(self.read("fall.svg"))], drawn)
        self.write("fall.csv", "t,omega1,kinetic,potential,total,work\n0,1,1,0,1,0\n1,1,1,0,1,0\n")
        self.succeed("plot", "fall.csv", "--columns", "total,omega1")
        self.assertEqual(legend(self.read("fall.svg")), ["Ω1", "T + V"])

    def test_residuals_are_drawn_on_request(self):
        self.succeed("run", "box.nml", "--quiet", "--plot", "box.svg", "--residuals")
        residuals = ["residual", "q·q − 1", "q·p"]
        self.assertEqual(legend(self.read("box.svg")), RATES + ATTITUDE + residuals)
        self.succeed("plot", "box.csv", "--residuals", "--columns", "omega1")
        self.assertEqual(legend(self.read("box.svg")), ["Ω1"] + residuals)

    def test_euler_angles_stand_for_the_quaternion(self):
        self.write("both.csv", "t,q0,q1,q2,q3,phi,theta,psi,p0,p1,p2,p3\n0,1,0,0,0,0,0,0,1,1,1,1\n1,1,0,0,0,0,0,0,1,1,1,1\n")
        self.succeed("plot", "both.csv")
        self.assertEqual(legend(self.read("both.svg")), ["φ", "θ", "ψ"])

    def test_angles_that_hardly_change_are_not_magnified(self):
        self.write("steady.csv", "t,theta\n0,1.047\n1,1.051\n")
        self.succeed("plot", "steady.csv")
        self.assertIn("1.05", labels(self.read("steady.svg")))
        self.assertNotIn("1.048", labels(self.read("steady.svg")))
        self.write("steady.csv", "t,theta\n0,0.001\n1,0.0012\n")
        self.succeed("plot", "steady.csv")
        self.assertIn("0.00105", labels(self.read("steady.svg")))

    def test_curves_that_coincide_are_dashed(self):
        self.write("same.csv", "t,omega1,omega2,omega3\n0,1,1,2\n1,2,2,3\n2,3,3,0\n")
        self.succeed("plot", "same.csv")
        picture = self.read("same.svg")
        curves = re.findall(r"<title>(Ω.)</title>(.*?)(?=<title>|</svg>)", picture, re.DOTALL)
        self.assertEqual([(name, "stroke-dasharray" in text) for name, text in curves],
                         [("Ω1", False), ("Ω2", True), ("Ω3", False)])

    def test_pictures_of_runs_have_rows_near_enough(self):
        self.succeed("run", "box.nml", "--quiet", "--set", "output.every=200", "--plot", "sparse.svg")
        self.succeed("run", "box.nml", "--quiet", "--set", "output.every=1", "--output", "all.csv", "--plot", "all.svg")
        points = [len(re.findall(r"[ML ]?-?[\d.]+,[\d.]+", self.read(name))) for name in ("sparse.svg", "all.svg")]
        self.assertGreater(points[0], 0.3*points[1])
        self.assertNotIn("between rows", self.read("sparse.svg"))
        self.assertLess(len(self.read("box.csv").splitlines()), 20)
        self.succeed("plot", "box.csv")
        self.assertIn("rad between rows)", self.read("box.svg"))

    def test_pictures_of_runs_may_have_other_columns_than_the_history(self):
        self.succeed("run", "box.nml", "--quiet", "--plot", "box.svg", "--columns", "euler,l_z")
        self.assertEqual(legend(self.read("box.svg")), ["φ", "θ", "ψ", "lz"])
        self.assertNotIn("theta", self.read("box.csv"))
        self.succeed("run", "box.nml", "--quiet", "--plot", "box.svg", "--columns", "roll")
        self.assertEqual(legend(self.read("box.svg")), ["roll"])
        self.fail_with(2, "run", "box.nml", "--quiet", "--plot", "box.svg", "--columns", "omega4",
                       says=("there is no column 'omega4'", "nearest: omega"))
        self.fail_with(2, "run", "box.nml", "--quiet", "--plot", "box.svg", "--columns", "wheel1_speed", says=("wheel",))

    def test_one_column_against_another(self):
        self.succeed("run", "box.nml", "--quiet", "--plot", "box.svg", "--xy", "omega1:omega2")
        shown = "".join(labels(self.read("box.svg")))
        for text in ("Ω", "(rad/s)", "t = 0 s"):
            self.assertIn(text, shown)
        self.succeed("plot", "box.csv", "--xy", "omega3:total")
        self.assertIn("(J)", "".join(labels(self.read("box.svg"))))
        self.fail_with(2, "plot", "box.csv", "--xy", "omega1", says=("--xy 'omega1' is not a pair of columns",))
        self.fail_with(2, "plot", "box.csv", "--xy", "energy:omega1", says=("'energy' is a set of columns", "kinetic"))
        self.fail_with(2, "plot", "box.csv", "--xy", "omega1:omega2", "--columns", "q0", says=("exclude each other",))

    def test_the_ratio_of_energies_of_tumbling_is_no_potential_energy(self):
        self.succeed("run", "box.nml", "--quiet", "--set", "output.columns=tumbling,energy", "--plot", "box.svg")
        drawn = labels(self.read("box.svg"))
        self.assertIn("E/E₀", drawn)
        self.assertFalse([label for label in drawn if "potential" in label])
        self.write("two.csv", "t,energy_ratio,energy_residual,energy_spring\n0,1,0,2\n1,2,0,1\n")
        self.succeed("plot", "two.csv", "--columns", "energies")
        self.assertEqual(legend(self.read("two.svg")), ["energy_spring"])

    def test_each_effect_has_its_colour(self):
        effects = ("gravity", "dipole", "gravity_gradient", "spring1", "spring2")
        self.write("five.csv", "t," + ",".join(f"energy_{name}" for name in effects) + "\n0,1,2,3,4,5\n1,2,3,4,5,6\n")
        self.succeed("plot", "five.csv")
        picture = self.read("five.svg")
        self.assertEqual(len({colour(picture, f"energy_{name}") for name in effects}), len(effects))

    def test_a_panel_has_at_most_six_curves_whose_names_fit(self):
        for count, panels in ((6, 1), (7, 2), (21, 4)):
            names = [f"covariance_{i}" for i in range(1, count + 1)]
            self.write("many.csv", "t," + ",".join(names) + "".join("\n" + ",".join(str(t + i) for i in range(count + 1)) for t in (0, 1)) + "\n")
            self.succeed("plot", "many.csv")
            picture = self.read("many.svg")
            self.assertEqual(legend(picture), names)
            self.assertEqual(labels(picture).count("covariances"), panels)
            self.assertIn("many.csv: covariances", labels(picture))
            self.assertEqual(len(set(re.findall(r'translate\(([\d.]+),[^>]*font-size="14.00"', picture))), 1)

    def test_degrees_are_not_in_the_symbols(self):
        self.write("roll.csv", "t,roll_deg,depth_deg\n0,1,2\n1,2,3\n")
        self.succeed("plot", "roll.csv", "--columns", "roll,depth_deg")
        self.assertEqual(legend(self.read("roll.svg")), ["roll", "depth_deg"])

    def test_a_true_anomaly_grows_without_breaks(self):
        self.write("orbit.csv", "t,true_anomaly\n0,0\n6000,6.28\n12000,12.56\n")
        self.succeed("plot", "orbit.csv")
        picture = self.read("orbit.svg")
        path = re.search(r"d='([^']*)'", picture[picture.index("<title>ν</title>"):])[1]
        self.assertEqual(path.count("L"), 3, path)  # one in the legend

    def test_long_symbols_fit_beside_the_panels(self):
        self.write("works.csv", "t,work_time_dependent,omega1\n0,0,1\n1,1,2\n")
        self.succeed("plot", "works.csv")
        start = max(float(x) for x in re.findall(r'translate\(([\d.]+),[^>]*font-size="14.00"', self.read("works.svg")))
        self.assertLess(start + 8*len("work_time_dependent"), 900)

    def test_each_axis_has_two_numbers(self):
        for greatest in range(36, 60, 3):
            self.assertGreaterEqual(self.numbers_of_the_axis(f"t,L1,L2\n0,{-greatest},0\n1,{greatest},1\n"), 2, greatest)

    def test_small_changes_of_large_values(self):
        self.write("far.csv", "t,orbit_radius\n1700000000.1,6878137.01\n1700000000.2,6878137.02\n1700000000.3,6878137.03\n")
        self.succeed("plot", "far.csv")
        drawn = labels(self.read("far.svg"))
        for number in ("1700000000.1", "1700000000.3", "6878137.01", "6878137.02"):
            self.assertIn(number, drawn)
        self.write("still.csv", "t,total\n0,51.02210000000001\n1,51.0221\n")
        self.succeed("plot", "still.csv", "--columns", "total")
        self.assertIn("51", labels(self.read("still.svg")))

    def test_values_that_have_no_picture(self):
        for name, rows, says in (("inf", "0,inf\n1,2", "a value is too large to plot (expected up to 1e100 in size)"),
                                 ("huge", "0,1e300\n1,-1e300", "a value is too large to plot"),
                                 ("once", "0,1\n0,2", "all rows have the same t (expected rows at different times)")):
            self.write(f"{name}.csv", f"t,L1\n{rows}\n")
            self.fail_with(2, "plot", f"{name}.csv", says=(f"{name}.csv: {says}",))
        for name, rows in (("tiny", "0,1e-310\n1,2e-310"), ("large", "0,1e100\n1,-1e100"), ("zero", "0,0\n1,0")):
            self.write(f"{name}.csv", f"t,L1\n{rows}\n")
            self.succeed("plot", f"{name}.csv", "--title", "two\nlines")

    def test_the_path_of_an_axis(self):
        half = 0.5**0.5
        self.write("turn.csv", f"t,q0,q1,q2,q3\n0,1,0,0,0\n1,{half},0,0,{half}\n")
        for axis, least, greatest in (("1", "0", "1"), ("-1", "-1", "0")):
            self.succeed("plot", "turn.csv", "--path", axis)
            picture = self.read("turn.svg")
            self.assertIn("from above", picture)
            self.assertIn(least, labels(picture))
            self.assertIn(greatest, labels(picture))
            self.assertNotIn({"1": "-1", "-1": "1"}[axis], labels(picture))
        self.succeed("run", "box.nml", "--quiet", "--set", "output.columns=energy", "--plot", "path.svg", "--path", "3")
        for wrong in ("4", ""):
            self.fail_with(2, "plot", "turn.csv", "--path", wrong, says=(f"--path '{wrong}' is not a body axis",))
        self.fail_with(2, "run", "box.nml", "--path", "3", says=("need --plot FILE",))

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
        self.assertEqual(sorted(drawn), sorted([f"axis {k}" for k in (1, 2, 3)]*2 + ["controller 1"]*2 + ["B1", "B2", "B3"]))

    def test_attitudes_relative_to_frames_are_drawn(self):
        self.write("seen.csv", "t,frame1_q0,frame1_q1,frame1_q2,frame1_q3,frame1_angle_deg\n0,1,0,0,0,0\n1,0.8,0.6,0,0,73.7\n")
        self.assertEqual(self.succeed("plot", "seen.csv").stderr, "")
        picture = self.read("seen.svg")
        self.assertEqual(legend(picture), [*ATTITUDE, "angle"])
        self.assertIn("angle from frame 1 (°)", picture)
        self.assertIn("attitude from frame 1", picture)

    def test_names_in_quotes_may_hold_commas(self):
        self.write("sheet.csv", '"t","x, seen from above","omega1","omega2",omega3\r\n0,"1",2,3,4\r\n1,"1",3,"3",5\r\n')
        self.succeed("plot", "sheet.csv")
        self.assertEqual(legend(self.read("sheet.svg")), RATES)

    def test_rows_half_a_turn_apart_are_noted(self):
        environment = self.without_drawing()
        for end, rate, noted in (("", 3.0, False), ("", 3.2, True), ("_deg", 170, False), ("_deg", 190, True)):
            with self.subTest(end=end, rate=rate):
                names = ",".join(f"omega{k}{end}" for k in (1, 2, 3))
                self.write("rows.csv", f"t,total,{names}\n0,1,0,0,{rate}\n1,1,0,0,{rate}\n2,1,0,0,{rate}\n")
                said = self.succeed("plot", "rows.csv", "--columns", "total", env=environment).stderr
                self.assertEqual("rows.csv: the body turns by half a revolution or more between rows, such as those after t = 0 s" in said, noted)
                self.assertEqual("expected rows less than" in said, noted)

    def test_each_wheel_and_controller_has_its_colour(self):
        self.write("wheels.csv", "t," + ",".join(f"{name}{k}{end}" for name, end in (("wheel", "_speed"), ("pointing_error", ""))
                                                 for k in range(1, 7)) + "\n" + "".join(f"{t}" + f",{t}" * 12 + "\n" for t in (0, 1)))
        self.succeed("plot", "wheels.csv")
        picture = self.read("wheels.svg")
        for colour in ("d55e00", "009e73", "0b3c5d", "e69f00", "56b4e9", "cc79a7"):
            red, green, blue = (int(colour[i:i + 2], 16) for i in (0, 2, 4))
            self.assertEqual(len(re.findall(rf"<path stroke='rgb\({red:3d}, *{green}, *{blue}\)'(?: stroke-dasharray='[^']*')? *d=", picture)), 2, colour)

    def test_png_under_another_name(self):
        self.succeed("run", "box.nml", "--quiet", "--output", "<box>.csv")
        self.succeed("plot", "<box>.csv", "--output", "a.png")
        with open(self.path("a.png"), "rb") as file:
            self.assertEqual(file.read(8), b"\x89PNG\r\n\x1a\n")

    def test_a_long_history_is_thinned_without_loss_of_extremes(self):
        rows = [f"{i},0,{2 if i == 12345 else 0},0\n" for i in range(13000)]
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
        environment = self.without_drawing()
        self.write("h.csv", "t,L1,L2,L3\n0,1,2,3\n1,1,2,4\n\n \n")
        self.succeed("plot", "h.csv", "--output", "h.svg", env=environment)
        self.write("h.csv", "\ufefft,L1,L2,L3\r\n0,1,2,3\r\n1,1,2,4")
        self.succeed("plot", "h.csv", "--output", "h.svg", env=environment)
        self.write("h.csv", "t,L1,L2,L3\n0,1,2,3\n\n1,1,2,4\n")
        self.fail_with(2, "plot", "h.csv", "--output", "h.svg", says=("h.csv:3:",))

    def test_what_is_no_history_is_refused(self):
        bad = {"no.csv": ("a,b\n1,2\n", "no.csv:1: not a history"), "empty.csv": ("", "empty.csv:1: not a history"),
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
        self.write("escape.csv", "t,omega1,\x1b[31m\n0,1,2\n1,2,3\n")
        self.fail_with(2, "plot", "escape.csv", "--columns", "depth", says=("expected omega1, \\x1B[31m",))
        for command in (("plot", "/dev/stdin", "--output", "a.svg"), ("export", "/dev/stdin", "--gltf", "a.gltf")):
            self.fail_with(2, *command, input="t,L1\n0,1\n1,2\n", says=("/dev/stdin: cannot be read twice (expected a file",))
        self.fail_with(2, "plot", "", says=("the name of the history is blank (expected nutate plot HISTORY.csv)",))
        self.fail_with(2, "plot", self.folder, says=("cannot be read (Is a directory)",))
        self.fail_with(2, "export", ".", "--gltf", "a.gltf", says=(".: cannot be read (Is a directory)",))
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
