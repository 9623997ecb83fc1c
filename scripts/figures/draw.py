"""Draw the figures of the guide: ``scripts/figures/draw.py [NAME...]``, all by default."""

import sys
import time

import driving
import fleets
import laws
import matplotlib as mpl
import outside
import structure
import style
import surroundings

FIGURES = (
    driving.FIGURES
    | laws.FIGURES
    | surroundings.FIGURES
    | fleets.FIGURES
    | outside.FIGURES
    | structure.FIGURES
)


def main(names):
    """Draw those that are named."""
    if unknown := [name for name in names if name not in FIGURES]:
        sys.exit(f"no figure {', '.join(unknown)}; there are: {', '.join(FIGURES)}")
    mpl.use("svg")
    style.FIGURES.mkdir(exist_ok=True)
    for name in names or FIGURES:
        begun = time.monotonic()
        path = style.FIGURES / f"{name}.svg"
        if not style.draw(FIGURES[name], path):
            print(f"{name}: skipped, its data are not here")
            continue
        print(f"{name}: {path.stat().st_size / 1000:.0f} kB, {time.monotonic() - begun:.1f} s")


if __name__ == "__main__":
    main(sys.argv[1:])
