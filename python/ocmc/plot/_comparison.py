"""Two studies beside each other."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from ocmc.plot._axis import BLUE, RED, axes, quantity, spine_free
from ocmc.plot._consumption import bins, completed, consumption_column

if TYPE_CHECKING:
    from ocmc import Run

_TAIL = 0.002


def comparison(a: "Run", b: "Run", *, column: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw the distributions of two runs over each other, with the means of their cycles.

    Parameters
    ----------
    a, b : Run
        Two runs. Only completed cycles count.
    column : str, optional
        A column of the records; by default the consumption that the first run has.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; new ones by default.

    Returns
    -------
    matplotlib.axes.Axes
        Those axes: shares of each run's cycles, a dashed line at the mean of each.

    Raises
    ------
    ValueError
        Where no completed cycle of one of them has the quantity.

    Examples
    --------
    >>> import ocmc
    >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
    >>> loaded = study.set("study.name", "loaded").set("mission.payload_kg", 20000.0)
    >>> ax = ocmc.plot.comparison(study.run(cycles=100), loaded.run(cycles=100))
    >>> len(ax.get_legend().get_texts())
    2
    """
    column = consumption_column(a) if column is None else column
    samples = [completed(run, column) for run in (a, b)]
    ax = axes(ax)
    low, high = np.quantile(np.concatenate(samples), [_TAIL, 1.0 - _TAIL])
    n = min(bins(sample) for sample in samples)
    edges = np.linspace(low, high, n + 1).tolist() if high > low else n
    for run, sample, colour in zip((a, b), samples, (BLUE, RED), strict=True):
        shares = np.full(sample.size, 100.0 / sample.size)
        mean = sample.mean()
        spread = f" ± {sample.std(ddof=1):.2g} (mean ± SD of the cycles)" if sample.size > 1 else ""
        label = f"{run.summary()['study']}: {mean:.4g}{spread}"
        ax.hist(sample, bins=edges, weights=shares, color=colour, alpha=0.25)
        ax.hist(sample, bins=edges, weights=shares, color=colour, histtype="step", linewidth=1.2, label=label)
        ax.axvline(mean, color=colour, linestyle="--", linewidth=1.0)
    ax.set(xlabel=quantity(column)[0], ylabel="share of the cycles, %")
    ax.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return spine_free(ax)
