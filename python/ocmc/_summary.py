"""The summary of a run."""

from ocmc._answer import Answer
from ocmc._display import html_table
from ocmc._ocmc import label

_QUANTILES = ["p5", "p25", "p50", "p75", "p95", "p99"]


class Summary(Answer):
    """The summary of a run: the content of ``summary.json``, printed as the command prints it.

    Statistics are over completed cycles: the mean is the fleet's (total over total) with its 95 %
    interval, standard deviation and quantiles are per cycle.

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

    def _repr_html_(self) -> str:
        rows = []
        for column, statistic in self["statistics"].items():
            if statistic["p50"] is None:
                continue
            name, factor = label(column)
            low, high = statistic["ci95"] or (None, None)
            half_width = None if low is None or high is None else (high - low) / 2
            numbers = [
                statistic["mean"],
                half_width,
                *(statistic[key] for key in ["sd", *_QUANTILES]),
            ]
            rows.append([name, *("-" if x is None else f"{factor * x:.4g}" for x in numbers)])
        head = ["", "mean of the fleet", "± 95 %", "SD", *(name.upper() for name in _QUANTILES)]
        done, cycles = self["outcomes"]["completed"], self["cycles"]
        caption = f"{self['study']}, seed {self['seed']}: {done:,} of {cycles:,} cycles completed"
        return f"<b>{caption}</b>{html_table(head, rows)}"
