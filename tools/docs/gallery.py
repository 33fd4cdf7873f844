"""Writes the gallery, docs/gallery, from tools/docs/gallery.ini: pages with a section for each scene of scenes/, and an index with
thumbnails.

    tools/docs/gallery.py PROGRAM   pages and pictures; those of the bodies with a headless Chromium, where there is one
    tools/docs/gallery.py --check   exit status 1 where a scene has no entry here or no picture, or a page is not as written here
"""

import configparser
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import textwrap

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
GALLERY = os.path.join(TOP, "docs", "gallery")
SIZE = 480, 360
# The pages in their order.
PAGES = {"free-bodies": "Free bodies", "tops": "Tops, gyroscopes, pendulums", "satellites": "Satellites",
         "moons-asteroids": "Moons and asteroids"}
# Leaves the body alone on the page of nutate.view.
ALONE = "<style>header, #nutate-polhode, #nutate-curves { display: none !important } body { display: block !important } " \
        "#nutate-body { height: 100vh; margin: 0 !important; background: #fff !important }</style></head>"

SCENES = configparser.ConfigParser(interpolation=None)
SCENES.read(os.path.join(TOP, "tools", "docs", "gallery.ini"), encoding="utf-8")


def text_of(name):
    """The text of a scene, which its section shows."""
    with open(os.path.join(TOP, "scenes", f"{name}.nml"), encoding="utf-8") as file:
        return file.read()


def title_of(name):
    """The title of a scene."""
    return re.search(r"title\s*=\s*'(.*)'", text_of(name))[1].replace("''", "'")


def settings_of(name):
    """Overrides for the pictures of a scene."""
    return SCENES[name].get("settings", "").split()


def has_group(name, group):
    """True for a scene with a group, by which one that is made for a sweep or a fit is known."""
    return re.search(rf"^&{group}\b", text_of(name), re.MULTILINE) is not None


def options_of(name):
    """Options of `nutate run` for the picture of a scene; none if docs/figures has it."""
    picture = SCENES[name]["picture"]
    return [] if picture.endswith(".svg") else shlex.split(picture)


def picture_of(name):
    """The picture of the result of a scene, relative to the gallery."""
    return f"{name}_plot.png" if options_of(name) else f"../figures/{SCENES[name]['picture']}"


def anchor_of(name):
    """The anchor of a scene on its page."""
    return re.sub(r"[^\w -]", "", title_of(name).lower()).replace(" ", "-")


def section_of(name):
    """The section of a scene on its page."""
    scene = SCENES[name]
    command = f"nutate run scenes/{name}.nml"
    if options_of(name):
        command += f" --plot {name}.svg \\\n    {scene['picture']}"
    if has_group(name, "ensemble"):
        command = f"nutate sweep scenes/{name}.nml"
    if has_group(name, "measurement"):
        command = f"nutate fit scenes/{name}.nml --plot {name}.svg"
    text = textwrap.fill(f"**{scene['question']}** " + " ".join(scene["answer"].split()), 140, break_on_hyphens=False,
                         break_long_words=False)
    return f"""## {title_of(name)}

{text}

![{scene["caption"]}]({picture_of(name)})

*{" ".join(scene["see"].split())}*

```sh
{command}
```

![{scene['caption']}, body]({name}.png)

[{name}.nml](../../scenes/{name}.nml):

```nml
{text_of(name)}```
"""


def page(name):
    """A page of the gallery."""
    sections = [section_of(scene) for scene in SCENES.sections() if SCENES[scene]["page"] == name]
    return f"# {PAGES[name]}\n\n" + "\n".join(sections)


def index():
    """The page with the thumbnails."""
    lines = ["# Gallery", "", "Every bundled scene, its question and its command; `nutate view scenes/NAME.nml` shows the body in motion.", ""]
    for page_name, title in PAGES.items():
        lines += [f"## [{title}]({page_name}.md)", "", "| | | |", "|:-:|:-:|:-:|"]
        names = [name for name in SCENES.sections() if SCENES[name]["page"] == page_name]
        for i in range(0, len(names), 3):
            row = [(name, SCENES[name]["caption"]) for name in names[i:i + 3]]
            lines.append("| " + " | ".join(f"![][{name}.picture]" for name, _ in row) + " |")
            lines.append("| " + " | ".join(f"[{caption}][{name}]" for name, caption in row) + " |")
        lines += ["", *(f"[{name}]: {page_name}.md#{anchor_of(name)}\n[{name}.picture]: {picture_of(name)}" for name in names), ""]
    return "\n".join([*lines, "```{toctree}", ":hidden:", "", *PAGES, "```", ""])


def pages():
    """All pages by their paths."""
    texts = {name: page(name) for name in PAGES} | {"index": index()}
    return {os.path.join(GALLERY, f"{name}.md"): text for name, text in texts.items()}


def draw(program, name, folder):
    """The curves of a scene, where no figure of docs/figures has them."""
    if not options_of(name):
        return
    settings = [word for setting in settings_of(name) for word in ("--set", setting)]
    history = os.path.join(folder, f"{name}.csv")
    subprocess.run([program, "run", os.path.join(TOP, "scenes", f"{name}.nml"), "--quiet", "--output", history, *settings,
                    "--plot", os.path.join(GALLERY, f"{name}_plot.png"), *options_of(name)], check=True)


def photograph(browser, name, folder):
    """The picture of the body."""
    import nutate
    page = nutate.view(os.path.join(TOP, "scenes", f"{name}.nml"), None, *settings_of(name),
                       begin=float(SCENES[name]["begin"]))
    path = os.path.join(folder, f"{name}.html")
    with open(path, "w", encoding="utf-8") as file:
        file.write(page.text.replace("</head>", ALONE, 1))
    subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                    f"--user-data-dir={folder}/profile",
                    f"--window-size={SIZE[0]},{SIZE[1]}", "--virtual-time-budget=3000",
                    f"--screenshot={os.path.join(GALLERY, name)}.png", f"file://{path}"], check=True, capture_output=True,
                   timeout=120)


def check():
    """Complaints about what is not there, or not as it is written here."""
    bundled = {name[:-4] for name in os.listdir(os.path.join(TOP, "scenes")) if name.endswith(".nml")}
    found = [f"tools/docs/gallery.ini: no entry for scenes/{name}.nml" for name in sorted(bundled - set(SCENES.sections()))]
    found += [f"tools/docs/gallery.ini: there is no scenes/{name}.nml" for name in sorted(set(SCENES.sections()) - bundled)]
    for path, text in ({} if found else pages()).items():
        name = os.path.relpath(path, TOP)
        if not os.path.exists(path) or open(path, encoding="utf-8").read() != text:
            found.append(f"{name}: not as tools/docs/gallery.py writes it (expected make figures)")
        for picture in re.findall(r"!\[[^]]*\]\(([^)]*\.(?:png|svg))\)", text):
            if not os.path.exists(os.path.join(GALLERY, picture)):
                found.append(f"{name}: there is no {picture} (expected make figures)")
    return found


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    if sys.argv[1] == "--check":
        complaints = check()
        print("\n".join(complaints), end="\n" if complaints else "")
        return 1 if complaints else 0
    os.makedirs(GALLERY, exist_ok=True)
    for path, text in pages().items():
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
    browser = shutil.which("chromium")
    with tempfile.TemporaryDirectory() as folder:
        for name in SCENES.sections():
            draw(os.path.abspath(sys.argv[1]), name, folder)
            if browser:
                photograph(browser, name, folder)
    print("Drawn: docs/gallery")
    return 0


if __name__ == "__main__":
    sys.exit(main())
