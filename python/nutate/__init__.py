"""Rotation of rigid bodies, integrated with quaternions so that energy, momentum and the unit norm hold to round-off at
any step size (Nielsen & Krenk 2012).

    import nutate
    history = nutate.run("scenes/box.nml")                  # a dictionary of arrays, one per column
    history = nutate.run("scenes/box.nml", "integrator.order=4")

or step by step:

    system = nutate.System(shape="box", size=(4, 1, 2), mass=12)
    system.add_user_torque(lambda t, q, omega: -0.1 * omega)
    stepper = nutate.Stepper(system, time_step=0.01)
    stepper.set_state(q=(1, 0, 0, 0), omega=(0.1, 0, 10))
    rows = stepper.run(1000, every=10)

or to an accuracy, with the motion at any time:

    solution = nutate.solve(system, omega0=(0.1, 0, 10), t_span=(0, 5), accuracy=1e-9)
    q, omega = solution.sol(2.5)

or an ensemble of motions from one scene with varied values:

    rows = nutate.sweep("tumble.nml", threads=8)            # a structured array, one row per member

or thousands of bodies with torques that the program computes:

    bodies = nutate.Bodies(nutate.System(moments=(1, 1, 0.1)))
    bodies.step(dt, q, l, torque)                           # in place: q (n, 4), l (n, 3)

SI units, radians. Quaternions are scalar first and convert body components to space components; a Rotation of SciPy is accepted
in their place. Scenes, systems and steppers own memory of the library; `with` or `close` frees it, otherwise Python does. All
of them can be copied and pickled.

All errors of the library derive from `NutateError`:

    NutateError         a step or a run failed (not converged, step limit, stopped, ...)
    NutateValueError    an argument, a body or a scene is invalid; also a ValueError
    NutateOSError       a file cannot be read or written; also an OSError

Their attributes are `status` (a code of nutate.h), `message`, and `history` (the rows so far of a run that failed). Exceptions
raised in callbacks propagate unchanged. As usual in Python, an argument of a wrong type gives a TypeError or ValueError, and
`import nutate` an ImportError if the C library is not found. A run that misses its accuracy gives a `NutateAccuracyWarning`.
"""

from ._library import NutateAccuracyWarning, NutateError, NutateOSError, NutateValueError, version
from .attitudes import (attitude_distance, axis_angle_from_quat, euler_from_quat, exact_free_body, follow_euler, from_rotation,
                        matrix_from_quat, omega_from_euler_rates, quat_from_axis_angle, quat_from_euler, quat_from_matrix,
                        quat_from_rotation_vector, quat_normalized, quat_product, rotate_to_body, rotate_to_space,
                        rotation_vector_from_quat, to_rotation)
from ._page import Page, view
from .bodies import Bodies
from .events import Event, History
from .exchange import AttitudeRows, date, read_aem, tdb
from .fits import FitProblem, FitResult, fit
from .linear import ControllerGains, Equilibrium, Linearization, equilibria, linearize
from .pictures import colour, plot, symbol
from .satellites import Sphere, Wheel
from .scenes import Scene, run
from .sensitivities import Sensitivity
from .solutions import Motion, Solution, solve
from .steppers import Stepper
from .sweeps import sweep, sweep_chunk
from .systems import System
from .tables import to_pandas, to_xarray

__version__ = version()

__all__ = ["AttitudeRows", "Bodies", "ControllerGains", "Equilibrium", "Event", "FitProblem", "FitResult", "History", "Linearization",
           "Motion", "NutateAccuracyWarning", "NutateError", "NutateOSError", "NutateValueError", "Page", "Scene", "Sensitivity", "Solution",
           "Sphere", "Stepper", "System", "Wheel", "attitude_distance", "axis_angle_from_quat", "colour", "date", "equilibria", "euler_from_quat",
           "exact_free_body", "fit", "follow_euler", "from_rotation", "linearize", "matrix_from_quat", "omega_from_euler_rates", "plot", "quat_from_axis_angle",
           "quat_from_euler", "quat_from_matrix", "quat_from_rotation_vector", "quat_normalized", "quat_product", "rotate_to_body",
           "rotate_to_space", "read_aem", "rotation_vector_from_quat", "run", "solve", "sweep", "sweep_chunk", "symbol", "tdb", "to_pandas",
           "to_rotation", "to_xarray", "version", "view", "__version__"]
