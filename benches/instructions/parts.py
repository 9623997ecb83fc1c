#!/usr/bin/env python3
"""Count the instructions of a lane-step by the parts of the step: `python3 benches/instructions/parts.py [avx2|baseline]`.

Builds the core with line tables, runs it under callgrind, and gives each instruction to the innermost function of the model that it was
inlined from. Needs valgrind and addr2line.
"""

import collections
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from run import CYCLES, PEERS, SETS, output

# functions of the model, and what they do
PARTS = {
    "turn_to_row": "road rows",
    "desired": "desired speed from the road row",
    "control": "pedal controllers, limiter, overspeed band",
    "decide": "hold and clutch: decisions at the start",
    "curves_at": "looking up the torque curves",
    "pull": "torque, brakes",
    "wheel_forces_n": "losses of gearbox and axle",
    "net": "cross wind, sum of forces",
    "drag_forces_n": "drag",
    "length": "length of the step, state at its end",
    "following": "lags of torque and speed filter",
    "change_of_mind": "cuts where a mind changes",
    "end": "cuts at segment ends and at rest",
    "books": "work and fuel for the books",
    "fuel_rates": "fuel map",
    "book": "adding to the totals",
    "renew": "new state",
    "wants_shift": "whether another gear is wanted",
    "alarm": "whether a lane needs a look",
    "attend": "looks: stops, shifts",
}
ALIASES = {
    **dict.fromkeys(("hold_line", "gear_line", "pedal_line", "of_rise", "or_earlier"), "change_of_mind"),
    **dict.fromkeys(("first_pull", "second_pull"), "pull"),
    **dict.fromkeys(("wish", "couple"), "decide"),
    **dict.fromkeys(("cells", "piece_of"), "fuel_rates"),
    **dict.fromkeys(("is_too_long", "longest_next", "predict"), "length"),
    **dict.fromkeys(("row", "set_row", "shift", "stop", "dwell", "start", "check", "stop_row"), "attend"),
    **dict.fromkeys(("sights", "is_captured", "leave_line", "wanted_gear", "set_gear"), "attend"),
    **dict.fromkeys(("clamp_integral", "control_now"), "control"),
    "spend": "books",
    "desired_ahead": "desired",
}


def costs(path: Path) -> collections.Counter[int]:
    """Read the instructions executed at each address of the program."""
    cost: collections.Counter[int] = collections.Counter()
    names: dict[str, str] = {}
    here, called, address = False, False, 0
    for line in path.read_text().splitlines():
        if line.startswith(("ob=", "cob=")):  # a name is written once and then called by its number
            number, _, name = line.partition("=")[2].partition(" ")
            file = names.setdefault(number, name)
            if line.startswith("ob="):
                here = file.endswith("/peers")
        elif line.startswith("calls="):
            called = True
        elif match := re.match(r"(0x[0-9a-f]+|[+-]\d+|\*) \S+ (\d+)$", line):
            word = match.group(1)
            if word != "*":
                address = int(word, 16) if word.startswith("0x") else address + int(word)
            if here and not called:
                cost[address] += int(match.group(2))
            called = False
    return cost


def part_of(frames: list[str]) -> str | None:
    """Find the innermost function of the model in a stack of inlined functions."""
    for frame in frames:
        name = re.sub(r"<[^<>]*>", "", re.sub(r"<[^<>]*>", "", frame)).split("::")[-1]
        name = ALIASES.get(name, name)
        if name in PARTS and "ocmc_core" in frame:
            return name
    return None


def counts(level: str, rounds: int) -> collections.Counter[str]:
    """Count by part."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "callgrind.out"
        words = ("valgrind", "--tool=callgrind", "--dump-instr=yes", f"--callgrind-out-file={path}", PEERS)
        output(*words, "drive", CYCLES, rounds, level, *SETS)
        cost = costs(path)
    asked = "\n".join(hex(address) for address in cost)
    words = ["addr2line", "-e", str(PEERS), "-i", "-f", "-C", "-a"]
    said = subprocess.run(words, input=asked, capture_output=True, text=True, check=True).stdout
    found: collections.Counter[str] = collections.Counter()
    for block in re.split(r"^0x", said, flags=re.MULTILINE)[1:]:
        address, *frames = block.splitlines()
        found[part_of(frames[::2]) or "rest"] += cost[int(address, 16)]
    return found


def main() -> None:
    """Print a table."""
    if shutil.which("valgrind") is None or shutil.which("addr2line") is None:
        print("SKIPPED: valgrind or addr2line is not installed", file=sys.stderr)
        return
    level = sys.argv[1] if len(sys.argv) > 1 else "avx2"
    lines = ("--config", "profile.release.package.ocmc-core.debug=1")
    output("cargo", "build", "--release", "--quiet", "--example", "peers", *lines)
    steps = int(output(PEERS, "steps", CYCLES, *SETS))
    once, again = counts(level, 1), counts(level, 2)
    again.subtract(once)
    total = sum(again.values())
    print(f"| part | instructions a lane-step, {level} | share, % |\n|---|---|---|")
    for name, count in again.most_common():
        print(f"| {PARTS.get(name, name)} | {count / steps:.1f} | {100 * count / total:.1f} |")
    print(f"| all | {total / steps:.1f} | 100 |")


if __name__ == "__main__":
    main()
