"""Torques by a table and rows at given times, from Python: the bits of the program."""

import os
import subprocess
import tempfile
import unittest

import numpy as np

import nutate

from test_nutate import read_csv

TABLE = """t (s),x (N m),y (N m),z (N m)
0.0137,1,0,-2
0.0731,2,0.5,1
0.0731,-1,0.5,1
0.1903,0,1,0.5
"""
SCENE = """&body inertia = 2.0, 3.0, 4.0 /
&initial angular_velocity = 0.7, -1.1, 0.9 /
&torque table = 'table.csv', outside = 'periodic', axes = 'space' /
&integrator time_step = 0.01, end_time = 0.5 /
"""
KEYS = {"outside": "periodic", "axes": "space"}


class TableTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.table = os.path.join(folder.name, "table.csv")
        self.scene = os.path.join(folder.name, "scene.nml")
        for path, text in ((self.table, TABLE), (self.scene, SCENE)):
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)

    def program(self, *settings):
        path = self.scene + ".csv"
        words = [word for setting in settings for word in ("--set", setting)]
        subprocess.run([os.environ["NUTATE"], "run", self.scene, "--quiet", "--output", path, *words], check=True)
        return read_csv(path)

    def test_an_inertia_that_varies(self):
        body = nutate.System(moments=(2.0, 1.5, 1.0))
        body.add("inertia_rate", tensor=(0.2, 0.15, 0.1))
        solution = nutate.solve(body, omega0=(0.8, -0.6, 1.4), t_span=(0, 5), accuracy=1e-10)
        rigid = nutate.solve(nutate.System(moments=(2.0, 1.5, 1.0)), omega0=(0.8, -0.6, 1.4), t_span=(0, 5), accuracy=1e-10)
        # J = J0 (1 + t/10) moves the body as the rigid one at 10 ln(1 + t/10).
        for t in (1.0, 3.0, 5.0):
            np.testing.assert_allclose(solution.sol(t)[0], rigid.sol(10 * np.log(1 + t / 10))[0], atol=1e-8)
            np.testing.assert_allclose((1 + t / 10) * solution.sol(t)[1], rigid.sol(10 * np.log(1 + t / 10))[1], atol=1e-8)
        with open(self.table, "w", encoding="utf-8") as file:
            file.write("t (s),J1 (kg m2),J2 (kg m2),J3 (kg m2)\n0,2,1.5,1\n10,4,3,2\n")
        table = nutate.System(text=f"&body inertia_table = '{self.table}' /")
        again = nutate.solve(table, omega0=(0.8, -0.6, 1.4), t_span=(0, 5), accuracy=1e-10)
        np.testing.assert_allclose(again.sol(5.0)[1], solution.sol(5.0)[1], atol=1e-9)

    def test_a_centre_of_mass_that_moves(self):
        with open(self.table, "w", encoding="utf-8") as file:
            file.write("t (s),x (m),y (m),z (m)\n0,0,0,0.1\n4,0,0,0.3\n")
        top = nutate.System(text=f"&body inertia = 2, 2, 1, mass = 3, center_of_mass_table = '{self.table}' / "
                            "&gravity acceleration = 0, 0, -10 /")
        stepper = nutate.Stepper(top, time_step=0.1, order=2)
        stepper.set_state(q=(1, 0, 0, 0), omega=(0, 0, 40))
        # m g h = 3 kg, 10 m/s2, 0.2 m.
        stepper.run(40)
        self.assertAlmostEqual(stepper.time_dependent_work, 6.0, delta=1e-12)

    def test_a_scene_with_a_table_and_times_is_that_of_the_program(self):
        for settings in (("integrator.order=4",), ("output.times=0.01,0.0123,0.4999",), ("output.degrees=.true.", "output.columns='euler'"),
                         ("integrator.method='taylor'", "output.times=0.0731,0.1,0.5")):
            expected, found = self.program(*settings), nutate.run(self.scene, *settings)
            self.assertEqual(list(expected), list(found))
            for name, values in expected.items():
                np.testing.assert_array_equal(found[name], values)

    def test_a_system_takes_a_table(self):
        system = nutate.System(moments=(2, 3, 4))
        system.add("torque", table=self.table, **KEYS)
        stepper = nutate.Stepper(system, time_step=0.01, order=4)
        stepper.set_state(q=(1, 0, 0, 0), omega=(0.7, -1.1, 0.9))
        rows, expected = stepper.run(50), self.program("integrator.order=4")
        for name in ("q0", "q1", "q2", "q3", "omega1", "omega2", "omega3", "work"):
            np.testing.assert_array_equal(rows[name], expected[name][1:], name)

    def test_a_table_that_is_none_is_refused_with_its_line(self):
        with open(self.table, "a", encoding="utf-8") as file:
            file.write("0.1,0,0,0\n")
        system = nutate.System(moments=(2, 3, 4))
        with self.assertRaisesRegex(nutate.NutateError, "table.csv:6: the time decreases"):
            system.add("torque", table=self.table, **KEYS)
        with self.assertRaisesRegex(nutate.NutateError, "table.csv:6: the time decreases"):
            nutate.run(self.scene)


if __name__ == "__main__":
    unittest.main()
