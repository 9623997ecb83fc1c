#!/usr/bin/env python3
"""Worth of a route without altitudes, curves or stops, on the roads of a study.

    scripts/what_routes_lack.py OCMC [--study field-truck] [--roads 200] [--cycles 20] [--seed 1]

Each road of the study is written with `ocmc cycle` and driven by the same trucks: whole, and
without the tracks of each set of parts. Prints, by set, the consumption over that of the whole
road, less 1, in %: its mean and the 95th percentile of its magnitude. The rows are those of
`WORTH_PERCENT` in crates/ocmc-io/src/intake/lacks.rs: bit 0 altitudes, bit 1 curves, bit 2 stops.
"""

import argparse
import concurrent.futures
import pathlib
import re
import subprocess
import tempfile

PARTS = [
    ("altitudes", ("altitude_m", "grade")),
    ("curves", ("curvature_per_m",)),
    (
        "stops",
        (
            "stop_sign_s",
            "give_way_stop_s",
            "give_way_pass_mps",
            "red_light_s",
            "green_light",
            "mission_stop_s",
            "railway_crossing",
            "speed_bump_height_m",
            "speed_bump_length_m",
        ),
    ),
]
LITRES = re.compile(r"^L/100 km +([0-9.]+)", re.MULTILINE)


def call(*words: str) -> str:
    """Run a command and return what it prints."""
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout


def litres(options: argparse.Namespace, path: pathlib.Path) -> float:
    """Mean litres per 100 km of a route."""
    words = [
        "drive",
        str(path),
        "--study",
        options.study,
        "--cycles",
        str(options.cycles),
        "--threads",
        "1",
    ]
    return float(LITRES.search(call(options.ocmc, *words))[1])


def changes(options: argparse.Namespace, number: int) -> list[float]:
    """Consumption without each set of parts over that with all, less 1, in %."""
    seed, number_text = str(options.seed), str(number)
    text = call(
        options.ocmc, "cycle", "--study", options.study, "--seed", seed, "--cycle-id", number_text
    )
    lines = text.splitlines(keepends=True)
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for lacking in range(1 << len(PARTS)):
            gone = {
                name for bit, part in enumerate(PARTS) if lacking >> bit & 1 for name in part[1]
            }
            path = pathlib.Path(folder) / f"{lacking}.csv"
            path.write_text("".join(line for line in lines if line.split(",", 1)[0] not in gone))
            found.append(litres(options, path))
    return [100 * (value / found[0] - 1) for value in found]


def main() -> None:
    """Drive roads whole and without parts, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("ocmc")
    parser.add_argument("--study", default="field-truck")
    parser.add_argument("--roads", type=int, default=200)
    parser.add_argument("--cycles", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with concurrent.futures.ThreadPoolExecutor() as pool:
        all_changes = list(pool.map(lambda number: changes(options, number), range(options.roads)))
    for lacking in range(1 << len(PARTS)):
        values = [row[lacking] for row in all_changes]
        sizes = sorted(abs(value) for value in values)
        mean, most = sum(values) / len(values), sizes[int(0.95 * (len(sizes) - 1))]
        without = [part[0] for bit, part in enumerate(PARTS) if lacking >> bit & 1]
        print(f"    [{mean:.1f}, {most:.1f}],  // without {', '.join(without) or 'nothing'}")


if __name__ == "__main__":
    main()
