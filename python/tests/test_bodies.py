"""Many bodies from Python: in place, without copies, failures by index."""

import multiprocessing
import unittest

import numpy as np

import nutate

MOMENTS = np.array([1.0, 2.0, 2.5])


def start(n):
    """Attitudes, momenta in space axes and torques."""
    random = np.random.default_rng(3)
    q = random.normal(size=(n, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    return q, random.normal(size=(n, 3)), random.normal(size=(n, 3))


def stepped(n):
    """Attitudes after a step by two threads."""
    q, l, torque = start(n)
    nutate.Bodies(nutate.System(moments=MOMENTS), threads=2).step(0.1, q, l, torque)
    return q


class BodiesTest(unittest.TestCase):
    def setUp(self):
        self.system = nutate.System(moments=MOMENTS)

    def test_a_step_is_a_kick_and_a_drift_in_place(self):
        q, l, torque = start(50)
        q1, l1 = q.copy(), l.copy()
        bodies = nutate.Bodies(self.system, threads=2)
        self.assertIsNone(bodies.step(0.1, q, l, torque))
        np.testing.assert_array_equal(l, l1 + 0.1 * torque)
        bodies.kick(0.1, q1, l1, torque)
        bodies.drift(0.1, q1, l1)
        np.testing.assert_array_equal(q, q1)
        np.testing.assert_array_equal(l, l1)
        self.assertEqual(bodies.failed.size, 0)

    def test_threads_in_processes_that_were_forked_after_threads(self):
        q = stepped(3000)
        with multiprocessing.get_context("fork").Pool(1) as pool:
            np.testing.assert_array_equal(pool.apply_async(stepped, (3000,)).get(timeout=600), q)

    def test_strided_arrays_and_lists_do_the_same(self):
        q, l, torque = start(20)
        wide_q, wide_l = np.zeros((20, 8)), np.zeros((3, 20))
        strided_q, strided_l = wide_q[:, ::2], wide_l.T
        strided_q[:], strided_l[:] = q, l
        bodies = nutate.Bodies([nutate.System(moments=(1, 1, 1)), self.system])
        kinds = np.arange(20) % 2
        bodies.step(0.1, q, l, torque, kinds)
        bodies.step(0.1, strided_q, strided_l, torque.tolist(), kinds.tolist())
        np.testing.assert_array_equal(strided_q, q)
        np.testing.assert_array_equal(strided_l, l)
        np.testing.assert_array_equal(wide_q[:, 1::2], 0)

    def test_rates_follow_the_exact_motion(self):
        q, omega = np.array([[1.0, 0.0, 0.0, 0.0]]), np.array([[0.1, 2.0, 0.2]])
        exact, rate = nutate.exact_free_body(self.system, q[0], omega[0], [1.5])
        bodies = nutate.Bodies(self.system, frame="rate")
        for _ in range(300):
            bodies.drift(1.5 / 300, q, omega)
        self.assertLess(nutate.attitude_distance(q[0], exact[0]), 1e-8)
        np.testing.assert_allclose(omega[0], rate[0], atol=1e-7)

    def test_bodies_that_fail_are_listed(self):
        q, l, torque = start(10)
        torque[3, 1], l[7, 2] = np.nan, np.inf
        before = q.copy()
        bodies = nutate.Bodies(self.system)
        with self.assertRaisesRegex(nutate.NutateError, "2 of 10 bodies"):
            bodies.step(0.1, q, l, torque)
        self.assertEqual(bodies.failed.tolist(), [3, 7])
        self.assertEqual(np.flatnonzero((q == before).all(axis=1)).tolist(), [3, 7])

    def test_wrong_arguments_change_nothing(self):
        q, l, torque = start(4)
        before = q.copy()
        bodies = nutate.Bodies(self.system)
        for arguments in [(0.0, q, l, torque), (np.nan, q, l, torque), (0.1, q[:, :3], l, torque), (0.1, 1.0, l, torque), (0.1, q, l[:3], torque),
                          (0.1, q.astype(np.float32), l, torque), (0.1, q, l.tolist(), torque), (0.1, q, l, torque[:3]),
                          (0.1, q, l, torque, [0.5] * 4), (0.1, q, l, torque, [0]),
                          (0.1, q, l, torque, np.ma.array([0] * 4, mask=[True] * 4))]:
            with self.assertRaises(nutate.NutateValueError):
                bodies.step(*arguments)
        np.testing.assert_array_equal(q, before)
        q.flags.writeable = False
        self.assertRaises(nutate.NutateValueError, bodies.step, 0.1, q, l, torque)
        self.assertRaises(nutate.NutateValueError, nutate.Bodies, self.system, "sky")
        self.assertRaises(nutate.NutateValueError, nutate.Bodies, [])
        self.assertRaises(nutate.NutateValueError, nutate.Bodies, self.system, threads=-1)
        bodies.close()
        self.assertRaises(nutate.NutateValueError, bodies.drift, 0.1, q, l)


if __name__ == "__main__":
    unittest.main()
