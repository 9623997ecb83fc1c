#!/usr/bin/env python3
"""From a study to logs, to a fitted study, and back: two fleets with other roads than the default.

    scripts/road_round_trip.py OCMC [--logs 200] [--cycles 4000] [--seed 5] [--directory DIR]

Each log is a trip of the fleet at 1 Hz: position, speed with 0.05 m/s of noise, altitude with 3 m,
yaw rate with 0.003 rad/s, the limit of trucks, the road type, and the objects of a map beside the
way. `fit operating-cycle` fits a study to the logs, over the default one. Mean, P5, P50 and P95 of
its litres per 100 km have to lie within 3 % of the fleet's own. Exit status 1 where one does not.
"""

import argparse
import bisect
import concurrent.futures
import csv
import json
import pathlib
import random
import subprocess
import sys
import tempfile

BASE = "field-truck"
FLEETS = {
    "hilly, long roads": {
        "mission.length_m": 60000,
        "road.types.urban.topography.slope_sd": 0.022,
        "road.types.urban.topography.hill_length_m": 430,
        "road.types.rural.topography.slope_sd": 0.031,
        "road.types.rural.topography.hill_length_m": 900,
        "road.types.motorway.topography.slope_sd": 0.014,
        "road.types.motorway.topography.hill_length_m": 1600,
        "road.types.urban.mean_length_m": 7000,
        "road.types.rural.mean_length_m": 9000,
        "road.types.urban.traffic_lights.per_m": 0.0016,
        "road.types.rural.give_ways.per_m": 0.0004,
        "road.types.rural.curves.per_m": 0.0018,
    },
    "flat, small towns": {
        "mission.length_m": 40000,
        "road.types.urban.topography.slope_sd": 0.009,
        "road.types.urban.topography.hill_length_m": 700,
        "road.types.rural.topography.slope_sd": 0.012,
        "road.types.rural.topography.hill_length_m": 520,
        "road.types.motorway.topography.slope_sd": 0.024,
        "road.types.motorway.topography.hill_length_m": 1100,
        "road.types.urban.mean_length_m": 2500,
        "road.types.rural.mean_length_m": 22000,
        "road.types.urban.traffic_lights.per_m": 0.0006,
        "road.types.rural.curves.per_m": 0.0005,
    },
}
# tracks of events, and the object that a map has there
OBJECTS = {
    "stop_sign_s": "stop_sign",
    "give_way_stop_s": "give_way",
    "give_way_pass_mps": "give_way",
    "red_light_s": "traffic_light",
    "green_light": "traffic_light",
    "speed_bump_height_m": "speed_bump",
}
COLUMNS = [
    "time_s",
    "position_m",
    "speed_mps",
    "altitude_m",
    "limit_mps",
    "road_type",
    "yaw_rate_radps",
]
FURTHEST = 0.03


def table(ocmc: str, *options: str) -> list[dict[str, str]]:
    """Run the program and read the table that it prints."""
    printed = subprocess.run([ocmc, *options], check=True, capture_output=True, text=True).stdout
    return list(csv.DictReader(printed.splitlines()))


def log(ocmc: str, options: list[str], cycle: int, path: pathlib.Path) -> None:
    """Write the log of one trip."""
    which = [*options, "--cycle-id", str(cycle)]
    rows = table(ocmc, "trace", *which)
    times = [float(row["time_s"]) for row in rows]
    tracks: dict[str, list[tuple[float, str]]] = {}
    for point in table(ocmc, "cycle", *which):
        tracks.setdefault(point["track"], []).append((float(point["position_m"]), point["value"]))
    altitudes = [(at, float(value)) for at, value in tracks["altitude_m"]]
    types = tracks["road_type"]
    noise = random.Random(f"{options} {cycle}")  # noqa: S311
    logged: list[list[object]] = []
    for second in range(int(times[-1]) + 1):
        row = rows[bisect.bisect_left(times, second)]
        at = float(row["position_m"])
        j = min(max(bisect.bisect_right(altitudes, (at, float("inf"))) - 1, 0), len(altitudes) - 2)
        (left, low), (right, high) = altitudes[j], altitudes[j + 1]
        altitude = low + (high - low) * (at - left) / (right - left)
        kind = types[max(bisect.bisect_right(types, (at, chr(0x10FFFF))) - 1, 0)][1]
        speed = max(0.0, float(row["speed_mps"]) + noise.gauss(0, 0.05))
        yaw = float(row["yaw_rate_radps"]) + noise.gauss(0, 0.003)
        logged.append(
            [second, at, speed, altitude + noise.gauss(0, 3), row["limit_mps"], kind, yaw, ""]
        )
    positions = [row[1] for row in logged]
    for track, name in OBJECTS.items():
        for at, _ in tracks.get(track, []):
            k = min(bisect.bisect_left(positions, at), len(logged) - 1)
            while logged[k][-1] and k + 1 < len(logged):
                k += 1
            logged[k][-1] = name
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([[*COLUMNS, "map_object"], *logged])


def litres(ocmc: str, cycles: int, *options: str) -> dict[str, float]:
    """Statistics of the litres per 100 km of a study."""
    command = [ocmc, *options, "--cycles", str(cycles), "--seed", "77", "--quiet", "--json"]
    answer = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return json.loads(answer)["statistics"]["consumption_l_per_100km"]


def main() -> int:
    """Make the round trip of both fleets."""
    parser = argparse.ArgumentParser(description="Studies that come back from their logs.")
    parser.add_argument("ocmc")
    parser.add_argument("--logs", type=int, default=200)
    parser.add_argument("--cycles", type=int, default=4000)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--directory", type=pathlib.Path)
    arguments = parser.parse_args()
    failed = False
    with tempfile.TemporaryDirectory() as scratch:
        root = arguments.directory or pathlib.Path(scratch)
        for name, keys in FLEETS.items():
            directory = root / name.replace(", ", "-").replace(" ", "-")
            directory.mkdir(parents=True)
            fleet = [
                "--study",
                BASE,
                *(part for key in keys for part in ("--set", f"{key}={keys[key]}")),
            ]
            seeded = [*fleet, "--seed", str(arguments.seed)]
            paths = [directory / f"{cycle}.csv" for cycle in range(arguments.logs)]
            with concurrent.futures.ThreadPoolExecutor() as pool:
                tasks = [
                    pool.submit(log, arguments.ocmc, seeded, cycle, path)
                    for cycle, path in enumerate(paths)
                ]
                for task in tasks:
                    task.result()
            study = directory / "fitted.toml"
            subprocess.run(
                [
                    arguments.ocmc,
                    "fit",
                    "operating-cycle",
                    *paths,
                    "--base",
                    BASE,
                    "--study-out",
                    study,
                ],
                check=True,
                capture_output=True,
            )
            own = litres(arguments.ocmc, arguments.cycles, *fleet)
            fitted = litres(arguments.ocmc, arguments.cycles, "--study", str(study))
            for key in ("mean", "p5", "p50", "p95"):
                off = fitted[key] / own[key] - 1
                failed |= abs(off) > FURTHEST
                print(
                    f"{name}: {key:4} {own[key]:.2f}, fitted {fitted[key]:.2f} L/100 km, {off:+.1%}"
                )
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
