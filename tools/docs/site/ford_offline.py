"""Makes pages of FORD load Bootstrap from a copy beside them instead of the network, and MathJax not at all: the comments of the
sources have no TeX.   ford_offline.py FOLDER"""

import pathlib
import re
import shutil
import sys

import mkdocs

BOOTSTRAP = pathlib.Path(mkdocs.__file__).parent / "themes" / "mkdocs"
COPIES = ("css/bootstrap.min.css", "js/bootstrap.bundle.min.js")
# <link> and <script> with an address of the network, with what stands between the tags of a script.
STYLE = re.compile(r'<link href="https://[^"]*/bootstrap\.min\.css"[^>]*>')
SCRIPT = re.compile(r'<script src="https://[^"]*/bootstrap\.bundle\.min\.js"[^>]*></script>')
MATHJAX = re.compile(r'<script type="text/x-mathjax-config">.*?</script>|'
                     r'<script src="https://[^"]*/MathJax\.js[^"]*"[^>]*></script>',
                     re.DOTALL)


def main():
    folder = pathlib.Path(sys.argv[1])
    for name in COPIES:
        (folder / name).parent.mkdir(exist_ok=True)
        shutil.copyfile(BOOTSTRAP / name, folder / name)
    for page in folder.rglob("*.html"):
        up = "../" * (len(page.relative_to(folder).parts) - 1)
        text = page.read_text(encoding="utf-8")
        text = STYLE.sub(f'<link href="{up}css/bootstrap.min.css" rel="stylesheet">', text)
        text = SCRIPT.sub(f'<script src="{up}js/bootstrap.bundle.min.js"></script>', text)
        page.write_text(MATHJAX.sub("", text), encoding="utf-8")


if __name__ == "__main__":
    main()
