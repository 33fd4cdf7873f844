"""The lists of all arguments of the FORTRAN 77 routines, drawn from src/interop/f77/.

    tools/lint/f77_arguments.py --write     puts it into docs/reference/f77.md
    tools/lint/f77_arguments.py --check     exit status 1 where docs/reference/f77.md says something else
"""

import glob
import os
import re
import sys
import textwrap

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
PAGE = os.path.join(TOP, "docs", "reference", "f77.md")
BEGIN, END = "<!-- begin arguments -->\n", "<!-- end arguments -->\n"
TYPES = {"real(wp)": "DOUBLE PRECISION", "integer": "INTEGER", "character": "CHARACTER*(*)", "procedure": "EXTERNAL"}
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


def table():
    parts = []
    for name, purpose, arguments in routines():
        items = [textwrap.fill(f"{i}. `{argument}`, {kind}, *{direction}*: {meaning}", 140, subsequent_indent="   ")
                 for i, (argument, kind, direction, meaning) in enumerate(arguments, 1)]
        parts.append(f"### {name}\n\n{purpose}.\n\n" + ("\n".join(items) or "No arguments.") + "\n")
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
