"""Inner spheres: their columns, events, switches, fits, and what the summary says of them."""
import unittest

from support import SPHERE_COLUMNS, CommandLineTest

SCENE = """&body inertia = 1.7, 1.1, 0.9 /
&inner_sphere inertia = 0.3, damping = 0.5, name = 'core' /
&inner_sphere inertia = 0.05, damping = 0.01, angular_velocity = 0.3, -0.2, 0.1 /
&initial angular_velocity = 0.02, 0.01, 2.0 /
&integrator order = 4, time_step = 0.02, end_time = 10.0 /
&output columns = 'angular_momentum_space', 'energy', 'sphere1', 'sphere2', 'works' /
"""


class InnerSpheres(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("spheres.nml", SCENE)

    def rows(self, *options):
        self.succeed("run", "spheres.nml", "--quiet", "--output", "rows.csv", *options)
        header, rows = self.history("rows.csv")
        return [dict(zip(header, row)) for row in rows]

    def test_columns_have_their_names_and_sums(self):
        rows = self.rows()
        self.assertEqual(list(rows[0])[9:], SPHERE_COLUMNS["sphere1"] + SPHERE_COLUMNS["sphere2"] + ["work_sphere1", "work_sphere2"])
        first, last = rows[0], rows[-1]
        for i, rate in enumerate((0.3, -0.2, 0.1)):
            self.assertAlmostEqual(first[f"sphere2_rate{i + 1}"], rate, delta=1e-15)
            self.assertAlmostEqual(first[f"sphere2_momentum_{'xyz'[i]}"], 0.05 * (rate + (0.02, 0.01, 2.0)[i]), delta=1e-15)
        for row in rows:
            self.assertLess(abs(row["energy_residual"]), 1e-14)
            for axis in "xyz":
                self.assertAlmostEqual(row[f"l_{axis}"], first[f"l_{axis}"], delta=1e-14)
        for i in "12":
            self.assertAlmostEqual(last[f"work_sphere{i}"], last[f"sphere{i}_friction_work"], delta=1e-15)
            self.assertLess(last[f"work_sphere{i}"], 0)
        self.assertAlmostEqual(last["work_sphere1"] + last["work_sphere2"], last["work"], delta=1e-14)

    def test_the_summary_tells_their_work(self):
        text = self.succeed("run", "spheres.nml").stderr
        for words in ("work of inner sphere 1 'core'", "work of inner sphere 2 ", "all components"):
            self.assertIn(words, text)
        self.assertEqual(text.count("work of inner sphere"), 2)

    def test_events_see_them_and_switch_their_friction(self):
        self.write("spheres.nml", SCENE + "&event name = 'slow', when = 'sphere2_rate1', crosses = 0, direction = -1, "
                   "switch = 'core off' /\n")
        rows = self.rows()
        self.assertIn("slow", self.read("rows.events.csv"))
        works = [row["work_sphere1"] for row in rows]
        self.assertEqual(works[-1], works[-100])
        self.assertLess(works[-1], 0)
        self.assertLess(max(abs(row["energy_residual"]) for row in rows), 1e-13)

    def test_every_method_follows_them(self):
        wanted = self.rows("--set", "integrator.order=8")[-1]
        for method in ("dop853", "rk8", "taylor"):
            last = self.rows("--set", f"integrator.method={method}", "--unset", "integrator.order")[-1]
            for name in wanted:
                if name != "energy_residual":
                    self.assertAlmostEqual(last[name], wanted[name], delta=1e-11, msg=f"{method} {name}")

    def test_what_has_none_rejects_them(self):
        self.fail_with(2, "run", "spheres.nml", "--set", "integrator.method=exact", "--unset", "integrator.order",
                       says=("expected no effects",))
        self.fail_with(2, "linearize", "spheres.nml", says=("inner spheres have no linear system",))
        self.fail_with(2, "run", "spheres.nml", "--set", "output.columns='sphere3'", says=("refer to an inner sphere that does not exist",))
        for setting, words in (("inertia=0", "a number > 0 for inertia"), ("damping=-1", "a number > 0 for damping")):
            self.fail_with(2, "run", "spheres.nml", "--set", f"inner_sphere.1.{setting}", says=(words,))
        self.write("many.nml", SCENE + 3 * "&inner_sphere inertia = 0.3, damping = 0.5 /\n")
        self.fail_with(2, "run", "many.nml", says=("too many inner spheres (expected up to 4)",))

    def test_sensitivities_have_their_columns(self):
        self.write("spheres.nml", SCENE.replace("'works' /", "'angular_velocity', 'sensitivities' /").replace("order = 4", "order = 8")
                   + "&free key = 'inner_sphere.1.damping', 'inner_sphere.1.inertia' /\n&free key = "
                   "'inner_sphere.2.angular_velocity.1' /\n")
        last, step = self.rows()[-1], 1e-4
        for key, value in (("1.damping", 0.5), ("1.inertia", 0.3)):
            ends = [self.rows("--set", f"inner_sphere.{key}={value + shift}")[-1]["sphere2_energy"] for shift in (step, -step)]
            # The energy of the second sphere is |h|^2/2I.
            change = sum((last[f"sphere2_rate{i}"] + last[f"omega{i}"]) * last[f"d_sphere2_momentum{i}/d_inner_sphere.{key}"]
                         for i in (1, 2, 3))
            self.assertAlmostEqual(change, (ends[0] - ends[1]) / (2 * step), delta=1e-8)
            self.assertGreater(abs(change), 1e-5)
        self.assertIn("d_sphere1_momentum3/d_inner_sphere.2.angular_velocity.1", last)

    def test_a_fit_finds_inertia_damping_and_rate_in_noise(self):
        scene = """&body inertia = 1.7, 1.1, 0.9 /
&inner_sphere inertia = 0.3, damping = 0.2, angular_velocity = 0.5, -1.0, 0.8 /
&initial angular_velocity = 0.8, -0.6, 1.4 /
&integrator method = 'rk8', time_step = 0.05, end_time = 20.0 /
&output every = 4 /
"""
        self.find_in_noise(scene, {"inner_sphere.inertia": 0.3, "inner_sphere.damping": 0.2,
                                   "inner_sphere.angular_velocity": [0.5, -1.0, 0.8]},
                           "--set", "inner_sphere.inertia=0.35", "--set", "inner_sphere.damping=0.16", "--set",
                           "inner_sphere.angular_velocity=0.4,-0.8,1.0", sigma=0.001)


if __name__ == "__main__":
    unittest.main()
