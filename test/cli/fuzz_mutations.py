"""Mutations of scene files and of values on the command line, down to their bytes."""

import re

from fuzz_scenes import extreme, number_text
from support import ROOT


def read_bases():
    """The shipped scenes, shortened, as bytes."""
    return [path.read_bytes() for path in sorted((ROOT / "scenes").glob("*.nml"))]


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
    b".true.", b".false.", b"T", b".t", b".maybe.", b"'box'", b"'full'", b"'reduced'", b"Infinity", b"\n", b"\n\n",
    b"title = 'a\nb'", b"inertia(2) = 7", b"body%mass = 1", b"=/", b"every = 0", b"shape = 'box'", b"mass = 1.0",
    b"table = 'table.csv'", b"table = 'scene.nml'", b"table = '.'", b"interpolation = 'cubic'", b"outside = 'periodic'",
    b"axes = 'space'", b"table = 'motor.csv'", b"speed_limit = 3", b"torque_limit = 0.2", b"law = 'bdot'",
    b"inertia_table = 'inertia.csv'", b"center_of_mass_table = 'center.csv'", b"by = 'wheels'", b"sample = 0.1", b"gains = 'scalar'",
    b"times = 0.1, 0.2", b"times_file = 'table.csv'", b"precision = 3", b"degrees = T",
]
RAW = [
    b"\x00", b"\x00\x00\x00\x00", b"\xff\xfe", b"\xef\xbb\xbf", b"\xc3\xa9", b"\xe2\x82\xac", b"\xf0\x9f\x98\x80",
    b"\xc3", b"\x80\x80", b"\x1b[31m", b"\x07", b"\x08", b"\x0b", b"\x0c", b"\x1a", b"\x7f", b"\x85", b"\t", b"\r",
    b"\r\n", b"\xa0", b"\xe2\x80\xa8", b"\xe3\x80\x80",
]
TOKEN = re.compile(rb"'[^'\n]*'|[\w.+-]+|[^\w\s]|\s+")


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
    """Removes what closes a group or a text."""
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
            b"integrator.method='dop853'", b"integrator.method='rk8'", b"integrator.auxiliary_inertia=2.0", b"gravity.acceleration=0.0,0.0,-1.0",
        ))
        for _ in range(dice.choice((0, 1, 1, 2))):
            text = dice.choice(MUTATIONS)(dice, text)
        # Arguments of a program hold no NUL, and the system takes none that is much longer.
        overrides.append(text.replace(b"\x00", b"?")[:100_000])
    return overrides
