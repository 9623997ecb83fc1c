"""The preprocessor of mdBook for the guide: formulas are marked, figures get their captions."""

import json
import sys

from captions import captioned
from formulas import marked


def _prepare(item):
    chapter = item.get("Chapter") if isinstance(item, dict) else None
    if chapter is None:
        return
    chapter["content"] = marked(captioned(chapter["content"]))
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
