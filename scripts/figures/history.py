"""What a step and a run cost, commit by commit: the table that `benches/checks.py --store` appends to."""

import csv

from style import BLUE, GREEN, GREY, ORANGE, ROOT, figure

LEVELS = {
    "instructions_baseline": ("SSE2", GREY),
    "instructions_neon": ("NEON", GREEN),
    "instructions_avx2": ("AVX2", BLUE),
}


def label_of(row):
    """Commit, and the machine's kind where it is said in brackets."""
    kind = row["machine"].partition("(")[2].partition(")")[0]
    return f"{row['commit']}\n{kind}" if kind else row["commit"]


def speed_history():
    """Instructions a lane-step and time for a simulated second, by commit."""
    with (ROOT / "benches" / "history.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    drawn, (left, right) = figure(1, 2, height=3.6, width_ratios=[3, 2])
    counted = [row for row in rows if any(row[name] for name in LEVELS)]
    places = range(len(counted))
    for name, (label, colour) in LEVELS.items():
        points = [(place, float(row[name])) for place, row in zip(places, counted, strict=True) if row[name]]
        if points:
            left.plot(*zip(*points, strict=True), "o-", color=colour, label=label, markersize=4)
    left.set_xticks(places, labels=[row["commit"] for row in counted], rotation=60, fontsize=7.5)
    left.set(ylabel="instructions a lane-step", ylim=(0, None))
    left.legend(loc="lower left")
    timed = [row for row in rows if row["ns_per_simulated_s"]]
    for place, row in enumerate(timed):
        time_ns = float(row["ns_per_simulated_s"])
        quiet = float(row["load"] or 0.0) <= 1.0
        right.plot(place, time_ns, "o", color=BLUE if quiet else ORANGE, markersize=6)
        right.annotate(
            f"{time_ns:.0f}", (place, time_ns), xytext=(7, 0), textcoords="offset points", va="center"
        )
    right.set_xticks(range(len(timed)), labels=[label_of(row) for row in timed], rotation=60, fontsize=7.5)
    right.set(ylabel="ns for a simulated second", xlim=(-0.5, len(timed) - 0.3), ylim=(0, None))
    return drawn


FIGURES = {"speed-history": speed_history}
