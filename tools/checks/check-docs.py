"""Runs every code block of README, tutorials and how-to guides against an installed tree.   tools/checks/check-docs.py PREFIX [PAGE]...

test/cli/pages.py says how blocks are run. Python has the package of the tree, in a fresh virtual environment. The last line is
`N passed, N failed`. With NUTATE_KEEP_PICTURES=1 the pictures that blocks draw and pages show become those of docs/figures/.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "test" / "cli"))
from pages import ROOT, Runner, marked_pages, pages  # noqa: E402


def environment_of(prefix, folder):
    """Where commands find the program, the libraries and a Python with the package."""
    venv = os.path.join(folder, "venv")
    subprocess.run([sys.executable, "-m", "venv", venv], check=True)
    subprocess.run([os.path.join(venv, "bin", "pip"), "install", "--quiet", "--disable-pip-version-check",
                    f"{prefix}/share/nutate/python[plot]"], check=True)
    return dict(os.environ, PREFIX=prefix, LD_LIBRARY_PATH=f"{prefix}/lib", PKG_CONFIG_PATH=f"{prefix}/lib/pkgconfig",
                PATH=os.pathsep.join((f"{venv}/bin", f"{prefix}/bin", os.environ["PATH"])), MPLBACKEND="Agg",
                VIRTUAL_ENV=venv, NUTATE_SOURCE=str(ROOT))


def keep_pictures(path, folder):
    """Copies to docs/figures/ what a page shows of there and its blocks have drawn."""
    for picture in re.findall(r"\(\S*(docs|\.\.)/figures/(\S+)\)", path.read_text(encoding="utf-8")):
        drawn = folder / picture[1]
        if drawn.exists():
            shutil.copy(drawn, ROOT / "docs" / "figures")
            print(f"Drawn: docs/figures/{picture[1]}")


def main():
    prefix, chosen = os.path.abspath(sys.argv[1]), [pathlib.Path(name).resolve() for name in sys.argv[2:]]
    passed = failed = 0
    with tempfile.TemporaryDirectory() as folder:
        runner = Runner(os.path.join(folder, "page"), environment_of(prefix, folder), installed=True)
        for strict, paths in ((True, pages()), (False, marked_pages())):
            for path in paths:
                if chosen and path not in chosen:
                    continue
                ran, wrong = runner.problems(path, strict)
                if os.environ.get("NUTATE_KEEP_PICTURES"):
                    keep_pictures(path, runner.folder)
                for problem in wrong:
                    print(f"FAILED: {problem}")
                passed, failed = passed + ran - len(wrong), failed + len(wrong)
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or passed < 2 else 0


if __name__ == "__main__":
    sys.exit(main())
