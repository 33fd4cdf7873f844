"""The version stands in fpm.toml; whatever else names it follows.

    tools/lint/version.py --write    writes it into the other files
    tools/lint/version.py --check    exit status 1 where one says another
"""

import os
import re
import sys

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
OWNER = ("fpm.toml", r'^version = "(\d+\.\d+\.\d+)"$')
# File, and what surrounds the version in it; %s is the whole version or the part of that number.
FOLLOWERS = [
    ("src/base/nutate_version.f90", "parameter :: version = '%s'", None),
    ("include/nutate.h", "#define NUTATE_VERSION_MAJOR %s\n", 0),
    ("include/nutate.h", "#define NUTATE_VERSION_MINOR %s\n", 1),
    ("include/nutate.h", "#define NUTATE_VERSION_PATCH %s\n", 2),
    ("python/pyproject.toml", '\nversion = "%s"\n', None),
    ("pyproject.toml", '\nversion = "%s"\n', None),
    ("mpi/fpm.toml", '\nversion = "%s"\n', None),
    ("CITATION.cff", "\nversion: %s\n", None),
    ("docs/about/cite.md", "\n  version = {%s},\n", None),
    ("tools/docs/ford.md", "\nversion: %s\n", None),
]


def read(name):
    with open(os.path.join(TOP, name), encoding="utf-8") as file:
        return file.read()


def main():
    found = re.search(OWNER[1], read(OWNER[0]), re.MULTILINE)
    if not found or sys.argv[1:] not in (["--check"], ["--write"]):
        sys.exit(__doc__)
    failed = False
    for name, surroundings, part in FOLLOWERS:
        wanted = surroundings % (found[1] if part is None else found[1].split(".")[part])
        before, after = (re.escape(side) for side in surroundings.split("%s"))
        text = read(name)
        right, places = re.subn(before + r"[\d.]+" + after, wanted, text)
        if places != 1:
            print(f"{name}: names the version {places} times as `{surroundings.strip()}`")
            failed = True
        elif right != text and sys.argv[1] == "--write":
            with open(os.path.join(TOP, name), "w", encoding="utf-8") as file:
                file.write(right)
        elif right != text:
            print(f"{name}: the version is not that of fpm.toml, {found[1]}: python3 tools/lint/version.py --write")
            failed = True
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
