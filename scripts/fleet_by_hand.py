#!/usr/bin/env python3
"""A fleet of trucks by hand, beside the program's own: one study a truck.

In each, the driver and the truck are frozen.

    scripts/fleet_by_hand.py OCMC [--trucks 400] [--trips 50] [--length 20000]

OCMC is the program. By hand, truck k is a run of its own seed in which every trip takes driver and
truck from cycle 0 (`simulation.frozen`); nested, it is truck k of one run with `--trucks --trips`.
The draws differ, the laws do not: mean, SD of trips, SD between the means of trucks, and the
variance between trucks have to agree within two standard errors of their difference. Exit status 1
where they do not.
"""

import argparse
import csv
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile

COLUMN = "consumption_l_per_100km"
# standard errors by which both may differ
FURTHEST = 2


def records(ocmc: str, out: pathlib.Path, *options: str) -> list[dict[str, str]]:
    """Run the program and read its records."""
    subprocess.run(
        [ocmc, "--quiet", "--format", "csv", "--out", str(out), *options],
        check=True,
        capture_output=True,
    )
    with (out / "records.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def consumption(trips: list[dict[str, str]]) -> list[float]:
    """Give the consumption of the completed trips."""
    return [float(trip[COLUMN]) for trip in trips if trip["outcome"] == "completed"]


def levels(trucks: list[list[float]]) -> dict[str, tuple[float, float]]:
    """Give each level's figure with its standard error.

    Those of spreads are by leaving out one truck at a time.
    """
    means = [statistics.fmean(trips) for trips in trucks]
    n = len(trucks)

    def jackknife(figure: "object") -> tuple[float, float]:
        whole = figure(list(range(n)))  # type: ignore[operator]
        others = ([k for k in range(n) if k != left] for left in range(n))
        parts = [figure(rows) for rows in others]  # type: ignore[operator]
        centre = statistics.fmean(parts)
        return whole, math.sqrt((n - 1) / n * sum((part - centre) ** 2 for part in parts))

    sums = [(len(trips), sum(trips), sum(x * x for x in trips)) for trips in trucks]

    def sd_of_trips(rows: list[int]) -> float:
        count, total, squares = (sum(sums[k][i] for k in rows) for i in range(3))
        return math.sqrt((squares - total * total / count) / (count - 1))

    def between(rows: list[int]) -> float:
        within = sum(sums[k][2] - sums[k][1] ** 2 / sums[k][0] for k in rows) / sum(
            sums[k][0] - 1 for k in rows
        )
        trips = statistics.fmean([sums[k][0] for k in rows])
        return statistics.variance([means[k] for k in rows]) - within / trips

    return {
        "mean of trucks": (statistics.fmean(means), statistics.stdev(means) / math.sqrt(n)),
        "SD of trips": jackknife(sd_of_trips),
        "SD of trucks' means": jackknife(lambda rows: statistics.stdev([means[k] for k in rows])),
        "variance between trucks": jackknife(between),
    }


def main() -> int:
    """Drive both fleets and compare them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("ocmc")
    parser.add_argument("--trucks", type=int, default=400)
    parser.add_argument("--trips", type=int, default=50)
    parser.add_argument("--length", type=int, default=20_000, help="of a trip, in m")
    arguments = parser.parse_args()
    trucks, trips = arguments.trucks, arguments.trips
    length = f"mission.length_m={arguments.length}"
    with tempfile.TemporaryDirectory() as folder:
        base = pathlib.Path(folder)
        options = ["--set", length, "--trucks", str(trucks), "--trips", str(trips), "--seed", "1"]
        nested = consumption_of_trucks(records(arguments.ocmc, base / "nested", *options))
        hand = []
        for truck in range(trucks):
            frozen = 'simulation.frozen=["driver", "vehicle"]'
            seed = str(1_000_000 + truck)
            options = ["--set", length, "--set", frozen, "--cycles", str(trips), "--seed", seed]
            hand.append(consumption(records(arguments.ocmc, base / f"{truck}", *options)))
    agree = True
    print(f"{trucks} trucks x {trips} trips of {arguments.length} m, {COLUMN}")
    print(f"{'':<24}{'by hand':>18}{'nested':>18}{'apart, SE':>11}")
    other = levels(hand)
    for name, (value, error) in levels(nested).items():
        by_hand, error_by_hand = other[name]
        apart = (value - by_hand) / math.hypot(error, error_by_hand)
        agree &= abs(apart) <= FURTHEST
        print(
            f"{name:<24}{by_hand:>10.3f} ± {error_by_hand:.3f}{value:>10.3f} ± "
            f"{error:.3f}{apart:>11.2f}"
        )
    return 0 if agree else 1


def consumption_of_trucks(trips: list[dict[str, str]]) -> list[list[float]]:
    """Give the consumption of each truck's completed trips."""
    of: dict[str, list[dict[str, str]]] = {}
    for trip in trips:
        of.setdefault(trip["truck_id"], []).append(trip)
    return [consumption(of_truck) for of_truck in of.values()]


if __name__ == "__main__":
    sys.exit(main())
