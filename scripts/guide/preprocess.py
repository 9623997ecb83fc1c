"""Preprocessor of mdBook: marks formulas, captions figures, and links the page in a tab."""

import json
import sys
from pathlib import Path

from captions import captioned
from formulas import marked

# where the front page has its link to the page in a tab, if `scripts/build-tab docs/src/tab` has
# built one
MARK = "<!-- ask in this tab -->"
LINK = (
    "**[Ask in this tab](tab/index.html)** what a fleet uses in a year: nothing is installed or "
    "sent."
)
TAB = Path(__file__).resolve().parents[2] / "docs" / "src" / "tab" / "index.html"


def _prepare(item):
    chapter = item.get("Chapter") if isinstance(item, dict) else None
    if chapter is None:
        return
    content = chapter["content"].replace(MARK, LINK) if TAB.exists() else chapter["content"]
    chapter["content"] = marked(captioned(content))
    for part in chapter["sub_items"]:
        _prepare(part)


def main():
    """Answer mdBook: whether it serves a renderer, or the book as it is to be rendered."""
    if sys.argv[1:2] == ["supports"]:
        return 0 if sys.argv[2] == "html" else 1
    _, book = json.load(sys.stdin)
    for item in book["items"]:
        _prepare(item)
    json.dump(book, sys.stdout)
    return 0


if __name__ == "__main__":
    sys.exit(main())
