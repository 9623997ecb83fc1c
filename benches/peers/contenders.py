"""What is timed: each contender prepares itself for the scenarios and then drives them, once a round.

Run as a program it is one contender, `contenders.py FOLDER KIND`. It says when it is ready and what it is; then each line of
its input, `{"step_s": ..., "cycles": ...}`, is a round, answered with the CPU time that it took and what it found.
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

LANES = 1024
STEPS_OF_A_CHUNK = 256


def cpu_s() -> float:
    """Give the user's CPU time of this process."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def numba_loop(scenarios: Scenarios, method: str) -> Round:
    """Drive cycle by cycle in a scalar loop."""
    import scalar_loop

    heun, euler = scalar_loop.build(scenarios.model, fastmath=True)
    drive = {"heun": heun, "euler": euler}[method]
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


def array_loop(scenarios: Scenarios, library: str) -> Round:
    """Drive all lanes together; the cycles fill them, several times if need be.

    A round may end before the cycles do, so that no lane waits for others.
    """
    import lanes as model

    if library == "numpy":
        xp, real, device = np, np.float64, np.asarray
    else:
        import jax
        import jax.numpy as xp

        real = {"jax-f64": np.float64, "jax-f32": np.float32}[library]
        jax.config.update("jax_enable_x64", real is np.float64)
        device = xp.asarray

    def placed(values: dict[str, Any]) -> dict[str, Any]:
        kind = {np.dtype(np.float64): real, np.dtype(np.int64): np.int32}
        return {name: device(np.asarray(v, kind.get(np.asarray(v).dtype))) for name, v in values.items()}

    step = model.step_function(scenarios.model, xp, shifts_apart=library == "numpy")
    tables = placed(model.tables(scenarios))

    def chunk(state: Any, truck: Any, tables: Any) -> Any:
        for _ in range(STEPS_OF_A_CHUNK):
            state = step(state, truck, tables)
        return state

    if library != "numpy":
        # a step over arrays of lanes is what vmap makes of the step of one lane
        def loop(state: Any, truck: Any, tables: Any) -> Any:
            return jax.lax.fori_loop(0, STEPS_OF_A_CHUNK, lambda _, s: step(s, truck, tables), state)

        chunk = jax.jit(loop)

    def one_round(step_s: float, cycles: int, lanes: int = LANES, chunks: int | None = None) -> Answer:
        truck, state = model.lanes(scenarios, [k % cycles for k in range(lanes)])
        truck, state = placed(truck | {"step_s": np.full(lanes, step_s)}), placed(state)
        sums = {name: np.zeros(lanes) for name in ("time", "wheel", "fuel")}
        driven = 0
        before = cpu_s()
        while driven != chunks:
            with np.errstate(all="ignore"):
                state = dict(chunk(state, truck, tables))
            driven += 1
            for name, total in sums.items():  # in doubles, whatever the lanes are in
                sums[name] = total + np.asarray(state[name], np.float64)
                state[name] = device(np.zeros(lanes, real))
            if np.asarray(state["done"]).all():
                break
        spent = cpu_s() - before
        return {
            "cpu_s": spent,
            "simulated_s": sums["time"].tolist(),
            "wheel_energy_j": sums["wheel"].tolist(),
            "fuel_kg": sums["fuel"].tolist(),
            "steps": float(STEPS_OF_A_CHUNK * driven * lanes),
        }

    if library != "numpy":
        one_round(0.2, len(scenarios), chunks=1)  # compiles
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
    elif kind.startswith("numba-"):
        one_round = numba_loop(scenarios, kind.removeprefix("numba-"))
        versions = ["numba"]
    else:
        one_round = array_loop(scenarios, kind)
        versions = [kind.split("-")[0]]
    print(json.dumps({"versions": {name: version(name) for name in versions}, "checks": checks}), flush=True)
    for line in sys.stdin:
        print(json.dumps(one_round(**json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
