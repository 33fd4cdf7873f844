"""Reaction wheels, inner spheres, orbits and rotating frames: methods of a System that add them, and of a Stepper that read them."""

from __future__ import annotations

import copy
import operator
from typing import NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from ._library import Array, doubles, encoded, number, pointer, refusal, vector
from ._owners import Owner, Recipe


class Wheel(NamedTuple):
    """Current state of a reaction wheel.

    Examples
    --------
    >>> body = nutate.System(moments=(1, 1.2, 0.4))
    >>> body.add_wheel(axis=(0, 0, 1), inertia=1e-3, speed=100)
    >>> nutate.Stepper(body).wheels[0].speed
    100.0
    """

    speed: float
    """Speed relative to the body, rad/s."""
    momentum: float
    """Absolute angular momentum about its axis, N m s."""
    motor_work: float
    """Work of the motor since the state was set, J."""
    friction_work: float
    """Work of the bearing friction since the state was set, J."""


class Sphere(NamedTuple):
    """Current state of an inner sphere.

    Examples
    --------
    >>> body = nutate.System(moments=(1.7, 1.1, 0.9))
    >>> body.add("inner_sphere", inertia=0.3, damping=0.5, angular_velocity=(0, 0, 2))
    >>> nutate.Stepper(body).spheres[0].rate.tolist()
    [0.0, 0.0, 2.0]
    """

    rate: Array
    """Angular velocity relative to the body, body axes, rad/s; shape (3)."""
    momentum: Array
    """Angular momentum, space axes, N m s; shape (3)."""
    energy: float
    """Kinetic energy, J."""
    friction_work: float
    """Work of the friction since the state was set, J."""


class WheelMounting(Recipe):
    """Methods of a System for reaction wheels, the Earth's field and forces. Frames, orbits and controllers are added as in a
    scene: system.add("orbit", altitude=500e3), system.add("gravity_gradient"), system.add("controller", law="quaternion",
    by="wheels", attitude_gain=0.01, rate_gain=0.12, sample=0.5); inertia=..., attitude_gain_matrix=...,
    rate_gain_matrix=... likewise."""

    def add_earth_field(self, moment: Optional[npt.ArrayLike] = None, *, epoch_angle: float = 0.0,
                        coefficients: Optional[npt.ArrayLike] = None) -> None:
        """Adds a magnetic moment in the field of the Earth along the orbit, which is required.

        Parameters
        ----------
        moment : array, shape (3,)
            Magnetic moment, body axes, A m2; default: none, so that the field serves magnetorquers only.
        epoch_angle : float
            Angle of Greenwich from the equinox at t = 0, rad.
        coefficients : array, shape (3,)
            g11, h11, g10 of the dipole, T; default: those of 2025.

        Raises
        ------
        NutateValueError
            If the system has no orbit, or a value is not finite.

        Examples
        --------
        >>> body = nutate.System(moments=(1, 1.2, 0.4))
        >>> body.add("orbit", altitude=500e3)
        >>> body.add_earth_field(moment=(0, 0.02, 0.1), epoch_angle=0.7)
        """
        self._add_earth_field(None if moment is None else vector(moment, 3, "moment").copy(), number(epoch_angle, "epoch_angle"),
                              None if coefficients is None else vector(coefficients, 3, "coefficients").copy())

    def _add_earth_field(self, moment: Optional[Array], epoch_angle: float, coefficients: Optional[Array]) -> None:
        self._call("nutate_system_add_earth_field", pointer(moment), epoch_angle, pointer(coefficients))
        self._add("_add_earth_field", moment, epoch_angle, coefficients)

    def add_force(self, body_point: npt.ArrayLike, force: npt.ArrayLike, axes: str = "space", *, start: float = -np.inf,
                  stop: float = np.inf) -> None:
        """Adds a constant force at a point of the body.

        Parameters
        ----------
        body_point : array, shape (3,)
            Point, body axes, m.
        force : array, shape (3,)
            Force, N, in `axes`.
        axes : str
            "space", "body" or, with an orbit, "lvlh" or "inertial".
        start, stop : float
            Times between which the force acts, s.

        Raises
        ------
        NutateValueError
            If an argument is invalid.

        Examples
        --------
        >>> body = nutate.System(moments=(1, 2, 2.5))
        >>> body.add_force((0, 0.1, 0), (2, 0, 0), "body", stop=1)
        >>> nutate.solve(body, omega0=(0, 0, 0), t_span=(0, 2)).omega[-1].round(9).tolist()
        [0.0, 0.0, -0.08]
        """
        self._add_force(vector(body_point, 3, "body_point").copy(), vector(force, 3, "force").copy(), axes, number(start, "start"),
                        number(stop, "stop"))

    def _add_force(self, body_point: Array, force: Array, axes: str, start: float, stop: float) -> None:
        self._call("nutate_system_add_force", pointer(body_point), pointer(force), encoded(axes), start, stop)
        self._add("_add_force", body_point, force, axes, start, stop)

    def add_wheel(self, axis: npt.ArrayLike, inertia: float, speed: float = 0.0, *, friction: float = 0.0,
                  torque_limit: float = np.inf, speed_limit: float = np.inf, torque: Optional[float] = None, frequency: float = 0.0,
                  phase: float = 0.0, start: float = -np.inf, stop: float = np.inf,
                  table: Optional[tuple[npt.ArrayLike, npt.ArrayLike]] = None, interpolation: str = "linear",
                  outside: str = "zero") -> None:
        """Adds a reaction wheel. The inertia of the body includes its wheels, locked.

        The motor torque is torque cos(2 pi frequency t + phase), or that of a table. A wheel without either is driven by a
        controller, or by the program with `Stepper.set_motor`.

        Parameters
        ----------
        axis : array, shape (3,)
            Axis, body axes, of any length but zero.
        inertia : float
            Moment of inertia about the axis, kg m2.
        speed : float
            Initial speed relative to the body, rad/s.
        friction : float
            Coefficient of bearing friction, N m s.
        torque_limit : float
            Largest motor torque, N m.
        speed_limit : float
            Largest speed, rad/s.
        torque : float
            Amplitude of the motor torque, N m.
        frequency : float
            Frequency of the motor torque, Hz.
        phase : float
            Phase of the motor torque, rad.
        start, stop : float
            Times between which the motor acts, s.
        table : pair of arrays, shape (n,)
            Times, s, and motor torques, N m.
        interpolation, outside : str
            Keys of the table, as in &wheel.

        Raises
        ------
        NutateValueError
            If an argument is invalid.

        Examples
        --------
        >>> body = nutate.System(moments=(1, 1.2, 0.4))
        >>> body.add_wheel(axis=(0, 0, 1), inertia=1e-3, torque=0.01)
        >>> nutate.solve(body, omega0=(0, 0, 0), t_span=(0, 2)).omega[-1].round(6).tolist()
        [0.0, 0.0, -0.050125]
        """
        if torque is not None and table is not None:
            raise refusal("torque and table exclude each other (expected one of them)")
        if torque is None and (frequency, phase) != (0.0, 0.0):
            raise refusal("frequency or phase without torque (expected torque)")
        if torque is None and table is None and (start, stop) != (-np.inf, np.inf):
            raise refusal("start or stop without torque or table (expected one of them)")
        window, motor, lines = (number(start, "start"), number(stop, "stop")), None, None
        if table is not None:
            times, torques = (doubles(column, "table").copy() for column in table)
            if times.ndim != 1 or torques.shape != times.shape:
                raise refusal(f"the table has times of shape {times.shape} and torques of shape {torques.shape} (expected (n,) twice)")
            lines = (times, torques, interpolation, outside, *window)
        given = (vector(axis, 3, "axis").copy(), number(inertia, "inertia"), number(speed, "speed"), number(friction, "friction"),
                 number(torque_limit, "torque_limit"), number(speed_limit, "speed_limit"))
        if torque is not None:
            motor = (number(torque, "torque"), number(frequency, "frequency"), number(phase, "phase"), *window)
        self._add_wheel(given, motor, lines)

    def _add_wheel(self, given: tuple[Array, float, float, float, float, float], motor: Optional[tuple[float, ...]],
               table: Optional[tuple[Array, Array, str, str, float, float]]) -> None:
        # On a copy, so that a motor that is rejected leaves no wheel without one.
        with copy.copy(self) as twin:
            twin._call("nutate_system_add_wheel", pointer(given[0]), *given[1:])
            count = twin._count("nutate_system_wheel_count")
            if motor is not None:
                twin._call("nutate_system_add_motor", count, *motor)
            elif table is not None:
                times, torques, interpolation, outside, start, stop = table
                keys = f"interpolation = '{interpolation}', outside = '{outside}'"
                keys += f", start = {start!r}" if start != -np.inf else ""
                keys += f", stop = {stop!r}" if stop != np.inf else ""
                twin._call("nutate_system_add_motor_table", count, times.size, pointer(times), pointer(torques), encoded(keys))
            self._owned, twin._owned = twin._owned, self._owned
        self._add("_add_wheel", given, motor, table)


class SatelliteState(Owner):
    """Methods of a Stepper for reaction wheels, inner spheres, orbit and frame."""

    @property
    def wheels(self) -> list[Wheel]:
        """Current states of all reaction wheels."""
        wheels, numbers = [], np.empty(4)
        for i in range(self._count("nutate_stepper_wheel_count")):
            self._call("nutate_stepper_wheel", i + 1, pointer(numbers[0:1]), pointer(numbers[1:2]), pointer(numbers[2:]))
            wheels.append(Wheel(*numbers.tolist()))
        return wheels

    @property
    def spheres(self) -> list[Sphere]:
        """Current states of all inner spheres, which System.add("inner_sphere", inertia=..., damping=...) adds."""
        spheres, numbers = [], np.empty(8)
        for i in range(self._count("nutate_stepper_sphere_count")):
            self._call("nutate_stepper_sphere", i + 1, pointer(numbers[0:3]), pointer(numbers[3:6]), pointer(numbers[6:7]),
                       pointer(numbers[7:8]))
            spheres.append(Sphere(numbers[0:3].copy(), numbers[3:6].copy(), float(numbers[6]), float(numbers[7])))
        return spheres

    def set_motor(self, wheel: int, torque: float) -> None:
        """Sets the motor torque of a wheel, which is held until it is set again or a state is set.

        Parameters
        ----------
        wheel : int
            Index in `wheels`: 0 for the first, -1 for the last.
        torque : float
            Torque, N m.

        Raises
        ------
        NutateValueError
            If there is no such wheel, or another motor or a controller drives it.
        """
        count = self._count("nutate_stepper_wheel_count")
        index = operator.index(wheel)
        if not -count <= index < count:
            raise refusal(f"wheel {index} does not exist (expected 0 to {count - 1})" if count
                          else "the system has no wheels (expected add_wheel)")
        self._call("nutate_stepper_set_motor", index % count + 1, number(torque, "torque"))

    @property
    def jacobi(self) -> float:
        """Jacobi integral T + V - omega.l, J; T + V if the space axes do not rotate."""
        return float(self._read("nutate_stepper_jacobi", 1)[0])

    @property
    def time_dependent_work(self) -> float:
        """Work of time-dependent potentials since the state was set, J."""
        return float(self._read("nutate_stepper_time_dependent_work", 1)[0])

    @property
    def orbit(self) -> tuple[Array, float]:
        """Position on the orbit, from the centre of attraction, inertial axes, m, shape (3,), and the true anomaly, rad."""
        position, anomaly = np.empty(3), np.empty(1)
        self._call("nutate_stepper_orbit", pointer(position), pointer(anomaly))
        return position, float(anomaly[0])

    @property
    def lvlh_attitude(self) -> tuple[Array, Array]:
        """Attitude in the LVLH frame, as a quaternion, shape (4,), and as roll, pitch, yaw, rad, shape (3,)."""
        q, angles = np.empty(4), np.empty(3)
        self._call("nutate_stepper_lvlh_attitude", pointer(q), pointer(angles))
        return q, angles
