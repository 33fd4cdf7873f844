"""Derivatives of motions by numbers of scenes: those of solve against differences of motions, and those of histories."""

import copy
import pickle
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
        plain, free = (nutate.solve(self.scene, **STEPS, **keys) for keys in ({}, {"free": "body.mass"}))
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

    def test_a_torque_that_starts_and_stops(self):
        def burn(start, stop, **other):
            system = nutate.System(moments=(1, 2, 2.5))
            system.add("torque", body=(0.2, -0.1, 0.3), start=start, stop=stop)
            return nutate.solve(system, omega0=(0.3, 0.2, 0.1), t_span=(0, 2), **other)

        times, h = np.array([0.4, 0.61, 0.62, 1.0, 1.333, 1.5, 2.0]), 1e-4
        for settings in ({"method": "rk8", "time_step": 0.1}, {"method": "taylor", "time_step": 0.1},
                         {"method": "nielsen_krenk", "order": 8, "time_step": 0.05}, {"method": "dop853", "local_tolerance": 1e-12}):
            with self.subTest(**settings):
                rates = burn(0.6, 1.3, free=["torque.start", "torque.stop"], **settings).sensitivity(times)[1]
                for i, (start, stop) in enumerate(((h, 0.0), (0.0, h))):
                    one = burn(0.6 + start, 1.3 + stop, **settings)
                    other = burn(0.6 - start, 1.3 - stop, **settings)
                    expected = (one.sol(times)[1] - other.sol(times)[1]) / (2 * h)
                    np.testing.assert_allclose(rates[:, :, i], expected, rtol=0, atol=1e-7)
                self.assertEqual(np.abs(rates[0]).max(), 0.0)
                self.assertEqual(np.abs(rates[3, :, 1]).max(), 0.0)
                self.assertGreater(np.abs(rates[5]).max(axis=0).min(), 0.05)

    def test_what_cannot_be_is_refused(self):
        system = nutate.System(moments=(1, 2, 2.5))
        with self.assertRaisesRegex(nutate.NutateError, "the scene has no 'body.mass' to start from"):
            nutate.solve(system, omega0=(1, 2, 3), t_span=(0, 1), free=["body.mass"])
        system.add_table([0, 1], np.zeros((2, 3)))
        with self.assertRaisesRegex(nutate.NutateValueError, "cannot have a table in its text"):
            nutate.solve(system, omega0=(1, 2, 3), t_span=(0, 1), free=["body.inertia"])
        with self.assertRaisesRegex(nutate.NutateError, "no derivative with respect to 'integrator.time_step'"):
            nutate.solve(self.scene, free=["integrator.time_step"], **STEPS)
        with self.assertRaisesRegex(nutate.NutateValueError, "outside the motion"):
            nutate.solve(self.scene, free=["body.mass"], **STEPS).sensitivity(1.5)
        rows = nutate.solve(self.scene, free=["body.mass"], t_eval=[0.25, 0.5], dense_output=False, **STEPS)
        whole = nutate.solve(self.scene, free=["body.mass"], **STEPS)
        np.testing.assert_allclose(rows.sensitivity(0.25)[1], whole.sensitivity(0.25)[1], rtol=0, atol=1e-14)
        with self.assertRaisesRegex(nutate.NutateValueError, "none of the rows"):
            rows.sensitivity(0.3)

    def test_times_inside_steps_need_no_other_run(self):
        calls = []

        def torque(t, q, omega):
            calls.append(t)
            return -0.05 * omega

        times = np.array([0.011, 1.234, 2.5, 2.51])
        for method in ("nielsen_krenk", "dop853", "rk8"):
            with self.subTest(method=method):
                settings = {"local_tolerance": 1e-9, "method": method}
                scene = nutate.Scene(None, "integrator.end_time=3", text=TOP)
                scene.add_user_torque(torque)
                solution = nutate.solve(scene, free=["body.mass", "initial.attitude"], **settings)
                of_run, calls[:] = len(calls), []
                found = [part[0] for part in solution.sensitivity(times[1:2])]
                self.assertLess(len(calls), of_run / 4)
                # As a run to there, but for the error of the step that ends there.
                there = nutate.solve(scene, t_span=(0, times[1]), free=["body.mass", "initial.attitude"], **settings)
                for part, other in zip(found, there.sensitivity(times[1])):
                    np.testing.assert_allclose(part, other, rtol=0, atol=1e-6)
                calls.clear()

    def test_columns_inside_steps_are_those_of_rows_there(self):
        times = np.array([0.011, 0.25, 0.5, 0.77])
        for settings in (STEPS, {"method": "rk8", "time_step": 0.05}, {"method": "taylor", "local_tolerance": 1e-10},
                         {"method": "nielsen_krenk", "order": 8, "local_tolerance": 1e-10}, {"method": "dop853", "local_tolerance": 1e-10}):
            with self.subTest(**settings):
                dense = nutate.solve(self.scene, free=["body.mass", "body.inertia.2"], **settings)
                rows = nutate.solve(self.scene, free=["body.mass", "body.inertia.2"], t_eval=times, dense_output=False, **settings)
                for found, wanted in zip(dense.sensitivity(times), rows.sensitivity(times)):
                    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 if "local_tolerance" in settings else 1e-12)

    def test_a_body_that_was_made_by_calls_has_names_too(self):
        system = nutate.System(tensor=(3, 2, 1.5, 0.1, 0, 0.2), mass=2.0, center_of_mass=(0.1, 0.05, 0.2))
        system.add("gravity", acceleration=(0.0, 1.0, -9.8))
        system.add_force((0.1, 0, 0), (0, 0, 0.5))
        start = {"q0": (0.8, 0.4, -0.4, 0.2), "omega0": (0.4, -0.3, 2.0), "t_span": (0, 1)}
        free = ["body.mass", "body.inertia_tensor.4", "force.force.3", "initial.angular_velocity.2"]
        solution = nutate.solve(system, free=free, **start, **STEPS)
        self.assertEqual(solution.free, tuple(free))
        step, found = 1e-5, solution.sensitivity(1.0)

        def disturbed(**keys):
            given = {"mass": 2.0, "jxy": 0.1, "force": 0.5, "rate": -0.3, **keys}
            other = nutate.System(tensor=(3, 2, 1.5, given["jxy"], 0, 0.2), mass=given["mass"], center_of_mass=(0.1, 0.05, 0.2))
            other.add("gravity", acceleration=(0.0, 1.0, -9.8))
            other.add_force((0.1, 0, 0), (0, 0, given["force"]))
            return nutate.solve(other, **{**start, "omega0": (0.4, given["rate"], 2.0)}, **STEPS)

        for i, (name, value) in enumerate((("mass", 2.0), ("jxy", 0.1), ("force", 0.5), ("rate", -0.3))):
            less, more = (disturbed(**{name: value + h}) for h in (-step, step))
            np.testing.assert_allclose(found[0][:, i], rotation(less.q[-1:], more.q[-1:])[0] / (2 * step), rtol=0, atol=5e-9)
            np.testing.assert_allclose(found[1][:, i], (more.omega[-1] - less.omega[-1]) / (2 * step), rtol=0, atol=5e-9)
        for made in (nutate.System(scene=self.scene), nutate.System(text=TOP.split("&initial")[0] + "&gravity acceleration = 0, 1, -9.8 /")):
            other = nutate.solve(made, free="body.mass", **start, **STEPS).sensitivity(1.0)
            np.testing.assert_allclose(other[1], nutate.solve(self.scene, free="body.mass", **STEPS).sensitivity(1.0)[1], rtol=0, atol=1e-13)

    def test_moments_about_the_centre_of_mass(self):
        system = nutate.System(moments=(3, 2, 1.5), mass=2.0, center_of_mass=(0.1, 0.05, 0.2), about_center=True)
        same = nutate.System(tensor=system.inertia, mass=2.0, center_of_mass=(0.1, 0.05, 0.2))
        ends = [nutate.solve(each, omega0=(0.4, -0.3, 2.0), t_span=(0, 1), free="initial.angular_velocity", **STEPS).sensitivity(1.0)
                for each in (system, same)]
        np.testing.assert_allclose(ends[0][1], ends[1][1], rtol=0, atol=1e-13)

    def test_wheels_and_the_shape_of_a_body(self):
        system = nutate.System(shape="box", size=(0.3, 0.2, 0.1), density=2000.0)
        system.add_wheel((0, 0, 1), 0.001, 50.0, torque=0.01)
        solution = nutate.solve(system, omega0=(0.1, 0.2, 1.0), t_span=(0, 2), free=["wheel.speed", "body.size.1"], **STEPS)
        ends = []
        for speed in (50.0 - 1e-3, 50.0 + 1e-3):
            other = nutate.System(shape="box", size=(0.3, 0.2, 0.1), density=2000.0)
            other.add_wheel((0, 0, 1), 0.001, speed, torque=0.01)
            ends.append(nutate.solve(other, omega0=(0.1, 0.2, 1.0), t_span=(0, 2), **STEPS).omega[-1])
        np.testing.assert_allclose(solution.sensitivity(2.0)[1][:, 0], (ends[1] - ends[0]) / 2e-3, rtol=0, atol=1e-9)
        # Inside of steps by a run to there.
        self.assertTrue(np.all(np.isfinite(solution.sensitivity([0.51, 1.013])[0])))

    def test_a_stepper_is_as_before(self):
        free = nutate.Scene(None, "free.key=body.mass", text=TOP)
        stepper = nutate.Stepper(free)
        twin = copy.copy(stepper)
        twin.differentiate(free)
        twin.set_columns("sensitivities")
        again = pickle.loads(pickle.dumps(twin))
        columns = twin.run_to(0.5, times=[0.25, 0.5])
        self.assertEqual(list(columns)[:2], ["t", "d_rotation1/d_body.mass"])
        for name, values in again.run_to(0.5, times=[0.25, 0.5]).items():
            np.testing.assert_array_equal(values, columns[name])
        np.testing.assert_array_equal(columns["t"], [0.25, 0.5])
        twin.set_columns("quaternion", "angular_velocity", "energy", "constraints")
        first, second = stepper.run_to(1.0), twin.run_to(1.0)
        self.assertEqual(list(first), list(second))
        self.assertAlmostEqual(first["q1"][-1], second["q1"][-1], delta=1e-12)
        with self.assertRaisesRegex(nutate.NutateValueError, "the scene has no free parameters"):
            stepper.differentiate(nutate.Scene(text=TOP))
        with self.assertRaisesRegex(nutate.NutateValueError, "nutate_stepper_differentiate|need free parameters"):
            nutate.Stepper(nutate.Scene(text=TOP)).set_columns("sensitivities")


class ChaosTest(unittest.TestCase):
    """Indicators of chaos."""

    def setUp(self):
        self.scene = nutate.Scene(text=TOP.replace("end_time = 1.0", "end_time = 20.0") + "&chaos exponents = 6 /\n"
                                  "&output columns = 'quaternion', 'lyapunov', 'megno', 'fli' /\n")

    def test_runs_of_scenes_have_them(self):
        history = self.scene.run()
        self.assertEqual(history.exponents.shape, (6,))
        np.testing.assert_array_equal(history.exponents, [history[f"lyapunov{i}"][-1] for i in range(1, 7)])
        self.assertEqual((history.megno, history.fli), (history["megno"][-1], history["fli"][-1]))
        plain = nutate.Scene(text=TOP).run()
        self.assertEqual((plain.exponents, plain.megno, plain.fli), (None, None, None))

    def test_solutions_and_steppers_have_them(self):
        history = self.scene.run()
        solution = nutate.solve(self.scene, **STEPS)
        # The attitude of the start is normalised again.
        np.testing.assert_allclose(solution.exponents, history.exponents, rtol=0, atol=1e-12)
        np.testing.assert_allclose((solution.megno, solution.fli), (history.megno, history.fli), rtol=1e-12)
        self.assertIsNone(nutate.solve(nutate.Scene(text=TOP)).exponents)
        # A method that is left open can carry what they need.
        self.assertGreater(nutate.solve(self.scene, accuracy=1e-5).fli, 1.0)
        stepper = nutate.Stepper(nutate.System(scene=self.scene), **STEPS)
        stepper.set_state(*self.scene.initial)
        stepper.follow_chaos(self.scene)
        again = pickle.loads(pickle.dumps(stepper))
        for one in (stepper, again):
            np.testing.assert_array_equal(one.run_to(20.0).exponents, solution.exponents)

    def test_a_stepper_that_follows_none_chooses_its_method_again(self):
        stepper = nutate.Stepper(nutate.System(scene=self.scene), accuracy=1e-6)
        stepper.set_state(*self.scene.initial)
        stepper.run_to(1.0)
        chosen = stepper.get("method"), stepper.get("choice")
        for scene, exponents in ((self.scene, 6), (nutate.Scene(text=TOP), None)):
            stepper.follow_chaos(scene)
            history = stepper.run_to(stepper.time + 1.0)
            self.assertEqual(history.exponents if exponents is None else len(history.exponents), exponents)
        self.assertEqual((stepper.get("method"), stepper.get("choice")), chosen)

    def test_they_and_derivatives_pass_events_of_a_series(self):
        text = ("&body inertia = 3, 4, 5 / &torque space = 0.1, 0.2, 0.3 / &initial angular_velocity = 0.1, 0.7, 1 /\n"
                "&event when = 'q3', crosses = 0.3 / &integrator method = 'taylor', end_time = 2, ")
        for more in ("&chaos /", "&free key = 'initial.angular_velocity' / &output columns = 'sensitivities' /"):
            times = [nutate.Scene(text=text + goal + " /\n" + more + "\n").run().events[0].t
                     for goal in ("accuracy = 1e-9", "local_tolerance = 1e-9", "time_step = 0.02")]
            np.testing.assert_allclose(times, times[2], rtol=0, atol=1e-8)

    def test_free_numbers_stand_beside_them(self):
        plain, both = nutate.solve(self.scene, **STEPS), nutate.solve(self.scene, free=["body.mass"], **STEPS)
        np.testing.assert_array_equal(plain.q, both.q)
        np.testing.assert_allclose(both.exponents, plain.exponents, rtol=0, atol=1e-12)
        scene = nutate.Scene(text=TOP.replace("end_time = 1.0", "end_time = 20.0"))
        np.testing.assert_allclose(both.sensitivity(19.99)[1], nutate.solve(scene, free=["body.mass"], **STEPS).sensitivity(19.99)[1],
                                   rtol=1e-9)


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
        text = TOP + "&orbit altitude = 5e5, eccentricity = 0, frame = 'lvlh' /\n&free key = 'orbit.eccentricity' /\n"
        with self.assertRaisesRegex(nutate.NutateError, ":6: the motion has no derivative with respect to orbit.eccentricity"):
            nutate.Scene(text=text, name="circle.nml").run()


if __name__ == "__main__":
    unittest.main()
