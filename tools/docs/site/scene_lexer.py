"""Colours for the scene files in the documentation: blocks of the language `nml`."""

from pygments.lexer import RegexLexer
from pygments.token import Comment, Keyword, Literal, Name, Number, Operator, Punctuation, String, Text


class SceneLexer(RegexLexer):
    """Recognises groups, keys and values of a scene file."""

    name = "Scene of nutate"
    aliases = ["nml"]
    tokens = {"root": [(r"![^\n]*", Comment.Single),
                       (r"&\w+", Keyword),
                       (r"'[^'\n]*'|\"[^\"\n]*\"", String),
                       (r"\.(true|false)\.", Literal),
                       (r"[-+]?(\d+\*)?[-+]?(\d+\.?\d*|\.\d+)([edED][-+]?\d+)?", Number),
                       (r"[A-Za-z]\w*(?=\s*=)", Name.Attribute),
                       (r"=", Operator),
                       (r"[,/*]", Punctuation),
                       (r"\w+", Name),
                       (r".|\n", Text)]}


def setup(app):
    """Registers the lexer."""
    app.add_lexer("nml", SceneLexer)
    return {"parallel_read_safe": True}
