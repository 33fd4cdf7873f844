"""Ensembles: members of one scene with varied values."""

from __future__ import annotations

import copy
import ctypes
import os
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from ._library import MESSAGE_SIZE, Text, check, encoded, interruptible, library, pointer, refusal, text_of
from .scenes import Scene

SceneOrPath = Union[Scene, str, bytes, "os.PathLike[str]"]
Rows = npt.NDArray[np.void]
MOST_THREADS = 4096


def sweep(scene: SceneOrPath, *overrides: str, table: Any = None, threads: int = 1) -> Rows:
    """Runs all members of an ensemble. Returns a structured array, one row per member, with the fields and bytes of the file that
    `nutate sweep` writes: rows["status"], rows["omega3"], rows["initial.angular_velocity.3"].

    `scene` is the path of a scene file, with `overrides` as in `run`, or a Scene. `table` has one line per member: a
    mapping of names such as "body.inertia.1" to columns, a DataFrame, or a structured array; a scene without `&ensemble`
    gets one member per line. `threads` is the number of threads; more than 1 requires a library built with OpenMP.
    The status of a member that fails is in its row, also where a callback of the scene raises an exception. Ctrl-C ends the
    sweep."""
    made = with_table(scene, overrides, table)
    return rows_of(made, 1, made.members, threads)


def sweep_chunk(scene: SceneOrPath, first: int, last: int, *overrides: str, table: Any = None) -> Rows:
    """Returns the rows of members `first` to `last`, counted from 1, as `sweep` does. Runs in the calling thread only, also
    in a forked process; function and arguments can be pickled. Dask, Ray, joblib and multiprocessing can therefore distribute
    it over processes and machines; numpy.concatenate joins the parts."""
    return rows_of(with_table(scene, overrides, table), first, last, 1)


def with_table(scene: SceneOrPath, overrides: tuple[str, ...], table: Any) -> Scene:
    """The scene with its table, and the one given as it was."""
    if isinstance(scene, Scene):
        if overrides:
            raise refusal("overrides are not allowed with a Scene (expected them in its constructor)")
        made = scene if table is None else copy.copy(scene)
    else:
        made = Scene(scene, *overrides)
    if table is not None:
        names, numbers = columns_of(table)
        array = (Text * len(names))(*[encoded(name) for name in names])
        message = ctypes.create_string_buffer(MESSAGE_SIZE)
        status = library.nutate_sweep_table(made._handle, array, len(names), pointer(numbers), len(numbers), message, MESSAGE_SIZE)
        check(status, message.value.decode("utf-8", "replace"))
    return made


def columns_of(table: Any) -> tuple[list[str], npt.NDArray[np.float64]]:
    """Names and numbers of a table; the numbers have shape (lines, names)."""
    names = getattr(getattr(table, "dtype", None), "names", None) or (list(table.keys()) if hasattr(table, "keys") else None)
    if not names or not all(isinstance(name, str) for name in names):
        raise refusal("table has no named columns (expected a mapping, a DataFrame or a structured array)")
    try:
        numbers = np.stack([np.asarray(table[name], dtype=np.float64) for name in names], axis=-1)
    except ValueError as error:
        raise refusal(f"the columns of the table differ in length: {error}") from error
    if numbers.ndim != 2:
        raise refusal(f"columns of the table have {numbers.ndim - 1} dimensions (expected 1)")
    return list(names), np.ascontiguousarray(numbers)


def rows_of(scene: Scene, first: int, last: int, threads: int) -> Rows:
    """The rows of some members."""
    first, last, threads = int(first), int(last), int(threads)
    if scene.members and not 1 <= first <= last <= scene.members:
        raise refusal(f"members {first} to {last} are out of range (expected 1 to {scene.members})")
    if not 1 <= threads <= MOST_THREADS:
        raise refusal(f"the number of threads is {threads} (expected 1 to {MOST_THREADS})")
    fields, n_fields, whole = [], ctypes.c_size_t(), ctypes.c_int()
    check(library.nutate_sweep_size(scene._handle, None, ctypes.byref(n_fields)))
    for i in range(n_fields.value):
        name = text_of(library.nutate_sweep_field, scene._handle, i, ctypes.byref(whole))
        fields.append((name, np.int64 if whole.value else np.float64))
    rows = np.zeros(max(0, last - first + 1), dtype=fields)
    message = ctypes.create_string_buffer(MESSAGE_SIZE)
    status = interruptible(library.nutate_sweep_members, scene._handle, first, last, threads, rows.ctypes.data, rows.nbytes, message,
                           MESSAGE_SIZE)
    if not status:
        scene._callbacks.discard()
    scene._conclude(status, message=message.value.decode("utf-8", "replace"))
    return rows
