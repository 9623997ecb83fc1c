"""Measures `ocmc benchmark` against invented fleets whose trucks are known.

A pool of trips is driven once. Each fleet draws its trips from it without putting back, its trucks
have effects on the fuel that are known, and the fuel is read with noise. Printed are the rank
correlation of estimated and true effects, how often the 95 % intervals of trucks cover, how many of
the fleets whose trucks do not differ are said not to, and how often the interval of a saving since
a date covers. The fleets' study may be another one than that which expects (`--off`), their trips
may be heavy on some trucks, and some rows are written down twice. Python's standard library is
enough.

    python scripts/benchmark_check.py OCMC --fleets 40 --null 100 --saving 100
"""

# ruff: noqa: PLR0913, PLR0915, PLR0917, PLR2004, S311 (invented fleets, one after the other)
import argparse
import csv
import datetime as dt
import json
import math
import random
import subprocess
import sys
import tempfile
from pathlib import Path

NOISE = 0.03
LENGTHS = '{ distribution = "uniform", lower = 10000.0, upper = 40000.0 }'
OFF = ["vehicle.drag_area_m2=6.2", "vehicle.powertrain.combustion.engine.fuel_factor=1.06"]
START = dt.date(2023, 1, 1)


def run(program, *arguments):
    """Run the command, and return what it prints."""
    done = subprocess.run(
        [program, *map(str, arguments)], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise RuntimeError(f"{arguments}: {done.stderr}")
    return done.stdout


def pool(program, folder, trips, sets):
    """Drive trips, and return those that were completed."""
    options = [x for value in sets for x in ("--set", value)]
    run(
        program,
        *options,
        "--cycles",
        trips,
        "--seed",
        77,
        "--out",
        folder,
        "--format",
        "csv",
        "--quiet",
    )
    with (folder / "records.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["outcome"] == "completed"]
    keys = [
        "distance_m",
        "consumption_l_per_100km",
        "payload_kg",
        "climb_m",
        "departure_s_of_year",
        "duration_s",
    ]
    return [{key: float(row[key]) for key in keys} for row in rows]


def fleet(trips, draw, path, options, truck_sd, driver_sd=0.0, saving=0.0):
    """Write the table of a fleet; return the true effects of its trucks and drivers."""
    n = options.trucks * options.trips
    drawn = draw.sample(trips, n)
    if options.sorted:
        # some trucks carry more than others
        drawn.sort(key=lambda trip: trip["payload_kg"] + draw.gauss(0, 6000))
    trucks = [draw.gauss(0, truck_sd) for _ in range(options.trucks)]
    drivers = [draw.gauss(0, driver_sd) for _ in range(options.trucks)]
    rows, since = [], START + dt.timedelta(days=365)
    for k, trip in enumerate(drawn):
        truck = k // options.trips
        driver = draw.randrange(max(truck - 2, 0), min(truck + 3, options.trucks))
        # the pool has the season of its own departure
        day = START + dt.timedelta(
            days=int(trip["departure_s_of_year"] // 86400) + 365 * draw.randrange(2)
        )
        effect = trucks[truck] + drivers[driver] + (math.log(1 - saving) if day >= since else 0.0)
        km = trip["distance_m"] / 1e3
        fuel = trip["consumption_l_per_100km"] * km / 100
        fuel *= math.exp(effect + NOISE * draw.gauss(0, 1))
        if draw.random() < options.doubled:
            fuel *= 2
        weight = options.curb_kg + trip["payload_kg"]
        rows.append([f"t{truck}", day.isoformat(), f"{km:.3f}", f"{fuel:.4f}", f"{weight:.0f}"])
        rows[-1] += [f"{trip['duration_s'] / 3600:.4f}"] if options.hours else []
        rows[-1] += [f"{trip['climb_m']:.0f}"] if options.climb else []
        rows[-1] += [f"name{driver}"] if driver_sd else []
    head = ["truck", "date", "distance_km", "fuel_l", "gross_weight_kg"]
    head += ["driving_time_h"] if options.hours else []
    head += (["climb_m"] if options.climb else []) + (["driver"] if driver_sd else [])
    path.write_text("\n".join(",".join(row) for row in [head, *rows]) + "\n")
    return {f"t{k}": effect for k, effect in enumerate(trucks)}, since


def ranks(values):
    """Rank values."""
    order = sorted(range(len(values)), key=values.__getitem__)
    found = [0] * len(values)
    for rank, place in enumerate(order):
        found[place] = rank
    return found


def correlation(a, b):
    """Rank correlation."""
    a, b = ranks(a), ranks(b)
    n = len(a)
    return 1 - 6 * sum((x - y) ** 2 for x, y in zip(a, b, strict=True)) / (n * (n * n - 1))


def level_of(answer, name):
    """Find a level of an answer."""
    return next(level for level in answer["levels"] if level["level"] == name)


def main():
    """Reckon, and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("ocmc")
    parser.add_argument("--fleets", type=int, default=40, help="fleets with effects of trucks")
    parser.add_argument("--null", type=int, default=0, help="fleets whose trucks do not differ")
    parser.add_argument("--saving", type=int, default=0, help="fleets with 3 %% less since a date")
    parser.add_argument("--trucks", type=int, default=100)
    parser.add_argument("--trips", type=int, default=30, help="of each truck")
    parser.add_argument("--pool", type=int, default=12000)
    parser.add_argument("--cycles", type=int, default=800, help="of the study that expects")
    parser.add_argument("--sd", type=float, default=0.03, help="of the trucks' effects")
    parser.add_argument("--driver-sd", type=float, default=0.0)
    parser.add_argument(
        "--doubled", type=float, default=0.002, help="share of rows with two trips' fuel"
    )
    parser.add_argument("--curb-kg", type=float, default=15250.0)
    parser.add_argument("--no-hours", dest="hours", action="store_false", help="no driving times")
    parser.add_argument("--climb", action="store_true", help="the table has a column climb_m")
    parser.add_argument("--sorted", action="store_true", help="some trucks carry more")
    parser.add_argument("--off", action="store_true", help="the fleets' study is another one")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sets = [f"mission.length_m={LENGTHS}", *(OFF if options.off else [])]
        trips = pool(options.ocmc, folder / "pool", options.pool, sets)
        print(f"{len(trips)} trips in the pool", flush=True)

        def asked(table, *more):
            done = run(
                options.ocmc,
                "benchmark",
                table,
                "--cycles",
                options.cycles,
                "--json",
                "--quiet",
                *more,
            )
            return json.loads(done)

        rank, covered, far, silent = [], [], 0, 0
        for f in range(options.fleets):
            table = folder / f"f{f}.csv"
            true, _ = fleet(
                trips, random.Random(100 + f), table, options, options.sd, options.driver_sd
            )
            answer = asked(table)
            level = level_of(answer, "truck")
            far += len(answer["far"])
            silent += not level["differ"]
            members = level["members"]
            if members:
                truth = [true[member["name"]] for member in members]
                rank.append(correlation([member["ratio"] for member in members], truth))
                for member, effect in zip(members, truth, strict=True):
                    low, high = member["ci95"]
                    covered.append(low <= math.exp(effect) <= high)
        if rank:
            rank.sort()
            print(f"{len(rank)} fleets with effects, {silent} more said to have none")
            print(f"rank correlation: mean {sum(rank) / len(rank):.3f}, least {rank[0]:.3f}")
            held, n = sum(covered), len(covered)
            print(f"95 % intervals of trucks cover {held} of {n} = {held / n:.4f}")
            print(f"far rows {far} of {n * options.trips}", flush=True)
        none = 0
        for f in range(options.null):
            table = folder / "n.csv"
            fleet(trips, random.Random(5000 + f), table, options, 0.0)
            none += not level_of(asked(table), "truck")["differ"]
        if options.null:
            print(
                f"fleets without differences: {none} of {options.null} said to have none",
                flush=True,
            )
        within, changes = 0, []
        for f in range(options.saving):
            table = folder / "s.csv"
            _, since = fleet(
                trips, random.Random(9000 + f), table, options, options.sd, saving=0.03
            )
            found = asked(table, "--since", since.isoformat())["compared"][0]
            changes.append(found["change"])
            within += found["ci95"][0] <= -0.03 <= found["ci95"][1]
        if changes:
            mean = sum(changes) / len(changes)
            print(
                f"saving of 3 %: mean {100 * mean:+.2f} %, 95 % intervals cover {within} of "
                f"{len(changes)}"
            )


if __name__ == "__main__":
    sys.exit(main())
