"""Rigid bodies and the effects that act on them."""

from __future__ import annotations

from typing import Any, Callable, Optional, Union

import numpy as np
import numpy.typing as npt

from ._library import Array, bounds_of, create, encoded, library, pointer, refusal, vector
from ._owners import Owner, Recipe
from .satellites import WheelMounting


def group(name: str, /, **values: Any) -> str:
    """A group of a scene file with the values that are not None."""

    def text(value: Any) -> str:
        if isinstance(value, str):
            return "'" + value.replace("'", "''") + "'"
        if isinstance(value, (bool, np.bool_)):
            return ".true." if value else ".false."
        return ", ".join(repr(float(number)) for number in np.ravel(value))

    given = [f"{key} = {text(value)}" for key, value in values.items() if value is not None]
    return f"&{name} " + ", ".join(given) + " /\n"


def tensor_entries(tensor: npt.ArrayLike) -> Array:
    """Jxx, Jyy, Jzz, Jxy, Jxz, Jyz of those, or of a symmetric 3 x 3 matrix."""
    matrix = np.asarray(tensor, dtype=np.float64)
    if matrix.shape != (3, 3):
        return vector(matrix, 6, "tensor")
    if not np.allclose(matrix, matrix.T, rtol=1e-12, atol=0):
        raise refusal("tensor is not symmetric (expected a symmetric 3 x 3 matrix)")
    return np.array([matrix[0, 0], matrix[1, 1], matrix[2, 2], matrix[0, 1], matrix[0, 2], matrix[1, 2]])


class System(WheelMounting):
    """A rigid body and the effects that act on it.

    One of:
        System(moments=(J1, J2, J3))                     principal moments about the reference point, kg m2
        System(tensor=(Jxx, Jyy, Jzz, Jxy, Jxz, Jyz))    the symmetric tensor in body axes, kg m2,
                                                         or all of it, 3 x 3
        System(shape="box", size=(4, 1, 2))              with mass or density; also cylinder, cone, sphere, ellipsoid
        System(text="&body inertia = 5, 20, 17 / &gravity /")   groups of a scene file
        System(scene=Scene("box.nml"))                   body and effects of a scene

    mass in kg, density in kg/m3; center_of_mass from the reference point, body axes, m; about_center: the moments or the
    tensor refer to the centre of mass.

    `with System(...) as system:` frees it at the end. copy.copy and pickle make another system with the same effects; pickle
    requires callbacks that can be pickled.
    """

    _destroy = "nutate_system_destroy"

    def __init__(self, *, moments: Optional[npt.ArrayLike] = None, tensor: Optional[npt.ArrayLike] = None,
                 shape: Optional[str] = None, size: Optional[npt.ArrayLike] = None, text: Union[str, bytes, None] = None,
                 scene: Optional[Recipe] = None, mass: float = 0.0, density: float = 0.0, center_of_mass: Optional[npt.ArrayLike] = None,
                 about_center: bool = False) -> None:
        if sum(way is not None for way in (moments, tensor, shape, text, scene)) != 1:
            raise refusal("a System needs exactly one of moments, tensor, shape, text and scene")
        center = None if center_of_mass is None else vector(center_of_mass, 3, "center_of_mass")
        if text is not None:
            handle = create(library.nutate_system_parse, encoded(text))
        elif scene is not None:
            handle = create(library.nutate_scene_system, scene._handle)
        elif shape is not None:
            lengths = np.ascontiguousarray(np.atleast_1d(() if size is None else size), dtype=np.float64)
            handle = create(library.nutate_system_create_shape, encoded(shape), pointer(lengths), lengths.size, float(mass),
                            float(density), pointer(center))
        elif tensor is not None:
            handle = create(library.nutate_system_create_tensor, pointer(tensor_entries(tensor)), float(mass),
                            pointer(center), bool(about_center))
        else:
            handle = create(library.nutate_system_create_moments, pointer(vector([] if moments is None else moments, 3, "moments")), float(mass),
                            pointer(center), bool(about_center))
        super().__init__(handle, None if scene is None else scene._callbacks)
        self._note(moments=moments, tensor=tensor, shape=shape, size=size, text=text, scene=scene, mass=mass, density=density,
                   center_of_mass=center_of_mass, about_center=about_center)

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
        """Rate at which the space axes turn, in these, rad/s; shape (3,). It is zero unless there is a rotating frame or an orbit
        with frame="lvlh"."""
        rate = np.empty(3)
        self._call("nutate_system_frame_rate", pointer(rate))
        return rate

    def space_axes(self, t: npt.ArrayLike) -> Array:
        """Computes the attitude of the space axes in inertial axes at times t, s: that of LVLH space axes, or the
        identity; shape (4,) or (n, 4). `quat_product(space_axes(t), q)` is an attitude in inertial axes. Raises NutateValueError for a
        rotating frame, whose attitude is not known."""
        times = np.ascontiguousarray(np.atleast_1d(t), dtype=np.float64)
        q = np.empty((times.size, 4))
        self._call("nutate_system_space_axes", times.size, pointer(times), pointer(q))
        return q if np.ndim(t) else q[0]

    def add(self, name: str, **keys: Any) -> None:
        """Adds a built-in effect with the keys of its group in a scene file:
        system.add("spring", body_point=(0, 0, 1), anchor=(0, 0, 2), stiffness=3)."""
        self._add_group(name, group(name, **keys))

    def add_table(self, t: npt.ArrayLike, torque: npt.ArrayLike, *, interpolation: str = "linear", outside: str = "zero",
                  axes: str = "body", start: Optional[float] = None, stop: Optional[float] = None,
                  name: Optional[str] = None, on: bool = True) -> None:
        """Adds a tabulated torque: times, s, shape (n,), and components, N m, shape (n, 3); the keys are those of the group
        &torque that go with a table."""
        times, values = (np.ascontiguousarray(array, dtype=np.float64) for array in (t, torque))
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

    def add_user_torque(self, torque: Callable[..., npt.ArrayLike], bounds: Optional[npt.ArrayLike] = None) -> None:
        """Adds a user-defined torque: torque(t, q, omega) returns three numbers, N m, body axes; omega is absolute, relative
        to the stars, in body axes, rad/s. Relative to the space axes it is omega - R.T @ frame_rate. The torque must depend on its
        arguments alone.

        bounds = (torque, by_rotation, second, rate), only for a torque that does not depend on omega, hold at all attitudes
        and times: of |tau|, of the norms of its first and second derivatives by the angle of a rotation of the body about any
        axis, N m; `rate`, 1/s, times these bounds their time derivatives (0: constant in time). If all effects have bounds,
        steps can be certified; otherwise they count as `uncertified_steps`. The bounds are not verified."""
        add_user_torque(self, "system", torque, bounds)
        self._add("add_user_torque", torque, bounds)

    def add_potential(self, direction: npt.ArrayLike, potential: Callable[..., Any],
                      hessian: Optional[Callable[..., npt.ArrayLike]] = None,
                      bounds: Optional[npt.ArrayLike] = None) -> None:
        """Adds a user-defined potential: potential(gamma) returns U (J) and its gradient by gamma, the body components of
        the vector `direction` fixed in space; hessian(gamma), if given, its second derivatives.

        bounds = (gradient, hessian, third): of the norm of the gradient, of the norm of the second derivatives and of
        the third derivative along any unit vector, for all gamma up to the length of `direction`. For their use see
        add_user_torque."""
        add_potential(self, "system", direction, potential, hessian, bounds)
        self._add("add_potential", direction, potential, hessian, bounds)


def add_user_torque(owner: Owner, kind: str, torque: Callable[..., npt.ArrayLike],
                    bounds: Optional[npt.ArrayLike]) -> None:
    """Adds a torque to a system or a scene, with its bounds."""
    given = bounds_of(bounds, ("torque", "by_rotation", "second", "rate"))
    owner._call(f"nutate_{kind}_add_user_torque", owner._callbacks.torque(torque), None)
    if given is not None:
        owner._call(f"nutate_{kind}_bound_torque", *given)


def add_potential(owner: Owner, kind: str, direction: npt.ArrayLike, potential: Callable[..., Any],
                  hessian: Optional[Callable[..., npt.ArrayLike]], bounds: Optional[npt.ArrayLike]) -> None:
    """Adds a potential to a system or a scene, with its bounds."""
    given = bounds_of(bounds, ("gradient", "hessian", "third"))
    owner._call(f"nutate_{kind}_add_potential", pointer(vector(direction, 3, "direction")),
                owner._callbacks.potential(potential), owner._callbacks.hessian(hessian), None)
    if given is not None:
        owner._call(f"nutate_{kind}_bound_potential", *given)
