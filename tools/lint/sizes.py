"""Looks for what is too long to read: files over 700 lines, procedures over 60, subjects of commits over 72 characters; and for
folders of src and app with more than 30 files.

    tools/lint/sizes.py      prints each that is over; exit status 1 where there is one
"""

import os
import re
import subprocess
import sys

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
FOLDERS = ["src", "app", "test", "example", "bench", "link", "include", "python", "tools", "mpi/app", "mpi/bench", "mpi/test", ".ci"]
ENDINGS = (".f90", ".f", ".c", ".cpp", ".h", ".py", ".sh")
LONGEST_FILE = 700
LONGEST_PROCEDURE = 60
LONGEST_SUBJECT = 72
MOST_FILES = 30
# Commits looked at, from the last one back.
COMMITS = 10
BEGIN = re.compile(r"^\s*(?:(?:pure|elemental|recursive|impure|module)\s+"
                   r"|(?:integer|real|complex|logical|character|type|class)(?:\s*\([^!]*?\))?\s+)*"
                   r"(?:subroutine|function)\s+(\w+)", re.IGNORECASE)
BODY = re.compile(r"^\s*module\s+procedure\s+(\w+)\s*$", re.IGNORECASE)
END = re.compile(r"^\s*end\s*(?:subroutine|function|procedure)\b", re.IGNORECASE)


def sources():
    """Paths of all files that have a limit, from the top of the project."""
    for folder in FOLDERS:
        for path, _, names in os.walk(os.path.join(TOP, folder)):
            for name in sorted(names):
                if name.endswith(ENDINGS) or (folder == ".ci" and name == "run"):
                    yield os.path.relpath(os.path.join(path, name), TOP)


def procedures(lines):
    """Name, first line and length of each procedure of a Fortran file; one that contains others without them."""
    open_ones = []
    in_submodule = any(line.startswith("submodule") for line in lines)
    for number, line in enumerate(lines, 1):
        begin = BEGIN.match(line) or (in_submodule and BODY.match(line))
        if END.match(line) and open_ones:
            name, first, inner = open_ones.pop()
            length = number - first + 1
            if open_ones:
                open_ones[-1][2] += length
            yield name, first, length - inner
        elif begin:
            open_ones.append([begin.group(1), number, 0])


def subjects():
    """Hash and subject of the last commits; none where this is no clone."""
    try:
        log = subprocess.run(["git", "-C", TOP, "log", f"-{COMMITS}", "--no-merges", "--format=%h %s"], check=False,
                             capture_output=True, encoding="utf-8").stdout
    except FileNotFoundError:
        return []
    return [line.split(" ", 1) for line in log.splitlines()]


def main():
    found = [f"commit {commit}: a subject of {len(subject)} characters (at most {LONGEST_SUBJECT})"
             for commit, subject in subjects() if len(subject) > LONGEST_SUBJECT]
    for top in ("src", "app"):
        for folder, _, names in os.walk(os.path.join(TOP, top)):
            if len(names) > MOST_FILES:
                found.append(f"{os.path.relpath(folder, TOP)}: {len(names)} files (at most {MOST_FILES})")
    for path in sources():
        with open(os.path.join(TOP, path), encoding="utf-8") as file:
            lines = file.read().splitlines()
        if len(lines) > LONGEST_FILE:
            found.append(f"{path}: {len(lines)} lines (at most {LONGEST_FILE})")
        if path.endswith(".f90"):
            found += [f"{path}:{first}: {name} has {length} lines (at most {LONGEST_PROCEDURE})"
                      for name, first, length in procedures(lines) if length > LONGEST_PROCEDURE]
    print("\n".join(found), end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
