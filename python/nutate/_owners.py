"""What owns memory of the library, and the functions that the library calls."""

from __future__ import annotations

import contextlib
import copy
import ctypes
import hashlib
import os
import re
import threading
from typing import Any, Callable, Dict, Optional

import numpy as np
import numpy.typing as npt

from ._library import (Array, BAD_HANDLE, HessianCallback, KnownAttributes, NutateValueError, PotentialCallback, QuantityCallback, TorqueCallback, check, doubles,
                       interruptible, library, number, pointer, raise_interrupt, refusal, shown, text_of, vector)

# Memory of callbacks that is known by its address, at most.
MOST_VIEWS = 4096
# Functions that only read a stepper or a scene: callbacks may call them for the object that calls the callback.
READING = frozenset("nutate_stepper_" + name for name in (
    "time quaternion conjugate_momentum angular_velocity angular_velocity_space angular_momentum angular_momentum_space matrix euler "
    "constraints conserved accuracy solver uncertified width column_names event_count event wheel_count wheel sphere_count sphere "
    "orbit lvlh_attitude time_dependent_work").split()) | {"nutate_scene_get_plan", "nutate_scene_get_initial", "nutate_sweep_size"}


class Owner(KnownAttributes):
    """Something with a handle that is freed with it, and with callbacks that must live as long."""

    _destroy = ""

    def __init__(self, handle: ctypes.c_void_p, callbacks: Optional[Callbacks] = None) -> None:
        self._owned = handle
        self._callbacks = callbacks if callbacks is not None else Callbacks()

    @property
    def _is_closed(self) -> bool:
        return not self._owned

    @property
    def _handle(self) -> ctypes.c_void_p:
        """Handle of the object in the library."""
        if not self._owned:
            raise NutateValueError(BAD_HANDLE, f"the {type(self).__name__} is closed (expected one that is open)")
        return self._owned

    def close(self) -> None:
        """Frees the memory of the library; a `with` block does so at its end, and Python when nothing refers to the object."""
        handle = getattr(self, "_owned", None)
        if handle:
            if self._callbacks._kept:
                self._callbacks.refuse(self)
            getattr(library, self._destroy)(ctypes.byref(handle))

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __del__(self) -> None:
        self.close()

    def __reduce_ex__(self, protocol: Any) -> Any:
        # A copy would share the handle, and free it under the original.
        raise TypeError(f"a {type(self).__name__} cannot be copied or pickled (expected a new one)")

    def _call(self, name: str, *arguments: Any) -> None:
        """Calls a function of this handle; raises what a callback raised, or NutateError."""
        function, handle = getattr(library, name), self._owned or self._handle
        if self._callbacks._kept:
            self._conclude((interruptible if name in READING else self._work)(function, handle, *arguments))
            return
        status = function(handle, *arguments)
        if status:
            check(status, text_of(library.nutate_last_message, handle))

    def _work(self, function: Any, *arguments: Any) -> int:
        """Returns the status of a function that changes the owned object, which its callbacks must not use for more than reading."""
        if self._callbacks._kept:
            self._callbacks.refuse(self)
        return self._read_by(function, *arguments)

    def _read_by(self, function: Any, *arguments: Any) -> int:
        """Returns the status of a function that only reads the owned object: its callbacks may read it too, but not change it."""
        if not self._callbacks._kept:
            return interruptible(function, *arguments)
        self._callbacks.callers.append(self)
        try:
            return interruptible(function, *arguments)
        finally:
            self._callbacks.callers.remove(self)

    def _conclude(self, status: int, history: Optional[dict[str, Array]] = None, message: Optional[str] = None) -> None:
        """Raises what interrupted a call, what a callback raised in it, or NutateError, with the rows so far."""
        try:
            raise_interrupt()
            if status:
                self._callbacks.raise_again()
                check(status, text_of(library.nutate_last_message, self._handle) if message is None else message)
        except BaseException as error:
            if history is not None:
                with contextlib.suppress(AttributeError):
                    error.history = history  # type: ignore[attr-defined]
            raise

    def _read(self, name: str, *shape: int) -> Array:
        """Returns the numbers that a function of this handle writes."""
        values = np.empty(shape)
        self._call(name, pointer(values))
        return values

    def _count(self, name: str, *arguments: Any, kind: Any = ctypes.c_size_t) -> int:
        """Returns the count that a function of this handle writes, its last argument."""
        count = kind()
        self._call(name, *arguments, ctypes.byref(count))
        return int(count.value)


class Recipe(Owner):
    """An owner that knows how it was made, so that it can be made again: by copy, and by pickle as far as its callbacks can be
    pickled, from the same files."""

    _given: tuple[tuple[Any, ...], dict[str, Any]]
    _additions: list[tuple[str, tuple[Any, ...]]]
    _files: dict[str, str]

    def _note(self, *arguments: Any, **keys: Any) -> None:
        """Notes the arguments of the constructor."""
        self._given = (copy.deepcopy(arguments), copy.deepcopy(keys))
        self._additions = []
        self._files = {}
        for text in (*arguments, keys.get("text")):
            self._note_files(text, keys.get("name"))

    def _add(self, name: str, *arguments: Any) -> None:
        """Notes a method that has been called."""
        self._additions.append((name, arguments))

    def _note_files(self, text: Any, name: Optional[str] = None) -> None:
        """Notes the digests of the files that a text names in quotes, beside a scene of the given name."""
        if not isinstance(text, (str, bytes)):
            return
        for found in re.findall(r"=\s*'([^'\n]+)'|=\s*\"([^\"\n]+)\"", text if isinstance(text, str) else os.fsdecode(text)):
            path = os.path.join(os.path.dirname(name or ""), "".join(found))
            if os.path.isfile(path):
                self._files[path] = digest_of(path)

    def __reduce_ex__(self, protocol: Any) -> Any:
        return make_again, (type(self), self._given, tuple(self._additions), self._files)


def digest_of(path: str) -> str:
    """Returns the SHA-256 of a file."""
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def make_again(kind: Any, given: tuple[tuple[Any, ...], dict[str, Any]], additions: tuple[Any, ...], files: dict[str, str]) -> Any:
    """Makes an owner in the same way as another one. Raises NutateValueError if a file that it was made from has changed."""
    for path, digest in files.items():
        if os.path.isfile(path) and digest_of(path) != digest:
            raise refusal(f"{path!r} has changed since the {kind.__name__} that is copied was made (expected the same file)")
    made = kind(*given[0], **given[1])
    for name, arguments in additions:
        getattr(made, name)(*arguments)
    return made


class Callbacks:
    """Functions that the library calls: kept alive here, with what one of them raised in the present thread."""

    def __init__(self) -> None:
        self._kept: list[Any] = []
        self._raised = threading.local()
        # Owners at work, in whatever thread, which may call these functions.
        self.callers: list[Any] = []

    def refuse(self, owner: Any) -> None:
        """Raises NutateValueError if a callback, or another thread, may change an owner at work."""
        if any(caller is owner for caller in self.callers):
            raise refusal(f"a callback uses the {type(owner).__name__} that calls it for more than reading (expected a copy)")

    def raise_again(self) -> None:
        """Raises what a callback raised since the last call, if one did."""
        error = getattr(self._raised, "error", None)
        self.discard()
        if error is not None:
            raise error

    def discard(self) -> None:
        """Forgets what a callback raised, if its failure is in a row."""
        self._raised.error = None

    def _guard(self, kind: Any, evaluate: Callable[..., None]) -> Any:
        """Returns a callback for C that returns 1 if `evaluate` raises."""
        raised = self._raised

        def call(*arguments: Any) -> int:
            try:
                evaluate(*arguments)
                return 0
            except BaseException as error:
                raised.error = error
                return 1

        guarded = kind(call)
        self._kept.append(guarded)
        return guarded

    def torque(self, function: Callable[..., npt.ArrayLike]) -> Any:
        """Evaluates tau = function(t, q, omega)."""
        three, four = Views(3), Views(4)

        def evaluate(t: float, q: int, omega: int, _: Any, tau: int) -> None:
            put(three[tau], function(t, four[q].copy(), three[omega].copy()), "the torque")

        return self._guard(TorqueCallback, evaluate)

    def potential(self, function: Callable[..., Any]) -> Any:
        """Evaluates energy, gradient = function(gamma)."""
        one, three = Views(1), Views(3)

        def evaluate(gamma: int, _: Any, energy: int, gradient: int) -> None:
            result = function(three[gamma].copy())
            try:
                value, slope = result
                one[energy][0] = number(value, "the energy")
            except (TypeError, ValueError) as error:
                raise refusal(f"the potential returned {shown(result)} (expected its energy, a number, and its gradient)") from error
            put(three[gradient], slope, "the gradient")

        return self._guard(PotentialCallback, evaluate)

    def hessian(self, function: Optional[Callable[..., npt.ArrayLike]]) -> Any:
        """Evaluates hessian = function(gamma), or returns None without a function."""
        if function is None:
            return HessianCallback()
        three, nine = Views(3), Views(9)

        def evaluate(gamma: int, _: Any, hessian: int) -> None:
            put(nine[hessian], doubles(function(three[gamma].copy()), "the hessian").reshape(-1), "the hessian")

        return self._guard(HessianCallback, evaluate)

    def quantity(self, function: Callable[..., float]) -> Any:
        """Evaluates g = function(t, q, omega)."""
        one, three, four = Views(1), Views(3), Views(4)

        def evaluate(t: float, q: int, omega: int, _: Any, g: int) -> None:
            value = function(t, four[q].copy(), three[omega].copy())
            try:
                one[g][0] = number(value, "the quantity")
            except (TypeError, ValueError) as error:
                raise refusal(f"the quantity of an event is {shown(value)} (expected a number)") from error

        return self._guard(QuantityCallback, evaluate)


class Views(Dict[int, Array]):
    """Memory of C as arrays, by its address: a run calls with the same few addresses, so each array is made once. An array is to be
    used in the call that has the address."""

    def __init__(self, size: int) -> None:
        super().__init__()
        self._type = ctypes.c_double * size

    def __missing__(self, address: int) -> Array:
        if len(self) >= MOST_VIEWS:
            self.clear()
        view: Array = np.ctypeslib.as_array(self._type.from_address(address))
        self[address] = view
        return view


def put(array: Array, values: npt.ArrayLike, name: str) -> None:
    """Copies as many numbers as an array has, or raises NutateError."""
    if type(values) is np.ndarray and values.shape == array.shape and values.dtype == array.dtype:
        array[:] = values
    else:
        array[:] = vector(values, array.size, name)
