"""Display of studies and tables in notebooks."""

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING, Any

from ocmc._section import rows

if TYPE_CHECKING:
    from ocmc import Study, Table

_ROWS = 5


def html_table(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """Make a table; the first column is on the left.

    Parameters
    ----------
    head : sequence of str
        Names of the columns.
    rows : sequence of sequence
        Cells.

    Returns
    -------
    str
        HTML.
    """

    def row(cells: Sequence[Any], tag: str) -> str:
        aligned = ("left" if k == 0 else "right" for k in range(len(cells)))
        parts = (
            f'<{tag} style="text-align:{side}">{escape(str(cell))}</{tag}>'
            for side, cell in zip(aligned, cells, strict=True)
        )
        return f"<tr>{''.join(parts)}</tr>"

    body = "".join(row(cells, "td") for cells in rows)
    return f"<table><thead>{row(head, 'th')}</thead><tbody>{body}</tbody></table>"


def study(study: "Study") -> str:
    """Show what a study is: its name, its description, and its values, table by table."""
    content = study.to_dict()
    about = content["study"]
    tables = (
        f"<details><summary><code>{escape(name)}</code> {escape(_first_keys(table))}</summary>"
        f"{rows(table)}</details>"
        for name, table in content.items()
        if name != "study"
    )
    return (
        f"<b>{escape(about['name'])}</b> "
        f"<code>{study.hash[:8]}</code><br>{escape(about['description'])}"
        f"{''.join(tables)}"
    )


_SHOWN_KEYS = 4


def _first_keys(table: dict[str, Any]) -> str:
    more = ", …" if len(table) > _SHOWN_KEYS else ""
    return f"{', '.join(list(table)[:_SHOWN_KEYS])}{more}"


def table(table: "Table") -> str:
    """Show the first and the last rows."""
    arrays = table.to_dict()
    n = len(table)
    places = list(range(n)) if n <= 2 * _ROWS else [*range(_ROWS), *range(n - _ROWS, n)]
    rows = [[k, *(_cell(values[k]) for values in arrays.values())] for k in places]
    if n > len(places):
        rows.insert(_ROWS, ["…"] * (1 + len(arrays)))
    return f"{html_table(['', *arrays], rows)}{n:,} rows, {len(arrays)} columns"


def _cell(value: Any) -> str:  # noqa: ANN401 (whatever a column holds)
    return f"{value:.6g}" if isinstance(value, float) else str(value)
