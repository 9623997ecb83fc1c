"""Layout of the guide in a browser: nothing cut at a desk, nothing wider than a phone."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from browser import Browser

DESK = 1280
PHONE = 360

_FAULTS = Path(__file__).with_name("layout.js").read_text(encoding="utf-8").strip()


def faults(program, pages, browsers=2):
    """Give what a reader of the pages would see cut, as (page, sentence), by several browsers."""
    shares = [list(pages)[first::browsers] for first in range(browsers)]
    with ThreadPoolExecutor(browsers) as threads:
        found = threads.map(lambda share: list(_seen(program, share)), shares)
        return sorted(fault for part in found for fault in part)


def _seen(program, paths):
    with Browser(program) as browser:
        yield from _faults(browser, paths)


def _faults(browser, paths):
    for width in (DESK, PHONE):
        browser.size(width)
        for path in paths:
            browser.open(path)  # anew: the table of contents opens by the width at the start
            for fault in browser.value(f"({_FAULTS})({'true' if width == DESK else 'false'})"):
                yield path, f"at {width} px: {fault}"
