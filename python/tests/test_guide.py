"""How the guide is built and checked: formulas are marked, and the checks find what is wrong."""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("fcntl", reason="the browser is asked over the pipes of Unix")

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "scripts" / "guide"), str(ROOT / "scripts" / "figures")]

import browser  # noqa: E402
import captions  # noqa: E402
import formulas  # noqa: E402
import layout  # noqa: E402
import pages  # noqa: E402
import search  # noqa: E402


def needs_chromium():
    program = browser.chromium()
    if program is None:
        pytest.skip("no Chromium is installed")
    return program


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a $x_1$ b", "a {x&#95;1} b"),
        (r"$\alpha*\beta$, $b$", r"{&#92;alpha&#42;&#92;beta}, {b}"),
        ("$$\n\\frac{a}{b}\n$$", "[&#92;frac&#123;a&#125;&#123;b&#125;]"),
        ("| $|a|$ | b |", "| {&#124;a&#124;} | b |"),
        ("$a <\nb$", "{a &#60; b}"),
    ],
)
def test_formulas_are_marked(text, shown):
    for signs, name in [("{}", "math"), ("[]", "math display")]:
        shown = shown.replace(signs[0], f'<span class="{name}">').replace(signs[1], "</span>")
    assert formulas.marked(text) == shown


@pytest.mark.parametrize(
    "text",
    [
        "it costs $5 and $6",
        "$5-$6",
        r"\$5 and 6$",
        "from $SCRATCH/fleet/part-$part",
        "`$x$`",
        "``a ` $b$``",
        "```sh\n$ ocmc\n$x$\n```",
        "  ~~~\n  $x$\n  ~~~",
        "```text\n\n```",
        "> ```\n> $x$\n> ```",
        "<!-- $x$ -->",
        "a $x\n\ny$",
    ],
)
def test_money_shell_and_code_are_no_formulas(text):
    assert formulas.marked(text) == text


def test_pictures_that_stand_alone_show_their_words():
    shown = captions.captioned("A.\n\n![Two\nwords.](a.svg)\n\nB.\n")
    assert "<figcaption>\n\nTwo\nwords.\n\n</figcaption>" in shown
    assert shown.startswith("A.\n\n<figure>\n\n![Two\nwords.](a.svg)\n\n")
    for text in ["A ![b](c.svg) in a line.", "```md\n\n![b](c.svg)\n\n```", "- ![b](c.svg)"]:
        assert captions.captioned(text) == text


def page_of(folder, name, article):
    (folder / name).write_text(
        '<html><body><nav><a href="none.html">not of the article</a></nav>'
        f'<div class="page"><div class="content"><main>{article}</main></div></div></body></html>',
        encoding="utf-8",
    )


def test_the_check_finds_what_leads_nowhere(tmp_path):
    page_of(
        tmp_path, "a.html", '<h1 id="one">One</h1><a href="b.html#two">b</a><a href="#one">c</a>'
    )
    page_of(
        tmp_path,
        "b.html",
        '<h2 id="two">Two</h2><a href="c.html">c</a><a href="a.html#two">a</a>'
        '<img src="d.svg" alt="d"><img src="a.html"><p>$$ x</p><code>$$</code>'
        '<a href="https://example.org/">e</a>',
    )
    found = [(path.name, fault) for path, fault in pages.faults(pages.pages_of(tmp_path))]
    assert {name for name, _ in found} == {"b.html"}
    told = " | ".join(fault for _, fault in found)
    for part in [
        "c.html leads nowhere",
        "a.html#two leads to no anchor",
        "d.svg is not there",
        "has no words",
    ]:
        assert part in told
    assert "not closed" in told
    assert len(found) == 5


def test_the_check_finds_what_the_search_does_not(tmp_path):
    mdbook = shutil.which("mdbook")
    if mdbook is None or shutil.which("node") is None:
        pytest.skip("mdbook or node is not installed")
    (tmp_path / "src").mkdir()
    for name, text in [
        ("book.toml", ""),
        ("src/SUMMARY.md", "[Snow](snow.md)\n[Rain](rain.md)\n"),
        ("src/snow.md", "# Snow\n\nIt is white.\n"),
        ("src/rain.md", "# Rain\n\nIt is wet.\n"),
    ]:
        (tmp_path / name).write_text(text, encoding="utf-8")
    subprocess.run([mdbook, "build", tmp_path], check=True, capture_output=True)
    expected = {
        "snows": ["snow.html"],
        "white": ["snow.html", "rain.html"],
        "wet": ["snow.html"],
        "hail": ["a.html"],
    }
    typed, found = search.faults(tmp_path / "book", expected)
    told = ["`wet` in the search finds rain.html#rain", "`hail` in the search finds nothing"]
    assert (typed, [sentence for _, sentence in found]) == (4, told)


def test_the_check_finds_what_is_cut(tmp_path):
    program = needs_chromium()
    page_of(tmp_path, "whole.html", "<h1>Whole</h1><pre><code>short</code></pre>")
    wide = "x" * 400
    page_of(
        tmp_path,
        "cut.html",
        f'<pre style="overflow-x: auto"><code>{wide}</code></pre><span class="math">x</span>'
        f'<img src="none.png" alt="none"><p>{wide}</p>'
        "<style>@font-face {font-family: lost; src: url(lost.woff2)}</style>"
        '<p style="font-family: lost">a</p>',
    )
    found = layout.faults(program, pages.pages_of(tmp_path))
    assert {path.name for path, _ in found} == {"cut.html"}
    told = " | ".join(fault for _, fault in found)
    for part in [
        "at 1280 px: cut by",
        "not typeset",
        "not drawn",
        "font lost",
        "at 360 px: the page is",
    ]:
        assert part in told


@pytest.fixture
def figures():
    pytest.importorskip("matplotlib")
    import draw  # noqa: PLC0415 (needs matplotlib)

    return draw


def test_each_figure_is_there_small_and_shown(figures):
    text = "".join(
        page.read_text(encoding="utf-8") for page in (ROOT / "docs" / "src").rglob("*.md")
    )
    files = {path.stem: path for path in (ROOT / "docs" / "src" / "figures").glob("*.svg")}
    drawn = {name: path for name, path in files.items() if not name.startswith("gallery-")}
    assert set(drawn) == set(figures.FIGURES), "python3 scripts/figures/draw.py"
    for name, path in files.items():
        assert path.stat().st_size < 200_000, name
        assert f"figures/{path.name})" in text, f"no page shows {name}"


@pytest.mark.parametrize("name", ["tactical", "peers", "pipeline"])
def test_a_figure_is_the_same_bytes_each_time(figures, tmp_path, name):
    for path in (tmp_path / "a.svg", tmp_path / "b.svg"):
        assert figures.style.draw(figures.FIGURES[name], path)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert b"<dc:date>" not in (tmp_path / "a.svg").read_bytes()


def test_the_plan_of_the_figure_is_that_of_the_program(figures):
    axes = figures.FIGURES["tactical"]().axes[0]
    lines = {line.get_label().split(",")[0]: line.get_xydata() for line in axes.get_lines()}
    plan, driven = lines["sweep forth"], lines["driven by the program"]
    planned = np.interp(driven[:, 0], plan[:, 0], plan[:, 1])
    kmh = 3.6 * (np.sqrt(driven[:, 1]) - np.sqrt(np.maximum(planned, 0.0)))
    assert kmh.max() < 5.0, "the program never drives faster than the plan allows"
    braking = (driven[:, 0] > 750.0) & (driven[:, 0] < 1000.0)
    assert np.abs(kmh[braking]).max() < 2.0, "and follows the ramp to the sign"
