"""Data frames of tables, by the libraries that are there, and the rows that pandas takes."""

from dataclasses import make_dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from ocmc import Table


def to_pandas(table: "Table") -> Any:  # noqa: ANN401 (pandas has no types)
    """Make a data frame of pandas: by way of Arrow where pyarrow is there, else of numpy's arrays.

    Raises
    ------
    ModuleNotFoundError
        Where pandas is not installed.
    """
    pd = _library("pandas")
    try:
        import pyarrow as pa  # type: ignore[import-untyped]  # noqa: PLC0415
    except ModuleNotFoundError:
        return pd.DataFrame(table.to_dict())
    return pa.table(table).to_pandas()


def to_polars(table: "Table") -> Any:  # noqa: ANN401 (not everybody has it)
    """Make a data frame of polars.

    Raises
    ------
    ModuleNotFoundError
        Where polars is not installed.
    """
    return _library("polars").DataFrame(table)


def _library(name: str) -> Any:  # noqa: ANN401 (not everybody has it)
    """Import a library where it is used, and name it where it is not there."""
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            f"to_{name} needs {name}: pip install {name}", name=name
        ) from error


def rows(
    table: "Table",
    dtype: Any,  # noqa: ANN401
    copy: bool | None,  # noqa: FBT001
) -> npt.NDArray[np.object_]:
    """Make an array of rows, objects with the columns as attributes; a missing word is None.

    Raises
    ------
    ValueError
        Where another type of cells is asked for, or no copy.
    """
    if dtype is not None and np.dtype(dtype) != np.object_:
        raise ValueError(f"rows are objects, not {np.dtype(dtype)}: take a column, or `to_dict`")
    if copy is False:
        raise ValueError("rows are made of columns, which is a copy")
    row = make_dataclass("Row", table.columns, frozen=True)
    columns = (
        [word or None for word in values.tolist()] if values.dtype.kind == "U" else values.tolist()
        for values in table.to_dict().values()
    )
    made = np.empty(len(table), dtype=object)
    made[:] = [row(*cells) for cells in zip(*columns, strict=True)]
    return made
