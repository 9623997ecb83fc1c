"""Progress: on a terminal, in a notebook, by a callable, and nothing where nobody looks."""

import io
import subprocess
import sys
import types

import pytest
from ocmc import _progress


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    monkeypatch.setattr(_progress, "_QUIET_S", 0.0)


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_callable_is_called(study):
    calls = []
    study.run(cycles=3000, progress=lambda done, total: calls.append((done, total)))
    assert calls[-1] == (3000, 3000)
    assert [done for done, _ in calls] == sorted(done for done, _ in calls)
    assert {total for _, total in calls} == {3000}


def test_what_a_callable_raises_ends_the_run(study):
    class EnoughError(Exception):
        pass

    def stop(done, total):
        raise EnoughError(f"{done} of {total}")

    with pytest.raises(EnoughError):
        study.run(cycles=10**9, progress=stop)


@pytest.mark.parametrize("progress", [None, True])
def test_a_terminal_has_a_bar_which_goes(study, monkeypatch, progress):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    study.run(cycles=24_000, threads=1, progress=progress)
    printed = terminal.getvalue()
    assert "of 24,000 cycles, " in printed
    assert " left" in printed
    assert printed.endswith(" \r")


def test_a_bar_says_what_it_counts(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    bar = _progress.progress(None, 8, "events")
    bar.reach(3)
    assert "3 of 8 events, " in terminal.getvalue()
    bar.finish(8)
    assert terminal.getvalue().endswith(" \r")


def test_nothing_is_told_where_nobody_looks(study, capsys):
    study.run(cycles=2000)
    study.run(cycles=2000, progress=False)
    assert capsys.readouterr() == ("", "")
    study.run(cycles=24_000, threads=1, progress=True)
    assert "cycles" in capsys.readouterr().err


def test_a_short_run_has_no_bar(study, monkeypatch, capsys):
    monkeypatch.setattr(_progress, "_QUIET_S", 1e9)
    study.run(cycles=3000, progress=True)
    assert capsys.readouterr() == ("", "")


def test_a_notebook_has_a_bar_which_goes(study, monkeypatch, capsys):
    shown = []

    class Handle:
        def update(self, html):
            shown.append(html)

    def display(html, *, display_id):
        assert display_id
        shown.append(html)
        return Handle()

    notebook = types.ModuleType("IPython")
    notebook.get_ipython = lambda: types.SimpleNamespace(kernel=object())
    parts = types.ModuleType("IPython.display")
    parts.HTML, parts.display = str, display
    monkeypatch.setitem(sys.modules, "IPython", notebook)
    monkeypatch.setitem(sys.modules, "IPython.display", parts)
    study.run(cycles=24_000, threads=1)
    assert 'max="24000"' in shown[0]
    assert shown[-1] == ""
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("progress", ["yes", 1, object()])
def test_anything_else_is_a_type_error(study, progress):
    with pytest.raises(TypeError, match="`progress` is "):
        study.run(cycles=10, progress=progress)


def test_python_without_streams_can_run(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import sys, ocmc\n"
        "sys.stderr = None\n"
        "study = ocmc.Study('field-truck').set('mission.length_m', 2000)\n"
        "assert len(study.run(cycles=50)) == 50\n"
    )
    subprocess.run([sys.executable, script], check=True, timeout=60)
