"""Headers of include/ in Markdown: every declaration with its docstring, whose arguments become a list."""

import pathlib
import re
import textwrap

INCLUDE = pathlib.Path(__file__).resolve().parent.parent.parent.parent / "include"
# A comment, a constant, a line of the preprocessor, a declaration up to its semicolon.
PART = re.compile(r"/\*(?P<comment>.*?)\*/|#define (?P<constant>\w+) \d+|#[^\n]*|extern \"C\" \{|\}(?!\s*;)"
                  r"|(?P<declaration>(?:typedef|enum|int|void|size_t|double)\b[^;{]*(?:\{[^}]*\}[^;]*)?)\s*;",
                  re.DOTALL)
# A tag of a docstring with its direction and its text, which ends before the next tag.
TAG = re.compile(r"@(?:param\[(?P<direction>[a-z,]+)\] (?P<name>\w+)|(?P<result>return)) +(?P<text>.*?)(?= @param| @return|$)", re.DOTALL)


def parts_of(text):
    """Yields (kind, text) of what a header holds, in order: "comment", "constant" or "declaration"."""
    for found in PART.finditer(text):
        if found.lastgroup:
            yield found.lastgroup, found[found.lastgroup]


def plain(comment):
    """Returns the lines of a comment without its stars."""
    lines = [re.sub(r"^ ?\* ?", "", line) for line in comment.strip("\n").split("\n")]
    return textwrap.dedent("\n".join([lines[0].strip(), textwrap.dedent("\n".join(lines[1:]))])).strip()


def marked(sentences):
    """Returns sentences with the names of C in them as code."""
    return re.sub(r"(?<![`\w.])(&?\b[A-Za-z]\w*_\w+\b(?:\(\))?|&\w+)(?![`\w])", r"`\1`", sentences)


def prose_of(comment):
    """Returns a comment in Markdown: its sentences, its arguments as a list, and the status."""
    sentences = re.split(r"\s@(?:param|return)\b", comment)[0]
    arguments, results = [], []
    for tag in TAG.finditer(" ".join(comment.split())):
        text = marked(tag["text"])
        if tag["result"]:
            results.append(f"S{text[1:]}" if text.startswith("status") else f"Returns {text}.")
        else:
            arguments.append(f"- `{tag['name']}` ({tag['direction']}): {text}")
    return "\n\n".join(part for part in (marked(sentences.strip()), "\n".join(arguments), *results) if part)


def directive(kind, signature, body):
    """Returns a declaration in Markdown."""
    fence = "`" * (4 if "```" in body else 3)
    return f"{fence}{{c:{kind}}} {signature}\n\n{body}\n{fence}\n"


def compound(kind, name, inside, members, body):
    """Returns an enumeration or a struct in Markdown, with the pairs (member, meaning) as directives of kind `inside`."""
    parts = [directive(inside, " ".join(member.split()), marked(" ".join(meaning.split()))) for member, meaning in members]
    return f"`````{{c:{kind}}} {name}\n\n{body}\n\n" + "\n".join(parts) + "`````\n"


def declared(declaration, comment):
    """Returns a declaration in Markdown."""
    body, words = prose_of(comment), " ".join(declaration.split())
    if words.startswith("enum"):
        values = re.findall(r"(\w+ = \d+),?[ ]*/\*\*<(.*?)\*/", declaration)
        return compound("enum", words.split()[1], "enumerator", values, body)
    if words.startswith("typedef struct"):
        members = re.findall(r"(\w[^;{]*);\s*/\*\*<(.*?)\*/", declaration, re.DOTALL)
        return compound("struct", words.split()[-1], "member", members, body)
    if words.startswith("typedef"):
        return directive("type", words.removeprefix("typedef "), body)
    return directive("function", words, body)


def markdown(name):
    """Returns a header in Markdown, its sections as headings; the docstring of the file is left out."""
    result, comment = [], ""
    for position, (kind, part) in enumerate(parts_of((INCLUDE / name).read_text(encoding="utf-8"))):
        if kind != "comment":
            result.append(declared(part, comment) if kind == "declaration" else directive("macro", part, prose_of(comment)))
            comment = ""
            continue
        if comment:
            result.append(prose_of(comment) + "\n")
        comment = ""
        if part.strip().startswith("----"):
            result.append(f"### {part.strip(' -')}\n")
        elif position > 0:
            comment = plain(part)
    # What stands before the first heading would be lost.
    return "\n".join(result if result[0].startswith("###") else ["### Declarations\n", *result])
