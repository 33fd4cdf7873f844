"""Gives programs mutated and extreme scenes (test/cli/fuzzing.py) and keeps those that they take amiss.

    tools/tests/fuzz.py [--seed S] [--cases N] [--case K] [--wide-case K] [--keep FOLDER] PROGRAM...

The last line is `N passed, N failed`. `--case K` repeats one case and shows what becomes of it.
"""

import argparse
import collections
import multiprocessing
import os
import pathlib
import resource
import shlex
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "test", "cli"))

import fuzzing  # pylint: disable=wrong-import-position

# Failures shown; all are counted and kept.
SHOWN = 30


# Processor time that a command may take, s; searches for events evaluate every radian of a step, and events have a row each.
# Studies have a budget in time here.
BUDGET = ("--seconds", "0.3")
ALLOWED_SECONDS, SECONDS_OF_STUDY, SECONDS_OF_SEARCH, SECONDS_PER_EVENT = 2.0, 5.5, 8.0, 4e-4


class Timed:
    """Runs commands as `fuzzing.call` does, and ends a case whose command takes longer than it may."""

    def __init__(self):
        # Longest processor time of a command, s.
        self.longest = 0.0

    def __call__(self, program, arguments, folder, *patience):
        before = processor_seconds()
        done = fuzzing.call(program, arguments, folder, *patience)
        seconds = processor_seconds() - before
        self.longest = max(self.longest, seconds)
        if seconds > allowed_seconds(arguments[0], pathlib.Path(folder)):
            raise fuzzing.Overrun(f"took {seconds:.1f} s")
        return done


def processor_seconds():
    """Processor time of the programs that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def allowed_seconds(command, folder):
    """Processor time that a command may take, s; no limit for those whose work nothing limits."""
    if command == "cost":
        return SECONDS_OF_STUDY
    if command not in ("check", "run"):
        return float("inf")
    if b"&event" not in (folder / "scene.nml").read_bytes():
        return ALLOWED_SECONDS
    rows = sum(path.read_bytes().count(b"\n") for path in folder.glob("*.events.csv*"))
    return ALLOWED_SECONDS + SECONDS_OF_SEARCH + rows * SECONDS_PER_EVENT


def try_case(job):
    """Number of a case, its faults with the programs that have them, exit statuses, and the longest time, s."""
    seed, number, programs = job
    case, timed = fuzzing.make_case(seed, number), Timed()
    verdicts = [fuzzing.assess(program, case, timed) for program in programs]
    faults = [f"{program}: {verdict.fault}" for program, verdict in zip(programs, verdicts) if verdict.fault]
    return number, faults, [verdict.statuses for verdict in verdicts], timed.longest


def try_wide_case(job):
    """The same for the commands `cost`, `plot` and `sweep`."""
    seed, number, programs = job
    case = fuzzing.make_wide_case(programs[0], seed, number)
    timed = Timed()
    verdicts = [fuzzing.assess_wide(program, case, timed, BUDGET) for program in programs]
    return number, [f"{program}: {verdict.fault}" for program, verdict in zip(programs, verdicts) if verdict.fault], case


def run_wide_cases(options, programs):
    """All wide cases on some processes; the number of those that failed."""
    failed = 0
    numbers = range(options.wide) if options.wide_case is None else [options.wide_case]
    with multiprocessing.Pool(options.jobs) as pool:
        for number, faults, case in pool.imap_unordered(try_wide_case, [(options.seed, number, programs) for number in numbers]):
            if faults:
                failed += 1
                keep(options.keep, options.seed, f"wide_{number}", case)
                print("\n".join(f"wide case {number}: {fault}" for fault in faults), flush=True)
    print(f"cost, plot and sweep: {len(numbers) - failed} passed, {failed} failed")
    return failed


def keep(folder, seed, number, case):
    """Writes a case that failed where it can be looked at."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{seed}_{number}.nml").write_bytes(case.text)
    settings = " ".join("--set " + shlex.quote(os.fsdecode(override)) for override in case.overrides)
    if settings:
        (folder / f"{seed}_{number}.sh").write_bytes(os.fsencode(settings + "\n"))


def repeat_case(options, programs):
    """Shows one case and what the programs make of it."""
    case = fuzzing.make_case(options.seed, options.case)
    keep(options.keep, options.seed, options.case, case)
    scene = options.keep / f"{options.seed}_{options.case}.nml"
    print(f"case {options.case} of seed {options.seed}: {scene}")
    failed = 0
    for program in programs:
        verdict = fuzzing.assess(program, case, Timed())
        failed += bool(verdict.fault)
        print(f"{program}: {verdict.fault or 'as it should be'} (exit statuses {verdict.statuses})")
        for command in ("check", "run"):
            arguments = fuzzing.arguments_of(command, case)
            arguments[1] = str(scene.absolute())
            if command == "run":
                arguments[-1] = os.devnull
            done = subprocess.run([program, *arguments], capture_output=True, timeout=fuzzing.PATIENCE, check=False)
            print(f"   {command}: {os.fsdecode(done.stderr).strip() or 'nothing on standard error'}")
    print(f"{1 - bool(failed)} passed, {int(bool(failed))} failed")
    return failed


def run_cases(options, programs):
    """All cases on some processes; the number of those that failed."""
    statuses, failed, longest = collections.Counter(), 0, 0.0
    jobs = ((options.seed, number, programs) for number in range(options.first, options.first + options.cases))
    with multiprocessing.Pool(options.jobs) as pool:
        for number, faults, ended, seconds in pool.imap_unordered(try_case, jobs, chunksize=20):
            longest = max(longest, seconds)
            statuses[ended[0][-1] if ended[0] else "none"] += 1
            if not faults:
                continue
            failed += 1
            keep(options.keep, options.seed, number, fuzzing.make_case(options.seed, number))
            if failed <= SHOWN:
                print("\n".join(f"case {number}: {fault}" for fault in faults), flush=True)
    outcomes = ", ".join(f"{count} with exit status {status}" for status, count in sorted(statuses.items()))
    print(f"{options.cases} cases from {options.first} of seed {options.seed}, {len(programs)} programs: {outcomes}")
    print(f"Longest run: {longest:.2f} s of processor time")
    if failed:
        print(f"Kept in {options.keep}. To repeat one: make fuzz FUZZ='--seed {options.seed} --case NUMBER'")
    print(f"{options.cases - failed} passed, {failed} failed")
    return failed


def main():
    parser = argparse.ArgumentParser(description="Gives programs mutated and extreme scenes.")
    parser.add_argument("programs", nargs="+", metavar="PROGRAM")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", type=int, default=20000, help="how many")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--case", type=int, help="this one alone")
    parser.add_argument("--wide", type=int, default=200, help="how many scenes go to cost, plot and sweep")
    parser.add_argument("--wide-case", type=int, help="this one of them alone")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--keep", type=pathlib.Path, default=pathlib.Path("build/fuzz"), help="folder for failures")
    options = parser.parse_args()
    programs = [os.path.abspath(program) for program in options.programs]
    if options.case is not None:
        return 1 if repeat_case(options, programs) else 0
    if options.wide_case is not None:
        return 1 if run_wide_cases(options, programs) else 0
    failed = run_wide_cases(options, programs)
    return 1 if run_cases(options, programs) + failed else 0


if __name__ == "__main__":
    sys.exit(main())
