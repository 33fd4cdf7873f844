"""Runs the tests of a folder, FOLDER/test_*.py, against the program that $NUTATE names, or those of the modules named.
   run_python_tests.py FOLDER [MODULE]...

Each module in a process of its own, $NUTATE_JOBS at a time, or as many as there are cores. Reports failures only and ends with
a line `N passed, N failed, N skipped`, where a test with several failing parts counts once, and a module that breaks off too.
"""

import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import unittest

# Runs one module in this process.
HERE = "--here"
TOTAL = re.compile(r"(\d+) passed, (\d+) failed, (\d+) skipped")


def run_module(folder, name):
    """Runs one module here; its exit status."""
    result = unittest.TestResult()
    unittest.defaultTestLoader.discover(folder, pattern=f"{name}.py").run(result)

    bad = result.errors + result.failures
    for test, report in bad:
        print(f"{test}\n{report}")
    for test in result.unexpectedSuccesses:
        print(f"{test}\nunexpected success")
    for test, reason in result.skipped:
        print(f"{test} skipped: {reason}")

    # A subtest's failure belongs to its test.
    failed = {getattr(test, "test_case", test).id() for test, _ in bad}
    failed |= {test.id() for test in result.unexpectedSuccesses}
    # A class that is skipped as a whole counts once, and none of its tests has run.
    skipped = sum(isinstance(test, unittest.TestCase) for test, _ in result.skipped)
    passed = max(result.testsRun - len(failed) - skipped, 0)
    print(f"{passed} passed, {len(failed)} failed, {len(result.skipped)} skipped")
    return 1 if failed else 0


def start_module(folder, name):
    """Runs one module in a process of its own: its report, and what its tests came to."""
    done = subprocess.run([sys.executable, __file__, HERE, folder, name], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, errors="replace", check=False)
    lines = done.stdout.splitlines()
    total = TOTAL.fullmatch(lines[-1]) if lines else None
    if total and (done.returncode == 0) == (total[2] == "0"):
        return lines[:-1], [int(count) for count in total.groups()]
    return [*lines, f"{name} broke off with exit status {done.returncode}"], [0, 1, 0]


def main():
    if not os.access(os.environ.get("NUTATE", ""), os.X_OK):
        sys.exit("NUTATE does not name a program")
    if sys.argv[1] == HERE:
        sys.exit(run_module(*sys.argv[2:]))
    modules = sorted(path.stem for path in pathlib.Path(sys.argv[1]).glob("test_*.py"))
    if unknown := set(sys.argv[2:]).difference(modules):
        sys.exit(f"{sys.argv[1]} has no {', '.join(sorted(unknown))}")
    modules = sys.argv[2:] or modules
    if not modules:
        sys.exit(f"{sys.argv[1]} has no tests (expected test_*.py)")
    counts = [0, 0, 0]
    with concurrent.futures.ThreadPoolExecutor(int(os.environ.get("NUTATE_JOBS") or os.cpu_count())) as pool:
        for lines, came_to in pool.map(lambda name: start_module(sys.argv[1], name), modules):
            print(*lines, sep="\n", end="\n" if lines else "", flush=True)
            counts = [a + b for a, b in zip(counts, came_to)]
    print("{} passed, {} failed, {} skipped".format(*counts))
    return 1 if counts[1] else 0


if __name__ == "__main__":
    sys.exit(main())
