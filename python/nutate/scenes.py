"""Scene files, and running them."""

from __future__ import annotations

import ctypes
import os
import re
import struct
from typing import Any, Optional, Union

import numpy as np

from ._library import (Address, Array, Text, Textual, answer, asked, check, create, encoded, library, name_of, pointer,
                       refusal, shown, text_of)
from .events import History, take_events
from .systems import UserEffects


# Keys of &scene beside the title.
LABELS = ("epoch", "time_system", "object", "object_id", "space_frame", "body_frame")


# A comment, a string in quotes, or, as group 1, a group &event.
EVENT_GROUP = r"""![^\n]*|'[^']*'|"[^"]*"|(&event\b(?:![^\n]*|'[^']*'|"[^"]*"|[^/!'"])*/)"""


class Scene(UserEffects):
    """A scene (input file), read and checked.

    `with Scene(...) as scene:` frees it at the end. copy.copy and pickle make another scene from the text that was read.

    Parameters
    ----------
    path : str or path
        Scene file.
    *overrides : str
        Overrides "GROUP.KEY=VALUE", as after --set, or "-GROUP.KEY", as after --unset.
    text : str
        Contents of a scene, instead of a path.
    name : str
        Name of that for messages.

    Raises
    ------
    NutateOSError
        If the file cannot be read.
    NutateValueError
        If the scene is invalid.

    Examples
    --------
    >>> scene = nutate.Scene("scenes/box.nml", "integrator.end_time=1")
    >>> scene.title, scene.plan
    ('Free box on its intermediate axis', (0.01, 1.0, 1))
    """

    _destroy = "nutate_scene_destroy"
    _kind = "scene"

    def __init__(self, path: Union[str, bytes, os.PathLike[str], None] = None, *overrides: str,
                 text: Union[str, bytes, None] = None, name: Optional[Textual] = None) -> None:
        if (path is None) == (text is None):
            raise refusal("a Scene needs a path or a text (expected one of them)")
        read: Union[str, bytes, None] = text
        array = (Text * max(1, len(overrides)))(*[encoded(override) for override in overrides])
        if path is not None:
            handle = create(library.nutate_scene_read, encoded(path), array, len(overrides))
            with open(path, "rb") as file:
                read, name = file.read(), path
        else:
            handle = create(library.nutate_scene_parse, encoded(text or ""), None if name is None else encoded(name), array,
                            len(overrides))
        super().__init__(handle)
        check(library.nutate_scene_set_poll(handle, asked, None))
        self._note(None, *overrides, text=read, name=None if name is None else os.fsdecode(name))
        self._uncertified_steps = 0

    def __repr__(self) -> str:
        return f"<Scene {self.title!r}>" if not self._is_closed else "<Scene, closed>"

    @property
    def uncertified_steps(self) -> int:
        """Number of uncertified steps of the last `run`."""
        return self._uncertified_steps

    @property
    def title(self) -> str:
        """Title of the scene."""
        return text_of(library.nutate_scene_get_title, self._handle)

    @property
    def labels(self) -> dict[str, str]:
        """Epoch of t = 0, its time system, and the names of body and axes, as &scene gives them; empty texts for others."""
        return {key: text_of(library.nutate_scene_get, self._handle, encoded(key)) for key in LABELS}

    @property
    def plan(self) -> tuple[float, float, int]:
        """time_step, s (0 for adaptive steps), end_time, s, and every (steps between rows)."""
        numbers, every = np.empty(2), ctypes.c_int64()
        self._call("nutate_scene_get_plan", pointer(numbers[:1]), pointer(numbers[1:]), ctypes.byref(every))
        return float(numbers[0]), float(numbers[1]), every.value

    @property
    def initial(self) -> tuple[Array, Array]:
        """Initial attitude, shape (4,), and angular velocity, body axes, rad/s, shape (3,)."""
        q, omega = np.empty(4), np.empty(3)
        self._call("nutate_scene_get_initial", pointer(q), pointer(omega))
        return q, omega

    @property
    def members(self) -> int:
        """Number of members of the ensemble; 0 without one."""
        members = ctypes.c_int64()
        self._call("nutate_sweep_size", ctypes.byref(members), None)
        return members.value

    @property
    def event_groups(self) -> list[str]:
        """Groups &event of the scene, as they were written."""
        text = self._given[1]["text"]
        lines = text if isinstance(text, str) else os.fsdecode(text)
        found = re.finditer(EVENT_GROUP, lines, re.IGNORECASE)
        return [match[1] for match in found if match[1]]

    def run(self) -> History:
        """Runs the scene.

        Returns
        -------
        History
            Dictionary of arrays, one for each column of the scene, with the events of the run.

        Raises
        ------
        NutateError
            If the run fails; the attribute `history` has the rows so far, also of the KeyboardInterrupt of Ctrl-C.

        Warns
        -----
        NutateAccuracyWarning
            If the accuracy is not attained.

        Examples
        --------
        >>> history = nutate.Scene("scenes/box.nml", "integrator.end_time=1").run()
        >>> len(history["t"])
        101
        """
        handle = ctypes.c_void_p()
        status, message = answer(self._read_by, library.nutate_scene_run, self._handle, ctypes.byref(handle))
        columns, self._uncertified_steps = take_history(handle)
        self._conclude(status, columns, message)
        columns._warn()
        return columns

    def write(self, path: Optional[Textual] = None) -> None:
        """Runs the scene and writes its CSV file, as `nutate run` does.

        Parameters
        ----------
        path : str or path
            File; default: that of the scene.

        Raises
        ------
        NutateOSError
            If the file cannot be written.
        NutateError
            If the run fails; `PATH.partial` has the rows so far.
        """
        status, message = answer(self._read_by, library.nutate_scene_write, self._handle, None if path is None else encoded(path))
        self._conclude(status, message=message)


# Counts and errors of a history, as the library writes them, and the offset of the errors.
SUMMARY, ERRORS_FROM = struct.Struct("5q3d"), struct.calcsize("5q")


def take_history(handle: Any, names: Optional[list[str]] = None) -> tuple[History, int]:
    """Returns the columns of a history of the library and its number of uncertified steps, and frees the history."""
    if not handle:
        return History(), 0
    try:
        written = ctypes.create_string_buffer(SUMMARY.size)
        address = ctypes.addressof(written)
        check(library.nutate_history_summary(handle, address, address + ERRORS_FROM))
        n_rows, n_columns, n_events, n_exponents, uncertified, *errors = SUMMARY.unpack(written)
        values = np.empty((n_rows, n_columns))
        if values.size:
            check(library.nutate_history_values(handle, pointer(values), values.size))
        if names is None:
            names = [name_of(library.nutate_history_name, handle, i) for i in range(n_columns)]
        history = History(zip(names, values.T))
        history._events = take_events(library.nutate_history_event, handle, n_events)
        if errors[2] > 0:
            history._take_accuracy(*errors)
        if n_exponents:
            history._take_chaos(handle, n_exponents)
    finally:
        library.nutate_history_destroy(ctypes.byref(handle))
    return history, uncertified


# The struct nutate_row_run: what is set for a run, the array for its rows, and the results, with their offsets.
PLAN, ARRAY, RESULTS = struct.Struct("dqdQQ"), struct.Struct("QQ"), struct.Struct("q32x3dQ")
RESULTS_FROM = PLAN.size + ARRAY.size
# Rows for which the array has room; a run with more makes a history of the library.
ROOM = 64


class RowRun:
    """A run to a time, for columns with these names, and the memory for its rows and results."""

    def __init__(self, names: list[str]) -> None:
        self.names = names
        self._rows = np.empty((ROOM, len(names)))
        self._columns = self._rows.T
        self._run = bytearray(RESULTS_FROM + RESULTS.size)
        ARRAY.pack_into(self._run, PLAN.size, self._rows.ctypes.data, ROOM)
        self.address = Address(ctypes.addressof(ctypes.c_char.from_buffer(self._run)))

    def plan(self, end_time: float, every: int, interval: float, times: Optional[Array]) -> None:
        """Sets what the run needs; `times` must live as long as the run."""
        try:
            if times is None:
                PLAN.pack_into(self._run, 0, end_time, every, interval, 0, 0)
            else:
                PLAN.pack_into(self._run, 0, end_time, every, interval, times.ctypes.data, times.size)
        except struct.error as error:
            raise refusal(f"every is {shown(every)} (expected 1 to {2**63 - 1})") from error

    def take(self) -> History:
        """Returns the rows and results of the last run."""
        n_rows, estimated_error, round_off, accuracy, history = RESULTS.unpack_from(self._run, RESULTS_FROM)
        if history:
            return take_history(ctypes.c_void_p(history), self.names)[0]
        rows = History(zip(self.names, self._columns[:, :n_rows].copy()))
        if accuracy > 0:
            rows._take_accuracy(estimated_error, round_off, accuracy)
        return rows


def run(path: Textual, *overrides: str) -> History:
    """Runs a scene file.

    Parameters
    ----------
    path : str or path
        Scene file.
    *overrides : str
        Overrides "GROUP.KEY=VALUE", as after --set, or "-GROUP.KEY", as after --unset.

    Returns
    -------
    History
        Dictionary of arrays, one per column of the output, the first being "t"; its attribute `events` lists the events that
        the run located.

    Raises
    ------
    NutateOSError
        If the file cannot be read.
    NutateValueError
        If the scene is invalid.
    NutateError
        If the run fails; the attribute `history` has the rows so far.

    Examples
    --------
    >>> history = nutate.run("scenes/box.nml", "integrator.end_time=1")
    >>> len(history["t"]), list(history)[:3]
    (101, ['t', 'q0', 'q1'])
    """
    return Scene(path, *overrides).run()
