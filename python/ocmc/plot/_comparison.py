"""Two studies beside each other."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from ocmc.plot._axis import BLUE, RED, axes, interval_text, quantity, spine_free
from ocmc.plot._consumption import bins, completed, consumption_column

if TYPE_CHECKING:
    from ocmc import Run

_TAIL = 0.002


def comparison(
    a: "Run",
    b: "Run",
    *,
    column: str | None = None,
    names: Sequence[str] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the distributions of two runs over each other, with the means of their fleets.

    Parameters
    ----------
    a, b : Run
        Two runs. Only completed cycles count.
    column : str, optional
        A column of the records; by default the consumption that the first run has.
    names : sequence of str, optional
        What the two are called; by default by their studies, and as A and B where those have one
        name.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; new ones by default.

    Returns
    -------
    matplotlib.axes.Axes
        Those axes: shares of each run's cycles, a dashed line at the mean of each. It is that of
        the fleet with half its 95 % interval, or that of the cycles, without one, where the column
        is no quantity of the summary.

    Raises
    ------
    ValueError
        Where no completed cycle of one of them has the quantity, or where there are not two names.

    Examples
    --------
    >>> import ocmc
    >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
    >>> loaded = study.set("study.name", "loaded").set("mission.payload_kg", 20000.0)
    >>> ax = ocmc.plot.comparison(study.run(cycles=100), loaded.run(cycles=100))
    >>> [text.get_text().partition(":")[0] for text in ax.get_legend().get_texts()]
    ['field-truck', 'loaded']
    """
    column = consumption_column(a) if column is None else column
    samples = [completed(run, column) for run in (a, b)]
    ax = axes(ax)
    low, high = np.quantile(np.concatenate(samples), [_TAIL, 1.0 - _TAIL])
    n = min(bins(sample) for sample in samples)
    edges = np.linspace(low, high, n + 1).tolist() if high > low else n
    statistics = [run.summary()["statistics"].get(column) for run in (a, b)]
    called, colours = _names((a, b), names), (BLUE, RED)
    for sample, statistic, name, colour in zip(samples, statistics, called, colours, strict=True):
        shares = np.full(sample.size, 100.0 / sample.size)
        mean, text = _mean(sample, statistic, quantity(column)[1])
        label = f"{name}: {text}"
        ax.hist(sample, bins=edges, weights=shares, color=colour, alpha=0.25)
        ax.hist(
            sample,
            bins=edges,
            weights=shares,
            color=colour,
            histtype="step",
            linewidth=1.2,
            label=label,
        )
        ax.axvline(mean, color=colour, linestyle="--", linewidth=1.0)
    ax.set(xlabel=quantity(column)[0], ylabel="share of the cycles, %")
    title = (
        "mean of the fleet ± half its 95 % interval" if all(statistics) else "mean of the cycles"
    )
    ax.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), title=title)
    return spine_free(ax)


def _names(runs: Sequence["Run"], names: Sequence[str] | None) -> list[str]:
    if names is None:
        studies = [str(run.summary()["study"]) for run in runs]
        same = studies[0] == studies[1]
        return [
            f"{study} {side}" if same else study for study, side in zip(studies, "AB", strict=True)
        ]
    if isinstance(names, str) or len(names) != len(runs):
        raise ValueError(f"`names` is {names!r}, allowed are {len(runs)} names")
    return list(names)


def _mean(
    sample: npt.NDArray[np.float64], statistic: Mapping[str, Any] | None, factor: float
) -> tuple[float, str]:
    """Take the mean of the fleet where the summary has it, and write it with half its interval."""
    if statistic is None:
        return float(sample.mean()), f"{sample.mean():.4g}"
    mean = factor * statistic["mean"]
    if statistic["ci95"] is None:
        return mean, f"{mean:.4g}"
    return mean, interval_text(mean, [factor * end for end in statistic["ci95"]])
