"""Conversions between representations of attitude, and the exact motion of a torque-free body.

Quaternions are scalar first and convert body components to space components; a Rotation of SciPy is accepted in
their place. They need not have unit length, and their sign does not matter. Each function accepts one attitude or an
array of them: a quaternion has shape (4,) or (n, 4), and the result has a leading axis of length n then. Angles are in
radians unless `degrees` is True.
"""

from __future__ import annotations

import ctypes
import importlib
from typing import Any, Iterator, Optional

import numpy as np
import numpy.typing as npt

from ._library import Array, check, doubles, library, pointer, quaternion, refusal, refuse_order, vector
from .systems import System


def _rows(values: Any, shape: tuple[int, ...], name: str, degrees: Optional[bool] = False) -> Array:
    """Numbers of the shape, or an array of these along a leading axis; in any unit if `degrees` is None."""
    array = doubles(values, name, degrees)
    if array.shape[-len(shape):] != shape or array.ndim > len(shape) + 1:
        wanted = " x ".join(str(n) for n in shape)
        raise refusal(f"{name} has shape {array.shape} (expected {wanted} numbers, or n times these)")
    return array


def _quaternions(q: Any, name: str = "q") -> Array:
    """Quaternions, scalar first, of such an array or of a Rotation of SciPy."""
    refuse_order(q, name)
    return _rows(np.roll(q.as_quat(), 1, axis=-1) if hasattr(q, "as_quat") else q, (4,), name)


def _converted(name: str, shape: tuple[int, ...], *arguments: tuple[Any, int],
               fault: str = "a number is not finite, or out of its range") -> Array:
    """Results of a function of the library, which converts one attitude, for each row; arguments with their number of axes."""
    given = [(np.require(value, np.float64, ("C", "W")), axes) for value, axes in arguments]
    counts = {len(array) for array, axes in given if array.ndim > axes}
    if len(counts) > 1:
        raise refusal(f"the arguments have {' and '.join(str(n) for n in sorted(counts))} rows (expected as many in each)")
    result = np.empty((*counts, *shape))
    n = len(result) if counts else 1
    columns = [_each_row(array, n, array.ndim > axes) if axes else np.broadcast_to(array, n).tolist() for array, axes in given]
    function = getattr(library, name)
    for row in zip(*columns, _each_row(result, n, True)):
        status = function(*row)
        if status:
            check(status, f"{name[len('nutate_'):]}: {fault}")
    return result


def _each_row(array: Array, n: int, advances: bool) -> Iterator[Any]:
    """Returns the addresses for C of n rows of an array, or n times that of the whole: creating a pointer costs more than a conversion."""
    memory: Any = array
    size = memory.nbytes // n if advances and n else 0
    return (ctypes.c_double.from_buffer(memory, i * size) for i in range(n))


def _angles(values: npt.ArrayLike, degrees: bool, name: str = "angle", shape: tuple[int, ...] = ()) -> Array:
    """Angles in radians, of any shape or of this one as `_rows` has it."""
    array = _rows(values, shape, name, degrees) if shape else doubles(values, name, degrees)
    return np.radians(array) if degrees else array


def _given(values: Array, degrees: bool) -> Array:
    """Angles in the requested unit."""
    return np.degrees(values) if degrees else values


def matrix_from_quat(q: Any) -> Array:
    """Converts quaternions to rotation matrices.

    Parameters
    ----------
    q : array, shape (4,) or (n, 4), or Rotation
        Attitude.

    Returns
    -------
    array, shape (3, 3) or (n, 3, 3)
        Matrix that converts body components to space components.

    Raises
    ------
    NutateValueError
        If a number is not finite, or all are zero.

    Examples
    --------
    >>> import nutate
    >>> nutate.matrix_from_quat([0, 0, 0, 1]).diagonal().tolist()
    [-1.0, -1.0, 1.0]
    """
    return _converted("nutate_matrix_from_quat", (3, 3), (_quaternions(q), 1))


def quat_from_matrix(matrix: npt.ArrayLike) -> Array:
    """Converts rotation matrices to unit quaternions with q[0] >= 0.

    Parameters
    ----------
    matrix : array, shape (3, 3) or (n, 3, 3)
        Matrix that converts body components to space components, orthogonal to 1e-6.

    Returns
    -------
    array, shape (4,) or (n, 4)
        Attitude.

    Raises
    ------
    NutateValueError
        If a matrix is not a rotation.

    Examples
    --------
    >>> nutate.quat_from_matrix(np.diag([1, -1, -1])).tolist()
    [0.0, 1.0, 0.0, 0.0]
    """
    return _converted("nutate_quat_from_matrix", (4,), (_rows(matrix, (3, 3), "matrix"), 2),
                      fault="a matrix is no rotation (expected orthonormal rows to 1e-6, and a determinant of 1)")


def euler_from_quat(q: Any, *, degrees: bool = False) -> Array:
    """Converts quaternions to Euler angles z-x-z: precession, nutation and spin.

    Parameters
    ----------
    q : array, shape (4,) or (n, 4), or Rotation
        Attitude.
    degrees : bool
        True for degrees.

    Returns
    -------
    array, shape (3,) or (n, 3)
        Precession and spin in (-pi, pi], nutation in [0, pi].

    Raises
    ------
    NutateValueError
        If a number is not finite, or all are zero.

    Examples
    --------
    >>> nutate.euler_from_quat([[1, 0, 0, 0], [0.8, 0.6, 0, 0]], degrees=True).round(2).tolist()
    [[0.0, 0.0, 0.0], [0.0, 73.74, 0.0]]
    """
    return _given(_converted("nutate_euler_from_quat", (3,), (_quaternions(q), 1)), degrees)


def follow_euler(q: Any, angles: Optional[npt.ArrayLike] = None, *, degrees: bool = False) -> Array:
    """Converts quaternions to Euler angles z-x-z, with precession and spin continued beyond half a revolution.

    Parameters
    ----------
    q : array, shape (4,) or (n, 4), or Rotation
        Attitudes one after the other.
    angles : array, shape (3,)
        Earlier angles; default: those of the first attitude. The body must have rotated by less than pi since, and between
        attitudes.
    degrees : bool
        True for degrees.

    Returns
    -------
    array, shape (3,) or (n, 3)
        Precession, nutation and spin.

    Raises
    ------
    NutateValueError
        If a number is not finite.

    Examples
    --------
    >>> turns = nutate.quat_from_euler([[0, 90, angle] for angle in (90, 180, 270, 360)], degrees=True)
    >>> nutate.follow_euler(turns, (0, 0, 0), degrees=True)[:, 2].round(6).tolist()
    [90.0, 180.0, 270.0, 360.0]
    >>> nutate.follow_euler(turns, degrees=True)[:, 2].round(6).tolist()
    [90.0, 180.0, 270.0, 360.0]
    """
    attitudes = _quaternions(q)
    if angles is None:
        followed = np.atleast_2d(euler_from_quat(np.atleast_2d(attitudes)[:1]))[0].copy()
    else:
        followed = _angles(vector(angles, 3, "angles", degrees), degrees).copy()
    found = []
    for attitude in np.atleast_2d(attitudes):
        check(library.nutate_follow_euler(pointer(np.ascontiguousarray(attitude)), pointer(followed)),
              "follow_euler: a number is not finite")
        found.append(followed.copy())
    return _given(np.array(found) if attitudes.ndim > 1 else found[0], degrees)


def quat_from_euler(angles: npt.ArrayLike, *, degrees: bool = False) -> Array:
    """Converts Euler angles z-x-z to unit quaternions.

    Parameters
    ----------
    angles : array, shape (3,) or (n, 3)
        Precession, nutation and spin.
    degrees : bool
        True for degrees.

    Returns
    -------
    array, shape (4,) or (n, 4)
        Attitude.

    Raises
    ------
    NutateValueError
        If an angle is not finite.

    Examples
    --------
    >>> nutate.quat_from_euler((0, 180, 0), degrees=True).round(12).tolist()
    [0.0, 1.0, 0.0, 0.0]
    """
    return _converted("nutate_quat_from_euler", (4,), (_angles(angles, degrees, "angles", (3,)), 1))


def omega_from_euler_rates(angles: npt.ArrayLike, rates: npt.ArrayLike, *, degrees: bool = False) -> Array:
    """Converts rates of Euler angles z-x-z to angular velocities.

    Parameters
    ----------
    angles, rates : array, shape (3,) or (n, 3)
        Precession, nutation and spin, rad, and their rates, rad/s.
    degrees : bool
        True for angles and rates in degrees and degrees per second, the result included.

    Returns
    -------
    array, shape (3,) or (n, 3)
        Angular velocity, body axes, rad/s.

    Raises
    ------
    NutateValueError
        If a number is not finite.

    Examples
    --------
    >>> nutate.omega_from_euler_rates((0, 90, 0), (10, 0, 5), degrees=True).round(9).tolist()
    [0.0, 10.0, 5.0]
    """
    return _given(_converted("nutate_omega_from_euler_rates", (3,), (_angles(angles, degrees, "angles", (3,)), 1),
                             (_angles(rates, degrees, "rates", (3,)), 1)), degrees)


def quat_from_axis_angle(axis: npt.ArrayLike, angle: npt.ArrayLike, *, degrees: bool = False) -> Array:
    """Converts axes and angles to unit quaternions.

    Parameters
    ----------
    axis : array, shape (3,) or (n, 3)
        Axis of any length but zero.
    angle : float, or array, shape (n,)
        Angle of the rotation about it.
    degrees : bool
        True for an angle in degrees.

    Returns
    -------
    array, shape (4,) or (n, 4)
        Attitude.

    Raises
    ------
    NutateValueError
        If an axis is zero, or a number is not finite.

    Examples
    --------
    >>> nutate.quat_from_axis_angle((0, 0, 2), [0, 180], degrees=True).round(12).tolist()
    [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
    """
    return _converted("nutate_quat_from_axis_angle", (4,), (_rows(axis, (3,), "axis", None), 1), (_angles(angle, degrees), 0))


def axis_angle_from_quat(q: Any, *, degrees: bool = False) -> tuple[Array, Any]:
    """Converts quaternions to axes and angles.

    Parameters
    ----------
    q : array, shape (4,) or (n, 4), or Rotation
        Attitude.
    degrees : bool
        True for an angle in degrees.

    Returns
    -------
    axis : array, shape (3,) or (n, 3)
        Unit vector along the axis.
    angle : float, or array, shape (n,)
        Angle in [0, pi].

    Raises
    ------
    NutateValueError
        If a number is not finite, or all are zero.

    Examples
    --------
    >>> axis, angle = nutate.axis_angle_from_quat([0, 1, 0, 0], degrees=True)
    >>> axis.tolist(), angle
    ([1.0, 0.0, 0.0], 180.0)
    """
    attitudes = _quaternions(q)
    axes, angles = [], []
    for attitude in np.atleast_2d(attitudes):
        axis, angle = np.empty(3), np.empty(1)
        check(library.nutate_axis_angle_from_quat(pointer(np.ascontiguousarray(attitude)), pointer(axis), pointer(angle)),
              "axis_angle_from_quat: a number is not finite")
        axes.append(axis)
        angles.append(float(_given(angle, degrees)[0]))
    if attitudes.ndim == 1:
        return axes[0], angles[0]
    return np.array(axes), np.array(angles)


def quat_from_rotation_vector(v: npt.ArrayLike, *, degrees: bool = False) -> Array:
    """Converts rotation vectors, axis times angle, to unit quaternions.

    Parameters
    ----------
    v : array, shape (3,) or (n, 3)
        Rotation vector.
    degrees : bool
        True for degrees.

    Returns
    -------
    array, shape (4,) or (n, 4)
        Attitude.

    Raises
    ------
    NutateValueError
        If a number is not finite.

    Examples
    --------
    >>> nutate.quat_from_rotation_vector((0, 0, 180), degrees=True).round(12).tolist()
    [0.0, 0.0, 0.0, 1.0]
    """
    return _converted("nutate_quat_from_rotation_vector", (4,), (_angles(v, degrees, "v", (3,)), 1))


def rotation_vector_from_quat(q: Any, *, degrees: bool = False) -> Array:
    """Converts quaternions to rotation vectors, axis times angle.

    Parameters
    ----------
    q : array, shape (4,) or (n, 4), or Rotation
        Attitude.
    degrees : bool
        True for degrees.

    Returns
    -------
    array, shape (3,) or (n, 3)
        Rotation vector, at most pi long.

    Raises
    ------
    NutateValueError
        If a number is not finite, or all are zero.

    Examples
    --------
    >>> nutate.rotation_vector_from_quat([0, 0, 1, 0], degrees=True).round(9).tolist()
    [0.0, 180.0, 0.0]
    """
    return _given(_converted("nutate_rotation_vector_from_quat", (3,), (_quaternions(q), 1)), degrees)


def quat_product(a: Any, b: Any) -> Array:
    """Multiplies quaternions: first the rotation b, then a.

    Parameters
    ----------
    a, b : array, shape (4,) or (n, 4), or Rotation
        Quaternions. One of them may be single and the other an array.

    Returns
    -------
    array, shape (4,) or (n, 4)
        Product a b.

    Raises
    ------
    NutateValueError
        If a number is not finite, or the numbers of rows differ.

    Examples
    --------
    >>> nutate.quat_product([0, 1, 0, 0], [0, 0, 1, 0]).tolist()
    [0.0, 0.0, 0.0, 1.0]
    """
    return _converted("nutate_quat_product", (4,), (_quaternions(a, "a"), 1), (_quaternions(b, "b"), 1))


def quat_normalized(q: Any) -> Array:
    """Gives quaternions unit length.

    Parameters
    ----------
    q : array, shape (4,) or (n, 4), or Rotation
        Quaternion of any length but zero.

    Returns
    -------
    array, shape (4,) or (n, 4)
        Quaternion of length 1.

    Raises
    ------
    NutateValueError
        If a number is not finite, or all are zero.

    Examples
    --------
    >>> nutate.quat_normalized([3, 4, 0, 0]).tolist()
    [0.6, 0.8, 0.0, 0.0]
    """
    return _converted("nutate_quat_normalized", (4,), (_quaternions(q), 1))


def rotate_to_space(q: Any, v: npt.ArrayLike) -> Array:
    """Converts body components of vectors to space components.

    Parameters
    ----------
    q : array, shape (4,) or (n, 4), or Rotation
        Attitude.
    v : array, shape (3,) or (n, 3)
        Body components.

    Returns
    -------
    array, shape (3,) or (n, 3)
        Space components.

    Raises
    ------
    NutateValueError
        If a number is not finite, or the numbers of rows differ.

    Examples
    --------
    >>> nutate.rotate_to_space([0, 1, 0, 0], (1, 2, 3)).tolist()
    [1.0, -2.0, -3.0]
    """
    return _converted("nutate_rotate_to_space", (3,), (_quaternions(q), 1), (_rows(v, (3,), "v", None), 1))


def rotate_to_body(q: Any, v: npt.ArrayLike) -> Array:
    """Converts space components of vectors to body components.

    Parameters
    ----------
    q : array, shape (4,) or (n, 4), or Rotation
        Attitude.
    v : array, shape (3,) or (n, 3)
        Space components.

    Returns
    -------
    array, shape (3,) or (n, 3)
        Body components.

    Raises
    ------
    NutateValueError
        If a number is not finite, or the numbers of rows differ.

    Examples
    --------
    >>> nutate.rotate_to_body([[1, 0, 0, 0], [0, 0, 0, 1]], (1, 2, 3)).tolist()
    [[1.0, 2.0, 3.0], [-1.0, -2.0, 3.0]]
    """
    return _converted("nutate_rotate_to_body", (3,), (_quaternions(q), 1), (_rows(v, (3,), "v", None), 1))


def attitude_distance(a: Any, b: Any, *, degrees: bool = False) -> Any:
    """Computes the angle of the rotation between two attitudes.

    Parameters
    ----------
    a, b : array, shape (4,) or (n, 4), or Rotation
        Attitudes. One of them may be single and the other an array.
    degrees : bool
        True for degrees.

    Returns
    -------
    float, or array, shape (n,)
        Angle in [0, pi].

    Raises
    ------
    NutateValueError
        If a number is not finite, or the numbers of rows differ.

    Examples
    --------
    >>> nutate.attitude_distance([1, 0, 0, 0], [0, 0, 1, 0], degrees=True)
    180.0
    """
    angle = _given(_converted("nutate_attitude_distance", (), (_quaternions(a, "a"), 1), (_quaternions(b, "b"), 1)), degrees)
    return float(angle) if np.ndim(angle) == 0 else angle


def to_rotation(q: Any) -> Any:
    """Converts quaternions to a Rotation of SciPy.

    Parameters
    ----------
    q : array, shape (4,) or (n, 4), or Rotation
        Attitude, scalar first.

    Returns
    -------
    scipy.spatial.transform.Rotation
        Rotation that converts body components to space components.

    Raises
    ------
    ImportError
        If SciPy is not installed.

    Examples
    --------
    >>> nutate.to_rotation([0, 1, 0, 0]).apply([1, 2, 3]).tolist()
    [1.0, -2.0, -3.0]
    """
    rotations = importlib.import_module("scipy.spatial.transform")
    return rotations.Rotation.from_quat(np.roll(_quaternions(q), -1, axis=-1))


def from_rotation(rotation: Any) -> Array:
    """Converts a Rotation of SciPy to unit quaternions with their scalar first.

    Parameters
    ----------
    rotation : scipy.spatial.transform.Rotation
        One rotation or n of them.

    Returns
    -------
    array, shape (4,) or (n, 4)
        Attitude.

    Raises
    ------
    NutateValueError
        If it is no Rotation.

    Examples
    --------
    >>> nutate.from_rotation(nutate.to_rotation([0, 0, 1, 0])).tolist()
    [0.0, 0.0, 1.0, 0.0]
    """
    if not hasattr(rotation, "as_quat"):
        raise refusal(f"rotation is {rotation!r} (expected a Rotation of SciPy)")
    return _quaternions(rotation)


def exact_free_body(system: System, q0: Any, omega0: npt.ArrayLike, t: npt.ArrayLike) -> tuple[Array, Array]:
    """Computes the exact motion of a torque-free rigid body.

    Parameters
    ----------
    system : System
        Body. Its effects are not considered.
    q0 : array, shape (4,), or Rotation
        Attitude at t = 0.
    omega0 : array, shape (3,)
        Angular velocity at t = 0, body axes, rad/s.
    t : array, shape (n,)
        Times, s, of either sign.

    Returns
    -------
    q : array, shape (n, 4)
        Attitudes.
    omega : array, shape (n, 3)
        Angular velocities, body axes, rad/s.

    Raises
    ------
    NutateValueError
        If a number is not finite, or an array has another shape.

    Examples
    --------
    >>> box = nutate.System(shape="box", size=(4, 1, 2), mass=12)
    >>> q, omega = nutate.exact_free_body(box, (1, 0, 0, 0), (0, 0, 1), [0, np.pi])
    >>> q[1].round(12).tolist()
    [0.0, 0.0, 0.0, 1.0]
    """
    times = np.atleast_1d(doubles(t, "t"))
    if times.ndim != 1:
        raise refusal(f"t has shape {times.shape} (expected n times)")
    q, omega = np.empty((times.size, 4)), np.empty((times.size, 3))
    system._call("nutate_exact_free_body", pointer(quaternion(q0, "q0")), pointer(vector(omega0, 3, "omega0")), times.size,
                 pointer(times), pointer(q), pointer(omega))
    return q, omega
