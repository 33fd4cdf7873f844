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

    def test_auto_takes_no_closed_solution(self):
        self.write("auto.nml", SCENE.replace("time_step = 0.5", "accuracy = 1e-9"))
        self.assertIn("taylor", self.succeed("check", "auto.nml").stdout)
        self.fail_with(2, "run", "wheels.nml", "--set", "integrator.method=exact", says=("free bodies only",))

    def test_interrupted_runs_go_on(self):
        for method in ([], ["--set", "integrator.linear_solver=reduced", "--set", "integrator.order=4"],
                       ["--set", "integrator.method=taylor"], ["--set", "integrator.method=dop853"]):
            self.succeed("run", "wheels.nml", "--quiet", "--output", "whole.csv", *method)
            self.fail_with(3, "run", "wheels.nml", "--quiet", "--output", "part.csv", "--checkpoint", "a.ck",
                           "--max-steps", "77", *method)
            self.succeed("run", "wheels.nml", "--quiet", "--output", "part.csv", "--resume", "a.ck", *method)
            self.assertEqual(self.read("part.csv"), self.read("whole.csv"))


if __name__ == "__main__":
    unittest.main()
