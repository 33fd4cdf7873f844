"""Columns of a run as tables of other packages: pandas, xarray."""

from __future__ import annotations

import importlib
import re
from typing import Any, Iterable, Iterator, Mapping, Union

import numpy as np

from ._library import Array, KnownAttributes, doubles, refusal
from ._units import UNITS

# Columns that are components of one quantity: its name and its axis.
VECTORS = (("q", ("q0", "q1", "q2", "q3"), "quaternion"), ("p", ("p0", "p1", "p2", "p3"), "quaternion"),
           ("omega", ("omega1", "omega2", "omega3"), "body_axis"), ("omega_space", ("omega_x", "omega_y", "omega_z"), "space_axis"),
           ("L", ("L1", "L2", "L3"), "body_axis"), ("l", ("l_x", "l_y", "l_z"), "space_axis"))
AXES = {"quaternion": [0, 1, 2, 3], "body_axis": [1, 2, 3], "space_axis": ["x", "y", "z"]}
PATTERNS = [("t", "s")] + [(name.replace("#", r"\d+").replace("*", ".*"), unit) for unit, names in UNITS for name in names.split()]


def unit_of(name: str) -> str:
    """Returns the unit of a column; "1" for one that has none or is not known."""
    plain = re.sub("_deg(?=[/_]|$)", "", name)
    if pair := re.fullmatch(r"covariance_(rotation|omega)\d_(rotation|omega)\d", plain):
        unit = "rad2" + ("", "/s", "/s2")[pair.groups().count("omega")]
    else:
        unit = next((unit for pattern, unit in PATTERNS if re.fullmatch(pattern, plain)), "1")
    return unit if plain == name else unit.replace("rad", "deg")


def stacked(columns: Mapping[str, Array], name: str, numbers: Any) -> Array:
    """Columns NAME with the numbers, side by side."""
    return np.stack([columns[f"{name}{i}"] for i in numbers], axis=-1)


def reject_repeated(names: Iterable[str]) -> None:
    """Raises an error if a name occurs twice, as columns of pandas can."""
    listed = list(names)
    for i, name in enumerate(listed):
        if name in listed[:i]:
            raise refusal(f"there are two columns {name!r} (expected one)")


def columns_of_motion(motion: Mapping[str, Array], wanted: Iterable[str]) -> dict[str, Array]:
    """Columns of a motion as arrays; rejects repeated columns and wrong units in attributes."""
    reject_repeated(motion)
    return {name: doubles(motion[name], f"column {name}", bool(re.search("_deg(?=/|$)", name))) for name in wanted}


class Columns(KnownAttributes, Mapping[str, Array]):
    """Mapping of column names to arrays; the first is "t"."""

    columns: dict[str, Array]
    t: Array

    def __init__(self, columns: Mapping[str, Array]) -> None:
        self.columns = dict(columns)
        self.t = self.columns["t"]

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    def to_pandas(self) -> Any:
        """Returns a DataFrame, as nutate.to_pandas."""
        return to_pandas(self)

    def to_xarray(self) -> Any:
        """Returns a Dataset, as nutate.to_xarray."""
        return to_xarray(self)


def to_pandas(history: Union[Mapping[str, Array], Columns]) -> Any:
    """Converts the columns of a run to a DataFrame of pandas.

    Parameters
    ----------
    history : mapping of arrays
        Columns of a run: of nutate.run, a Stepper or nutate.solve.

    Returns
    -------
    pandas.DataFrame
        Columns by their names; the index is the time, s, and attrs["units"] has the units.

    Raises
    ------
    ImportError
        If pandas is not installed.
    """
    pandas = importlib.import_module("pandas")
    frame = pandas.DataFrame({name: values for name, values in history.items() if name != "t"},
                             index=pandas.Index(np.asarray(history["t"]), name="t"))
    frame.attrs["units"] = {name: unit_of(name) for name in history}
    return frame


def to_xarray(history: Union[Mapping[str, Array], Columns]) -> Any:
    """Converts the columns of a run to a Dataset of xarray.

    Parameters
    ----------
    history : mapping of arrays
        Columns of a run: of nutate.run, a Stepper or nutate.solve.

    Returns
    -------
    xarray.Dataset
        Attitude q, angular velocity omega and momenta with an axis of components, all else column by column, over the time, s;
        attrs["units"] of each has its unit.

    Raises
    ------
    ImportError
        If xarray is not installed.
    """
    xarray = importlib.import_module("xarray")
    rest = {name: values for name, values in history.items() if name != "t"}
    variables: dict[str, Any] = {}
    for name, names, axis in VECTORS:
        if all(part in rest for part in names):
            variables[name] = (("t", axis), np.stack([rest.pop(part) for part in names], axis=-1), {"units": unit_of(names[0])})
    variables.update({name: (("t",), np.asarray(values), {"units": unit_of(name)}) for name, values in rest.items()})
    used = {dimension for dimensions, _, _ in variables.values() for dimension in dimensions}
    axes = {axis: values for axis, values in AXES.items() if axis in used}
    return xarray.Dataset(variables, coords={"t": ("t", np.asarray(history["t"]), {"units": "s"}), **axes})
