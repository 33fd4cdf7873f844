"""The Python package: states inside steps, and events of scenes."""

import copy
import os
import tempfile
import unittest

import numpy as np

import nutate

BOX = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes", "box.nml")


def make_box(**settings):
    """The box of scenes/box.nml, ready to step."""
    system = nutate.System(shape="box", size=(4, 1, 2), mass=12)
    stepper = nutate.Stepper(system, **settings)
    stepper.set_state(q=(1, 0, 0, 0), omega=(0.1, 0, 10))
    return stepper


class InsideTest(unittest.TestCase):
    def test_states_inside_a_step_are_as_good_as_the_method_and_unnoticed(self):
        for settings in ({"order": 8}, {"method": "dop853"}, {"method": "taylor"}):
            plain, looked, exact = (make_box(**settings) for _ in range(3))
            with self.assertRaises(nutate.NutateError):
                looked.state_at(0.0)
            looked.keep_steps()
            for _ in range(10):
                plain.step(0.02)
                looked.step(0.02)
                q, omega = looked.state_at(looked.time - 0.0075)
            np.testing.assert_array_equal(plain.quaternion, looked.quaternion)
            for _ in range(7):
                exact.step(0.0275)
            np.testing.assert_allclose(q, exact.quaternion, atol=1e-9)
            np.testing.assert_allclose(omega, exact.angular_velocity, atol=1e-8)
            with self.assertRaises(nutate.NutateError):
                looked.state_at(0.1)

    def test_states_inside_the_last_adaptive_step_are_its_rows(self):
        for method in ("nielsen_krenk", "rk4", "rk8", "dop853", "taylor", "exact"):
            for goal in ({"accuracy": 1e-7}, {"local_tolerance": 1e-8}):
                kept, other = (make_box(method=method, **goal) for _ in range(2))
                other.run_to(0.5)
                if method not in ("taylor", "exact"):
                    with self.assertRaisesRegex(nutate.NutateValueError, "not inside a step that was kept"):
                        other.state_at(0.4999)
                kept.keep_steps()
                kept.run_to(0.5)
                rows = make_box(method=method, **goal).run_to(0.5, times=(0.4999, 0.5))
                for k, t in enumerate((0.4999, 0.5)):
                    q, omega = kept.state_at(t)
                    np.testing.assert_allclose(q, [rows[f"q{i}"][k] for i in range(4)], rtol=0, atol=1e-6)
                    np.testing.assert_allclose(omega, [rows[f"omega{i}"][k] for i in (1, 2, 3)], rtol=0, atol=1e-5)
                for t in (-0.1, 0.6, 5.0, np.nan):
                    for stepper in (kept, other):
                        with self.assertRaisesRegex(nutate.NutateValueError, "not inside a step that was kept"):
                            stepper.state_at(t)
        fixed = make_box(method="taylor", time_step=0.01)
        fixed.run_to(0.5)
        with self.assertRaisesRegex(nutate.NutateValueError, "not inside a step that was kept"):
            fixed.state_at(5.0)

    def test_a_step_before_a_switch_cannot_be_repeated(self):
        for method in ("nielsen_krenk", "rk4", "rk8", "dop853", "taylor"):
            for steps in ({"time_step": 0.05}, {"local_tolerance": 1e-8}):
                system = nutate.System(moments=(3, 4, 5))
                system.add("torque", name="x", space=(3, 2, 1))
                stepper = nutate.Stepper(system, method=method, **steps)
                stepper.set_state(q=(1, 0, 0, 0), omega=(1, 0.2, -0.7))
                stepper.add_event("q1", crosses=0.2, switch="x off")
                stepper.add_event("q1", "end", crosses=0.2, stop=True)
                stepper.keep_steps()
                stepper.run_to(2.0)
                with self.assertRaisesRegex(nutate.NutateValueError, "not inside a step that was kept"):
                    stepper.state_at(stepper.time - 0.005)

    def test_events_of_a_scene_end_its_run(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "flip.nml")
            with open(BOX, encoding="utf-8") as box, open(path, "w", encoding="utf-8") as flip:
                flip.write(box.read() + "\n&event name = 'flip', when = 'omega3', crosses = 0.0, count = 2 /\n")
            history = nutate.run(path)
            self.assertAlmostEqual(history["t"][-1], 3 * 0.9664094834075236, delta=0.02)
            self.assertLess(abs(history["omega3"][-1]), 1e-10)
            self.assertEqual([(event.name, event.number) for event in history.events], [("flip", 1), ("flip", 2)])
            self.assertEqual(history.events[-1].t, history["t"][-1])
            self.assertEqual(nutate.run(BOX).events, [])

    def test_events_and_rows_are_those_of_the_program_to_the_last_bit(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "flip.nml")
            with open(BOX, encoding="utf-8") as box, open(path, "w", encoding="utf-8") as flip:
                flip.write(box.read() + "\n&event name = 'flip', when = 'omega3', crosses = 0.0 /\n"
                           "&event name = 'most', when = 'omega1', extremum = 'both' /\n")
            rows = os.path.join(folder, "flip.csv")
            scene = nutate.Scene(path)
            scene.write(rows)
            with open(os.path.join(folder, "flip.events.csv"), encoding="utf-8") as file:
                written = [line.split(",") for line in file.read().splitlines()[1:]]
            history = scene.run()
            self.assertGreater(len(history.events), 10)
            self.assertEqual([(event.name, event.number, event.t) for event in history.events],
                             [(fields[1], int(fields[2]), float(fields[0])) for fields in written])
            stepper = nutate.Stepper(scene)
            stepper.run(2000)
            for event, other in zip(history.events, stepper.events):
                self.assertEqual(event.t, other.t)
                np.testing.assert_array_equal(event.q, other.q)
                np.testing.assert_array_equal(event.omega, other.omega)
            self.assertEqual(len(history.events), len(stepper.events))


class StepperTest(unittest.TestCase):
    def test_functions_and_columns_find_the_same_events(self):
        stepper = make_box(method="taylor", time_step=0.01)
        stepper.add_event("omega3", "column", crosses=0)
        stepper.add_event(lambda t, q, omega: omega[2], "function", crosses=0, direction=-1)
        stepper.add_event(("L1", "L2"), "sum", weights=(1, -1), extremum="maximum")
        stepper.run(500)
        times = {name: [event.t for event in stepper.events if event.name == name] for name in ("column", "function", "sum")}
        np.testing.assert_allclose(times["column"], 0.9664094834075236 * np.array([1, 3, 5]), atol=1e-11)
        np.testing.assert_allclose(times["function"], times["column"][::2], atol=1e-11)
        self.assertGreater(len(times["sum"]), 0)

    def test_a_run_ends_at_an_event_and_goes_on_behind_it(self):
        stepper = make_box(method="taylor", time_step=0.01)
        stepper.add_event("omega3", crosses=0, stop=True)
        for n in (1, 2, 3):
            rows = stepper.run(1000, every=10)
            self.assertEqual(stepper.events[0].number, n)
            self.assertAlmostEqual(rows["t"][-1], (2 * n - 1) * 0.9664094834075236, delta=1e-10)
            self.assertEqual(rows["t"][-1], stepper.time)

    def test_an_event_at_the_end_of_a_run_happens_once(self):
        for settings in ({"time_step": 0.25}, {"accuracy": 1e-8}, {"method": "dop853", "local_tolerance": 1e-8}):
            for modulo, expected in ((None, [1.0]), (1.0, [1.0, 2.0, 3.0])):
                stepper, found = make_box(**settings), []
                stepper.add_event(lambda t, q, omega: t - 1.0, "second", crosses=0, modulo=modulo, direction=1)
                for end in (0.5, 1.0, 1.5, 2.0, 3.0):
                    found += stepper.run_to(end).events
                self.assertEqual([event.t for event in found], expected, settings)
                self.assertEqual([event.number for event in found], [1, 2, 3][:len(expected)])

    def test_what_is_no_event_is_refused_and_exceptions_come_out(self):
        stepper = make_box(time_step=0.01)
        for arguments in (("omega9",), ("omega3", "a name that is much too long for one"), (lambda t, q, w: w[2],)):
            with self.assertRaises(nutate.NutateValueError):
                stepper.add_event(*arguments)
        with self.assertRaises(nutate.NutateValueError):
            stepper.add_event(lambda t, q, omega: omega[2], "x", weights=[1], crosses=0)
        stepper.add_event(lambda t, q, omega: [][0], "bad", crosses=0)
        with self.assertRaises(IndexError):
            stepper.run(10)
        self.assertEqual(stepper.time, 0)
        self.assertEqual(stepper.events, [])


class MemoryTableTest(unittest.TestCase):
    def test_a_table_in_memory_is_that_of_a_file(self):
        times, torque = [0.0, 0.137, 0.3, 0.5], np.array([[1.0, 0, 0], [2, 0.5, 1], [0, 1, 1], [1, 0, 0]])
        keys = {"interpolation": "cubic", "outside": "periodic", "axes": "space"}
        states = []
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "table.csv")
            with open(path, "w", encoding="utf-8") as file:
                file.write("t (s),x (N m),y (N m),z (N m)\n")
                file.writelines(f"{t!r},{x[0]},{x[1]},{x[2]}\n" for t, x in zip(times, torque))
            for add in (lambda system: system.add("torque", table=path, **keys),
                        lambda system: system.add_table(times, torque, **keys)):
                system = nutate.System(moments=(2, 3, 4))
                add(system)
                for made in (system, copy.copy(system)):
                    stepper = nutate.Stepper(made, time_step=0.03)
                    stepper.set_state(q=(1, 0, 0, 0), omega=(0.7, -1.1, 0.9))
                    stepper.run(100)
                    states.append(stepper.quaternion)
        for state in states[1:]:
            np.testing.assert_array_equal(state, states[0])

    def test_a_table_that_is_none_is_refused(self):
        system = nutate.System(moments=(2, 3, 4))
        with self.assertRaisesRegex(nutate.NutateValueError, "line 2 of the table"):
            system.add_table([1, 0], np.zeros((2, 3)))
        with self.assertRaises(nutate.NutateValueError):
            system.add_table([0, 1], np.zeros((3, 2)))
        with self.assertRaises(nutate.NutateValueError):
            system.add_table([0, 1], np.zeros((2, 3)), interpolation="quartic")


if __name__ == "__main__":
    unittest.main()
