"""nutate linearize: what it prints and writes, and what it refuses."""
import json
import math

from support import ROOT, CommandLineTest

SATELLITE = """&body inertia = 90, 100, 40 /
&orbit semi_major_axis = 6878137.0 /
&gravity_gradient /
&initial attitude_from = 'lvlh', rate_from = 'lvlh', roll_pitch_yaw = 0, 0, 0, angular_velocity = 0, 0, 0 /
&integrator time_step = 30, end_time = 6000 /
"""
# The rate of that orbit, rad/s.
RATE = 0.001106783446334940580568


def libration(j):
    """Squares of the rates, as s of exp(st) over the rate of the orbit, of pitch, and of roll and yaw."""
    pitch = -3 * (j[0] - j[2]) / j[1]
    k1, k3 = (j[1] - j[2]) / j[0], (j[1] - j[0]) / j[2]
    half, last = (1 + 3 * k1 + k1 * k3) / 2, 4 * k1 * k3
    root = complex(half * half - last) ** 0.5
    return [pitch, -half + root, -half - root]


class Linearize(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("sat.nml", SATELLITE)

    def linear(self, *arguments):
        """The linearisation of a scene as it is written."""
        return json.loads(self.succeed("linearize", *arguments, "--quiet", "--json", "-").stdout)

    def test_librations_of_satellites(self):
        for inertia in ((90.0, 100.0, 40.0), (100.0, 90.0, 40.0), (40.0, 100.0, 90.0)):
            found = self.linear("sat.nml", "--set", "body.inertia=" + ",".join(map(repr, inertia)))
            values = [complex(*pair) / RATE for pair in found["eigenvalues"]]
            for square in libration(inertia):
                for root in (complex(square) ** 0.5, -complex(square) ** 0.5):
                    # Rounding of A over the least distance of its eigenvalues, 0.4.
                    self.assertLess(min(abs(value - root) for value in values), 1e-14, inertia)

    def test_what_is_printed(self):
        page = self.succeed("linearize", "sat.nml").stdout
        for text in ("sat.nml: sat", "motion              equilibrium", "residual            0 rad/s^2", "A, rates by states",
                     "theta3  -1.106783E-3", "B, rates by inputs", "Eigenvalues of A (1/s)", "±1.355527E-3    4635.233"):
            self.assertIn(text, page)

    def test_what_is_written(self):
        found = self.linear("sat.nml", "--set", "output.file=x.csv")
        self.assertEqual(found["states"], ["theta1", "theta2", "theta3", "omega1", "omega2", "omega3"])
        self.assertEqual(found["state_units"], ["rad"] * 3 + ["rad/s"] * 3)
        self.assertEqual(found["rates"], "absolute")
        self.assertEqual(found["inputs"], ["torque1", "torque2", "torque3"])
        self.assertEqual(found["input_units"], ["N m"] * 3)
        self.assertEqual([row[2] for row in found["B"]], [0, 0, 0, 0, 0, 0.025])
        self.assertAlmostEqual(found["angular_velocity"][1], -RATE, delta=1e-15 * RATE)
        self.assertEqual((found["period"], found["closes"], found["residual"]), (0, True, 0))
        # A file of its own kind is replaced, no other.
        for _ in range(2):
            self.succeed("linearize", "sat.nml", "--quiet", "--json", "sat.json")
        self.assertEqual(json.loads(self.read("sat.json")), found)
        self.fail_with(2, "linearize", "sat.nml", "--json", "sat.nml", says=["sat.nml is the scene itself"])
        self.fail_with(2, "linearize", "sat.nml", "--json", "box.nml", says=["exists and is not a linearisation as JSON"])

    def test_multipliers_of_a_satellite_are_exponentials_of_its_rates(self):
        found = self.linear("sat.nml", "--period", "orbit", "--set", "integrator.order=8")
        self.assertAlmostEqual(found["period"], 2 * math.pi / RATE, delta=1e-11)
        self.assertTrue(found["closes"])
        multipliers = [complex(*pair) for pair in found["eigenvalues"]]
        for square in libration((90.0, 100.0, 40.0)):
            angle = 2 * math.pi * abs(square) ** 0.5
            # The error of steps of 30 s by order 8.
            self.assertLess(min(abs(value - complex(math.cos(angle), math.sin(angle))) for value in multipliers), 1e-10)
        page = self.succeed("linearize", "sat.nml", "--period", "orbit").stdout
        self.assertIn("Floquet multipliers", page)
        self.assertIn("a period of 5676.978029 s", page)

    def test_the_motion_of_hyperion_that_returns_is_unstable_against_tilts(self):
        scene = str(ROOT / "scenes" / "hyperion.nml")
        found = self.linear(scene, "--period", "orbit", "--set", "initial.angular_velocity=0,0,0.5515368654328064883257")
        self.assertTrue(found["closes"])
        # The error of steps of 0.125, a fiftieth of a revolution, by order 8.
        self.assertLess(min(abs(complex(*pair) + 1.88104197787748) for pair in found["eigenvalues"]), 1e-5)
        page = self.succeed("linearize", scene, "--period", "orbit").stdout
        self.assertIn("none: the motion does not return to its start", page)
        self.assertNotIn("Floquet", page)

    def test_a_swing_from_rest_to_rest_closes(self):
        # J3 θ'' = -m b sin θ: the period is 4 K(sin θ0/2) √(J3/mb), here θ0 = 1.1 rad, J3/mb = 4/3 s².
        period = 7.845222360554189
        self.write("needle.nml", "&body inertia = 2, 3, 4 /\n&dipole moment = 1.5, 0, 0, field = 2, 0, 0 /\n"
                   "&initial axis = 0, 0, 1, angle = 1.1, angular_velocity = 0, 0, 0 /\n"
                   "&integrator order = 8, time_step = 0.02, end_time = 8 /\n")
        for method in ("order=8", "order=4", "method=taylor", "method=rk8"):
            found = self.linear("needle.nml", "--period", repr(period), "--unset", "integrator.order",
                                "--set", "integrator." + method)
            self.assertTrue(found["closes"], method)
            # Energy and period change with the amplitude: the multipliers of the swing itself are 1 in a Jordan block.
            swing = [[found["A"][i][j] for j in (2, 5)] for i in (2, 5)]
            self.assertAlmostEqual(swing[0][0], 1, delta=1e-5)
            self.assertAlmostEqual(swing[0][0]*swing[1][1] - swing[0][1]*swing[1][0], 1, delta=1e-10)

    def test_motors_are_inputs(self):
        wheel = "&wheel axis = 0, 0, 1, inertia = 0.5, speed = 10 /\n"
        self.write("wheel.nml", "&body inertia = 5, 20, 17 /\n&initial angular_velocity = 0, 0, 0 /\n" + wheel +
                   "&integrator time_step = 0.1, end_time = 10 /\n")
        found = self.linear("wheel.nml")
        self.assertEqual((found["states"][6], found["inputs"][3], found["wheel_speeds"]), ("wheel1_speed", "motor1", [10]))
        period = self.linear("wheel.nml", "--period", "2")
        # A constant motor torque for 2 s.
        self.assertAlmostEqual(period["B"][6][3], 2 * (1 / 0.5 + 1 / 16.5), delta=1e-13)
        self.assertAlmostEqual(period["B"][5][3], -2 / 16.5, delta=1e-15)
        self.assertAlmostEqual(period["B"][2][3], -2 / 16.5, delta=1e-15)

    def test_what_is_refused(self):
        self.fail_with(2, "linearize", "box.nml", says=[
            "box.nml: the start is no equilibrium: angular acceleration 6.00E-01 rad/s^2 (expected 0, or a period"])
        self.fail_with(2, "linearize", "box.nml", "--period", "orbit", says=["there is no orbit with a period"])
        for value in ("0", "-1", "x", "inf", ""):
            self.fail_with(2, "linearize", "sat.nml", "--period", value, says=["--period"])
        self.fail_with(2, "run", "sat.nml", "--period", "3", says=["nutate run has no option --period"])
        self.fail_with(3, "linearize", "sat.nml", "--period", "orbit", "--max-steps", "3", says=["sat.nml: "])
        self.write("jump.nml", SATELLITE + "&torque body = 0, 0, 1e-9, name = 'jet' /\n"
                   "&event when = 'omega3', crosses = 0, switch = 'jet off' /\n")
        self.fail_with(2, "linearize", "jump.nml", "--period", "orbit", says=["events that switch effects"])
        self.write("sampled.nml", SATELLITE + "&controller law = 'quaternion', attitude_gain = 1, rate_gain = 1, sample = 1 /\n")
        for arguments in ((), ("--period", "orbit")):
            self.fail_with(2, "linearize", "sampled.nml", *arguments, says=["sample"])

    def test_help(self):
        page = self.succeed("linearize", "--help").stdout
        for text in ("--period T|orbit", "--json FILE", "Floquet multipliers"):
            self.assertIn(text, page)

    def test_relative_rates_on_request(self):
        absolute, relative = self.linear("sat.nml"), self.linear("sat.nml", "--relative-rates")
        self.assertEqual((absolute["rates"], relative["rates"]), ("absolute", "relative"))
        self.assertEqual([row[:3] for row in relative["A"][:3]], [[0, 0, 0]] * 3)
        self.assertEqual(relative["B"], absolute["B"])
        # Pitch does not differ; roll and yaw have Coriolis and centrifugal terms.
        self.assertAlmostEqual(relative["A"][4][1], absolute["A"][4][1], delta=1e-20)
        j, n = (90.0, 100.0, 40.0), RATE
        self.assertAlmostEqual(relative["A"][3][0], -4 * n * n * (j[1] - j[2]) / j[0], delta=1e-20)
        self.assertAlmostEqual(relative["A"][3][5], n * (j[0] - j[1] + j[2]) / j[0], delta=1e-17)
        page = self.succeed("linearize", "sat.nml", "--relative-rates").stdout
        self.assertIn("rates of states     relative to axes that rotate with the equilibrium", page)
        self.assertIn("space axes          inertial, x to the equinox, z north", page)
        self.fail_with(2, "linearize", "sat.nml", "--relative-rates", "--period", "orbit", says=("cannot be combined",))

    def test_all_equilibria(self):
        page = self.succeed("linearize", "sat.nml", "--equilibria").stdout
        self.assertIn("equilibria          24 attitudes, relative to the LVLH frame", page)
        self.assertIn("by index            4 minima, 8 and 8 saddles (index 1, 2), 4 maxima", page)
        found = self.linear("sat.nml", "--equilibria", "--set", "rotor.momentum=0.03,0.05,0.04")
        self.assertTrue(found["balanced"])
        self.assertGreaterEqual(len(found["equilibria"]), 8)
        # A run from each of them stays there, or leaves it as its growth says.
        for one in found["equilibria"]:
            attitude = ",".join(map(repr, one["attitude"]))
            linear = self.linear("sat.nml", "--set", "rotor.momentum=0.03,0.05,0.04", "--unset", "initial.roll_pitch_yaw",
                                 "--set", "initial.quaternion=" + attitude)
            self.assertAlmostEqual(max(value[0] for value in linear["eigenvalues"]), one["growth"], delta=1e-6 * RATE)
            self.assertEqual(one["growth"] > 0 or one["index"] in (0, 2), True)
        self.fail_with(2, "linearize", "sat.nml", "--equilibria", "--period", "orbit", says=("cannot be combined",))
        self.fail_with(2, "linearize", "sat.nml", "--equilibria", "--set", "body.inertia=90,90,40", says=("sat.nml: equilibria are not isolated",))
