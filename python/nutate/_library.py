"""Finds the C library, declares what is called of it, and turns its statuses into exceptions."""

import ctypes
import os
import sys
import threading

import numpy as np

SONAME = "libnutate.so.0"
MESSAGE_SIZE = 1024

Handle = ctypes.c_void_p
HandlePointer = ctypes.POINTER(ctypes.c_void_p)
Doubles = ctypes.POINTER(ctypes.c_double)
Text = ctypes.c_char_p
Size = ctypes.c_size_t
Sizes = ctypes.POINTER(ctypes.c_size_t)
Int = ctypes.c_int
Long = ctypes.c_int64
Double = ctypes.c_double

PotentialCallback = ctypes.CFUNCTYPE(Int, Doubles, ctypes.c_void_p, Doubles, Doubles)
HessianCallback = ctypes.CFUNCTYPE(Int, Doubles, ctypes.c_void_p, Doubles)
TorqueCallback = ctypes.CFUNCTYPE(Int, Double, Doubles, Doubles, ctypes.c_void_p, Doubles)

# Arguments as include/nutate.h has them; every function returns a status.
SIGNATURES = {
    "nutate_get_version": (Text, Size),
    "nutate_status_text": (Int, Text, Size),
    "nutate_last_message": (Handle, Text, Size),
    "nutate_system_create_moments": (Doubles, Double, Doubles, Int, HandlePointer, Text, Size),
    "nutate_system_create_tensor": (Doubles, Double, Doubles, Int, HandlePointer, Text, Size),
    "nutate_system_create_shape": (Text, Doubles, Size, Double, Double, Doubles, HandlePointer, Text, Size),
    "nutate_system_parse": (Text, HandlePointer, Text, Size),
    "nutate_system_destroy": (HandlePointer,),
    "nutate_system_body": (Handle, Doubles, Doubles, Doubles),
    "nutate_system_add_groups": (Handle, Text),
    "nutate_system_add_potential": (Handle, Doubles, PotentialCallback, HessianCallback, ctypes.c_void_p),
    "nutate_system_add_user_torque": (Handle, TorqueCallback, ctypes.c_void_p),
    "nutate_system_bound_potential": (Handle, Double, Double, Double),
    "nutate_system_bound_torque": (Handle, Double, Double, Double, Double),
    "nutate_scene_read": (Text, ctypes.POINTER(Text), Size, HandlePointer, Text, Size),
    "nutate_scene_parse": (Text, Text, ctypes.POINTER(Text), Size, HandlePointer, Text, Size),
    "nutate_scene_destroy": (HandlePointer,),
    "nutate_scene_get_title": (Handle, Text, Size),
    "nutate_scene_add_potential": (Handle, Doubles, PotentialCallback, HessianCallback, ctypes.c_void_p),
    "nutate_scene_add_user_torque": (Handle, TorqueCallback, ctypes.c_void_p),
    "nutate_scene_bound_potential": (Handle, Double, Double, Double),
    "nutate_scene_bound_torque": (Handle, Double, Double, Double, Double),
    "nutate_scene_system": (Handle, HandlePointer, Text, Size),
    "nutate_scene_run": (Handle, HandlePointer, Text, Size),
    "nutate_scene_write": (Handle, Text, Text, Size),
    "nutate_history_size": (Handle, Sizes, Sizes),
    "nutate_history_name": (Handle, Size, Text, Size),
    "nutate_history_values": (Handle, Doubles, Size),
    "nutate_history_unproved": (Handle, ctypes.POINTER(Long)),
    "nutate_history_destroy": (HandlePointer,),
    "nutate_stepper_create": (Handle, HandlePointer, Text, Size),
    "nutate_stepper_create_scene": (Handle, HandlePointer, Text, Size),
    "nutate_stepper_destroy": (HandlePointer,),
    "nutate_stepper_set": (Handle, Text, Text),
    "nutate_stepper_set_state": (Handle, Double, Doubles, Doubles),
    "nutate_stepper_step": (Handle, Double),
    "nutate_stepper_keep_steps": (Handle,),
    "nutate_stepper_state_at": (Handle, Double, Doubles, Doubles),
    "nutate_stepper_steps": (Handle, Double, Long, ctypes.POINTER(Long)),
    "nutate_stepper_run": (Handle, Long, Long, Doubles, Size, Sizes),
    "nutate_stepper_set_columns": (Handle, Text),
    "nutate_stepper_width": (Handle, Sizes),
    "nutate_stepper_column": (Handle, Size, Text, Size),
    "nutate_stepper_time": (Handle, Doubles),
    "nutate_stepper_quaternion": (Handle, Doubles),
    "nutate_stepper_conjugate_momentum": (Handle, Doubles),
    "nutate_stepper_angular_velocity": (Handle, Doubles),
    "nutate_stepper_angular_velocity_space": (Handle, Doubles),
    "nutate_stepper_angular_momentum": (Handle, Doubles),
    "nutate_stepper_angular_momentum_space": (Handle, Doubles),
    "nutate_stepper_matrix": (Handle, Doubles),
    "nutate_stepper_euler": (Handle, Doubles),
    "nutate_stepper_energy": (Handle, Doubles),
    "nutate_stepper_constraints": (Handle, Doubles),
    "nutate_stepper_unproved": (Handle, ctypes.POINTER(Long)),
    "nutate_stepper_accuracy": (Handle, Doubles),
}


class NutateError(Exception):
    """A call of the library failed. `status` is its number, as NUTATE_... in nutate.h."""

    def __init__(self, status, message):
        super().__init__(message or status_text(status))
        self.status = status


def installed_with():
    """The library that was installed together with this package, if it was: `make install` says where."""
    try:
        from ._location import LIBRARY
    except ImportError:
        return []
    return [LIBRARY]


def load():
    """The library, with its functions declared."""
    named = os.environ.get("NUTATE_LIBRARY")
    places = [named] if named else [*installed_with(), os.path.join(sys.prefix, "lib", SONAME), SONAME]
    reasons = []
    for place in places:
        try:
            library = ctypes.CDLL(place)
            break
        except OSError as error:
            reasons.append(str(error))
    else:
        raise ImportError("nutate: the C library is not there (" + "; ".join(reasons) + "). Build and install it with "
                          "`make install PREFIX=FOLDER` and this package with `pip install FOLDER/share/nutate/python`, "
                          f"or let NUTATE_LIBRARY name {SONAME}.")
    for name, arguments in SIGNATURES.items():
        function = getattr(library, name)
        function.argtypes = arguments
        function.restype = Int
    return library


library = load()


def text_of(function, *arguments):
    """What a function with (buffer, size) at its end writes there."""
    buffer = ctypes.create_string_buffer(MESSAGE_SIZE)
    check(function(*arguments, buffer, MESSAGE_SIZE))
    return buffer.value.decode("utf-8", "replace")


def status_text(status):
    """One line about a status."""
    buffer = ctypes.create_string_buffer(MESSAGE_SIZE)
    library.nutate_status_text(status, buffer, MESSAGE_SIZE)
    return buffer.value.decode()


def version():
    """Version of the library."""
    return text_of(library.nutate_get_version)


def check(status, message=""):
    """Raises NutateError unless the status is NUTATE_OK."""
    if status:
        raise NutateError(status, message)


def create(function, *arguments):
    """The handle that a create function makes."""
    handle = ctypes.c_void_p()
    message = ctypes.create_string_buffer(MESSAGE_SIZE)
    status = function(*arguments, ctypes.byref(handle), message, MESSAGE_SIZE)
    check(status, message.value.decode("utf-8", "replace"))
    return handle


def encoded(text):
    """A text, or a path, as C has it. C ends texts at a NUL: what stands behind one would be lost."""
    data = os.fsencode(text) if isinstance(text, (bytes, os.PathLike)) else text.encode("utf-8", "surrogateescape")
    if b"\0" in data:
        raise ValueError(f"{text!r} has a NUL character")
    return data


def vector(values, size, name):
    """A contiguous array of so many doubles."""
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.shape != (size,):
        raise ValueError(f"{name} has shape {array.shape} (expected {size} numbers)")
    return array


def bounds_of(values, names):
    """The bounds of a callback as floats; None where there are none. Tested before the callback is added."""
    if values is None:
        return None
    bounds = [float(value) for value in vector(values, len(names), "bounds")]
    for name, bound in zip(names, bounds):
        if not (bound == 0 or 1e-300 <= bound <= 1e100):
            raise ValueError(f"the bound {name} is {bound} (expected 0 or 1e-300 to 1e100)")
    return bounds


def pointer(array):
    """What C sees of an array of doubles; None is NULL."""
    return None if array is None else array.ctypes.data_as(Doubles)


class Owner:
    """Something with a handle that is freed with it, and with callbacks that must live as long."""

    destroy = None

    def __init__(self, handle, callbacks=None):
        self._handle = handle
        self._callbacks = callbacks if callbacks is not None else Callbacks()

    def __del__(self):
        handle = getattr(self, "_handle", None)
        if handle:
            getattr(library, self.destroy)(ctypes.byref(handle))

    def __reduce_ex__(self, protocol):
        # A copy would share the handle, and free it under the original.
        raise TypeError(f"a {type(self).__name__} cannot be copied or pickled: make another one")

    def _call(self, name, *arguments):
        """Calls a function of this handle; raises what a callback raised, or NutateError."""
        status = getattr(library, name)(self._handle, *arguments)
        if status:
            self._callbacks.raise_again()
            check(status, text_of(library.nutate_last_message, self._handle))

    def _read(self, name, *shape):
        """The numbers that a function of this handle writes."""
        values = np.empty(shape)
        self._call(name, pointer(values))
        return values


class Callbacks:
    """Functions that the library calls: kept alive here, with what one of them raised in the present thread."""

    def __init__(self):
        self._kept = []
        self._raised = threading.local()

    def raise_again(self):
        """Raises what a callback raised since the last call, if one did."""
        error = getattr(self._raised, "error", None)
        self._raised.error = None
        if error is not None:
            raise error

    def _guard(self, kind, evaluate):
        """A callback of C that returns 1 where `evaluate` raises."""

        def call(*arguments):
            try:
                evaluate(*arguments)
                return 0
            except BaseException as error:
                self._raised.error = error
                return 1

        guarded = kind(call)
        self._kept.append(guarded)
        return guarded

    def torque(self, function):
        """tau = function(t, q, omega)"""

        def evaluate(t, q, omega, _, tau):
            value = function(t, np.ctypeslib.as_array(q, (4,)).copy(), np.ctypeslib.as_array(omega, (3,)).copy())
            np.ctypeslib.as_array(tau, (3,))[:] = vector(value, 3, "the torque")

        return self._guard(TorqueCallback, evaluate)

    def potential(self, function):
        """energy, gradient = function(gamma)"""

        def evaluate(gamma, _, energy, gradient):
            value, slope = function(np.ctypeslib.as_array(gamma, (3,)).copy())
            energy[0] = value
            np.ctypeslib.as_array(gradient, (3,))[:] = vector(slope, 3, "the gradient")

        return self._guard(PotentialCallback, evaluate)

    def hessian(self, function):
        """hessian = function(gamma), or None"""
        if function is None:
            return HessianCallback()

        def evaluate(gamma, _, hessian):
            value = np.ascontiguousarray(function(np.ctypeslib.as_array(gamma, (3,)).copy()), dtype=np.float64)
            np.ctypeslib.as_array(hessian, (9,))[:] = vector(value.reshape(-1), 9, "the hessian")

        return self._guard(HessianCallback, evaluate)
