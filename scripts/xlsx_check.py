#!/usr/bin/env python3
"""Whether LibreOffice reads the workbook of a run as it was written.

    scripts/xlsx_check.py [OCMC [CYCLES]]

A run of several trucks and one on two routes are written with `--format xlsx` and once more as CSV.
LibreOffice converts each sheet to CSV, and each cell of `Records` and `By truck` is compared with
`records.csv` and `trucks.csv`: words letter by letter, numbers to the 15 digits that it shows. A
study that is called like a formula has to stay a text. Says what it skips, and exits with 0, where
there is no `soffice`; with 1 where a cell differs.
"""

import csv
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

DIGITS = 1e-14
# separator, quotes, UTF-8, from the first row, then: numbers as they are stored, and every sheet
FILTER = "csv:Text - txt - csv (StarCalc):44,34,76,1,,0,false,false,false,false,false,-1"
FORMULA = "=1+1"


def rows(path):
    """Read a table."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


def same(found, wanted):
    """Tell whether a cell shows a value."""
    if found == wanted:
        return True
    try:
        return math.isclose(float(found), float(wanted), rel_tol=DIGITS, abs_tol=0.0)
    except ValueError:
        return False


def differences(found, wanted):
    """List the cells that differ: row, column, what is there, what should be."""
    if len(found) != len(wanted):
        return [("rows", "", len(found), len(wanted))]
    pairs = enumerate(zip(found, wanted, strict=True))
    cells = ((k, *cell) for k, (a, b) in pairs for cell in zip(wanted[0], a, b, strict=True))
    return [cell for cell in cells if not same(cell[2], cell[3])]


def check(soffice, ocmc, folder, arguments):
    """Run, convert, compare; give the number of faults."""
    own, text = folder / "xlsx", folder / "csv"
    for out, form in ((own, "xlsx"), (text, "csv")):
        command = [ocmc, *arguments, "--quiet", "--out", out, "--format", form]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    home = f"-env:UserInstallation=file://{folder}/profile"
    convert = [
        soffice,
        home,
        "--headless",
        "--convert-to",
        FILTER,
        "--outdir",
        folder,
        own / "run.xlsx",
    ]
    subprocess.run(convert, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    faults = 0
    for sheet, table in (("Records", "records.csv"), ("By truck", "trucks.csv")):
        if not (text / table).exists():
            continue
        found = differences(rows(folder / f"run-{sheet}.csv"), rows(text / table))
        print(f"{sheet}: {len(rows(text / table)) - 1} rows, {len(found)} cells differ")
        for cell in found[:5]:
            print("   ", *cell)
        faults += len(found)
    answer = {row[0]: row[2] for row in rows(folder / "run-Answer.csv") if row}
    if not answer["study"].startswith(FORMULA):
        print(f"Answer: the study is {answer['study']}, not {FORMULA}")
        faults += 1
    return faults


def main():
    """Check both runs."""
    soffice = shutil.which("soffice") or shutil.which("libreoffice")
    if soffice is None:
        print("skipped: there is no soffice (LibreOffice)")
        return 0
    ocmc = sys.argv[1] if len(sys.argv) > 1 else "ocmc"
    cycles = sys.argv[2] if len(sys.argv) > 2 else "200"  # noqa: PLR2004
    faults = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        routes = []
        for route in ("=one.csv", "two.csv"):
            path = folder / route
            path.write_text(
                "position_m,speed_limit_kmh\n0,60\n2000,80\n4000,80\n", encoding="utf-8"
            )
            routes.append(path)
        study = [
            "--set",
            f'study.name="{FORMULA}"',
            "--set",
            "mission.length_m=5000",
            "--cycles",
            cycles,
        ]
        for k, arguments in enumerate(([*study, "--trips", "4"], ["drive", *routes, *study])):
            (folder / str(k)).mkdir()
            faults += check(soffice, ocmc, folder / str(k), arguments)
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())
