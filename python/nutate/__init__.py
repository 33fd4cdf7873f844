"""Rotation of rigid bodies, integrated with quaternions so that energy, momentum and the unit norm hold to round-off at
any step size (Nielsen & Krenk 2012).

    import nutate
    history = nutate.run("scenes/box.nml")                  # a dictionary of arrays, one for each column
    history = nutate.run("scenes/box.nml", "integrator.order=4")

or step by step:

    system = nutate.System(shape="box", size=(4, 1, 2), mass=12)
    system.add_user_torque(lambda t, q, omega: -0.1 * omega)
    stepper = nutate.Stepper(system, time_step=0.01)
    stepper.set_state(q=(1, 0, 0, 0), omega=(0.1, 0, 10))
    rows = stepper.run(1000, every=10)

SI units, radians. Quaternions have their scalar first and take body components to space components. Every failure is a
`NutateError`, but for what a callback raised, which comes out as it was. Scenes, systems and steppers own memory of the
library and cannot be copied: make another one.
"""

from ._library import NutateError, version
from .scenes import Scene, run
from .steppers import Stepper
from .systems import System

__all__ = ["NutateError", "Scene", "Stepper", "System", "run", "version"]
