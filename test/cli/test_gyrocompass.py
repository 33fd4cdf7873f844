"""scenes/gyrocompass.nml: the path of the axis by the equations of a rotor without inertia, and where it rests."""
import math
import unittest

from support import ROOT, CommandLineTest

# Of the scene: momentum, weight times its lever, what the fluid resists with about axes 1 and 3; the Earth at 50 degrees.
MOMENTUM, WEIGHT, FLUID = 15.0, 50.0 * 9.81 * 0.001, (0.1, 0.45)
LEVEL, UPRIGHT = (7.292115e-5 * part(math.radians(50)) for part in (math.cos, math.sin))
REST = 0.0017058357338493677566


def turn(place):
    """Rates of azimuth (to the east) and elevation where rotor, weight and fluid are in balance, rad/s."""
    azimuth, elevation = place
    aside = UPRIGHT * math.cos(elevation) - LEVEL * math.cos(azimuth) * math.sin(elevation) \
        - WEIGHT / MOMENTUM * math.sin(elevation)
    first, third = (part / MOMENTUM for part in FLUID)
    aside = (aside - first * LEVEL * math.sin(azimuth)) / (1 + first * third)
    return aside / math.cos(elevation), LEVEL * math.sin(azimuth) + third * aside


def follow(place, rows, step):
    """The path by the classical Runge-Kutta method."""
    path = [place]
    for _ in range(rows):
        first = turn(place)
        second = turn([x + step / 2 * v for x, v in zip(place, first)])
        third = turn([x + step / 2 * v for x, v in zip(place, second)])
        fourth = turn([x + step * v for x, v in zip(place, third)])
        place = [x + step / 6 * (a + 2 * b + 2 * c + d) for x, a, b, c, d in zip(place, first, second, third, fourth)]
        path.append(place)
    return path


def axis_of(q):
    """Azimuth and elevation of body axis 2, rad."""
    east, north = 2 * (q[1] * q[2] - q[0] * q[3]), q[0]**2 - q[1]**2 + q[2]**2 - q[3]**2
    return math.atan2(east, north), math.asin(2 * (q[2] * q[3] + q[0] * q[1]))


class Gyrocompass(CommandLineTest):
    def test_the_axis_finds_north(self):
        # The inertia of the float adds to the path what is proportional to it: next to nothing in a light one.
        for inertia, solver, aside, above in (("1,1.2,1.4", "reduced", 1.5e-3, 6e-5), ("0.1,0.12,0.14", "reduced", 1.5e-4, 6e-6),
                                              ("0.1,0.12,0.14", "full", 1.5e-4, 6e-6)):
            self.succeed("run", str(ROOT / "scenes/gyrocompass.nml"), "--quiet", "--output", "compass.csv", "--set",
                         f"body.inertia={inertia}", "--set", f"integrator.formulation={solver}")
            header, rows = self.history("compass.csv")
            residual = header.index("energy_residual")
            for row, (azimuth, elevation) in zip(rows, follow((math.pi / 3, 0.0), len(rows) - 1, rows[1][0])):
                east, up = axis_of(row[1:5])
                self.assertAlmostEqual(east, azimuth, delta=aside)
                self.assertAlmostEqual(up, elevation, delta=above)
                self.assertLess(abs(row[residual]), 1e-14)
            self.assertAlmostEqual(east, 0.0, delta=2e-5)
            self.assertAlmostEqual(up, REST, delta=2e-6)


if __name__ == "__main__":
    unittest.main()
