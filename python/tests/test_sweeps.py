"""nutate.sweep and nutate.sweep_chunk: the rows of `nutate sweep`, whoever runs them."""

import contextlib
import functools
import io
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import unittest
import unittest.mock

import numpy as np

import nutate
from test_interrupts import Interrupted, Stop

BODY = """&body inertia = 5.0, 20.0, 17.0 /
&initial angular_velocity = 0.1, 0.0, 10.0 /
&integrator formulation = 'reduced', time_step = 0.01, end_time = 0.5 /
&output columns = 'quaternion', 'angular_velocity', every = 10 /
"""
TUMBLE = BODY + """&event name = 'flip', when = 'q0', crosses = 0.0 /
&ensemble members = 60, seed = 1, file = 'tumble.npy' /
&vary key = 'initial.angular_velocity', distribution = 'normal', sigma = 0.01, 0.01, 0.5 /
&vary key = 'body.inertia', distribution = 'uniform', low = 4.9, 16.0, 16.7, high = 5.1, 24.0, 17.3 /
&vary key = 'initial.quaternion', distribution = 'rotation' /
"""
TABLE = {"body.inertia.1": [5.0, 6.0, 7.0], "initial.angular_velocity.3": np.array([9, 10, 11])}


def has_threads():
    """The library was built with OpenMP."""
    try:
        nutate.sweep(nutate.Scene(text=TUMBLE, name="tumble.nml"), threads=2)
    except nutate.NutateValueError as error:
        if "built without threads" not in str(error):
            raise
        return False
    return True


class SweepTest(unittest.TestCase):
    """In a folder with the scene in a file."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.scene = os.path.join(folder.name, "tumble.nml")
        with open(self.scene, "w", encoding="utf-8") as file:
            file.write(TUMBLE)

    def test_progress_changes_no_row(self):
        rows = nutate.sweep(self.scene)
        for modules in ({"tqdm.auto": None, "tqdm": None}, {}):
            with unittest.mock.patch.dict(sys.modules, modules), contextlib.redirect_stderr(io.StringIO()) as shown:
                self.assertEqual(nutate.sweep(self.scene, progress=True).tobytes(), rows.tobytes())
            self.assertIn("60", shown.getvalue())
            if modules:
                self.assertIn("60 of 60 members", shown.getvalue())

    def test_rows_are_those_of_the_program_to_the_byte(self):
        rows = nutate.sweep(self.scene)
        file = self.scene + ".npy"
        subprocess.run([os.environ["NUTATE"], "sweep", self.scene, "--quiet", "--output", file], check=True)
        with open(file, "rb") as content:
            written = np.load(content)
        self.assertEqual(rows.dtype, written.dtype)
        self.assertEqual(rows.tobytes(), written.tobytes())
        self.assertEqual(rows["member"].tolist(), list(range(1, 61)))
        self.assertEqual(set(rows["status"]), {0, 6})
        self.assertTrue((rows["flip_count"][rows["status"] == 0] > 0).any())

    def test_a_scene_and_a_path_are_the_same(self):
        rows = nutate.sweep(self.scene, "ensemble.members=5", "ensemble.seed=7")
        with nutate.Scene(self.scene, "ensemble.members=5", "ensemble.seed=7") as scene:
            self.assertEqual(scene.members, 5)
            self.assertEqual(nutate.sweep(scene).tobytes(), rows.tobytes())
            with self.assertRaisesRegex(nutate.NutateValueError, "overrides"):
                nutate.sweep(scene, "ensemble.members=6")
        self.assertNotEqual(nutate.sweep(self.scene, "ensemble.members=5").tobytes(), rows.tobytes())

    def test_any_number_of_threads_gives_the_same_bytes(self):
        if not has_threads():
            self.skipTest("a library without threads")
        rows = nutate.sweep(self.scene)
        for threads in (2, 3, 8):
            self.assertEqual(nutate.sweep(self.scene, threads=threads).tobytes(), rows.tobytes())

    def test_chunks_put_together_are_the_whole(self):
        rows = nutate.sweep(self.scene)
        chunk = pickle.loads(pickle.dumps(functools.partial(nutate.sweep_chunk, self.scene)))
        parts = [chunk(first, last) for first, last in ((1, 1), (2, 37), (38, 60))]
        self.assertEqual(np.concatenate(parts).tobytes(), rows.tobytes())
        scene = pickle.loads(pickle.dumps(nutate.Scene(self.scene)))
        self.assertEqual(nutate.sweep_chunk(scene, np.int64(7), 9).tobytes(), rows[6:9].tobytes())

    def test_chunks_run_in_processes_that_were_forked_after_threads(self):
        if has_threads():
            nutate.sweep(self.scene, threads=2)
        rows = nutate.sweep(self.scene)
        chunks = [(self.scene, first, first + 19) for first in (1, 21, 41)]
        with multiprocessing.get_context("fork").Pool(2) as pool:
            parts = pool.starmap_async(nutate.sweep_chunk, chunks).get(timeout=600)
        self.assertEqual(np.concatenate(parts).tobytes(), rows.tobytes())

    def test_threads_in_processes_that_were_forked_after_threads(self):
        if not has_threads():
            self.skipTest("the library has no threads")
        rows = nutate.sweep(self.scene, threads=2)
        with multiprocessing.get_context("fork").Pool(1) as pool:
            forked = pool.apply_async(nutate.sweep, (self.scene,), {"threads": 2}).get(timeout=600)
        self.assertEqual(forked.tobytes(), rows.tobytes())

    @unittest.skipUnless(hasattr(os, "fork"), "processes are not forked here")
    def test_scenes_are_read_in_processes_that_were_forked_while_another_thread_read_one(self):
        ends = threading.Event()
        reader = threading.Thread(target=lambda: [nutate.Scene(text=TUMBLE) for _ in iter(ends.is_set, True)])
        reader.start()
        codes = []
        for _ in range(30):
            child = os.fork()
            if child == 0:
                signal.alarm(60)
                nutate.Scene(text=TUMBLE)
                os._exit(0)
            codes.append(os.waitpid(child, 0)[1])
            if codes[-1]:
                break
        ends.set()
        reader.join()
        self.assertEqual(codes, [0]*30)

    def test_chunks_run_in_threads_of_python(self):
        rows, parts = nutate.sweep(self.scene), [None] * 6
        scene = nutate.Scene(self.scene)

        def work(i):
            parts[i] = nutate.sweep_chunk(scene, 10 * i + 1, 10 * i + 10)

        threads = [threading.Thread(target=work, args=(i,)) for i in range(6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(np.concatenate(parts).tobytes(), rows.tobytes())


class TableTest(unittest.TestCase):
    def test_a_table_is_that_of_a_file(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "cases.csv"), "w", encoding="utf-8") as file:
                file.write("body.inertia.1,initial.angular_velocity.3\n5.0,9\n6.0,10\n7.0,11\n")
            with open(os.path.join(folder, "scene.nml"), "w", encoding="utf-8") as file:
                file.write(BODY + "&ensemble table = 'cases.csv' /")
            read = nutate.sweep(os.path.join(folder, "scene.nml"))
        rows = nutate.sweep(nutate.Scene(text=BODY), table=TABLE)
        self.assertEqual((rows.tobytes(), rows.dtype), (read.tobytes(), read.dtype))
        self.assertEqual(rows["body.inertia.1"].tolist(), [5, 6, 7])
        structured = np.zeros(3, dtype=[(name, float) for name in TABLE])
        for name, values in TABLE.items():
            structured[name] = values
        self.assertEqual(nutate.sweep(nutate.Scene(text=BODY), table=structured).tobytes(), rows.tobytes())

    def test_rows_are_those_of_scenes_by_hand(self):
        rows = nutate.sweep(nutate.Scene(text=BODY), table=TABLE)
        for i, (inertia, rate) in enumerate(zip(*TABLE.values())):
            overrides = f"body.inertia={inertia},20,17", f"initial.angular_velocity=0.1,0,{rate}"
            history = nutate.Scene(None, *overrides, text=BODY).run()
            for name in ("t", "q0", "q3", "omega1", "omega3"):
                self.assertEqual(rows[name][i], history[name][-1])

    def test_a_table_beside_draws_takes_as_many_members_as_the_scene_says(self):
        text = BODY + "&ensemble members = 2 / &vary key = 'initial.angular_velocity.1', distribution = 'uniform', low = 0, high = 1 /"
        scene = nutate.Scene(text=text)
        rows = nutate.sweep(scene, table=TABLE)
        self.assertEqual(rows["body.inertia.1"].tolist(), [5, 6])
        self.assertEqual(rows["initial.angular_velocity.1"].tolist(), nutate.sweep(scene)["initial.angular_velocity.1"].tolist())
        self.assertEqual(nutate.sweep_chunk(scene, 2, 2, table=TABLE).tobytes(), rows[1:].tobytes())
        self.assertEqual(scene.members, 2)
        with self.assertRaisesRegex(nutate.NutateValueError, "more members than lines"):
            nutate.sweep(scene, table={"body.inertia.1": [5.0]})

    def test_a_column_that_pandas_has_twice_is_refused(self):
        class Frame:
            def keys(self):
                return ["body.inertia.1", "body.inertia.1"]

            def __getitem__(self, name):
                return np.array([[5.0, 6.0], [5.0, 6.0]])

        with self.assertRaisesRegex(nutate.NutateValueError, "there are two columns 'body.inertia.1'"):
            nutate.sweep(nutate.Scene(text=BODY), table=Frame())

    def test_what_is_no_table_is_refused(self):
        scene = nutate.Scene(text=BODY)
        for table, says in (({}, "no named columns"), ([[1.0]], "no named columns"), ({1: [1.0]}, "no named columns"),
                            ({"body.inertia.1": [[1.0]]}, "2 dimensions"), ({"body.inertia.1": "x"}, "column body.inertia.1 is 'x'"),
                            ({"body.inertia.1": [1, 2], "body.inertia.2": [1]}, "differ in length"), ({"body.inertia.1": []}, "no line"),
                            ({"body.inertia.1": [np.nan]}, "not finite"), ({"body.inertia": [1.0]}, "several numbers"),
                            ({"body.inertia.9": [1.0]}, "beyond the last"), ({"output.every": [1.0]}, "does not change"),
                            ({"body.inertia.1" + 100 * " " + "x": [1.0]}, "too long"), ({"nonsense": [1.0]}, "nonsense")):
            with self.subTest(says=says), self.assertRaisesRegex(nutate.NutateValueError, says):
                nutate.sweep(scene, table=table)
        self.assertEqual(scene.members, 0)


class RefusalTest(unittest.TestCase):
    def test_members_and_threads_that_there_are_not(self):
        scene = nutate.Scene(text=TUMBLE)
        for first, last in ((0, 1), (1, 61), (5, 4), (1, 10**12)):
            with self.assertRaisesRegex(nutate.NutateValueError, "(first|last) is .*expected"):
                nutate.sweep_chunk(scene, first, last)
        for threads in (0, -1, 2**32 + 1):
            with self.assertRaisesRegex(nutate.NutateValueError, "threads is .*expected 1 to"):
                nutate.sweep(scene, threads=threads)
        with self.assertRaisesRegex(nutate.NutateValueError, "no ensemble"):
            nutate.sweep(nutate.Scene(text=BODY))

    def test_callbacks_act_on_every_member(self):
        scene = nutate.Scene(text=TUMBLE)
        scene.add_user_torque(lambda t, q, omega: -0.1 * omega)
        named = nutate.sweep(nutate.Scene(None, "damping.coefficient=0.1,0.1,0.1", text=TUMBLE))
        for threads in (1, 2)[:1 + has_threads()]:
            rows = nutate.sweep(scene, threads=threads)
            self.assertEqual(list(rows["status"]), list(named["status"]))
            np.testing.assert_allclose(rows["omega3"], named["omega3"], rtol=1e-12)

    def test_a_callback_that_raises_fails_its_member_alone(self):
        scene = nutate.Scene(text=TUMBLE)
        limit = np.median(nutate.sweep(scene)["initial.angular_velocity.3"])
        scene.add_user_torque(lambda t, q, omega: [0, 0, 0] if omega[2] < limit else 1 / 0)
        rows = nutate.sweep(scene)
        failed = rows["status"] == 11
        self.assertTrue(0 < failed.sum() < len(rows))
        self.assertTrue(np.all(np.isnan(rows["omega3"][failed])))
        self.assertFalse(np.any(np.isnan(rows["omega3"][rows["status"] == 0])))
        with self.assertRaisesRegex(nutate.NutateValueError, "direction"):
            scene.add_potential((0, 0, 0), lambda gamma: (0.0, gamma))


class InterruptTest(Interrupted):
    def test_ctrl_c_ends_a_sweep(self):
        for threads in (1, 2)[:1 + has_threads()]:
            for overrides in (("ensemble.members=1000000", "integrator.end_time=500"), ("ensemble.members=1", "integrator.end_time=1e9")):
                scene = nutate.Scene(None, *overrides, "output.every=1000000", text=TUMBLE)
                with self.subTest(threads=threads, overrides=overrides), Stop():
                    with self.assertRaises(KeyboardInterrupt):
                        nutate.sweep(scene, threads=threads)

    def test_ctrl_c_is_heard_by_a_thread_that_has_no_more_members(self):
        if not has_threads():
            self.skipTest("the library was built without threads")
        # Hours, were it not received. Which of the threads gets the long member is left to them.
        for ends in ((1e9, 0.5), (0.5, 1e9)):
            scene = nutate.Scene(None, "output.every=1000000", text=BODY)
            with self.subTest(ends=ends), Stop():
                with self.assertRaises(KeyboardInterrupt):
                    nutate.sweep(scene, table={"integrator.end_time": ends}, threads=2)


if __name__ == "__main__":
    unittest.main()
