"""Events of scenes: their file, their lines in summary and check, and how they end a run or switch effects."""
import csv
import io
import math
import os
import unittest

from support import CommandLineTest

BOX = """&body inertia = 5.0, 20.0, 17.0 /
&initial angular_velocity = 0.1, 0.0, 10.0 /
&integrator method = 'taylor', time_step = 0.01, end_time = 10.0 /
&output every = 100 /
"""
SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes")
# (2j+1) K/lambda of the box.
QUARTER = 0.9664094834075236
BANG = """&body inertia = 1.0, 1.0, 1.0 /
&initial euler = 0.0, 1.5707963267948966, 0.2, angular_velocity = 0.0, 0.0, -0.01 /
&integrator order = 4, time_step = 0.05, end_time = 40.0 /
&output columns = 'euler', 'angular_velocity', 'energy' /
&torque name = 'minus', body = 0.0, 0.0, -0.02 /
&torque name = 'plus', body = 0.0, 0.0, 0.02, on = .false. /
""" + "".join(
    f"&event name = '{name}', when = 'psi', 'omega3', weights = 1.0, 2.0, crosses = {level}, direction = {way}, "
    f"switch = '{name}' /\n"
    for name, level, way in (("minus on", 1e-2, 1), ("minus off", 5e-3, -1), ("plus on", -1e-2, -1), ("plus off", -5e-3, 1)))

# An extremum that toggles a sphere, which changes no rate of the field at once: a step to the event ends beside it.
TOGGLED = """&body inertia_tensor = 2.169, 1.914041929566479, 1.6107229980785749, -0.226, -0.15118674071964844, 0.2436 /
&inner_sphere name = 'ball', inertia = 0.13, damping = 0.0741, angular_velocity = 1.56, -2.1, 1.37, on = .false. /
&controller law = 'quaternion', target = -0.6193024591672625, 0.0952318149631968, 0.0255, -0.7789385645719317,
   target_from = 'lvlh', inertia = 1.7, 1.63, 1.25, 0.092606, -0.055563374065211585, 0.037,
   attitude_gain = 0.8866615800884861, rate_gain = 1, sample = 0.24755492921908429 /
&controller law = 'bdot', gain = 1.2312, field = 0.53, 0.89, 0.79558, sample = 0.26, limit = 1.5 /
&gravity_gradient /
&initial roll_pitch_yaw = -52, 23, 89.3, angular_velocity = 22, 17.02, 84, degrees = .true. /
&orbit mu = 2.82e+20, inclination = 0.065, raan = 5.2, argument_of_periapsis = 5.1, mean_anomaly = -2.1,
   semi_major_axis = 1.1873e+07, frame = 'lvlh' /
&event name = 'least', when = 'B1', extremum = 'minimum', switch = 'ball toggle' /
&integrator local_tolerance = 1e-11, end_time = 1.9 /
&output columns = 'magnetic_field', every = 1000 /
"""


class Events(CommandLineTest):
    def rows(self, name):
        return list(csv.DictReader(io.StringIO(self.read(name))))

    def test_an_extremum_switches_once(self):
        self.write("toggled.nml", TOGGLED)
        for method in ("rk8", "dop853", "rk4", "taylor"):
            with self.subTest(method=method):
                self.succeed("run", "toggled.nml", "--set", f"integrator.method='{method}'")
                times = [float(row["t"]) for row in self.rows("toggled.events.csv")]
                self.assertTrue(all(after - before > 1e-3 for before, after in zip(times, times[1:])), times)
                self.assertGreater(len(times), 0)

    def test_the_step_that_an_event_shortens_is_counted(self):
        """Nine steps of 0.01 s and one to the event, which is not on their grid; or none of 0.2 s. A run without events shortens none."""
        self.write("box.nml", BOX + "&event name = 'turned', when = 'q0', crosses = 0.9, stop = .true. /\n")
        extra = "shortened steps     1 more, which ends at an event"
        for step, steps in ((0.01, 9), (0.2, 0)):
            text = self.succeed("run", "box.nml", "--set", f"integrator.time_step={step}", "--set", "integrator.method=rk4").stderr
            self.assertIn(f"steps               {steps} of {step} s", text)
            self.assertIn(extra, text)
        self.write("box.nml", BOX)
        self.assertNotIn("shortened steps", self.succeed("run", "box.nml").stderr)

    def test_flips_of_the_box(self):
        self.write("box.nml", BOX + "&event name = 'flip', when = 'omega3', crosses = 0.0 /\n")
        done = self.succeed("run", "box.nml")
        rows = self.rows("box.events.csv")
        self.assertEqual(len(rows), 5)
        for i, row in enumerate(rows):
            self.assertEqual((row["event"], row["number"]), ("flip", str(i + 1)))
            self.assertAlmostEqual(float(row["t"]), (2 * i + 1) * QUARTER, delta=1e-11)
            self.assertAlmostEqual(float(row["omega3"]), 0.0, delta=1e-12)
        self.assertEqual(list(rows[0])[:4], ["t", "event", "number", "q0"])
        self.assertIn("event 'flip'        5 times", done.stderr)
        self.assertIn("5 rows in box.events.csv", done.stderr)

    def test_the_history_is_the_same(self):
        self.write("box.nml", BOX)
        self.succeed("run", "box.nml")
        plain = self.read("box.csv")
        self.write("box.nml", BOX + "&event when = 'omega3', crosses = 0.0 /\n&event when = 'psi', extremum = 'both' /\n")
        self.succeed("run", "box.nml")
        self.assertEqual(plain, self.read("box.csv"))

    def test_rows_have_the_units_and_the_digits_of_the_history(self):
        self.write("box.nml", BOX.replace("&output", "&output degrees = .true., precision = 6, columns = 'euler', "
                   "'angular_velocity'") + "&event name = 'flip', when = 'omega3', crosses = 0.0, count = 2 /\n")
        self.succeed("run", "box.nml")
        first, last = self.rows("box.events.csv")
        self.assertEqual(list(first), ["t", "event", "number", "omega1_deg", "omega2_deg", "omega3_deg", "phi_deg",
                                       "theta_deg", "psi_deg"])
        self.assertEqual(first["t"], "0.966409")
        self.assertEqual(first["omega1_deg"], "472.508")
        rows = self.rows("box.csv")
        for name in ("t", "phi_deg", "theta_deg", "psi_deg", "omega1_deg", "omega2_deg"):
            self.assertEqual(last[name], rows[-1][name])

    def test_scenes_of_events(self):
        self.succeed("run", os.path.join(SCENES, "intermediate_axis.nml"), "--output", "flips.csv")
        flips = [float(row["t"]) for row in self.rows("flips.events.csv") if row["event"] == "flip"]
        self.assertEqual(len(flips), 10)
        self.assertAlmostEqual(flips[0], QUARTER, delta=1e-11)
        done = self.succeed("run", os.path.join(SCENES, "bang_bang.nml"), "--output", "cycle.csv")
        switches = self.rows("cycle.events.csv")
        self.assertEqual(len(switches), 31)
        # The cycle: a coast to the other side, a pulse, and back.
        self.assertEqual([row["event"] for row in switches[-4:]], ["minus on", "minus off", "plus on", "plus off"])
        self.assertLess(abs(float(self.rows("cycle.csv")[-1]["energy_residual"])), 1e-14)
        self.assertIn("31 rows", done.stderr)

    def test_stop_and_count(self):
        for key, end in (("stop = .true.", 1), ("count = 3", 5)):
            self.write("box.nml", BOX + f"&event when = 'omega3', crosses = 0.0, {key} /\n")
            done = self.succeed("run", "box.nml")
            self.assertAlmostEqual(float(self.rows("box.csv")[-1]["t"]), end * QUARTER, delta=1e-11)
            self.assertIn("by an event", done.stderr)

    def test_standard_output_has_events_only_where_a_file_is_named(self):
        self.write("box.nml", BOX + "&event when = 'omega3', crosses = 0.0 /\n")
        self.succeed("run", "box.nml", "--output", "-")
        self.assertNotIn("box.events.csv", self.names())
        self.succeed("run", "box.nml", "--output", "-", "--set", "output.events='when.csv'")
        self.assertEqual(len(self.rows("when.csv")), 5)

    def test_bang_bang(self):
        self.write("bang.nml", BANG)
        done = self.succeed("run", "bang.nml")
        rows = self.rows("bang.events.csv")
        self.assertEqual(len(rows), 19)
        self.assertAlmostEqual(float(rows[0]["t"]), 2.373397172404482, delta=1e-9)
        self.assertAlmostEqual(float(self.rows("bang.csv")[-1]["psi"]), -0.0039300749765, delta=1e-9)
        self.assertIn("work of torque 'plus'", done.stderr)
        for row in self.rows("bang.csv") + rows:
            self.assertLess(abs(float(row["energy_residual"])), 1e-17)

    def test_a_potential_that_is_switched(self):
        self.write("swing.nml", """&body inertia = 1.0, 1.0, 1.0 /
&initial angular_velocity = 0.0, 0.0, 3.5 /
&integrator time_step = 0.02, end_time = 10.0 /
&dipole name = 'field', moment = 5.0, 0.0, 0.0, field = 1.0, 0.0, 0.0 /
&event when = 'q3', crosses = 0.4, switch = 'field toggle' /
""")
        done = self.succeed("run", "swing.nml")
        self.assertIn("work of switches", done.stderr)
        for row in self.rows("swing.csv"):
            self.assertLess(abs(float(row["energy_residual"])), 1e-13)

    def test_a_switch_of_a_potential_is_booked_as_work(self):
        self.write("needle.nml", """&body inertia = 1.0, 1.0, 1.0 /
&initial angular_velocity = 0.0, 0.0, 3.5 /
&integrator time_step = 0.1, end_time = 1.0 /
&output columns = 'energy', 'time_dependent_work' /
&dipole name = 'field', moment = 5.0, 0.0, 0.0, field = 1.0, 0.0, 0.0 /
&event when = 'q3', crosses = 0.4, switch = 'field off' /
""")
        done = self.succeed("run", "needle.nml")
        event, = self.rows("needle.events.csv")
        rows = self.rows("needle.csv")
        # The potential was -3.4 J: cos 2 asin 0.4 of 5.
        self.assertAlmostEqual(float(event["potential"]), -5 * (1 - 2 * 0.4**2), delta=1e-10)
        self.assertEqual(float(event["work"]), 0.0)
        for row in rows:
            after = float(row["t"]) > float(event["t"])
            self.assertAlmostEqual(float(row["work"]), 3.4 if after else 0.0, delta=1e-10)
            self.assertEqual(float(row["time_dependent_work"]), 0.0)
            self.assertLess(abs(float(row["energy_residual"])), 1e-13)
        self.assertIn("work of switches    3.4 J", done.stderr)

    def test_every_turn_of_a_fast_top(self):
        """Steps of the series turn the top by fifteen radians."""
        with open(os.path.join(SCENES, "fast_top.nml"), encoding="utf-8") as file:
            text = file.read()
        self.write("top.nml", text + "&event name = 'turn', when = 'psi', crosses = 0.1 /\n"
                   "&event name = 'two', when = 'psi', crosses = 0.1, modulo = 12.566370614359172, direction = 1 /\n"
                   "&event name = 'radian', when = 'psi', crosses = 0.0, modulo = 1.0 /\n")
        self.succeed("run", "top.nml", "--set", "integrator.method='taylor'", "--set", "integrator.accuracy=1e-6")
        events = self.rows("top.events.csv")
        # By the shipped steps, a fifth of a radian each, the history follows psi, in every row.
        self.succeed("run", "top.nml", "--output", "fine.csv")
        psi = [float(row["psi"]) for row in self.rows("fine.csv")]
        self.assertTrue(all(abs(b - a) < 0.3 for a, b in zip(psi, psi[1:])))
        for name, level, period in (("turn", 0.1, 2 * math.pi), ("two", 0.1, 4 * math.pi), ("radian", 0.0, 1.0)):
            due = math.floor((psi[-1] - level) / period) - math.floor((psi[0] - level) / period)
            self.assertEqual(sum(row["event"] == name for row in events), due, name)
        for row in events:
            if row["event"] == "turn":
                self.assertAlmostEqual(math.remainder(float(row["psi"]) - 0.1, 2 * math.pi), 0.0, delta=1e-6)

    def test_every_multiple_of_a_modulus(self):
        self.write("box.nml", BOX.replace("time_step = 0.01, end_time = 10.0", "time_step = 0.1, end_time = 20.0")
                   + "&event name = 'odd', when = 'omega3', crosses = 0.5, modulo = 2 /\n")
        self.succeed("run", "box.nml")
        events = self.rows("box.events.csv")
        # Omega3 goes from one extreme to the other ten times: each time past -9.5, -7.5, ..., 8.5.
        self.assertEqual(len(events), 100)
        for row in events:
            self.assertAlmostEqual(math.remainder(float(row["omega3"]) - 0.5, 2.0), 0.0, delta=1e-9)

    def test_a_jump_of_the_torque_makes_an_extremum(self):
        self.write("kick.nml", """&body inertia = 1, 1, 1 /
&torque body = 1, 0, 0, stop = 1.3 /
&torque body = -1, 0, 0, start = 1.3 /
&initial angular_velocity = 0, 0, 0 /
&integrator time_step = 0.4, end_time = 4 /
&event name = 'speed', when = 'omega1', extremum = 'maximum' /
&event name = 'energy', when = 'kinetic', extremum = 'both' /
""")
        self.succeed("run", "kick.nml")
        found = [(row["event"], round(float(row["t"]), 12)) for row in self.rows("kick.events.csv")]
        self.assertEqual(found, [("speed", 1.3), ("energy", 1.3), ("energy", 2.6)])

    def test_a_level_at_which_a_limit_holds_is_reached_once_a_time(self):
        """The motor is switched off at the speed limit, where the speed turns back."""
        scene = ("&body inertia = 90, 100, 40 /\n&initial angular_velocity = 0, 0, 0 /\n"
                 "&wheel axis = 0, 0, 1, inertia = 0.05, torque = 0.05, friction = 5e-4, speed_limit = 6 /\n"
                 "&event name = 'top', when = 'wheel1_speed', crosses = 6{} /\n&output columns = 'wheel1' /\n")
        for steps in ("time_step = 0.1", "local_tolerance = 1e-9", "time_step = 0.37, order = 6", "method = 'dop853', local_tolerance = 1e-9"):
            for direction in ("", ", direction = 1"):
                with self.subTest(steps=steps, direction=direction):
                    self.write("wheel.nml", scene.format(direction) + f"&integrator {steps}, end_time = 20 /\n")
                    summary = self.succeed("run", "wheel.nml").stderr
                    self.assertRegex(summary, r"event 'top' +13 times")
                    self.assertRegex(summary, r"upper limit of wheel 1 +13 times")

    def test_switches_without_end(self):
        self.write("chatter.nml", """&body inertia = 1.0, 1.0, 1.0 /
&initial angular_velocity = 0.0, 0.0, 1.0 /
&integrator time_step = 0.1, end_time = 2.0 /
&torque name = 'push', on = .false., body = 0.0, 0.0, 2.0 /
&torque body = 0.0, 0.0, -1.0 /
&event name = 'chatter', when = 'omega3', crosses = 0.5, switch = 'push toggle' /
""")
        self.fail_with(3, "run", "chatter.nml", says=["more than 1000 switches in one step", "chatter"])

    def test_check_says_what_is_looked_for(self):
        self.write("bang.nml", BANG)
        done = self.succeed("check", "bang.nml")
        self.assertIn("psi + 2 omega3 crosses 0.01, growing; switches 'minus' on", done.stdout)
        self.assertIn("off at the start", done.stdout)

    def test_cost_refuses_switches(self):
        self.write("bang.nml", BANG)
        self.fail_with(2, "cost", "bang.nml", says=["switch"])


if __name__ == "__main__":
    unittest.main()
