"""A motion as a web page: the body that turns, its axes, the polhode and curves with a moving cursor. Drawn by plotly, the extra
`view` of the package; the page holds all that it needs."""

from __future__ import annotations

import html
import importlib
import json
import os
import re
import tempfile
import webbrowser
from typing import Any, Mapping, Optional, Union

import numpy as np

from ._library import Array, Textual, refusal
from .scenes import Scene
from .shapes import Surface, surface_of
from .solutions import Solution, stacked
from .systems import System

FRAMES, POINTS, LOOP = 1500, 4000, 12.0
# Turn between two frames that the eye follows, rad.
FRAME_TURN = 0.15
COLUMNS = "output.columns='quaternion','angular_velocity','angular_momentum_space','energy'"
COLOURS = {"axis 3": "#333333", "ω": "#d55e00", "l": "#009e73", "path": "#0b3c5d"}
CURVE_COLOURS = ("#0b3c5d", "#d55e00", "#009e73", "#e69f00", "#56b4e9")

PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<link rel="icon" href="data:,">
<style>
html, body {{ height: 100%; margin: 0; font: 15px Helvetica, Arial, sans-serif; color: #222; background: #fff; }}
body {{ display: grid; grid-template: auto minmax(0, 3fr) minmax(0, 2fr) / 3fr 2fr; }}
header {{ grid-column: 1 / 3; display: flex; gap: 1em; align-items: center; padding: 0.5em 1em; flex-wrap: wrap; }}
h1 {{ font-size: 1.1em; margin: 0; }}
#nutate-slider {{ flex: 1; min-width: 10em; }}
#nutate-time {{ min-width: 9em; font-variant-numeric: tabular-nums; }}
#nutate-curves {{ grid-column: 1 / 3; }}
</style></head>
<body><header><h1>{title}</h1>
<button id="nutate-play" type="button">Play</button>
<label>speed <select id="nutate-speed">
<option value="0.1">0.1</option><option value="0.3">0.3</option><option value="1" selected>1</option>
<option value="3">3</option></select></label>
<input id="nutate-slider" type="range" min="0" value="0" aria-label="time"><span id="nutate-time"></span></header>
<div id="nutate-body"></div><div id="nutate-polhode"></div><div id="nutate-curves"></div>
<script>{plotly}</script>
<script>const motion = {motion}, figures = {figures};
{script}</script>
</body></html>
"""


class Page:
    """A web page that shows a motion; a notebook shows it in its cell."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return f"<Page of {len(self.text) / 1e6:.1f} MB>"

    def _repr_html_(self) -> str:
        return (f'<iframe srcdoc="{html.escape(self.text)}" style="width: 100%; height: 800px; border: 0" '
                'title="a motion"></iframe>')

    def save(self, path: Textual) -> None:
        """Writes it into a file, which opens without a network."""
        partial = os.fspath(os.fsdecode(path)) + ".partial"
        with open(partial, "w", encoding="utf-8") as file:
            file.write(self.text)
        os.replace(partial, os.fsdecode(path))

    def show(self) -> None:
        """Opens it in a browser."""
        handle, path = tempfile.mkstemp(suffix=".html", prefix="nutate-")
        os.close(handle)
        self.save(path)
        webbrowser.open(f"file://{path}")


def view(motion: Union[Solution, Scene, Mapping[str, Array], Textual], system: Optional[System] = None, *overrides: str,
         title: Optional[str] = None, play: bool = False, begin: float = 0.0) -> Page:
    """A web page with the body turning in three dimensions (its shape, or the box of its inertia), the paths of its axis 3, of the
    angular velocity and of the angular momentum, the polhode on the inertia ellipsoid, and curves with a moving cursor.

    motion    a Solution of nutate.solve; a Scene, or the path of one with `overrides`, which is run; or the columns of a run
              with the sets quaternion and angular_velocity, together with the System that moved
    play      whether it moves at once; begin: where it starts, 0 to 1

    page.save(path) writes it, page.show() opens it, and the last line of a notebook cell shows it."""
    scene = None
    if isinstance(motion, (str, bytes, os.PathLike)):
        motion = Scene(motion, *overrides)
    if isinstance(motion, Scene):
        scene, title = motion, title or motion.title
        columns: Mapping[str, Array] = shown_columns(motion)
        system = System(scene=motion)
    elif isinstance(motion, Solution):
        columns, system = frames_of(motion), system or motion.system
    else:
        columns = motion
    if system is None:
        raise refusal("the System that moved is needed to draw it (expected view(columns, system))")
    if "q0" not in columns or "omega1" not in columns or len(columns["t"]) < 2:
        raise refusal("there is nothing to show (expected two rows of quaternion and angular_velocity)")
    return Page(page_of(columns, system, surface_of(system, scene), title or "nutate", play, begin))


def shown_columns(scene: Scene) -> dict[str, Array]:
    """The rows of a scene, with the columns that are shown."""
    _, *overrides = scene._given[0]
    facts = scene._given[1]
    again = Scene(None, *overrides, COLUMNS, "output.degrees=.false.", text=facts["text"], name=facts["name"])
    for name, arguments in scene._additions:
        getattr(again, name)(*arguments)
    with again:
        return again.run()


def frames_of(solution: Solution) -> Mapping[str, Array]:
    """Rows at even times, near enough for the eye, where the motion between the rows is known."""
    if solution.sol is None or len(solution.t) < 2:
        return solution
    turn = np.linalg.norm(solution.omega, axis=1).max() * abs(solution.t[-1] - solution.t[0])
    count = int(min(FRAMES, max(200.0, turn / FRAME_TURN)))
    return solution.sol.rows(np.linspace(solution.t[0], solution.t[-1], count))


def thinned(count: int, most: int) -> Any:
    """Places of at most so many rows, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


def page_of(columns: Mapping[str, Array], system: System, surface: Surface, title: str, play: bool, begin: float) -> str:
    """The text of the page."""
    plotly = importlib.import_module("plotly.offline")
    chosen = thinned(len(columns["t"]), FRAMES)
    rows = {name: np.asarray(values)[chosen] for name, values in columns.items()}
    frames = Frames(rows, system, surface)
    points = thinned(len(columns["t"]), POINTS)
    curves, cursors = curves_of({name: np.asarray(values)[points] for name, values in columns.items()})
    span = abs(float(rows["t"][-1] - rows["t"][0]))
    motion = {"t": rows["t"], "q": frames.q, "axis": frames.axis, "omega": frames.omega, "momentum": frames.momentum,
              "polhode": frames.polhode, "mesh": surface.points.T, "edges": surface.edges.T, "cursors": cursors,
              "rate": span / LOOP, "begin": begin, "play": play}
    figures = {"body": body_figure(frames, surface), "polhode": polhode_figure(frames, system.inertia), "curves": curves}
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "page.js")
    with open(script, encoding="utf-8") as file:
        return PAGE.format(title=html.escape(title), plotly=plotly.get_plotlyjs(), motion=in_json(motion),
                           figures=in_json(figures), script=file.read())


class Frames:
    """What moves: attitudes, arrows in space and the point of the polhode, frame by frame; arrows are as long as suits the
    picture."""

    def __init__(self, rows: Mapping[str, Array], system: System, surface: Surface) -> None:
        self.q = stacked(dict(rows), "q", range(4))
        a, v = self.q[:, :1], self.q[:, 1:]

        def to_space(u: Array) -> Array:
            return np.asarray(u + 2 * np.cross(v, np.cross(v, u) + a * u))

        omega = stacked(dict(rows), "omega", range(1, 4))
        inertia = system.inertia
        momentum = to_space(omega @ inertia.T)
        if "l_x" in rows:
            momentum = np.stack([rows[name] for name in ("l_x", "l_y", "l_z")], axis=-1)
        self.reach = 1.6 * surface.size
        self.axis = self.reach * to_space(np.broadcast_to([0.0, 0.0, 1.0], omega.shape))
        self.omega = self._scaled(to_space(omega))
        self.momentum = self._scaled(momentum)
        # On the ellipsoid x.Jx = 1, whatever becomes of the energy.
        length = np.sqrt(np.einsum("ni,ij,nj->n", omega, inertia, omega))
        self.polhode = omega / np.where(length > 0, length, 1.0)[:, None]

    def _scaled(self, vectors: Array) -> Array:
        longest = float(np.linalg.norm(vectors, axis=1).max())
        return vectors * (self.reach / longest if longest > 0 else 1.0)


def axes3d(reach: float, names: tuple[str, str, str]) -> dict[str, Any]:
    """The axes of a picture in three dimensions."""
    ranges = {"range": [-reach, reach], "showspikes": False, "backgroundcolor": "#f6f6f6", "gridcolor": "#dddddd",
              "showticklabels": False}
    return {**{f"{axis}axis": {**ranges, "title": {"text": name}} for axis, name in zip("xyz", names)}, "aspectmode": "cube",
            "camera": {"eye": {"x": 1.0, "y": 0.85, "z": 0.6}}}


def line3d(points: Array, name: str, colour: str, width: float, **more: Any) -> dict[str, Any]:
    """A line in three dimensions."""
    return {"type": "scatter3d", "mode": "lines", "name": name, "x": points[:, 0], "y": points[:, 1], "z": points[:, 2],
            "line": {"color": colour, "width": width}, "hoverinfo": "name", **more}


def body_figure(frames: Frames, surface: Surface) -> dict[str, Any]:
    """The body, its arrows, and the paths of their tips. The first five are moved by page.js."""
    corners = surface.corners
    arrows = (("axis 3", frames.axis), ("ω", frames.omega), ("l", frames.momentum))
    body = {"type": "mesh3d", "name": "body", "x": surface.points[:, 0], "y": surface.points[:, 1], "z": surface.points[:, 2],
            "i": corners[:, 0], "j": corners[:, 1], "k": corners[:, 2], "facecolor": surface.colours, "flatshading": True,
            "hoverinfo": "skip", "lighting": {"ambient": 0.65, "diffuse": 0.6, "specular": 0.1}}
    edges = surface.edges if len(surface.edges) else np.full((1, 3), np.nan)
    data = [body, line3d(edges, "edges", "#111111", 3, showlegend=False, connectgaps=False, hoverinfo="skip")]
    data += [line3d(np.array([np.zeros(3), tips[0]]), name, COLOURS[name], 7) for name, tips in arrows]
    data += [line3d(tips, f"path of {name}", COLOURS[name], 2, opacity=0.45, showlegend=False) for name, tips in arrows]
    layout = {"scene": axes3d(1.1 * frames.reach, ("x", "y", "z")), "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
              "legend": {"x": 0.02, "y": 0.98}, "uirevision": "kept"}
    return {"data": data, "layout": layout}


def polhode_figure(frames: Frames, inertia: Array) -> dict[str, Any]:
    """The ellipsoid x.Jx = 1 in body axes, and the path of the angular velocity on it. The first is moved by page.js."""
    moments, axes = np.linalg.eigh(inertia)
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 49), np.linspace(0, np.pi, 25))
    unit = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)
    x, y, z = np.moveaxis((unit / np.sqrt(moments)) @ axes.T, -1, 0)
    point = {**line3d(frames.polhode[:1], "ω/√(2T)", COLOURS["ω"], 1), "mode": "markers",
             "marker": {"size": 4, "color": COLOURS["ω"]}}
    surface = {"type": "surface", "name": "inertia ellipsoid", "x": x, "y": y, "z": z, "showscale": False, "opacity": 0.55,
               "colorscale": [[0, "#9ecae1"], [1, "#9ecae1"]], "hoverinfo": "skip", "showlegend": True}
    # A little outside, so that the surface does not hide it.
    # Where the body stands still for a moment, the path goes on from the other side.
    reach = 1.1 / np.sqrt(moments.min())
    jumps = 1 + np.flatnonzero(np.linalg.norm(np.diff(frames.polhode, axis=0), axis=1) > 0.5 * reach)
    path = line3d(1.01 * np.insert(frames.polhode, jumps, np.nan, axis=0), "polhode", COLOURS["path"], 5)
    layout = {"scene": axes3d(float(reach), ("1", "2", "3")), "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
              "legend": {"x": 0.02, "y": 0.98}, "uirevision": "kept"}
    return {"data": [point, surface, path], "layout": layout}


def curves_of(rows: Mapping[str, Array]) -> tuple[dict[str, Any], list[int]]:
    """Angular velocity and energy over time, and which shapes are cursors."""
    panels = [("rad/s", ("omega1", "omega2", "omega3")), ("J", ("kinetic", "potential", "total", "work"))]
    shown = [(unit, [name for name in names if name in rows]) for unit, names in panels]
    shown = [(unit, names) for unit, names in shown if names]
    data: list[dict[str, Any]] = []
    layout: dict[str, Any] = {"margin": {"l": 60, "r": 20, "t": 30, "b": 40}, "shapes": [], "uirevision": "kept"}
    for i, (unit, names) in enumerate(shown):
        axis = "" if i == 0 else str(i + 1)
        left, width = i / len(shown), 1 / len(shown)
        left += 0.06 if i else 0
        layout[f"legend{axis}"] = {"orientation": "h", "x": left, "y": 1.02, "yanchor": "bottom"}
        layout[f"xaxis{axis}"] = {"domain": [left, (i + 1) * width - 0.01], "title": {"text": "t (s)"}, "anchor": f"y{axis}"}
        layout[f"yaxis{axis}"] = {"title": {"text": unit}, "anchor": f"x{axis}"}
        data += [{"type": "scatter", "mode": "lines", "name": name, "x": rows["t"], "y": rows[name], "xaxis": f"x{axis}",
                  "yaxis": f"y{axis}", "legend": f"legend{axis}", "line": {"color": CURVE_COLOURS[k % len(CURVE_COLOURS)], "width": 1.5}}
                 for k, name in enumerate(names)]
        layout["shapes"].append({"type": "line", "xref": f"x{axis}", "yref": f"y{axis} domain", "x0": rows["t"][0],
                                 "x1": rows["t"][0], "y0": 0, "y1": 1, "line": {"color": "#999999", "width": 1.5}})
    return {"data": data, "layout": layout}, list(range(len(shown)))


def in_json(value: Any) -> str:
    """Arrays of seven digits, enough for the eye; what is no number is null; nothing that could end a script."""

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

    return re.sub("</", "<\\\\/", json.dumps(plain(value), ensure_ascii=False, separators=(",", ":")))
