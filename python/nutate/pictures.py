"""Symbols, colours and panels of columns, as in pictures of `nutate plot`, and pictures by matplotlib."""

from __future__ import annotations

import re
import sys
from typing import Any, Iterator, Mapping, NamedTuple, Union

import numpy as np

from ._library import Array, refusal
from ._units import COMPONENTS, GREY, QUANTITIES
from .solutions import Solution
from .tables import columns_of_motion, unit_of

# Columns that a picture has only if they are requested, beside those that show errors.
AUXILIARY = ("p0", "p1", "p2", "p3")
SUBSCRIPTS = dict(zip("0123456789xyz", "₀₁₂₃₄₅₆₇₈₉ₓᵧ_"))
# Angles that jump by a revolution.
WRAPPED = ("roll", "yaw", "pole_longitude")
# Rows of a picture that is drawn from dense output.
POINTS = 2000


class Look(NamedTuple):
    """How a column is drawn."""

    panel: int
    label: str
    symbol: str
    colour: str
    is_residual: bool


def look_of(column: str) -> Look:
    """Returns the look of a column; an unknown column has its own panel."""
    plain = re.sub("_deg(?=/|$)", "", column)
    for names, label, panel, colour, symbols, is_residual in QUANTITIES:
        listed = names.split()
        for i, name in enumerate(listed):
            found = re.fullmatch(name.replace("#", r"(\d+)"), plain)
            if found:
                number = found[1] if "#" in name else ""
                symbol = symbols.split(",")[i] if symbols else name
                return Look(panel, label.replace("#", number), symbol.replace("#", number), colour or component_colour(plain),
                            is_residual)
    return Look(len(QUANTITIES), column, column, component_colour(plain), False)


def component_colour(name: str) -> str:
    """Returns the colour of the component or wheel whose number or letter a name has."""
    wheel = re.match(r"wheel(\d)", name)
    last = wheel[1] if wheel else name[-1]
    place = max("123456".find(last), "xyz".find(last))
    return COMPONENTS[place] if place >= 0 else GREY if last == "0" else COMPONENTS[2]


def symbol(column: str, style: str = "mathtext") -> str:
    """Returns the symbol of a column for legends.

    Parameters
    ----------
    column : str
        Name of a column.
    style : str
        "mathtext" for matplotlib, "html" for plotly, or "unicode".

    Returns
    -------
    str
        Symbol; the name of a column that has none.

    Raises
    ------
    NutateValueError
        If the style is not one of these.

    Examples
    --------
    >>> [nutate.symbol("l_x", style) for style in ("mathtext", "html", "unicode")]
    ['$l_x$', 'l<sub>x</sub>', 'lₓ']
    """
    if style not in ("mathtext", "html", "unicode"):
        raise refusal(f"style is {style!r} (expected mathtext, html or unicode)")
    plain = look_of(column).symbol
    found = re.fullmatch(r"(.+)_(\w)", plain)
    if not found or plain == column and len(found[1]) > 1:
        return plain
    base, index = found.groups()
    if style == "mathtext":
        return f"${base}_{index}$"
    if style == "html":
        return f"{base}<sub>{index}</sub>"
    return base + (SUBSCRIPTS[index] if index != "z" else "_z")


def colour(column: str) -> str:
    """Returns the colour of a column, the same in all pictures.

    Parameters
    ----------
    column : str
        Name of a column.

    Returns
    -------
    str
        Colour as "#rrggbb".

    Examples
    --------
    >>> nutate.colour("omega1"), nutate.colour("total")
    ('#d55e00', '#000000')
    """
    return look_of(column).colour


def plot(motion: Union[Solution, Mapping[str, Array]], *columns: str, residuals: bool = False) -> Any:
    """Draws the columns of a motion by matplotlib, a panel for each quantity.

    `figure.savefig(path)` writes the picture, and the last line of a notebook cell shows it. In a program that has imported
    matplotlib.pyplot, `plt.show()` and `plt.savefig(path)` refer to the figure, too.

    Parameters
    ----------
    motion : Solution, or dict of arrays
        Motion. The columns of a Solution are drawn from its dense output.
    *columns : str
        Columns; default: all but residuals and conjugate momenta, with the energies of a body without potential only if they
        change.
    residuals : bool
        True to draw the errors of the integration, too.

    Returns
    -------
    matplotlib.figure.Figure
        Figure.

    Raises
    ------
    NutateValueError
        If there is no such column.
    ImportError
        If matplotlib is not installed.

    Examples
    --------
    >>> box = nutate.System(shape="box", size=(4, 1, 2), mass=12)
    >>> solution = nutate.solve(box, omega0=(0.1, 0, 10), t_span=(0, 5))
    >>> figure = nutate.plot(solution, "omega1", "omega2", "omega3")
    >>> [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    ['$Ω_1$', '$Ω_2$', '$Ω_3$']
    """
    rows = rows_of(motion)
    for name in columns:
        if name not in rows:
            raise refusal(f"there is no column {name!r} (expected {', '.join(name for name in rows if name != 't')})")
    if "t" not in rows or len(rows) < 2 or not len(rows["t"]):
        raise refusal("there are no rows to plot (expected t and other columns of a run)")
    wanted = list(columns) or usual_columns(rows, residuals)
    rows = columns_of_motion(rows, ["t", *wanted])
    panels: dict[tuple[int, str], list[str]] = {}
    for name in wanted:
        look = look_of(name)
        panels.setdefault((look.panel, titled(look.label, unit_of(name))), []).append(name)
    figure = new_figure(figsize=(9, 1 + 1.6 * len(panels)), layout="constrained")
    drawn = figure.subplots(len(panels), sharex=True, squeeze=False)[:, 0]
    for axes, ((_, title), names) in zip(drawn, sorted(panels.items())):
        for name, style in styles(rows, names):
            axes.plot(*curve(rows, name), style, color=colour(name), label=symbol(name), linewidth=1.3)
        axes.set_title(title, loc="left", fontsize="medium")
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False)
        axes.grid(color="#dddddd")
        axes.spines[["top", "right"]].set_visible(False)
    drawn[-1].set_xlabel("t (s)")
    return figure


def new_figure(**options: Any) -> Any:
    """Returns a figure, which pyplot manages if the program uses it. A notebook would show such a figure twice."""
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is not None and "inline" not in pyplot.get_backend().lower():
        return pyplot.figure(**options)
    from matplotlib.figure import Figure
    return Figure(**options)


def rows_of(motion: Union[Solution, Mapping[str, Array]]) -> Mapping[str, Array]:
    """Returns the columns; rows of a solution are close enough for smooth curves."""
    if isinstance(motion, Solution) and motion._sol is not None and len(motion.t) > 1:
        return motion._sol.rows(np.linspace(motion.t[0], motion.t[-1], POINTS + 1))
    return motion


def titled(label: str, unit: str) -> str:
    """Returns the title of a panel, with its unit."""
    return label if unit == "1" else f"{label} ({unit.replace('deg', '°').replace('m2', 'm²')})"


def usual_columns(rows: Mapping[str, Array], residuals: bool) -> list[str]:
    """Returns the columns that `nutate plot` draws."""
    names = [name for name in rows if name not in ("t", *AUXILIARY) and (residuals or not look_of(name).is_residual)]
    if any(name.startswith("theta") for name in names):
        names = [name for name in names if not re.fullmatch("q[0-3]", name)]
    silent = {name for name in ("work", "potential") if name in rows and not np.any(rows[name])}
    if "potential" in silent:
        silent.add("total")
        if "kinetic" in rows and np.ptp(rows["kinetic"]) <= 1e-9 * np.max(rows["kinetic"]):
            silent.add("kinetic")
    return [name for name in names if name not in silent] or names


def curve(rows: Mapping[str, Array], name: str) -> tuple[Array, Array]:
    """Returns times and values of a curve, which is broken where an angle wraps."""
    t, values = np.asarray(rows["t"], float), np.asarray(rows[name], float)
    if name.removesuffix("_deg") not in WRAPPED:
        return t, values
    breaks = 1 + np.flatnonzero(np.abs(np.diff(values)) > (270 if name.endswith("_deg") else 1.5 * np.pi))
    return np.insert(t, breaks, t[breaks]), np.insert(values, breaks, np.nan)


def styles(rows: Mapping[str, Array], names: list[str]) -> Iterator[tuple[str, str]]:
    """Columns of a panel and their line styles: one that coincides with others is dashed."""
    span = np.ptp([rows[name] for name in names])
    for i, name in enumerate(names):
        same = sum(bool(np.mean(np.abs(rows[name] - rows[other]) <= 0.012 * span) >= 0.5) for other in names[:i])
        yield name, ("-", "--", ":", "-.")[min(same, 3)]
