"""Quantities that columns, events and measurements share: their values against others, and events on them."""
import csv
import math
import unittest

from support import CommandLineTest

SCENE = """&body inertia = 90.0, 100.0, 40.0 /
&orbit semi_major_axis = 8e6, eccentricity = 0.1, inclination = 1.0, raan = 0.5, sun = 0.6, 0.64, 0.48 /
&gravity_gradient /
&initial axis = 1, 1, 1, angle = 0.7, angular_velocity = 0.02, -0.01, 0.03 /
&controller law = 'quaternion', attitude_gain = 0.01, rate_gain = 0.012, target = 0.5, 0.5, 0.5, 0.5 /
&integrator method = 'dop853', local_tolerance = 1e-12, end_time = 400.0 /
&output columns = 'quaternion', 'angular_velocity', 'roll_pitch_yaw', 'orbit', 'angular_speed', 'lvlh_angular_velocity', 'orbit_speed',
   'sun_angle', 'pointing_error1', interval = 4.0 /
"""
MU = 3.986004418e14


def axis3(q):
    """Body axis 3 in space axes."""
    return (2*(q[1]*q[3] + q[0]*q[2]), 2*(q[2]*q[3] - q[0]*q[1]), q[0]**2 - q[1]**2 - q[2]**2 + q[3]**2)


class Quantities(CommandLineTest):
    def rows_of(self, text):
        self.write("q.nml", text)
        self.succeed("run", "q.nml", "--quiet")
        header, rows = self.history("q.csv")
        return [dict(zip(header, row)) for row in rows]

    def test_columns_hold_what_their_names_say(self):
        for row in self.rows_of(SCENE):
            omega = [row[f"omega{i}"] for i in (1, 2, 3)]
            self.assertAlmostEqual(row["angular_speed"], math.hypot(*omega), delta=1e-15)
            self.assertAlmostEqual(row["orbit_speed"], math.sqrt(MU*(2/row["orbit_radius"] - 1/8e6)), delta=1e-8)
            sun = sum(a*b for a, b in zip(axis3([row[f"q{i}"] for i in range(4)]), (0.6, 0.64, 0.48)))
            self.assertAlmostEqual(row["sun_angle"], math.acos(sun), delta=1e-13)
            # The angular momentum of the orbit over r² is the rate of the LVLH frame about its axis -2.
            rate = math.sqrt(MU*8e6*(1 - 0.1**2))/row["orbit_radius"]**2
            away = [a - b for a, b in zip(omega, [row[f"lvlh_omega{i}"] for i in (1, 2, 3)])]
            self.assertAlmostEqual(math.hypot(*away), rate, delta=1e-13)

    def test_events_cross_where_columns_do(self):
        levels = {"angular_speed": 0.025, "lvlh_omega2": 0.0, "orbit_speed": 7780.0, "sun_angle": 1.0, "pointing_error1": 1.0,
                  "orbit_x": 6e6, "lvlh_q2": 0.5}
        text = SCENE.replace("'roll_pitch_yaw'", "'lvlh_attitude'")
        for name, level in levels.items():
            rows = self.rows_of(text + f"&event when = '{name}', crosses = {level!r} /\n")
            values = [row[name] for row in rows]
            crossings = sum((a - level)*(b - level) < 0 for a, b in zip(values, values[1:]))
            events = list(csv.DictReader(self.read("q.events.csv").splitlines()))
            self.assertGreater(crossings, 0, name)
            self.assertEqual(len(events), crossings, name)
            for event in events:
                self.assertAlmostEqual(float(event[name]), level, delta=1e-9*max(abs(level), 1), msg=name)

    def test_events_of_angles_pass_their_poles(self):
        """A motion that starts at a pole, or beside it: angles jump there, and cross their levels as rows do."""
        poles = [("roll", "1.0, 0.0, 0.0, 0.0"), ("yaw", "1.0, 0.0, 0.0, 0.0")]
        poles += [(name, f"1.0, {tilt}, 0.0, 0.0") for name in ("phi", "psi") for tilt in (0.0, 1e-13, 1e-11, 1e-8)]
        for name, q in poles:
            columns = "'roll_pitch_yaw', 'euler', 'quaternion'"
            text = (f"&body inertia = 2, 3, 4 /\n&initial quaternion = {q}, angular_velocity = 0.01, 0.02, 0.03 /\n"
                    f"&orbit semi_major_axis = 7e6 /\n&integrator end_time = 100, time_step = 1 /\n&output columns = {columns} /\n")
            for method in ("nielsen_krenk", "taylor"):
                rows = self.rows_of(text.replace("time_step", f"method = '{method}', time_step")
                                    + f"&event when = '{name}', crosses = 1.5 /\n")[1:]
                values = [row[name] for row in rows]
                crossings = sum(math.floor((a - 1.5)/math.tau) != math.floor((b - 1.5)/math.tau) and abs(a - b) < 3
                                for a, b in zip(values, values[1:]))
                events = [event for event in csv.DictReader(self.read("q.events.csv").splitlines()) if float(event["t"]) > 1]
                self.assertEqual(len(events), crossings, (name, q, method))

    def test_roll_pitch_and_yaw_need_no_orbit(self):
        for frame in ("", "&rotating_frame rate = 0.2, -0.3, 0.5 /\n"):
            text = ("&body inertia = 5.0, 20.0, 17.0 /\n&initial quaternion = 0.8, 0.4, -0.4, 0.2, angular_velocity = 0.4, -0.3, 2.0"
                    + (", rate_from = 'inertial' /\n" if frame else " /\n") + frame +
                    "&integrator local_tolerance = 1e-12, end_time = 5.0 /\n&output columns = 'roll_pitch_yaw', interval = 0.01 /\n")
            for name in ("roll", "pitch", "yaw"):
                rows = self.rows_of(text + f"&event name = 'level', when = '{name}', crosses = 0.3 /\n"
                                    f"&event name = 'turn', when = '{name}', extremum = 'both' /\n")
                values = [row[name] for row in rows]
                steps = [b - a for a, b in zip(values, values[1:])]
                crossings = sum((a - 0.3)*(b - 0.3) < 0 and abs(b - a) < 1 for a, b in zip(values, values[1:]))
                turns = sum(a*b < 0 and abs(a) < 1 and abs(b) < 1 for a, b in zip(steps, steps[1:]))
                with self.subTest(frame=frame, name=name):
                    events = list(csv.DictReader(self.read("q.events.csv").splitlines()))
                    found = [float(event[name]) for event in events if event["event"] == "level"]
                    self.assertGreater(crossings, 1)
                    self.assertEqual(len(found), crossings)
                    self.assertLess(max(abs(value - 0.3) for value in found), 1e-9)
                    self.assertEqual(sum(event["event"] == "turn" for event in events), turns)

    def test_a_sum_has_four_parts(self):
        self.write("sum.nml", SCENE + "&event when = 'omega1', 'omega2', 'omega3', 'angular_speed', weights = 1, 1, 1, -1, crosses = 0 /\n")
        self.succeed("run", "sum.nml", "--quiet")
        self.write("sum.nml", SCENE + "&event when = 5*'omega1', crosses = 0 /\n")
        self.fail_with(2, "run", "sum.nml", says=("sum.nml:9:",))

    def test_an_angle_is_measured_away_from_its_ends(self):
        fit = SCENE.split("&output")[0] + "&free key = 'initial.angular_velocity.1', 'initial.angular_velocity.2' /\n" \
            "&measurement file = 'sun.csv', columns = 'sun_angle', 'angular_speed', sigma = 1e-6, 1e-8 /\n"
        rows = self.rows_of(SCENE)
        self.write("sun.csv", "t,sun_angle,angular_speed\n" + "".join(f"{row['t']!r},{row['sun_angle']!r},{row['angular_speed']!r}\n"
                                                                     for row in rows[:20]))
        self.write("fit.nml", fit.replace("0.02, -0.01, 0.03", "0.021, -0.012, 0.03"))
        page = self.succeed("fit", "fit.nml").stdout
        values = [float(line.split()[1]) for line in page.splitlines() if line.strip().startswith("initial.angular_velocity")]
        self.assertAlmostEqual(values[0], 0.02, delta=1e-7)
        self.assertAlmostEqual(values[1], -0.01, delta=1e-7)
        self.write("sun.csv", "t,sun_angle,angular_speed\n0,1e-3,0.03\n")
        self.fail_with(2, "fit", "fit.nml", says=("sun.csv:2: the angle 'sun_angle' has no derivative at 0 and pi",))


if __name__ == "__main__":
    unittest.main()
