"""Bodies and what acts on them."""

import numpy as np

from ._library import Owner, bounds_of, create, encoded, library, pointer, vector


def group(name, **values):
    """A group of a scene file with the values that are not None."""

    def text(value):
        if isinstance(value, str):
            return "'" + value.replace("'", "''") + "'"
        return ", ".join(repr(float(number)) for number in np.atleast_1d(value))

    given = [f"{key} = {text(value)}" for key, value in values.items() if value is not None]
    return f"&{name} " + ", ".join(given) + " /\n"


class System(Owner):
    """A rigid body and the effects that act on it.

    One of:
        System(moments=(J1, J2, J3))                     principal moments about the reference point, kg m2
        System(tensor=(Jxx, Jyy, Jzz, Jxy, Jxz, Jyz))    the symmetric tensor in body axes, kg m2
        System(shape="box", size=(4, 1, 2))              with mass or density; also cylinder, cone, sphere, ellipsoid
        System(text="&body inertia = 5, 20, 17 / &gravity /")   as a scene file says it

    mass in kg, density in kg/m3; center_of_mass from the reference point, body axes, m; about_center: the moments or the
    tensor refer to the centre of mass.
    """

    destroy = "nutate_system_destroy"

    def __init__(self, *, moments=None, tensor=None, shape=None, size=None, text=None, mass=0.0, density=0.0,
                 center_of_mass=None, about_center=False):
        if sum(way is not None for way in (moments, tensor, shape, text)) != 1:
            raise ValueError("a System takes one of moments, tensor, shape and text")
        center = None if center_of_mass is None else vector(center_of_mass, 3, "center_of_mass")
        if text is not None:
            handle = create(library.nutate_system_parse, encoded(text))
        elif shape is not None:
            lengths = np.ascontiguousarray(np.atleast_1d(() if size is None else size), dtype=np.float64)
            handle = create(library.nutate_system_create_shape, encoded(shape), pointer(lengths), lengths.size, mass,
                            density, pointer(center))
        elif tensor is not None:
            handle = create(library.nutate_system_create_tensor, pointer(vector(tensor, 6, "tensor")), mass,
                            pointer(center), bool(about_center))
        else:
            handle = create(library.nutate_system_create_moments, pointer(vector(moments, 3, "moments")), mass,
                            pointer(center), bool(about_center))
        super().__init__(handle)

    @property
    def inertia(self):
        """Inertia about the reference point, body axes, kg m2; shape (3, 3)."""
        tensor = np.empty((3, 3))
        self._call("nutate_system_body", pointer(tensor), None, None)
        return tensor

    def add(self, name, **keys):
        """Adds a built-in effect with the keys of its group in a scene file:
        system.add("spring", body_point=(0, 0, 1), anchor=(0, 0, 2), stiffness=3)."""
        self._call("nutate_system_add_groups", encoded(group(name, **keys)))

    def add_user_torque(self, torque, bounds=None):
        """Adds a torque of your own: torque(t, q, omega) gives three numbers, N m, body axes; omega in body axes, rad/s.
        It must depend on its arguments alone.

        bounds = (torque, by_rotation, second, rate), for a torque that does not depend on omega, at all attitudes and
        times: of |tau|, of the length of its first and of its second derivative by the angle as the body turns about any
        axis, N m, and a rate, 1/s, that times these bounds their derivatives by time (0: constant in time). With bounds
        of every effect steps can be proved to follow the true motion; without them they count as `unproved_steps`. The
        bounds are promised, not tested."""
        add_user_torque(self, "system", torque, bounds)

    def add_potential(self, direction, potential, hessian=None, bounds=None):
        """Adds a potential of your own: potential(gamma) gives U (J) and its gradient by gamma, the body components of
        the vector `direction` fixed in space; hessian(gamma), if there is one, its second derivatives.

        bounds = (gradient, hessian, third): of the length of the gradient, of the norm of the second derivatives and of
        the third derivative along any unit vector, for all gamma up to the length of `direction`. What they are good for:
        see add_user_torque."""
        add_potential(self, "system", direction, potential, hessian, bounds)


def add_user_torque(owner, kind, torque, bounds):
    """Adds a torque to a system or a scene, with its bounds."""
    given = bounds_of(bounds, ("torque", "by_rotation", "second", "rate"))
    owner._call(f"nutate_{kind}_add_user_torque", owner._callbacks.torque(torque), None)
    if given is not None:
        owner._call(f"nutate_{kind}_bound_torque", *given)


def add_potential(owner, kind, direction, potential, hessian, bounds):
    """Adds a potential to a system or a scene, with its bounds."""
    given = bounds_of(bounds, ("gradient", "hessian", "third"))
    owner._call(f"nutate_{kind}_add_potential", pointer(vector(direction, 3, "direction")),
                owner._callbacks.potential(potential), owner._callbacks.hessian(hessian), None)
    if given is not None:
        owner._call(f"nutate_{kind}_bound_potential", *given)
