"""Docstrings of the Python package as they read in a terminal: lists of arguments become lists, other indented lines stay as they
are, all else is sentences. Those in numpydoc are left to napoleon."""

import re

from sphinx.util.inspect import TypeAliasForwardRef

# An argument, or several, and what they mean; lines that go on are indented.
ARGUMENT = re.compile(r"([a-z_]\w*(?:, [a-z_]\w*)*)  +(\S.*)")


def as_blocks(lines):
    """Returns lines of a docstring in reStructuredText."""
    result, inside, listed = [], False, False
    for position, line in enumerate(lines):
        argument = ARGUMENT.fullmatch(line)
        following = lines[position + 1] if position + 1 < len(lines) else ""
        indented = line.startswith(" ") or (inside and not line and following.startswith(" "))
        if argument:
            result += ([] if listed else [""]) + [f"``{argument[1]}``", "   " + plain(argument[2])]
        elif listed and line.startswith(" "):
            result.append("   " + plain(line.strip()))
        else:
            if indented and not inside:
                result += ["", ".. code-block:: text", ""]
            elif inside != indented or listed:
                result.append("")
            result.append("   " + line if indented else plain(line))
            inside = indented
        listed = bool(argument) or (listed and line.startswith(" "))
    return result


def plain(line):
    """Returns a line without what would be marks of reStructuredText."""
    return re.sub(r"(?<!`)(\|\w+\||\w+_)(?=\W|$)(?!`)", lambda found: re.sub(r"(\||_$)", r"\\\1", found[0]), line)


def process(_app, _what, _name, _object, _options, lines):
    """Replaces the lines of a docstring."""
    if not any(re.fullmatch("-{4,}", line) for line in lines):
        lines[:] = as_blocks(lines)


def setup(app):
    """Registers the reading of docstrings, and shows aliases of types by their names."""
    TypeAliasForwardRef.__repr__ = lambda alias: alias.name
    # Before napoleon, whose priority is the usual one.
    app.connect("autodoc-process-docstring", process, priority=400)
    return {"parallel_read_safe": True}
