#!/usr/bin/env python3
"""Simulates how well a large run would use many processors.

``python3 benches/schedule.py [--km 10] [--cycles 1000000]``

Runs of 512 cycles are driven one by one, and the time of each is noted (a trace of times). What the
thread that takes the records does for each is measured by itself: adding to the summary, writing
chunks, putting the file of records together. Then the program's own rule is simulated with them:
threads take the next few cycles while their lanes drive the last, one thread takes the records in
order, and at most two chunks a thread wait for it. At the end a thread's lanes run empty. CPU time
throughout: other work on the machine hardly matters. What waiting for a disk costs is `--sync-ms`,
five for each 1024 records. Needs Linux and `cargo build --release`.
"""

import argparse
import heapq
import os
import subprocess
import tempfile
import time
from collections import deque
from collections.abc import Iterator
from itertools import cycle, islice
from pathlib import Path
from typing import NamedTuple

from checks import BINARY, ocmc

# as in crates/ocmc-core/src/fleet/run.rs and crates/ocmc-io/src/run_directory/{chunks,assembly}.rs
CHUNK = 128
LEAST_CHUNK = 4
CHUNKS_A_THREAD = 256
LANES = 16
WAITING_A_THREAD = 2
FILE_ROWS = 1024
THREADS_A_WRITER = 4
SYNCS = 5
MOST_ENCODERS = 8
# cycles of a traced run
TRACED = 512
# records that are driven to measure what is done with each
RECORDS = 40 * FILE_ROWS


class Spent(NamedTuple):
    """CPU time of a process, in s: of its first thread, and of all."""

    first_s: float
    all_s: float

    def less(self, other: "Spent") -> "Spent":
        """Give what is more than in another one."""
        return Spent(self.first_s - other.first_s, self.all_s - other.all_s)


class Behind(NamedTuple):
    """Work behind the last chunk: how long it takes, and the CPU time of all threads."""

    wall_s: float
    busy_s: float


class Sink(NamedTuple):
    """CPU time for each record, in s.

    By the thread that takes the records; by those that write chunks; at the end by those that
    encode groups of rows, and by the one that puts these together.
    """

    summary_s: float
    taking_s: float
    writing_s: float
    encoding_s: float
    assembly_s: float

    def behind(self, cycles: int, threads: int) -> Behind:
        """Give the work behind the last chunk: groups are encoded, and put together meanwhile."""
        busy_s = cycles * (self.encoding_s + self.assembly_s)
        return Behind(max(cycles * self.assembly_s, busy_s / min(threads, MOST_ENCODERS)), busy_s)


def spent_by(words: list[str], chunks: Path | None) -> tuple[Spent, Spent]:
    """Give what a command spends until its last chunk is there, and behind that."""
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL)
    clock = Path(f"/proc/{process.pid}/task/{process.pid}/schedstat")
    total = Path(f"/proc/{process.pid}/stat")
    last = f"{RECORDS // FILE_ROWS - 1:08}.parquet"
    spent, until = Spent(0.0, 0.0), None
    while process.poll() is None:
        try:
            ticks = total.read_text().rsplit(")", 1)[1].split()[11:13]
            of_all_s = sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK")
            spent = Spent(int(clock.read_text().split()[0]) / 1e9, of_all_s)
        except (OSError, IndexError):
            break
        if until is None and chunks is not None and (chunks / last).exists():
            until = spent
        time.sleep(0.001)
    if process.wait():
        raise SystemExit(f"{' '.join(words)} failed")
    until = until or spent
    return until, spent.less(until)


def sink() -> Sink:
    """Measure what is done with a record, on the shortest cycles that there are."""
    words = [
        str(BINARY),
        "--set",
        "mission.length_m=200",
        "--threads",
        "1",
        "--quiet",
        "--json",
        "--cycles",
    ]
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        start, _ = spent_by([*words, "16"], None)
        alone, _ = spent_by([*words, str(RECORDS)], None)
        until, behind = spent_by([*words, str(RECORDS), "--out", str(out)], out / "chunks")
    more = until.less(alone)
    summary_s = alone.first_s - start.first_s
    writing_s, encoding_s = (max(0.0, spent.all_s - spent.first_s) for spent in (more, behind))
    parts = (summary_s, more.first_s, writing_s, encoding_s, behind.first_s)
    return Sink(*(part / RECORDS for part in parts))


def times_of_runs(km: float, number: int) -> list[float]:
    """Drive so many runs, and give the CPU time of each."""
    start_s = min(ocmc(1, "--threads", 1, length_m=1e3).cpu_s for _ in range(5))
    drive = ("--threads", 1, "--first-cycle")
    return [
        ocmc(TRACED, *drive, k * TRACED, length_m=1e3 * km).cpu_s - start_s for k in range(number)
    ]


class Schedule(NamedTuple):
    """How a run went."""

    driving_s: float
    idle: float


def simulate(
    times: Iterator[float],
    threads: int,
    chunks: int,
    taking_s: float,
    tail_s: float,
    behind: Behind,
) -> Schedule:
    """Simulate the rule of the program.

    `taking_s` is what the records of a chunk take, `tail_s` how long the lanes of a thread run
    empty at the end.
    """
    free = [0.0] * threads  # when each thread takes its next chunk
    taken: deque[float] = deque()  # when the records of each chunk are taken, in order
    busy_s = end_s = 0.0
    for chunk_s in islice(times, chunks):
        done_s = heapq.heappop(free) + chunk_s
        busy_s += chunk_s
        # a chunk is taken once it and all before it are there
        end_s = max(end_s, done_s) + taking_s
        taken.append(end_s)
        # a full channel holds the thread until there is room
        if len(taken) > WAITING_A_THREAD * threads:
            done_s = max(done_s, taken.popleft())
        heapq.heappush(free, done_s)
    end_s += tail_s
    return Schedule(end_s, 1.0 - (busy_s + behind.busy_s) / (threads * (end_s + behind.wall_s)))


def main() -> None:
    """Measure, simulate, and print a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--km", type=float, default=10.0)
    parser.add_argument("--cycles", type=int, default=1_000_000)
    parser.add_argument("--traced", type=int, default=16, help="runs that are driven for the trace")
    parser.add_argument(
        "--sync-ms", type=float, default=0.0, help="time for which a write waits for the disk"
    )
    asked = parser.parse_args()
    of = sink()
    times = times_of_runs(asked.km, asked.traced)
    a_cycle_s = sum(times) / len(times) / TRACED
    parts = {
        "driven": a_cycle_s,
        "summary": of.summary_s,
        "handed over": of.taking_s,
        "written": of.writing_s,
        "encoded": of.encoding_s,
        "put together": of.assembly_s,
    }
    print(
        f"{asked.cycles:,} cycles of {asked.km:g} km; µs a record: "
        + ", ".join(f"{name} {1e6 * part_s:.1f}" for name, part_s in parts.items())
    )
    spread = (max(times) - min(times)) / (sum(times) / len(times))
    print(
        f"runs of {TRACED}: {1e3 * min(times):.1f} to {1e3 * max(times):.1f} ms, "
        f"{100 * spread:.0f} % apart\n"
    )
    print(
        "| threads | cycles a chunk | driving, s | putting together, s | idle, % | without files, "
        "s | idle, % |"
    )
    print("|---|---|---|---|---|---|---|")
    for threads in (1, 2, 8, 64):
        chunk = min(max(-(-asked.cycles // (CHUNKS_A_THREAD * threads)), LEAST_CHUNK), CHUNK)
        chunks = -(-asked.cycles // chunk)
        driven = [time_s * chunk / TRACED for time_s in times]
        # those that write chunks run on the same processors, one for each four threads
        written = [time_s + chunk * of.writing_s for time_s in driven]
        sync_s = asked.sync_ms / 1e3 * SYNCS / FILE_ROWS
        slowest_s = max(
            of.summary_s + of.taking_s + sync_s, of.writing_s / -(-threads // THREADS_A_WRITER)
        )
        behind = of.behind(asked.cycles, threads)
        # half of the lanes are empty then, on average
        tail_s = LANES / 2 * a_cycle_s
        with_files = simulate(cycle(written), threads, chunks, chunk * slowest_s, tail_s, behind)
        without = simulate(
            cycle(driven), threads, chunks, chunk * of.summary_s, tail_s, Behind(0.0, 0.0)
        )
        print(
            f"| {threads} | {chunk} | {with_files.driving_s:.1f} | {behind.wall_s:.1f} | "
            f"{100 * with_files.idle:.0f} |"
            f" {without.driving_s:.1f} | {100 * without.idle:.0f} |"
        )
    if os.getloadavg()[0] > 1.0:
        print("\nthe machine was not idle: times are those of CPUs, and their caches were shared")


if __name__ == "__main__":
    main()
