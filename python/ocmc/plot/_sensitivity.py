"""Factors that drive the spread."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ocmc.plot._axis import BLUE, SKY, axes, ink, quantity, spine_free


def sensitivity(answer: Mapping[str, Any], *, ax: Axes | None = None) -> Axes:
    """Draw the share of the variance that each factor explains, with 95 % intervals.

    Parameters
    ----------
    answer : dict
        What `Study.sensitivity` or ``ocmc sensitivity --json`` gives.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes: a pair of bars for each factor, the one that matters most on top. ``first`` is the
        factor's first-order effect, ``total`` its total effect, joint effects included.

    Examples
    --------
    >>> import ocmc
    >>> road = {"factor": "road", "first": 0.5, "first_ci95": [0.4, 0.6]}
    >>> road |= {"total": 0.6, "total_ci95": [0.5, 0.7]}
    >>> answer = {"column": "consumption_l_per_100km", "factors": [road]}
    >>> ocmc.plot.sensitivity(answer).get_xlabel()
    'share of the variance of consumption, %'
    """
    ax = axes(ax)
    factors = sorted(answer["factors"], key=lambda factor: factor["total"] or 0.0)
    places = np.arange(len(factors), dtype=float)
    for key, colour, offset in [("total", SKY, -0.19), ("first", BLUE, 0.19)]:
        values = np.array([_number(factor[key]) for factor in factors])
        intervals = np.array(
            [factor[f"{key}_ci95"] or [np.nan, np.nan] for factor in factors], dtype=float
        )
        whiskers = 100.0 * np.abs(intervals.T - values)
        ax.barh(
            places + offset,
            100.0 * values,
            height=0.36,
            color=colour,
            label={"first": "first-order effect", "total": "total effect"}[key],
            xerr=whiskers,
            error_kw={"elinewidth": 1.0, "ecolor": ink(), "capsize": 2},
        )
    ax.axvline(0.0, color=ink(), linewidth=0.6)
    ax.set_yticks(places, labels=[_name(factor["factor"]) for factor in factors])
    ax.set_xlabel(f"share of the variance of {quantity(answer['column'])[0].partition(',')[0]}, %")
    handles, labels = ax.get_legend_handles_labels()
    ax.legend(handles[::-1], labels[::-1], frameon=False, loc="lower right")
    return spine_free(ax)


def _name(factor: str) -> str:
    return factor.replace("_", " ").replace(".", ": ")


def _number(value: float | None) -> float:
    return np.nan if value is None else value
