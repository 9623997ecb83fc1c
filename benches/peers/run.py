#!/usr/bin/env python3
"""Time ocmc and its rivals on the same scenarios, and print the table of docs/src/peers.md.

All drive on one core, in turns.

``python3 benches/peers/run.py [--rounds N] [--cycles N] [--only KIND ...] [--folder target/peers]
[--no-build]``

Installs the rivals of requirements.txt into FOLDER/venv, builds ocmc, exports the scenarios with
ocmc's answers, gives each rival the longest step at which it is as right as ocmc, and then runs
rounds in which everybody drives once. Needs nothing but Python and a Rust toolchain; a rival that
cannot be installed is skipped with a message.
"""

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import venv
from dataclasses import dataclass, field
from datetime import UTC, datetime
from math import ceil
from pathlib import Path
from statistics import median
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
# mean absolute bias against 1 ms up to which energies are equally good, but for what ocmc itself
# has, rounded up to ROUNDING
EQUAL_ERROR, ROUNDING = 5e-4, 1e-4
# differences up to which two answers are the same: in closed loop at one step, and on one trace
SAME_CLOSED_LOOP = 5e-3
SAME_TRACE = 1e-2
DEFAULT_STEP_S = 1.5
LEVELS = {"baseline": "SSE2 or NEON", "avx2": "AVX2", "avx512": "AVX-512"}
TRUTH_S = 0.001
# rounds of `peers drive` in one timing of the kernel alone
KERNEL_ROUNDS = 8
# half-width of the mean's 95 % interval that is asked for, and the trips from which the plain
# number is taken
PRECISION, PLAIN_TRIPS = 2e-3, 10_000

# kind, what it is, customary steps, whether other steps are tried for 0.05 %, cycles of a round
RIVALS = [
    ("numba-growing", "numba, scalar loop, ocmc's own steps", [1.5], True, 128),
    ("numba-heun", "numba, scalar loop, cut Heun steps", [0.1], True, 128),
    ("numba-euler", "numba, scalar loop, Euler steps", [0.1], True, 128),
    ("fastsim", "FASTSim, class-8 truck, given speeds", [1.0], False, 16),
    ("sumo", "SUMO, EIDM, energy model", [1.0, 0.1], False, 8),
]


@dataclass
class Entry:
    """One line of the table."""

    kind: str
    name: str
    step_s: float
    cycles: int
    needed: bool = False
    """The step is the longest one at which it is as right as ocmc."""
    difference: float | None = None
    """From ocmc's energies, or from those that ocmc finds on the rival's trace."""
    bias: tuple[float, float] | None = None
    """Mean absolute bias of wheel energy and fuel against 1 ms."""
    ns_per_s: list[float] = field(default_factory=list)
    us_per_100km: list[float] = field(default_factory=list)
    ns_per_step: list[float] = field(default_factory=list)

    @property
    def agrees(self) -> bool:
        """Whether its answer is the same as ocmc's."""
        allowed = SAME_TRACE if self.kind in ("fastsim", "sumo") else SAME_CLOSED_LOOP
        return self.difference is None or self.difference <= allowed


class Worker:
    """A contender in its own process, which drives on request."""

    def __init__(self, python: Path, folder: Path, kind: str) -> None:
        self.process = subprocess.Popen(
            [python, HERE / "contenders.py", folder, kind],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.about = self._answer()

    def _answer(self) -> dict[str, Any]:
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError((self.process.stderr.read().strip().splitlines() or ["ended"])[-1])
        return json.loads(line)

    def round(self, step_s: float, cycles: int) -> dict[str, Any]:
        """Drive once."""
        self.process.stdin.write(json.dumps({"step_s": step_s, "cycles": cycles}) + "\n")
        self.process.stdin.flush()
        return self._answer()


def say(text: str) -> None:
    """Print what is going on."""
    print(text, file=sys.stderr, flush=True)


def timed(words: list[Any], given: str | None = None) -> tuple[float, str]:
    """Run a command; the user's CPU time and what it printed."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(
        [str(w) for w in words], input=given, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(done.stderr.strip() or f"{words[0]} failed")
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, done.stdout


def environment(folder: Path) -> Path:
    """Install the rivals, each as far as it can be had; give their Python."""
    python = folder / "venv/bin/python"
    wanted = (HERE / "requirements.txt").read_text()
    stamp = folder / "venv/installed.txt"
    if stamp.exists() and stamp.read_text() == wanted:
        return python
    say("installing the rivals")
    venv.create(folder / "venv", with_pip=True, clear=True)
    install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    try:
        timed([*install, "-r", HERE / "requirements.txt"])
    except RuntimeError:
        for line in wanted.splitlines():
            if not line.startswith("#"):
                try:
                    timed([*install, line])
                except RuntimeError as error:
                    say(f"SKIPPED {line}: {str(error).splitlines()[-1]}")
    stamp.write_text(wanted)
    return python


def ocmc_round(entry: Entry, binary: Path, peers: Path) -> dict[str, Any]:
    """Time ocmc itself, at the level that its kind names.

    It is the whole command, or the kernel alone on planned cycles.
    """
    if entry.kind == "ocmc":
        words = [binary, "--cycles", entry.cycles, "--seed", 1, "--threads", 1, "--quiet", "--json"]
        spent, text = timed([*words, "--set", f"simulation.step_s={entry.step_s}"])
        answer = json.loads(text)
        return {
            "cpu_s": spent,
            "simulated_s": [answer["simulated_s"]],
            "distance_m": answer["distance_m"],
        }
    words = [peers, "drive", entry.cycles]
    last = [entry.kind, f"simulation.step_s={entry.step_s}"]
    once, _ = timed([*words, 1, *last])
    often, text = timed([*words, 1 + KERNEL_ROUNDS, *last])
    answer = json.loads(text)
    spent = (often - once) / KERNEL_ROUNDS
    return {
        "cpu_s": spent,
        "simulated_s": [answer["simulated_s"]],
        "distance_m": answer["distance_m"],
    }


def planning_s(peers: Path, cycles: int) -> float:
    """Time ocmc's sampling and planning alone."""
    none, _ = timed([peers, "drive", 1, 0, "baseline"])
    all_of_them, _ = timed([peers, "drive", cycles, 0, "baseline"])
    return all_of_them - none


def trips_needed(binary: Path) -> tuple[float, float]:
    """Trips that the mean needs for its precision: adjusted, as ocmc runs them, and plain."""
    words = [binary, "--seed", 1, "--quiet", "--json"]
    adjusted = json.loads(timed([*words, "--precision", f"{100 * PRECISION:g}%"])[1])["cycles"]
    plain = json.loads(timed([*words, "--cycles", PLAIN_TRIPS])[1])["statistics"][
        "consumption_l_per_100km"
    ]
    low, high = plain["ci95"]
    return adjusted, PLAIN_TRIPS * (0.5 * (high - low) / plain["mean"] / PRECISION) ** 2


def cpu_levels() -> list[str]:
    """Give the levels that ocmc has for this CPU, the best one last."""
    flags = cpu_flags()
    found = [level for level, flag in (("avx2", "avx2"), ("avx512", "avx512f")) if flag in flags]
    return found or ["baseline"]


def cpu_flags() -> set[str]:
    """Read what the CPU has."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    return {
        flag for line in lines if line.startswith("flags") for flag in line.split(":")[1].split()
    }


def cpu_name() -> str:
    """Read what the CPU is called."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    return next(
        (line.split(":")[1].strip() for line in lines if line.startswith("model name")),
        platform.machine(),
    )


def mean_difference(found: list[float], right: list[float]) -> float:
    """Mean absolute relative difference by cycle, infinite where a cycle was not finished."""
    cycles = len(right)
    total = sum(abs(value / right[k % cycles] - 1.0) for k, value in enumerate(found)) / len(found)
    return total if total == total else float("inf")  # noqa: PLR0124 - not a number


def judge(
    entry: Entry, answer: dict[str, Any], answers: dict[float, dict[str, list[float]]]
) -> None:
    """Compare a closed loop with ocmc at the same step and with ocmc at 1 ms."""

    def against(step_s: float) -> tuple[float, float]:
        right = answers[step_s]
        columns = ("wheel_energy_j", "fuel_kg")
        return tuple(mean_difference(answer[name], right[name][: entry.cycles]) for name in columns)

    entry.difference = max(against(entry.step_s))
    entry.bias = against(TRUTH_S)


def same_rules(
    worker: Worker, name: str, cycles: int, answers: dict[float, dict[str, list[float]]]
) -> None:
    """Say how far the cycles are from ocmc's with steps so short that only the rules count."""
    step_s = min(step_s for step_s in answers if step_s > TRUTH_S)
    answer = worker.round(step_s, cycles)
    for column in ("wheel_energy_j", "fuel_kg"):
        pairs = zip(answer[column], answers[TRUTH_S][column], strict=False)
        apart = [abs(found / right - 1.0) for found, right in pairs]
        mean, most = 100 * sum(apart) / len(apart), 100 * max(apart)
        say(
            f"{name}, steps of {step_s:g} s: {column} of a cycle differs by {mean:.4f} %, at most "
            f"{most:.4f} %"
        )


def record(entry: Entry, answer: dict[str, Any], mean_mps: float) -> None:
    """Book one round."""
    simulated_s = sum(answer["simulated_s"])
    # a rival drives the same cycles in the same time as ocmc does
    distance_m = answer.get("distance_m", simulated_s * mean_mps)
    entry.ns_per_s.append(answer["cpu_s"] / simulated_s * 1e9)
    entry.us_per_100km.append(answer["cpu_s"] / distance_m * 1e11)
    if "steps" in answer:
        entry.ns_per_step.append(answer["cpu_s"] / answer["steps"] * 1e9)


def figure(value: float) -> str:
    """Write three digits."""
    rounded = float(f"{value:.3g}")
    return f"{rounded:,.0f}" if rounded >= 100 else f"{rounded:.3g}"


def spread(values: list[float]) -> str:
    """Write median, lowest and highest value."""
    if not values:
        return ""
    return f"{figure(median(values))} ({figure(min(values))} to {figure(max(values))})"


@dataclass
class Table:
    """Common parts of the lines."""

    whole: Entry
    kernels: list[Entry]
    """Driving alone by level, the best one last."""
    planning_ns: list[float]
    """Sampling and planning, for each simulated second."""
    trip_s: float
    """Simulated time of a trip."""
    adjusted: float
    plain: float
    """Trips that a mean needs."""

    @property
    def head(self) -> str:
        """Write what the columns are."""
        times = [f"times ocmc, {LEVELS[kernel.kind]}" for kernel in self.kernels]
        cells = [
            "program",
            "step, s",
            "bias of wheel energy / fuel against 1 ms, %",
            "difference from ocmc, %",
            "ns per simulated second",
            *times,
            "with the road in both",
            f"CPU to ± {100 * PRECISION:g} %, s",
        ]
        return "| " + " | ".join(cells) + " |\n" + "|---" * len(cells) + "|"

    def row(self, entry: Entry) -> str:
        """Write a line; no ratio where the energies differ."""
        percent = (
            "" if entry.bias is None else " / ".join(f"{100 * bias:.3f}" for bias in entry.bias)
        )
        same = "" if entry.difference is None else f"{100 * entry.difference:.4f}"
        best, road = self.kernels[-1].ns_per_s, self.planning_ns
        own = entry is self.whole or entry in self.kernels
        needs = self.adjusted if own else self.plain
        with_road = entry.ns_per_s
        if entry is not self.whole:
            with_road = [there + way for there, way in zip(entry.ns_per_s, road, strict=False)]
        cpu = figure(median(with_road) * 1e-9 * self.trip_s * needs)
        if not entry.agrees:
            ratios, cpu = ["energies differ: no ratio"] * (len(self.kernels) + 1), ""
        elif own:
            ratios = [""] * (len(self.kernels) + 1)
        else:
            pairs = [zip(entry.ns_per_s, base.ns_per_s, strict=False) for base in self.kernels]
            pairs.append(
                zip(
                    with_road,
                    [here + way for here, way in zip(best, road, strict=False)],
                    strict=False,
                )
            )
            ratios = [spread([there / here for there, here in pair]) for pair in pairs]
        step = f"{entry.step_s:g}" + (" (needed)" if entry.needed else "")
        return (
            "| "
            + " | ".join([entry.name, step, percent, same, spread(entry.ns_per_s), *ratios, cpu])
            + " |"
        )


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--cycles", type=int, default=128, help="exported scenarios")
    parser.add_argument("--folder", type=Path, default=ROOT / "target/peers")
    parser.add_argument("--no-build", action="store_true", help="take ocmc as it was built last")
    parser.add_argument("--only", nargs="*", help="these rivals alone")
    return parser.parse_args()


def prepare(options: argparse.Namespace, peers: Path) -> dict[str, Any]:
    """Export the scenarios, unless this program has done so before."""
    exported = options.folder / f"scenarios-{options.cycles}"
    answers = exported / "scenarios.json"
    if not answers.exists() or answers.stat().st_mtime < peers.stat().st_mtime:
        say(f"exporting {options.cycles} scenarios, with answers down to steps of 1 ms")
        exported.mkdir(parents=True, exist_ok=True)
        timed([peers, "export", exported, options.cycles])
    return {"folder": exported, "answers": json.loads(answers.read_text())["answers"]}


def checked_on_trace(worker: Worker, entry: Entry, peers: Path) -> None:
    """Let ocmc follow the rival's speeds with the rival's body, and compare the wheel work."""
    checks = worker.about["checks"][str(entry.step_s)]
    found = [
        json.loads(timed([peers, "follow"], json.dumps(check["follow"]))[1])["wheel_j"]
        for check in checks
    ]
    entry.difference = max(
        abs(check["wheel_j"] / wheel_j - 1.0) for check, wheel_j in zip(checks, found, strict=True)
    )


def enter(
    worker: Worker,
    rival: tuple,
    answers: dict[float, dict[str, list[float]]],
    allowed: tuple[float, float],
    peers: Path,
) -> list[Entry]:
    """Try a rival's steps: the customary ones, and the longest one with an allowed bias.

    It is the bias of wheel energy and fuel.
    """
    kind, name, customary, tries, cycles = rival
    entries = [Entry(kind, name, step_s, cycles) for step_s in customary]
    if worker.about["checks"]:
        for entry in entries:
            checked_on_trace(worker, entry, peers)
        return entries
    for entry in entries:
        judge(entry, worker.round(entry.step_s, cycles), answers)
    if tries:
        same_rules(worker, name, cycles, answers)
    steps = [step_s for step_s in answers if step_s > TRUTH_S] if tries else customary
    for step_s in sorted(steps, reverse=True):
        entry = next((entry for entry in entries if entry.step_s == step_s), None)
        if entry is None:
            entry = Entry(kind, name, step_s, cycles)
            judge(entry, worker.round(step_s, entry.cycles), answers)
        if all(bias <= most for bias, most in zip(entry.bias, allowed, strict=True)):
            entry.needed = True
            return entries if entry in entries else [*entries, entry]
    say(f"{name}: no step is right enough")
    return entries


def main() -> None:
    """Run everything."""
    options = arguments()
    options.folder.mkdir(parents=True, exist_ok=True)
    if hasattr(os, "sched_setaffinity"):  # everything on one core
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    os.environ |= {"OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
    os.environ.setdefault("OCMC_DATA", str(ROOT.parent / "shared/data"))
    python = environment(options.folder)
    if not options.no_build:
        say("building ocmc")
        timed(
            [
                "cargo",
                "build",
                "--release",
                "--quiet",
                "--manifest-path",
                ROOT / "Cargo.toml",
                "--bin",
                "ocmc",
                "--example",
                "peers",
            ]
        )
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    binary, peers = target / "ocmc", target / "examples/peers"
    given = prepare(options, peers)
    answers = {answer["step_s"]: answer for answer in given["answers"]}
    ours = answers[DEFAULT_STEP_S]
    mean_mps = sum(ours["distance_m"]) / sum(ours["simulated_s"])

    whole = Entry("ocmc", "**ocmc**, a whole run", DEFAULT_STEP_S, 16 * options.cycles)
    kernels = [
        Entry(level, f"ocmc, driving alone, {LEVELS[level]}", DEFAULT_STEP_S, 4 * options.cycles)
        for level in cpu_levels()
    ]
    for entry in (whole, *kernels):
        judge(entry, answers[DEFAULT_STEP_S], answers)
        entry.difference = None
    allowed = tuple(max(EQUAL_ERROR, ceil(bias / ROUNDING) * ROUNDING) for bias in whole.bias)
    entries, workers, versions = [whole, *kernels], {}, {}
    for rival in RIVALS:
        kind, cycles = rival[0], min(rival[4], options.cycles)
        if options.only is not None and kind not in options.only:
            continue
        say(f"preparing {kind}")
        try:
            worker = Worker(python, given["folder"], kind)
            entries += enter(worker, (*rival[:4], cycles), answers, allowed, peers)
        except RuntimeError as error:
            say(f"SKIPPED {kind}: {error}")
            continue
        workers[kind] = worker
        versions |= worker.about["versions"]
    adjusted, plain = trips_needed(binary)
    trip_s = sum(ours["simulated_s"]) / len(ours["simulated_s"])
    table = Table(whole, kernels, [], trip_s, adjusted, plain)
    for k in range(options.rounds):
        say(f"round {k + 1} of {options.rounds}")
        for entry in entries:
            if entry.kind in workers:
                answer = workers[entry.kind].round(entry.step_s, entry.cycles)
            else:
                answer = ocmc_round(entry, binary, peers)
            record(entry, answer, mean_mps)
            if entry is kernels[-1]:
                spent = planning_s(peers, entry.cycles)
                table.planning_ns.append(spent / sum(answer["simulated_s"]) * 1e9)

    said = ", ".join(f"{name} {number}" for name, number in versions.items())
    python_version = timed([python, "--version"])[1].strip()
    print(
        f"{datetime.now(UTC):%Y-%m-%d}, {cpu_name()}, one core, user CPU time, median (lowest to "
        f"highest) of {options.rounds} rounds in turns. "
    )
    print(f"ocmc {timed([binary, '--version'])[1].split()[1]}, {python_version}, {said}.\n")
    print(f"Sampling and planning: {spread(table.planning_ns)} ns per simulated second. ")
    print(
        f"Trips to ± {100 * PRECISION:g} %: {adjusted:.0f} with adjusted means, {plain:.0f} "
        "without.\n"
    )
    print(table.head)
    for entry in entries:
        print(table.row(entry))
    raw = [vars(entry) for entry in entries]
    (options.folder / "rounds.json").write_text(json.dumps(raw, indent=1))


if __name__ == "__main__":
    main()
