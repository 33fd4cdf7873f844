"""Reference for the tests: a body with a magnetic moment in the field of the Earth along an eccentric, inclined orbit.

    python3 tools/docs/references/earth_field.py      prints attitude, rate and work of time-dependent potentials; wants mpmath; some minutes

Nothing is shared with the library: Euler's equations and those of the quaternion in 34 digits, by Gragg's method extrapolated
to order 26, in steps of two lengths; the shorter ones are printed. What the two differ by is that of the longer ones, some
1e5 times the error of the others. Printed too: the change of the energy less the work of time-dependent potentials, which is integrated for
itself, and by how much errors of the start grow.
"""

from mpmath import mp, mpf, matrix, cos, sin, sqrt, pi, svd

mp.dps = 34

MU, EARTH_RATE, RADIUS = mpf("3.986004418e14"), mpf("7.292115e-5"), mpf("6371.2e3")
COEFFICIENTS = [mpf(x) * mpf("1e-9") for x in ("-1410.3", "4545.5", "-29350.0")]
EPOCH_ANGLE = mpf("0.7")
AXIS, ECCENTRICITY, MEAN_ANOMALY = mpf("1e7"), mpf("0.3"), mpf(1)
INCLINATION, NODE, PERIAPSIS = (mpf(x) * pi / 180 for x in (60, 30, 45))
MOMENTS = [mpf(x) for x in ("0.09", "0.1", "0.04")]
MAGNET = [mpf(x) for x in ("0.6", "-0.9", "1.2")]
RATE = [mpf(x) for x in ("4e-3", "-3e-3", "5e-3")]
TIMES = [1000, 3000, 10000, 20000]
COLUMNS = 13


def dot(a, b):
    """The product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    """a x b."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def plane():
    """Directions of the periapsis and, a right angle ahead in the plane, of the motion there; inertial axes."""
    c, s, ci, si = cos(NODE), sin(NODE), cos(INCLINATION), sin(INCLINATION)
    line, ahead = [c, s, mpf(0)], [-s * ci, c * ci, si]
    return ([cos(PERIAPSIS) * x + sin(PERIAPSIS) * y for x, y in zip(line, ahead)],
            [cos(PERIAPSIS) * y - sin(PERIAPSIS) * x for x, y in zip(line, ahead)])


FORWARD, ACROSS = plane()
MOTION, FLATNESS = sqrt(MU / AXIS**3), sqrt(1 - ECCENTRICITY**2)


def field(t):
    """B and its rate at a time, inertial axes."""
    mean = MEAN_ANOMALY + MOTION * t
    anomaly = mean
    for _ in range(200):
        change = (anomaly - ECCENTRICITY * sin(anomaly) - mean) / (1 - ECCENTRICITY * cos(anomaly))
        anomaly -= change
        if abs(change) < mpf(10)**(5 - mp.dps):
            break
    c, s = cos(anomaly), sin(anomaly)
    place = [AXIS * ((c - ECCENTRICITY) * x + FLATNESS * s * y) for x, y in zip(FORWARD, ACROSS)]
    speed = AXIS * MOTION / (1 - ECCENTRICITY * c)
    velocity = [speed * (-s * x + FLATNESS * c * y) for x, y in zip(FORWARD, ACROSS)]
    angle = EPOCH_ANGLE + EARTH_RATE * t
    c, s = cos(angle), sin(angle)
    g = [COEFFICIENTS[0] * c - COEFFICIENTS[1] * s, COEFFICIENTS[0] * s + COEFFICIENTS[1] * c, COEFFICIENTS[2]]
    turn = [-EARTH_RATE * g[1], EARTH_RATE * g[0], mpf(0)]
    # a^3 (3 (G.r) r/r^5 - G/r^3), by the rule of products.
    square = dot(place, place)
    distance = sqrt(square)
    third, fifth = RADIUS**3 / distance**3, 3 * RADIUS**3 / distance**5
    along = dot(g, place)
    climb = dot(place, velocity) / square
    along_rate = dot(turn, place) + dot(g, velocity) - 5 * climb * along
    return ([fifth * along * x - third * y for x, y in zip(place, g)],
            [fifth * (along_rate * x + along * v) - third * (w - 3 * climb * y)
             for x, v, y, w in zip(place, velocity, g, turn)])


def to_body(q, v):
    """A vector of inertial axes in those of the body; q of any length."""
    u = q[1:4]
    square = dot(u, u)
    ahead, twice, scale = 2 * dot(u, v), cross(u, v), q[0]**2 - square
    return [(scale * x + ahead * y - 2 * q[0] * z) / (q[0]**2 + square) for x, y, z in zip(v, u, twice)]


def rates(t, y):
    """Of quaternion, rate and work of time-dependent potentials, which is that of the changing field at a body that stands still."""
    q, w = y[0:4], y[4:7]
    b, change = field(t)
    torque = [x + y for x, y in zip(cross([j * x for j, x in zip(MOMENTS, w)], w), cross(MAGNET, to_body(q, b)))]
    turn = [(q[0] * x + y) / 2 for x, y in zip(w, cross(q[1:4], w))]
    return [-dot(q[1:4], w) / 2] + turn + [x / j for x, j in zip(torque, MOMENTS)] + [-dot(MAGNET, to_body(q, change))]


def midpoint(t, y, step, n):
    """Gragg's modified midpoint rule in n parts of a step, n even."""
    h = step / n
    before, now = y, [a + h * b for a, b in zip(y, rates(t, y))]
    for i in range(1, n):
        before, now = now, [a + 2 * h * b for a, b in zip(before, rates(t + i * h, now))]
    return [(a + b + h * c) / 2 for a, b, c in zip(before, now, rates(t + step, now))]


def extrapolate(t, y, step):
    """One step of order 2K."""
    parts = [2 * (k + 1) for k in range(COLUMNS)]
    row = []
    for k, n in enumerate(parts):
        new = [midpoint(t, y, step, n)]
        for j in range(1, k + 1):
            factor = mpf(n)**2 / mpf(parts[k - j])**2 - 1
            new.append([a + (a - b) / factor for a, b in zip(new[j - 1], row[j - 1])])
        row = new
    return row[-1]


def follow(y, step, times):
    """States at times."""
    states, t = [], mpf(0)
    for end in times:
        for _ in range(int(round((end - t) / step))):
            y = extrapolate(t, y, step)
            t += step
        length = sqrt(sum(x**2 for x in y[0:4]))
        states.append([x / length for x in y[0:4]] + y[4:8])
    return states


def energy(t, y):
    """T + V, J."""
    return sum(j * x**2 for j, x in zip(MOMENTS, y[4:7])) / 2 - dot(MAGNET, to_body(y[0:4], field(t)[0]))


def growth(start):
    """Largest factor by which errors of the start, 1 rad or the largest rate, have grown at each time, by differences."""
    scale, unit = [1, 1, 1] + [sqrt(dot(RATE, RATE))] * 3, mpf("1e-10")
    ends = [follow(start, mpf(50), TIMES)]
    for i in range(6):
        y = list(start)
        if i < 3:
            turn = [unit / 2 if k == i else mpf(0) for k in range(3)]
            y[0:4] = [y[0] - dot(y[1:4], turn)] + [a + y[0] * b + c for a, b, c in zip(y[1:4], turn, cross(y[1:4], turn))]
        else:
            y[4 + i - 3] += unit * scale[i]
        ends.append(follow(y, mpf(50), TIMES))
    factors = []
    for k in range(len(TIMES)):
        columns = [[(a - b) / unit / c for a, b, c in zip(end[k][0:7], ends[0][k][0:7], [0.5] * 4 + scale[3:])]
                   for end in ends[1:]]
        factors.append(svd(matrix(columns), compute_uv=False)[0])
    return factors


def main():
    """Prints the table."""
    start = [cos(pi / 9)] + [sin(pi / 9) / sqrt(mpf(3))] * 3 + RATE + [mpf(0)]
    coarse, fine = (follow(start, mpf(step), TIMES) for step in (40, 25))
    for t, a, b, factor in zip(TIMES, coarse, fine, growth(start)):
        print(t, *(mp.nstr(x, 21) for x in b))
        print("   two lengths:", mp.nstr(max(abs(x - y) for x, y in zip(a, b)), 2),
              "account:", mp.nstr(abs(energy(t, b) - energy(0, start) - b[7]), 2),
              "growth:", mp.nstr(factor, 3))


if __name__ == "__main__":
    main()
