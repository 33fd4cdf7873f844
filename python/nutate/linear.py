"""Motions linearised about an equilibrium, or over a period."""

import ctypes
import json
from dataclasses import dataclass
from typing import Union

import numpy as np
import numpy.typing as npt

from ._library import MESSAGE_SIZE, Array, interruptible, library, refusal
from .sweeps import SceneOrPath, with_table

# As include/nutate_scene.h has it.
TEXT_SIZE = 32768


@dataclass(frozen=True)
class Linearization:
    """dx/dt = A x + B u about an equilibrium, or x(T) = A x(0) + B u over a period, with inputs that are constant in it.

    `states` and `inputs` name x and u, `state_units` and `input_units` have their units; `eigenvalues` are those of A (about an
    equilibrium in 1/s), the Floquet multipliers of a motion that `closes`. `period` is 0 about an equilibrium. `residual` is the
    largest angular acceleration, rad/s², or the largest change of a velocity in a period, rad/s. `q`, `omega` and
    `wheel_speeds` are the start."""

    A: Array
    B: Array
    eigenvalues: npt.NDArray[np.complex128]
    states: list[str]
    inputs: list[str]
    state_units: list[str]
    input_units: list[str]
    period: float
    closes: bool
    residual: float
    q: Array
    omega: Array
    wheel_speeds: Array


def linearize(scene: SceneOrPath, *overrides: str, period: Union[float, str, None] = None) -> Linearization:
    """Linearises the motion of a scene, a Scene or a path with `overrides`: about its start, which has to be an equilibrium, or
    over a `period`, s, or "orbit" for that of the orbit. As `nutate linearize`."""
    if isinstance(period, str) and period != "orbit":
        raise refusal('period is no time (expected seconds, "orbit" or None)')
    if period is not None and period != "orbit" and not float(period) > 0:
        raise refusal("period is out of its range (expected one above 0 s)")
    made = with_table(scene, overrides, None)
    text, message = ctypes.create_string_buffer(TEXT_SIZE), ctypes.create_string_buffer(MESSAGE_SIZE)
    status = interruptible(library.nutate_scene_linearize, made._handle,
                           -1.0 if period == "orbit" else float(period or 0.0), text, TEXT_SIZE, message, MESSAGE_SIZE)
    made._conclude(status, message=message.value.decode("utf-8", "replace"))
    found = json.loads(text.value)
    return Linearization(
        np.array(found["A"], float), np.array(found["B"], float), np.array([complex(*pair) for pair in found["eigenvalues"]]),
        found["states"], found["inputs"], found["state_units"], found["input_units"], float(found["period"]), found["closes"],
        float(found["residual"]), np.array(found["attitude"], float), np.array(found["angular_velocity"], float),
        np.array(found["wheel_speeds"], float))
