"""The tutorial notebook runs, and says what its text says."""

import re
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")
pytest.importorskip("matplotlib")

TUTORIAL = Path(__file__).parents[2] / "docs" / "src" / "tutorial" / "fleet.ipynb"

# what Jupyter's own packages say of themselves is not ours
pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture(scope="module")
def outputs():
    """All outputs of the executed notebook, with their cells' sources."""
    notebook = nbformat.read(TUTORIAL, as_version=4)
    assert not [cell for cell in notebook.cells if cell.get("outputs")], "kept without outputs"
    client = nbclient.NotebookClient(
        notebook, timeout=300, resources={"metadata": {"path": str(TUTORIAL.parent)}}
    )
    client.execute()
    return [(cell.source, output) for cell in notebook.cells for output in cell.get("outputs", [])]


def shown(outputs, part, kind):
    """Outputs of the cells with this text."""
    found = [
        output.data[kind]
        for source, output in outputs
        if part in source and kind in output.get("data", {})
    ]
    assert found, part
    return "".join(found)


def test_the_tutorial_runs(outputs):
    assert "exponent" in shown(outputs, "fit_curve_speed", "text/html")
    assert "simulator drivers" in shown(outputs, "study.set(", "text/html")
    summary = shown(outputs, "run.summary()", "text/html")
    assert "1,000 of 1,000 cycles completed" in summary
    for picture in ["curve_fit", "plot.consumption", "plot.trace", "plot.comparison"]:
        assert len(shown(outputs, picture, "image/png")) > 10_000


def test_the_smoother_truck_consumes_less(outputs):
    printed = shown(outputs, "ocmc.compare(", "text/plain")
    difference, _, rest = re.search(r"B - A +(.*)", printed)[1].partition(" ± ")
    error = float(rest.split()[0])
    assert float(difference) < 0
    assert error < 0.1 * abs(float(difference)), "much better known than either consumption"


def test_nothing_is_told_on_the_way(outputs):
    assert [output.text for _, output in outputs if output.get("name") == "stderr"] == []
