"""nutate-mpi sweep goes on, to the bytes of nutate sweep, after processes are lost."""
import os
import random
import re
import signal
import subprocess
import time
import unittest

from rank_support import MEANS, PATIENCE, RankTest, chunks_done, mpirun, wait_until


class LostRanks(RankTest):
    """Sweeps long enough for ranks to be lost on the way."""

    LONG = ("--set", "integrator.end_time=400", "--set", "ensemble.chunk=3")
    # The bytes of one process, by the settings: a run of seconds, which several tests compare with.
    WHOLE = {}

    def start(self, ranks, *arguments):
        return subprocess.Popen([*mpirun(ranks), self.ranks, "sweep", "tumble.nml", "--quiet", *arguments], cwd=self.folder,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    @staticmethod
    def children(run):
        """Process numbers of the ranks."""
        found = subprocess.run(["ps", "--ppid", str(run.pid), "-o", "pid="], capture_output=True, text=True, check=False)
        return [int(word) for word in found.stdout.split()]

    def lose(self, number, victims, ranks, dice, output, *arguments):
        """Sends a signal to some of the ranks, or to mpirun, some chunks on; true if the sweep was not over."""
        path = self.path(output)
        before, more = chunks_done(path), dice.randint(1, 6)
        run = self.start(ranks, "--output", output, "--resume", *arguments)
        wait_until(lambda: run.poll() is not None or chunks_done(path) >= before + more)
        time.sleep(dice.uniform(0, 0.03))
        for process in ([run.pid] if victims is None else self.children(run)[victims]):
            try:
                os.kill(process, number)
            except ProcessLookupError:
                pass
        run.communicate(timeout=PATIENCE)
        return run.returncode != 0

    def resumes(self, number, victims, seed, output, *settings):
        """Ranks are lost again and again; in the end, by whatever ranks, the bytes are those of one process."""
        if settings not in self.WHOLE:
            self.WHOLE[settings] = self.sweep(0, *settings, *self.LONG, output="whole" + output)
        dice = random.Random(seed)
        lost = 0
        # A signal may come when all is done: mpirun takes its time to pass it on. Then the sweep begins anew.
        for ranks in 2 * (4, 2, 8):
            if self.lose(number, victims, ranks, dice, output, *settings, *self.LONG):
                lost += 1
            elif lost < 2:
                os.remove(self.path(output))
            if lost > 1:
                break
        self.assertGreater(lost, 1)
        self.assertEqual(self.sweep(dice.choice((0, 2, 5)), "--resume", *settings, *self.LONG, output=output),
                         self.WHOLE[settings])
        self.assertNotIn(output + ".partial", self.names())

    def test_one_rank_is_killed(self):
        self.resumes(signal.SIGKILL, slice(-1, None), 1, "rows.npy")

    def test_rank_0_is_killed(self):
        self.resumes(signal.SIGKILL, slice(0, 1), 2, "rows.npy")

    def test_all_are_killed(self):
        self.resumes(signal.SIGKILL, slice(None), 3, "rows.npy")

    def test_a_rank_is_killed_where_no_rows_are_kept(self):
        self.resumes(signal.SIGKILL, slice(-1, None), 4, "mean.csv", *MEANS)

    def test_ctrl_c(self):
        self.resumes(signal.SIGINT, None, 5, "rows.npy")

    def test_a_signal_is_answered_in_one_line(self):
        # The signal goes to rank 0: mpirun does not always pass on what ranks print after a signal to it.
        run = self.start(3, "--set", "integrator.end_time=3000", "--set", "ensemble.chunk=1")
        wait_until(lambda: chunks_done(self.path("tumble.npy")) > 0)
        os.kill(self.children(run)[0], signal.SIGTERM)
        _, said = run.communicate(timeout=PATIENCE)
        self.assertEqual(len(re.findall(r"(?m)^nutate: tumble\.nml: stopped by SIGTERM; \d+ of 200 members are in "
                                        r"tumble\.npy\.partial \(nutate-mpi sweep --resume continues\)$", said)), 1, said)
        self.assertNotEqual(run.returncode, 0)


if __name__ == "__main__":
    unittest.main()
