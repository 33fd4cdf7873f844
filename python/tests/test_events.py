"""The Python package: states inside steps, and events of scenes."""

import os
import tempfile
import unittest

import numpy as np

import nutate

BOX = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes", "box.nml")


def make_box(**settings):
    """The box of scenes/box.nml, ready to step."""
    system = nutate.System(shape="box", size=(4, 1, 2), mass=12)
    stepper = nutate.Stepper(system, **settings)
    stepper.set_state(q=(1, 0, 0, 0), omega=(0.1, 0, 10))
    return stepper


class InsideTest(unittest.TestCase):
    def test_states_inside_a_step_are_as_good_as_the_method_and_unnoticed(self):
        for settings in ({"order": 8}, {"method": "dop853"}, {"method": "taylor"}):
            plain, looked, exact = (make_box(**settings) for _ in range(3))
            with self.assertRaises(nutate.NutateError):
                looked.state_at(0.0)
            looked.keep_steps()
            for _ in range(10):
                plain.step(0.02)
                looked.step(0.02)
                q, omega = looked.state_at(looked.time - 0.0075)
            np.testing.assert_array_equal(plain.quaternion, looked.quaternion)
            for _ in range(7):
                exact.step(0.0275)
            np.testing.assert_allclose(q, exact.quaternion, atol=1e-9)
            np.testing.assert_allclose(omega, exact.angular_velocity, atol=1e-8)
            with self.assertRaises(nutate.NutateError):
                looked.state_at(0.1)

    def test_events_of_a_scene_end_its_run(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "flip.nml")
            with open(BOX, encoding="utf-8") as box, open(path, "w", encoding="utf-8") as flip:
                flip.write(box.read() + "\n&event name = 'flip', when = 'omega3', crosses = 0.0, count = 2 /\n")
            history = nutate.run(path)
            self.assertAlmostEqual(history["t"][-1], 3 * 0.9664094834075236, delta=0.02)
            self.assertLess(abs(history["omega3"][-1]), 1e-10)


if __name__ == "__main__":
    unittest.main()
