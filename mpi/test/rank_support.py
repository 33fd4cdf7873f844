"""What the tests of nutate-mpi share. The environment variables NUTATE and NUTATE_MPI name the programs."""
import os
import re
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "test", "cli"))
from support import PATIENCE, CommandLineTest, chunks_done, wait_until  # noqa: E402,F401  pylint: disable=wrong-import-position

TUMBLE = """&scene title = 'Tumble' /
&body inertia = 5.0, 20.0, 17.0 /
&initial angular_velocity = 0.1, 0.0, 10.0 /
&integrator formulation = 'reduced', time_step = 0.01, end_time = 0.5 /
&output columns = 'quaternion', 'angular_velocity', 'energy', every = 10 /
&event name = 'flip', when = 'q0', crosses = 0.0 /
&ensemble members = 200, seed = 1, file = 'tumble.npy' /
&vary key = 'initial.angular_velocity', distribution = 'normal', sigma = 0.01, 0.01, 0.5 /
&vary key = 'body.inertia', distribution = 'uniform', low = 1.0, 19.6, 16.7, high = 5.1, 20.4, 17.3 /
&vary key = 'initial.quaternion', distribution = 'rotation' /
"""
# Free bodies without events, which are run several at once.
TOGETHER = re.sub("&event.*\n", "", TUMBLE)
MEANS = ("--set", "ensemble.rows=none")


def mpirun(ranks):
    """How processes are started: more than there are cores, by root too, and without a search for fast networks."""
    words = ["mpirun", "--quiet", "--oversubscribe", "--mca", "pml", "ob1", "--mca", "btl_base_warn_component_unused", "0",
             "-n", str(ranks)]
    return words + (["--allow-run-as-root"] if os.getuid() == 0 else [])


class RankTest(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.ranks = os.environ["NUTATE_MPI"]
        self.write("tumble.nml", TUMBLE)

    def bytes_of(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def by_ranks(self, ranks, *arguments):
        return subprocess.run([*mpirun(ranks), self.ranks, *arguments], cwd=self.folder, capture_output=True, text=True,
                              timeout=PATIENCE, check=False)

    def sweep(self, ranks, *arguments, output="tumble.npy"):
        """The bytes of the rows; 0 ranks: those of nutate sweep."""
        words = ["sweep", "tumble.nml", "--quiet", "--output", output, *arguments]
        done = self.by_ranks(ranks, *words) if ranks else self.nutate(*words)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.bytes_of(output)

    def says_once(self, status, text, *arguments):
        """What nutate says is one line, though three processes have been started. MPI may add what it thinks of it."""
        done = self.by_ranks(3, *arguments)
        self.assertEqual(done.returncode, status, done.stderr)
        self.assertEqual(done.stderr.lower().count(text.lower()), 1, done.stderr)
