"""Events of runs: times at which a quantity of the motion crosses a value or has an extremum."""

from __future__ import annotations

import ctypes
from typing import Any, NamedTuple, Optional

import numpy as np

from ._library import Array, KnownAttributes, check, library, pointer, warn

NAME_SIZE = 32


class Event(NamedTuple):
    """Event that a run has located.

    Examples
    --------
    >>> box = nutate.System(shape="box", size=(4, 1, 2), mass=12)
    >>> flip = nutate.solve(box, omega0=(0.1, 0, 10), t_span=(0, 5), events="omega3").events[0]
    >>> flip.name, flip.number, round(flip.t, 5)
    ('omega3', 1, 0.96641)
    """

    name: str
    """Name of the event."""
    number: int
    """Number of the occurrence, 1 for the first of this name."""
    t: float
    """Time, s."""
    q: Array
    """Attitude, body to space; shape (4,)."""
    omega: Array
    """Angular velocity, body axes, rad/s; shape (3,)."""


class History(KnownAttributes, dict):  # type: ignore[type-arg]
    """Rows of a run: a dictionary of arrays, one for each column; `history["t"]` has the times, s.

    Examples
    --------
    >>> history = nutate.run("scenes/intermediate_axis.nml")
    >>> history["omega3"].shape == history["t"].shape, history.events[0].name
    (True, 'flip')
    """

    estimated_error: Optional[float] = None
    """Estimated attitude error at the end, rad; None after a run without an accuracy."""
    round_off: Optional[float] = None
    """Part of that error due to round-off, rad, whatever the steps; None after a run without an accuracy."""
    accuracy_reached: Optional[bool] = None
    """True if the estimated error is at most the accuracy; None after a run without one."""
    exponents: Optional[Array] = None
    """Lyapunov exponents, 1/s; shape (1,) or (6,); None without &chaos."""
    megno: Optional[float] = None
    """Mean MEGNO; None without &chaos."""
    fli: Optional[float] = None
    """Fast Lyapunov indicator; None without &chaos."""

    @property
    def events(self) -> list[Event]:
        """Events that the run located, in the order of time."""
        # The list is created at its first use, since a short run takes little longer than its steps.
        events: list[Event] = self.__dict__.setdefault("_events", [])
        return events

    @events.setter
    def events(self, events: list[Event]) -> None:
        self._events = events

    def _take_accuracy(self, estimated_error: float, round_off: float, accuracy: float) -> None:
        """Stores the results of a run with an accuracy."""
        self.estimated_error, self.round_off, self.accuracy_reached = estimated_error, round_off, estimated_error <= accuracy

    def _take_chaos(self, handle: Any, n: int) -> None:
        """Reads the indicators of chaos, with n exponents, of a history of the library."""
        exponents, megno, fli = np.empty(6), ctypes.c_double(), ctypes.c_double()
        check(library.nutate_history_chaos(handle, None, pointer(exponents), ctypes.byref(megno), ctypes.byref(fli), None))
        self.exponents, self.megno, self.fli = exponents[:n], megno.value, fli.value

    def _warn(self) -> None:
        """Issues NutateAccuracyWarning if the requested accuracy was not attained."""
        if self.accuracy_reached is False:
            warn(f"the requested accuracy is not attainable: estimated error {self.estimated_error:.1e} rad, "
                 f"{self.round_off:.1e} rad by round-off (expected a larger accuracy, a shorter run, or a finer table of an orbit)")


def take_events(function: Any, handle: Any, n: int) -> list[Event]:
    """Returns the n events that a function of the library returns of a stepper or a history."""
    events = []
    for i in range(n):
        name, number, t = ctypes.create_string_buffer(NAME_SIZE), ctypes.c_int64(), ctypes.c_double()
        q, omega = np.empty(4), np.empty(3)
        check(function(handle, i, name, NAME_SIZE, ctypes.byref(number), ctypes.byref(t), pointer(q), pointer(omega)))
        events.append(Event(name.value.decode(), number.value, t.value, q, omega))
    return events
