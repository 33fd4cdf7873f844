"""Bodies whose inertia varies: what runs print, tables and their errors, sweeps and fits."""
import re
import unittest

from support import CommandLineTest

TABLE = "t (s),J1 (kg m2),J2 (kg m2),J3 (kg m2)\n0,1.5,2,2.5\n2,1.6,2.4,2.9\n4,1.7,2.6,3\n6,1.7,3,3.4\n"
REST = """&initial angular_velocity = 0.3, 0.1, 1.2 /
&integrator method = 'nielsen_krenk', order = 8, formulation = 'reduced', time_step = 0.05, end_time = 5.0 /
&output columns = 'angular_velocity', 'angular_momentum_space', 'energy', 'time_dependent_work' /
"""
BOOM = "&body inertia_table = 'table.csv' /\n" + REST
RATE = "&body inertia = 1.5, 2.0, 2.5 /\n&inertia_rate tensor = 0.05, 0.2, 0.2, start = 1.0, stop = 4.0 /\n" + REST


class VaryingInertia(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("table.csv", TABLE)
        self.write("boom.nml", BOOM)
        self.write("rate.nml", RATE)

    def test_momentum_stays_and_the_balance_closes(self):
        for name in ("boom", "rate"):
            page = self.succeed("run", f"{name}.nml").stderr
            self.assertIn("work of time-dependent inertia", page)
            _, rows = self.history(f"{name}.csv")
            for row in rows:
                for component in (4, 5, 6):
                    self.assertAlmostEqual(row[component], rows[0][component], delta=1e-14)
                self.assertLess(abs(row[11]), 1e-14)
                self.assertAlmostEqual(row[9] - row[12], rows[0][9], delta=1e-14)
            self.assertLess(rows[-1][12], -0.1)

    def test_every_method_ends_at_the_same_rate(self):
        self.succeed("run", "boom.nml", "--quiet")
        expected = self.history("boom.csv")[1][-1][1:4]
        for method in ("rk8", "dop853", "taylor"):
            settings = (f"integrator.method={method}", "integrator.conserve=.true.", "integrator.time_step=0.02")
            self.succeed("run", "boom.nml", "--quiet", "--output", f"{method}.csv", "--unset", "integrator.order", "--unset",
                         "integrator.formulation", *(word for setting in settings for word in ("--set", setting)))
            for value, other in zip(self.history(f"{method}.csv")[1][-1][1:4], expected):
                self.assertAlmostEqual(value, other, delta=1e-12)

    def test_check_tells_what_varies(self):
        page = self.succeed("check", "boom.nml").stdout
        for text in ("varies with time: the moments are those of t = 0, the centre of mass stays", "but the change of the inertia"):
            self.assertIn(text, page)
        page = self.succeed("check", "rate.nml", "--set", "inertia_rate.mass_leaves=.true.").stdout
        self.assertIn("varies with time as mass leaves: the moments", page)

    def test_errors_name_line_and_time(self):
        self.write("table.csv", TABLE.replace("4,1.7,2.6,3\n", "4,1.7,2.6,4.4\n"))
        self.fail_with(2, "check", "boom.nml", says=("table.csv:4: no rigid body has the principal moments",))
        self.write("table.csv", TABLE.replace("J3 (kg m2)", "J3"))
        self.fail_with(2, "check", "boom.nml", says=("table.csv:1:", "lacks the unit (kg m2)"))
        self.write("table.csv", TABLE.replace("2,1.6", "0,1.6"))
        self.fail_with(2, "check", "boom.nml", says=("table.csv:3: the time repeats",))
        self.write("table.csv", TABLE)
        self.fail_with(2, "check", "boom.nml", "--set", "integrator.end_time=7",
                       says=("end_time is outside of the table of the inertia (expected 0 to 6 s)",))
        self.fail_with(2, "check", "rate.nml", "--set", "inertia_rate.tensor=0,0,1", says=("at t = 2.000000 s",))
        self.fail_with(2, "check", "rate.nml", "--set", "output.columns='tumbling'", says=("a constant inertia",))
        self.fail_with(2, "run", "rate.nml", "--set", "integrator.method='exact'", "--unset", "integrator.order", "--unset",
                       "integrator.formulation", says=("method 'exact' has no solution for an inertia that varies",))
        self.fail_with(2, "linearize", "rate.nml", says=("the inertia varies with time",))

    def test_a_sweep_of_rates(self):
        self.write("sweep.nml", RATE + "&ensemble members = 3, seed = 1 /\n"
                   "&vary key = 'inertia_rate.tensor.3', distribution = 'uniform', low = 0.1, high = 0.2 /\n")
        self.succeed("sweep", "sweep.nml", "--quiet", "--csv", "sweep.csv")
        header, rows = self.history("sweep.csv")
        self.assertEqual(len(rows), 3)
        # The inertia at the end is that of the member: l = (J + 3 K) omega about axis 3.
        rate, omega = header.index("inertia_rate.tensor.3"), header.index("omega3")
        self.assertEqual(len({row[omega] for row in rows}), 3)
        self.assertEqual([row[omega] for row in sorted(rows, key=lambda row: row[rate])], sorted((row[omega] for row in rows), reverse=True))

    def test_a_fit_finds_rates_and_scale(self):
        for name, key, near in (("rate", "inertia_rate.tensor.3", "inertia_rate.tensor=0.05,0.2,0.15"),
                                ("boom", "body.inertia_scale", "body.inertia_scale=1.02")):
            scene = self.read(f"{name}.nml")
            if name == "boom":
                scene = scene.replace("'table.csv'", "'table.csv', inertia_scale = 1")
            scene += "&gravity acceleration = 0, 0, -1 /\n"
            scene = scene.replace("&body ", "&body mass = 1.0, center_of_mass = 0.0, 0.0, 0.3, ")
            self.write("truth.nml", scene)
            self.succeed("run", "truth.nml", "--quiet", "--output", "truth.csv")
            self.write("fit.nml", scene + f"&free key = '{key}' /\n&measurement file = 'truth.csv', sigma = 0.01, "
                       "columns = 'omega1', 'omega2', 'omega3' /\n")
            page = self.succeed("fit", "fit.nml", "--set", near).stdout
            value = float(re.search(key.replace(".", r"\.") + r" +(\S+) ±", page)[1])
            self.assertAlmostEqual(value, 1.0 if name == "boom" else 0.2, delta=1e-7)


if __name__ == "__main__":
    unittest.main()
