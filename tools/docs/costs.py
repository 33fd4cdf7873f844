"""Measures what steps, runs to an accuracy and members of sweeps cost on this machine, and writes it into bench/cost-of-a-step.md
and docs/results/accuracy-costs.md between their markers. What was measured stays in build/costs/.

    python3 tools/docs/costs.py PROGRAM FOLDER [PART]...

FOLDER holds the benchmarks. A part is the name of a pair of markers: step, methods, frames, tangent, interfaces, handles
(bench/cost-of-a-step.md), heavy_top, choice, explicit, members (accuracy-costs.md); all of them unless some are named.
"""

import os
import re
import subprocess
import sys
import tempfile

DATA = "build/costs"


def table(header, rows):
    """Returns a table."""
    return "".join("| " + " | ".join(row) + " |\n" + ("|---"*len(row) + "|\n" if row is header else "") for row in [header, *rows])


def output(name, command):
    """Runs a command, keeps what it prints in DATA and returns it."""
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, encoding="utf-8")
    with open(f"{DATA}/{name}.txt", "w", encoding="utf-8") as file:
        file.write(done.stdout)
    return done.stdout


# Cases of bench_step in the table.
SHOWN_STEPS = ("no effect", "only gravity", "only spring", "only damping", "all of them")


def step_part(bench):
    """Returns the cost of the implicit step by effect, from bench_step."""
    text = bench("step")
    rows = []
    for line in text.splitlines():
        found = re.match(r"(\S.*?)\s{2,}([\d.]+)\s+([\d.]+)\s+(\S+)\s+(\d+)\. \(([\d.]+)\)\s+(\d+)\. \(([\d.]+)\)", line)
        if found and found[1] in SHOWN_STEPS:
            rows.append(list(found.groups()[:3]))
    yardstick = re.search(r"takes\s+(\d+)\. ns", text)[1]
    return f"One `dgesv` of an 8×8 system takes {yardstick} ns here.\n\n" + table(
        ["case", "full", "reduced"], rows)


# Names of the methods and what they need in &integrator.
METHODS = {
    "full, order 2": {"method": "nielsen_krenk"},
    "reduced, order 2": {"method": "nielsen_krenk", "formulation": "reduced"},
    "reduced, order 8": {"method": "nielsen_krenk", "formulation": "reduced", "order": 8},
    "rk4": {"method": "rk4"},
    "rk4, projected": {"method": "rk4", "conserve": True},
    "dop853": {"method": "dop853"},
    "dop853, projected": {"method": "dop853", "conserve": True},
    "rk8": {"method": "rk8", "conserve": False},
    "rk8, projected": {"method": "rk8"},
    "taylor, order 16": {"method": "taylor", "conserve": False},
    "taylor, projected": {"method": "taylor"},
}


def instructions(program, scene, step, settings, lines=""):
    """Returns the instructions of a step, from runs of two lengths by callgrind, so that start and end cancel."""
    counts = []
    short, long = 64, 256
    for steps in (short, long):
        with tempfile.TemporaryDirectory() as folder:
            with open(f"scenes/{scene}.nml", encoding="utf-8") as file:
                text = file.read()
            with open(f"{folder}/scene.nml", "w", encoding="utf-8") as file:
                file.write(text + lines)
            chosen = {"method": "'nielsen_krenk'", "time_step": step, "end_time": steps*step}
            for key, value in settings.items():
                chosen[key] = f"'{value}'" if isinstance(value, str) else str(value)[0] if value in (True, False) else value
            command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/counts", program, "run",
                       f"{folder}/scene.nml", "--quiet", "--output", f"{folder}/rows.csv", "--set", f"output.every={steps}"]
            for key, value in chosen.items():
                command += ["--set", f"integrator.{key}={value}"]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            with open(f"{folder}/counts", encoding="utf-8") as file:
                counts.append(int(re.findall(r"^(?:summary|totals): (\d+)", file.read(), re.MULTILINE)[-1]))
    return (counts[1] - counts[0])/(long - short)


SCENES = {"box": 0.01, "heavy_top": 0.001, "all_effects": 0.01}


def methods_part(program):
    """Returns the instructions of a step of each method."""
    rows = [[name, *(f"{instructions(program, scene, step, settings):.0f}" for scene, step in SCENES.items())]
            for name, settings in METHODS.items()]
    return table(["method", "box", "heavy top", "all effects"], rows)


FRAMES = (("box", "0.0, 0.0, 0.1"), ("heavy_top", "0.0, 0.0, 0.1"), ("heavy_top", "0.1, 0.0, 0.1"))


def frames_part(program):
    """Returns what a rotating frame adds to the instructions of a step."""
    parts = []
    for name in ("reduced, order 2", "rk8, projected", "taylor, projected"):
        more = []
        for scene, rate in FRAMES:
            plain = instructions(program, scene, SCENES[scene], METHODS[name])
            turned = instructions(program, scene, SCENES[scene], METHODS[name],
                                  f"\n&rotating_frame angular_velocity = {rate} /\n")
            more.append(100*(turned/plain - 1))
        parts.append(f"{name}: {min(more):.0f} to {max(more):.0f} %")
    return f"A [rotating frame](../docs/explanation/conservation.md#rotating-frames) adds: {'; '.join(parts)}.\n"


def tangent_part(bench):
    """Returns the time of a step with sensitivities, over the plain step."""
    names = {"nielsen_krenk": "reduced"}
    rows = [re.split(r"\s{2,}", line.strip()) for line in bench("tangent").splitlines()[1:]]
    return table(["method, case", "plain, ns", "6", "12", "6 and 6 of the inertia"],
                 [[f"{names.get(row[0], row[0])}, {row[1]}", row[2].rstrip("."), *row[3:]] for row in rows
                  if row[1] in ("top", "damped")])


def counted(command):
    """Returns the instructions that a command takes."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/counts", *command], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with open(f"{folder}/counts", encoding="utf-8") as file:
            return int(re.findall(r"^(?:summary|totals): (\d+)", file.read(), re.MULTILINE)[-1])


def interfaces_part(folder):
    """Returns the instructions of a step by one call each of Fortran, FORTRAN 77 and C; in brackets, over Fortran."""
    rows = []
    solvers = (("reduced", 2), ("rk8", 0), ("taylor", 0))
    for scene, methods in (("box", solvers[:1]), ("top", solvers), ("damped", solvers[:1])):
        for solver, order in methods:
            commands = [[f"{folder}/f77_stepping", "@", "-1", scene, solver, str(order)]]
            if order > 0:
                commands.append([*commands[0][:2], "1", *commands[0][3:]])
            commands.append([f"{folder}/c_steps", "@", solver, "one", scene])
            short, long = 1000, 2000
            costs = [(counted([word.replace("@", str(long)) for word in command])
                      - counted([word.replace("@", str(short)) for word in command]))/(long - short) for command in commands]
            cells = [f"{cost:.0f} ({cost/costs[0]:.2f})" for cost in costs[1:]]
            if order == 0:
                cells.insert(0, "")
            rows.append([scene, f"{solver}, order {order}" if order else solver, f"{costs[0]:.0f}", *cells])
    return table(["body", "method", "Fortran", "FORTRAN 77", "C"], rows)


def handles_part(bench_folder):
    """Returns the memory of C steppers, and the time of a step of one and of many in turn."""
    text = output("handles", [f"{bench_folder}/c_handles"])
    rows = [re.split(r"\s{2,}", line.strip()) for line in text.splitlines()[1:] if re.search("reduced|rk8|taylor", line)]
    return table(["stepper", "bytes", "one, ns", "10,000 in turn, ns"], rows)


def ranking_part(program, scene):
    """Returns what `nutate cost` reports about a scene for one accuracy, cheapest first."""
    text = output(f"cost_{scene}", [program, "cost", f"scenes/{scene}.nml"])
    lines, kept = [], True
    for line in text[text.index("\naccuracy ") + 1:].rstrip().splitlines():
        accuracy = re.match(r"\s*(1E-\d+) ", line)
        kept = accuracy[1] == "1E-8" if accuracy else kept
        lines += [line] if kept else []
    return "\n".join(["```text", *lines, "```"]) + "\n"


# Columns of bench_choice and the method that `auto` names.
CHOICE = {1e-2: 1, 1e-4: 3, 1e-6: 4, 1e-8: 5, 1e-10: 6}
ROWS = {"taylor": "taylor", "dop853": "dop853+conserve", "rk8": "rk8"}


def choice_part(bench):
    """Returns what a run to an accuracy costs with the method that `auto` chooses."""
    text = bench("choice")
    rows = []
    for block in re.split(r"\n\n+", text)[1:]:
        lines = block.strip("\n").splitlines()
        times = {line[2:44].strip(): re.findall(r"[\d.]+[! ]|\*+", line[43:] + " ") for line in lines[1:-1]}
        chosen = lines[-1].split("auto takes")[1].split()
        cells = []
        for column in list(CHOICE.values())[1:]:
            method = chosen[column]
            cells.append(f"{method} {times[ROWS[method]][column].strip()}" if method in ROWS else method)
        rows.append([lines[0].split(",")[0].replace("_", " "), *cells])
    return table(["scene", *(f"{accuracy:.0e}".replace("e-0", "e-") for accuracy in list(CHOICE)[1:])], rows)


def explicit_part(bench):
    """Returns the time of the best method that conserves over the better bare one."""
    rows = []
    for block in re.split(r"\n(?=[^\n]*\nattitude known to)", bench("explicit")):
        title = block.strip().splitlines()[0]
        for label, words in (("", "best of ours over the better bare"), (", by steps", "best of our steps over the bare")):
            ratios = re.search(words + r"\s+(.*)", block)
            if ratios:
                rows.append([title + label, *ratios[1].split()])
    return table(["motion", "1e-4", "1e-6", "1e-8", "1e-12"], rows)


def members_part(bench):
    """Returns the time of a member of a sweep by one thread."""
    members = re.findall(r"^ +(\d+) +1 +([\d.]+)$", bench("ensemble"), re.MULTILINE)
    costs = sorted(float(cost) for _, cost in members)
    return f"One member takes {costs[0]:.0f} to {costs[-1]:.0f} µs, in sweeps of {members[0][0]} to {members[-1][0]} members.\n"


def insert(page, name, part):
    """Puts a part between its markers."""
    path = f"{page}.md"
    with open(path, encoding="utf-8") as file:
        text = file.read()
    begin, end = f"<!-- begin {name} -->\n", f"<!-- end {name} -->\n"
    if begin not in text or end not in text:
        sys.exit(f"costs: {path} lacks the markers of '{name}'")
    head, rest = text.split(begin, 1)
    with open(path, "w", encoding="utf-8") as file:
        file.write(head + begin + part + end + rest.split(end, 1)[1])
    print(f"Written: {path}, {name}", flush=True)


def main(program, folder, *names):
    os.makedirs(DATA, exist_ok=True)

    def bench(name):
        return output(name, [f"{folder}/bench_{name}"])

    parts = {"step": ("bench/cost-of-a-step", lambda: step_part(bench)),
             "methods": ("bench/cost-of-a-step", lambda: methods_part(program)),
             "frames": ("bench/cost-of-a-step", lambda: frames_part(program)),
             "tangent": ("bench/cost-of-a-step", lambda: tangent_part(bench)),
             "interfaces": ("bench/cost-of-a-step", lambda: interfaces_part(folder)),
             "handles": ("bench/cost-of-a-step", lambda: handles_part(folder)),
             "heavy_top": ("docs/results/accuracy-costs", lambda: ranking_part(program, "heavy_top")),
             "choice": ("docs/results/accuracy-costs", lambda: choice_part(bench)),
             "explicit": ("docs/results/accuracy-costs", lambda: explicit_part(bench)),
             "members": ("docs/results/accuracy-costs", lambda: members_part(bench))}
    for name, (page, make) in parts.items():
        if not names or name in names:
            insert(page, name, make())


if __name__ == "__main__":
    main(*sys.argv[1:])
