#!/usr/bin/env python3
"""Writes python/nutate/_units.py, the units of columns, from the table of quantities; --check fails if it differs.

usage: python3 tools/lint/quantities.py --write | --check"""
import pathlib
import re
import sys
import textwrap

ROOT = pathlib.Path(__file__).resolve().parents[2]
TABLE = ROOT / "src" / "io" / "output" / "nutate_quantities.f90"
PAGE = ROOT / "python" / "nutate" / "_units.py"


def units():
    """Names of columns by unit; those with a rest that the scene decides come last."""
    text = TABLE.read_text(encoding="utf-8")
    text = re.sub(r"&\n\s*", "", text[text.index(":: quantities(*)"):text.index("\ncontains")])
    found = {}
    for entry in text.split("quantity_t(")[1:]:
        names, unit = re.match(r"'[^']*', '([^']*)', \w+, '([^']*)'", entry).groups()
        pattern = re.search(r"pattern='([^']*)'", entry)
        names = [re.sub(r"\d+", "#", name) for name in (pattern[1].split() if pattern else names.split(","))]
        listed = found.setdefault(("*" in names[0], unit.replace("²", "2") or "1"), [])
        listed += [name for name in dict.fromkeys(names) if name not in listed]
    return sorted(found.items(), key=lambda item: item[0][0])


def page():
    lines = ['"""Units of columns: `#` is a number, `*` any rest. Written by tools/lint/quantities.py."""', "", "UNITS = ("]
    for (_, unit), names in units():
        first, *rest = textwrap.wrap(" ".join(names), 104)
        lines += [f'    ("{unit}", "{first}', *(f'     "{part}' for part in rest)]
        lines = [*lines[:-len(rest) - 1], *(f'{line} "' for line in lines[-len(rest) - 1:-1]), f'{lines[-1]}"),']
    return "\n".join(lines + [")", ""])


if sys.argv[1:] == ["--write"]:
    PAGE.write_text(page(), encoding="utf-8")
elif PAGE.read_text(encoding="utf-8") != page():
    sys.exit(f"{PAGE}: out of date (run python3 tools/lint/quantities.py --write)")
