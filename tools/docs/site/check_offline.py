"""Fails if a page or a style of a site loads something from the network.   check_offline.py FOLDER"""

import pathlib
import re
import sys

ELSEWHERE = r"(?:https?:)?//"
# Tags that load what they name; a link only as style, script, font or icon.
TAG = re.compile(rf'<(?:script|img|iframe|source|video|audio)\b[^>]*\bsrc="{ELSEWHERE}[^"]*"'
                 rf'|<link\b(?=[^>]*\brel="[^"]*(?:stylesheet|preload|icon))[^>]*\bhref="{ELSEWHERE}[^"]*"')
STYLE = re.compile(rf'@import\s+(?:url\()?["\']?{ELSEWHERE}[^;]*|url\(["\']?{ELSEWHERE}[^)]*')


def main():
    folder = pathlib.Path(sys.argv[1])
    pages, found = 0, 0
    for path in sorted(folder.rglob("*")):
        pattern = {".html": TAG, ".css": STYLE}.get(path.suffix)
        if pattern is None or not path.is_file():
            continue
        pages += 1
        for loaded in pattern.findall(path.read_text(encoding="utf-8")):
            print(f"{path}: loads from the network: {loaded}")
            found += 1
    print(f"{pages} pages and styles, {found} load something from the network")
    return 1 if found or not pages else 0


if __name__ == "__main__":
    sys.exit(main())
