"""Ensembles: members of one scene with varied values."""

from __future__ import annotations

import contextlib
import copy
import ctypes
import importlib
import os
import sys
import time
from typing import Any, Callable, Iterator, Union

import numpy as np
import numpy.typing as npt

from ._library import Text, answer, check, doubles, encoded, library, names_degrees, pointer, refusal, text_of, ticking, whole
from .scenes import Scene
from .tables import reject_repeated

SceneOrPath = Union[Scene, str, bytes, "os.PathLike[str]"]
Rows = npt.NDArray[np.void]
MOST_THREADS = 4096
# Parts of a sweep between which its progress is shown.
PARTS = 100


def sweep(scene: SceneOrPath, *overrides: str, table: Any = None, threads: int = 1, progress: bool = False) -> Rows:
    """Runs all members of an ensemble.

    Parameters
    ----------
    scene : str, path or Scene
        Scene, or the path of its file.
    *overrides : str
        Overrides "GROUP.KEY=VALUE" of a scene file, as in `run`.
    table : mapping, DataFrame or structured array
        Values with one line per member; names such as "body.inertia.1". A scene without &ensemble gets a member per line.
    threads : int
        Number of threads; more than 1 requires a library built with OpenMP. A process forked from one that has used threads has
        one.
    progress : bool
        True to show the progress: with a bar of tqdm if that is installed, else in a line of the standard error.

    Returns
    -------
    structured array, shape (members,)
        Fields and bytes of the file that `nutate sweep` writes: rows["status"], rows["omega3"],
        rows["initial.angular_velocity.3"]. The status of a member that fails is in its row, also if a callback of the scene
        raises an exception.

    Raises
    ------
    NutateValueError
        If the scene or an argument is invalid.
    KeyboardInterrupt
        Ctrl-C ends the sweep.

    Examples
    --------
    >>> text = ("&body inertia = 5, 20, 17 /\\n &initial angular_velocity = 0.1, 0, 10 /\\n"
    ...         " &integrator time_step = 0.01, end_time = 1 /")
    >>> rows = nutate.sweep(nutate.Scene(text=text), table={"initial.angular_velocity.3": [8.0, 9.0, 10.0]})
    >>> rows["status"].tolist(), rows["initial.angular_velocity.3"].tolist()
    ([0, 0, 0], [8.0, 9.0, 10.0])
    """
    made = with_table(scene, overrides, table)
    if not progress or made.members < 1:
        return rows_of(made, 1, made.members, threads)
    # Members do not depend on each other: parts of the sweep have the same rows.
    size = max(threads, -(-made.members // PARTS))
    parts = []
    with bar(made.members) as advance:
        for first in range(1, made.members + 1, size):
            last = min(first + size - 1, made.members)
            parts.append(rows_of(made, first, last, threads))
            advance(last - first + 1)
    return np.concatenate(parts)


def installed_tqdm() -> Any:
    """Returns the progress bar of tqdm; None if that is not installed."""
    try:
        return importlib.import_module("tqdm.auto").tqdm
    except ImportError:
        return None


@contextlib.contextmanager
def shown(what: str) -> Iterator[None]:
    """Shows the time spent in a run while it goes on."""
    start, tqdm = time.monotonic(), installed_tqdm()
    counter = None if tqdm is None else tqdm(desc=what, bar_format="{desc}: {elapsed}")

    def tick() -> None:
        if counter is not None:
            counter.update()
        else:
            print(f"\r{what}: {time.monotonic() - start:.0f} s", end="", file=sys.stderr, flush=True)

    tick()
    ticking.append(tick)
    try:
        yield
    finally:
        ticking.remove(tick)
        if counter is not None:
            counter.close()
        else:
            print(file=sys.stderr)


@contextlib.contextmanager
def bar(members: int) -> Iterator[Callable[[int], Any]]:
    """Returns a function that advances a progress bar by some members."""
    tqdm = installed_tqdm()
    if tqdm is not None:
        with tqdm(total=members, unit="member") as shown:
            yield shown.update
        return
    done = 0

    def advance(more: int) -> None:
        nonlocal done
        done += more
        print(f"\r{done} of {members} members", end="", file=sys.stderr, flush=True)

    yield advance
    print(file=sys.stderr)


def sweep_chunk(scene: SceneOrPath, first: int, last: int, *overrides: str, table: Any = None) -> Rows:
    """Runs some members of an ensemble in the calling thread.

    Function and arguments can be pickled, and a forked process may call it. Dask, Ray, joblib and multiprocessing can therefore
    distribute a sweep over processes and machines; numpy.concatenate joins the parts.

    Parameters
    ----------
    scene : str, path or Scene
        Scene, or the path of its file.
    first, last : int
        First and last member, counted from 1.
    *overrides : str
        Overrides "GROUP.KEY=VALUE" of a scene file.
    table : mapping, DataFrame or structured array
        Values, as in `sweep`.

    Returns
    -------
    structured array, shape (last - first + 1,)
        Rows, as those of `sweep`.

    Raises
    ------
    NutateValueError
        If the scene or an argument is invalid.
    """
    return rows_of(with_table(scene, overrides, table), first, last, 1)


def with_table(scene: SceneOrPath, overrides: tuple[str, ...], table: Any) -> Scene:
    """Returns the scene with its table, and the one given as it was."""
    if isinstance(scene, Scene):
        if overrides:
            raise refusal("overrides are not allowed with a Scene (expected them in its constructor)")
        made = scene if table is None else copy.copy(scene)
    else:
        made = Scene(scene, *overrides)
    if table is not None:
        names, numbers = columns_of(table)
        array = (Text * len(names))(*[encoded(name) for name in names])
        check(*answer(library.nutate_sweep_table, made._handle, array, len(names), pointer(numbers), len(numbers)))
    return made


def columns_of(table: Any) -> tuple[list[str], npt.NDArray[np.float64]]:
    """Names and numbers of a table; the numbers have shape (lines, names)."""
    names = getattr(getattr(table, "dtype", None), "names", None) or (list(table.keys()) if hasattr(table, "keys") else None)
    if not names or not all(isinstance(name, str) for name in names):
        raise refusal("table has no named columns (expected a mapping, a DataFrame or a structured array)")
    reject_repeated(names)
    # Whether a key is in degrees, its group in the scene says.
    columns = [doubles(table[name], f"column {name}", names_degrees(table[name])) for name in names]
    try:
        numbers = np.stack(columns, axis=-1)
    except ValueError as error:
        raise refusal(f"the columns of the table differ in length: {error}") from error
    if numbers.ndim != 2:
        raise refusal(f"columns of the table have {numbers.ndim - 1} dimensions (expected 1)")
    return list(names), np.ascontiguousarray(numbers)


def rows_of(scene: Scene, first: int, last: int, threads: int) -> Rows:
    """Returns the rows of some members."""
    if scene.members:
        first = whole(first, "first", 1, scene.members)
        last = whole(last, "last", first, scene.members)
    else:
        first = last = 1
    threads = whole(threads, "threads", 1, MOST_THREADS)
    fields, n_fields, is_whole = [], ctypes.c_size_t(), ctypes.c_int()
    check(library.nutate_sweep_size(scene._handle, None, ctypes.byref(n_fields)))
    for i in range(n_fields.value):
        name = text_of(library.nutate_sweep_field, scene._handle, i, ctypes.byref(is_whole))
        fields.append((name, np.int64 if is_whole.value else np.float64))
    rows = np.zeros(max(0, last - first + 1), dtype=fields)
    status, message = answer(scene._read_by, library.nutate_sweep_members, scene._handle, first, last, threads, rows.ctypes.data,
                             rows.nbytes)
    if not status:
        scene._callbacks.discard()
    scene._conclude(status, message=message)
    return rows
