"""Curve speed against radius, with the fitted law."""

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from ocmc.plot._axis import (
    BLUE,
    COLOURS,
    GREY,
    KMH_PER_MPS,
    RED,
    axes,
    has,
    numbers,
    spine_free,
    words,
)

_NORMAL_95 = 1.959964  # of a standard normal, 95 % lie within
_MOST_LARGE = 500  # points that are drawn as large symbols

_DECADE = 10.0

_Numbers = npt.NDArray[np.float64]


def curve_fit(
    curves: Any,  # noqa: ANN401 (any table)
    fit: Mapping[str, Any],
    *,
    ax: Axes | None = None,
) -> Axes:
    """Draw speed against radius of measured curves, with the fitted law and its bands.

    Parameters
    ----------
    curves : table
        The curves: ``radius_m``, ``speed_mps``, and where known ``driver`` and ``direction`` (left,
        right).
    fit : dict
        What `fit_curve_speed` or ``ocmc fit curve-speed --json`` gives for them.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes: radius in m, on a logarithmic scale, and speed in km/h. The inner band holds 95 %
        of the drivers' own medians, the outer one 95 % of the curves.

    Notes
    -----
    The law is v = v₀ (R/R₀)^δ exp(driver + residual), both normal: Romano, Godio, Bruzelius,
    Johannesson, equation of the curve speed.

    Examples
    --------
    >>> import ocmc
    >>> curves = {"driver": ["a"] * 4 + ["b"] * 4 + ["c"] * 4}
    >>> curves["radius_m"] = [50.0, 100.0, 200.0, 400.0] * 3
    >>> speeds = [10.1, 13.9, 20.2, 27.8, 11.1, 15.3, 22.1, 30.6, 9.6, 13.5, 19.0, 27.2]
    >>> curves["speed_mps"] = speeds
    >>> ax = ocmc.plot.curve_fit(curves, ocmc.fit_curve_speed(curves))
    >>> ax.get_xlabel()
    'curve radius, m'
    """
    ax = axes(ax, legend_beside=True)
    radius_m, speed_kmh = numbers(curves, "radius_m"), KMH_PER_MPS * numbers(curves, "speed_mps")
    _points(ax, curves, radius_m, speed_kmh)
    smallest_m, largest_m = fit["radius_range_m"]
    along_m = np.geomspace(smallest_m, largest_m, 100)
    estimated, fixed = fit["estimated"], fit["fixed"]
    reference_m = fit["reference_radius_m"]

    def law(model: Mapping[str, Any]) -> _Numbers:
        speed = (
            KMH_PER_MPS
            * model["reference_speed_mps"]
            * (along_m / reference_m) ** model["exponent"]
        )
        return np.asarray(speed)

    driver_sd, residual_sd = estimated["driver_sd"] or 0.0, estimated["residual_sd"]
    bands = [
        (np.hypot(driver_sd, residual_sd), 0.12, "95 % of the curves"),
        (driver_sd, 0.25, "95 % of the drivers"),
    ]
    for sd, alpha, name in bands:
        factor = np.exp(_NORMAL_95 * sd)
        middle = law(estimated)
        ax.fill_between(
            along_m,
            middle / factor,
            middle * factor,
            color=BLUE,
            alpha=alpha,
            linewidth=0,
            label=name,
        )
    label = (
        f"$v_0$ {KMH_PER_MPS * estimated['reference_speed_mps']:.1f} km/h, δ "
        f"{estimated['exponent']:.3f}"
    )
    interval = estimated.get("exponent_ci95")
    if interval is not None:
        label += f" ({interval[0]:.3f}; {interval[1]:.3f})"
    ax.plot(along_m, law(estimated), color=BLUE, linewidth=2, label=label)
    label = (
        f"$v_0$ {KMH_PER_MPS * fixed['reference_speed_mps']:.1f} km/h, δ {fixed['exponent']:g} "
        "(fixed)"
    )
    ax.plot(along_m, law(fixed), color=RED, linestyle="--", linewidth=1.5, label=label)
    ax.set(xscale="log", xlabel="curve radius, m", ylabel="speed in the curve, km/h")
    ax.set_ylim(bottom=0)
    _round_ticks(ax, along_m)
    ax.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return spine_free(ax)


def curve_fit_by_driver(
    curves: Any,  # noqa: ANN401 (any table)
    fit: Mapping[str, Any],
    *,
    ax: Sequence[Axes] | None = None,
) -> list[Axes]:
    """Draw speed against radius of measured curves, a panel for each driver or truck.

    Each has its own regression.

    Parameters
    ----------
    curves : table
        The curves: ``driver``, ``radius_m``, ``speed_mps``, and where known ``direction`` (left,
        right).
    fit : dict
        What `fit_curve_speed` or ``ocmc fit curve-speed --json`` gives for them.
    ax : sequence of matplotlib.axes.Axes, optional
        Where to draw, one for each driver; new axes by default, up to five beside one another.

    Returns
    -------
    list of matplotlib.axes.Axes
        The axes, in the order of the drivers' names: radius in m, logarithmic, and speed in km/h.
        The line is the least-squares regression of log v on log R over this driver's curves;
        dashed, the law fitted to all. A driver whose curves have one radius has no line.

    Raises
    ------
    KeyError
        Where no curve has a driver.
    ValueError
        Where there are not as many axes as drivers.

    Notes
    -----
    The picture is figure 9 of Romano, Godio, Bruzelius, Johannesson.

    Examples
    --------
    >>> import ocmc
    >>> curves = {"driver": ["a"] * 4 + ["b"] * 4 + ["c"] * 4}
    >>> curves["radius_m"] = [50.0, 100.0, 200.0, 400.0] * 3
    >>> speeds = [10.1, 13.9, 20.2, 27.8, 11.1, 15.3, 22.1, 30.6, 9.6, 13.5, 19.0, 27.2]
    >>> curves["speed_mps"] = speeds
    >>> panels = ocmc.plot.curve_fit_by_driver(curves, ocmc.fit_curve_speed(curves))
    >>> [panel.get_title(loc="left") for panel in panels]
    ['a: $v_0$ 79.8 km/h, δ 0.492', 'b: $v_0$ 87.7 km/h, δ 0.492', 'c: $v_0$ 77.0 km/h, δ 0.500']
    """
    drivers = words(curves, "driver")
    names = sorted(set(drivers), key=lambda name: (len(name), name))
    radius_m, speed_kmh = numbers(curves, "radius_m"), KMH_PER_MPS * numbers(curves, "speed_mps")
    left = words(curves, "direction") == "left" if has(curves, "direction") else None
    panels = _grid(len(names)) if ax is None else list(ax)
    if len(panels) != len(names):
        raise ValueError(f"`ax` has {len(panels)} axes, the drivers need {len(names)}")
    reference_m, estimated = fit["reference_radius_m"], fit["estimated"]
    smallest_m, largest_m = fit["radius_range_m"]
    along_m = np.geomspace(smallest_m, largest_m, 50)
    pooled = (
        KMH_PER_MPS
        * estimated["reference_speed_mps"]
        * (along_m / reference_m) ** estimated["exponent"]
    )
    for panel, name in zip(panels, names, strict=True):
        own = drivers == name
        title = str(name)
        for marker, side in [("o", False), ("+", True)]:
            part = own & (not side if left is None else left == side)
            panel.plot(
                radius_m[part],
                speed_kmh[part],
                marker,
                color=GREY,
                markerfacecolor="none",
                markersize=3,
                alpha=0.6,
            )
        panel.plot(along_m, pooled, color=RED, linestyle="--", linewidth=1.2)
        x, y = np.log(radius_m[own] / reference_m), np.log(speed_kmh[own])
        if np.ptp(x) > 0.0:
            exponent, middle = np.polyfit(x, y, 1)
            span_m = np.geomspace(radius_m[own].min(), radius_m[own].max(), 50)
            panel.plot(
                span_m, np.exp(middle) * (span_m / reference_m) ** exponent, color=BLUE, linewidth=2
            )
            title += f": $v_0$ {np.exp(middle):.1f} km/h, δ {exponent:.3f}"
        panel.set_title(title, fontsize="small", loc="left")
        panel.set(xscale="log", ylim=(0, None))
        _round_ticks(panel, along_m)
        spine_free(panel)
    for panel in panels:
        grid = panel.get_subplotspec()
        if grid is None or grid.is_last_row():
            panel.set_xlabel("curve radius, m")
        if grid is None or grid.is_first_col():
            panel.set_ylabel("speed, km/h")
    return panels


_COLUMNS = 5


def _grid(n: int) -> list[Axes]:
    columns = min(n, _COLUMNS)
    rows = -(-n // columns)
    figure, grid = plt.subplots(
        rows,
        columns,
        sharex=True,
        sharey=True,
        squeeze=False,
        layout="constrained",
        figsize=(3 * columns, 2.4 * rows),
    )
    panels = list(np.ravel(grid))
    for panel in panels[n:]:
        figure.delaxes(panel)
    return panels[:n]


def _points(ax: Axes, curves: Any, radius_m: _Numbers, speed_kmh: _Numbers) -> None:  # noqa: ANN401
    drivers = words(curves, "driver") if has(curves, "driver") else np.full(radius_m.shape, "")
    left = words(curves, "direction") == "left" if has(curves, "direction") else None
    names = sorted(set(drivers), key=lambda name: (len(name), name))
    coloured = 1 < len(names) <= len(COLOURS)
    few = radius_m.size <= _MOST_LARGE
    size, alpha = (5.5, 0.9) if few else (1.5, 0.3)
    for k, name in enumerate(names):
        colour = COLOURS[k] if coloured else GREY
        for marker, side in [("o", False), ("+", True)]:
            part = (drivers == name) & (not side if left is None else left == side)
            ax.plot(
                radius_m[part],
                speed_kmh[part],
                marker,
                color=colour,
                markerfacecolor="none" if few else colour,
                markersize=size,
                alpha=alpha,
                rasterized=not few,
                zorder=3 if few else 1,
                label=name if coloured and not side else None,
            )
    if left is not None and few:
        ax.set_title("+ left   o right", fontsize="medium", loc="left")


def _round_ticks(ax: Axes, along_m: _Numbers) -> None:
    low, high = along_m[0] / 1.02, along_m[-1] * 1.02
    leading = (1, 2, 5) if high > _DECADE * low else (1, 1.25, 1.5, 2, 2.5, 3, 4, 5, 7)
    ticks = [power * x for power in (1, 10, 100, 1000) for x in leading if low <= power * x <= high]
    ax.set_xticks(ticks, labels=[f"{tick:g}" for tick in ticks])
    ax.minorticks_off()
