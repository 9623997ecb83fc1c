"""The summary of a run."""

from typing import Any


class Summary(dict[str, Any]):
    """What a run adds up to: the content of ``summary.json``, printed as the command prints it.

    Statistics are over completed cycles: the mean is the fleet's (total over total) with its 95 % interval,
    standard deviation and quantiles are per cycle.

    Parameters
    ----------
    content : dict
        The content of ``summary.json``.
    text : str
        The answer as text.

    Examples
    --------
    >>> import ocmc
    >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
    >>> summary = study.run(cycles=50).summary()
    >>> summary["statistics"]["mean_speed_mps"]["mean"] < 30.0
    True
    >>> print(summary)  # doctest: +ELLIPSIS
    study      field-truck
    ...
    """

    def __init__(self, content: dict[str, Any], text: str) -> None:
        super().__init__(content)
        self._text = text

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return self._text
