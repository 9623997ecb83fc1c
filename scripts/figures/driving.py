"""Course of a truck on its road: one cycle, a stop, a curve, a descent."""

import functools

import numpy as np
import ocmc
from style import BLUE, GREEN, GREY, KMH, ORANGE, PALE, PURPLE, RED, column, figure

CYCLE = 3
CURVES_BELOW_M = 500.0


@functools.cache
def drive(cycle_id=CYCLE, study="field-truck"):
    """Give the road and the trace of one cycle."""
    study = ocmc.Study(study)
    return dict(study.operating_cycle(cycle_id).items()), study.trace(cycle_id)


def part_of(trace, first_m, last_m, margin=1):
    """Give the rows between two places, with some beside them."""
    position = column(trace, "position_m")
    inside = np.flatnonzero((position >= first_m) & (position <= last_m))
    rows = slice(max(inside[0] - margin, 0), inside[-1] + 1 + margin)
    return {name: column(trace, name)[rows] for name in trace.columns}


def limits(road, first_m, last_m):
    """Give the signs between two places, as steps."""
    place, limit = (
        column(road["speed_limit_mps"], "position_m"),
        column(road["speed_limit_mps"], "value"),
    )
    inside = (place > first_m) & (place < last_m)
    before = np.flatnonzero(place <= first_m)[-1]
    steps = np.concatenate(
        [[limit[before]], limit[inside], limit[inside][-1:] if inside.any() else [limit[before]]]
    )
    return np.concatenate([[first_m], place[inside], [last_m]]), steps


def events(ax, road, window_m, *, scale, top):
    """Mark stops, slow passes and bumps along an edge."""
    first_m, last_m = window_m
    kinds = {
        "stop": ("v", RED, ["stop_sign_s", "red_light_s", "give_way_stop_s", "mission_stop_s"]),
        "speed bump": ("^", ORANGE, ["speed_bump_length_m"]),
        "give way, slow pass": ("d", PURPLE, ["give_way_pass_mps"]),
    }
    for name, (sign, colour, tracks) in kinds.items():
        places = np.concatenate([column(road[track], "position_m") for track in tracks])
        places = places[(places >= first_m) & (places <= last_m)]
        if places.size:
            ax.plot(
                scale * places,
                np.full(places.size, top),
                sign,
                color=colour,
                label=name,
                clip_on=False,
            )


def curves(road, first_m, last_m):
    """Give the curves between two places: from, to, radius."""
    place, value = (
        column(road["curvature_per_m"], "position_m"),
        column(road["curvature_per_m"], "value"),
    )
    ends = np.append(place[1:], place[-1])
    sharp = (np.abs(value) > 1.0 / CURVES_BELOW_M) & (ends > first_m) & (place < last_m)
    return [
        (a, b, 1.0 / abs(v))
        for a, b, v in zip(place[sharp], ends[sharp], value[sharp], strict=True)
    ]


def one_cycle():
    """Nine kilometres of one cycle: limits, plan and drive, slope, pedals, gear."""
    first_m, last_m = 0.0, 9000.0
    road, trace = drive()
    rows = part_of(trace, first_m, last_m)
    km = rows["position_m"] / 1000.0
    drawn, axes = figure(4, 1, height=6.4, sharex=True, height_ratios=[3.2, 1.0, 1.4, 1.2])
    speed, slope, pedals, gear = axes
    for a, b, _ in curves(road, first_m, last_m):
        speed.axvspan(a / 1000.0, b / 1000.0, color=PALE, linewidth=0, label="_")
    speed.fill_between([], [], color=PALE, label="curve, R < 500 m")
    place, limit = limits(road, first_m, last_m)
    speed.step(place / 1000.0, KMH * limit, where="post", color=GREY, linewidth=1.2, label="limit")
    speed.plot(km, KMH * rows["desired_speed_mps"], color=ORANGE, linewidth=1.4, label="desired")
    speed.plot(km, KMH * rows["speed_mps"], color=BLUE, linewidth=1.4, label="driven")
    events(speed, road, (first_m, last_m), scale=1e-3, top=99.0)
    speed.set(ylabel="speed, km/h", ylim=(0, 100), xlim=(first_m / 1000.0, last_m / 1000.0))
    speed.legend(ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.03))
    place = column(road["grade"], "position_m")
    near = place < last_m
    slope.fill_between(
        place[near] / 1000.0,
        100.0 * column(road["grade"], "value")[near],
        step="post",
        color=GREEN,
        alpha=0.45,
        linewidth=0,
    )
    slope.axhline(0.0, color="black", linewidth=0.6)
    slope.set(ylabel="slope, %", ylim=(-7, 7))
    pedals.fill_between(
        km, 100.0 * rows["accelerator"], color=BLUE, alpha=0.6, linewidth=0, label="accelerator"
    )
    pedals.fill_between(
        km, -100.0 * rows["brake"], color=RED, alpha=0.7, linewidth=0, label="brake"
    )
    pedals.set(ylabel="pedals, %", ylim=(-60, 105), yticks=[-50, 0, 50, 100])
    pedals.set_yticklabels(["50", "0", "50", "100"])
    pedals.legend(loc="lower right", ncols=2)
    gear.step(km, rows["gear"], where="pre", color="black", linewidth=1.0)
    gear.set(ylabel="gear", xlabel="position, km", yticks=[1, 4, 8, 12], ylim=(0, 13))
    drawn.align_ylabels()
    return drawn


def stop():
    """A stop: the desired speed runs to zero, the truck stands, and starts anew."""
    road, trace = drive()
    places = column(road["stop_sign_s"], "position_m")
    line_m = places[0]
    rows = part_of(trace, line_m - 330.0, line_m + 330.0)
    standing = np.flatnonzero((rows["speed_mps"] == 0.0) & (rows["step_s"] > 1.0))[0]
    stood_s = rows["step_s"][standing]
    time = rows["time_s"] - rows["time_s"][standing] + stood_s
    # a row says what is at its end: the halt begins where the row before it ends
    rows = {name: np.insert(values, standing, values[standing]) for name, values in rows.items()}
    time = np.insert(time, standing, 0.0)
    drawn, axes = figure(3, 1, height=5.2, sharex=True, height_ratios=[2.6, 1.3, 1.1])
    speed, pedals, engine = axes
    for ax in axes:
        ax.axvspan(0.0, stood_s, color=PALE, linewidth=0)
    speed.plot(time, KMH * rows["desired_speed_mps"], color=ORANGE, label="desired")
    speed.plot(time, KMH * rows["speed_mps"], color=BLUE, label="driven")
    speed.set(ylabel="speed, km/h", ylim=(0, None), xlim=(-32, 45))
    speed.annotate(
        "at the line", (stood_s / 2.0, 30.0), ha="center", rotation=90, color="0.35", va="center"
    )
    speed.legend(loc="lower right")
    pedals.fill_between(
        time, 100.0 * rows["accelerator"], color=BLUE, alpha=0.6, linewidth=0, label="accelerator"
    )
    pedals.fill_between(
        time, -100.0 * rows["brake"], color=RED, alpha=0.7, linewidth=0, label="brake"
    )
    pedals.set(ylabel="pedals, %", ylim=(-105, 105), yticks=[-100, 0, 100])
    pedals.set_yticklabels(["100", "0", "100"])
    pedals.legend(loc="lower right", ncols=2)
    engine.step(time, rows["gear"], where="pre", color="black", linewidth=1.0)
    engine.set(ylabel="gear", xlabel="time from the halt, s", yticks=[1, 6, 12], ylim=(0, 13))
    drawn.align_ylabels()
    return drawn


def curve_entry():
    """Curves: braking ends at the curve, its law holds inside, the truck speeds up behind it."""
    road, trace = drive()
    first_m, last_m = 24200.0, 26300.0
    rows = part_of(trace, first_m, last_m)
    drawn, (speed, side) = figure(2, 1, height=4.4, sharex=True, height_ratios=[2.4, 1.2])
    for a, b, radius in curves(road, first_m, last_m):
        for ax in (speed, side):
            ax.axvspan(a, b, color=PALE, linewidth=0)
        speed.annotate(
            f"{radius:.0f} m",
            ((a + b) / 2.0, 92.0),
            ha="center",
            fontsize=8,
            color="0.3",
            rotation=90,
            va="top",
        )
    events(speed, road, (first_m, last_m), scale=1.0, top=3.0)
    place, limit = limits(road, first_m, last_m)
    speed.step(place, KMH * limit, where="post", color=GREY, linewidth=1.2, label="limit")
    speed.plot(rows["position_m"], KMH * rows["desired_speed_mps"], color=ORANGE, label="desired")
    speed.plot(rows["position_m"], KMH * rows["speed_mps"], color=BLUE, label="driven")
    speed.set(ylabel="speed, km/h", ylim=(0, 95), xlim=(first_m, last_m))
    speed.legend(loc="lower left", ncols=4)
    side.plot(
        rows["position_m"],
        rows["speed_mps"] * np.abs(rows["yaw_rate_radps"]),
        color=RED,
        linewidth=1.2,
    )
    side.set(ylabel="to the side, m/s²", xlabel="position, m", ylim=(0, 3))
    drawn.align_ylabels()
    return drawn


FIGURES = {"one-cycle": one_cycle, "stop": stop, "curve-entry": curve_entry}
