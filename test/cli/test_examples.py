"""The programs of example/, built beside the program, run and say what they should."""
import os
import re
import subprocess
import unittest

from support import PATIENCE

PROJECT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def numbers(line):
    return [float(word) for word in re.findall(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?", line)]


class Examples(unittest.TestCase):
    NAMES = ("box_by_hand", "custom_potential", "custom_torque", "satellite_by_hand", "top_precession")

    def output(self, name):
        """What an example prints, line by line."""
        # CMake puts the folder beside the program, fpm beside the folder of the program.
        beside = os.path.dirname(os.path.realpath(os.environ["NUTATE"]))
        folders = [os.path.join(place, "example") for place in (beside, os.path.dirname(beside))]
        folder = next((folder for folder in folders if any(os.path.isfile(os.path.join(folder, name)) for name in self.NAMES)), None)
        if folder is None:
            self.skipTest("a build of the program alone")
        done = subprocess.run([os.path.join(folder, name)], capture_output=True, text=True, timeout=PATIENCE,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.splitlines()

    def test_every_example_is_tested_here(self):
        names = sorted(name[:-4] for name in os.listdir(os.path.join(PROJECT, "example")) if name.endswith(".f90"))
        self.assertEqual(names, list(self.NAMES))

    def test_box_by_hand_prints_a_motion(self):
        self.assertGreater(len(self.output("box_by_hand")), 5)

    def test_custom_potential_keeps_energy_and_momentum(self):
        last = numbers(self.output("custom_potential")[-1])
        self.assertLess(max(abs(error) for error in last[-2:]), 1e-13)

    def test_custom_torque_keeps_the_energy_account(self):
        last = numbers(self.output("custom_torque")[-1])
        self.assertLess(abs(last[-1]), 1e-13)

    def test_satellite_points_to_the_earth_and_the_account_closes(self):
        last = numbers(self.output("satellite_by_hand")[-1])
        self.assertLess(max(abs(angle) for angle in last[1:4]), 0.1)
        self.assertLess(abs(last[-1]), 1e-12)

    def test_precession_converges_to_ten(self):
        rows = [numbers(line) for line in self.output("top_precession")[1:]]
        self.assertAlmostEqual(rows[-1][1], 10.0, delta=2e-3)
        self.assertAlmostEqual(rows[0][2] / rows[1][2], 4.0, delta=0.1)
