"""Tests that need a clock: budgets in seconds, bars of long runs, commands that must not take long. `make stress` runs them,
on a machine that does nothing else; all other tests count steps and evaluations."""
import os
import pathlib
import sys
import time
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "cli"), str(HERE.parent.parent / "tools" / "tests")]
import fuzz  # noqa: E402  pylint: disable=wrong-import-position
import fuzzing  # noqa: E402  pylint: disable=wrong-import-position
from support import CommandLineTest  # noqa: E402  pylint: disable=wrong-import-position
import test_cost  # noqa: E402  pylint: disable=wrong-import-position
import test_run  # noqa: E402  pylint: disable=wrong-import-position


class Timed(CommandLineTest):
    def takes(self, seconds, call):
        """What a call returns that must not take longer than so many seconds."""
        begun = time.monotonic()
        done = call()
        self.assertLess(time.monotonic() - begun, seconds)
        return done


class Budget(Timed):
    def test_the_time_of_a_study_is_used_and_kept(self):
        for seconds in (0.5, 3.0):
            begun = time.monotonic()
            text = self.takes(1.2*seconds + 1.0, lambda: self.succeed("cost", "top.nml", "--seconds", str(seconds))).stdout
            self.assertGreater(time.monotonic() - begun, 0.5*seconds)
            self.assertIn("cheapest first", text)

    def test_subdivided_steps_do_not_outlast_the_time(self):
        self.write("subdivided.nml", test_cost.SUBDIVIDED)
        self.takes(4.0, lambda: self.fail_with(3, "cost", "subdivided.nml", "--seconds", "1", says=(
            "no run was completed: nielsen_krenk order 2 (full):", "even subdivided into 1024 parts")))

    def test_no_run_in_the_time(self):
        self.fail_with(3, "cost", "top.nml", "--seconds", "0.2", "--set", "integrator.end_time=1e6",
                       says=("no run was completed within 0.2 s", "--seconds"))

    def test_values_of_the_option(self):
        for arguments, words in ((("--seconds", "0"), "--seconds '0'"), (("--seconds", "soon"), "soon"), (("--seconds", "nan"), "nan"),
                                 (("--seconds",), "needs a value"), (("--seconds", "1", "--seconds", "2"), "given twice"),
                                 (("--seconds", "1", "--evaluations", "9"), "exclude each other")):
            self.fail_with(2, "cost", "box.nml", *arguments, says=(words,))
        self.fail_with(2, "run", "box.nml", "--seconds", "1", says=("no option --seconds",))


class Short(Timed):
    def test_a_missing_gnuplot_is_reported_before_the_study(self):
        os.mkdir(self.path("bin"))
        self.takes(5.0, lambda: self.fail_with(4, "cost", "box.nml", "--plot", "a.svg", says=("gnuplot is not installed",),
                                               env={**os.environ, "PATH": self.path("bin")}))

    def test_a_short_run_shows_no_bar(self):
        seen, _ = test_run.ProgressBar.on_terminal(self, "run", "box.nml")
        self.assertNotIn("[#", seen)
        self.assertNotIn("[.", seen)

    def test_long_scenes_are_read_in_a_time_that_grows_with_their_length(self):
        for piece in ("x", "1,", "!\n", "''"):
            self.write("long.nml", "&body inertia = " + 10_000_000//len(piece)*piece)
            self.takes(10.0, lambda: self.fail_with(2, "check", "long.nml"))

    def test_make_fuzz_sees_a_command_that_takes_too_long(self):
        self.write("program", "#!/bin/sh\ni=0; while [ $i -lt 3000000 ]; do i=$((i + 1)); done\n")
        os.chmod(self.path("program"), 0o755)
        self.assertRegex(fuzzing.assess(self.path("program"), fuzzing.make_case(1, 0), fuzz.Timed()).fault, "check: took .* s")


if __name__ == "__main__":
    unittest.main()
