"""nutate.plot, and the symbols and colours of columns."""

import unittest

import numpy as np

import nutate

try:
    import matplotlib  # noqa: F401
except ImportError:
    matplotlib = None


def make_box():
    """The body of scenes/box.nml."""
    return nutate.System(shape="box", size=(4, 1, 2), mass=12)


def legends(figure):
    """Titles of the panels, and the symbols of their curves."""
    return [(axes.get_title(loc="left"), [text.get_text() for text in axes.get_legend().get_texts()]) for axes in figure.axes]


class Looks(unittest.TestCase):
    def test_symbols(self):
        for column, expected in (("omega1", ("$Ω_1$", "Ω<sub>1</sub>", "Ω₁")), ("q0", ("$q_0$", "q<sub>0</sub>", "q₀")),
                                 ("l_y", ("$l_y$", "l<sub>y</sub>", "lᵧ")), ("theta_deg", ("θ", "θ", "θ")),
                                 ("wheel2_speed", ("wheel 2",) * 3), ("depth_of_water", ("depth_of_water",) * 3)):
            self.assertEqual(tuple(nutate.symbol(column, style) for style in ("mathtext", "html", "unicode")), expected)
        self.assertRaises(nutate.NutateValueError, nutate.symbol, "q0", "latex")

    def test_one_quantity_has_one_colour(self):
        self.assertEqual(len({nutate.colour(f"omega{i}") for i in (1, 2, 3)}), 3)
        for same in (("omega1", "L1", "l_x", "q1", "phi"), ("omega3", "psi", "l_z", "wheel3_speed"), ("q0", "norm_error")):
            self.assertEqual(len({nutate.colour(name) for name in same}), 1, same)


@unittest.skipUnless(matplotlib, "matplotlib is not here")
class Pictures(unittest.TestCase):
    def test_what_is_drawn(self):
        solution = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 2))
        symbols = sum((names for _, names in legends(nutate.plot(solution))), [])
        self.assertEqual(symbols, ["$Ω_1$", "$Ω_2$", "$Ω_3$", "$q_0$", "$q_1$", "$q_2$", "$q_3$", "$l_x$", "$l_y$", "$l_z$"])
        more = sum((names for _, names in legends(nutate.plot(solution, residuals=True))), [])
        self.assertEqual(more[len(symbols):], ["residual", "q·q − 1", "q·p"])
        self.assertEqual(legends(nutate.plot(solution, "total", "omega3")),
                         [("angular velocity Ω (rad/s)", ["$Ω_3$"]), ("energy (J)", ["T + V"])])
        self.assertRaises(nutate.NutateValueError, nutate.plot, solution, "omega4")

    def test_curves_come_from_dense_output_and_differ(self):
        solution = nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 2), method="taylor")
        self.assertGreater(len(nutate.plot(solution, "omega1").axes[0].lines[0].get_xdata()), 10 * len(solution.t))
        rows = {"t": np.arange(4.0), "omega1": np.arange(4.0), "omega2": np.arange(4.0)}
        self.assertEqual([line.get_linestyle() for line in nutate.plot(rows).axes[0].lines], ["-", "--"])

    def test_angles_that_wrap_are_broken(self):
        for name, revolution in (("roll", 2*np.pi), ("yaw_deg", 360)):
            rows = {"t": np.arange(3.0), name: np.array([0.4, 0.49, -0.49])*revolution}
            t, values = nutate.plot(rows).axes[0].lines[0].get_data()
            self.assertEqual([len(t), int(np.isnan(values).sum()), np.isnan(values[2])], [4, 1, True])
        rows = {"t": np.arange(3.0), "true_anomaly": np.array([0.0, 6.2, 12.4])}
        self.assertEqual(len(nutate.plot(rows).axes[0].lines[0].get_xdata()), 3)

    def test_what_has_no_rows_is_rejected(self):
        for rows in ({}, {"omega1": np.zeros(2)}, {"t": np.arange(2.0)}, {"t": np.zeros(0), "omega1": np.zeros(0)}):
            with self.assertRaisesRegex(nutate.NutateValueError, "no rows to plot"):
                nutate.plot(rows)

    def test_pyplot_knows_the_figure_of_a_program_that_uses_it(self):
        matplotlib.use("Agg")
        from matplotlib import pyplot
        before = pyplot.get_fignums()
        figure = nutate.plot(nutate.solve(make_box(), omega0=(0.1, 0, 10), t_span=(0, 2)))
        self.addCleanup(pyplot.close, figure)
        self.assertIs(pyplot.gcf(), figure)
        self.assertEqual(len(pyplot.get_fignums()), len(before) + 1)


if __name__ == "__main__":
    unittest.main()
