"""nutate.solve: a motion from start to end in one call."""

import contextlib
import io
import math
import os
import pickle
import sys
import unittest
import unittest.mock
import warnings

import numpy as np

import nutate
from nutate.tables import unit_of
from test_nutate import BOX, SCENES

FLIP = 0.9664094834075236  # first time at which omega3 of the box is 0, s


def make_box():
    """The box of scenes/box.nml."""
    return nutate.System(shape="box", size=(4, 1, 2), mass=12)


def distance(a, b):
    """Largest angle between attitudes, rad."""
    return max(nutate.attitude_distance(x, y) for x, y in zip(a, b))


class SolveTest(unittest.TestCase):
    """Against exact motions, and against what it says of itself."""

    def test_every_method_keeps_its_accuracy_between_steps_too(self):
        times = np.linspace(0, 5, 97)
        q, omega = nutate.exact_free_body(make_box(), (1, 0, 0, 0), (0.1, 0, 10), times)
        for method, accuracy in (("auto", 1e-8), ("taylor", 1e-10), ("dop853", 1e-7), ("rk8", 1e-7), ("nielsen_krenk", 1e-6),
                                 ("rk4", 1e-4)):
            solution = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 5), accuracy=accuracy, method=method)
            found_q, found_omega = solution.sol(times)
            self.assertLess(distance(found_q, q), accuracy, method)
            self.assertLess(np.abs(found_omega - omega).max(), 10 * accuracy, method)
            self.assertEqual((solution.status, solution.success, solution.t[-1]), (0, True, 5.0))
            self.assertEqual((solution.q.shape, solution.omega.shape), ((len(solution.t), 4), (len(solution.t), 3)))
            self.assertEqual(solution.method, "exact" if method == "auto" else method)
            self.assertLessEqual(solution.errors["attitude"], accuracy)

    def test_between_steps_the_account_is_that_of_the_steps(self):
        system = nutate.System(moments=(1, 1, 0.5), mass=1, center_of_mass=(0, 0, 1))
        system.add("gravity")
        system.add("damping", coefficient=(0.1, 0.1, 0.1))
        for settings in ({"method": "nielsen_krenk", "accuracy": 1e-6}, {"accuracy": 1e-9}, {"time_step": 0.01}):
            solution = nutate.solve(system, omega0=(0, 1, 20), t_span=(0, 2), **settings)
            rows = solution.sol.rows(np.linspace(0, 2, 33))
            self.assertLess(rows["work"][-1], -1)
            self.assertLess(np.abs(rows["energy_residual"]).max(), 1e-11)
            self.assertLess(np.abs(rows["norm_error"]).max(), 1e-14)
            for name, values in solution.sol.rows(solution.t).items():
                np.testing.assert_array_equal(values, solution[name])

    def test_looking_inside_takes_each_step_again_once(self):
        calls = [0]

        def spin_down(t, q, omega):
            calls[0] += 1
            return -0.1 * omega

        system = nutate.System(moments=(1, 2, 2.5))
        system.add_user_torque(spin_down)
        times = np.linspace(0, 10, 400)
        # Evaluations of a step, and steps that it is taken again in.
        for method, accuracy, stages, parts in (("dop853", 1e-8, 12, 1), ("rk8", 1e-8, 12, 2), ("rk4", 1e-5, 4, 2)):
            solution = nutate.solve(system, omega0=(1, 2, 3), t_span=(0, 10), method=method, accuracy=accuracy)
            calls[0] = 0
            q, omega = solution.sol(times)
            self.assertLessEqual(calls[0], stages * (len(times) + parts * solution.n_steps), method)
            # Where a step ends, what is inside comes to what was there.
            before, after = solution.sol(np.nextafter(solution.t[1:], 0)), solution.sol(solution.t[1:])
            self.assertLess(distance(before[0], after[0]), 1e-11, method)
            reference = nutate.solve(system, omega0=(1, 2, 3), t_span=(0, 10), t_eval=times, method="dop853", accuracy=1e-12,
                                     dense_output=False)
            self.assertLess(distance(q, reference.q), accuracy, method)
            self.assertLess(np.abs(omega - reference.omega).max(), 10 * accuracy, method)

    def test_wheels_and_held_commands_go_with_the_motion(self):
        wheel = nutate.System(moments=(90, 100, 40))
        wheel.add_wheel((1, 2, 2), 0.05, 30.0, friction=1e-3, torque=0.2, frequency=0.05)
        held = nutate.System(moments=(90, 100, 40))
        held.add("controller", law="quaternion", by="torque", attitude_gain=0.02, rate_gain=0.2, sample=1.7)
        times = np.linspace(0, 30, 40)
        for system, settings in ((wheel, {"method": "dop853", "accuracy": 1e-8}), (wheel, {"time_step": 0.3, "order": 6}),
                                 (held, {"method": "dop853", "local_tolerance": 1e-9}), (held, {"time_step": 0.05, "order": 6})):
            solution = nutate.solve(system, omega0=(0.02, -0.01, 0.3), t_span=(0, 30), **settings)
            rows = nutate.solve(system, omega0=(0.02, -0.01, 0.3), t_span=(0, 30), t_eval=times, dense_output=False,
                                method="dop853", time_step=0.02)
            q, omega = solution.sol(times)
            self.assertLess(distance(q, rows.q), 1e-7, settings)
            self.assertLess(np.abs(omega - rows.omega).max(), 1e-8, settings)

    def test_max_step_finds_a_narrow_pulse(self):
        system = nutate.System(moments=(1, 1, 1))
        system.add_user_torque(lambda t, q, omega: (2.0 * (abs(t - 5.0) < 0.005), 0.0, 0.0))
        for method in ("dop853", "rk8"):
            for limit, gained in (({}, 0.0), ({"max_step": 0.002}, 0.02)):
                solution = nutate.solve(system, omega0=(0.1, 0, 0), t_span=(0, 10), method=method, local_tolerance=1e-6, **limit)
                # An edge of the pulse lies inside of a step: the impulse is good to a step.
                self.assertAlmostEqual(solution.omega[-1][0], 0.1 + gained, delta=4e-3 if limit else 1e-12)

    def test_the_balance_closes_with_time_dependent_potentials(self):
        system = nutate.System(moments=(90, 100, 40))
        system.add("orbit", semi_major_axis=7e6, eccentricity=0.1)
        system.add("gravity_gradient")
        solution = nutate.solve(system, omega0=(0.01, 0.02, 0.03), t_span=(0, 1500), accuracy=1e-8, method="dop853")
        rows = solution.sol.rows(np.linspace(0, 1500, 23))
        self.assertGreater(np.ptp(rows["total"]), 1e-9)
        self.assertLess(np.abs(rows["energy_residual"]).max(), 1e-12)

    def test_an_accuracy_out_of_reach_is_told(self):
        def spin_down(t, q, omega):
            return -0.1 * omega

        system = nutate.System(moments=(1, 2, 2.5))
        system.add_user_torque(spin_down)
        with self.assertWarnsRegex(nutate.NutateAccuracyWarning, "not attainable") as caught:
            solution = nutate.solve(system, omega0=(1, 2, 3), t_span=(0, 20), accuracy=1e-16)
        self.assertEqual(os.path.basename(caught.filename), os.path.basename(__file__))
        self.assertEqual((solution.success, solution.status, solution.accuracy_reached), (True, 0, False))
        self.assertIn("the accuracy was not", solution.message)
        self.assertGreater(solution.errors["attitude"], 1e-16)
        with self.assertWarns(nutate.NutateAccuracyWarning):
            stepper = nutate.Stepper(system, method="dop853", accuracy=1e-16)
            stepper.set_state(q=(1, 0, 0, 0), omega=(1, 2, 3))
            history = stepper.run_to(20)
        self.assertFalse(history.accuracy_reached)
        np.testing.assert_array_equal((history.estimated_error, history.round_off), stepper.estimated_error)
        settings = ("integrator.method=taylor", "-integrator.order", "-integrator.formulation", "integrator.end_time=20")
        with self.assertWarns(nutate.NutateAccuracyWarning) as caught:
            history = nutate.run(BOX, *settings, "integrator.accuracy=1e-16")
        self.assertEqual(os.path.basename(caught.filename), os.path.basename(__file__))
        self.assertFalse(history.accuracy_reached)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.assertTrue(nutate.run(BOX, *settings, "integrator.accuracy=1e-6").accuracy_reached)
            self.assertIsNone(nutate.run(BOX, "integrator.end_time=1").accuracy_reached)
            solution = nutate.solve(system, omega0=(1, 2, 3), t_span=(0, 1), accuracy=1e-8)
            self.assertEqual((solution.accuracy_reached, solution.message), (True, "the end was reached"))
            self.assertIsNone(nutate.solve(system, omega0=(1, 2, 3), t_span=(0, 1), time_step=0.1).accuracy_reached)

    def test_torques_are_called_inside_of_the_run_only(self):
        def torque(t, q, omega):
            if not start <= t <= end:
                raise ValueError(f"{t!r} is outside of {start} to {end}")
            return np.array([math.sqrt(t - start), -0.2 * t, 0.1])

        for start, end in ((0.0, 1.7), (0.3, 2.0)):
            system = nutate.System(moments=(1, 2, 2.5))
            system.add_user_torque(torque)
            for method in ("auto", "dop853", "rk4", "nielsen_krenk"):
                for settings in ({"accuracy": 1e-7}, {"local_tolerance": 1e-7}, {"time_step": 0.01}):
                    if method == "auto" and "accuracy" not in settings:
                        continue
                    for order in (2, 4, 6, 8) if method == "nielsen_krenk" else (0,):
                        with self.subTest(method, start=start, order=order, **settings):
                            given = {**settings, "order": order} if order else settings
                            nutate.solve(system, omega0=(0.3, 0.2, 0.1), t_span=(start, end), method=method, **given)

    def test_rows_at_times_of_ones_own_are_those_of_the_motion(self):
        times = [0.0, 0.3, 1.75, 2.0]
        for dense in (True, False):
            solution = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 2), t_eval=times, method="taylor",
                                    dense_output=dense)
            np.testing.assert_array_equal(solution.t, times)
            q, omega = nutate.exact_free_body(make_box(), (1, 0, 0, 0), (0.1, 0, 10), times)
            self.assertLess(distance(solution.q, q), 1e-8)
            if not dense:
                with self.assertRaisesRegex(nutate.NutateValueError, "no dense output .expected solve"):
                    solution.sol
            self.assertEqual(list(solution.energy), ["kinetic", "potential", "total", "work", "energy_residual"])
            for name, values in solution.energy.items():
                np.testing.assert_array_equal(values, solution[name])

    def test_a_motion_goes_back_in_time(self):
        there = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(2, 5), method="taylor")
        back = nutate.solve(make_box(), there.q[-1], there.omega[-1], (5, 2), t_eval=[4.5, 3, 2], method="taylor")
        np.testing.assert_array_equal(back.t, [4.5, 3, 2])
        self.assertLess(distance(back.q, there.sol(back.t)[0]), 4e-8)
        self.assertEqual((back.sol.t_min, back.sol.t_max), (2, 5))

    def test_errors_are_those_of_the_rows(self):
        top = nutate.System(moments=(1, 1, 0.5), mass=1, center_of_mass=(0, 0, 1))
        top.add("gravity")
        solution = nutate.solve(top, (np.cos(0.2), np.sin(0.2), 0, 0), (0, 0, 30), (0, 3))
        scale = (solution["kinetic"] + np.abs(solution["potential"])).max()
        self.assertEqual(solution.errors["energy"], np.abs(solution["energy_residual"]).max() / scale)
        self.assertEqual(solution.errors["norm"], np.abs(solution["norm_error"]).max())
        momentum = np.linalg.norm([solution[name] for name in ("l_x", "l_y", "l_z")], axis=0).max()
        # Lengths are taken of components that are scaled: two roundings.
        np.testing.assert_allclose(solution.errors["momentum"], np.abs(solution["l_z"] - solution["l_z"][0]).max() / momentum, rtol=4.5e-16)
        still = nutate.solve(make_box(), omega0=(0, 0, 0), t_span=(0, 1), time_step=0.1)
        self.assertEqual((still.errors["energy"], still.errors["momentum"]), (0, 0))
        self.assertLess(solution.errors["momentum"], 1e-12)
        self.assertGreater(np.ptp(solution["l_x"]), 0.1)
        self.assertTrue(np.isnan(nutate.solve(top, omega0=(0, 0, 30), t_span=(0, 1), time_step=0.01).errors["attitude"]))

    def test_names_of_other_packages_are_explained(self):
        for name in ("rtol", "atol"):
            with self.assertRaisesRegex(nutate.NutateValueError, f"no {name} .did you mean accuracy"):
                nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 1), **{name: 1e-6})
        free = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 1), method="taylor", max_step=0.01)
        self.assertLessEqual(np.diff(free.t).max(), 0.01 + 1e-15)

    def test_progress_changes_nothing(self):
        plain = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 5))
        for modules in ({"tqdm.auto": None, "tqdm": None}, {}):
            with unittest.mock.patch.dict(sys.modules, modules), contextlib.redirect_stderr(io.StringIO()) as said:
                shown = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 5), progress=True)
            np.testing.assert_array_equal(shown.q, plain.q)
            self.assertRegex(said.getvalue(), r"solve: \d")

    def test_a_column_is_an_event(self):
        both = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 5), events=["omega3", lambda t, q, omega: omega[2]])
        np.testing.assert_allclose(both.t_events[0], both.t_events[1], atol=1e-9)
        one = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 5), events="omega3")
        np.testing.assert_allclose(one.t_events, both.t_events[:1], atol=1e-12)
        self.assertEqual({event.name for event in one.events}, {"omega3"})
        for wrong in ("omega4", [3]):
            self.assertRaises(nutate.NutateValueError, nutate.solve, make_box(), omega0=(0, 0, 1), t_span=(0, 1), events=wrong)

    def test_events_of_scenes_are_located(self):
        text = ("! a comment with &event when = 'omega1' /\n&scene title = '&event / in a title' /\n&body shape = 'box', size = 4, 1, 2, mass "
                "= 12 /\n&initial angular_velocity = 0.1, 0, 10 /\n&integrator accuracy = 1e-8, end_time = 50 /\n"
                "&EVENT name = 'flip', when = 'omega3', crosses = 0 ! a slash / here\n count = 2 /\n")
        scene = nutate.Scene(text=text)
        self.assertEqual(len(scene.event_groups), 1)
        solution = nutate.solve(scene, events="omega1")
        flips = [event for event in solution.events if event.name == "flip"]
        np.testing.assert_allclose([event.t for event in flips], [event.t for event in nutate.Scene(text=text).run().events], atol=1e-7)
        self.assertEqual((len(flips), solution.status, solution.t[-1]), (2, 1, flips[-1].t))
        self.assertIn("'flip' ended the motion", solution.message)
        switching = text.replace("count = 2", "switch = 'x toggle'") + "&torque name = 'x', body = 0, 0, 1 /\n"
        with self.assertRaisesRegex(nutate.NutateValueError, "switch effects"):
            nutate.solve(nutate.Scene(text=switching))

    def test_axes_and_rotations_are_what_set_state_takes(self):
        q = np.array([0.8, 0.0, 0.6, 0.0])
        body = nutate.solve(make_box(), q, nutate.rotate_to_body(q, (0.1, 0, 10)), (0, 1))
        space = nutate.solve(make_box(), q, (0.1, 0, 10), (0, 1), frame="space")
        np.testing.assert_allclose(space.q, body.q, atol=1e-13)

    def test_a_scene_gives_what_is_not_given(self):
        scene = nutate.Scene(os.path.join(SCENES, "heavy_top.nml"), "integrator.end_time=0.5")
        solution = nutate.solve(scene)
        np.testing.assert_array_equal(solution.q[0], scene.initial[0])
        self.assertEqual(solution.t[-1], 0.5)
        history = nutate.run(os.path.join(SCENES, "heavy_top.nml"), "integrator.end_time=0.5", "integrator.accuracy=1e-9",
                             "integrator.method=taylor", "-integrator.order", "-integrator.formulation")
        self.assertLess(nutate.attitude_distance(solution.q[-1], [history[f"q{i}"][-1] for i in range(4)]), 2e-8)

    def test_strong_damping_is_told_by_the_duration(self):
        system = nutate.System(moments=(1, 2, 2.5))
        system.add("damping", coefficient=(1e4, 1e4, 1e4))
        self.assertNotEqual(nutate.solve(system, omega0=(1, 2, 3), t_span=(0, 1e-3), accuracy=1e-4).method, "nielsen_krenk")
        self.assertEqual(nutate.solve(system, omega0=(1, 2, 3), t_span=(0, 1e4), accuracy=1e-4).method, "nielsen_krenk")

    def test_a_solution_is_pickled_with_its_motion(self):
        solution = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 1), method="taylor")
        again = pickle.loads(pickle.dumps(solution))
        np.testing.assert_array_equal(again.sol(0.123)[0], solution.sol(0.123)[0])
        self.assertEqual(repr(again), repr(solution))
        self.assertIn("steps of taylor: the end was reached", repr(solution))

    def test_what_cannot_be_is_refused(self):
        for wrong in (dict(t_span=(0, 1)), dict(omega0=(0, 0, 1)), dict(omega0=(0, 0, 1), t_span=(0, 1), t_eval=[0.5, 0.2]),
                      dict(omega0=(0, 0, 1), t_span=(0, 1), t_eval=[1.5]), dict(omega0=(0, 0), t_span=(0, 1)),
                      dict(omega0=(0, 0, 1), t_span=(0, 1), accuracy=2), dict(omega0=(0, 0, 1), t_span=(0, 1), method="euler"),
                      dict(omega0=(0, 0, 1), t_span=(0, 1, 2)), dict(omega0=(0, 0, 1), t_span=(0, np.inf))):
            with self.subTest(wrong=wrong), self.assertRaises(nutate.NutateValueError):
                nutate.solve(make_box(), **wrong)
        solution = nutate.solve(make_box(), omega0=(0, 0, 1), t_span=(0, 1))
        for outside in (-0.1, 1.1, np.nan):
            with self.assertRaises(nutate.NutateValueError):
                solution.sol(outside)
        with self.assertRaisesRegex(nutate.NutateValueError, r"t has shape \(1, 2\)"):
            solution.sol([[0.1, 0.2]])


class EventTest(unittest.TestCase):
    """Functions that are 0 where something happens."""

    def test_times_are_exact(self):
        for settings in ({}, {"method": "taylor"}, {"method": "dop853"}, {"time_step": 0.01, "order": 8}):
            solution = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 6), events=lambda t, q, omega: omega[2], **settings)
            np.testing.assert_allclose(solution.t_events[0], FLIP * np.array([1, 3, 5]), atol=1e-8)
            self.assertLess(np.abs(solution.omega_events[0][:, 2]).max(), 1e-11)
            self.assertEqual((solution.q_events[0].shape, solution.status), ((3, 4), 0))

    def test_direction_and_terminal_are_heeded(self):
        def falling(t, q, omega):
            return omega[2]

        def last(t, q, omega):
            return t - 10.0

        falling.direction, falling.terminal = -1, 2
        solution = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 50), method="taylor", events=[last, falling])
        np.testing.assert_allclose(solution.t_events[1], FLIP * np.array([1, 5]), atol=1e-7)
        self.assertEqual((len(solution.t_events[0]), solution.status), (0, 1))
        self.assertIn("falling", solution.message)
        self.assertEqual(solution.t[-1], solution.t_events[1][-1])
        self.assertLess(abs(solution.omega[-1, 2]), 1e-11)
        self.assertTrue(np.all(np.diff(solution.t) > 0))
        some = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 50), method="taylor", events=[last, falling],
                            t_eval=np.arange(50.0))
        np.testing.assert_array_equal(some.t, np.arange(5.0))

    def test_the_start_is_no_event(self):
        solution = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 1), events=lambda t, q, omega: t)
        self.assertEqual(len(solution.t_events[0]), 0)
        for settings in ({}, {"method": "dop853"}, {"time_step": 0.25}, {"t_eval": [1.0], "dense_output": False}):
            for span in ((0, 1), (2, 1)):
                touched = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=span, events=lambda t, q, omega: t - 1.0, **settings)
                np.testing.assert_array_equal(touched.t_events[0], [1.0])

    def test_two_changes_of_sign_near_each_other_are_two_events(self):
        for settings in ({}, {"method": "taylor"}, {"method": "dop853"}, {"time_step": 0.05, "order": 8}):
            near = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 2), events=lambda t, q, omega: (t - 0.5) ** 2 - 1e-8,
                                **settings)
            np.testing.assert_allclose(near.t_events[0], (0.4999, 0.5001), atol=1e-11)

    def test_jumps_and_kinks_are_found_where_they_are(self):
        solution = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 6),
                                events=[lambda t, q, omega: float(omega[2] > 0) - 0.5, lambda t, q, omega: abs(omega[2]) - 3.0,
                                        lambda t, q, omega: omega[2] - 3.0, lambda t, q, omega: omega[2] + 3.0])
        np.testing.assert_allclose(solution.t_events[0], FLIP * np.array([1, 3, 5]), atol=1e-8)
        np.testing.assert_allclose(solution.t_events[1], np.sort(np.concatenate(solution.t_events[2:])), atol=1e-9)

    def test_none_is_missed_of_motions_drawn_at_random(self):
        random = np.random.default_rng(31)
        happened = 0
        for i in range(40):
            system = nutate.System(moments=random.uniform(1, 1.9, 3), mass=1, center_of_mass=random.uniform(-0.3, 0.3, 3))
            if i % 2:
                system.add("gravity")
            form, slope, value = random.normal(size=(4, 4)), random.normal(size=3, scale=0.2), random.normal(scale=0.3)

            def event(t, q, omega):
                return q @ form @ q / (q @ q) + slope @ omega - value

            settings = ({}, {"method": "taylor"}, {"method": "dop853"}, {"time_step": 0.05, "order": 6})[i // 2 % 4]
            q0, omega0 = random.normal(size=4), random.normal(size=3, scale=3)
            solution = nutate.solve(system, q0 / np.linalg.norm(q0), omega0, (0, 10 * (-1) ** (i // 8)), events=event, **settings)
            times = np.linspace(0, solution.t[-1], 1501)
            signs = np.sign([event(*state) for state in zip(times, *solution.sol(times))])
            found = np.histogram(np.abs(solution.t_events[0]), np.abs(times))[0]
            np.testing.assert_array_equal(found % 2, signs[1:] != signs[:-1], f"motion {i}")
            happened += len(solution.t_events[0])
            for state in zip(solution.t_events[0], solution.q_events[0], solution.omega_events[0]):
                self.assertLess(abs(event(*state)), 1e-9)
        self.assertGreater(happened, 200)

    def test_the_n_th_ends_the_motion_backward_too(self):
        def event(t, q, omega):
            return omega[2]

        forward = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 12), events=event)
        for direction, place in ((0, 3), (1, 4), (-1, 6)):
            event.direction, event.terminal = direction, 4 if direction == 0 else 3 if direction < 0 else 2
            back = nutate.solve(make_box(), forward.q[-1], forward.omega[-1], (12, 0), events=event)
            self.assertEqual((back.status, back.t[-1]), (1, back.t_events[0][-1]))
            every = forward.t_events[0][::-1]
            first = 0 if direction == 0 or direction * forward.omega[-1, 2] < 0 else 1
            expected = every[first::1 if direction == 0 else 2][:event.terminal]
            np.testing.assert_allclose(back.t_events[0], expected, atol=1e-6)
            self.assertEqual(len(back.sol.rows(back.t)["t"]), back.n_steps + 1)

    def test_what_an_event_raises_comes_out_with_the_rows(self):
        for raised in (ZeroDivisionError, KeyboardInterrupt):
            def fail(t, q, omega):
                if t > 0.6:
                    raise raised
                return omega[2]

            for settings in ({}, {"time_step": 0.05}, {"method": "dop853"}):
                with self.assertRaises(raised) as caught:
                    nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 1), events=fail, **settings)
                times = caught.exception.history["t"]
                self.assertTrue(0.3 < times[-1] <= 0.6 and len(times) > 1, settings)
        with self.assertRaisesRegex(nutate.NutateValueError, "expected a number"):
            nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 1), events=lambda t, q, omega: None)

    def test_a_step_that_fails_ends_the_motion_and_says_why(self):
        system = nutate.System(moments=(1, 2, 2.5))
        system.add_user_torque(lambda t, q, omega: np.full(3, np.nan if t > 0.5 else 0.0))
        solution = nutate.solve(system, omega0=(1, 2, 3), t_span=(0, 1), time_step=0.1)
        self.assertEqual((solution.status, solution.success), (-1, False))
        self.assertAlmostEqual(solution.t[-1], 0.5)
        self.assertIn("not finite", solution.message)
        self.assertEqual(solution.sol(0.25)[0].shape, (4,))


class TableTest(unittest.TestCase):
    """pandas and xarray in one call."""

    def setUp(self):
        self.solution = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 1), t_eval=np.linspace(0, 1, 5))
        self.history = nutate.run(BOX, "integrator.end_time=1", "output.columns='euler','angular_velocity_space'")

    def test_pandas(self):
        try:
            import pandas
        except ImportError:
            self.skipTest("pandas is not there")
        frame = self.solution.to_pandas()
        self.assertIsInstance(frame, pandas.DataFrame)
        np.testing.assert_array_equal(frame.index, self.solution.t)
        np.testing.assert_array_equal(frame["omega3"], self.solution.omega[:, 2])
        self.assertEqual(frame.attrs["units"]["total"], "J")
        self.assertEqual(list(nutate.to_pandas(self.history)), ["omega_x", "omega_y", "omega_z", "phi", "theta", "psi"])

    def test_units_of_covariances(self):
        for name, unit in (("covariance_rotation1_rotation2", "rad2"), ("covariance_rotation3_omega1", "rad2/s"),
                           ("covariance_omega2_omega2", "rad2/s2"), ("covariance_rotation1_deg_omega3_deg", "deg2/s"),
                           ("sigma_omega1_deg", "deg/s"), ("d_omega1_deg/d_body.inertia.1", "deg/s per unit")):
            self.assertEqual(unit_of(name), unit)

    def test_xarray(self):
        try:
            import xarray
        except ImportError:
            self.skipTest("xarray is not there")
        data = self.solution.to_xarray()
        self.assertIsInstance(data, xarray.Dataset)
        np.testing.assert_array_equal(data["q"], self.solution.q)
        np.testing.assert_array_equal(data["omega"].sel(body_axis=3), self.solution.omega[:, 2])
        self.assertEqual((data["omega"].attrs["units"], data["total"].attrs["units"]), ("rad/s", "J"))
        self.assertEqual(nutate.to_xarray(self.history)["omega_space"].dims, ("t", "space_axis"))


if __name__ == "__main__":
    unittest.main()
