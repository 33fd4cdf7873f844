"""A motion from start to end in one call, modelled on scipy.integrate.solve_ivp."""

from __future__ import annotations

import contextlib
import copy
import re
from functools import cached_property, partial
from typing import Any, Callable, Iterator, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from ._library import (Array, KnownAttributes, NOT_CONVERGED, NOT_FINITE, NutateError, NutateValueError, OFF_BRANCH, SINGULAR, STEP_LIMIT, doubles, encoded,
                       number, quaternion, refusal, vector)
from .events import Event as Happened
from .events import History
from .exchange import Exchange
from .scenes import Scene
from .sensitivities import Sensitivity, rows_at, scene_with_free
from .steppers import Stepper
from .sweeps import shown
from .systems import System
from .tables import stacked

SETS = ("quaternion", "conjugate_momentum", "angular_velocity", "angular_momentum_space", "energy", "constraints")
# Failures of a step, which leave the rows so far.
STEPS_FAILED = (NOT_CONVERGED, OFF_BRANCH, SINGULAR, NOT_FINITE, STEP_LIMIT)
# Methods that know the error of a step.
ESTIMATING = ("dop853", "taylor", "exact")

Event = Callable[[float, Array, Array], float]


class Motion(KnownAttributes):
    """Dense output of a motion: attitude and angular velocity at any time.

    A call repeats the step that contains the time and evaluates the dense output of the method, which is as accurate as
    the steps themselves.

    Parameters
    ----------
    t : float, or array, shape (n,)
        Times, s, from `t_min` to `t_max`, in any order.

    Returns
    -------
    q : array, shape (4,) or (n, 4)
        Attitude.
    omega : array, shape (3,) or (n, 3)
        Angular velocity, body axes, rad/s.

    Raises
    ------
    NutateValueError
        If a time is outside the motion.

    Examples
    --------
    >>> top = nutate.System(moments=(1, 1, 2))
    >>> motion = nutate.solve(top, omega0=(0, 0, 3), t_span=(0, 2)).sol
    >>> q, omega = motion([0.5, 1.0, 1.5])
    >>> q.shape, omega[1].round(9).tolist()
    ((3, 4), [0.0, 0.0, 3.0])
    """

    def __init__(self, stepper: Stepper, branch: Stepper, ends: dict[str, Array]) -> None:
        """`branch` is as the stepper was before its run, which led to the ends of steps."""
        method, tolerance = stepper.get("method"), float(stepper.get("local_tolerance"))
        keys = {"nielsen_krenk": ("order", "formulation"), "dop853": ("conserve",), "rk4": ("conserve",)}.get(method, ())
        self._settings = {"method": method, **{key: stepper.get(key) for key in keys}, **({"local_tolerance": tolerance} if tolerance else {})}
        self._branch = branch
        # A method without an estimate of its own has found the error of a step from its two halves, and kept these.
        self._parts = 2 if tolerance and method not in ESTIMATING else 1
        self._ends = ends
        self._sense = 1.0 if ends["t"][-1] >= ends["t"][0] else -1.0

    def __repr__(self) -> str:
        return f"<Motion from t={self.t_min:g} s to t={self.t_max:g} s>"

    @cached_property
    def _stepper(self) -> Stepper:
        """The stepper that evaluates the steps again, with the settings that were chosen for them."""
        self._branch.set(**self._settings)
        return self._branch

    @cached_property
    def _replays(self) -> bool:
        """True if only the motion as a whole can be evaluated again, not each of its steps."""
        try:
            self._stepper._dense_output(self._start(0), 1.0, np.empty(0))
        except NutateValueError:
            return True
        return False

    @property
    def t_min(self) -> float:
        """Least time, s."""
        return float(min(self._ends["t"][[0, -1]]))

    @property
    def t_max(self) -> float:
        """Greatest time, s."""
        return float(max(self._ends["t"][[0, -1]]))

    def __call__(self, t: npt.ArrayLike) -> tuple[Array, Array]:
        rows = self.rows(t)
        q, omega = stacked(rows, "q", range(4)), stacked(rows, "omega", range(1, 4))
        return (q[0], omega[0]) if np.ndim(t) == 0 else (q, omega)

    def rows(self, t: npt.ArrayLike) -> dict[str, Array]:
        """Computes all columns of the solution at any times.

        Parameters
        ----------
        t : float, or array, shape (n,)
            Times, s, from `t_min` to `t_max`, in any order.

        Returns
        -------
        dict of arrays
            One array of n numbers for each column; of one number for a single time.

        Raises
        ------
        NutateValueError
            If a time is outside the motion.

        Examples
        --------
        >>> top = nutate.System(moments=(1, 1, 2))
        >>> motion = nutate.solve(top, omega0=(0, 0, 3), t_span=(0, 2)).sol
        >>> motion.rows([0.5, 1.0])["kinetic"].round(9).tolist()
        [9.0, 9.0]
        """
        wanted = np.atleast_1d(doubles(t, "t"))
        if wanted.ndim != 1:
            raise refusal(f"t has shape {wanted.shape} (expected n times)")
        if not np.all((wanted >= self.t_min) & (wanted <= self.t_max)):
            raise refusal(f"a time is outside the motion (expected {self.t_min!r} to {self.t_max!r} s)")
        times, places = np.unique(wanted, return_inverse=True)
        found = {name: np.empty(len(times)) for name in self._ends}
        for chosen, rows in self._pieces(times):
            for name, values in rows.items():
                found[name][chosen] = values
        return {name: values[places] for name, values in found.items()}

    def _pieces(self, times: Array) -> Iterator[tuple[Any, dict[str, Array]]]:
        """Yields indices of times, in ascending order, and their rows."""
        ends = self._sense * self._ends["t"]
        last = np.searchsorted(ends, self._sense * times, side="right") - 1
        on_end = ends[last] == self._sense * times
        here = np.flatnonzero(on_end)
        yield here, {name: values[last[here]] for name, values in self._ends.items()}
        inside = np.flatnonzero(~on_end)[::1 if self._sense > 0 else -1]
        if self._replays and len(inside):
            yield inside, self._replay(times[inside])
        elif len(inside):
            for chosen in np.split(inside, np.flatnonzero(np.diff(last[inside])) + 1):
                yield chosen, self._inside(int(last[chosen[0]]), times[chosen])

    def _start(self, k: int) -> dict[str, float]:
        """Returns the row at the end of a step, where another one starts."""
        return {name: values[k] for name, values in self._ends.items()}

    def _replay(self, times: Array) -> dict[str, Array]:
        """Returns rows of the motion, repeated from its start."""
        start = self._start(0)
        self._stepper.set_canonical([start[f"q{i}"] for i in range(4)], [start[f"p{i}"] for i in range(4)], start["t"])
        return self._stepper.run_to(times[-1], times=times)

    def _inside(self, k: int, times: Array) -> dict[str, Array]:
        """Rows inside the step that starts at the end of another one."""
        start = self._start(k)
        rows = self._stepper._dense_output(start, (self._ends["t"][k + 1] - start["t"]) / self._parts, times)
        for name in ("work", "energy_residual"):
            rows[name] += start[name]
        return rows


class Solution(Exchange):
    """Result of `solve`: a mapping of column names to arrays, with attributes.

    Attributes
    ----------
    t : array, shape (n,)
        Times of the rows, s.
    q : array, shape (n, 4)
        Attitudes.
    omega : array, shape (n, 3)
        Angular velocities, body axes, rad/s.
    energy : dict of arrays, shape (n,)
        Energies, J: kinetic, potential, total, work, energy_residual.
    sol : Motion
        Dense output: sol(t) returns q and omega at any time in between.
    status : int
        0: the end was reached; 1: an event ended the motion; -1: a step failed.
    message : str
        Description of the status.
    errors : dict of float
        Largest errors of the invariants at the rows: "energy" (total - total at the start - work, over the largest T + abs(V)),
        "momentum" (conserved components, over the largest momentum), "norm" (q.q - 1), "orthogonality" (q.p, kg m2/s), and
        "attitude", the estimated attitude error at the end, rad, nan if no accuracy was requested.
    accuracy_reached : bool or None
        True if that estimate is at most the requested accuracy; None if none was requested, or a step failed. False comes with
        a NutateAccuracyWarning; the motion is then as accurate as possible, and success is unaffected.
    t_events : list of arrays, shape (k,)
        For each of `events` of `solve` the times of its occurrences, s.
    q_events : list of arrays, shape (k, 4)
        Attitudes at these times.
    omega_events : list of arrays, shape (k, 3)
        Angular velocities at these times, body axes, rad/s.
    events : list of Event
        Occurrences of all events by their names, those of a Scene included, in the order of time.
    method : str
        Integration method.
    n_steps : int or None
        Number of steps; None without dense output.
    uncertified_steps : int
        Number of steps whose root is not certified.
    free : tuple of str
        Names of the parameters of solve(..., free=[...]); else empty.
    sensitivity : Sensitivity or None
        Derivatives with respect to the parameters `free`.
    exponents : array, shape (1,) or (6,), or None
        Lyapunov exponents of a Scene with &chaos, 1/s.
    megno : float or None
        Mean MEGNO of such a Scene.
    fli : float or None
        Fast Lyapunov indicator of such a Scene.

    Examples
    --------
    >>> box = nutate.System(shape="box", size=(4, 1, 2), mass=12)
    >>> solution = nutate.solve(box, omega0=(0.1, 0, 10), t_span=(0, 5), events="omega3")
    >>> solution.success, solution.t_events[0].round(5).tolist()
    (True, [0.96641, 2.89923, 4.83205])
    >>> solution["omega3"] is solution.columns["omega3"]
    True
    """

    _sol: Optional[Motion]
    status: int
    message: str
    method: str
    n_steps: Optional[int]
    uncertified_steps: int
    errors: dict[str, float]
    accuracy_reached: Optional[bool]
    t_events: list[Array]
    q_events: list[Array]
    omega_events: list[Array]
    sensitivity: Optional[Sensitivity]
    free: tuple[str, ...]
    exponents: Optional[Array]
    megno: Optional[float]
    fli: Optional[float]
    events: list[Happened]
    q: Array
    omega: Array
    energy: dict[str, Array]

    def __init__(self, columns: dict[str, Array], sol: Optional[Motion], **facts: Any) -> None:
        super().__init__(columns)
        vars(self).update(facts, _sol=sol)
        self.free = self.sensitivity.names if self.sensitivity is not None else ()
        self.q = stacked(columns, "q", range(4))
        self.omega = stacked(columns, "omega", range(1, 4))
        self.energy = {name: columns[name] for name in ("kinetic", "potential", "total", "work", "energy_residual")}

    @property
    def sol(self) -> Motion:
        """Dense output.

        Raises
        ------
        NutateValueError
            If `solve` was called with dense_output=False, or the motion has no rows.
        """
        if self._sol is None:
            raise refusal("the solution has no dense output (expected solve(..., dense_output=True))")
        return self._sol

    @property
    def success(self) -> bool:
        """True if the end was reached, or an event ended the motion."""
        return self.status >= 0

    def __repr__(self) -> str:
        errors = ", ".join(f"{name} {value:.1e}" for name, value in self.errors.items())
        steps = "" if self.n_steps is None else f"{self.n_steps} steps of "
        return (f"<Solution of {len(self.t)} rows, t={self.t[0]:g} to {self.t[-1]:g} s, {steps}{self.method}: "
                f"{self.message}; errors: {errors}>") if len(self.t) else f"<Solution without rows: {self.message}>"

    def view(self, **options: Any) -> Any:
        """Makes a web page with an animation.

        Parameters
        ----------
        **options
            `title`, `play`, `begin` and `start`, as for `nutate.view`.

        Returns
        -------
        Page
            Web page.
        """
        from ._page import view
        return view(self, **options)


def solve(system: Union[System, Scene], q0: Any = None, omega0: Optional[npt.ArrayLike] = None,
          t_span: Optional[Sequence[float]] = None, t_eval: Optional[npt.ArrayLike] = None,
          accuracy: Optional[float] = 1e-8, method: Optional[str] = "auto",
          events: Union[None, str, Event, Sequence[Union[str, Event]]] = None, *, frame: str = "body", dense_output: bool = True,
          free: Union[None, str, Sequence[str]] = None, max_step: Optional[float] = None, progress: bool = False,
          **settings: Any) -> Solution:
    """Computes the motion of a System, or of a Scene, from an initial state.

    Parameters
    ----------
    system : System or Scene
        Body and effects. A Scene supplies initial state, end time and events, too; arguments replace the first two.
    q0 : array, shape (4,), or Rotation
        Attitude at the start, scalar first; default: the identity.
    omega0 : array, shape (3,)
        Angular velocity at the start, rad/s, in the axes of `frame`.
    t_span : pair of float
        First and last time, s; the motion may run backward.
    t_eval : array, shape (n,)
        Times of the rows, s, in the order of the run; default: the ends of the steps.
    accuracy : float
        Largest attitude error at the end, rad; trial runs find the steps for it. `local_tolerance`, the error of each step,
        rad, or `time_step`, s, replace it.
    method : str
        "auto": chosen by the accuracy; else a method of &integrator.
    events : str, function event(t, q, omega), or a list of these
        A column such as "omega3" whose zeros are located inside the steps, or a smooth function of its arguments alone. As in
        SciPy functions may have the attributes direction (1: only rising, -1: only falling) and terminal (True: the first
        occurrence ends the motion; n: the n-th).
    frame : str
        Axes of omega0: "body" or "space".
    dense_output : bool
        False, with t_eval, saves the memory of `sol`.
    free : str or list of str
        Names of parameters, such as "body.inertia.1" or "initial.attitude", with respect to which `sensitivity` of the solution
        differentiates, as key in &free; for a System, use the names of the corresponding scene keys.
    max_step : float
        Longest adaptive step, s.
    progress : bool
        True to show the time spent while the motion is computed: by tqdm if that is installed, else in a line of the standard
        error.
    **settings
        Other keys of &integrator: local_tolerance, time_step, order, conserve, ...

    Returns
    -------
    Solution
        Rows, dense output, events and errors. A step that fails ends the motion with the rows before it and status -1.

    Raises
    ------
    NutateValueError
        If an argument is invalid.
    Exception
        Exceptions of callbacks and events, and the KeyboardInterrupt of Ctrl-C, with the rows so far as attribute `history`.

    Examples
    --------
    >>> box = nutate.System(shape="box", size=(4, 1, 2), mass=12)
    >>> solution = nutate.solve(box, omega0=(0.1, 0, 10), t_span=(0, 5), accuracy=1e-9)
    >>> q, omega = solution.sol(2.5)
    >>> omega.round(4).tolist()
    [1.4923, -1.489, -9.8356]
    >>> solution.errors["energy"] < 1e-14
    True
    """
    scene = system if isinstance(system, Scene) else None
    labels = scene.labels if scene is not None else {}
    for foreign in ("rtol", "atol"):
        if foreign in settings:
            raise refusal(f"solve has no {foreign} (did you mean accuracy, the attitude error at the end in rad?)")
    body, q0, omega0, span = start_of(system, q0, omega0, t_span)
    if "time_step" in settings or "local_tolerance" in settings:
        accuracy = None
    if "time_step" in settings and method == "auto":
        method = None
    given = {"accuracy": accuracy, "method": method, "max_step": max_step, **settings}
    if "time_step" in given:
        given["time_step"] = np.copysign(number(given["time_step"], "time_step"), span[1] - span[0])
    looked_for = [events] if callable(events) or isinstance(events, str) else list(events or ())
    times = None if t_eval is None else times_of(t_eval, span)
    rows_only = times is not None and not dense_output
    with Stepper(body, **{key: value for key, value in given.items() if value is not None}) as stepper:
        stepper.set_columns(*SETS)
        stepper.set_state(q0, omega0, span[0], frame=frame)
        if scene is not None:
            stepper.follow_chaos(scene)
        if free is not None:
            with scene_with_free(system, free, stepper.quaternion, stepper.angular_velocity) as with_free:
                stepper.differentiate(with_free)
            stepper.set_columns(*SETS, "sensitivities")
        # The copy takes over the names of the columns that the stepper has found.
        _ = stepper.column_names
        branch = copy.copy(stepper)
        add_events(stepper, looked_for)
        if scene is not None:
            add_events_of(stepper, scene)
        with shown("solve") if progress else contextlib.nullcontext():
            ends, failed = run_of(stepper, span[1], times if rows_only else None)
        sol = Motion(stepper, branch, ends) if dense_output and len(ends["t"]) else None
        columns = ends if sol is None or times is None else sol.rows(times[(times >= sol.t_min) & (times <= sol.t_max)])
        sensitivity = None if free is None else Sensitivity(ends, partial(rows_at, columns) if sol is None else sol.rows)
        return Solution(columns, sol, system=copy.copy(body), _labels=labels, method=stepper.get("method"),
                        n_steps=None if rows_only else max(len(ends["t"]) - 1, 0), uncertified_steps=stepper.uncertified_steps,
                        sensitivity=sensitivity, exponents=ends.exponents, megno=ends.megno, fli=ends.fli,
                        errors=errors_of(stepper, columns, ends.estimated_error), accuracy_reached=ends.accuracy_reached,
                        **outcome(stepper, looked_for, failed, ends.accuracy_reached, ended_early(ends["t"], span[1])))


def start_of(system: Union[System, Scene], q0: Any, omega0: Optional[npt.ArrayLike],
             t_span: Optional[Sequence[float]]) -> tuple[System, Any, Array, tuple[float, float]]:
    """Returns the system, initial state and times of its motion: those of a scene if they are not given."""
    span = None if t_span is None else vector(t_span, 2, "t_span")
    if isinstance(system, Scene):
        attitude, rates = system.initial
        q0 = attitude if q0 is None else q0
        omega0 = rates if omega0 is None else omega0
        span = np.array([0.0, system.plan[1]]) if span is None else span
        system = System(scene=system)
    if omega0 is None or span is None:
        raise refusal("omega0 or t_span is missing (expected both, or a Scene that has them)")
    return system, quaternion((1, 0, 0, 0) if q0 is None else q0, "q0"), vector(omega0, 3, "omega0"), (float(span[0]), float(span[1]))


def times_of(t_eval: npt.ArrayLike, span: tuple[float, float]) -> Array:
    """Returns the times of the rows. They must be in the order of the run, and in it."""
    times = np.atleast_1d(doubles(t_eval, "t_eval"))
    sense = 1.0 if span[1] >= span[0] else -1.0
    if (times.ndim != 1 or np.any(np.diff(sense * times) <= 0) or not np.all(np.isfinite(times))
            or np.any(sense * times < sense * span[0]) or np.any(sense * times > sense * span[1])):
        raise refusal("t_eval is out of order or outside t_span (expected times in the order of the run)")
    return times


def run_of(stepper: Stepper, end: float, times: Optional[Array]) -> tuple[History, Optional[NutateError]]:
    """Returns the rows of a run, and the reason why a step failed, if one did."""
    try:
        return stepper.run_to(end, times=times), None
    except NutateValueError:
        raise
    except NutateError as error:
        if error.status not in STEPS_FAILED or not len(error.history.get("t", ())):
            raise
        return History(error.history), error


def errors_of(stepper: Stepper, columns: dict[str, Array], attitude: Optional[float]) -> dict[str, float]:
    """Returns the largest errors of the invariants; those of energy and momentum are relative, as in the summary of `nutate run`."""
    errors = {"attitude": float("nan") if attitude is None else attitude}
    if not len(columns["t"]):
        return errors
    conserved, axis = stepper.conserved
    if conserved:
        x, y, z = columns["l_x"], columns["l_y"], columns["l_z"]
        changes = (x - x[0], y - y[0], z - z[0])
        worst = longest(*changes) if conserved == 3 else abs(axis[0] * changes[0] + axis[1] * changes[1] + axis[2] * changes[2]).max()
        errors["momentum"] = over(worst, longest(x, y, z))
    errors["energy"] = over(abs(columns["energy_residual"]).max(), (columns["kinetic"] + abs(columns["potential"])).max())
    for name, column in (("norm", "norm_error"), ("orthogonality", "orthogonality")):
        errors[name] = float(abs(columns[column]).max())
    return errors


def longest(x: Array, y: Array, z: Array) -> float:
    """Returns the greatest length of vectors with these components; scaled, as squares would leave the range of numbers."""
    scale = max(abs(x).max(), abs(y).max(), abs(z).max())
    if not scale > 0:
        return float(scale)
    x, y, z = x / scale, y / scale, z / scale
    return float(scale * np.sqrt((x * x + y * y + z * z).max()))


def over(error: float, scale: float) -> float:
    """Returns an error relative to a scale; 0 if that is 0."""
    return float(error / scale) if scale > 0 else 0.0


def ended_early(t: Array, end: float) -> bool:
    """Returns true if the last row is before the end."""
    return bool(len(t) and t[-1] != end)


def terminal_of(event: Union[str, Event]) -> int:
    """Returns the number of occurrences of an event that end the motion; 0: it does not end it."""
    return int(getattr(event, "terminal", None) or 0)


def add_events(stepper: Stepper, events: Sequence[Union[str, Event]]) -> None:
    """Lets a run look for events; each is called by its index."""
    for i, event in enumerate(events):
        if not (callable(event) or isinstance(event, str)):
            raise refusal(f"events has {event!r} (expected a column or a function)")
        stepper.add_event(event, str(i), crosses=0, direction=int(np.sign(getattr(event, "direction", 0))) or None,
                          count=terminal_of(event) or None)


def add_events_of(stepper: Stepper, scene: Scene) -> None:
    """Lets a run look for the events of a scene. Steps are evaluated again for dense output, with all effects as they were at the
    start: events that switch them are rejected."""
    groups = scene.event_groups
    if not groups:
        return
    if any(str(override).lower().lstrip("-").startswith("event.") for override in scene._given[0][1:]):
        raise refusal("solve does not support overrides of &event (expected them in the scene, or nutate.run)")
    if any(re.search(r"\bswitch\s*=", group, re.IGNORECASE) for group in groups):
        raise refusal("the scene has events that switch effects, which solve does not support (expected nutate.run)")
    stepper._call("nutate_stepper_add_events", encoded("\n".join(groups) + "\n"))


def outcome(stepper: Stepper, events: Sequence[Union[str, Event]], failed: Optional[NutateError], reached: Optional[bool],
            early: bool) -> dict[str, Any]:
    """Status, message and events of a run."""
    happenings = stepper.events
    found = [[event for event in happenings if event.name == str(i)] for i in range(len(events))]
    names = [event if isinstance(event, str) else getattr(event, "__name__", "") for event in events]
    facts: dict[str, Any] = {
        "events": [event._replace(name=names[int(event.name)]) if event.name in map(str, range(len(events))) else event
                   for event in happenings],
        "t_events": [np.array([event.t for event in happened]) for happened in found],
        "q_events": [np.reshape([event.q for event in happened], (-1, 4)) for happened in found],
        "omega_events": [np.reshape([event.omega for event in happened], (-1, 3)) for happened in found]}
    ended_by = next((i for i, event in enumerate(events) if 0 < terminal_of(event) == len(found[i])), None)
    if ended_by is not None:
        return {**facts, "status": 1, "message": f"event {ended_by} ({names[ended_by]}) ended the motion"}
    if failed is not None:
        return {**facts, "status": -1, "message": str(failed)}
    if early and happenings:
        return {**facts, "status": 1, "message": f"event {happenings[-1].name!r} ended the motion"}
    return {**facts, "status": 0, "message": "the end was reached" + (", the accuracy was not" if reached is False else "")}
