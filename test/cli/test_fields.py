"""The field of the Earth, forces at points of the body and the shadow of the Earth: columns, events, restarts, check and summary."""
import math
import unittest

from support import SUN_COLUMNS, CommandLineTest, in_turn

BODY = "&body inertia = 0.09, 0.1, 0.04 /\n&initial angular_velocity = 4e-3, -3e-3, 5e-3 /\n"
SHADE = BODY + """&orbit semi_major_axis = 7e6, sun = 3, 0, 0 /
&earth_field moment = 0.06, -0.09, 0.12, epoch_angle = 40, degrees = .true. /
&force name = 'light', body_point = 0.0, 0.1, 0.02, force = -1e-5, 0, 0, axes = 'inertial' /
&integrator order = 4, time_step = 5, end_time = 12000 /
&event name = 'dark', when = 'shadow_depth', crosses = 0, direction = 1, switch = 'light off' /
&event name = 'bright', when = 'shadow_depth', crosses = 0, direction = -1, switch = 'light on' /
&output columns = 'quaternion', 'energy', 'time_dependent_work', 'eclipse', every = 10 /
"""
MOVING = BODY + """&orbit semi_major_axis = 1e7, eccentricity = 0.3, inclination = 60, degrees = .true. /
&earth_field moment = 0.06, -0.09, 0.12 /
&force body_point = 0.0, 0.1, 0.02, force = -1e-5, 2e-5, 0, axes = 'lvlh' /
&force body_point = 0.0, 0.1, 0.02, force = 0, 2e-5, 1e-5, axes = 'lvlh', start = 1000, stop = 2500 /
&force body_point = 0.1, 0.0, 0.0, force = 0, 2e-6, 0, axes = 'body', stop = 1000 /
&controller law = 'bdot', gain = 1e4, sample = 20, start = 500 /
&integrator time_step = 5, end_time = 4000 /
&output columns = 'quaternion', 'energy', 'time_dependent_work', every = 5 /
"""
# B-dot brings this satellite to rest relative to the field, which turns along the orbit.
BDOT = """&body inertia = 0.12, 0.1, 0.04 /
&initial angular_velocity = 3*0.0, attitude_from = 'lvlh', rate_from = 'inertial' /
&orbit altitude = 500e3, inclination = 97.4, raan = 30, degrees = .true. /
&earth_field /
&gravity_gradient /
&controller name = 'law', law = 'bdot', gain = 1e5, sample = 1, limit = 0.2 /
&integrator local_tolerance = 1e-9, end_time = 20000 /
&output columns = 'angular_velocity', 'magnetic_field', 'controller1', interval = 1 /
"""
FRAMES = (["--set", "orbit.frame=lvlh"], ["--set", "orbit.frame=inertial"], [])
METHODS = (["integrator.order=2"], ["integrator.order=8", "integrator.formulation=reduced"], ["integrator.method=taylor"],
           ["integrator.method=dop853", "integrator.conserve=.true."], ["integrator.method=rk8"])


class Fields(CommandLineTest):
    def test_the_shadow_switches_the_light(self):
        self.write("shade.nml", SHADE)
        done = self.succeed("run", "shade.nml")
        self.assertIn("by potentials switched on and off", done.stderr)
        header, rows = self.history("shade.csv")
        self.assertEqual(header[-3:], SUN_COLUMNS["eclipse"] + ["time_dependent_work"])
        # A circle whose plane holds the sun is dark while the place is behind a disk of the Earth's radius.
        rate, half = math.sqrt(3.986004418e14 / 7e6**3), math.asin(6378137 / 7e6)
        expected = [(math.pi + sign * half + 2 * math.pi * k) / rate for k in (0, 1) for sign in (-1, 1)]
        with open(self.path("shade.events.csv"), encoding="utf-8") as file:
            events = [line.split(",") for line in file.read().splitlines()[1:]]
        self.assertEqual([event[1] for event in events], ["dark", "bright"] * 2)
        for event, time in zip(events, expected):
            self.assertAlmostEqual(float(event[0]), time, delta=1e-10)
        for row in rows:
            dark = expected[0] < row[0] < expected[1] or expected[2] < row[0] < expected[3]
            self.assertEqual(row[-3], 1.0 if dark else 0.0)
            self.assertEqual(row[-2] > 0, dark)
            self.assertLess(abs(row[header.index("energy_residual")]), 1e-19)
        self.succeed("run", "shade.nml", "--quiet", "--set", "orbit.shadow_radius=6e6")
        with open(self.path("shade.events.csv"), encoding="utf-8") as file:
            first = float(file.read().splitlines()[1].split(",")[0])
        self.assertAlmostEqual(first, (math.pi - math.asin(6 / 7)) / rate, delta=1e-10)

    def test_the_account_closes_with_every_method(self):
        self.write("moving.nml", MOVING)
        last = []
        for settings in METHODS:
            done = self.succeed("run", "moving.nml", *(word for setting in settings for word in ("--set", setting)))
            self.assertIn("work of time-dependent potentials", done.stderr)
            header, rows = self.history("moving.csv")
            for row in rows:
                self.assertLess(abs(row[header.index("energy_residual")]), 1e-19)
            last.append(rows[-1])
        for row in last[1:]:
            for a, b in zip(row[1:5], last[1][1:5]):
                self.assertAlmostEqual(a, b, delta=1e-6)
            self.assertAlmostEqual(row[-1], last[1][-1], delta=1e-11)
        self.assertGreater(abs(last[1][-1]), 1e-7)
        text = self.succeed("check", "moving.nml").stdout
        self.assertIn("coefficients = IGRF-14 of 2025 (default)", text)
        self.assertIn("changes by the work of torques and time-dependent potentials alone", text)
        self.assertIn("axes = lvlh; start = 1000; stop = 2500", text)
        self.fail_with(2, "run", "moving.nml", "--set", "integrator.method=exact", says=("free bodies only",))

    def test_runs_go_on(self):
        for name, scene in (("shade", SHADE), ("moving", MOVING)):
            self.write(name + ".nml", scene)
            for method in ("nielsen_krenk", "taylor", "dop853", "rk8"):
                order = ["--unset", "integrator.order"] if name == "shade" else []
                arguments = [name + ".nml", "--quiet", "--set", f"integrator.method={method}", *order]
                self.succeed("run", *arguments, "--output", "whole.csv")
                self.fail_with(3, "run", *arguments, "--output", "part.csv", "--checkpoint", "p.ck", "--max-steps", "401")
                self.succeed("run", *arguments, "--output", "part.csv", "--resume", "p.ck")
                self.assertEqual(self.read("whole.csv"), self.read("part.csv"))

    def test_bdot_is_the_same_in_every_frame(self):
        # tools/docs/references/bdot.py: fourth-order steps in inertial axes, with the field differentiated numerically.
        self.write("bdot.nml", BDOT)
        for turn, (settings, expected) in enumerate((([], 1.93403449e-3), (["--unset", "controller.sample"], 1.94217100e-3))):
            for number, frame in enumerate(FRAMES):
                if not in_turn(turn + number):
                    continue
                self.succeed("run", "bdot.nml", "--quiet", *settings, *frame, "--set", "output.interval=20000")
                rate = math.hypot(*self.history("bdot.csv")[1][-1][1:4])
                self.assertAlmostEqual(rate, expected, delta=2e-9)

    def test_bdot_commands_the_difference_of_two_samples(self):
        self.write("bdot.nml", BDOT + "&event when = 'omega2', crosses = 0.02, direction = -1, switch = 'law off' /\n"
                   "&event when = 'omega2', crosses = 0.006, direction = -1, switch = 'law on' /\n")
        fast = ["--quiet", "--set", "initial.angular_velocity=2e-2,3e-2,1e-2", "--set", "integrator.end_time=80"]
        for method in ("nielsen_krenk", "rk8", "dop853", "taylor"):
            for frame in FRAMES[:2]:
                self.succeed("run", "bdot.nml", *fast, *frame, "--set", f"integrator.method={method}")
                header, rows = self.history("bdot.csv")
                field, moment = header.index("B1"), header.index("controller1_commanded1")
                with open(self.path("bdot.events.csv"), encoding="utf-8") as file:
                    switches = [line.split(",") for line in file.read().splitlines()]
                off, on = (float(switch[0]) for switch in switches[1:])
                self.assertTrue(20 < off < off + 20 < on < 70)
                first = switches[0].index("B1")
                samples = [(row[0], row[field:field + 3]) for row in rows]
                samples = [sample for sample in samples if sample[0] < off] + \
                    [(on, [float(number) for number in switches[2][first:first + 3]])] + [sample for sample in samples if sample[0] > on]
                expected = {time: [0.0] * 3 for time in range(81)}
                for before, now in zip(samples, samples[1:]):
                    # The row at a sample shows what was held until then.
                    if now[0] != on and not now[0] < off < now[0] + 1:
                        expected[now[0] + 1] = [-1e5 * (b - a) / (now[0] - before[0]) for a, b in zip(before[1], now[1])]
                for row in rows:
                    for i in range(3):
                        self.assertAlmostEqual(row[moment + i], expected[row[0]][i], delta=1e-10)

    def test_bdot_goes_on_from_a_checkpoint(self):
        self.write("bdot.nml", BDOT.replace("interval = 1", "every = 1"))
        arguments = ["bdot.nml", "--quiet", "--set", "integrator.end_time=40", "--set", "initial.angular_velocity=2e-2,3e-2,1e-2"]
        self.succeed("run", *arguments, "--output", "whole.csv")
        for steps in range(1, 12):
            self.fail_with(3, "run", *arguments, "--output", "part.csv", "--checkpoint", "p.ck", "--max-steps", str(steps))
            self.succeed("run", *arguments, "--output", "part.csv", "--resume", "p.ck")
            self.assertEqual(self.read("whole.csv"), self.read("part.csv"))

    def test_a_force_in_the_body_is_a_torque(self):
        scene = BODY + "&integrator time_step = 1, end_time = 100 /\n"
        self.write("force.nml", scene + "&force body_point = 0.5, 0, 0.25, force = 1e-4, 2e-4, 0, axes = 'body', stop = 50.5 /\n")
        self.write("torque.nml", scene + "&torque body = -5e-5, 2.5e-5, 1e-4, stop = 50.5 /\n")
        for name in ("force", "torque"):
            self.succeed("run", name + ".nml", "--quiet")
        self.assertEqual(self.read("force.csv"), self.read("torque.csv"))

    def test_a_force_in_the_axes_of_the_scene_is_a_weight(self):
        for frame in ("lvlh", "inertial"):
            with self.subTest(frame=frame):
                self.check_weight(frame)

    def check_weight(self, frame):
        """That a force in space axes of a kind is a weight, and the same by the name of the axes."""
        scene = BODY + f"&integrator time_step = 1, end_time = 100, order = 4 /\n&orbit altitude = 400e3, frame = '{frame}' /\n"
        for axes in ("space", frame):
            self.write(axes + ".nml", scene + f"&force body_point = 0.5, 0, 0.25, force = 1e-4, 2e-4, 0, axes = '{axes}' /\n")
        self.write("weight.nml", scene.replace("0.04 /", "0.04, mass = 2, center_of_mass = 0.5, 0, 0.25, check_triangle = .false. /")
                   + "&gravity acceleration = 5e-5, 1e-4, 0 /\n")
        for name in ("space", frame, "weight"):
            self.succeed("run", name + ".nml", "--quiet")
        self.assertEqual(self.read("space.csv"), self.read("weight.csv"))
        self.assertEqual(self.read("space.csv"), self.read(frame + ".csv"))


if __name__ == "__main__":
    unittest.main()
