"""Lines of code of the program: without comments, blanks and what stands under `#[cfg(test)]`.

    python3 scripts/code_lines.py [--files] [TREE ...]

Counts the Rust of `crates/*/src` and the Python of `python/ocmc`, a row a crate, for each tree
(this one where none is given). Exits 1 where a file has more than 400 such lines.
"""

import argparse
import pathlib
import re
import sys

MOST = 400
TOKEN = re.compile(
    r"""//[^\n]*|/\*.*?\*/|r(?P<hash>\#*)".*?"(?P=hash)"""
    r"""|b?"(?:\\.|[^"\\])*"|'(?:\\.[^']*|[^'\\])'""",
    re.DOTALL,
)


def without_comments(text: str) -> str:
    """Rust without its comments; string literals stay without content, on as many lines."""

    def short(match: re.Match[str]) -> str:
        token = match[0]
        if token.startswith(("//", "/*")):
            return "\n" * token.count("\n")
        return '""' + "s\n" * token.count("\n")

    return TOKEN.sub(short, text)


def without_tests(text: str) -> str:
    """Rust without the items under `#[cfg(test)]`."""
    while (start := text.find("#[cfg(test)]")) >= 0:
        brace, end = text.find("{", start), text.find(";", start)
        if end < 0 or 0 <= brace < end:
            depth, end = 0, brace
            while True:
                depth += {"{": 1, "}": -1}.get(text[end], 0)
                if depth == 0:
                    break
                end += 1
        text = text[:start] + text[end + 1 :]
    return text


def rust_lines(path: pathlib.Path) -> int:
    """Count the lines of a Rust file."""
    text = without_tests(without_comments(path.read_text()))
    return sum(1 for line in text.splitlines() if line.strip())


def python_lines(path: pathlib.Path) -> int:
    """Count the lines of a Python file."""
    text = re.sub(
        r'^\s*[rf]?"""(?:[^\\]|\\.)*?"""', "", path.read_text(), flags=re.MULTILINE | re.DOTALL
    )
    return sum(1 for line in text.splitlines() if line.strip() and not line.strip().startswith("#"))


def is_test(path: pathlib.Path) -> bool:
    """Say whether its module declares a file under `#[cfg(test)]`."""
    return path.name in {"tests.rs", "testing.rs"}


def count(tree: pathlib.Path) -> dict[str, dict[pathlib.Path, int]]:
    """Count the lines of each file of a tree, by crate."""
    rooms = {}
    for crate in sorted(tree.glob("crates/*/src")):
        files = [path for path in crate.rglob("*.rs") if not is_test(path)]
        rooms[crate.parent.name] = {path: rust_lines(path) for path in files}
    rooms["python"] = {
        path: python_lines(path)
        for path in (tree / "python/ocmc").rglob("*.py*")
        if path.suffix in {".py", ".pyi"}
    }
    return rooms


def main() -> int:
    """Print the counts."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument(
        "trees", nargs="*", type=pathlib.Path, default=[pathlib.Path(__file__).parents[1]]
    )
    parser.add_argument("--files", action="store_true", help="a row a file, the longest first")
    arguments = parser.parse_args()
    too_long = []
    for tree in arguments.trees:
        rooms = count(tree)
        for room, files in rooms.items():
            print(f"{sum(files.values()):7} {room} ({len(files)} files)")
            too_long += [(path, lines) for path, lines in files.items() if lines > MOST]
            if arguments.files:
                for path, lines in sorted(files.items(), key=lambda item: -item[1]):
                    print(f"{lines:11} {path.relative_to(tree)}")
        print(f"{sum(sum(files.values()) for files in rooms.values()):7} {tree.resolve()}")
    for path, lines in too_long:
        print(f"{path}: {lines} lines of code, {MOST} at most", file=sys.stderr)
    return bool(too_long)


if __name__ == "__main__":
    sys.exit(main())
