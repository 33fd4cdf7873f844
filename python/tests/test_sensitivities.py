"""Derivatives of motions by numbers of scenes: those of solve against differences of motions, and those of histories."""

import copy
import unittest

import numpy as np

import nutate

TOP = """&body inertia = 3.0, 2.0, 1.5, mass = 2.0, center_of_mass = 0.1, 0.05, 0.2 /
&initial quaternion = 0.8, 0.4, -0.4, 0.2, angular_velocity = 0.4, -0.3, 2.0 /
&gravity acceleration = 0.0, 1.0, -9.8 /
&integrator method = 'nielsen_krenk', order = 4, time_step = 0.05, end_time = 1.0 /
"""
STEPS = {"method": "nielsen_krenk", "order": 4, "time_step": 0.05}


def rotation(q, r):
    """The rotation vector, body axes, from attitudes q to r."""
    return 2 * np.stack([q[:, 0] * r[:, i] - r[:, 0] * q[:, i] - q[:, j] * r[:, k] + q[:, k] * r[:, j]
                         for i, j, k in ((1, 2, 3), (2, 3, 1), (3, 1, 2))], axis=-1)


class SensitivityTest(unittest.TestCase):
    """Of solutions."""

    def setUp(self):
        self.scene = nutate.Scene(text=TOP)

    def test_derivatives_are_differences_of_motions(self):
        times, step = np.array([0.0, 0.033, 0.5, 1.0]), 1e-5
        solution = nutate.solve(self.scene, t_eval=times, free=["body.mass", "initial.angular_velocity"], **STEPS)
        self.assertEqual(solution.free, ("body.mass", *(f"initial.angular_velocity.{i}" for i in (1, 2, 3))))
        theta, omega = solution.sensitivity(times)
        self.assertEqual((theta.shape, omega.shape), ((4, 3, 4), (4, 3, 4)))
        for number, changed in ((0, lambda h: f"body.mass={2 + h!r}"),
                                (2, lambda h: f"initial.angular_velocity=0.4,{-0.3 + h!r},2")):
            more, less = (nutate.solve(nutate.Scene(None, changed(h), text=TOP), t_eval=times, **STEPS) for h in (step, -step))
            # Rounding over the step, and its square.
            np.testing.assert_allclose(theta[:, :, number], rotation(less.q, more.q) / (2 * step), rtol=0, atol=2e-9)
            np.testing.assert_allclose(omega[:, :, number], (more.omega - less.omega) / (2 * step), rtol=0, atol=2e-9)

    def test_the_motion_itself_keeps_its_bits(self):
        plain, free = (nutate.solve(self.scene, accuracy=1e-8, **keys) for keys in ({}, {"free": "body.mass"}))
        np.testing.assert_array_equal(plain.q, free.q)
        before = free.sol(0.5)
        free.sensitivity(0.5)
        np.testing.assert_array_equal(free.sol(0.5)[0], before[0])
        self.assertEqual((plain.free, plain.sensitivity), ((), None))

    def test_one_time_many_times_and_backward(self):
        for span in ((0.0, 1.0), (0.0, -1.0)):
            solution = nutate.solve(self.scene, t_span=span, free=["initial.attitude"], **STEPS)
            times = span[1] * np.array([0.7, 0.2, 0.7])
            theta, omega = solution.sensitivity(times)
            np.testing.assert_array_equal(theta[0], theta[2])
            for i, t in enumerate(times):
                one = solution.sensitivity(t)
                self.assertEqual((one[0].shape, one[1].shape), ((3, 3), (3, 3)))
                np.testing.assert_array_equal(one[0], theta[i])
                np.testing.assert_array_equal(one[1], omega[i])
            # The start turns with the body.
            np.testing.assert_allclose(solution.sensitivity(0.0)[0], np.eye(3), rtol=0, atol=1e-11)

    def test_what_cannot_be_is_refused(self):
        with self.assertRaisesRegex(nutate.NutateValueError, "expected a Scene"):
            nutate.solve(nutate.System(moments=(1, 2, 2.5)), omega0=(1, 2, 3), t_span=(0, 1), free=["body.mass"])
        with self.assertRaisesRegex(nutate.NutateError, "no derivative by 'integrator.time_step'"):
            nutate.solve(self.scene, free=["integrator.time_step"], **STEPS)
        with self.assertRaisesRegex(nutate.NutateValueError, "outside the motion"):
            nutate.solve(self.scene, free=["body.mass"], **STEPS).sensitivity(1.5)

    def test_a_stepper_is_as_before(self):
        free = nutate.Scene(None, "free.key=body.mass", text=TOP)
        stepper = nutate.Stepper(free)
        twin = copy.copy(stepper)
        columns = twin.sensitivities(free, 0.5, times=[0.25, 0.5])
        self.assertEqual(list(columns)[:2], ["t", "d_rotation1/d_body.mass"])
        np.testing.assert_array_equal(columns["t"], [0.25, 0.5])
        first, second = stepper.run_to(1.0), twin.run_to(1.0)
        self.assertEqual(list(first), list(second))
        self.assertEqual(first["q1"][-1], second["q1"][-1])
        with self.assertRaisesRegex(nutate.NutateValueError, "need free numbers"):
            stepper.sensitivities(nutate.Scene(text=TOP), 2.0)


class HistoryTest(unittest.TestCase):
    """Of scenes that are run."""

    def test_a_scene_has_the_columns_of_the_program(self):
        scene = nutate.Scene(text=TOP + "&free key = 'body.mass', sigma = 0.1 /\n&output every = 5 /\n")
        history, plain = scene.run(), nutate.Scene(text=TOP + "&output every = 5 /\n").run()
        for name, values in plain.items():
            np.testing.assert_array_equal(history[name], values)
        np.testing.assert_allclose(history["sigma_omega1"], 0.1 * np.abs(history["d_omega1/d_body.mass"]), rtol=1e-14)
        theta, omega = nutate.solve(nutate.Scene(text=TOP), free=["body.mass"], **STEPS).sensitivity(history["t"])
        np.testing.assert_allclose(history["d_omega2/d_body.mass"], omega[:, 1, 0], rtol=0, atol=1e-13)
        np.testing.assert_allclose(history["d_rotation3/d_body.mass"], theta[:, 2, 0], rtol=0, atol=1e-13)

    def test_what_has_no_derivative_is_refused_with_its_line(self):
        text = TOP + "&torque body = 1, 0, 0, start = 0.5 /\n&free key = 'torque.start' /\n"
        with self.assertRaisesRegex(nutate.NutateError, ":6: the motion has no derivative by torque.start"):
            nutate.Scene(text=text, name="late.nml").run()


if __name__ == "__main__":
    unittest.main()
