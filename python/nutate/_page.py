"""A motion as a web page: the rotating body, the path of its axis or of its centre of mass, the polhode, and curves with a moving
cursor. The page holds all that it needs."""

from __future__ import annotations

import base64
import contextlib
import html
import json
import os
import re
import tempfile
import webbrowser
import zlib
from typing import Any, Callable, Iterable, Mapping, Optional, Sequence, Union

import numpy as np

from ._library import Array, KnownAttributes, NutateValueError, Textual, number, refusal
from .events import History
from .pictures import colour, symbol
from .scenes import Scene
from .shapes import Surface, surface_of, wheel_axes
from .solutions import Solution
from .steppers import Stepper
from .systems import System
from .tables import columns_of_motion, stacked

# Turn between two frames, rad: the one that is aimed at, and the largest; and how many frames there are.
FRAME_TURN, LARGEST_TURN = 0.2, 0.3
LEAST_FRAMES, MOST_FRAMES, OVERVIEW = 240, 8000, 2000
# A centre of mass that is nearer to the reference point, by the size of the body, is not followed.
NEAR = 0.05
# Rates that the eye follows, rad/s, and how long it likes to look, s: a motion in these bounds is shown in real time.
SLOWEST, FASTEST, LONGEST, PLEASANT = 0.3, 12.0, 120.0, 4.0
# Longest name of a file, bytes.
LONGEST_NAME = 255
Rows = Mapping[str, Array]
COLUMNS = ("quaternion", "angular_velocity", "angular_momentum_space", "energy")
SHOWN = r"t|[qL]\d|omega\d|l_[xyz]|lvlh_q\d|roll|pitch|yaw|phi|theta|kinetic|potential|total|work|wheel\d_speed"
MOMENTUM = ("l_x", "l_y", "l_z")
ENERGIES = ("kinetic", "potential", "total", "work")

PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<link rel="icon" href="data:,">
<style>
html, body {{ height: 100%; margin: 0; font: 15px Helvetica, Arial, sans-serif; color: #222; background: #fff; }}
body {{ display: grid; grid-template: auto minmax(0, 3fr) minmax(0, 2fr) / 3fr 2fr; }}
header {{ grid-column: 1 / -1; display: flex; gap: 0.4em 1em; align-items: center; padding: 0.5em 1em; flex-wrap: wrap; }}
h1 {{ font-size: 1.1em; margin: 0; }}
p {{ margin: 0; flex-basis: 100%; font-size: 0.85em; color: #7a3b00; }}
button, select {{ font: inherit; }}
#nutate-slider {{ flex: 1; min-width: 8em; }}
#nutate-time {{ min-width: 8em; font-variant-numeric: tabular-nums; }}
#nutate-body, #nutate-polhode, #nutate-curves > div {{ position: relative; overflow: hidden; }}
#nutate-body, #nutate-polhode {{ background: #f7f8f9; margin: 0 4px; }}
#nutate-curves {{ grid-column: 1 / -1; display: flex; }}
#nutate-curves > div {{ flex: 1; }}
canvas {{ position: absolute; width: 100%; height: 100%; }}
@media (max-width: 700px) {{
  html, body {{ height: auto; }}
  body {{ display: block; }}
  #nutate-body {{ height: 92vw; }}
  #nutate-polhode {{ height: 75vw; }}
  #nutate-curves {{ display: block; }}
  #nutate-curves > div {{ height: 60vw; }}
}}
</style></head>
<body><header><h1>{title}</h1>
<button id="nutate-play" type="button">Play</button>
<select id="nutate-speed" aria-label="speed of the playback"></select>
<input id="nutate-slider" type="range" min="0" value="0" aria-label="time"><span id="nutate-time"></span>
{notes}</header>
<div id="nutate-body"></div><div id="nutate-polhode"></div><div id="nutate-curves"></div>
<script>const motion = {motion};
{script}</script>
</body></html>
"""


class Page(KnownAttributes):
    """Web page that shows a motion, as `nutate.view` makes it; a notebook displays it in its cell.

    Examples
    --------
    >>> page = nutate.view("scenes/box.nml", None, "integrator.end_time=1")
    >>> page.text.startswith("<!DOCTYPE html>")
    True
    """

    text: str
    """Contents of the page, HTML."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return f"<Page of {len(self.text) / 1e6:.1f} MB>"

    def _repr_html_(self) -> str:
        return (f'<iframe srcdoc="{html.escape(self.text)}" style="width: 100%; height: 800px; border: 0" '
                'title="a motion"></iframe>')

    def save(self, path: Textual) -> None:
        """Writes the page to a file, which opens without a network. Symbolic links are followed.

        Parameters
        ----------
        path : str or path
            File, pipe or device.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        name = os.fsdecode(path)
        data = self.text.encode("utf-8", "replace")
        if os.path.exists(name):
            with open(name, "ab") as file:  # raises an error if the file is a folder or may not be written
                if not os.path.isfile(name):
                    file.write(data)
                    return
        name = os.path.realpath(name)
        last = os.path.basename(name)
        partial = name + ".partial"
        if len(os.fsencode(last)) > LONGEST_NAME - len(".partial"):
            partial = os.path.join(os.path.dirname(name), f"{zlib.crc32(os.fsencode(last)):08x}.partial")
        try:
            with open(partial, "wb") as file:
                file.write(data)
            os.replace(partial, name)
        except BaseException:
            with contextlib.suppress(OSError):
                os.remove(partial)
            raise

    def show(self) -> None:
        """Opens the page in a browser."""
        handle, path = tempfile.mkstemp(suffix=".html", prefix="nutate-")
        os.close(handle)
        self.save(path)
        webbrowser.open(f"file://{path}")


def view(motion: Union[Solution, Scene, Rows, Textual], system: Optional[System] = None, *overrides: str,
         title: Optional[str] = None, play: bool = False, begin: float = 0.0, start: Optional[float] = None) -> Page:
    """Makes a web page with an animation of a motion.

    The page shows the body in three dimensions (its shape, or one with its moments of inertia, which a note then names), the
    path of its symmetry axis or of its centre of mass, angular velocity and momentum, the polhode on the inertia ellipsoid,
    curves with a moving cursor, events, reaction wheels and the LVLH frame of an orbit. Between two frames the body rotates by
    less than 0.3 rad, however few rows the scene writes; 8000 frames are animated. Columns of a run are shown as they are.

    Parameters
    ----------
    motion : Solution, Scene, str, path, or dict of arrays
        Solution of `solve`; Scene, or the path of one, which is run; or the columns of a run with the sets quaternion and
        angular_velocity, for a body with wheels or inner spheres also angular_momentum_space.
    system : System
        Body that moved, needed with the columns of a run.
    *overrides : str
        Overrides "GROUP.KEY=VALUE" of a scene file.
    title : str
        Title of the page; default: that of the scene.
    play : bool
        True to start the animation at once.
    begin : float
        Position of the cursor in the animation, 0 to 1.
    start : float
        First time that is animated, s; default: the start of the motion.

    Returns
    -------
    Page
        page.save(path) writes the page, page.show() opens it, and the last line of a notebook cell shows it.

    Raises
    ------
    NutateValueError
        If columns, System or overrides are missing or invalid.

    Examples
    --------
    >>> page = nutate.view("scenes/box.nml", None, "integrator.end_time=1")
    >>> page
    <Page of 0.1 MB>
    """
    scene: Optional[Scene] = None
    events: Sequence[tuple[str, float]] = ()
    begin, start = number(begin, "begin"), None if start is None else number(start, "start")
    if isinstance(motion, (str, bytes, os.PathLike)):
        motion = Scene(motion, *overrides)
    if isinstance(motion, Scene):
        scene, title = motion, title or motion.title
        system = System(scene=motion)
        first = scene_rows(motion, None)
        events = [(event.name, event.t) for event in first.events]
        rows, overview = frames_of(lambda times: scene_rows(scene, times), first, start)
    elif isinstance(motion, Solution):
        system = system or motion.system
        events = [(f"event {i}", float(t)) for i, found in enumerate(motion.t_events) for t in found]
        columns = motion.columns
        if motion._sol is not None and len(motion.t) > 1:
            rows, overview = frames_of(motion.sol.rows, motion.sol.rows(np.linspace(motion.t[0], motion.t[-1], OVERVIEW + 1)), start)
        else:
            rows, overview = columns, columns
    else:
        if "t" not in motion:
            raise refusal("there is no column 't' (expected the times of the rows)")
        shown = [name for name in motion if isinstance(name, str) and name != "t" and re.fullmatch(SHOWN, name)]
        rows = columns_of_motion(motion, ["t", *shown])
        overview = rows
        if start is not None:
            kept = (rows["t"] - start) * np.sign(rows["t"][-1] - rows["t"][0]) >= 0
            rows = {name: values[kept] for name, values in rows.items()}
        events = [(event.name, event.t) for event in getattr(motion, "events", ())]
    if system is None:
        raise refusal("the columns do not name their System (expected view(columns, system))")
    if "q0" not in rows or "omega1" not in rows or len(rows["t"]) < 2:
        raise refusal("too few rows or columns to show (expected at least two rows of quaternion and angular_velocity)")
    surface, assumed = surface_of(system, scene)
    notes = [] if assumed is None else [f"The shape is assumed: a {assumed} with the moments of inertia of the body."]
    return Page(page_of(rows, overview, events, system, surface, scene, title or "nutate", play, begin, notes))


def scene_rows(scene: Scene, times: Optional[Array]) -> History:
    """Returns the rows of a scene at given times, or at many equidistant ones, with all columns that are shown."""
    _, *overrides = scene._given[0]
    facts = scene._given[1]
    end = scene.plan[1]
    times = np.linspace(0.0, end, OVERVIEW + 1) if times is None else times
    with tempfile.NamedTemporaryFile("w", suffix=".csv", prefix="nutate-", delete=False) as file:
        file.write("t (s)\n" + "".join(f"{t!r}\n" for t in times.tolist()))
    output = ["-output.every", "-output.interval", "-output.times", "-output.precision", "output.degrees=.false.",
              "output.times_file='" + file.name.replace("'", "''") + "'"]
    try:
        for columns in column_choices(scene):
            listed = ",".join(f"'{name}'" for name in columns)
            try:
                again = Scene(None, *overrides, *output, f"output.columns={listed}", text=facts["text"], name=facts["name"])
            except NutateValueError:
                if columns == COLUMNS:
                    raise
                continue
            for name, arguments in scene._additions:
                getattr(again, name)(*arguments)
            with again:
                return again.run()
    finally:
        os.unlink(file.name)
    raise AssertionError


def column_choices(scene: Scene) -> list[tuple[str, ...]]:
    """Sets of columns that a scene may have, most of them first."""
    wheels = tuple(f"wheel{i + 1}" for i in range(len(wheel_axes(System(scene=scene), scene))))
    return [COLUMNS + wheels + ("lvlh_attitude",), COLUMNS + wheels, COLUMNS]


def frames_of(run: Callable[[Array], Rows], overview: Rows, start: Optional[float] = None) -> tuple[Rows, Rows]:
    """Rows so near each other that the eye follows the motion, from a time on, and rows over all of it. `run` gives the rows at
    some times."""
    if len(overview["t"]) < 2:
        return overview, overview
    first, last = float(overview["t"][0]), float(overview["t"][-1])
    if start is not None and not min(first, last) <= start <= max(first, last) or start == last:
        raise refusal(f"the animation cannot start at {start:g} s (expected {first:g} to {last:g} s)")
    rows = overview
    for _ in range(4):
        rows = run(times_by_turn(rows["t"], stacked(dict(rows), "omega", range(1, 4)), first if start is None else start))
        if largest_turn(rows) < LARGEST_TURN:
            break
    return rows, overview


def rate_of(rows: Rows) -> Array:
    """Returns the magnitude of the angular velocity, rad/s."""
    return np.asarray(np.linalg.norm(stacked(dict(rows), "omega", range(1, 4)), axis=1))


def times_by_turn(t: Array, omega: Array, start: float) -> Array:
    """Times of frames from a time on: one for each FRAME_TURN that the body rotates, or its angular velocity in the body, and as many
    more that a slow motion is smooth."""
    steps = np.abs(np.diff(t))
    # The greater rate of two rows, as the motion between them may be either.
    rate = np.linalg.norm(omega, axis=1)
    rate = np.maximum(rate[1:], rate[:-1])
    swing = np.linalg.norm(np.diff(omega, axis=0), axis=1) / np.maximum(rate, max(0.05 * rate.max(), 1e-300))
    frames = np.maximum(rate * steps, swing) / FRAME_TURN + LEAST_FRAMES * steps / abs(t[-1] - t[0])
    passed = np.concatenate([[0.0], np.cumsum(frames)])
    sense = np.sign(t[-1] - t[0])
    before = float(np.interp(sense * start, sense * t, passed))
    count = int(np.ceil(passed[-1] - before))
    if count > MOST_FRAMES:
        return np.asarray(np.interp(before + np.arange(MOST_FRAMES + 1.0), passed, t))
    return np.asarray(np.interp(np.linspace(before, passed[-1], max(count, 1) + 1), passed, t))


def largest_turn(rows: Rows) -> float:
    """Returns the largest angle between the attitudes of two rows, rad, or that which follows from the angular velocity."""
    q = stacked(dict(rows), "q", range(4))
    q = q / np.linalg.norm(q, axis=1)[:, None]
    angles = 2 * np.arccos(np.minimum(1.0, np.abs(np.sum(q[1:] * q[:-1], axis=1))))
    rate = rate_of(rows)
    turns = np.minimum(rate[1:], rate[:-1]) * np.abs(np.diff(rows["t"]))
    return float(np.max(np.maximum(angles, turns)))


def factors_of(rows: Rows) -> tuple[float, list[float]]:
    """Returns the speed of the animation, 1: real time, and the speeds that can be chosen."""
    rate = float(np.max(rate_of(rows)))
    span = abs(float(rows["t"][-1] - rows["t"][0]))
    factor = 1.0
    if not (SLOWEST <= rate <= FASTEST and span <= LONGEST):
        factor = nice(min(PLEASANT / rate, span / 4) if rate > 0 else span / 12)
    return factor, sorted({factor * step for step in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)} | {1.0})


def nice(number: float) -> float:
    """Returns the largest 1, 2 or 5 times a power of ten that does not exceed a number."""
    power = 10.0 ** np.floor(np.log10(number))
    best = max(step for step in (1, 2, 5) if step * power <= number * (1 + 1e-9))
    return float(f"{best * power:.3g}")


def path_of(system: System, surface: Surface, rows: Rows) -> dict[str, Any]:
    """Returns the path to draw: that of the centre of mass if it is not near the reference point, else of the axis of symmetry, else of
    the body axis     that is nearest to the angular momentum at the start."""
    center = system.center_of_mass
    if np.linalg.norm(center) > NEAR * surface.size:
        return {"name": "the centre of mass", "point": center, "hangs": True}
    moments, axes = np.linalg.eigh(system.inertia)
    first, second = np.isclose(moments[0], moments[1], rtol=1e-9), np.isclose(moments[1], moments[2], rtol=1e-9)
    if first != second:
        return {"name": "the symmetry axis", "point": axes[:, 2] if first else axes[:, 0], "hangs": False}
    q = np.array([rows[f"q{i}"][0] for i in range(4)]) * (1, -1, -1, -1)
    axis = int(np.argmax(np.abs(rotated(q, np.array([rows[name][0] for name in MOMENTUM])))))
    return {"name": f"axis {axis + 1}", "point": np.eye(3)[axis], "hangs": False}


def rotated(q: Array, u: Array) -> Array:
    """Rotates vectors u by unit quaternions q; shapes (..., 3) and (..., 4)."""
    a, v = q[..., :1], q[..., 1:]
    return np.asarray(u + 2 * np.cross(v, np.cross(v, u) + a * u))


def page_of(rows: Rows, overview: Rows, events: Sequence[tuple[str, float]], system: System,
            surface: Surface, scene: Optional[Scene], title: str, play: bool, begin: float, notes: list[str]) -> str:
    """Returns the text of the page."""
    rows, overview = with_angles(with_momentum(rows, system)), with_angles(overview)
    path = path_of(system, surface, rows)
    factor, factors = factors_of(rows)
    whole, shown = (abs(float(each["t"][-1] - each["t"][0])) for each in (overview, rows))
    if shown < whole * (1 - 1e-9):
        notes.append(f"Of {whole:.4g} s the animation shows {shown:.4g} s, from t = {float(rows['t'][0]):.4g} s on.")
    if largest_turn(rows) >= LARGEST_TURN:
        notes.append(f"The rows are up to {largest_turn(rows):.2g} rad apart: how the body turns between them is not known.")
    panels = panels_of(rows)
    kept = {"t", *(f"{name}{i}" for name, numbers in (("q", range(4)), ("omega", range(1, 4))) for i in numbers), "l_x", "l_y",
            "l_z", *(f"lvlh_q{i}" for i in range(4)), *(curve[0] for panel in panels for curve in panel["curves"])}
    motion = {"rows": packed(rows, kept), "overview": packed(overview, kept) if shown < whole * (1 - 1e-9) else None,
              "events": [{"name": name, "t": t} for name, t in events], "points": surface.points, "corners": surface.corners,
              "colours": surface.colours, "edges": surface.edges, "center": system.center_of_mass, "inertia": system.inertia,
              "path": path, "wheels": wheel_axes(system, scene), "panels": panels, "factor": factor, "factors": factors,
              "begin": begin, "play": play}
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "page.js")
    with open(script, encoding="utf-8") as file:
        return PAGE.format(title=html.escape(title), motion=in_json(motion), script=file.read(),
                           notes="".join(f"<p>{html.escape(note)}</p>" for note in notes))


def with_momentum(rows: Rows, system: System) -> Rows:
    """Returns the rows with the angular momentum, space axes, which attitude and rate do not determine for bodies with wheels or
    inner spheres."""
    if all(name in rows for name in MOMENTUM):
        return rows
    q, omega = stacked(dict(rows), "q", range(4)), stacked(dict(rows), "omega", range(1, 4))
    q = q / np.linalg.norm(q, axis=1)[:, None]
    if all(f"L{i}" in rows for i in (1, 2, 3)):
        return {**rows, **dict(zip(MOMENTUM, rotated(q, stacked(dict(rows), "L", range(1, 4))).T))}
    momenta, stepper = np.empty((len(q), 3)), Stepper(system)
    if stepper.wheels or stepper.spheres:
        raise refusal("the rows lack the angular momentum, which wheels and inner spheres change (expected the columns of "
                      "angular_momentum_space)")
    for i, t in enumerate(rows["t"]):
        stepper.set_state(q[i], omega[i], float(t))
        momenta[i] = stepper.angular_momentum_space
    return {**rows, **dict(zip(MOMENTUM, momenta.T))}


def with_angles(rows: Rows) -> Rows:
    """Returns the rows with the Euler angles φ, between -π and π, and θ, unless they have the angles of the LVLH frame."""
    if "roll" in rows:
        return rows
    q = stacked(dict(rows), "q", range(4))
    axis = rotated(q / np.linalg.norm(q, axis=1)[:, None], np.broadcast_to([0.0, 0.0, 1.0], (len(q), 3)))
    return {**rows, "phi": np.arctan2(axis[:, 0], -axis[:, 1]), "theta": np.arccos(np.clip(axis[:, 2], -1, 1))}


def looks(names: Iterable[str]) -> list[tuple[str, str, str]]:
    """Columns with their colours and symbols."""
    return [(name, colour(name), symbol(name, "unicode")) for name in names]


def panels_of(rows: Rows) -> list[dict[str, Any]]:
    """Returns the panels of curves: the title of each, and column, colour and name of its curves."""
    wheels = [name for name in rows if re.fullmatch(r"wheel\d_speed", name)]
    panels: list[dict[str, Any]] = [
        {"label": "Ω (rad/s)", "curves": looks(f"omega{i}" for i in (1, 2, 3))},
        {"label": "Euler angles (rad)", "wraps": True, "curves": looks(("phi", "theta"))},
        {"label": "energy (J)", "curves": looks(ENERGIES)},
        {"label": "LVLH angles (rad)", "wraps": True,
         "curves": looks(("roll", "pitch", "yaw"))},
        {"label": "wheel speed (rad/s)",
         "curves": looks(wheels)}]
    return [panel for panel in panels if any(curve[0] in rows for curve in panel["curves"])]


def packed(rows: Rows, names: set[str]) -> dict[str, str]:
    """Encodes columns as numbers of four bytes, enough for the eye, in base 64."""
    return {name: base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode() for name, values in rows.items()
            if name in names}


def in_json(value: Any) -> str:
    """Encodes arrays with seven digits, enough for the eye; numbers that are not finite are null. HTML has no marks in it: `<` is `\\u003c`."""

    def plain(item: Any) -> Any:
        if isinstance(item, np.ndarray):
            return plain(item.tolist())
        if isinstance(item, Mapping):
            return {key: plain(each) for key, each in item.items()}
        if isinstance(item, (list, tuple)):
            return [plain(each) for each in item]
        if isinstance(item, np.generic):
            return plain(item.item())
        if isinstance(item, float):
            return float(f"{item:.7g}") if np.isfinite(item) else None
        return item

    text = json.dumps(plain(value), ensure_ascii=False, separators=(",", ":"))
    return re.sub("[<>&\u2028\u2029]", lambda found: f"\\u{ord(found[0]):04x}", text)
