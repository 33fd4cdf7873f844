"""Ctrl-C in long runs, and what is left of runs that end half-way."""

import faulthandler
import os
import signal
import tempfile
import threading
import time
import unittest

import numpy as np

import nutate
from nutate import _library
from test_nutate import BOX, make_box

# Pause between two looks at another thread, and time after which a run is taken to hang, s.
PAUSE, PATIENCE = 0.001, 600


class Stop:
    """Sends Ctrl-C when the main thread has been in the library for a while."""

    def __init__(self, after=0.1, times=1):
        self._after, self._times = after, times
        self._over = False
        self._thread = threading.Thread(target=self._wait)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *error):
        self._over = True
        self._thread.join()

    def _wait(self):
        while not (_library.waiting or self._over):
            time.sleep(PAUSE)
        for _ in range(self._times):
            time.sleep(self._after)
            if not self._over:
                self.send()

    def send(self):
        """Sends the signal."""
        os.kill(os.getpid(), signal.SIGINT)


class Interrupted(unittest.TestCase):
    """Tests of runs that would take hours. One that is not interrupted ends the process with a traceback."""

    def setUp(self):
        faulthandler.dump_traceback_later(PATIENCE, exit=True)
        self.addCleanup(faulthandler.cancel_dump_traceback_later)
        # In the background of a script the signal may be ignored.
        self.addCleanup(signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, signal.default_int_handler))


class InterruptTest(Interrupted):
    def stop(self, call, rows=0):
        """Interrupts a call that would write so many rows: those that it leaves. On a machine that has written none by then,
        the call is repeated and interrupted later."""
        for k in range(10):
            with Stop(0.1 * 2 ** k), self.assertRaises(KeyboardInterrupt) as caught:
                call()
            self.assertIs(signal.getsignal(signal.SIGINT), signal.default_int_handler)
            history = getattr(caught.exception, "history", {"t": ()})
            if len(history["t"]) or not rows:
                break
        if rows:
            self.assertTrue(0 < len(history["t"]) < rows)
        return history

    def test_nominal_steps_end_with_their_rows(self):
        steppers = []

        def run():
            steppers.append(make_box())
            steppers[-1].run(10 ** 9, every=1000)

        rows, stepper = self.stop(run, rows=10 ** 6), steppers[-1]
        np.testing.assert_array_equal(make_box().run(1000 * len(rows["t"]), every=1000)["q1"], rows["q1"])
        reached = stepper.time
        stepper.run(1)
        self.assertAlmostEqual(stepper.time, reached + 0.01, delta=1e-9)

    def test_steps_and_trial_runs_and_runs_to_a_time_end(self):
        self.stop(lambda: make_box().steps(1e-3, 10 ** 11))
        self.stop(lambda: make_box(method="taylor", accuracy=1e-10).run_to(1e9, every=1000))
        self.stop(lambda: make_box(method="taylor", local_tolerance=1e-10).run_to(1e7, every=1000), rows=10 ** 5)
        self.stop(lambda: nutate.solve(nutate.System(moments=(5, 20, 17)), omega0=(0.1, 0, 10), t_span=(0, 1e9), method="dop853"))

    def test_scenes_end_with_their_rows(self):
        scene = nutate.Scene(BOX, "integrator.end_time=1e7", "output.every=1000")
        self.stop(scene.run, rows=10 ** 6)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "box.csv")
            self.stop(lambda: scene.write(path))
            self.assertEqual(os.listdir(folder), ["box.csv.partial"])

    def test_fits_end(self):
        self.stop(lambda: nutate.fit("scenes/thrown_phone.nml", "-integrator.local_tolerance", "integrator.time_step=1e-8"))

    def test_a_torque_of_python_is_no_obstacle(self):
        system = nutate.System(moments=(1, 2, 2.5))
        system.add_user_torque(lambda t, q, omega: -1e-3 * omega)
        stepper = nutate.Stepper(system, time_step=1e-2)
        stepper.set_state((1, 0, 0, 0), (1, 2, 3))
        rows = self.stop(lambda: stepper.run(10 ** 7, every=5), rows=2 * 10 ** 6)
        self.assertTrue(np.all(np.diff(rows["kinetic"]) < 0))

    def test_a_slow_torque_is_no_obstacle(self):
        def slow(t, q, omega):
            calls.append(t)
            if len(calls) == 5:
                os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.03)
            return np.zeros(3)

        system = nutate.System(moments=(1, 2, 2.5))
        scene = nutate.Scene(BOX)
        for made in (system, scene):
            made.add_user_torque(slow)
        stepper = nutate.Stepper(system, time_step=1e-2)
        for run in (lambda: stepper.run_to(5.0), lambda: stepper.run(500), lambda: stepper.steps(0.01, 500), scene.run):
            calls = []
            with self.assertRaises(KeyboardInterrupt):
                run()
            self.assertLess(len(calls), 50)

    def test_a_solution_with_a_torque_of_python_leaves_its_rows(self):
        system = nutate.System(moments=(1, 2, 2.5))
        system.add_user_torque(lambda t, q, omega: -1e-3 * omega)
        rows = self.stop(lambda: nutate.solve(system, omega0=(1, 2, 3), t_span=(0, 1e6), method="dop853", local_tolerance=1e-9),
                         rows=10 ** 7)
        self.assertTrue(np.all(np.diff(rows["kinetic"]) < 0))

    def test_a_callback_that_hangs_ends_by_the_second_one(self):
        def hang(t, q, omega):
            while t > 0.1:
                time.sleep(0.01)
            return np.zeros(3)

        system = nutate.System(moments=(1, 2, 2.5))
        system.add_user_torque(hang)
        stepper = nutate.Stepper(system, time_step=1e-2)
        stepper.set_state((1, 0, 0, 0), (1, 2, 3))
        with Stop(times=2), self.assertRaises(KeyboardInterrupt):
            stepper.run(100)

    def test_a_handler_of_ones_own_is_called(self):
        heard = []
        before = signal.signal(signal.SIGINT, lambda number, frame: heard.append(number))
        try:
            with Stop(), self.assertRaisesRegex(nutate.NutateError, "asked to stop"):
                make_box().steps(1e-3, 10 ** 11)
        finally:
            signal.signal(signal.SIGINT, before)
        self.assertEqual(heard, [signal.SIGINT])

    def test_other_threads_are_not_stopped(self):
        rows = {}
        worker = threading.Thread(target=lambda: rows.update(make_box().run(10 ** 6, every=10 ** 5)))
        worker.start()
        self.stop(lambda: make_box().run(10 ** 9, every=1000), rows=10 ** 6)
        worker.join()
        self.assertEqual(len(rows["t"]), 10)


class RowsTest(unittest.TestCase):
    """Rows that were made are not lost when a callback raises."""

    def test_what_a_callback_raises_has_the_rows_before(self):
        def fail(t, q, omega):
            if t > 0.5:
                raise ZeroDivisionError("half-way")
            return np.zeros(3)

        def make(**settings):
            system = nutate.System(moments=(1, 2, 2.5))
            system.add_user_torque(fail)
            stepper = nutate.Stepper(system, **settings)
            stepper.set_state((1, 0, 0, 0), (1, 2, 3))
            return stepper

        scene = nutate.Scene(BOX)
        scene.add_user_torque(fail)
        for call, count in ((lambda: make(time_step=0.1).run(20), 5), (lambda: make(time_step=0.1).run(20, initial=True), 6),
                            (lambda: make(time_step=0.1).run_to(2.0), 6), (scene.run, 51)):
            with self.assertRaisesRegex(ZeroDivisionError, "half-way") as caught:
                call()
            self.assertEqual(len(caught.exception.history["t"]), count)
            self.assertLessEqual(caught.exception.history["t"][-1], 0.5 + 1e-9)
        for settings in ({"local_tolerance": 1e-6, "method": "dop853"}, {"accuracy": 1e-6, "method": "dop853"}):
            with self.assertRaises(ZeroDivisionError) as caught:
                make(**settings).run_to(2.0)
            self.assertEqual(list(caught.exception.history)[:1], ["t"])

    def test_a_step_that_fails_leaves_the_rows_before(self):
        stepper = nutate.Stepper(nutate.System(moments=(1, 1, 1.5)), time_step=1.0, max_iterations=1)
        system = nutate.System(moments=(1, 2, 2.5))
        system.add_user_torque(lambda t, q, omega: np.full(3, np.nan if t > 0.5 else 0.0))
        stepper = nutate.Stepper(system, time_step=0.1)
        stepper.set_state((1, 0, 0, 0), (1, 2, 3))
        with self.assertRaises(nutate.NutateError) as caught:
            stepper.run(20)
        self.assertEqual(len(caught.exception.history["t"]), 5)


if __name__ == "__main__":
    unittest.main()
