"""Headers of include/ in Markdown: every declaration with its comment."""

import pathlib
import re
import textwrap

INCLUDE = pathlib.Path(__file__).resolve().parent.parent.parent.parent / "include"
ARROW = re.compile(r"==>|<==|<=>")
# A comment, a line of the preprocessor, a declaration up to its semicolon.
PART = re.compile(r"/\*(?P<comment>.*?)\*/|#[^\n]*|extern \"C\" \{|\}(?!\s*;)"
                  r"|(?P<declaration>(?:typedef|enum|int|void|size_t|double)\b[^;{]*(?:\{[^}]*\})?)\s*;",
                  re.DOTALL)


def parts_of(text):
    """Yields (kind, text, whether it stands behind a declaration on its line) of what a header holds, in order."""
    for found in PART.finditer(text):
        if found["comment"] is not None:
            behind = text[text.rfind("\n", 0, found.start()) + 1:found.start()].strip() != ""
            yield "comment", found["comment"], behind
        elif found["declaration"]:
            yield "declaration", found["declaration"], False


def plain(comment):
    """Returns the lines of a comment without its stars."""
    lines = [re.sub(r"^ ?\* ?", "", line) for line in comment.strip("\n").split("\n")]
    return textwrap.dedent("\n".join([lines[0].strip(), textwrap.dedent("\n".join(lines[1:]))])).strip()


def marked(sentences):
    """Returns sentences with the names of C in them as code."""
    return re.sub(r"(?<![`\w.])(&?\b[A-Za-z]\w*_\w+\b(?:\(\))?|&\w+)(?![`\w])", r"`\1`", sentences)


def prose_of(comment):
    """Returns a comment in Markdown: its sentences, its arguments as they stand, and what it says of the status."""
    lines = comment.split("\n")
    first = next((i for i, line in enumerate(lines) if ARROW.search(line)), len(lines))
    last = next((i for i in range(first, len(lines)) if lines[i].startswith("Status")), len(lines))
    arguments = lines[first:last]
    sentences = lines[:first]
    if arguments:
        start = ARROW.search(arguments[0]).start()
        sentences.append(arguments[0][:start].strip())
        arguments[0] = " " * start + arguments[0][start:] if len(arguments) > 1 and not sentences[-1] else arguments[0][start:]
    block = textwrap.dedent("\n".join(arguments)).strip("\n")
    parts = [marked("\n".join(sentences).strip()), f"```text\n{block}\n```" if block else "", marked("\n".join(lines[last:]))]
    return "\n\n".join(part for part in parts if part)


def directive(kind, signature, body):
    """Returns a declaration in Markdown."""
    fence = "`" * (4 if "```" in body else 3)
    return f"{fence}{{c:{kind}}} {signature}\n\n{body}\n{fence}\n"


def enumeration(words, declaration, body):
    """Returns an enumeration and its values in Markdown."""
    values = re.findall(r"(\w+ = \d+),?[ ]*(?:/\*(.*?)\*/)?", declaration)
    inside = [directive("enumerator", value, meaning.strip()) for value, meaning in values]
    return f"`````{{c:enum}} {words.split()[1]}\n\n{body}\n\n" + "\n".join(inside) + "`````\n"


def declared(declaration, comment):
    """Returns a declaration in Markdown."""
    body, words = prose_of(comment), " ".join(declaration.split())
    if words.startswith("enum"):
        return enumeration(words, declaration, body)
    if words.startswith("typedef struct"):
        return directive("struct", words.split()[-1], body)
    if words.startswith("typedef"):
        return directive("type", words.removeprefix("typedef "), body)
    return directive("function", words, body)


def markdown(name):
    """Returns a header in Markdown, its sections as headings. Functions below one comment share it: the last one has it."""
    result, comment, waiting = [], "", []

    def flush():
        nonlocal comment
        result.extend(declared(each, "") for each in waiting[:-1])
        if waiting:
            result.append(declared(waiting[-1], comment))
        elif comment:
            result.append(prose_of(comment) + "\n")
        comment = ""
        waiting.clear()

    for position, (kind, part, behind) in enumerate(parts_of((INCLUDE / name).read_text(encoding="utf-8"))):
        if kind == "declaration":
            waiting.append(part)
        elif behind:
            last = waiting.pop()
            flush()
            waiting, comment = [last], plain(part)
            flush()
        else:
            flush()
            if part.strip().startswith("----"):
                result.append(f"### {part.strip(' -')}\n")
            elif position > 0:
                comment = plain(part)
    flush()
    # What stands before the first heading would be lost.
    return "\n".join(result if result[0].startswith("###") else ["### Declarations\n", *result])
