"""Trucks of a fleet: their years beside one another, and how the spread is shared out at each level."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from ocmc import Run
from ocmc.plot._axis import BLUE, COLOURS, GREY, axes, ink, numbers, quantity, spine_free

# 97.5 % quantile of the normal law
_FAR = 1.959963984540054


def trucks(run: Run, *, column: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw the year of each truck with the interval that the chance of its trips leaves: a caterpillar.

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
        The axes: trucks from the lowest to the highest, each with the 95 % interval of its mean
        over other trips of the same truck, and the mean of the fleet. Effects that trucks share are
        not in the intervals.

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
        places, heights, yerr=whiskers, fmt="o", markersize=3, color=BLUE, ecolor=GREY, elinewidth=0.8
    )
    ax.axhline(
        float(np.average(values, weights=weights)), color=ink(), linewidth=0.8, label="mean of the fleet"
    )
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set(xlabel="trucks, from the lowest to the highest", ylabel=name)
    ax.legend(frameon=False, loc="upper left")
    return spine_free(ax)


def shares(answers: Mapping[str, Mapping[str, Any]], *, ax: Axes | None = None) -> Axes:
    """Draw what each factor explains at each level, as stacked bars.

    Parameters
    ----------
    answers : dict
        Answers of `Study.sensitivity` by the name of their bar, such as ``{"trips":
        study.sensitivity(...), "truck-years": study.sensitivity(..., over="truck")}``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes: a bar for each answer, a part for each factor by its first-order share, without
        those below zero. The rest to 100 % is joint effects, and error.

    Examples
    --------
    >>> import ocmc
    >>> answer = {"factors": [{"factor": "road", "first": 0.4}, {"factor": "driver", "first": 0.5}]}
    >>> len(ocmc.plot.shares({"trips": answer}).patches)
    2
    """
    ax = axes(ax, legend_beside=True)
    factors: list[str] = []
    for answer in answers.values():
        # parts of factors stand below them already
        names = [share["factor"] for share in answer["factors"] if "." not in share["factor"]]
        factors += [name for name in names if name not in factors]
    bottoms = np.zeros(len(answers))
    for factor, colour in zip(factors, COLOURS, strict=False):
        heights = [
            100.0 * max(sum(s["first"] for s in answer["factors"] if s["factor"] == factor), 0.0)
            for answer in answers.values()
        ]
        ax.bar(list(answers), heights, bottom=bottoms, color=colour, label=factor, width=0.6)
        bottoms += np.asarray(heights)
    ax.set_ylabel("share of the variance, first order, %")
    ax.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return spine_free(ax)
