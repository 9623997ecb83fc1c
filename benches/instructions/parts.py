#!/usr/bin/env python3
"""Count the instructions of a lane-step by the parts of the step.

``python3 benches/instructions/parts.py [avx2|baseline]``

Builds the core with line tables, runs it under callgrind, and gives each instruction to the
innermost function of the model that it was inlined from. Needs valgrind and addr2line.
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
    "advance_segment": "road rows",
    "desired": "desired speed from the road row",
    "control": "pedal controllers, limiter, overspeed band",
    "decide": "hold and clutch: decisions at the start",
    "curves_at": "looking up the torque curves",
    "tractive_effort": "torque, brakes",
    "wheel_and_lost_forces_n": "losses of gearbox and axle",
    "net": "cross wind, sum of forces",
    "drag_forces_n": "drag",
    "predict": "length of the step, state at its end",
    "first_order_lags": "lags of torque and speed filter",
    "locate_crossing": "cuts at switching events",
    "end_step": "cuts at segment ends and at rest",
    "accumulate": "work and fuel for the energy ledger",
    "fuel_rates": "fuel map",
    "add": "adding to the totals",
    "commit_step": "new state",
    "wants_shift": "whether another gear is wanted",
    "event_flags": "whether a lane has an event",
    "handle_event": "lane events: stops, shifts",
}
ALIASES = {
    **dict.fromkeys(("driver_function", "gear_function", "pedal_function"), "locate_crossing"),
    **dict.fromkeys(("of_rise", "or_earlier"), "locate_crossing"),
    **dict.fromkeys(("first_effort", "second_effort"), "tractive_effort"),
    **dict.fromkeys(("speed_target", "couple"), "decide"),
    **dict.fromkeys(("cells", "piece_of"), "fuel_rates"),
    **dict.fromkeys(("is_too_long", "longest_next"), "predict"),
    **dict.fromkeys(
        ("row", "set_row", "shift", "stop", "dwell", "start", "check", "stop_row"), "handle_event"
    ),
    **dict.fromkeys(
        ("events", "is_captured", "leave_line", "wanted_gear", "set_gear"), "handle_event"
    ),
    **dict.fromkeys(("clamp_integral", "control_at_start", "control_at_end"), "control"),
    "consume": "accumulate",
    "desired_at_end": "desired",
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
        words = (
            "valgrind",
            "--tool=callgrind",
            "--dump-instr=yes",
            f"--callgrind-out-file={path}",
            PEERS,
        )
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
    lines = (
        "--config",
        "profile.release.package.ocmc-core.debug=1",
        "--config",
        "profile.release.strip=false",
    )
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
