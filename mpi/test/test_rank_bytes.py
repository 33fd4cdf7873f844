"""nutate-mpi sweep: the bytes of nutate sweep for any number of processes."""
import os
import subprocess
import unittest

from rank_support import MEANS, PATIENCE, TOGETHER, TUMBLE, RankTest


class Bytes(RankTest):
    def test_any_number_of_ranks(self):
        for scene, counts in ((TUMBLE, range(1, 9)), (TOGETHER, (1, 2, 4, 8))):
            self.write("tumble.nml", scene)
            whole = self.sweep(0)
            listing = self.read("tumble.npy.txt")
            if "threads" in self.succeed("--version").stdout:
                self.assertEqual(self.sweep(0, "--threads", "2"), whole)
            for ranks in counts:
                self.assertEqual(self.sweep(ranks), whole, ranks)
                self.assertEqual(self.read("tumble.npy.txt"), listing)

    def test_any_chunk(self):
        whole = self.sweep(0)
        for chunk in (1, 7, 50, 200):
            for ranks in (2, 3):
                self.assertEqual(self.sweep(ranks, "--set", f"ensemble.chunk={chunk}"), whole, (chunk, ranks))

    def test_sums_are_those_of_one_process(self):
        whole = self.sweep(0, *MEANS, output="mean.csv")
        for ranks, chunk in ((1, 13), (2, 1), (2, 0), (4, 13), (8, 1)):
            settings = ("--set", f"ensemble.chunk={chunk}") if chunk else ()
            self.assertEqual(self.sweep(ranks, *MEANS, *settings, output="mean.csv"), whole, (ranks, chunk))

    def test_without_mpirun_it_is_one_rank(self):
        whole = self.sweep(0, output="whole.npy")
        done = subprocess.run([self.ranks, "sweep", "tumble.nml", "--quiet"], cwd=self.folder, capture_output=True,
                              text=True, timeout=PATIENCE, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(self.bytes_of("tumble.npy"), whole)

    def test_parts_histories_and_csv(self):
        self.sweep(0, "--csv", "whole.csv", "--set", "ensemble.histories=2,17,18,19", output="whole.npy")
        self.sweep(3, "--csv", "rows.csv", "--set", "ensemble.histories=2,17,18,19")
        self.assertEqual(self.bytes_of("tumble.npy"), self.bytes_of("whole.npy"))
        self.assertEqual(self.read("rows.csv"), self.read("whole.csv"))
        histories = [name.removeprefix("whole.") for name in self.names() if name.startswith("whole.member")]
        self.assertGreater(len(histories), 1)
        for name in histories:
            self.assertEqual(self.read("tumble." + name), self.read("whole." + name))
        for part in ("1:60", "61:200"):
            done = self.by_ranks(2, "sweep", "tumble.nml", "--quiet", "--members", part)
            self.assertEqual(done.returncode, 0, done.stderr)
        os.remove(self.path("tumble.npy"))
        self.succeed("sweep", "tumble.nml", "--quiet", "--merge")
        self.assertEqual(self.bytes_of("tumble.npy"), self.bytes_of("whole.npy"))


if __name__ == "__main__":
    unittest.main()
