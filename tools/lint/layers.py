"""Tests that the layers of the sources point one way, and draws them from the `use` statements.

    tools/lint/layers.py --write     the column `uses` of the table in CONTRIBUTING.md, and docs/figures/layers.svg
    tools/lint/layers.py --check     exit status 1 for a use that points the wrong way, and where table or picture are not so

The order of the layers is that of the table in CONTRIBUTING.md.
"""

import glob
import os
import re
import sys
import textwrap
from xml.sax.saxutils import escape

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
TABLE = os.path.join(TOP, "CONTRIBUTING.md")
PICTURE = os.path.join(TOP, "docs", "figures", "layers.svg")
ROW = re.compile(r"^\| `((?:src|app|mpi)[\w/.]*)` \| (.*?) \| ?(.*?) ?\|$", re.MULTILINE)
USE = re.compile(r"^\s*use\b\s*(?:,[^:]*::|::)?\s*(\w+)", re.IGNORECASE | re.MULTILINE)

# Measures of the picture: size of a cell, width of the descriptions, height of the names over the columns, distance of a cell from its edge.
CELL, TEXTS, HEADS, INSET = 26, 500, 150, 3
DIRECT, INDIRECT, EDGE = "#2c5f8a", "#c9dcee", "#d8d8d8"
FONT = "font-family='Helvetica, Arial, sans-serif'"


def read_layers():
    """What each layer holds, by its folder, in their order."""
    with open(TABLE, encoding="utf-8") as file:
        return {folder: holds for folder, holds, _ in ROW.findall(file.read())}


def short(folder):
    """The layer's name in table and picture."""
    return folder.rstrip("/").removeprefix("src/")


def layer_of(path, layers):
    """The layer of a file: the one with the longest name that the path begins with; None outside all."""
    found = [folder for folder in layers if path == folder or path.startswith(folder.rstrip("/") + "/")]
    return max(found, key=len, default=None)


def read_uses(layers):
    """The layers that each layer uses, and complaints about what points the wrong way."""
    order = list(layers)
    homes, texts, complaints = {}, {}, []
    paths = [path for top in ("src", "app", "mpi/app") for path in glob.glob(f"{TOP}/{top}/**/*.f90", recursive=True)]
    for path in sorted(paths):
        name = os.path.relpath(path, TOP)
        home = layer_of(name, layers)
        if home is None:
            complaints.append(f"{name}: in no layer of CONTRIBUTING.md")
            continue
        homes[os.path.basename(path)[:-4].lower()] = home
        with open(path, encoding="utf-8") as file:
            texts[name] = (home, file.read())
    uses = {layer: set() for layer in order}
    for name, (home, text) in texts.items():
        for module in {match.lower() for match in USE.findall(text)}:
            used = homes.get(module, home)
            if order.index(used) > order.index(home):
                complaints.append(f"{name}: uses {module} of {short(used)}, a later layer than {short(home)}")
            elif used != home:
                uses[home].add(used)
    return uses, complaints


def reachable(layer, uses):
    """All layers below one."""
    found, waiting = set(), list(uses[layer])
    while waiting:
        below = waiting.pop()
        if below not in found:
            found.add(below)
            waiting += uses[below]
    return found


def direct_uses(uses):
    """The uses that do not follow from others."""
    return {layer: [below for below in uses if below in known
                    and not any(below in reachable(other, uses) for other in known if other != below)]
            for layer, known in uses.items()}


def new_table(text, layers, uses):
    """The text of CONTRIBUTING.md with the column `uses` as the sources have it."""
    def row(match):
        known = ", ".join(short(below) for below in layers if below in uses[match[1]])
        return f"| `{match[1]}` | {match[2]} | {known} |" if known else f"| `{match[1]}` | {match[2]} | |"
    return ROW.sub(row, text)


def picture(layers, uses):
    """The matrix of the layers: a row for each with a cell for each layer that it uses, dark where no other layer passes it on."""
    order, direct = list(layers), direct_uses(uses)
    width, height = TEXTS + CELL * len(order) + 44, HEADS + CELL * len(order) + 8
    lines = [f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width} {height}' width='{width}' height='{height}' {FONT}>",
             "<title>The layers of nutate: each row has a cell for each layer that it uses</title>",
             f"<rect width='{width}' height='{height}' fill='white'/>"]
    for k, (fill, text) in enumerate(((DIRECT, "uses"), (INDIRECT, "uses, and a layer that it uses does so, too"))):
        lines += [f"<rect x='12' y='{16 + 24 * k}' width='{CELL - 2 * INSET}' height='{CELL - 2 * INSET}' fill='{fill}'/>",
                  f"<text x='40' y='{31 + 24 * k}' font-size='12'>{text}</text>"]
    for i, layer in enumerate(order):
        y = HEADS + CELL * i
        holds = textwrap.shorten(re.split("[:;]", layers[layer].replace("`", ""))[0], 60, placeholder=" …")
        lines += [f"<path d='M12 {y} H{TEXTS + CELL * (i + 1)}' stroke='{EDGE}'/>",
                  f"<text x='12' y='{y + 17}' font-size='12'><tspan font-weight='bold'>{escape(short(layer))}</tspan>  {escape(holds)}</text>",
                  f"<text transform='translate({TEXTS + CELL * i + 17} {HEADS - 8}) rotate(-60)' font-size='12'>{escape(short(layer))}</text>"]
        for j, below in enumerate(order[:i]):
            if below in uses[layer]:
                lines.append(f"<rect x='{TEXTS + CELL * j + INSET}' y='{y + INSET}' width='{CELL - 2 * INSET}' "
                             f"height='{CELL - 2 * INSET}' fill='{DIRECT if below in direct[layer] else INDIRECT}'/>")
        lines.append(f"<rect x='{TEXTS + CELL * i + INSET}' y='{y + INSET}' width='{CELL - 2 * INSET}' height='{CELL - 2 * INSET}' "
                     f"fill='none' stroke='{EDGE}'/>")
    return "\n".join(lines + ["</svg>", ""])


def main():
    layers = read_layers()
    uses, complaints = read_uses(layers)
    with open(TABLE, encoding="utf-8") as file:
        table = file.read()
    wanted = {TABLE: new_table(table, layers, uses), PICTURE: picture(layers, uses)}
    if sys.argv[1:] == ["--write"]:
        for path, text in wanted.items():
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
    elif sys.argv[1:] == ["--check"]:
        for path, text in wanted.items():
            if not os.path.exists(path) or open(path, encoding="utf-8").read() != text:
                complaints.append(f"{os.path.relpath(path, TOP)}: not as the sources: python3 tools/lint/layers.py --write")
    else:
        sys.exit(__doc__)
    print("\n".join(complaints), end="\n" if complaints else "")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
