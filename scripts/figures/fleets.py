"""Answers of runs: distributions, losses, shares of the variance, differences, ranges, trucks."""

import numpy as np
import ocmc
from matplotlib.ticker import PercentFormatter
from style import BLUE, GREEN, GREY, KWH, ORANGE, PALE, PURPLE, RED, SKY, column, figure

CONSUMPTION = "consumption_l_per_100km"


def _summary(run):
    return run.summary()["statistics"]


def distribution():
    """The spread of trips, and how well their mean is known: two widths that differ fifty times."""
    run = ocmc.Study("field-truck").run(cycles=10_000, progress=False)
    values = run[CONSUMPTION]
    told = _summary(run)[CONSUMPTION]
    drawn, ax = figure(height=4.0)
    edges = np.arange(22.0, 60.0, 1.0)
    counts, _, _ = ax.hist(values, bins=edges, color=SKY, edgecolor="white", linewidth=0.6)
    top = counts.max()
    low, high = told["ci95"]
    ax.axvspan(low, high, color=RED, linewidth=0)
    ax.annotate(
        f"mean of the fleet\n{told['mean']:.2f} ± {(high - low) / 2.0:.2f} L/100 km, 95 %",
        (high, 1.02 * top),
        (high + 4.0, 1.10 * top),
        color=RED,
        va="center",
        arrowprops={"arrowstyle": "-", "color": RED},
    )
    centre = values.mean()
    ax.annotate(
        "",
        (centre - told["sd"], 0.62 * top),
        (centre + told["sd"], 0.62 * top),
        arrowprops={
            "arrowstyle": "<->",
            "color": "black",
            "shrinkA": 0,
            "shrinkB": 0,
            "linewidth": 1.2,
        },
    )
    ax.annotate(
        f"± SD of one trip, {told['sd']:.1f}",
        (centre - 0.6, 0.64 * top),
        ha="right",
        va="bottom",
        fontsize=9,
    )
    for name, where in [
        ("p5", "P5"),
        ("p25", "P25"),
        ("p50", "P50"),
        ("p75", "P75"),
        ("p95", "P95"),
    ]:
        ax.axvline(told[name], ymax=0.07, color="black", linewidth=1.2)
        around = {"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.85}
        ax.annotate(where, (told[name], 0.1 * top), ha="center", fontsize=8, bbox=around)
    ax.set(
        xlabel="consumption of a trip of 100 km, L/100 km",
        ylabel="trips of 10,000",
        ylim=(0, 1.2 * top),
        xlim=(22, 58),
    )
    return drawn


# name, colour, terms of the energy balance
_LOSSES = [
    ("air", SKY, ["drag_energy_j"]),
    ("rolling", BLUE, ["rolling_energy_j"]),
    ("brakes of the wheels", RED, ["service_brake_energy_j"]),
    ("engine brake, retarder", ORANGE, ["engine_brake_energy_j"]),
    ("gearbox, axle, clutch", GREEN, ["transmission_loss_j", "shift_loss_j", "clutch_loss_j"]),
    ("auxiliaries", PURPLE, ["auxiliary_energy_j"]),
    ("motor, battery", GREY, ["motor_loss_j", "battery_loss_j"]),
]


def losses():
    """Where the work of the engine, or the energy of the battery, goes in six studies."""
    studies = [
        "field-truck",
        "field-truck-loaded",
        "long-haul",
        "regional",
        "urban-delivery",
        "battery-truck",
    ]
    drawn, ax = figure(height=3.7)
    places = np.arange(len(studies))[::-1]
    for place, name in zip(places, studies, strict=True):
        run = ocmc.Study(name).run(cycles=1000, progress=False)
        km = column(run, "distance_m").sum() / 1000.0
        left = 0.0
        for label, colour, terms in _LOSSES:
            size = sum(np.nansum(column(run, term)) for term in terms) / KWH / km
            ax.barh(
                place,
                size,
                left=left,
                color=colour,
                height=0.62,
                label=label if place == 0 else None,
            )
            if size > 0.085:  # what has room for its number
                dark = colour in {BLUE, RED, GREEN, GREY}
                ax.annotate(
                    f"{size:.2f}",
                    (left + size / 2.0, place),
                    ha="center",
                    va="center",
                    fontsize=8,
                    color="white" if dark else "black",
                )
            left += size
        tonnes = column(run, "payload_kg").mean() / 1000.0
        ax.annotate(
            f"{left:.2f}, payload {tonnes:.1f} t", (left + 0.015, place), va="center", fontsize=8.5
        )
    ax.set_yticks(places, labels=studies)
    ax.set(xlabel="kWh/km, of the crankshaft or the battery", xlim=(0, 2.55))
    ax.grid(visible=False, axis="y")
    ax.legend(ncols=4, loc="lower center", bbox_to_anchor=(0.42, 1.0), fontsize=8.5)
    return drawn


def sensitivity():
    """Shares of the variance of single trips, with their intervals."""
    answer = ocmc.Study("field-truck").sensitivity(cycles=1500, progress=False)
    factors = [f for f in answer["factors"] if f["factor"] != "mission"]
    factors.sort(key=lambda f: f["total"])
    inner = {"driver.curve_speed", "driver.speed_change", "driver.pedals", "driver.compliance"}
    names = [
        f"driver: {f['factor'][7:].replace('_', ' ')}"
        if f["factor"] in inner
        else f["factor"].replace("mission.", "")
        for f in factors
    ]
    drawn, ax = figure(height=4.2)
    places = np.arange(len(factors))
    for key, colour, offset, label in [
        ("first", BLUE, 0.2, "first-order effect"),
        ("total", SKY, -0.2, "total effect"),
    ]:
        values = 100.0 * np.array([f[key] for f in factors])
        ends = 100.0 * np.array([f[f"{key}_ci95"] for f in factors])
        ax.barh(places + offset, values, height=0.38, color=colour, label=label)
        ax.hlines(places + offset, ends[:, 0], ends[:, 1], color="0.2", linewidth=1.1)
    for place, factor in zip(places, factors, strict=True):
        right = 100.0 * max(factor["first_ci95"][1], factor["total_ci95"][1])
        ax.annotate(
            f"{100.0 * factor['total']:.1f} %",
            (right + 1.2, place),
            va="center",
            fontsize=8.5,
            color="0.25",
        )
    ax.set_yticks(places, labels=names)
    ax.axvline(0.0, color="black", linewidth=0.6)
    ax.set(
        xlabel=(
            "share of the variance of L/100 km between trips of 100 km, %; lines: 95 % intervals"
        ),
        xlim=(-2, 92),
    )
    ax.grid(visible=False, axis="y")
    ax.legend(loc="lower right")
    return drawn


def compare_pairs():
    """Why pairs tell more: the same trips with two trucks, and the spread of their differences."""
    study = ocmc.Study("field-truck")
    other = study.set("vehicle.drag_area_m2", 4.6)
    a, b = (s.run(cycles=1000, progress=False)[CONSUMPTION] for s in (study, other))
    told = ocmc.compare(study, other, cycles=1000, progress=False)
    drawn, (left, right) = figure(1, 2, height=3.9)
    ends = [20.0, 60.0]
    left.plot(ends, ends, color="black", linewidth=0.8)
    left.plot(a, b, ".", color=BLUE, markersize=2.2, alpha=0.6, markeredgewidth=0)
    left.annotate("equal", (54.0, 55.0), rotation=45, rotation_mode="anchor", fontsize=8.5)
    left.set(
        xlabel="as it is, L/100 km",
        ylabel="drag area 4.6 m², L/100 km",
        xlim=ends,
        ylim=ends,
        aspect="equal",
    )
    left.set_title("each point is one trip, driven twice")
    edges = np.arange(-20.0, 20.1, 0.25)
    shuffled = np.roll(b, 1) - a
    right.hist(
        shuffled,
        bins=np.arange(-20.0, 20.1, 1.0),
        weights=np.full(a.size, 0.25),
        color=PALE,
        label="other trips",
    )
    right.hist(b - a, bins=edges, color=BLUE, label="same trips")
    right.axvline(told["difference"], color=RED, linewidth=1.4)
    half = (told["ci95"][1] - told["ci95"][0]) / 2.0
    right.annotate(
        f"{told['difference']:.2f} ± {half:.2f}".replace("-", "−"),
        (told["difference"], 0.9 * right.get_ylim()[1]),
        (3.0, 0.9 * right.get_ylim()[1]),
        color=RED,
        va="center",
        arrowprops={"arrowstyle": "-", "color": RED},
    )
    right.set(
        xlabel="difference of two trips, L/100 km", ylabel="trips per 0.25 L/100 km", xlim=(-14, 14)
    )
    right.set_title("differences")
    right.legend(loc="upper left")
    return drawn


def precision():
    """How the interval of the mean narrows with the cycles, in three ways to use them."""
    study = ocmc.Study("field-truck")
    even = study.set("simulation.sampling", "sobol")
    other = study.set("vehicle.drag_area_m2", 4.6)
    counts = [128, 256, 512, 1024, 2048, 4096, 8192]

    def half(answer):
        low, high = answer["ci95"]
        return (high - low) / 2.0

    mean = [half(_summary(study.run(cycles=n, progress=False))[CONSUMPTION]) for n in counts]
    spread = [half(_summary(even.run(cycles=n, progress=False))[CONSUMPTION]) for n in counts]
    pairs = [half(ocmc.compare(study, other, cycles=n, progress=False)) for n in counts[:-1]]
    drawn, ax = figure(height=3.9)
    ax.loglog(counts, mean, "o-", color=BLUE, markersize=4, label="mean")
    ax.loglog(
        counts, spread, "s-", color=GREEN, markersize=4, label="mean, cycles that spread evenly"
    )
    ax.loglog(
        counts[:-1], pairs, "^-", color=RED, markersize=4, label="difference of two trucks, paired"
    )
    n = np.array([110.0, 9500.0])
    for level in (0.045, 0.48):
        ax.loglog(n, level * np.sqrt(100.0 / n) * 3.0, ":", color="0.7", linewidth=0.8)
    percent = 0.01 * 38.12
    ax.axhline(percent, color="0.4", linewidth=0.9)
    ax.annotate("1 % of the mean", (9300.0, 1.06 * percent), fontsize=8.5, color="0.3", ha="right")
    ax.set(
        xlabel="cycles",
        ylabel="half of the 95 % interval, L/100 km",
        xlim=(110, 9500),
        ylim=(0.01, 3.0),
    )
    ax.set_xticks(counts, labels=[f"{n:,}" for n in counts])
    ax.set_yticks([0.01, 0.03, 0.1, 0.3, 1.0, 3.0], labels=["0.01", "0.03", "0.1", "0.3", "1", "3"])
    ax.minorticks_off()
    ax.legend(loc="upper right")
    return drawn


def ranges():
    """Share of battery trucks that arrive, by the length of the trip: all, winter, summer."""
    answer = ocmc.Study("battery-truck").range(cycles=1500, progress=False)
    drawn, ax = figure(height=3.9)
    curve = answer["curve"]
    km = np.array([point["distance_m"] for point in curve]) / 1000.0
    share = np.array([point["share"] for point in curve])
    ends = np.array([point["ci95"] or [point["share"]] * 2 for point in curve])
    ax.fill_between(km, ends[:, 0], ends[:, 1], color=BLUE, alpha=0.2, linewidth=0)
    ax.plot(km, share, color=BLUE, linewidth=2.0, label="all trips, 95 % interval")
    for group, colour in [("winter", SKY), ("summer", ORANGE)]:
        found = next(part for part in answer["by_season"] if part["group"] == group)
        at = [point["range_m"] / 1000.0 for point in found["arriving"]]
        ax.plot(
            at,
            [point["share"] for point in found["arriving"]],
            "o--",
            color=colour,
            markersize=4,
            label=group,
        )
    for wanted in (0.95, 0.5):
        reached = (
            next(point["range_m"] for point in answer["arriving"] if point["share"] == wanted)
            / 1000.0
        )
        ax.plot([0.0, reached, reached], [wanted, wanted, 0.0], color="0.4", linewidth=0.9)
        ax.annotate(f"{reached:.0f} km", (reached + 4.0, 0.03), fontsize=8.5, color="0.25")
        ax.annotate(
            f"{100.0 * wanted:.0f} % arrive",
            (104.0, wanted - 0.035),
            fontsize=8.5,
            color="0.25",
            va="center",
        )
    ax.yaxis.set_major_formatter(PercentFormatter(1.0))
    ax.set(
        xlabel="length of the trip, km",
        ylabel="share that arrives",
        xlim=(100, 500),
        ylim=(0, 1.03),
    )
    ax.legend(loc="upper right")
    return drawn


def trucks():
    """A year of 200 trucks that do the same work: whose interval does not hold the fleet's mean."""
    study = ocmc.Study("field-truck").set("mission.length_m", 50_000.0)
    run = study.run(trucks=200, trips=100, progress=False)
    fuel = column(run, "fuel_kg").reshape(200, 100)
    litres = 100.0 * fuel / (column(run, "distance_m").reshape(200, 100) / 1000.0) / 0.836
    mean = litres.mean(axis=1)
    half = 1.984 * litres.std(axis=1, ddof=1) / np.sqrt(100.0)  # Student, 99 degrees of freedom
    order = np.argsort(mean)
    mean, half = mean[order], half[order]
    fleet = litres.mean()
    beyond = np.abs(mean - fleet) > half
    drawn, (ax, side) = figure(1, 2, height=3.9, width_ratios=[3.0, 1.0])
    place = np.arange(200)
    for which, colour, name in [
        (~beyond, GREY, "interval holds it"),
        (beyond, RED, "interval does not"),
    ]:
        ax.vlines(
            place[which],
            (mean - half)[which],
            (mean + half)[which],
            color=colour,
            linewidth=0.9,
            label=name,
        )
        ax.plot(place[which], mean[which], ".", color=colour, markersize=3)
    ax.axhline(fleet, color=BLUE, linewidth=1.2, label="mean of the fleet")
    ax.set(xlabel="trucks, by their mean", ylabel="L/100 km", xlim=(-3, 203), ylim=(32, 48))
    ax.legend(loc="upper left", fontsize=8.5)
    ax.set_title("100 trips of each truck, 95 % intervals")
    bins = np.linspace(15.0, 70.0, 45)
    side.hist(litres.ravel(), bins=bins, orientation="horizontal", density=True, color=SKY)
    side.axhspan(32.0, 48.0, color=PALE, linewidth=0, zorder=0)
    side.axhline(fleet, color=BLUE, linewidth=1.2)
    side.set_title("single trips")
    side.set(xlabel="grey: the left panel", xticks=[], ylim=(20, 62))
    return drawn


FIGURES = {
    "distribution": distribution,
    "losses": losses,
    "sensitivity": sensitivity,
    "compare-pairs": compare_pairs,
    "precision": precision,
    "range": ranges,
    "trucks": trucks,
}
