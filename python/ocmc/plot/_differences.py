"""How two studies differ, cycle by cycle."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from ocmc.plot._axis import BLUE, GREY, RED, axes, numbers, quantity, spine_free, words
from ocmc.plot._consumption import bins, consumption_column

if TYPE_CHECKING:
    from ocmc import Run

_TAIL = 0.002


def differences(a: "Run", b: "Run", *, column: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw the paired differences of two runs over the same cycles, pair by pair.

    Parameters
    ----------
    a, b : Run
        Two runs of the same seed and cycle ids, such as those that ``ocmc.compare(..., out=)``
        writes. Only cycles that both completed count.
    column : str, optional
        A column of the records; by default the consumption that the first run has.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; new ones by default.

    Returns
    -------
    matplotlib.axes.Axes
        Those axes: numbers of cycles over b less a, a dashed line at the mean of the pairs.

    Raises
    ------
    ValueError
        Where the runs are not of the same cycles, or no cycle has the quantity in both.

    Examples
    --------
    >>> import ocmc
    >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
    >>> loaded = study.set("mission.payload_kg", 20000.0)
    >>> ax = ocmc.plot.differences(study.run(cycles=100), loaded.run(cycles=100))
    >>> ax.get_ylabel()
    'cycles'
    """
    if a.seed != b.seed or not np.array_equal(a["cycle_id"], b["cycle_id"]):
        raise ValueError(
            "`a` and `b` are runs of other cycles: allowed are runs of the same seed and cycle ids"
        )
    column = consumption_column(a) if column is None else column
    name, factor = quantity(column)
    done = (words(a, "outcome") == "completed") & (words(b, "outcome") == "completed")
    change = factor * (numbers(b, column) - numbers(a, column))[done]
    change = change[np.isfinite(change)]
    if change.size == 0:
        raise ValueError(f"no cycle has `{column}` in both runs")
    ax = axes(ax)
    low, high = np.quantile(change, [_TAIL, 1.0 - _TAIL])
    edges = np.linspace(low, high, bins(change) + 1).tolist() if high > low else 1
    ax.hist(change, bins=edges, color=BLUE, alpha=0.75)
    mean = change.mean()
    lower = 100.0 * np.mean(change < 0.0)
    label = f"mean of the pairs {mean:+.3g}, lower in b in {lower:.0f} % of them"
    ax.axvline(0.0, color=GREY, linewidth=1.0)
    ax.axvline(mean, color=RED, linestyle="--", linewidth=1.2, label=label)
    ax.set(xlabel=f"b less a: {name}", ylabel="cycles")
    ax.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return spine_free(ax)
