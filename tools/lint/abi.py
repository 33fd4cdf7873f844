"""The names that libnutate.so exports, and the numbers of the constants of its headers, each with the version that brought it.

    tools/lint/abi.py --write    writes cmake/exported_symbols.txt and debian/libnutate0.symbols
    tools/lint/abi.py --check    compares them with include/ and src/interop/f77/; exit status 1 where they differ

--check also compares the parameters of each function of include/ with the @param of its docstring.

A name or number of an earlier version stays as long as the soname does: --write rejects a list without it.
"""

import difflib
import glob
import os
import re
import sys

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
LIST = "cmake/exported_symbols.txt"
DEBIAN = "debian/libnutate0.symbols"
HEADING = """Names that the shared library exports, constants of its headers, and the version that brought each. Written by
`python3 tools/lint/abi.py --write`, compared by `make lint`; what an earlier version has stays until the soname changes.
"""


def read(name):
    """The text of a file; empty if there is none."""
    path = os.path.join(TOP, name)
    if not os.path.exists(path):
        return ""
    with open(path, encoding="utf-8") as file:
        return file.read()


def sources(pattern):
    """The texts of the files that match, without comments of C."""
    names = sorted(glob.glob(os.path.join(TOP, pattern)))
    return [re.sub(r"/\*.*?\*/|//[^\n]*", " ", read(os.path.relpath(name, TOP)), flags=re.DOTALL) for name in names]


def functions():
    """Names of the functions of the headers and of the FORTRAN 77 routines, as the linker has them."""
    names = set()
    for text in sources("include/*.h"):
        names.update(re.findall(r"\b(nutate_[a-z0-9_]+)\(", text))
    for text in sources("src/interop/f77/nutate_f77*.f90"):
        names.update(name + "_" for name in re.findall(r"^ *(?:pure )?subroutine (nu[a-z0-9]+)\(", text, re.MULTILINE))
    return sorted(names)


def constants():
    """Constants of the headers with their values: `NUTATE_OK = 0`."""
    found = []
    for text in sources("include/*.h"):
        for body in re.findall(r"\benum \w+ \{(.*?)\}", text, re.DOTALL):
            value = -1
            for item in filter(None, map(str.strip, body.split(","))):
                name, _, given = map(str.strip, item.partition("="))
                value = int(given) if given else value + 1
                found.append(f"{name} = {value}")
    return found


def undocumented():
    """Functions of the headers whose docstring has other parameters than they, or a direction that const contradicts."""
    found = []
    for path in sorted(glob.glob(os.path.join(TOP, "include/*.h"))):
        for part in re.finditer(r"(?:/\*((?:(?!\*/).)*)\*/)?\s*^(?:typedef )?int (?:\(\*)?(\w+)\)?\(([^;]*)\);", read(path),
                                re.DOTALL | re.MULTILINE):
            documented = re.findall(r"@param\[(in|out|in,out)\] +(\w+) +\w*\S", part[1] or "")
            arguments = [" ".join(each.split()) for each in part[3].split(",")]
            names = [re.sub(r"(\[\d*\])*$", "", each).split()[-1].lstrip("*") for each in arguments]
            changed = [name for way, name in documented if way != "in"]
            constant = [name for name, each in zip(names, arguments) if each.startswith("const ") or not re.search(r"[*[]", each)]
            if not re.match(r"\* [A-Z]", part[1] or "") or [name for _, name in documented] != names or {*changed} & {*constant}:
                found.append(f"{os.path.relpath(path, TOP)}: docstring of {part[2]}: expected @param[in], [out] or [in,out] "
                             f"for {', '.join(names)}; [in] for what is const or a value")
    return found


def listed():
    """The soname of the list, and the version of each of its names."""
    text = read(LIST)
    soname = re.search(r"^soname (\S+)$", text, re.MULTILINE)
    return soname and soname[1], dict(re.findall(r"^   (\S.*\S) +(\d+\.\d+\.\d+)$", text, re.MULTILINE))


def texts(version):
    """The text of each file as it should be; ends the program if a name of an earlier version is gone."""
    soname = f"libnutate.so.{version.split('.', maxsplit=1)[0]}"
    old_soname, old = listed()
    known = old if soname == old_soname else {}
    names, numbers = functions(), constants()
    gone = [name for name, since in known.items() if since != version and name not in (*names, *numbers)]
    if gone:
        sys.exit(f"{soname} of an earlier version has {', '.join(gone)}: keep what is exported, or change the soname")
    lines = [HEADING, f"soname {soname}", "", "functions"]
    lines += [f"   {name:40} {known.get(name, version)}" for name in names] + ["", "constants"]
    lines += [f"   {name:40} {known.get(name, version)}" for name in numbers] + [""]
    debian = [f"{soname} libnutate0 #MINVER#", "* Build-Depends-Package: libnutate-dev"]
    debian += [f" {name}@Base {known.get(name, version)}" for name in names] + [""]
    return {LIST: "\n".join(lines), DEBIAN: "\n".join(debian)}


def main():
    if sys.argv[1:] not in (["--write"], ["--check"]):
        sys.exit(__doc__)
    version = re.search(r'^version = "([^"]*)"', read("fpm.toml"), re.MULTILINE)[1]
    wrong = undocumented() if sys.argv[1] == "--check" else []
    print("\n".join(wrong), end="\n" if wrong else "")
    status = 1 if wrong else 0
    for name, text in texts(version).items():
        changes = list(difflib.unified_diff(read(name).splitlines(), text.splitlines(), name, "sources", lineterm="", n=1))
        if changes and sys.argv[1] == "--check":
            print("\n".join(changes))
            status = f"{name} is not what the sources export; if that is meant: python3 tools/lint/abi.py --write"
        elif changes:
            os.makedirs(os.path.dirname(os.path.join(TOP, name)), exist_ok=True)
            with open(os.path.join(TOP, name), "w", encoding="utf-8") as file:
                file.write(text)
    sys.exit(status)


if __name__ == "__main__":
    main()
