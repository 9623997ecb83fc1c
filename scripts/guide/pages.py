"""Pages of the built guide: targets of links, pictures shown, and formulas not rendered."""

import re
from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit

# made by mdBook for itself: all pages in one, the page of a missing page, the table of contents as
# a frame
NOT_PAGES = {"print.html", "404.html", "toc.html"}


class Page(HTMLParser):
    """Anchors, links, pictures and text of one page; links and text of its article only."""

    def __init__(self, path):
        super().__init__()
        self.path = path
        self.anchors = set()
        self.links = []
        self.pictures = []
        self.text = []
        self._article = False
        self._code = 0
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):  # noqa: D102
        given = dict(attributes)
        self.anchors.update(filter(None, [given.get("id"), given.get("name")]))
        self._article |= tag == "main"
        self._code += tag in {"code", "pre", "script", "style"}
        if not self._article:
            return
        if tag == "a" and given.get("href"):
            self.links.append(given["href"])
        if tag in {"img", "video", "source", "iframe", "object"}:
            self.pictures.append((given.get("src") or given.get("data") or "", given.get("alt")))

    def handle_endtag(self, tag):  # noqa: D102
        self._article &= tag != "main"
        if tag in {"code", "pre", "script", "style"}:
            self._code -= 1

    def handle_data(self, data):  # noqa: D102
        if self._article and not self._code:
            self.text.append(data)


def pages_of(book):
    """Pages of the guide by path, in order."""
    paths = (path for path in sorted(book.rglob("*.html")) if path.name not in NOT_PAGES)
    return {path.resolve(): Page(path) for path in paths}


def faults(pages):
    """Yield what is wrong with the pages, each as (page, sentence)."""
    for page in pages.values():
        for link in page.links:
            if fault := _link_fault(page, link, pages):
                yield page.path, fault
        for source, words in page.pictures:
            if not (page.path.parent / unquote(urlsplit(source).path)).is_file():
                yield page.path, f"picture {source} is not there"
            if not (words or "").strip():
                yield page.path, f"picture {source} has no words for those who do not see it"
        for dollars in re.findall(r".{0,20}\$\$.{0,20}", " ".join(page.text)):
            yield page.path, f"a formula is not closed: {dollars}"


def _link_fault(page, link, pages):
    parts = urlsplit(link)
    if parts.scheme in {"http", "https", "mailto"}:
        return None
    target = (
        (page.path.parent / unquote(parts.path)).resolve() if parts.path else page.path.resolve()
    )
    if not target.is_file():
        return f"link {link} leads nowhere"
    if parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors:
        return f"link {link} leads to no anchor of its page"
    return None
