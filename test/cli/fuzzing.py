"""Scenes nobody would write: mutated files and legal files with extreme values, each made from a seed and a number.

The same seed and number give the same case on every machine, as long as `scenes/` stays the same.
"""

import os
import pathlib
import random
import re
import resource
import subprocess
import tempfile

from support import COLUMNS, METHODS, ROOT

LONGEST_RUN = 1000

# What a run or a check may take of processor time, s, and how long a hanging one is waited for. Sanitizers and their like
# take their time.
ALLOWED_SECONDS = 20.0 if os.environ.get("NUTATE_SLOW_BUILD") else 1.0
PATIENCE = 60.0


def read_bases():
    """The shipped scenes, shortened, as bytes."""
    return [path.read_bytes() for path in sorted((ROOT / "scenes").glob("*.nml"))]


def read_effects():
    """The first group of each effect in test/effect_samples.nml: keys and numbers by name."""
    text = (ROOT / "test" / "effect_samples.nml").read_text(encoding="utf-8")
    found = {}
    for name, body in re.findall(r"^&(\w+)\n(.*?)^/", text, flags=re.DOTALL | re.MULTILINE):
        if name not in ("scene", "body", "initial", "integrator", "output"):
            found.setdefault(name, re.findall(r"(\w+) = ([-+.\d, ]+)", body))
    return found


BASES = read_bases()

NUMBERS = [
    b"0", b"-0.0", b"1", b"-1", b"2.5", b"1e-5", b"1d3", b"1e308", b"-1e308", b"1.7976931348623157e308", b"1e309",
    b"1e999", b"-1e999", b"1e99999999999999999999", b"2.2250738585072014e-308", b"5e-324", b"1e-310", b"1e-400",
    b"1e-999999999", b"1e100", b"1e-100", b"1e150", b"1e-150", b"1e50", b"1e-50", b"NaN", b"-NaN", b"nan(1)", b"Inf",
    b"-Infinity", b"+inf", b"0x1p3", b"1e", b"e5", b".", b"-", b"+.e1", b"1.2.3", b"1,5", b"9223372036854775807",
    b"9223372036854775808", b"-2147483649", b"2147483648", b"3*1.0", b"0*1", b"99999999*1", b"2147483648*0.5", b"3*",
    b"(1,2)", b"1_8", b"1e+-5", b"0." + 400 * b"0" + b"1", b"1" + 400 * b"0", 5000 * b"9", b"1e-" + 300 * b"0" + b"5",
]
WORDS = [
    b"&", b"/", b"=", b",", b"'", b'"', b"!", b"(", b")", b"%", b";", b":", b"*", b"&end", b"&body", b"&initial",
    b"&integrator", b"&scene", b"&output", b"&nothing", b"&&body", b"& body", b"$body", b"''", b"'''", b"' / &body '",
    b".true.", b".false.", b"T", b".t", b".maybe.", b"'box'", b"'lapack'", b"'reduced'", b"Infinity", b"\n", b"\n\n",
    b"title = 'a\nb'", b"inertia(2) = 7", b"body%mass = 1", b"=/", b"every = 0", b"shape = 'box'", b"mass = 1.0",
]
RAW = [
    b"\x00", b"\x00\x00\x00\x00", b"\xff\xfe", b"\xef\xbb\xbf", b"\xc3\xa9", b"\xe2\x82\xac", b"\xf0\x9f\x98\x80",
    b"\xc3", b"\x80\x80", b"\x1b[31m", b"\x07", b"\x08", b"\x0b", b"\x0c", b"\x1a", b"\x7f", b"\x85", b"\t", b"\r",
    b"\r\n", b"\xa0", b"\xe2\x80\xa8", b"\xe3\x80\x80",
]
TOKEN = re.compile(rb"'[^'\n]*'|[\w.+-]+|[^\w\s]|\s+")


class Case:
    """One case: the bytes of the scene file and the overrides of the command line."""

    def __init__(self, text, overrides, legal):
        self.text = text
        self.overrides = overrides
        # Written key by key, not mutated.
        self.legal = legal


def make_case(seed, number):
    """The case of that seed and number."""
    dice = random.Random(f"nutate {seed} {number}")
    legal = dice.random() < 0.5
    if legal:
        return Case(write_scene(dice), [], True)
    text = write_scene(dice) if dice.random() < 0.3 else dice.choice(BASES)
    # Mostly one or two mutations: files with more fail at the first line.
    for _ in range(dice.choice((0, 1, 1, 1, 1, 2, 2, 3, 6, 20))):
        text = dice.choice(MUTATIONS)(dice, text)
    if dice.random() < 0.002:
        text = stretch(dice, text)
    return Case(text, make_overrides(dice), False)


# ---------------------------------------------------------------------------------------------------------------------
# Mutations of a text
# ---------------------------------------------------------------------------------------------------------------------


def change_tokens(change):
    """A mutation from what changes the list of tokens at one index."""

    def mutate(dice, text):
        tokens = TOKEN.findall(text)
        places = [i for i, token in enumerate(tokens) if token.strip()]
        if not places:
            return text
        change(dice, tokens, dice.choice(places), dice.choice(places))
        return b"".join(tokens)

    return mutate


def swap_tokens(_, tokens, i, k):
    tokens[i], tokens[k] = tokens[k], tokens[i]


def repeat_token(dice, tokens, i, _):
    tokens[i] = b" ".join([tokens[i]] * dice.choice((2, 2, 3, 100)))


def delete_token(_, tokens, i, k):
    tokens[i] = b""


def replace_token(dice, tokens, i, _):
    tokens[i] = dice.choice(WORDS + NUMBERS)


def insert_token(dice, tokens, i, _):
    tokens[i] += b" " + dice.choice(WORDS + NUMBERS + RAW) + b" "


def replace_number(dice, text):
    """Puts another value in the place of a number."""
    places = list(re.finditer(rb"(?<=[\s,=])[-+]?\d[\w.+-]*", text))
    if not places:
        return text
    place = dice.choice(places)
    value = dice.choice(NUMBERS) if dice.random() < 0.5 else number_text(extreme(dice)).encode()
    return text[: place.start()] + value + text[place.end():]


def misspell(dice, text):
    """Changes one letter of a word."""
    places = list(re.finditer(rb"[a-z_]{3,}", text))
    if not places:
        return text
    i = dice.randrange(*dice.choice(places).span())
    return text[:i] + dice.choice((b"", b"x", b"_", text[i:i + 1] * 2, b"A", b" ")) + text[i + 1:]


def change_lines(dice, text):
    """Deletes, doubles, swaps, joins or comments out lines."""
    lines = text.split(b"\n")
    i, k = dice.randrange(len(lines)), dice.randrange(len(lines))
    way = dice.randrange(5)
    if way == 0:
        del lines[i]
    elif way == 1:
        lines.insert(k, lines[i])
    elif way == 2:
        lines[i], lines[k] = lines[k], lines[i]
    elif way == 3:
        lines[i] = b"!" + lines[i]
    else:
        lines[i:i + 2] = [b" ".join(lines[i:i + 2])]
    return b"\n".join(lines)


def truncate(dice, text):
    return text[: dice.randrange(len(text) + 1)]


def behead(dice, text):
    return text[dice.randrange(len(text) + 1):]


def spoil_bytes(dice, text):
    """Overwrites some bytes by any others."""
    spoilt = bytearray(text)
    for _ in range(dice.choice((1, 1, 2, 10)) if spoilt else 0):
        spoilt[dice.randrange(len(spoilt))] = dice.randrange(256)
    return bytes(spoilt)


def insert_raw(dice, text):
    i = dice.choice((0, len(text), dice.randrange(len(text) + 1)))
    return text[:i] + dice.choice(RAW) + text[i:]


def change_ends(dice, text):
    """Other ends of lines, and none at the end."""
    return text.replace(b"\n", dice.choice((b"\r\n", b"\r", b"\n\n", b"\t\n", b" "))).rstrip(dice.choice((b"\n", b"")))


def unclose(dice, text):
    """Takes away what closes a group or a text."""
    sign = dice.choice((b"/", b"'", b"="))
    places = [i for i in range(len(text)) if text[i:i + 1] == sign]
    if not places:
        return text
    i = dice.choice(places)
    return text[:i] + text[i + 1:]


def mix(dice, text):
    """Parts of two scenes, cut where groups begin or anywhere."""
    other = dice.choice(BASES)
    if dice.random() < 0.5:
        groups = re.split(rb"\n(?=&)", text) + re.split(rb"\n(?=&)", other)
        dice.shuffle(groups)
        return b"\n".join(groups[: dice.randrange(1, len(groups) + 1)])
    return text[: dice.randrange(len(text) + 1)] + other[dice.randrange(len(other) + 1):]


def repeat(dice, text):
    """One part of the text very often."""
    i = dice.randrange(len(text) + 1)
    part = text[i:i + dice.choice((1, 10, 100))]
    return text[:i] + part * dice.choice((10, 1000)) + text[i:]


def stretch(dice, text):
    """A line of 10 MB somewhere."""
    i = dice.randrange(len(text) + 1)
    part = dice.choice((b" ", b"1,", b"'", b"a", b"9", b"!", b"&", b"\x00", b"mass = 1.0 ", b"/ &body "))
    return text[:i] + part * (10_000_000 // len(part)) + text[i:]


MUTATIONS = [
    change_tokens(swap_tokens), change_tokens(repeat_token), change_tokens(delete_token), change_tokens(replace_token),
    change_tokens(insert_token), replace_number, replace_number, replace_number, misspell, change_lines, change_lines,
    truncate, behead, spoil_bytes, insert_raw, change_ends, unclose, mix, repeat,
]


def make_overrides(dice):
    """Values of `--set`, mostly none."""
    overrides = []
    while dice.random() < 0.3 and len(overrides) < 5:
        text = dice.choice((
            b"integrator.time_step=0.01", b"integrator.end_time=-1.0", b"output.columns='energy','solver'",
            b"body.inertia=1.0,2.0,2.5", b"initial.angular_velocity=1.0,2.0,3.0", b"spring.stiffness=2.0",
            b"scene.title='x'", b"torque.space=0.0,0.0,1.0", b"integrator.order=4", b"body.mass=2.0",
            b"integrator.method='dop853'", b"integrator.auxiliary_inertia=2.0", b"gravity.acceleration=0.0,0.0,-1.0",
        ))
        for _ in range(dice.choice((0, 1, 1, 2))):
            text = dice.choice(MUTATIONS)(dice, text)
        # Arguments of a program hold no NUL, and the system takes none that is much longer.
        overrides.append(text.replace(b"\x00", b"?")[:100_000])
    return overrides


# ---------------------------------------------------------------------------------------------------------------------
# Legal scenes with extreme values
# ---------------------------------------------------------------------------------------------------------------------


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
    parts = [body(dice, scales), initial(dice, scales), integrator(dice, scales, not effects), output(dice, scales)]
    parts += dict.fromkeys(effects)
    dice.shuffle(parts)
    return "".join(parts).encode()


def body(dice, scales):
    lines = []
    if dice.random() < 0.3:
        shape, sizes = dice.choice((("box", 3), ("cylinder", 2), ("cone", 2), ("sphere", 1), ("ellipsoid", 3)))
        lines += [f"shape = '{shape}'", f"size = {scales.text(sizes, length=1, signed=False)}"]
    else:
        lines += [f"inertia = {moments(dice, scales)}", f"check_triangle = .{dice.choice(('true', 'false'))}."]
        if dice.random() < 0.2:
            lines.append("inertia_about = 'center_of_mass'")
    lines.append(f"mass = {scales.text(mass=1, signed=False)}")
    if dice.random() < 0.7:
        lines.append(f"center_of_mass = {dice.choice((scales.text(3, length=1), '0, 0, ' + scales.text(length=1)))}")
    return group("body", lines)


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


def initial(dice, scales):
    lines = []
    way = dice.randrange(4)
    if way == 0:
        lines.append(f"euler = {dice.uniform(-7, 7)}, {dice.choice((0.0, 3.141592653589793, 1e-200, 1.0))}, 0.5")
    elif way == 1:
        lines += [f"axis = {scales.text(3)}", f"angle = {scales.text()}"]
    elif way == 2:
        q = [dice.choice((0.0, dice.gauss(0, 1))) for _ in range(3)] + [1.0]
        size = sum(x * x for x in q) ** 0.5
        lines.append("quaternion = " + ", ".join(number_text(x / size) for x in q))
    if way == 0 and dice.random() < 0.3:
        lines.append(f"euler_rates = {scales.text(3, time=-1)}")
    else:
        rate = [scales.value(time=-1) * dice.choice((1, 1, 1, 0, 1e-16, 1e-300, 1e6)) for _ in range(3)]
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
        lines += [f"linear_solver = '{solver}'", f"order = {order}"]
    direction = dice.choice((1, 1, 1, -1))
    step = scales.value(time=1, signed=False) * dice.choice((1e-9, 1e-3, 0.01, 0.1, 0.1, 1, 4, 100))
    if dice.random() < 0.3 and order != "0":
        lines.append(f"{dice.choice(('accuracy', 'local_tolerance'))} = {10.0 ** dice.uniform(-18, -1)}")
        end = scales.value(time=1, signed=False) * dice.choice((0.1, 1, 1, 10, 1e6, 1e12))
    else:
        lines.append(f"time_step = {number_text(direction * step)}")
        end = step * dice.choice((0.3, 1, 3, 20, 20, 20.5, 200, 1e5))
    lines.append(f"end_time = {number_text(direction * end)}")
    if dice.random() < 0.3:
        lines.append(f"auxiliary_inertia = {scales.text(length=2, mass=1, signed=False)}")
    if solver == "lapack" and len(lines) == 6 and dice.random() < 0.2:
        lines.append("projection = .false.")
    if dice.random() < 0.1:
        lines.append(f"max_iterations = {dice.choice((1, 2, 5, 1000, 2147483647))}")
    if dice.random() < 0.1:
        lines.append(f"tolerance = {10.0 ** dice.uniform(-320, -1)}")
    return group("integrator", lines)


def output(dice, scales):
    lines = []
    if dice.random() < 0.8:
        sets = list(COLUMNS)
        chosen = dice.choice((sets, dice.sample(sets, dice.randrange(1, 4)), ["angular_velocity"]))
        lines.append("columns = " + ", ".join(f"'{name}'" for name in chosen))
    if dice.random() < 0.3:
        lines.append(f"every = {dice.choice((1, 7, 1000, 2147483647))}")
    elif dice.random() < 0.05:
        lines.append(f"interval = {scales.text(time=1, signed=False)}")
    return group("output", lines)


def gravity(_, scales):
    return group("gravity", [f"acceleration = {scales.text(3, length=1, time=-2)}"])


def dipole(_, scales):
    return group("dipole", [f"moment = {scales.text(3)}", f"field = {scales.text(3, length=2, mass=1, time=-2)}"])


def gravity_gradient(_, scales):
    return group("gravity_gradient", [f"direction = {scales.text(3)}", f"strength = {scales.text(time=-2)}"])


def spring(dice, scales):
    lines = [f"body_point = {scales.text(3, length=1)}", f"anchor = {scales.text(3, length=1)}",
             f"stiffness = {scales.text(mass=1, time=-2)}"]
    if dice.random() < 0.7:
        lines.append(f"rest_length = {scales.text(length=1, signed=False)}")
    return group("spring", lines)


def damping(_, scales):
    return group("damping", [f"coefficient = {scales.text(3, length=2, mass=1, time=-1)}"])


def torque(dice, scales):
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


def from_samples(name, keys):
    """An effect of the samples without a function of its own: its numbers, each scaled at random."""

    def effect(dice, _):
        lines = [f"{key} = " + ", ".join(number_text(float(number) * 10.0 ** dice.uniform(-3, 3))
                                         for number in numbers.split(",")) for key, numbers in keys]
        return group(name, lines)

    return effect


# In the units of a scene, and then those that have no function of their own.
EFFECTS = [gravity, dipole, gravity_gradient, spring, damping, torque, rotor]
EFFECTS += [from_samples(name, keys) for name, keys in read_effects().items()
            if name not in [effect.__name__ for effect in EFFECTS]]


def group(name, lines):
    return "&" + name + "\n" + "".join(f"   {line}\n" for line in lines) + "/\n"


# ---------------------------------------------------------------------------------------------------------------------
# What a program must do with it
# ---------------------------------------------------------------------------------------------------------------------


class Verdict:
    """How a program took a case: what is wrong with it (blank: nothing), and the exit statuses of check and run."""

    def __init__(self, fault, statuses, seconds):
        self.fault = fault
        self.statuses = statuses
        self.seconds = seconds


def arguments_of(command, case):
    """The arguments of a command for a case whose scene is `scene.nml`."""
    arguments = [command, "scene.nml"]
    for override in case.overrides:
        arguments += ["--set", override]
    if command == "run":
        arguments += ["--quiet", "--max-steps", str(LONGEST_RUN), "--output", "history.csv"]
    return arguments


def judge(program, case):
    """Gives a case to `check` and `run` of a program, in an empty folder."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder)
        (path / "scene.nml").write_bytes(case.text)
        statuses, longest = [], 0.0
        for command in ("check", "run"):
            started = processor_seconds()
            try:
                done = subprocess.run([program, *arguments_of(command, case)], cwd=folder, capture_output=True,
                                      stdin=subprocess.DEVNULL, timeout=PATIENCE, check=False)
            except subprocess.TimeoutExpired:
                return Verdict(f"{command}: hangs", statuses, PATIENCE)
            seconds = processor_seconds() - started
            longest = max(longest, seconds)
            statuses.append(done.returncode)
            fault = fault_of(command, case, done, path)
            if not fault and seconds > ALLOWED_SECONDS:
                fault = f"took {seconds:.1f} s"
            if fault:
                return Verdict(f"{command}: {fault}", statuses, longest)
        if statuses[0] != statuses[1] and 2 in statuses:
            return Verdict(f"check and run disagree: {statuses}", statuses, longest)
        return Verdict("", statuses, longest)


def processor_seconds():
    """Processor time of the programs that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def fault_of(command, case, done, folder):
    """What is wrong with the outcome of a command; blank where nothing is."""
    said = done.stderr
    if done.returncode not in ((0, 2) if command == "check" else (0, 2, 3)):
        return f"exit status {done.returncode}, {said[-400:]!r}"
    if done.returncode == 0 and said:
        return f"a message though it succeeded: {said[-400:]!r}"
    if done.returncode != 0 and (said.count(b"\n") != 1 or not said.endswith(b"\n") or len(said) < 10):
        return f"not one line: {said[-400:]!r}"
    if not said.decode("utf-8", "replace")[:-1].isprintable() and said:
        return f"not printable: {said[-400:]!r}"
    if command == "check":
        if case.legal and re.search(rb"\bNaN\b|\*\*\*", done.stdout):
            return "a number that is none"
        return fault_of_files(folder, [])
    if done.returncode == 0:
        return fault_of_files(folder, ["history.csv"]) or fault_of_history(folder / "history.csv")
    if done.returncode == 3 and (folder / "history.csv.partial").exists():
        return fault_of_files(folder, ["history.csv.partial"]) or fault_of_history(folder / "history.csv.partial")
    return fault_of_files(folder, [])


def fault_of_files(folder, expected):
    found = sorted(set(os.listdir(folder)) - {"scene.nml"})
    return "" if found == expected else f"left {found} instead of {expected}"


def fault_of_history(path):
    """Whole rows of finite numbers, or what is wrong."""
    text = path.read_bytes()
    if not text.endswith(b"\n"):
        return f"{path.name}: the last row is not whole"
    header, *rows = text.lower().splitlines()
    if b"n" in b"".join(rows) or b"*" in b"".join(rows):
        return f"{path.name}: a number that is none"
    if any(row.count(b",") != header.count(b",") for row in rows):
        return f"{path.name}: a row of another length"
    return ""
