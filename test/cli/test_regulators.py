"""Regulators: samples that are held by every method, switches, refusals, and runs that go on."""
import unittest

from support import CommandLineTest

BODY = """&body inertia = 90.0, 100.0, 40.0 /
&initial angular_velocity = 0.02, -0.01, 0.03 /
&integrator time_step = 0.4, end_time = 120.0 /
&output columns = 'quaternion', 'angular_velocity', 'energy', 'angular_momentum_space' /
"""
WHEELS = "".join(f"&wheel axis = {axis}, inertia = 0.05, torque_limit = 0.3, speed_limit = 90.0 /\n"
                 for axis in ("1, 1, 1", "-1, 1, 1", "1, -1, 1", "1, 1, -1"))
LAW = "&regulator law = 'quaternion', attitude_gain = 0.01, rate_gain = 0.12, target = 0.5, 0.5, 0.5, 0.5"
METHODS = ("nielsen_krenk", "rk4", "rk8", "dop853", "taylor")


class Regulators(CommandLineTest):
    def test_every_method_holds_the_samples_of_wheels(self):
        self.write("wheels.nml", WHEELS + LAW + ", by = 'wheels', sample = 0.5, name = 'law' /\n" + BODY)
        ends = {}
        for method in METHODS:
            self.succeed("run", "wheels.nml", "--quiet", "--set", f"integrator.method={method}")
            rows = self.history("wheels.csv")[1]
            ends[method] = rows[-1]
            # Momentum and account, without the projection but for nielsen_krenk and taylor.
            tolerance = 1e-12 if method in ("nielsen_krenk", "taylor") else 1e-6
            self.assertLessEqual(max(abs(row[15]) for row in rows), 1e3 * tolerance)
            for k in (8, 9, 10):
                self.assertAlmostEqual(rows[-1][k], rows[0][k], delta=tolerance)
        for method in METHODS:
            for k in range(1, 8):
                self.assertAlmostEqual(ends[method][k], ends["taylor"][k], delta=1e-3 if method == "nielsen_krenk" else 1e-6)
        # On its way to the target.
        self.assertGreater(sum(ends["taylor"][1:5]) / 2, 0.9)

    def test_what_is_switched_off_holds_nothing(self):
        self.write("off.nml", LAW + ", sample = 0.5, name = 'law' /\n" + BODY +
                   "&event when = 'q3', crosses = 0.3, direction = 1, switch = 'law off' /\n")
        self.succeed("run", "off.nml", "--quiet")
        self.assertEqual(len(self.read("off.events.csv").splitlines()), 2)
        rows = self.history("off.csv")[1]
        self.assertNotEqual(rows[10][8], rows[0][8])
        self.assertAlmostEqual(rows[-1][8], rows[-20][8], delta=1e-13)

    def test_interrupted_runs_go_on(self):
        for kind, by in (("wheels", ", by = 'wheels'"), ("magnets", ", by = 'magnets', field = 0.3, -0.2, 0.4"), ("torque", "")):
            self.write(f"{kind}.nml", WHEELS + LAW + by + ", sample = 0.7 /\n" + BODY)
            for method in (["nielsen_krenk"], ["taylor"], ["dop853"]):
                options = ["--set", f"integrator.method={method[0]}"]
                self.succeed("run", f"{kind}.nml", "--quiet", "--output", "whole.csv", *options)
                for steps in ("50", "51", "52", "53"):
                    self.fail_with(3, "run", f"{kind}.nml", "--quiet", "--output", "part.csv", "--checkpoint", "a.ck",
                                   "--max-steps", steps, *options)
                    self.succeed("run", f"{kind}.nml", "--quiet", "--output", "part.csv", "--resume", "a.ck", *options)
                    self.assertEqual(self.read("part.csv"), self.read("whole.csv"))

    def test_laws_at_all_times_keep_their_limits(self):
        # Springy, so that what it asks for grows from the start on.
        law = "&regulator law = 'quaternion', attitude_gain = 0.1, rate_gain = 0.12"
        wheels = WHEELS.replace("torque_limit = 0.3, speed_limit = 90.0", "torque_limit = 0.15, speed_limit = 12.0")
        columns = BODY.replace("'energy', ", "'energy', 'wheel1', ")
        for kind, scene, said in (("torque", law + ", limit = 0.3 /\n" + BODY, "limit of torque"),
                                  ("magnets", law + ", by = 'magnets', field = 0.3, -0.2, 0.4, limit = 0.5 /\n" + BODY,
                                   "limit of moment"),
                                  ("wheels", wheels + law + ", by = 'wheels' /\n" + columns, "limit of motor")):
            self.write(f"{kind}.nml", scene)
            for method in ("rk4", "rk8", "dop853") + (() if kind == "wheels" else ("nielsen_krenk",)):
                options = ["--set", f"integrator.method={method}"]
                text = self.succeed("run", f"{kind}.nml", "--output", "whole.csv", *options).stderr
                self.assertIn(said, text)
                self.fail_with(3, "run", f"{kind}.nml", "--quiet", "--output", "part.csv", "--checkpoint", "a.ck",
                               "--max-steps", "37", *options)
                self.succeed("run", f"{kind}.nml", "--quiet", "--output", "part.csv", "--resume", "a.ck", *options)
                self.assertEqual(self.read("part.csv"), self.read("whole.csv"))
        header, rows = self.history("whole.csv")
        speed = next(k for k, name in enumerate(header) if name.startswith("wheel1_speed"))
        self.assertAlmostEqual(max(abs(row[speed]) for row in rows), 12.0, delta=0.5)

    def test_what_does_not_go_is_said(self):
        self.write("all_times.nml", LAW + " /\n" + BODY)
        self.fail_with(2, "run", "all_times.nml", "--set", "integrator.method=taylor", says=("expected sample",))
        self.assertIn("dop853", self.succeed("check", "all_times.nml", "--set", "integrator.accuracy=1e-6").stdout)
        self.write("sampled.nml", LAW + ", sample = 0.5 /\n" + BODY)
        self.fail_with(2, "cost", "sampled.nml", says=("no sample and no limits in &regulator",))
        free = WHEELS.replace(", torque_limit = 0.3, speed_limit = 90.0", "")
        self.write("by_wheels.nml", free + LAW + ", by = 'wheels' /\n" + BODY)
        self.fail_with(2, "run", "by_wheels.nml", says=("expected sample", "dop853"))
        self.succeed("run", "by_wheels.nml", "--quiet", "--set", "integrator.method=dop853")


if __name__ == "__main__":
    unittest.main()
