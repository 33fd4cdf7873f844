"""Legal scenes with extreme values: all rules of scene files kept, numbers of any size."""

import re

from support import (COLUMNS, CONTROL_COLUMNS, FIELD_COLUMNS, FREE_COLUMNS, METHODS, ORBIT_COLUMNS, POINTING_COLUMNS, ROOT,
                     SUN_COLUMNS, TUMBLING_COLUMNS, WHEEL_COLUMNS)


def read_effects():
    """The first group of each effect in test/effect_samples.nml: keys and numbers by name."""
    text = (ROOT / "test" / "effect_samples.nml").read_text(encoding="utf-8")
    found = {}
    for name, body in re.findall(r"^&(\w+)\n(.*?)^/", text, flags=re.DOTALL | re.MULTILINE):
        if name not in ("scene", "body", "initial", "integrator", "output"):
            found.setdefault(name, re.findall(r"(\w+) = ([-+.\d, ]+)", body))
    return found


def number_text(value):
    return repr(float(value)).replace("inf", "Infinity")


def extreme(dice):
    """A number of any size that a double can have."""
    sign = dice.choice((1, 1, -1))
    edge = dice.random()
    if edge < 0.1:
        return sign * dice.choice((5e-324, 2.2250738585072014e-308, 1.7976931348623157e308, 1e-310, 0.0))
    return sign * dice.uniform(1, 10) * 10.0 ** dice.uniform(-300, 300 if edge < 0.5 else 100)


class Scales:
    """Scales of a scene, from which its numbers deviate now and then."""

    def __init__(self, dice):
        self.dice = dice
        reach = dice.choice((0, 0, 3, 10, 25, 40))
        self.length = 10.0 ** dice.uniform(-reach, reach)
        self.mass = 10.0 ** dice.uniform(-reach, reach)
        self.time = 10.0 ** dice.uniform(-reach, reach)
        # How far the numbers of one scene are apart, and how often one is out of all proportion.
        self.spread = dice.choice((0.0, 1.0, 4.0, 12.0))
        self.oddity = dice.choice((0.0, 0.0, 0.05, 0.2))

    def value(self, length=0, mass=0, time=0, signed=True):
        """A number of that dimension."""
        dice = self.dice
        if dice.random() < self.oddity:
            number = dice.choice((0.0, extreme(dice), extreme(dice)))
        else:
            size = dice.uniform(0.3, 3.0) * 10.0 ** dice.uniform(-self.spread, self.spread)
            number = size * self.length**length * self.mass**mass * self.time**time
        return number if signed and dice.random() < 0.5 else abs(number)

    def text(self, count=1, **dimension):
        """Numbers of that dimension as a scene has them."""
        return ", ".join(number_text(self.value(**dimension)) for _ in range(count))


def write_scene(dice):
    """A scene that keeps the rules of scene files, whose values need not make sense."""
    scales = Scales(dice)
    effects = [dice.choice(EFFECTS)(dice, scales) for _ in range(dice.choice((0, 0, 1, 1, 2, 5)))]
    # What only an orbit has is refused without one, but for a few.
    if any(word in effect for effect in effects for word in ("&earth_field", "&third_degree", "'lvlh'")) and dice.random() < 0.9:
        effects.append(orbit(dice, scales))
    axes = [name for name in ("rotating_frame", "orbit") if any("&" + name in effect for effect in effects)]
    axes += ["sun"] if any("sun = " in effect for effect in effects) else []
    parts = [body(dice, scales), initial(dice, scales, axes), integrator(dice, scales, not effects), output(dice, scales, axes)]
    parts += dict.fromkeys(effects)
    if dice.random() < 0.3:
        parts += [event(dice, scales) for _ in range(dice.choice((1, 1, 2, 4)))]
    if dice.random() < 0.2:
        parts += [ensemble(dice), *dict.fromkeys(vary(dice, scales) for _ in range(dice.choice((1, 1, 2))))]
    # Most runs of such scenes leave the calendar.
    if dice.random() < 0.08:
        parts.append(labels(dice))
        if dice.random() < 0.5:
            parts[3] = parts[3].rstrip()[:-1] + " calendar = .true. /\n"
        if dice.random() < 0.5:
            parts[3] = parts[3].replace("columns = ", "columns = 'frame1', ")
            parts.append(group("frame", [f"attitude = '{dice.choice(('frame.aem', 'frame.aem', 'frame.aem', 'table.csv'))}'"]))
            parts.append(group("event", [f"when = 'frame1_{dice.choice(('angle', 'q2'))}'",
                                         dice.choice(("crosses = 0.5", "extremum = 'both'"))]))
    if dice.random() < 0.2:
        parts += [*dict.fromkeys(free(dice, scales) for _ in range(dice.choice((1, 1, 2)))), measurement(dice, scales), fit(dice)]
    elif dice.random() < 0.2:
        parts.append(free(dice, scales))
    if dice.random() < 0.1:
        parts.append(tangent(dice, scales))
    dice.shuffle(parts)
    return "".join(parts).encode()


def body(dice, scales):
    lines = []
    if dice.random() < 0.3:
        shape, sizes = dice.choice((("box", 3), ("cylinder", 2), ("cone", 2), ("sphere", 1), ("ellipsoid", 3)))
        lines += [f"shape = '{shape}'", f"size = {scales.text(sizes, length=1, signed=False)}"]
    else:
        lines += [f"inertia = {moments(dice, scales)}", f"check_triangle = .{dice.choice(('true', 'false', 'false', 'false'))}."]
        if dice.random() < 0.2:
            lines.append("inertia_about = 'center_of_mass'")
    lines.append(f"mass = {scales.text(mass=1, signed=False)}")
    if dice.random() < 0.1:
        return body_by_tables(dice)
    if dice.random() < 0.7:
        lines.append(f"center_of_mass = {dice.choice((scales.text(3, length=1), '0, 0, ' + scales.text(length=1)))}")
    return group("body", lines)


def body_by_tables(dice):
    lines = [f"center_of_mass_table = '{dice.choice(('center.csv', 'center.csv', 'track.csv'))}'"] if dice.random() < 0.7 else []
    if lines and dice.random() < 0.5:
        lines.append(f"center_of_mass_interpolation = '{dice.choice(('linear', 'cubic'))}'")
    if dice.random() < 0.7:
        lines += [f"inertia_table = '{dice.choice(('inertia.csv', 'inertia.csv', 'center.csv'))}'",
                  f"inertia_interpolation = '{dice.choice(('linear', 'cubic'))}'"]
        lines += [f"mass_leaves = .{dice.choice(('true', 'false'))}."] if dice.random() < 0.3 else []
    else:
        lines.append("inertia = 1, 1.5, 2")
    return group("body", lines + [f"mass = {dice.choice(('0.1', '2', '1e-30'))}"])


def moments(dice, scales):
    """Principal moments: of a sphere, a top, nearly those, or any."""
    j = [scales.value(length=2, mass=1, signed=False) for _ in range(3)]
    way = dice.randrange(6)
    if way < 3:
        j[1] = j[0] * (1 + dice.choice((0.0, 1e-15, 1e-9)))
    if way == 0:
        j[2] = j[0] * (1 + dice.choice((0.0, 2.3e-16, -1e-15)))
    elif way == 3:
        j[2] = min(j[0] + j[1], 1.7e308)
    elif way == 4:
        j[1] = j[2] = j[0]
        j[dice.randrange(3)] *= 10.0 ** -dice.uniform(0, 20)
    return ", ".join(number_text(moment) for moment in j)


def tumbling(dice, scales):
    lines = [f"tumbling = '{dice.choice(('sam', 'lam'))}'", f"period_axis = '{dice.choice(('short', 'long'))}'",
             f"precession_period = {scales.text(time=1, signed=False)}", f"pole = {scales.text(2)}"]
    lines.append(dice.choice((f"rotation_period = {scales.text(time=1, signed=False)}",
                              f"energy_ratio = {1 + 10.0 ** -dice.uniform(0, 17)}")))
    lines += [f"{key} = {scales.text()}" for key in ("precession_angle", "rotation_phase") if dice.random() < 0.3]
    lines += [f"sense = '{dice.choice(('positive', 'negative'))}'"] if dice.random() < 0.3 else []
    return group("initial", lines)


def initial(dice, scales, axes):
    if dice.random() < 0.1:
        return tumbling(dice, scales)
    if "orbit" in axes and dice.random() < 0.1:
        return group("initial", [f"resonance = '{dice.choice(('1:2', '1:1', '3:2', '2:1', '5:2', '3:1'))}'"])
    lines = []
    if axes and dice.random() < 0.5:
        lines.append(f"rate_from = '{dice.choice(('inertial', 'frame', 'lvlh'))}'")
    if "orbit" in axes and dice.random() < 0.5:
        lines.append(f"attitude_from = '{dice.choice(('space', 'lvlh'))}'")
    way = dice.randrange(5)
    if way == 0:
        lines.append(f"euler = {dice.uniform(-7, 7)}, {dice.choice((0.0, 3.141592653589793, 1e-200, 1.0))}, 0.5")
    elif way == 1:
        lines += [f"axis = {scales.text(3)}", f"angle = {scales.text()}"]
    elif way == 2:
        q = [dice.choice((0.0, dice.gauss(0, 1))) for _ in range(3)] + [1.0]
        size = sum(x * x for x in q) ** 0.5
        lines.append("quaternion = " + ", ".join(number_text(x / size) for x in q))
    elif way == 3:
        lines.append(f"roll_pitch_yaw = {dice.uniform(-7, 7)}, {dice.choice((0.0, 1.5707963267948966, 1.0))}, {scales.text()}")
    if way == 0 and dice.random() < 0.3:
        lines.append(f"euler_rates = {scales.text(3, time=-1)}")
        if "rotating_frame" in axes and not lines[0].startswith("rate_from"):
            lines.append("rate_from = 'frame'")
    else:
        factors = dice.choice(((1,), (1, 1, 0), (1, 1, 0, 1e-16, 1e6), (1, 1, 1e-300)))
        rate = [scales.value(time=-1) * dice.choice(factors) for _ in range(3)]
        lines.append("angular_velocity = " + ", ".join(number_text(x) for x in rate))
        if dice.random() < 0.3:
            lines.append("frame = 'space'")
    if dice.random() < 0.1:
        lines.append("degrees = .true.")
    return group("initial", lines)


def integrator(dice, scales, free):
    name, solver, order, _ = dice.choice([row for row in METHODS if free or row[0] != "exact"])
    lines = [f"method = '{name}'"]
    if solver:
        lines += [f"formulation = '{solver}'", f"order = {order}"]
    direction = dice.choice((1, 1, 1, -1))
    step = scales.value(time=1, signed=False) * dice.choice((1e-9, 1e-3, 0.01, 0.1, 0.1, 1, 4, 100))
    if dice.random() < 0.3 and order != "0":
        lines.append(f"{dice.choice(('accuracy', 'local_tolerance'))} = {10.0 ** dice.uniform(-16, -1)}")
        end = scales.value(time=1, signed=False) * dice.choice((0.1, 1, 1, 10, 1e6, 1e12))
        if dice.random() < 0.1:
            lines.append(f"max_step = {number_text(end * dice.choice((0.01, 0.1, 10)))}")
    else:
        lines.append(f"time_step = {number_text(direction * step)}")
        end = step * dice.choice((0.3, 1, 3, 20, 20, 20.5, 200, 1e5))
    lines.append(f"end_time = {number_text(direction * end)}")
    if dice.random() < 0.3:
        lines.append(f"auxiliary_inertia = {scales.text(length=2, mass=1, signed=False)}")
    if solver == "full" and len(lines) == 6 and dice.random() < 0.2:
        lines.append("projection = .false.")
    if dice.random() < 0.1:
        lines.append(f"max_iterations = {dice.choice((1, 2, 5, 20, 100, 1000, 2147483647))}")
    if dice.random() < 0.1:
        lines.append(f"tolerance = {10.0 ** dice.choice((dice.uniform(-16, -1), dice.uniform(-320, -1)))}")
    return group("integrator", lines)


def output(dice, scales, axes):
    lines = []
    if dice.random() < 0.8:
        sets = list(COLUMNS) + (list(WHEEL_COLUMNS)[:2] if dice.random() < 0.1 else [])
        sets += list(ORBIT_COLUMNS) if "orbit" in axes or dice.random() < 0.05 else []
        sets += list(SUN_COLUMNS) if "sun" in axes or dice.random() < 0.02 else []
        sets += [*list(CONTROL_COLUMNS)[:1], *list(POINTING_COLUMNS)[:1], *FIELD_COLUMNS] if dice.random() < 0.1 else []
        sets += TUMBLING_COLUMNS if dice.random() < 0.2 else []
        sets += FREE_COLUMNS if dice.random() < 0.05 else []
        chosen = dice.choice((sets, dice.sample(sets, dice.randrange(1, 4)), ["angular_velocity"]))
        lines.append("columns = " + ", ".join(f"'{name}'" for name in chosen))
    if dice.random() < 0.3:
        lines.append(f"every = {dice.choice((1, 1, 7, 7, 1000, 1000, 999999999, 2147483647))}")
    elif dice.random() < 0.05:
        lines.append(f"interval = {scales.text(time=1, signed=False)}")
    elif dice.random() < 0.2:
        times = sorted(scales.value(time=1, signed=False) * dice.choice((0, 1e-3, 0.1)) for _ in range(dice.randrange(1, 5)))
        lines.append("times = " + ", ".join(number_text(time) for time in times))
    if dice.random() < 0.1:
        lines.append(f"precision = {dice.choice((1, 3, 17))}")
    if dice.random() < 0.1:
        lines.append("degrees = .true.")
    return group("output", lines)


def labels(dice):
    """Title, epoch and names."""
    system = dice.choice(("TDB", "TT", "TAI", "UTC"))
    date = dice.choice(("2029-04-13T21:46:12.7", "2016-12-31T23:59:59.5", "1999-365", "1972-01-01", "9999-12-31T23:59:59.999999999999999"))
    lines = [f"epoch = '{date}'", f"time_system = '{system}'"] if dice.random() < 0.8 else []
    lines += [f"{key} = '{dice.choice(('APOPHIS', 'a b', 'ICRF'))}'" for key in ("title", "object", "object_id", "space_frame", "body_frame")
              if dice.random() < 0.3]
    return group("scene", lines)


# Stands beside every scene: intervals of ages and of moments.
FRAME = b"""CCSDS_AEM_VERS = 2.0
META_START
OBJECT_NAME = TARGET
OBJECT_ID = TARGET
REF_FRAME_A = ICRF
REF_FRAME_B = SC_BODY_1
TIME_SYSTEM = TDB
ATTITUDE_TYPE = QUATERNION
META_STOP
DATA_START
1972-01-01T00:00:50 0 0 0 1
2016-12-31T23:59:58 0.6 0 0 0.8
2029-04-13T21:46:12.5 0 0.6 0 0.8
2029-04-13T21:46:12.50001 0 0 0.6 0.8
2029-04-13T21:46:13 0.5 0.5 0.5 0.5
9999-12-31T23:59:59 0 0 0.6 -0.8
DATA_STOP
"""


def event(dice, scales):
    columns = dice.sample(EVENT_COLUMNS, dice.choice((1, 1, 1, 2)))
    lines = ["when = " + ", ".join(f"'{name}'" for name in columns)]
    if dice.random() < 0.5:
        lines.append(f"name = '{dice.choice(('flip', 'a, b', 'north'))}'")
    if len(columns) > 1:
        lines.append(f"weights = {scales.text(2)}")
    if dice.random() < 0.3:
        lines.append(f"extremum = '{dice.choice(('maximum', 'minimum', 'both'))}'")
    else:
        lines.append(f"crosses = {dice.choice(('0.0', scales.text()))}")
        if dice.random() < 0.3:
            lines.append(f"direction = {dice.choice((1, -1))}")
        if dice.random() < 0.2:
            lines.append(f"modulo = {scales.text(signed=False)}")
    lines += dice.choice(([], [], ["stop = .true."], ["count = 3"]))
    return group("event", lines)


def ensemble(dice):
    lines = [f"members = {dice.choice((1, 3, 999999999))}"]
    if dice.random() < 0.3:
        lines += [f"seed = {dice.choice((0, 7, 999999999))}", f"sampling = '{dice.choice(('random', 'latin'))}'"]
    if dice.random() < 0.2:
        lines += ["histories = 1", f"rows = '{dice.choice(('final', 'none'))}'", "chunk = 2", "file = 'rows.npy'"]
    return group("ensemble", lines)


def vary(dice, scales):
    key = dice.choice(("body.inertia.1", "body.mass", "initial.angular_velocity.3", "integrator.end_time", "torque.1.start",
                       "event.crosses", "Body.Mass"))
    way = dice.choice((f"'uniform', low = -{scales.text(signed=False)}, high = {scales.text(signed=False)}",
                       f"'normal', mean = {scales.text()}, sigma = {scales.text(signed=False)}",
                       f"'normal', covariance = {scales.text(signed=False)}",
                       f"'grid', low = -{scales.text(signed=False)}, high = {scales.text(signed=False)}, points = 3"))
    return group("vary", [f"key = '{key}', distribution = {way}"])


def free(dice, scales):
    key = dice.choice(("body.inertia.1", "body.mass", "initial.angular_velocity.3", "initial.attitude", "torque.1.body.3",
                       "Body.Mass"))
    lines = [f"key = '{key}'"]
    if key != "initial.attitude" and dice.random() < 0.5:
        lines += [f"sigma = {scales.text(signed=False)}", f"low = -{scales.text(signed=False)}",
                  f"high = {scales.text(signed=False)}"]
    return group("free", lines)


# Stands beside every scene; at the start, which every run has.
MEASURED = b"""t,omega1,omega2,omega3,q0,q1,q2,q3
0,1,-0.5,0.25,1,0,0,0
"""


def measurement(dice, scales):
    columns = dice.choice(("'omega1', 'omega2', 'omega3'", "'q0', 'q1', 'q2', 'q3'", "'omega2'"))
    lines = [f"file = '{dice.choice(('measured.csv', 'measured.csv', 'measured.csv', 'absent.csv'))}'", f"columns = {columns}"]
    lines += [f"loss = '{dice.choice(('linear', 'huber', 'soft_l1', 'cauchy'))}'"] if dice.random() < 0.3 else []
    lines += [f"sigma = {scales.text(signed=False)}"] if dice.random() < 0.7 else []
    if "q0" not in columns and dice.random() < 0.3:
        lines.append("bias = 'constant'")
    return group("measurement", lines)


def fit(dice):
    return group("fit", [f"starts = {dice.choice((0, 3))}", f"arcs = '{dice.choice(('growing', 'whole'))}'",
                         f"start = '{dice.choice(('data', 'scene'))}'", "seed = 7"])


def tangent(dice, scales):
    lines = [f"exponents = {dice.choice((1, 6))}", f"every = {dice.choice((1, 3, 100))}"]
    lines += [f"momentum_scale = {scales.text(length=2, mass=1, time=-1, signed=False)}"] if dice.random() < 0.5 else []
    lines += [f"vector = {scales.text(6)}"] if dice.random() < 0.5 else []
    return group("chaos", lines)


def gravity(_, scales):
    return group("gravity", [f"acceleration = {scales.text(3, length=1, time=-2)}"])


def dipole(_, scales):
    return group("dipole", [f"moment = {scales.text(3)}", f"field = {scales.text(3, length=2, mass=1, time=-2)}"])


def gravity_gradient(dice, scales):
    if dice.random() < 0.2:
        return group("gravity_gradient", dice.choice(([], [], ["orbit = 'one'"])))
    return group("gravity_gradient", [f"direction = {scales.text(3)}", f"strength = {scales.text(time=-2)}"])


def spring(dice, scales):
    lines = [f"body_point = {scales.text(3, length=1)}", f"anchor = {scales.text(3, length=1)}",
             f"stiffness = {scales.text(mass=1, time=-2)}"]
    if dice.random() < 0.7:
        lines.append(f"rest_length = {scales.text(length=1, signed=False)}")
    return group("spring", lines)


def damping(_, scales):
    return group("damping", [f"coefficient = {scales.text(3, length=2, mass=1, time=-1)}"])


def inertia_rate(dice, scales):
    """Slow changes, most of which leave a body that is one, and others."""
    size = scales.length**2 * scales.mass / scales.time
    numbers = [dice.uniform(-1, 1) * size * 10.0 ** -dice.uniform(0, 6) for _ in range(dice.choice((3, 6)))]
    lines = [f"tensor = {', '.join(map(number_text, numbers))}"]
    lines += [f"{key} = {scales.text(time=1)}" for key in ("start", "stop") if dice.random() < 0.3]
    lines += [f"mass_leaves = .{dice.choice(('true', 'false'))}."] if dice.random() < 0.5 else []
    return group("inertia_rate", lines)


TABLE = b"""t (s),x (N m),y (N m),z (N m)
-0.5,0.1,-0.2,0.3
0.25,2,1,0
0.25,-1,0,1.5
1.75,1e-3,0.5,-2
2,0.1,-0.2,0.3
"""


POINTS = b"""mass (kg),x (m),y (m),z (m)
1,0.12,0,0
2,0,0.09,0
3,-0.02,-0.03,0.08
"""


TRACK = b"""t (s),x (m),y (m),z (m),vx (m/s),vy (m/s),vz (m/s)
-2,1,0,0.5,0.1,0.4,0
0.5,1.2,1,0.5,0,0.5,0.1
2,1,2,0.7,-0.2,0.6,0
1e3,1e3,600,0.7,1,0.6,0
"""


INERTIA = b"""t (s),J1 (kg m2),J2 (kg m2),J3 (kg m2)
-2,1,1.5,2
0.5,1.2,1.5,2
2,1.2,1.6,2.5
1e3,1.2,1.6,2.7
"""


CENTER = b"""t (s),x (m),y (m),z (m)
-2,0,0,0.1
0.5,0.1,0,0.2
2,0.1,-0.2,0.3
1e3,0.1,-0.2,0.2
"""


MOTOR = b"""t (s),u (N m)
-0.5,0.1
0.25,2
0.25,-1
2,0.5
"""


def table(dice, scales):
    """A torque by the table that stands beside every scene."""
    lines = [f"table = '{dice.choice(('table.csv', 'table.csv', 'table.csv', 'absent.csv'))}'",
             f"outside = '{dice.choice(('zero', 'periodic'))}'", f"axes = '{dice.choice(('body', 'space'))}'",
             f"interpolation = '{dice.choice(('linear', 'linear', 'cubic'))}'"]
    lines += [f"{key} = {scales.text(time=1)}" for key in ("start", "stop") if dice.random() < 0.2]
    return group("torque", lines)


def torque(dice, scales):
    if dice.random() < 0.2:
        return table(dice, scales)
    lines = [f"{dice.choice(('body', 'space'))} = {scales.text(3, length=2, mass=1, time=-2)}"]
    if dice.random() < 0.5:
        lines += [f"frequency = {scales.text(time=-1)}", f"phase = {scales.text()}"]
    if dice.random() < 0.5:
        lines.append(f"start = {scales.text(time=1)}")
    if dice.random() < 0.5:
        lines.append(f"stop = {scales.text(time=1)}")
    return group("torque", lines)


def rotor(_, scales):
    return group("rotor", [f"momentum = {scales.text(3, length=2, mass=1, time=-1)}"])


def rotating_frame(dice, scales):
    if dice.random() < 0.3:
        return group("rotating_frame", [f"latitude = {dice.uniform(-90, 90)}", "degrees = .true."])
    return group("rotating_frame", [f"rate = {scales.text(3, time=-1)}"])


def orbit(dice, scales):
    if dice.random() < 0.1:
        return group("orbit", [f"table = '{dice.choice(('track.csv', 'track.csv', 'table.csv'))}'",
                               f"mu = {scales.text(signed=False)}", f"interpolation = '{dice.choice(('cubic', 'quintic'))}'"])
    lines = [f"semi_major_axis = {scales.text(length=1, signed=False)}", f"mu = {scales.text(length=3, time=-2, signed=False)}"]
    if dice.random() < 0.2:
        lines = [f"altitude = {10.0 ** dice.uniform(0, 8)}"]
    elif dice.random() < 0.3:
        lines.append(f"eccentricity = {dice.choice((0.0, 1e-17, 0.3, 0.999, 0.9999999999999999))}")
    angles = ["inclination", "raan", "argument_of_periapsis", "mean_anomaly"]
    if dice.random() < 0.3:
        shape = dice.choice((0.0, 0.5, 0.9999999999999999, 1.0, 1.0000000000000002, 4.0, scales.text()))
        lines = [f"periapsis_distance = {scales.text(length=1, signed=False)}", f"eccentricity = {shape}",
                 f"mu = {scales.text(length=3, time=-2, signed=False)}", f"periapsis_time = {scales.text(time=1)}"]
        angles.pop()
    if dice.random() < 0.2:
        lines += [f"name = '{dice.choice(('one', 'two'))}'", f"main = .{dice.choice(('true', 'false'))}."]
    lines += [f"{key} = {dice.uniform(-400, 400)}" for key in angles if dice.random() < 0.3]
    lines += dice.choice(([], ["degrees = .true."], ["frame = 'inertial'"], ["frame = 'lvlh'"]))
    if dice.random() < 0.4:
        lines.append(f"sun = {scales.text(3)}")
        lines += dice.choice(([], [f"shadow_radius = {scales.text(length=1, signed=False)}"]))
    return group("orbit", lines)


def third_degree(dice, scales):
    way = dice.random()
    if way < 0.5:
        lines = [f"third_moments = {scales.text(10, mass=1, length=3)}"]
    elif way < 0.9:
        points = [f"{scales.text(mass=1, signed=False)}, {scales.text(3, length=1)}" for _ in range(dice.choice((1, 2, 5)))]
        lines = ["points = " + ", ".join(points)]
    else:
        lines = [f"table = '{dice.choice(('points.csv', 'table.csv'))}'"]
    return group("third_degree", lines)


def earth_field(dice, scales):
    lines = [f"moment = {scales.text(3)}"] if dice.random() < 0.8 else []
    if dice.random() < 0.5:
        lines.append(f"epoch_angle = {dice.uniform(-400, 400)}")
    if dice.random() < 0.5:
        lines.append(f"coefficients = {scales.text(3)}")
    lines += dice.choice(([], ["degrees = .true."]))
    return group("earth_field", lines)


def force(dice, scales):
    lines = [f"body_point = {scales.text(3, length=1)}", f"force = {scales.text(3, length=1, mass=1, time=-2)}",
             f"axes = '{dice.choice(('space', 'body', 'lvlh', 'inertial'))}'"]
    lines += [f"{key} = {scales.text(time=1)}" for key in ("start", "stop") if dice.random() < 0.2]
    return group("force", lines)


def wheel(dice, scales):
    lines = [f"axis = {scales.text(3)}", f"inertia = {scales.text(length=2, mass=1, signed=False)}"]
    if dice.random() < 0.7:
        lines.append(f"speed = {scales.text(time=-1)}")
    way = dice.random()
    if way < 0.15:
        lines += ["table = 'motor.csv'", f"outside = '{dice.choice(('zero', 'periodic'))}'"]
    elif way < 0.8:
        lines.append(f"torque = {scales.text(length=2, mass=1, time=-2)}")
    if way >= 0.15 and dice.random() < 0.3:
        lines += [f"frequency = {scales.text(time=-1)}", f"phase = {scales.text()}"]
    if dice.random() < 0.2:
        lines.append(f"torque_limit = {scales.text(length=2, mass=1, time=-2, signed=False)}")
    if dice.random() < 0.2:
        lines.append(f"speed_limit = {scales.text(time=-1, signed=False)}")
    if dice.random() < 0.5:
        lines.append(f"friction = {scales.text(length=2, mass=1, time=-1, signed=False)}")
    lines += [f"{key} = {scales.text(time=1)}" for key in ("start", "stop") if dice.random() < 0.3]
    return group("wheel", lines)


def inner_sphere(dice, scales):
    lines = [f"inertia = {scales.text(length=2, mass=1, signed=False)}",
             f"damping = {scales.text(length=2, mass=1, time=-1, signed=False)}"]
    if dice.random() < 0.5:
        lines.append(f"angular_velocity = {scales.text(3, time=-1)}")
    return group("inner_sphere", lines)


def controller(dice, scales):
    lines = [f"sample = {scales.text(time=1, signed=False)}"] if dice.random() < 0.5 else []
    if dice.random() < 0.3:
        lines.append(f"limit = {scales.text(length=2, mass=1, time=-2, signed=False)}")
    if dice.random() < 0.3:
        lines += ["law = 'bdot'", f"gain = {scales.text(signed=False)}"]
        lines += dice.choice(([], [f"field = {scales.text(3)}"]))
    else:
        lines += ["law = 'quaternion'", f"attitude_gain = {scales.text(time=-2, signed=False)}",
                  f"rate_gain = {scales.text(time=-1, signed=False)}", *dice.choice((["gains = 'inertia'"], ["gains = 'scalar'"],
                                  [f"inertia = {scales.text(3, length=2, mass=1, signed=False)}"]))]
        lines += dice.choice(([], ["target = 0.0, 0.6, 0.0, -0.8"]))
        lines += dice.choice(([], [], ["target_from = 'lvlh'"]))
        lines += dice.choice(([], ["by = 'wheels'"], ["by = 'magnetorquers'", f"field = {scales.text(3)}"]))
    lines += [f"{key} = {scales.text(time=1)}" for key in ("start", "stop") if dice.random() < 0.2]
    return group("controller", lines)


def from_samples(name, keys):
    """An effect of the samples without a function of its own: its numbers, each scaled at random."""

    def effect(dice, _):
        lines = [f"{key} = " + ", ".join(number_text(float(number) * 10.0 ** dice.uniform(-3, 3))
                                         for number in numbers.split(",")) for key, numbers in keys]
        return group(name, lines)

    return effect


EVENT_COLUMNS = [*(f"q{i}" for i in range(4)), *(f"omega{i}" for i in (1, 2, 3)), "omega_x", "L1", "l_z", "p0", "phi", "theta",
                 "psi", "kinetic", "potential", "total", "jacobi", "wheel1_speed",
                 "wheel2_momentum", "sphere1_rate2", "sphere1_energy", "roll", "pitch", "yaw", "orbit_radius", "true_anomaly",
                 "shadow_depth", "energy_ratio", "rotation_period", "pole_longitude", "pole_latitude"]

# In the units of a scene, and then those that have no function of their own.
EFFECTS = [gravity, dipole, gravity_gradient, spring, damping, torque, rotor, rotating_frame, orbit, earth_field, third_degree,
           force, wheel, inner_sphere, controller, inertia_rate]
EFFECTS += [from_samples(name, keys) for name, keys in read_effects().items()
            if name not in [effect.__name__ for effect in EFFECTS]]


def group(name, lines):
    return "&" + name + "\n" + "".join(f"   {line}\n" for line in lines) + "/\n"
