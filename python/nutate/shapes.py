"""The look of bodies: surfaces and edges of shapes, and of a shape with the inertia of a body of any other form."""

from __future__ import annotations

import os
import re
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from ._library import Array, NutateError
from .scenes import Scene
from .systems import System

# Colours of the faces towards -1 and 1, -2 and 2, -3 and 3, or of sectors about the axis; they differ for every kind of colour
# vision.
FACES = ("#0b3c5d", "#56b4e9", "#8c510a", "#e69f00", "#009e73", "#d55e00")
SECTORS = ("#56b4e9", "#0b3c5d", "#e69f00", "#0b3c5d")
AROUND = 32


class Surface:
    """Triangles of a surface, body axes, m: points of shape (n, 3), corners of shape (m, 3), a colour for each; and the lines
    of its edges, parted by nan, of shape (k, 3)."""

    def __init__(self, points: npt.ArrayLike, corners: npt.ArrayLike, colours: list[str], edges: npt.ArrayLike) -> None:
        self.points = np.asarray(points, dtype=np.float64)
        self.corners = np.asarray(corners, dtype=np.int64)
        self.colours = colours
        self.edges = np.asarray(edges, dtype=np.float64)

    def moved(self, axes: Array, origin: Array) -> Surface:
        """Returns the same surface, its axes rotated to the columns of a matrix, its centre moved."""
        return Surface(self.points @ axes.T + origin, self.corners, self.colours, self.edges @ axes.T + origin)

    @property
    def size(self) -> float:
        """Distance of the farthest point from the reference point, m."""
        return float(np.linalg.norm(self.points, axis=1).max())


def box(edges: Array) -> Surface:
    """Returns a box with its edges along the axes."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    points: list[Any] = []
    corners: list[list[int]] = []
    colours: list[str] = []
    for axis in range(3):
        for side in (-1, 1):
            face = signs[signs[:, axis] == side][[0, 1, 3, 2]]
            corners += [[len(points), len(points) + 1, len(points) + 2], [len(points), len(points) + 2, len(points) + 3]]
            points += list(face * edges / 2)
            colours += [FACES[2 * axis + (side > 0)]] * 2
    pairs = [(a, b) for a in signs for b in signs if np.abs(a - b).sum() == 2 and tuple(a) < tuple(b)]
    lines = [row for a, b in pairs for row in (a * edges / 2, b * edges / 2, np.full(3, np.nan))]
    return Surface(points, corners, colours, lines)


def rotated_profile(radii: Array, heights: Array) -> Surface:
    """Returns the surface of revolution of a profile about axis 3, with colours by sectors that show the spin."""
    angles = 2 * np.pi * np.arange(AROUND + 1) / AROUND
    points = [(r * np.cos(angle), r * np.sin(angle), z) for r, z in zip(radii, heights) for angle in angles]
    corners, colours = [], []
    for i in range(len(radii) - 1):
        for k in range(AROUND):
            a, b = i * (AROUND + 1) + k, (i + 1) * (AROUND + 1) + k
            corners += [[a, a + 1, b], [a + 1, b + 1, b]]
            colours += [SECTORS[k * len(SECTORS) // AROUND]] * 2
    rims = [i for i in range(1, len(radii) - 1) if len(radii) <= 4]
    lines = [row for i in rims for row in [*points[i * (AROUND + 1):(i + 1) * (AROUND + 1)], (np.nan,) * 3]]
    return Surface(points, corners, colours, lines or np.empty((0, 3)))


def ellipsoid(axes: Array) -> Surface:
    """Returns an ellipsoid with its semi-axes along the axes."""
    polar = np.pi * np.arange(AROUND // 2 + 1) / (AROUND // 2)
    unit = rotated_profile(np.sin(polar), -np.cos(polar))
    return Surface(unit.points * axes, unit.corners, unit.colours, unit.edges)


def of_shape(shape: str, size: Array) -> Surface:
    """Returns a shape of scene files about its centre of mass."""
    if shape == "box":
        return box(size)
    if shape == "cylinder":
        return rotated_profile(size[0] * np.array([0, 1, 1, 0]), size[1] * np.array([-0.5, -0.5, 0.5, 0.5]))
    if shape == "cone":
        return rotated_profile(size[0] * np.array([0, 1, 0]), size[1] * np.array([-0.75, 0.25, 0.25]))
    return ellipsoid(size if shape == "ellipsoid" else np.full(3, size[0]))


def assumed_shape(system: System) -> tuple[str, Surface]:
    """Returns a homogeneous body with the inertia of another about its centre of mass: a sphere or a cylinder if it is symmetric, else a
    box. It has 1 kg if the mass is not known, since the form does not depend on it."""
    mass, center = system.mass, system.center_of_mass
    inertia = system.inertia - mass * (center @ center * np.eye(3) - np.outer(center, center))
    moments, axes = np.linalg.eigh(inertia)
    equal = np.isclose(moments[:2], moments[1:], rtol=1e-9)
    if equal.all():
        return "sphere", ellipsoid(np.full(3, np.sqrt(2.5 * moments[0] / (mass or 1.0)))).moved(np.eye(3), center)
    if equal.any():
        along = 2 if equal[0] else 0
        radius = np.sqrt(2 * moments[along] / (mass or 1.0))
        height = np.sqrt(max(12 * moments[1] / (mass or 1.0) - 3 * radius ** 2, 4e-4 * radius ** 2))
        around = np.roll(axes, 2 - along, axis=1)
        around[:, 0] *= np.sign(np.linalg.det(around))
        return "disc" if height < radius else "cylinder", of_shape("cylinder", np.array([radius, height])).moved(around, center)
    squares = (moments.sum() / 2 - moments) * 12 / (mass or 1.0)
    # A plate has an edge of zero; and moments that no body has would give less.
    edges = np.sqrt(np.maximum(squares, 1e-4 * squares.max()))
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    return "box", box(edges).moved(axes, center)


def surface_of(system: System, scene: Optional[Scene] = None) -> tuple[Surface, Optional[str]]:
    """Returns the surface of a body: of the shape that it was given, else of one with its inertia, and the name of that."""
    found = shape_of(system, scene)
    if found is None:
        name, surface = assumed_shape(system)
        return surface, name
    return of_shape(*found).moved(np.eye(3), system.center_of_mass), None


def shape_of(system: System, scene: Optional[Scene] = None) -> Optional[tuple[str, Array]]:
    """Returns the shape that a body was given, and its lengths; None if it has none."""
    for shape, size in candidates(system, scene):
        # Overrides, or a text that says it in another way: what is drawn must have the inertia.
        try:
            with System(shape=shape, size=size, mass=system.mass, center_of_mass=system.center_of_mass) as twin:
                if np.allclose(twin.inertia, system.inertia, rtol=1e-9, atol=0):
                    return shape, np.atleast_1d(np.asarray(size, dtype=np.float64))
        except NutateError:
            continue
    return None


def plain_text(system: System, scene: Optional[Scene]) -> str:
    """Returns the scene text of a body and its effects, without comments."""
    scene = scene or system._given[1].get("scene")
    texts = [system._given[1].get("text")] if scene is None else [*scene._given[0][1:], scene._given[1]["text"]]
    texts += [arguments[1] for name, arguments in system._additions if name == "_add_group"]
    words = [text if isinstance(text, str) else os.fsdecode(text) for text in texts if text is not None]
    # Comments may speak of shapes, too.
    return "\n".join(re.sub(r"!.*", "", text) for text in words)


def wheel_axes(system: System, scene: Optional[Scene] = None) -> list[Array]:
    """Returns the axes of all reaction wheels, body axes, of any length."""
    axes = [arguments[0][0] for name, arguments in system._additions if name == "_add_wheel"]
    number = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?"
    for group in re.findall(r"&wheel\b(.*?)(?=&|\Z)", plain_text(system, scene), re.DOTALL):
        found = re.search(rf"\baxis\s*=\s*({number})[\s,]+({number})[\s,]+({number})", group)
        if found:
            axes.append(np.array([float(text.lower().replace("d", "e")) for text in found.groups()]))
    return axes


def candidates(system: System, scene: Optional[Scene]) -> list[tuple[str, Any]]:
    """Shapes that the body may have, from what it was made of."""
    given = system._given[1]
    if given.get("shape") is not None:
        return [(given["shape"], given["size"])]
    plain = plain_text(system, scene)
    shapes = re.findall(r"\bshape\s*=\s*['\"]?(\w+)", plain)
    sizes = [np.array([float(number) for number in re.split(r"[\s,]+", found.lower().replace("d", "e").strip(" ,\n"))])
             for found in re.findall(r"\bsize\s*=((?:[\s,]*[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?)+)", plain)]
    return [(shape, size) for shape in shapes for size in sizes]
