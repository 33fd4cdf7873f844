"""Writes the tables of docs/results/hard-cases.md from the rows of docs/results/hard-cases.csv: one row per case, the worst of its
variants.

    python3 tools/docs/hard_cases.py CASES ROWS PAGE

CASES lists groups, cases and what could go wrong in each, as `unit --stress` writes them; ROWS is the CSV file; PAGE has a pair of markers
for each group.
"""

import csv
import re
import sys

HEADER = "| case | largest error | result |\n|---|---|---|\n"


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


def result(rows):
    """Returns what else was measured, over all variants, and how many of them were rejected."""
    parts = []
    values = sorted((row["value"] for row in rows if row["measure"]), key=lambda text: abs(float(text)))
    if values:
        low, high = number(values[0]), number(values[-1])
        measure = next(row["measure"] for row in rows if row["measure"])
        parts.append(f"{measure}: {low}" + (f" to {high}" if high != low else ""))
    rejected = sum(row["rejected"] == "1" for row in rows)
    if rejected:
        parts.append(f"{rejected} of {len(rows)} variants rejected")
    if any(row["message"].startswith("FAILED") for row in rows):
        parts.append("**FAILED**")
    return "; ".join(parts) or "within its bounds"


def table_row(case, rows):
    """Returns the row of a case: the largest error of all variants and invariants, and its result."""
    worst = number(max((row[key] for row in rows for key in ("energy", "momentum", "norm")), key=float))
    return "| " + " | ".join([case, worst, result(rows)]).replace("Δt|Ω|", "Δt\\|Ω\\|").replace("|q|", "\\|q\\|") + " |\n"


def group_part(group, rows):
    """Returns the part of a group, and the cases that have no rows."""
    name, title, cases = group
    text = f"### {title}\n\n" + HEADER
    missing = []
    for case in cases:
        variants = [row for row in rows if row["group"] == name and row["case"] == case]
        if variants:
            text += table_row(case, variants)
        else:
            missing.append(case)
    if missing:
        text += "\nNot part of the stored run: " + "; ".join(missing) + ".\n"
    return text


def main(cases, csv_file, page):
    with open(csv_file, encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    with open(page, encoding="utf-8") as file:
        text = file.read()
    for group in read_cases(cases):
        begin, end = f"<!-- begin {group[0]} -->\n", f"<!-- end {group[0]} -->\n"
        if begin not in text or end not in text:
            sys.exit(f"hard_cases: {page} lacks the markers of '{group[0]}'")
        head, rest = text.split(begin, 1)
        text = head + begin + group_part(group, rows) + end + rest.split(end, 1)[1]
    with open(page, "w", encoding="utf-8") as file:
        file.write(text)


if __name__ == "__main__":
    main(*sys.argv[1:])
