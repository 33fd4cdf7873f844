"""Draws the animation of the tennis-racket theorem: python3 tennis_racket.py HISTORY.csv FIGURE.svg

The history is that of scenes/box.nml with the columns quaternion and angular_velocity. One period of the angular velocity is shown,
after which the attitude comes back to within a degree or two, so that the animation loops without a visible jump. Browsers
interpolate between the frames.
"""

import csv
import math
import sys

EDGES = (4.0, 1.0, 2.0)
SLOWER = 3
# Turn between two frames, rad, and how far the attitude may be off where the animation starts again.
FRAME_TURN, SEAM = 0.2, 0.03
WIDTH, HEIGHT = 1600, 720
# Of the camera, rad, m; pixels per metre; and where the centre of the body is drawn.
AZIMUTH, ELEVATION, DISTANCE, SCALE, CENTER = 0.5, 0.42, 16.0, 118.0, (400, 370)
LIGHT = (0.35, 0.75, 0.56)
# The ends of axis 3, then the sides.
FACES = {(2, 1): "#e69f00", (2, -1): "#0b3c5d", (0, 1): "#8fb3cf", (0, -1): "#8fb3cf", (1, 1): "#c3d5e3", (1, -1): "#c3d5e3"}
COMPONENTS = ("#d55e00", "#009e73", "#0b3c5d")
INK, GREY = "#222222", "#dddddd"
# Of the panel with the curves: left, right, top, bottom; the largest rate, rad/s.
LEFT, RIGHT, TOP, BOTTOM, MOST = 900, 1560, 110, 600, 12.0


def read(path):
    """Rows of t, q (4) and Omega (3)."""
    with open(path, encoding="utf-8") as file:
        return [[float(row[name]) for name in ("t", "q0", "q1", "q2", "q3", "omega1", "omega2", "omega3")]
                for row in csv.DictReader(file)]


def between(rows, t):
    """The row at a time, linear between two rows."""
    step = rows[1][0] - rows[0][0]
    i = min(int(t / step), len(rows) - 2)
    part = (t - rows[i][0]) / step
    return [a + part * (b - a) for a, b in zip(rows[i], rows[i + 1])]


def period(rows):
    """The time after which the angular velocity comes back: omega2 rises through 0 while omega3 and omega1 are positive."""
    for a, b in zip(rows[1:], rows[2:]):
        if a[6] * b[6] <= 0 and a[5] > 0 and a[7] > 0 and a[0] > 1:
            return a[0] + (b[0] - a[0]) * a[6] / (a[6] - b[6])
    sys.exit("tennis_racket: the history is shorter than a period")


def rotated(q, u):
    """Space components of a body vector; q need not have unit norm."""
    n = sum(x * x for x in q)
    a, b, c, d = (x / math.sqrt(n) for x in q)
    t = (2 * (c * u[2] - d * u[1]), 2 * (d * u[0] - b * u[2]), 2 * (b * u[1] - c * u[0]))
    return (u[0] + a * t[0] + c * t[2] - d * t[1], u[1] + a * t[1] + d * t[0] - b * t[2], u[2] + a * t[2] + b * t[1] - c * t[0])


def camera(u):
    """Coordinates to the right, up and towards the eye."""
    ca, sa, ce, se = math.cos(AZIMUTH), math.sin(AZIMUTH), math.cos(ELEVATION), math.sin(ELEVATION)
    right, ahead = -sa * u[0] + ca * u[1], ca * u[0] + sa * u[1]
    return right, -se * ahead + ce * u[2], ce * ahead + se * u[2]


def projected(u):
    """Pixels of a point of space."""
    x, y, z = camera(u)
    zoom = SCALE * DISTANCE / (DISTANCE - z)
    return f"{CENTER[0] + zoom * x:.0f},{CENTER[1] - zoom * y:.0f}"


def shaded(colour, normal):
    """The colour of a face by the light that falls on it."""
    bright = 0.72 + 0.34 * max(0.0, sum(a * b for a, b in zip(camera(normal), LIGHT)))
    return "#" + "".join(f"{min(255, round(bright * int(colour[i:i + 2], 16))):02x}" for i in (1, 3, 5))


def animated(name, values, duration, mode=""):
    """An attribute that runs through values, evenly spaced."""
    return f"<animate attributeName='{name}' dur='{duration}s' repeatCount='indefinite'{mode} values='{';'.join(values)}'/>"


def switched(shown, duration):
    """Visibility, with a value for each change only."""
    changes = [0] + [k for k in range(1, len(shown)) if shown[k] != shown[k - 1]]
    return animated("visibility", ["visible" if shown[k] else "hidden" for k in changes], duration,
                    f" calcMode='discrete' keyTimes='{';'.join(f'{k / (len(shown) - 1):.4f}' for k in changes)}'")


def faces(frames, duration):
    """The sides of the box; those that look away are hidden, and a convex body needs no more."""
    front = {}
    for (axis, side), colour in FACES.items():
        others = [i for i in range(3) if i != axis]
        points, fills, seen = [], [], []
        for frame in frames:
            corners = []
            for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1)):
                corner = [0.0, 0.0, 0.0]
                corner[axis], corner[others[0]], corner[others[1]] = (side * EDGES[axis] / 2, a * EDGES[others[0]] / 2,
                                                                      b * EDGES[others[1]] / 2)
                corners.append(rotated(frame[1:5], corner))
            normal = rotated(frame[1:5], [side * float(i == axis) for i in range(3)])
            middle = [sum(corner[i] for corner in corners) / 4 for i in range(3)]
            x, y, z = (m - e for m, e in zip(camera(middle), (0, 0, DISTANCE)))
            n = camera(normal)
            seen.append(n[0] * x + n[1] * y + n[2] * z < 0)
            points.append(" ".join(projected(corner) for corner in corners))
            fills.append(shaded(colour, normal))
        front[axis, side] = (f"<polygon points='{points[0]}' fill='{fills[0]}' visibility='{'visible' if seen[0] else 'hidden'}'>"
                             + animated("points", points, duration) + animated("fill", fills, duration)
                             + switched(seen, duration) + "</polygon>", seen)
    return front


def axis_arrow(frames, duration, shown=None):
    """Axis 3 of the body, out of its face."""
    foot, tip = ([projected(rotated(frame[1:5], (0, 0, z))) for frame in frames] for z in (EDGES[2] / 2, EDGES[2] / 2 + 1.3))
    paths = [f"M{a}L{b}" for a, b in zip(foot, tip)]
    circle = [point.split(",") for point in tip]
    hidden = "" if shown is None else switched(shown, duration)
    return (f"<g>{hidden}<path d='{paths[0]}' stroke='{COMPONENTS[2]}' stroke-width='9' stroke-linecap='round'>"
            f"{animated('d', paths, duration)}</path><circle r='15' cx='{circle[0][0]}' cy='{circle[0][1]}' fill='{COMPONENTS[2]}'>"
            f"{animated('cx', [c[0] for c in circle], duration)}{animated('cy', [c[1] for c in circle], duration)}</circle></g>")


def panel(frames, duration):
    """The three components over time, each with a dot that moves."""
    def x(t):
        return LEFT + (RIGHT - LEFT) * t / frames[-1][0]

    def y(value):
        return (TOP + BOTTOM) / 2 - (BOTTOM - TOP) / 2 * value / MOST

    lines = [f"<path d='M{LEFT} {y(v):.0f}H{RIGHT}' stroke='{GREY}' stroke-width='2'/><text x='{LEFT - 16}' y='{y(v) + 10:.0f}' "
             f"text-anchor='end'>{v}</text>" for v in (-10, -5, 0, 5, 10)]
    lines += [f"<text x='{x(t):.0f}' y='{BOTTOM + 42}' text-anchor='middle'>{t}</text>" for t in range(4)]
    lines.append(f"<text x='{RIGHT}' y='{BOTTOM + 42}' text-anchor='end'>t (s)</text>")
    lines.append(f"<text x='{LEFT - 70}' y='{TOP - 34}'>angular velocity in body axes (rad/s)</text>")
    for i, colour in enumerate(COMPONENTS):
        points = [(x(frame[0]), y(frame[5 + i])) for frame in frames]
        lines.append(f"<polyline points='{' '.join(f'{a:.0f},{b:.0f}' for a, b in points)}' fill='none' stroke='{colour}' "
                     f"stroke-width='{6 if i == 2 else 4}' stroke-linejoin='round'/>")
        lines.append(f"<circle r='12' cx='{points[0][0]:.0f}' cy='{points[0][1]:.0f}' fill='{colour}' stroke='white' "
                     "stroke-width='3'>"
                     f"{animated('cx', [f'{a:.0f}' for a, _ in points], duration)}"
                     f"{animated('cy', [f'{b:.0f}' for _, b in points], duration)}</circle>")
        lines.append(f"<text x='{LEFT + 60 + 110 * i}' y='{HEIGHT - 24}' fill='{colour}' font-weight='bold'>"
                     f"Ω<tspan font-size='22' dy='8'>{i + 1}</tspan></text>")
    return lines


def main():
    rows = read(sys.argv[1])
    end = period(rows)
    last = between(rows, end)
    first = rows[0]
    off = 2 * math.acos(min(1.0, abs(sum(a * b for a, b in zip(first[1:5], last[1:5]))) / math.hypot(*last[1:5])))
    if off > SEAM:
        sys.exit(f"tennis_racket: the attitude after one period is off by {off:.3f} rad")
    rate = max(math.hypot(*row[5:8]) for row in rows)
    count = math.ceil(rate * end / FRAME_TURN)
    frames = [between(rows, end * k / count) for k in range(count + 1)]
    duration = f"{SLOWER * end:.3f}"
    sides = faces(frames, duration)
    seen = sides[2, 1][1]
    text = [f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {WIDTH} {HEIGHT}' width='{WIDTH // 2}' height='{HEIGHT // 2}' "
            f"font-family='Helvetica, Arial, sans-serif' font-size='30' fill='{INK}'>",
            "<title>The tennis-racket theorem: a box that spins about its intermediate axis flips, again and again</title>",
            f"<rect width='{WIDTH}' height='{HEIGHT}' rx='16' fill='white'/>",
            f"<path d='M{projected((0, 0, -2.9)).replace(',', ' ')}L{projected((0, 0, 2.75)).replace(',', ' ')}' stroke='#888888' "
            "stroke-width='4' stroke-dasharray='14 10'/>",
            f"<text x='{CENTER[0] + 22}' y='40' fill='#666666'>angular momentum</text>",
            axis_arrow(frames, duration), f"<g stroke='{INK}' stroke-width='4' stroke-linejoin='round'>",
            *[side for side, _ in sides.values()], "</g>", axis_arrow(frames, duration, seen), *panel(frames, duration),
            f"<text x='60' y='{HEIGHT - 24}' fill='#666666'>{SLOWER} × slower than real time</text>", "</svg>", ""]
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        file.write("\n".join(text))


main()
