"""Step-by-step integration."""

from __future__ import annotations

import copy
import ctypes
import numbers
import operator
from typing import Any, Callable, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from ._library import (Array, FLOAT, MESSAGE_SIZE, Message, NAME_SIZE, NutateError, asked, check, create, digits, doubles, encoded, library,
                       noted, number, pointer, quaternion, refusal, refuse_order, refuse_units, shown, text_of, vector, whole)
from ._owners import make_again
from .attitudes import rotate_to_body
from .events import Event, History, take_events
from .satellites import SatelliteState
from .scenes import RowRun, Scene
from .systems import System, group


def setting(key: str, value: Any) -> str:
    """Returns a value as a scene file writes it; numbers and booleans may be those of NumPy."""
    refuse_units(value, key)
    if isinstance(value, (np.generic, np.ndarray)) and value.ndim == 0:
        value = (value if value.dtype.kind in "biuSU" else doubles(value, key)).item()
    if isinstance(value, bool):
        return ".true." if value else ".false."
    if isinstance(value, numbers.Integral):
        return digits(value, key)
    if isinstance(value, numbers.Real):
        return repr(number(value, key))
    if isinstance(value, str):
        return value
    raise TypeError(f"{key} is {shown(value)} (expected a number, a boolean or a string)")


take_step, put_state, run_rows = library.nutate_stepper_step, library.nutate_stepper_set_state, library.nutate_stepper_run_rows


class Stepper(SatelliteState):
    """Integrates the motion of a System, or of a Scene from its initial state, step by step.

    `with Stepper(...) as stepper:` frees it at the end. copy.copy makes an independent stepper that continues with identical
    results; so does pickle, if its callbacks can be pickled. A run that fails in a step or a callback, or is ended by Ctrl-C,
    raises an exception; its attribute `history` has the rows so far.

    Parameters
    ----------
    source : System or Scene
        Body and effects; a Scene supplies initial state and settings, too.
    **settings
        Keys of &integrator, such as method="nielsen_krenk", order=4, time_step=0.01, or accuracy=1e-8 for `run_to`.

    Raises
    ------
    NutateValueError
        If a setting is invalid.

    Examples
    --------
    >>> stepper = nutate.Stepper(nutate.System(moments=(5, 20, 17)), time_step=0.01)
    >>> stepper.set_state(q=(1, 0, 0, 0), omega=(0.1, 0, 10))
    >>> rows = stepper.run(100, every=10)
    >>> len(rows["t"]), round(stepper.time, 9)
    (10, 1.0)
    """

    _destroy = "nutate_stepper_destroy"

    def __init__(self, source: Union[System, Scene], **settings: Any) -> None:
        function = library.nutate_stepper_create_scene if isinstance(source, Scene) else library.nutate_stepper_create
        try:
            handle = create(function, source._handle)
        except NutateError:
            source._callbacks.raise_again()
            raise
        super().__init__(handle, source._callbacks)
        check(library.nutate_stepper_set_poll(self._handle, asked, None))
        self._source = (type(source), source._given, tuple(source._additions), source._files)
        self._settings: dict[str, Any] = {}
        self._sets: Optional[tuple[str, ...]] = None
        self._names: Optional[list[str]] = None
        self._run: Optional[RowRun] = None
        self._events: list[tuple[tuple[Any, ...], dict[str, Any]]] = []
        self._propagated: dict[str, tuple[Any, ...]] = {}
        self.set(**settings)

    def __repr__(self) -> str:
        if self._is_closed:
            return "<Stepper, closed>"
        return f"<Stepper at t={self.time:g} s>"

    def set(self, **settings: Any) -> None:
        """Sets keys of the group &integrator.

        Parameters
        ----------
        **settings
            Keys and their values, as for the constructor.

        Raises
        ------
        NutateValueError
            If a key is unknown or a value is out of its range.
        """
        for key, value in settings.items():
            self._call("nutate_stepper_set", encoded(key), encoded(setting(key, value)))
            self._settings.pop(key, None)
            self._settings[key] = copy.copy(value)

    def get(self, key: str) -> str:
        """Returns the value in force for a key of &integrator, given or chosen.

        Parameters
        ----------
        key : str
            "method", "choice" (why the method was chosen; empty if it was given), "formulation", "order", "series_order",
            "conserve", "time_step", "accuracy" or "local_tolerance" (with an accuracy: the value found by the last run).

        Returns
        -------
        str
            Value in the notation of scene files.

        Raises
        ------
        NutateValueError
            If the key is none of these.

        Examples
        --------
        >>> nutate.Stepper(nutate.System(moments=(5, 20, 17)), order=4).get("order")
        '4'
        """
        value = Message()
        self._call("nutate_stepper_get", encoded(key), value, MESSAGE_SIZE)
        return value.value.decode()

    def __copy__(self) -> Stepper:
        handle = create(library.nutate_stepper_copy, self._handle)
        twin = type(self).__new__(type(self))
        twin.__dict__.update(self.__dict__, _owned=handle, _settings=dict(self._settings), _events=list(self._events),
                             _run=None)
        check(library.nutate_stepper_set_poll(twin._handle, asked, None))
        return twin

    def __deepcopy__(self, _: Any) -> Stepper:
        return copy.copy(self)

    def __reduce_ex__(self, protocol: Any) -> Any:
        needed = self._count("nutate_stepper_save", None, 0)
        saved = ctypes.create_string_buffer(needed)
        self._call("nutate_stepper_save", saved, needed, None)
        return restored, (self._source, self._settings, self._sets, self._events, self._propagated, saved.raw)

    def set_state(self, q: Any = None, omega: Optional[npt.ArrayLike] = None, t: float = 0.0, *,
                  xyzw: Optional[npt.ArrayLike] = None, frame: str = "body") -> None:
        """Sets the state; the work starts at zero.

        Parameters
        ----------
        q : array, shape (4,), or Rotation
            Attitude, body to space, scalar first.
        omega : array, shape (3,)
            Angular velocity, rad/s, in the axes of `frame`.
        t : float
            Time, s.
        xyzw : array, shape (4,)
            Attitude with the scalar last, instead of `q`.
        frame : str
            Axes of omega: "body" or "space".

        Raises
        ------
        NutateValueError
            If the norm of the quaternion is not 1, or a value is not finite.

        Examples
        --------
        >>> stepper = nutate.Stepper(nutate.System(moments=(5, 20, 17)), time_step=0.01)
        >>> stepper.set_state(xyzw=(0, 0, 0, 1), omega=(0.1, 0, 10), t=2)
        >>> stepper.time, stepper.quaternion.tolist()
        (2.0, [1.0, 0.0, 0.0, 0.0])
        """
        # For such arrays all that follows amounts to these lines, and takes as long as some steps.
        if type(q) is np.ndarray and type(omega) is np.ndarray and q.dtype is omega.dtype is FLOAT and q.shape == (4,) and omega.shape == (3,) \
                and frame == "body" and xyzw is None and not self._callbacks._kept and self._owned:
            status = put_state(self._owned, number(t, "t"), q.tobytes(), omega.tobytes())
            if status:
                check(status, text_of(library.nutate_last_message, self._owned))
            return
        if (q is None) == (xyzw is None) or omega is None or frame not in ("body", "space"):
            raise refusal('wrong arguments of set_state (expected q or xyzw, omega, and frame="body" or "space")')
        refuse_order(xyzw, "xyzw", ("xyzw", "1230"))
        attitude = quaternion(q) if xyzw is None else np.roll(vector(xyzw, 4, "xyzw"), 1)
        rates = vector(omega, 3, "omega")
        if frame == "space":
            rates = rotate_to_body(attitude, rates)
        self._call("nutate_stepper_set_state", number(t, "t"), attitude.tobytes(), rates.tobytes())

    def set_canonical(self, q: Any, p: npt.ArrayLike, t: float = 0.0) -> None:
        """Sets attitude and conjugate momentum without normalising them.

        Parameters
        ----------
        q : array, shape (4,), or Rotation
            Attitude, body to space, scalar first.
        p : array, shape (4,)
            Conjugate momentum 2 q o [0, L], kg m2/s.
        t : float
            Time, s.

        Raises
        ------
        NutateValueError
            If the norm of the quaternion differs from 1 by more than 1e-6, or a value is not finite.
        """
        self._call("nutate_stepper_set_canonical", number(t, "t"), quaternion(q).tobytes(), vector(p, 4, "p").tobytes())

    def prepare(self) -> None:
        """Prepares the method and checks the settings together; otherwise the first step does.

        Raises
        ------
        NutateValueError
            If settings contradict each other.
        """
        self._call("nutate_stepper_prepare")

    def step(self, dt: float) -> None:
        """Performs one step without subdividing it.

        It does not end when a torque starts or stops, nor at the lines of a table, as the steps of `run` and `run_to` do; inside
        such a step its order is lost.

        Parameters
        ----------
        dt : float
            Length, s; negative to integrate backward.

        Raises
        ------
        NutateError
            If the step fails; the state is unchanged.

        Examples
        --------
        >>> stepper = nutate.Stepper(nutate.System(moments=(1, 1, 2)))
        >>> stepper.set_state(q=(1, 0, 0, 0), omega=(0, 0, 3))
        >>> stepper.step(0.01)
        >>> stepper.time, stepper.angular_velocity.round(9).tolist()
        (0.01, [0.0, 0.0, 3.0])
        """
        # Without callbacks what _call does, line by line: looking the function up would take as long as a step.
        if self._callbacks._kept or not self._owned:
            self._call("nutate_stepper_step", number(dt, "dt"))
            return
        status = take_step(self._owned, number(dt, "dt"))
        if status:
            check(status, text_of(library.nutate_last_message, self._owned))

    def steps(self, dt: float, n: int) -> None:
        """Performs steps of equal length.

        Parameters
        ----------
        dt : float
            Length, s; negative to integrate backward.
        n : int
            Number of steps.

        Raises
        ------
        NutateError
            If a step fails; the state is that before it.
        """
        status = self._work(library.nutate_stepper_steps, self._handle, number(dt, "dt"), whole(n, "n", 0), None)
        self._conclude(status)

    def run(self, n: int, every: int = 1, initial: bool = False) -> dict[str, Array]:
        """Performs fixed steps of length time_step, as `nutate run` does.

        Parameters
        ----------
        n : int
            Number of steps.
        every : int
            Steps between two rows.
        initial : bool
            True for the current state as the first row.

        Returns
        -------
        dict of arrays
            One array for each column.

        Raises
        ------
        NutateError
            If a step fails; the attribute `history` has the rows so far.

        Examples
        --------
        >>> stepper = nutate.Stepper(nutate.System(moments=(5, 20, 17)), time_step=0.01)
        >>> stepper.set_state(q=(1, 0, 0, 0), omega=(0.1, 0, 10))
        >>> stepper.run(100, every=50, initial=True)["t"].round(9).tolist()
        [0.0, 0.5, 1.0]
        """
        n, every = whole(n, "n", 0), whole(every, "every", 1)
        names = self.column_names
        # One row more where an event ends the run.
        rows = np.empty((n // every + 1 + bool(initial), len(names)))
        n_rows, first = ctypes.c_size_t(), rows[1:] if initial else rows
        if initial:
            self._call("nutate_stepper_row", pointer(rows[0]), len(names))
        status = self._work(library.nutate_stepper_run, self._handle, n, every, pointer(first), len(first),
                            ctypes.byref(n_rows))
        history = dict(zip(names, rows[:n_rows.value + bool(initial)].T))
        self._conclude(status, history)
        return history

    def run_to(self, end_time: float, every: int = 1, interval: float = 0.0,
               times: Optional[npt.ArrayLike] = None) -> History:
        """Runs to a time, with adaptive steps if accuracy or local_tolerance is set, else with fixed ones.

        Parameters
        ----------
        end_time : float
            Last time, s; the last fixed step is shortened to end there.
        every : int
            Steps between two rows.
        interval : float
            Time between two rows, s, with adaptive steps.
        times : array, shape (n,)
            Times of the rows, s, in the order of the run, instead of `every` and `interval`.

        Returns
        -------
        History
            Dictionary of arrays, one for each column, with its events. Without `times` the first and the last state have rows.

        Raises
        ------
        NutateError
            If a step fails; the attribute `history` has the rows so far.

        Warns
        -----
        NutateAccuracyWarning
            If the accuracy is not attained.

        Examples
        --------
        >>> stepper = nutate.Stepper(nutate.System(moments=(5, 20, 17)), accuracy=1e-8)
        >>> stepper.set_state(q=(1, 0, 0, 0), omega=(0.1, 0, 10))
        >>> history = stepper.run_to(5, times=(0, 2.5, 5))
        >>> history["omega3"].round(4).tolist(), history.accuracy_reached
        ([10.0, -9.8356, -7.6486], True)
        """
        wanted = None if times is None else np.atleast_1d(doubles(times, "times"))
        # Before the run: a call after it would raise the KeyboardInterrupt without the rows.
        run = self._run
        if run is None or run.names is not self._names:
            run = self._run = RowRun(self._known_names())
        run.plan(number(end_time, "end_time"), operator.index(every), number(interval, "interval"), wanted)
        status = self._work(run_rows, self._owned or self._handle, run.address)
        history = run.take()
        if status or noted:
            self._conclude(status, history)
        if history.accuracy_reached is False:
            history._warn()
        return history

    def differentiate(self, scene: Scene) -> None:
        """Lets the following runs propagate sensitivities, each from its start; the columns "sensitivities" show them.

        Parameters
        ----------
        scene : Scene
            Scene with the same body and effects, whose &free names the parameters.

        Raises
        ------
        NutateValueError
            If the scene has no &free, or the motion cannot be differentiated with respect to one of its parameters.
        """
        self._call("nutate_stepper_differentiate", scene._handle)
        self._propagate("differentiate", scene)

    def follow_chaos(self, scene: Scene) -> None:
        """Lets the following runs compute indicators of chaos, each from its start.

        The history that `run_to` returns has them, and so have the columns "lyapunov", "megno" and "fli". A stepper that was made
        from a scene computes those of its &chaos anyway.

        Parameters
        ----------
        scene : Scene
            Scene whose &chaos names the indicators.

        Raises
        ------
        NutateValueError
            If the method does not support them.
        """
        self._call("nutate_stepper_follow_chaos", scene._handle)
        self._propagate("follow_chaos", scene)

    def _propagate(self, name: str, scene: Scene) -> None:
        """Notes a call for copies."""
        self._names = None
        self._propagated = {**self._propagated, name: (type(scene), scene._given, tuple(scene._additions), scene._files)}

    def add_event(self, when: Union[str, Sequence[str], Callable[..., float]], name: Optional[str] = None, *,
                  crosses: Optional[float] = None, extremum: Optional[str] = None, direction: Optional[int] = None,
                  modulo: Optional[float] = None, weights: Optional[Sequence[float]] = None, stop: Optional[bool] = None,
                  count: Optional[int] = None, switch: Optional[str] = None) -> None:
        """Adds an event, which all following calls of `run` and `run_to` locate.

        A run that an event ends leaves the state there; the next run continues from it.

        Parameters
        ----------
        when : str, list of str, or function when(t, q, omega)
            Column; up to four columns, of which a sum is formed; or a smooth function of its arguments alone (omega absolute,
            body axes, rad/s).
        name : str
            Name of the event; default: the column.
        crosses : float
            Value to cross.
        extremum : str
            "maximum", "minimum" or "both", instead of `crosses`.
        direction : int
            1 only rising, -1 only falling.
        modulo : float
            Period of the value, in its unit.
        weights : list of float
            Factors of the columns of a sum.
        stop : bool
            True to end the run at the event.
        count : int
            Number of the occurrence that ends the run.
        switch : str
            Effect to switch: "NAME on", "NAME off" or "NAME toggle".

        Raises
        ------
        NutateValueError
            If an argument is invalid.

        Examples
        --------
        >>> stepper = nutate.Stepper(nutate.System(moments=(5, 20, 17)), accuracy=1e-8)
        >>> stepper.set_state(q=(1, 0, 0, 0), omega=(0.1, 0, 10))
        >>> stepper.add_event("omega3", "flip", crosses=0, stop=True)
        >>> history = stepper.run_to(5)
        >>> round(stepper.time, 5), stepper.events[0].name
        (0.96641, 'flip')
        """
        keys = {"crosses": None if crosses is None else number(crosses, "crosses"), "extremum": extremum, "direction": direction,
                "modulo": None if modulo is None else number(modulo, "modulo"), "stop": stop, "count": count, "switch": switch}
        again = ((when if callable(when) else copy.copy(when), name), {**keys, "weights": copy.copy(weights)})
        if callable(when):
            if weights is not None:
                raise refusal("weights are not allowed with a function")
            of_function = group("event", name="event" if name is None else name, **keys)
            self._call("nutate_stepper_add_event", self._callbacks.quantity(when), None, encoded(of_function))
        else:
            given = None if weights is None else np.atleast_1d(doubles(weights, "weights"))
            self._call("nutate_stepper_add_events", encoded(group("event", name=name, when=when, weights=given, **keys)))
        self._events.append(again)

    @property
    def events(self) -> list[Event]:
        """Events that the last run located, in the order of time."""
        return take_events(library.nutate_stepper_event, self._handle, self._count("nutate_stepper_event_count"))

    def keep_steps(self) -> None:
        """Stores the start of each following step, for `state_at`."""
        self._call("nutate_stepper_keep_steps")

    def state_at(self, t: float) -> tuple[Array, Array]:
        """Computes the state at a time inside the last stored step, to the accuracy of the method.

        Parameters
        ----------
        t : float
            Time, s.

        Returns
        -------
        q : array, shape (4,)
            Attitude, body to space.
        omega : array, shape (3,)
            Angular velocity, body axes, rad/s.

        Raises
        ------
        NutateValueError
            If the time is outside the step, or no step was stored: call `keep_steps` before the step.

        Examples
        --------
        >>> stepper = nutate.Stepper(nutate.System(moments=(1, 1, 2)))
        >>> stepper.set_state(q=(1, 0, 0, 0), omega=(0, 0, 3))
        >>> stepper.keep_steps()
        >>> stepper.step(0.02)
        >>> q, omega = stepper.state_at(0.01)
        >>> omega.round(9).tolist()
        [0.0, 0.0, 3.0]
        """
        q, omega = np.empty(4), np.empty(3)
        self._call("nutate_stepper_state_at", number(t, "t"), pointer(q), pointer(omega))
        return q, omega

    def _dense_output(self, start: dict[str, float], dt: float, times: Array) -> dict[str, Array]:
        """Returns rows at times inside a step of an earlier run, s, from the row at its start. NutateValueError, also of no times, if a
        state has more to it than attitude and momentum: momenta of wheels, commands that a controller holds."""
        names = self.column_names
        times, rows = np.ascontiguousarray(times), np.empty((len(times), len(names)))
        q, p = (np.array([start[f"{name}{i}"] for i in range(4)]) for name in "qp")
        derivatives = np.array([start[name] for name in names if name.startswith(("d_rotation", "d_omega"))])
        self._call("nutate_stepper_dense_output", start["t"], pointer(q), pointer(p), pointer(derivatives) if derivatives.size else None,
                   dt, len(times), pointer(times), pointer(rows))
        return dict(zip(names, rows.T))

    def set_columns(self, *sets: str) -> None:
        """Chooses the columns of the following runs.

        Parameters
        ----------
        *sets : str
            Sets of columns, such as "quaternion" and "energy", as in the key columns of &output.

        Raises
        ------
        NutateValueError
            If a set is unknown, or the system lacks what it shows.
        """
        self._call("nutate_stepper_set_columns", encoded(",".join(sets)))
        self._sets, self._names = sets, None

    @property
    def column_names(self) -> list[str]:
        """Names of the columns of runs; the first is "t"."""
        return list(self._known_names())

    def _known_names(self) -> list[str]:
        """Returns the list of these names, which stays the same until the columns change."""
        if self._names is None:
            buffer = ctypes.create_string_buffer(NAME_SIZE*self._count("nutate_stepper_width"))
            self._call("nutate_stepper_column_names", buffer, len(buffer))
            self._names = names = buffer.value.decode().split(",")
            return names
        return self._names

    @property
    def row(self) -> dict[str, float]:
        """The current state as a row, a dictionary of numbers, one per column."""
        names = self.column_names
        values = np.empty(len(names))
        self._call("nutate_stepper_row", pointer(values), values.size)
        return dict(zip(names, values.tolist()))

    @property
    def time(self) -> float:
        """Time, s."""
        return float(self._read("nutate_stepper_time", 1)[0])

    @property
    def quaternion(self) -> Array:
        """Attitude, body to space; shape (4,)."""
        return self._read("nutate_stepper_quaternion", 4)

    @property
    def rotation(self) -> Any:
        """Attitude as a Rotation of SciPy."""
        from scipy.spatial.transform import Rotation  # type: ignore[import-untyped,unused-ignore]
        return Rotation.from_quat(np.roll(self.quaternion, -1))

    @property
    def conjugate_momentum(self) -> Array:
        """Conjugate momentum p, kg m2/s; shape (4,)."""
        return self._read("nutate_stepper_conjugate_momentum", 4)

    @property
    def angular_velocity(self) -> Array:
        """Angular velocity, body axes, rad/s; shape (3,)."""
        return self._read("nutate_stepper_angular_velocity", 3)

    @property
    def angular_velocity_space(self) -> Array:
        """Angular velocity, space axes, rad/s; shape (3,)."""
        return self._read("nutate_stepper_angular_velocity_space", 3)

    @property
    def angular_momentum(self) -> Array:
        """Angular momentum, body axes, N m s; shape (3,)."""
        return self._read("nutate_stepper_angular_momentum", 3)

    @property
    def angular_momentum_space(self) -> Array:
        """Angular momentum, space axes, N m s; shape (3,)."""
        return self._read("nutate_stepper_angular_momentum_space", 3)

    @property
    def matrix(self) -> Array:
        """Rotation matrix, body to space; shape (3, 3)."""
        return self._read("nutate_stepper_matrix", 3, 3)

    @property
    def euler(self) -> Array:
        """Euler angles (precession, nutation, spin; z-x-z), rad; shape (3,)."""
        return self._read("nutate_stepper_euler", 3)

    @property
    def energy(self) -> Array:
        """Kinetic, potential and total energy, work of all torques, and energy residual (change of the total less work), J; shape
        (5,)."""
        return self._read("nutate_stepper_energy", 5)

    @property
    def uncertified_steps(self) -> int:
        """Number of uncertified steps since the state was set."""
        return self._count("nutate_stepper_uncertified", kind=ctypes.c_int64)

    @property
    def estimated_error(self) -> Array:
        """Estimated attitude error at the end of the last run with accuracy, rad, which exceeds the accuracy if that is not
        attained, and the part of it due to round-off, whatever the steps; shape (2,)."""
        return self._read("nutate_stepper_accuracy", 2)

    @property
    def constraints(self) -> Array:
        """Errors of the constraints, q.q - 1 and q.p (kg m2/s); shape (2,)."""
        return self._read("nutate_stepper_constraints", 2)

    @property
    def conserved(self) -> tuple[int, Array]:
        """Number of components of the inertial angular momentum that are conserved, 0, 1 or 3, and, if 1, the axis of that
        component (unit vector, space axes; else zeros)."""
        components, axis = ctypes.c_int(), np.empty(3)
        self._call("nutate_stepper_conserved", ctypes.byref(components), pointer(axis))
        return components.value, axis

    @property
    def solver(self) -> tuple[int, float]:
        """Newton iterations of the last step, and its last increment relative to the increment of the step."""
        iterations, residual = ctypes.c_int(), np.empty(1)
        self._call("nutate_stepper_solver", ctypes.byref(iterations), pointer(residual))
        return iterations.value, float(residual[0])


def restored(source: Any, settings: dict[str, Any], sets: Optional[tuple[str, ...]],
             events: list[tuple[tuple[Any, ...], dict[str, Any]]], propagated: dict[str, tuple[Any, ...]], saved: bytes) -> Stepper:
    """Makes a stepper in the same way as another one, in the state that was saved."""
    with make_again(*source) as made:
        stepper = Stepper(made, **settings)
    for name, recipe in propagated.items():
        with make_again(*recipe) as scene:
            getattr(stepper, name)(scene)
    if sets is not None:
        stepper.set_columns(*sets)
    for arguments, keys in events:
        stepper.add_event(*arguments, **keys)
    stepper._call("nutate_stepper_restore", saved, len(saved))
    return stepper
