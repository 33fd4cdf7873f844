"""Runs the tests of a folder, FOLDER/test_*.py, against the program that $NUTATE names.   run_python_tests.py FOLDER

Reports failures only and ends with a line `N passed, N failed, N skipped`, where a test with several failing parts counts once.
"""

import os
import sys
import unittest


def main():
    if not os.access(os.environ.get("NUTATE", ""), os.X_OK):
        sys.exit("NUTATE does not name a program")
    result = unittest.TestResult()
    unittest.defaultTestLoader.discover(sys.argv[1]).run(result)

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


if __name__ == "__main__":
    sys.exit(main())
