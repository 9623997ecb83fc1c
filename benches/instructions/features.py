#!/usr/bin/env python3
"""Count what each part of the model costs: `python3 benches/instructions/features.py`.

Turns parts of the default study off, one by one, and counts the kernel's lane-steps and
instructions (AVX2) for a simulated second. The step has no branch for a part: what a part costs is
the steps that it cuts and the lane events that it causes.
"""

import json
import shutil
import sys

from run import CYCLES, PEERS, SETS, instructions, output

ALL = [
    *("slope", "curves", "signs", "traffic", "weather"),
    *("stop_signs", "give_ways", "traffic_lights", "speed_bumps"),
]
PARTS = [
    ("everything on", ()),
    ("slope", ('simulation.without=["slope"]',)),
    ("curves", ('simulation.without=["curves"]',)),
    ("signs", ('simulation.without=["signs"]',)),
    ("traffic", ('simulation.without=["traffic"]',)),
    ("stops", ('simulation.without=["stop_signs", "give_ways", "traffic_lights"]',)),
    ("speed bumps", ('simulation.without=["speed_bumps"]',)),
    ("weather", ('simulation.without=["weather"]',)),
    ("switched drivers (all PID)", ("driver.pedals.pid_share=1",)),
    ("PID drivers (all switched)", ("driver.pedals.pid_share=0",)),
    ("all but the drivers", (f"simulation.without={json.dumps(ALL)}",)),
]


def main() -> None:
    """Print a table."""
    if shutil.which("valgrind") is None:
        print("SKIPPED: valgrind is not installed", file=sys.stderr)
        return
    output("cargo", "build", "--release", "--quiet", "--example", "peers")
    print(
        "| turned off | lane-steps a simulated second | instructions a lane-step | instructions a "
        "simulated second |"
    )
    print("|---|---|---|---|")
    for name, sets in PARTS:
        sets = (*SETS, *sets)  # noqa: PLW2901
        simulated_s = json.loads(output(PEERS, "drive", CYCLES, 1, "avx2", *sets))["simulated_s"]
        steps = int(output(PEERS, "steps", CYCLES, *sets))
        count = instructions(2, "avx2", sets) - instructions(1, "avx2", sets)
        print(
            f"| {name} | {steps / simulated_s:.2f} | {count / steps:.0f} | "
            f"{count / simulated_s:.0f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
