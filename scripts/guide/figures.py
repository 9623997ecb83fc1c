"""Figures that pages quote, against what the commands of ``docs/figures.toml`` print."""

import functools
import html
import re
import shlex
import shutil
import subprocess
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIST = ROOT / "docs" / "figures.toml"
# the files of the tutorial, which its commands name
EXPORT = ROOT / "docs" / "src" / "tutorial" / "export"

_NUMBER = r"[\u2212+-]?\d[\d,]*(?:\.\d+)?"
_UNIT = r"(?:L/100 km|kWh/km|EUR/km|km/h|kWh|kW|MW|%|ns|s|seconds|minutes|times)"
_FIGURE = re.compile(rf"{_NUMBER}(?: (?:±|to|and|of) {_NUMBER})* {_UNIT}(?![\w/])")
_BLOCK = re.compile(r"```text\n(.*?)```", re.DOTALL)
_STUDY = re.compile(r"```toml\n(# (\S+\.toml): .*?)```", re.DOTALL)


def faults(slow):
    """Return the number of commands that ran, and the faults as (page, sentence).

    Without the program none runs.
    """
    commands = tomllib.loads(LIST.read_text(encoding="utf-8"))
    pages = {*commands["given"], *(command["page"] for command in commands["command"])}
    texts = {page: _text(ROOT / page) for page in sorted(pages)}
    found = [
        fault for page in commands["given"] for fault in _unlisted(page, texts[page], commands)
    ]
    runs = [command for command in commands["command"] if command["run"].startswith("ocmc")]
    runs = (
        [command for command in runs if slow or "slow" not in command]
        if shutil.which("ocmc")
        else []
    )
    for command in runs:
        found += _differences(command, texts[command["page"]])
    return len(runs), [(ROOT / page, fault) for page, fault in found]


def _text(path):
    text = path.read_text(encoding="utf-8")
    # the picture of an answer is that answer
    return (
        f"```text\n{html.unescape(re.sub('<[^>]*>', '', text))}\n```"
        if path.suffix == ".svg"
        else text
    )


def _unlisted(page, text, commands):
    """Yield figures and answers of a page that no command of the list gives."""
    own = [command for command in commands["command"] if command["page"] == page]
    quoted = [entry[0] for command in own for entry in command.get("quoted", [])]
    blocks = [mark for command in own for mark in command.get("blocks", [])]
    prose = _in_line(re.sub(r"`[^`]*`", "", re.sub(r"```.*?```", "", text, flags=re.DOTALL)))
    for known in sorted(quoted + commands["given"][page], key=len, reverse=True):
        if known not in prose and known not in _in_line(text):
            yield page, f"`{known}` of figures.toml is not on the page"
        prose = prose.replace(known, "")
    for figure in _FIGURE.findall(prose):
        yield page, f"no command of figures.toml gives `{figure}`"
    for block in _BLOCK.findall(text):
        if not any(mark in block for mark in blocks):
            yield page, f"no command of figures.toml gives the answer {block.splitlines()[0]!r}"


def _differences(command, text):
    """Yield what a page says otherwise than its command, which meets the studies of the page."""
    said = _said(command["run"], command.get("before"), tuple(_STUDY.findall(text)))
    lines = {_in_line(line) for line in said.splitlines()}
    for mark in command.get("blocks", []):
        block = next((block for block in _BLOCK.findall(text) if mark in block), "")
        # the time that a run took is another one each time
        for line in map(_in_line, block.splitlines()):
            if line not in lines and not line.startswith(("took", "$ ")):
                yield command["page"], f"`{command['run']}` does not print `{line}`"
    for figure, *pattern in command.get("quoted", []):
        taken = re.search(pattern[0], said, re.MULTILINE) if pattern else None
        agrees = taken and _agree(figure, taken.groups()) if pattern else figure in _in_line(said)
        if not agrees:
            yield command["page"], f"`{command['run']}` does not give `{figure}`"


@functools.cache
def _said(run, before, studies):
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, EXPORT.name).symlink_to(EXPORT)
        for study, name in studies:
            Path(folder, name).write_text(study, encoding="utf-8")
        for command in filter(None, [before, run]):
            typed = shlex.split(command)
            answer = subprocess.run(typed, cwd=folder, capture_output=True, text=True, check=False)
    return answer.stdout + answer.stderr


def _agree(figure, taken):
    """Whether numbers are the first ones of a figure, at its precision."""
    quoted, taken = (
        [number.replace(",", "").replace("\N{MINUS SIGN}", "-") for number in numbers]
        for numbers in (re.findall(_NUMBER, figure), taken)
    )
    pairs = zip(quoted, taken, strict=False)
    return all(
        round(float(exact), len(shown.partition(".")[2])) == float(shown) for shown, exact in pairs
    )


def _in_line(text):
    return re.sub(r"\s+", " ", text).strip()
