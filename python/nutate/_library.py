"""Finds the C library, declares what is called of it, and turns its statuses into exceptions."""

from __future__ import annotations

import ctypes
import importlib
import os
import signal
import sys
import warnings
from threading import get_ident, main_thread
from typing import Any, Callable, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

SONAME = "libnutate.so.0"
# The name in a package that pip built, which has no version in it.
BUNDLED = "libnutate.so"
# A message can name a path, and all the columns or keys that there are.
MESSAGE_SIZE = 8192

Handle = ctypes.c_void_p
HandlePointer = ctypes.POINTER(ctypes.c_void_p)
Doubles = ctypes.POINTER(ctypes.c_double)
Text = ctypes.c_char_p
Size = ctypes.c_size_t
Sizes = ctypes.POINTER(ctypes.c_size_t)
Int = ctypes.c_int
Long = ctypes.c_int64
Double = ctypes.c_double

# Addresses for arrays: ctypes would make an object of each pointer in each call.
Address = ctypes.c_void_p
PotentialCallback = ctypes.CFUNCTYPE(Int, Address, Address, Address, Address)
HessianCallback = ctypes.CFUNCTYPE(Int, Address, Address, Address)
PollCallback = ctypes.CFUNCTYPE(Int, Address)
TorqueCallback = ctypes.CFUNCTYPE(Int, Double, Address, Address, Address, Address)
QuantityCallback = TorqueCallback

Array = npt.NDArray[np.float64]
Textual = Union[str, bytes, "os.PathLike[str]"]

# Arguments as include/nutate.h has them; every function returns a status.
SIGNATURES: dict[str, tuple[Any, ...]] = {
    "nutate_get_version": (Text, Size),
    "nutate_status_text": (Int, Text, Size),
    "nutate_last_message": (Handle, Text, Size),
    "nutate_system_create_moments": (Doubles, Double, Doubles, Int, HandlePointer, Text, Size),
    "nutate_system_create_tensor": (Doubles, Double, Doubles, Int, HandlePointer, Text, Size),
    "nutate_system_create_shape": (Text, Doubles, Size, Double, Double, Doubles, HandlePointer, Text, Size),
    "nutate_system_parse": (Text, HandlePointer, Text, Size),
    "nutate_system_copy": (Handle, HandlePointer, Text, Size),
    "nutate_system_destroy": (HandlePointer,),
    "nutate_system_body": (Handle, Doubles, Doubles, Doubles),
    "nutate_system_add_groups": (Handle, Text),
    "nutate_system_add_potential": (Handle, Doubles, PotentialCallback, HessianCallback, ctypes.c_void_p),
    "nutate_system_add_user_torque": (Handle, TorqueCallback, ctypes.c_void_p),
    "nutate_system_bound_potential": (Handle, Double, Double, Double),
    "nutate_system_bound_torque": (Handle, Double, Double, Double, Double),
    "nutate_system_add_table": (Handle, Size, Doubles, Doubles, Text),
    "nutate_system_add_earth_field": (Handle, Doubles, Double, Doubles),
    "nutate_system_add_force": (Handle, Doubles, Doubles, Text, Double, Double),
    "nutate_system_add_wheel": (Handle, Doubles, Double, Double, Double, Double, Double),
    "nutate_system_wheel_count": (Handle, Sizes),
    "nutate_system_add_motor": (Handle, Size, Double, Double, Double, Double, Double),
    "nutate_system_add_motor_table": (Handle, Size, Size, Doubles, Doubles, Text),
    "nutate_scene_read": (Text, ctypes.POINTER(Text), Size, HandlePointer, Text, Size),
    "nutate_scene_parse": (Text, Text, ctypes.POINTER(Text), Size, HandlePointer, Text, Size),
    "nutate_scene_destroy": (HandlePointer,),
    "nutate_scene_get": (Handle, Text, Text, Size),
    "nutate_system_frame_rate": (Handle, Doubles),
    "nutate_system_space_axes": (Handle, Size, Doubles, Doubles),
    "nutate_date": (Text, Text, Double, Text, Size),
    "nutate_tdb": (Text, Text, Size, Doubles, Doubles),
    "nutate_write_aem": (Text, Text, Size, Doubles, Doubles, Doubles, Text, Double, Text, Size),
    "nutate_write_gltf": (Text, Text, Size, Doubles, Doubles, Double, Text, Size),
    "nutate_read_aem": (Text, HandlePointer, Text, Size, Text, Size),
    "nutate_scene_get_title": (Handle, Text, Size),
    "nutate_scene_add_potential": (Handle, Doubles, PotentialCallback, HessianCallback, ctypes.c_void_p),
    "nutate_scene_add_user_torque": (Handle, TorqueCallback, ctypes.c_void_p),
    "nutate_scene_bound_potential": (Handle, Double, Double, Double),
    "nutate_scene_bound_torque": (Handle, Double, Double, Double, Double),
    "nutate_scene_system": (Handle, HandlePointer, Text, Size),
    "nutate_scene_equilibria": (Handle, Text, Size, Text, Size),
    "nutate_scene_linearize": (Handle, Double, Text, Size, Text, Size),
    "nutate_fit_size": (Handle, Sizes, Sizes),
    "nutate_fit_name": (Handle, Size, Text, Size),
    "nutate_fit_start": (Handle, Doubles, Doubles, Doubles),
    "nutate_fit_evaluate": (Handle, Doubles, Doubles, Doubles),
    "nutate_fit_cost": (Handle, Doubles, Doubles),
    "nutate_fit_solve": (Handle, Doubles, Doubles, ctypes.POINTER(Int), Text, Size),
    "nutate_scene_run": (Handle, HandlePointer, Text, Size),
    "nutate_scene_write": (Handle, Text, Text, Size),
    "nutate_sweep_size": (Handle, ctypes.POINTER(Long), Sizes),
    "nutate_sweep_field": (Handle, Size, ctypes.POINTER(Int), Text, Size),
    "nutate_sweep_table": (Handle, ctypes.POINTER(Text), Size, Doubles, Size, Text, Size),
    "nutate_sweep_members": (Handle, Long, Long, Int, ctypes.c_void_p, Size, Text, Size),
    "nutate_bodies_create": (HandlePointer, Size, Int, HandlePointer, Text, Size),
    "nutate_bodies_destroy": (HandlePointer,),
    "nutate_bodies_set_threads": (Handle, Int),
    "nutate_bodies_step": (Handle, Size, Address, Double, Address, Address, Address),
    "nutate_bodies_kick": (Handle, Size, Address, Double, Address, Address, Address),
    "nutate_bodies_drift": (Handle, Size, Address, Double, Address, Address),
    "nutate_bodies_failed": (Handle, Size, Address, Sizes),
    "nutate_history_name": (Handle, Size, Text, Size),
    "nutate_history_values": (Handle, Doubles, Size),
    "nutate_history_summary": (Handle, ctypes.POINTER(Long), Doubles),
    "nutate_history_chaos": (Handle, Sizes, Doubles, Doubles, Doubles, Doubles),
    "nutate_history_event": (Handle, Size, Text, Size, ctypes.POINTER(Long), Doubles, Doubles, Doubles),
    "nutate_history_destroy": (HandlePointer,),
    "nutate_stepper_create": (Handle, HandlePointer, Text, Size),
    "nutate_stepper_create_scene": (Handle, HandlePointer, Text, Size),
    "nutate_stepper_destroy": (HandlePointer,),
    "nutate_stepper_set": (Handle, Text, Text),
    "nutate_stepper_set_time_step": (Handle, Double),
    "nutate_stepper_set_state": (Handle, Double, Doubles, Doubles),
    "nutate_stepper_set_canonical": (Handle, Double, Doubles, Doubles),
    "nutate_stepper_prepare": (Handle,),
    "nutate_stepper_step": (Handle, Double),
    "nutate_stepper_keep_steps": (Handle,),
    "nutate_stepper_state_at": (Handle, Double, Doubles, Doubles),
    "nutate_stepper_dense_output": (Handle, Double, Doubles, Doubles, Doubles, Double, Size, Doubles, Doubles),
    "nutate_stepper_steps": (Handle, Double, Long, ctypes.POINTER(Long)),
    "nutate_stepper_run": (Handle, Long, Long, Doubles, Size, Sizes),
    "nutate_stepper_add_events": (Handle, Text),
    "nutate_stepper_add_event": (Handle, QuantityCallback, ctypes.c_void_p, Text),
    "nutate_stepper_event_count": (Handle, Sizes),
    "nutate_stepper_event": (Handle, Size, Text, Size, ctypes.POINTER(Long), Doubles, Doubles, Doubles),
    "nutate_stepper_wheel_count": (Handle, Sizes),
    "nutate_stepper_wheel": (Handle, Size, Doubles, Doubles, Doubles),
    "nutate_stepper_sphere_count": (Handle, Sizes),
    "nutate_stepper_sphere": (Handle, Size, Doubles, Doubles, Doubles, Doubles),
    "nutate_stepper_set_motor": (Handle, Size, Double),
    "nutate_stepper_jacobi": (Handle, Doubles),
    "nutate_stepper_time_dependent_work": (Handle, Doubles),
    "nutate_stepper_orbit": (Handle, Doubles, Doubles),
    "nutate_stepper_lvlh_attitude": (Handle, Doubles, Doubles),
    "nutate_stepper_run_history": (Handle, Double, Long, Double, Doubles, Size, HandlePointer),
    "nutate_stepper_differentiate": (Handle, Handle),
    "nutate_stepper_follow_chaos": (Handle, Handle),
    "nutate_stepper_get": (Handle, Text, Text, Size),
    "nutate_stepper_set_poll": (Handle, PollCallback, ctypes.c_void_p),
    "nutate_scene_set_poll": (Handle, PollCallback, ctypes.c_void_p),
    "nutate_stepper_copy": (Handle, HandlePointer, Text, Size),
    "nutate_stepper_save": (Handle, Text, Size, Sizes),
    "nutate_stepper_restore": (Handle, Text, Size),
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
    "nutate_stepper_uncertified": (Handle, ctypes.POINTER(Long)),
    "nutate_stepper_accuracy": (Handle, Doubles),
    "nutate_stepper_row": (Handle, Doubles, Size),
    "nutate_stepper_conserved": (Handle, ctypes.POINTER(Int), Doubles),
    "nutate_stepper_solver": (Handle, ctypes.POINTER(Int), Doubles),
    "nutate_scene_get_plan": (Handle, Doubles, Doubles, ctypes.POINTER(Long)),
    "nutate_scene_get_initial": (Handle, Doubles, Doubles),
    "nutate_matrix_from_quat": (Doubles, Doubles),
    "nutate_quat_from_matrix": (Doubles, Doubles),
    "nutate_euler_from_quat": (Doubles, Doubles),
    "nutate_follow_euler": (Doubles, Doubles),
    "nutate_quat_from_euler": (Doubles, Doubles),
    "nutate_omega_from_euler_rates": (Doubles, Doubles, Doubles),
    "nutate_quat_from_axis_angle": (Doubles, Double, Doubles),
    "nutate_axis_angle_from_quat": (Doubles, Doubles, Doubles),
    "nutate_quat_from_rotation_vector": (Doubles, Doubles),
    "nutate_rotation_vector_from_quat": (Doubles, Doubles),
    "nutate_quat_product": (Doubles, Doubles, Doubles),
    "nutate_quat_normalized": (Doubles, Doubles),
    "nutate_rotate_to_space": (Doubles, Doubles, Doubles),
    "nutate_rotate_to_body": (Doubles, Doubles, Doubles),
    "nutate_attitude_distance": (Doubles, Doubles, Doubles),
    "nutate_exact_free_body": (Handle, Doubles, Doubles, Size, Doubles, Doubles, Doubles),
}
NOT_CONVERGED, OFF_BRANCH, SINGULAR, NOT_FINITE, BAD_ARGUMENT, BAD_BODY, BAD_SCENE, IO, STEP_LIMIT, BAD_HANDLE = range(1, 11)


class NutateError(Exception):
    """Base class of all errors of the library.

    Attributes
    ----------
    status : int
        Code of the error, as in nutate.h.
    message : str
        Text of the error.
    history : dict of arrays
        Rows so far of a run that failed. Exceptions of callbacks and the KeyboardInterrupt of Ctrl-C have this attribute too.

    Examples
    --------
    >>> try:
    ...     nutate.System(moments=(1, 1, 3))
    ... except nutate.NutateError as error:
    ...     print(type(error).__name__, len(error.history))
    NutateValueError 0
    """

    def __init__(self, status: int, message: str) -> None:
        text = message or status_text(status)
        super().__init__(text)
        self.status = status
        self.message = text
        self.history: dict[str, Array] = {}

    def __reduce__(self) -> Any:
        return type(self), (self.status, self.message), {"history": self.history}

    def __str__(self) -> str:
        return self.message


class NutateValueError(NutateError, ValueError):
    """Error for an invalid argument, body or scene."""


class NutateOSError(NutateError, OSError):
    """Error for a file that cannot be read or written."""


class NutateAccuracyWarning(UserWarning):
    """Warning that a run reached its end but not the requested accuracy, because of round-off or error growth."""


def warn(message: str) -> None:
    """Warns of an accuracy; the line that is shown is the one that called the package."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_globals.get("__package__") == __package__:
        level, frame = level + 1, frame.f_back
    warnings.warn(message, NutateAccuracyWarning, stacklevel=level)


def refusal(message: str) -> NutateValueError:
    """The error of an argument that the library has not seen."""
    return NutateValueError(BAD_ARGUMENT, message)


def failure(status: int, message: str) -> NutateError:
    """The error of a status."""
    if status == IO:
        return NutateOSError(status, message)
    return (NutateValueError if status in (BAD_ARGUMENT, BAD_BODY, BAD_SCENE) else NutateError)(status, message)


def installed_with() -> list[str]:
    """The library that was installed together with this package, if it was: `make install` says where."""
    try:
        return [importlib.import_module("._location", __package__).LIBRARY]
    except ImportError:
        return []


def load() -> ctypes.CDLL:
    """The library, with its functions declared."""
    named = os.environ.get("NUTATE_LIBRARY")
    bundled = os.path.join(os.path.dirname(os.path.abspath(__file__)), BUNDLED)
    places = [named] if named else [*([bundled] if os.path.exists(bundled) else installed_with()), os.path.join(sys.prefix, "lib", SONAME), SONAME]
    reasons = []
    for place in places:
        try:
            library = ctypes.CDLL(place)
            break
        except OSError as error:
            reasons.append(str(error))
    else:
        raise ImportError("nutate: the C library was not found (" + "; ".join(reasons) + "). Build and install it with "
                          "`make install PREFIX=FOLDER` and this package with `pip install FOLDER/share/nutate/python`, "
                          f"or set NUTATE_LIBRARY to the path of {SONAME}.")
    for name, arguments in SIGNATURES.items():
        function = getattr(library, name)
        function.argtypes = arguments
        function.restype = Int
    return library


library = load()


Message = ctypes.c_char * MESSAGE_SIZE
NAME_SIZE = 512
Name = ctypes.c_char * NAME_SIZE


def text_of(function: Any, *arguments: Any) -> str:
    """What a function with (buffer, size) at its end writes there."""
    buffer = Message()
    check(function(*arguments, buffer, MESSAGE_SIZE))
    return buffer.value.decode("utf-8", "replace")


def name_of(function: Any, handle: Any, i: int) -> str:
    """The name that a function with (handle, i, buffer, size) writes."""
    buffer = Name()
    check(function(handle, i, buffer, NAME_SIZE))
    return buffer.value.decode()


def status_text(status: int) -> str:
    """Returns a description of a status code."""
    buffer = ctypes.create_string_buffer(MESSAGE_SIZE)
    library.nutate_status_text(status, buffer, MESSAGE_SIZE)
    return buffer.value.decode()


def version() -> str:
    """Returns the version of the library."""
    return text_of(library.nutate_get_version)


def check(status: int, message: str = "") -> None:
    """Raises NutateError unless the status is NUTATE_OK."""
    if status:
        raise failure(status, message)


def create(function: Any, *arguments: Any) -> ctypes.c_void_p:
    """The handle that a create function makes."""
    handle = ctypes.c_void_p()
    message = Message()
    status = function(*arguments, ctypes.byref(handle), message, MESSAGE_SIZE)
    check(status, message.value.decode("utf-8", "replace"))
    return handle


def encoded(text: Textual) -> bytes:
    """Encodes a string or path for C; rejects embedded NULs."""
    if not isinstance(text, (str, bytes, os.PathLike)):
        raise TypeError(f"{text!r} is not a text (expected str, bytes or a path)")
    data = os.fsencode(text) if isinstance(text, (bytes, os.PathLike)) else text.encode("utf-8", "surrogateescape")
    if b"\0" in data:
        raise refusal(f"{text!r} contains a NUL character (expected text without it)")
    return data


def vector(values: npt.ArrayLike, size: int, name: str) -> Array:
    """A contiguous array of so many doubles."""
    try:
        array = np.ascontiguousarray(values, dtype=np.float64)
    except ValueError as error:
        raise refusal(f"{name} is {values!r} (expected {size} numbers)") from error
    if array.shape != (size,):
        raise refusal(f"{name} has shape {array.shape} (expected {size} numbers)")
    return array


def quaternion(q: Any, name: str = "q") -> Array:
    """Four numbers, scalar first, of such an array or of a Rotation of SciPy."""
    if hasattr(q, "as_quat"):
        return vector(np.roll(q.as_quat(), 1), 4, name) if np.ndim(q.as_quat()) == 1 else vector(q.as_quat(), 4, name)
    return vector(q, 4, name)


def bounds_of(values: Optional[npt.ArrayLike], names: Sequence[str]) -> Optional[list[float]]:
    """The bounds of a callback as floats; None where there are none. Tested before the callback is added."""
    if values is None:
        return None
    bounds = [float(value) for value in vector(values, len(names), "bounds")]
    for name, bound in zip(names, bounds):
        if not (bound == 0 or 1e-300 <= bound <= 1e100):
            raise refusal(f"the bound {name} is {bound} (expected 0 or 1e-300 to 1e100)")
    return bounds


def pointer(array: Optional[Array]) -> Any:
    """What C sees of an array of doubles; None is NULL."""
    if array is None:
        return None
    memory: Any = array
    try:
        # NumPy takes ten times as long to make a pointer.
        return ctypes.c_double.from_buffer(memory)
    except (TypeError, ValueError):
        # Read-only, empty, or not contiguous.
        return array.ctypes.data_as(Doubles)


# Ctrl-C while the library works. Python would run the handler of the signal as soon as a callback enters Python, outside of
# what catches exceptions there: ctypes would print what it raises and go on. So the signal is noted, the run is told to stop
# when it asks, and the handler is called when it has. A second Ctrl-C goes to the handler immediately, for a callback that hangs.
noted: list[Any] = []
waiting: list[Any] = []
# The functions below those of `signal`, whose enumerations take longer than a short run.
raw_signal: Any = importlib.import_module("_signal" if "_signal" in sys.builtin_module_names else "signal")
SIGINT = int(signal.SIGINT)


def note(number: int, frame: Any) -> None:
    """Takes a signal in place of its handler."""
    noted.append((number, frame))
    if len(noted) > 1 and waiting:
        waiting[-1](number, frame)


# Functions that report the progress of a run: called whenever the run polls, the last one first.
ticking: list[Callable[[], Any]] = []


def wants_to_stop(_: Any) -> int:
    """The answer to a run that asks whether to stop."""
    if ticking:
        ticking[-1]()
    return 1 if noted and get_ident() == main_thread().ident else 0


asked = PollCallback(wants_to_stop)


def interruptible(function: Any, *arguments: Any) -> int:
    """The status of a function of the library, which Ctrl-C ends where it asks; raise_interrupt is to follow."""
    handler = raw_signal.getsignal(SIGINT) if get_ident() == main_thread().ident else None
    if not callable(handler) or handler is note:
        return int(function(*arguments))
    waiting.append(handler)
    try:
        raw_signal.signal(SIGINT, note)
        return int(function(*arguments))
    finally:
        raw_signal.signal(SIGINT, handler)
        if not noted:
            waiting.clear()


def raise_interrupt() -> None:
    """Gives a signal that was noted to its handler, which mostly raises KeyboardInterrupt."""
    if not noted or get_ident() != main_thread().ident or raw_signal.getsignal(SIGINT) is note:
        return
    handlers, signals = waiting[:], noted[:]
    waiting.clear()
    noted.clear()
    for number, frame in signals[:1]:
        handlers[0](number, frame)
