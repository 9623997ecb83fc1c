#!/usr/bin/env python3
"""Check what a run costs.

``python3 benches/checks.py [cycles] [kilometres] [threads] [memory] [start]``, all without a name.

`--store` measures five figures instead and appends them to `history.csv` beside this file, a line
for each commit and machine; `--numba 6.7 --fastsim 99` puts the ratios that `peers/run.py` printed
beside them. Needs `cargo build --release`. CPU time is the user's, of the whole command; memory is
the largest resident set. The figures depend on what else the machine does; those of CPU time and
memory the least.
"""

import argparse
import csv
import datetime as dt
import json
import os
import platform
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
BINARY = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release/ocmc"
MEGABYTE = 1e6
HISTORY = Path(__file__).with_name("history.csv")
COUNTS = Path(__file__).with_name("instructions") / "counts.json"


class Spent(NamedTuple):
    """Time and memory that a command took."""

    wall_s: float
    cpu_s: float
    memory_mb: float
    simulated_s: float


def ocmc(cycles: int, *more: object, length_m: float | None = None) -> Spent:
    """Run ocmc in a process of its own, so that its memory can be measured."""
    words = [str(BINARY), "--cycles", str(cycles), "--quiet", "--json", *map(str, more)]
    if length_m is not None:
        words += ["--set", f"mission.length_m={length_m}"]
    before = time.perf_counter()
    process = subprocess.Popen(words, stdout=subprocess.PIPE)
    text = process.stdout.read() if process.stdout else b""
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(words)} failed")
    answer = json.loads(text)
    wall_s = time.perf_counter() - before
    return Spent(wall_s, used.ru_utime, used.ru_maxrss * 1024 / MEGABYTE, answer["simulated_s"])


def best(of: int, run: Callable[[], Spent]) -> Spent:
    """Give the run with the least CPU time."""
    return min((run() for _ in range(of)), key=lambda spent: spent.cpu_s)


def cycles() -> None:
    """Cost is linear in the number of cycles."""
    print(
        "| cycles of 100 km | CPU time, s | µs a cycle | ns per simulated second |\n"
        "|---|---|---|---|"
    )
    for n in (100, 1_000, 10_000, 100_000):
        spent = best(max(1, 1000 // n, 3 if n < 100_000 else 1), lambda n=n: ocmc(n))
        per_second = spent.cpu_s / spent.simulated_s * 1e9
        print(f"| {n:,} | {spent.cpu_s:.2f} | {spent.cpu_s / n * 1e6:.0f} | {per_second:.1f} |")


def kilometres() -> None:
    """Cost is linear in the length of the road."""
    # as many cycles of each length: a run's end, where lanes run out of cycles, weighs the same
    print(
        "| km, 1000 cycles | CPU time, s | µs a km | ns per simulated second |\n|---|---|---|---|"
    )
    for km in (10, 30, 100, 300, 1000):
        spent = best(1 if km > 300 else 3, lambda km=km: ocmc(1000, length_m=km * 1e3))
        per_second = spent.cpu_s / spent.simulated_s * 1e9
        print(
            f"| {km} | {spent.cpu_s:.2f} | {spent.cpu_s / km * 1e3:.2f} | {per_second:.1f} |",
            flush=True,
        )


def threads() -> None:
    """Two threads against one; needs two idle cores."""
    one, two = [], []
    for _ in range(3):
        one.append(ocmc(10_000, "--threads", 1))
        two.append(ocmc(10_000, "--threads", 2))
    wall = [min(spent.wall_s for spent in spents) for spents in (one, two)]
    cpu = [min(spent.cpu_s for spent in spents) for spents in (one, two)]
    print(
        f"10,000 cycles of 100 km: one thread {wall[0]:.2f} s, two {wall[1]:.2f} s: "
        f"{wall[0] / wall[1]:.2f} times as fast"
    )
    print(
        f"CPU time {cpu[0]:.2f} s and {cpu[1]:.2f} s: with two idle cores "
        f"{2 * cpu[0] / cpu[1]:.2f} times as fast at best"
    )
    if max(os.getloadavg()) > 0.5 + 2:
        print("the machine is not idle: the wall times say little")


def memory() -> None:
    """Memory stays what it is while records stream to Parquet."""
    print("| run | memory, MB | allowed | wall time, s |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for n, km, allowed in ((10_000, 100, 100), (1_000_000, 10, 300)):
            spent = ocmc(n, "--out", Path(folder) / str(n), length_m=km * 1e3)
            size = sum(path.stat().st_size for path in Path(folder).rglob("*.parquet")) / MEGABYTE
            print(
                f"| {n:,} cycles of {km} km to {size:.0f} MB of Parquet | {spent.memory_mb:.0f} | "
                f"{allowed} | {spent.wall_s:.0f} |"
            )
            if spent.memory_mb > allowed:
                raise SystemExit(f"{spent.memory_mb:.0f} MB are more than {allowed}")


def start() -> None:
    """From the command to the end of one cycle of 1 km, which takes less than a millisecond."""
    runs = [ocmc(1, "--threads", 1, length_m=1e3) for _ in range(31)]
    wall = sorted(1e3 * spent.wall_s for spent in runs)
    cpu = median(1e3 * spent.cpu_s for spent in runs)
    print(
        f"start, study, one cycle of 1 km and its summary: {median(wall):.1f} ms ({wall[0]:.1f} to "
        f"{wall[-1]:.1f}), CPU {cpu:.1f} ms"
    )
    if wall[0] > 50:
        raise SystemExit("more than 50 ms")


def machine() -> str:
    """Name the processor, and how many of it there are."""
    information = Path("/proc/cpuinfo")
    lines = information.read_text().splitlines() if information.exists() else []
    named = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{named[0] if named else platform.machine()}, {os.cpu_count()} threads"


def store(numba: float | None, fastsim: float | None) -> None:
    """Measure what the history has, and append it."""
    git = ("git", "-C", str(ROOT))
    commit, changed = (
        subprocess.run([*git, *words], capture_output=True, text=True, check=True).stdout.strip()
        for words in (
            ["rev-parse", "--short=7", "HEAD"],
            ["status", "--porcelain", "-uno", "--", "crates"],
        )
    )
    load = os.getloadavg()[0]
    one, two = (best(3, lambda n=n: ocmc(10_000, "--threads", n)) for n in (1, 2))
    with tempfile.TemporaryDirectory() as folder:
        memory_mb = ocmc(10_000, "--out", Path(folder) / "run").memory_mb
    counts = json.loads(COUNTS.read_text())["counts"]
    row = {
        "date": dt.datetime.now(dt.UTC).date().isoformat(),
        "commit": commit + ("+" if changed else ""),
        "machine": machine(),
        "load": f"{load:.1f}",
        "ns_per_simulated_s": f"{one.cpu_s / one.simulated_s * 1e9:.1f}",
        "two_threads_wall_s": f"{two.wall_s:.2f}",
        "memory_mb": f"{memory_mb:.0f}",
        "instructions_avx2": counts.get("avx2", ""),
        "instructions_baseline": counts.get("baseline", ""),
        "instructions_neon": counts.get("neon", ""),
        "times_numba": numba or "",
        "times_fastsim": fastsim or "",
    }
    with HISTORY.open("a", newline="") as file:
        csv.DictWriter(file, row, lineterminator="\n").writerow(row)
    print("\n".join(f"{name:22} {value}" for name, value in row.items()))
    if load > 0.5:
        print("the machine was not idle: its load stands beside the figures")


def main() -> None:
    """Run the checks that are named, or store the figures of the history."""
    checks = {check.__name__: check for check in (start, cycles, kilometres, threads, memory)}
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("checks", nargs="*", choices=[*checks, []], help="these alone")
    parser.add_argument(
        "--store", action="store_true", help="append the figures of this commit to history.csv"
    )
    parser.add_argument(
        "--numba", type=float, metavar="RATIO", help="times as fast as the best numba loop"
    )
    parser.add_argument("--fastsim", type=float, metavar="RATIO", help="times as fast as FASTSim")
    asked = parser.parse_args()
    if asked.store:
        store(asked.numba, asked.fastsim)
        return
    for name in asked.checks or checks:
        print(f"\n{checks[name].__doc__}\n")
        checks[name]()


if __name__ == "__main__":
    main()
