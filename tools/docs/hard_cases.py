"""Writes the summary of docs/results/hard-cases.md from the rows of docs/results/hard-cases.csv: a table of groups with the worst of
their cases and variants, and a list of what else was measured in some of them.

    python3 tools/docs/hard_cases.py CASES ROWS PAGE

CASES lists groups, cases and what could go wrong in each, as `unit --stress` writes them; ROWS is the CSV file; PAGE has a pair of markers.
"""

import csv
import re
import sys

HEADER = "| group | cases | largest error | of the case | rejected |\n|---|---|---|---|---|\n"
# Groups of which the page lists what else was measured.
LISTED = ("long", "large_steps")
BEGIN, END = "<!-- begin cases -->\n", "<!-- end cases -->\n"


def read_cases(path):
    """Returns the groups: name, title, and cases."""
    groups = []
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            fields = line.rstrip("\n").split("\t")
            if fields[0]:
                groups.append((fields[0], fields[1], []))
            else:
                groups[-1][2].append(fields[1])
    return groups


def number(text):
    """Returns a number of the CSV file in as few characters as show its two digits."""
    value = float(text)
    if value == int(value) and abs(value) < 1e5:
        return str(int(value))
    if 0.01 <= abs(value) < 1e5:
        return f"{value:.3g}"
    return re.sub(r"e([-+])0?", lambda sign: "e" + sign.group(1).replace("+", ""), f"{value:.1e}")


def measured(groups, rows):
    """Returns the list of what else was measured, over all variants: a line for each measure, with the cases."""
    lines = {}
    for name, _, cases in groups:
        for case in cases:
            own = [row for row in rows if row["group"] == name and row["case"] == case and row["measure"]]
            values = sorted((row["value"] for row in own), key=lambda text: abs(float(text)))
            if values:
                low, high = number(values[0]), number(values[-1])
                found = f"{re.sub(', (?=1e|Δt).*', '', case)} {low}" + (f" to {high}" if high != low else "")
                lines.setdefault(own[0]["measure"], []).append(found)
    return "".join(f"- *{measure}*: {'; '.join(found)}\n" for measure, found in lines.items())


def group_parts(group, rows):
    """Returns the row of a group in the table, and the cases that have no rows."""
    name, title, cases = group
    own = [row for row in rows if row["group"] == name and row["case"] in cases]
    if not own:
        return "", cases
    largest = lambda row: max(float(row[key]) for key in ("energy", "momentum", "norm"))
    worst = max(own, key=largest)
    rejected = sum(row["rejected"] == "1" for row in own)
    tried = [case for case in cases if any(row["case"] == case for row in own)]
    cells = [title, str(len(tried)), number(largest(worst)), worst["case"], f"{rejected} of {len(own)}"]
    if any(row["message"].startswith("FAILED") for row in own):
        cells[0] += ": **FAILED**"
    return "| " + " | ".join(cells) + " |\n", [case for case in cases if case not in tried]


def main(cases, csv_file, page):
    with open(csv_file, encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    with open(page, encoding="utf-8") as file:
        text = file.read()
    if BEGIN not in text or END not in text:
        sys.exit(f"hard_cases: {page} lacks the markers")
    groups = read_cases(cases)
    table, missing = zip(*(group_parts(group, rows) for group in groups))
    part = HEADER + "".join(table).replace("Δt|Ω|", "Δt\\|Ω\\|").replace("|q|", "\\|q\\|")
    left_out = [case for group in missing for case in group]
    if left_out:
        part += "\nNot part of the stored run: " + "; ".join(left_out) + ".\n"
    part += "\nMeasured besides:\n\n" + measured([group for group in groups if group[0] in LISTED], rows)
    with open(page, "w", encoding="utf-8") as file:
        file.write(text.split(BEGIN)[0] + BEGIN + part + END + text.split(END)[1])


if __name__ == "__main__":
    main(*sys.argv[1:])
