"""Runs that are killed and go on from what was pickled: the same bits as without."""

import os
import pickle
import random
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np

import nutate

# Everything that a run remembers: switches, tables, wheels, events with counts, rows between steps.
SCENE = """&body inertia = 1, 2, 2.5 /
&initial angular_velocity = 1, 2, 3 /
&torque name = 'jets', body = 0, 0, -0.8, start = 0.1 /
&torque space = 0.1, 0, 0.2, frequency = 0.7 /
&wheel axis = 0, 1, 0, inertia = 0.1, speed = 20, torque = 0.05, friction = 0.01 /
&damping coefficient = 0.01, 0.02, 0.01 /
&event name = 'fast', when = 'omega3', crosses = 2, switch = 'jets toggle' /
&event name = 'slow', when = 'omega3', crosses = -2, switch = 'jets toggle' /
&event name = 'most', when = 'omega1', extremum = 'both' /
&integrator method = '{method}', time_step = 0.013, end_time = 10 /
"""
ROWS, CHUNK = 1200, 8

WORKER = """
import os, pickle, sys
import nutate
from test_restart import CHUNK, ROWS, make_stepper
path, method = sys.argv[1:]
if os.path.exists(path):
    with open(path, "rb") as file:
        done, events, stepper = pickle.load(file)
else:
    done, events, stepper = 0, [], make_stepper(method)
while done < ROWS:
    stepper.run(CHUNK)
    done += CHUNK
    events += [(event.name, event.number, event.t) for event in stepper.events]
    with open(path + ".part", "wb") as file:
        pickle.dump((done, events, stepper), file)
    os.replace(path + ".part", path)
    print(done, flush=True)
"""


def level(t, q, omega):
    """A quantity that pickle finds by its name."""
    return omega[0] + 0.1 * q[1]


def make_stepper(method):
    stepper = nutate.Stepper(nutate.Scene(text=SCENE.format(method=method)))
    stepper.add_event(level, "level", crosses=0.3)
    return stepper


class RestartTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = os.path.join(folder.name, "saved")
        self.drawn = random.Random(3)

    def go_on(self, method, chunks=None):
        """Goes on from what was saved; with chunks, until the process is killed at some moment after that many."""
        paths = [os.path.dirname(os.path.abspath(__file__)), *sys.path]
        with subprocess.Popen([sys.executable, "-c", WORKER, self.path, method], stdout=subprocess.PIPE,
                              env=dict(os.environ, PYTHONPATH=os.pathsep.join(paths))) as worker:
            if chunks is not None:
                for _ in range(chunks):
                    self.assertTrue(worker.stdout.readline())
                time.sleep(0.003 * self.drawn.random())
                worker.kill()
            worker.stdout.read()
        self.assertEqual(worker.returncode, 0 if chunks is None else -signal.SIGKILL)

    def test_killed_at_random_moments_a_run_comes_to_the_same_end(self):
        for method in ("nielsen_krenk", "dop853"):
            whole, events = make_stepper(method), []
            for _ in range(ROWS // CHUNK):
                whole.run(CHUNK)
                events += [(event.name, event.number, event.t) for event in whole.events]
            self.assertEqual({name for name, _, _ in events}, {"fast", "slow", "most", "level"})
            for _ in range(3):
                self.go_on(method, self.drawn.randrange(1, 40))
            self.go_on(method)
            with open(self.path, "rb") as file:
                _, again, stepper = pickle.load(file)
            os.remove(self.path)
            self.assertEqual(again, events)
            for name in ("quaternion", "angular_velocity", "conjugate_momentum", "energy", "time"):
                np.testing.assert_array_equal(getattr(stepper, name), getattr(whole, name), name)
            expected = whole.run(CHUNK)
            for name, values in stepper.run(CHUNK).items():
                np.testing.assert_array_equal(values, expected[name], name)

    def test_what_was_found_is_saved_too(self):
        stepper = make_stepper("taylor")
        stepper.run(400)
        twin = pickle.loads(pickle.dumps(stepper))
        found = [(event.name, event.number, event.t) for event in stepper.events]
        self.assertGreater(len(found), 5)
        self.assertEqual([(event.name, event.number, event.t) for event in twin.events], found)

    def test_a_stepper_that_chooses_its_method_can_be_saved_at_any_time(self):
        for goal, group in ((goal, group) for goal in ("accuracy = 1e-6", "local_tolerance = 1e-6") for group in ("", "&chaos /")):
            text = ("&body inertia = 1, 2, 2.5 / &torque space = 0.1, 0.2, 0.3 / &initial angular_velocity = 1, 2, 3 /\n"
                    f"&integrator {goal}, end_time = 1 /\n")
            scene, key = nutate.Scene(text=text + group), goal.split(" ")[0]
            for source in (scene, nutate.System(scene=scene)):
                for runs in range(3):
                    stepper = nutate.Stepper(source, **({} if source is scene else {key: 1e-6}))
                    stepper.set_state(*scene.initial)
                    if group and source is not scene:
                        stepper.follow_chaos(scene)
                    for k in range(runs):
                        stepper.run_to(0.2 * (k + 1))
                    twin = pickle.loads(pickle.dumps(stepper))
                    np.testing.assert_array_equal(twin.run_to(0.9)["q1"], stepper.run_to(0.9)["q1"])

    def test_steps_in_other_axes_are_saved(self):
        scene = nutate.Scene(text="&body inertia = 1, 2, 2.5 / &orbit semi_major_axis = 1, mu = 1, frame = 'lvlh' / &gravity_gradient /\n"
                             "&initial angular_velocity = 1, 2, 3 / &integrator time_step = 0.01, end_time = 1 /\n"
                             "&free key = 'orbit.mu' / &output columns = 'quaternion', 'sensitivities' /\n")
        stepper = nutate.Stepper(scene)
        stepper.run(5)
        twin = pickle.loads(pickle.dumps(stepper))
        np.testing.assert_array_equal(twin.run(5)["q1"], stepper.run(5)["q1"])

    def test_bytes_of_other_events_are_refused(self):
        stepper = make_stepper("rk4")
        stepper.run(10)
        saved = pickle.dumps(stepper)
        with self.assertRaises(ValueError):
            pickle.loads(saved.replace(b"event level", b"event hevel"))
