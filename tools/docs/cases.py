"""Runs the published cases of small bodies, satellites and tops and writes docs/results/validation.md: the numbers of nutate beside
those of references and papers.

    python3 tools/docs/cases.py PROGRAM [CASE...]

Each case is a part of the page between markers; without CASE all of them are written. References of 16 digits were computed in 128-bit
arithmetic by two independent methods; the unit tests compare with them too. Files stay in build/cases/.
"""

import csv
import json
import math
import os
import re
import subprocess
import sys

DATA = "build/cases"
PAGE = "docs/results/validation.md"
SERIES = "&integrator method = 'taylor', local_tolerance = 1e-15, end_time = {} /\n"
PROGRAM = ["build/nutate"]


def nutate(*arguments):
    """Returns what the program prints."""
    done = subprocess.run([PROGRAM[0], *arguments], check=True, capture_output=True, text=True, encoding="utf-8")
    return done.stdout + done.stderr


def scene_file(name, text):
    path = f"{DATA}/{name}.nml"
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def rows_of(path):
    """Returns the rows of a CSV file as numbers by name."""
    with open(path, encoding="utf-8", newline="") as lines:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(lines)]


def history(name, scene, *settings):
    """Runs a scene, by its path, and returns the rows of its history."""
    path = f"{DATA}/{name}.csv"
    command = ["run", scene, "--quiet", "--output", path]
    for setting in settings:
        command += ["--set", setting]
    nutate(*command)
    return rows_of(path)


def run(name, text, *settings):
    return history(name, scene_file(name, text), *settings)


def states(name, text, times):
    """Returns attitude and angular velocity at some times; shape (times, 7)."""
    keys = ("q0", "q1", "q2", "q3", "omega1", "omega2", "omega3")
    text += "&output columns = 'quaternion', 'angular_velocity', times = " + ", ".join(map(repr, times)) + " /\n"
    return [[row[key] for key in keys] for row in run(name, text + SERIES.format(times[-1]))]


def away(found, expected):
    """Returns the largest difference of components, the attitude up to its sign; rates in their own size."""
    sign = 1 if sum(a*b for a, b in zip(found[:4], expected[:4])) > 0 else -1
    size = max(map(abs, expected[4:]), default=1.0)
    attitude = max(abs(sign*a - b) for a, b in zip(found[:4], expected[:4]))
    return max([attitude] + [abs(a - b)/size for a, b in zip(found[4:], expected[4:])])


def last_and_worst(name, text, expected):
    """Returns the state at the last of the times of a reference, and the largest difference at all of them."""
    found = states(name, text, [row[0] for row in expected])
    return found[-1], max(away(state, row[1:]) for state, row in zip(found, expected))


def angle_between(p, q):
    """Returns the angle between two attitudes, degrees."""
    cross = [p[0]*q[k] - q[0]*p[k] - (p[1:] + p[1:])[k % 3]*(q[1:] + q[1:])[(k + 1) % 3]
             + (p[1:] + p[1:])[(k + 1) % 3]*(q[1:] + q[1:])[k % 3] for k in (1, 2, 3)]
    return math.degrees(2*math.atan2(math.hypot(*cross), abs(sum(a*b for a, b in zip(p, q)))))


def small(value):
    return f"{value:.1e}"


def table(head, rows):
    lines = [f"| {' | '.join(map(str, row))} |" for row in (head, *rows)]
    return "\n".join([lines[0], "|---"*len(head) + "|", *lines[1:]]) + "\n"


def floats(text):
    return [[float(word) for word in line.split()] for line in text.strip().splitlines()]


CONICS = floats("""
0.99999999 10 6.8047207401239575 -4.8047207981711655 4.8185975555855024
0.99999999 1000 164.10241671040841 -162.1024183414326 25.542300954606797
1 1 1.3912782187175312 0.60872178128246875 1.2510447133776334
1 1000 164.10244397119079 -162.10244397119079 25.542313440343714
1.00000001 10 6.8047208641878095 -4.8047208061406015 4.8185977228393426
1.00000001 1000 164.1024712319693 -162.1024696009446 25.542325926080856
1.2 1 1.4579181635848267 0.61840153034597773 1.3202669877628185
1.2 1000 467.54913398062424 -387.79094498385353 261.19030547583805
4.25390187321279 10 18.813137367148379 -3.1874819631640631 18.541146036038291""")
BODY = "&gravity_gradient /\n&initial quaternion = 0.9, 0.1, -0.3, 0.3, angular_velocity = 0.2, -0.1, 0.5 /\n"
TWO = ("&body inertia = 1, 1.5, 2.2 /\n&orbit name = 'one', mu = 1, periapsis_distance = 1, eccentricity = 0.3, inclination = 0.4, "
       "raan = 0.5,\n   argument_of_periapsis = 0.6, main = .true. /\n&orbit name = 'two', mu = 0.3, periapsis_distance = 1.2, "
       "eccentricity = 1.5, inclination = 1.1,\n   raan = 2, argument_of_periapsis = -0.7, periapsis_time = 4 /\n" + BODY)
THIRD = ("&body inertia = 0.05, 0.06, 0.075 /\n&orbit mu = 1, periapsis_distance = 1, eccentricity = 1.5, inclination = 0.4, raan = 0.5,"
         "\n   argument_of_periapsis = 0.6, periapsis_time = 4 /\n&third_degree third_moments = 10e-4, -4e-4, 7e-4, 2e-4, -3e-4, "
         "1e-4, 5e-4, -2e-4, -6e-4, 3e-4 /\n" + BODY)
TWO_ROWS = floats("""
1 0.7655337213363232 0.03772515024456461 -0.2629950965715646 0.5859765470693337 0.1194884072933048 0.08539653256861043 0.7644858159901559
4 -0.5130885106498339 -0.0742403825608845 0.1885921826410025 0.8340632676740126 0.4349022778343656 0.3181700730084481 1.002698721075141
8 -0.4753808468051067 0.1345927352418627 0.08909232438099646 -0.8648470407230199 -0.2105660882743414 -0.3900494506410578 1.013665773480139
12 0.7342298005202412 0.6128511073604635 -0.01212149811978699 -0.2918444611747712 0.7824378433780706 0.9687407841357545 0.1112675942196829
""")
THIRD_ROWS = floats("""
2 0.5855886197344764 0.1344705350599183 -0.2927018539197035 0.7438610544652399 0.2272494149997771 -0.01716619073740479 0.5131255184707867
4 0.06320989886681358 0.07840220916525724 -0.1416595949074498 0.9847792450361206 0.2400211694569789 0.05006243451493634 0.6667262753951525
6 -0.5710787822415679 -0.0910272414345521 -0.05005395049066472 0.814295811011319 0.04671025281662878 0.1199025173786163 0.674693088862863
8 -0.9443045649881078 -0.1991709678380682 -0.04019038365510185 0.2588523655961509 -0.02081787412167031 0.1363025286501634 0.6824091190211093
""")


def open_orbits():
    errors = {}
    for e, t, *expected in CONICS:
        text = (f"&body inertia = 1, 1.5, 2.2 /\n&orbit mu = 1, periapsis_distance = 1, eccentricity = {e!r} /\n&gravity_gradient /\n"
                f"&initial angular_velocity = 0, 0, 0.1 /\n&output columns = 'orbit', times = {t!r} /\n"
                f"&integrator local_tolerance = 1e-6, end_time = {t!r} /\n")
        found = [run("conic", text)[0][key] for key in ("orbit_radius", "orbit_x", "orbit_y")]
        errors.setdefault(f"{e:.10g}", []).append(max(abs(a - b) for a, b in zip(found, expected))/expected[0])
    rows = []
    for name, text, expected, title in (("two", TWO, TWO_ROWS, "between two bodies, on an ellipse and a hyperbola"),
                                        ("third", THIRD, THIRD_ROWS, "with third moments, on a hyperbola")):
        state, worst = last_and_worst(name, text, expected)
        rows.append((title, f"{expected[-1][0]:g}", f"{state[0]:.12f}", f"{state[6]:.12f}", small(worst)))
    return ("Suites `flyby` and `third_degree`. In the units $\\mu = q = 1$, $q$ the periapsis distance, positions on conic orbits have these "
            "largest errors\nrelative to $r$ at the times of the reference, $t$ from 1 to 1000:\n\n"
            + table(("$e$", *errors), [("error", *(small(max(values)) for values in errors.values()))])
            + "\nFlybys:\n\n" + table(("body", "$t$", "$q_0$", "$\\Omega_3$", "difference"), rows))


def wobble(row, turns):
    """The libration of a body that turns `turns` times in a revolution, rad."""
    angle = 2*math.atan2(row["q3"], row["q0"]) - turns*row["t"]
    return abs(angle - 2*math.pi*round(angle/(2*math.pi)))


def librations():
    cases = (("Phobos", "0.3615, 0.4265, 0.5024", 0.0151, "1:1", 1.0, 0.98057115494161526, 1.095466160498906, 1.555055509728412, 1,
              0.622129699614924, "°", 1), ("Mercury", "0.9995, 0.999703, 1.0", 0.2056, "3:2", 1.5, 1.500129574985609, 36.81041541414131,
                                           1.748838156774148, 0, 0.0199651934142077622, "″", 3600))
    rows = []
    for name, inertia, e, ratio, turns, rate, largest, place, whole, free, unit, parts in cases:
        text = (f"&body inertia = {inertia} /\n&orbit semi_major_axis = 1, mu = 1, eccentricity = {e} /\n&gravity_gradient /\n"
                f"&initial resonance = '{ratio}' /\n&output columns = 'quaternion', 'angular_velocity', times = 0, {place} /\n"
                + SERIES.format(place))
        start, later = run(name.lower(), text)
        a = json.loads(nutate("linearize", f"{DATA}/{name.lower()}.nml", "--period", "orbit", "--set", "integrator.method='dop853'",
                              "--quiet", "--json", "-"))["A"]
        found = abs(whole - math.acos((a[2][2] + a[5][5])/2)/(2*math.pi))
        width = math.degrees(wobble(later, turns))*parts
        rows += [(f"{name}: $\\Omega_3$ at periapsis", f"{start['omega3']:.14f} $n$", f"{rate:.14f} $n$",
                  small(abs(start["omega3"] - rate))),
                 (f"{name}: forced libration", f"{width:.11f}{unit}", f"{largest:.11f}{unit}",
                  small(math.radians(abs(width - largest)/parts)) + " rad"),
                 (f"{name}: free libration", f"{found:.13f} $n$", f"{free:.13f} $n$", small(abs(found - free)))]
    return ("Suite `periodic_start`. [`resonance`](../reference/scenes/initial.md#periodic-motions-resonance) starts on the periodic\n"
            "motion, which has the forced libration alone. The Floquet multipliers of one revolution give the free libration. $n$ is the mean motion.\n\n"
            + table(("quantity", "nutate", "reference", "difference"), rows))


CYLINDER = ("&body inertia = 500, 12250, 12250 /\n&orbit semi_major_axis = 6756095, frame = 'lvlh' /\n&gravity_gradient /\n&initial attitude_from = 'lvlh', "
            "rate_from = 'lvlh', {} /\n")
START = "quaternion = 0.7372492635482824, 0.005895561929111876, 0.6755644832106784, 0.006433876851820143, angular_velocity = 0, {}, 0"
OMEGA1 = -1.984177793105603e-05
CYLINDER_ROWS = {"10A": (0.0, floats(f"""
600 0.7194419393815384 0.0001917050359229728 0.6945465801103467 0.002882215316699578 {OMEGA1} -0.0009828028737645809 -4.029531611761019e-05
3600 0.7309045724934126 -0.02357918166414719 0.6817883701816931 0.01967603581165482 {OMEGA1} -0.001031237681779574 -0.0001007294919531874
14400 0.6746597213015703 -0.08831877448183007 0.7253031489142182 0.1047348877043107 {OMEGA1} -0.001002120776779925 -0.000308779637059417
28800 0.6933292149560277 -0.1965545847447972 0.6670678718650391 0.1888950746570871 {OMEGA1} -0.001075275770224725 -0.0007088567190357103
""")), "10B": (0.00017453292519943296, floats(f"""
600 0.6900135514053427 0.0002215795587781857 0.7237880997488715 0.003469357491410394 {OMEGA1} -0.000912328719676459 -3.958029237280174e-05
28800 0.7181212929138288 -0.2042288769354876 0.6400112106782583 0.1815985261382661 {OMEGA1} -0.001030730672601492 -0.0006821076766417492
"""))}


def check_cases():
    rows = []
    for case, (rate, expected) in CYLINDER_ROWS.items():
        state, worst = last_and_worst(case, CYLINDER.format(START.format(repr(rate))), expected)
        q = state[:4]
        x, y, z = 1 - 2*(q[2]**2 + q[3]**2), 2*(q[1]*q[2] + q[0]*q[3]), 2*(q[1]*q[3] - q[0]*q[2])
        rows.append((case, f"{math.degrees(math.atan2(x, -z)):.10f}°", f"{math.degrees(math.asin(y)):.10f}°", small(worst)))
    scene = scene_file("cylinder", CYLINDER.format(f"roll_pitch_yaw = 0, {math.pi/2!r}, 0, angular_velocity = 3*0") + SERIES.format(6000))
    values = json.loads(nutate("linearize", scene, "--quiet", "--json", "-"))["eigenvalues"]
    periods = sorted({round(2*math.pi/value[1], 6) for value in values if value[1] > 1e-4})
    swings = [(f"small swings {name}", f"{found:.6f} s", f"{expected:.6f} s") for name, found, expected in
              zip(("across the plane", "in the plane of the orbit"), periods, (2806.5697607408, 3257.9400294036904))]
    return ("Suite `check_cases`. NESC check cases ([NASA/TM-2015-218675](https://ntrs.nasa.gov/citations/20150001263)) as JEOD has them: a "
            "long cylinder under the\ngravity gradient for 8 hours, initially at rest in the LVLH frame (10A) or with a pitch rate (10B). "
            "Angles of the long axis from the vertical at the end:\n\n"
            + table(("case", "in the plane", "across", "difference"), rows) + "\n"
            + table(("period of", "nutate, `linearize`", "closed form"), swings)
            + "\nJEOD states 2821.46 s across the plane, the period of a body that cannot yaw.\n")


APOPHIS_ROWS = {"A": ("0", "0", floats("""
172800 0.1832636741234202 -0.7786250007370177 -0.5570360380197681 0.2233123066946906 2.969730825063049e-06 2.645732155063629e-05 3.466941410818314e-05
345600 -0.2178522418772809 0.7838006475355681 0.5414617749226201 -0.2121699600073314 -1.692884403370018e-06 3.16674253201309e-05 1.848700642328027e-05
""")), "C": ("0.5", "120", floats("""
172800 -0.1330127857162137 -0.3808288507991365 -0.8792740123242034 -0.2532867870346147 -4.871525162167504e-06 -3.083526380547306e-05 4.190142227441394e-05
345600 -0.1126480486438868 0.05510279664969389 -0.9836563050091814 -0.1292067047555632 1.03896180443254e-05 -1.962303863147729e-05 6.441722016145258e-05
"""))}


def apophis():
    rows = []
    for case, (phase, angle, expected) in APOPHIS_ROWS.items():
        found = history(f"apophis_{case}", "scenes/apophis.nml", "initial.rotation_phase=" + phase, "initial.precession_angle=" + angle,
                        "integrator.local_tolerance=1e-15", "output.interval=172800")
        for row, one in zip(expected, found[1:]):
            state = [one[key] for key in ("q0", "q1", "q2", "q3", "omega1", "omega2", "omega3")]
            rows.append((case, f"{(row[0] - 172800)/86400:g} d", f"{state[0]:.12f}", f"{state[6]:.11e}", small(away(state, row[1:]))))
    before = history("apophis_start", "scenes/apophis_ensemble.nml")[0]
    nutate("sweep", "scenes/apophis_ensemble.nml", "--quiet", "--output", f"{DATA}/ensemble.npy", "--csv", f"{DATA}/ensemble.csv")
    vector = lambda row: [row[key] for key in ("l_x", "l_y", "l_z")]
    rate = lambda row: 2*row["kinetic"]/math.hypot(*vector(row))
    with open(f"{DATA}/ensemble.csv", encoding="utf-8", newline="") as lines:
        members = [{key: float(row[key]) for key in ("l_x", "l_y", "l_z", "kinetic", "short_axis_mode")} for row in csv.DictReader(lines)]
    rates = sorted(rate(row)/rate(before) for row in members)
    cosine = lambda row: sum(a*b for a, b in zip(vector(row), vector(before)))/math.hypot(*vector(row))/math.hypot(*vector(before))
    turns = sorted(math.degrees(math.acos(max(-1, min(1, cosine(row))))) for row in members)
    middle = len(members)//2
    share = sum(row["short_axis_mode"] for row in members)/len(members)
    return ("Suite `flyby`. Two initial states two days before the passage of 13 April 2029, integrated for four days "
            "(scene [apophis](../gallery/moons-asteroids.md#apophis-passes-the-earth)):\n\n"
            + table(("state", "after periapsis", "$q_0$", "$\\Omega_3$, rad/s", "difference"), rows)
            + f"\n`nutate sweep scenes/apophis_ensemble.nml` runs {len(members):,} members with "
            "the periods of\n[Lee et al. (2022)](https://doi.org/10.1051/0004-6361/202243442), their standard deviations, and uniform phases.\n\n"
            + table(("after the passage", "smallest", "median", "largest"),
                    [("spin rate $2T/\\lvert l\\rvert$, over that before", *(f"{rates[i]:.2f}" for i in (0, middle, -1))),
                     ("rotation of the direction of $l$", *(f"{turns[i]:.2f}°" for i in (0, middle, -1)))])
            + f"\n{100*share:.1f} % stay in the short-axis mode, the others change to the long-axis mode. "
            "[Benson et al. (2023)](https://doi.org/10.1016/j.icarus.2022.115324)\nfound that the rate may halve or double, and the pole move by 10° or "
            "more.\n\n"
            "![Distribution of the spin rate after the passage, and its map over the phases before](../figures/apophis_ensemble.svg)\n")


def toutatis():
    scene = "test/cases/toutatis.nml"
    off = ["gravity_gradient.1.on=.false.", "gravity_gradient.2.on=.false."]
    radar = rows_of("scenes/toutatis_radar.csv")
    first = 2001013.0
    times = "output.times=" + ",".join(repr(first + row["t"]) for row in radar)
    attitude = lambda row: [row[key] for key in ("q0", "q1", "q2", "q3")]
    runs = {name: [attitude(row) for row in history("toutatis_" + name, scene, times, *settings)]
            for name, settings in (("free", off), ("sun", off[1:]), ("both", []))}
    expected = (8.0, 7.9, 15.9, 9.4, 2.1, 15.3, 3.3, 3.5, 3.4, 3.0, 3.2, 5.6, 5.1, 8.4, 8.7, 1.3, 6.6)
    norm = lambda values: math.sqrt(sum(value**2 for value in values)/len(values))
    errors = {name: [angle_between(q, attitude(row)) for q, row in zip(found, radar)] for name, found in runs.items()}
    fitted = dict(re.findall(r"body\.inertia\.(\d) +(.*)", nutate("fit", "scenes/toutatis.nml", "--output", f"{DATA}/fit.nml", "--csv",
                                                                 f"{DATA}/fit.csv")))
    turned = [("Sun, until 2 December", angle_between(runs["sun"][0], runs["free"][0]), "0.29°"),
              ("Sun, until 18 December", angle_between(runs["sun"][-1], runs["free"][-1]), "0.54°"),
              ("Earth, until 18 December", angle_between(runs["both"][-1], runs["sun"][-1]), "0.04°")]
    apart = max(abs(error - value) for error, value in zip(errors["free"], expected))
    return ("Suites `tumbling` and `fit`. The state of 9 November 1992 of "
            "[Takahashi, Busch and Scheeres (2013)](https://doi.org/10.1088/0004-6256/146/4/95),\nintegrated to the 17 epochs of radar "
            f"images in December. The angles to the attitudes by radar differ from the published ones by at most {apart:.2f}°, their\nrounding.\n\n"
            + table(("quantity", "nutate", "published"),
                    [("rms angle to the radar, free motion", f"{norm(errors['free']):.2f}°", "7.70°"),
                     ("rms angle with Sun and Earth", f"{norm(errors['both']):.2f}°", "")]
                    + [("rotation by the " + name, f"{value:.3f}°", text) for name, value, text in turned]
                    + [("$J_1/J_3$, by `nutate fit scenes/toutatis.nml`", fitted["1"], "3.0836"), ("$J_2/J_3$", fitted["2"], "3.235")])
            + "\nTwo rounded elements of the orbit are fitted to the closest approach to the Earth; the choice changes the rotations by the\n"
            "Sun by a few per cent.\n")


TOPS = (("Kovalevskaya", "2, 2, 1", "0.3, -0.5, 1.2", lambda w, g: (w[0]**2 - w[1]**2 + g[0])**2 + (2*w[0]*w[1] + g[1])**2, floats("""
5 0.5234077294793439 -0.6072673873144912 -0.02424655345636298 -0.5972292471664441 0.4524398226279543 1.199009461742076 0.5803651844262966
20 0.2830477476422388 -0.9449708572303368 -0.1367554262393558 0.0906201132978218 0.09779413878612736 -0.3913154870499697 1.267642216457804
""")), ("Goryachev, Chaplygin", "4, 4, 1", "0.5, -0.07, 0.96", lambda w, g: w[2]*(w[0]**2 + w[1]**2) + w[0]*g[2], floats("""
5 0.1512358987663099 -0.6635941566840519 -0.6896788701663514 -0.2472115575477681 0.1023236945803238 0.7682786836280707 0.7821255005518101
20 0.5229094690640181 0.4230897854291477 -0.2901129018815057 -0.6807313896028274 0.5387015348486249 0.1149944472706855 0.4269389622799929
""")))


def tops():
    rows = []
    for name, inertia, omega, integral, expected in TOPS:
        text = (f"&body inertia = {inertia} /\n&dipole moment = 1, 0, 0, field = 0, 0, 1 /\n"
                f"&initial quaternion = 0.8, 0.6, 0, 0, angular_velocity = {omega} /\n")
        state, worst = last_and_worst("top", text, expected)
        found = run("long", text + "&integrator method = 'taylor', time_step = 0.1, end_time = 1e4 /\n"
                    "&output columns = 'quaternion', 'angular_velocity', 'energy', interval = 10 /\n")
        values = []
        for row in found:
            q = [row[f"q{k}"] for k in range(4)]
            gamma = (2*(q[1]*q[3] - q[0]*q[2]), 2*(q[2]*q[3] + q[0]*q[1]), q[0]**2 - q[1]**2 - q[2]**2 + q[3]**2)
            values.append(integral([row[f"omega{k}"] for k in (1, 2, 3)], gamma))
        rows.append((name, f"{state[0]:.13f}", f"{state[6]:.13f}", small(worst),
                     small(max(abs(value - values[0]) for value in values))))
    return ("Suite `classical_tops`. $V = -m\\cdot R^T\\hat z$ with $m = (1, 0, 0)$; the state at $t = 20$. The "
            "last\ncolumn is its largest drift over 100 000 steps of the Taylor series, in which $10^5$ rounding errors could "
            "add up to 2.2e-11.\n\n" + table(("top", "$q_0$", "$\\Omega_3$", "difference", "drift"), rows))


GYROSTATS = (((0, 0, 0), (4, 8, 8, 4)), ((0.1, 0.2, 0.15), (4, 8, 8, 4)), ((0.3, 0.5, 0.4), (2, 6, 6, 2)), ((0, 1, 0), (2, 6, 8, 4)),
             ((1, 1.5, 1), (2, 4, 4, 2)), ((3, 5, 4), (2, 2, 2, 2)))


def gyrostats():
    scene = scene_file("gyrostat", "&body inertia = 3, 4, 2 /\n&rotor momentum = 0, 0, 0 /\n&orbit semi_major_axis = 1, mu = 1 /\n"
                       "&gravity_gradient /\n&initial angular_velocity = 0, 0, 0 /\n&integrator time_step = 0.1, end_time = 1 /\n")
    rows = []
    for momentum, expected in GYROSTATS:
        found = json.loads(nutate("linearize", scene, "--equilibria", "--quiet", "--json", "-", "--set",
                                  "rotor.momentum=" + ",".join(map(str, momentum))))["equilibria"]
        counts = [sum(one["index"] == index for one in found) for index in range(4)]
        if tuple(counts) != expected:
            sys.exit(f"cases: at h = {momentum} there are {counts} equilibria, not {expected}")
        rows.append((", ".join(map(str, momentum)), len(found), ", ".join(map(str, counts)), sum(one["growth"] == 0 for one in found)))
    return ("Suite `equilibria`. A gyrostat on a circular orbit is at rest in the LVLH frame if\n\n"
            "$$ 3\\, g\\times Jg = b\\times(Jb - h), $$\n\nwith the orbit normal $b$ and the vertical $g$ in body axes, and the momentum $h$ of the "
            "rotor in units of the mean motion; $J = (3, 4, 2)$. `nutate\nlinearize --equilibria` finds all equilibria. The index counts the "
            "directions in which the effective potential falls. The reference, which solved\nthe equations from 1200 initial guesses, has the same "
            "numbers.\n\n"
            + table(("$h$", "equilibria", "of index 0, 1, 2, 3", "stable to first order"), rows)
            + "\n[Gutnik and Sarychev (2013)](https://doi.org/10.1007/978-3-319-02297-0), in the proceedings of CASC, show "
            "that there are between 8 and 24. At $h = (0, 1, 0)$ two pairs have just met.\n")


CASES = {"orbits": ("Conic orbits and flybys", open_orbits), "librations": ("Phobos and Mercury: librations", librations),
         "nesc": ("A cylinder on a circular orbit: NESC 10A and 10B", check_cases), "toutatis": ("Toutatis in 1992", toutatis),
         "apophis": ("Apophis passes the Earth in 2029", apophis), "tops": ("Tops with a fourth integral", tops),
         "gyrostats": ("Equilibria of a gyrostat in orbit", gyrostats)}


def main(program, *chosen):
    PROGRAM[0] = program
    os.makedirs(DATA, exist_ok=True)
    for name in chosen or CASES:
        title, write = CASES[name]
        part = f"## {title}\n\n{write()}"
        with open(PAGE, encoding="utf-8") as file:
            text = file.read()
        begin, end = f"<!-- begin {name} -->\n", f"<!-- end {name} -->\n"
        if begin not in text or end not in text:
            sys.exit(f"cases: {PAGE} lacks the markers of '{name}'")
        with open(PAGE, "w", encoding="utf-8") as file:
            file.write(text.split(begin)[0] + begin + part + end + text.split(end)[1])
        print(f"Written: {PAGE}, {name}")


if __name__ == "__main__":
    main(*sys.argv[1:])
