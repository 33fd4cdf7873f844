"""A history holds enough digits to go on from any of its rows."""
import re
import sys
import unittest

from support import CommandLineTest


class RestartFromRow(CommandLineTest):
    def check(self, bound, *settings):
        columns = ["--set", "output.columns='quaternion','angular_velocity'", *settings]
        self.succeed("run", "top.nml", "--quiet", "--output", "whole.csv", *columns)
        lines = self.read("whole.csv").splitlines()
        middle = lines[1 + (len(lines) - 1)//2].split(",")
        self.assertEqual(float(middle[0]), 0.5)
        # The digits as they stand in the file.
        start = f"&initial quaternion = {', '.join(middle[1:5])}, angular_velocity = {', '.join(middle[5:])} /"
        self.write("rest.nml", re.sub("&initial .*/", start, self.read("top.nml")))
        self.succeed("run", "rest.nml", "--quiet", "--output", "rest.csv", *columns,
                     "--set", "integrator.end_time=0.5")
        whole, rest = self.history("whole.csv")[1][-1], self.history("rest.csv")[1][-1]
        for one, other in zip(whole[1:5], rest[1:5]):
            self.assertLessEqual(abs(one - other), bound)
        for one, other in zip(whole[5:], rest[5:]):
            self.assertLessEqual(abs(one - other), 50*bound)

    def test_row_continues_the_run(self):
        # The spin of the row is rounded, and with it the 25 rad that follow.
        bound = 25*sys.float_info.epsilon
        for solver in ("full", "reduced"):
            self.check(bound, "--set", f"integrator.formulation='{solver}'")
        self.check(bound, "--set", "integrator.method='dop853'")


if __name__ == "__main__":
    unittest.main()
