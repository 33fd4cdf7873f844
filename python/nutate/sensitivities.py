"""Derivatives of a motion by numbers of its scene."""

from __future__ import annotations

import copy
from typing import Sequence

import numpy as np
import numpy.typing as npt

from ._library import Array, refusal
from ._owners import make_again
from .scenes import Scene
from .steppers import Stepper

# Part of a motion that is run to find out what has derivatives.
SHORT = 1e-9


class Sensitivity:
    """Derivatives of a motion by `names`, the free numbers of a scene: sensitivity(t) returns those of the rotation vector, body
    axes, rad, and of the angular velocity, body axes, rad/s, each per unit of the number. At a time, s, both have the shape
    (3, len(names)), at n times (n, 3, len(names)). Each call runs the motion again, with the same steps."""

    names: tuple[str, ...]

    def __init__(self, scene: Scene, keys: Sequence[str], stepper: Stepper, start: float, end: float) -> None:
        """`stepper` is as it was before the run of the motion, which it can repeat."""
        (arguments, given), additions = scene._given, scene._additions
        quoted = ",".join(f"'{key}'" for key in ([keys] if isinstance(keys, str) else keys))
        self._scene = make_again(Scene, ((*(arguments or (None,)), f"free.key={quoted}"), given), tuple(additions))
        self._stepper, self._start, self._end = copy.copy(stepper), start, end
        columns = self._run(start + SHORT * (end - start), np.array([start]))
        self.names = tuple(name.split("/d_")[1] for name in columns if name.startswith("d_rotation1/"))

    def __call__(self, t: npt.ArrayLike) -> tuple[Array, Array]:
        wanted = np.atleast_1d(np.asarray(t, dtype=np.float64))
        first, last = sorted((self._start, self._end))
        if wanted.ndim != 1 or not np.all((wanted >= first) & (wanted <= last)):
            raise refusal(f"a time is outside the motion (expected {first!r} to {last!r} s)")
        times, places = np.unique(wanted, return_inverse=True)
        backward = self._end < self._start
        columns = self._run(self._end, times[::-1] if backward else times)
        rotation, omega = (np.stack([np.stack([columns[f"d_{part}{i}/d_{name}"] for name in self.names], axis=-1)
                                     for i in (1, 2, 3)], axis=-2)[::-1 if backward else 1][places] for part in ("rotation", "omega"))
        return (rotation[0], omega[0]) if np.ndim(t) == 0 else (rotation, omega)

    def _run(self, end: float, times: Array) -> dict[str, Array]:
        """The columns of a run at times in its order."""
        return copy.copy(self._stepper).sensitivities(self._scene, end, times)
