"""What owns memory of the library: copies, pickles, its end, how it shows itself, and what its failures are."""

import contextlib
import copy
import os
import pickle
import tempfile
import unittest

import numpy as np

import nutate
from test_nutate import BOX, make_box


def spin_down(t, q, omega):
    """A torque that pickle finds by its name."""
    return -0.1 * omega


def upright(gamma):
    """A potential that pickle finds by its name."""
    return 9 * gamma[2], (0, 0, 9)


class OwnersTest(unittest.TestCase):
    """Copies, pickles, the end of what owns memory, and how it shows itself."""

    WAYS = (copy.copy, copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing)))

    def test_a_table_that_has_changed_is_not_read_again(self):
        line = "t (s),x (N m),y (N m),z (N m)\n0,{0},0,0\n10,{0},0,0\n"
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "table.csv")
            with open(path, "w", encoding="utf-8") as file:
                file.write(line.format(0.1))
            system = nutate.System(moments=(2, 3, 4))
            system.add("torque", table=path)
            scene = nutate.Scene(text=f"&body inertia = 2, 3, 4 / &initial angular_velocity = 0, 0, 1 / &torque table = '{path}' / "
                                 "&integrator time_step = 0.1, end_time = 1 /")
            saved = [pickle.dumps(thing) for thing in (system, scene)]
            before = nutate.solve(system, None, (0.1, 0.2, 1), (0, 5)).omega[-1].tolist()
            self.assertEqual(nutate.solve(pickle.loads(saved[0]), None, (0.1, 0.2, 1), (0, 5)).omega[-1].tolist(), before)
            with open(path, "w", encoding="utf-8") as file:
                file.write(line.format(0.9))
            for bytes_of in saved:
                with self.assertRaisesRegex(nutate.NutateValueError, "table.csv' has changed since the S"):
                    pickle.loads(bytes_of)
            self.assertEqual(nutate.solve(copy.copy(system), None, (0.1, 0.2, 1), (0, 5)).omega[-1].tolist(), before)

    def test_a_copied_system_moves_as_the_first_and_outlives_it(self):
        for way in self.WAYS:
            system = nutate.System(tensor=np.diag((1, 2, 2.5)), mass=2, center_of_mass=[0, 0, 0.1])
            system.add("gravity")
            system.add_user_torque(spin_down, bounds=(1, 0, 0, 0))
            steppers = [nutate.Stepper(system), nutate.Stepper(way(system))]
            system.close()
            for stepper in steppers:
                stepper.set_state(q=(1, 0, 0, 0), omega=(1, 2, 3))
                stepper.steps(0.01, 20)
            np.testing.assert_array_equal(steppers[0].quaternion, steppers[1].quaternion)
            self.assertLess(steppers[1].energy[3], 0)

    def test_a_copied_system_has_no_effects_that_are_added_later(self):
        for way in self.WAYS:
            system, plain = (nutate.System(moments=(1, 2, 2.5)) for _ in range(2))
            twin = way(system)
            system.add("rotor", momentum=(0, 0, 60))
            self.assertEqual((repr(system).count("rotor"), repr(twin).count("rotor")), (1, 0))
            steppers = [nutate.Stepper(each) for each in (system, twin, plain)]
            for stepper in steppers:
                stepper.set_state(q=(1, 0, 0, 0), omega=(1, 2, 3))
                stepper.steps(0.01, 5)
            np.testing.assert_array_equal(steppers[1].quaternion, steppers[2].quaternion)
            self.assertGreater(np.max(np.abs(steppers[0].quaternion - steppers[1].quaternion)), 1e-3)

    def test_a_copy_is_made_of_the_values_that_were_given(self):
        n, bounds, step, when, weights = np.array((0.0, 0, 1)), [1.0, 0, 0, 0], np.array(0.1), ["omega1", "omega2"], np.array((1.0, 2.0))
        system = nutate.System(moments=(1, 2, 2.5))
        system.add_user_torque(spin_down, bounds=bounds)
        system.add_potential(n, upright)
        stepper = nutate.Stepper(system, time_step=step)
        stepper.set_state(q=(0.6, 0.8, 0, 0), omega=(1, 2, 3))
        stepper.add_event(when, "sum", weights=weights, crosses=0.1)
        n[:], bounds[0], step[...], when[0], weights[:] = (1, 0, 0), -1, 0.2, "omega3", 5
        twins = [way(stepper) for way in self.WAYS]
        self.assertEqual(nutate.Stepper(pickle.loads(pickle.dumps(system))).energy[1], nutate.Stepper(system).energy[1])
        expected = stepper.run_to(3.0)
        self.assertGreater(len(expected.events), 0)
        for twin in twins:
            history = twin.run_to(3.0)
            np.testing.assert_array_equal(history["q1"], expected["q1"])
            self.assertEqual([event.t for event in history.events], [event.t for event in expected.events])

    def test_callbacks_do_not_change_what_calls_them(self):
        uses = {"step": lambda one: one.step(0.01), "steps": lambda one: one.steps(0.01, 2), "run": lambda one: one.run(2),
                "run_to": lambda one: one.run_to(5.0), "set": lambda one: one.set(order=4), "close": lambda one: one.close(),
                "set_state": lambda one: one.set_state((1, 0, 0, 0), (0, 0, 1)), "set_columns": lambda one: one.set_columns("energy"),
                "set_state of arrays": lambda one: one.set_state(np.array((1.0, 0, 0, 0)), np.zeros(3))}
        for name, use in uses.items():
            for event in (False, True):
                def used(t, q, omega, use=use, event=event):
                    if t > 0.02:
                        use(stepper)
                    return t - 9 if event else np.zeros(3)

                system = nutate.System(moments=(1, 2, 2.5))
                if not event:
                    system.add_user_torque(used)
                stepper = nutate.Stepper(system, time_step=0.01)
                stepper.set_state(q=(1, 0, 0, 0), omega=(1, 2, 3))
                if event:
                    stepper.add_event(used, crosses=0)
                with self.subTest(name, event=event), self.assertRaisesRegex(nutate.NutateValueError, "callback .*expected a copy"):
                    stepper.run_to(0.1)
                self.assertLess(stepper.time, 0.04)
        scene = nutate.Scene(BOX)
        scene.add_user_torque(lambda t, q, omega: scene.plan and scene.close() or np.zeros(3))
        with self.assertRaisesRegex(nutate.NutateValueError, "callback .*expected a copy"):
            scene.run()
        scene = nutate.Scene(text="&body inertia = 1, 2, 2.5 / &initial angular_velocity = 1, 2, 3 / &integrator time_step = 0.1, end_time = 1 / &ensemble members = 8 /"
                                  "&vary key = 'initial.angular_velocity.1', distribution = 'uniform', low = 1, high = 2 /")
        scene.add_user_torque(lambda t, q, omega: scene.close() or np.zeros(3))
        for threads in (1, 2):
            with contextlib.suppress(nutate.NutateValueError):
                self.assertEqual(set(nutate.sweep(scene, threads=threads)["status"]), {11})
        # To read it does no harm, nor to make a copy.
        made, called = [], []
        system = nutate.System(moments=(1, 2, 2.5))
        system.add_user_torque(lambda t, q, omega: (made.append(copy.copy(called[0])) if called else None) or np.zeros(3))
        solution = nutate.solve(system, omega0=(1, 2, 3), t_span=(0, 1))
        called.append(solution.sol._branch)
        solution.sol([0.5])
        self.assertGreater(len(made), 0)
        seen = []
        system = nutate.System(moments=(1, 2, 2.5))
        system.add_user_torque(lambda t, q, omega: seen.append((stepper.time, other.step(0.01))) or np.zeros(3))
        stepper, other = nutate.Stepper(system, time_step=0.01), nutate.Stepper(nutate.System(moments=(1, 2, 2.5)))
        stepper.run(3)
        self.assertGreater(other.time, 0.02)
        self.assertEqual(seen[0][0], 0.0)

    def test_a_copied_stepper_is_of_its_class(self):
        class Mine(nutate.Stepper):
            """A stepper of a program."""

        stepper = Mine(nutate.System(moments=(1, 2, 2.5)))
        self.assertEqual([type(copy.copy(stepper)), type(copy.deepcopy(stepper))], [Mine, Mine])

    def test_what_is_closed_says_so(self):
        system, scene = nutate.System(moments=(1, 2, 2.5)), nutate.Scene(BOX)
        stepper = nutate.Stepper(system)
        for thing, uses in ((system, (lambda: system.mass, lambda: nutate.Stepper(system), lambda: system.add("gravity"),
                                      lambda: nutate.solve(system, omega0=(1, 2, 3), t_span=(0, 1)),
                                      lambda: nutate.exact_free_body(system, (1, 0, 0, 0), (1, 2, 3), [0.0]))),
                            (scene, (lambda: scene.title, scene.run, lambda: nutate.System(scene=scene),
                                     lambda: nutate.Stepper(scene), lambda: nutate.sweep(scene), scene.write)),
                            (stepper, (lambda: stepper.time, lambda: stepper.run(3), lambda: stepper.steps(0.1, 3),
                                       lambda: stepper.column_names, lambda: stepper.events, lambda: stepper.run_to(1.0),
                                       lambda: copy.copy(stepper), lambda: stepper.get("method")))):
            thing.close()
            thing.close()
            for use in uses:
                with self.assertRaisesRegex(nutate.NutateValueError, f"the {type(thing).__name__} is closed"):
                    use()

    def test_completion_offers_what_can_be_used(self):
        for name in nutate.__all__:
            kind = getattr(nutate, name)
            for attribute in dir(kind) if isinstance(kind, type) and issubclass(kind, (nutate.System, nutate.Scene, nutate.Stepper)) else ():
                value = getattr(kind, attribute)
                self.assertTrue(attribute.startswith("_") or callable(value) or isinstance(value, property), f"{name}.{attribute}")

    def test_unknown_attributes_are_refused_with_a_near_name(self):
        system, scene = nutate.System(moments=(1, 2, 2.5)), nutate.Scene(BOX, "integrator.end_time=0.1")
        solution, history = nutate.solve(system, omega0=(1, 2, 3), t_span=(0, 1), free="initial.angular_velocity"), scene.run()
        things = (system, scene, nutate.Stepper(system), nutate.Bodies(system), solution, solution.sol, solution.sensitivity, history,
                  nutate.view(scene), nutate.FitProblem(os.path.join(os.path.dirname(BOX), "thrown_phone.nml")), history.events,
                  nutate.equilibria(os.path.join(os.path.dirname(BOX), "earth_pointing.nml"))[0])
        for thing in things:
            for name in ("moments", "accurracy"):
                with self.assertRaises(AttributeError):
                    setattr(thing, name, 1)
        for thing, name, nearest in ((system, "inertias", "inertia"), (things[2], "quaternio", "quaternion"), (solution, "omga", "omega")):
            with self.assertRaisesRegex(AttributeError, f"^a {type(thing).__name__} has no attribute '{name}' .*; nearest: {nearest}\\)$"):
                setattr(thing, name, 1)
        # Documented attributes can be set, and those of derived classes; copies keep them.
        solution.message, history.events = "none", []
        class Labelled(nutate.System):
            pass
        labelled = Labelled(moments=(1, 2, 2.5))
        labelled.label = "box"
        self.assertEqual((copy.copy(labelled).label, pickle.loads(pickle.dumps(history)).events), ("box", []))

    def test_messages_are_whole_and_speak_of_python(self):
        system = nutate.System(moments=(1, 2, 2.5))
        with self.assertRaises(nutate.NutateValueError) as caught:
            system.add("gravty")
        self.assertRegex(caught.exception.message, r"rotating_frame, orbit, .*; nearest: gravity\)$")
        for override in ("integrator.ordr=4", "-integrator.ordr", "nonsense"):
            with self.assertRaises(nutate.NutateValueError) as caught:
                nutate.Scene(BOX, override)
            self.assertRegex(caught.exception.message, "^override")
            self.assertNotIn("--", caught.exception.message)
        with self.assertRaisesRegex(nutate.NutateValueError, "expected no order with it"):
            nutate.Stepper(system, method="exact", order=4).prepare()
        with self.assertRaises(nutate.NutateValueError) as caught:
            nutate.Stepper(system).add_event("omega4", crosses=0)
        self.assertRegex(caught.exception.message, r"a name that the reference lists; nearest: omega1\)$")

    def test_a_copied_scene_is_what_was_read(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "spin.nml")
            with open(path, "w", encoding="utf-8") as file:
                file.write("&body inertia = 1, 2, 2.5 /\n&initial angular_velocity = 1, 2, 3 /\n"
                           "&integrator time_step = 0.1, end_time = 0.7 /\n")
            scene = nutate.Scene(path, "integrator.order=4", "-integrator.end_time", "integrator.end_time=0.3")
            scene.add_user_torque(spin_down)
            os.remove(path)
            expected = scene.run()
            for way in self.WAYS:
                twin = way(scene)
                self.assertEqual((twin.title, twin.plan), ("spin", (0.1, 0.3, 1)))
                for name, values in twin.run().items():
                    np.testing.assert_array_equal(values, expected[name])

    def test_a_copied_stepper_goes_on_as_the_first_to_the_last_digit(self):
        for settings in ({}, {"order": 8, "formulation": "reduced"}, {"method": "taylor"}, {"method": "exact"}, {"method": "rk8"},
                         {"method": "dop853", "conserve": True}, {"method": "rk4"}):
            for way in self.WAYS:
                stepper = make_box(**settings)
                stepper.set_columns("quaternion", "euler", "energy", "solver")
                stepper.run(37)
                twin = way(stepper)
                expected = stepper.run(40, every=3)
                for name, values in twin.run(40, every=3).items():
                    np.testing.assert_array_equal(values, expected[name], f"{settings} {name}")
                stepper.close()
                twin.step(0.01)

    def test_a_copied_stepper_keeps_its_account_its_callbacks_and_what_was_chosen(self):
        for way in self.WAYS:
            system = nutate.System(moments=(1, 2, 2.5))
            system.add_user_torque(spin_down)
            with nutate.Stepper(system, method="auto", accuracy=1e-8) as stepper:
                stepper.set_state(q=(1, 0, 0, 0), omega=(1, 2, 3))
                stepper.run_to(1.0)
                system.add_user_torque(spin_down)
                twin = way(stepper)
                np.testing.assert_array_equal(twin.energy, stepper.energy)
                np.testing.assert_array_equal(twin.estimated_error, stepper.estimated_error)
                self.assertEqual(twin.get("method"), "dop853")
                self.assertEqual(twin.get("local_tolerance"), stepper.get("local_tolerance"))
                np.testing.assert_array_equal(twin.run_to(2.0)["q2"], stepper.run_to(2.0)["q2"])
                twin.set(method="rk4", time_step=0.1)
                twin.run(1)
                self.assertEqual((twin.get("method"), stepper.get("method")), ("rk4", "dop853"))

    def test_a_copied_stepper_of_a_scene_knows_its_step(self):
        stepper = nutate.Stepper(nutate.Scene(BOX))
        stepper.run(3)
        stepper.keep_steps()
        stepper.step(0.01)
        inside = stepper.time - 0.005
        np.testing.assert_array_equal(copy.copy(stepper).state_at(inside)[0], stepper.state_at(inside)[0])
        twin = pickle.loads(pickle.dumps(stepper))
        with self.assertRaises(nutate.NutateError):
            twin.state_at(inside)
        for each in (stepper, twin):
            each.step(0.01)
        np.testing.assert_array_equal(twin.state_at(inside + 0.01)[0], stepper.state_at(inside + 0.01)[0])

    def test_a_stepper_takes_back_its_own_bytes_only(self):
        stepper = make_box(order=4)
        stepper.step(0.01)
        saved = pickle.dumps(stepper)
        for wrong in (saved.replace(b"stepper 0", b"stepper 9"), saved.replace(b"nielsen_krenk", b"nielsen_krank")):
            with self.assertRaises(ValueError):
                pickle.loads(wrong)

    def test_with_frees_at_its_end(self):
        with nutate.System(moments=(1, 2, 2.5)) as system, nutate.Stepper(system) as stepper, nutate.Scene(BOX) as scene:
            stepper.set_state(q=(1, 0, 0, 0), omega=(1, 2, 3))
        for use in (lambda: system.inertia, lambda: stepper.step(0.1), scene.run):
            with self.assertRaises(nutate.NutateError):
                use()
        for thing in (system, stepper, scene):
            thing.close()
            self.assertIn("closed", repr(thing))

    def test_what_it_is_shows(self):
        system = nutate.System(moments=(5, 5, 1), mass=1, center_of_mass=(0, 0, 1))
        system.add("gravity")
        self.assertRegex(repr(system), r"<System inertia=\[\[5.*\]\] mass=1 with gravity>")
        self.assertIn("Scene 'Free", repr(nutate.Scene(BOX)))
        self.assertEqual(repr(make_box()), "<Stepper at t=0 s>")
        self.assertEqual(nutate.__version__, nutate.version())

    def test_an_effect_that_a_scene_has_once_is_added_once(self):
        system = nutate.System(moments=(5, 5, 1), mass=1, center_of_mass=(0, 0, 1))
        system.add("gravity")
        system.add("rotor", momentum=(0, 0, 1))
        system.add("rotor", momentum=(0, 0, 1))
        with self.assertRaisesRegex(nutate.NutateValueError, "second group &gravity"):
            system.add("gravity", acceleration=(0, 0, -1))

    def test_values_that_a_system_would_not_use_are_refused(self):
        scene = nutate.Scene(BOX)
        for given in (dict(moments=(1, 2, 2.5), size=(1, 2, 3)), dict(moments=(1, 2, 2.5), density=3.0), dict(scene=scene, mass=2.0),
                      dict(text="&body inertia = 1, 2, 2.5 /", mass=3.0), dict(scene=scene, center_of_mass=(0, 0, 1)),
                      dict(shape="sphere", size=1, mass=1, about_center=True), dict(scene=scene, about_center=True)):
            with self.subTest(given), self.assertRaisesRegex(nutate.NutateValueError, "expected"):
                nutate.System(**given)

    def test_failures_are_what_python_calls_them(self):
        with self.assertRaises(OSError) as caught:
            nutate.Scene("absent.nml")
        self.assertIsInstance(caught.exception, nutate.NutateError)
        self.assertIn("absent.nml", str(caught.exception))
        again = pickle.loads(pickle.dumps(caught.exception))
        self.assertEqual((type(again), again.status, str(again)),
                         (type(caught.exception), caught.exception.status, str(caught.exception)))
        for wrong in (lambda: nutate.Scene(text="&body /"), lambda: nutate.System(moments=(1, 1, 3)),
                      lambda: nutate.System(moments=(1, 1)), lambda: make_box(order=3).step(0.1), nutate.System):
            with self.assertRaises(ValueError) as caught:
                wrong()
            self.assertIsInstance(caught.exception, nutate.NutateError)
