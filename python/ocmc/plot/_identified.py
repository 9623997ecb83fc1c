"""Identified gains of the pedal controllers."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter

from ocmc.plot._axis import BLUE, RED, spine_free
from ocmc.plot._axis import panels as panels_of

_GAINS = [("kp", "$K_P$, s/m"), ("ki", "$K_I$, 1/m"), ("kd", "$K_D$, s²/m")]
_SWITCHED = [("kp", "$K_P$, s/m"), ("threshold_mps", "$e_{SW}$, m/s")]
_SPREAD = 0.3


def identified(answer: Mapping[str, Any], *, ax: Sequence[Axes] | None = None) -> list[Axes]:
    """Draw the identified gains of each driver and event, uphill and downhill apart.

    Parameters
    ----------
    answer : dict
        What `identify` or ``ocmc identify --json`` gives.
    ax : sequence of matplotlib.axes.Axes, optional
        Where to draw, three of them for a PID controller, two for a switched one; new axes by
        default, one above the other.

    Returns
    -------
    list of matplotlib.axes.Axes
        The axes of K_P, K_I and K_D, of a switched controller of K_P and its threshold e_SW; gains
        are logarithmic. A point is one event with its 95 % interval, a driver's steepest climb on
        the left; a hollow one is not identified, as where it ran to a bound. A K_D that noise has
        put below 0 has no place there: its interval alone is seen.

    Raises
    ------
    ValueError
        Where there are not as many axes.

    Notes
    -----
    The split is that of Romano, Godio, Bruzelius, Johannesson, figures 5 and 6: the optimal
    parameters, uphill and downhill apart, of the PID and of the switched controller.

    Examples
    --------
    >>> import ocmc
    >>> fit = {"driver": "a", "grade": 0.03, "kp": 0.5, "ki": 0.02, "kd": None, "at_bound": []}
    >>> [ax.get_ylabel() for ax in ocmc.plot.identified({"fits": [fit]})]
    ['$K_P$, s/m', '$K_I$, 1/m', '$K_D$, s²/m']
    """
    fits = answer["fits"]
    switched = any(fit.get("threshold_mps") is not None for fit in fits)
    gains = _SWITCHED if switched else _GAINS
    panels = panels_of(ax, len(gains), "the gains need", figsize=(8, 7))
    drivers = sorted({str(fit["driver"]) for fit in fits}, key=lambda name: (len(name), name))
    slopes = sorted({fit["grade"] for fit in fits}, reverse=True)
    offsets = dict(zip(slopes, np.linspace(-_SPREAD, _SPREAD, len(slopes)), strict=True))
    handles: dict[str, Any] = {}
    for panel, (gain, name) in zip(panels, gains, strict=True):
        for fit in fits:
            if fit[gain] is None:
                continue
            uphill, found = (
                fit["grade"] > 0,
                gain not in fit.get("not_identifiable", fit["at_bound"]),
            )
            colour = RED if uphill else BLUE
            place = drivers.index(str(fit["driver"])) + offsets[fit["grade"]]
            interval = _interval(fit, gain)
            if interval is not None:
                panel.plot([place, place], interval, color=colour, linewidth=1.0, alpha=0.6)
            (handle,) = panel.plot(
                place,
                fit[gain],
                "o",
                color=colour,
                markersize=5,
                markerfacecolor=colour if found else "none",
            )
            handles[
                ("uphill" if uphill else "downhill") + ("" if found else ", not identified")
            ] = handle
        panel.set_ylabel(name)
        if gain == "threshold_mps":
            panel.set_ylim(bottom=0)  # it may be none at all
        else:
            panel.set_yscale("log")
            panel.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            panel.yaxis.set_major_formatter("{x:g}")
            panel.yaxis.set_minor_formatter(NullFormatter())
        panel.grid(axis="y", alpha=0.3)
        spine_free(panel)
    labels = sorted(handles, key=lambda label: (label.startswith("down"), label))
    panels[0].legend(
        [handles[label] for label in labels],
        labels,
        frameon=False,
        ncols=4,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
    )
    panels[-1].set_xticks(range(len(drivers)), labels=drivers)
    panels[-1].set_xlabel("driver")
    return panels


def _interval(fit: Mapping[str, Any], gain: str) -> list[float] | None:
    """Interval of a gain, where it was worked out."""
    parameters = fit.get("parameters", [])
    return next(
        (parameter["interval"] for parameter in parameters if parameter["name"] == gain), None
    )
