#!/usr/bin/env python3
"""Finds clocks in tests: what `make test` and .ci/run assert must not depend on how fast or how busy a machine is.

Tests count steps and evaluations instead, and so do the commands of the documentation, which the tests run. Tests that need a
clock are in test/timing/ and python/timing/, which only `make stress` runs.
    python3 tools/lint/clocks.py      exit status 1 if a test reads a clock or has a budget in seconds
"""

import pathlib
import re
import sys

from tracked import names_of

ROOT = pathlib.Path(__file__).resolve().parents[2]
TESTS = ("test", "python/tests", "mpi/test", "link", "example", "README.md", "docs/*.md")
SOURCES = (".f90", ".F90", ".f", ".c", ".cpp", ".h", ".py", ".sh")
CLOCK = re.compile(r"\b(monotonic|perf_counter|process_time|processor_seconds|system_clock|cpu_time|clock_gettime|gettimeofday"
                   r"|date_and_time|getrusage|time\.time|timeit)\b|\bclock\(\)|os\.times|(?<![\w-])--seconds\b", re.IGNORECASE)


def main():
    found = 0
    for name in names_of(*TESTS):
        path = ROOT / name
        if path.suffix not in (*SOURCES, ".md") or name.startswith("test/timing/"):
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            # Only commands in the console blocks of a page run.
            if (match := CLOCK.search(line)) and (path.suffix != ".md" or line.startswith("$ ")):
                print(f"{name}:{number}: '{match[0]}' in a test (count steps or evaluations, or move it to test/timing/)")
                found += 1
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
