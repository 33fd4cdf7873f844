"""Stepping by hand."""

import ctypes
import numbers

import numpy as np

from ._library import Owner, create, encoded, library, pointer, text_of, vector
from .scenes import Scene


def setting(key, value):
    """A value as a scene file writes it; numbers and truth values may be those of NumPy."""
    if isinstance(value, (np.generic, np.ndarray)) and value.ndim == 0:
        value = value.item()
    if isinstance(value, bool):
        return ".true." if value else ".false."
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    if isinstance(value, str):
        return value
    raise TypeError(f"{key} is {value!r} (expected a number, a truth value or a text)")


class Stepper(Owner):
    """Moves the state of a System, or of a Scene from its initial state.

    Settings are the keys of the group &integrator: Stepper(system, method="nielsen_krenk", order=4,
    linear_solver="reduced", time_step=0.01).
    """

    destroy = "nutate_stepper_destroy"

    def __init__(self, source, **settings):
        function = library.nutate_stepper_create_scene if isinstance(source, Scene) else library.nutate_stepper_create
        super().__init__(create(function, source._handle), source._callbacks)
        self.set(**settings)

    def set(self, **settings):
        """Sets keys of the group &integrator."""
        for key, value in settings.items():
            self._call("nutate_stepper_set", encoded(key), encoded(setting(key, value)))

    def set_state(self, q, omega, t=0.0):
        """Sets attitude, angular velocity (body axes, rad/s) and time (s); work counts from here."""
        self._call("nutate_stepper_set_state", t, pointer(vector(q, 4, "q")), pointer(vector(omega, 3, "omega")))

    def step(self, dt):
        """One step of the method, s."""
        self._call("nutate_stepper_step", dt)

    def steps(self, dt, n):
        """n steps of the method of the same length, s."""
        self._call("nutate_stepper_steps", dt, n, None)

    def run(self, n, every=1):
        """n nominal steps of the setting time_step, as the program makes them: a dictionary of arrays, one for each
        column, with a row after each `every` steps."""
        if every < 1 or n < 0:
            raise ValueError(f"n is {n} and every is {every} (expected at least 0 and 1)")
        names = self.column_names
        rows = np.empty((n // every, len(names)))
        self._call("nutate_stepper_run", n, every, pointer(rows), len(rows), None)
        return dict(zip(names, rows.T))

    def keep_steps(self):
        """Keeps the starts of steps from now on, for `state_at`."""
        self._call("nutate_stepper_keep_steps")

    def state_at(self, t):
        """Attitude, shape (4,), and angular velocity, body axes, rad/s, shape (3,), at a time inside the last step that was kept:
        as good as the method, and unnoticed by the steps that follow."""
        q, omega = np.empty(4), np.empty(3)
        self._call("nutate_stepper_state_at", t, pointer(q), pointer(omega))
        return q, omega

    def set_columns(self, *sets):
        """Chooses the sets of columns of `run`, as &output columns does."""
        self._call("nutate_stepper_set_columns", encoded(",".join(sets)))

    @property
    def column_names(self):
        """Names of the columns of `run`."""
        width = ctypes.c_size_t()
        self._call("nutate_stepper_width", ctypes.byref(width))
        return [text_of(library.nutate_stepper_column, self._handle, i) for i in range(width.value)]

    @property
    def time(self):
        """s"""
        return float(self._read("nutate_stepper_time", 1)[0])

    @property
    def quaternion(self):
        """Attitude, body to space; shape (4,)."""
        return self._read("nutate_stepper_quaternion", 4)

    @property
    def conjugate_momentum(self):
        """p, kg m2/s; shape (4,)."""
        return self._read("nutate_stepper_conjugate_momentum", 4)

    @property
    def angular_velocity(self):
        """Body axes, rad/s; shape (3,)."""
        return self._read("nutate_stepper_angular_velocity", 3)

    @property
    def angular_velocity_space(self):
        """Space axes, rad/s; shape (3,)."""
        return self._read("nutate_stepper_angular_velocity_space", 3)

    @property
    def angular_momentum(self):
        """Body axes, N m s; shape (3,)."""
        return self._read("nutate_stepper_angular_momentum", 3)

    @property
    def angular_momentum_space(self):
        """Space axes, N m s; shape (3,)."""
        return self._read("nutate_stepper_angular_momentum_space", 3)

    @property
    def matrix(self):
        """Rotation matrix, body to space; shape (3, 3)."""
        return self._read("nutate_stepper_matrix", 3, 3)

    @property
    def euler(self):
        """Precession, nutation, spin (z-x-z), rad; shape (3,)."""
        return self._read("nutate_stepper_euler", 3)

    @property
    def energy(self):
        """Kinetic, potential, total, work of all torques, and total less its first value less work, J; shape (5,)."""
        return self._read("nutate_stepper_energy", 5)

    @property
    def unproved_steps(self):
        """Steps since the state was set in which a root was taken for that of the true motion without a proof."""
        steps = ctypes.c_int64()
        self._call("nutate_stepper_unproved", ctypes.byref(steps))
        return steps.value

    @property
    def estimated_error(self):
        """Of the last run with accuracy: a bound on the error of the attitude at its end, rad, above the accuracy where that
        is out of reach; and the part of it that round-off makes whatever the steps; shape (2,)."""
        return self._read("nutate_stepper_accuracy", 2)

    @property
    def constraints(self):
        """q.q - 1 and q.p (kg m2/s); shape (2,)."""
        return self._read("nutate_stepper_constraints", 2)
