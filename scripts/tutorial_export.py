"""Make the files of the tutorial "Your fleet in an afternoon": what a made-up haulier has.

Ten trucks of a hilly, heavy fleet make 60 trips each. Trucks differ by an SD of 3 %, and new tyres
save 4 % since July. The folder has a workbook with the trips, GPX tracks of some, and the log of a
truck.

    python scripts/tutorial_export.py OCMC docs/src/tutorial/export
"""

# ruff: noqa: S311 (a made-up fleet)
import csv
import random
import shutil
import sys
import tempfile
import zipfile
from datetime import timedelta
from pathlib import Path
from xml.sax.saxutils import escape

from learn_check import FUEL_NOISE, START, WEIGHT_NOISE, curb, rows_of, run

TRUCKS, TRIPS = 10, 60
TYRES_DAY, TYRES_SAVE, TRUCK_SD = 182, 0.04, 0.03
STUDY = """study = { base = "field-truck", name = "haulier" }
mission.length_m = { distribution = "log_normal", median = 24e3, log_sd = 0.4, \
lower = 8e3, upper = 90e3 }
mission.payload_kg = { distribution = "beta", alpha = 6.0, beta = 1.5, scale = 24300.0 }
road.types.urban.topography.slope_sd = 0.022
road.types.rural.topography.slope_sd = 0.031
road.types.motorway.topography.slope_sd = 0.028
vehicle.drag_area_m2 = { distribution = "log_normal", median = 6.2, log_sd = 0.05 }
"""
TRACKS, LOGGED = range(0, 600, 23), (5, 15)
XML = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>'
MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006"
PACKAGE = "http://schemas.openxmlformats.org/package/2006"
OFFICE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"


def workbook(path, rows):
    """Write rows of text and numbers as the one sheet of a workbook, the same bytes each time."""
    lines = []
    for row in rows:
        cells = [
            f"<c><v>{cell}</v></c>"
            if isinstance(cell, int | float)
            else f'<c t="inlineStr"><is><t>{escape(cell)}</t></is></c>'
            for cell in row
        ]
        lines.append(f"<row>{''.join(cells)}</row>")
    kind = "application/vnd.openxmlformats-officedocument.spreadsheetml"
    parts = {
        "[Content_Types].xml": f'<Types xmlns="{PACKAGE}/content-types">'
        '<Default Extension="rels" '
        'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
        f'<Override PartName="/xl/workbook.xml" ContentType="{kind}.sheet.main+xml"/>'
        '<Override PartName="/xl/worksheets/sheet1.xml" '
        f'ContentType="{kind}.worksheet+xml"/></Types>',
        "_rels/.rels": f'<Relationships xmlns="{PACKAGE}/relationships"><Relationship Id="a" '
        f'Type="{OFFICE}/officeDocument" Target="xl/workbook.xml"/></Relationships>',
        "xl/workbook.xml": f'<workbook xmlns="{MAIN}/main" xmlns:r="{OFFICE}"><sheets>'
        '<sheet name="trips" sheetId="1" r:id="a"/></sheets></workbook>',
        "xl/_rels/workbook.xml.rels": f'<Relationships xmlns="{PACKAGE}/relationships">'
        '<Relationship Id="a" '
        f'Type="{OFFICE}/worksheet" Target="worksheets/sheet1.xml"/></Relationships>',
        "xl/worksheets/sheet1.xml": f'<worksheet xmlns="{MAIN}/main">'
        f"<sheetData>{''.join(lines)}</sheetData>"
        "</worksheet>",
    }
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, text in parts.items():
            file.writestr(
                zipfile.ZipInfo(name, (2024, 1, 1, 0, 0, 0)), XML + text, zipfile.ZIP_DEFLATED
            )


def track(path, start, rows):
    """Write a trip as GPX, a point each five seconds."""
    points = [
        f'<trkpt lat="{row["lat"]:.6f}" lon="{row["lon"]:.6f}"><ele>{row["altitude"]:.1f}</ele>'
        f"<time>{(start + timedelta(seconds=row['time_s'])).isoformat().split('+')[0]}Z</time>"
        "</trkpt>"
        for row in rows[::5]
    ]
    head = f'{XML}\n<gpx version="1.1" creator="made up"><trk><trkseg>'
    path.write_text("\n".join([head, *points, "</trkseg></trk></gpx>\n"]))


def main():
    """Write the folder."""
    ocmc, folder = sys.argv[1], Path(sys.argv[2])
    draw = random.Random(7)
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "tracks").mkdir(parents=True)
    with tempfile.TemporaryDirectory() as name:
        study = Path(name) / "haulier.toml"
        study.write_text(STUDY)
        common = [
            "--study",
            study,
            "--cycles",
            TRUCKS * TRIPS,
            "--seed",
            77,
            "--quiet",
            "--format",
            "csv",
        ]
        run(ocmc, *common, "--out", Path(name) / "run")
        with (Path(name) / "run" / "records.csv").open() as file:
            trips = list(csv.DictReader(file))
        curb_kg = curb(ocmc, study)
        effects = [draw.gauss(0, TRUCK_SD) for _ in range(TRUCKS)]
        table, log = [], []
        for k, trip in enumerate(trips):
            start = START + timedelta(seconds=round(float(trip["departure_s_of_year"])))
            km = float(trip["distance_m"]) / 1e3
            factor = 1 + effects[k % TRUCKS] + FUEL_NOISE * draw.gauss(0, 1)
            factor *= 1 - (TYRES_SAVE if start >= START + timedelta(days=TYRES_DAY) else 0)
            litres = float(trip["consumption_l_per_100km"]) * km / 100 * factor
            tons = (
                (curb_kg + float(trip["payload_kg"])) / 1e3 * (1 + WEIGHT_NOISE * draw.gauss(0, 1))
            )
            hours = round(float(trip["duration_s"]) / 3600, 3)
            truck, driver = f"HL {k % TRUCKS + 1:02}", f"D. {draw.choice('ABCDEFGHIJKL')}"
            stamp = start.isoformat(timespec="minutes").split("+")[0]
            table.append(
                [truck, driver, stamp, round(km, 1), round(litres, 1), round(tons, 2), hours]
            )
            if k in TRACKS:
                track(
                    folder / "tracks" / f"{start:%Y-%m-%d}-{k:03}.gpx",
                    start,
                    list(rows_of(ocmc, study, k, draw)),
                )
            if k in LOGGED:
                for row in rows_of(ocmc, study, k, draw):
                    at = (start + timedelta(seconds=row["time_s"])).isoformat().split("+")[0]
                    log.append(
                        f"{at},{truck},{k},{row['speed_kmh']:.1f},"
                        f"{row['altitude']:.1f},{row['yaw']:.4f},"
                        f"{row['limit_kmh']}"
                    )
        table.sort(key=lambda row: row[2])
        head = ["truck", "driver", "date", "km", "litres", "gross_weight_t", "driving_h"]
        workbook(folder / "trips.xlsx", [head, *table])
        head = "time,truck,trip,speed_kmh,altitude_m,yaw_rate_radps,speed_limit_kmh"
        (folder / "telematics-HL06.csv").write_text("\n".join([head, *log]) + "\n")


if __name__ == "__main__":
    main()
