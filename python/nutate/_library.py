"""Finds the C library, declares its functions, and turns its statuses into exceptions."""

from __future__ import annotations

import ctypes
import difflib
import importlib
import operator
import os
import re
import signal
import sys
import warnings
from threading import get_ident, main_thread
from typing import Any, Callable, Mapping, Optional, Sequence, Union

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

# Functions by their arguments, as include/nutate.h has them, without `nutate_` before the names; every one returns a status.
SIGNATURES: list[tuple[tuple[Any, ...], str]] = [
    ((Text, Size), "get_version"),
    ((Int, Text, Size), "status_text"),
    ((Handle, Text, Size), "last_message scene_get_title stepper_restore stepper_column_names"),
    ((Doubles, Double, Doubles, Int, HandlePointer, Text, Size), "system_create_moments system_create_tensor"),
    ((Text, Doubles, Size, Double, Double, Doubles, HandlePointer, Text, Size), "system_create_shape"),
    ((Text, HandlePointer, Text, Size), "system_parse"),
    ((Handle, HandlePointer, Text, Size), "system_copy scene_system scene_run stepper_create stepper_create_scene stepper_copy"),
    ((HandlePointer,), "system_destroy scene_destroy bodies_destroy history_destroy stepper_destroy"),
    ((Handle, Doubles, Doubles, Doubles), "system_body fit_start fit_evaluate"),
    ((Handle, Text), "system_add_groups stepper_add_events stepper_set_columns"),
    ((Handle, Doubles, PotentialCallback, HessianCallback, ctypes.c_void_p), "system_add_potential scene_add_potential"),
    ((Handle, TorqueCallback, ctypes.c_void_p), "system_add_user_torque scene_add_user_torque"),
    ((Handle, Double, Double, Double), "system_bound_potential scene_bound_potential"),
    ((Handle, Double, Double, Double, Double), "system_bound_torque scene_bound_torque"),
    ((Handle, Size, Doubles, Doubles, Text), "system_add_table"),
    ((Handle, Doubles, Double, Doubles), "system_add_earth_field"),
    ((Handle, Doubles, Doubles, Text, Double, Double), "system_add_force"),
    ((Handle, Doubles, Double, Double, Double, Double, Double), "system_add_wheel"),
    ((Handle, Sizes),
     "system_wheel_count stepper_event_count stepper_wheel_count stepper_sphere_count stepper_width"),
    ((Handle, Size, Double, Double, Double, Double, Double), "system_add_motor"),
    ((Handle, Size, Size, Doubles, Doubles, Text), "system_add_motor_table"),
    ((Text, ctypes.POINTER(Text), Size, HandlePointer, Text, Size), "scene_read"),
    ((Text, Text, ctypes.POINTER(Text), Size, HandlePointer, Text, Size), "scene_parse"),
    ((Handle, Text, Text, Size), "scene_get scene_write stepper_get"),
    ((Handle, Doubles),
     "system_frame_rate stepper_jacobi stepper_time_dependent_work stepper_time stepper_quaternion stepper_conjugate_momentum "
     "stepper_angular_velocity stepper_angular_velocity_space stepper_angular_momentum stepper_angular_momentum_space "
     "stepper_matrix stepper_euler stepper_energy stepper_constraints stepper_accuracy"),
    ((Handle, Size, Doubles, Doubles), "system_space_axes"),
    ((Text, Text, Double, Text, Size), "date"),
    ((Text, Text, Size, Doubles, Doubles), "tdb"),
    ((Text, Text, Size, Doubles, Doubles, Doubles, Text, Double, Text, Size), "write_aem"),
    ((Text, Text, Size, Doubles, Doubles, Double, Text, Size), "write_gltf"),
    ((Text, HandlePointer, Text, Size, Text, Size), "read_aem"),
    ((Handle, Text, Size, Text, Size), "scene_equilibria"),
    ((Handle, Double, Text, Size, Text, Size), "scene_linearize"),
    ((Handle, Sizes, Sizes), "fit_size"),
    ((Handle, Size, Text, Size), "fit_name history_name"),
    ((Handle, Doubles, Doubles), "fit_cost stepper_orbit stepper_lvlh_attitude scene_get_initial"),
    ((Handle, Doubles, Doubles, ctypes.POINTER(Int), Text, Size), "fit_solve"),
    ((Handle, ctypes.POINTER(Long), Sizes), "sweep_size"),
    ((Handle, Size, ctypes.POINTER(Int), Text, Size), "sweep_field"),
    ((Handle, ctypes.POINTER(Text), Size, Doubles, Size, Text, Size), "sweep_table"),
    ((Handle, Long, Long, Int, ctypes.c_void_p, Size, Text, Size), "sweep_members"),
    ((HandlePointer, Size, Int, HandlePointer, Text, Size), "bodies_create"),
    ((Handle, Int), "bodies_set_threads"),
    ((Handle, Size, Address, Double, Address, Address, Address), "bodies_step bodies_kick"),
    ((Handle, Size, Address, Double, Address, Address), "bodies_drift"),
    ((Handle, Size, Address, Sizes), "bodies_failed"),
    ((Handle, Doubles, Size), "history_values stepper_row"),
    ((Handle, ctypes.POINTER(Long)), "stepper_uncertified"),
    ((Handle, Address, Address), "history_summary"),
    ((Handle, Sizes, Doubles, Doubles, Doubles, Doubles), "history_chaos"),
    ((Handle, Size, Text, Size, ctypes.POINTER(Long), Doubles, Doubles, Doubles), "history_event stepper_event"),
    ((Handle, Text, Text), "stepper_set"),
    ((Handle, Double), "stepper_set_time_step stepper_step"),
    ((Handle, Double, Address, Address), "stepper_set_state stepper_set_canonical"),
    ((Handle, Double, Doubles, Doubles), "stepper_state_at"),
    ((Handle,), "stepper_prepare stepper_keep_steps"),
    ((Handle, Address), "stepper_run_rows"),
    ((Handle, Double, Doubles, Doubles, Doubles, Double, Size, Doubles, Doubles), "stepper_dense_output"),
    ((Handle, Double, Long, ctypes.POINTER(Long)), "stepper_steps"),
    ((Handle, Long, Long, Doubles, Size, Sizes), "stepper_run"),
    ((Handle, QuantityCallback, ctypes.c_void_p, Text), "stepper_add_event"),
    ((Handle, Size, Doubles, Doubles, Doubles), "stepper_wheel"),
    ((Handle, Size, Doubles, Doubles, Doubles, Doubles), "stepper_sphere"),
    ((Handle, Size, Double), "stepper_set_motor"),
    ((Handle, Handle), "stepper_differentiate stepper_follow_chaos"),
    ((Handle, PollCallback, ctypes.c_void_p), "stepper_set_poll scene_set_poll"),
    ((Handle, Text, Size, Sizes), "stepper_save"),
    ((Handle, ctypes.POINTER(Int), Doubles), "stepper_conserved stepper_solver"),
    ((Handle, Doubles, Doubles, ctypes.POINTER(Long)), "scene_get_plan"),
    ((Doubles, Doubles),
     "matrix_from_quat quat_from_matrix euler_from_quat follow_euler quat_from_euler quat_from_rotation_vector "
     "rotation_vector_from_quat quat_normalized"),
    ((Doubles, Doubles, Doubles),
     "omega_from_euler_rates axis_angle_from_quat quat_product rotate_to_space rotate_to_body attitude_distance"),
    ((Doubles, Double, Doubles), "quat_from_axis_angle"),
    ((Handle, Doubles, Doubles, Size, Doubles, Doubles, Doubles), "exact_free_body"),
]
NOT_CONVERGED, OFF_BRANCH, SINGULAR, NOT_FINITE, BAD_ARGUMENT, BAD_BODY, BAD_SCENE, IO, STEP_LIMIT, BAD_HANDLE = range(1, 11)


class KnownAttributes:
    """Rejects values for public attributes that the class does not have, such as misspelt ones. Classes that a program derives may add
    some."""

    _known: Optional[frozenset[str]] = None

    def __init_subclass__(cls, **keys: Any) -> None:
        super().__init_subclass__(**keys)
        names = (key for each in cls.__mro__ for key in (*vars(each), *getattr(each, "__annotations__", ())))
        cls._known = frozenset(key for key in names if key[0] != "_") if cls.__module__.partition(".")[0] == __package__ else None

    def __setattr__(self, name: str, value: Any) -> None:
        known = self._known
        if known is not None and name not in known and name[0] != "_":
            nearest = "".join(f"; nearest: {key}" for key in difflib.get_close_matches(name, sorted(known), n=1))
            raise AttributeError(f"a {type(self).__name__} has no attribute {name!r} (expected one of {', '.join(sorted(known))}{nearest})")
        super().__setattr__(name, value)


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
    """Returns the error of an argument that the library has not seen."""
    return NutateValueError(BAD_ARGUMENT, message)


def failure(status: int, message: str) -> NutateError:
    """Returns the error of a status."""
    if status == IO:
        return NutateOSError(status, message)
    return (NutateValueError if status in (BAD_ARGUMENT, BAD_BODY, BAD_SCENE) else NutateError)(status, message)


def installed_with() -> list[str]:
    """Returns the library that was installed with this package, if any: at the path of `make install`, or beside the package if moved."""
    try:
        beside = os.path.join(os.path.dirname(os.path.abspath(__file__)), *[os.pardir] * 4, "lib", SONAME)
        return [importlib.import_module("._location", __package__).LIBRARY, beside]
    except ImportError:
        return []


def load() -> ctypes.CDLL:
    """Returns the library, with its functions declared."""
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
    for arguments, names in SIGNATURES:
        for name in names.split():
            function = getattr(library, f"nutate_{name}")
            function.argtypes = arguments
            function.restype = Int
    return library


library = load()


Message = ctypes.c_char * MESSAGE_SIZE
NAME_SIZE = 512
Name = ctypes.c_char * NAME_SIZE


def text_of(function: Any, *arguments: Any) -> str:
    """Returns the string that a function with (buffer, size) at its end writes."""
    buffer = Message()
    check(function(*arguments, buffer, MESSAGE_SIZE))
    return buffer.value.decode("utf-8", "replace")


def name_of(function: Any, handle: Any, i: int) -> str:
    """Returns the name that a function with (handle, i, buffer, size) writes."""
    buffer = Name()
    check(function(handle, i, buffer, NAME_SIZE))
    return buffer.value.decode()


def status_text(status: int) -> str:
    """Returns a description of a status code."""
    return text_of(library.nutate_status_text, status)


def version() -> str:
    """Returns the version of the library."""
    return text_of(library.nutate_get_version)


def check(status: int, message: str = "") -> None:
    """Raises NutateError unless the status is NUTATE_OK."""
    if status:
        raise failure(status, message)


def answer(function: Any, *arguments: Any) -> tuple[int, str]:
    """Status and message of a function with (message, size) at its end; of `interruptible` and such a function likewise."""
    message = Message()
    status = function(*arguments, message, MESSAGE_SIZE)
    return status, message.value.decode("utf-8", "replace")


def create(function: Any, *arguments: Any) -> ctypes.c_void_p:
    """Returns the handle that a create function makes."""
    handle = ctypes.c_void_p()
    check(*answer(function, *arguments, ctypes.byref(handle)))
    return handle


def encoded(text: Textual) -> bytes:
    """Encodes a string or path for C; rejects embedded NULs."""
    if isinstance(text, str):
        data = text.encode("utf-8", "surrogateescape")
    elif isinstance(text, (bytes, os.PathLike)):
        data = os.fsencode(text)
    else:
        raise TypeError(f"{text!r} is not a text (expected str, bytes or a path)")
    if b"\0" in data:
        raise refusal(f"{text!r} contains a NUL character (expected text without it)")
    return data


FLOAT = np.dtype(np.float64)
# Types of numbers in a list that are nothing but numbers.
PLAIN = frozenset((float, int, bool, np.float64, np.int64))


# Units that xarray and pandas may name in attrs: coherent ones of the SI, with powers, and those of angles where degrees are expected.
WORDS = (r"(?:rad(?:ians?)?|s(?:ec(?:onds?)?)?|m(?:et(?:er|re)s?)?|kg|kilograms?|N|newtons?|Nms?|J|joules?|W|watts?|Pa|T|teslas?|A|amperes?|"
         r"C|coulombs?|V|volts?|dimensionless|per|unit|or)")
SI_UNITS = re.compile(rf"1?(?:[\s.·⋅*/()]|{WORDS}(?:(?:\s*(?:\^|\*\*)\s*)?[-+⁻]?[\d¹²³])?(?![^\W_]))*")
DEGREE_UNITS = re.compile(r"(?:(?:°|deg(?:rees?)?)(?:\s*(?:/|per|\*)?\s*s(?:ec(?:onds?)?)?(?:(?:\^|\*\*)?-1)?)?(?:\s+per unit)?)?")


def attributed_units(values: Any) -> list[str]:
    """Returns the units in the attributes of an object of xarray, pandas or h5py; pandas has those of all columns by their names."""
    named = values.attrs.items() if hasattr(values.attrs, "items") else ()
    units = next((unit for key, unit in named if str(key).lower() in ("unit", "units")), None)
    if isinstance(units, Mapping):
        names = getattr(values, "columns", None)
        return [str(units.get(name, "")) for name in ([getattr(values, "name", None)] if names is None else names)]
    if isinstance(units, np.ndarray) and units.size == 1:
        units = units.item()
    return ["" if units is None else units.decode() if isinstance(units, bytes) else str(units)]


def names_degrees(values: Any) -> bool:
    """Returns true for an object whose attributes name degrees, or degrees per second."""
    return hasattr(values, "attrs") and any(unit.strip() and DEGREE_UNITS.fullmatch(unit.strip()) for unit in attributed_units(values))


def is_expected(unit: str, degrees: bool) -> bool:
    """Returns true for a coherent unit of the SI; if `degrees`, angles and their rates are in degrees instead of radians."""
    return bool(SI_UNITS.fullmatch(unit) and not (degrees and "rad" in unit) or degrees and DEGREE_UNITS.fullmatch(unit))


def refuse_units(values: Any, name: str, degrees: Optional[bool] = False) -> None:
    """Rejects quantities of astropy, pint and unyt, also in lists, since NumPy would ignore their unit, and masked values in lists. A unit
    in attributes must be one of the SI, or degrees if `degrees` is true; if it is None, any unit is accepted."""
    if type(values) in (tuple, list):
        if PLAIN.issuperset(map(type, values)):
            return
        for value in values:
            refuse_units(value, name, degrees)
            if np.ma.is_masked(value):
                raise refusal(f"{name} has masked values (expected real numbers)")
        return
    # An xarray.DataArray shows its attributes, and those of a history have the unit that is expected.
    if hasattr(values, "attrs"):
        for unit in attributed_units(values):
            if degrees is not None and not is_expected(unit.strip(), degrees):
                raise refusal(f"{name} has the unit {unit!r} (expected {'degrees' if degrees else 'SI units and radians'}; "
                              "convert it, and correct attrs['units'])")
        values = getattr(values, "data", None)
    if getattr(values, "unit", None) is not None or getattr(values, "units", None) is not None:
        raise refusal(f"{name} has a unit (expected numbers without one, in the documented unit)")


def doubles(values: Any, name: str, degrees: Optional[bool] = False) -> Array:
    """Returns a contiguous array of doubles. Masked, complex and calendar values are rejected: NumPy would convert what is under the mask,
    the real part, and a count of some unit of time; quantities with a unit, too."""
    if type(values) is np.ndarray and values.dtype is FLOAT:
        return np.asarray(values, order="C")
    if type(values) in (tuple, list) and PLAIN.issuperset(map(type, values)):
        try:
            return np.array(values, dtype=FLOAT)
        except OverflowError:
            pass  # An integer that no double can hold: refused below.
    refuse_units(values, name, degrees)
    try:
        array: Any = np.asarray(values)
        if array.dtype.kind == "O":
            refuse_units(array.ravel().tolist(), name, degrees)
        whole = np.asarray(array.real, dtype=FLOAT, order="C")
    except NutateValueError:
        raise
    except (ValueError, OverflowError) as error:
        raise refusal(f"{name} is {shown(values)} (expected numbers)") from error
    kind = "masked" if np.ma.is_masked(values) else {"c": "complex", "m": "calendar", "M": "calendar"}.get(array.dtype.kind)
    if kind:
        raise refusal(f"{name} has {kind} values (expected real numbers)")
    return whole


def number(value: Any, name: str) -> float:
    """Returns a float. Rejects what `doubles` rejects: `float` would ignore units, imaginary parts and masks."""
    if isinstance(value, float):
        return float(value)
    if isinstance(value, (np.ndarray, np.generic)):
        value = doubles(value, name)
    if not isinstance(value, int):
        refuse_units(value, name)
    try:
        return float(value)
    except (ValueError, OverflowError) as error:
        raise refusal(f"{name} is {shown(value)} (expected a number)") from error


# Largest numbers that C's int and int64_t hold: ctypes would cut off what is above.
GREATEST_INT, GREATEST_LONG = 2**31 - 1, 2**63 - 1


def whole(value: Any, name: str, least: int, greatest: int = GREATEST_LONG) -> int:
    """Returns an integer in its range."""
    n = operator.index(value)
    if not least <= n <= greatest:
        raise refusal(f"{name} is {shown(n)} (expected {least} to {greatest})")
    return n


def digits(value: Any, name: str) -> str:
    """Returns an integer as a scene file writes it."""
    try:
        return str(int(value))
    except ValueError as error:
        raise refusal(f"{name} is too large to be written (expected fewer digits)") from error


def shown(value: Any) -> str:
    """Returns a value as text for messages. Python refuses to write integers of more than some thousand digits."""
    try:
        return repr(value)
    except ValueError:
        return "too large to be written"


def vector(values: npt.ArrayLike, size: int, name: str, degrees: bool = False) -> Array:
    """Returns a contiguous array of so many doubles."""
    array = doubles(values, name, degrees)
    if array.shape != (size,):
        raise refusal(f"{name} has shape {array.shape} (expected {size} numbers)")
    return array


def refuse_order(values: Any, name: str, orders: tuple[str, str] = ("wxyz", "0123")) -> None:
    """Rejects four components whose labels, the columns or the index of pandas, or the coordinate of xarray, end in other orders."""
    labels = getattr(values, "columns", None)
    if labels is None:
        labels = getattr(values, "index", None)
    if hasattr(values, "dims") and hasattr(values, "coords"):
        labels = values.coords[values.dims[-1]] if values.dims and values.dims[-1] in values.coords else None
    if labels is None or callable(labels) or len(labels) != 4:
        return
    texts = [str(label) for label in np.asarray(labels).tolist()]
    ends = "".join(text[-1:].lower() for text in texts)
    # Labels without letters number the components; they do not name them.
    if any(text.strip().isdigit() for text in texts):
        return
    if ends not in orders and "".join(sorted(ends)) in ("wxyz", "0123"):
        raise refusal(f"{name} has components in the order {', '.join(texts)} "
                      f"(expected {', '.join(orders[0])}: scalar {'first' if orders[0][0] == 'w' else 'last'})")


def quaternion(q: Any, name: str = "q") -> Array:
    """Returns four numbers, scalar first, of an array or of a Rotation of SciPy."""
    if type(q) not in (np.ndarray, tuple, list):
        refuse_order(q, name)
    if type(q) is not np.ndarray and hasattr(q, "as_quat"):
        return vector(np.roll(q.as_quat(), 1), 4, name) if np.ndim(q.as_quat()) == 1 else vector(q.as_quat(), 4, name)
    return vector(q, 4, name)


def bounds_of(values: Optional[npt.ArrayLike], names: Sequence[str]) -> Optional[list[float]]:
    """Returns the bounds of a callback as floats, or None; they are tested before the callback is added."""
    if values is None:
        return None
    bounds = [float(value) for value in vector(values, len(names), "bounds")]
    for name, bound in zip(names, bounds):
        if not (bound == 0 or 1e-300 <= bound <= 1e100):
            raise refusal(f"the bound {name} is {bound} (expected 0 or 1e-300 to 1e100)")
    return bounds


def pointer(array: Optional[Array]) -> Any:
    """Returns a pointer to an array of doubles for C; NULL for None."""
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
get_handler, set_handler = raw_signal.getsignal, raw_signal.signal
SIGINT = int(signal.SIGINT)


def note(number: int, frame: Any) -> None:
    """Notes a signal instead of its handler."""
    noted.append((number, frame))
    if len(noted) > 1 and waiting:
        waiting[-1](number, frame)


# Functions that report the progress of a run: called whenever the run polls, the last one first.
ticking: list[Callable[[], Any]] = []


def wants_to_stop(_: Any) -> int:
    """Returns the answer of the poll callback: 1 to stop the run."""
    if ticking:
        ticking[-1]()
    return 1 if noted and get_ident() == main_thread().ident else 0


asked = PollCallback(wants_to_stop)


def interruptible(function: Any, *arguments: Any) -> int:
    """Returns the status of a function of the library, which Ctrl-C ends at its next poll; call raise_interrupt afterwards."""
    handler = get_handler(SIGINT)
    status: int
    if handler is note or not callable(handler):
        status = function(*arguments)
        return status
    try:
        set_handler(SIGINT, note)
    except ValueError:
        # Signals go to the main thread, which this is not.
        status = function(*arguments)
        return status
    waiting.append(handler)
    try:
        status = function(*arguments)
        return status
    finally:
        set_handler(SIGINT, handler)
        if not noted:
            waiting.clear()


def raise_interrupt() -> None:
    """Gives a signal that was noted to its handler, which mostly raises KeyboardInterrupt."""
    if not noted or get_ident() != main_thread().ident or get_handler(SIGINT) is note:
        return
    handlers, signals = waiting[:], noted[:]
    waiting.clear()
    noted.clear()
    for number, frame in signals[:1]:
        handlers[0](number, frame)
