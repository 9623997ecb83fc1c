"""How the program is built: from a study to answers, with the files that do each step."""

from matplotlib.patches import FancyArrowPatch, FancyBboxPatch
from style import BLUE, GREEN, ORANGE, PURPLE, SKY, figure

# name, what it is, function, files
_STAGES = [
    (
        "Study",
        "a TOML file: roads, weather, traffic,\nmissions, drivers, truck, numerics",
        "study/ · configs/*.toml",
        ORANGE,
    ),
    (
        "Scenario",
        "one road with its weather and traffic,\none mission, one driver, one truck",
        "operating_cycle/ · driver/ · vehicle/",
        GREEN,
    ),
    (
        "Speed profile",
        "the speed that this driver wants\nat each place of this road",
        "tactical.rs",
        PURPLE,
    ),
    (
        "Record",
        "totals of one driven cycle:\nfuel, time, each energy (or a trace)",
        "kernel/ · powertrain/ · energy/ledger.rs",
        BLUE,
    ),
    ("Summary", "the fleet: means with intervals,\nspread, quantiles, differences", "fleet/", SKY),
]
_STEPS = [
    "Study::sample(seed, cycle id)",
    "tactical::plan",
    "kernel: 8 or 16 side by side",
    "fleet::run, in the order of ids",
]


def pipeline():
    """From a study to the answer about the fleet, and the files of each step."""
    drawn, ax = figure(height=5.4)
    ax.set(xlim=(0, 100), ylim=(-3, 100))
    ax.axis("off")
    height, gap = 13.0, 8.4
    top = 99.0
    for number, (name, text, files, colour) in enumerate(_STAGES):
        y = top - height - number * (height + gap)
        box = FancyBboxPatch(
            (2, y),
            60,
            height,
            boxstyle="round,pad=0.3,rounding_size=1.5",
            fc=colour,
            ec="none",
            alpha=0.25,
        )
        ax.add_patch(box)
        ax.text(4, y + height / 2.0, name, va="center", fontsize=11, fontweight="bold")
        ax.text(24, y + height / 2.0, text, va="center", fontsize=9.5)
        ax.text(
            66, y + height / 2.0, files, va="center", fontsize=8.5, family="monospace", color="0.25"
        )
        if number < len(_STEPS):
            arrow = FancyArrowPatch(
                (13, y - 0.8), (13, y - gap + 0.8), arrowstyle="-|>", mutation_scale=13, color="0.3"
            )
            ax.add_patch(arrow)
            ax.text(
                16,
                y - gap / 2.0,
                _STEPS[number],
                va="center",
                fontsize=8.5,
                family="monospace",
                color="0.25",
            )
    ax.text(66, top + 1.0, "in crates/ocmc-core/src/", fontsize=8.5, color="0.35", va="bottom")
    return drawn


FIGURES = {"pipeline": pipeline}
