"""Answers: dictionaries that print as the command's text."""

from html import escape
from typing import Any, Self


class Answer(dict[str, Any]):
    """Answer: a dictionary with the content of the command's JSON, printed as the command's text.

    Parameters
    ----------
    content : dict
        The content.
    text : str
        The text.

    Examples
    --------
    >>> import ocmc
    >>> answer = ocmc.Answer({"n": 48}, "48 curves")
    >>> answer["n"]
    48
    >>> print(answer)
    48 curves
    """

    def __init__(self, content: dict[str, Any], text: str) -> None:
        super().__init__(content)
        self._text = text

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return self._text

    def __reduce__(self) -> tuple[type[Self], tuple[dict[str, Any], str]]:
        return type(self), (dict(self), self._text)

    def _repr_html_(self) -> str:
        return f"<pre>{escape(self._text)}</pre>"
