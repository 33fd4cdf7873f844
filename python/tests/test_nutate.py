"""The Python package: the numbers of the program bit for bit, callbacks, misuse. $NUTATE names the program."""

import csv
import ctypes
import gc
import glob
import itertools
import os
import subprocess
import tempfile
import threading
import unittest

import numpy as np

import nutate

SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes")
BOX = os.path.join(SCENES, "box.nml")


def make_box(**settings):
    """The box of scenes/box.nml, ready to step."""
    system = nutate.System(shape="box", size=(4, 1, 2), mass=12)
    stepper = nutate.Stepper(system, **{"time_step": 0.01, **settings})
    stepper.set_state(q=(1, 0, 0, 0), omega=(0.1, 0, 10))
    return stepper


def read_csv(path):
    """Columns of a CSV file."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    return dict(zip(rows[0], np.array(rows[1:], dtype=float).T))


class ProgramTest(unittest.TestCase):
    """What the program computes, Python computes."""

    def test_every_scene_gives_the_bits_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            for scene in sorted(glob.glob(os.path.join(SCENES, "*.nml"))):
                path = os.path.join(folder, "program.csv")
                subprocess.run([os.environ["NUTATE"], "run", scene, "--quiet", "--output", path], check=True)
                expected, found = read_csv(path), nutate.run(scene)
                self.assertEqual(list(expected), list(found), scene)
                for name, values in expected.items():
                    np.testing.assert_array_equal(found[name], values, f"{scene}: {name}")

    def test_overrides_are_those_of_the_program(self):
        history = nutate.run(BOX, "integrator.end_time=1", "output.columns='energy'")
        self.assertEqual(list(history), ["t", "kinetic", "potential", "total", "work", "energy_residual"])
        self.assertEqual(len(history["t"]), 101)
        self.assertEqual(history["t"][-1], 1.0)

    def test_stepping_gives_the_bits_of_the_scene(self):
        scene = nutate.run(BOX, "integrator.end_time=2")
        stepper = make_box()
        rows = stepper.run(200)
        for name in ("q0", "q1", "q2", "q3", "omega1", "omega2", "omega3"):
            np.testing.assert_array_equal(rows[name], scene[name][1:], name)
        by_hand = make_box()
        for _ in range(200):
            by_hand.step(0.01)
        np.testing.assert_array_equal(by_hand.quaternion, stepper.quaternion)

    def test_a_scene_can_be_stepped_and_written(self):
        scene = nutate.Scene(BOX, "integrator.end_time=0.5")
        self.assertIn("box", scene.title)
        stepper = nutate.Stepper(scene)
        stepper.run(50)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "box.csv")
            scene.write(path)
            self.assertEqual(read_csv(path)["omega2"][-1], stepper.angular_velocity[1])


class StepperTest(unittest.TestCase):
    """What a stepper says of its state."""

    def test_quantities_agree_with_each_other(self):
        stepper = make_box(order=4, formulation="reduced")
        stepper.steps(0.01, 100)
        rotation = stepper.matrix
        np.testing.assert_allclose(rotation @ stepper.angular_momentum, stepper.angular_momentum_space, rtol=1e-14, atol=1e-12)
        np.testing.assert_allclose(rotation @ stepper.angular_velocity, stepper.angular_velocity_space, rtol=1e-14, atol=1e-13)
        np.testing.assert_allclose(stepper.angular_momentum, (5, 20, 17) * stepper.angular_velocity, rtol=1e-14, atol=1e-12)
        self.assertAlmostEqual(stepper.time, 1.0, delta=1e-14)
        self.assertLess(abs(stepper.energy[4]), 1e-13 * stepper.energy[2])
        self.assertLess(abs(stepper.constraints).max(), 1e-12)
        self.assertEqual(stepper.euler.shape, (3,))
        self.assertEqual(stepper.conjugate_momentum.shape, (4,))

    def test_columns_are_those_chosen(self):
        stepper = make_box()
        stepper.set_columns("quaternion", "energy")
        rows = stepper.run(10, every=5)
        self.assertEqual(len(rows), 1 + 4 + 5)
        self.assertEqual(len(rows["total"]), 2)

    def test_angles_keep_the_turns_of_subdivided_steps(self):
        for effects in ((), (lambda t, q, omega: np.zeros(3),)):
            system = nutate.System(moments=(1, 1, 1.5))
            for torque in effects:
                system.add_user_torque(torque)
            stepper = nutate.Stepper(system, time_step=1.0)
            stepper.set_columns("euler")
            stepper.set_state(q=(1, 0, 0, 0), omega=(0, 0, 10))
            rows = stepper.run(3)
            # 10 rad a step in four parts, each of which the scheme turns by 4 atan(2.5/4).
            np.testing.assert_allclose(rows["phi"] + rows["psi"], 16 * np.arctan(0.625) * np.arange(1, 4), rtol=1e-14)

    def test_built_in_effects_act(self):
        system = nutate.System(moments=(5, 5, 1), mass=1, center_of_mass=(0, 0, 1))
        system.add("gravity", acceleration=(0, 0, -20))
        np.testing.assert_array_equal(system.inertia, np.diag((5.0, 5.0, 1.0)))
        stepper = nutate.Stepper(system)
        stepper.set_state(q=(1, 0, 0, 0), omega=(0, 0, 50))
        self.assertEqual(stepper.energy[1], 20.0)

    def test_a_stepper_with_a_new_state_is_as_good_as_a_new_stepper(self):
        texts = ("&body inertia = 2, 3, 4 /", "&body inertia = 2, 3, 4, mass = 1, center_of_mass = 0, 0, 0.3 / &gravity /",
                 "&body inertia_tensor = 2, 3, 4, 0.1, 0.2, 0.3 / &rotor momentum = 0.3, -0.4, 0.7 /",
                 "&body inertia = 2, 3, 4 / &damping coefficient = 0.05, 0.05, 0.02 / &torque body = 0.5, 0.2, 0.1, frequency = 0.3 /",
                 "&body inertia = 2, 3, 4 / &wheel axis = 1, 1, 0, inertia = 0.1, friction = 0.01 / &inner_sphere inertia = 0.2, damping = 0.05 /")
        methods = ({"method": name, "conserve": conserve} for name in ("rk4", "rk8", "dop853", "taylor") for conserve in (False, True))
        orders = ({"formulation": formulation, "order": order} for formulation in ("full", "reduced") for order in (2, 4))
        kinds = [*methods, *orders]
        generator = np.random.default_rng(7)
        for text, settings in itertools.product(texts, kinds):
            length = {"local_tolerance": 1e-7} if settings.get("method") in ("dop853", "taylor") else {"time_step": 0.03}
            steppers = [nutate.Stepper(nutate.System(text=text), **settings, **length) for _ in range(4)]
            used = steppers.pop()
            for i, new in enumerate(steppers):
                q, omega = generator.normal(size=4), generator.normal(size=3)
                if i == 1:
                    used.keep_steps()
                for stepper in (used, new):
                    stepper.set_state(q/np.linalg.norm(q), omega, t=0.1*i)
                    # A wheel's motor is set for one motion.
                    if i == 1 and "wheel" in text:
                        stepper.set_motor(0, 0.02)
                with self.subTest(text=text, settings=settings, i=i):
                    self.assertEqual(*(str({name: column.tolist() for name, column in stepper.run_to(1.0).items()}) for stepper in (used, new)))
                    self.assertEqual(used.energy.tolist(), new.energy.tolist())


class CallbackTest(unittest.TestCase):
    """Potentials and torques in Python."""

    def test_a_torque_of_python_does_what_the_built_in_one_does(self):
        coefficient = np.array([0.1, 0.2, 0.3])
        built_in = nutate.System(moments=(1, 2, 2.5))
        built_in.add("damping", coefficient=coefficient)
        own = nutate.System(moments=(1, 2, 2.5))
        own.add_user_torque(lambda t, q, omega: -coefficient * omega)
        states = []
        for system in (built_in, own):
            stepper = nutate.Stepper(system)
            stepper.set_state(q=(1, 0, 0, 0), omega=(1, 2, 3))
            stepper.steps(0.05, 100)
            states.append(stepper.angular_velocity)
            self.assertLess(abs(stepper.energy[4]), 1e-14)
        np.testing.assert_allclose(states[1], states[0], rtol=1e-12)

    def test_a_potential_that_returns_a_torque_is_rejected(self):
        for wrong in (lambda gamma: (0.0, 0.0, 1.0), lambda gamma: ((0.0, 0.0, 1.0), 1.0), lambda gamma: 1.0):
            system = nutate.System(moments=(1.0, 2.0, 2.5))
            system.add_potential((0, 0, 1), wrong)
            with self.assertRaisesRegex(nutate.NutateValueError, "expected its energy, a number, and its gradient"):
                nutate.solve(system, omega0=(1.0, 0.0, 0.0), t_span=(0.0, 1.0))

    def test_moments_of_no_body_are_rejected_in_words_of_python(self):
        with self.assertRaises(nutate.NutateError) as caught:
            nutate.System(moments=(3.0, 5.0, 9.0))
        self.assertIn("one exceeds the sum of the other two by 1.1E-01 of itself", str(caught.exception))
        self.assertNotIn("check_triangle", str(caught.exception))

    def test_single_steps_stop_where_the_inertia_is_that_of_no_rigid_body(self):
        body = nutate.System(moments=(1.0, 2.0, 2.5))
        body.add("inertia_rate", tensor=(0.0, 0.0, 0.2))
        for all_at_once in (False, True):
            stepper = nutate.Stepper(body, method="rk8", time_step=0.1)
            stepper.set_state(q=(1, 0, 0, 0), omega=(1.0, 0.3, 0.2))
            # The third moment reaches the sum of the others, 3 kg m2, at 2.5 s.
            with self.assertRaisesRegex(nutate.NutateError, "no rigid body"):
                if all_at_once:
                    stepper.steps(0.2, 15)
                for _ in range(15):
                    stepper.step(0.2)
            self.assertAlmostEqual(stepper.time, 2.4, delta=1e-9)

    def test_a_potential_of_python_conserves_energy_and_momentum(self):
        system = nutate.System(moments=(1, 2, 2.5))
        system.add_potential((0, 0, 1), lambda gamma: (gamma[0] ** 4, (4 * gamma[0] ** 3, 0, 0)),
                             lambda gamma: np.diag((12 * gamma[0] ** 2, 0, 0)))
        stepper = nutate.Stepper(system)
        stepper.set_state(q=(0.8, 0.6, 0, 0), omega=(1, 2, 3))
        momentum = stepper.angular_momentum_space[2]
        stepper.steps(0.1, 200)
        self.assertLess(abs(stepper.energy[4]), 1e-13)
        self.assertAlmostEqual(stepper.angular_momentum_space[2], momentum, delta=1e-13)

    def test_steps_without_a_proof_are_counted(self):
        free = nutate.Stepper(nutate.System(moments=(1, 2, 2.5)))
        free.set_state(q=(0.8, 0.6, 0, 0), omega=(1, 2, 3))
        free.steps(0.1, 5)
        self.assertEqual(free.uncertified_steps, 0)
        system = nutate.System(moments=(1, 2, 2.5))
        system.add_potential((0, 0, 1), lambda gamma: (gamma[0] ** 4, (4 * gamma[0] ** 3, 0, 0)))
        stepper = nutate.Stepper(system)
        stepper.set_state(q=(0.8, 0.6, 0, 0), omega=(1, 2, 3))
        stepper.steps(0.1, 5)
        self.assertEqual(stepper.uncertified_steps, 5)
        scene = nutate.Scene(text="&body inertia = 1, 2, 2.5 /\n&initial angular_velocity = 1, 2, 3 /\n"
                                  "&integrator time_step = 0.1, end_time = 0.7 /")
        scene.run()
        self.assertEqual(scene.uncertified_steps, 0)
        scene.add_potential((0, 0, 1), lambda gamma: (gamma[0] ** 4, (4 * gamma[0] ** 3, 0, 0)))
        scene.run()
        self.assertEqual(scene.uncertified_steps, 7)

    def test_bounds_prove_steps_and_change_no_digit(self):
        def quartic(gamma):
            return gamma[0] ** 4, (4 * gamma[0] ** 3, 0, 0)

        def push(t, q, omega):
            return 0.3 * np.cos(t), 0, 0

        states = []
        for of_potential, of_torque in (((4, 12, 24), (0.3, 0, 0, 1)), (None, (0.3, 0, 0, 1)), ((4, 12, 24), None)):
            expected = 0 if of_potential and of_torque else 5
            system = nutate.System(moments=(2, 3, 4))
            system.add_potential((0, 0, 1), quartic, bounds=of_potential)
            system.add_user_torque(push, bounds=of_torque)
            system.add("gravity_gradient", direction=(1, 0, 0), strength=0.01)
            stepper = nutate.Stepper(system)
            stepper.set_state(q=(0.8, 0.6, 0, 0), omega=(0.3, 0.2, 1))
            stepper.steps(0.02, 5)
            states.append(stepper.quaternion)
            self.assertEqual(stepper.uncertified_steps, expected)
            scene = nutate.Scene(text="&body inertia = 2, 3, 4 /\n&initial angular_velocity = 0.3, 0.2, 1 /\n"
                                      "&integrator time_step = 0.02, end_time = 0.1 /")
            scene.add_potential((0, 0, 1), quartic, bounds=of_potential)
            scene.add_user_torque(push, bounds=of_torque)
            scene.run()
            self.assertEqual(scene.uncertified_steps, expected)
        np.testing.assert_array_equal(states[0], states[1])
        np.testing.assert_array_equal(states[0], states[2])

    def test_bounds_that_are_none_are_refused_and_add_nothing(self):
        for owner in (nutate.System(moments=(1, 2, 2.5)), nutate.Scene(text="&body inertia = 1, 2, 2.5 /\n"
                      "&initial angular_velocity = 1, 2, 3 /\n&integrator time_step = 0.1, end_time = 0.2 /")):
            for bounds in ((1, 1), (1, 1, 1, 1, 1), 1, (1, -1, 1), (1, 1, np.nan), (np.inf, 1, 1), (1, 1e101, 1)):
                with self.subTest(bounds=bounds), self.assertRaises(ValueError):
                    owner.add_potential((0, 0, 1), lambda gamma: 1 / 0, bounds=bounds)
            for bounds in ((1, 1, 1), (1, 1, 1, -1), (np.nan, 1, 1, 1)):
                with self.subTest(bounds=bounds), self.assertRaises(ValueError):
                    owner.add_user_torque(lambda t, q, omega: 1 / 0, bounds=bounds)
            stepper = nutate.Stepper(owner)
            stepper.set_state(q=(1, 0, 0, 0), omega=(1, 2, 3))
            stepper.step(0.1)

    def test_an_exception_of_a_callback_comes_out_and_leaves_the_state(self):
        system = nutate.System(moments=(1, 2, 2.5))

        def torque(t, q, omega):
            if t > 0.5:
                raise ZeroDivisionError("on purpose")
            return -omega

        system.add_user_torque(torque)
        stepper = nutate.Stepper(system)
        stepper.set_state(q=(1, 0, 0, 0), omega=(1, 2, 3))
        with self.assertRaisesRegex(ZeroDivisionError, "on purpose"):
            stepper.steps(0.1, 100)
        self.assertAlmostEqual(stepper.time, 0.5, delta=1e-12)
        before = stepper.quaternion
        with self.assertRaises(ZeroDivisionError):
            stepper.step(0.1)
        np.testing.assert_array_equal(stepper.quaternion, before)

    def test_a_torque_that_jumps_is_named_and_dop853_runs(self):
        scene = nutate.Scene(BOX, "integrator.end_time=1")
        scene.add_user_torque(lambda t, q, omega: -20 * np.sign(omega))
        with self.assertRaisesRegex(nutate.NutateError, "effect 'callback' jumps: method 'dop853'"):
            scene.run()
        stepper = nutate.Stepper(scene)
        for function, arguments in ((stepper.run, (100,)), (stepper.steps, (0.01, 100))):
            with self.assertRaisesRegex(nutate.NutateError, "effect 'callback' jumps: method 'dop853'"):
                function(*arguments)
        stepper.set(method="dop853")
        before = stepper.time
        stepper.run(100)
        self.assertAlmostEqual(stepper.time, before + 1, delta=1e-12)

    def test_results_that_are_no_torque_are_refused(self):
        for result, error in ((None, (TypeError, ValueError)), ((1, 2), ValueError), (("a", 0, 0), ValueError), (np.array((1j, 0, 0)), ValueError),
                              ((np.nan, 0, 0), nutate.NutateError), ((1e200, 0, 0), nutate.NutateError)):
            system = nutate.System(moments=(1, 2, 2.5))
            system.add_user_torque(lambda t, q, omega, result=result: result)
            stepper = nutate.Stepper(system)
            with self.subTest(result=result), self.assertRaises(error):
                stepper.set_state(q=(1, 0, 0, 0), omega=(1, 2, 3))
                stepper.step(0.1)

    def test_what_a_callback_is_given_can_be_kept(self):
        system = nutate.System(moments=(1, 2, 2.5))
        kept, seen = [], []

        def torque(t, q, omega):
            kept.append((q, omega))
            seen.append((tuple(q), tuple(omega)))
            return -omega

        def potential(gamma):
            kept.append((gamma, gamma))
            seen.append((tuple(gamma), tuple(gamma)))
            return gamma[2], (0, 0, 1)

        system.add_user_torque(torque)
        system.add_potential((0, 0, 1), potential, lambda gamma: kept.append((gamma, gamma)) or
                             seen.append((tuple(gamma), tuple(gamma))) or np.zeros((3, 3)))
        stepper = nutate.Stepper(system)
        stepper.set_state(q=(1, 0, 0, 0), omega=(1, 2, 3))
        stepper.steps(0.1, 10)
        del stepper, system
        gc.collect()
        self.assertEqual([(tuple(a), tuple(b)) for a, b in kept], seen)
        self.assertGreater(len({omega for _, omega in seen}), 20)

    def test_work_and_energy_count_from_the_state_that_was_set(self):
        system = nutate.System(moments=(1, 2, 2.5))
        system.add("damping", coefficient=(0.1, 0.2, 0.3))
        stepper = nutate.Stepper(system)
        stepper.set_state(q=(1, 0, 0, 0), omega=(1, 2, 3))
        stepper.set(time_step=0.01)
        stepper.run(100)
        self.assertLess(stepper.energy[3], -0.1)
        stepper.set_state(q=(1, 0, 0, 0), omega=(1, 2, 3))
        self.assertEqual(tuple(stepper.energy[3:]), (0.0, 0.0))

    def test_a_stepper_that_ran_before_gives_the_bits_of_a_new_one(self):
        effects = ("", "&damping coefficient = 0.05, 0.05, 0.02 /&torque body = 0.5, 0.2, 0.1, frequency = 0.3 /",
                   "&wheel axis = 0, 0, 1, inertia = 0.1, speed = 10, torque = 0.1 /",
                   "&orbit semi_major_axis = 7e6, inclination = 0.5 /&gravity_gradient /", "&rotating_frame rate = 0.3, -0.2, 0.5 /",
                   "&inner_sphere inertia = 0.3, damping = 0.2 /")
        tried = 0
        for effect in effects:
            system = nutate.System(text=f"&body inertia = 2, 3, 4 /{effect}")
            for method in ("nielsen_krenk", "rk4", "rk8", "dop853", "taylor"):
                for settings in ({"time_step": 0.02}, {"local_tolerance": 1e-8}, {"local_tolerance": 1e-8, "conserve": True}):
                    new = nutate.Stepper(system, method=method, **settings)
                    used = nutate.Stepper(system, method=method, **settings)
                    used.set_state((1, 0, 0, 0), (3, -1, 2))
                    used.run_to(0.7, times=(0.1, 0.33))
                    used.run_to(0.9)
                    for end in (1.5, 2.5):
                        for stepper in (new, used):
                            if end < 2:
                                stepper.set_state((0.8, 0.6, 0, 0), (0.3, 1, 5))
                        first, second = new.run_to(end), used.run_to(end)
                        for name, values in first.items():
                            self.assertEqual(values.tobytes(), second[name].tobytes(), (effect, method, settings, name))
                        tried += 1
        self.assertEqual(tried, 2*3*5*len(effects))

    def test_a_stepper_whose_effects_were_switched_gives_the_bits_of_a_new_one(self):
        system = nutate.System(text="&body inertia = 3, 4, 5, mass = 1, center_of_mass = 0, 0, 0.3 / "
                                    "&gravity name = 'field', acceleration = 0, 0, -9.81 / &wheel axis = 0, 0, 1, inertia = 0.1 /")

        def make(settings):
            stepper = nutate.Stepper(system, method="taylor", **settings)
            stepper.set_columns("quaternion", "angular_velocity")
            stepper.add_event(lambda t, q, omega: t - 0.5, "late", crosses=0, switch="field off")
            return restart(stepper)

        def bits(stepper, end):
            return {name: values.tobytes() for name, values in stepper.run_to(end).items()}

        def restart(stepper):
            stepper.set_state((0.8, 0.6, 0, 0), (0.3, 1, 5))
            return stepper

        for settings in ({"local_tolerance": 1e-9}, {"time_step": 0.01}):
            with self.subTest(**settings):
                new, used, prepared = (make(settings) for _ in range(3))
                for stop in (0.3, 0.7):
                    restart(used).run_to(stop)
                    restart(used).set_motor(0, 0.2)
                    used.run_to(stop)
                self.assertEqual(bits(restart(used), 0.7), bits(new, 0.7))
                # The state that is restored has no field, the stepper that restores it has been prepared with the field, and
                # settings that are read by the next run leave that to it.
                new.set(**settings)
                saved = ctypes.create_string_buffer(new._count("nutate_stepper_save", None, 0))
                new._call("nutate_stepper_save", saved, len(saved), None)
                prepared.prepare()
                restart(prepared)._call("nutate_stepper_restore", saved, len(saved))
                self.assertEqual(bits(prepared, 1.0), bits(new, 1.0))

    def test_a_stepper_outlives_its_system(self):
        system = nutate.System(moments=(1, 2, 2.5))
        system.add_user_torque(lambda t, q, omega: -omega)
        stepper = nutate.Stepper(system)
        del system
        gc.collect()
        stepper.set_state(q=(1, 0, 0, 0), omega=(1, 2, 3))
        stepper.steps(0.1, 10)
        self.assertLess(np.linalg.norm(stepper.angular_velocity), 3.0)

    def test_a_scene_takes_callbacks(self):
        scene = nutate.Scene(BOX, "integrator.end_time=1")
        scene.add_user_torque(lambda t, q, omega: -omega)
        history = scene.run()
        self.assertLess(history["total"][-1], 0.99 * history["total"][0])
        self.assertLess(abs(history["energy_residual"]).max(), 1e-11)

    def test_threads_with_their_own_steppers_give_the_same_bits(self):
        expected = make_box().run(2000, every=2000)["q0"]
        found = [None] * 8

        def work(i):
            found[i] = make_box().run(2000, every=2000)["q0"]

        threads = [threading.Thread(target=work, args=(i,)) for i in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for values in found:
            np.testing.assert_array_equal(values, expected)


class SettingTest(unittest.TestCase):
    """Settings as Python and NumPy have them."""

    def test_numbers_of_numpy_are_numbers(self):
        expected = make_box(order=4, formulation="reduced").run(20)
        for number, whole, text in ((np.float64, np.int64, np.str_), (np.longdouble, np.uint8, str),
                                    (np.array, np.int16, np.str_)):
            with self.subTest(number=number):
                stepper = make_box(order=whole(4), formulation=text("reduced"), time_step=number(0.01))
                for name, values in stepper.run(20).items():
                    np.testing.assert_array_equal(values, expected[name], name)
        single = make_box(time_step=np.float32(0.25)).run(2)
        np.testing.assert_array_equal(single["t"], (0.25, 0.5))

    def test_truth_values_of_numpy_are_truth_values(self):
        for true, false in ((True, False), (np.bool_(True), np.bool_(False)), (np.array(True), np.array(False))):
            stepper = make_box(auxiliary_inertia=20.0)
            stepper.set(projection=false)
            stepper.step(0.01)
            stepper.set(projection=true, auxiliary_inertia=np.inf, formulation="reduced")
            stepper.step(0.01)
            stepper.set(projection=false)
            with self.assertRaisesRegex(nutate.NutateError, "projection"):
                stepper.step(0.01)

    def test_what_is_no_setting_is_refused(self):
        for value in (None, (0.01,), np.array((0.01, 0.02)), 1j, b"0.01"):
            with self.subTest(value=value), self.assertRaisesRegex(TypeError, "time_step is .* number"):
                make_box(time_step=value)


class LimitTest(unittest.TestCase):
    """What a scene refuses, arguments are refused for too, in the same words; and taken otherwise."""

    NUMBERS = (0.0, 5e-324, 9.99e-301, 1e-300, 1e-150, 9.99e-101, 1e-100, 1.0, 1e100, 1.01e100, 1e300, np.inf, -np.inf,
               np.nan)

    def verdict(self, function, *arguments, **keys):
        """What is said behind the number or the name; empty if it is taken."""
        try:
            function(*arguments, **keys)
        except nutate.NutateError as error:
            return str(error).partition(" is ")[2] or str(error)
        return ""

    def test_effects(self):
        for x in self.NUMBERS:
            for group, key, others in (("gravity_gradient", "direction", {"strength": 1.0}),
                                       ("damping", "coefficient", {}), ("rotor", "momentum", {})):
                with self.subTest(x=x, group=group):
                    values = (x, 0.0, 0.0)
                    text = f"&body inertia = 5, 20, 17 / &{group} {key} = {x!r}, 0, 0 "
                    text += "".join(f", {name} = {value}" for name, value in others.items()) + " /"
                    system = nutate.System(moments=(5, 20, 17))
                    self.assertEqual(self.verdict(system.add, group, **{key: values}, **others),
                                     self.verdict(nutate.System, text=text))

    def test_a_gravity_gradient_along_a_tiny_direction_is_refused(self):
        system = nutate.System(moments=(5, 20, 17))
        with self.assertRaisesRegex(nutate.NutateError, "direction is too short"):
            system.add("gravity_gradient", direction=(1e-150, 0, 0), strength=1)
        with self.assertRaisesRegex(nutate.NutateError, "direction is too short"):
            system.add_potential((1e-150, 0, 0), lambda gamma: (0, (0, 0, 0)))

    def test_bodies(self):
        for x in self.NUMBERS:
            with self.subTest(x=x):
                text = f"&body inertia = {x!r}, {x!r}, {x!r} /"
                self.assertEqual(self.verdict(nutate.System, moments=(x, x, x)), self.verdict(nutate.System, text=text))
                if x:
                    text = f"&body inertia = 1, 1, 1, mass = {x!r} /"
                    self.assertEqual(self.verdict(nutate.System, moments=(1, 1, 1), mass=x),
                                     self.verdict(nutate.System, text=text))

    def test_steps(self):
        scene = ("&body inertia = 1, 1, 1 / &initial angular_velocity = 0, 0, 1e-60 / "
                 "&integrator time_step = {0!r}, end_time = {0!r} /")
        for x in (9.99e-51, 1e-50, 1.0, 1e50, 1.01e50, np.inf, np.nan, 0.0):
            with self.subTest(x=x):
                refused = self.verdict(nutate.Scene, text=scene.format(x)) != ""
                stepper = nutate.Stepper(nutate.System(moments=(1, 1, 1)))
                stepper.set_state(q=(1, 0, 0, 0), omega=(0, 0, 1e-60))
                self.assertEqual(self.verdict(stepper.step, x) != "", refused)
                self.assertEqual(self.verdict(stepper.set, time_step=x) != "", refused)


class MisuseTest(unittest.TestCase):
    """What is wrong is said."""

    def refuse(self, error, pattern, function, *arguments, **keys):
        with self.assertRaisesRegex(error, pattern):
            function(*arguments, **keys)

    def test_bodies(self):
        self.refuse(nutate.NutateError, "moments|body", nutate.System, moments=(1, 1, 3))
        self.refuse(nutate.NutateError, "shape", nutate.System, shape="bx", size=(1, 2, 3), mass=1)
        self.refuse(ValueError, "shape", nutate.System, moments=(1, 2))
        self.refuse(ValueError, "one of", nutate.System)
        self.refuse(ValueError, "one of", nutate.System, moments=(1, 1, 1), shape="box")
        self.refuse(nutate.NutateError, "gravty", nutate.System(moments=(1, 1, 1)).add, "gravty")

    def test_scenes(self):
        self.refuse(nutate.NutateError, "no/such", nutate.run, "no/such/scene.nml")
        self.refuse(nutate.NutateError, "nearest: time_step", nutate.run, BOX, "integrator.time_stp=1")
        self.refuse(nutate.NutateError, "incomplete|missing", nutate.Scene, text="&body /")
        self.refuse(ValueError, "path or a text", nutate.Scene)

    def test_a_run_that_fails_keeps_its_rows(self):
        scene = nutate.Scene(BOX, "integrator.end_time=1")

        def torque(t, q, omega):
            return (np.nan if t > 0.5 else 0.0, 0.0, 0.0)

        scene.add_user_torque(torque)
        with self.assertRaises(nutate.NutateError) as caught:
            scene.run()
        self.assertEqual(len(caught.exception.history["t"]), 51)

    def test_rows_are_the_same_however_many_there_are(self):
        for n in (1, 63, 64, 65, 3000):
            stepper = make_box()
            with self.subTest(n=n):
                history = stepper.run_to(0.01*(n - 1)) if n > 1 else stepper.run_to(0.0)
                self.assertEqual(len(history["t"]), n)
                single = make_box().run(n - 1, initial=True)
                for name, values in single.items():
                    self.assertEqual(values.tobytes(), history[name].tobytes(), name)

    def test_a_number_of_steps_beyond_64_bits_is_rejected(self):
        for every in (2**63, -2**63 - 1):
            with self.assertRaisesRegex(nutate.NutateValueError, r"every is -?\d+ \(expected 1 to 9223372036854775807\)"):
                make_box().run_to(1.0, every)

    def test_steps(self):
        stepper = make_box()
        before = stepper.quaternion
        for step in (0.0, np.nan, np.inf):
            self.refuse(nutate.NutateError, ".", stepper.step, step)
        self.refuse(ValueError, "every", stepper.run, 10, every=0)
        self.refuse(ValueError, "n is -1", stepper.run, -1)
        self.refuse(nutate.NutateError, "nearest: order", stepper.set, ordr=4)
        self.refuse(nutate.NutateError, ".", stepper.set_columns, "energie")
        self.refuse(ValueError, "q has shape", stepper.set_state, q=(1, 0, 0), omega=(0, 0, 1))
        self.refuse(nutate.NutateError, ".", stepper.set_state, q=(1, 1, 0, 0), omega=(0, 0, 1))
        np.testing.assert_array_equal(stepper.quaternion, before)

    def test_arrays_whose_numbers_are_other_quantities(self):
        """Values under a mask, imaginary parts, dates and durations (which NumPy counts in its own unit)."""
        box = nutate.System(moments=(5, 20, 17))
        free = nutate.System(moments=(5, 20, 17))
        motion = nutate.solve(box, omega0=(0.1, 0, 10), t_span=(0, 1)).sol
        masked, whole = np.ma.masked_array([0.1, 0.2, 0.3], mask=(0, 0, 1)), np.ma.masked_array([0.1, 0.2, 0.3])
        wrong = {"masked": masked, "complex": np.array((0.1, 0.2j, 0.3)), "calendar": np.arange(1, 4).astype("m8[s]")}
        table = np.ones((3, 3))
        uses = {
            "moments": lambda array: nutate.System(moments=array),
            "tensor": lambda array: nutate.System(tensor=np.ma.diag(array) + 0 * np.eye(3) if array.dtype.kind == "f" else array),
            "size": lambda array: nutate.System(shape="box", size=array, mass=1),
            "coefficient": lambda array: box.add("damping", coefficient=array),
            "torque": lambda array: box.add_table((0, 1, 2), np.ma.stack((array,) * 3)),
            "t": lambda array: box.add_table(array, table),
            "table": lambda array: box.add_wheel(axis=(0, 0, 1), inertia=1, table=(array, np.zeros(3))),
            "omega0": lambda array: nutate.solve(box, omega0=array, t_span=(0, 1)),
            "t_eval": lambda array: nutate.solve(box, omega0=(0, 0, 1), t_span=(0, 1), t_eval=array),
            "times": lambda array: make_box().run_to(1, times=array),
            "t of sol": lambda array: motion(array),
            "t of the exact motion": lambda array: nutate.exact_free_body(box, (1, 0, 0, 0), (0, 0, 1), array),
            "v": lambda array: nutate.quat_from_rotation_vector(array),
            "angle": lambda array: nutate.quat_from_axis_angle((0, 0, 1), array),
            "bodies": lambda array: nutate.Bodies(free).step(0.1, np.eye(4)[:1].copy(), np.ones((1, 3)), np.ma.stack((array,))),
            "cases": lambda array: nutate.sweep(BOX, table={"integrator.end_time": array}),
        }
        for name, use in uses.items():
            for kind, array in wrong.items():
                with self.subTest(use=name, kind=kind):
                    self.refuse(nutate.NutateValueError, kind + " values", use, array)
        nutate.System(moments=whole)
        with self.assertRaisesRegex(nutate.NutateValueError, "masked values"):
            nutate.Bodies(free).step(0.1, np.eye(4)[:1].copy(), np.ma.masked_array(np.ones((1, 3)), mask=True), np.ones((1, 3)))

    def test_quantities_with_units(self):
        """As those of astropy, which are arrays, and of pint, which become arrays."""
        class Quantity(np.ndarray):
            unit = "deg"

        class Measure:
            units = "deg"

            def __array__(self, dtype=None, copy=None):
                return np.array([0.2, 0.3, 0.4], dtype)

        class Labelled(Measure):
            attrs = {"units": "rad/s"}

        box = nutate.System(moments=(5, 20, 17))
        uses = (lambda array: nutate.System(moments=array),
                lambda array: nutate.solve(box, omega0=array, t_span=(0, 1)), lambda array: nutate.quat_from_axis_angle((0, 0, 1), array),
                lambda array: nutate.solve(box, omega0=(0, 0, 1), t_span=(0, 1), t_eval=array),
                lambda array: nutate.tdb("2029-04-13", "TT", array), lambda array: nutate.sweep(BOX, table={"integrator.end_time": array}))
        for use in uses:
            for quantity in (np.array([0.2, 0.3, 0.4]).view(Quantity), Measure()):
                self.refuse(nutate.NutateValueError, "has a unit", use, quantity)
            use(Labelled())
        scalar = np.array(500e3).view(Quantity)
        self.refuse(nutate.NutateValueError, "altitude has a unit", lambda: box.add("orbit", altitude=scalar))

    def test_an_attitude_that_the_steps_left_out_is_not_shown(self):
        scene = nutate.Scene(text="&body inertia = 1, 2, 2.5 / &initial angular_velocity = 1, 2, 3 /\n"
                             "&integrator time_step = 0.01, end_time = 10 / &output columns = 'angular_velocity' /\n")
        stepper = nutate.Stepper(scene)
        stepper.run(100)
        uses = ((stepper.set_columns, ("quaternion",), {}), (stepper.add_event, ("q1",), {"crosses": 0.1}), (stepper.set, (), {"accuracy": 1e-6}),
                (getattr, (stepper, "quaternion"), {}), (getattr, (stepper, "angular_momentum_space"), {}))
        self.refuse(nutate.NutateError, "nearest: order", stepper.set, ordr=4)
        for use, arguments, keys in uses:
            self.refuse(nutate.NutateValueError, "the steps leave out the attitude", use, *arguments, **keys)
        stepper.set_state(*scene.initial)
        stepper.set_columns("quaternion")
        stepper.run(100)
        np.testing.assert_allclose(stepper.angular_momentum_space, (1, 4, 7.5), rtol=1e-13)

    def test_settings_that_do_not_fit_together(self):
        stepper = make_box()
        stepper.set(method="rk4", formulation="full")
        self.refuse(nutate.NutateError, ".", stepper.step, 0.01)

    def test_a_method_that_cannot_be_prepared_moves_nothing(self):
        stepper = nutate.Stepper(nutate.System(text="&body inertia = 2, 3, 4 /&damping coefficient = 0.1, 0.1, 0.1 /"), method="exact", time_step=0.1)
        stepper.set_state((1, 0, 0, 0), (1, 2, 3))
        for _ in range(2):
            for attempt in (stepper.prepare, lambda: stepper.step(0.1), lambda: stepper.run(3), lambda: stepper.run_to(1)):
                with self.assertRaisesRegex(nutate.NutateValueError, "solves free bodies only"):
                    attempt()
        self.assertEqual((stepper.time, *stepper.angular_velocity.round(12)), (0, 1, 2, 3))

    def test_a_text_with_a_nul_is_refused_as_a_whole(self):
        system, stepper = nutate.System(moments=(1, 2, 2.5)), make_box()
        with open(BOX, encoding="utf-8") as file:
            box = file.read()
        for function, arguments, keys in (
                (nutate.Scene, (), {"text": box + "\0 &gravty /"}), (nutate.Scene, (BOX, "integrator.order=4\0"), {}),
                (nutate.Scene, (BOX + "\0",), {}), (nutate.run, (BOX + "\0x",), {}),
                (nutate.System, (), {"text": "&body inertia = 1, 1, 1 /\0"}),
                (nutate.System, (), {"shape": "box\0", "size": (4, 1, 2), "mass": 12}), (system.add, ("rotor\0",), {}),
                (system.add, ("torque",), {"body\0": (0, 0, 1)}), (stepper.set, (), {"method": "rk4\0"}),
                (stepper.set, (), {"order\0": 4}), (stepper.set_columns, ("energy\0",), {}),
                (nutate.Scene(BOX).write, ("x\0y",), {})):
            with self.subTest(function=function, arguments=arguments, keys=keys):
                self.refuse(ValueError, "NUL", function, *arguments, **keys)

    def test_version(self):
        self.assertRegex(nutate.version(), r"^\d+\.\d+\.\d+$")


if __name__ == "__main__":
    unittest.main()
