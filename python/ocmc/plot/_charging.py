"""Charging of a fleet: load curves, state of charge along the way, winter against summer."""

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator

from ocmc import Run
from ocmc.plot._axis import BLUE, GREY, RED, SKY, axes, numbers, spine_free, words

_KWH_J = 3.6e6
_PLACES = {"depot": "depots", "public": "public chargers", "stop": "chargers at stops"}
# columns of the balance of a battery truck, and what they are called; together they are all of it
_LOSSES = {
    "rolling_energy_j": "rolling resistance",
    "drag_energy_j": "air drag",
    "auxiliary_energy_j": "auxiliaries",
    "battery_loss_j": "battery",
    "motor_loss_j": "motor and inverter",
    "transmission_loss_j": "gearbox and axle",
    "service_brake_energy_j": "service brakes",
    "shift_loss_j": "gear shifts",
    "clutch_loss_j": "clutch",
    "potential_change_j": "climb, net",
    "kinetic_change_j": "speed at the end",
}
# a year in days, from which day on the four seasons begin, and how many days they have
_YEAR, _FIRST_OF_MARCH, _SEASON = 365.0, 59.0, 365.0 / 4.0


def loads(run: Run, *, place: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw the power that chargers draw from the grid over the day.

    Parameters
    ----------
    run : Run
        A run of a study with ``[charging]``.
    place : {"depot", "public", "stop"}, optional
        The chargers; by default those that draw most energy.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes: the mean over the days, and a band from the median day up to the one that 19 of 20
        stay below.

    Examples
    --------
    >>> import ocmc
    >>> run = ocmc.Study("electric-regional").set("mission.length_m", 20e3).run(cycles=40)
    >>> ocmc.plot.loads(run).get_ylabel()
    'power of depots at the meter, kW'
    """
    table = run.loads()
    if table is None:
        raise ValueError("no trip of the run was charged: its study needs a table `[charging]`")
    places = words(table, "place")
    if place is None:
        totals = {
            name: numbers(table, "mean_power_w")[places == name].sum() for name in set(places)
        }
        place = max(sorted(totals), key=totals.__getitem__)
    own = places == place
    if not own.any():
        raise ValueError(f"no charging at {place!r}, only at {', '.join(sorted(set(places)))}")
    edges = np.arange(97) / 4.0
    mean, median, high = (
        numbers(table, f"{name}_power_w")[own] / 1000.0 for name in ("mean", "p50", "p95")
    )
    ax = axes(ax)
    ax.stairs(
        high,
        edges,
        baseline=median,
        fill=True,
        color=SKY,
        alpha=0.5,
        label="P50 to P95 over the days",
    )
    ax.stairs(mean, edges, color=BLUE, linewidth=1.5, label="mean")
    ax.set(xlabel="time of the day, h", ylabel=f"power of {_PLACES[place]} at the meter, kW")
    ax.set(xlim=(0.0, 24.0), ylim=(0.0, None))
    ax.xaxis.set_major_locator(MultipleLocator(3.0))
    ax.legend(frameon=False)
    return spine_free(ax)


def state_of_charge(run: Run, *, ax: Axes | None = None) -> Axes:
    """Draw the state of charge of a run's trips over the distance.

    It is known at departure, before and behind each charging, and at the end, and drawn straight
    between.

    Parameters
    ----------
    run : Run
        A run of a study with ``[charging]``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes: the median, and the band that holds 90 % of the trips that come so far.

    Examples
    --------
    >>> import ocmc
    >>> run = ocmc.Study("electric-regional").set("mission.length_m", 20e3).run(cycles=40)
    >>> ocmc.plot.state_of_charge(run).get_xlabel()
    'distance, km'
    """
    courses = _courses(run)
    if not courses:
        raise ValueError("no trip of the run was charged: its study needs a table `[charging]`")
    farthest = max(course[-1, 0] for course in courses)
    places, bands = [], []
    for at in np.linspace(0.0, farthest, 121):
        there = [
            np.interp(at, course[:, 0], course[:, 1]) for course in courses if course[-1, 0] >= at
        ]
        if len(there) < min(20, len(courses)):
            break
        places.append(at / 1000.0)
        bands.append(100.0 * np.quantile(there, [0.05, 0.5, 0.95]))
    low, middle, high = np.transpose(bands)
    ax = axes(ax)
    ax.fill_between(places, low, high, color=SKY, alpha=0.5, linewidth=0.0, label="P5 to P95")
    ax.plot(places, middle, color=BLUE, label="median")
    reserve = 100.0 * float(run.study["charging.reserve"])
    ax.axhline(reserve, color=RED, linewidth=0.8, linestyle="--", label="reserve")
    ax.set(xlabel="distance, km", ylabel="state of charge, %", xlim=(0.0, None), ylim=(0.0, 100.0))
    ax.legend(frameon=False)
    return spine_free(ax)


def _courses(run: Run) -> list[npt.NDArray[np.float64]]:
    """Positions and states of charge of each trip."""
    if (
        "grid_energy_public_j" not in run
        or not np.isfinite(numbers(run, "grid_energy_public_j")).any()
    ):
        return []
    events = run.chargings()
    way = words(events, "place") != "depot"
    ids = np.asarray(events["cycle_id"])[way]
    at, arrival, departure = (
        numbers(events, name)[way] for name in ("position_m", "begin_charge", "end_charge")
    )
    counts = np.isin(words(run, "outcome"), ["completed", "depleted"])
    begin, end, length = (
        numbers(run, name) for name in ("departure_charge", "final_charge", "distance_m")
    )
    courses = []
    for row in np.flatnonzero(counts):
        own = ids == run["cycle_id"][row]
        points = [[0.0, begin[row]]]
        for position, before, behind in zip(at[own], arrival[own], departure[own], strict=True):
            points += [[position, before], [position, behind]]
        courses.append(np.asarray([*points, [length[row], end[row]]]))
    return courses


def seasons(run: Run, *, ax: Axes | None = None) -> Axes:
    """Draw how the consumption of a battery truck goes up from summer to winter, and why.

    Parameters
    ----------
    run : Run
        A run of battery trucks with trips in both seasons (of the north). Completed trips count.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes: bars for summer and winter, in kWh/km, and between them what each kind of loss
        adds.

    Examples
    --------
    >>> import ocmc
    >>> run = ocmc.Study("battery-truck").set("mission.length_m", 10e3).run(cycles=200)
    >>> ocmc.plot.seasons(run).get_xlabel()
    'electricity from the battery, kWh/km'
    """
    totals = [_totals(run, season) for season in (2, 0)]
    if any(total is None for total in totals):
        raise ValueError(
            "the run has no completed trips of battery trucks in one of summer and winter"
        )
    summer, winter = (total for total in totals if total is not None)
    changes = {name: winter[column] - summer[column] for column, name in _LOSSES.items()}
    steps = {name: change for name, change in changes.items() if change != 0.0}
    order = sorted(steps, key=lambda name: -abs(steps[name]))
    ax = axes(ax)
    whole = [total["battery_energy_j"] for total in (summer, winter)]
    names, level = ["summer", *order, "winter"], whole[0]
    ax.barh(0, whole[0], color=BLUE)
    levels = [*whole]
    for k, name in enumerate(order):
        ax.barh(k + 1, steps[name], left=level, color=RED if steps[name] > 0.0 else SKY)
        level += steps[name]
        levels.append(level)
        ax.annotate(
            f"{steps[name]:+.3f}",
            (max(level, level - steps[name]), k + 1),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
        )
    ax.barh(len(order) + 1, whole[1], color=BLUE)
    low, high = min(levels), max(levels)
    ax.set_xlim(max(0.0, low - 0.6 * (high - low)), high + 0.25 * (high - low))
    ax.set_yticks(range(len(names)), names)
    ax.invert_yaxis()
    ax.axvline(whole[0], color=GREY, linewidth=0.6)
    ax.set_xlabel("electricity from the battery, kWh/km")
    return spine_free(ax)


def _totals(run: Run, season: int) -> dict[str, Any] | None:
    """Energy over distance of the trips of a season, in kWh/km; none where there are none."""
    day = numbers(run, "departure_s_of_year") / 86400.0
    of = (1 + np.floor((day - _FIRST_OF_MARCH + _YEAR) % _YEAR / _SEASON)) % 4
    own = (of == season) & (words(run, "outcome") == "completed")
    own &= np.isfinite(numbers(run, "battery_energy_j"))
    if not own.any():
        return None
    km = numbers(run, "distance_m")[own].sum() / 1000.0
    return {
        # what a powertrain does not have is no part of its balance
        column: np.nansum(numbers(run, column)[own]) / _KWH_J / km
        for column in [*_LOSSES, "battery_energy_j"]
    }
