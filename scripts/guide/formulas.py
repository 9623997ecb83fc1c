r"""Mark the formulas of a page.

``$…$`` within a line and ``$$…$$`` become spans whose every sign is escaped, so that Markdown
leaves underscores, backslashes and bars alone, in tables too; ``docs/src/guide.js`` typesets them
in the browser. Code is never a formula. A dollar is money or shell where a space follows it, where
a space stands before its partner, or a letter or digit after it, and where it is written ``\$``.
"""

import re

_FENCE = (
    r"^(?P<indent>[ >]*)(?P<fence>`{3,}|~{3,})[^\n]*\n(?:.*?\n)??(?P=indent) *(?P=fence)[`~]*[ ]*$"
)
_CODE = r"(?P<ticks>`+)(?!`)(?:[^`]|(?!(?P=ticks)(?!`))`+)+?(?<!`)(?P=ticks)(?!`)"
_COMMENT = r"<!--.*?-->"
_ESCAPED = r"\\[\\$`]"
_DISPLAY = r"\$\$(?P<display>(?:[^$\n]|\\\$|\n(?!\s*\n))+?)\$\$"
_INLINE = r"(?<![\w$])\$(?P<inline>(?![\s$])(?:\\.|[^\\$\n]|\n(?!\s*\n))*?(?<!\s))\$(?![\w$])"
_PARTS = re.compile(
    f"{_FENCE}|{_COMMENT}|{_CODE}|{_ESCAPED}|{_DISPLAY}|{_INLINE}", re.MULTILINE | re.DOTALL
)


def marked(text):
    """Give the text of a page with its formulas marked."""
    return _PARTS.sub(_part, text)


def _part(match):
    if (display := match["display"]) is not None:
        return _span("math display", display)
    if (inline := match["inline"]) is not None:
        return _span("math", inline)
    return match[0]


def _span(name, tex):
    signs = (
        c if c.isalnum() or c == " " or not c.isascii() else f"&#{ord(c)};"
        for c in " ".join(tex.split())
    )
    return f'<span class="{name}">{"".join(signs)}</span>'
