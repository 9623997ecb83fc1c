"""Effect of values of a study's keys."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ocmc.plot._axis import COLOURS, ink, panels, quantity, spine_free

_LONGEST = 24


def sweep(answer: Mapping[str, Any], *, ax: Sequence[Axes] | None = None) -> list[Axes]:
    """Draw means over the values of a key, and below them the differences to the reference.

    Parameters
    ----------
    answer : dict
        What `Study.sweep` or ``ocmc sweep --json`` gives, of one key or of two.
    ax : sequence of matplotlib.axes.Axes, optional
        Two axes to draw into, one for the means and one for the differences; new ones by default.

    Returns
    -------
    list of matplotlib.axes.Axes
        The axes: means and differences with their 95 % intervals over the values of the first key,
        and a line for each value of the second. Words and laws stand side by side in the order of
        the points. A dashed line is the study itself, where the points are compared with it.

    Raises
    ------
    ValueError
        Where the answer has more than two keys, or `ax` not two axes.

    Examples
    --------
    >>> import ocmc
    >>> study = ocmc.Study("field-truck").set("mission.length_m", 3000.0)
    >>> answer = study.sweep({"vehicle.drag_area_m2.median": [5.5, 5.0, 4.5]}, cycles=10)
    >>> above, below = ocmc.plot.sweep(answer)
    >>> below.get_xlabel(), above.get_ylabel()
    ('vehicle.drag_area_m2.median', 'consumption, L/100 km')
    """
    keys, points = answer["keys"], answer["points"]
    if len(keys) > 2:  # noqa: PLR2004 (an axis and a colour)
        raise ValueError(f"the answer has {len(keys)} keys, a picture has one or two")
    both = panels(ax, 2, "a sweep has", figsize=(6.4, 6.4))
    name, factor = quantity(answer["column"])
    places = _places([point["values"][keys[0]] for point in points], both[1])
    groups: dict[str, list[int]] = {}
    for number, point in enumerate(points):
        groups.setdefault(_word(point["values"][keys[1]]) if keys[1:] else "", []).append(number)
    for number, (group, members) in enumerate(groups.items()):
        members.sort(key=lambda member: places[member])
        x = [places[member] for member in members]
        look: dict[str, Any] = {
            "color": COLOURS[number % len(COLOURS)],
            "marker": "o",
            "markersize": 4,
        }
        for axes, value, interval in [
            (both[0], "mean", "ci95"),
            (both[1], "difference", "difference_ci95"),
        ]:
            y = [_number(points[member][value], factor) for member in members]
            ends = np.array(
                [points[member][interval] or [np.nan] * 2 for member in members], dtype=float
            )
            axes.errorbar(
                x, y, yerr=np.abs(factor * ends.T - y), label=group or None, capsize=2, **look
            )
    if base := answer.get("base"):
        both[0].axhline(_number(base["mean"], factor), color=ink(), linewidth=0.8, linestyle="--")
    both[1].axhline(0.0, color=ink(), linewidth=0.6)
    both[0].set_ylabel(name)
    both[1].set_ylabel(f"difference, {name.rpartition(', ')[2]}")
    both[1].set_xlabel(keys[0])
    if keys[1:]:
        both[0].legend(title=keys[1], frameon=False)
    return [spine_free(axes) for axes in both]


def _places(values: Sequence[object], ax: Axes) -> list[float]:
    """Places of the values on the axis: the numbers, or a place for each word."""
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return [float(str(value)) for value in values]
    words = [_word(value) for value in values]
    known = list(dict.fromkeys(words))
    ax.set_xticks(range(len(known)), labels=known)
    return [float(known.index(word)) for word in words]


def _word(value: object) -> str:
    word = "as it is" if value is None else str(value)
    return word if len(word) <= _LONGEST else f"{word[:_LONGEST]}…"


def _number(value: float | None, factor: float) -> float:
    return np.nan if value is None else factor * value
