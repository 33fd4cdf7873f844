"""Attitudes for other programs: AEM (CCSDS 504.0-B), glTF 2.0, SPICE CK; calendar time."""

from __future__ import annotations

import ctypes
import importlib
import os
import re
from typing import Any, Callable, Optional

import numpy as np
import numpy.typing as npt

from ._library import (Array, MESSAGE_SIZE, NutateValueError, Textual, answer, check, doubles, encoded, library, number, pointer, refusal,
                       text_of)
from .attitudes import _quaternions, matrix_from_quat
from .scenes import LABELS, take_history
from .shapes import shape_of
from .steppers import Stepper
from .systems import System, group, tensor_entries
from .tables import Columns, stacked

# Names of inertial axes, as src/io/scene/reading/nutate_aem_keywords.f90 has them.
INERTIAL = {"ICRF", "ICRF2", "ICRF3", "GCRF", "EME2000", "J2000", "ECLIPJ2000", "MOD", "TOD", "TEME", "B1950"}
# Names of axes that rotate, without their numbers, as that file has them.
ROTATING = re.compile(r"(?!.*_inertial)(?:itrf|dtrf|efg|grc|gtod|tdr|tirs|wgs|lvlh|rsw|rtn|qsw|tnw|ntw|nsw|sez|vnc)(?![a-z])", re.IGNORECASE)
# Attitude error between the rows of files for other programs, rad, where the rows would be the ends of steps.
USUAL_ERROR = 1e-5
# Largest turn between two chosen rows, rad; part of the error that is used at the quarters; more rows are a mistake.
LARGEST_TURN, MARGIN, MOST_ROWS = 1.0, 0.9, 20_000_000
# Rotation between two attitudes from which its sense is not known, rad, as src/base/nutate_limits.f90 has it.
HALF_TURN = np.pi - 1e-6


def date(epoch: str, time_system: str, t: float) -> str:
    """Returns the date of a time.

    Parameters
    ----------
    epoch : str
        Date of t = 0, such as "2029-04-13T21:46:12.7".
    time_system : str
        System of both dates: "TDB", "TT", "TAI", or "UTC" with its leap seconds.
    t : float
        Time, s.

    Returns
    -------
    str
        Date.

    Raises
    ------
    NutateValueError
        If the epoch is not a date, or the date is outside the calendar.

    Examples
    --------
    >>> nutate.date("2029-04-13T21:46:00", "UTC", 90)
    '2029-04-13T21:47:30'
    """
    seconds = number(t, "t")
    try:
        return text_of(library.nutate_date, encoded(epoch), encoded(time_system), seconds)
    except ValueError:
        raise wrong_epoch(epoch, time_system) from None


def tdb(epoch: str, time_system: str, t: npt.ArrayLike) -> Array:
    """Returns barycentric dynamical time past J2000: SPICE's ephemeris time.

    Parameters
    ----------
    epoch : str
        Date of t = 0.
    time_system : str
        System of the epoch: "TDB", "TT", "TAI" or "UTC".
    t : float, or array, shape (n,)
        Times, s.

    Returns
    -------
    float, or array, shape (n,)
        Barycentric dynamical time, s.

    Raises
    ------
    NutateValueError
        If the epoch is not a date.

    Examples
    --------
    >>> nutate.tdb("2000-01-01T12:00:00", "TDB", [0, 60]).tolist()
    [0.0, 60.0]
    """
    times = np.atleast_1d(doubles(t, "t"))
    result = np.empty_like(times)
    try:
        check(library.nutate_tdb(encoded(epoch), encoded(time_system), times.size, pointer(times), pointer(result)))
    except ValueError:
        raise wrong_epoch(epoch, time_system) from None
    return result if np.ndim(t) else result[0]


def wrong_epoch(epoch: str, time_system: str) -> Exception:
    """Returns the error of an invalid date."""
    return refusal(f"{epoch!r} in {time_system!r} is not a date, or leaves the calendar (expected one such as "
                   "'2029-04-13T21:46:12.7' in TDB, TT, TAI or UTC, and times within the years 1583 to 9999, of UTC from 1972)")


class AttitudeRows(Columns):
    """Attitudes that `read_aem` has read; a mapping of column names to arrays, too.

    Attributes
    ----------
    t : array, shape (n,)
        Times since the first record, s.
    q : array, shape (n, 4)
        Attitudes, body to space, scalar first. REF_FRAME_A has the space axes and REF_FRAME_B the body axes, or vice versa if
        REF_FRAME_A is a frame of the spacecraft.
    omega : array, shape (n, 3), or None
        Angular velocities, body axes, rad/s; None if the message has none.
    segment : array of int, shape (n,)
        Numbers of the segments of the message, from 1; there are no attitudes between two segments.
    epoch : str
        Date of the first record.
    time_system : str
        System of this date.
    object : str
        Name of the body.
    object_id : str
        Its identifier.
    space_frame : str
        Name of the space axes.
    body_frame : str
        Name of the body axes.

    Examples
    --------
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "top.aem")
    >>> top = nutate.System(moments=(1, 1, 2))
    >>> nutate.solve(top, omega0=(0, 0, 0.5), t_span=(0, 2), t_eval=(0, 1, 2)).to_aem(
    ...     path, epoch="2029-04-13", time_system="TDB", space_frame="ICRF")
    >>> q, omega = nutate.read_aem(path).at([0.5, 1.5])
    >>> omega[1].round(6).tolist()
    [0.0, 0.0, 0.5]
    """

    q: Array
    omega: Optional[Array]
    segment: npt.NDArray[np.int64]
    epoch: str
    time_system: str
    object: str
    object_id: str
    space_frame: str
    body_frame: str

    def __init__(self, columns: dict[str, Array], labels: dict[str, str]) -> None:
        super().__init__(columns)
        self.q = stacked(columns, "q", range(4))
        self.omega = stacked(columns, "omega", range(1, 4)) if "omega1" in columns else None
        self.segment = columns.get("segment", np.ones(len(self.q))).astype(int)
        self.epoch, self.time_system, self.object, self.object_id, self.space_frame, self.body_frame = (
            labels.get(key, "") for key in LABELS)

    def at(self, t: npt.ArrayLike, epoch: Optional[str] = None, time_system: Optional[str] = None) -> tuple[Array, Array]:
        """Interpolates the records: the message as a frame.

        With angular velocities in the message, the rotation vector from one record to the next is a cubic polynomial of the time
        that has them at both: attitude and rate are continuous, and the error falls as the fourth power of the distance of the
        records. Without them the rate is constant between records, and the error is ``h^2 |dOmega/dt|/8``.

        Parameters
        ----------
        t : float, or array, shape (n,)
            Times since the first record, or since `epoch`, s.
        epoch : str
            Date of t = 0.
        time_system : str
            System of `epoch`; default: that of the message.

        Returns
        -------
        q : array, shape (4,) or (n, 4)
            Attitude, body to space.
        omega : array, shape (3,) or (n, 3)
            Angular velocity, body axes, rad/s.

        Raises
        ------
        NutateValueError
            If a time is outside the records, or between records that are half a revolution or more apart.
        """
        times = np.atleast_1d(doubles(t, "t")) + self._start_of(epoch, time_system)
        if times.ndim != 1:
            raise refusal(f"t has shape {times.shape} (expected n times)")
        if len(self.t) < 2:
            raise refusal("there are no attitudes between records (expected two records or more)")
        # The difference of two dates is rounded as these are.
        slack = 0.0 if epoch is None else 1e-6
        outside = ~((times >= self.t[0] - slack) & (times <= self.t[-1] + slack))
        if outside.any():
            raise refusal(f"t is outside of the records ({float(times[outside][0])!r} s after the first one; expected 0 to {float(self.t[-1])!r})")
        i = np.clip(np.searchsorted(self.t, times, side="right") - 1, 0, len(self.t) - 2)
        # The last record of a segment ends the interval before it.
        i = np.where((self.segment[i] != self.segment[i + 1]) & (times <= self.t[i]) & (i > 0), i - 1, i)
        between = self.segment[i] != self.segment[i + 1]
        if between.any():
            raise refusal(f"t is between two segments of the message ({float(times[between][0])!r} s after the first record)")
        step = (self.t[i + 1] - self.t[i])[:, None]
        s = (times - self.t[i])[:, None] / step
        turn = rotation_vectors(times_conjugate(self.q[i], self.q[i + 1]))
        angle = np.linalg.norm(turn, axis=1)
        if self.omega is None:
            vector, rate = s * turn, turn / step
        else:
            angle = np.maximum(angle, step[:, 0] * np.linalg.norm([self.omega[i], self.omega[i + 1]], axis=2).max(axis=0))
            first, last = step * self.omega[i], step * by_rate(turn, self.omega[i + 1])
            vector = s * (1 - s) ** 2 * first + s**2 * (3 - 2 * s) * turn - s**2 * (1 - s) * last
            rate = ((1 - s) * (1 - 3 * s) * first + 6 * s * (1 - s) * turn + s * (3 * s - 2) * last) / step
        if np.any(angle >= HALF_TURN):
            raise refusal(f"records are half a turn or more apart {float(self.t[i][angle >= HALF_TURN][0])!r} s after the first one (expected less)")
        # The sign of the quaternion does not jump at records.
        signs = np.cumprod(np.append(1.0, np.where(np.sum(self.q[1:] * self.q[:-1], axis=1) < 0, -1.0, 1.0)))
        q, omega = product(signs[i, None] * self.q[i], exponentials(vector)), to_rate(vector, rate)
        return (q, omega) if np.ndim(t) else (q[0], omega[0])

    def relative(self, t: npt.ArrayLike, q: npt.ArrayLike, epoch: Optional[str] = None, time_system: Optional[str] = None) -> Array:
        """Returns attitudes relative to the frame of the message, such as pointing errors of a body that is to follow it.

        Parameters
        ----------
        t : array, shape (n,)
            Times, s, as for `at`.
        q : array, shape (n, 4), or Rotation
            Attitudes, body to space.
        epoch, time_system : str
            As for `at`.

        Returns
        -------
        array, shape (n, 4)
            Quaternions from the axes of the body to those of REF_FRAME_B.

        Raises
        ------
        NutateValueError
            If a time is outside the records.
        """
        frame, _ = self.at(t, epoch, time_system)
        return times_conjugate(frame, _quaternions(q))

    def _start_of(self, epoch: Optional[str], time_system: Optional[str]) -> float:
        """Returns the time of a date after the first record, s."""
        if epoch is None:
            return 0.0
        return float(tdb(epoch, time_system or self.time_system, 0.0) - tdb(self.epoch, self.time_system, 0.0))

    def __repr__(self) -> str:
        return f"<AttitudeRows of {self.object!r}: {len(self.t)} rows from {self.epoch} {self.time_system}>"


def read_aem(path: Textual) -> AttitudeRows:
    """Reads an Attitude Ephemeris Message (CCSDS 504.0-B, version 1.0 or 2.0, KVN) with quaternions.

    Records outside USEABLE_START_TIME and USEABLE_STOP_TIME are left out. A segment that begins with the last record of the
    previous one continues it.

    Parameters
    ----------
    path : str or path
        File.

    Returns
    -------
    AttitudeRows
        Times, attitudes, angular velocities if the message has them, and names.

    Raises
    ------
    NutateOSError
        If the file cannot be read.
    NutateValueError
        If the message is invalid: "FILE:LINE: ...".

    Examples
    --------
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "box.aem")
    >>> box = nutate.System(shape="box", size=(4, 1, 2), mass=12)
    >>> solution = nutate.solve(box, omega0=(0.1, 0, 10), t_span=(0, 1), t_eval=np.linspace(0, 1, 11))
    >>> solution.to_aem(path, epoch="2029-04-13", time_system="TDB", space_frame="ICRF")
    >>> rows = nutate.read_aem(path)
    >>> rows.q.shape, rows.epoch, rows.space_frame
    ((11, 4), '2029-04-13T00:00:00', 'ICRF')
    """
    handle, facts = ctypes.c_void_p(), ctypes.create_string_buffer(MESSAGE_SIZE)
    check(*answer(library.nutate_read_aem, encoded(path), ctypes.byref(handle), facts, MESSAGE_SIZE))
    columns, _ = take_history(handle)
    found = re.findall(r"(\w+) = '((?:[^']|'')*)'", facts.value.decode("utf-8", "replace"))
    return AttitudeRows(dict(columns), {key: value.replace("''", "'") for key, value in found})


def product(a: Array, b: Array) -> Array:
    """Products of quaternions, shape (..., 4)."""
    a0, av, b0, bv = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    return np.concatenate([a0 * b0 - np.sum(av * bv, axis=-1, keepdims=True), a0 * bv + b0 * av + np.cross(av, bv)], axis=-1)


def times_conjugate(a: Array, b: Array) -> Array:
    """Returns the rotations b against a, conjugate of a times b, shape (..., 4), with a positive scalar."""
    relative = product(a * [1.0, -1.0, -1.0, -1.0], b)
    return np.where(relative[..., :1] < 0, -relative, relative)


def rotation_vectors(q: Array) -> Array:
    """Returns rotation vectors of unit quaternions, shape (n, 3)."""
    length = np.linalg.norm(q[:, 1:], axis=1, keepdims=True)
    safe = np.where(length > 0, length, 1.0)
    return q[:, 1:] * np.where(length > 0, 2 * np.arctan2(length, q[:, :1]) / safe, 2.0)


def exponentials(v: Array) -> Array:
    """Returns unit quaternions of rotation vectors, shape (n, 4)."""
    half = np.linalg.norm(v, axis=1, keepdims=True) / 2
    return np.concatenate([np.cos(half), v / 2 * np.sinc(half / np.pi)], axis=1)


def by_rate(v: Array, omega: Array) -> Array:
    """Returns the rates of change of rotation vectors v, shape (n, 3), of bodies with angular velocities omega, body axes."""
    half = np.linalg.norm(v, axis=1, keepdims=True) / 2
    safe = np.where(half > 1e-4, half, 1.0)
    weight = np.where(half > 1e-4, (1 - safe / np.tan(safe)) / (4 * safe**2), 1 / 12)
    across = np.cross(v, omega)
    return omega + across / 2 + weight * np.cross(v, across)


def to_rate(v: Array, change: Array) -> Array:
    """Returns the angular velocities, body axes, of bodies whose rotation vectors v, shape (n, 3), change at these rates."""
    angle = np.linalg.norm(v, axis=1, keepdims=True)
    safe = np.where(angle > 1e-3, angle, 1.0)
    weight = np.where(angle > 1e-3, (1 - np.sin(safe) / safe) / safe**2, 1 / 6)
    across = np.cross(v, change)
    rate: Array = change - np.sinc(angle / 2 / np.pi) ** 2 / 2 * across + weight * np.cross(v, across)
    return rate


def body_text(system: System) -> str:
    """Returns a body as a group &body: its shape, if it is known to have one, else its inertia."""
    shape = shape_of(system)
    if shape is not None:
        return group("body", shape=shape[0], size=shape[1], mass=system.mass, center_of_mass=system.center_of_mass)
    return group("body", inertia_tensor=tensor_entries(system.inertia), mass=system.mass or None, center_of_mass=system.center_of_mass, check_triangle=False)


def constant_rate(q1: Array, q2: Array, s: Array) -> Array:
    """Attitudes between those of two sets, of shape (n, 4), at fractions s of the times between them, at a constant rate."""
    cosine = np.sum(q1 * q2, axis=-1, keepdims=True)
    q2 = np.where(cosine < 0, -q2, q2)
    half = 2 * np.arcsin(np.minimum(np.linalg.norm(q2 - q1, axis=-1, keepdims=True) / 2, 1))
    safe = np.where(half > 1e-9, half, 1.0)
    first, second = (np.where(half > 1e-9, np.sin(part * half) / np.sin(safe), part) for part in (1 - s[:, None], s[:, None]))
    return first * q1 + second * q2


def resampled(sol: Any, error: float, motion: Optional[Callable[[Array], tuple[Array, Array]]] = None) -> Array:
    """Finds times such that a rotation at a constant rate between them stays within an attitude error, rad. From the whole motion on,
    an interval is halved as long as it rotates the body by more than a radian, or that rotation departs from the motion by more than 0.9 of
    the error at one of its quarters or at an end of a step inside it. That departure is ``h^2 |dOmega/dt|/8`` at its largest.
    `motion` returns attitudes and angular velocities at times, by default those of the dense output `sol`."""
    at: Callable[[Array], tuple[Array, Array]] = motion or sol
    if not 1e-12 <= error <= 1:
        raise refusal(f"error is {error!r} (expected 1e-12 to 1 rad)")
    starts, ends = np.array([sol.t_min]), np.array([sol.t_max])
    marks = np.sort(sol._ends["t"])
    kept: list[Array] = []
    while len(starts):
        quarters = starts[:, None] + (ends - starts)[:, None] * np.arange(5) / 4
        quarters[:, 4] = ends
        q, omega = at(quarters.ravel())
        q, omega = q.reshape(-1, 5, 4), omega.reshape(-1, 5, 3)
        good = np.max(np.linalg.norm(omega, axis=2), axis=1) * (ends - starts) <= LARGEST_TURN
        for k in (1, 2, 3):
            between = constant_rate(q[:, 0], q[:, 4], np.full(len(starts), k / 4))
            good &= distances(q[:, k], between) <= MARGIN * error
        first, last = np.searchsorted(marks, starts, side="right"), np.searchsorted(marks, ends, side="left")
        for i in np.flatnonzero(good & (first < last)):
            inside = marks[first[i]:last[i]]
            between = constant_rate(np.repeat(q[i:i + 1, 0], len(inside), 0), np.repeat(q[i:i + 1, 4], len(inside), 0),
                                    (inside - starts[i]) / (ends[i] - starts[i]))
            good[i] = np.all(distances(at(inside)[0], between) <= MARGIN * error)
        kept.append(starts[good])
        middles = (starts + (ends - starts) / 2)[~good]
        starts, ends = np.concatenate([starts[~good], middles]), np.concatenate([middles, ends[~good]])
        if len(starts) > MOST_ROWS:
            raise refusal(f"an error of {error!r} rad needs more than 2e7 rows (expected a larger error)")
    return np.append(np.sort(np.concatenate(kept)), sol.t_max)


def distances(q1: Array, q2: Array) -> Array:
    """Angles between attitudes, rad; shape (n,)."""
    chord = np.minimum(np.linalg.norm(q1 - q2, axis=-1), np.linalg.norm(q1 + q2, axis=-1))
    return np.asarray(4 * np.arcsin(np.minimum(chord / 2, 1)))


class Exchange(Columns):
    """Methods of a Solution that write it for other programs. With `error`, rows of its dense output are chosen so that a rotation at a constant rate
    between them, which readers assume, stays within this attitude error, rad. Without it the rows at `t_eval` are written; a solution
    without `t_eval` has the ends of steps, and the error is 1e-5. 0 writes the rows as they are. Rows that are half a revolution or
    more apart are rejected."""

    _sol: Any
    system: System
    _labels: dict[str, str]

    def to_aem(self, path: Textual, *, epoch: Optional[str] = None, time_system: Optional[str] = None, object: Optional[str] = None,
               object_id: Optional[str] = None, space_frame: Optional[str] = None, body_frame: Optional[str] = None,
               version: str = "2.0", error: Optional[float] = None) -> None:
        """Writes an Attitude Ephemeris Message (CCSDS 504.0-B). A Scene that was solved supplies names that are not given.

        The quaternion is (q1, q2, q3, q0), from `space_frame` (REF_FRAME_A) to the body axes (REF_FRAME_B). Attitudes in the LVLH
        frame of an orbit are converted to inertial axes, which `space_frame` names; for a rotating frame it names this frame.

        Parameters
        ----------
        path : str or path
            File.
        epoch : str
            Date of t = 0.
        time_system : str
            System of the epoch: "TDB", "TT", "TAI" or "UTC".
        object, object_id, space_frame, body_frame : str
            Names in the message.
        version : str
            "2.0", or "1.0" without angular velocities.
        error : float
            Attitude error between the chosen rows, rad.

        Raises
        ------
        NutateValueError
            If a name is missing or invalid.
        NutateOSError
            If the file cannot be written.
        """
        labels = self._named(epoch=epoch, time_system=time_system, object=object, object_id=object_id, space_frame=space_frame,
                             body_frame=body_frame)
        labels.setdefault("object", "BODY")
        error = self._error_of(error)
        t, q, omega = self._attitudes(error, labels.get("space_frame", ""))
        check(*answer(library.nutate_write_aem, encoded(path), encoded(group("scene", **labels)), len(t), pointer(t), pointer(q),
                      pointer(omega), encoded(version), error))

    def to_gltf(self, path: Textual, *, object: Optional[str] = None, speed: float = 1.0, error: Optional[float] = None) -> None:
        """Writes the moving body as glTF 2.0, for Blender and browsers: its shape, or the box with its inertia.

        Parameters
        ----------
        path : str or path
            File.
        object : str
            Name of the body.
        speed : float
            Simulated seconds per second of animation.
        error : float
            Attitude error between the chosen rows, rad.

        Raises
        ------
        NutateValueError
            If an argument is invalid.
        NutateOSError
            If the file cannot be written.
        """
        facts = group("scene", object=self._named(object=object).get("object", "BODY")) + body_text(self.system)
        t, q, _ = self._attitudes(self._error_of(error))
        check(*answer(library.nutate_write_gltf, encoded(path), encoded(facts), len(t), pointer(t), pointer(q), number(speed, "speed")))

    def to_spice_ck(self, path: Textual, *, epoch: Optional[str] = None, time_system: Optional[str] = None,
                    object: Optional[str] = None, space_frame: Optional[str] = None, body_frame: Optional[str] = None,
                    spacecraft: int = -999, error: Optional[float] = None) -> list[str]:
        """Writes a SPICE CK of type 3 with angular velocities, and beside it the text kernels that it needs.

        Parameters
        ----------
        path : str or path
            File of the CK.
        epoch : str
            Date of t = 0.
        time_system : str
            System of the epoch: "TDB", "TT", "TAI" or "UTC".
        object : str
            Name of the body.
        space_frame : str
            Frame of SPICE, such as "J2000" or "ECLIPJ2000"; "ICRF" stands for "J2000". Attitudes in the LVLH frame of an orbit
            are converted to it.
        body_frame : str
            Name of the body's frame in SPICE; default: NUTATE_BODY.
        spacecraft : int
            Negative number of the clock.
        error : float
            Attitude error between the chosen rows, rad.

        Returns
        -------
        list of str
            Paths of the CK, of the clock (.tsc) and of the body's frame (.tf), for `spiceypy.furnsh`.

        Raises
        ------
        ImportError
            If spiceypy is not installed.
        NutateValueError
            If a name is missing or invalid.
        """
        spice = spiceypy()
        labels = self._named(epoch=epoch, time_system=time_system, object=object, space_frame=space_frame, body_frame=body_frame)
        for key in ("epoch", "time_system", "space_frame"):
            if key not in labels:
                raise refusal(f"a CK needs {key} (expected epoch='2029-04-13T21:46:12.7', time_system='TDB', space_frame='J2000')")
        if spacecraft > -1 or spacecraft < -2_000_000:
            raise refusal(f"spacecraft is {spacecraft!r} (expected a number below 0)")
        t, q, omega = self._attitudes(self._error_of(error), labels["space_frame"])
        return write_ck(spice, os.fsdecode(path), labels, spacecraft, tdb(labels["epoch"], labels["time_system"], t), q, omega)

    def _named(self, **given: Optional[str]) -> dict[str, str]:
        """Returns epoch and names: those given, else those of the scene."""
        return {key: value for key in LABELS if (value := given.get(key) or self._labels.get(key, ""))}

    def _error_of(self, error: Optional[float]) -> float:
        """Returns the attitude error between rows: the one given, else the usual one if the rows are the ends of steps, or 0."""
        if error is not None:
            return number(error, "error")
        return USUAL_ERROR if self._sol is not None and np.array_equal(self.t, self._sol._ends["t"]) else 0.0

    def _knows_axes(self) -> bool:
        """Returns true unless the space axes are those of a rotating frame."""
        try:
            self.system.space_axes(0.0)
        except NutateValueError:
            return False
        return True

    def _on_orbit(self) -> bool:
        """Returns true if the body moves along an orbit."""
        try:
            return bool(Stepper(self.system).orbit)
        except NutateValueError:
            return False

    def _attitudes(self, error: float, frame: str = "") -> tuple[Array, Array, Array]:
        """Times, attitudes and angular velocities, in ascending order: in inertial axes, or relative to a rotating frame; `frame` must not
        name axes of the other kind."""
        rate, known = self.system.frame_rate, self._knows_axes()
        if not known and frame.upper() in INERTIAL:
            raise refusal(f"the space axes rotate, and space_frame={frame!r} names inertial axes (expected the name of the axes of "
                          "&rotating_frame, such as 'LAB')")
        if ROTATING.match(frame) and self._on_orbit():
            raise refusal(f"space_frame={frame!r} names axes that rotate, and the attitudes are in inertial axes (expected their name, such as 'ICRF')")

        def converted(t: Array, q: Array, omega: Array) -> tuple[Array, Array]:
            # The angular velocities of a solution are absolute.
            if not known:
                return q, omega - np.array([matrix_from_quat(attitude).T @ rate for attitude in q])
            return (product(self.system.space_axes(t), q) if np.any(rate) else q), omega

        if error:
            if self._sol is None:
                raise refusal("error needs the dense output of the solution (expected dense_output=True, and a step or more)")
            t = resampled(self._sol, error, lambda t: converted(t, *self._sol(t)))
            q, omega = converted(t, *self._sol(t))
        else:
            t = self.t
            q, omega = converted(t, stacked(self, "q", range(4)), stacked(self, "omega", range(1, 4)))
        order = np.argsort(t, kind="stable")
        t, q, omega = (np.ascontiguousarray(values[order], dtype=np.float64) for values in (t, q, omega))
        rates = np.linalg.norm(omega, axis=1)
        far = np.flatnonzero((np.diff(t) * np.maximum(rates[:-1], rates[1:]) >= np.pi) | (distances(q[:-1], q[1:]) >= HALF_TURN))
        if len(far):
            raise refusal(f"the body turns by half a turn or more from the row at t = {float(t[far[0]])!r} s to the next one "
                          "(expected rows closer together, or error=)")
        return t, q, omega


def spiceypy() -> Any:
    """Returns the package spiceypy, if it is installed."""
    try:
        return importlib.import_module("spiceypy")
    except ImportError:
        raise ImportError("to_spice_ck needs the package spiceypy, which is not installed (expected pip install spiceypy)") from None


def write_ck(spice: Any, path: str, labels: dict[str, str], spacecraft: int, times: Array, q: Array, omega: Array) -> list[str]:
    """Writes a CK of type 3 and its text kernels; `times` are TDB past J2000, s. Returns their paths."""
    frame = {"ICRF": "J2000"}.get(labels["space_frame"].upper(), labels["space_frame"].upper())
    body = labels.get("body_frame", "NUTATE_BODY").upper()
    if spice.namfrm(frame) == 0:
        raise refusal(f"SPICE has no frame {frame!r} (expected space_frame='J2000', or 'ECLIPJ2000')")
    if not re.fullmatch(r"[A-Z0-9_]{1,26}", body):
        raise refusal(f"body_frame {body!r} is no name of SPICE (expected up to 26 letters, digits and _)")
    if np.any(np.diff(times) <= 0):
        raise refusal("two rows are closer than TDB can tell apart (expected rows at longer intervals)")
    stem = path[:-3] if path.lower().endswith(".bc") else path
    paths = [path, stem + ".tsc", stem + ".tf"]
    for name, start in zip(paths, (b"DAF/CK", b"KPL/SCLK", b"KPL/FK")):
        check_replaced(name, start)
    # Ticks of a microsecond from the second before the first row: small numbers, which keep their digits.
    origin = np.floor(times[0]) - 1
    ticks = (times - origin) * 1e6
    texts = (clock_text(spacecraft, origin), frame_text(spacecraft, body))
    rates = np.array([matrix_from_quat(attitude) @ rate for attitude, rate in zip(q, omega)])
    partial = path + ".partial"
    if os.path.exists(partial):
        os.remove(partial)
    handle = spice.ckopn(partial, "nutate", 0)
    try:
        # The C-matrix takes components from space to body: the conjugate quaternion.
        spice.ckw03(handle, ticks[0], ticks[-1], 1000 * spacecraft, frame, True, labels.get("object", "BODY")[:40], len(ticks), ticks,
                    q * np.array([1.0, -1.0, -1.0, -1.0]), rates, 1, ticks[:1])
    finally:
        spice.ckcls(handle)
    for name, text in zip(paths[1:], texts):
        with open(name, "w", encoding="ascii") as file:
            file.write(text)
    os.replace(partial, path)
    return paths


def check_replaced(path: str, start: bytes) -> None:
    """Raises an error for a file of another kind than the one that is to take its place."""
    if os.path.exists(path) and os.path.getsize(path):
        with open(path, "rb") as file:
            if not file.read(len(start)) == start:
                raise refusal(f"{path} exists and is not a kernel of this kind (expected another name, or remove it)")


def clock_text(spacecraft: int, origin: float) -> str:
    """Returns a clock kernel: ticks of a microsecond of TDB from an origin, s past J2000."""
    number = -spacecraft
    lines = {"SCLK_KERNEL_ID": "@2026-01-01", f"SCLK_DATA_TYPE_{number}": "1", f"SCLK01_TIME_SYSTEM_{number}": "1",
             f"SCLK01_N_FIELDS_{number}": "2", f"SCLK01_MODULI_{number}": "10000000000 1000000", f"SCLK01_OFFSETS_{number}": "0 0",
             f"SCLK01_OUTPUT_DELIM_{number}": "1", f"SCLK_PARTITION_START_{number}": "0.0", f"SCLK_PARTITION_END_{number}": "1.0E+16",
             f"SCLK01_COEFFICIENTS_{number}": f"0 {float(origin)!r} 1"}
    return "KPL/SCLK\n\n\\begindata\n" + "".join(f"{key} = ( {value} )\n" for key, value in lines.items()) + "\\begintext\n"


def frame_text(spacecraft: int, body: str) -> str:
    """Returns a frame kernel: the body's axes by its CK."""
    code = 1000 * spacecraft
    lines = {f"FRAME_{body}": str(code), f"FRAME_{code}_NAME": f"'{body}'", f"FRAME_{code}_CLASS": "3", f"FRAME_{code}_CLASS_ID": str(code),
             f"FRAME_{code}_CENTER": str(spacecraft), f"CK_{code}_SCLK": str(spacecraft), f"CK_{code}_SPK": str(spacecraft)}
    return "KPL/FK\n\n\\begindata\n" + "".join(f"{key} = {value}\n" for key, value in lines.items()) + "\\begintext\n"
