"""Execute the notebooks of the gallery and write their pages.

``scripts/figures/gallery.py [NAME...]``

A page has the notebook's text and code and what the cells show. The caption of a picture is the
cell's ``metadata.caption``.
"""

import re
import sys
import textwrap
import time

import nbclient
import nbformat
from style import FIGURES, PAGES, shortened

GALLERY = PAGES / "gallery"
NAMES = ["first-run", "two-trucks", "spread", "curves-from-a-log", "trucks", "electric-range"]
_SETTINGS = """\
%config InlineBackend.figure_formats = ["svg"]
%config InlineBackend.print_figure_kwargs = {"bbox_inches": "tight", "metadata": {"Date": None}}
import matplotlib
matplotlib.rcParams |= {"svg.hashsalt": "ocmc", "savefig.facecolor": "white"}
"""
_LONGEST_S = 300


def executed(name):
    """Give the notebook with its outputs."""
    notebook = nbformat.read(GALLERY / f"{name}.ipynb", as_version=4)
    notebook.cells.insert(0, nbformat.v4.new_code_cell(_SETTINGS))
    resources = {"metadata": {"path": str(GALLERY)}}
    nbclient.NotebookClient(notebook, timeout=_LONGEST_S, resources=resources).execute()
    del notebook.cells[0]
    return notebook


def page(notebook, name):
    """Give the text of the page, and the texts of its pictures by their file names."""
    parts, pictures = [], {}
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(re.sub(r"\]\(([\w-]+)\.ipynb\)", r"](\1.md)", cell.source))
            continue
        parts.append(f"```python\n{cell.source}\n```")
        for shown in _shown(cell.outputs):
            if "image/svg+xml" in shown:
                file = f"gallery-{name}-{len(pictures) + 1}.svg"
                pictures[file] = shortened(shown["image/svg+xml"])
                parts.append(textwrap.fill(f"![{cell.metadata.caption}](../figures/{file})", 100))
            else:
                parts.append(f"```text\n{shown['text/plain'].rstrip()}\n```")
    title, *rest = parts[0].partition("\n")
    source = f"Made of the notebook [{name}.ipynb]({name}.ipynb) by `scripts/figures/gallery.py`."
    parts[0] = f"{title}\n\n{source}{''.join(rest)}"
    return "\n\n".join(parts) + "\n", pictures


def _shown(outputs):
    """Give each output by its types; texts that follow each other are one."""
    shown = []
    for output in outputs:
        if output.output_type != "stream":
            shown.append(dict(output.data))
        elif shown and "stream" in shown[-1]:
            shown[-1]["text/plain"] += output.text
        else:
            shown.append({"stream": output.name, "text/plain": output.text})
    return shown


def main(names):
    """Write the pages of those that are named, all by default."""
    for name in names or NAMES:
        begun = time.monotonic()
        text, pictures = page(executed(name), name)
        (GALLERY / f"{name}.md").write_text(text, encoding="utf-8")
        for file, drawn in pictures.items():
            (FIGURES / file).write_text(drawn, encoding="utf-8")
        print(f"{name}: {time.monotonic() - begun:.0f} s, {len(pictures)} pictures")


if __name__ == "__main__":
    main(sys.argv[1:])
