"""Reckon the stored effects of judged numbers again: configs/judged-effects.csv.

Usage: python3 scripts/judged_effects.py target/release/ocmc [STUDY...]. It takes some ten minutes
on two cores for all built-in studies. Run it when a built-in study changes, which the test
`every_built_in_study_has_its_effects` notices.
"""

import json
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
FILE = ROOT / "configs/judged-effects.csv"
HEAD = "study,study_hash,vehicle,column,name,square"
CYCLES = "1000"


def answer(program: str, *arguments: str) -> str:
    """Return what the program prints."""
    return subprocess.run([program, *arguments], check=True, capture_output=True, text=True).stdout


def vehicle_of(study: str) -> str:
    """Find the vehicle with which the stored effects of a study hold."""
    text = tomllib.loads((ROOT / f"configs/{study}.toml").read_text())
    base = text.get("vehicle", {}).get("base")
    return base or vehicle_of(text["study"]["base"])


def rows_of(program: str, study: str) -> list[str]:
    """Reckon the rows of a study, the largest effect first."""
    found = json.loads(
        answer(program, "doubt", "--study", study, "--cycles", CYCLES, "--json", "--quiet")
    )
    start = f"{study},{found['study_hash'][:12]},{vehicle_of(study)},{found['column']}"
    whole = (found["together"]["mean"] / found["mean"]) ** 2
    return [
        f"{start},{numbers['name']},{numbers['share'] * whole:.3g}" for numbers in found["numbers"]
    ]


def main() -> None:
    """Write the rows of all studies, or those of some anew."""
    program, *wanted = sys.argv[1:]
    studies = [
        line.split()[0]
        for line in answer(program, "study", "list").splitlines()
        if line[:1].strip()
    ]
    known: dict[str, list[str]] = {}
    for line in FILE.read_text().splitlines()[1:]:
        known.setdefault(line.split(",")[0], []).append(line)
    for study in studies:
        if study in wanted or not wanted:
            known[study] = rows_of(program, study)
            print(study, len(known[study]), file=sys.stderr, flush=True)
    lines = [HEAD, *(line for study in studies for line in known.get(study, []))]
    FILE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
