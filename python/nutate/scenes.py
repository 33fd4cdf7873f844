"""Scene files, and running them."""

import ctypes

import numpy as np

from ._library import NutateError, Owner, Text, check, create, encoded, library, MESSAGE_SIZE, pointer, text_of
from .systems import add_potential, add_user_torque


class Scene(Owner):
    """A scene file, read and checked; `overrides` are texts "GROUP.KEY=VALUE" as after --set, and "-GROUP.KEY" as --unset."""

    destroy = "nutate_scene_destroy"

    def __init__(self, path=None, *overrides, text=None):
        if (path is None) == (text is None):
            raise ValueError("a Scene takes a path or a text")
        array = (Text * max(1, len(overrides)))(*[encoded(override) for override in overrides])
        if text is None:
            handle = create(library.nutate_scene_read, encoded(path), array, len(overrides))
        else:
            handle = create(library.nutate_scene_parse, encoded(text), None, array, len(overrides))
        super().__init__(handle)
        self._unproved_steps = 0

    @property
    def unproved_steps(self):
        """Steps of the last `run` in which a root was taken for that of the true motion without a proof."""
        return self._unproved_steps

    @property
    def title(self):
        """The title of the scene."""
        return text_of(library.nutate_scene_get_title, self._handle)

    def add_user_torque(self, torque, bounds=None):
        """As System.add_user_torque."""
        add_user_torque(self, "scene", torque, bounds)

    def add_potential(self, direction, potential, hessian=None, bounds=None):
        """As System.add_potential."""
        add_potential(self, "scene", direction, potential, hessian, bounds)

    def run(self):
        """Runs the scene: a dictionary of arrays, one for each column the scene asks for. A run that fails half-way
        raises NutateError, the rows so far are then its attribute `history`."""
        handle = ctypes.c_void_p()
        message = ctypes.create_string_buffer(MESSAGE_SIZE)
        status = library.nutate_scene_run(self._handle, ctypes.byref(handle), message, MESSAGE_SIZE)
        columns = {}
        try:
            if handle:
                columns = take_history(handle)
                steps = ctypes.c_int64()
                check(library.nutate_history_unproved(handle, ctypes.byref(steps)))
                self._unproved_steps = steps.value
        finally:
            library.nutate_history_destroy(ctypes.byref(handle))
        if status:
            self._callbacks.raise_again()
            error = NutateError(status, message.value.decode("utf-8", "replace"))
            error.history = columns
            raise error
        return columns

    def write(self, path=None):
        """Runs the scene and writes its CSV file, as the program does; by default the one that the scene names."""
        message = ctypes.create_string_buffer(MESSAGE_SIZE)
        status = library.nutate_scene_write(self._handle, None if path is None else encoded(path), message,
                                            MESSAGE_SIZE)
        if status:
            self._callbacks.raise_again()
        check(status, message.value.decode("utf-8", "replace"))


def take_history(handle):
    """The columns of a history of the library."""
    n_rows, n_columns = ctypes.c_size_t(), ctypes.c_size_t()
    check(library.nutate_history_size(handle, ctypes.byref(n_rows), ctypes.byref(n_columns)))
    values = np.empty((n_rows.value, n_columns.value))
    check(library.nutate_history_values(handle, pointer(values), values.size))
    names = [text_of(library.nutate_history_name, handle, i) for i in range(n_columns.value)]
    return dict(zip(names, values.T))


def run(path, *overrides):
    """Runs a scene file: a dictionary of arrays, one for each column of its output, "t" the first.

    `overrides` are texts "GROUP.KEY=VALUE" as after --set: run("box.nml", "integrator.time_step=0.005").
    """
    return Scene(path, *overrides).run()
