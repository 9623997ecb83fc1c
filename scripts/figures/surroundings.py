"""Surroundings of trucks: a drawn road, the forces on it, the seasons."""

import numpy as np
import ocmc
from driving import drive
from style import BLUE, GREEN, GREY, KMH, ORANGE, PALE, PURPLE, RED, SKY, column, figure

GRAVITY_MPS2 = 9.81
_TYPES = {
    "urban": ("0.78", "urban"),
    "rural": ("0.93", "rural"),
    "motorway": ("#d9ecf7", "motorway"),
}


def road():
    """One drawn road: altitude, signs on its road types, curvature, events."""
    tracks, _ = drive()
    last_km = 100.0
    drawn, (height, signs, curves) = figure(
        3, 1, height=5.4, sharex=True, height_ratios=[1.5, 1.7, 1.2]
    )
    altitude = tracks["altitude_m"]
    above = column(altitude, "value")
    height.fill_between(
        column(altitude, "position_m") / 1000.0, above.min() - 10.0, above, color=GREEN, alpha=0.35
    )
    height.set(ylabel="altitude, m", ylim=(above.min() - 10.0, None), xlim=(0, last_km))
    types = tracks["road_type"]
    ends = np.append(column(types, "position_m")[1:], 1000.0 * last_km) / 1000.0
    named = set()
    for start, end, kind in zip(
        column(types, "position_m") / 1000.0, ends, types["value"], strict=True
    ):
        colour, name = _TYPES[kind]
        signs.axvspan(start, end, color=colour, linewidth=0, label=None if kind in named else name)
        named.add(kind)
    limit = tracks["speed_limit_mps"]
    place = np.append(column(limit, "position_m"), 1000.0 * last_km) / 1000.0
    value = KMH * np.append(column(limit, "value"), column(limit, "value")[-1])
    signs.step(place, value, where="post", color="black", linewidth=1.2, label="sign")
    kinds = {
        "stop": ("v", RED, ["stop_sign_s", "red_light_s", "give_way_stop_s"]),
        "give way, passed": ("d", PURPLE, ["give_way_pass_mps"]),
        "speed bump": ("^", ORANGE, ["speed_bump_length_m"]),
    }
    for row, (name, (sign, colour, names)) in enumerate(kinds.items()):
        places = np.concatenate([column(tracks[track], "position_m") for track in names]) / 1000.0
        signs.plot(
            places,
            np.full(places.size, 24.0 - 8.0 * row),
            sign,
            color=colour,
            markersize=4.5,
            label=name,
        )
    signs.set(ylabel="km/h", ylim=(0, 135))
    signs.legend(ncols=4, loc="upper left", fontsize=8)
    bends = tracks["curvature_per_m"]
    place, value = column(bends, "position_m") / 1000.0, 1000.0 * column(bends, "value")
    turned = np.abs(value) > 0.0
    curves.vlines(
        place[turned], 0.0, np.clip(value[turned], -25.0, 25.0), color=BLUE, linewidth=0.9
    )
    curves.axhline(0.0, color="black", linewidth=0.6)
    curves.set(ylabel="curvature, 1/km\nleft +, right −", xlabel="position, km", ylim=(-26, 26))
    drawn.align_ylabels()
    return drawn


def forces():
    """Tractive effort by gear over the resistances of a truck of 40 t."""
    study = ocmc.Study("field-truck-loaded").set(
        "simulation.without", ["driver_spread", "vehicle_spread"]
    )
    run = study.run(cycles=20, progress=False)
    vehicle = study.to_dict()["vehicle"]
    engine, box = (
        vehicle["powertrain"]["combustion"]["engine"],
        vehicle["powertrain"]["combustion"]["gearbox"],
    )
    coefficient, area = run["rolling_coefficient"].mean(), run["drag_area_m2"].mean()
    mass = vehicle["curb_mass_kg"] + run["payload_kg"].mean()
    air = 1.25  # kg/m³, about 8 °C at sea level
    drawn, ax = figure(height=4.4)
    speed = np.linspace(0.0, 100.0, 201)
    rolling = np.full(speed.size, mass * GRAVITY_MPS2 * coefficient)
    drag = 0.5 * air * area * (speed / KMH) ** 2
    for slope, style in [(0.0, "-"), (2.0, "--"), (4.0, "-."), (6.0, ":")]:
        need = rolling + drag + mass * GRAVITY_MPS2 * slope / 100.0
        ax.plot(speed, need / 1000.0, style, color=RED, linewidth=1.4)
        ax.annotate(
            f"{slope:.0f} %",
            (100.6, need[-1] / 1000.0),
            color=RED,
            fontsize=9,
            va="center",
            annotation_clip=False,
        )
    ax.fill_between(speed, rolling / 1000.0, color=PALE, linewidth=0, label="rolling resistance")
    ax.fill_between(
        speed,
        rolling / 1000.0,
        (rolling + drag) / 1000.0,
        color=SKY,
        alpha=0.6,
        linewidth=0,
        label="drag, still air",
    )
    ax.plot([], [], color=RED, label="needed at a steady speed, by slope")
    turns, full = (
        np.asarray(engine["full_load_speed_radps"]),
        np.asarray(engine["full_load_torque_nm"]),
    )
    turned = np.linspace(turns[0], 219.0, 120)
    for number, ratio in enumerate(box["ratio"], start=1):
        loss = box["direct_loss_share"] if ratio == 1.0 else box["indirect_loss_share"]
        torque = np.interp(turned, turns, full)
        shaft = ratio * (
            torque * (1.0 - loss) - box["loss_torque_nm"] - box["loss_torque_nms"] * turned
        )
        wheel = (shaft * (1.0 - box["axle_loss_share"]) - box["axle_loss_torque_nm"]) * box[
            "axle_ratio"
        ]
        at = KMH * turned * vehicle["wheel_radius_m"] / (ratio * box["axle_ratio"])
        ax.plot(
            at,
            wheel / vehicle["wheel_radius_m"] / 1000.0,
            color=BLUE,
            linewidth=1.1,
            label="full load, by gear" if number == 1 else None,
        )
        top = wheel.argmax()
        if number >= 5:
            ax.annotate(
                str(number),
                (at[top], wheel[top] / vehicle["wheel_radius_m"] / 1000.0 + 0.6),
                color=BLUE,
                fontsize=8.5,
                ha="center",
            )
    ax.set(xlabel="speed, km/h", ylabel="force at the wheels, kN", xlim=(0, 100), ylim=(0, 60))
    ax.legend(loc="upper right")
    return drawn


def seasons():
    """Consumption and temperature by month."""
    run = ocmc.Study("field-truck").run(cycles=6000, progress=False)
    month = np.minimum(
        (column(run, "departure_s_of_year") / 86400.0 / 365.0 * 12.0).astype(int), 11
    )
    fuel, km = column(run, "fuel_kg") / 0.836, column(run, "distance_m") / 1000.0
    mean, half, celsius, spread = [], [], [], []
    for number in range(12):
        part = month == number
        ratio = 100.0 * fuel[part].sum() / km[part].sum()
        errors = 100.0 * fuel[part] - ratio * km[part]
        n = part.sum()
        mean.append(ratio)
        half.append(1.96 * np.sqrt(n / (n - 1) * (errors**2).sum()) / km[part].sum())
        celsius.append(column(run, "air_temperature_k")[part].mean() - 273.15)
        spread.append(column(run, "air_temperature_k")[part].std())
    names = list("JFMAMJJASOND")
    place = np.arange(12)
    drawn, (litres, degrees) = figure(2, 1, height=4.4, sharex=True, height_ratios=[1.6, 1.0])
    litres.errorbar(place, mean, yerr=half, fmt="o", color=BLUE, capsize=3)
    litres.axhline(100.0 * fuel.sum() / km.sum(), color=GREY, linewidth=1.0)
    litres.annotate(
        "the year",
        (11.45, 100.0 * fuel.sum() / km.sum() + 0.06),
        ha="right",
        fontsize=8.5,
        color="0.3",
    )
    litres.set(ylabel="L/100 km", xlim=(-0.5, 11.5))
    litres.set_title("mean of each month's trips, with its 95 % interval")
    celsius, spread = np.array(celsius), np.array(spread)
    degrees.fill_between(
        place, celsius - spread, celsius + spread, color=ORANGE, alpha=0.25, linewidth=0
    )
    degrees.plot(place, celsius, "o-", color=ORANGE, markersize=4)
    degrees.axhline(0.0, color="black", linewidth=0.6)
    degrees.set(ylabel="air, °C")
    degrees.set_xticks(place, labels=names)
    drawn.align_ylabels()
    return drawn


FIGURES = {"road": road, "forces": forces, "seasons": seasons}
