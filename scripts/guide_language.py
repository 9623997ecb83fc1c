#!/usr/bin/env python3
"""Prints places of the guide's pages that are hard to read: file, line and fault.

``scripts/guide_language.py docs/src/theory/*.md``. Faults are sentences of more than 30 words,
sentences with two or more semicolons, tables with a column without a label, and programs that know,
want or tell. Code, maths, tables and headings are no sentences. The last line counts the faults.
"""

import itertools
import re
import sys
from collections import Counter
from pathlib import Path

MOST_WORDS = 30
CODE = re.compile(r"^```.*?^```$|^\$\$.*?^\$\$$|^<!--.*?-->$", re.MULTILINE | re.DOTALL)
END = re.compile(r"(?:(?<=[a-z0-9)\]`*$%°²³½][.?!:])|(?<=[A-Z]{2}[.?!:]))\s+(?=[A-Z*`$\[(_0-9-])")
NO_PERSON = re.compile(
    r"\b(?:program|model|study|truck|step|fit|run)s? (?:knows?|wants?|tells?)\b", re.IGNORECASE
)
RULE = re.compile(r"^\|(?:\s*:?-+:?\s*\|)+$")


def blank(match: re.Match[str]) -> str:
    """Give the line ends of what is no prose."""
    return "\n" * match.group().count("\n")


def paragraphs(text: str) -> list[tuple[int, str]]:
    """Give paragraphs and items of lists, each with its first line."""
    found: list[tuple[int, str]] = []
    ends = True
    for number, line in enumerate(text.splitlines(), start=1):
        item = re.match(r"\s*(?:[-*]|\d+\.)\s", line)
        if not line.strip() or line.lstrip().startswith(("#", "|", "!")):
            ends = True
        elif ends or item:
            found.append((number, line.strip()))
            ends = False
        else:
            found[-1] = (found[-1][0], f"{found[-1][1]} {line.strip()}")
    return found


def faults(page: Path) -> list[tuple[int, str, str]]:
    """Give line, kind and text of each fault of a page."""
    text = CODE.sub(blank, page.read_text(encoding="utf-8"))
    lines = text.splitlines()
    found = [
        (number, "unlabelled column", header)
        for number, (header, rule) in enumerate(itertools.pairwise(lines), start=1)
        if RULE.match(rule) and "" in [cell.strip() for cell in header.strip("|").split("|")]
    ]
    for number, paragraph in paragraphs(text):
        plain = re.sub(r"\]\([^)]*\)", "]", paragraph)
        plain = re.sub(r"\$[^$]+\$|`[^`]+`", "Xx", plain)
        for sentence in END.split(plain):
            words = re.findall(r"[^\W_][\w'.,-]*", sentence)
            if len(words) > MOST_WORDS:
                found.append((number, f"{len(words)} words", sentence))
            if sentence.count(";") > 1:
                found.append((number, "semicolons", sentence))
            if NO_PERSON.search(sentence):
                found.append((number, "no person", sentence))
    return found


def main() -> None:
    """Print the faults of the pages that are named."""
    counts: Counter[str] = Counter()
    for name in sys.argv[1:]:
        for number, kind, text in faults(Path(name)):
            counts["long sentence" if kind.endswith("words") else kind] += 1
            print(f"{name}:{number}: {kind}: {text[:120]}")
    print(dict(counts))


if __name__ == "__main__":
    main()
