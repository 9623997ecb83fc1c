"""The time series of one cycle."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from ocmc.plot._axis import BLUE, GREEN, GREY, KMH_PER_MPS, ORANGE, RED, has, numbers, spine_free
from ocmc.plot._axis import panels as panels_of

if TYPE_CHECKING:
    from ocmc import OperatingCycle


def trace(
    trace: Any,  # noqa: ANN401 (a table of any library)
    *,
    cycle: "OperatingCycle | None" = None,
    against: Literal["position", "time"] = "position",
    between: tuple[float, float] | None = None,
    ax: Sequence[Axes] | None = None,
) -> list[Axes]:
    """Draw one cycle: speed against desired speed and limits, slope, pedals, gear, braking, charge.

    Parameters
    ----------
    trace : Table
        What `Study.trace` gives, or any table with these columns.
    cycle : OperatingCycle, optional
        What `Study.operating_cycle` gives for the same cycle: its speed limits are drawn, too.
    against : {"position", "time"}
        The horizontal axis, in km or min.
    between : tuple of float, optional
        The part to draw, from and to: in m for a position, in s for a time.
    ax : sequence of matplotlib.axes.Axes, optional
        Where to draw; new axes by default, one above the other. Four draw no braking and no charge.

    Returns
    -------
    list of matplotlib.axes.Axes
        The axes: speed, slope, pedals, gear and braking, and of a battery truck its charge. Braking
        is the power that the service brakes take, and the engine brake or retarder; of a battery
        truck what the motor brings back to the battery.

    Raises
    ------
    ValueError
        Where there are not as many axes, or where nothing lies in that part.

    Examples
    --------
    >>> import ocmc
    >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
    >>> panels = ocmc.plot.trace(study.trace(3), cycle=study.operating_cycle(3), between=(0, 2000))
    >>> [ax.get_ylabel() for ax in panels]
    ['speed, km/h', 'slope, %', 'pedals, %', 'gear', 'braking, kW']
    """
    if against not in ("position", "time"):
        raise ValueError(f"`against` is {against!r}, allowed is one of: position, time")
    along = numbers(trace, "position_m" if against == "position" else "time_s")
    part = np.full(along.shape, fill_value=True)
    if between is not None:
        part = (along >= between[0]) & (along <= between[1])
        if not part.any():
            raise ValueError(
                f"no step lies between {between[0]} and {between[1]}, the trace ends at "
                f"{along[-1]:.0f}"
            )
    x = along[part] / (1000.0 if against == "position" else 60.0)

    def of(column: str) -> npt.NDArray[np.float64]:
        values: npt.NDArray[np.float64] = numbers(trace, column)[part]
        return values

    heights = [3, 1, 1.3, 1.3]
    if ax is None or np.size(np.asarray(ax, dtype=object)) != len(heights):
        heights += [1.3, 1.3] if has(trace, "state_of_charge") else [1.3]
    size, ratios = (9.0, 1.5 + 0.83 * sum(heights)), {"height_ratios": heights}
    panels = panels_of(ax, len(heights), "a trace needs", figsize=size, gridspec_kw=ratios)
    if ax is None:
        panels[0].figure.align_ylabels()
    ink = panels[0].spines["bottom"].get_edgecolor()  # seen on light styles and on dark ones
    _speed(panels[0], x, of, cycle)
    panels[1].fill_between(x, 100.0 * of("grade"), step="pre", color=GREEN, alpha=0.5, linewidth=0)
    panels[1].axhline(0.0, color=ink, linewidth=0.6)
    panels[1].set_ylabel("slope, %")
    pedals = panels[2]
    pedals.fill_between(
        x, 100.0 * of("accelerator"), color=BLUE, alpha=0.7, linewidth=0, label="accelerator"
    )
    pedals.fill_between(x, -100.0 * of("brake"), color=RED, alpha=0.7, linewidth=0, label="brake")
    pedals.axhline(0.0, color=ink, linewidth=0.6)
    pedals.set(
        ylabel="pedals, %", ylim=(-105, 105), yticks=[-100, 0, 100], yticklabels=["100", "0", "100"]
    )
    pedals.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    panels[3].step(x, of("gear"), where="pre", color=ink, linewidth=1.0)
    panels[3].set_ylabel("gear")
    braking, charge = [*panels[4:], None, None][:2]
    if braking is not None:
        _braking(braking, x, of, electric=has(trace, "state_of_charge"))
    if charge is not None:
        charge.plot(x, 100.0 * of("state_of_charge"), color=GREEN, linewidth=1.4)
        charge.set_ylabel("charge, %")
    panels[-1].set_xlabel("position, km" if against == "position" else "time, min")
    for panel in panels:
        panel.margins(x=0)
        spine_free(panel)
    return panels


def _braking(
    ax: Axes,
    x: npt.NDArray[np.float64],
    of: Any,  # noqa: ANN401
    *,
    electric: bool,
) -> None:
    """Draw what brakes: the power of each, mean over the row, 0 where a row takes no time."""
    step = of("step_s")
    own = ("regenerated_energy_added_j", GREEN, "regenerated") if electric else None
    own = own or ("engine_brake_energy_added_j", ORANGE, "engine brake")
    for column, color, name in (("service_brake_energy_added_j", RED, "service brakes"), own):
        energy = of(column)
        power = np.divide(energy, step, out=np.zeros_like(energy), where=step > 0.0) / 1000.0
        ax.fill_between(x, power, step="pre", color=color, alpha=0.6, linewidth=0, label=name)
    ax.set(ylabel="braking, kW", ylim=(0, None))
    ax.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))


def _speed(
    ax: Axes,
    x: npt.NDArray[np.float64],
    of: Any,  # noqa: ANN401
    cycle: "OperatingCycle | None",
) -> None:
    if cycle is not None:
        limit = cycle["speed_limit_mps"]
        place = np.searchsorted(limit["position_m"], of("position_m"), side="right") - 1
        limits = KMH_PER_MPS * limit["value"][np.maximum(place, 0)]
        ax.plot(x, limits, color=GREY, linewidth=1.2, drawstyle="steps-pre", label="speed limit")
    ax.plot(
        x, KMH_PER_MPS * of("desired_speed_mps"), color=ORANGE, linewidth=1.2, label="desired speed"
    )
    ax.plot(x, KMH_PER_MPS * of("speed_mps"), color=BLUE, linewidth=1.2, label="speed")
    ax.set(ylabel="speed, km/h", ylim=(0, None))
    ax.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
