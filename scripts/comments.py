"""Lines of more than 100 columns, and doc comments that begin with a word such as What or Those.

    python3 scripts/comments.py

A doc comment of Rust or a docstring of Python begins with a noun or a verb. Exempt from the width
are tables, lines with an address, and lines of raw strings of Rust. Prints each fault with its
place, and exits 1 where there is one.
"""

import ast
import pathlib
import re
import sys

from code_lines import TOKEN

ROOT = pathlib.Path(__file__).parents[1]
FOLDERS = ["crates", "tests", "benches", "examples", "python", "scripts"]
OF_OTHERS = {"vendor", "node_modules"}
KINDS = {".rs", ".py", ".pyi", ".js", ".mjs"}
WIDEST = 100
OPENER = re.compile(r"(What|Those|That|Of|Who|Whom|Whose|Which)\b")
DOC = re.compile(r"\s*(//[/!])(?!/)\s*(.*)")
EXEMPT = re.compile(r"\s*(//[/!]?|#)?\s*\||.*https?://")


def raw_lines(text: str) -> set[int]:
    """Find the lines that raw strings of Rust touch, from 1."""
    lines = set()
    for match in TOKEN.finditer(text):
        if match[0].startswith("r"):
            first = text.count("\n", 0, match.start()) + 1
            lines.update(range(first, first + match[0].count("\n") + 1))
    return lines


def rust_comments(lines: list[str], raw: set[int]) -> list[tuple[int, str]]:
    """Find where each doc comment begins, and with what."""
    found, before = [], None
    for number, line in enumerate(lines, 1):
        match = None if number in raw else DOC.match(line)
        if match and match[1] != before:
            found.append((number, match[2]))
        before = match[1] if match else None
    return found


def docstrings(text: str) -> list[tuple[int, str]]:
    """Find where each docstring begins, those of attributes among them, and with what."""
    return [
        (statement.lineno, statement.value.value.lstrip())
        for node in ast.walk(ast.parse(text))
        if isinstance(body := getattr(node, "body", None), list)
        for statement in body
        if isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    ]


def faults(path: pathlib.Path) -> list[tuple[int, str]]:
    """List the faults of a file, each with its line; none of a file that is no source."""
    if path.suffix not in KINDS and (path.suffix or path.parent.name != "scripts"):
        return []
    text = path.read_text()
    lines = text.split("\n")
    raw, comments = set(), []
    if path.suffix == ".rs":
        raw = raw_lines(text)
        comments = rust_comments(lines, raw)
    elif path.suffix in {".py", ".pyi"} or "python" in lines[0]:
        comments = docstrings(text)
    found = [
        (number, f'a doc comment begins with "{match[0]}", not with a noun or a verb')
        for number, comment in comments
        if (match := OPENER.match(comment))
    ]
    found += [
        (number, f"{len(line)} columns, {WIDEST} at most")
        for number, line in enumerate(lines, 1)
        if len(line) > WIDEST and number not in raw and not EXEMPT.match(line)
    ]
    return sorted(found)


def main() -> int:
    """Print the faults of all files."""
    files = [
        path
        for folder in FOLDERS
        for path in sorted((ROOT / folder).rglob("*"))
        if path.is_file() and not OF_OTHERS.intersection(path.parts)
    ]
    count = 0
    for path in files:
        for number, fault in faults(path):
            print(f"{path.relative_to(ROOT)}:{number}: {fault}", file=sys.stderr)
            count += 1
    return bool(count)


if __name__ == "__main__":
    sys.exit(main())
