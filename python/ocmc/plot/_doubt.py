"""Contribution of judged numbers to an answer's uncertainty."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ocmc.plot._axis import BLUE, SKY, axes, ink, quantity, spine_free


def doubt(answer: Mapping[str, Any], *, most: int = 15, ax: Axes | None = None) -> Axes:
    """Draw what the plausible ranges of judged numbers do to the mean: a tornado.

    Parameters
    ----------
    answer : dict
        What `Study.doubt` or ``ocmc doubt --json`` gives.
    most : int
        Entries to draw, those with the largest effects.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes: a pair of bars for each entry, from the unmoved mean to both ends of its range,
        the one that matters most on top.

    Examples
    --------
    >>> import ocmc
    >>> low, high = ({"mean": {"by": by, "standard_error": 0.1}} for by in (-3.0, 2.5))
    >>> payload = {"name": "payload", "low": low, "high": high, "share": 1.0}
    >>> answer = {"column": "consumption_l_per_100km", "numbers": [payload]}
    >>> ocmc.plot.doubt(answer).get_xlabel()
    'change of the mean consumption, L/100 km'
    """
    ax = axes(ax)
    name, factor = quantity(answer["column"])
    numbers = answer["numbers"][:most][::-1]
    places = np.arange(len(numbers), dtype=float)
    for key, colour, what in [("low", SKY, "first end of the range"), ("high", BLUE, "other end")]:
        changes = [
            np.nan if entry[key] is None else factor * entry[key]["mean"]["by"] for entry in numbers
        ]
        ax.barh(places, changes, height=0.7, color=colour, label=what)
    ax.axvline(0.0, color=ink(), linewidth=0.6)
    ax.set_yticks(places, labels=[entry["name"].replace("_", " ") for entry in numbers])
    ax.set_xlabel(f"change of the mean {name}")
    ax.legend(frameon=False, loc="lower right")
    return spine_free(ax)
