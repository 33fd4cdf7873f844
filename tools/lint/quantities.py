#!/usr/bin/env python3
"""Writes python/nutate/_units.py, units, symbols and colours of columns, from the table of quantities; --check fails if it differs.

usage: python3 tools/lint/quantities.py --write | --check"""
import pathlib
import re
import sys
import textwrap

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = ROOT / "src" / "io" / "quantities"
PAGE = ROOT / "python" / "nutate" / "_units.py"


def source(name):
    """The text of a file of the table, continued lines in one."""
    return re.sub(r"&\n\s*", "", (FOLDER / f"{name}.f90").read_text(encoding="utf-8"))


def entries():
    """The entries of the table, each a line, family by family."""
    families = re.search(r":: table\(\*\) = \[([^\]]*)\]", source("nutate_quantities"))[1].split(",")
    texts = "".join(source(path.stem) for path in FOLDER.glob("*.f90"))
    for family in families:
        listed = re.search(rf":: {family.strip()}\(\*\) = \[(.*)\]$", texts, re.MULTILINE)[1]
        yield from listed.split("quantity_t(")[1:]


def units():
    """Names of columns by unit; those with a rest that the scene decides come last."""
    found = {}
    for entry in entries():
        names, unit = re.match(r"'[^']*', '([^']*)', \w+, '([^']*)'", entry).groups()
        pattern = re.search(r"pattern='([^']*)'", entry)
        names = [re.sub(r"\d+", "#", name) for name in (pattern[1].split() if pattern else names.split(","))]
        listed = found.setdefault(("*" in names[0], unit.replace("²", "2") or "1"), [])
        listed += [name for name in dict.fromkeys(names) if name not in listed]
    return sorted(found.items(), key=lambda item: item[0][0])


def colours():
    """Colours by their names, and those of the components 1 to 6."""
    text = source("nutate_quantity")
    named = dict(re.findall(r"(\w+) = '(#\w{6})'", text))
    listed = re.search(r"component_colours\(6\) = \[([^\]]*)\]", text)[1]
    return named, [named[name.strip()] for name in listed.split(",")]


def looks():
    """For each quantity that has names in the table: names, label, panel, colour, symbols, and whether it shows errors."""
    named, _ = colours()
    for entry in entries():
        names, label, panel, colour = re.match(
            r"'[^']*', '([^']*)', \w+, '[^']*', *'([^']*)', (\d+)(?:, *([A-Z]+|'')(?=[,)]))?", entry).groups()
        pattern = re.search(r"pattern='([^']*)'", entry)
        symbols = re.search(r"symbols='([^']*)'", entry)
        if not pattern:
            yield (names.split(","), label, int(panel), named.get(colour or "", ""), symbols[1].split(",") if symbols else [],
                   "is_residual=.true." in entry)


def page():
    lines = ['"""Units, symbols and colours of columns: `#` is a number, `*` any rest. Written by tools/lint/quantities.py."""', "", "UNITS = ("]
    for (_, unit), names in units():
        first, *rest = textwrap.wrap(" ".join(names), 104)
        lines += [f'    ("{unit}", "{first}', *(f'     "{part}' for part in rest)]
        lines = [*lines[:-len(rest) - 1], *(f'{line} "' for line in lines[-len(rest) - 1:-1]), f'{lines[-1]}"),']
    lines += [")", "", "# Names, label and position of the panel, colour (empty: that of the component), symbols (`_` before a subscript; none:",
              "# the names), and whether the quantity shows errors of the integration.", "QUANTITIES = ("]
    for names, label, panel, colour, symbols, errors in looks():
        one = [f'"{" ".join(names)}"', f'"{label}"', f"{panel}", f'"{colour}"', f'"{",".join(symbols)}"', f"{errors}"]
        whole = f"    ({', '.join(one)}),"
        lines += [whole] if len(whole) <= 120 else [f"    ({one[0]},", f"     {', '.join(one[1:])}),"]
    components = ", ".join(f'"{colour}"' for colour in colours()[1])
    return "\n".join(lines + [")", "", f"COMPONENTS = ({components})", f'GREY = "{colours()[0]["GREY"]}"', ""])


if sys.argv[1:] == ["--write"]:
    PAGE.write_text(page(), encoding="utf-8")
elif PAGE.read_text(encoding="utf-8") != page():
    sys.exit(f"{PAGE}: out of date (run python3 tools/lint/quantities.py --write)")
