"""How the figures of the guide look, and where their numbers come from."""

import re
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PAGES = ROOT / "docs" / "src"
FIGURES = PAGES / "figures"

# Okabe and Ito's colours, as in ocmc.plot
BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
PURPLE, SKY = "#CC79A7", "#56B4E9"
GREY, PALE = "0.5", "0.85"
KMH = 3.6
KWH = 3.6e6

STYLE = {
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 10,
    "figure.constrained_layout.use": True,
    "font.size": 9.5,
    "grid.color": "0.9",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "lines.linewidth": 1.6,
    "path.simplify_threshold": 0.2,
    "savefig.facecolor": "white",
    "svg.hashsalt": "ocmc",  # the same identifiers each time
}


def figure(rows=1, columns=1, *, height=3.6, width=7.4, **options):
    """Make a figure as wide as the column of the guide, and its axes."""
    return plt.subplots(rows, columns, figsize=(width, height), **options)


def draw(figure_of, path):
    """Draw a figure in this style and write it: the same bytes each time.

    Return False where its data are absent.
    """
    with mpl.rc_context(STYLE):
        drawn = figure_of()
        if drawn is None:
            return False
        drawn.savefig(path, format="svg", metadata={"Date": None, "Creator": None})
        plt.close(drawn)
    path.write_text(shortened(path.read_text(encoding="utf-8")), encoding="utf-8")
    return True


def shortened(drawn):
    """Give the text of an SVG with its visible digits and points, without trailing spaces."""
    text = _PLACES.sub(lambda places: _AGAIN.sub(r"\1", _LONG.sub(_short, places[0])), drawn)
    return "".join(f"{line.rstrip()}\n" for line in text.splitlines())


# a tenth of a point is enough for places; scales keep their digits
_PLACES = re.compile(r' (?:d|x|y)="[^"]*"')
_AGAIN = re.compile(r"(\nL \S+ \S+ ?)(?:\1)+(?=\n)")
_LONG = re.compile(r"-?\d+\.\d{2,}(?:e-?\d+)?")


def _short(number):
    return f"{float(number[0]):.1f}".rstrip("0").rstrip(".")


def column(table, name):
    """Give a column as numbers; missing ones are NaN."""
    return np.asarray(table[name], dtype=float)


def printed_table(*heads):
    """Give the rows of the guide's table with these first heads, each as a list of texts."""
    start = re.compile(r"^\| *" + r" *\| *".join(map(re.escape, heads)) + r" *\|")
    for page in sorted(PAGES.rglob("*.md")):
        lines = page.read_text(encoding="utf-8").splitlines()
        for number, line in enumerate(lines):
            if start.match(line):
                rows = []
                for row in lines[number + 2 :]:
                    if not row.startswith("|"):
                        return rows
                    rows.append(
                        [re.sub(r"[*`]", "", cell).strip() for cell in row.strip("|").split("|")]
                    )
                return rows
    raise LookupError(f"no page has a table that begins with {' | '.join(heads)}")


def first_number(text):
    """Give the number that a cell begins with."""
    return float(re.match(r"[-−+]?[\d,.]+", text)[0].replace(",", "").replace("−", "-"))
