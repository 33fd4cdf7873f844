"""Writes the Fortran sources of library and program as a few files, each module before those that use it and before its
submodules.

    tools/tests/flang_parts.py FOLDER COUNT

flang takes most of its time to start and to read modules again: joined, the sources compile in less than half of it.
"""

import glob
import os
import re
import sys

MODULE = re.compile(r"^\s*module\s+(?!procedure\b)(\w+)\s*(?:!.*)?$", re.IGNORECASE | re.MULTILINE)
USE = re.compile(r"^\s*(?:use\b\s*(?:,[^:\n]*::|::)?|submodule\s*\()\s*(\w+)", re.IGNORECASE | re.MULTILINE)


def in_order(texts):
    """The paths of the sources, each after those whose modules it uses."""
    homes = {name.lower(): path for path, text in texts.items() for name in MODULE.findall(text)}
    ordered = {}

    def visit(path):
        if path in ordered:
            return
        for name in USE.findall(texts[path]):
            home = homes.get(name.lower(), path)
            if home != path:
                visit(home)
        ordered[path] = None

    for path in sorted(texts):
        visit(path)
    return list(ordered)


def main(folder, count):
    """Writes FOLDER/part_00.f90 and so on, of about equal lengths."""
    texts = {}
    for path in glob.glob("src/**/*.f90", recursive=True) + glob.glob("app/**/*.f90", recursive=True):
        with open(path, encoding="utf-8") as file:
            texts[path] = file.read()
    share = sum(map(len, texts.values())) / count
    parts, written = [[] for _ in range(count)], 0
    for path in in_order(texts):
        parts[min(int(written / share), count - 1)].append(f"! {path}\n{texts[path]}\n")
        written += len(texts[path])
    for number, part in enumerate(parts):
        with open(os.path.join(folder, f"part_{number:02}.f90"), "w", encoding="utf-8") as file:
            file.writelines(part)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
