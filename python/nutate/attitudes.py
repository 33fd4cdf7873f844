"""Conversions between representations of attitude, and the exact motion of a torque-free body.

Quaternions have their scalar first and take body components to space components; a Rotation of SciPy is accepted in
their place. They need not have unit length, and their sign does not matter. Angles in radians.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._library import Array, check, library, pointer, quaternion, refusal, vector
from .systems import System


def _converted(name: str, shape: tuple[int, ...], *arguments: Any) -> Array:
    """The array that a function of the library writes."""
    result = np.empty(shape)
    check(getattr(library, name)(*[pointer(a) if isinstance(a, np.ndarray) else a for a in arguments], pointer(result)),
          f"{name[len('nutate_'):]}: a number is not finite, or out of its range")
    return result


def matrix_from_quat(q: Any) -> Array:
    """Returns the rotation matrix, body to space; shape (3, 3)."""
    return _converted("nutate_matrix_from_quat", (3, 3), quaternion(q))


def quat_from_matrix(matrix: npt.ArrayLike) -> Array:
    """Returns the unit quaternion, q[0] >= 0, of a rotation matrix, body to space, orthogonal to 1e-6; shape (4,)."""
    rows = np.ascontiguousarray(matrix, dtype=np.float64)
    if rows.shape != (3, 3):
        raise refusal(f"matrix has shape {rows.shape} (expected 3 x 3)")
    return _converted("nutate_quat_from_matrix", (4,), rows)


def euler_from_quat(q: Any) -> Array:
    """Returns precession, nutation and spin (z-x-z), rad; shape (3,)."""
    return _converted("nutate_euler_from_quat", (3,), quaternion(q))


def follow_euler(q: Any, angles: npt.ArrayLike) -> Array:
    """Returns Euler angles (z-x-z), rad, with precession and spin continued beyond +-pi from the earlier `angles`, if the body
    turned by less than pi in between; shape (3,)."""
    followed = vector(angles, 3, "angles").copy()
    check(library.nutate_follow_euler(pointer(quaternion(q)), pointer(followed)), "follow_euler: a number is not finite")
    return followed


def quat_from_euler(angles: npt.ArrayLike) -> Array:
    """Returns the unit quaternion of precession, nutation, spin, rad; shape (4,)."""
    return _converted("nutate_quat_from_euler", (4,), vector(angles, 3, "angles"))


def omega_from_euler_rates(angles: npt.ArrayLike, rates: npt.ArrayLike) -> Array:
    """Returns the angular velocity, body axes, rad/s, for Euler rates, rad/s; shape (3,)."""
    return _converted("nutate_omega_from_euler_rates", (3,), vector(angles, 3, "angles"), vector(rates, 3, "rates"))


def quat_from_axis_angle(axis: npt.ArrayLike, angle: float) -> Array:
    """Returns the unit quaternion of a rotation by an angle, rad, about an axis of any length but zero; shape (4,)."""
    return _converted("nutate_quat_from_axis_angle", (4,), vector(axis, 3, "axis"), float(angle))


def axis_angle_from_quat(q: Any) -> tuple[Array, float]:
    """Returns the unit vector along the axis, shape (3,), and the angle, rad, in [0, pi]."""
    axis, angle = np.empty(3), np.empty(1)
    check(library.nutate_axis_angle_from_quat(pointer(quaternion(q)), pointer(axis), pointer(angle)),
          "axis_angle_from_quat: a number is not finite")
    return axis, float(angle[0])


def quat_from_rotation_vector(v: npt.ArrayLike) -> Array:
    """Returns the unit quaternion of a rotation vector, axis times angle, rad; shape (4,)."""
    return _converted("nutate_quat_from_rotation_vector", (4,), vector(v, 3, "v"))


def rotation_vector_from_quat(q: Any) -> Array:
    """Returns the rotation vector, axis times angle, rad, at most pi long; shape (3,)."""
    return _converted("nutate_rotation_vector_from_quat", (3,), quaternion(q))


def quat_product(a: Any, b: Any) -> Array:
    """Returns the product a b: first the rotation b, then a; shape (4,)."""
    return _converted("nutate_quat_product", (4,), quaternion(a, "a"), quaternion(b, "b"))


def quat_normalized(q: Any) -> Array:
    """Returns the quaternion with unit length; shape (4,)."""
    return _converted("nutate_quat_normalized", (4,), quaternion(q))


def rotate_to_space(q: Any, v: npt.ArrayLike) -> Array:
    """Converts body components to space components; shape (3,)."""
    return _converted("nutate_rotate_to_space", (3,), quaternion(q), vector(v, 3, "v"))


def rotate_to_body(q: Any, v: npt.ArrayLike) -> Array:
    """Converts space components to body components; shape (3,)."""
    return _converted("nutate_rotate_to_body", (3,), quaternion(q), vector(v, 3, "v"))


def attitude_distance(a: Any, b: Any) -> float:
    """Returns the angle of the rotation between two attitudes, rad, in [0, pi]."""
    return float(_converted("nutate_attitude_distance", (1,), quaternion(a, "a"), quaternion(b, "b"))[0])


def exact_free_body(system: System, q0: Any, omega0: npt.ArrayLike, t: npt.ArrayLike) -> tuple[Array, Array]:
    """Computes the exact motion of a torque-free body from q0 and omega0 (body axes, rad/s) at t = 0: attitudes, shape (n, 4), and
    angular velocities, body axes, rad/s, shape (n, 3), at n times, s, of either sign."""
    times = np.ascontiguousarray(np.atleast_1d(t), dtype=np.float64)
    if times.ndim != 1:
        raise refusal(f"t has shape {times.shape} (expected n times)")
    q, omega = np.empty((times.size, 4)), np.empty((times.size, 3))
    system._call("nutate_exact_free_body", pointer(quaternion(q0, "q0")), pointer(vector(omega0, 3, "omega0")), times.size,
                 pointer(times), pointer(q), pointer(omega))
    return q, omega
