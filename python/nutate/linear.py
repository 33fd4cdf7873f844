"""Motions linearised about an equilibrium, or over a period, and all equilibria of a body."""

from __future__ import annotations

import ctypes
import json
from dataclasses import dataclass
from typing import Any, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from ._library import Array, answer, doubles, library, number, refusal
from .scenes import Scene
from .sweeps import SceneOrPath, with_table

# As include/nutate_scene.h has it.
TEXT_SIZE = 32768


@dataclass(frozen=True)
class Linearization:
    """Linear system dx/dt = A x + B u about an equilibrium, or x(T) = A x(0) + B u over a period with constant inputs.

    The state x has n components: a rotation vector from the motion and the change of the angular velocity, both in body axes, and
    the changes of the wheel speeds. The m inputs u are torques about the body axes and torques of motors.

    Attributes
    ----------
    A : array, shape (n, n)
        Matrix of the states; over a period that closes, the monodromy matrix.
    B : array, shape (n, m)
        Matrix of the inputs.
    eigenvalues : array of complex, shape (n,)
        Eigenvalues of A: 1/s about an equilibrium; over a period that closes, the Floquet multipliers.
    states : list of str
        Names of the components of x.
    inputs : list of str
        Names of the components of u.
    state_units : list of str
        Units of the components of x.
    input_units : list of str
        Units of the components of u.
    period : float
        Period, s; 0 about an equilibrium.
    closes : bool
        True if the motion returns to its start after the period.
    residual : float
        Largest angular acceleration at the equilibrium, rad/s², or largest change of a velocity over the period, rad/s.
    q : array, shape (4,)
        Attitude at the start, body to space.
    omega : array, shape (3,)
        Angular velocity at the start, body axes, rad/s.
    wheel_speeds : array
        Speeds of the wheels at the start, rad/s.
    rates : str
        "absolute", or "relative" if the angular velocities are relative to axes that rotate with the equilibrium.

    Examples
    --------
    >>> top = nutate.Scene(text="&body inertia = 1, 1, 2 / &initial angular_velocity = 0, 0, 3 /"
    ...                         "&integrator accuracy = 1e-8, end_time = 1 /")
    >>> nutate.linearize(top).eigenvalues.imag.round(6).tolist()[:3]
    [3.0, -3.0, 3.0]
    """

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
    rates: str = "absolute"

    def controller_gains(self, feedback: npt.ArrayLike) -> ControllerGains:
        """Computes the gains with which `&controller law = 'quaternion'` gives the feedback u = -K x about an equilibrium.

        The torque of the law is -½K'θ - D dθ/dt with the rate dθ/dt = A11 θ + δΩ relative to the target; so D = K_Ω and
        K' = 2 (K_θ - K_Ω A11). The target of the controller must be the attitude of the equilibrium, in axes in which the body
        rests: `target_from = 'lvlh'` on an orbit.

        Parameters
        ----------
        feedback : array, shape (3, 6) or (m, n)
            Matrix K in SI units: rows are torques about the body axes, columns rotation vector and angular velocity; or all inputs and states,
            with zeros for motors and wheel speeds.

        Returns
        -------
        ControllerGains
            K', N m, and D, N m s.

        Raises
        ------
        NutateValueError
            If the shape is another one, or the motion is one over a period.
        """
        gain = doubles(feedback, "feedback")
        if self.period > 0:
            raise refusal("a controller has no gains for a motion over a period (expected an equilibrium)")
        if gain.shape not in ((3, 6), self.B.shape[::-1]):
            raise refusal(f"the feedback has the shape {gain.shape} (expected (3, 6) or {self.B.shape[::-1]})")
        if gain[3:].any() or gain[:, 6:].any():
            raise refusal("the feedback uses motors or speeds of wheels (expected zeros there)")
        rate = gain[:3, 3:6].copy()
        return ControllerGains(2 * (gain[:3, :3] - rate @ self.A[:3, :3]), rate)


class ControllerGains(NamedTuple):
    """Gain matrices of `&controller law = 'quaternion'`; keys of `System.add("controller", ...)` have the same names.

    Examples
    --------
    >>> rest = nutate.Scene("scenes/earth_pointing.nml", "initial.roll_pitch_yaw=0,0,0", "initial.angular_velocity=0,0,0")
    >>> gains = nutate.linearize(rest).controller_gains(0.01 * np.eye(3, 6))
    >>> gains.attitude_gain_matrix[0, 0].tolist()
    0.02
    """

    attitude_gain_matrix: Array
    """K, N m; shape (3, 3)."""
    rate_gain_matrix: Array
    """D, N m s; shape (3, 3)."""


def linearize(scene: SceneOrPath, *overrides: str, period: Union[float, str, None] = None, rates: str = "absolute") -> Linearization:
    """Linearises a motion about an equilibrium or over a period, as `nutate linearize`.

    Parameters
    ----------
    scene : str, path or Scene
        Scene, or the path of its file.
    *overrides : str
        Overrides "GROUP.KEY=VALUE" of a scene file.
    period : float or "orbit"
        Period, s, or that of the orbit; default: an equilibrium, at which the scene has to start.
    rates : str
        "absolute", or "relative" about an equilibrium: the angular velocities among the states are then relative to axes that
        rotate with it, such as the LVLH frame.

    Returns
    -------
    Linearization
        Matrices A and B, eigenvalues, names and units.

    Raises
    ------
    NutateValueError
        If an argument or the scene is invalid.

    Examples
    --------
    >>> found = nutate.linearize("scenes/earth_pointing.nml", "initial.roll_pitch_yaw=0,0,0", "initial.angular_velocity=0,0,0")
    >>> found.A.shape, found.period
    ((6, 6), 0.0)
    """
    if rates not in ("absolute", "relative") or (rates == "relative" and period is not None):
        raise refusal(f"rates is {rates!r} (expected 'absolute', or 'relative' about an equilibrium)")
    if isinstance(period, str) and period != "orbit":
        raise refusal('period is no time (expected seconds, "orbit" or None)')
    if not isinstance(period, str) and period is not None:
        period = number(period, "period")
        if not period > 0:
            raise refusal("period is out of its range (expected one above 0 s)")
    found = found_by(with_table(scene, overrides, None), library.nutate_scene_linearize,
                     -1.0 if isinstance(period, str) else period or 0.0)
    matrix = np.array(found["A"], float)
    if rates == "relative":
        # In place of the absolute rate the derivative of theta.
        turn = matrix[:3, :3].copy()
        matrix[3:6] += turn @ matrix[:3]
        matrix[:, :3] -= matrix[:, 3:6] @ turn
    return Linearization(
        matrix, np.array(found["B"], float), np.array([complex(*pair) for pair in found["eigenvalues"]]),
        found["states"], found["inputs"], found["state_units"], found["input_units"], float(found["period"]), found["closes"],
        float(found["residual"]), np.array(found["attitude"], float), np.array(found["angular_velocity"], float),
        np.array(found["wheel_speeds"], float), rates)


@dataclass(frozen=True)
class Equilibrium:
    """Attitude in which a body rests in the space axes, or in the LVLH frame.

    Attributes
    ----------
    q : array, shape (4,)
        Attitude, body to space, or body to LVLH frame.
    energy : float
        Effective potential, J.
    index : int
        Number of directions in which the effective potential falls: 0 at a minimum.
    growth : float
        Largest real part of an eigenvalue, 1/s: 0 if the equilibrium is stable to first order.

    Examples
    --------
    >>> lowest = nutate.equilibria("scenes/earth_pointing.nml")[0]
    >>> lowest.index, lowest.growth
    (0, 0.0)
    """

    q: Array
    energy: float
    index: int
    growth: float


def equilibria(scene: SceneOrPath, *overrides: str) -> list[Equilibrium]:
    """Finds all equilibria of a body with rotors and free wheels under potentials, as `nutate linearize --equilibria`.

    On a circular orbit attitudes are relative to the LVLH frame: `attitude_from = 'lvlh'` starts there. Of the initial state of
    the scene only the speeds of the wheels are used.

    Parameters
    ----------
    scene : str, path or Scene
        Scene, or the path of its file.
    *overrides : str
        Overrides "GROUP.KEY=VALUE" of a scene file.

    Returns
    -------
    list of Equilibrium
        Equilibria by their energy.

    Raises
    ------
    NutateValueError
        If the scene is invalid.

    Examples
    --------
    >>> len(nutate.equilibria("scenes/earth_pointing.nml"))
    24
    """
    found = found_by(with_table(scene, overrides, None), library.nutate_scene_equilibria)
    return [Equilibrium(np.array(one["attitude"], float), float(one["energy"]), one["index"], float(one["growth"]))
            for one in found["equilibria"]]


def found_by(scene: Scene, function: Any, *arguments: float) -> Any:
    """Returns the results that a function of the library writes as JSON for a scene."""
    text = ctypes.create_string_buffer(TEXT_SIZE)
    status, message = answer(scene._read_by, function, scene._handle, *arguments, text, TEXT_SIZE)
    scene._conclude(status, message=message)
    return json.loads(text.value)
