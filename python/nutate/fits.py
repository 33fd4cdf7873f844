"""Scenes fitted to measurements, and their residuals as functions for other optimisers and samplers."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ._library import Array, KnownAttributes, answer, library, pointer, text_of, vector
from .sweeps import SceneOrPath, with_table


@dataclass(frozen=True)
class FitResult:
    """A fitted scene, with the names of SciPy.

    Attributes
    ----------
    x : array, shape (n,)
        Parameters.
    fun : array, shape (k,)
        Residuals.
    jac : array, shape (k, n)
        Derivatives of the residuals with respect to the parameters.
    cost : float
        Half the sum of the squares of `fun`, with the losses of the scene.
    success : bool
        False also if noise of the given `sigma` does not explain the residuals.
    message : str
        Description of the result.
    names : list of str
        Names of the parameters.
    cov : array, shape (n, n)
        Covariance of `x`; a row and column of zeros is a parameter that the data do not determine, or one at a bound.

    Examples
    --------
    >>> result = nutate.fit("scenes/thrown_phone.nml")
    >>> result.jac.shape == (len(result.fun), len(result.x))
    True
    """

    x: Array
    fun: Array
    jac: Array
    cost: float
    success: bool
    message: str
    names: list[str]
    cov: Array


class FitProblem(KnownAttributes):
    """Residuals of a scene as functions of its n parameters, for other optimisers and samplers.

    The parameters `x` are those of &free, then the biases. An attitude is a rotation vector from the attitude of the scene, body
    axes, in the unit of its angles.

    Parameters
    ----------
    scene : str, path or Scene
        Scene with &free and &measurement, or the path of its file.
    *overrides : str
        Overrides "GROUP.KEY=VALUE" of a scene file.

    Raises
    ------
    NutateValueError
        If the scene has nothing to fit.

    Examples
    --------
    >>> problem = nutate.FitProblem("scenes/thrown_phone.nml")
    >>> problem.names[0], problem.jacobian(problem.x0).shape == (len(problem.residuals(problem.x0)), len(problem.names))
    ('initial.angular_velocity.1', True)
    """

    names: list[str]
    """Names of the parameters."""
    x0: Array
    """Values of the parameters in the scene; shape (n,)."""
    bounds: tuple[Array, Array]
    """Lower and upper bounds, infinite if the scene has none; two arrays of shape (n,), as SciPy expects them."""

    def __init__(self, scene: SceneOrPath, *overrides: str) -> None:
        self._scene = with_table(scene, overrides, None)
        parameters, residuals = ctypes.c_size_t(), ctypes.c_size_t()
        self._scene._call("nutate_fit_size", ctypes.byref(parameters), ctypes.byref(residuals))
        n, self._size = parameters.value, residuals.value
        self.names = [text_of(library.nutate_fit_name, self._scene._handle, k) for k in range(n)]
        self.x0 = np.empty(n)
        low, high = np.empty(n), np.empty(n)
        self._scene._call("nutate_fit_start", pointer(self.x0), pointer(low), pointer(high))
        most = np.finfo(float).max
        self.bounds = (np.where(low <= -most, -np.inf, low), np.where(high >= most, np.inf, high))

    def residuals(self, x: npt.ArrayLike) -> Array:
        """Computes the residuals (model - measured)/sigma, without robust losses.

        Parameters
        ----------
        x : array, shape (n,)
            Parameters.

        Returns
        -------
        array, shape (k,)
            Residuals of the measurements, then those of parameters with a `sigma` in &free.

        Raises
        ------
        NutateError
            If no motion has these parameters.
        """
        residuals = np.empty(self._size)
        self._scene._call("nutate_fit_evaluate", pointer(vector(x, self.x0.size, "x")), pointer(residuals), None)
        return residuals

    def jacobian(self, x: npt.ArrayLike) -> Array:
        """Computes the derivatives of `residuals`, from the sensitivities of the motion.

        Parameters
        ----------
        x : array, shape (n,)
            Parameters.

        Returns
        -------
        array, shape (k, n)
            One row for each residual.

        Raises
        ------
        NutateError
            If no motion has these parameters.
        """
        jacobian = np.empty((self._size, self.x0.size))
        self._scene._call("nutate_fit_evaluate", pointer(vector(x, self.x0.size, "x")), None, pointer(jacobian))
        return jacobian

    def cost(self, x: npt.ArrayLike) -> float:
        """Computes what `fit` minimises: half the sum of the squares of `residuals`, with robust losses.

        Parameters
        ----------
        x : array, shape (n,)
            Parameters.

        Returns
        -------
        float
            Cost.

        Raises
        ------
        NutateError
            If no motion has these parameters.
        """
        cost = ctypes.c_double()
        self._scene._call("nutate_fit_cost", pointer(vector(x, self.x0.size, "x")), ctypes.byref(cost))
        return cost.value

    def log_likelihood(self, x: npt.ArrayLike) -> float:
        """Computes minus half the sum of the squares of `residuals`, for samplers such as emcee.

        Parameters
        ----------
        x : array, shape (n,)
            Parameters.

        Returns
        -------
        float
            Logarithm of the likelihood up to a constant; -inf outside of the bounds.
        """
        x = vector(x, self.x0.size, "x")
        if np.any(x < self.bounds[0]) or np.any(x > self.bounds[1]):
            return -np.inf
        return -0.5 * float(np.sum(self.residuals(x) ** 2))


def fit(scene: SceneOrPath, *overrides: str) -> FitResult:
    """Fits a scene to its measurements, as `nutate fit`.

    Parameters
    ----------
    scene : str, path or Scene
        Scene with &free and &measurement, or the path of its file.
    *overrides : str
        Overrides "GROUP.KEY=VALUE" of a scene file.

    Returns
    -------
    FitResult
        Parameters, residuals and covariance.

    Raises
    ------
    NutateValueError
        If the scene has nothing to fit.

    Examples
    --------
    >>> result = nutate.fit("scenes/thrown_phone.nml")
    >>> result.success, len(result.names) == len(result.x)
    (True, True)
    """
    problem = FitProblem(scene, *overrides)
    made, n = problem._scene, problem.x0.size
    x, cov, converged = np.empty(n), np.empty((n, n)), ctypes.c_int()
    status, text = answer(made._read_by, library.nutate_fit_solve, made._handle, pointer(x), pointer(cov), ctypes.byref(converged))
    made._conclude(status, message=text)
    fun = problem.residuals(x)
    return FitResult(x, fun, problem.jacobian(x), problem.cost(x), bool(converged.value), text or "converged",
                     problem.names, cov)
