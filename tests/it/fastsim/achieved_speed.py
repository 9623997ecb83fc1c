"""Runs FASTSim 3.1.0 and prints its achieved speed and energies: `achieved_speed.py VEHICLE CYCLE`.

VEHICLE is a file in the format of FASTSim 2, or the name of a vehicle that FASTSim has.
"""

import json
import pathlib
import sys
import warnings

warnings.filterwarnings("ignore")

import fastsim  # noqa: E402

if pathlib.Path(sys.argv[1]).exists():
    vehicle = fastsim.Vehicle.from_f2_file(sys.argv[1])
else:
    vehicle = fastsim.Vehicle.from_resource(sys.argv[1])
vehicle.set_save_interval(1)
parameters = fastsim.SimParams.default().to_pydict()
parameters["trace_miss_opts"] = "Allow"
cycle = fastsim.Cycle.from_resource(f"{sys.argv[2]}.csv")
drive = fastsim.SimDrive(vehicle, cycle, fastsim.SimParams.from_pydict(parameters))
drive.walk()
table = drive.to_dataframe()
state = drive.to_pydict()["veh"]["state"]
engine = drive.to_pydict()["veh"]["pt_type"]["Conv"]["fc"]
curve = engine["eff_interp_from_pwr_out"]["data"]
speed = list(table["veh.history.speed_ach_meters_per_second"])
time = list(table["cyc.time_seconds"])[: len(speed)]
tractive = list(table["veh.history.pwr_tractive_watts"])
wheel_j = sum(max(tractive[k], 0.0) * (time[k] - time[k - 1]) for k in range(1, len(speed)))
answer = {
    "version": fastsim.__version__ if hasattr(fastsim, "__version__") else "3.1.0",
    "time_s": time,
    "speed_mps": speed,
    "mass_kg": state["mass_kilograms"],
    "drag_j": state["energy_drag_joules"],
    "rolling_j": state["energy_rr_joules"],
    "wheel_j": wheel_j,
    "fuel_j": engine["state"]["energy_fuel_joules"],
    "rated_w": engine["pwr_out_max_watts"],
    "share": curve["grid"][0]["data"],
    "efficiency": curve["values"]["data"],
    "auxiliary_w": drive.to_pydict()["veh"]["pwr_aux_base_watts"],
}
print(json.dumps(answer))
