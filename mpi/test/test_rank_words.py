"""What nutate-mpi says, and that it says it once."""
import os
import subprocess
import unittest

from rank_support import PATIENCE, TUMBLE, RankTest, mpirun


class Words(RankTest):
    def test_bad_input_is_said_once(self):
        self.says_once(2, "absent.nml: cannot be read", "sweep", "absent.nml")
        self.says_once(2, "no group &ensemble", "sweep", "box.nml")
        self.says_once(2, "unknown option '--ranks'", "sweep", "tumble.nml", "--ranks", "3")
        self.says_once(2, "no member 201", "sweep", "tumble.nml", "--members", "1:201")
        self.says_once(2, "MPI runs sweeps only", "run", "box.nml")
        self.says_once(2, "--member runs in one process", "sweep", "tumble.nml", "--member", "3")
        self.says_once(2, "each process runs one thread", "sweep", "tumble.nml", "--threads", "2")
        self.assertEqual([name for name in self.names() if "npy" in name], [])

    def test_what_cannot_be_written_is_said_once(self):
        self.says_once(4, "cannot write absent/rows.npy", "sweep", "tumble.nml", "--output", "absent/rows.npy")

    def test_help_version_and_summary_are_shown_once(self):
        for word in ("--help", "help"):
            done = self.by_ranks(3, *((word,) if word == "help" else ("sweep", word)))
            self.assertEqual((done.returncode, done.stdout.count("Usage: mpirun")), (0, 1))
            self.assertNotIn("--merge", done.stdout)
        done = self.by_ranks(2, "--version")
        self.assertRegex(done.stdout, r"^nutate-mpi [\d.]+\narithmetic .*; .*MPI.*\n$")
        self.says_once(0, "200 members of 200", "sweep", "tumble.nml")

    def test_a_rank_that_sees_another_scene_is_named(self):
        # The second process reads a scene of its own, in a folder of its own.
        os.mkdir(self.path("elsewhere"))
        self.write("elsewhere/tumble.nml", TUMBLE.replace("seed = 1", "seed = 2"))
        done = subprocess.run([*mpirun(1), self.ranks, "sweep", "tumble.nml", "--quiet", ":", "-n", "1", "-wdir",
                               self.path("elsewhere"), self.ranks, "sweep", "tumble.nml", "--quiet"],
                              cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(done.stderr.count("rank 1: the scene differs between processes"), 1, done.stderr)

    def test_an_ensemble_of_which_nothing_comes_fails(self):
        self.write("tumble.nml", TUMBLE.replace("low = 1.0, 19.6, 16.7, high = 5.1", "low = 0.1, 19.6, 16.7, high = 0.2"))
        self.assertEqual(self.by_ranks(2, "sweep", "tumble.nml", "--quiet").returncode, 3)


if __name__ == "__main__":
    unittest.main()
