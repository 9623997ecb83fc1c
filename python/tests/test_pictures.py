"""The README's pictures as browsers draw them: the columns of a terminal keep their places."""

import os
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("fcntl", reason="the browser is asked over the pipes of Unix")

ROOT = Path(__file__).parents[2]
RUN = ROOT / "docs" / "images" / "run.svg"
sys.path.insert(0, str(ROOT / "scripts" / "guide"))

import browser  # noqa: E402

COLLAPSED = '<svg xmlns="http://www.w3.org/2000/svg"><text x="16" y="30">a      b</text></svg>'

# how many signs each line has, and where each of them begins
PLACES = """
[...document.querySelectorAll("text")].map(line => ({
    signs: line.textContent.length,
    drawn: line.getNumberOfChars(),
    places: [...Array(line.getNumberOfChars()).keys()].map(i => line.getStartPositionOfChar(i).x),
}))
"""


def lines_of(picture):
    """Text, left edge and base of each line that is not empty."""
    texts = ET.parse(picture).iter("{http://www.w3.org/2000/svg}text")  # noqa: S314 (our own)
    found = [
        ("".join(text.itertext()), float(text.get("x")), float(text.get("y"))) for text in texts
    ]
    return [line for line in found if line[0].strip()]


def columns_stand(lines):
    """Whether each sign of each line stands in its column: all are equally wide."""
    width = np.median(
        np.concatenate([np.diff(line["places"]) for line in lines if line["drawn"] > 1])
    )
    for line in lines:
        if line["signs"] != line["drawn"]:
            return False
        at = np.array(line["places"])
        if at.size and np.abs(at - at[0] - width * np.arange(at.size)).max() > 1.0:
            return False
    return True


def test_columns_keep_their_places_in_chromium(tmp_path):
    program = browser.chromium()
    if program is None:
        pytest.skip("no Chromium is installed")
    broken = tmp_path / "broken.svg"
    broken.write_text(COLLAPSED, encoding="utf-8")
    with browser.Browser(program) as window:
        window.size(760, 800)
        window.open(RUN)
        lines = window.value(PLACES)
        window.open(broken)
        collapsed = window.value(PLACES)
    assert len(lines) > 30
    assert columns_stand(lines)
    assert not columns_stand(collapsed), "the measure sees columns that collapse"


def ink(firefox, picture, folder):
    """Ink that Firefox draws, as darkness against the ground at the picture's corner."""
    image = pytest.importorskip("matplotlib.image")
    shown = folder / f"{picture.stem}.png"
    command = [firefox, "--headless", "--no-remote", "--profile", folder, "--window-size=760,1000"]
    environment = {"HOME": str(folder), "PATH": os.environ["PATH"]}
    subprocess.run(
        [*command, "--screenshot", shown, picture.as_uri()],
        env=environment,
        capture_output=True,
        timeout=120,
        check=True,
    )
    pixels = image.imread(shown)[:, :, :3]
    return np.abs(pixels - pixels[20, 8]).max(axis=2) > 0.2


def test_columns_keep_their_places_in_firefox(tmp_path):
    firefox = shutil.which("firefox") or shutil.which("firefox-esr")
    if firefox is None:
        pytest.skip("no Firefox is installed")
    drawn = ink(firefox, RUN, tmp_path)
    widths = []
    for text, left, base in lines_of(RUN):
        if len(text) < 20 or "█" in text:
            continue
        row = drawn[int(base) - 11 : int(base) + 3, int(left) : 700].any(axis=0)
        widths.append((np.flatnonzero(row)[-1] + 1) / len(text))
    assert len(widths) > 10
    assert max(widths) < 1.04 * min(widths), (
        "lines of signs of one width end where their lengths say"
    )
