"""Builds and runs every program of docs/linking.md and docs/f77.md against an installed tree.   tools/checks/check-linking.py PREFIX

A program stands after `<!-- file: NAME -->`, the command that builds and runs it after `<!-- run -->`. Programs have at most
40 lines. The last line is `N passed, N failed`.
"""

import os
import re
import subprocess
import sys
import tempfile

DOCS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs")
PAGES = ("linking.md", "f77.md")
MOST_LINES = 40


def main():
    prefix = os.path.abspath(sys.argv[1])
    text = "".join(open(os.path.join(DOCS, page), encoding="utf-8").read() for page in PAGES)
    parts = re.findall(r"<!-- file: (\S+) -->\n```\S*\n(.*?)```|<!-- run -->\n    ([^\n]*)\n", text, flags=re.DOTALL)
    environment = dict(os.environ, PREFIX=prefix, LD_LIBRARY_PATH=f"{prefix}/lib",
                       PKG_CONFIG_PATH=f"{prefix}/lib/pkgconfig")
    passed = failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, program, command in parts:
            if name:
                with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                    file.write(program)
                problem = "" if program.count("\n") <= MOST_LINES else f"{name} has more than {MOST_LINES} lines"
            else:
                run = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, text=True, check=False,
                                     stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
                problem = f"{command}\n{run.stdout}" if run.returncode else ""
            if problem:
                print(f"FAILED: {problem}")
            passed, failed = passed + (not problem), failed + bool(problem)
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or passed < 2 else 0


if __name__ == "__main__":
    sys.exit(main())
