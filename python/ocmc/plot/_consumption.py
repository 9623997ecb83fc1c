"""The distribution of a quantity over the fleet."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from ocmc.plot._axis import BLUE, RED, axes, ink, interval_text, quantity, spine_free

if TYPE_CHECKING:
    from ocmc import Run

_COLUMNS = ["consumption_l_per_100km", "consumption_kwh_per_km", "wheel_kwh_per_km"]
_LEVELS = (5, 25, 50, 75, 95)
# of the axis, for the name of one quantile
_LABEL_WIDTH = 0.06


def completed(run: "Run", column: str) -> npt.NDArray[np.float64]:
    """Take the values of the completed cycles that have the quantity, in the unit of its label."""
    values: npt.NDArray[np.float64] = run[column][run["outcome"] == "completed"]
    values = quantity(column)[1] * values[np.isfinite(values)]
    if values.size == 0:
        raise ValueError(f"no completed cycle has `{column}`")
    return values


def consumption_column(run: "Run") -> str:
    """Choose the column to judge by: fuel, else electricity, else the work at the wheels."""
    statistics = run.summary()["statistics"]
    return next((name for name in _COLUMNS if statistics[name]["p50"] is not None), _COLUMNS[0])


def consumption(run: "Run", *, column: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw how the consumption of the cycles is distributed, with quantiles and the fleet's mean.

    Parameters
    ----------
    run : Run
        A run. Only completed cycles count.
    column : str, optional
        Another column of the records; by default litres per 100 km, or kWh/km where there is no
        fuel.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    ValueError
        Where no completed cycle has the quantity.

    Examples
    --------
    >>> import ocmc
    >>> run = ocmc.Study("field-truck").set("mission.length_m", 5000.0).run(cycles=100)
    >>> ocmc.plot.consumption(run, column="mean_speed_mps").get_xlabel()
    'speed, km/h'
    """
    column = consumption_column(run) if column is None else column
    name, factor = quantity(column)
    values = completed(run, column)
    ax = axes(ax)
    share = np.full(values.size, 100.0 / values.size)
    ax.hist(
        values,
        bins=bins(values),
        weights=share,
        color=BLUE,
        alpha=0.55,
        edgecolor="white",
        linewidth=0.4,
    )
    statistic: dict[str, Any] = run.summary()["statistics"].get(column, {})
    quantiles = {}
    for level in _LEVELS:
        value = statistic.get(f"p{level}")
        value = float(np.quantile(values, level / 100)) if value is None else factor * value
        quantiles[f"P{level}"] = value
        style = "-" if level == 50 else ":"  # noqa: PLR2004
        ax.axvline(value, color=ink(), linewidth=0.8, linestyle=style)
    low, high = ax.get_xlim()
    for name_of_level, place in _apart(quantiles, _LABEL_WIDTH * (high - low)):
        ax.annotate(
            name_of_level,
            (place, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 2),
            textcoords="offset points",
            ha="center",
            fontsize="small",
        )
    if statistic.get("mean") is not None and statistic.get("ci95") is not None:
        mean, interval = factor * statistic["mean"], [factor * end for end in statistic["ci95"]]
        ax.axvspan(*interval, color=RED, alpha=0.3, linewidth=0)
        ax.axvline(mean, color=RED, label=f"mean of the fleet {interval_text(mean, interval)}")
        # above the names of the quantiles
        ax.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.04))
    ax.set(xlabel=name, ylabel="share of the cycles, %")
    return spine_free(ax)


def _apart(quantiles: Mapping[str, float], width: float) -> list[tuple[str, float]]:
    """Name quantiles and their places; those that are nearer than a name is wide share one."""
    groups: list[list[tuple[str, float]]] = []
    for name, value in quantiles.items():
        if groups and value - groups[-1][-1][1] < width * len(groups[-1][:2]):
            groups[-1].append((name, value))
        else:
            groups.append([(name, value)])
    return [
        (
            group[0][0] if len(group) == 1 else f"{group[0][0]} to {group[-1][0]}",
            (group[0][1] + group[-1][1]) / 2.0,
        )
        for group in groups
    ]


def bins(values: npt.NDArray[np.float64]) -> int:
    """Count bins by Freedman and Diaconis, within reason."""
    return int(np.clip(len(np.histogram_bin_edges(values, "fd")) - 1, 8, 60))
