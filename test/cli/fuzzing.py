"""Fuzzing: mutated files and legal files with extreme values, each made from a seed and a number; and what a program must do
with them.

The same seed and number give the same case on every machine, as long as `scenes/` stays the same.
"""

import os
import pathlib
import random
import re
import shutil
import subprocess
import tempfile

from fuzz_mutations import BASES, MUTATIONS, make_overrides, stretch
from fuzz_scenes import CENTER, FRAME, INERTIA, MEASURED, MOTOR, POINTS, TABLE, TRACK, write_scene

LONGEST_RUN = 1000

# Time after which a program is taken to hang, and after which a sweep is given up, s: nothing limits the steps of its members.
PATIENCE, PATIENCE_FOR_SWEEPS = 600.0, 20.0


class Case:
    """One case: the bytes of the scene file and the overrides of the command line."""

    def __init__(self, text, overrides, legal):
        self.text = text
        self.overrides = overrides
        # Written key by key, not mutated.
        self.legal = legal


def make_case(seed, number):
    """The case of that seed and number."""
    dice = random.Random(f"nutate {seed} {number}")
    legal = dice.random() < 0.5
    if legal:
        return Case(write_scene(dice), [], True)
    text = write_scene(dice) if dice.random() < 0.3 else dice.choice(BASES)
    # Mostly one or two mutations: files with more fail at the first line.
    for _ in range(dice.choice((0, 1, 1, 1, 1, 2, 2, 3, 6, 20))):
        text = dice.choice(MUTATIONS)(dice, text)
    if dice.random() < 0.002:
        text = stretch(dice, text)
    return Case(text, make_overrides(dice), False)


class Verdict:
    """How a program took a case: what is wrong with it (blank: nothing), and the exit statuses of check and run."""

    def __init__(self, fault, statuses):
        self.fault = fault
        self.statuses = statuses


def arguments_of(command, case, longest=LONGEST_RUN):
    """The arguments of a command for a case whose scene is `scene.nml`; a run has so many steps at most."""
    arguments = [command, "scene.nml"]
    for override in case.overrides:
        arguments += ["--set", override]
    if command == "run":
        arguments += ["--quiet", "--max-steps", str(longest), "--output", "history.csv"]
    return arguments


class Overrun(Exception):
    """Raised by the runner of a assess: the command took longer than it may."""


def call(program, arguments, folder, patience=PATIENCE):
    """Runs a program in a folder, for so many seconds at most."""
    return subprocess.run([program, *arguments], cwd=folder, capture_output=True, stdin=subprocess.DEVNULL, timeout=patience,
                          check=False)


def assess(program, case, runner=call, longest=LONGEST_RUN):
    """Gives a case to `check` and `run` of a program, in an empty folder; `runner` runs them, as `call` does. A run has so many steps
    at most."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder)
        put_scene(path, case.text)
        statuses = []
        for command in ("check", "run"):
            try:
                done = runner(program, arguments_of(command, case, longest), folder)
            except subprocess.TimeoutExpired:
                return Verdict(f"{command}: hangs", statuses)
            except Overrun as reason:
                return Verdict(f"{command}: {reason}", statuses)
            statuses.append(done.returncode)
            fault = fault_of(command, case, done, path)
            if fault:
                return Verdict(f"{command}: {fault}", statuses)
        if statuses[0] != statuses[1] and 2 in statuses:
            return Verdict(f"check and run disagree: {statuses}", statuses)
        return Verdict("", statuses)


# Budget of a study, about a second, and its picture where gnuplot draws it.
BUDGET = ("--evaluations", "1000000")
COST_PLOT = ("--plot", "cost.svg") if shutil.which("gnuplot") else ()
WIDE_COMMANDS = (("cost", "scene.nml", *COST_PLOT), ("run", "scene.nml", "--quiet", "--max-steps", "200", "--output", "h.csv"),
                 ("plot", "h.csv", "--output", "h.svg"),
                 ("sweep", "scene.nml", "--set", "ensemble.members=3", "--output", "rows.npy"))


def make_wide_case(program, seed, number):
    """A legal scene of that seed and number that `check` admits: most others are refused by all commands alike."""
    dice = random.Random(f"nutate wide {seed} {number}")
    for _ in range(200):
        text = write_scene(dice)
        with tempfile.TemporaryDirectory() as folder:
            put_scene(pathlib.Path(folder), text)
            if call(program, ("check", "scene.nml"), folder).returncode == 0:
                break
    if b"&ensemble" not in text:
        text += b"&ensemble members = 3 /\n&vary key = 'initial.angular_velocity.3', distribution = 'normal', sigma = 0.1 /\n"
    return Case(text, [], True)


def assess_wide(program, case, runner=call, budget=BUDGET):
    """Gives a case to the commands that cost more than `check` and `run`: a study of costs of that budget, a picture, a sweep."""
    statuses = []
    with tempfile.TemporaryDirectory() as folder:
        put_scene(pathlib.Path(folder), case.text)
        for arguments in WIDE_COMMANDS:
            command = arguments[0]
            if command == "cost":
                arguments += budget
            if command == "plot" and not (shutil.which("gnuplot") and (pathlib.Path(folder) / "h.csv").exists()):
                continue
            # Only scenes whose run is short are swept; a member may still be long.
            if command == "sweep" and statuses[1] != 0:
                continue
            try:
                done = runner(program, arguments, folder, PATIENCE if command != "sweep" else PATIENCE_FOR_SWEEPS)
            except subprocess.TimeoutExpired:
                if command == "sweep":
                    continue
                return Verdict(f"{command}: hangs", statuses)
            except Overrun as reason:
                return Verdict(f"{command}: {reason}", statuses)
            statuses.append(done.returncode)
            fault = fault_of_wide(done)
            if fault:
                return Verdict(f"{command}: {fault}", statuses)
    return Verdict("", statuses)


def fault_of_wide(done):
    """What is wrong with what a command said and its exit status; blank where nothing is."""
    said = done.stdout + done.stderr
    if done.returncode not in (0, 2, 3):
        return f"exit status {done.returncode}, {done.stderr[-400:]!r}"
    if re.search(rb"runtime error|Backtrace|\bnan\b|[*]{3}", said, re.IGNORECASE):
        return f"a failure or a number that is none: {said[-400:]!r}"
    if done.returncode != 0 and len(done.stderr.strip()) < 10:
        return f"no reason: {done.stderr!r}"
    return ""


def put_scene(folder, text):
    """Writes a scene with the tables that it may name."""
    (folder / "scene.nml").write_bytes(text)
    (folder / "table.csv").write_bytes(TABLE)
    (folder / "motor.csv").write_bytes(MOTOR)
    (folder / "track.csv").write_bytes(TRACK)
    (folder / "center.csv").write_bytes(CENTER)
    (folder / "inertia.csv").write_bytes(INERTIA)
    (folder / "points.csv").write_bytes(POINTS)
    (folder / "measured.csv").write_bytes(MEASURED)
    (folder / "frame.aem").write_bytes(FRAME)


def fault_of(command, case, done, folder):
    """What is wrong with the outcome of a command; blank where nothing is."""
    said = done.stderr
    if done.returncode not in ((0, 2) if command == "check" else (0, 2, 3)):
        return f"exit status {done.returncode}, {said[-400:]!r}"
    if done.returncode == 0 and said:
        return f"a message though it succeeded: {said[-400:]!r}"
    if done.returncode != 0 and (said.count(b"\n") != 1 or not said.endswith(b"\n") or len(said) < 10):
        return f"not one line: {said[-400:]!r}"
    if not said.decode("utf-8", "replace")[:-1].isprintable() and said:
        return f"not printable: {said[-400:]!r}"
    if command == "check":
        if case.legal and re.search(rb"\bNaN\b|\*\*\*", done.stdout):
            return "a number that is none"
        return fault_of_files(folder, [])
    if done.returncode == 0:
        return fault_of_files(folder, ["history.csv"]) or fault_of_history(folder / "history.csv")
    if done.returncode == 3 and (folder / "history.csv.partial").exists():
        return fault_of_files(folder, ["history.csv.partial"]) or fault_of_history(folder / "history.csv.partial")
    return fault_of_files(folder, [])


def fault_of_files(folder, expected):
    events = {name.replace("history.", "history.events.") for name in expected}
    found = sorted(set(os.listdir(folder)) - {"scene.nml", "table.csv", "motor.csv", "track.csv", "center.csv", "inertia.csv",
                                           "points.csv", "measured.csv", "frame.aem"} - events)
    return "" if found == expected else f"left {found} instead of {expected}"


def fault_of_history(path):
    """Whole rows of finite numbers, or what is wrong."""
    text = path.read_bytes()
    if not text.endswith(b"\n"):
        return f"{path.name}: the last row is not whole"
    header, *rows = text.lower().splitlines()
    if b"n" in b"".join(rows) or b"*" in b"".join(rows):
        return f"{path.name}: a number that is none"
    if any(row.count(b",") != header.count(b",") for row in rows):
        return f"{path.name}: a row of another length"
    return ""
