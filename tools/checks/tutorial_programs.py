#!/usr/bin/env python3
"""Writes the Python programs of README and tutorials to a folder, a file for each page, for type checkers.

usage: python3 tools/checks/tutorial_programs.py FOLDER"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]

for page in [ROOT / "README.md", *sorted((ROOT / "docs" / "tutorials").glob("*.md"))]:
    blocks = re.findall(r"^```(?:\{code-cell\} )?python\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    if blocks:
        name = re.sub(r"\W", "_", page.stem.lower()) + "_page.py"
        (pathlib.Path(sys.argv[1]) / name).write_text("\n".join(blocks), encoding="utf-8")
