"""Controllers: samples that are held by every method, switches, refusals, and runs that go on."""
import unittest

from support import CommandLineTest, in_turn

BODY = """&body inertia = 90.0, 100.0, 40.0 /
&initial angular_velocity = 0.02, -0.01, 0.03 /
&integrator time_step = 0.4, end_time = 120.0 /
&output columns = 'quaternion', 'angular_velocity', 'energy', 'angular_momentum_space' /
"""
WHEELS = "".join(f"&wheel axis = {axis}, inertia = 0.05, torque_limit = 0.3, speed_limit = 90.0 /\n"
                 for axis in ("1, 1, 1", "-1, 1, 1", "1, -1, 1", "1, 1, -1"))
LAW = "&controller law = 'quaternion', attitude_gain = 0.01, rate_gain = 0.12, target = 0.5, 0.5, 0.5, 0.5"
METHODS = ("nielsen_krenk", "rk4", "rk8", "dop853", "taylor")


class Controllers(CommandLineTest):
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

    def test_a_body_that_a_sampled_controller_accelerates_without_end_is_reported(self):
        scene = ("&body inertia = 1.0, 1.2, 1.5 /\n&initial angular_velocity = 0.0, 0.0, 0.1 /\n"
                 "&controller law = 'quaternion', attitude_gain = 1.0, rate_gain = 10.0, sample = 0.3 /\n&output interval = 1.0 /\n")
        for method in ("taylor", "dop853", "rk8"):
            with self.subTest(method):
                self.write("unstable.nml", scene + f"&integrator method = '{method}', local_tolerance = 1e-6, end_time = 1000.0 /\n")
                self.fail_with(3, "run", "unstable.nml", "--quiet", "--max-steps", "1000000",
                               says=("a sampled controller is unstable: the body turns by over 1e5 rad from sample to sample",
                                     "(expected a shorter sample or smaller gains)"))

    def test_what_is_switched_off_holds_nothing(self):
        self.write("off.nml", LAW + ", sample = 0.5, name = 'law' /\n" + BODY +
                   "&event when = 'q3', crosses = 0.3, direction = 1, switch = 'law off' /\n")
        self.succeed("run", "off.nml", "--quiet")
        self.assertEqual(len(self.read("off.events.csv").splitlines()), 2)
        rows = self.history("off.csv")[1]
        self.assertNotEqual(rows[10][8], rows[0][8])
        self.assertAlmostEqual(rows[-1][8], rows[-20][8], delta=1e-13)

    def test_a_law_that_is_switched_off_and_on_at_one_time_begins_again(self):
        motor = "&wheel axis = 1, 0, 0, inertia = 0.05, torque = 0.1 /\n" \
                "&controller law = 'bdot', gain = 0.4, field = 0.3, 0.8, -0.5, sample = 0.5, name = 'law' /\n" + BODY
        events = "".join(f"&event when = 'wheel1_momentum', crosses = 0.133, switch = 'law {change}' /\n" for change in ("off", "on"))
        self.write("again.nml", motor + events)
        self.succeed("run", "again.nml", "--quiet", "--set", "output.columns=controller1", "--set", "integrator.time_step=0.1",
                     "--set", "integrator.end_time=2")
        for t, *moment in self.history("again.csv")[1]:
            self.assertEqual(any(moment[:3]), 0.55 < t < 1.35 or t > 1.55, t)

    def test_interrupted_runs_go_on(self):
        kinds = ("wheels", ", by = 'wheels'"), ("magnetorquers", ", by = 'magnetorquers', field = 0.3, -0.2, 0.4"), ("torque", "")
        for turn, (kind, by) in enumerate(kinds):
            self.write(f"{kind}.nml", WHEELS + LAW + by + ", sample = 0.7 /\n" + BODY)
            for number, method in enumerate(("nielsen_krenk", "taylor", "dop853"), turn):
                if not in_turn(number):
                    continue
                options = ["--set", f"integrator.method={method}"]
                self.succeed("run", f"{kind}.nml", "--quiet", "--output", "whole.csv", *options)
                for steps in ("50", "51", "52", "53"):
                    self.fail_with(3, "run", f"{kind}.nml", "--quiet", "--output", "part.csv", "--checkpoint", "a.ck",
                                   "--max-steps", steps, *options)
                    self.succeed("run", f"{kind}.nml", "--quiet", "--output", "part.csv", "--resume", "a.ck", *options)
                    self.assertEqual(self.read("part.csv"), self.read("whole.csv"))

    def test_laws_at_all_times_keep_their_limits(self):
        # Springy, so that what it asks for grows from the start on.
        law = "&controller law = 'quaternion', attitude_gain = 0.1, rate_gain = 0.12"
        wheels = WHEELS.replace("torque_limit = 0.3, speed_limit = 90.0", "torque_limit = 0.15, speed_limit = 12.0")
        columns = BODY.replace("'energy', ", "'energy', 'wheel1', ")
        for kind, scene, said in (("torque", law + ", limit = 0.3 /\n" + BODY, "limit of torque"),
                                  ("magnetorquers", law + ", by = 'magnetorquers', field = 0.3, -0.2, 0.4, limit = 0.5 /\n" + BODY,
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
        # Adaptive steps that end at limits are counted, and limit the next ones, behind a checkpoint too.
        options = ["--unset", "integrator.time_step", "--set", "integrator.local_tolerance=1e-8", "--set", "integrator.method=dop853"]
        text = self.succeed("run", "magnetorquers.nml", "--output", "free.csv", *options).stderr
        self.assertRegex(text, "shortened steps +[0-9]+ more, which end at events")
        self.fail_with(3, "run", "magnetorquers.nml", "--quiet", "--output", "part.csv", "--checkpoint", "a.ck", "--max-steps", "25",
                       *options)
        self.succeed("run", "magnetorquers.nml", "--quiet", "--output", "part.csv", "--resume", "a.ck", *options)
        self.assertEqual(self.read("part.csv"), self.read("free.csv"))
        header, rows = self.history("whole.csv")
        speed = next(k for k, name in enumerate(header) if name.startswith("wheel1_speed"))
        self.assertAlmostEqual(max(abs(row[speed]) for row in rows), 12.0, delta=0.5)

    def test_members_are_controlled_by_the_inertia_before_variation(self):
        varied = "&ensemble members = 5, seed = 3, histories = 2 /\n" \
                 "&vary key = 'body.inertia', distribution = 'uniform', low = 80, 95, 30, high = 100, 105, 50 /\n"
        for name, wheels, by in (("torque", "", ""), ("wheels", WHEELS, ", by = 'wheels', sample = 0.5")):
            scene = wheels + LAW + by + " /\n" + BODY
            self.write(f"{name}.nml", scene + varied)
            self.succeed("sweep", f"{name}.nml", "--quiet", "--csv", "rows.csv")
            header, rows = self.history("rows.csv")
            for row in rows:
                member = str(int(row[0]))
                inertia = ",".join(repr(x) for x in row[2:5])
                # The true inertia to the body, the nominal one to the controller; and what a controller would do that knew it.
                own, nominal = ["--set", f"body.inertia={inertia}"], ["--set", "controller.inertia=90,100,40"]
                ends = [self.history("run.csv")[1][-1] for options in (own + nominal, own)
                        if self.succeed("run", f"{name}.nml", "--quiet", "--output", "run.csv", *options)]
                self.assertEqual(row[5:5 + len(ends[0])], ends[0])
                self.assertGreater(max(abs(a - b) for a, b in zip(*ends)), 1e-4)
                again = self.succeed("sweep", f"{name}.nml", "--member", member, "--quiet").stdout
                self.assertEqual(again.splitlines()[1], self.read("rows.csv").splitlines()[int(member)])
            self.assertEqual(self.history(f"{name}.member2.csv")[1][-1], rows[1][5:5 + len(ends[0])])

    def test_gains_as_numbers_and_as_matrices_are_the_same(self):
        tensor = BODY.replace("inertia = 90.0, 100.0, 40.0", "inertia_tensor = 90.0, 100.0, 40.0, 5.0, -3.0, 2.0")
        rows = {}
        for name, keys in (("plain", "attitude_gain = 0.25, rate_gain = 0.5"),
                           ("given", "attitude_gain = 0.25, rate_gain = 0.5, inertia = 90, 100, 40, 5, -3, 2"),
                           ("symmetric", "attitude_gain_matrix = 22.5, 25, 10, 1.25, -0.75, 0.5, rate_gain = 0.5"),
                           ("full", "attitude_gain = 0.25, rate_gain_matrix = 45, 2.5, -1.5, 2.5, 50, 1, -1.5, 1, 20"),
                           ("rotated", "attitude_gain = 0.25, rate_gain_matrix = 45, 9, -9, -4, 50, 1, 3, 1, 20"),
                           ("transposed", "attitude_gain = 0.25, rate_gain_matrix = 45, -4, 3, 9, 50, 1, -9, 1, 20"),
                           ("scalar", "attitude_gain = 2, rate_gain = 3, gains = 'scalar'"),
                           ("diagonal", "attitude_gain_matrix = 2, 2, 2, rate_gain_matrix = 3, 3, 3")):
            self.write(f"{name}.nml", f"&controller law = 'quaternion', {keys} /\n" + tensor)
            self.succeed("run", f"{name}.nml", "--quiet")
            rows[name] = self.read(f"{name}.csv")
        for name in ("given", "symmetric", "full"):
            self.assertEqual(rows[name], rows["plain"])
        self.assertEqual(rows["diagonal"], rows["scalar"])
        self.assertEqual(len({rows[name] for name in ("plain", "rotated", "transposed", "scalar")}), 4)

    def test_check_says_whose_inertia_gains_use(self):
        varied = "&ensemble members = 5 /\n&vary key = 'body.inertia', distribution = 'uniform', " \
                 "low = 80, 95, 30, high = 100, 105, 50 /\n"
        self.write("plain.nml", LAW + " /\n" + BODY)
        self.write("varied.nml", LAW + " /\n" + BODY + varied)
        own = "gains times the inertia of the body, 90, 100, 40 kg m^2"
        for scene, settings, said, unsaid in (
                ("plain", (), own, "before variation"), ("varied", (), own + ", before variation", "given"),
                ("varied", ("controller.inertia=90,100,41",), "gains times the inertia given", "before variation"),
                ("plain", ("controller.gains='scalar'",), "gains = scalar", "gains times"),
                ("plain", ("controller.attitude_gain_matrix=1,1,1", "controller.rate_gain_matrix=2,2,2"),
                 "attitude_gain_matrix = 1, 1, 1", "gains times")):
            options = [word for setting in settings for word in ("--set", setting)]
            text = self.succeed("check", f"{scene}.nml", *options).stdout
            line = next(line for line in text.splitlines() if "law = quaternion" in line)
            self.assertIn(said, line)
            self.assertNotIn(unsaid, line)
            self.assertNotIn("&earth_field", line)

    def test_magnetorquers_leave_the_momentum_along_their_field(self):
        for law in ("law = 'bdot', gain = 3", LAW[len("&controller "):] + ", by = 'magnetorquers', sample = 0.5"):
            magnetorquers = "&controller " + law + ", field = 0, 0.3, -0.4 /\n"
            self.write("magnetorquers.nml", magnetorquers + BODY)
            said = "the exact motion conserves the component along the field of the magnetorquers, 0, 0.6, -0.8; it is not monitored"
            self.assertIn(said, self.succeed("check", "magnetorquers.nml").stdout)
            self.assertIn(said, self.succeed("run", "magnetorquers.nml").stderr)
            momenta = [0.6 * row[9] - 0.8 * row[10] for row in self.history("magnetorquers.csv")[1]]
            self.assertLess(max(momenta) - min(momenta), 1e-12)
            for other in ("&gravity_gradient direction = 0, 0, 1, strength = 1e-6 /\n", magnetorquers.replace("0.3", "0.31")):
                self.write("magnetorquers.nml", magnetorquers + other + BODY)
                self.assertIn("these effects conserve no component", self.succeed("check", "magnetorquers.nml").stdout)

    def test_what_does_not_go_is_said(self):
        self.write("all_times.nml", LAW + " /\n" + BODY)
        self.fail_with(2, "run", "all_times.nml", "--set", "integrator.method=taylor", says=("expected sample",))
        self.assertIn("dop853", self.succeed("check", "all_times.nml", "--set", "integrator.accuracy=1e-6").stdout)
        self.write("sampled.nml", LAW + ", sample = 0.5 /\n" + BODY)
        self.fail_with(2, "cost", "sampled.nml", says=("no sample and no limits in &controller",))
        free = WHEELS.replace(", torque_limit = 0.3, speed_limit = 90.0", "")
        self.write("by_wheels.nml", free + LAW + ", by = 'wheels' /\n" + BODY)
        self.fail_with(2, "run", "by_wheels.nml", says=("expected sample", "dop853"))
        self.succeed("run", "by_wheels.nml", "--quiet", "--set", "integrator.method=dop853")


if __name__ == "__main__":
    unittest.main()
