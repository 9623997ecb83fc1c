"""Closed-loop model as a scalar loop in numba: what a user writes in an afternoon, and better.

Three integrators over the same rules (truck_rules.py): `heun`, Heun's method with cut steps;
`growing`, the same with ocmc's own steps, which grow where the acceleration is steady, and lags
that are stable with them; and `euler`, semi-implicit steps of fixed length. All book less than ocmc
does: time, distance, wheel energy and fuel, no balance and no look at the progress.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import truck_rules
from numba import njit
from scenarios import (
    AUXILIARY,
    BACKWARD,
    CROSS_WIND,
    DECELERATION,
    DERIVATIVE,
    DRAG_AREA,
    DRIVEN_MASS,
    DWELL,
    FAR,
    FROM_REST,
    FUEL_FACTOR,
    GRADE,
    GRIP,
    HALF_DENSITY,
    HEAD_WIND,
    INTEGRAL,
    LENGTH,
    LIMIT,
    MASS,
    PEAK_RATIO,
    PER_MPS,
    PROPORTIONAL,
    ROLLING,
    SLIPS_FROM,
    STATIC,
    THRESHOLD,
    TO_STOP,
    Array,
)

PASSING = 2e-3
MOST_STEPS = 20_000_000
# ocmc's rule for the length of steps (kernel/step/step_length.rs): shares of the longest one,
# changes of acceleration in m/s²
SHORT_SHARE, AFTER_JUMP = 0.25, 0.07
AIM_MPS2, TOO_MUCH_MPS2, SMALLEST_MPS2 = 0.03, 0.05, 1e-9

Drive = Callable[[Array, Array, float], tuple[float, float, float, float, int]]


def build(model: dict[str, Any], method: str, *, fastmath: bool) -> Drive:
    """Compile an integrator for a study; its numbers become constants of the machine code."""
    grows = method == "growing"
    jit = njit(error_model="numpy", fastmath=fastmath)
    inlined = njit(error_model="numpy", fastmath=fastmath, inline="always")
    rules = truck_rules.rules(model, jit, inlined)
    driver, cell, forecast = rules.driver, rules.cell, rules.forecast
    desired_speed, near_ramp, stance, control = (
        rules.desired_speed,
        rules.near_ramp,
        rules.stance,
        rules.control,
    )
    rising_pedal, ceiling_after, coasting_function = (
        rules.rising_pedal,
        rules.ceiling_after,
        rules.coasting_function,
    )
    couple, forces, fuel_rate, idle_rate = (
        rules.couple,
        rules.forces,
        rules.fuel_rate,
        rules.idle_rate,
    )
    start_gear, wanted_gear = rules.start_gear, rules.wanted_gear

    study = model["study"]
    vehicle, simulation, pid = (
        study["vehicle"],
        study["simulation"],
        study["driver"]["pedals"]["pid"],
    )
    shift = vehicle["powertrain"]["combustion"]["gearbox"]["shift"]
    inertia, wheel_mass, idle_w, open_w = (
        vehicle["powertrain"]["combustion"]["engine"]["inertia_kgm2"],
        model["wheel_mass_kg"],
        model["idle_radps"],
        model["open_radps"],
    )
    torque_lag_s, filter_s = (
        vehicle["powertrain"]["combustion"]["engine"]["torque_lag_s"],
        pid["derivative_filter_s"],
    )
    per_lag = 1.0 / torque_lag_s
    # beyond it Heun's method would let the lags of torque and filtered speed run away
    longest_s = FAR if grows else 2.0 * min(torque_lag_s, filter_s)
    pedals = study["driver"]["pedals"]
    brake_mps2 = pedals["brake_scale"] * vehicle["brakes"]["full_deceleration_mps2"]
    ramp_gain_minimum = pedals["ramp_gain_minimum"]
    j_low, j_high = pid["integral_minimum"], pid["integral_maximum"]
    up_w, up_pedal = shift["up_speed_radps"], shift["up_pedal_radps"]
    down_w, down_pedal = shift["down_speed_radps"], shift["down_pedal_radps"]
    kick_pedal, kick_s, shift_s = shift["kickdown_pedal"], shift["kickdown_s"], shift["duration_s"]
    interval_s = shift["interval_s"]
    opposite_s = max(shift["opposite_interval_s"], interval_s)
    capture_m, creep_m = simulation["capture_distance_m"], simulation["creep_distance_m"]
    creep_v = simulation["creep_speed_mps"]
    per_m_of = np.array([gear["speed_ratio_per_m"] for gear in model["gears"]])
    loss_of = np.array([gear["loss_share"] for gear in model["gears"]])
    launches_of = np.array([gear["launches"] for gear in model["gears"]])
    up_per_m, skip_per_m = truck_rules.upshift_ratios(per_m_of, shift)

    @jit
    def truck_of(p: Array) -> tuple:
        """Masses, drag area, auxiliaries and decelerations.

        In this order: mass, moving mass without engine, driven mass, drag area, auxiliaries,
        deceleration, and those of the rise.
        """
        return (
            p[MASS],
            p[MASS] + wheel_mass,
            p[DRIVEN_MASS],
            p[DRAG_AREA],
            p[AUXILIARY],
            p[DECELERATION],
            p[FROM_REST],
            p[PER_MPS],
            p[PEAK_RATIO],
        )

    @jit
    def lag(dt: float, time_constant_s: float) -> tuple:
        """Shares of a first-order lag over a step, by a fraction for exp(-x).

        They are x and the half of it, and their divisor's inverse.
        """
        x = dt / time_constant_s
        over = (x * (1.0 / 12.0) + 0.5) * x
        return x, over, 1.0 / (1.0 + over)

    @jit
    def clamped(integral: float) -> float:
        return min(max(integral, j_low), j_high)

    @jit
    def rise_cut(before: float, after: float, part: float) -> float:
        """Share of a step up to a little beyond a function's rise through zero, if earlier."""
        if before < 0.0 < after:
            return min(part, (after * PASSING - before) / (after - before))
        return part

    @jit
    def pedal_function(
        output: float, demand: float, first_output: float, first_demand: float
    ) -> float:
        """Rise through zero where the driver leaves the pedal pressed at first, or presses one."""
        if first_output > 0.0:
            return -output
        return demand if first_demand < 0.0 else max(output, -demand)

    @jit
    def driver_function(
        error: float, pedals: float, hold: bool, releases: bool, ramps: bool, d: tuple
    ) -> float:
        """Rise through zero where the driver changes pedals, or begins or ends to hold one."""
        _, _, _, _, _, _, _, threshold, entry, _, _ = d
        if hold:
            return max(error if releases else abs(error) - threshold, pedals)
        enters = entry - abs(error)
        return max(-abs(enters) if ramps else enters, pedals)

    @jit
    def gear_function(
        v: float,
        accelerator: float,
        closed: bool,
        free_w: float,
        low: bool,
        gathers: bool,
        gear: int,
    ) -> float:
        """Rise through zero where the engine's speed changes the state of gear or clutch.

        It comes to a shifting line, to where the clutch opens, or to a slipping gear.
        """
        turns = v * per_m_of[gear]
        if not closed:
            return turns - free_w
        up = v * (skip_per_m[gear] if gathers else up_per_m[gear]) - up_w - up_pedal * accelerator
        return max(up, open_w - turns if low else down_w + down_pedal * accelerator - turns)

    @jit
    def coasting_target(dwell: float, served: bool) -> float:
        """Square of the speed to which the truck may coast before a crest."""
        if served:
            return 0.0
        return FAR if dwell >= 0.0 else -1.0 - dwell

    @jit
    def line_row(rows: Array, row: int) -> int:
        """Row at whose end the next stop line is."""
        while rows[row, DWELL] < 0.0:
            row += 1
        return row

    @jit
    def heun(rows: Array, p: Array, step_s: float) -> tuple:
        truck, d = truck_of(p), driver(p[PROPORTIONAL], p[INTEGRAL], p[DERIVATIVE], p[THRESHOLD])
        mass, open_mass, auxiliary_w, deceleration = (
            p[MASS],
            p[MASS] + wheel_mass,
            p[AUXILIARY],
            p[DECELERATION],
        )
        fuel_factor, has_integral, slips_from = p[FUEL_FACTOR], p[INTEGRAL] > 0.0, p[SLIPS_FROM]
        last = rows.shape[0] - 1
        time = way = wheel_j = fuel_kg = 0.0
        row, served, steps = -1, False, 0
        left = limit = static = grade = target = 0.0
        backward = to_stop = FAR
        here = (0.0, 0.0, 0.0, 0.0, 0.0)
        v = torque = integral = filtered = held = ceiling = drag = 0.0
        shift_left = up_left = down_left = 0.0
        holding = rolling = False
        kick_left, w_last = kick_s, idle_w
        short_s, brake_step_s = (
            SHORT_SHARE * step_s,
            1.0 / (brake_mps2 * max(p[PROPORTIONAL], ramp_gain_minimum)),
        )
        longest = short_s if grows else step_s
        gear = start_gear(rows[0, GRADE])
        while steps < MOST_STEPS and step_s < longest_s:
            if left <= 0.0:
                if row >= 0 and rows[row, DWELL] >= 0.0:
                    served = False
                row += 1
                r = rows[row]
                left, limit, static, grade = r[LENGTH], r[LIMIT], r[STATIC], r[GRADE]
                target = coasting_target(r[DWELL], served)
                backward, to_stop = (FAR, FAR) if served else (r[BACKWARD], r[TO_STOP])
                here = (
                    mass * (r[ROLLING] + grade),
                    r[HALF_DENSITY],
                    r[HEAD_WIND],
                    r[CROSS_WIND],
                    r[GRIP],
                )
            steps += 1
            per_m, loss, launches = per_m_of[gear], loss_of[gear], launches_of[gear]
            wish = desired_speed(left, limit, backward, ceiling, deceleration)
            desired, to_lead, _, to_plan, _ = wish
            known = forecast(v, cell(w_last), per_m, loss, launches, drag, here[0], truck)
            error = desired - v
            stands = stance(v, wish, static, target, holding, held, rolling, known, deceleration, d)
            ramps, rises, hold, held, gathers, coasts, rolling, crest = stands
            output, demand, accelerator, braking, j_rate, f_rate = control(
                v, desired, static, integral, filtered, known[7], stands, known, d
            )
            coupling = couple(
                v, per_m, launches, accelerator > slips_from, shift_left > 0.0, rolling
            )
            closed, engaged, free_w = coupling
            w = v * per_m if closed else free_w
            turning = inertia * per_m * per_m if closed else 0.0
            inverse = 1.0 / (open_mass + turning)
            net_1, command, _, _, driving_1, aux_1, wheel_1, drag_1 = forces(
                v, torque, 0.0, accelerator, braking, coupling, per_m, loss, known[3], here, truck
            )
            a_1 = net_1 * inverse

            whole = longest
            if shift_left > 0.0:
                whole = min(whole, shift_left)
            if up_left > 0.0:
                whole = min(whole, up_left)
            if down_left > 0.0:
                whole = min(whole, down_left)
            to_end = left / max(v + 0.5 * a_1 * whole, 1e-9)
            dt = min(whole, to_end)
            v_2 = max(v + dt * a_1, 0.0)
            left_2 = max(left - 0.5 * dt * (v + v_2), 0.0)
            desired_2, to_lead_2, _, to_plan_2, braking_way = desired_speed(
                left_2, limit, backward, ceiling_after(desired, dt, truck), deceleration
            )
            rise_2 = 0.0
            if gathers:
                rise_2 = rising_pedal(v_2, cell(w), per_m, loss, launches, drag, here[0], truck)
            if grows:
                x, over, under = lag(dt, torque_lag_s)
                response = (over - x * (1.0 / 6.0)) * under
                torque_2 = torque + 2.0 * over * under * (command - torque) - response * command
                x, over, under = lag(dt, filter_s)
                filtered_2 = filtered + (x * (v - filtered) + over * (v_2 - v)) * under
            else:
                response = 0.0
                torque_2 = torque + dt * per_lag * (command - torque)
                filtered_2 = filtered + dt * f_rate
            output_2, demand_2, accelerator_2, braking_2, j_rate_2, f_rate_2 = control(
                v_2,
                desired_2,
                static,
                clamped(integral + dt * j_rate),
                filtered_2,
                rise_2,
                stands,
                known,
                d,
            )
            net_2, command_2, lowest, full, driving_2, aux_2, wheel_2, drag_2 = forces(
                v_2,
                torque_2,
                response,
                accelerator_2,
                braking_2,
                coupling,
                per_m,
                loss,
                known[3],
                here,
                truck,
            )

            a_2 = net_2 * inverse
            if grows:
                change = abs(a_2 - a_1)
                if change > TOO_MUCH_MPS2 and dt > short_s:  # too long: it is taken back
                    longest, holding, drag, w_last = short_s, hold, drag_1, w
                    continue
                longest = min(max(dt * AIM_MPS2 / (change + SMALLEST_MPS2), short_s), step_s)
                if braking_2 > 0.0:
                    longest = min(longest, brake_step_s)
                if ramps:
                    longest = min(longest, short_s)

            # a step ends where a switching function of driver, plan or gearbox crosses zero
            error_2 = desired_2 - v_2
            releases = hold and held < 0.0 and error < error_2
            part = rise_cut(
                driver_function(
                    error, pedal_function(output, demand, output, demand), hold, releases, ramps, d
                ),
                driver_function(
                    error_2,
                    pedal_function(output_2, demand_2, output, demand),
                    hold,
                    releases,
                    ramps,
                    d,
                ),
                1.0,
            )
            low = v * per_m < down_w + down_pedal * accelerator
            part = rise_cut(
                gear_function(v, accelerator, closed, free_w, low, gathers, gear),
                gear_function(v_2, accelerator_2, closed, free_w, low, gathers, gear),
                part,
            )
            ahead, ahead_2 = (
                (max(to_lead, to_plan), max(to_lead_2, to_plan_2))
                if rises
                else (to_lead, to_lead_2)
            )
            crest_2 = coasting_function(v_2, braking_way, target, known[5], deceleration)
            part = rise_cut(max(ahead, crest), max(ahead_2, crest_2), part)

            jumps = part < 1.0
            if grows and jumps:
                longest = AFTER_JUMP * step_s
            second = 0.5 * part
            dt *= part
            a = a_1 + second * (a_2 - a_1)
            if v <= 0.0:
                a = max(a, 0.0)
            square = v * v + 2.0 * a * left
            timed = v + a * dt
            far = left < 0.5 * dt * (v + timed) or (to_end <= whole and not jumps) or timed < 0.0
            reaches = square > 0.0 and far
            if reaches:
                v_new = np.sqrt(square)
                dt = 2.0 * left / (v + v_new)
                dx = left
            else:
                if timed < 0.0:
                    dt, v_new = -v / a, 0.0
                else:
                    v_new = timed
                dx = 0.5 * dt * (v + v_new)

            w_new = v_new * per_m if closed else free_w
            mean_torque = driving_1 + aux_1 + second * (driving_2 + aux_2 - driving_1 - aux_1)
            fuel_kg += fuel_rate(0.5 * (w + w_new), mean_torque) * fuel_factor * dt
            # what speeds up the engine does not come through the hubs
            hub = wheel_1 - turning * a_1 if engaged else wheel_1
            hub_2 = wheel_2 - turning * a_2 if engaged else wheel_2
            hub_end = hub + part * (hub_2 - hub)
            pushed = max(hub, 0.0) + max(hub_end, 0.0)
            wheel_j += 0.5 * pushed * pushed / (abs(hub) + abs(hub_end) + 1e-9) * dx
            time += dt
            way += dx

            if grows:
                x, over, under = lag(dt, torque_lag_s)
                torque += (x * (command - torque) + over * part * (command_2 - command)) * under
                x, over, under = lag(dt, filter_s)
                filtered += (x * (v - filtered) + over * (v_new - v)) * under
            else:
                t_rate = (command - torque) * per_lag
                torque += dt * (t_rate + second * ((command_2 - torque_2) * per_lag - t_rate))
                filtered += dt * (f_rate + second * (f_rate_2 - f_rate))
            torque = min(max(torque, lowest), full) if engaged else 0.0
            if has_integral:
                # behind a ramp it begins with the pedal that keeps the speed
                after = (
                    known[0]
                    if ramps or coasts
                    else integral + dt * (j_rate + second * (j_rate_2 - j_rate))
                )
                integral = clamped(after)
            holding = hold
            mean_drag = drag_1 + second * (drag_2 - drag_1)
            drag = drag_1 + part * (drag_2 - drag_1)
            v, w_last = v_new, w
            left = 0.0 if reaches else left - dx
            shift_left = max(shift_left - dt, 0.0)
            up_left = max(up_left - dt, 0.0)
            down_left = max(down_left - dt, 0.0)
            kick_left = max(kick_left - dt, 0.0) if accelerator_2 > kick_pedal else kick_s
            risen = ceiling_after(desired, dt, truck)
            desired, _, to_ramp, _, _ = desired_speed(left, limit, backward, risen, deceleration)
            ceiling = desired * desired

            if left + to_stop <= (creep_m if v < creep_v else capture_m):
                line = line_row(rows, row)
                if line == last:
                    return time, way, wheel_j, fuel_kg, steps
                fuel_kg += idle_rate(auxiliary_w) * fuel_factor * rows[line, DWELL]
                served = True
                backward = to_stop = FAR
                target = 0.0
                v = torque = integral = filtered = ceiling = drag = 0.0
                shift_left = up_left = down_left = 0.0
                holding = rolling = False
                kick_left, w_last = kick_s, idle_w
                gear = start_gear(grade)
                if grows:
                    longest = short_s
            elif shift_left <= 0.0 and (up_left <= 0.0 or down_left <= 0.0):
                may_up = (
                    up_left <= 0.0 and braking_2 <= 0.0 and not near_ramp(to_ramp, v, deceleration)
                )
                kick, may_down, asked = kick_left <= 0.0, down_left <= 0.0, mean_drag + here[0]
                wanted = wanted_gear(
                    gear,
                    v,
                    accelerator_2,
                    a < 0.0,
                    gathers,
                    kick,
                    closed,
                    may_up,
                    may_down,
                    asked,
                    open_mass,
                )
                if wanted != gear:
                    up_left, down_left = (
                        (interval_s, opposite_s) if wanted > gear else (opposite_s, interval_s)
                    )
                    gear = wanted
                    shift_left, kick_left = shift_s, shift_s + kick_s
                    if grows:
                        longest = short_s
        return np.nan, way, np.nan, np.nan, steps

    @jit
    def euler(rows: Array, p: Array, step_s: float) -> tuple:
        truck, d = truck_of(p), driver(p[PROPORTIONAL], p[INTEGRAL], p[DERIVATIVE], p[THRESHOLD])
        mass, open_mass, auxiliary_w, deceleration = (
            p[MASS],
            p[MASS] + wheel_mass,
            p[AUXILIARY],
            p[DECELERATION],
        )
        fuel_factor, has_integral, slips_from = p[FUEL_FACTOR], p[INTEGRAL] > 0.0, p[SLIPS_FROM]
        last = rows.shape[0] - 1
        # times are counted in steps
        shift_n, kick_n = round(shift_s / step_s), round(kick_s / step_s)
        interval_n, opposite_n = round(interval_s / step_s), round(opposite_s / step_s)
        way = wheel_j = fuel_kg = 0.0
        row, served, steps = -1, False, 0
        left = limit = static = grade = target = 0.0
        backward = to_stop = FAR
        here = (0.0, 0.0, 0.0, 0.0, 0.0)
        v = torque = integral = filtered = held = ceiling = drag = 0.0
        shift_left = up_left = down_left = 0
        holding = rolling = False
        kick_left, w_last = kick_n, idle_w
        gear = start_gear(rows[0, GRADE])
        while steps < MOST_STEPS:
            while left <= 0.0:
                if row == last:  # a step so long that it passed the last line
                    return np.nan, way, np.nan, np.nan, steps
                if row >= 0 and rows[row, DWELL] >= 0.0:
                    served = False
                row += 1
                r = rows[row]
                left += r[LENGTH]
                limit, static, grade = r[LIMIT], r[STATIC], r[GRADE]
                target = coasting_target(r[DWELL], served)
                backward, to_stop = (FAR, FAR) if served else (r[BACKWARD], r[TO_STOP])
                here = (
                    mass * (r[ROLLING] + grade),
                    r[HALF_DENSITY],
                    r[HEAD_WIND],
                    r[CROSS_WIND],
                    r[GRIP],
                )
            steps += 1
            per_m, loss, launches = per_m_of[gear], loss_of[gear], launches_of[gear]
            wish = desired_speed(left, limit, backward, ceiling, deceleration)
            desired = wish[0]
            known = forecast(v, cell(w_last), per_m, loss, launches, drag, here[0], truck)
            stands = stance(v, wish, static, target, holding, held, rolling, known, deceleration, d)
            ramps, _, holding, held, gathers, coasts, rolling, _ = stands
            _, _, accelerator, braking, j_rate, f_rate = control(
                v, desired, static, integral, filtered, known[7], stands, known, d
            )
            coupling = couple(v, per_m, launches, accelerator > slips_from, shift_left > 0, rolling)
            closed, engaged, free_w = coupling
            net, command, lowest, full, driving, auxiliary, wheel, drag = forces(
                v, torque, 0.0, accelerator, braking, coupling, per_m, loss, known[3], here, truck
            )
            w_last = v * per_m if closed else free_w
            fuel_kg += fuel_rate(w_last, driving + auxiliary) * fuel_factor * step_s
            turning = inertia * per_m * per_m if closed else 0.0
            a = net / (open_mass + turning)
            v_new = max(v + a * step_s, 0.0)
            slowing = v_new < v
            v = v_new
            dx = v * step_s
            wheel_j += max(wheel - turning * a if engaged else wheel, 0.0) * dx
            way += dx
            left -= dx
            torque += step_s * (command - torque) * per_lag
            torque = min(max(torque, lowest), full) if engaged else 0.0
            if has_integral:
                integral = clamped(known[0] if ramps or coasts else integral + step_s * j_rate)
            filtered += step_s * f_rate
            shift_left, up_left, down_left = (
                max(shift_left - 1, 0),
                max(up_left - 1, 0),
                max(down_left - 1, 0),
            )
            kick_left = max(kick_left - 1, 0) if accelerator > kick_pedal else kick_n
            risen = ceiling_after(desired, step_s, truck)
            desired, _, to_ramp, _, _ = desired_speed(
                max(left, 0.0), limit, backward, risen, deceleration
            )
            ceiling = desired * desired

            if left + to_stop <= (creep_m if v < creep_v else capture_m):
                line = line_row(rows, row)
                if line == last:
                    return steps * step_s, way, wheel_j, fuel_kg, steps
                fuel_kg += idle_rate(auxiliary_w) * fuel_factor * rows[line, DWELL]
                served = True
                backward = to_stop = FAR
                target = 0.0
                v = torque = integral = filtered = ceiling = drag = 0.0
                shift_left = up_left = down_left = 0
                holding = rolling = False
                kick_left, w_last = kick_n, idle_w
                gear = start_gear(grade)
            elif shift_left <= 0 and (up_left <= 0 or down_left <= 0):
                may_up = up_left <= 0 and braking <= 0.0 and not near_ramp(to_ramp, v, deceleration)
                kick, may_down, asked = kick_left <= 0, down_left <= 0, drag + here[0]
                wanted = wanted_gear(
                    gear,
                    v,
                    accelerator,
                    slowing,
                    gathers,
                    kick,
                    closed,
                    may_up,
                    may_down,
                    asked,
                    open_mass,
                )
                if wanted != gear:
                    up_left, down_left = (
                        (interval_n, opposite_n) if wanted > gear else (opposite_n, interval_n)
                    )
                    gear = wanted
                    shift_left, kick_left = shift_n, shift_n + kick_n
        return np.nan, way, np.nan, np.nan, steps

    return euler if method == "euler" else heun
