"""Measured drives over simulated ones."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

from ocmc.plot._axis import BLUE, GREY, KMH_PER_MPS, RED, spine_free


def validation(answer: Mapping[str, Any], *, road: int = 0, ax: Axes | None = None) -> Axes:
    """Draw the speeds of drives over the bands of the simulated trips of their road.

    Parameters
    ----------
    answer : Answer
        What `validate` gives.
    road : int
        Which of its roads, from 0.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    ValueError
        Where there is no such road.

    Examples
    --------
    >>> import warnings, ocmc
    >>> study = ocmc.Study("passenger-car").set("mission.length_m", 3000.0)
    >>> study = study.set("simulation.step_s", 0.5)
    >>> trace = study.trace(3, seed=7)
    >>> log = {name: trace[name] for name in ["time_s", "speed_mps", "position_m", "limit_mps"]}
    >>> with warnings.catch_warnings(action="ignore"):
    ...     answer = ocmc.validate(log, study, trips=20)
    >>> ocmc.plot.validation(answer).get_ylabel()
    'speed, km/h'
    """
    roads = answer["roads"]
    if not 0 <= road < len(roads):
        raise ValueError(f"`road` is {road}, allowed is a number from 0 to {len(roads) - 1}")
    shown = roads[road]
    if ax is None:
        _, ax = plt.subplots(layout="constrained", figsize=(9, 4))

    def of(column: str) -> Any:  # noqa: ANN401 (an array of numbers)
        return KMH_PER_MPS * np.array(shown[column], dtype=float)

    km = np.array(shown["position_m"], dtype=float) / 1000.0
    ax.fill_between(
        km,
        of("p5_mps"),
        of("p95_mps"),
        color=BLUE,
        alpha=0.2,
        linewidth=0,
        label="90 % of the trips",
    )
    ax.fill_between(
        km, of("p25_mps"), of("p75_mps"), color=BLUE, alpha=0.4, linewidth=0, label="half of them"
    )
    ax.plot(km, of("p50_mps"), color=BLUE, linewidth=1.2, label="median")
    ax.plot(km, of("limit_mps"), color=GREY, linewidth=1.2, linestyle="--", label="speed limit")
    for k, (_, speeds) in enumerate(shown["measured_mps"]):
        measured = KMH_PER_MPS * np.array(speeds, dtype=float)
        ax.plot(km, measured, color=RED, linewidth=1.0, label="measured" if k == 0 else None)
    ax.set(xlabel="position, km", ylabel="speed, km/h", title=shown["name"])
    ax.set_ylim(bottom=0)
    ax.margins(x=0)
    ax.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return spine_free(ax)
