"""Scenes whose answers are known to twenty digits: tops, needles, satellites and wheels with closed solutions."""
import csv
import io
import math
import unittest

from support import ROOT, CommandLineTest

SERIES = "&integrator method = 'taylor', local_tolerance = 1e-15, end_time = {} /\n"
# Box on its unstable axis: K/lambda, and the largest rates; that of the start about axis 3.
QUARTER = 0.9664094834075236
LARGEST = {"omega1": 8.246817568007673, "omega2": 8.246211251235321, "omega3": 10.0}
# Fast top: period of nutation, s, largest inclination and precession in a period, rad.
NUTATION, LOWEST, PRECESSION = 0.2916105281845178, 1.484518485876696, 1.457695092710995
# Needle without damping from 150 degrees: K/omega0, the crossing of 90 degrees, s, and the rate at zero, rad/s.
SWING, FIRST_RIGHT_ANGLE, RATE = 1.163636428084856, 0.7757576187232375, 4.595496697041639
# Circular orbit at 500 km: its period, s, and rate, rad/s.
ORBIT, ORBIT_RATE = 5676.978028525859, 0.001106783446334940580568
# Pendulum of 30 degrees in pitch: a quarter of its period, s, and its rate at zero, rad/s.
PITCH, PITCH_RATE = 1243.612203959228, 0.0006777636748199132


class PrintedRows(CommandLineTest):
    def events(self, scene):
        self.write("scene.nml", scene)
        self.succeed("run", "scene.nml", "--quiet")
        return list(csv.DictReader(io.StringIO(self.read("scene.events.csv"))))

    def relative(self, value, expected, bound=1e-11):
        self.assertLessEqual(abs(float(value) - expected), bound * abs(expected), f"{value} for {expected}")

    def test_box_zeros_and_largest_rates(self):
        rows = self.events("&body inertia = 5.0, 20.0, 17.0 /\n&initial angular_velocity = 0.1, 0.0, 10.0 /\n" +
                           SERIES.format(9.0) + "&output every = 1000 /\n"
                           "&event name = 'flip', when = 'omega3', crosses = 0.0 /\n" +
                           "".join(f"&event name = '{name}', when = '{name}', extremum = 'both' /\n"
                                   for name in LARGEST))
        zeros = [float(row["t"]) for row in rows if row["event"] == "flip"]
        self.assertEqual(len(zeros), 5)
        for i, t in enumerate(zeros):
            self.relative(t, (2 * i + 1) * QUARTER)
        for name, expected in LARGEST.items():
            largest = max(abs(float(row[name])) for row in rows if row["event"] == name)
            self.relative(largest, expected, 1e-12)

    def test_fast_top_nutates(self):
        scene = (ROOT / "scenes" / "fast_top.nml").read_text(encoding="utf-8")
        scene = scene[:scene.index("&integrator")] + SERIES.format(1.0) + \
            "&output columns = 'euler', every = 1000 /\n&event when = 'theta', extremum = 'both' /\n"
        rows = [row for row in self.events(scene) if float(row["t"]) > 0.01]
        self.assertEqual(len(rows), 6)
        phi = [0.0]
        for i, row in enumerate(rows):
            self.relative(row["t"], (i + 1) * NUTATION / 2)
            self.relative(row["theta"], math.pi / 3 if i % 2 else LOWEST)
            if i % 2:
                turn = (float(row["phi"]) - phi[-1]) % (2 * math.pi)
                self.relative(turn, PRECESSION)
                phi.append(float(row["phi"]))

    def test_needle_without_damping(self):
        scene = (ROOT / "scenes" / "compass.nml").read_text(encoding="utf-8")
        scene = scene[:scene.index("&damping")] + \
            "&initial euler = 150.0, 0.0, 0.0, angular_velocity = 0.0, 0.0, 0.0, degrees = .true. /\n" + \
            SERIES.format(9.0) + "&output columns = 'euler', 'angular_velocity', every = 1000 /\n" \
            "&event name = 'zero', when = 'phi', crosses = 0.0 /\n&event name = 'right', when = 'phi', crosses = " \
            "1.5707963267948966 /\n&event name = 'turn', when = 'phi', extremum = 'both' /\n"
        rows = self.events(scene)
        zeros = [row for row in rows if row["event"] == "zero"]
        self.assertEqual(len(zeros), 4)
        for i, row in enumerate(zeros):
            self.relative(row["t"], (2 * i + 1) * SWING)
            self.relative(row["omega3"], -RATE if i % 2 == 0 else RATE)
        self.relative(next(row["t"] for row in rows if row["event"] == "right"), FIRST_RIGHT_ANGLE)
        turns = [row for row in rows if row["event"] == "turn" and float(row["t"]) > 0.1]
        for i, row in enumerate(turns[:2]):
            self.relative(row["t"], 2 * (i + 1) * SWING)
            self.relative(row["phi"], math.radians(-150 if i == 0 else 150))

    def satellite(self, inertia, angles, end_time):
        """A scene of a satellite that starts at rest in the LVLH frame, rotated by angles in rad."""
        return (f"&body inertia = {inertia} /\n&orbit semi_major_axis = 6878137.0 /\n&gravity_gradient /\n"
                f"&initial attitude_from = 'lvlh', rate_from = 'lvlh', roll_pitch_yaw = {angles}, "
                "angular_velocity = 0.0, 0.0, 0.0 /\n" + SERIES.format(repr(end_time)))

    def test_pendulum_in_pitch(self):
        rows = self.events(self.satellite("90.0, 100.0, 40.0", "0.0, 0.5235987755982989, 0.0", 7000.0) +
                           "&output columns = 'lvlh_attitude', 'angular_velocity', every = 1000 /\n"
                           "&event when = 'pitch', crosses = 0.0 /\n")
        self.assertEqual(len(rows), 3)
        for i, row in enumerate(rows):
            self.relative(row["t"], (2 * i + 1) * PITCH)
            self.relative(float(row["omega2"]) + ORBIT_RATE, -PITCH_RATE if i % 2 == 0 else PITCH_RATE, 1e-10)

    def test_wheel_spun_up_on_axis_3(self):
        scene = "&body inertia = 90.0, 100.0, 40.0 /\n&initial angular_velocity = 0.0, 0.0, 0.03 /\n" \
                "&wheel axis = 0.0, 0.0, 1.0, inertia = 0.05, torque = 0.2 /\n" \
                "&output columns = 'euler', 'angular_velocity', 'wheel1' /\n"
        for method in ("method = 'taylor', time_step = 5.0", "order = 8, time_step = 0.5",
                       "method = 'dop853', time_step = 1.0"):
            self.write("spin.nml", scene + f"&integrator {method}, end_time = 50.0 /\n")
            self.succeed("run", "spin.nml", "--quiet")
            header, rows = self.history("spin.csv")
            last = dict(zip(header, rows[-1]))
            self.relative(last["omega3"], -0.22031289111389236)
            self.relative(last["wheel1_speed"], 200.25031289111389)
            self.relative(last["wheel1_motor_work"], 1001.2515644555694)
            turn = (last["phi"] + last["psi"] + 4.757822277847309 + math.pi) % (2 * math.pi) - math.pi
            self.assertAlmostEqual(turn, 0.0, delta=1e-10)


if __name__ == "__main__":
    unittest.main()
