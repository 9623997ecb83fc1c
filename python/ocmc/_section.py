"""The tables of a study: values as attributes and by their names."""

from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from html import escape
from typing import Any


class Section(Mapping[str, Any]):
    """A table of a study. Its values are attributes, and items: ``study.vehicle["drag_area_m2"]``.

    It does not change; `Study.set` makes another study.

    Parameters
    ----------
    content : dict
        The table.
    path : str
        Its path in the study.
    """

    __slots__ = ("_content", "_path")

    def __init__(self, content: dict[str, Any], path: str) -> None:
        object.__setattr__(self, "_content", content)
        object.__setattr__(self, "_path", path)

    def __getitem__(self, name: str) -> Any:  # noqa: ANN401 (whatever a key holds)
        if name not in self._content:
            raise KeyError(f"{self._path}.{name}{_near(name, self._content)}")
        return section(self._content[name], f"{self._path}.{name}")

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401 (whatever a key holds)
        if name.startswith("_") or name not in self._content:
            raise AttributeError(f"`{self._path}` has no {name!r}{_near(name, self._content)}")
        return self[name]

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(
            f"a study does not change; study.set({f'{self._path}.{name}'!r}, {value!r}) makes "
            "another one"
        )

    def __iter__(self) -> Iterator[str]:
        return iter(self._content)

    def __len__(self) -> int:
        return len(self._content)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._content]

    def __repr__(self) -> str:
        return f"<{self._path} of a study: {', '.join(self._content)}>"

    def __reduce__(self) -> tuple[type["Section"], tuple[dict[str, Any], str]]:
        return Section, (self._content, self._path)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._content)

    def _repr_html_(self) -> str:
        return f"<b>{escape(self._path)}</b>{rows(self._content)}"


def section(value: Any, path: str) -> Any:  # noqa: ANN401 (whatever a key holds)
    """Make a table one with attributes; a law, which is one value, stays a dictionary."""
    return (
        Section(value, path) if isinstance(value, dict) and "distribution" not in value else value
    )


def at(content: dict[str, Any], path: str) -> Any:  # noqa: ANN401 (whatever a key holds)
    """Find the value at a dotted path.

    Raises
    ------
    KeyError
        Where there is none.
    """
    here: Any = content
    for name in path.split("."):
        if not isinstance(here, dict) or name not in here:
            known = here if isinstance(here, dict) else {}
            raise KeyError(f"a study has no {path!r}{_near(name, known)}")
        here = here[name]
    return section(here, path)


def paths(content: dict[str, Any], above: str = "") -> list[str]:
    """List the dotted paths of all tables and values."""
    found = []
    for name, value in content.items():
        path = f"{above}{name}"
        found.append(path)
        if isinstance(value, dict) and "distribution" not in value:
            found.extend(paths(value, f"{path}."))
    return found


def rows(content: dict[str, Any]) -> str:
    """Make a table of all values below, with their paths, for a notebook."""
    lines = []
    for path in paths(content):
        value: Any = content
        for name in path.split("."):
            value = value[name]
        if not isinstance(value, dict) or "distribution" in value:
            cells = (
                f'<td style="text-align:left">{escape(text)}</td>' for text in (path, _shown(value))
            )
            lines.append(f"<tr>{''.join(cells)}</tr>")
    return f"<table><tbody>{''.join(lines)}</tbody></table>"


_LONGEST = 120  # of a value, in characters


def _shown(value: Any) -> str:  # noqa: ANN401 (whatever a key holds)
    if isinstance(value, dict) and "distribution" in value:
        numbers = ", ".join(
            f"{name} {_shown(part)}" for name, part in value.items() if name != "distribution"
        )
        text = f"{value['distribution']} ({numbers})"
    else:
        text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"


def _near(name: str, known: Mapping[str, Any]) -> str:
    near = get_close_matches(name, list(known), n=1)
    return f"; did you mean {near[0]!r}?" if near else ""
