#!/usr/bin/env python3
"""Counts the lines of src, app and python that are neither blank nor a comment or docstring, by folder.

usage: code_lines.py [REVISION]

With a revision, its files are counted instead of those of the working tree.
"""
import ast
import subprocess
import sys

import tracked

MARKS = {".f90": "!", ".inc": "!", ".F90": "!", ".f": "!", ".py": "#", ".c": "//", ".h": "//"}


def names_of(revision):
    """Names of the files of a revision, or of the working tree."""
    if not revision:
        return tracked.names_of("src", "app", "python")
    command = ["git", "ls-tree", "-r", "--name-only", revision, "src", "app", "python"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()


def text_of(name, revision):
    if not revision:
        with open(name, encoding="utf-8") as file:
            return file.read()
    return subprocess.run(["git", "show", f"{revision}:{name}"], capture_output=True, text=True, check=True).stdout


def code_lines(text, mark):
    """Number of lines that are neither blank nor a comment; a block comment of C is treated as comments."""
    number, in_block = 0, False
    for line in map(str.strip, text.splitlines()):
        if mark == "//" and not in_block and line.startswith("/*"):
            in_block = "*/" not in line
            continue
        if in_block:
            in_block = "*/" not in line
            continue
        number += bool(line) and not line.startswith(mark)
    return number


def docstrings(text):
    """Number of lines of the docstrings of a Python module."""
    number = 0
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)) and ast.get_docstring(node):
            first = node.body[0]
            number += code_lines("\n".join(text.splitlines()[first.lineno - 1:first.end_lineno]), "#")
    return number


def main():
    revision = sys.argv[1] if len(sys.argv) > 1 else None
    counts = {}
    for name in names_of(revision):
        mark = MARKS.get("." + name.rsplit(".", 1)[-1])
        if mark:
            folder = "/".join(name.split("/")[:2]) if name.startswith("src/") else name.split("/")[0]
            text = text_of(name, revision)
            lines = code_lines(text, mark) - (docstrings(text) if mark == "#" else 0)
            counts[folder] = counts.get(folder, 0) + lines
    for folder, count in counts.items():
        print(f"{count:7d}  {folder}")
    print(f"{sum(counts.values()):7d}  total")


main()
