"""Identified gains of the pedal controllers."""

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from ocmc.plot._axis import BLUE, RED, spine_free

_GAINS = [("kp", "$K_P$, s/m"), ("ki", "$K_I$, 1/m"), ("kd", "$K_D$, s²/m")]
_SPREAD = 0.16


def identified(answer: Mapping[str, Any], *, ax: Sequence[Axes] | None = None) -> list[Axes]:
    """Draw the identified gains of each driver and event, uphill and downhill apart.

    Parameters
    ----------
    answer : dict
        What `identify` or ``ocmc identify --json`` gives.
    ax : sequence of three matplotlib.axes.Axes, optional
        Where to draw; new axes by default, one above the other.

    Returns
    -------
    list of matplotlib.axes.Axes
        The axes of K_P, K_I and K_D, logarithmic. A point is one event, a hollow one ran to a bound.

    Raises
    ------
    ValueError
        Where there are not three axes.

    Notes
    -----
    The split is that of Romano, Godio, Bruzelius, Johannesson, figure of the sorted parameters.

    Examples
    --------
    >>> import ocmc
    >>> fit = {"driver": "a", "grade": 0.03, "kp": 0.5, "ki": 0.02, "kd": None, "at_bound": []}
    >>> [ax.get_ylabel() for ax in ocmc.plot.identified({"fits": [fit]})]
    ['$K_P$, s/m', '$K_I$, 1/m', '$K_D$, s²/m']
    """
    fits = answer["fits"]
    if ax is None:
        panels = list(plt.subplots(len(_GAINS), sharex=True, figsize=(8, 7), layout="constrained")[1])
    else:
        panels = list(np.ravel(np.asarray(ax, dtype=object)))
    if len(panels) != len(_GAINS):
        message = f"`ax` has {len(panels)} axes, the gains need {len(_GAINS)}"
        raise ValueError(message)
    drivers = sorted({str(fit["driver"]) for fit in fits}, key=lambda name: (len(name), name))
    for panel, (gain, name) in zip(panels, _GAINS, strict=True):
        for uphill, colour, side in [(True, RED, -_SPREAD), (False, BLUE, _SPREAD)]:
            for at_bound in (False, True):
                part = [
                    fit
                    for fit in fits
                    if fit[gain] is not None
                    and _uphill(fit) == uphill
                    and (gain in fit["at_bound"]) == at_bound
                ]
                x = [drivers.index(str(fit["driver"])) + side for fit in part]
                label = ("uphill" if uphill else "downhill") + (", at a bound" if at_bound else "")
                panel.plot(
                    np.array(x),
                    np.array([fit[gain] for fit in part]),
                    "o",
                    color=colour,
                    markerfacecolor="none" if at_bound else colour,
                    alpha=0.8,
                    label=label,
                )
        panel.set(yscale="log", ylabel=name)
        panel.grid(axis="y", alpha=0.3)
        spine_free(panel)
    panels[0].legend(frameon=False, ncols=4, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    panels[-1].set_xticks(range(len(drivers)), labels=drivers)
    panels[-1].set_xlabel("driver")
    return panels


def _uphill(fit: Mapping[str, Any]) -> bool:
    return bool(fit["grade"] > 0)
