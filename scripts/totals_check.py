"""How well `ocmc calibrate totals` does on invented fleets whose truth is known.

Each fleet has the largest judged numbers of `field-truck` drawn with the ends of their ranges as
one SD; a fifth of the fleets is drawn half as wide again, a fifth drives other mixes of roads. Its
table has trips with noise of fuel and weight. The default study and the calibrated one then answer
what the true one does: mean, P5 and P95 of the consumption, what less drag, less rolling
resistance, a tonne more and a lower limiter change, and what an electric truck takes. Python's
standard library is enough.

    python scripts/totals_check.py OCMC --fleets 100 --rows 10 60 1000 [--climb] [--truth 20000]
    python scripts/totals_check.py OCMC --fleets 10 --rows 60 --spoil payload
"""

# ruff: noqa: PLR0913, PLR0915, PLR0917, PLR2004, S311 (invented fleets, one after the other)
import argparse
import csv
import json
import math
import random
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ENTRIES = 18
# of the replaced: what a fleet of its own draws beside them
OF_TABLE = {"trip_length"}
QUESTIONS = {
    "drag": ["vehicle.drag_area_m2", 0.9],
    "rolling": ["vehicle.rolling_factor", 0.9],
    "weight": ["weight", 1000.0],
    "limiter": ["vehicle.limiter_speed_mps", 80 / 3.6],
}
# the command's names of them
ASKED = {"drag": "drag", "rolling": "rolling", "weight": "weight", "limiter": "limiter"}
MEASURES = ["mean", "p5", "p95", *QUESTIONS, "electric"]
FUEL_NOISE, WEIGHT_NOISE = 0.03, 0.05
SPOILT = ["payload", "breaks", "kilograms", "doubled"]


def between(low, judged, high, place, *, share=False):
    """Move a value to a place of its range: -1 and 1 are the ends, one SD of the fleets."""
    if isinstance(judged, dict):
        return {
            key: between(low[key], judged[key], high[key], place, share=share or key == "weights")
            for key in judged
        }
    if isinstance(judged, list):
        return [
            between(*three, place, share=share) for three in zip(low, judged, high, strict=True)
        ]
    if isinstance(judged, str):
        return judged
    end, size = (low if place < 0 else high), abs(place)
    if min(low, judged, high) > 0 and not share:
        value = judged * (end / judged) ** size
    else:
        value = max(judged + size * (end - judged), 0.0)
    return round(value) if all(isinstance(x, int) for x in (low, judged, high)) else value


def put(tree, path, value):
    """Put a value under a dotted path."""
    *above, last = path.split(".")
    for key in above:
        tree = tree.setdefault(key, {})
    tree[last] = value


def toml(value):
    """Write a value of TOML on one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f'"{k}" = {toml(v)}' for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


def entries():
    """Find the judged entries that do most to the mean, as {path: [low, judged, high]}."""
    with (ROOT / "configs/judged-effects.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["study"] == "field-truck"]
    rows.sort(key=lambda row: -float(row["square"]))
    names = [row["name"] for row in rows if row["name"] not in OF_TABLE][:ENTRIES]
    found = {}
    for file, before in [("field-truck.toml", ""), ("vehicles/tractor-40t.toml", "vehicle.")]:
        with (ROOT / "configs" / file).open("rb") as text:
            judged = tomllib.load(text)["judged"]
        for name, entry in judged.items():
            if name in names:
                found[name] = {before + key: v for key, v in entry.items() if key != "reason"}
    return found


class Program:
    """The command, and what it answers."""

    def __init__(self, path, folder, trips):
        self.path, self.folder, self.trips = path, folder, trips

    def __call__(self, *arguments):
        """Run the command."""
        command = [self.path, *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}: {done.stderr}")
        return done

    def is_legal(self, study):
        """Whether a file is a study."""
        command = [self.path, "study", "check", str(study)]
        return subprocess.run(command, capture_output=True, check=False).returncode == 0

    def mean(self, study, cycles, *sets, column="consumption_l_per_100km"):
        """Statistics of a consumption."""
        common = ["--study", study, "--cycles", cycles, "--seed", 9, "--json", "--quiet"]
        sets = [x for s in ("simulation.sampling=sobol", *sets) for x in ("--set", s)]
        return json.loads(self(*common, *sets).stdout)["statistics"][column]

    def measures(self, study, electric):
        """All that is asked of a study."""
        whole = self.mean(study, self.trips)
        found = {key: whole[key] for key in ("mean", "p5", "p95")}
        few = max(self.trips // 2, 512)
        base = self.mean(study, few)["mean"]
        tree = tomllib.loads(self("study", "show", study, "--resolved").stdout)
        for name, (key, by) in QUESTIONS.items():
            if name == "weight":
                own = tree["vehicle"]
                masses = {k: own[k] + by for k in ("curb_mass_kg", "gross_mass_limit_kg")}
                sets = [f"vehicle.{k}={v}" for k, v in masses.items()]
            elif name == "limiter":
                sets = [f"{key}={by}"]
            else:
                law = tree["vehicle"][key.split(".")[1]]
                sets = [f"{key}={toml({**law, 'median': by * law['median']})}"]
            found[name] = self.mean(study, few, *sets)["mean"] / base - 1
        found["electric"] = self.mean(electric, few, column="consumption_kwh_per_km")["mean"]
        return found


def fleet(draw, kind, judged, path, length_km):
    """Write the study of an invented fleet."""
    tree = {"study": {"base": "field-truck", "name": path.stem}}
    sd = 1.5 if kind == "wider" else 1.0
    for keys in judged.values():
        place = min(max(sd * draw.gauss(0, 1), -2.2), 2.2)
        for key, three in keys.items():
            share = any(word in key.split(".") for word in ("next", "share", "ground"))
            # shares end where they are used up
            put(
                tree,
                key,
                between(*three, min(max(place, -1.5), 1.5) if share else place, share=share),
            )
    if kind == "mix":
        for road, mean in [("urban", 4e3), ("rural", 15e3), ("motorway", 40e3)]:
            put(tree, f"road.types.{road}.mean_length_m", mean * 3 ** draw.uniform(-1, 1))
    median = 1e3 * draw.uniform(0.6, 1.4) * length_km
    law = {
        "distribution": "log_normal",
        "median": median,
        "log_sd": 0.4,
        "lower": 1e4,
        "upper": 3e5,
    }
    put(tree, "mission.length_m", law)
    lines = [f"{key} = {toml(value)}" for key, value in tree.items()]
    path.write_text("\n".join(lines) + "\n")


def derived(base, path, *, electric):
    """Write a study without what is uncertain, of an electric truck where it is asked for."""
    text = f'study = {{ base = "{base}", name = "{path.stem}" }}\n'
    if "uncertainty" in Path(base).read_text():
        text = text.replace(" }", ', drop = ["uncertainty.totals"] }')
    if electric:
        text += 'vehicle = { base = "tractor-electric-40t" }\n'
    path.write_text(text)
    return path


def records(program, study, rows, folder, seed):
    """Trips of a study, drawn with a seed of its own: fleets that share one share their luck."""
    program(
        "--study",
        study,
        "--cycles",
        rows,
        "--seed",
        seed,
        "--out",
        folder,
        "--format",
        "csv",
        "--quiet",
    )
    with (folder / "records.csv").open() as file:
        return [row for row in csv.DictReader(file) if row["outcome"] == "completed"]


def write_table(trips, curb_kg, draw, path, climb, spoil):
    """Write a table with noise, and return its own mean and quantiles."""
    lines, litres, km, each = [], 0.0, 0.0, []
    for k, trip in enumerate(trips):
        distance = float(trip["distance_m"]) / 1e3
        fuel = float(trip["consumption_l_per_100km"]) * distance / 100
        fuel *= 1 + FUEL_NOISE * draw.gauss(0, 1)
        weight = (curb_kg + float(trip["payload_kg"])) * (1 + WEIGHT_NOISE * draw.gauss(0, 1))
        hours = float(trip["duration_s"]) / 3600
        litres, km = litres + fuel, km + distance
        each.append(100 * fuel / distance)
        if spoil == "payload":
            weight = max(weight - curb_kg, 0.0)
        if spoil == "breaks" and draw.random() < 0.5:
            hours += draw.uniform(0.3, 0.8)
        if spoil == "kilograms":
            fuel *= 0.836
        if spoil == "doubled" and k in (3, 17, 31):
            fuel *= 2
        row = [f"{distance:.2f}", f"{fuel:.2f}", f"{weight:.0f}", f"{hours:.4f}"]
        lines.append(row + ([f"{float(trip['climb_m']):.0f}"] if climb else []))
    head = ["distance_km", "fuel_l", "gross_weight_kg", "driving_time_h"] + (
        ["climb_m"] if climb else []
    )
    path.write_text("\n".join(",".join(row) for row in [head, *lines]) + "\n")
    each.sort()
    return {"mean": 100 * litres / km, "p5": quantile(each, 0.05), "p95": quantile(each, 0.95)}


def quantile(values, p):
    """Find a quantile of values in order, linear between them."""
    place = p * (len(values) - 1)
    k = min(int(place), len(values) - 2)
    return values[k] + (place - k) * (values[k + 1] - values[k])


def error(measure, found, true):
    """In per cent, or in points of a saving."""
    if measure in QUESTIONS:
        return 100 * (found - true)
    return 100 * (found / true - 1)


def main():
    """Reckon, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("ocmc")
    parser.add_argument("--fleets", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="the first fleet")
    parser.add_argument("--rows", type=int, nargs="+", default=[60])
    parser.add_argument("--truth", type=int, default=20000)
    parser.add_argument("--trips", type=int, default=4000, help="trips of the studies compared")
    parser.add_argument("--length-km", type=float, default=80, help="of trips, about")
    parser.add_argument("--each", type=Path, help="CSV of the errors of each fleet, to write")
    parser.add_argument("--climb", action="store_true")
    parser.add_argument("--spoil", choices=SPOILT)
    options = parser.parse_args()
    judged = entries()
    errors = {}
    covered = {"inside": [], "outside": []}
    named, seconds = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        program = Program(options.ocmc, folder, options.trips)
        truth = Program(options.ocmc, folder, options.truth)
        plain = folder / "plain.toml"
        plain.write_text('study = { base = "field-truck", name = "plain" }\n')
        default = program.measures(plain, derived(plain, folder / "plain-e.toml", electric=True))
        kinds = ["inside", "inside", "inside", "wider", "mix"]
        for f in range(options.first, options.first + options.fleets):
            draw, kind = random.Random(1000 + f), kinds[f % 5]
            study = folder / f"fleet-{f}.toml"
            legal = False
            while not legal:
                fleet(draw, kind, judged, study, options.length_km)
                legal = program.is_legal(study)
            true = truth.measures(
                study, derived(study, folder / f"fleet-{f}-e.toml", electric=True)
            )
            trips = records(program, study, max(options.rows), folder / f"run-{f}", 1000 + f)
            resolved = tomllib.loads(program("study", "show", study, "--resolved").stdout)
            for rows in options.rows:
                table, out = folder / f"{f}-{rows}.csv", folder / f"my-{f}-{rows}.toml"
                curb_kg = resolved["vehicle"]["curb_mass_kg"]
                own = write_table(trips[:rows], curb_kg, draw, table, options.climb, options.spoil)
                start = time.monotonic()
                done = program(
                    "calibrate", "totals", table, "--study", "field-truck", "--out", out, "--json"
                )
                seconds.append(time.monotonic() - start)
                answer = json.loads(done.stdout)
                named.append([x["check"] for x in answer["inputs"][0]["findings"]])
                electric = derived(out, folder / f"my-{f}-{rows}-e.toml", electric=True)
                found = program.measures(
                    derived(out, folder / f"my-{f}-{rows}-d.toml", electric=False), electric
                )
                for asked in answer["questions"]:
                    of = next(q for q, n in ASKED.items() if n == asked["question"])
                    low, high = asked["ci90"]
                    where = "inside" if kind == "inside" else "outside"
                    covered[where].append((of, low <= true[of] <= high))
                    errors.setdefault((rows, "asked", of), []).append(
                        error(of, asked["change"], true[of])
                    )
                for measure in MEASURES:
                    for who, values in [("calibrated", found), ("default", default), ("rows", own)]:
                        if measure in values:
                            off = error(measure, values[measure], true[measure])
                            errors.setdefault((rows, who, measure), []).append(off)
            if options.each:
                write_each(options.each, errors)
            report(f + 1 - options.first, options.rows, errors, covered, named, seconds)


def rms(values):
    """Root mean square."""
    return math.sqrt(sum(x * x for x in values) / len(values))


def write_each(path, errors):
    """Write the errors of each fleet, in the order in which they were driven."""
    rows = [[*key, k, value] for key, values in errors.items() for k, value in enumerate(values)]
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([["rows", "who", "measure", "fleet", "error"], *rows])


def report(fleets, sizes, errors, covered, named, seconds):
    """Print what was found so far."""
    print(
        f"\n{fleets} fleets, calibration {sum(seconds) / len(seconds):.1f} s in the mean",
        flush=True,
    )
    for rows in sizes:
        print(f"RMS errors from {rows} rows: {'':14}" + "".join(f"{m:>9}" for m in MEASURES))
        for who in ("rows", "default", "calibrated", "asked"):
            cells = [errors.get((rows, who, m)) for m in MEASURES]
            print(f"  {who:36}" + "".join(f"{rms(c):9.3f}" if c else f"{'':9}" for c in cells))
        over = ["rows" if m in ("mean", "p5", "p95") else "default" for m in MEASURES]
        ratio = [
            rms(errors[rows, "calibrated", m]) / rms(errors[rows, w, m])
            for m, w in zip(MEASURES, over, strict=True)
        ]
        print(f"  {'over that of rows, or default':36}" + "".join(f"{r:9.2f}" for r in ratio))
    for where, hits in covered.items():
        if hits:
            held = sum(hit for _, hit in hits)
            print(f"90 % intervals cover, {where}: {held} of {len(hits)} = {held / len(hits):.2f}")
    counts = {}
    for checks in named:
        for check in set(checks):
            counts[check] = counts.get(check, 0) + 1
    print(
        "named:",
        ", ".join(f"{check} {n}" for check, n in sorted(counts.items())) or "nothing",
        flush=True,
    )


if __name__ == "__main__":
    sys.exit(main())
