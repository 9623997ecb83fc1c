#!/usr/bin/env python3
"""Count the kernel's instructions for a lane-step under callgrind, and compare with the count stored beside this file.

``python3 benches/instructions/run.py [--store]``

The count does not depend on what else the machine does. It is the difference between driving planned cycles once more and
not, so that neither start-up nor planning is in it. valgrind 3.19 knows no AVX-512; the baseline and AVX2 are counted. The
count belongs to one compiler: with another one it is shown, not judged. Skips with a message without valgrind.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
STORED = Path(__file__).with_name("counts.json")
PEERS = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release/examples/peers"
CYCLES = 64
SETS = ("mission.length_m=5000",)
# a change of the count that has to be meant
ALLOWED = 0.02


def output(*words: object) -> str:
    """Run a command and read what it prints."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=True)
    return done.stdout + done.stderr


def instructions(rounds: int, level: str, sets: tuple[str, ...] = SETS) -> int:
    """Count all instructions of a process that drives the cycles so many times."""
    words = ("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", PEERS)
    said = output(*words, "drive", CYCLES, rounds, level, *sets)
    collected = re.search(r"Collected : (\d+)", said)
    if collected is None:
        raise SystemExit(said)
    return int(collected.group(1))


def main() -> None:
    """Count, and compare or store."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--store", action="store_true", help="store the count as the new one")
    store = parser.parse_args().store
    if shutil.which("valgrind") is None:
        print("SKIPPED: valgrind is not installed", file=sys.stderr)
        return
    output(
        "cargo", "build", "--release", "--quiet", "--manifest-path", ROOT / "Cargo.toml", "--example", "peers"
    )
    compiler = output("rustc", "--version").strip()
    steps = int(output(PEERS, "steps", CYCLES, *SETS))
    stored = json.loads(STORED.read_text()) if STORED.exists() else {"compiler": compiler, "counts": {}}
    counts, worse = {}, False
    for level in ("baseline", "avx2"):
        try:
            count = (instructions(3, level) - instructions(1, level)) / 2 / steps
        except subprocess.CalledProcessError as error:
            print(f"SKIPPED {level}: {error.stderr.strip().splitlines()[-1]}", file=sys.stderr)
            continue
        counts[level] = round(count, 1)
        before = stored["counts"].get(level)
        change = "" if before is None else f", stored {before}: {100 * (count / before - 1):+.2f} %"
        print(f"{level}: {count:.1f} instructions a lane-step{change}")
        worse |= before is not None and abs(count / before - 1) > ALLOWED
    if store:
        STORED.write_text(json.dumps({"compiler": compiler, "counts": counts}, indent=2) + "\n")
    elif stored["compiler"] != compiler:
        print(
            f"the stored counts are of {stored['compiler']}, these of {compiler}: not judged", file=sys.stderr
        )
    elif worse:
        raise SystemExit(f"changed by more than {100 * ALLOWED:.0f} %: if that is meant, run with --store")


if __name__ == "__main__":
    main()
