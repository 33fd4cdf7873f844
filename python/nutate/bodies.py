"""Steps many bodies whose torques the calling program computes."""

from __future__ import annotations

import contextlib
import ctypes
from typing import Any, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from ._library import Array, GREATEST_INT, create, doubles, library, number, refusal, whole
from ._owners import Owner
from .systems import System

FRAMES = ("space", "body", "rate")


class Bodies(Owner):
    """Classes of bodies, and the steps of any number of them.

    Arrays `q` of shape (n, 4) and `l` of shape (n, 3) are changed in place; contiguous float64 arrays are never copied. `torque`
    has the shape (n, 3), `class_of` has n integers, 0 for the first class. A body with invalid numbers keeps its
    state, all others move, and the call raises NutateError; `failed` then has the indices.

    Parameters
    ----------
    classes : System, or a sequence of them
        Bodies without effects.
    frame : str
        Meaning of `l`: "space", the angular momentum in space axes, with torques in space axes; "body", that in body axes, with
        torques in body axes; "rate", the angular velocity in body axes, with torques in body axes.
    threads : int
        Number of threads that share the bodies of a call; 0: as many as OpenMP gives. Results are bitwise identical. A process
        forked from one that has used threads has one.

    Raises
    ------
    NutateValueError
        If an argument is invalid.

    Examples
    --------
    >>> bodies = nutate.Bodies(nutate.System(moments=(1, 1, 0.1)))
    >>> q, l = np.tile([1.0, 0, 0, 0], (1000, 1)), np.tile([0.1, 0, 1.0], (1000, 1))
    >>> torque, dt = np.zeros((1000, 3)), 0.01
    >>> bodies.kick(-dt / 2, q, l, torque)       # once: l goes half a step behind q
    >>> for _ in range(10):
    ...     bodies.step(dt, q, l, torque)
    >>> bodies.kick(dt / 2, q, l, torque)        # l catches up with q
    >>> q.shape
    (1000, 4)
    """

    _destroy = "nutate_bodies_destroy"

    def __init__(self, classes: Union[System, Sequence[System]], frame: str = "space", threads: int = 1) -> None:
        if frame not in FRAMES:
            raise refusal(f"frame is {frame!r} (expected 'space', 'body' or 'rate')")
        systems = [classes] if isinstance(classes, System) else list(classes)
        handles = (ctypes.c_void_p * len(systems))(*[system._handle for system in systems])
        super().__init__(create(library.nutate_bodies_create, handles, len(systems), FRAMES.index(frame)))
        self._call("nutate_bodies_set_threads", whole(threads, "threads", 0, GREATEST_INT))

    def step(self, dt: float, q: Array, l: Array, torque: npt.ArrayLike, class_of: Optional[npt.ArrayLike] = None) -> None:
        """Moves bodies by a step: `l` by dt torque, then `q` without torque.

        Parameters
        ----------
        dt : float
            Step, s, of either sign.
        q : array, shape (n, 4)
            Attitudes, changed in place.
        l : array, shape (n, 3)
            Momenta or rates, as `frame` says, changed in place.
        torque : array, shape (n, 3)
            Torques, N m, in the axes of `l`.
        class_of : array of int, shape (n,)
            Class of each body; default: the first.

        Raises
        ------
        NutateError
            If bodies fail; they keep their state, and `failed` has their indices.
        NutateValueError
            If an array has a wrong shape or type.
        """
        self._move("nutate_bodies_step", dt, q, l, class_of, torque)

    def kick(self, dt: float, q: Array, l: Array, torque: npt.ArrayLike, class_of: Optional[npt.ArrayLike] = None) -> None:
        """Changes the momenta alone, by dt torque; `q` is only tested. Arguments are those of `step`."""
        self._move("nutate_bodies_kick", dt, q, l, class_of, torque)

    def drift(self, dt: float, q: Array, l: Array, class_of: Optional[npt.ArrayLike] = None) -> None:
        """Moves bodies without torques. Arguments are those of `step`."""
        self._move("nutate_bodies_drift", dt, q, l, class_of)

    @property
    def failed(self) -> npt.NDArray[np.int64]:
        """Indices of the bodies that failed in the last call."""
        places = np.empty(self._count("nutate_bodies_failed", 0, None), dtype=np.uintp)
        self._call("nutate_bodies_failed", places.size, places.ctypes.data, None)
        return places.astype(np.int64)

    def _move(self, name: str, dt: float, q: Array, l: Array, class_of: Optional[npt.ArrayLike], *torque: npt.ArrayLike) -> None:
        n = len(q) if np.ndim(q) else 0
        with in_place(q, (n, 4), "q") as attitudes, in_place(l, (n, 3), "l") as momenta:
            read = [of_shape(values, (n, 3), "torque", np.float64) for values in torque]
            numbers = None if class_of is None else of_shape(class_of, (n,), "class_of", np.intc)
            self._call(name, n, None if numbers is None else numbers.ctypes.data, number(dt, "dt"), attitudes.ctypes.data,
                       momenta.ctypes.data, *[values.ctypes.data for values in read])


@contextlib.contextmanager
def in_place(array: Array, shape: tuple[int, ...], name: str) -> Any:
    """Returns the array itself if C can write to it, else a copy that is written back."""
    if not isinstance(array, np.ndarray) or array.dtype != np.float64 or array.shape != shape or not array.flags.writeable:
        raise refusal(f"{name} must be a writeable float64 array of shape {shape}")
    whole = doubles(array, name)
    try:
        yield whole
    finally:
        if whole is not array:
            array[...] = whole


def of_shape(values: npt.ArrayLike, shape: tuple[int, ...], name: str, kind: Any) -> npt.NDArray[Any]:
    """Returns a contiguous array of this type."""
    array = np.asarray(values) if kind is np.intc else doubles(values, name)
    if kind is np.intc and (array.dtype.kind not in "iu" or np.ma.is_masked(values)):
        raise refusal(f"{name} must hold whole numbers")
    if array.shape != shape:
        raise refusal(f"{name} has shape {array.shape} (expected {shape})")
    if kind is np.intc and array.dtype.itemsize >= 4 and array.dtype != np.intc:
        # The conversion would cut off digits; the greatest number is no class, as those beyond it are none.
        array = np.minimum(array, GREATEST_INT) if array.dtype.kind == "u" else np.clip(array, -1, GREATEST_INT)
    return np.ascontiguousarray(array, dtype=kind)
