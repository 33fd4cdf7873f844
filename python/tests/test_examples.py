"""The gallery in examples/: each script checks itself against something exact, and says so by its exit status."""

import glob
import os
import subprocess
import sys
import tempfile
import unittest

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "examples")
SAYS = {"accuracy_cost.py": "every accuracy was kept", "ensemble.py": "200 members turn over at 0.9775 s",
        "many_bodies.py": "1000 dipoles, 2000 steps: energy off by",
        "intermediate_axis.py": "10 times in 20 s, the first at 0.966409483", "satellite.py": "period 3722.2087",
        "top_exact.py": "nods between 34.377 and 91.471 degrees"}


class GalleryTest(unittest.TestCase):
    def test_every_script_finds_what_it_should(self):
        self.assertEqual(sorted(os.path.basename(path) for path in glob.glob(os.path.join(FOLDER, "*.py"))), sorted(SAYS))
        for name, says in SAYS.items():
            with self.subTest(name=name), tempfile.TemporaryDirectory() as folder:
                ran = subprocess.run([sys.executable, os.path.join(FOLDER, name)], cwd=folder, capture_output=True, text=True)
                self.assertEqual((ran.returncode, ran.stderr), (0, ""), ran.stdout + ran.stderr)
                self.assertIn(says, ran.stdout)
                self.assertEqual(os.listdir(folder), [])


if __name__ == "__main__":
    unittest.main()
