"""Reaction wheels, orbits and rotating frames: methods of a System that add them, and of a Stepper that read them."""

from __future__ import annotations

import ctypes
import operator
from typing import NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from ._library import Array, encoded, pointer, refusal, vector
from ._owners import Owner, Recipe


class Wheel(NamedTuple):
    """Current state of a reaction wheel."""

    speed: float
    """Speed relative to the body, rad/s."""
    momentum: float
    """Absolute angular momentum about its axis, N m s."""
    motor_work: float
    """Work of the motor since the state was set, J."""
    friction_work: float
    """Work of the bearing friction since the state was set, J."""


class WheelMounting(Recipe):
    """Methods of a System for reaction wheels, the Earth's field and forces. Frames, orbits and controllers are added as in a
    scene: system.add("orbit", altitude=500e3), system.add("gravity_gradient"), system.add("controller", law="quaternion",
    by="wheels", attitude_gain=0.01, rate_gain=0.12, sample=0.5); inertia=..., attitude_gain_matrix=...,
    rate_gain_matrix=... likewise."""

    def add_earth_field(self, moment: Optional[npt.ArrayLike] = None, *, epoch_angle: float = 0.0,
                        coefficients: Optional[npt.ArrayLike] = None) -> None:
        """Adds a magnetic moment, body axes, A m2, in the field of the Earth along the orbit, which is required. Without a
        moment the field serves magnetorquers only. epoch_angle is the angle of Greenwich from the equinox at t = 0, rad;
        coefficients are g11, h11, g10 of the dipole, T; default: those of 2025."""
        self._add_earth_field(None if moment is None else vector(moment, 3, "moment").copy(), float(epoch_angle),
                              None if coefficients is None else vector(coefficients, 3, "coefficients").copy())

    def _add_earth_field(self, moment: Optional[Array], epoch_angle: float, coefficients: Optional[Array]) -> None:
        self._call("nutate_system_add_earth_field", pointer(moment), epoch_angle, pointer(coefficients))
        self._add("_add_earth_field", moment, epoch_angle, coefficients)

    def add_force(self, body_point: npt.ArrayLike, force: npt.ArrayLike, axes: str = "space", *, start: float = -np.inf,
                  stop: float = np.inf) -> None:
        """Adds a constant force, N, at a point of the body, body axes, m, from start to stop, s. Its axes are "space", "body" or, with
        an orbit, "lvlh" or "inertial"."""
        self._add_force(vector(body_point, 3, "body_point").copy(), vector(force, 3, "force").copy(), axes, float(start), float(stop))

    def _add_force(self, body_point: Array, force: Array, axes: str, start: float, stop: float) -> None:
        self._call("nutate_system_add_force", pointer(body_point), pointer(force), encoded(axes), start, stop)
        self._add("_add_force", body_point, force, axes, start, stop)

    def add_wheel(self, axis: npt.ArrayLike, inertia: float, speed: float = 0.0, *, friction: float = 0.0,
                  torque_limit: float = np.inf, speed_limit: float = np.inf, torque: Optional[float] = None, frequency: float = 0.0,
                  phase: float = 0.0, start: float = -np.inf, stop: float = np.inf,
                  table: Optional[tuple[npt.ArrayLike, npt.ArrayLike]] = None, interpolation: str = "linear",
                  outside: str = "zero") -> None:
        """Adds a reaction wheel: its axis, body axes, of any length but zero, its inertia about the axis, kg m2, its initial speed
        relative to the body, rad/s, its bearing friction, N m s, and the limits of motor torque, N m, and speed, rad/s. The
        inertia of the body includes its wheels, locked. A motor gives torque cos(2 pi frequency t + phase), N m (frequency in
        Hz, phase in rad), or interpolates a table (t, torque), s and N m, from start to stop, s. A wheel without a motor is
        driven by a controller, or by the program with Stepper.set_motor."""
        if torque is not None and table is not None:
            raise refusal("torque and table exclude each other (expected one of them)")
        window, motor, lines = (float(start), float(stop)), None, None
        if table is not None:
            times, torques = (np.array(column, dtype=np.float64) for column in table)
            if times.ndim != 1 or torques.shape != times.shape:
                raise refusal(f"the table has times of shape {times.shape} and torques of shape {torques.shape} (expected (n,) twice)")
            lines = (times, torques, interpolation, outside, *window)
        given = (vector(axis, 3, "axis").copy(), float(inertia), float(speed), float(friction), float(torque_limit), float(speed_limit))
        if torque is not None:
            motor = (float(torque), float(frequency), float(phase), *window)
        self._add_wheel(given, motor, lines)

    def _add_wheel(self, given: tuple[Array, float, float, float, float, float], motor: Optional[tuple[float, ...]],
               table: Optional[tuple[Array, Array, str, str, float, float]]) -> None:
        self._call("nutate_system_add_wheel", pointer(given[0]), *given[1:])
        self._add("_add_wheel", given, None, None)
        count = ctypes.c_size_t()
        self._call("nutate_system_wheel_count", ctypes.byref(count))
        if motor is not None:
            self._call("nutate_system_add_motor", count.value, *motor)
        elif table is not None:
            times, torques, interpolation, outside, start, stop = table
            keys = f"interpolation = '{interpolation}', outside = '{outside}'"
            keys += f", start = {start!r}" if np.isfinite(start) else ""
            keys += f", stop = {stop!r}" if np.isfinite(stop) else ""
            self._call("nutate_system_add_motor_table", count.value, times.size, pointer(times), pointer(torques), encoded(keys))
        self._additions[-1] = ("_add_wheel", (given, motor, table))


class SatelliteState(Owner):
    """Methods of a Stepper for reaction wheels, orbit and frame."""

    @property
    def wheels(self) -> list[Wheel]:
        """Current states of all reaction wheels."""
        count, numbers = ctypes.c_size_t(), np.empty(4)
        self._call("nutate_stepper_wheel_count", ctypes.byref(count))
        wheels = []
        for i in range(count.value):
            self._call("nutate_stepper_wheel", i + 1, pointer(numbers[0:1]), pointer(numbers[1:2]), pointer(numbers[2:]))
            wheels.append(Wheel(*numbers.tolist()))
        return wheels

    def set_motor(self, wheel: int, torque: float) -> None:
        """Sets the motor torque of wheels[wheel], N m, which is held until it is set again or a state is set. Wheels count
        from 0, as in the list; -1 is the last."""
        count = ctypes.c_size_t()
        self._call("nutate_stepper_wheel_count", ctypes.byref(count))
        number = operator.index(wheel)
        if not -count.value <= number < count.value:
            raise refusal(f"wheel {number} does not exist (expected 0 to {count.value - 1})" if count.value
                          else "the system has no wheels (expected add_wheel)")
        self._call("nutate_stepper_set_motor", number % count.value + 1, float(torque))

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
