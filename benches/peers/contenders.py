"""Contenders that are timed: each prepares itself for the scenarios and drives them once a round.

Run as a program it is one contender, `contenders.py FOLDER KIND`. It says when it is ready and what
it is; then each line of its input, `{"step_s": ..., "cycles": ...}`, is a round, answered with the
CPU time that it took and what it found.
"""

import json
import os
import resource
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import scenarios as exported
from scenarios import Scenarios

Answer = dict[str, Any]
Round = Callable[[float, int], Answer]


def cpu_s() -> float:
    """Give the user's CPU time of this process."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def numba_loop(scenarios: Scenarios, method: str) -> Round:
    """Drive cycle by cycle in a scalar loop."""
    import scalar_loop

    drive = scalar_loop.build(scenarios.model, method, fastmath=True)
    roads = [
        scenarios.rows[first : first + n]
        for first, n in zip(scenarios.first_row, scenarios.n_rows, strict=True)
    ]

    def one_round(step_s: float, cycles: int) -> Answer:
        before = cpu_s()
        found = np.array([drive(roads[k], scenarios.trucks[k], step_s) for k in range(cycles)])
        spent = cpu_s() - before
        return {
            "cpu_s": spent,
            "simulated_s": found[:, 0].tolist(),
            "wheel_energy_j": found[:, 2].tolist(),
            "fuel_kg": found[:, 3].tolist(),
            "steps": float(found[:, 4].sum()),
        }

    drive(roads[0], scenarios.trucks[0], 0.2)
    return one_round


def main() -> None:
    """Wait for lines; each is a round."""
    folder, kind = Path(sys.argv[1]), sys.argv[2]
    scenarios = exported.load(folder)
    checks: dict[str, list[Any]] = {}
    if kind == "fastsim":
        import fastsim_trace

        vehicle = Path(os.environ["OCMC_DATA"]) / "vehicles/fastsim/Line_Haul_Conv.yaml"
        fastsim = fastsim_trace.Follower(scenarios, vehicle)
        one_round: Round = fastsim.one_round
        checks = {"1.0": [fastsim.check(1.0, k) for k in range(4)]}
        versions = ["fastsim"]
    elif kind == "sumo":
        import sumo_roads

        sumo = sumo_roads.Roads(scenarios, folder / "sumo", 8)
        one_round = sumo.one_round
        checks = {step: sumo.checks(float(step), 2) for step in ("1.0", "0.1")}
        versions = ["eclipse-sumo"]
    else:
        one_round = numba_loop(scenarios, kind.removeprefix("numba-"))
        versions = ["numba"]
    print(
        json.dumps({"versions": {name: version(name) for name in versions}, "checks": checks}),
        flush=True,
    )
    for line in sys.stdin:
        print(json.dumps(one_round(**json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
