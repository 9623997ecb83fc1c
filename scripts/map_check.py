#!/usr/bin/env python3
"""Whether a GPS track gets limits, lights and altitudes of a map, without a web.

    scripts/map_check.py EXTRACT.osm.pbf [TRIPS [SEED]]

Tiles are built of the extract, and ways between random places of it are driven: a place each 10 m,
with errors of 3 m that fade over 300 m. `ocmc.map.route` lays them on the map again, and on a
made-up hill, and `ocmc drive` drives the table. Compared are the length of the way, the altitudes,
and the lights, give ways and stop signs with the extract's own nodes within 1.5 m of the way. Needs
`pip install '.[map]' osmium`, and says what it skips without them. Exits with 1 where lengths
differ by more than 2 % in sum, where more than 10 % of the lights are missed or not in the extract,
or where more than a tenth of the altitudes (bridges and tunnels are straight) is off by more than
0.5 m.
"""

import importlib.util
import itertools
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import warnings

import numpy as np

SCATTER_M, MEMORY_M, STEP_M = 3.0, 300.0, 10.0
LENGTH, LIGHTS, HEIGHT_M = 0.02, 0.1, 0.5
ON_WAY_M, NEAR_M, SHORTEST_M = 1.5, 60.0, 500.0
EARTH_M = 6371008.8
KINDS = {"traffic_signals": "traffic_light", "give_way": "give_way", "stop": "stop_sign"}


def along(way):
    """Give the position of each point, in m."""
    step = np.radians(np.diff(way, axis=0)) * [1.0, math.cos(math.radians(way[0, 0]))]
    return np.append(0.0, np.cumsum(EARTH_M * np.hypot(*step.T)))


def spread(way, step_m):
    """Give places each `step_m` along a way."""
    at_m = along(way)
    even_m = np.append(np.arange(0.0, at_m[-1], step_m), at_m[-1])
    return np.column_stack([np.interp(even_m, at_m, column) for column in way.T])


def nodes_of(extract):
    """Give the box of an extract, and its lights and signs: latitude, longitude, object."""
    import osmium  # noqa: PLC0415 (it need not be installed)

    places, objects = [], []
    for node in osmium.FileProcessor(extract, osmium.osm.NODE):
        places.append((node.lat, node.lon))
        if node.tags.get("highway") in KINDS:
            objects.append((node.lat, node.lon, KINDS[node.tags["highway"]]))
    return np.min(places, axis=0), np.max(places, axis=0), objects


def tiles_of(extract, folder):
    """Build tiles, and give their configuration."""
    import valhalla  # noqa: PLC0415 (it need not be installed)

    (folder / "tiles").mkdir()
    settings = valhalla.get_config(tile_extract="", tile_dir=folder / "tiles")
    settings["mjolnir"]["concurrency"] = 1
    config = folder / "valhalla.json"
    config.write_text(json.dumps(settings), encoding="utf-8")
    program = pathlib.Path(valhalla.__file__).parent / "bin" / "valhalla_build_tiles"
    subprocess.run([program, "-c", config, extract], check=True, capture_output=True)
    return config


def hill(lat, lon):
    """Give the altitude of a made-up hill, in m."""
    return 50.0 + 2000.0 * (lat - 60.0) + 10.0 * np.sin(300.0 * lon)


def raster_of(low, high, path):
    """Write the hill with cells of some 10 m."""
    import rasterio  # noqa: PLC0415 (it need not be installed)

    cell, (south, west), (north, east) = 1e-4, low - 0.01, high + 0.01
    rows, columns = np.mgrid[: math.ceil((north - south) / cell), : math.ceil((east - west) / cell)]
    heights = hill(north - (rows + 0.5) * cell, west + (columns + 0.5) * cell)
    corner = rasterio.Affine(cell, 0.0, west, 0.0, -cell, north)
    size = {"width": heights.shape[1], "height": heights.shape[0], "count": 1, "dtype": "float64"}
    with rasterio.open(
        path, "w", driver="GTiff", crs="EPSG:4326", transform=corner, **size
    ) as raster:
        raster.write(heights, 1)


def noisy(way, draw):
    """Give places of a receiver."""
    places = spread(way, STEP_M)
    keep, error = math.exp(-STEP_M / MEMORY_M), draw.normal(0.0, SCATTER_M, 2)
    scale = [1.0, 1.0 / math.cos(math.radians(way[0, 0]))]
    for k in range(len(places)):
        places[k] += np.degrees(error / EARTH_M) * scale
        error = keep * error + draw.normal(0.0, SCATTER_M * math.sqrt(1.0 - keep * keep), 2)
    return {"lat": places[:, 0], "lon": places[:, 1]}


def met(way, objects):
    """Give where objects are on a way: position and word, once a passage."""
    fine = spread(way, 1.0)
    scale = EARTH_M * math.pi / 180.0 * np.array([1.0, math.cos(math.radians(way[0, 0]))])
    at_m, found = along(fine), []
    for lat, lon, word in objects:
        on = np.hypot(*((fine - [lat, lon]) * scale).T) < ON_WAY_M
        found += [(at_m[k], word) for k in np.flatnonzero(on & ~np.append(False, on[:-1]))]
    return [(place_m, word) for place_m, word in found if 0.0 < place_m < at_m[-1] - 1.0]


def lacking(these, those):
    """Count those that have none of these near them."""
    return sum(
        not any(word == other and abs(at_m - place_m) < NEAR_M for place_m, other in these)
        for at_m, word in those
    )


def ways_of(actor, low, high, draw):
    """Yield ways between random places."""
    from ocmc._matched import decoded  # noqa: PLC0415 (where it is not skipped)

    while True:
        ends = [dict(zip(["lat", "lon"], draw.uniform(low, high), strict=True)) for _ in range(2)]
        try:
            [leg] = actor.route({"locations": ends, "costing": "auto"})["trip"]["legs"]
        except RuntimeError:  # a place without a road
            continue
        way = decoded(leg["shape"])
        if along(way)[-1] >= SHORTEST_M:
            yield way


def driven(route, path):
    """Drive a route."""
    route.write(path)
    drawn = "stops" if "speed_limit_kmh" in route.columns else "stops,limits"
    command = [sys.executable, "-c", "import ocmc; ocmc._main()", "drive", path, "--cycles", "20"]
    subprocess.run([*command, "--quiet", "--draw", drawn], check=True, capture_output=True)


def check(extract, trips, seed):
    """Drive ways of the extract, and print what comes back."""
    import ocmc.map  # noqa: PLC0415 (where it is not skipped)
    import valhalla  # noqa: PLC0415

    draw = np.random.default_rng(seed)
    low, high, objects = nodes_of(extract)
    sums, off = dict.fromkeys(["way", "matched", "known", "rows", "limited"], 0.0), []
    counts = {word: np.zeros(4, int) for word in KINDS.values()}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        config = tiles_of(extract, folder)
        raster_of(low, high, folder / "hill.tif")
        ways = ways_of(valhalla.Actor(str(config)), low, high, draw)
        for way in itertools.islice(ways, trips):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # limits that are left out are counted here
                route = ocmc.map.route(noisy(way, draw), config, elevation=[folder / "hill.tif"])
            driven(route, folder / "route.csv")
            rows = np.column_stack([route.columns["lat"], route.columns["lon"]])
            off.extend(np.abs(hill(*rows.T) - route.columns["altitude_m"]))
            [known] = re.findall(r"limits: the map has ([0-9.]+)", " ".join(route.account))
            limited = len(route.columns.get("speed_limit_kmh", []))
            values = [along(way)[-1], along(rows)[-1], 1e3 * float(known), len(rows), limited]
            sums = {key: sums[key] + value for key, value in zip(sums, values, strict=True)}
            words = route.columns.get("map_object", [""] * len(rows))
            ours = [(at_m, word) for at_m, word in zip(along(rows), words, strict=True) if word]
            theirs = met(way, objects)
            for word, count in counts.items():
                a, b = (
                    [thing for thing in things if thing[1] == word] for things in (ours, theirs)
                )
                count += [len(a), len(b), lacking(a, b), lacking(b, a)]
    print("the last track:", *route.account, sep="\n    ")
    height_m, change = np.quantile(off, 0.9), sums["matched"] / sums["way"] - 1.0
    print(f"{trips} tracks: {sums['way'] / 1e3:.1f} km, in the tables {100 * change:+.2f} %")
    print(f"limits: the map has {100 * sums['known'] / sums['matched']:.0f} % of the way", end="; ")
    print(f"{100 * sums['limited'] / sums['rows']:.0f} % of {sums['rows']:.0f} rows have one")
    print(f"altitudes: 9 in 10 within {height_m:.2f} m")
    for word, (ours, theirs, missed, false) in counts.items():
        print(
            f"{word}: {ours} in the tables, {theirs} on the ways; {missed} missed, {false} not "
            "there"
        )
    ours, theirs, missed, false = counts["traffic_light"]
    lights = missed <= LIGHTS * theirs and false <= LIGHTS * ours
    return abs(change) <= LENGTH and lights and height_m <= HEIGHT_M


def main():
    """Check, or say why not."""
    extract = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else None
    missing = [
        name
        for name in ("ocmc", "valhalla", "rasterio", "osmium")
        if not importlib.util.find_spec(name)
    ]
    if missing:
        print(
            f"skipped: without {', '.join(missing)} (pip install '.[map]' osmium, Python 3.12 or "
            "newer)"
        )
    elif extract is None or not extract.is_file():
        print(f"skipped: no extract {extract or ''} (scripts/map_check.py EXTRACT.osm.pbf)")
    elif not check(extract, *map(int, sys.argv[2:4] + ["20", "1"][len(sys.argv) - 2 :])):
        sys.exit(1)


if __name__ == "__main__":
    main()
