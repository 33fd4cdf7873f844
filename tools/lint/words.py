#!/usr/bin/env python3
"""Finds words of this project's own in user-facing text, and names the field's term for each (words.tsv beside this file).

Read are README, CHANGELOG, docs, the C headers, docstrings of the Python package, and of Fortran sources the `!>` comments and
the texts between quotes. Words that no identifier, and no comment, of the sources may have are listed below,
and no comment may begin with a word that refers to another one.
    python3 tools/lint/words.py [FILE]...     all of them unless named; exit status 1 if a phrase is found
"""

import pathlib
import re
import sys

from tracked import names_of

ROOT = pathlib.Path(__file__).resolve().parents[2]
FILES = ("README.md", "CHANGELOG.md", "docs/*.md", "include/*.h", "python/README.md", "python/nutate/*.py", "app/*.f90",
         "src/*.f90", "mpi/app/*.f90")
# Where former names are listed, to be rejected with the present ones; and what 0.1.0 was released with.
EXEMPT = ("src/base/nutate_spelling.f90", "docs/public-api.txt")
SOURCES = ("src", "app", "mpi", "include", "python", "test", "bench", "example", "link")
# Words of no identifier: each with the field's word.
PRIVATE = {"lean": "specialised", "pilot": "trial run", "carried": "propagated", "crew": "workers", "desk": "lane buffer", "shelf": "cache",
           "hunt": "root search", "whom": "poll, callback", "judge": "accept"}
QUOTED = re.compile(r"'(?:[^']|'')*'|\"[^\"]*\"")


def phrases():
    """Pairs of a phrase, as a pattern, and what to write instead."""
    for line in pathlib.Path(__file__).with_name("words.tsv").read_text(encoding="utf-8").splitlines():
        phrase, better = line.split("\t")
        start = r"\b" if phrase[0].isalnum() else ""
        yield re.compile(start + re.escape(phrase), re.IGNORECASE), phrase.strip(), better


def user_text(path, line):
    """What of a line a user may read."""
    if path.suffix != ".f90":
        return line
    stripped = line.lstrip()
    if stripped.startswith("!"):
        return line if stripped.startswith("!>") else ""
    return " ".join(QUOTED.findall(line))


def private_words():
    """Prints each word of the sources that has a private word as a part; returns their number."""
    pattern = re.compile(r"(?:(?<=_)|(?<![a-z0-9]))(" + "|".join(PRIVATE) + r")s?(?![a-z0-9])", re.IGNORECASE)
    found = 0
    for name in names_of(*SOURCES):
        if not name.endswith((".f90", ".inc", ".f", ".c", ".h", ".py")):
            continue
        for number, line in enumerate((ROOT / name).read_text(encoding="utf-8").splitlines(), 1):
            for word in pattern.findall(line):
                print(f"{name}:{number}: '{word}' (write: {PRIVATE[word.lower()]})")
                found += 1
    return found


def openings(lines):
    """Number and first word of each sentence of Fortran comments that stands at the beginning of a line."""
    before = ""
    for number, line in enumerate(lines, 1):
        comment = re.match(r"\s*!>?\s?(.*)", line)
        text = comment.group(1).rstrip() if comment else ""
        if text and (not before or before[-1] in ".:"):
            yield number, text
        before = text


def without_subject():
    """Prints each comment of the sources that begins with a word which refers to another one; returns their number."""
    pattern = re.compile(r"(Of|What|Who|Whom|Whose|Where|Those|That of|As it|Such)\b")
    found = 0
    for name in names_of("src", "app", "mpi"):
        if not name.endswith((".f90", ".inc")):
            continue
        for number, text in openings((ROOT / name).read_text(encoding="utf-8").splitlines()):
            begin = pattern.match(text)
            if begin:
                print(f"{name}:{number}: a comment begins with '{begin.group(1)}' (write: a phrase with a subject of its own)")
                found += 1
    return found


def main():
    words = list(phrases())
    found = 0
    for name in sys.argv[1:] or names_of(*FILES):
        if name in EXEMPT:
            continue
        path = ROOT / name
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            for pattern, phrase, better in words:
                if pattern.search(user_text(path, line)):
                    print(f"{name}:{number}: '{phrase}' (write: {better})")
                    found += 1
    if not sys.argv[1:]:
        found += private_words() + without_subject()
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
