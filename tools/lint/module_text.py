"""Measures the module text that gfortran reads in a build: for each `use` that of its module, for each submodule that of its parent.

    tools/lint/module_text.py [--most MB] [--list N]

The sizes are those of the newest build with tests by fpm and gfortran; without one nothing is measured. Exit status 1 if the
sources read more than --most MB in all; --list shows the N modules whose text costs most: MB read, kB of text, name. gfortran
reads some 25 MB a second.
"""

import argparse
import collections
import pathlib
import re
import sys

TOP = pathlib.Path(__file__).resolve().parents[2]
USE = re.compile(r"^\s*use\b(?!\s*=)\s*(?:,[^:\n]*)?(?:::)?\s*(\w+)", re.IGNORECASE | re.MULTILINE)
PARENT = re.compile(r"^\s*submodule\s*\(\s*([\w:]+)\s*\)", re.IGNORECASE | re.MULTILINE)


def newest_build():
    """The folder of .mod files that a build with tests has written last, or None."""
    found = [path for path in (TOP / "build").glob("gfortran_*/suites_of_runs.mod")]
    return max(found, key=lambda path: path.stat().st_mtime).parent if found else None


def text_size(path):
    """Bytes of the text in a gzip file: its last four bytes, or 0 if there is no such file."""
    return int.from_bytes(path.read_bytes()[-4:], "little") if path.exists() else 0


def read_text(folder):
    """Bytes read of each module, and bytes of its text."""
    read, size = collections.Counter(), {}
    for path in (path for top in ("src", "app", "test") for path in (TOP / top).rglob("*.f90")):
        source = path.read_text(encoding="utf-8")
        names = [f"{name.lower()}.mod" for name in USE.findall(source)]
        names += [f"{name.lower().replace(':', '@')}.smod" for name in PARENT.findall(source)]
        for name in names:
            size.setdefault(name, text_size(folder / name))
            read[name] += size[name]
    return read, size


def main():
    """Prints the modules that cost most, and the sum."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--most", type=float)
    parser.add_argument("--list", type=int)
    arguments = parser.parse_args()
    folder = newest_build()
    if folder is None:
        return
    read, size = read_text(folder)
    total = sum(read.values()) / 1e6
    for name, number in read.most_common(arguments.list or 0):
        print(f"{number/1e6:8.1f} MB {size[name]/1e3:8.1f} kB  {name}")
    if arguments.most is None:
        print(f"{total:.0f} MB of module text are read")
    elif total > arguments.most:
        sys.exit(f"module text: {total:.0f} MB are read (at most {arguments.most:.0f}): tools/lint/module_text.py --list 20")


if __name__ == "__main__":
    main()
