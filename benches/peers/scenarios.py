"""The exported scenarios: planned roads, drivers, trucks, and the engine's answers."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

# columns of a road row, as ocmc has them
LENGTH, LIMIT, BACKWARD, STATIC, GRADE, ROLLING = range(6)
HALF_DENSITY, HEAD_WIND, CROSS_WIND, TO_STOP, GRIP, DWELL = range(6, 12)
COLUMNS = 12
FAR = 1e9

# columns of a truck with its driver
TRUCK = (
    "mass_kg",
    "driven_mass_kg",
    "drag_area_m2",
    "auxiliary_power_w",
    "fuel_factor",
    "proportional",
    "integral",
    "derivative",
    "threshold_mps",
    "deceleration_mps2",
    "rise_from_rest",
    "rise_per_mps",
    "peak_ratio",
    "slips_from",
)
MASS, DRIVEN_MASS, DRAG_AREA, AUXILIARY, FUEL_FACTOR, PROPORTIONAL, INTEGRAL = range(7)
DERIVATIVE, THRESHOLD, DECELERATION, FROM_REST, PER_MPS, PEAK_RATIO, SLIPS_FROM = range(7, 14)

# cells of the look-up tables of speed (0.25 rad/s) and torque (4 Nm)
CELLS = 1024
CELLS_PER_RADPS = 4.0
CELLS_PER_NM = 0.25
LEAST_DRAG_NM = 0.1


@dataclass
class Scenarios:
    """Scenarios that were exported."""

    model: dict[str, Any]
    """The study, and what ocmc has derived from it."""
    rows: Array
    first_row: npt.NDArray[np.int64]
    n_rows: npt.NDArray[np.int64]
    trucks: Array
    """One row a cycle, by `TRUCK`."""
    answers: dict[float, dict[str, Array]]
    """By the step."""
    traces: list[Array]
    """Traces of some cycles: time without standstill, position, speed, slope."""

    def __len__(self) -> int:
        """Count the cycles."""
        return len(self.first_row)


def load(folder: Path) -> Scenarios:
    """Read what `peers export` has written."""
    model = json.loads((folder / "scenarios.json").read_text())
    cycles = model.pop("scenarios")
    answers = {
        answer.pop("step_s"): {name: np.array(column) for name, column in answer.items()}
        for answer in model.pop("answers")
    }
    ends = np.cumsum(model.pop("traces"))
    traces = np.fromfile(folder / "traces.f64", "<f8").reshape(-1, 4)
    return Scenarios(
        model=model,
        rows=np.fromfile(folder / "rows.f64", "<f8").reshape(-1, COLUMNS),
        first_row=np.array([cycle["first_row"] for cycle in cycles]),
        n_rows=np.array([cycle["rows"] for cycle in cycles]),
        # a PID driver has no threshold: below zero nothing is held
        trucks=np.array(
            [[-1.0 if c[name] is None else float(c[name]) for name in TRUCK] for c in cycles]
        ),
        answers=answers,
        traces=np.split(traces, ends[:-1]),
    )


def curve_cells(engine: dict[str, Any]) -> Array:
    """Full load and drag at zero speed and their slopes, for each cell of engine speed."""
    middle = (np.arange(CELLS) + 0.5) / CELLS_PER_RADPS

    def lines(x: list[float], y: list[float]) -> Array:
        knots, values = np.array(x), np.array(y)
        k = np.clip(np.searchsorted(knots, middle, side="right") - 1, 0, len(knots) - 2)
        slope = (values[k + 1] - values[k]) / (knots[k + 1] - knots[k])
        return np.stack([values[k] - slope * knots[k], slope], axis=1)

    full = lines(engine["full_load_speed_radps"], engine["full_load_torque_nm"])
    drag = lines(engine["map_speed_radps"], engine["drag_torque_nm"])
    # beyond the curves' ends drag stays below zero, and full load does not fall below drag
    drag[drag[:, 0] + drag[:, 1] * middle > -LEAST_DRAG_NM] = -LEAST_DRAG_NM, 0.0
    is_below = full[:, 0] + full[:, 1] * middle < drag[:, 0] + drag[:, 1] * middle
    full[is_below] = drag[is_below]
    return np.hstack([full, drag])


def fuel_cells(
    engine: dict[str, Any],
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], Array]:
    """Pieces of speed and of torque for each cell, and the bilinear map: a + b w + T (c + d w)."""
    speed, torque = np.array(engine["map_speed_radps"]), np.array(engine["map_torque_nm"])
    fuel = np.zeros((len(speed), len(torque)))
    for i, row in enumerate(engine["map_fuel_kgps"]):
        filled = list(row)
        while len(filled) < len(torque):  # an empty cell goes on with the last slope
            k = len(filled)
            slope = (filled[k - 1] - filled[k - 2]) / (torque[k - 1] - torque[k - 2])
            filled.append(filled[k - 1] + slope * (torque[k] - torque[k - 1]))
        fuel[i] = filled
    cells = np.zeros((len(speed) - 1, len(torque) - 1, 4))
    for i in range(len(speed) - 1):
        for j in range(len(torque) - 1):
            w0, t0, dw, dt = speed[i], torque[j], speed[i + 1] - speed[i], torque[j + 1] - torque[j]
            d = (fuel[i, j] - fuel[i, j + 1] - fuel[i + 1, j] + fuel[i + 1, j + 1]) / (dw * dt)
            b = (fuel[i + 1, j] - fuel[i, j]) / dw - d * t0
            c = (fuel[i, j + 1] - fuel[i, j]) / dt - d * w0
            cells[i, j] = fuel[i, j] - b * w0 - c * t0 - d * w0 * t0, b, c, d

    def pieces(knots: Array, cells_per_unit: float) -> npt.NDArray[np.int64]:
        middle = (np.arange(CELLS) + 0.5) / cells_per_unit
        return np.clip(np.searchsorted(knots, middle, side="right") - 1, 0, len(knots) - 2)

    return pieces(speed, CELLS_PER_RADPS), pieces(torque, CELLS_PER_NM), cells
