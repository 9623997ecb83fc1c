"""The closed-loop model over many lanes at once, for NumPy and for JAX: Heun's method with cut steps, on whole arrays.

All lanes take each step together; what one lane does and another does not is computed for all and selected. Like the scalar
loop it books time, distance, wheel energy and fuel alone.

It drives by the rules of the driver before feed-forward, on rows and trucks as they were exported then, and `run.py` compares
it no more: its energies would be others. The figures in docs/src/peers.md are of that time.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from scenarios import (
    BACKWARD,
    CELLS,
    CELLS_PER_NM,
    CELLS_PER_RADPS,
    CROSS_WIND,
    DWELL,
    FAR,
    GRADE,
    GRIP,
    HALF_DENSITY,
    HEAD_WIND,
    LENGTH,
    LIMIT,
    ROLLING,
    TO_STOP,
    TRUCK,
    Scenarios,
    curve_cells,
    fuel_cells,
)

GRAVITY_MPS2 = 9.80665
PASSING = 2e-3
FORWARD = 3  # the accelerating branch, in whose place rows have the static limit today

State = dict[str, Any]


Step = Callable[[State, State, State], State]


def tables(scenarios: Scenarios) -> State:
    """Everything that is looked up: roads, engine, gears."""
    engine = scenarios.model["study"]["vehicle"]["engine"]
    speed_piece, torque_piece, fuel_map = fuel_cells(engine)
    ends = np.flatnonzero(scenarios.rows[:, DWELL] >= 0.0)
    next_end = ends[np.searchsorted(ends, np.arange(len(scenarios.rows)))]
    gears = scenarios.model["gears"]
    fields = ("speed_ratio_per_m", "ratio", "loss_share", "launches")
    own = np.array([[float(gear[field]) for field in fields] for gear in gears])
    # beside each gear's own numbers the speed ratios of those that it may shift to, 0 where there is none
    most_up = scenarios.model["study"]["vehicle"]["gearbox"]["shift"]["most_steps"]
    around = [np.append(own[1:, 0], np.zeros(most_up))[k : k + len(own)] for k in range(most_up)]
    below = np.append(own[0, 0], own[:-1, 0])
    return {
        "rows": scenarios.rows,
        "stop": next_end,
        "curves": curve_cells(engine),
        "speed_piece": speed_piece,
        "torque_piece": torque_piece,
        "fuel": fuel_map,
        "gears": np.column_stack([own, below, *around]),
    }


def step_function(model: dict[str, Any], xp: Any, *, shifts_apart: bool) -> Step:
    """Write the step for an array library; `shifts_apart` looks at shifting lanes alone, where the library may do that."""
    study = model["study"]
    vehicle, pedals, simulation = study["vehicle"], study["driver"]["pedals"], study["simulation"]
    engine, gearbox, brakes, pid = vehicle["engine"], vehicle["gearbox"], vehicle["brakes"], pedals["pid"]
    shift = gearbox["shift"]
    scale = pedals["brake_scale"]
    limiter_range = vehicle["limiter_range_mps"]
    limiter_end = vehicle["limiter_speed_mps"] + limiter_range
    inertia, wheel_mass = engine["inertia_kgm2"], model["wheel_mass_kg"]
    idle, axle = model["idle_radps"], model["axle_per_m"]
    wind = model["cross_wind"]["coefficients_m2"]
    largest_tangent = model["cross_wind"]["maximum_tangent"]
    speeds = [gear["speed_ratio_per_m"] for gear in model["gears"]]
    top = len(speeds) - 1
    where, maximum, minimum = xp.where, xp.maximum, xp.minimum

    def cell(x):
        return xp.clip(x, 0, CELLS - 1).astype(xp.int32)

    def speed_target(left, row, truck):
        braking = row["backward"] + truck["dec2"] * left
        leaving = maximum(row["forward"] - truck["acc2"] * left, model["launch_m2ps2"])
        return xp.sqrt(minimum(minimum(row["limit"], braking), leaving)), braking

    def control(v, desired, braking, integral, filtered, hold, held, row, truck):
        error = desired - v
        lag = v - filtered
        pull = truck["kp"] * error
        output = where(hold, held, pull + integral - truck["kd"] * lag)
        pedal = xp.clip(minimum(output, (limiter_end - v) * (1.0 / limiter_range)), 0.0, 1.0)
        edge = pull + truck["kp"] * pedals["overspeed_band_mps"]
        in_band = (v > pedals["overspeed_from_mps"]) & (braking >= row["limit"])
        demand = where(in_band, maximum(output, edge), output)
        brake = xp.clip(-scale * demand, 0.0, 1.0)
        realised = pedal - brake * (1.0 / scale)
        rate = truck["ki"] * error + truck["tracking"] * (realised - output)
        return pedal, brake, rate, lag * (1.0 / pid["derivative_filter_s"])

    def forces(v, torque, pedal, brake, clutch, curve, row, truck):
        closed, engaged, free_w, ratio_w, ratio, loss = clutch
        w = where(closed, v * ratio_w, free_w)
        full = curve[:, 0] + curve[:, 1] * w
        drag_torque = curve[:, 2] + curve[:, 3] * w
        available = minimum(maximum(torque, drag_torque), full)
        rate = (drag_torque + pedal * (full - drag_torque) - available) * (1.0 / engine["torque_lag_s"])
        auxiliary = truck["auxiliary"] / w
        inner = where(engaged, available - auxiliary, 0.0)
        box = inner - gearbox["loss_torque_nm"] - loss * xp.abs(inner)
        shaft = ratio * box - gearbox["retarder_torque_nm"]
        wheel = (shaft - gearbox["axle_loss_torque_nm"] - gearbox["axle_loss_share"] * xp.abs(shaft)) * axle
        relative = v + row["head"]
        t = minimum(row["cross"] / maximum(relative, 1.0), largest_tangent)
        area = truck["drag_area"]
        area = area + (((t * wind[3] + wind[2]) * t + wind[1]) * t + wind[0]) * t
        pressure = row["half_density"] * (relative * relative + row["cross"] * row["cross"])
        drag = where(relative < 0.0, -pressure, pressure) * area
        braking = truck["mass"] * minimum(brake * brakes["full_deceleration_mps2"], row["grip"])
        net = wheel - drag - truck["mass"] * row["resistance"] - braking
        return net, rate, full, drag_torque, auxiliary, inner, wheel, drag

    def fuel_rate(w, torque, drag_torque, t):
        powered = maximum(torque, 0.0)
        i = t["speed_piece"][cell(w * CELLS_PER_RADPS)]
        j = t["torque_piece"][cell(powered * CELLS_PER_NM)]
        row = t["fuel"][i, j]
        burnt = maximum(row[:, 0] + row[:, 1] * w + powered * (row[:, 2] + row[:, 3] * w), 0.0)
        return burnt * maximum(1.0 - minimum(torque, 0.0) / drag_torque, 0.0)

    def wanted_gear(gear, gearing, v, pedal, slowing, kick, closed, road_power, t):
        up_line = shift["up_speed_radps"] + shift["up_pedal_radps"] * pedal
        w = gearing[:, 0] * v
        below = maximum(gear - 1, 0)
        # what comes first counts: the weakest reason is looked at first and overruled by stronger ones
        kicks = kick & (w < shift["kickdown_speed_radps"]) & (gearing[:, 4] * v < shift["overspeed_radps"])
        wanted = where(kicks, below, gear)
        low = w < shift["down_speed_radps"] + shift["down_pedal_radps"] * pedal
        low = low & (closed | (gearing[:, 3] <= 0.0) & (pedal > 0.0))
        fast = sum((speed * v >= up_line).astype(xp.int32) for speed in speeds)
        wanted = where(low, maximum(minimum(fast - 1, below), 0), wanted)
        wanted = where((gear == 0) | ~slowing, gear, wanted)
        wanted = where((gear < top) & (w > shift["overspeed_radps"]), gear + 1, wanted)
        for steps in range(1, shift["most_steps"] + 1):
            there = gearing[:, 4 + steps] * v
            curve = t["curves"][cell(there * CELLS_PER_RADPS)]
            power = shift["power_share"] * (curve[:, 0] + curve[:, 1] * there) * there
            up = (there >= up_line) & (power >= shift["power_reserve"] * road_power)
            wanted = where(up, gear + steps, wanted)
        return where(v <= shift["minimum_speed_mps"], gear, wanted)

    def cut(before, after, part):
        crosses = (before < 0.0) & (after > 0.0)
        return where(
            crosses, minimum((after * PASSING - before) / where(crosses, after - before, 1.0), part), part
        )

    def step(s, truck, t):
        here = t["rows"][s["row"]]
        served = s["served"]
        row = {
            "limit": here[:, LIMIT],
            "backward": where(served, FAR, here[:, BACKWARD]),
            "forward": where(served, -FAR, here[:, FORWARD]),
            "resistance": here[:, ROLLING] + here[:, GRADE],
            "half_density": here[:, HALF_DENSITY],
            "head": here[:, HEAD_WIND],
            "cross": here[:, CROSS_WIND],
            "grip": here[:, GRIP],
        }
        v, left, gear = s["v"], s["left"], s["gear"]
        gearing = t["gears"][gear]
        ratio_w, launches = gearing[:, 0], gearing[:, 3] > 0.0
        desired, braking = speed_target(left, row, truck)
        error = desired - v
        hold = xp.abs(error) < truck["threshold"]
        held = where(s["holding"], s["held"], truck["kp"] * error)
        held = where((error >= 0.0) & ~truck["holds_brake"], maximum(held, 0.0), held)
        pedal, brake, j_rate, f_rate = control(
            v, desired, braking, s["integral"], s["filtered"], hold, held, row, truck
        )
        w = v * ratio_w
        slips = (w < shift["launch_speed_radps"]) & launches & (pedal > truck["slips_from"])
        closed = ~(slips | (w < model["open_radps"]))
        engaged = (slips | closed) & (s["shift"] <= 0.0)
        free_w = where(slips, shift["launch_speed_radps"], idle)
        clutch = closed, engaged, free_w, ratio_w, gearing[:, 1], gearing[:, 2]
        curve = t["curves"][cell(where(closed, w, free_w) * CELLS_PER_RADPS)]
        moving = truck["mass"] + wheel_mass + where(closed, inertia * ratio_w * ratio_w, 0.0)
        net_1, t_rate, _, _, aux_1, inner_1, wheel_1, drag_1 = forces(
            v, s["torque"], pedal, brake, clutch, curve, row, truck
        )
        a_1 = net_1 / moving

        longest = truck["step_s"]
        whole = where(s["shift"] > 0.0, minimum(s["shift"], longest), longest)
        whole = where(s["wait"] > 0.0, minimum(s["wait"], whole), whole)
        to_end = left / maximum(v + 0.5 * a_1 * whole, 1e-9)
        dt = minimum(whole, to_end)
        v_2 = maximum(v + dt * a_1, 0.0)
        desired_2, braking_2 = speed_target(maximum(left - 0.5 * dt * (v + v_2), 0.0), row, truck)

        def clamped(integral):
            return where(
                truck["ki"] > 0.0, xp.clip(integral, pid["integral_minimum"], pid["integral_maximum"]), 0.0
            )

        integral_2, filtered_2 = clamped(s["integral"] + dt * j_rate), s["filtered"] + dt * f_rate
        pedal_2, brake_2, j_rate_2, f_rate_2 = control(
            v_2, desired_2, braking_2, integral_2, filtered_2, hold, held, row, truck
        )
        net_2, t_rate_2, full, drag_torque, aux_2, inner_2, wheel_2, drag_2 = forces(
            v_2, s["torque"] + dt * t_rate, pedal_2, brake_2, clutch, curve, row, truck
        )

        error_2 = desired_2 - v_2
        releases = hold & (held < 0.0) & ~truck["holds_brake"] & (error < error_2)
        side = where(hold, 1.0, -1.0)
        outside = side * (xp.abs(error) - truck["threshold"]), side * (xp.abs(error_2) - truck["threshold"])
        part = cut(where(releases, error, outside[0]), where(releases, error_2, outside[1]), 1.0)
        above = gearing[:, 5]
        up = shift["up_speed_radps"], shift["up_pedal_radps"]
        part = cut(v * above - up[0] - up[1] * pedal, v_2 * above - up[0] - up[1] * pedal_2, part)
        down = shift["down_speed_radps"], shift["down_pedal_radps"]
        part = cut(down[0] + down[1] * pedal - w, down[0] + down[1] * pedal_2 - v_2 * ratio_w, part)

        a = 0.5 * (a_1 + net_2 / moving)
        a = where(v > 0.0, a, maximum(a, 0.0))
        square = v * v + 2.0 * a * left
        reaches = (square > 0.0) & ((left < dt * (v + 0.5 * a * dt)) | (to_end < whole))
        rests = (v + a * dt < 0.0) & ~reaches
        at_end = xp.sqrt(maximum(square, 0.0))
        under = where(reaches, v + at_end, where(rests, -a, 1.0))
        dt = where(reaches, 2.0 * left, where(rests, v, dt * part)) / under
        v_new = where(reaches, at_end, where(rests, 0.0, maximum(v + a * dt, 0.0)))
        dx = where(reaches, left, 0.5 * dt * (v + v_new))
        driving = ~s["done"]
        mean_w = where(closed, 0.5 * (v + v_new) * ratio_w, free_w)
        burnt = fuel_rate(
            mean_w, 0.5 * (inner_1 + inner_2 + aux_1 + aux_2), curve[:, 2] + curve[:, 3] * mean_w, t
        )
        pushed = maximum(wheel_1 + wheel_2, 0.0) + maximum(wheel_1, 0.0) + maximum(wheel_2, 0.0)
        fuel = burnt * truck["fuel_factor"] * dt

        torque = minimum(maximum(s["torque"] + 0.5 * dt * (t_rate + t_rate_2), drag_torque), full)
        torque = where(engaged, torque, 0.0)
        integral = clamped(s["integral"] + 0.5 * dt * (j_rate + j_rate_2))
        filtered = s["filtered"] + 0.5 * dt * (f_rate + f_rate_2)
        left = where(reaches, 0.0, left - dx)
        shift_left, wait = maximum(s["shift"] - dt, 0.0), maximum(s["wait"] - dt, 0.0)
        kick_s = shift["kickdown_s"]
        kick = where(pedal_2 > shift["kickdown_pedal"], maximum(s["kick"] - dt, 0.0), kick_s)

        reach = where(
            v_new < simulation["creep_speed_mps"],
            simulation["creep_distance_m"],
            simulation["capture_distance_m"],
        )
        captured = left + where(served, FAR, here[:, TO_STOP]) <= reach
        stop = t["stop"][s["row"]]
        ends = captured & (stop == truck["last"])
        fuel = fuel + where(captured & ~ends, truck["idling"] * t["rows"][stop, DWELL], 0.0)

        road_power = (0.5 * (drag_1 + drag_2) + truck["mass"] * row["resistance"]) * v_new
        asked = gear, gearing, v_new, pedal_2, a < 0.0, kick <= 0.0, closed, road_power
        ready = (wait <= 0.0) & (shift_left <= 0.0) & ~captured
        if shifts_apart:
            wanted = gear.copy()
            k = np.flatnonzero(ready)
            wanted[k] = wanted_gear(*(column[k] for column in asked), t)
        else:
            wanted = where(ready, wanted_gear(*asked, t), gear)
        shifts = wanted != gear
        start = where(
            here[:, GRADE] > shift["steep_slope"] * GRAVITY_MPS2,
            shift["steep_start_gear"],
            shift["start_gear"],
        )
        passes = left <= 0.0
        next_row = where(passes & driving & ~ends, s["row"] + 1, s["row"])
        served = (served | captured) & ~(passes & (here[:, DWELL] >= 0.0))
        rest = captured
        return {
            "v": where(rest, 0.0, v_new),
            "left": where(passes, t["rows"][next_row, LENGTH], left),
            "torque": where(rest, 0.0, torque),
            "integral": where(rest, 0.0, integral),
            "filtered": where(rest, 0.0, filtered),
            "held": held,
            "holding": hold & ~rest,
            "shift": where(rest, 0.0, where(shifts, shift["duration_s"], shift_left)),
            "wait": where(rest, 0.0, where(shifts, shift["interval_s"], wait)),
            "kick": where(rest, kick_s, where(shifts, shift["duration_s"] + kick_s, kick)),
            "gear": where(rest, start - 1, wanted).astype(xp.int32),
            "row": next_row.astype(xp.int32),
            "served": served,
            "done": s["done"] | ends,
            "time": s["time"] + where(driving, dt, 0.0),
            "wheel": s["wheel"] + where(driving, 0.25 * pushed * dx, 0.0),
            "fuel": s["fuel"] + where(driving, fuel, 0.0),
        }

    return step


def lanes(scenarios: Scenarios, cycles: list[int]) -> tuple[State, State]:
    """Put cycles into lanes: the trucks with their drivers, and their state at the start."""
    study = scenarios.model["study"]
    pid, shift = study["driver"]["pedals"]["pid"], study["vehicle"]["gearbox"]["shift"]
    columns = dict(zip(TRUCK, scenarios.trucks[cycles].T, strict=True))
    first = scenarios.first_row[cycles]
    engine, idle = study["vehicle"]["engine"], scenarios.model["idle_radps"]
    i, j, fuel_map = fuel_cells(engine)
    torque = columns["auxiliary_power_w"] / idle
    a, b, c, d = fuel_map[i[int(idle * CELLS_PER_RADPS)], j[(torque * CELLS_PER_NM).astype(int)]].T
    idling = (a + b * idle + torque * (c + d * idle)) * columns["fuel_factor"]
    truck = {
        "mass": columns["mass_kg"],
        "drag_area": columns["drag_area_m2"],
        "auxiliary": columns["auxiliary_power_w"],
        "fuel_factor": columns["fuel_factor"],
        "kp": columns["proportional"],
        "ki": columns["integral"],
        "kd": columns["derivative"] / pid["derivative_filter_s"],
        "tracking": columns["integral"] / (pid["tracking_ratio"] * columns["proportional"]),
        "threshold": columns["threshold_mps"],
        "holds_brake": columns["holds_brake"] > 0.0,
        "dec2": columns["twice_deceleration_mps2"],
        "acc2": columns["twice_acceleration_mps2"],
        "slips_from": columns["slips_from"],
        "idling": idling,
        "step_s": np.zeros(len(cycles)),
        "last": (first + scenarios.n_rows[cycles] - 1).astype(np.int32),
    }
    steep_start = scenarios.rows[first, GRADE] > shift["steep_slope"] * GRAVITY_MPS2
    zeros = ("v", "torque", "integral", "filtered", "held", "shift", "wait", "time", "wheel", "fuel")
    state = {name: np.zeros(len(cycles)) for name in zeros} | {
        "left": scenarios.rows[first, LENGTH],
        "holding": np.zeros(len(cycles), bool),
        "kick": np.full(len(cycles), shift["kickdown_s"]),
        "gear": (np.where(steep_start, shift["steep_start_gear"], shift["start_gear"]) - 1).astype(np.int32),
        "row": first.astype(np.int32),
        "served": np.zeros(len(cycles), bool),
        "done": np.zeros(len(cycles), bool),
    }
    return truck, state
