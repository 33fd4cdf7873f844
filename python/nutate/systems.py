"""Rigid bodies and the effects that act on them."""

from __future__ import annotations

from typing import Any, Callable, Optional, Union

import numpy as np
import numpy.typing as npt

from ._library import Array, bounds_of, create, digits, doubles, encoded, library, number, pointer, refusal, refuse_units, vector
from ._owners import Recipe
from .satellites import WheelMounting


def group(name: str, /, **values: Any) -> str:
    """Returns a group of a scene file with the values that are not None."""

    def text(value: Any, key: str) -> str:
        items: Any = value
        refuse_units(value, key, degrees)
        if isinstance(value, str):
            return "'" + value.replace("'", "''") + "'"
        if isinstance(value, (bool, np.bool_)):
            return ".true." if value else ".false."
        if isinstance(value, (int, np.integer)) and not isinstance(value, np.timedelta64):
            return digits(value, key)
        return ", ".join(text(item, key) for item in items) if np.ndim(items) else repr(float(doubles(items, key, degrees)))

    degrees = bool(values.get("degrees"))
    given = [f"{key} = {text(value, key)}" for key, value in values.items() if value is not None]
    return f"&{name} " + ", ".join(given) + " /\n"


def tensor_entries(tensor: npt.ArrayLike) -> Array:
    """Returns Jxx, Jyy, Jzz, Jxy, Jxz, Jyz of six numbers, or of a symmetric 3 x 3 matrix."""
    matrix = doubles(tensor, "tensor")
    if matrix.shape != (3, 3):
        return vector(matrix, 6, "tensor")
    # Products of inertia have the round-off of the moments.
    if not np.allclose(matrix, matrix.T, rtol=0, atol=1e-12 * abs(matrix).max()):
        raise refusal("tensor is not symmetric (expected a symmetric 3 x 3 matrix)")
    return np.array([matrix[0, 0], matrix[1, 1], matrix[2, 2], matrix[0, 1], matrix[0, 2], matrix[1, 2]])


class UserEffects(Recipe):
    """Methods of a System and of a Scene for torques and potentials that a program computes."""

    _kind = ""

    def add_user_torque(self, torque: Callable[..., npt.ArrayLike], bounds: Optional[npt.ArrayLike] = None) -> None:
        """Adds a user-defined torque.

        Parameters
        ----------
        torque : function torque(t, q, omega)
            Returns the torque, N m, body axes; shape (3,). It must depend on its arguments alone. omega is relative to the stars,
            in body axes, rad/s; relative to the space axes it is omega - R.T @ frame_rate.
        bounds : four floats
            Bounds (torque, by_rotation, second, rate) at all attitudes and times, only for a torque that does not depend on
            omega: of its norm, of the norms of its first and second derivatives with respect to the angle of a rotation about any
            axis, N m; `rate`, 1/s: the bounds times `rate` bound the time derivatives (0: constant in time). If all effects have bounds,
            steps can be certified; otherwise `uncertified_steps` counts them. The bounds are not verified.

        Raises
        ------
        NutateValueError
            If a bound is out of its range.

        Examples
        --------
        >>> body = nutate.System(moments=(1, 2, 2.5))
        >>> body.add_user_torque(lambda t, q, omega: -0.5 * omega)
        >>> solution = nutate.solve(body, omega0=(0, 0, 1), t_span=(0, 5), accuracy=1e-8)
        >>> solution.omega[-1].round(6).tolist()
        [0.0, 0.0, 0.367879]
        """
        given = bounds_of(bounds, ("torque", "by_rotation", "second", "rate"))
        self._call(f"nutate_{self._kind}_add_user_torque", self._callbacks.torque(torque), None)
        if given is not None:
            self._call(f"nutate_{self._kind}_bound_torque", *given)
        self._add("add_user_torque", torque, given)

    def add_potential(self, direction: npt.ArrayLike, potential: Callable[..., Any],
                      hessian: Optional[Callable[..., npt.ArrayLike]] = None,
                      bounds: Optional[npt.ArrayLike] = None) -> None:
        """Adds a user-defined potential.

        Parameters
        ----------
        direction : array, shape (3,)
            Vector that is fixed in space.
        potential : function potential(gamma)
            Returns U, J, and its gradient, shape (3,), with respect to gamma, the body components of `direction`.
        hessian : function hessian(gamma)
            Returns the second derivatives, shape (3, 3); default: differences.
        bounds : three floats
            Bounds (gradient, hessian, third) for all gamma up to the length of `direction`: of the norm of the gradient, of the
            norm of the second derivatives and of the third derivative along any unit vector. For their use see `add_user_torque`.

        Raises
        ------
        NutateValueError
            If a bound is out of its range.

        Examples
        --------
        >>> pendulum = nutate.System(moments=(1, 1, 0.1))
        >>> pendulum.add_potential((0, 0, 1), lambda gamma: (9.0 * gamma[2], (0, 0, 9.0)))
        >>> nutate.Stepper(pendulum).energy.tolist()[1]
        9.0
        """
        given, n = bounds_of(bounds, ("gradient", "hessian", "third")), vector(direction, 3, "direction").copy()
        self._call(f"nutate_{self._kind}_add_potential", pointer(n),
                   self._callbacks.potential(potential), self._callbacks.hessian(hessian), None)
        if given is not None:
            self._call(f"nutate_{self._kind}_bound_potential", *given)
        self._add("add_potential", n, potential, hessian, given)


class System(UserEffects, WheelMounting):
    """A rigid body and the effects that act on it.

    Give one of `moments`, `tensor`, `shape`, `text` and `scene`. `with System(...) as system:` frees it at the end. copy.copy
    and pickle make another system with the same effects; pickle requires callbacks that can be pickled, and the same files of
    tables.

    Parameters
    ----------
    moments : array, shape (3,)
        Principal moments about the reference point, kg m2.
    tensor : array, shape (6,) or (3, 3)
        Jxx, Jyy, Jzz, Jxy, Jxz, Jyz in body axes, or the whole symmetric tensor, kg m2. Jxy is the element of the tensor,
        -sum(m x y); many CAD programs print the opposite sign.
    shape : str
        "box", "cylinder", "cone", "sphere" or "ellipsoid", with `size` and `mass` or `density`.
    size : array
        Lengths of the shape, m, as key size in &body.
    text : str
        Groups of a scene file, such as "&body inertia = 5, 20, 17 / &gravity /".
    scene : Scene
        Scene that supplies body and effects.
    mass : float
        Mass, kg.
    density : float
        Density, kg/m3.
    center_of_mass : array, shape (3,)
        Centre of mass from the reference point, body axes, m.
    about_center : bool
        True if moments or tensor refer to the centre of mass.

    Raises
    ------
    NutateValueError
        If no body has these values.

    Examples
    --------
    >>> top = nutate.System(shape="cone", size=(0.05, 0.1), density=2700, center_of_mass=(0, 0, 0.075))
    >>> top.add("gravity", acceleration=(0, 0, -9.81))
    >>> round(top.mass, 4), top.center_of_mass.tolist()
    (0.7069, [0.0, 0.0, 0.075])
    """

    _destroy = "nutate_system_destroy"
    _kind = "system"

    def __init__(self, *, moments: Optional[npt.ArrayLike] = None, tensor: Optional[npt.ArrayLike] = None,
                 shape: Optional[str] = None, size: Optional[npt.ArrayLike] = None, text: Union[str, bytes, None] = None,
                 scene: Optional[Recipe] = None, mass: float = 0.0, density: float = 0.0, center_of_mass: Optional[npt.ArrayLike] = None,
                 about_center: bool = False) -> None:
        if sum(way is not None for way in (moments, tensor, shape, text, scene)) != 1:
            raise refusal("a System needs exactly one of moments, tensor, shape, text and scene")
        if shape is None and (size is not None or number(density, "density") != 0):
            raise refusal("size or density without shape (expected shape)")
        if (text is not None or scene is not None) and (number(mass, "mass") != 0 or center_of_mass is not None):
            raise refusal("mass or center_of_mass beside text or scene (expected them in these)")
        if about_center and moments is None and tensor is None:
            raise refusal("about_center without moments or tensor (expected one of them)")
        center = None if center_of_mass is None else vector(center_of_mass, 3, "center_of_mass")
        if text is not None:
            handle = create(library.nutate_system_parse, encoded(text))
        elif scene is not None:
            handle = create(library.nutate_scene_system, scene._handle)
        elif shape is not None:
            lengths = np.atleast_1d(doubles(() if size is None else size, "size"))
            handle = create(library.nutate_system_create_shape, encoded(shape), pointer(lengths), lengths.size, number(mass, "mass"),
                            number(density, "density"), pointer(center))
        elif tensor is not None:
            handle = create(library.nutate_system_create_tensor, pointer(tensor_entries(tensor)), number(mass, "mass"),
                            pointer(center), bool(about_center))
        else:
            handle = create(library.nutate_system_create_moments, pointer(vector([] if moments is None else moments, 3, "moments")),
                            number(mass, "mass"), pointer(center), bool(about_center))
        super().__init__(handle, None if scene is None else scene._callbacks)
        self._note(moments=moments, tensor=tensor, shape=shape, size=size, text=text, scene=scene, mass=mass, density=density,
                   center_of_mass=center_of_mass, about_center=about_center)

    def __copy__(self) -> System:
        # Without parsing its groups again.
        twin = type(self).__new__(type(self))
        twin.__dict__.update(self.__dict__, _owned=create(library.nutate_system_copy, self._handle), _additions=list(self._additions),
                             _files=dict(self._files))
        return twin

    def __repr__(self) -> str:
        if self._is_closed:
            return "<System, closed>"
        with np.printoptions(precision=6):
            inertia = np.array2string(self.inertia, separator=", ").replace("\n", "")
        effects = ", ".join(arguments[0] if name == "_add_group" else name.lstrip("_")[len("add_"):]
                            for name, arguments in self._additions)
        return f"<System inertia={inertia} mass={self.mass:g}{' with ' + effects if effects else ''}>"

    @property
    def mass(self) -> float:
        """Mass, kg; 0 if unknown."""
        mass = np.zeros(1)
        self._call("nutate_system_body", None, pointer(mass), None)
        return float(mass[0])

    @property
    def center_of_mass(self) -> Array:
        """Centre of mass, from the reference point, body axes, m; shape (3,)."""
        center = np.empty(3)
        self._call("nutate_system_body", None, None, pointer(center))
        return center

    @property
    def inertia(self) -> Array:
        """Inertia about the reference point, body axes, kg m2; shape (3, 3)."""
        tensor = np.empty((3, 3))
        self._call("nutate_system_body", pointer(tensor), None, None)
        return tensor

    @property
    def frame_rate(self) -> Array:
        """Angular velocity of the space axes, resolved in those axes, rad/s; shape (3,). It is zero unless there is a rotating frame or an orbit
        with frame="lvlh"."""
        return self._read("nutate_system_frame_rate", 3)

    def space_axes(self, t: npt.ArrayLike) -> Array:
        """Computes the attitude of the space axes in inertial axes: that of LVLH space axes, or the identity.

        Parameters
        ----------
        t : float, or array, shape (n,)
            Times, s.

        Returns
        -------
        array, shape (4,) or (n, 4)
            Quaternion from space to inertial axes; `quat_product` of it and q is an attitude in inertial axes.

        Raises
        ------
        NutateValueError
            If the system has a rotating frame, whose attitude is not known.

        Examples
        --------
        >>> body = nutate.System(moments=(1, 1.2, 0.4))
        >>> body.space_axes([0.0, 1.0]).tolist()
        [[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]
        """
        times = np.atleast_1d(doubles(t, "t"))
        q = np.empty((times.size, 4))
        self._call("nutate_system_space_axes", times.size, pointer(times), pointer(q))
        return q if np.ndim(t) else q[0]

    def add(self, effect: str, /, **keys: Any) -> None:
        """Adds a built-in effect.

        Parameters
        ----------
        effect : str
            Group of a scene file, such as "gravity" or "damping".
        **keys
            Keys of this group; `name` is the name of the effect for switches.

        Raises
        ------
        NutateValueError
            If the group or a key is unknown, or a value is out of its range.

        Examples
        --------
        >>> body = nutate.System(moments=(1, 2, 2.5))
        >>> body.add("spring", body_point=(0, 0, 1), anchor=(0, 0, 2), stiffness=3)
        """
        self._add_group(effect, group(effect, **keys))

    def add_table(self, t: npt.ArrayLike, torque: npt.ArrayLike, *, interpolation: str = "linear", outside: str = "zero",
                  axes: str = "body", start: Optional[float] = None, stop: Optional[float] = None,
                  name: Optional[str] = None, on: bool = True) -> None:
        """Adds a tabulated torque.

        Parameters
        ----------
        t : array, shape (n,)
            Times, s, ascending.
        torque : array, shape (n, 3)
            Components, N m, in `axes`.
        interpolation, outside, axes : str
            Keys of &torque with a table: "linear" or "cubic"; "zero" or "periodic"; "body" or "space".
        start, stop : float
            Times between which the torque acts, s.
        name : str
            Name for switches.
        on : bool
            False if the torque is switched off at the start.

        Raises
        ------
        NutateValueError
            If the table or a key is invalid.

        Examples
        --------
        >>> body = nutate.System(moments=(1, 2, 2.5))
        >>> body.add_table((0, 1), [(0, 0, 0), (0, 0, 0.5)])
        >>> nutate.solve(body, omega0=(0, 0, 0), t_span=(0, 2)).omega[-1].round(9).tolist()
        [0.0, 0.0, 0.1]
        """
        times, values = np.atleast_1d(doubles(t, "t")), np.atleast_1d(doubles(torque, "torque"))
        if times.ndim != 1 or values.shape != (times.size, 3):
            raise refusal(f"the table has times of shape {times.shape} and torques of shape {values.shape} (expected (n,) and (n, 3))")
        given = {"interpolation": interpolation, "outside": outside, "axes": axes, "start": start, "stop": stop, "name": name}
        # The group without its name and its end.
        keys = group("torque", **given)[len("&torque "):-len(" /\n")] + (", on = .true." if on else ", on = .false.")
        self._add_table(times.copy(), values.copy(), keys)

    def _add_table(self, times: Array, values: Array, keys: str) -> None:
        self._call("nutate_system_add_table", times.size, pointer(times), pointer(values), encoded(keys))
        self._add("_add_table", times, values, keys)

    def _add_group(self, name: str, text: str) -> None:
        self._call("nutate_system_add_groups", encoded(text))
        self._add("_add_group", name, text)
        self._note_files(text)
