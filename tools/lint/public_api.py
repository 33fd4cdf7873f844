"""Lists what programs can name: module `nutate`, the modules that its head names, the headers, the FORTRAN 77 routines.

    tools/lint/public_api.py --write     puts the list into docs/public-api.txt
    tools/lint/public_api.py --check     compares it with docs/public-api.txt; exit status 1 where they differ

A change of the list is a change of the public interface: it belongs into the commit that makes it, and into CHANGELOG.md.
"""

import difflib
import glob
import os
import re
import sys

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
LIST = os.path.join(TOP, "docs", "public-api.txt")
HEADING = """Everything that a program can name. Written by `make api`, compared by `make lint`: a change here is a change of the
public interface.
"""
PROCEDURE = re.compile(r"^((?:pure |elemental |recursive |impure |integer |logical |type\([^)]*\) "
                       r"|(?:real|integer|complex|logical|character)\([^)]*\) )*)(subroutine|function) (\w+) ?\((.*)$")


def statements(lines):
    """The statements of lines of Fortran: without comments, continuation lines joined."""
    joined = ""
    for line in lines:
        line = re.sub(r"""^((?:[^!'"]|'[^']*'|"[^"]*")*)!.*""", r"\1", line.rstrip("\n")).strip()
        if not line or line.startswith("#"):
            continue
        joined += line.lstrip("&").strip() if joined else line
        if joined.endswith("&"):
            joined = joined[:-1].rstrip() + " "
            continue
        yield re.sub(r"\s+", " ", joined)
        joined = ""


def lines_of(path):
    """The lines of a file."""
    with open(path, encoding="utf-8") as file:
        return file.read().splitlines()


def split_names(text):
    """Names of a list, without what stands in brackets or behind `=`."""
    text = re.sub(r"=[^,]*(?:\[[^\]]*\])?", "", text)
    while re.search(r"\([^()]*\)", text):
        text = re.sub(r"\([^()]*\)", "", text)
    return [name.strip().lower() for name in text.split(",")]


class Module:
    """The definitions of one module."""

    def __init__(self, path):
        # The interface of what a submodule holds reads as any other.
        self.lines = [re.sub(r"\bmodule (?=(?:subroutine|function) )", "", line) for line in statements(lines_of(path))]
        self.procedures = {}
        self.types = {}
        self.constants = {}
        self.generics = {}
        self._read()

    def _read(self):
        i = 0
        while i < len(self.lines):
            line = self.lines[i]
            procedure = PROCEDURE.match(line)
            generic = re.match(r"interface (\w+)$", line)
            type_start = re.match(r"type(?:, .*)? ?:: ?(\w+)$", line)
            if procedure and not line.startswith("end "):
                self._read_procedure(i, procedure)
            elif type_start:
                end = next(k for k in range(i, len(self.lines)) if re.match(r"end type\b", self.lines[k]))
                self.types.setdefault(type_start.group(1).lower(), (line, self.lines[i + 1:end]))
                i = end
            elif generic:
                end = next(k for k in range(i, len(self.lines)) if re.match(r"end interface\b", self.lines[k]))
                self.generics[generic.group(1).lower()] = [
                    name for text in self.lines[i + 1:end] if text.startswith(("module procedure", "procedure"))
                    for name in split_names(text.split("::")[-1].replace("module procedure", ""))]
            elif "parameter" in line.split("::")[0] and "::" in line:
                head, _, values = line.partition("::")
                for name, value in re.findall(r"(\w+)(?:\([^)]*\))? ?= ?(\[.*\]|[^,]+)", values):
                    self.constants[name.lower()] = f"{head.strip()} :: {name} = {value.strip()}"
            i += 1

    def _read_procedure(self, i, match):
        """Header and declarations of the arguments and the result of the procedure that starts at line i."""
        name = match.group(3).lower()
        names = split_names(match.group(4).split(")")[0])
        result = re.search(r"result ?\((\w+)\)", match.group(4))
        names.append(result.group(1).lower() if result else name)
        declared = []
        for line in self.lines[i + 1:]:
            if re.match(r"(end|contains)\b", line):
                break
            head, separator, tail = line.partition("::")
            if separator and any(known in split_names(tail) for known in names):
                declared.append(f"{head.strip()} :: {tail.strip()}")
        self.procedures.setdefault(name, (self.lines[i], declared))

    def describe(self, name, indent="   "):
        """The lines that say what a name is."""
        if name in self.procedures:
            header, declared = self.procedures[name]
            return [indent + header] + [f"{indent}   {line}" for line in declared]
        if name in self.types:
            return self._describe_type(name, indent)
        if name in self.generics:
            found = [f"{indent}interface {name}"]
            for specific in self.generics[name]:
                found += self.describe(specific, indent + "   ")
            return found
        if name in self.constants:
            return [indent + self.constants[name]]
        sys.exit(f"public_api: cannot find what {name} is")

    def _describe_type(self, name, indent):
        """Public components and bindings of a type; bindings with the procedures behind them."""
        header, body = self.types[name]
        found, bound, hidden = [indent + header], False, False
        for line in body:
            if line in ("contains", "private", "public"):
                bound = bound or line == "contains"
                hidden = line == "private"
                continue
            head = line.split("::")[0]
            if (hidden and "public" not in head) or re.search(r"\bprivate\b", head):
                continue
            found.append(f"{indent}   {line}")
            deferred = re.match(r"procedure\((\w+)\)", line)
            binding = deferred.group(1) if deferred else line.split("::")[-1].split("=>")[-1].strip()
            if bound and binding.lower() in self.procedures:
                found += self.describe(binding.lower(), indent + "      ")
        return found


def fortran_modules():
    """Everything that Fortran programs can name: of module nutate, and of each module that its head names."""
    paths = {os.path.basename(path)[:-4]: path for path in glob.glob(f"{TOP}/src/**/*.f90", recursive=True)}
    lines = lines_of(f"{TOP}/src/nutate.f90")
    found = {"nutate": {}}
    for of_head, text in ((False, lines), (True, [line[2:] for line in lines if line.startswith("!>     ")])):
        for line in statements(text):
            use = re.match(r"use (\w+), only ?: ?(.*)", line)
            if use:
                module, shown = Module(paths[use.group(1)]), found.setdefault(use.group(1) if of_head else "nutate", {})
                for name in split_names(use.group(2)):
                    shown[name] = module.describe(name)
    return [line for module, names in found.items()
            for line in ["", f"Fortran: module {module}", *(line for name in sorted(names) for line in names[name])]]


def c_names():
    """The declarations of the headers."""
    text = "\n".join(open(path, encoding="utf-8").read() for path in sorted(glob.glob(f"{TOP}/include/*.h")))
    text = re.sub(r"/\*.*?\*/|//[^\n]*", " ", text, flags=re.DOTALL).replace("\\\n", " ")
    directives = [line.strip() for line in text.splitlines()
                  if re.match(r"\s*#\s*define \w+ +\S", line)]
    text = "\n".join(line for line in text.splitlines() if not re.match(r"\s*#", line))
    text = re.sub(r'extern "C" \{', "", re.sub(r"\s+", " ", text))
    declarations = [piece.strip() for piece in re.findall(r"(?:[^;{}]|\{[^}]*\})+;", text)]
    return ["   " + re.sub(r"\s+", " ", line) for line in directives + declarations]


def f77_names():
    """The routines and their arguments."""
    found = {}
    for path in glob.glob(f"{TOP}/src/interop/f77/nutate_f77*.f90"):
        module = Module(path)
        for name in module.procedures:
            if re.match(r"nu\w{1,4}$", name):
                found[name] = module.describe(name)
    return [line for name in sorted(found) for line in found[name]]


def main():
    text = "\n".join([HEADING.rstrip("\n"), *fortran_modules(), "", "C: include/nutate.h and what it includes", *c_names(), "",
                      "FORTRAN 77", *f77_names(), ""])
    if sys.argv[1:] == ["--write"]:
        with open(LIST, "w", encoding="utf-8") as file:
            file.write(text)
    elif sys.argv[1:] == ["--check"]:
        old = open(LIST, encoding="utf-8").read().splitlines() if os.path.exists(LIST) else []
        changes = list(difflib.unified_diff(old, text.splitlines(), "docs/public-api.txt", "sources", lineterm="", n=1))
        if changes:
            print("\n".join(changes))
            sys.exit("The public interface is not what docs/public-api.txt says; if that is meant: make api")
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
