#!/usr/bin/env python3
"""Print the guide's page on the Python package, made of its docstrings.

``scripts/python_reference.py > docs/src/reference/python.md``
"""

import inspect
import re

import ocmc
import ocmc.dask
import ocmc.map
import ocmc.plot

HEAD = """# Python

This page is made of the package's docstrings by `scripts/python_reference.py`; \
`help(ocmc.Study)` shows them.
"""


def members(owner):
    """Public members of a class, by their names."""
    for name, member in sorted(vars(owner).items()):
        if not name.startswith("_") and member.__doc__:
            yield name, member


def signature(name, thing):
    """Name and arguments, without types: those are in the stub."""
    try:
        arguments = inspect.signature(thing).parameters.values()
    except (TypeError, ValueError):
        return name
    plain = [a.replace(annotation=inspect.Parameter.empty) for a in arguments if a.name != "self"]
    return name + str(inspect.Signature(plain)) if callable(thing) else name


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
        else:
            out.append(line)
    if code:
        out.append("```")
    return re.sub(r"\n{3,}", "\n\n", "\n".join(out)).strip()


def page():
    """Make the page."""
    parts = [HEAD]
    for name in sorted(set(ocmc.__all__) - {"__version__"}):
        thing = getattr(ocmc, name)
        if not inspect.isclass(thing):
            parts.append(f"## `{signature(f'ocmc.{name}', thing)}`\n\n{text(thing)}\n")
            continue
        made = name == "Study"
        title = signature(f"ocmc.{name}", thing) if made else f"ocmc.{name}"
        parts.append(f"## `{title}`\n\n{text(thing)}\n")
        parts += [
            f"### `{signature(f'{name}.{m}', member)}`\n\n{text(member)}\n"
            for m, member in members(thing)
        ]
    for module in [ocmc.plot, ocmc.dask, ocmc.map]:
        parts.append(f"## `{module.__name__}`\n\n{text(module)}\n")
        for name in module.__all__:
            thing = getattr(module, name)
            parts.append(
                f"### `{signature(f'{module.__name__}.{name}', thing)}`\n\n{text(thing)}\n"
            )
    return "\n".join(parts)


if __name__ == "__main__":
    print(page(), end="")
