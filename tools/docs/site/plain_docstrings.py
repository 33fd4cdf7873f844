"""Docstrings of the Python package as they read in a terminal: indented lines stay as they are, all else is sentences."""

import re


def as_blocks(lines):
    """Returns lines of a docstring with each run of indented ones as a literal block."""
    result, inside = [], False
    for position, line in enumerate(lines):
        indented = line.startswith(" ") or (inside and not line and any(lines[position + 1:position + 2])
                                            and lines[position + 1].startswith(" "))
        if indented and not inside:
            result += ["", "::", ""]
        elif inside and not indented:
            result.append("")
        inside = indented
        result.append(line if indented else re.sub(r"(?<!`)(\|\w+\||\w+_)(?=\W|$)(?!`)", escaped, line))
    return result


def escaped(found):
    """Returns what would be a mark of reStructuredText as plain text."""
    return found[0].replace("|", r"\|").replace("_", r"\_") if found[0][-1] in "|_" else found[0]


def process(_app, _what, _name, _object, _options, lines):
    """Replaces the lines of a docstring."""
    lines[:] = as_blocks(lines)


def setup(app):
    """Registers the reading of docstrings."""
    app.connect("autodoc-process-docstring", process)
    return {"parallel_read_safe": True}
