"""The closed-loop model as a scalar loop in numba: what a user writes in an afternoon, and a better one.

Two integrators over the same model: `heun`, Heun's method with cut steps, and `euler`, semi-implicit steps of fixed length.
Both book less than ocmc does: time, distance, wheel energy and fuel, no balance and no look at the progress.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit
from scenarios import (
    BACKWARD,
    CELLS,
    CELLS_PER_NM,
    CELLS_PER_RADPS,
    CROSS_WIND,
    DWELL,
    FAR,
    FORWARD,
    GRADE,
    GRIP,
    HALF_DENSITY,
    HEAD_WIND,
    LENGTH,
    LIMIT,
    ROLLING,
    TO_STOP,
    Array,
    curve_cells,
    fuel_cells,
)

GRAVITY_MPS2 = 9.80665
PASSING = 2e-3
MOST_STEPS = 200_000_000

Drive = Callable[[Array, Array, float], tuple[float, float, float, float, int]]


def build(model: dict[str, Any], *, fastmath: bool) -> tuple[Drive, Drive]:
    """Compile both integrators for a study; its numbers become constants of the machine code."""
    jit = njit(error_model="numpy", fastmath=fastmath)
    study = model["study"]
    vehicle, pedals, simulation = study["vehicle"], study["driver"]["pedals"], study["simulation"]
    engine, gearbox, brakes, pid = vehicle["engine"], vehicle["gearbox"], vehicle["brakes"], pedals["pid"]
    shift = gearbox["shift"]

    launch = model["launch_m2ps2"]
    filter_s, tracking_ratio = pid["derivative_filter_s"], pid["tracking_ratio"]
    j_low, j_high = pid["integral_minimum"], pid["integral_maximum"]
    scale, full_brake = pedals["brake_scale"], brakes["full_deceleration_mps2"]
    band, band_from = pedals["overspeed_band_mps"], pedals["overspeed_from_mps"]
    limiter_range = vehicle["limiter_range_mps"]
    limiter_end = vehicle["limiter_speed_mps"] + limiter_range
    lag_s, inertia = engine["torque_lag_s"], engine["inertia_kgm2"]
    idle, open_w, axle = model["idle_radps"], model["open_radps"], model["axle_per_m"]
    wheel_mass = model["wheel_mass_kg"]
    box_loss, retarder = gearbox["loss_torque_nm"], gearbox["retarder_torque_nm"]
    axle_loss, axle_share = gearbox["axle_loss_torque_nm"], gearbox["axle_loss_share"]
    c1, c2, c3, c4 = model["cross_wind"]["coefficients_m2"]
    largest_tangent = model["cross_wind"]["maximum_tangent"]
    launch_w, minimum_v = shift["launch_speed_radps"], shift["minimum_speed_mps"]
    up_w, up_pedal = shift["up_speed_radps"], shift["up_pedal_radps"]
    down_w, down_pedal = shift["down_speed_radps"], shift["down_pedal_radps"]
    overspeed, share, reserve = shift["overspeed_radps"], shift["power_share"], shift["power_reserve"]
    most_up, kick_pedal, kick_s = shift["most_steps"], shift["kickdown_pedal"], shift["kickdown_s"]
    kick_w, shift_s, interval_s = shift["kickdown_speed_radps"], shift["duration_s"], shift["interval_s"]
    start_gear, steep_gear, steep = shift["start_gear"], shift["steep_start_gear"], shift["steep_slope"]
    capture_m, creep_m = simulation["capture_distance_m"], simulation["creep_distance_m"]
    creep_v = simulation["creep_speed_mps"]
    speed_of = np.array([gear["speed_ratio_per_m"] for gear in model["gears"]])
    ratio_of = np.array([gear["ratio"] for gear in model["gears"]])
    loss_of = np.array([gear["loss_share"] for gear in model["gears"]])
    launches_of = np.array([gear["launches"] for gear in model["gears"]])
    top = len(speed_of) - 1
    curves = curve_cells(engine)
    speed_piece, torque_piece, fuel_map = fuel_cells(engine)

    @jit
    def cell(x: float) -> int:
        return min(max(int(x), 0), CELLS - 1)

    @jit
    def clip(x: float, low: float, high: float) -> float:
        return min(max(x, low), high)

    @jit
    def full_load(w: float) -> float:
        k = cell(w * CELLS_PER_RADPS)
        return curves[k, 0] + curves[k, 1] * w

    @jit
    def fuel_rate(w: float, torque: float, drag_torque: float) -> float:
        powered = max(torque, 0.0)
        row = fuel_map[speed_piece[cell(w * CELLS_PER_RADPS)], torque_piece[cell(powered * CELLS_PER_NM)]]
        burnt = max(row[0] + row[1] * w + powered * (row[2] + row[3] * w), 0.0)
        return burnt if torque >= 0.0 else burnt * max(1.0 - torque / drag_torque, 0.0)

    @jit
    def wanted_gear(
        gear: int, v: float, pedal: float, slowing: bool, kick: bool, closed: bool, road_power: float
    ) -> int:
        if v <= minimum_v:
            return gear
        up_line = up_w + up_pedal * pedal
        for g in range(min(gear + most_up, top), gear, -1):
            w = speed_of[g] * v
            if w >= up_line and share * full_load(w) * w >= reserve * road_power:
                return g
        w = speed_of[gear] * v
        if gear < top and w > overspeed:
            return gear + 1
        if gear == 0 or not slowing:
            return gear
        if w < down_w + down_pedal * pedal and (closed or (not launches_of[gear] and pedal > 0.0)):
            for g in range(gear - 1, -1, -1):
                if speed_of[g] * v >= up_line:
                    return g
            return 0
        if kick and w < kick_w and speed_of[gear - 1] * v < overspeed:
            return gear - 1
        return gear

    @jit
    def speed_target(
        left: float, limit: float, backward: float, forward: float, dec2: float, acc2: float
    ) -> tuple:
        braking = backward + dec2 * left
        leaving = max(forward - acc2 * left, launch)
        return np.sqrt(min(limit, braking, leaving)), braking

    @jit
    def control(
        v: float,
        desired: float,
        braking: float,
        limit: float,
        integral: float,
        filtered: float,
        hold: bool,
        held: float,
        gains: tuple,
    ) -> tuple:
        kp, ki, kd, tracking = gains
        error = desired - v
        lag = v - filtered
        pull = kp * error
        output = held if hold else pull + integral - kd * lag
        pedal = clip(min(output, (limiter_end - v) * (1.0 / limiter_range)), 0.0, 1.0)
        demand = output
        if v > band_from and braking >= limit:
            demand = max(output, pull + kp * band)
        brake = clip(-scale * demand, 0.0, 1.0)
        realised = pedal - brake * (1.0 / scale)
        return pedal, brake, ki * error + tracking * (realised - output), lag * (1.0 / filter_s)

    @jit
    def forces(
        v: float,
        torque: float,
        pedal: float,
        brake: float,
        closed: bool,
        engaged: bool,
        free_w: float,
        gear: tuple,
        curve: tuple,
        truck: tuple,
        air: tuple,
    ) -> tuple:
        ratio_w, ratio, loss = gear
        f0, f1, d0, d1 = curve
        mass, drag_area, auxiliary_w = truck
        half_density, head, cross, rolling_grade, grip = air
        w = v * ratio_w if closed else free_w
        full, drag_torque = f0 + f1 * w, d0 + d1 * w
        available = min(max(torque, drag_torque), full)
        rate = (drag_torque + pedal * (full - drag_torque) - available) * (1.0 / lag_s)
        auxiliary = auxiliary_w / w
        inner = available - auxiliary if engaged else 0.0
        shaft = ratio * (inner - box_loss - loss * abs(inner)) - retarder
        wheel = (shaft - axle_loss - axle_share * abs(shaft)) * axle
        relative = v + head
        t = min(cross / max(relative, 1.0), largest_tangent)
        area = drag_area + (((t * c4 + c3) * t + c2) * t + c1) * t
        drag = half_density * (relative * relative + cross * cross) * area
        if relative < 0.0:
            drag = -drag
        braking = mass * min(brake * full_brake, grip)
        net = wheel - drag - mass * rolling_grade - braking
        return net, rate, full, drag_torque, auxiliary, inner, wheel, drag

    @jit
    def line_cut(before: float, after: float, part: float) -> float:
        if before < 0.0 < after:
            return min(part, (after * PASSING - before) / (after - before))
        return part

    @jit
    def heun(rows: Array, p: Array, step_s: float) -> tuple:
        mass, drag_area, auxiliary_w, fuel_factor = p[0], p[1], p[2], p[3]
        gains = (p[4], p[5], p[6] / filter_s, p[5] / (tracking_ratio * p[4]))
        kp, has_integral = p[4], p[5] > 0.0
        threshold, holds_brake, dec2, acc2, slips_from = p[7], p[8] > 0.0, p[9], p[10], p[11]
        truck = (mass, drag_area, auxiliary_w)
        open_inverse = 1.0 / (mass + wheel_mass)
        last = rows.shape[0] - 1
        time = way = wheel_j = fuel_kg = 0.0
        row, served, steps = 0, False, 0
        limit, backward, forward, to_stop = (
            rows[0, LIMIT],
            rows[0, BACKWARD],
            rows[0, FORWARD],
            rows[0, TO_STOP],
        )
        left = rows[0, LENGTH]
        grade = rows[0, GRADE]
        air = (
            rows[0, HALF_DENSITY],
            rows[0, HEAD_WIND],
            rows[0, CROSS_WIND],
            rows[0, ROLLING] + rows[0, GRADE],
            rows[0, GRIP],
        )
        v = torque = integral = filtered = held = shift_left = hold_left = 0.0
        holding = False
        kick_left = kick_s
        gear = (steep_gear if grade > steep * GRAVITY_MPS2 else start_gear) - 1
        while steps < MOST_STEPS:
            steps += 1
            ratio_w = speed_of[gear]
            gearing = (ratio_w, ratio_of[gear], loss_of[gear])
            desired, braking = speed_target(left, limit, backward, forward, dec2, acc2)
            error = desired - v
            hold = abs(error) < threshold
            if not holding:
                held = kp * error
            if error >= 0.0 and not holds_brake:
                held = max(held, 0.0)
            pedal, brake, j_rate, f_rate = control(
                v, desired, braking, limit, integral, filtered, hold, held, gains
            )
            w = v * ratio_w
            slips = w < launch_w and launches_of[gear] and pedal > slips_from
            closed = not (slips or w < open_w)
            engaged = (slips or closed) and shift_left <= 0.0
            free_w = launch_w if slips else idle
            k = cell((w if closed else free_w) * CELLS_PER_RADPS)
            curve = (curves[k, 0], curves[k, 1], curves[k, 2], curves[k, 3])
            inverse = 1.0 / (mass + wheel_mass + inertia * ratio_w * ratio_w) if closed else open_inverse
            net_1, t_rate, _, _, aux_1, inner_1, wheel_1, drag_1 = forces(
                v, torque, pedal, brake, closed, engaged, free_w, gearing, curve, truck, air
            )
            a_1 = net_1 * inverse

            whole = step_s
            if shift_left > 0.0:
                whole = min(whole, shift_left)
            if hold_left > 0.0:
                whole = min(whole, hold_left)
            to_end = left / max(v + 0.5 * a_1 * whole, 1e-9)
            dt = min(whole, to_end)
            v_2 = max(v + dt * a_1, 0.0)
            desired_2, braking_2 = speed_target(
                max(left - 0.5 * dt * (v + v_2), 0.0), limit, backward, forward, dec2, acc2
            )
            integral_2 = clip(integral + dt * j_rate, j_low, j_high) if has_integral else 0.0
            pedal_2, brake_2, j_rate_2, f_rate_2 = control(
                v_2, desired_2, braking_2, limit, integral_2, filtered + dt * f_rate, hold, held, gains
            )
            net_2, t_rate_2, full, drag_torque, aux_2, inner_2, wheel_2, drag_2 = forces(
                v_2,
                torque + dt * t_rate,
                pedal_2,
                brake_2,
                closed,
                engaged,
                free_w,
                gearing,
                curve,
                truck,
                air,
            )

            # a step ends where a switching function of driver or gearbox crosses zero
            error_2 = desired_2 - v_2
            if hold and held < 0.0 and not holds_brake and error < error_2:
                part = line_cut(error, error_2, 1.0)
            else:
                side = 1.0 if hold else -1.0
                part = line_cut(side * (abs(error) - threshold), side * (abs(error_2) - threshold), 1.0)
            up = speed_of[gear + 1] if gear < top else 0.0
            part = line_cut(v * up - up_w - up_pedal * pedal, v_2 * up - up_w - up_pedal * pedal_2, part)
            part = line_cut(
                down_w + down_pedal * pedal - v * ratio_w, down_w + down_pedal * pedal_2 - v_2 * ratio_w, part
            )

            a = 0.5 * (a_1 + net_2 * inverse)
            if v <= 0.0:
                a = max(a, 0.0)
            square = v * v + 2.0 * a * left
            reaches = square > 0.0 and (left < dt * (v + 0.5 * a * dt) or to_end < whole)
            if reaches:
                v_new = np.sqrt(square)
                dt = 2.0 * left / (v + v_new)
                dx = left
            else:
                if v + a * dt < 0.0:
                    dt = -v / a
                    v_new = 0.0
                else:
                    dt *= part
                    v_new = max(v + a * dt, 0.0)
                dx = 0.5 * dt * (v + v_new)
            mean_w = 0.5 * (v + v_new) * ratio_w if closed else free_w
            mean_torque = 0.5 * (inner_1 + inner_2 + aux_1 + aux_2)
            burnt = fuel_rate(mean_w, mean_torque, curve[2] + curve[3] * mean_w)
            fuel_kg += burnt * fuel_factor * dt
            pushed = max(wheel_1 + wheel_2, 0.0) + max(wheel_1, 0.0) + max(wheel_2, 0.0)
            wheel_j += 0.25 * pushed * dx
            time += dt
            way += dx

            torque = min(max(torque + 0.5 * dt * (t_rate + t_rate_2), drag_torque), full) if engaged else 0.0
            if has_integral:
                integral = clip(integral + 0.5 * dt * (j_rate + j_rate_2), j_low, j_high)
            filtered += 0.5 * dt * (f_rate + f_rate_2)
            holding = hold
            v = v_new
            left = 0.0 if reaches else left - dx
            shift_left = max(shift_left - dt, 0.0)
            hold_left = max(hold_left - dt, 0.0)
            kick_left = max(kick_left - dt, 0.0) if pedal_2 > kick_pedal else kick_s

            if left + to_stop <= (creep_m if v < creep_v else capture_m):
                stop = row
                while rows[stop, DWELL] < 0.0:
                    stop += 1
                if stop == last:
                    return time, way, wheel_j, fuel_kg, steps
                idling = fuel_rate(idle, auxiliary_w / idle, -1.0)
                fuel_kg += idling * fuel_factor * rows[stop, DWELL]
                served = True
                backward, forward, to_stop = FAR, -FAR, FAR
                v = torque = integral = filtered = shift_left = hold_left = 0.0
                holding = False
                kick_left = kick_s
                gear = (steep_gear if grade > steep * GRAVITY_MPS2 else start_gear) - 1
            elif hold_left <= 0.0 and shift_left <= 0.0:
                road_power = (0.5 * (drag_1 + drag_2) + mass * air[3]) * v
                wanted = wanted_gear(gear, v, pedal_2, a < 0.0, kick_left <= 0.0, closed, road_power)
                if wanted != gear:
                    gear = wanted
                    shift_left, hold_left, kick_left = shift_s, interval_s, shift_s + kick_s
            if left <= 0.0:
                if rows[row, DWELL] >= 0.0:
                    served = False
                row += 1
                here = rows[row]
                left, limit, grade = here[LENGTH], here[LIMIT], here[GRADE]
                backward, forward, to_stop = here[BACKWARD], here[FORWARD], here[TO_STOP]
                if served:
                    backward, forward, to_stop = FAR, -FAR, FAR
                air = (
                    here[HALF_DENSITY],
                    here[HEAD_WIND],
                    here[CROSS_WIND],
                    here[ROLLING] + here[GRADE],
                    here[GRIP],
                )
        return np.nan, way, np.nan, np.nan, steps

    @jit
    def euler(rows: Array, p: Array, step_s: float) -> tuple:
        mass, drag_area, auxiliary_w, fuel_factor = p[0], p[1], p[2], p[3]
        gains = (p[4], p[5], p[6] / filter_s, p[5] / (tracking_ratio * p[4]))
        kp, has_integral = p[4], p[5] > 0.0
        threshold, holds_brake, dec2, acc2, slips_from = p[7], p[8] > 0.0, p[9], p[10], p[11]
        truck = (mass, drag_area, auxiliary_w)
        open_inverse = 1.0 / (mass + wheel_mass)
        last = rows.shape[0] - 1
        shift_steps, interval_steps = round(shift_s / step_s), round(interval_s / step_s)
        kick_steps = round(kick_s / step_s)
        wheel_j = fuel_kg = way = 0.0
        row, served, steps = 0, False, 0
        limit, backward, forward, to_stop = (
            rows[0, LIMIT],
            rows[0, BACKWARD],
            rows[0, FORWARD],
            rows[0, TO_STOP],
        )
        left = rows[0, LENGTH]
        grade = rows[0, GRADE]
        air = (
            rows[0, HALF_DENSITY],
            rows[0, HEAD_WIND],
            rows[0, CROSS_WIND],
            rows[0, ROLLING] + rows[0, GRADE],
            rows[0, GRIP],
        )
        v = torque = integral = filtered = held = 0.0
        shift_left = hold_left = 0
        kick_left = kick_steps
        holding = False
        gear = (steep_gear if grade > steep * GRAVITY_MPS2 else start_gear) - 1
        while steps < MOST_STEPS:
            steps += 1
            ratio_w = speed_of[gear]
            desired, braking = speed_target(left, limit, backward, forward, dec2, acc2)
            error = desired - v
            hold = abs(error) < threshold
            if not holding:
                held = kp * error
            if error >= 0.0 and not holds_brake:
                held = max(held, 0.0)
            pedal, brake, j_rate, f_rate = control(
                v, desired, braking, limit, integral, filtered, hold, held, gains
            )
            holding = hold
            w = v * ratio_w
            slips = w < launch_w and launches_of[gear] and pedal > slips_from
            closed = not (slips or w < open_w)
            engaged = (slips or closed) and shift_left <= 0
            free_w = launch_w if slips else idle
            k = cell((w if closed else free_w) * CELLS_PER_RADPS)
            curve = (curves[k, 0], curves[k, 1], curves[k, 2], curves[k, 3])
            inverse = 1.0 / (mass + wheel_mass + inertia * ratio_w * ratio_w) if closed else open_inverse
            net, t_rate, full, drag_torque, auxiliary, inner, wheel, drag = forces(
                v,
                torque,
                pedal,
                brake,
                closed,
                engaged,
                free_w,
                (ratio_w, ratio_of[gear], loss_of[gear]),
                curve,
                truck,
                air,
            )
            fuel_kg += (
                fuel_rate(w if closed else free_w, inner + auxiliary, drag_torque) * fuel_factor * step_s
            )
            v_new = max(v + net * inverse * step_s, 0.0)
            slowing = v_new < v
            v = v_new
            dx = v * step_s
            wheel_j += max(wheel, 0.0) * dx
            way += dx
            left -= dx
            torque = min(max(torque + step_s * t_rate, drag_torque), full) if engaged else 0.0
            if has_integral:
                integral = clip(integral + step_s * j_rate, j_low, j_high)
            filtered += step_s * f_rate
            shift_left = max(shift_left - 1, 0)
            hold_left = max(hold_left - 1, 0)
            kick_left = max(kick_left - 1, 0) if pedal > kick_pedal else kick_steps
            if left + to_stop <= (creep_m if v < creep_v else capture_m):
                stop = row
                while rows[stop, DWELL] < 0.0:
                    stop += 1
                if stop == last:
                    return steps * step_s, way, wheel_j, fuel_kg, steps
                idling = fuel_rate(idle, auxiliary_w / idle, -1.0)
                fuel_kg += idling * fuel_factor * rows[stop, DWELL]
                served = True
                backward, forward, to_stop = FAR, -FAR, FAR
                v = torque = integral = filtered = 0.0
                shift_left = hold_left = 0
                holding = False
                kick_left = kick_steps
                gear = (steep_gear if grade > steep * GRAVITY_MPS2 else start_gear) - 1
            elif hold_left <= 0:
                road_power = (drag + mass * air[3]) * v
                wanted = wanted_gear(gear, v, pedal, slowing, kick_left <= 0, closed, road_power)
                if wanted != gear:
                    gear = wanted
                    shift_left, hold_left, kick_left = shift_steps, interval_steps, shift_steps + kick_steps
            while left <= 0.0:
                if row == last:  # a step so long that it passed the last line
                    return np.nan, way, np.nan, np.nan, steps
                if rows[row, DWELL] >= 0.0:
                    served = False
                row += 1
                here = rows[row]
                left += here[LENGTH]
                limit, grade = here[LIMIT], here[GRADE]
                backward, forward, to_stop = here[BACKWARD], here[FORWARD], here[TO_STOP]
                if served:
                    backward, forward, to_stop = FAR, -FAR, FAR
                air = (
                    here[HALF_DENSITY],
                    here[HEAD_WIND],
                    here[CROSS_WIND],
                    here[ROLLING] + here[GRADE],
                    here[GRIP],
                )
        return np.nan, way, np.nan, np.nan, steps

    return heun, euler
