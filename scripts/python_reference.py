#!/usr/bin/env python3
"""Write the guide's pages on the Python package from its docstrings: an index, a page a theme.

``scripts/python_reference.py`` writes ``docs/src/reference/python.md`` and the folder ``python``
beside it.
"""

import inspect
import re
import textwrap
from pathlib import Path

import ocmc
import ocmc.dask
import ocmc.map
import ocmc.plot

REFERENCE = Path(__file__).resolve().parents[1] / "docs" / "src" / "reference"

HEAD = """# Python

All names of the package by theme, each with its page. These pages are made of its docstrings by
`scripts/python_reference.py`; `help(ocmc.Study)` shows them. [Work with runs in
Python](../how-to/python.md) shows how they go together, and [which errors
come](../how-to/python.md#when-something-is-wrong).
"""

# Pages by theme: file, title, names. A class brings its members, but for those of `Study` that a
# theme names. What no theme names is on the first page.
THEMES = [
    ("studies", "Studies", ["Study", "studies", "vehicles"]),
    ("runs", "Runs", ["Study.run", "Run", "Summary", "Table", "load", "merge", "mixed_fleet"]),
    (
        "cycles",
        "Cycles and routes",
        ["Study.drive", "Study.operating_cycle", "Study.trace", "OperatingCycle"],
    ),
    (
        "questions",
        "Questions",
        [
            "compare",
            "Study.sweep",
            "Study.sensitivity",
            "Study.doubt",
            "Study.bound",
            "Study.training",
            "simulator_study",
            "Answer",
        ],
    ),
    ("electric", "Cost, range and battery", ["Study.cost", "Study.range", "Study.size"]),
    (
        "drivers",
        "Drivers from logs",
        [
            "detect_curves",
            "fit_curve_speed",
            "calibrate_curve_speed",
            "fit_speed_change",
            "identify",
        ],
    ),
    (
        "roads",
        "Roads, weather and traffic from measurements",
        ["road", "validate", "fit_operating_cycle", "fit_weather", "fit_traffic"],
    ),
    (
        "fleet",
        "A fleet's own tables",
        ["learn", "Study.calibrate_totals", "benchmark", "fit_fleet"],
    ),
    ("plot", "Pictures", ["plot"]),
    ("machines", "Clusters and maps", ["dask", "map"]),
]
MODULES = {"plot": ocmc.plot, "dask": ocmc.dask, "map": ocmc.map}


def members(owner):
    """Public members of a class, by their names."""
    for name, member in sorted(vars(owner).items()):
        if not name.startswith("_") and member.__doc__:
            yield name, member


def signature(name, thing):
    """Make a block of code of a name and its arguments, without types: those are in the stub."""
    try:
        arguments = inspect.signature(thing).parameters.values()
    except (TypeError, ValueError):
        return ""
    plain = [a.replace(annotation=inspect.Parameter.empty) for a in arguments if a.name != "self"]
    call = name + str(inspect.Signature(plain))
    lines = textwrap.wrap(
        call, 88, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
    )
    return "\n".join(["```python", *lines, "```", "", ""])


def text(thing):
    """Make Markdown of a numpydoc docstring."""
    lines = inspect.cleandoc(thing.__doc__ or "").replace("``", "`").splitlines()
    out, code = [], False
    for k, line in enumerate(lines):
        below = lines[k + 1] if k + 1 < len(lines) else ""
        if re.fullmatch(r"-{3,}", line):
            continue
        example = line.startswith((">>> ", "... ")) or (code and line.strip() != "")
        if example != code:
            out.append("```" if code else "```python")
            code = example
        if re.fullmatch(r"-{3,}", below):
            out.append(f"*{line}*\n")
        elif code:
            out.append(line)
        elif line.startswith("    "):
            out.append("  " + line.strip())
        elif re.fullmatch(r"[\w, ]+ : .+", line):
            name, _, kind = line.partition(" : ")
            out.append(f"- `{name}`: {kind}  ")
        elif line and below.startswith("    "):
            out.append(f"- `{line}`  " if re.fullmatch(r"[\w.]+", line) else f"- {line}  ")
        else:
            out.append(line)
    if code:
        out.append("```")
    return re.sub(r"\n{3,}", "\n\n", "\n".join(out)).strip()


def section(name, thing, level="##"):
    """Make the section of a name."""
    made = not inspect.isclass(thing) or thing is ocmc.Study
    call = signature(name, thing) if callable(thing) and made else ""
    return f"{level} `{name}`\n\n{call}{text(thing)}\n"


def of_theme(names, elsewhere):
    """Yield names, things and levels of a theme: of a class and a module their members, too."""
    for name in names:
        if name in MODULES:
            yield f"ocmc.{name}", MODULES[name], "##"
            for part in MODULES[name].__all__:
                yield f"ocmc.{name}.{part}", getattr(MODULES[name], part), "###"
            continue
        owner, _, member = name.rpartition(".")
        thing = vars(getattr(ocmc, owner))[member] if owner else getattr(ocmc, name)
        yield name if owner else f"ocmc.{name}", thing, "##"
        if inspect.isclass(thing):
            for member, value in members(thing):
                if f"{name}.{member}" not in elsewhere:
                    yield f"{name}.{member}", value, "###"


def summary(thing):
    """Give the first sentence of a docstring."""
    first = " ".join(
        inspect.cleandoc(thing.__doc__ or "").replace("``", "`").split("\n\n")[0].split()
    )
    return re.split(r"(?<=\.)\s(?=[A-Z])", first)[0].replace("|", "\\|")


def pages():
    """Give the text of each page by its path in the folder `reference`."""
    named = {name for _, _, names in THEMES for name in names}
    rest = sorted(set(ocmc.__all__) - {"__version__"} - named - set(MODULES))
    made, index = {}, [HEAD]
    for place, (file, title, names) in enumerate(THEMES):
        parts = list(of_theme(names + rest * (place == 0), named))
        made[f"python/{file}.md"] = "\n".join([f"# {title}\n", *(section(*part) for part in parts)])
        index.append(f"## {title}\n\n| name | what it is |\n|---|---|")
        for name, thing, _ in parts:
            anchor = re.sub(r"[^\w-]", "", name.lower())
            index[-1] += f"\n| [`{name}`](python/{file}.md#{anchor}) | {summary(thing)} |"
        index[-1] += "\n"
    return {"python.md": "\n".join(index)} | made


if __name__ == "__main__":
    for path, page in pages().items():
        (REFERENCE / path).parent.mkdir(exist_ok=True)
        (REFERENCE / path).write_text(page, encoding="utf-8")
