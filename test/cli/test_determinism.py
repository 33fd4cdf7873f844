"""The same input gives the same bytes, in a file and through a pipe."""
import glob
import os
import unittest

from support import ONE_IN, CommandLineTest, all_columns

SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes")
# End times, s, of scenes that take longer than others: a part of their motion shows the same.
LONG = {"apophis.nml": 2e4, "boom.nml": 30, "burning_rocket.nml": 4, "detumbling.nml": 600, "dual_spin.nml": 200, "foucault.nml": 20,
        "gyrocompass.nml": 400, "hyperion.nml": 30, "spring_gyroscope.nml": 1}


class Determinism(CommandLineTest):
    def check(self, scene, *settings):
        name = os.path.basename(scene)
        self.succeed("run", name, "--quiet", "--output", "first.csv", *settings)
        piped = self.succeed("run", name, "--quiet", "--output", "-", *settings)
        self.assertEqual(self.read("first.csv"), piped.stdout, f"{name} {settings}")

    def test_every_scene_with_every_column_and_solver(self):
        """The scenes take turns with the solvers; in `make stress` each is run by both."""
        scenes = sorted(glob.glob(os.path.join(SCENES, "*.nml")))
        self.assertTrue(scenes)
        for table in glob.glob(os.path.join(SCENES, "*.csv")):
            with open(table, encoding="utf-8") as file:
                self.write(os.path.basename(table), file.read())
        solvers = ["full", "reduced"]
        for number, scene in enumerate(scenes):
            with open(scene, encoding="utf-8") as file:
                self.write(os.path.basename(scene), file.read())
            end = ("--set", f"integrator.end_time={LONG[name]}") if (name := os.path.basename(scene)) in LONG else ()
            if ONE_IN == 1:
                self.check(scene)
            for solver in [solvers[number % 2]] if ONE_IN > 1 else solvers:
                self.check(scene, "--set", f"output.columns={all_columns()}", "--set", "integrator.method='nielsen_krenk'", "--set",
                           f"integrator.formulation='{solver}'", "--set", "integrator.order=4", "--set", "output.every=3", *end)

    def test_steps_by_their_error(self):
        for key in ("accuracy", "local_tolerance"):
            self.write("chosen.nml", self.read("top.nml").replace("time_step = 0.005", f"{key} = 1e-6"))
            self.check("chosen.nml", "--set", f"output.columns={all_columns()}", "--set", "output.interval=0.013")


if __name__ == "__main__":
    unittest.main()
