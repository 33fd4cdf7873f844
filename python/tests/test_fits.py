"""nutate.fit and nutate.FitProblem: what they return agrees with the program, with differences and with a Gauss-Newton fit."""

import os
import subprocess
import tempfile
import unittest

import numpy as np

import nutate

TRUTH = """&body inertia = 5, 20, 17 /
&initial quaternion = 0.9, 0.3, -0.1, 0.3, angular_velocity = 3, 1, 5 /
&integrator time_step = 0.001, end_time = 1.0 /
&output every = 50, columns = 'angular_velocity', 'quaternion' /
"""
SCENE = """&body inertia = 5.1, 20.0, 17.0 /
&initial quaternion = 0.9, 0.3, -0.3, 0.1, angular_velocity = 3.0, 1.0, 5.0 /
&integrator local_tolerance = 1e-10, end_time = 1.0 /
&free key = 'initial.attitude' /
&free key = 'initial.angular_velocity', sigma = 0.1, 0.1, 0.1 /
&free key = 'body.inertia.1', low = 4, high = 7 /
&measurement file = '{0}', columns = 'omega1', 'omega2', 'omega3', sigma = 0.01, bias = 'constant' /
&measurement file = '{0}', columns = 'q0', 'q1', 'q2', 'q3', sigma = 0.02 /
"""


class FitTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        data = os.path.join(cls.folder.name, "data.csv")
        nutate.Scene(text=TRUTH).write(data)
        cls.path = os.path.join(cls.folder.name, "fit.nml")
        with open(cls.path, "w", encoding="utf-8") as file:
            file.write(SCENE.format("data.csv"))

    def test_the_jacobian_is_the_difference_of_residuals(self):
        problem = nutate.FitProblem(self.path)
        self.assertEqual(len(problem.names), 10)
        self.assertEqual((problem.bounds[0][6], problem.bounds[1][6], problem.bounds[1][0]), (4, 7, np.inf))
        # An attitude far from that of the scene: the derivative is by the rotation vector, not by a further turn.
        x = problem.x0 + np.array([0.4, -0.3, 0.7, 0.01, -0.02, 0.03, 0.2, 0.1, -0.1, 0.05])
        jacobian, h = problem.jacobian(x), 1e-4
        for k in range(10):
            step = np.zeros(10)
            step[k] = h
            f = [problem.residuals(x + i * step) for i in (-2, -1, 1, 2)]
            difference = (f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * h)
            # The tolerance of the steps over h and sigma.
            np.testing.assert_allclose(jacobian[:, k], difference, atol=1e-6 * np.abs(jacobian[:, k]).max(), err_msg=problem.names[k])

    def test_a_fit_is_that_of_gauss_and_newton(self):
        result, problem = nutate.fit(self.path), nutate.FitProblem(self.path)
        self.assertTrue(result.success, result.message)
        x = problem.x0
        for _ in range(12):
            x = x - np.linalg.lstsq(problem.jacobian(x), problem.residuals(x), rcond=None)[0]
        error = np.sqrt(np.diag(result.cov))
        self.assertLess(np.abs((result.x - x) / error).max(), 1e-4)
        self.assertAlmostEqual(result.x[6], 5.0, delta=3 * error[6])
        np.testing.assert_allclose(result.cov, np.linalg.inv(result.jac.T @ result.jac), rtol=1e-5, atol=1e-6 * error.max() ** 2)
        np.testing.assert_array_equal(result.fun, problem.residuals(result.x))
        self.assertAlmostEqual(result.cost, -problem.log_likelihood(result.x), delta=1e-12)

    def test_the_cost_is_what_was_minimised(self):
        with open(os.path.join(self.folder.name, "data.csv"), encoding="utf-8") as file:
            lines = file.read().splitlines()
        row = lines[5].split(",")
        row[5] = repr(float(row[5]) + 1)
        with open(os.path.join(self.folder.name, "outlier.csv"), "w", encoding="utf-8") as file:
            file.write("\n".join(lines[:5] + [",".join(row)] + lines[6:]) + "\n")
        with open(self.path + ".outlier", "w", encoding="utf-8") as file:
            file.write(SCENE.format("outlier.csv").replace("sigma = 0.01,", "sigma = 0.01, loss = 'huber',"))
        result, problem = nutate.fit(self.path + ".outlier"), nutate.FitProblem(self.path + ".outlier")
        z = result.fun ** 2
        z[:63] = np.where(z[:63] <= 1, z[:63], 2 * np.sqrt(z[:63]) - 1)
        self.assertAlmostEqual(result.cost, 0.5 * z.sum(), delta=1e-12)
        self.assertEqual(result.cost, problem.cost(result.x))
        self.assertLess(result.cost, 0.5 * float(result.fun @ result.fun) - 100)
        self.assertLess(result.cost, problem.cost(result.x + 0.1 * np.sqrt(np.diag(result.cov))))

    def test_a_fit_that_noise_does_not_explain_fails(self):
        with open(self.path + ".wrong", "w", encoding="utf-8") as file:
            file.write(SCENE.format("data.csv").replace("5.1, 20.0, 17.0", "5.1, 21.0, 17.0"))
        result = nutate.fit(self.path + ".wrong")
        self.assertFalse(result.success)
        self.assertRegex(result.message, "noise of the given sigma exceeds.* sigma at t = .* s of .*data.csv")

    def test_the_program_finds_the_same(self):
        result = nutate.fit(self.path)
        done = subprocess.run([os.environ["NUTATE"], "fit", self.path, "--output", "-", "--csv", os.devnull],
                              capture_output=True, text=True, check=False, cwd=self.folder.name)
        self.assertEqual(done.returncode, 0, done.stderr)
        line = next(line for line in done.stdout.splitlines() if "inertia" in line and "=" in line)
        self.assertAlmostEqual(float(line.split("=")[1].split(",")[0]), result.x[6], delta=1e-9)

    def test_what_is_refused(self):
        with self.assertRaisesRegex(nutate.NutateValueError, "there is nothing to fit"):
            nutate.fit(nutate.Scene(text=TRUTH))
        problem = nutate.FitProblem(self.path)
        with self.assertRaises(nutate.NutateValueError):
            problem.residuals(problem.x0 * np.nan)
        with self.assertRaises(ValueError):
            problem.jacobian(problem.x0[:3])
        self.assertEqual(problem.log_likelihood(problem.x0 + 100), -np.inf)


if __name__ == "__main__":
    unittest.main()
