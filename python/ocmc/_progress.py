"""Progress of a run: a line on a terminal, a bar in a notebook, a callable, or nothing."""

import sys
import time
from collections.abc import Callable
from typing import Any

_WIDTH = 30
_QUIET_S = 0.5  # a run that is over sooner shows no bar


def progress(
    asked: bool | Callable[[int, int], object] | None,  # noqa: FBT001
    total: int,
    what: str = "cycles",
) -> "Silent":
    """Choose what a run reports its progress to.

    Parameters
    ----------
    asked : bool or callable, optional
        True for a bar, False for none, None for one on a terminal and in a notebook; or what is to
        be called with the numbers that are done and that were asked for.
    total : int
        How many were asked for.
    what : str
        Of what.

    Returns
    -------
    Silent
        What `reach` and `finish` are called on.

    Raises
    ------
    TypeError
        Where it is none of these.
    """
    if callable(asked):
        return Callback(asked, total)
    if asked is not None and not isinstance(asked, bool):
        raise TypeError(f"`progress` is {asked!r}, allowed is True, False or a callable")
    if asked is False:
        return Silent()
    if _in_notebook():
        return Notebook(total, what)
    if asked or (sys.stderr is not None and sys.stderr.isatty()):
        return Terminal(total, what)
    return Silent()


def note(asked: bool | Callable[[int, int], object] | None, text: str) -> None:  # noqa: FBT001
    """Say something on standard error where a bar would be shown.

    Parameters
    ----------
    asked : bool or callable, optional
        As of `progress`.
    text : str
        What is said.
    """
    terminal = sys.stderr is not None and sys.stderr.isatty()
    if asked is True or (asked is None and (_in_notebook() or terminal)):
        sys.stderr.write(text + "\n")


class Silent:
    """Reports nothing."""

    def reach(self, done: int) -> None:
        """Go on to that number."""

    def finish(self, done: int) -> None:
        """End, after that number."""


class Callback(Silent):
    """Calls the user's own callable."""

    def __init__(self, call: Callable[[int, int], object], total: int) -> None:
        self._call = call
        self._total = total

    def reach(self, done: int) -> None:
        """Call it."""
        self._call(done, self._total)

    def finish(self, done: int) -> None:
        """Call it once more where the run came to its end."""
        if done == self._total:
            self._call(done, self._total)


class Bar(Silent):
    """Draws how far the run is, from half a second on."""

    def __init__(self, total: int, what: str) -> None:
        self._total = total
        self._what = what
        self._begin = time.monotonic()

    def reach(self, done: int) -> None:
        """Draw it anew."""
        elapsed = time.monotonic() - self._begin
        if elapsed >= _QUIET_S:
            self._draw(done, _status(done, self._total, self._what, elapsed))

    def _draw(self, done: int, status: str) -> None:
        raise NotImplementedError


class Terminal(Bar):
    """A line on the terminal, which goes when the run is over."""

    _shown = 0

    def finish(self, done: int) -> None:  # noqa: ARG002 (the same for all)
        """Wipe the line."""
        if self._shown:
            sys.stderr.write("\r" + " " * self._shown + "\r")
            sys.stderr.flush()

    def _draw(self, done: int, status: str) -> None:
        filled = _WIDTH * done // self._total
        text = f"[{'=' * filled}{' ' * (_WIDTH - filled)}] {status}"
        sys.stderr.write("\r" + text.ljust(self._shown))
        sys.stderr.flush()
        self._shown = len(text)


class Notebook(Bar):
    """A bar below the cell, which goes when the run is over."""

    _display: Any = None

    def finish(self, done: int) -> None:  # noqa: ARG002 (the same for all)
        """Take the bar away."""
        if self._display is not None:
            self._show("")

    def _draw(self, done: int, status: str) -> None:
        self._show(f'<progress max="{self._total}" value="{done}"></progress> {status}')

    def _show(self, html: str) -> None:
        from IPython.display import HTML, display  # noqa: PLC0415 (only a notebook has it)

        if self._display is None:
            self._display = display(HTML(html), display_id=True)
        else:
            self._display.update(HTML(html))


def _in_notebook() -> bool:
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return getattr(shell, "kernel", None) is not None


def _status(done: int, total: int, what: str, elapsed_s: float) -> str:
    digits = 0 if done > 10 * elapsed_s else 1
    left = _duration((total - done) * elapsed_s / done) if done else "-"
    return f"{done:,} of {total:,} {what}, {done / elapsed_s:,.{digits}f}/s, {left} left"


def _duration(seconds: float) -> str:
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"
