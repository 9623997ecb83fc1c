"""Trucks of a fleet: their years beside one another, and the levels of their spread."""

from collections.abc import Mapping
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from ocmc import Run
from ocmc.plot._axis import BLUE, COLOURS, GREY, axes, ink, numbers, quantity, spine_free

# 97.5 % quantile of the normal law
_FAR = 1.959963984540054


def trucks(run: Run, *, column: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw the year of each truck with the interval by the chance of its trips: a caterpillar.

    Parameters
    ----------
    run : Run
        A run of trucks that make several trips.
    column : str, optional
        Quantity per distance of the records; the consumption by default.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes: trucks from the lowest to the highest, and the mean of the fleet. Each truck has
        the 95 % interval of its mean over other trips of its own. Effects that trucks share are not
        in the intervals.

    Examples
    --------
    >>> import ocmc
    >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
    >>> ocmc.plot.trucks(study.run(trucks=5, trips=8)).get_ylabel()
    'consumption, L/100 km'
    """
    if run.trucks is None:
        raise ValueError("each trip of the run has a truck of its own: run(trucks=..., trips=...)")
    if column is None:
        diesel = np.isfinite(numbers(run, "consumption_l_per_100km")).any()
        column = "consumption_l_per_100km" if diesel else "consumption_kwh_per_km"
    name, factor = quantity(column)
    completed = np.asarray(run["outcome"]).astype(str) == "completed"
    ids, values = numbers(run, "truck_id")[completed], factor * numbers(run, column)[completed]
    weights = numbers(run, "distance_m")[completed]
    means, errors = [], []
    for truck in np.unique(ids):
        own = ids == truck
        x, w = values[own], weights[own]
        mean = float(np.average(x, weights=w))
        means.append(mean)
        # the linearised error of a ratio of totals
        n = len(x)
        residuals = w * (x - mean)
        errors.append(np.sqrt(n / (n - 1) * np.sum(residuals**2)) / np.sum(w) if n > 1 else np.nan)
    order = np.argsort(means)
    heights, whiskers = np.asarray(means)[order], _FAR * np.asarray(errors)[order]
    ax = axes(ax)
    places = np.arange(len(order))
    ax.errorbar(
        places,
        heights,
        yerr=whiskers,
        fmt="o",
        markersize=3,
        color=BLUE,
        ecolor=GREY,
        elinewidth=0.8,
    )
    ax.axhline(
        float(np.average(values, weights=weights)),
        color=ink(),
        linewidth=0.8,
        label="mean of the fleet",
    )
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set(xlabel="trucks, from the lowest to the highest", ylabel=name)
    ax.legend(frameon=False, loc="upper left")
    return spine_free(ax)


def shares(answers: Mapping[str, Mapping[str, Any]], *, ax: Axes | None = None) -> Axes:
    """Draw what each factor explains at each level, as bars beside one another.

    Parameters
    ----------
    answers : dict
        Answers of `Study.sensitivity` by the name of their bars, such as ``{"trips":
        study.sensitivity(...), "truck-years": study.sensitivity(..., over="truck")}``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes: for each factor a bar for each answer, its first-order share with the 95 %
        interval. They are not stacked: each is an estimate with an error of its own, and they sum
        to no whole.

    Examples
    --------
    >>> import ocmc
    >>> answer = {"factors": [{"factor": "road", "first": 0.4}, {"factor": "driver", "first": 0.5}]}
    >>> len(ocmc.plot.shares({"trips": answer}).patches)
    2
    """
    ax = axes(ax)
    # parts of factors are in them already
    wholes = [
        {share["factor"]: share for share in answer["factors"] if "." not in share["factor"]}
        for answer in answers.values()
    ]
    factors = list(dict.fromkeys(factor for whole in wholes for factor in whole))
    places, width = np.arange(len(factors), dtype=float), 0.8 / len(answers)
    for k, (name, whole, colour) in enumerate(zip(answers, wholes, cycle(COLOURS))):
        found = [whole.get(factor, {}) for factor in factors]
        heights = np.array([100.0 * share.get("first", np.nan) for share in found])
        ends = np.array(
            [share.get("first_ci95") or [np.nan, np.nan] for share in found], dtype=float
        )
        ax.bar(
            places + (k - (len(answers) - 1) / 2.0) * width,
            heights,
            width=width,
            color=colour,
            label=name,
            yerr=np.abs(100.0 * ends.T - heights),
            error_kw={"elinewidth": 1.0, "ecolor": ink(), "capsize": 2},
        )
    ax.axhline(0.0, color=ink(), linewidth=0.6)
    ax.set_xticks(places, labels=[factor.replace("_", " ") for factor in factors])
    ax.set_ylabel("share of the variance, first order, %")
    ax.legend(frameon=False)
    return spine_free(ax)
