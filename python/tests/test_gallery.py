"""The notebooks of the gallery run, and their pages show what they answer."""

import re
import sys
import time
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")
pytest.importorskip("matplotlib")

ROOT = Path(__file__).parents[2]
GALLERY = ROOT / "docs" / "src" / "gallery"
sys.path.insert(0, str(ROOT / "scripts" / "figures"))

import gallery  # noqa: E402

# what Jupyter's own packages say of themselves is not ours
pytestmark = pytest.mark.filterwarnings("ignore")

NUMBER = re.compile(r"-?\d[\d,]*(?:\.\d+)?")


def numbers(text):
    return [float(number.replace(",", "")) for number in NUMBER.findall(text)]


def test_each_notebook_has_a_page_and_no_outputs():
    assert {path.stem for path in GALLERY.glob("*.ipynb")} == set(gallery.NAMES)
    assert {path.stem for path in GALLERY.glob("*.md")} == {*gallery.NAMES, "index"}
    index = (GALLERY / "index.md").read_text(encoding="utf-8")
    for name in gallery.NAMES:
        assert f"({name}.md)" in index
        notebook = nbformat.read(GALLERY / f"{name}.ipynb", as_version=4)
        assert not [cell for cell in notebook.cells if cell.get("outputs")], "kept without outputs"


@pytest.mark.parametrize("name", gallery.NAMES)
def test_the_notebook_runs_and_its_page_shows_that(name):
    begun = time.monotonic()
    notebook = gallery.executed(name)
    print(f"{name}: {time.monotonic() - begun:.1f} s")
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert [output.text for output in outputs if output.get("name") == "stderr"] == []
    text, pictures = gallery.page(notebook, name)
    page = (GALLERY / f"{name}.md").read_text(encoding="utf-8")
    remake = f"scripts/figures/gallery.py {name}"
    assert NUMBER.sub("#", text).split() == NUMBER.sub("#", page).split(), remake
    # pages stay right while the models move a little; a sign or a tenth is another answer
    for now, shown in zip(numbers(text), numbers(page), strict=True):
        assert now == pytest.approx(shown, rel=0.1, abs=0.1), remake
    assert pictures
    for file in pictures:
        assert (ROOT / "docs" / "src" / "figures" / file).is_file(), remake
