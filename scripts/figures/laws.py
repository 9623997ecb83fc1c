"""The laws behind the driving: curve speeds, the plan, the pedals, the gears."""

import tempfile
from pathlib import Path

import numpy as np
import ocmc
from driving import part_of
from style import BLUE, GREEN, GREY, KMH, ORANGE, PURPLE, RED, SKY, column, figure

RPM = 60.0 / (2.0 * np.pi)
G_PER_KWH = 3.6e9


def curve_law():
    """Curve speeds: the default law, the paper's law and its 25 trucks, and the law's end."""
    law = ocmc.Study("field-truck").to_dict()["driver"]["curve_speed"]
    printed = ocmc.Study("field-truck-printed").to_dict()["driver"]["curve_speed"]
    simulator = ocmc.Study("simulator-truck").to_dict()["driver"]["curve_speed"]
    reference_m, end_m = law["reference_radius_m"], law["maximum_radius_m"]

    def speed(of, radius):
        return KMH * of["reference_speed_mps"] * (radius / reference_m) ** of["exponent"]

    radius = np.geomspace(20.0, end_m, 200)
    drawn, ax = figure(height=4.4)
    for side in (1.0, 2.0, 3.0):
        wide = np.geomspace(15.0, 1500.0, 200)
        ax.plot(wide, KMH * np.sqrt(side * wide), ":", color=GREY, linewidth=0.9)
        name = f"{side:.0f} m/s²" + (" to the side" if side == 1.0 else "")
        at = (88.0 / KMH) ** 2 / side
        ax.annotate(
            name, (at * 1.02, 84.0), rotation=50, rotation_mode="anchor", fontsize=8, color="0.35"
        )
    table = law["table"]
    for exponent, at_reference in zip(table["exponent"], table["reference_speed_mps"], strict=True):
        truck = {"exponent": exponent, "reference_speed_mps": at_reference}
        ax.plot(radius, speed(truck, radius), color=SKY, linewidth=0.6, alpha=0.7)
    ax.plot([], [], color=SKY, linewidth=0.8, label="the paper's 25 trucks")
    ax.plot(
        radius, speed(printed, radius), "--", color=RED, label="the paper's pooled fit, as printed"
    )
    short = np.geomspace(125.0, 250.0, 50)
    ax.plot(
        short, speed(simulator, short), color=GREEN, label="the paper's simulator, 125 to 250 m"
    )
    middle, spread = speed(law, radius), np.exp(1.96 * law["driver_sd"])
    ax.fill_between(radius, middle / spread, middle * spread, color=BLUE, alpha=0.15, linewidth=0)
    ax.plot(radius, middle, color=BLUE, linewidth=2.2, label="default law, 95 % of drivers")
    ax.axvline(end_m, color="black", linewidth=0.9)
    ax.annotate(
        "the law ends here:\nwider curves\nslow no truck", (end_m * 1.04, 26.0), fontsize=8.5
    )
    ax.axhline(80.0, color=ORANGE, linewidth=1.0)
    ax.annotate("limit of 80 km/h", (19.0, 81.5), fontsize=8.5, color="0.25")
    ax.set(
        xscale="log",
        xlim=(15, 1500),
        ylim=(0, 110),
        xlabel="radius, m",
        ylabel="speed in the curve, km/h",
    )
    ax.set_xticks([20, 50, 100, 200, 500, 1000], labels=["20", "50", "100", "200", "500", "1000"])
    ax.minorticks_off()
    ax.legend(loc="upper left", bbox_to_anchor=(0.0, 0.99))
    return drawn


_ROUTE = """track,rule,position_m,value
road_type,constant,0,rural
speed_limit_mps,constant,0,22.222222
speed_limit_mps,constant,900,16.666667
speed_limit_mps,constant,1020,8.333333
speed_limit_mps,constant,1300,22.222222
stop_sign_s,event,2000,8
roughness_m3,constant,0,7.6e-6
ground,constant,0,asphalt
altitude_m,linear,0,0
altitude_m,linear,2700,0
"""


def _driven_route():
    """Drive a short route of known limits, with the typical driver and without chance."""
    study = ocmc.Study("field-truck")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "route.csv"
        path.write_text(_ROUTE, encoding="utf-8")
        study = study.set("mission.routes", [{"file": str(path), "weight": 1.0}])
        without = ["weather", "traffic", "driver_spread", "vehicle_spread", "payload_spread"]
        study = study.set("simulation.without", without).set("mission.payload_kg", 0.0)
        study = study.set("simulation.step_s", 0.2)
        return study.trace(0), study.operating_cycle(0), study.run(cycles=1, progress=False)


def tactical():
    """The plan in v²: static speeds, the sweep back, the sweep forth, and what is driven."""
    trace, cycle, run = _driven_route()
    slower = run["driver_deceleration_mps2"][0]
    faster = run["driver_acceleration_mps2"][0]
    length = cycle.length_m
    x = np.linspace(0.0, length, 1 + int(length))
    signs = [(0.0, 80.0), (900.0, 60.0), (1020.0, 30.0), (1300.0, 80.0)]
    static = np.zeros(x.size)
    for place, limit in signs:
        static[x >= place] = (limit / KMH) ** 2
    lowest = static.copy()
    lowest[np.abs(x - 2000.0) < 0.5] = 0.0  # the stop of the route
    lowest[-1] = 0.0
    back = lowest.copy()
    for i in range(x.size - 2, -1, -1):
        back[i] = min(lowest[i], back[i + 1] + 2.0 * slower * (x[i + 1] - x[i]))
    plan = back.copy()
    plan[0] = 0.0
    for i in range(1, x.size):
        plan[i] = min(back[i], plan[i - 1] + 2.0 * faster * (x[i] - x[i - 1]))
    drawn, ax = figure(height=4.2)
    ax.step(x, static, where="mid", color=GREY, linewidth=1.1, label="static: the signs")
    ax.plot(
        x,
        back,
        color=RED,
        linewidth=1.2,
        linestyle="--",
        label=f"sweep back, slope −2·{slower:.2f} m/s²",
    )
    ax.plot(
        x,
        plan,
        color=ORANGE,
        linewidth=3.4,
        alpha=0.7,
        label=f"sweep forth, slope 2·{faster:.2f} m/s²",
    )
    position, speed = column(trace, "position_m"), column(trace, "speed_mps")
    ax.plot(position, speed**2, color=BLUE, linewidth=1.3, label="driven by the program")
    for kmh in (30, 60, 80):
        ax.annotate(
            f"{kmh} km/h",
            (length + 15.0, (kmh / KMH) ** 2),
            fontsize=8.5,
            va="center",
            color="0.3",
            annotation_clip=False,
        )
    ax.annotate("stop", (2000.0, 40.0), (2000.0, 505.0), ha="center", fontsize=8.5, color=RED)
    ax.annotate(
        "the sign of 30 acts before\nthat of 60 has begun",
        (870.0, 245.0),
        (950.0, 560.0),
        fontsize=8.5,
        arrowprops={"arrowstyle": "-", "color": "0.4"},
    )
    ax.set(xlabel="position, m", ylabel="v², m²/s²", xlim=(0, length), ylim=(0, 640))
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return drawn


def pedals():
    """From the speed error to the pedals, and a descent in the overspeed band."""
    study = ocmc.Study("field-truck")
    law = study.to_dict()["driver"]["pedals"]
    gain, scale = law["pid"]["proportional_median"], law["brake_scale"]
    band, tolerance = law["overspeed_band_mps"], law["brake_tolerance_mps"]
    error = np.linspace(-4.0, 4.0, 401)
    drawn, (left, right) = figure(1, 2, height=3.9, width_ratios=[1.0, 1.35])
    left.plot(error, 100.0 * np.clip(gain * error, 0.0, 1.0), color=BLUE, label="accelerator")
    for width, style, name in [
        (0.0, ":", "without slack"),
        (tolerance, "-", "usually"),
        (band, "--", "in the band"),
    ]:
        brake = -scale * gain * np.minimum(error + width, 0.0)
        left.plot(
            error, -100.0 * np.clip(brake, 0.0, 1.0), style, color=RED, label=f"brake, {name}"
        )
    left.axhline(0.0, color="black", linewidth=0.6)
    left.axvline(0.0, color="black", linewidth=0.6)
    left.set(
        xlabel="desired − driven speed, m/s",
        ylabel="pedal, %",
        ylim=(-60, 105),
        yticks=[-50, 0, 50, 100],
    )
    left.set_yticklabels(["50", "0", "50", "100"])
    left.set_title("the typical driver, proportional part")
    left.legend(loc="lower right", fontsize=8)
    trace, middle = _descent(study, band)
    rows = part_of(trace, middle - 1300.0, middle + 1500.0)
    km = rows["position_m"] / 1000.0
    desired = KMH * rows["desired_speed_mps"]
    right.fill_between(
        km,
        desired,
        desired + KMH * band,
        color=ORANGE,
        alpha=0.2,
        linewidth=0,
        label="band, 5 km/h",
    )
    right.plot(km, desired, color=ORANGE, label="desired")
    right.plot(km, KMH * rows["speed_mps"], color=BLUE, label="driven")
    right.set(xlabel="position, km", ylabel="speed, km/h", xlim=(km[0], km[-1]), ylim=(60, 100))
    right.legend(loc="upper left", ncols=3, fontsize=8.5)
    right.set_title("a descent")
    below = right.twinx()
    below.grid(visible=False)
    below.spines["right"].set_visible(True)
    below.fill_between(km, 100.0 * rows["brake"], color=RED, alpha=0.7, linewidth=0)
    below.plot(km, 100.0 * rows["grade"], color=GREEN, linewidth=1.0)
    below.axhline(0.0, color="black", linewidth=0.6)
    below.set(ylim=(-8, 40), yticks=[-6, 0, 6])
    below.set_ylabel("slope (green), brake (red), %", fontsize=8.5)
    return drawn


def _descent(study, band):
    """Find a descent on which the truck runs up to the edge of the band."""
    for cycle_id in range(40):
        trace = study.trace(cycle_id)
        position, over = (
            column(trace, "position_m"),
            column(trace, "speed_mps") - column(trace, "desired_speed_mps"),
        )
        held = (
            (over > 0.9 * band)
            & (column(trace, "brake") > 0.0)
            & (column(trace, "desired_speed_mps") > 20.0)
        )
        if held.sum() > 60:  # steps: more than a minute
            return trace, float(np.median(position[held]))
    raise LookupError("no cycle has such a descent")


def shift_lines():
    """Where the engine works: full load, specific fuel, the lines of the gearbox, and a drive."""
    study = ocmc.Study("field-truck")
    vehicle = study.to_dict()["vehicle"]
    engine, box = (
        vehicle["powertrain"]["combustion"]["engine"],
        vehicle["powertrain"]["combustion"]["gearbox"]["shift"],
    )
    rows = np.asarray(engine["map_speed_radps"])
    torques = np.asarray(engine["map_torque_nm"])
    speed = np.linspace(rows[0], rows[-1], 160)
    torque = np.linspace(60.0, 2200.0, 160)
    by_row = []
    for fuel in engine["map_fuel_kgps"]:
        known = torques[: len(fuel)]
        slope = (fuel[-1] - fuel[-2]) / (known[-1] - known[-2])
        by_row.append(
            np.where(
                torque <= known[-1],
                np.interp(torque, known, fuel),
                fuel[-1] + slope * (torque - known[-1]),
            )
        )
    fuel = np.array([np.interp(speed, rows, values) for values in np.transpose(by_row)])
    specific = G_PER_KWH * fuel / (torque[:, None] * speed[None, :])
    full_speed, full = (
        np.asarray(engine["full_load_speed_radps"]),
        np.asarray(engine["full_load_torque_nm"]),
    )
    drag = np.interp(full_speed, rows, engine["drag_torque_nm"])
    specific[torque[:, None] > np.interp(speed, full_speed, full)[None, :]] = np.nan
    drawn, ax = figure(height=4.6)
    levels = [188, 190, 193, 197, 205, 220, 250, 300, 400]
    lines = ax.contour(RPM * speed, torque, specific, levels=levels, colors="0.6", linewidths=0.8)
    ax.clabel(lines, fontsize=7.5, fmt="%d")
    trace = study.trace(3)
    open_ = column(trace, "clutch_closed") < 1.0
    ran = np.where(open_, np.nan, column(trace, "engine_speed_radps"))
    every = slice(None, None, 8)
    ax.plot(
        RPM * ran[every],
        column(trace, "engine_torque_nm")[every],
        ".",
        color=SKY,
        markersize=2.4,
        label="one cycle, every eighth step",
    )
    ax.plot(RPM * full_speed, full, color="black", linewidth=2.0, label="full load")
    ax.plot(RPM * full_speed[:-1], drag[:-1], color=PURPLE, linewidth=1.4, label="drag")
    pedal = np.linspace(0.0, 1.0, 60)
    for name, colour, base, rise in [
        ("upshift line", GREEN, box["up_speed_radps"], box["up_pedal_radps"]),
        ("downshift line", RED, box["down_speed_radps"], box["down_pedal_radps"]),
    ]:
        at = base + rise * pedal
        low, high = np.interp(at, rows, engine["drag_torque_nm"]), np.interp(at, full_speed, full)
        ax.plot(RPM * at, low + pedal * (high - low), color=colour, linewidth=2.2, label=name)
    ax.axhline(0.0, color="black", linewidth=0.6)
    ax.set(xlabel="engine speed, rpm", ylabel="torque, Nm", xlim=(580, 2150), ylim=(-330, 2250))
    ax.annotate("thin lines: g/kWh", (1990.0, 2090.0), ha="right", fontsize=8.5, color="0.35")
    ax.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 0.14),
        fontsize=8.5,
        frameon=True,
        framealpha=0.95,
        markerscale=3,
    )
    return drawn


FIGURES = {
    "curve-law": curve_law,
    "tactical": tactical,
    "pedals": pedals,
    "shift-lines": shift_lines,
}
