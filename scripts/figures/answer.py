"""Draw the first picture of the README: a fleet's consumption, and what a truck of less drag saves.

``scripts/figures/answer.py`` writes ``docs/images/answer.svg`` (10,000 cycles, 15 seconds on two
cores).
"""

from pathlib import Path

import matplotlib as mpl
import numpy as np
import ocmc
from matplotlib.axes import Axes

mpl.use("svg")
from matplotlib import pyplot as plt

PICTURE = Path(__file__).parents[2] / "docs" / "images" / "answer.svg"
CYCLES = 10_000
LITRES = "consumption_l_per_100km"
BARS, MEAN, PALE = "#5b8db8", "#c0392b", "#dfe9f2"


def mark(axes: Axes, mean: float, half: float, low: float, high: float) -> None:
    """Shade the middle nine tenths of the cycles, and draw the fleet's mean with its interval."""
    axes.axvspan(low, high, color=PALE, zorder=0)
    axes.axvspan(mean - half, mean + half, color=MEAN, alpha=0.4, linewidth=0)
    axes.axvline(mean, color=MEAN, linewidth=1.5)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_ylabel("trips")


def say(axes: Axes, question: str, mean: str, middle: str) -> None:
    """Write the question and both answers above the bars."""
    axes.set_title(question, loc="left", weight="bold", fontsize=12, pad=36.0)
    for height, text, style in [
        (1.09, mean, {"color": MEAN, "weight": "bold"}),
        (1.02, middle, {"color": "#345"}),
    ]:
        axes.text(0.0, height, text, transform=axes.transAxes, **style)


def fleet(axes: Axes, run: ocmc.Run) -> None:
    """Draw how the consumption of the study's trips is distributed."""
    axes.hist(
        run[LITRES], bins=np.arange(20.0, 60.0, 2.0), color=BARS, edgecolor="white", linewidth=0.4
    )
    row = run.summary()["statistics"][LITRES]
    half = (row["ci95"][1] - row["ci95"][0]) / 2.0
    mark(axes, row["mean"], half, row["p5"], row["p95"])
    say(
        axes,
        "How much does the fleet use?",
        f"the fleet's mean: {row['mean']:.1f} ± {half:.1f} L/100 km",
        f"nine trips of ten: {row['p5']:.0f} to {row['p95']:.0f} L/100 km",
    )
    for place, height, kind in [(28.0, 880, "empty"), (41.5, 1300, "loaded")]:
        axes.text(place, height, kind, ha="center", color="#345")
    axes.set_xlabel("consumption of a trip, L/100 km")
    axes.set_ylim(0.0, 1400.0)


def saving(axes: Axes, run: ocmc.Run, other: ocmc.Run) -> None:
    """Draw what less drag changes, trip by trip: the same roads, weather, loads and drivers."""
    litres = other[LITRES] - run[LITRES]
    axes.hist(litres, bins=np.arange(-2.0, 0.1, 0.05), color=BARS, edgecolor="white", linewidth=0.3)
    answer = ocmc.compare(run.study, other.study, cycles=CYCLES, seed=run.seed)
    half = (answer["ci95"][1] - answer["ci95"][0]) / 2.0
    mark(axes, answer["difference"], half, *np.quantile(litres, [0.05, 0.95]))
    say(
        axes,
        "What does a truck of less drag save?",
        f"the fleet's mean: −{-answer['difference']:.3f} ± {half:.3f} L/100 km",
        "nine trips of ten: −{:.2f} to −{:.2f} L/100 km".format(
            *-np.quantile(litres, [0.05, 0.95])
        ),
    )
    axes.set_xlabel("change of the same trip, L/100 km: drag area 4.6 m² instead of 5.3 m²")


def main() -> None:
    """Drive both fleets and write the picture."""
    mpl.rcParams |= {"svg.hashsalt": "ocmc", "font.size": 10, "font.family": "DejaVu Sans"}
    study = ocmc.Study("field-truck")
    run = study.run(cycles=CYCLES, seed=1)
    other = study.set("vehicle.drag_area_m2.median", 4.6).run(cycles=CYCLES, seed=1)
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(11.0, 4.0), layout="constrained", facecolor="white"
    )
    fleet(left, run)
    saving(right, run, other)
    PICTURE.parent.mkdir(exist_ok=True)
    figure.savefig(PICTURE, metadata={"Date": None})


if __name__ == "__main__":
    main()
