"""Cost of a km."""

from collections.abc import Mapping
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes

from ocmc.plot._axis import axes, ink, spine_free


def cost(answer: Mapping[str, Any], *, ax: Axes | None = None) -> Axes:
    """Draw the items of the cost over a km, at the centres of the prices.

    Parameters
    ----------
    answer : dict
        What `Study.cost` or ``ocmc cost --json`` gives, of one study or of two.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes: a bar for each study, of its items one after the other. What is negative, such as
        the residual value, lies to the left of zero, and a line marks the total.

    Examples
    --------
    >>> import ocmc
    >>> items = [{"item": "fuel", "per_km": 0.4}, {"item": "driver", "per_km": 0.5}]
    >>> answer = {"study": "mine", "currency": "EUR", "items": items, "total": {"per_km": 0.9}}
    >>> ocmc.plot.cost(answer).get_xlabel()
    'cost, EUR/km'
    """
    ax = axes(ax)
    studies = [answer[side] for side in ("a", "b")] if "difference" in answer else [answer]
    names = list(dict.fromkeys(item["item"] for study in studies for item in study["items"]))
    places = np.arange(len(studies), dtype=float)[::-1]
    left, right = np.zeros(len(studies)), np.zeros(len(studies))
    colours = mpl.colormaps["tab20"]
    for number, name in enumerate(names):
        costs = [{item["item"]: item["per_km"] for item in study["items"]} for study in studies]
        values = np.array([known.get(name, 0.0) for known in costs])
        start = np.where(values < 0.0, left, right)
        ax.barh(
            places,
            values,
            left=start,
            height=0.6,
            color=colours(number % 20),
            label=name.replace("_", " "),
        )
        left += np.minimum(values, 0.0)
        right += np.maximum(values, 0.0)
    for place, study in zip(places, studies, strict=True):
        ax.plot(
            [study["total"]["per_km"]] * 2, [place - 0.36, place + 0.36], color=ink(), linewidth=1.5
        )
    ax.axvline(0.0, color=ink(), linewidth=0.6)
    ax.set_yticks(places, labels=[study["study"] for study in studies])
    ax.set_xlabel(f"cost, {studies[0]['currency']}/km")
    ax.legend(frameon=False, ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.2))
    return spine_free(ax)
