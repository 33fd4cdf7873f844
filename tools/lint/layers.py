"""Tests that the layers of the sources point one way, and draws them from the `use` statements.

    tools/lint/layers.py --write     the column `uses` of the table in CONTRIBUTING.md, and docs/figures/layers.svg
    tools/lint/layers.py --check     exit status 1 for a use that points the wrong way, and where table or picture are not so

The order of the layers is that of the table in CONTRIBUTING.md. The picture leaves out what follows from other arrows.
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

# Of the picture: sizes of boxes and of the space between them.
WIDTH, HEIGHT, ACROSS, DOWN, MARGIN = 264, 84, 126, 26, 12
# Between arrows side by side.
LANE = 9
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


class Drawing:
    """Where each layer has its box: rows by how many layers are below it, the longest chain in the first column."""

    def __init__(self, layers, direct):
        self.layers, self.direct, self.arrows = layers, direct, {}
        self.rows = {}
        for layer in layers:
            self.rows[layer] = 1 + max((self.rows[below] for below in direct[layer]), default=-1)
        self.columns = dict.fromkeys(self.longest_chain(), 0)
        beside = [layer for layer in layers if layer not in self.columns]
        # In a row, those first that stand above what they use.
        for layer in sorted(beside, key=lambda layer: (self.rows[layer], not set(direct[layer]) & set(beside))):
            self.columns[layer] = self.free_column(layer)
        self.highest = max(self.rows.values())

    def longest_chain(self):
        """One layer of each row, each used by the one above it."""
        chain = [max(self.layers, key=lambda layer: (self.rows[layer], -len(self.direct[layer])))]
        while self.direct[chain[-1]]:
            chain.append(max(self.direct[chain[-1]], key=self.rows.get))
        return chain

    def free_column(self, layer):
        """That of a layer used and not in the first column, else the first one free in the row."""
        taken = {self.columns[other] for other in self.columns if self.rows[other] == self.rows[layer]}
        wanted = [self.columns.get(below, 0) for below in self.direct[layer]] + list(range(1, len(self.layers)))
        return next(column for column in wanted if column > 0 and column not in taken)

    def corner(self, layer):
        """Left upper corner of a box."""
        return (MARGIN + self.columns[layer] * (WIDTH + ACROSS),
                MARGIN + (self.highest - self.rows[layer]) * (HEIGHT + DOWN))

    def box(self, layer):
        x, y = self.corner(layer)
        lines = textwrap.wrap(self.layers[layer].replace("`", ""), 40)
        return [f"<rect x='{x}' y='{y}' width='{WIDTH}' height='{HEIGHT}' rx='5' fill='#eef3fa' stroke='#4a6a94'/>",
                f"<text x='{x + 10}' y='{y + 19}' font-size='14' font-weight='bold'>{escape(short(layer))}</text>"] + [
                f"<text x='{x + 10}' y='{y + 35 + 14 * i}' font-size='11'>{escape(line)}</text>"
                for i, line in enumerate(lines)]

    def next_of(self, place, spread=False):
        """How far the next arrow is from the first one at a place; on both sides of the middle where they spread."""
        count = self.arrows[place] = self.arrows.get(place, -1) + 1
        return LANE * ((count + 1) // 2) * (1 if count % 2 else -1) if spread else LANE * count

    def side(self, layer, shift=0):
        """Where the next arrow meets the right side of a box; shifted, the left one."""
        return self.corner(layer)[1] + HEIGHT // 2 + shift + self.next_of((layer, shift), True)

    def lane(self, column):
        """The next way down to the right of a column."""
        return MARGIN + column * (WIDTH + ACROSS) + WIDTH + 16 + self.next_of(column)

    def arrow(self, layer, below):
        """From a layer to one that it uses: straight down, or by a lane of its own between two columns."""
        (x, y), (x_below, y_below) = self.corner(layer), self.corner(below)
        column, column_below = self.columns[layer], self.columns[below]
        between = any(self.columns[other] == column and self.rows[below] < self.rows[other] < self.rows[layer]
                      for other in self.layers)
        if column == column_below and not between:
            points = f"M{x + WIDTH // 2} {y + HEIGHT} V{y_below}"
        elif column == column_below:
            points = f"M{x + WIDTH} {self.side(layer)} H{self.lane(column)} V{self.side(below)} H{x + WIDTH}"
        elif column == column_below + 1:
            points = f"M{x} {self.side(layer, 5)} H{self.lane(column_below)} V{self.side(below)} H{x_below + WIDTH}"
        elif column > column_below:
            # Below its own row, over the boxes of the next one.
            gap = y + HEIGHT + 9 + self.next_of(("gap", self.rows[layer]))
            points = f"M{x + WIDTH // 2} {y + HEIGHT} V{gap} H{self.lane(column_below)} V{self.side(below)} H{x_below + WIDTH}"
        else:
            gap = y_below - 16 + self.next_of(("gap", self.rows[below] + 1))
            points = f"M{x + WIDTH} {self.side(layer)} H{self.lane(column)} V{gap} H{x_below + WIDTH // 2} V{y_below}"
        return f"<path d='{points}' fill='none' stroke='#333' marker-end='url(#tip)'/>"

    def text(self):
        width = 2 * MARGIN + (1 + max(self.columns.values())) * (WIDTH + ACROSS) - ACROSS
        height = 2 * MARGIN + (1 + self.highest) * (HEIGHT + DOWN) - DOWN
        lines = [f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width} {height}' width='{width}' "
                 f"height='{height}' {FONT}>",
                 "<title>The layers of nutate: an arrow leads to a layer that is used</title>",
                 "<defs><marker id='tip' viewBox='0 0 10 10' refX='9' refY='5' markerWidth='7' markerHeight='7' "
                 "orient='auto'><path d='M0 0 L10 5 L0 10 z' fill='#333'/></marker></defs>",
                 f"<rect width='{width}' height='{height}' fill='white'/>"]
        lines += [self.arrow(layer, below) for layer in self.layers for below in self.direct[layer]]
        for layer in self.layers:
            lines += self.box(layer)
        return "\n".join(lines + ["</svg>", ""])


def main():
    layers = read_layers()
    uses, complaints = read_uses(layers)
    with open(TABLE, encoding="utf-8") as file:
        table = file.read()
    wanted = {TABLE: new_table(table, layers, uses), PICTURE: Drawing(layers, direct_uses(uses)).text()}
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
