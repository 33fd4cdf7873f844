"""Mutated and extreme scenes (fuzzing.py), the first of those that `make fuzz` tries: 56 in `make test`, 167 in
`.ci/run`, 500 in `make stress`."""
import collections
import os
import pathlib
import re
import unittest

import fuzzing
from support import ONE_IN, ROOT, CommandLineTest, in_turn, share_of

SEED = 1
CASES, WIDE_CASES = share_of(500), share_of(20)
BUDGET = fuzzing.BUDGET if ONE_IN <= 3 else ("--evaluations", "50000")
BUNDLED_BUDGET = ("--evaluations", "30000" if ONE_IN <= 3 else "10000")
# Steps of an extreme scene: the fault was in the first ones.
LONGEST_EXTREME = fuzzing.LONGEST_RUN if ONE_IN <= 3 else 100
EXTREME = pathlib.Path(__file__).resolve().parent / "extreme"


class Fuzz(CommandLineTest):
    def test_any_scene_is_simulated_or_refused_in_one_line(self):
        statuses = collections.Counter()
        for number in range(CASES):
            verdict = fuzzing.assess(self.program, fuzzing.make_case(SEED, number))
            with self.subTest(repeat=f"make fuzz FUZZ='--seed {SEED} --case {number}'"):
                self.assertEqual(verdict.fault, "")
            statuses[verdict.statuses[-1]] += 1
        # Cases that all fail alike would show nothing. Few cases have one of each status.
        least = CASES//20 if CASES > 50 else 0
        for status in (0, 2, 3):
            self.assertGreater(statuses[status], least, statuses)


class Wide(CommandLineTest):
    """The first of the scenes that `make fuzz` gives to `cost`, `plot` and `sweep`, and the bundled scenes."""

    def test_cost_plot_and_sweep_succeed_or_name_the_reason(self):
        costs = collections.Counter()
        for number in range(WIDE_CASES):
            verdict = fuzzing.assess_wide(self.program, fuzzing.make_wide_case(self.program, SEED, number), budget=BUDGET)
            with self.subTest(repeat=f"make fuzz FUZZ='--seed {SEED} --wide-case {number}'"):
                self.assertEqual(verdict.fault, "")
            costs[verdict.statuses[0]] += 1
        # Where all were refused nothing would be shown.
        self.assertGreater(costs[0], WIDE_CASES//3, costs)

    def test_cost_of_every_bundled_scene(self):
        for number, scene in enumerate(sorted((ROOT / "scenes").glob("*.nml"))):
            if not in_turn(number):
                continue
            with self.subTest(scene.name):
                done = fuzzing.call(self.program, ("cost", str(scene), *BUNDLED_BUDGET, *fuzzing.COST_PLOT), self.folder)
                self.assertEqual(fuzzing.fault_of_wide(done), "")


class Extreme(CommandLineTest):
    """Legal scenes that once went wrong; each begins with a comment `! expect: STATUS: what it is about`."""

    def test_extreme_scenes_are_simulated_or_refused(self):
        for path in sorted(EXTREME.glob("*.nml")):
            text = path.read_bytes()
            status = int(re.match(rb"! expect: (\d): ", text)[1])
            verdict = fuzzing.assess(self.program, fuzzing.Case(text, [], True), longest=LONGEST_EXTREME)
            with self.subTest(path.name):
                self.assertEqual(verdict.fault, "")
                self.assertEqual(verdict.statuses, [2 if status == 2 else 0, status])


class Assess(CommandLineTest):
    """The assess sees what must not be, shown by scripts in the place of the program."""

    def fault_of(self, script):
        self.write("program", "#!/bin/sh\n" + script)
        os.chmod(self.path("program"), 0o755)
        return fuzzing.assess(self.path("program"), fuzzing.make_case(SEED, 0)).fault

    def test_one_line_and_exit_status_2_are_right(self):
        self.assertEqual(self.fault_of("echo 'scene.nml:1: wrong' >&2; exit 2"), "")

    def test_faults_are_seen(self):
        line = "echo 'scene.nml:1: wrong' >&2"
        good = "printf 't,q0\\n0,1\\n'"
        for script, fault in (
                ("kill -FPE $$", "exit status -8"),
                ("exit 1", "exit status 1"),
                ("exit 2", "not one line"),
                (f"{line}; {line}; exit 2", "not one line"),
                (line, "though it succeeded"),
                ("printf 'scene.nml:\\033[1m wrong\\n' >&2; exit 2", "not printable"),
                (f"[ $1 = run ] && {line} && exit 2; exit 0", "disagree"),
                (f"{line}; touch history.csv; exit 2", "left ['history.csv']"),
                ("[ $1 = check ] || touch other", "left ['other']"),
                (f"[ $1 = check ] || {{ {good} >history.csv; {line}; exit 3; }}", "left ['history.csv']"),
                (f"[ $1 = check ] || {{ {good}; echo '1,NaN'; }} >history.csv", "a number that is none"),
                (f"[ $1 = check ] || {{ {good}; echo '1,'; printf 2; }} >history.csv", "not whole"),
                (f"[ $1 = check ] || {{ {good}; echo '2'; }} >history.csv", "another length")):
            with self.subTest(script=script):
                self.assertIn(fault, self.fault_of(script))

    def test_faults_of_cost_plot_and_sweep_are_seen(self):
        case = fuzzing.make_case(SEED, 0)
        for script, fault in (("exit 0", ""), ("kill -FPE $$", "exit status -8"), ("exit 2", "no reason"),
                              ("echo 'Fortran runtime error: wide' >&2; exit 2", "a number that is none"),
                              ("[ $1 = cost ] || echo '  NaN '", "a number that is none"), ("echo '1 ****'", "a number that is none"),
                              ("[ $1 = sweep ] && exit 1; exit 0", "sweep: exit status 1")):
            self.write("program", "#!/bin/sh\n" + script)
            os.chmod(self.path("program"), 0o755)
            with self.subTest(script=script):
                found = fuzzing.assess_wide(self.path("program"), case).fault
                self.assertTrue(fault in found and bool(fault) == bool(found), found)

    def test_an_overrun_is_a_fault(self):
        def overrun(*arguments):
            raise fuzzing.Overrun("took 9 s")
        case = fuzzing.make_case(SEED, 0)
        self.assertEqual(fuzzing.assess(self.program, case, overrun).fault, "check: took 9 s")
        self.assertEqual(fuzzing.assess_wide(self.program, case, overrun).fault, "cost: took 9 s")


if __name__ == "__main__":
    unittest.main()
