"""Files of the project, for the checks that read them: in a clone those that git does not ignore, in an unpacked archive all that
no build has made."""

import fnmatch
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILT = {"build", ".venv", "__pycache__"}


def all_names():
    """Paths from the top of the project, sorted."""
    if (ROOT / ".git").exists():
        command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
        listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
        return sorted(name for name in set(listed) if (ROOT / name).exists())
    names = []
    for folder, folders, files in os.walk(ROOT):
        folders[:] = [name for name in folders if name not in BUILT and not name.endswith(".egg-info")]
        names += [os.path.relpath(os.path.join(folder, name), ROOT) for name in files]
    return sorted(names)


def names_of(*patterns):
    """Paths of the files in the folders named, or that match; `*` stands for slashes too."""
    return [name for name in all_names()
            if any(name == pattern or name.startswith(pattern + "/") or fnmatch.fnmatchcase(name, pattern) for pattern in patterns)]
