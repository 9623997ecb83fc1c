"""FASTSim's class-8 truck over the speeds that ocmc's trucks drove, one second a step.

FASTSim 3.1.0 takes the first slope of a cycle for all of it, so the road is flat here, for it and
for what it is compared with.
"""

import resource
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from scenarios import Array, Scenarios

# what FASTSim takes, as in tests/it/prescribed.rs: gravity, and the density of air that its drag
# energies say
FASTSIM_GRAVITY_MPS2 = 9.80
FASTSIM_AIR_KGPM3 = 1.1729
GRAVITY_MPS2 = 9.80665


def second_by_second(trace: Array, step_s: float) -> tuple[Array, Array]:
    """Speed at whole steps, standstill left out."""
    at, _, speed, _ = trace.T
    grid = np.arange(0.0, at[-1] + step_s, step_s)
    return grid, np.interp(grid, np.concatenate([[0.0], at]), np.concatenate([[0.0], speed]))


class Follower:
    """FASTSim's vehicle and the cycles that it follows."""

    def __init__(self, scenarios: Scenarios, vehicle: Path) -> None:
        warnings.filterwarnings("ignore")
        import fastsim

        self.fastsim = fastsim
        self.vehicle = fastsim.Vehicle.from_f2_file(str(vehicle))
        parameters = fastsim.SimParams.default().to_pydict()
        parameters["trace_miss_opts"] = "Allow"
        self.parameters = fastsim.SimParams.from_pydict(parameters)
        self.traces = scenarios.traces

    def drive(self, step_s: float, k: int, save_interval: int | None) -> Any:
        """Put the truck at the start of a cycle."""
        at, speed = second_by_second(self.traces[k], step_s)
        cycle = {
            "name": f"cycle {k}",
            "init_elev_meters": 0.0,
            "time_seconds": at.tolist(),
            "speed_meters_per_second": speed.tolist(),
            "grade": [0.0] * len(at),
        }
        self.vehicle.set_save_interval(save_interval)
        return self.fastsim.SimDrive(
            self.vehicle, self.fastsim.Cycle.from_pydict(cycle), self.parameters
        )

    def one_round(self, step_s: float, cycles: int) -> dict[str, Any]:
        """Follow some cycles; only the walk is timed."""
        drives = [self.drive(step_s, k, None) for k in range(min(cycles, len(self.traces)))]
        before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
        for drive in drives:
            drive.walk()
        spent = resource.getrusage(resource.RUSAGE_SELF).ru_utime - before
        states = [drive.to_pydict()["veh"]["state"] for drive in drives]
        return {
            "cpu_s": spent,
            "simulated_s": [state["time_seconds"] for state in states],
            "distance_m": sum(state["dist_meters"] for state in states),
            "steps": float(sum(state["i"] for state in states)),
        }

    def check(self, step_s: float, k: int) -> dict[str, Any]:
        """Give the speeds reached, the positive wheel work, and its body as ocmc needs it."""
        drive = self.drive(step_s, k, 1)
        drive.walk()
        table, whole = drive.to_dataframe(), drive.to_pydict()["veh"]
        speed = np.array(table["veh.history.speed_ach_meters_per_second"])
        at = np.array(table["cyc.time_seconds"])[: len(speed)]
        power = np.array(table["veh.history.pwr_tractive_watts"])
        body, state = whole["chassis"], whole["state"]
        rotating = body["wheel_inertia_kilogram_square_meters"] * body["num_wheels"]
        drag_area = body["drag_coef"] * body["frontal_area_square_meters"]
        return {
            "wheel_j": float(np.sum(np.maximum(power[1:], 0.0) * np.diff(at))),
            "follow": {
                "time_s": at.tolist(),
                "speed_mps": speed.tolist(),
                "slope": [0.0] * len(at),
                "mass_kg": state["mass_kilograms"],
                "wheel_mass_kg": rotating / body["wheel_radius_meters"] ** 2,
                "drag_area_m2": drag_area,
                "rolling_coefficient": body["wheel_rr_coef"] * FASTSIM_GRAVITY_MPS2 / GRAVITY_MPS2,
                "air_density_kgpm3": FASTSIM_AIR_KGPM3,
            },
        }
