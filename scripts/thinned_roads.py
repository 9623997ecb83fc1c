#!/usr/bin/env python3
"""Random roads by few points: how far the consumption is off, and whether the account warns of it.

    scripts/thinned_roads.py OCMC [--roads 8] [--cycles 10] [--seed 40]

Roads of straights and bends with ramps, a point each 5 m, 20 km long, of five kinds: radii of 50 to
500 m, 50 to 2000 m, 700 to 2500 m, motorways of 1500 to 6000 m, and quarter turns of 15 to 40 m in
a city. Each is thinned so that no point moves by more than a tolerance (Douglas and Peucker), or to
even spacings, written as a route with latitude, longitude and limit, and driven by the same trucks
as the whole road. Prints, by kind and thinning, the consumption over that of the whole road, less
1, in %: `!` marks `sparse-points`, `B` `beeline`. At the end: answers that are more than 2 % off
without a warning, and those less than 0.5 % off with one.
"""

import argparse
import concurrent.futures
import math
import pathlib
import random
import re
import subprocess
import tempfile

# radius in m from which on curves turn less; changes in % that are wrong, and right
WIDE_M = 1000
WRONG_PERCENT = 2
RIGHT_PERCENT = 0.5
STEP_M = 5.0
LENGTH_M = 20_000.0
# least and largest radius, longest straight, in m, and the limit, in km/h
KINDS = {
    "curvy": (50, 500, 400, 80),
    "mixed": (50, 2000, 800, 80),
    "wide": (700, 2500, 1000, 80),
    "motorway": (1500, 6000, 2000, 90),
    "city": (15, 40, 400, 50),
}
TOLERANCES_M = (0.3, 1, 2, 5, 10, 20)
SPACINGS_M = (10, 20, 30, 50, 100, 200, 500, 1000, 2000, 5000)
LITRES = re.compile(r"^L/100 km +([0-9.]+)", re.MULTILINE)

Point = tuple[float, float]


def road(draw: random.Random, kind: str) -> list[Point]:
    """Points of a road on a plane, in m."""
    least_m, most_m, straight_m, _ = KINDS[kind]
    points, heading, done_m = [(0.0, 0.0)], 0.0, 0.0
    while done_m < LENGTH_M:
        radius_m = math.exp(draw.uniform(math.log(least_m), math.log(most_m)))
        turn_deg = (
            90
            if kind == "city"
            else draw.uniform(10, 90)
            if radius_m < WIDE_M
            else draw.uniform(5, 40)
        )
        turn = math.radians(turn_deg) * draw.choice((-1, 1))
        length_m = radius_m * abs(turn)
        ramp_m = min(length_m / 2, 0.3 * length_m + 20)
        count, ramp = max(2, int((length_m + ramp_m) / STEP_M)), max(1, int(ramp_m / STEP_M))
        weights = [min(1.0, (k + 1) / ramp, (count - k) / ramp) for k in range(count)]
        turns = [0.0] * int(draw.uniform(50, straight_m) / STEP_M)
        turns += [turn * weight / sum(weights) for weight in weights]
        for step in turns:
            x, y = points[-1]
            middle = heading + step / 2
            points.append((x + STEP_M * math.cos(middle), y + STEP_M * math.sin(middle)))
            heading += step
        done_m += STEP_M * len(turns)
    return points


def off_m(point: Point, start: Point, end: Point) -> float:
    """Distance of a point from a stretch, in m."""
    px, py = point[0] - start[0], point[1] - start[1]
    dx, dy = end[0] - start[0], end[1] - start[1]
    along = min(1.0, max(0.0, (px * dx + py * dy) / max(dx * dx + dy * dy, 1e-9)))
    return math.hypot(px - along * dx, py - along * dy)


def thinned(points: list[Point], tolerance_m: float) -> list[Point]:
    """Thin a road to its corners within a tolerance (Douglas and Peucker)."""
    keep, parts = {0, len(points) - 1}, [(0, len(points) - 1)]
    while parts:
        first, last = parts.pop()
        farthest = max(
            range(first + 1, last),
            key=lambda k, ends=(points[first], points[last]): off_m(points[k], *ends),
            default=None,
        )
        if (
            farthest is not None
            and off_m(points[farthest], points[first], points[last]) > tolerance_m
        ):
            keep.add(farthest)
            parts += [(first, farthest), (farthest, last)]
    return [points[k] for k in sorted(keep)]


def spaced(points: list[Point], spacing_m: float) -> list[Point]:
    """Keep a point each so many metres, and the last one."""
    some = points[:: int(spacing_m / STEP_M)]
    return some if some[-1] == points[-1] else [*some, points[-1]]


def drive(
    options: argparse.Namespace, path: pathlib.Path, points: list[Point], limit: int
) -> tuple[float, str]:
    """Consumption of a route, infinite where it is refused, and what was printed."""
    per_degree, latitude = 111_195.0, 48.0
    shrink = math.cos(math.radians(latitude))
    rows = (
        f"{latitude + y / per_degree:.7f},{9 + x / per_degree / shrink:.7f},{limit}\n"
        for x, y in points
    )
    path.write_text("lat,lon,speed_limit_kmh\n" + "".join(rows))
    words = [
        options.ocmc,
        "drive",
        str(path),
        "--study",
        "field-truck-loaded",
        "--cycles",
        str(options.cycles),
    ]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    found = LITRES.search(done.stdout)
    return (float(found[1]) if found else math.inf), done.stdout + done.stderr


def of_road(options: argparse.Namespace, kind: str, number: int) -> list[tuple[str, float, str]]:
    """By thinning: its name, the change in %, and the marks of its warnings."""
    points = road(random.Random(options.seed + number), kind)  # noqa: S311
    thinnings = [("5 m", points)]
    thinnings += [
        (f"tolerance {tolerance} m", thinned(points, tolerance)) for tolerance in TOLERANCES_M
    ]
    thinnings += [(f"each {spacing} m", spaced(points, spacing)) for spacing in SPACINGS_M]
    found, whole = [], 0.0
    with tempfile.TemporaryDirectory() as folder:
        for name, some in thinnings:
            litres, text = drive(options, pathlib.Path(folder) / "route.csv", some, KINDS[kind][3])
            whole = whole or litres
            marks = "".join(
                mark
                for mark, check in (("!", "[sparse-points]"), ("B", "[beeline]"))
                if check in text
            )
            found.append((name, 100 * (litres / whole - 1), marks))
    return found


def main() -> None:
    """Drive all roads and print what their thinning changes."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("ocmc")
    parser.add_argument("--roads", type=int, default=8)
    parser.add_argument("--cycles", type=int, default=10)
    parser.add_argument("--seed", type=int, default=40)
    options = parser.parse_args()
    everything = []
    for kind in KINDS:
        with concurrent.futures.ThreadPoolExecutor() as pool:
            roads = list(
                pool.map(
                    lambda number, kind=kind: of_road(options, kind, number), range(options.roads)
                )
            )
        for same in zip(*roads, strict=True):
            print(
                f"{kind:9}{same[0][0]:16}"
                + " ".join(f"{change:+.1f}{marks}" for _, change, marks in same)
            )
            everything += same
    off = [marks for _, change, marks in everything if abs(change) > WRONG_PERCENT]
    right = [marks for _, change, marks in everything if abs(change) < RIGHT_PERCENT]
    silent, wrong = sum(not marks for marks in off), sum(bool(marks) for marks in right)
    print(
        f"{len(everything)} answers, {len(off)} more than 2 % off, {silent} of them without a "
        "warning;"
    )
    print(f"{len(right)} less than 0.5 % off, {wrong} of them with a warning")


if __name__ == "__main__":
    main()
