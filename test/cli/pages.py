"""Runs the code blocks of a page of documentation, in the order of the page and in a folder of its own.

A comment in the line before a block says what becomes of it:
   <!-- file: NAME -->          it is written to NAME; a scene (NAME.nml) must then pass `nutate check`
   <!-- add to: NAME.nml -->    it is appended to the scene NAME.nml, which must then pass `nutate check`
   <!-- exit status: N -->      its commands end with N, not with 0
   <!-- not run: WHY -->        nothing
   <!-- run -->                 the one command in the next line, indented by four blanks, is run
Without a comment, `console` blocks hold commands after `$ ` and below each what it prints, as far as shown: every line must be
the beginning of one that is printed, in this order, with the same numbers to the digits shown, six at most, but for times and round-off; `...`
stands for lines left out. `sh` blocks are run as a whole; `python` and `{code-cell}` blocks are run together, as one program. Directives of Sphinx,
`{toctree}`, are left out; every other block is a mistake. Scenes of the reference are run as well.
"""
import os
import pathlib
import re
import shutil
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BLOCK = re.compile(r"(?:^<!-- (?P<mark>[^\n]*?) -->\n)?^```(?P<kind>[^\n]*)\n(?P<text>.*?)^```$"
                   r"|^<!-- run -->\n    (?P<command>[^\n]*)\n", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"(?<![A-Za-z_])[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
# Lines whose numbers depend on the machine, and size of the numbers that round-off makes.
TIMED, ROUND_OFF = re.compile(r"wall time|time per step|measured for|(?<![A-Za-z])[nµm]s\b|/s of"), 1e-9
PLAIN = ("nutate", "cat", "head", "tail", "ls", "grep", "mkdir", "cp")
PYTHON = ("python", "{code-cell}", "{code-cell} python", "{code-cell} ipython3")
MOST_LINES = 50


def pages():
    """The pages all of whose blocks run."""
    docs = ROOT / "docs"
    return [ROOT / "README.md", ROOT / "python" / "README.md", docs / "index.md", docs / "scenes.md",
            *(path for part in ("tutorials", "how-to", "reference") for path in sorted((docs / part).glob("**/*.md")))]


def marked_pages():
    """Other pages, of which the blocks after a comment run."""
    known = set(pages())
    return [path for path in sorted((ROOT / "docs").glob("**/*.md"))
            if path not in known and re.search(r"^<!-- (file|add to): ", path.read_text(encoding="utf-8"), re.MULTILINE)]


def masked(line):
    """A line with `#` for each number and one blank for several."""
    return " ".join(NUMBER.sub("#", line).split())


def agree(shown, printed):
    """Whether a line shows the beginning of one that is printed, numbers but counts to a unit in their last digit or in the sixth."""
    if not masked(printed).startswith(masked(shown)):
        return False
    if TIMED.search(shown):
        return True
    for one, other in zip(NUMBER.findall(shown), NUMBER.findall(printed)):
        mantissa, _, power = one.lower().partition("e")
        unit = 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2])) if power or "." in mantissa else 0.0
        both = float(one), float(other)
        size = max(map(abs, both))
        if abs(both[0] - both[1]) > max(1.01 * unit, 1e-6 * size if unit else 0.0) and size > ROUND_OFF:
            return False
    return True


def missing_line(shown, printed):
    """The first line shown that is not printed where it should be; None if there is none."""
    rest = iter(printed.splitlines())
    for line in shown:
        if line.strip() not in ("", "...") and not any(agree(line, text) for text in rest):
            return line
    return None


class Runner:
    """Runs pages. Without `installed` it runs only what the program alone can do, and leaves out what needs an installed nutate.

    folder       where pages are run, one after the other
    environment  that of the commands; `nutate` must be on its PATH
    """

    def __init__(self, folder, environment, installed, patience=600):
        self.folder, self.environment = pathlib.Path(folder), environment
        self.installed, self.patience, self.runs_scenes, self.lacks_pictures = installed, patience, False, False

    def shell(self, command):
        """Runs a command: status, and what it printed."""
        try:
            done = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", command], cwd=self.folder, env=self.environment,
                                  text=True, errors="replace", check=False, timeout=self.patience, stdin=subprocess.DEVNULL,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        except subprocess.TimeoutExpired:
            return -1, f"not finished after {self.patience} s"
        return done.returncode, done.stdout

    def can_run(self, command):
        """Whether what the command needs is here."""
        if re.search(r"--plot|nutate plot", command) and not shutil.which("gnuplot"):
            self.lacks_pictures = True
            return False
        first = command.split()[0] if command.split() else ""
        return self.installed or (first in PLAIN and not re.search(r"nutate view|--threads|[|&;] *(?!head|tail|grep|cat)\w", command))

    def problems(self, path, strict=True):
        """How many blocks of a page ran, and what is wrong with others. Not `strict`: blocks without a comment are left alone."""
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        for name in ("scenes", "link", "example"):
            (self.folder / name).symlink_to(ROOT / name)
        text = path.read_text(encoding="utf-8")
        self.runs_scenes, self.lacks_pictures = "reference" in path.parts, False
        ran, wrong, program = 0, [], ""
        for block in BLOCK.finditer(text):
            place = f"{os.path.relpath(path, ROOT)}:{text.count(chr(10), 0, block.start()) + 1}"
            mark, kind = block["mark"] or "", block["kind"] or ""
            if mark.startswith("not run: ") or not (strict or mark or block["command"]):
                continue
            if kind in PYTHON and not mark.startswith("file: "):
                program += f"# {place}\n" + re.sub(r"^:.*\n|^---\n.*?^---\n", "", block["text"], flags=re.MULTILINE | re.DOTALL)
                continue
            problem = self.block(mark, kind, block["text"], block["command"])
            ran += problem is not None
            if problem:
                wrong.append(f"{place}: {problem}")
        if program and self.installed:
            (self.folder / "page.py").write_text(program, encoding="utf-8")
            status, printed = self.shell("python page.py")
            ran += 1
            if status:
                wrong.append(f"{os.path.relpath(path, ROOT)}: its Python fails\n{printed}")
        return ran, wrong

    def block(self, mark, kind, text, command):
        """Runs a block: None if it is left out, '' if all is well, else what is wrong."""
        status = int(mark[len("exit status: "):]) if mark.startswith("exit status: ") else 0
        if command:
            return self.commands([(command, [])], 0)
        if mark.startswith(("file: ", "add to: ")):
            name = mark.split(": ", 1)[1]
            with open(self.folder / name, "a" if mark.startswith("add") else "w", encoding="utf-8") as file:
                file.write(text)
            if kind not in ("sh", "text", "nml") and text.count("\n") > MOST_LINES:
                return f"{name} has more than {MOST_LINES} lines"
            tries = [f"nutate check {name}", *([f"nutate run {name} --quiet"] if self.runs_scenes else [])]
            return self.commands([(command, []) for command in tries], 0) if name.endswith(".nml") else ""
        if kind == "sh":
            return self.commands([(text, [])], status)
        if kind.startswith("{"):
            return None
        if kind == "console":
            parts = re.split(r"^\$ ((?:.*\\\n)*.*)\n?", text, flags=re.MULTILINE)
            if parts[0].strip() or len(parts) < 3:
                return "a console block begins with `$ `"
            return self.commands(list(zip(parts[1::2], [part.splitlines() for part in parts[2::2]])), status)
        return f"a block '{kind}' without a comment that says what becomes of it"

    def commands(self, commands, expected):
        """Runs commands, each with the lines shown below it."""
        ran = False
        for command, shown in commands:
            # What follows a picture that could not be drawn may need what its command writes.
            if self.lacks_pictures or not self.can_run(command):
                continue
            ran = True
            status, printed = self.shell(command)
            if status != expected:
                return f"`{command.strip()}` ends with {status}, not {expected}\n{printed}"
            line = missing_line(shown, printed)
            if line is not None:
                return f"`{command.strip()}` does not print this line here: {line}\n{printed}"
        return "" if ran else None
