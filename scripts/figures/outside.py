"""The program beside others: measured roads, other programs, VECTO, measured curves."""

import csv
import gzip
import io
import os

import numpy as np
import ocmc
from style import (
    BLUE,
    GREEN,
    GREY,
    KMH,
    ORANGE,
    ROOT,
    SKY,
    column,
    figure,
    first_number,
    printed_table,
)

DATA = ROOT / (os.environ.get("OCMC_DATA") or "../shared/data")


def outside_roads():
    """Curves per km by the sign: the default road beside a map."""
    rows = {}
    for row in printed_table("road", "km", "all", "≤ 50", "60-80", "≥ 100"):
        rows.setdefault(row[0], row)  # below "as drawn" the same words stand again
    shown = [
        ("map", "OpenStreetMap, Lower Saxony", GREY),
        ("default road, detected", "default road", BLUE),
        ("without junction turns", "default road, without junction turns", SKY),
    ]
    classes = ["all", "up to 50", "60 to 80", "from 100"]
    drawn, (left, right) = figure(1, 2, height=3.5, width_ratios=[2.0, 1.0])
    for offset, (key, name, colour) in zip((-0.27, 0.0, 0.27), shown, strict=True):
        values = [first_number(cell) for cell in rows[key][2:6]]
        places = np.arange(4) + offset
        left.bar(places, values, width=0.25, color=colour, label=name)
        for place, value in zip(places, values, strict=True):
            left.annotate(f"{value:.2f}", (place, value + 0.04), ha="center", fontsize=7.5)
        radius, spread = first_number(rows[key][7]), first_number(rows[key][8])
        right.errorbar(
            radius,
            1.0 - offset,
            xerr=[[radius - radius / np.exp(spread)], [radius * np.exp(spread) - radius]],
            fmt="o",
            color=colour,
            capsize=3,
        )
    left.set_xticks(np.arange(4), labels=classes)
    left.set(xlabel="limit, km/h", ylabel="curves with R < 500 m, per km", ylim=(0, 3.9))
    left.grid(visible=False, axis="x")
    left.legend(loc="upper right", fontsize=8.5)
    right.set(
        xscale="log", xlim=(40, 500), ylim=(0.5, 1.5), yticks=[], xlabel="radius (20 to 500), m"
    )
    right.set_xticks([50, 100, 200, 400], labels=["50", "100", "200", "400"])
    right.minorticks_off()
    right.set_title("radii, geometric mean ± SD")
    return drawn


def peers():
    """Time for a simulated second, of programs that find the same energies."""
    shown = []
    for row in printed_table("program", "step, s"):
        name, step, time = row[0], row[1], row[4]
        if (
            "needed" in step
            or "ocmc" in name
            or "FASTSim" in name
            or ("SUMO" in name and first_number(step) == 1.0)
        ):
            shown.append((name.replace(", energy model", ""), time))
    drawn, ax = figure(height=3.9)
    places = np.arange(len(shown))[::-1]
    for place, (name, time) in zip(places, shown, strict=True):
        middle = first_number(time)
        low, high = (first_number(part) for part in time.split("(")[1].rstrip(")").split(" to "))
        colour = BLUE if name.startswith("ocmc") else GREY
        ax.hlines(place, low, high, color=colour, linewidth=2.4)
        ax.plot(middle, place, "o", color=colour, markersize=7)
        ax.annotate(
            f"{middle:,.0f} ns", (1.22 * max(middle, 0.95 * high), place), va="center", fontsize=8.5
        )
    ax.set_yticks(places, labels=[name for name, _ in shown])
    ax.set(
        xscale="log",
        xlim=(10, 30_000),
        xlabel="CPU time for each simulated second, ns, one core; logarithmic",
    )
    ax.set_xticks([10, 100, 1000, 10_000], labels=["10", "100", "1,000", "10,000"])
    ax.minorticks_off()
    ax.set_ylim(-0.6, len(shown) - 0.4)
    return drawn


def curve_fit():
    """Measured curves, the fitted law, and its bands."""
    path = ROOT / "examples" / "data" / "simulator_curves.csv"
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    curves = {
        "driver": [row["driver"] for row in rows],
        "direction": [row["direction"] for row in rows],
    }
    for name in ("radius_m", "speed_mps"):
        curves[name] = np.array([float(row[name]) for row in rows])
    drawn, ax = figure(height=4.0)
    ocmc.plot.curve_fit(curves, ocmc.fit_curve_speed(curves), ax=ax)
    return drawn


def _vecto():
    """VECTO's own drive of its long haul: distance, speed, slope, and the mission's target."""
    folder = DATA / "vecto" / "results" / "declaration_40t"
    path = folder / "40t_Long_Haul_Truck_Long_Haul_Full_Loading.vmod.gz"
    rows = list(csv.reader(io.StringIO(gzip.decompress(path.read_bytes()).decode("utf-8-sig"))))
    head = {name: number for number, name in enumerate(rows[0])}
    found = [[float(row[head[name]]) for row in rows[1:]] for name in ("dist [m]", "v_act [km/h]")]
    return np.array(found)


def vecto():
    """A VECTO mission: target speed, VECTO's driver, the program's driver."""
    mission = DATA / "vecto" / "cycles" / "LongHaul.vdri"
    if not mission.is_file():
        return None
    with mission.open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.DictReader(file))
    place = np.array([float(row["<s>"]) for row in rows])
    target = np.array([float(row["<v>"]) for row in rows])
    slope = np.array([float(row["<grad>"]) for row in rows])
    distance, speed = _vecto()
    study = ocmc.Study("field-truck-loaded").set(
        "mission.routes", [{"file": str(mission), "weight": 1.0}]
    )
    study = study.set(
        "simulation.without", ["traffic", "weather", "driver_spread", "vehicle_spread"]
    )
    trace = study.trace(0)
    first_km, last_km = 22.0, 47.0
    drawn, (top, bottom) = figure(2, 1, height=4.4, sharex=True, height_ratios=[2.6, 1.0])
    top.step(
        place / 1000.0,
        target,
        where="post",
        color=ORANGE,
        linewidth=1.3,
        label="target of the mission",
    )
    top.plot(
        distance / 1000.0,
        speed,
        color=GREY,
        linewidth=1.6,
        label="VECTO 2.2, its driver and 40 t truck",
    )
    top.plot(
        column(trace, "position_m") / 1000.0,
        KMH * column(trace, "speed_mps"),
        color=BLUE,
        linewidth=1.3,
        label="ocmc, typical driver, tractor of 40 t",
    )
    top.set(ylabel="speed, km/h", xlim=(first_km, last_km), ylim=(58, 94))
    top.legend(loc="lower left", fontsize=8.5)
    bottom.fill_between(place / 1000.0, slope, step="post", color=GREEN, alpha=0.45, linewidth=0)
    bottom.axhline(0.0, color="black", linewidth=0.6)
    bottom.set(ylabel="slope, %", xlabel="position, km", ylim=(-7, 7))
    drawn.align_ylabels()
    return drawn


FIGURES = {"outside-roads": outside_roads, "peers": peers, "curve-fit": curve_fit, "vecto": vecto}
