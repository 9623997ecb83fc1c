"""How well `ocmc learn` does on made-up exports of a hilly, heavy fleet whose truth is known.

A fleet has judged numbers of `field-truck` drawn with the ends of their ranges as one SD, hills
half as steep again, heavy loads, and takes at least a fifth more than the default. Its export is a
folder with a table of 60 trips (3 % noise of fuel, 5 % of weight) and either logs of 1 Hz with
speed, positions, altitude, yaw rate, limit and consumption, or GPX tracks. The learnt study then
answers what the true one does, and the trips that were held back are counted in their intervals.

    python scripts/learn_check.py OCMC --fleets 5 --kind logs [--splits 20] [--truth 20000] [--keep
    DIR] python scripts/learn_check.py OCMC --fleets 5 --kind gpx
"""

# ruff: noqa: PLR0915, S311 (made-up exports, one after the other)
import argparse
import csv
import io
import itertools
import json
import math
import random
import subprocess
import sys
import tempfile
from datetime import UTC, datetime, timedelta
from pathlib import Path

from totals_check import between, derived, entries, error, put, quantile, toml
from tracks_check import EARTH_M

TRIPS, TRUCKS = 60, 12
FUEL_NOISE, WEIGHT_NOISE = 0.03, 0.05
LITRES_PER_KG = 1 / 0.836
MEASURES = ["mean", "p5", "p50", "p95"]
HILLS, HEAVY = 1.5, {"distribution": "beta", "alpha": 6.0, "beta": 1.5, "scale": 24300.0}
SLOPE_SD = {"urban": 0.015, "rural": 0.021, "motorway": 0.019}
START = datetime(2024, 1, 1, tzinfo=UTC)
SCATTER_M, HEIGHT_M, MEMORY_S = 1.5, 3.0, 60.0


def run(ocmc, *arguments):
    """Run the command, and give what it prints."""
    done = subprocess.run([ocmc, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{arguments}: {done.stderr}")
    return done.stdout


def fleet(draw, path, length_km):
    """Write the study of a made-up fleet."""
    tree = {"study": {"base": "field-truck", "name": path.stem}}
    for name, keys in entries().items():
        place = min(max(draw.gauss(0, 1), -1.5), 1.5)
        for key, three in keys.items():
            share = any(word in key.split(".") for word in ("next", "share", "ground"))
            if name not in ("slopes", "payload"):
                put(tree, key, between(*three, place, share=share))
    for road, sd in SLOPE_SD.items():
        put(tree, f"road.types.{road}.topography.slope_sd", HILLS * sd * draw.uniform(0.9, 1.1))
    put(tree, "mission.payload_kg", HEAVY)
    law = {
        "distribution": "log_normal",
        "median": 1e3 * length_km,
        "log_sd": 0.4,
        "lower": 1e4,
        "upper": 3e5,
    }
    put(tree, "mission.length_m", law)
    path.write_text("\n".join(f"{key} = {toml(value)}" for key, value in tree.items()) + "\n")


def answers(ocmc, study, cycles, seed):
    """Give mean and quantiles of a study."""
    common = ["--study", study, "--cycles", cycles, "--seed", seed, "--json", "--quiet"]
    found = json.loads(run(ocmc, *common, "--set", "simulation.sampling=sobol"))["statistics"]
    return {measure: found["consumption_l_per_100km"][measure] for measure in MEASURES}


def rows_of(ocmc, study, cycle, draw):
    """Give rows each second of a trip as its truck logs them."""
    text = run(ocmc, "trace", "--study", study, "--seed", 77, "--cycle-id", cycle)
    x, y, z, heading, before, t = 0.0, 0.0, 300.0, 0.7 * cycle, 0.0, 0.0
    errors, keep = [draw.gauss(0, 1) for _ in range(3)], math.exp(-1 / MEMORY_S)
    kick = math.sqrt(1 - keep * keep)
    for row in csv.DictReader(io.StringIO(text)):
        time_s, at_m = float(row["time_s"]), float(row["position_m"])
        way_m, before = at_m - before, at_m
        heading += float(row["yaw_rate_radps"]) * float(row["step_s"])
        x, y = x + way_m * math.cos(heading), y + way_m * math.sin(heading)
        z += way_m * float(row["grade"])
        while t <= time_s:
            errors = [keep * e + kick * draw.gauss(0, 1) for e in errors]
            yield {
                "time_s": t,
                "lat": 48.0 + math.degrees((y + SCATTER_M * errors[0]) / EARTH_M),
                "lon": 9.0
                + math.degrees((x + SCATTER_M * errors[1]) / EARTH_M / math.cos(math.radians(48))),
                "altitude": z + HEIGHT_M * errors[2],
                "speed_kmh": 3.6 * float(row["speed_mps"]),
                "yaw": float(row["yaw_rate_radps"]) + 0.004 * draw.gauss(0, 1),
                "limit_kmh": round(3.6 * float(row["limit_mps"])),
                "fuel_lph": 3600 * LITRES_PER_KG * float(row["fuel_rate_kgps"]),
            }
            t += 1.0


def export(ocmc, study, kind, folder, draw):
    """Write the files of a fleet; give its trips' consumption."""
    records = folder.parent / (folder.name + "-run")
    common = ["--study", study, "--cycles", TRIPS, "--seed", 77, "--quiet", "--format", "csv"]
    run(ocmc, *common, "--out", records)
    folder.mkdir()
    curb_kg = curb(ocmc, study)
    table, logs, each = [], {}, []
    with (records / "records.csv").open() as file:
        trips = list(csv.DictReader(file))
    for k, trip in enumerate(trips):
        if trip["outcome"] != "completed":
            continue
        truck = f"truck-{k % TRUCKS:02}"
        start = START + timedelta(seconds=float(trip["departure_s_of_year"]))
        km = float(trip["distance_m"]) / 1e3
        litres = (
            float(trip["consumption_l_per_100km"]) * km / 100 * (1 + FUEL_NOISE * draw.gauss(0, 1))
        )
        tons = (curb_kg + float(trip["payload_kg"])) / 1e3 * (1 + WEIGHT_NOISE * draw.gauss(0, 1))
        hours = float(trip["duration_s"]) / 3600
        stamp = start.isoformat(timespec="minutes").split("+")[0]
        table.append([truck, stamp, f"{km:.1f}", f"{litres:.1f}", f"{tons:.2f}", f"{hours:.3f}"])
        each.append(100 * litres / km)
        rows = list(rows_of(ocmc, study, int(trip["cycle_id"]), draw))
        if kind == "gpx":
            track(folder / f"trip-{k:02}.gpx", start, rows)
        else:
            for row in rows:
                at = (
                    (start + timedelta(seconds=row["time_s"]))
                    .isoformat(timespec="seconds")
                    .split("+")[0]
                )
                logs.setdefault(truck, []).append(
                    f"{at},{truck},{k},{row['speed_kmh']:.2f},{row['lat']:.7f},{row['lon']:.7f},"
                    f"{row['altitude']:.1f},{row['yaw']:.4f},{row['limit_kmh']},"
                    f"{row['fuel_lph']:.2f},{tons:.2f}"
                )
    head = (
        "time,truck,trip,speed_kmh,latitude,longitude,altitude_m,yaw_rate_radps,speed_limit_kmh,"
        "fuel_rate_lph,gross_weight_t"
    )
    for truck, lines in logs.items():
        (folder / f"{truck}.csv").write_text("\n".join([head, *lines]) + "\n")
    head = ["truck", "date", "km", "litres", "gross_weight_t", "driving_h"]
    (folder / "trips.csv").write_text("\n".join(",".join(row) for row in [head, *table]) + "\n")
    return each


def track(path, start, rows):
    """Write a trip as GPX."""
    points = []
    for row in rows:
        at = (
            (start + timedelta(seconds=row["time_s"]))
            .isoformat(timespec="seconds")
            .replace("+00:00", "Z")
        )
        points.append(
            f'<trkpt lat="{row["lat"]:.7f}" lon="{row["lon"]:.7f}"><ele>{row["altitude"]:.1f}</ele>'
            f"<time>{at}</time></trkpt>"
        )
    text = '<?xml version="1.0"?><gpx version="1.1" creator="made up"><trk><trkseg>'
    path.write_text("\n".join([text, *points, "</trkseg></trk></gpx>"]))


def curb(ocmc, study):
    """Give the curb mass of a study's truck."""
    text = run(ocmc, "study", "show", study, "--resolved")
    line = next(line for line in text.splitlines() if line.startswith("curb_mass_kg"))
    return float(line.split("=")[1].split("#")[0])


def main():
    """Reckon, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("ocmc")
    parser.add_argument("--fleets", type=int, default=5)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--kind", choices=["logs", "gpx"], default="logs")
    parser.add_argument(
        "--splits", type=int, default=0, help="further seeds, each with its own fifth"
    )
    parser.add_argument("--truth", type=int, default=20000)
    parser.add_argument("--length-km", type=float, default=60)
    parser.add_argument("--keep", type=Path, help="folder in which the exports stay")
    options = parser.parse_args()
    errors, within, held = {}, 0, 0
    with tempfile.TemporaryDirectory() as name:
        folder = options.keep or Path(name)
        folder.mkdir(exist_ok=True)
        plain = folder / "plain.toml"
        plain.write_text('study = { base = "field-truck", name = "plain" }\n')
        default = answers(options.ocmc, plain, 4000, 9)
        for f in range(options.first, options.first + options.fleets):
            draw = random.Random(500 + f)
            study = folder / f"fleet-{f}.toml"
            true = {"mean": 0.0}
            while true["mean"] < 1.2 * default["mean"]:
                fleet(draw, study, options.length_km)
                try:
                    true = answers(options.ocmc, study, options.truth, 9)
                except RuntimeError:
                    continue
            files = folder / f"export-{f}-{options.kind}"
            each = sorted(export(options.ocmc, study, options.kind, files, draw))
            se = 100 * deviation(each) / math.sqrt(len(each)) / (sum(each) / len(each))
            own = {
                "p5": quantile(each, 0.05),
                "p50": quantile(each, 0.5),
                "p95": quantile(each, 0.95),
            }
            own["mean"] = sum(each) / len(each)
            for split in range(1, 2 + options.splits):
                out = folder / f"learnt-{f}-{options.kind}-{split}.toml"
                told = ["--json", "--quiet", "--seed", split]
                answer = json.loads(run(options.ocmc, "learn", files, "--out", out, *told))
                if answer["held_back"]:
                    within += answer["held_back"]["within"]
                    held += len(answer["held_back"]["trips"])
                if split > 1:
                    continue
                one = derived(out, folder / f"one-{f}-{options.kind}.toml", electric=False)
                found = answers(options.ocmc, one, 4000, 9)
                line = [
                    (
                        f"fleet {f}: true {true['mean']:.1f} (default {default['mean']:.1f}), "
                        f"{se:.1f} % of SE"
                    )
                ]
                for who, values in [("learnt", found), ("rows", own), ("default", default)]:
                    off = [error(measure, values[measure], true[measure]) for measure in MEASURES]
                    errors.setdefault(who, []).append(off)
                    line.append(f"{who} " + " ".join(f"{x:+.1f}" for x in off))
                print("; ".join(line), flush=True)
                print(
                    "  ",
                    {p["what"]: p["refused"] for p in answer["parts"]},
                    f"{answer['wall_s']:.0f} s",
                )
    for who, rows in errors.items():
        means = [sum(column) / len(column) for column in zip(*rows, strict=True)]
        rms = [
            math.sqrt(sum(x * x for x in column) / len(column))
            for column in zip(*rows, strict=True)
        ]
        pairs = itertools.chain(*zip(MEASURES, means, rms, strict=True))
        print(
            f"{who:8}",
            " ".join(x if isinstance(x, str) else f"{x:+.2f}" for x in pairs),
            "% (mean, RMS)",
        )
    if held:
        print(f"held back: {within} of {held} within 90 % = {within / held:.3f}")


def deviation(values):
    """Give the SD of values."""
    mean = sum(values) / len(values)
    return math.sqrt(sum((x - mean) ** 2 for x in values) / (len(values) - 1))


if __name__ == "__main__":
    sys.exit(main())
