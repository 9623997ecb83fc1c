#!/usr/bin/env python3
"""Reasons for gear shifts.

``python3 benches/shifts.py [--study field-truck] [--cycles 400] [--vecto FOLDER]``

Traces of a study and time series of VECTO (`.vmod`, `.vmod.gz`) are cut into pieces of 5 km. Shifts
per km of a piece are regressed, by least squares, on its stops and changes of the limit per km, the
share of its way that is steeper than 2 %, and its road types (of VECTO: its missions). A table in
Markdown, with standard errors: pieces of one drive count as one observation, those of VECTO's few
drives each by itself. ``--many 800`` lists the cycles of the run with more shifts per 100 km, and
how many of their shifts lie near a stop. Needs numpy and `cargo build --release`.
"""

import argparse
import csv
import gzip
import io
import subprocess
import tempfile
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
from checks import BINARY

PIECE_M = 5000.0
STEEP = 0.02
# a shift this near to a stop line is one of arriving or starting
NEAR_M = 300.0
# changes of a limit below it are none, in m/s
SAME_MPS = 0.1


class Drive(NamedTuple):
    """A drive, row by row."""

    position_m: np.ndarray
    gear: np.ndarray
    grade: np.ndarray
    limit_mps: np.ndarray
    rests: np.ndarray
    """Whether the row is a standstill."""
    kinds: list[str]
    """Road type or mission of each row."""


class Piece(NamedTuple):
    """Some kilometres of a drive."""

    drive: int
    kinds: dict[str, float]
    """Share of its way by road type."""
    stops_per_km: float
    limits_per_km: float
    steep: float
    shifts_per_km: float


def table(text: str) -> list[list[str]]:
    """Give the rows of a CSV text, the head among them."""
    return list(csv.reader(io.StringIO(text)))


def said(*words: object) -> str:
    """Run the program and give what it prints."""
    return subprocess.run(
        [BINARY, *map(str, words)], check=True, capture_output=True, text=True
    ).stdout


def driven(study: str, sets: Sequence[str], seed: int, cycle_id: int) -> Drive:
    """Drive one cycle of a study."""
    which = ["--study", study, "--seed", seed, "--cycle-id", cycle_id]
    which += [word for value in sets for word in ("--set", value)]
    head, *rows = table(said("trace", *which))
    values = np.array([[float(cell or "nan") for cell in row] for row in rows])
    column = {name: values[:, k] for k, name in enumerate(head)}
    tracks = [row for row in table(said("cycle", *which)) if row[0] == "road_type"]
    starts = np.array([float(row[2]) for row in tracks])
    places = np.searchsorted(starts, column["position_m"], side="right") - 1
    return Drive(
        column["position_m"],
        column["gear"],
        column["grade"],
        column["limit_mps"],
        column["simulated_added_s"] == 0.0,
        [tracks[max(place, 0)][3] for place in places],
    )


def of_vecto(path: Path) -> Drive:
    """Read a time series of VECTO. Its name says the mission; gear 0 is a gap, and no gear."""
    opened = gzip.open if path.suffix == ".gz" else open
    with opened(path, "rt", encoding="utf-8-sig", errors="replace") as file:
        head, *rows = table(file.read())
    names = [name.split("[")[0].strip() for name in head]
    column = {
        name: np.array([float(row[k]) for row in rows])
        for k, name in enumerate(names)
        if name in {"dist", "v_act", "v_targ", "grad", "Gear"}
    }
    gear = held(column["Gear"])
    limit = held(column["v_targ"] / 3.6)
    mission = "regional" if "regional" in path.name.lower() else "long haul"
    rests = column["v_act"] <= 0.0
    return Drive(column["dist"], gear, column["grad"] / 100.0, limit, rests, [mission] * len(gear))


def held(values: np.ndarray) -> np.ndarray:
    """Replace zeros by what comes next to them: before, or at the beginning after."""
    filled = values.copy()
    for k in range(1, len(filled)):
        filled[k] = filled[k] or filled[k - 1]
    for k in range(len(filled) - 2, -1, -1):
        filled[k] = filled[k] or filled[k + 1]
    return filled


def pieces(drive: Drive, number: int) -> Iterable[Piece]:
    """Cut a drive; what is left at its end is dropped."""
    way = np.diff(drive.position_m, prepend=0.0)
    moving = ~drive.rests
    begins = drive.rests & np.concatenate([[False], moving[:-1]])
    shifts = np.concatenate([[False], np.diff(drive.gear) != 0.0]) & moving
    # a gear that is chosen at rest is no shift
    shifts &= ~np.concatenate([[True], drive.rests[:-1]])
    limits = np.concatenate([[False], np.abs(np.diff(drive.limit_mps)) > SAME_MPS])
    place = (drive.position_m / PIECE_M).astype(int)
    kinds = np.array(drive.kinds)
    for k in range(int(drive.position_m[-1] // PIECE_M)):
        here = place == k
        length_m = way[here].sum()
        km = length_m / 1000.0
        if km > 0.0:
            shares = {
                str(kind): way[here & (kinds == kind)].sum() / length_m
                for kind in np.unique(kinds[here])
            }
            steep = way[here & (np.abs(drive.grade) > STEEP)].sum() / length_m
            counts = [sum(found[here]) / km for found in (begins, limits, shifts)]
            yield Piece(number, shares, counts[0], counts[1], steep, counts[2])


def regression(
    found: Sequence[Piece], together: bool
) -> tuple[list[str], np.ndarray, np.ndarray, float]:
    """Give names, coefficients, standard errors and R².

    ``together``: the pieces of a drive are one observation.
    """
    kinds = sorted({kind for piece in found for kind in piece.kinds})
    names = [
        "stop",
        "change of the limit",
        "way steeper than 2 %, km",
        *(f"km, {kind}" for kind in kinds),
    ]
    known = np.array(
        [
            [p.stops_per_km, p.limits_per_km, p.steep, *(p.kinds.get(k, 0.0) for k in kinds)]
            for p in found
        ]
    )
    # what a study has turned off is left out
    present = known.any(axis=0)
    names = [name for name, kept in zip(names, present, strict=True) if kept]
    known = known[:, present]
    shifts = np.array([piece.shifts_per_km for piece in found])
    inverse = np.linalg.inv(known.T @ known)
    solution = inverse @ known.T @ shifts
    rest = shifts - known @ solution
    groups = np.array([piece.drive for piece in found]) if together else np.arange(len(found))
    scores = np.array(
        [known[groups == group].T @ rest[groups == group] for group in np.unique(groups)]
    )
    n, observations, unknowns = len(found), len(scores), known.shape[1]
    factor = observations / (observations - 1) * (n - 1) / (n - unknowns)
    errors = np.sqrt(factor * np.diag(inverse @ scores.T @ scores @ inverse))
    return names, solution, errors, 1.0 - rest.var() / shifts.var()


def show(title: str, found: Sequence[Piece], together: bool) -> None:
    """Print a table."""
    names, solution, errors, share = regression(found, together)
    mean = np.mean([piece.shifts_per_km for piece in found])
    print(f"\n{title}: {len(found)} pieces, {mean:.2f} shifts per km, R² {share:.2f}\n")
    print("| for each | shifts |\n|---|---|")
    for name, value, error in zip(names, solution, errors, strict=True):
        print(f"| {name} | {value:.2f} ± {error:.2f} |")


def many(study: str, sets: Sequence[str], seed: int, cycles: int, limit: float) -> None:
    """List the cycles with more shifts per 100 km than ``limit``, and where these are."""
    words = ["--study", study, "--seed", seed, "--cycles", cycles, "--quiet"]
    words += [word for value in sets for word in ("--set", value)]
    with tempfile.TemporaryDirectory() as folder:
        said(*words, "--out", f"{folder}/run", "--format", "csv")
        head, *rows = table((Path(folder) / "run/records.csv").read_text())
    column = {name: k for k, name in enumerate(head)}
    print(f"\nMore than {limit:.0f} shifts per 100 km in {cycles} cycles:\n")
    print("| cycle | shifts per 100 km | stops per km | shifts near a stop, % |\n|---|---|---|---|")
    for row in rows:
        km = float(row[column["distance_m"]]) / 1000.0
        rate = 100.0 * float(row[column["n_gear_shifts"]]) / km
        if rate > limit:
            cycle_id = int(row[column["cycle_id"]])
            drive = driven(study, sets, seed, cycle_id)
            stops = drive.position_m[drive.rests]
            shifts = drive.position_m[1:][(np.diff(drive.gear) != 0.0) & ~drive.rests[1:]]
            near = np.mean([np.abs(stops - place).min() < NEAR_M for place in shifts])
            n_stops = float(row[column["n_stops"]])
            print(f"| {cycle_id} | {rate:.0f} | {n_stops / km:.2f} | {100.0 * near:.0f} |")


def main() -> None:
    """Compare."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--study", default="field-truck")
    parser.add_argument("--set", action="append", default=[], dest="sets")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cycles", type=int, default=400)
    parser.add_argument("--vecto", type=Path)
    parser.add_argument("--many", type=float)
    given = parser.parse_args()
    with ThreadPoolExecutor() as pool:
        drives = pool.map(
            lambda k: driven(given.study, given.sets, given.seed, k), range(given.cycles)
        )
        found = [piece for k, drive in enumerate(drives) for piece in pieces(drive, k)]
    show(given.study, found, together=True)
    if given.vecto:
        paths = sorted(path for path in given.vecto.iterdir() if ".vmod" in path.suffixes)
        show(
            "VECTO",
            [p for k, path in enumerate(paths) for p in pieces(of_vecto(path), k)],
            together=False,
        )
    if given.many:
        many(given.study, given.sets, given.seed, given.cycles, given.many)


if __name__ == "__main__":
    main()
