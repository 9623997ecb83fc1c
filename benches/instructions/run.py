#!/usr/bin/env python3
"""Count the kernel's instructions for a lane-step, and compare with the counts beside this file.

``python3 benches/instructions/run.py [--store]``

The count does not depend on what else the machine does. It is the difference between driving
planned cycles once more and not, so that neither start-up nor planning is in it. valgrind 3.19
knows no AVX-512; its callgrind counts the baseline and AVX2. NEON is counted by qemu-aarch64 with
the plugin ``emulated.c``. A count belongs to one compiler: with another one it is shown, not
judged. What is not installed is skipped with a message.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
STORED = Path(__file__).with_name("counts.json")
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
PEERS = TARGET / "release/examples/peers"
BUILD = (
    "cargo",
    "build",
    "--release",
    "--locked",
    "--quiet",
    "--manifest-path",
    ROOT / "Cargo.toml",
    "--example",
    "peers",
)
AARCH64 = "aarch64-unknown-linux-gnu"
AARCH64_COMPILER = "aarch64-linux-gnu-gcc"
# with the cross compiler of Debian
AARCH64_LIBRARIES = Path("/usr/aarch64-linux-gnu")
CYCLES = 64
SETS = ("mission.length_m=5000",)
# a change of the count that has to be meant
ALLOWED = 0.02


class SkippedError(Exception):
    """Something is not installed."""


def output(*words: object, **environment: str) -> str:
    """Run a command and read what it prints."""
    words_of_text = [str(word) for word in words]
    done = subprocess.run(
        words_of_text, capture_output=True, text=True, check=True, env={**os.environ, **environment}
    )
    return done.stdout + done.stderr


def number(said: str, before: str) -> int:
    """Read the number behind some words."""
    found = re.search(rf"{before}(\d+)", said)
    if found is None:
        raise SystemExit(said)
    return int(found.group(1))


def instructions(rounds: int, level: str, sets: tuple[str, ...] = SETS) -> int:
    """Count all instructions of a process that drives the cycles so many times."""
    words = ("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", PEERS)
    return number(output(*words, "drive", CYCLES, rounds, level, *sets), "Collected : ")


def on_this_cpu(level: str) -> float:
    """Count instructions with a level that callgrind knows."""
    if shutil.which("valgrind") is None:
        raise SkippedError("valgrind is not installed")
    return float(instructions(3, level) - instructions(1, level)) / 2


def on_aarch64(_: str) -> float:
    """Count instructions with NEON, under an emulator."""
    for program in ("qemu-aarch64", AARCH64_COMPILER, "cc"):
        if shutil.which(program) is None:
            raise SkippedError(f"{program} is not installed")
    if not Path(output("rustc", "--print", "target-libdir", "--target", AARCH64).strip()).is_dir():
        raise SkippedError(f"rustup target add {AARCH64}")
    name = AARCH64.replace("-", "_")
    linker = {
        f"CC_{name}": AARCH64_COMPILER,
        f"CARGO_TARGET_{name.upper()}_LINKER": AARCH64_COMPILER,
    }
    output(*BUILD, "--target", AARCH64, **linker)
    with tempfile.TemporaryDirectory() as folder:
        plugin = Path(folder) / "emulated.so"
        output(
            "cc", "-O2", "-shared", "-fPIC", "-o", plugin, Path(__file__).with_name("emulated.c")
        )
        emulator = ("qemu-aarch64", "-d", "plugin", "-plugin", plugin, "-L", AARCH64_LIBRARIES)
        program = TARGET / AARCH64 / "release/examples/peers"

        def count(rounds: int) -> int:
            return number(
                output(*emulator, program, "drive", CYCLES, rounds, "baseline", *SETS),
                "instructions ",
            )

        return float(count(3) - count(1)) / 2


LEVELS: dict[str, Callable[[str], float]] = {
    "baseline": on_this_cpu,
    "avx2": on_this_cpu,
    "neon": on_aarch64,
}


def main() -> None:
    """Count, and compare or store."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--store", action="store_true", help="store the counts as the new ones")
    store = parser.parse_args().store
    output(*BUILD)
    compiler = output("rustc", "--version").strip()
    steps = int(output(PEERS, "steps", CYCLES, *SETS))
    stored = (
        json.loads(STORED.read_text()) if STORED.exists() else {"compiler": compiler, "counts": {}}
    )
    counts, worse = {}, False
    for level, of in LEVELS.items():
        try:
            count = of(level) / steps
        except SkippedError as why:
            print(f"SKIPPED {level}: {why}", file=sys.stderr)
            continue
        except subprocess.CalledProcessError as error:
            print(f"SKIPPED {level}: {error.stderr.strip().splitlines()[-1]}", file=sys.stderr)
            continue
        counts[level] = round(count, 1)
        before = stored["counts"].get(level)
        change = "" if before is None else f", stored {before}: {100 * (count / before - 1):+.2f} %"
        print(f"{level}: {count:.1f} instructions a lane-step{change}")
        worse |= before is not None and abs(count / before - 1) > ALLOWED
    if store:
        kept = stored["counts"] if stored["compiler"] == compiler else {}
        STORED.write_text(
            json.dumps({"compiler": compiler, "counts": kept | counts}, indent=2) + "\n"
        )
    elif stored["compiler"] != compiler:
        print(
            f"the stored counts are of {stored['compiler']}, these of {compiler}: not judged",
            file=sys.stderr,
        )
    elif worse:
        raise SystemExit(
            f"changed by more than {100 * ALLOWED:.0f} %: if that is meant, run with --store"
        )


if __name__ == "__main__":
    main()
