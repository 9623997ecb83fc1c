"""Draw the terminal's picture of the README: ``ocmc --cycles 10000``, as docs/images/run.svg.

``scripts/figures/terminal.py [PROGRAM]`` writes it: the quickest of five runs, as others may use
the machine.
"""

import html
import pathlib
import re
import subprocess
import sys

OUT = pathlib.Path(__file__).resolve().parents[2] / "docs" / "images" / "run.svg"
COMMAND = "ocmc --cycles 10000"
LINE, LEFT, TOP = 18, 16, 30
RUNS = 5
WIDTH = 708  # 80 signs of 14 px
FONT = "ui-monospace,SFMono-Regular,Menlo,Consolas,DejaVu Sans Mono,monospace"


def picture(answer: str) -> str:
    """Draw one text for each line: spaces are kept on each of them, which browsers ask for."""
    lines = answer.rstrip("\n").split("\n")
    height = TOP + LINE * len(lines) + 20
    texts = [f'<text xml:space="preserve" x="{LEFT}" y="{TOP}" fill="#8fbcbb">$ {COMMAND}</text>']
    texts += [
        f'<text xml:space="preserve" x="{LEFT}" '
        f'y="{TOP + LINE * (k + 1)}">{html.escape(line)}</text>'
        for k, line in enumerate(lines)
    ]
    size = f'width="{WIDTH}" height="{height}" viewBox="0 0 {WIDTH} {height}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size}'
    return "\n".join(
        [
            f'{head} role="img" aria-label="Output of {COMMAND}">',
            '<rect width="100%" height="100%" rx="8" fill="#16181d"/>',
            f'<g font-family="{FONT}" font-size="14" fill="#d8dee9">',
            *texts,
            "</g>",
            "</svg>\n",
        ]
    )


def took_s(answer: str) -> float:
    """Read how long the run took."""
    return float(re.search(r"^took +([\d.]+) s", answer, re.MULTILINE)[1])


def main() -> None:
    """Run the program and draw its answer."""
    program = sys.argv[1] if len(sys.argv) > 1 else "ocmc"
    command = [program, *COMMAND.split()[1:]]
    answers = [
        subprocess.run(command, check=True, capture_output=True, text=True).stdout
        for _ in range(RUNS)
    ]
    OUT.write_text(picture(min(answers, key=took_s)))


if __name__ == "__main__":
    main()
