"""Members in SIMD batches, and the few steps at which members are looked at: neither shows in a row."""
import re
import signal
import subprocess
import time
import unittest

from test_sweep import SweepTest, TUMBLE, read_npy


class Looks(SweepTest):
    """Where the scene asks for no rows, some hundred steps are looked at: seen in the largest errors alone."""

    SCENE = TUMBLE.replace(", every = 10", "").replace("members = 200", "members = 20").replace("&event", "! &event").replace(
        "&integrator", "&rotor momentum = 0.0, 1.0, 2.0 /\n&integrator")

    def scene(self, steps, **changes):
        text = self.SCENE.replace("time_step = 0.01, end_time = 0.5", f"time_step = 0.001, end_time = {steps/1000}")
        for old, new in changes.items():
            text = text.replace(old, new)
        self.write("tumble.nml", text)

    def test_a_member_alone_has_the_row_of_the_ensemble(self):
        for steps in (99, 1000, 1005):
            for method in ("method = 'taylor', ", ""):
                self.scene(steps, **{"formulation = 'reduced', ": method})
                self.sweep("--csv", "rows.csv")
                lines = self.read("rows.csv").splitlines()
                self.assertEqual(self.sweep("--set", "ensemble.chunk=1", output="alone.npy"), self.bytes_of("tumble.npy"))
                done = self.succeed("sweep", "tumble.nml", "--member", "17")
                self.assertEqual(done.stdout.splitlines(), [lines[0], lines[17]])
                self.assertEqual(len(self.history("tumble.member17.csv")[1]), steps + 1)

    def test_the_end_is_that_of_all_rows(self):
        self.scene(1005)
        names, few = read_npy(self.sweep())
        _, many = read_npy(self.sweep("--set", "output.every=1"))
        last = names.index("largest_energy_residual")
        self.assertEqual([row[:last] for row in few], [row[:last] for row in many])
        for row, whole in zip(few, many):
            for field in (last, last + 1):
                self.assertTrue(0 < row[field] <= whole[field] * (1 + 1e-12) < 1e-13, (row[field], whole[field]))
        _, tenth = read_npy(self.sweep("--set", "output.every=10"))
        self.assertEqual(few, tenth)

    def test_what_keeps_members_out_of_batches_is_named(self):
        steps = "time_step = 0.001, end_time = 1"
        cases = (("", "16 members at a time"),
                 ("method = 'taylor', ", "none: method is 'nielsen_krenk' (formulation = 'reduced' gives the same trajectory 3"),
                 ("method = 'taylor'", "none: method is 'nielsen_krenk' (steps in batches", "formulation = 'reduced'"),
                 ("method = 'taylor'", "none: conserve is off", "method = 'taylor', conserve = .false."),
                 (steps, "none: steps are adaptive", "local_tolerance = 1e-9, end_time = 1"),
                 (steps, "none: the last step is shorter", "time_step = 0.003, end_time = 1"),
                 ("! &event", "none: there are events", "&event"),
                 ("'energy'", "none: there are Euler angles", "'euler'"),
                 ("'energy'", "none: 'solver' is among", "'solver'"),
                 ("&ensemble", "none: a number of &integrator varies",
                  "&vary key = 'integrator.end_time', distribution = 'uniform', low = 0.9, high = 1.1 /\n&ensemble"),
                 ("&rotor", "none: a free body has a closed solution, method = 'exact'", "! &rotor"),
                 ("&ensemble", "none: an effect that batches do not support", "&damping coefficient = 0.1, 0.1, 0.1 /\n&ensemble"))
        for old, says, *new in cases:
            self.scene(1000, **{"formulation = 'reduced'": "method = 'taylor'"}, **({old: new[0] if new else ""} if old else {}))
            for command in (("check",), ("sweep", "--set", "ensemble.members=2")):
                done = self.succeed(*command[:1], "tumble.nml", *command[1:])
                shown = done.stdout + done.stderr
                self.assertRegex(shown, "SIMD batches +" + re.escape(says), old)


class Together(SweepTest):
    """Gyrostats by Taylor series, which are run several at once, some too fast for their steps: nothing shows of it."""

    SCENE = """&body inertia = 5.0, 20.0, 17.0 /
&initial angular_velocity = 0.1, 0.0, 10.0 /
&rotor momentum = 0.0, 1.0, 2.0 /
&integrator method = 'taylor', time_step = 0.1, end_time = 5.0 /
&output columns = 'quaternion', 'angular_velocity', 'energy', every = 10 /
&ensemble members = 203, seed = 1, file = 'tumble.npy' /
&vary key = 'initial.angular_velocity', distribution = 'normal', sigma = 0.01, 15.0, 0.5 /
&vary key = 'body.inertia', distribution = 'uniform', low = 4.9, 16.0, 16.7, high = 5.1, 24.0, 17.3 /
"""
    # Of some the energy is lost, and some bodies are none.
    STATUSES = {0, 2, 6}

    def setUp(self):
        super().setUp()
        self.write("tumble.nml", self.SCENE)

    def test_rows_are_those_of_members_alone(self):
        rows = self.sweep()
        for chunk in (1, 2, 3, 9, 50):
            self.assertEqual(self.sweep("--set", f"ensemble.chunk={chunk}"), rows)
        if self.has_threads():
            for threads in (2, 3):
                self.assertEqual(self.sweep("--threads", str(threads)), rows)
        statuses = [row[1] for row in read_npy(rows)[1]]
        self.assertEqual(set(statuses), self.STATUSES)

    def test_a_member_again_with_its_history_is_its_row(self):
        names, rows = read_npy(self.sweep())
        first = 2 + sum(name.startswith(("initial", "body")) for name in names)
        for member in (1, 57, 203):
            if rows[member - 1][1] != 0:
                continue
            self.succeed("sweep", "tumble.nml", "--member", str(member))
            last = [float(text) for text in self.read(f"tumble.member{member}.csv").splitlines()[-1].split(",")]
            self.assertEqual(last, list(rows[member - 1][first:first + len(last)]))

    def test_ctrl_c_and_resume(self):
        whole = self.sweep("--set", "integrator.end_time=50.0", output="whole.npy")
        run = subprocess.Popen([self.program, "sweep", "tumble.nml", "--quiet", "--set", "integrator.end_time=50.0", "--set",
                                "ensemble.chunk=8"], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        time.sleep(0.02)
        run.send_signal(signal.SIGINT)
        run.communicate()
        self.assertEqual(self.sweep("--set", "integrator.end_time=50.0", "--resume"), whole)


if __name__ == "__main__":
    unittest.main()
