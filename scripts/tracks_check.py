"""Whether trips come back from the files that fleets have.

    python3 scripts/tracks_check.py [OCMC [TRIPS [SEED]]]

Trips of `field-truck` are driven (`ocmc trace`), laid on a plane by their yaw rate, and exported as
a receiver would have them: a row each 1, 5 or 10 s, with errors of 3 m across and 4 m in height
that fade over 30 s, and gaps of up to a minute. GPX, GeoJSON, KML, CSV with decimal commas, XLSX
(where openpyxl is installed) and rFMS are read back by `ocmc fit operating-cycle` without `--map`.
Compared are the number of trips, the length, and the SD of the slopes, which the fit has to have
within 5 %, or within its own interval.
"""

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

STUDY = ["--study", "field-truck"]
SCATTER_M, HEIGHT_M, MEMORY_S = 3.0, 4.0, 30.0
START = datetime(2024, 3, 4, 6, 0, 0, tzinfo=UTC)
EARTH_M = 6371008.8
# Largest relative errors, and rows so sparse that the interval of a fit may say it instead.
LENGTH, SLOPE, SPARSE_S = 0.005, 0.05, 10.0


def rows_of(ocmc, cycle):
    """Give time, x, y, z in m, speed in m/s of a trip each 0.5 s or so."""
    out = subprocess.run(
        [ocmc, "trace", *STUDY, "--cycle-id", str(cycle)],
        check=True,
        capture_output=True,
        text=True,
    )
    rows, x, y, z, heading, before = [], 0.0, 0.0, 200.0, 0.3 * cycle, 0.0
    for row in csv.DictReader(io.StringIO(out.stdout)):
        time_s, at_m, speed = (float(row[k]) for k in ("time_s", "position_m", "speed_mps"))
        way_m = at_m - before
        heading += float(row["yaw_rate_radps"]) * float(row["step_s"])
        x, y = x + way_m * math.cos(heading), y + way_m * math.sin(heading)
        z += way_m * float(row["grade"])
        before = at_m
        rows.append((time_s, x, y, z, speed, at_m))
    return rows


def sampled(rows, step_s, draw):
    """Give rows each `step_s` with the errors of a receiver, and gaps."""
    found, errors = [], [draw.gauss(0, 1) for _ in range(3)]
    keep = math.exp(-step_s / MEMORY_S)
    next_s, lost_until = 0.0, -1.0
    for before, row in itertools.pairwise(rows):
        while next_s < row[0]:
            share = max(0.0, (next_s - before[0]) / (row[0] - before[0]))
            _, x, y, z, _, at_m = (a + share * (b - a) for a, b in zip(before, row, strict=True))
            kick = math.sqrt(1 - keep * keep)
            errors = [keep * e + kick * draw.gauss(0, 1) for e in errors]
            if lost_until < next_s and draw.random() < step_s / 1800.0:
                lost_until = next_s + draw.uniform(15.0, 60.0)
            if next_s > lost_until:
                found.append(
                    (
                        next_s,
                        50.0 + math.degrees((y + SCATTER_M * errors[0]) / EARTH_M),
                        9.0
                        + math.degrees(
                            (x + SCATTER_M * errors[1]) / EARTH_M / math.cos(math.radians(50.0))
                        ),
                        z + HEIGHT_M * errors[2],
                        at_m,
                    )
                )
            next_s += step_s
    return found


def stamp(day, time_s):
    """Give the time of a row as text, in UTC."""
    at = START + timedelta(days=day, seconds=time_s)
    return at.isoformat(timespec="milliseconds").replace("+00:00", "Z")


def gpx(trips):
    """Write GPX, a track a trip."""
    parts = ['<?xml version="1.0"?><gpx version="1.1" creator="made up">']
    for k, rows in enumerate(trips):
        parts.append(f"<trk><name>trip {k}</name><trkseg>")
        parts += [
            f'<trkpt lat="{la:.7f}" '
            f'lon="{lo:.7f}"><ele>{z:.1f}</ele><time>{stamp(k, t)}</time></trkpt>'
            for t, la, lo, z, _ in rows
        ]
        parts.append("</trkseg></trk>")
    return "\n".join([*parts, "</gpx>"])


def geojson(trips):
    """Write GeoJSON, a feature a trip."""
    features = [
        {
            "type": "Feature",
            "properties": {"name": f"trip {k}", "coordTimes": [stamp(k, row[0]) for row in rows]},
            "geometry": {
                "type": "LineString",
                "coordinates": [
                    [round(lo, 7), round(la, 7), round(z, 1)] for _, la, lo, z, _ in rows
                ],
            },
        }
        for k, rows in enumerate(trips)
    ]
    return json.dumps({"type": "FeatureCollection", "features": features})


def kml(trips):
    """Write KML, a placemark a trip."""
    parts = ['<?xml version="1.0"?><kml xmlns:gx="g"><Document>']
    for k, rows in enumerate(trips):
        parts.append(f"<Placemark><name>trip {k}</name><gx:Track>")
        parts += [f"<when>{stamp(k, row[0])}</when>" for row in rows]
        parts += [f"<gx:coord>{lo:.7f} {la:.7f} {z:.1f}</gx:coord>" for _, la, lo, z, _ in rows]
        parts.append("</gx:Track></Placemark>")
    return "\n".join([*parts, "</Document></kml>"])


HEAD = ["Fahrzeug", "trip_id", "Zeit", "Breitengrad", "Längengrad", "Höhe [m]"]


def cells(trips):
    """Give the rows of a table of positions."""
    for k, rows in enumerate(trips):
        for t, la, lo, z, _ in rows:
            yield f"truck {k % 10}", k, stamp(k, t), round(la, 7), round(lo, 7), round(z, 1)


def semicolons(trips):
    """Write CSV with semicolons and decimal commas."""
    text = [";".join(HEAD)]

    def written(cell):
        return str(cell).replace(".", ",") if isinstance(cell, float) else str(cell)

    text += [";".join(map(written, row)) for row in cells(trips)]
    return "\n".join(text) + "\n"


def xlsx(trips, path):
    """Write a workbook."""
    import openpyxl  # noqa: PLC0415 (it need not be installed)

    book = openpyxl.Workbook(write_only=True)
    sheet = book.create_sheet("Positionen")
    sheet.append(HEAD)
    for row in cells(trips):
        sheet.append(row)
    book.save(path)


def rfms(trips):
    """Write the answer of an rFMS server: ten trucks, parted by the ignition."""
    statuses, way_m = [], [0.0] * 10
    for k, rows in enumerate(trips):
        truck = k % 10
        for n, (t, la, lo, z, at_m) in enumerate(rows):
            trigger = "IGNITION_ON" if n == 0 else "IGNITION_OFF" if n == len(rows) - 1 else "TIMER"
            statuses.append(
                {
                    "vin": f"MADEUP{truck}",
                    "createdDateTime": stamp(k, t),
                    "triggerType": {"triggerType": trigger, "context": "RFMS"},
                    "hrTotalVehicleDistance": 5 * round((way_m[truck] + at_m) / 5),
                    "engineTotalFuelUsed": round(300 * (way_m[truck] + at_m) / 1000),
                    "grossCombinationVehicleWeight": 30000,
                    "snapshotData": {
                        "gnssPosition": {
                            "latitude": round(la, 7),
                            "longitude": round(lo, 7),
                            "altitude": round(z, 1),
                            "positionDateTime": stamp(k, t),
                        }
                    },
                }
            )
        way_m[truck] += rows[-1][4]
    return json.dumps(
        {"vehicleStatusResponse": {"vehicleStatuses": statuses}, "moreDataAvailable": False}
    )


def main():
    """Drive, export, read back and compare."""
    given = sys.argv[1:]
    defaults = ["target/release/ocmc", "60", "1"]
    ocmc, count, seed = [*given, *defaults[len(given) :]][:3]
    count, seed = int(count), int(seed)
    draw = random.Random(seed)  # noqa: S311 (no secret)
    trips = [rows_of(ocmc, 1000 * seed + k) for k in range(count)]
    length_km = sum(rows[-1][5] for rows in trips) / 1000
    truth = (count, length_km, slope_sd(trips))
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for step_s in (1.0, 5.0, 10.0):
            tracks = [sampled(rows, step_s, draw) for rows in trips]
            files = {"gpx": gpx, "geojson": geojson, "kml": kml, "csv": semicolons, "json": rfms}
            files["xlsx"] = None
            for ending, write in files.items():
                path = Path(folder) / f"trips.{ending}"
                if write:
                    path.write_text(write(tracks))
                else:
                    try:
                        xlsx(tracks, path)
                    except ImportError:
                        print("skipped: openpyxl is not installed")
                        continue
                    except ValueError as error:
                        print(f"skipped: {error}")
                        continue
                answer = subprocess.run(
                    [ocmc, "fit", "operating-cycle", str(path), "--road-type", "rural", "--json"],
                    check=False,
                    capture_output=True,
                    text=True,
                )
                if answer.returncode:
                    print(f"{step_s:4.0f} s {ending:8} refused: {answer.stderr.strip()[-300:]}")
                    failed += 1
                    continue
                fit = json.loads(answer.stdout)
                failed += judged(step_s, ending, fit, answer.stderr, truth)
    print(f"{failed} failures")
    sys.exit(failed > 0)


def slope_sd(trips):
    """Give the SD of the slopes over the way, about the mean slope of each trip."""
    squares, ways = 0.0, 0.0
    for rows in trips:
        steps = [(b[5] - a[5], b[3] - a[3]) for a, b in itertools.pairwise(rows) if b[5] > a[5]]
        way = sum(step[0] for step in steps)
        mean = sum(step[1] for step in steps) / way
        squares += sum(dz * dz / ds for ds, dz in steps) - mean * mean * way
        ways += way
    return math.sqrt(squares / ways)


def judged(step_s, ending, fit, notes, truth):
    """Print what came back, and count what did not."""
    count, length_km, wanted_sd = truth
    trips = fit["cycles"]
    [length] = [entry["value"] for entry in fit["mission"] if entry["key"] == "length_m, mean"]
    off = length * trips / 1000 / length_km - 1
    numbers = {entry["key"]: entry for entry in fit["types"][0]["parameters"]}
    slope = numbers["topography.slope_sd"]
    sd, error = slope["value"], slope["standard_error"] or float("nan")
    told = fit["told"]["curves"] != "none" and fit["told"]["curves"] is not None
    known = "curves are not known" not in notes and told
    close = abs(sd / wanted_sd - 1) <= SLOPE
    covers = abs(sd - wanted_sd) <= 1.96 * error
    print(
        f"{step_s:4.0f} s {ending:8} trips {trips} of {count}, length {100 * off:+.2f} %, "
        f"slope SD {sd:.5f} ± {1.96 * error:.5f} of {wanted_sd:.5f} "
        f"({100 * (sd / wanted_sd - 1):+.1f} %), "
        f"curves {'told' if known else 'not known'}"
    )
    slopes = close or (step_s >= SPARSE_S and covers)
    return (trips != count) + (abs(off) > LENGTH) + (not slopes) + known


if __name__ == "__main__":
    main()
