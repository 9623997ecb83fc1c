"""How far battery trucks come."""

from collections.abc import Mapping
from typing import Any

from matplotlib.axes import Axes

from ocmc.plot._axis import axes, ink, spine_free

MARKED = 0.95  # share of the trucks whose range is marked


def arrivals(answer: Mapping[str, Any], *, ax: Axes | None = None) -> Axes:
    """Draw the share of the trucks that arrive over the length of the trip.

    Parameters
    ----------
    answer : dict
        What `Study.range` or ``ocmc range --json`` gives.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes: the share with its band of 95 %, and a mark where 95 % arrive.

    Examples
    --------
    >>> import ocmc
    >>> curve = [{"distance_m": 0.0, "share": 1.0, "ci95": [0.9, 1.0]}]
    >>> answer = {"source": "mine", "curve": curve, "arriving": []}
    >>> ocmc.plot.arrivals(answer).get_xlabel()
    'length of the trip, km'
    """
    ax = axes(ax)
    points = answer["curve"]
    km = [point["distance_m"] / 1000.0 for point in points]
    percent = [100.0 * point["share"] for point in points]
    bands = [point["ci95"] for point in points]
    low, high = ([100.0 * band[end] for band in bands] for end in (0, 1))
    ax.fill_between(km, low, high, alpha=0.25, linewidth=0.0)
    ax.plot(km, percent, label=answer["source"])
    for arriving in answer["arriving"]:
        if arriving["share"] == MARKED and arriving["range_m"] is not None:
            at_km = arriving["range_m"] / 1000.0
            ax.plot(
                [0.0, at_km, at_km],
                [100.0 * MARKED, 100.0 * MARKED, 0.0],
                color=ink(),
                linewidth=0.6,
            )
            text = f"{100.0 * MARKED:.0f} %: {at_km:.0f} km"
            ax.annotate(text, (at_km, 50.0), xytext=(-4, 0), textcoords="offset points", ha="right")
    ax.set(xlabel="length of the trip, km", ylabel="trucks that arrive, %")
    ax.set(xlim=(0.0, None), ylim=(0.0, 104.0))
    return spine_free(ax)
