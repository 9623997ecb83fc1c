"""Give the figures of a page their captions: a picture in its own paragraph shows its words."""

import re

_FENCE = (
    r"^(?P<indent>[ >]*)(?P<fence>`{3,}|~{3,})[^\n]*\n(?:.*?\n)??(?P=indent) *(?P=fence)[`~]*[ ]*$"
)
_FIGURE = r"(?<=\n\n)!\[(?P<words>[^\]]+)\]\((?P<file>[^)\s]+)\)(?=\n\n|\n?\Z)"
_PARTS = re.compile(f"{_FENCE}|{_FIGURE}", re.MULTILINE | re.DOTALL)


def captioned(text):
    """Give the text of a page with captions below its figures."""
    return _PARTS.sub(_part, text)


def _part(match):
    if match["words"] is None:
        return match[0]
    caption = f"<figcaption>\n\n{match['words']}\n\n</figcaption>"
    return f"<figure>\n\n![{match['words']}]({match['file']})\n\n{caption}\n\n</figure>"
