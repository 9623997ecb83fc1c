"""Common parts of the pictures: colours, labels with units, and the columns of any table."""

import os
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from ocmc._ocmc import label

# Okabe and Ito's colours, which people with any kind of colour vision can distinguish
BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
PURPLE, SKY, YELLOW = "#CC79A7", "#56B4E9", "#F0E442"
COLOURS = (BLUE, RED, GREEN, ORANGE, PURPLE, SKY, "#999999", YELLOW)
GREY = "0.55"
KMH_PER_MPS = 3.6

_UNITS = {
    "mps2": "m/s²",
    "mps": "m/s",
    "kg": "kg",
    "j": "J",
    "s": "s",
    "m": "m",
    "k": "K",
    "m2": "m²",
    "rad": "rad",
}


def axes(ax: Axes | None, *, legend_beside: bool = False) -> Axes:
    """Take the axes that were given, or new ones."""
    size = (8.5, 4.5) if legend_beside else (6.4, 4.5)
    return plt.subplots(layout="constrained", figsize=size)[1] if ax is None else ax


def ink() -> str:
    """Colour of lines that belong to the axes: dark on a light style, light on a dark one."""
    return str(plt.rcParams["axes.edgecolor"])


def panels(ax: Sequence[Axes] | None, n: int, what: str, **new: Any) -> list[Axes]:  # noqa: ANN401
    """Take the axes that were given, or new ones, one above the other."""
    given = plt.subplots(n, sharex=True, layout="constrained", **new)[1] if ax is None else ax
    all_axes = list(np.ravel(np.asarray(given, dtype=object)))
    if len(all_axes) != n:
        raise ValueError(f"`ax` has {len(all_axes)} axes, {what} {n}")
    return all_axes


def quantity(column: str) -> tuple[str, float]:
    """How a column of the records is labelled, and the factor to the label's unit."""
    name, factor = label(column)
    if column.startswith("consumption_"):
        return f"consumption, {name}", factor
    if name != column:
        return name, factor
    words, _, unit = column.rpartition("_")
    return (
        (f"{words.replace('_', ' ')}, {_UNITS[unit]}", 1.0)
        if unit in _UNITS
        else (column.replace("_", " "), 1.0)
    )


def numbers(
    table: Any,  # noqa: ANN401 (tables of any library)
    column: str,
) -> npt.NDArray[np.float64]:
    """One column of a table of ours, a data frame or a dictionary."""
    if isinstance(table, str | os.PathLike):
        raise TypeError(f"`{table}` is a path: read the table first, with pandas or pyarrow")
    return np.asarray(table[column], dtype=np.float64)


def words(table: Any, column: str) -> npt.NDArray[np.str_]:  # noqa: ANN401 (tables of any library)
    """One column of words."""
    return np.asarray(table[column]).astype(np.str_)


def has(table: Any, column: str) -> bool:  # noqa: ANN401 (tables of any library)
    """Whether a table has the column: ours, pyarrow's, a data frame or a dictionary."""
    names = table if isinstance(table, Mapping) else getattr(table, "column_names", None)
    return column in (table.columns if names is None else names)


def spine_free(ax: Axes) -> Axes:
    """Leave away what frames nothing, and give the axes back."""
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def interval_text(mean: float, interval: Sequence[float]) -> str:
    """Write a mean with half its interval."""
    return f"{mean:.4g} ± {(interval[1] - interval[0]) / 2:.2g}"
