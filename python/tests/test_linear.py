"""nutate.linearize: matrices, names and units, and what is refused."""

import unittest

import numpy as np

import nutate

SATELLITE = """&body inertia = 90, 100, 40 /
&orbit semi_major_axis = 6878137.0 /
&gravity_gradient /
&wheel axis = 0, -1, 0, inertia = 0.01, speed = 5 /
&initial attitude_from = 'lvlh', rate_from = 'lvlh', roll_pitch_yaw = 0, 0, 0, angular_velocity = 0, 0, 0 /
&integrator order = 8, time_step = 60, end_time = 6000 /
"""


class LinearizeTest(unittest.TestCase):
    def test_a_satellite_about_its_equilibrium(self):
        scene = nutate.Scene(text=SATELLITE)
        found = nutate.linearize(scene)
        self.assertEqual((found.A.shape, found.B.shape), ((7, 7), (7, 4)))
        self.assertEqual(found.states[-1] + found.inputs[-1], "wheel1_speedmotor1")
        self.assertEqual((found.state_units[3], found.input_units[3], found.period), ("rad/s", "N m", 0.0))
        rate = -found.omega[1]
        # Pitch: 3n²(J1 - J3)/J2, of what turns with the body about that axis.
        self.assertAlmostEqual(found.A[4, 1], -3 * rate**2 * 50 / 99.99, delta=1e-14 * rate**2)
        np.testing.assert_allclose(found.eigenvalues.sum(), np.trace(found.A), atol=1e-12 * rate)
        np.testing.assert_array_equal(found.wheel_speeds, [5.0])

    def test_all_equilibria(self):
        for speed, counts in ((0, [4, 8, 8, 4]), (5, [2, 4, 6, 4])):
            found = nutate.equilibria(nutate.Scene(None, f"wheel.speed={speed}", text=SATELLITE))
            self.assertEqual([sum(one.index == i for one in found) for i in range(4)], counts)
            self.assertEqual(len(found), sum(counts))
            self.assertTrue(all(one.growth == 0 for one in found if one.index == 0))
            self.assertTrue(all(abs(np.linalg.norm(one.q) - 1) < 1e-15 for one in found))
        with self.assertRaisesRegex(nutate.NutateValueError, "not isolated"):
            nutate.equilibria(nutate.Scene(None, "body.inertia=100,100,40", "wheel.speed=0", text=SATELLITE))

    def test_a_period_is_the_exponential(self):
        scene = nutate.Scene(text=SATELLITE)
        rest, period = nutate.linearize(scene), nutate.linearize(scene, period="orbit")
        self.assertTrue(period.closes)
        values = np.linalg.eigvals(rest.A * period.period)
        self.assertAlmostEqual(period.period, 2 * np.pi / -rest.omega[1], delta=1e-11)
        for value in values:
            # A double 0 is known to the root of rounding; the rest to the error of steps of 60 s by order 8.
            self.assertLess(np.abs(period.eigenvalues - np.exp(value)).min(), 1e-7)

    def test_a_controller_with_these_gains_closes_the_loop(self):
        feedback = np.sin(np.arange(18.0)).reshape(3, 6) * np.array([1e-3] * 3 + [1.0] * 3)
        for frame in ("lvlh", "inertial"):
            text = SATELLITE.replace("6878137.0", f"6878137.0, inclination = 1, frame = '{frame}'")
            found = nutate.linearize(nutate.Scene(text=text))
            gains = found.controller_gains(feedback)
            keys = ", ".join(f"{name} = {', '.join(map(repr, map(float, matrix.ravel())))}" for name, matrix in gains._asdict().items())
            closed = nutate.linearize(nutate.Scene(text=text + f"&controller law = 'quaternion', target_from = 'lvlh', {keys} /\n"))
            expected = found.A - found.B[:, :3] @ np.hstack([feedback, np.zeros((3, 1))])
            np.testing.assert_allclose(closed.A, expected, atol=1e-15)
            whole = np.zeros((4, 7))
            whole[:3, :6] = feedback
            np.testing.assert_array_equal(found.controller_gains(whole).rate_gain_matrix, feedback[:, 3:])

    def test_relative_rates_on_request(self):
        scene = nutate.Scene(text=SATELLITE)
        absolute, relative = nutate.linearize(scene), nutate.linearize(scene, rates="relative")
        self.assertEqual((absolute.rates, relative.rates), ("absolute", "relative"))
        np.testing.assert_array_equal(relative.A[:3, :6], np.eye(3, 6, 3))
        change = np.eye(7)
        change[3:6, :3] = absolute.A[:3, :3]
        np.testing.assert_allclose(relative.A @ change, change @ absolute.A, atol=1e-18)
        np.testing.assert_allclose(relative.controller_gains(np.ones((3, 6))).attitude_gain_matrix, np.full((3, 3), 2.0))
        with self.assertRaises(nutate.NutateValueError):
            nutate.linearize(scene, rates="relative", period="orbit")
        with self.assertRaises(nutate.NutateValueError):
            nutate.linearize(scene, rates="lvlh")

    def test_gains_that_a_controller_cannot_have(self):
        found = nutate.linearize(nutate.Scene(text=SATELLITE))
        for place, words in (((3, 0), "motors or speeds"), ((0, 6), "motors or speeds")):
            gain = np.zeros((4, 7))
            gain[place] = 1
            with self.assertRaisesRegex(nutate.NutateValueError, words):
                found.controller_gains(gain)
        with self.assertRaisesRegex(nutate.NutateValueError, r"expected \(3, 6\) or \(4, 7\)"):
            found.controller_gains(np.zeros((6, 3)))
        with self.assertRaisesRegex(nutate.NutateValueError, "expected an equilibrium"):
            nutate.linearize(nutate.Scene(text=SATELLITE), period="orbit").controller_gains(np.zeros((3, 6)))

    def test_what_is_refused(self):
        scene = nutate.Scene(text=SATELLITE)
        for period in (0, -1, "orbits", float("nan"), 1e300):
            with self.assertRaises(nutate.NutateValueError, msg=period):
                nutate.linearize(scene, period=period)
        tumbling = nutate.Scene(None, "initial.angular_velocity=1,2,3", text=SATELLITE)
        with self.assertRaisesRegex(nutate.NutateValueError, "no equilibrium: angular acceleration .* rad/s"):
            nutate.linearize(tumbling)
        with self.assertRaises(nutate.NutateValueError):
            nutate.linearize(scene, "integrator.order=4")


if __name__ == "__main__":
    unittest.main()
