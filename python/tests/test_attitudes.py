"""Attitudes in all their forms, and what C has beside steps and runs."""

import unittest

import numpy as np

import nutate
from test_nutate import BOX, make_box


class AttitudeTest(unittest.TestCase):
    """Conversions, the exact solution, and what the header has beside."""

    Q = nutate.quat_normalized((0.5, -0.1, 0.7, 0.2))

    def same(self, a, b):
        np.testing.assert_allclose(a, b, rtol=1e-14, atol=1e-14)

    def test_every_form_comes_back(self):
        q = self.Q
        self.same(nutate.quat_from_matrix(nutate.matrix_from_quat(q)), q)
        self.same(nutate.quat_from_euler(nutate.euler_from_quat(q)), q)
        self.same(nutate.quat_from_rotation_vector(nutate.rotation_vector_from_quat(q)), q)
        self.same(nutate.quat_from_axis_angle(*nutate.axis_angle_from_quat(q)), q)
        self.same(nutate.rotate_to_body(q, nutate.rotate_to_space(q, (1, 2, 3))), (1, 2, 3))
        self.same(nutate.rotate_to_space(q, (1, 2, 3)), nutate.matrix_from_quat(q) @ (1, 2, 3))
        self.same(nutate.matrix_from_quat(nutate.quat_product(q, q)), np.linalg.matrix_power(nutate.matrix_from_quat(q), 2))
        self.assertAlmostEqual(nutate.attitude_distance(q, nutate.quat_product(q, nutate.quat_from_axis_angle((0, 0, 2), 0.3))),
                               0.3, delta=1e-14)
        phi, theta, psi = nutate.euler_from_quat(q)
        self.same(nutate.follow_euler(q, (phi + 2 * np.pi, theta, psi - 2 * np.pi)), (phi + 2 * np.pi, theta, psi - 2 * np.pi))
        self.same(nutate.omega_from_euler_rates((phi, 0.0, 0.0), (0.1, 0.2, 0.3)), (0.2, 0.0, 0.4))
        for wrong in (lambda: nutate.matrix_from_quat((1, 0, 0)), lambda: nutate.quat_from_matrix(np.eye(2)),
                      lambda: nutate.quat_from_axis_angle((0, 0, 0), 1), lambda: nutate.quat_normalized((np.nan, 0, 0, 0))):
            self.assertRaises(nutate.NutateValueError, wrong)
        with self.assertRaisesRegex(nutate.NutateValueError, "quat_from_matrix: a matrix is no rotation .expected orthonormal rows"):
            nutate.quat_from_matrix(np.diag([1, 1, -1]))

    def test_arrays_are_converted_row_by_row(self):
        generator = np.random.default_rng(1)
        many, v = nutate.quat_normalized(generator.normal(size=(5, 4))), generator.normal(size=(5, 3))
        one = many[0]
        for name, arguments in (("matrix_from_quat", (many,)), ("euler_from_quat", (many,)), ("rotation_vector_from_quat", (many,)),
                                ("quat_from_matrix", (nutate.matrix_from_quat(many),)), ("quat_from_euler", (v,)),
                                ("quat_from_rotation_vector", (v,)), ("quat_from_axis_angle", (v, v[:, 0])), ("quat_product", (many, many)),
                                ("rotate_to_space", (many, v)), ("rotate_to_body", (many, v)), ("attitude_distance", (many, many[::-1])),
                                ("omega_from_euler_rates", (v, v))):
            with self.subTest(function=name):
                function = getattr(nutate, name)
                np.testing.assert_array_equal(function(*arguments), [function(*row) for row in zip(*arguments)])
        self.same(nutate.quat_product(one, many)[3], nutate.quat_product(one, many[3]))
        self.same(nutate.rotate_to_space(many, (1, 2, 3))[2], nutate.rotate_to_space(many[2], (1, 2, 3)))
        axes, angles = nutate.axis_angle_from_quat(many)
        self.same(nutate.quat_from_axis_angle(axes, angles)*np.sign(many[:, :1]), many)
        self.assertEqual(nutate.matrix_from_quat(np.empty((0, 4))).shape, (0, 3, 3))
        for wrong in (lambda: nutate.quat_product(many, many[:3]), lambda: nutate.matrix_from_quat(many[None]),
                      lambda: nutate.rotate_to_space(many, v[:2])):
            self.assertRaises(nutate.NutateValueError, wrong)

    def test_degrees(self):
        q, angles = self.Q, (10.0, 20.0, 30.0)
        self.same(nutate.euler_from_quat(nutate.quat_from_euler(angles, degrees=True), degrees=True), angles)
        self.same(nutate.euler_from_quat(q, degrees=True), np.degrees(nutate.euler_from_quat(q)))
        self.same(nutate.rotation_vector_from_quat(nutate.quat_from_rotation_vector(angles, degrees=True), degrees=True), angles)
        self.same(nutate.quat_from_axis_angle((0, 0, 1), 90, degrees=True), (0.5**0.5, 0, 0, 0.5**0.5))
        self.same(nutate.axis_angle_from_quat((0, 1, 0, 0), degrees=True)[1], 180)
        self.same(nutate.attitude_distance((1, 0, 0, 0), (0, 0, 1, 0), degrees=True), 180)

    def test_rotations_of_scipy_go_in_and_out(self):
        try:
            from scipy.spatial.transform import Rotation
        except ImportError:
            self.skipTest("SciPy is not here")
        rotation = Rotation.from_quat(np.roll(self.Q, -1))
        self.same(nutate.matrix_from_quat(rotation), rotation.as_matrix())
        self.same(nutate.from_rotation(rotation), self.Q)
        self.same(nutate.to_rotation([self.Q, (0, 1, 0, 0)]).as_matrix()[0], rotation.as_matrix())
        self.assertRaises(nutate.NutateValueError, nutate.from_rotation, np.eye(3))
        stepper = make_box()
        stepper.set_state(rotation, (0.1, 0, 10))
        self.same(stepper.rotation.as_matrix(), rotation.as_matrix())

    def test_ways_to_set_a_state_agree(self):
        stepper = make_box()
        stepper.set_state(q=self.Q, omega=(1, 2, 3), t=np.float32(0.5))
        states = [stepper.conjugate_momentum]
        stepper.set_state(xyzw=np.roll(self.Q, -1), omega=(1, 2, 3))
        states.append(stepper.conjugate_momentum)
        stepper.set_state(q=self.Q, omega=nutate.rotate_to_space(self.Q, (1, 2, 3)), frame="space")
        states.append(stepper.conjugate_momentum)
        stepper.set_canonical(self.Q, states[0])
        states.append(stepper.conjugate_momentum)
        for p in states[1:]:
            np.testing.assert_allclose(p, states[0], rtol=1e-14, atol=1e-13)
        for wrong in ({"q": self.Q}, {"omega": (1, 2, 3)}, {"q": self.Q, "xyzw": self.Q, "omega": (1, 2, 3)},
                      {"q": self.Q, "omega": (1, 2, 3), "frame": "earth"}):
            self.assertRaises(nutate.NutateValueError, stepper.set_state, **wrong)

    def test_the_exact_motion_is_that_of_short_steps(self):
        system = nutate.System(tensor=((5, 0.1, 0), (0.1, 20, 0), (0, 0, 17)))
        q, omega = nutate.exact_free_body(system, self.Q, (0.1, 0.2, 3), (0.0, 0.5))
        stepper = nutate.Stepper(system, order=8, formulation="reduced")
        stepper.set_state(self.Q, (0.1, 0.2, 3))
        stepper.steps(0.01, 50)
        self.assertLess(nutate.attitude_distance(q[1], stepper.quaternion), 1e-12)
        np.testing.assert_allclose(stepper.angular_velocity, omega[1], rtol=1e-11)
        with self.assertRaisesRegex(nutate.NutateValueError, "not symmetric"):
            nutate.System(tensor=((5, 0.1, 0), (0, 20, 0), (0, 0, 17)))

    def test_a_tensor_is_symmetric_to_its_round_off(self):
        """Products of inertia that nearly cancel differ by the round-off of the moments."""
        tensor = np.diag((5.0, 20.0, 17.0))
        tensor[0, 1], tensor[1, 0] = 3e-16, -1e-15
        self.assertEqual(nutate.System(tensor=tensor).inertia[0, 1], 3e-16)
        for scale in (1e-9, 1.0, 1e9):
            wrong = scale * tensor
            wrong[0, 2] = scale * 1e-10
            with self.assertRaisesRegex(nutate.NutateValueError, "not symmetric"):
                nutate.System(tensor=wrong)

    def test_what_body_and_effects_say(self):
        system = nutate.System(moments=(5, 5, 1), mass=np.int64(2), center_of_mass=(0, 0, 1))
        self.assertEqual((system.mass, tuple(system.center_of_mass)), (2.0, (0.0, 0.0, 1.0)))
        self.assertEqual(nutate.Stepper(system).conserved[0], 3)
        system.add("gravity")
        stepper = nutate.Stepper(system, time_step=0.01)
        components, axis = stepper.conserved
        self.assertEqual((components, abs(axis[2])), (1, 1.0))
        stepper.set_state((1, 0, 0, 0), (1, 0, 5))
        stepper.prepare()
        stepper.step(0.01)
        self.assertGreater(stepper.solver[0], 0)
        self.assertEqual(stepper.row["t"], stepper.time)
        q, omega = nutate.Scene(BOX).initial
        np.testing.assert_array_equal(np.concatenate((q, omega)), (1, 0, 0, 0, 0.1, 0, 10))
