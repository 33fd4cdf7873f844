"""Derivatives of a motion with respect to parameters of its scene."""

from __future__ import annotations

import os
from typing import Any, Callable, Sequence, Union

import numpy as np
import numpy.typing as npt

from ._library import Array, KnownAttributes, doubles, refusal
from ._owners import make_again
from .scenes import Scene
from .systems import System, group, tensor_entries

# What of a System a scene cannot say in its text.
NOT_IN_A_TEXT = {"_add_table": "a table", "_add_wheel": "the motor table of a wheel"}


class Sensitivity(KnownAttributes):
    """Derivatives of a motion with respect to k parameters, at any time: `sensitivity` of a Solution.

    A call inside a step repeats this step, as `Motion` does. A solution without dense output has only the times of its rows.

    Parameters
    ----------
    t : float, or array, shape (n,)
        Times, s, in any order.

    Returns
    -------
    rotation : array, shape (3, k) or (n, 3, k)
        Derivatives of the attitude, as a rotation vector in body axes, rad per unit of the parameter.
    omega : array, shape (3, k) or (n, 3, k)
        Derivatives of the angular velocity, body axes, rad/s per unit of the parameter.

    Raises
    ------
    NutateValueError
        If a time is outside the motion, or is not one of the rows of a solution without dense output.

    Examples
    --------
    >>> top = nutate.System(moments=(1, 1, 2))
    >>> solution = nutate.solve(top, omega0=(0, 0, 3), t_span=(0, 2), free="initial.angular_velocity")
    >>> rotation, omega = solution.sensitivity(2.0)
    >>> solution.sensitivity.names[2], rotation.shape, round(float(rotation[2, 2]), 9)
    ('initial.angular_velocity.3', (3, 3), 2.0)
    """

    names: tuple[str, ...]
    """Names of the parameters."""

    def __init__(self, columns: dict[str, Array], rows: Callable[[Array], dict[str, Array]]) -> None:
        """`columns` are those of the run, and `rows` returns them at times."""
        self.names = tuple(name.split("/d_", 1)[1] for name in columns if name.startswith("d_rotation1/"))
        self._rows = rows

    def __call__(self, t: npt.ArrayLike) -> tuple[Array, Array]:
        columns = self._rows(np.atleast_1d(doubles(t, "t")))
        rotation, omega = (np.stack([np.stack([columns[f"d_{part}{i}/d_{name}"] for name in self.names], axis=-1)
                                     for i in (1, 2, 3)], axis=-2) for part in ("rotation", "omega"))
        return (rotation[0], omega[0]) if np.ndim(t) == 0 else (rotation, omega)


def rows_at(columns: dict[str, Array], wanted: Array) -> dict[str, Array]:
    """Columns at times of their rows, s."""
    places = [np.flatnonzero(columns["t"] == t) for t in wanted]
    if not all(len(place) for place in places):
        raise refusal("a time is none of the rows (expected t_eval with it, or dense_output=True)")
    chosen = np.array([place[0] for place in places], dtype=int)
    return {name: values[chosen] for name, values in columns.items()}


def scene_with_free(system: Union[System, Scene], keys: Union[str, Sequence[str]], q: Array, omega: Array) -> Scene:
    """Returns a scene of a body and its effects in which `keys` are free. A System starts from attitude q and angular velocity omega (body
    axes, rad/s)."""
    quoted = "free.key=" + ",".join(f"'{key}'" for key in ([keys] if isinstance(keys, str) else keys))
    if isinstance(system, Scene):
        (arguments, given), additions = system._given, system._additions
        return make_scene((*(arguments or (None,)), quoted), given, additions, system._files)
    given, additions = system._given[1], []
    text = body_text(given)
    for name, arguments in system._additions:
        if name in ("add_user_torque", "add_potential"):
            additions.append((name, arguments))
        else:
            text += group_text(name, arguments)
    if given["scene"] is not None:
        (arguments, of_scene), before = given["scene"]._given, given["scene"]._additions
        return make_scene((*(arguments or (None,)), quoted), {**of_scene, "text": text_of(of_scene["text"]) + "\n" + text},
                          [*before, *additions], {**given["scene"]._files, **system._files})
    text += group("initial", quaternion=q, angular_velocity=omega) + group("integrator", local_tolerance=1e-6, end_time=1.0)
    return make_scene((None, quoted), {"text": text, "name": "system"}, additions, system._files)


def make_scene(arguments: tuple[Any, ...], given: dict[str, Any], additions: Sequence[Any], files: dict[str, str]) -> Scene:
    """Returns a scene made from its text."""
    made: Scene = make_again(Scene, (arguments, given), tuple(additions), files)
    return made


def text_of(text: Union[str, bytes]) -> str:
    return text if isinstance(text, str) else os.fsdecode(text)


def body_text(given: dict[str, Any]) -> str:
    """Returns the group &body, or the groups, that correspond to the arguments of a System."""
    if given["text"] is not None:
        return text_of(given["text"]) + "\n"
    if given["scene"] is not None:
        return ""
    rest = {"mass": given["mass"] or None, "center_of_mass": given["center_of_mass"]}
    if given["shape"] is not None:
        return group("body", shape=given["shape"], size=given["size"], density=given["density"] or None, **rest)
    tensor = None if given["tensor"] is None else tensor_entries(given["tensor"])
    return group("body", inertia=given["moments"], inertia_tensor=tensor,
                 inertia_about="center_of_mass" if given["about_center"] else None, **rest)


def group_text(name: str, arguments: tuple[Any, ...]) -> str:
    """Returns the group that corresponds to a recorded call of a method of a System."""
    if name == "_add_group":
        return str(arguments[1])
    if name == "_add_earth_field":
        moment, angle, coefficients = arguments
        return group("earth_field", moment=moment, epoch_angle=angle, coefficients=coefficients)
    if name == "_add_force":
        point, force, axes, start, stop = arguments
        return group("force", body_point=point, force=force, axes=axes, start=finite(start), stop=finite(stop))
    if name == "_add_wheel" and arguments[2] is None:
        (axis, inertia, speed, friction, torque_limit, speed_limit), motor, _ = arguments
        keys = dict(zip(("torque", "frequency", "phase", "start", "stop"), map(finite, motor or ())))
        return group("wheel", axis=axis, inertia=inertia, speed=speed, friction=friction or None, torque_limit=finite(torque_limit),
                     speed_limit=finite(speed_limit), **keys)
    raise refusal(f"free names numbers of a scene, which cannot have {NOT_IN_A_TEXT.get(name, name)} in its text (expected a Scene)")


def finite(number: float) -> Any:
    """Returns a number, or None for one that a scene leaves out."""
    return number if np.isfinite(number) else None
