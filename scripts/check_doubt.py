"""Check `ocmc doubt` by paired runs: the ten largest effects within 20 % or two standard errors.

Usage: python3 scripts/check_doubt.py target/release/ocmc [STUDY] [CYCLES] [SEED]. The ranges are
read from the text of the study and of its vehicle; each end is settings with which `ocmc compare`
drives the study once more, under another seed.
"""

import json
import math
import subprocess
import sys
import tomllib


def answer(*arguments: str) -> str:
    """Return what the program prints."""
    return subprocess.run(arguments, check=True, capture_output=True, text=True).stdout


def ranges(program: str, study: str) -> dict[str, dict[str, list]]:
    """Read the keys of each entry of a study, its bases and its vehicle, with their ranges."""
    text = tomllib.loads(answer(program, "study", "show", study))
    base = text["study"].get("base")
    found = ranges(program, base) if base else {}
    judged = dict(text.get("judged", {}))
    vehicle = text.get("vehicle", {}).get("base")
    if vehicle:
        of_trucks = [
            name for name, keys in found.items() if any(key.startswith("vehicle.") for key in keys)
        ]
        found = {name: keys for name, keys in found.items() if name not in of_trucks}
        of_vehicle = tomllib.loads(answer(program, "study", "show", vehicle)).get("judged", {})
        judged |= {
            name: {"vehicle." + key: values for key, values in keys.items() if key != "reason"}
            for name, keys in of_vehicle.items()
            if name != "effects_of"
        }
    judged.pop("effects_of", None)
    keep = {
        name: {key: v for key, v in keys.items() if key != "reason"}
        for name, keys in judged.items()
    }
    return found | {name: found.get(name, {}) | keys for name, keys in keep.items()}


def toml(value: object) -> str:
    """Write a value as TOML does on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml(below)}" for key, below in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


def paired(
    program: str, asked: tuple[str, str, str], keys: dict[str, list], end: int
) -> tuple[float, float]:
    """Find the change of the mean at an end, and its standard error."""
    study, cycles, seed = asked
    sets = [
        word for key, values in keys.items() for word in ("--set", f"{key}={toml(values[end])}")
    ]
    found = json.loads(
        answer(
            program,
            "compare",
            study,
            *sets,
            "--cycles",
            cycles,
            "--seed",
            seed,
            "--json",
            "--quiet",
        )
    )
    low, high = found["ci95"]
    return found["difference"], (high - low) / 2 / 1.96


def main() -> None:
    """Print each of the ten, and whether both ends agree."""
    given = sys.argv[1:]
    program, study, cycles, seed = given + ["", "field-truck", "2000", "77"][len(given) :]
    found = json.loads(answer(program, "doubt", "--study", study, "--json", "--quiet"))
    known = ranges(program, study)
    wrong = 0
    for numbers in found["numbers"][:10]:
        for end, name in [(0, "low"), (2, "high")]:
            told = numbers[name]["mean"]
            keys = {
                key: values
                for key, values in known[numbers["name"]].items()
                if key in numbers["keys"]
            }
            change, error = paired(program, (study, cycles, seed), keys, end)
            apart = abs(told["by"] - change)
            allowed = max(0.2 * abs(change), 2 * math.hypot(error, told["standard_error"]))
            wrong += apart > allowed
            print(
                f"{numbers['name']:22} {name:5} {told['by']:+.3f} ± {told['standard_error']:.3f}, "
                f"paired {change:+.3f} ± {error:.3f} {'' if apart <= allowed else 'APART'}",
                flush=True,
            )
    sys.exit(f"{wrong} of 20 are apart" if wrong else 0)


if __name__ == "__main__":
    main()
