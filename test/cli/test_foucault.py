"""scenes/foucault.nml: the rate at which the plane of the pendulum turns."""
import math
import unittest

from support import ROOT, CommandLineTest

EARTH, LATITUDE, TILT = 7.292115e-5, math.radians(48.8462), math.radians(3)
# Whole periods of the pendulum, 16.42 s, to a tenth of a second.
WINDOW = 328


def plane_of(rows):
    """Azimuth of the principal axis of the bob's path, rad."""
    bobs = [(-2 * (q1 * q3 + q0 * q2), 2 * (q0 * q1 - q2 * q3)) for _, q0, q1, q2, q3, *_ in rows]
    xx, xy, yy = (sum(bob[i] * bob[j] for bob in bobs) for i, j in ((0, 0), (0, 1), (1, 1)))
    return 0.5 * math.atan2(2 * xy, xx - yy)


class Foucault(CommandLineTest):
    def test_the_plane_turns_with_the_sine_of_the_latitude(self):
        self.succeed("run", str(ROOT / "scenes/foucault.nml"), "--quiet", "--output", "foucault.csv")
        header, rows = self.history("foucault.csv")
        rate = (plane_of(rows[-WINDOW:]) - plane_of(rows[:WINDOW])) / (rows[-WINDOW][0] - rows[0][0])
        # The ellipse of the bob precesses by itself, against the Earth (Airy).
        expected = -EARTH * math.sin(LATITUDE) * (1 - 3 / 8 * TILT**2)
        self.assertAlmostEqual(rate / expected, 1, delta=5e-4)
        residual = header.index("energy_residual")
        self.assertLess(max(abs(row[residual]) for row in rows), 1e-9)


if __name__ == "__main__":
    unittest.main()
