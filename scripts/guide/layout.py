"""What a browser shows of the guide: nothing cut at a desk, nothing wider than the screen of a phone."""

from pathlib import Path

DESK = 1280
PHONE = 360

_FAULTS = Path(__file__).with_name("layout.js").read_text(encoding="utf-8").strip()


def faults(browser, pages):
    """Yield what a reader of the pages would see cut, each as (page, sentence)."""
    for width in (DESK, PHONE):
        browser.size(width)
        for page in pages.values():
            browser.open(page.path)  # anew: the table of contents opens by the width at the start
            for fault in browser.value(f"({_FAULTS})({'true' if width == DESK else 'false'})"):
                yield page.path, f"at {width} px: {fault}"
