"""Wheels: their columns, their events and switches, what the summary says of them, and runs that go on."""
import unittest

from support import WHEEL_COLUMNS, CommandLineTest

SCENE = """&body inertia = 90.0, 100.0, 40.0 /
&wheel axis = 1.0, 2.0, 2.0, inertia = 0.05, torque = 0.2, start = 0.0, stop = 50.0, name = 'spinner' /
&wheel axis = 0.0, 0.0, 1.0, inertia = 0.04, speed = 100.0, friction = 2e-4 /
&initial angular_velocity = 0.02, -0.01, 0.03 /
&integrator time_step = 0.5, end_time = 100.0 /
&output columns = 'quaternion', 'energy', 'wheel1', 'wheel2' /
"""


class Wheels(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("wheels.nml", SCENE)

    def test_columns_have_their_names(self):
        self.succeed("run", "wheels.nml", "--quiet")
        header, rows = self.history("wheels.csv")
        self.assertEqual(header[10:], WHEEL_COLUMNS["wheel1"] + WHEEL_COLUMNS["wheel2"])
        first, last = rows[0], rows[-1]
        self.assertAlmostEqual(first[14], 100.0, delta=1e-12)
        # h1 grows by 0.2 N m until 50 s; the works are those of the account.
        self.assertAlmostEqual(last[11] - first[11], 10.0, delta=1e-12)
        self.assertAlmostEqual(last[12] + last[17], last[8], delta=1e-9)
        self.assertEqual([last[13], last[16]], [0.0, 0.0])
        self.assertLess(last[17], 0.0)
        self.assertLessEqual(max(abs(row[9]) for row in rows), 1e-11)

    def test_the_summary_tells_their_work(self):
        text = self.succeed("run", "wheels.nml").stderr
        for words in ("work of motor 1 'spinner'", "work of friction 1 'spinner'", "work of motor 2", "all components"):
            self.assertIn(words, text)

    def test_check_shows_the_body_with_its_wheels_locked(self):
        text = self.succeed("check", "wheels.nml").stdout
        self.assertIn("90, 100, 40 kg m^2", text)
        self.assertIn("by the work of torques, motors and friction alone", text)

    def test_events_see_them_and_switch_motors(self):
        self.write("event.nml", SCENE + "&event name = 'full', when = 'wheel1_speed', crosses = 120.0, "
                   "direction = 1, "
                   "switch = 'spinner off' /\n")
        self.succeed("run", "event.nml", "--quiet", "--output", "event.csv")
        rows = self.history("event.csv")[1]
        # Coasting, the speed changes by as much as the body's rotation about the axis does.
        self.assertTrue(119.9 < max(row[10] for row in rows) < 120.1)
        self.assertTrue(119.9 < rows[-1][10] < 120.1)
        self.assertLess(rows[-1][11], 6.1)
        self.assertLessEqual(max(abs(row[9]) for row in rows), 1e-11)

    def test_a_motor_switched_on_its_level_is_counted_once(self):
        # Friction, or the body's rotation, takes the speed back from the level as soon as the motor is off.
        lone = SCENE.replace("friction = 2e-4", "torque = 0.2, friction = 2e-3, name = 'spinner'").replace("speed = 100.0,", "")
        for scene in (SCENE, lone.replace("0.02, -0.01, 0.03", "0.0, 0.0, 0.0")):
            wheel = "wheel1" if scene is SCENE else "wheel2"
            self.write("once.nml", scene + f"&event name = 'full', when = '{wheel}_speed', crosses = 50.0, "
                       "switch = 'spinner off' /\n&event name = 'seen', when = '" + wheel + "_speed', crosses = 50.0 /\n")
            for method in ([], ["--set", "integrator.formulation=reduced"], ["--set", "integrator.method=taylor"],
                           ["--set", "integrator.method=dop853"], ["--set", "integrator.time_step=0.1"]):
                self.succeed("run", "once.nml", "--quiet", "--output", "once.csv", *method)
                rows = self.read("once.events.csv").splitlines()[1:]
                self.assertEqual(sorted(row.split(",")[1] for row in rows), ["full", "seen"], (wheel, method, rows))

    def test_motors_go_by_tables_and_keep_limits(self):
        self.write("ramp.csv", "t (s),u (N m)\n0,0\n20,0.4\n20,-0.1\n60,-0.1\n")
        limited = SCENE.replace("torque = 0.2, start = 0.0, stop = 50.0",
                                "table = 'ramp.csv', torque_limit = 0.3, speed_limit = 60.0")
        self.write("limited.nml", limited)
        rows = {}
        for method in ("nielsen_krenk", "taylor", "dop853", "rk4"):
            text = self.succeed("run", "limited.nml", "--set", f"integrator.method={method}").stderr
            self.assertRegex(text, r"upper limit of wheel 1 +once, at t = ")
            rows[method] = self.history("limited.csv")[1]
            self.assertLessEqual(max(row[10] for row in rows[method]), 60.2)
            # From 20 s on the motor brakes.
            self.assertAlmostEqual(rows[method][40][11] - rows[method][-1][11], 4.0, delta=1e-9)
            # rk4 and dop853 run without the projection here.
            self.assertLessEqual(max(abs(row[9]) for row in rows[method]), 1e-11 if method[0] in "nt" else 1e-7)
        for method in ("dop853", "rk4"):
            self.assertAlmostEqual(rows[method][-1][11], rows["taylor"][-1][11], delta=1e-6)
        for method in ([], ["--set", "integrator.method=taylor"]):
            self.succeed("run", "limited.nml", "--quiet", "--output", "whole.csv", *method)
            for steps in ("25", "35", "61"):
                self.fail_with(3, "run", "limited.nml", "--quiet", "--output", "part.csv", "--checkpoint", "a.ck",
                               "--max-steps", steps, *method)
                self.succeed("run", "limited.nml", "--quiet", "--output", "part.csv", "--resume", "a.ck", *method)
                self.assertEqual(self.read("part.csv"), self.read("whole.csv"))
        self.fail_with(2, "cost", "limited.nml", says=("neither limits nor samples",))

    def test_auto_takes_no_closed_solution(self):
        self.write("auto.nml", SCENE.replace("time_step = 0.5", "accuracy = 1e-9"))
        self.assertIn("taylor", self.succeed("check", "auto.nml").stdout)
        self.fail_with(2, "run", "wheels.nml", "--set", "integrator.method=exact", says=("free bodies only",))

    def test_interrupted_runs_go_on(self):
        for method in ([], ["--set", "integrator.formulation=reduced", "--set", "integrator.order=4"],
                       ["--set", "integrator.method=taylor"], ["--set", "integrator.method=dop853"]):
            self.succeed("run", "wheels.nml", "--quiet", "--output", "whole.csv", *method)
            self.fail_with(3, "run", "wheels.nml", "--quiet", "--output", "part.csv", "--checkpoint", "a.ck",
                           "--max-steps", "77", *method)
            self.succeed("run", "wheels.nml", "--quiet", "--output", "part.csv", "--resume", "a.ck", *method)
            self.assertEqual(self.read("part.csv"), self.read("whole.csv"))


if __name__ == "__main__":
    unittest.main()
