#!/usr/bin/env python3
"""Whether routes whose lacking parts are drawn take as much fuel as the whole ones.

    scripts/draw_check.py OCMC [--roads 60] [--cycles 3000] [--seed 1] [STUDY ...]

Roads of each study are written with `ocmc cycle` and driven whole; stripped to positions and
limits, with stops, hills and curves drawn; and stripped to their lengths, with all drawn. The same
trucks and drivers drive them. Prints by how much mean, P5 and P95 of the consumption differ, in %,
and exits with 1 where limits alone miss the mean by more than 2 % or a quantile by more than 4 %,
where lengths alone miss the mean by more than 4 %, or where a mean and the same one adjusted differ
by more than twice half the interval.
"""

import argparse
import concurrent.futures
import json
import pathlib
import subprocess
import sys
import tempfile

STUDIES = ["field-truck", "long-haul", "regional", "urban-delivery"]
QUANTITY = "consumption_l_per_100km"
# by what is left: what is drawn, and the bounds of mean and quantiles, in %
CASES = {
    "limits": ("stops,hills,curves", 2.0, 4.0),
    "lengths": ("stops,limits,hills,curves", 4.0, None),
}


def call(*words: str) -> str:
    """Run a command and return what it prints."""
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout


def stripped(text: str, left: str) -> str:
    """Make a route by rows of what is left of a road's tracks."""
    rows = [line.split(",") for line in text.splitlines()[1:]]
    length_m = max(float(row[2]) for row in rows)
    if left == "lengths":
        return f"position_m\n0\n{length_m}\n"
    limits = [(float(row[2]), float(row[3])) for row in rows if row[0] == "speed_limit_mps"]
    # a sign that repeats the one before would show where a road type begins
    kept = [limit for k, limit in enumerate(limits) if k == 0 or limit[1] != limits[k - 1][1]]
    kept.append((length_m, kept[-1][1]))
    return "position_m,speed_limit_mps\n" + "".join(f"{at_m},{mps}\n" for at_m, mps in kept)


def roads(options: argparse.Namespace, study: str, folder: pathlib.Path) -> dict[str, list[str]]:
    """Files of the roads, whole and by what is left of them."""

    def road(number: int) -> dict[str, str]:
        path = folder / f"{number}-whole.csv"
        seed, number_text = str(options.seed), str(number)
        words = ["--study", study, "--seed", seed, "--cycle-id", number_text, "--out", str(path)]
        call(options.ocmc, "cycle", *words)
        files = {"whole": str(path)}
        for left in CASES:
            file = folder / f"{number}-{left}.csv"
            file.write_text(stripped(path.read_text(), left))
            files[left] = str(file)
        return files

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        all_files = list(pool.map(road, range(options.roads)))
    return {left: [files[left] for files in all_files] for left in ["whole", *CASES]}


def driven(options: argparse.Namespace, study: str, files: list[str], draw: str | None) -> dict:
    """Statistics of the consumption on the routes."""
    words = [
        "drive",
        *files,
        "--study",
        study,
        "--cycles",
        str(options.cycles),
        "--seed",
        str(options.seed),
    ]
    words += ["--json", "--quiet", *(["--draw", draw] if draw else [])]
    return json.loads(call(options.ocmc, *words))["statistics"][QUANTITY]


def main() -> None:
    """Drive the roads of each study in all ways, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("ocmc")
    parser.add_argument("studies", metavar="STUDY", nargs="*", default=STUDIES)
    parser.add_argument("--roads", type=int, default=60)
    parser.add_argument("--cycles", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    failed = False
    print(f"{'study':16} {'left':8} {'mean':>6} {'P5':>6} {'P95':>6}   adjusted - plain")
    for study in options.studies:
        with tempfile.TemporaryDirectory() as folder:
            files = roads(options, study, pathlib.Path(folder))
            whole = driven(options, study, files["whole"], None)
            for left, (draw, most_of_mean, most_of_quantiles) in CASES.items():
                found = driven(options, study, files[left], draw)
                errors = [100 * (found[key] / whole[key] - 1) for key in ("mean", "p5", "p95")]
                half = 0.5 * (found["ci95"][1] - found["ci95"][0])
                adjusted = (
                    found["adjusted"]["mean"] - found["mean"] if found.get("adjusted") else 0.0
                )
                bad = abs(errors[0]) > most_of_mean or abs(adjusted) > 2 * half
                bad |= (
                    most_of_quantiles is not None and max(map(abs, errors[1:])) > most_of_quantiles
                )
                failed |= bad
                numbers = " ".join(f"{error:6.2f}" for error in errors)
                print(
                    f"{study:16} {left:8} {numbers}   {adjusted:+.3f} of +-{half:.3f}"
                    f"{'  FAILS' if bad else ''}",
                    flush=True,
                )
    sys.exit(failed)


if __name__ == "__main__":
    main()
