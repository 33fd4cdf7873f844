"""The version stands in fpm.toml, the addresses of the sources and of the documentation in CITATION.cff; what else names them follows.

    tools/lint/version.py --write    writes them into the other files
    tools/lint/version.py --check    exit status 1 where one says another
"""

import os
import re
import sys

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
OWNERS = {
    "version": ("fpm.toml", r'^version = "(\d+\.\d+\.\d+)"$'),
    "sources": ("CITATION.cff", r'^repository-code: "(.*)"$'),
    "site": ("CITATION.cff", r'^url: "(.*)"$'),
}
# File, and what surrounds the version in it; %s is the whole version or the part of that number.
VERSIONS = [
    ("src/base/nutate_version.f90", "parameter :: version = '%s'", None),
    ("include/nutate.h", "#define NUTATE_VERSION_MAJOR %s\n", 0),
    ("include/nutate.h", "#define NUTATE_VERSION_MINOR %s\n", 1),
    ("include/nutate.h", "#define NUTATE_VERSION_PATCH %s\n", 2),
    ("python/pyproject.toml", '\nversion = "%s"\n', None),
    ("pyproject.toml", '\nversion = "%s"\n', None),
    ("mpi/fpm.toml", '\nversion = "%s"\n', None),
    ("CITATION.cff", "\nversion: %s\n", None),
    ("docs/about/cite.md", "\n  version = {%s},\n", None),
    ("codemeta.json", '\n  "version": "%s",\n', None),
    ("debian/nutate.1", '"nutate %s"', None),
    ("python/nutate/_library.py", 'SONAME = "libnutate.so.%s"\n', 0),
    ("tools/docs/ford.md", "\nversion: %s\n", None),
]
# File, and what surrounds an address in it.
ADDRESSES = [
    ("codemeta.json", '\n  "codeRepository": "%s",\n', "sources"),
    ("codemeta.json", '\n  "url": "%s",\n', "site"),
    ("codemeta.json", '\n  "softwareHelp": "%s",\n', "site"),
    ("debian/control", "\nHomepage: %s\n", "site"),
    ("debian/control", "\nVcs-Git: %s\n", "sources"),
    ("fpm.toml", '\nhomepage = "%s"\n', "site"),
    ("pyproject.toml", '\nHomepage = "%s"\n', "site"),
    ("pyproject.toml", '\nRepository = "%s"\n', "sources"),
]


def read(name):
    with open(os.path.join(TOP, name), encoding="utf-8") as file:
        return file.read()


def followers(facts):
    """File, what surrounds the fact, pattern of the fact, the fact."""
    version = facts["version"]
    for name, surroundings, part in VERSIONS:
        yield name, surroundings, r"[\d.]+", version if part is None else version.split(".")[part]
    for name, surroundings, fact in ADDRESSES:
        yield name, surroundings, r"[^\"\n]*", facts[fact]


def main():
    facts = {}
    for fact, (name, pattern) in OWNERS.items():
        found = re.search(pattern, read(name), re.MULTILINE)
        if not found or sys.argv[1:] not in (["--check"], ["--write"]):
            sys.exit(__doc__)
        facts[fact] = found[1]
    failed = False
    for name, surroundings, pattern, fact in followers(facts):
        wanted = surroundings % fact
        before, after = (re.escape(side) for side in surroundings.split("%s"))
        text = read(name)
        right, places = re.subn(before + pattern + after, wanted, text)
        if places != 1:
            print(f"{name}: has {places} times `{surroundings.strip()}`")
            failed = True
        elif right != text and sys.argv[1] == "--write":
            with open(os.path.join(TOP, name), "w", encoding="utf-8") as file:
                file.write(right)
        elif right != text:
            print(f"{name}: is not `{wanted.strip()}`: python3 tools/lint/version.py --write")
            failed = True
    # A package of Debian has a history; its last entry is of this version.
    if not re.match(rf"nutate \({re.escape(facts['version'])}-\d+\) ", read("debian/changelog")):
        print(f"debian/changelog: the first entry is not of {facts['version']}")
        failed = True
    if not re.search(rf"^## \[{re.escape(facts['version'])}\]", read("CHANGELOG.md"), re.MULTILINE):
        print(f"CHANGELOG.md: has no section [{facts['version']}]")
        failed = True
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
