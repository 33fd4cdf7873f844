"""The lists of all arguments of the FORTRAN 77 routines, drawn from src/interop/f77/.

    tools/lint/f77_arguments.py --write     puts it into docs/reference/f77.md
    tools/lint/f77_arguments.py --check     exit status 1 where docs/reference/f77.md says something else
"""

import collections
import glob
import os
import re
import sys
import textwrap

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
PAGE = os.path.join(TOP, "docs", "reference", "f77.md")
BEGIN, END = "<!-- begin arguments -->\n", "<!-- end arguments -->\n"
TYPES = {"real(wp)": "DOUBLE PRECISION", "integer": "INTEGER", "character": "CHARACTER*(*)", "procedure": "EXTERNAL"}
# An argument that at least so many routines describe in the same words is described once.
COMMON = 3
DIRECTIONS = {"input": "in", "output": "out", "input/output": "in, out", "workspace": "work"}


def routines():
    """Name, purpose and arguments of each routine: argument, type, direction, meaning."""
    for path in sorted(glob.glob(os.path.join(TOP, "src", "interop", "f77", "*.f90"))):
        with open(path, encoding="utf-8") as file:
            text = file.read()
        for found in re.finditer(r"((?:^!>.*\n)+)(?:pure )?subroutine (nu\w+)\(([^)]*)\).*\n([\s\S]*?)^end subroutine",
                                 text, re.MULTILINE):
            purpose, name, names, body = found.groups()
            purpose = joined(purpose).split(". ")[0].rstrip(".")
            arguments = {}
            for comment, declared, rest in re.findall(r"((?:^ +!>.*\n)+) +(\S[^\n]*?) :: ([^\n]*)", body, re.MULTILINE):
                meaning = re.match(r"\(([\w/]+)\) (.*)", joined(comment))
                kind = next(wide for narrow, wide in TYPES.items() if declared.startswith(narrow))
                argument = re.match(r"(\w+)(\([\d,:* ]+\))?", rest)
                size = (argument[2] or "").replace(" ", "")
                # The size is not repeated where the declaration has it.
                sentences = meaning[2] if "*" in size else meaning[2].replace(f"; dimension {size}", "")
                arguments[argument[1]] = (argument[1].upper() + size, kind, DIRECTIONS[meaning[1]], sentences)
            yield name.upper(), purpose, [arguments[argument] for argument in re.findall(r"\w+", names)]


def joined(comment):
    """The lines of a comment as one."""
    return " ".join(line.strip().removeprefix("!>").strip() for line in comment.strip().splitlines())


def common_arguments():
    """The most frequent description of each argument that COMMON routines describe alike."""
    described = collections.defaultdict(collections.Counter)
    for _, _, arguments in routines():
        for argument in arguments:
            described[argument[0]][argument] += 1
    most = [descriptions.most_common(1)[0] for descriptions in described.values()]
    return [argument for argument, times in most if times >= COMMON]


def item(names, kind, direction, meaning):
    """The line of a list; the type is left out if it is the one that the first letter implies."""
    implied = "INTEGER" if names[0][0] in "IJKLMN" else "DOUBLE PRECISION"
    shown = "" if kind == implied else f", {kind}"
    return filled(f"- {quoted(names)}{shown}, *{direction}*: {meaning}")


def quoted(names):
    return ", ".join(f"`{name}`" for name in names)


def filled(text):
    return textwrap.fill(text, 140, subsequent_indent="  ")


def items(arguments, earlier):
    """The list of a routine: arguments that an earlier routine describes in the same words are named alone, neighbours that are
    described alike share a line."""
    source = {argument: next((name for name in earlier if argument[3] == f"As for {name}."), None)
              or next((name for name, others in earlier.items() if argument in others), None) for argument in arguments}
    repeated = {name: [argument for argument in arguments if source[argument] == name] for name in earlier}
    lines, done = [], set()
    for argument in arguments:
        name = source[argument]
        if argument in done:
            continue
        if name and len(repeated[name]) > 1:
            lines.append(filled(f"- {quoted([other[0] for other in repeated[name]])}: as in {name}."))
            done.update(repeated[name])
            continue
        alike = [other for other in arguments if other[1:] == argument[1:]]
        lines.append(item([other[0] for other in alike], *argument[1:]))
        done.update(alike)
    return lines


def table():
    common = common_arguments()
    parts = ["### Common arguments\n\nA routine that does not describe one of its arguments has it as described here.\n\n"
             + "\n".join(item([argument[0]], *argument[1:]) for argument in common) + "\n"]
    earlier = {}
    for name, purpose, arguments in routines():
        names = [argument[0].split("(")[0] for argument in arguments]
        call = f"`CALL {name}({', '.join(names)})`" if names else f"`CALL {name}`"
        own = [argument for argument in arguments if argument not in common]
        lines = items(own, earlier)
        earlier[name] = own
        purpose = purpose.removeprefix(name + " ")
        parts.append("\n\n".join([f"### {name}", f"{purpose[0].upper()}{purpose[1:]}.", call, *(["\n".join(lines)] if lines else [])]) + "\n")
    return "\n".join(parts)


def names_for_messages():
    """The arguments of each routine as the table of nutate_f77_names has them."""
    with open(os.path.join(TOP, "src", "interop", "f77", "nutate_f77_names.f90"), encoding="utf-8") as file:
        return {name: arguments.split(",") for name, arguments in re.findall(r"routine_t\('(\w+) *', '([\w,]+)'\)", file.read())}


def main():
    if sys.argv[1:] not in (["--check"], ["--write"]):
        sys.exit(__doc__)
    with open(PAGE, encoding="utf-8") as file:
        text = file.read()
    before, rest = text.split(BEGIN)
    right = before + BEGIN + "\n" + table() + "\n" + END + rest.split(END)[1]
    if sys.argv[1] == "--write":
        with open(PAGE, "w", encoding="utf-8") as file:
            file.write(right)
    elif right != text:
        print("docs/reference/f77.md: the arguments are not those of src/interop/f77: python3 tools/lint/f77_arguments.py --write")
        return 1
    declared = {name: [re.match(r"\w+", argument)[0] for argument, _, _, _ in arguments]
                for name, _, arguments in routines() if arguments and name not in ("NUTEXT", "NUWHY")}
    if declared != names_for_messages():
        print("src/interop/f77/nutate_f77_names.f90: its table is not that of the routines")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
