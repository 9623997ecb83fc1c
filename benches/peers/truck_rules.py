"""The rules of ocmc's driver and truck for one truck, in numba: what a step of any integrator asks.

They are those that `field-truck` has turned on, as docs/src/theory/closed-loop-rules.md and the
theory pages say them: the forecast of a driver who knows his truck, feed-forward on braking ramps
and on rises, an acceleration that falls with speed, the held pedal in balance, the gearbox that
looks ahead and skips gears, rolling with an open clutch, crests passed slowly, grip by the driven
axle. Nothing is here for what that study has turned off.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scenarios import CELLS, CELLS_PER_NM, CELLS_PER_RADPS, FAR, Array, curve_cells, fuel_cells

GRAVITY_MPS2 = 9.80665
# judgements of the engine, which are no keys of a study
LEAST_TRACTION_MPS2 = 0.4 * GRAVITY_MPS2
LIFTS_AT = 1.2
ENTRY_SHARE = 0.25
ROLLED_OUT_MPS2 = 0.05
# VECTO's decision factor goes over to 1 for small changes of speed that end fast
SLOW_END_MPS, LARGE_CHANGE_MPS = 48.0 / 3.6, 11.0 / 3.6
PER_SLOW_RANGE, PER_CHANGE_RANGE = 3.6 / 4.0, 3.6 / 2.0


class Rules(NamedTuple):
    """The compiled functions."""

    driver: Callable
    cell: Callable
    forecast: Callable
    rising_pedal: Callable
    desired_speed: Callable
    ceiling_after: Callable
    coasting_function: Callable
    near_ramp: Callable
    stance: Callable
    control: Callable
    couple: Callable
    forces: Callable
    fuel_rate: Callable
    idle_rate: Callable
    start_gear: Callable
    wanted_gear: Callable


def refuse_others(driver: dict[str, Any]) -> None:
    """Raise an error for a study whose driver follows rules that are not here."""
    pedals, ahead = driver["pedals"], driver["look_ahead"]
    looks = ahead["eco_roll"] and ahead["predictive_cruise"]
    others = ahead["coasting"] or ahead["engine_stop"]
    balances = pedals["switched"]["hold"] == "balance" and pedals["feed_forward"]
    if not looks or others or not balances or driver["speed_change"]["rise"] != "ramp":
        raise ValueError("the numba loop drives by the rules of field-truck alone")


def upshift_ratios(per_m: Array, shift: dict[str, Any]) -> tuple[Array, Array]:
    """Engine speed for each m/s in the gear that an upshift waits for.

    It waits in any case, or where a truck gathers speed.
    """
    up = np.append(per_m[1:], 0.0)
    skips = up.copy()
    if shift["most_steps"] > 1:
        for gear in range(min(shift.get("skip_gears", 0), len(per_m) - 2)):
            skips[gear] = per_m[gear + 2]
    return up, skips


def rules(model: dict[str, Any], jit: Callable, inlined: Callable) -> Rules:
    """Compile the rules of a study; its numbers become constants of the machine code.

    `inlined` compiles into the caller what the compiler would call: pedals, forces and gears, a
    sixth of the time.
    """
    study = model["study"]
    vehicle, driver_model = study["vehicle"], study["driver"]
    pedals, pid, brakes = driver_model["pedals"], driver_model["pedals"]["pid"], vehicle["brakes"]
    engine, gearbox = (
        vehicle["powertrain"]["combustion"]["engine"],
        vehicle["powertrain"]["combustion"]["gearbox"],
    )
    shift, ahead = gearbox["shift"], driver_model["look_ahead"]
    refuse_others(driver_model)

    idle_w, open_w, launch_w = model["idle_radps"], model["open_radps"], shift["launch_speed_radps"]
    axle = model["axle_per_m"]
    box_nm, box_nms = gearbox["loss_torque_nm"], gearbox.get("loss_torque_nms", 0.0)
    box_floor = gearbox.get("loss_floor_nm", 0.0)
    retarder_n = gearbox["retarder_torque_nm"] * axle
    retarder_kgpm = gearbox.get("retarder_torque_nms2", 0.0) * axle**3
    axle_n, axle_share = gearbox["axle_loss_torque_nm"] * axle, gearbox["axle_loss_share"]
    per_kept_by_axle = 1.0 / (1.0 - axle_share)
    c1, c2, c3, c4 = model["cross_wind"]["coefficients_m2"]
    largest_tangent = model["cross_wind"]["maximum_tangent"]

    per_filter = 1.0 / pid["derivative_filter_s"]
    tracking_ratio = pid["tracking_ratio"]
    brake_mps2 = pedals["brake_scale"] * brakes["full_deceleration_mps2"]
    most_braking = 1.0 / pedals["brake_scale"]
    ramp_gain_minimum = pedals["ramp_gain_minimum"]
    band, band_from = pedals["overspeed_band_mps"], pedals["overspeed_from_mps"]
    tolerance = pedals["brake_tolerance_mps"]
    braked_share = 1.0 - pedals["ramp_slack_share"]
    lead_s, before_ramp_s = pedals["ramp_lead_s"], shift["before_ramp_s"]
    per_limiter = 1.0 / vehicle["limiter_range_mps"]
    limiter_end = vehicle["limiter_speed_mps"] + vehicle["limiter_range_mps"]

    minimum_v, shift_s, least_mps2 = (
        shift["minimum_speed_mps"],
        shift["duration_s"],
        shift["minimum_acceleration_mps2"],
    )
    up_w, up_pedal = shift["up_speed_radps"], shift["up_pedal_radps"]
    down_w, down_pedal = shift["down_speed_radps"], shift["down_pedal_radps"]
    overspeed, share_of_power, reserve = (
        shift["overspeed_radps"],
        shift["power_share"],
        shift["power_reserve"],
    )
    most_up, kick_w = shift["most_steps"], shift["kickdown_speed_radps"]
    slowest_v, preview_s = ahead["minimum_speed_mps"], ahead["preview_s"]
    decision, underspeed = ahead["decision_factor"], ahead["underspeed_mps"]
    flat_gear, steep_gear = shift["start_gear"] - 1, shift["steep_start_gear"] - 1
    steep_mps2 = shift["steep_slope"] * GRAVITY_MPS2
    inertia = engine["inertia_kgm2"]
    per_m_of = np.array([gear["speed_ratio_per_m"] for gear in model["gears"]])
    launches_of = np.array([gear["launches"] for gear in model["gears"]])
    top = len(per_m_of) - 1
    most_power_nm = share_of_power * max(engine["full_load_torque_nm"])
    # the gear that an upshift waits for: the next one, or beyond it while the truck gathers speed
    up_per_m, skip_per_m = upshift_ratios(per_m_of, shift)
    curves = curve_cells(engine)
    speed_piece, torque_piece, fuel_map = fuel_cells(engine)

    @jit
    def clip(x: float, low: float, high: float) -> float:
        return min(max(x, low), high)

    @jit
    def cell(w: float) -> int:
        return min(max(int(w * CELLS_PER_RADPS), 0), CELLS - 1)

    @jit
    def full_load(w: float) -> float:
        k = cell(w)
        return curves[k, 0] + curves[k, 1] * w

    @jit
    def drag_torque(w: float) -> float:
        k = cell(w)
        return curves[k, 2] + curves[k, 3] * w

    @jit
    def fuel_rate(w: float, torque: float) -> float:
        """Fuel in kg/s, before the truck's factor."""
        powered = max(torque, 0.0)
        column = torque_piece[min(int(powered * CELLS_PER_NM), CELLS - 1)]
        row = fuel_map[speed_piece[cell(w)], column]
        burnt = max(row[0] + row[1] * w + powered * (row[2] + row[3] * w), 0.0)
        return burnt if torque >= 0.0 else burnt * max(1.0 - torque / drag_torque(w), 0.0)

    @jit
    def idle_rate(auxiliary_w: float) -> float:
        return fuel_rate(idle_w, auxiliary_w / idle_w)

    @jit
    def wheel_force(per_m: float, loss: float, v: float, torque: float) -> float:
        """Force at the wheels for a torque at the gearbox's input."""
        box = loss * max(abs(torque), box_floor) + box_nm + box_nms * per_m * v
        shaft = per_m * (torque - box) - (retarder_n + retarder_kgpm * v * v)
        return shaft - axle_n - axle_share * abs(shaft)

    @jit
    def driving_torque(per_m: float, loss: float, v: float, force: float) -> float:
        """Torque that drives the wheels with a force."""
        shaft = (force + axle_n) * per_kept_by_axle + retarder_n + retarder_kgpm * v * v
        return (shaft / per_m + box_nm + box_nms * per_m * v) / (1.0 - loss)

    @jit
    def driver(kp: float, ki: float, kd: float, threshold: float) -> tuple:
        """Give what holds for a driver over a cycle; a threshold below zero is that of a PID."""
        balances = threshold > 0.0
        entry = ENTRY_SHARE * threshold if balances else threshold
        return (
            kp,
            ki,
            kd * per_filter,
            ki / (tracking_ratio * kp),
            max(kp, ramp_gain_minimum),
            kp * band,
            kp * tolerance if tolerance > 0.0 else -FAR,
            threshold,
            entry,
            entry if balances else 0.0,
            balances,
        )

    @jit
    def pedal_forces(
        v: float, k: int, per_m: float, loss: float, launches: bool, truck: tuple
    ) -> tuple:
        """Give forces without and with a released accelerator, pedal for each N more, moving mass.

        `k`: cell of the engine's speed at the step's start.
        """
        _, open_mass, _, _, auxiliary_w, _, _, _, _ = truck
        turns = v * per_m
        w = max(turns, open_w)
        moving = open_mass + inertia * per_m * per_m
        if launches and turns < launch_w:
            w, moving = launch_w, open_mass
        pressed = wheel_force(per_m, loss, v, curves[k, 0] + curves[k, 1] * w)
        released = wheel_force(per_m, loss, v, curves[k, 2] + curves[k, 3] * w)
        per_force = 1.0 / max(pressed - released, 1.0)
        released -= auxiliary_w * per_m / w
        return released if turns >= open_w else 0.0, released, per_force, moving

    @jit
    def forecast(
        v: float,
        k: int,
        per_m: float,
        loss: float,
        launches: bool,
        drag: float,
        road: float,
        truck: tuple,
    ) -> tuple:
        """Give what the driver knows by feel.

        `k`: cell of the engine's speed in the last step, `drag`: of the air then.

        It is outputs that keep the speed, follow a braking ramp, and give his peak acceleration;
        the push at which he lifts his foot; the output that holds back a truck which a descent
        pushes harder; decelerations of coasting in gear and with an open clutch; and the output
        that gives his acceleration.
        """
        mass, open_mass, _, _, _, deceleration, from_rest, per_mps, peak_ratio = truck
        coasting, released, per_force, moving = pedal_forces(v, k, per_m, loss, launches, truck)
        per_brake = 1.0 / (brake_mps2 * mass)
        steady = drag + road
        slower = steady - moving * deceleration
        rise = moving / (from_rest + per_mps * v)
        wanted = rise * peak_ratio
        most = steady + LIFTS_AT * wanted
        holding = (
            (steady - released) * per_force
            if steady > coasting
            else (steady - coasting) * per_brake
        )
        ramp = (
            (slower - released) * per_force
            if slower > coasting
            else (slower - coasting) * per_brake
        )
        holding_back = (most - coasting) * per_brake if most < coasting else FAR
        return (
            holding,
            ramp,
            (steady + wanted - released) * per_force,
            most,
            holding_back,
            (steady - coasting) / moving,
            steady / open_mass,
            (steady + rise - released) * per_force,
        )

    @jit
    def rising_pedal(
        v: float,
        k: int,
        per_m: float,
        loss: float,
        launches: bool,
        drag: float,
        road: float,
        truck: tuple,
    ) -> float:
        """Accelerator that gives the driver's acceleration at the end of a step."""
        _, _, _, _, _, _, from_rest, per_mps, _ = truck
        _, released, per_force, moving = pedal_forces(v, k, per_m, loss, launches, truck)
        return (drag + road + moving / (from_rest + per_mps * v) - released) * per_force

    @jit
    def ceiling_after(desired: float, dt: float, truck: tuple) -> float:
        """Square of what the desired speed has risen to some time later."""
        _, _, _, _, _, _, from_rest, per_mps, _ = truck
        before = from_rest + per_mps * desired
        risen = desired + 2.0 * dt / (before + np.sqrt(before * before + 2.0 * per_mps * dt))
        return risen * risen

    @jit
    def desired_speed(
        left: float, limit: float, backward: float, ceiling: float, deceleration: float
    ) -> tuple:
        """Desired speed, three functions of it, and its square on a braking ramp.

        The functions rise through zero where the driver leaves the accelerator before a braking
        ramp, where he shifts up no more before one (but for the truck's own speed), and where the
        rise with his acceleration has come to the plan.
        """
        braking = backward + 2.0 * deceleration * left
        level = min(limit, ceiling)
        desired = np.sqrt(min(level, braking))
        to_ramp = level - braking
        return (
            desired,
            to_ramp + 2.0 * deceleration * lead_s * desired,
            to_ramp,
            ceiling - min(limit, braking),
            braking,
        )

    @jit
    def coasting_function(
        v: float, braking: float, target: float, coasting: float, deceleration: float
    ) -> float:
        """Rise through zero where a truck begins to coast before a crest.

        `target`: square of the speed to which it may.
        """
        too_fast = v * v - target
        if v <= slowest_v or too_fast <= 0.0:
            return -1.0
        way, end = braking - target, np.sqrt(target)
        fast_end = clip((end - SLOW_END_MPS) * PER_SLOW_RANGE, 0.0, 1.0)
        small = clip((end - v + LARGE_CHANGE_MPS) * PER_CHANGE_RANGE, 0.0, 1.0)
        factor = decision - fast_end * small * (decision - 1.0)
        late = 2.0 * deceleration * too_fast - factor * coasting * way * 2.0
        return min(late, 2.0 * deceleration * v * preview_s - way)

    @jit
    def near_ramp(to_ramp: float, v: float, deceleration: float) -> bool:
        """Say whether the driver soon brakes: no upshift then."""
        return to_ramp + 2.0 * deceleration * before_ramp_s * v > 0.0

    @jit
    def stance(
        v: float,
        wish: tuple,
        static: float,
        target: float,
        was_holding: bool,
        held: float,
        was_rolling: bool,
        known: tuple,
        deceleration: float,
        d: tuple,
    ) -> tuple:
        """Decide for a step what the driver does.

        It is whether a ramp is there, the speed rises, a pedal is held, and which; whether the
        driver follows a rise, the truck coasts, and rolls with an open clutch; and the function
        that tells of coasting before a crest.
        """
        _, _, _, _, _, _, _, threshold, entry, _, _ = d
        desired, to_lead, _, to_plan, braking = wish
        holding, _, _, _, _, coasting, neutral, _ = known
        error = desired - v
        ramps, rises = to_lead >= 0.0, to_plan < 0.0
        crest = coasting_function(v, braking, target, coasting, deceleration)
        coasts, rolls = crest > 0.0, False
        # on a descent that gives speed
        if v > slowest_v and static > 0.0 and error <= underspeed and not ramps:
            # a clutch that has closed at the band's edge does not open again before its middle
            in_band = -error <= (band if was_rolling else 0.5 * band)
            keeps = neutral < (ROLLED_OUT_MPS2 if was_rolling else 0.0)
            rolls = in_band and keeps and not coasts
            coasts = coasts or rolls or coasting < 0.0
        within = abs(error) < (threshold if was_holding else entry) and v > 0.0
        hold = within and not ramps and not rises and not coasts
        if not was_holding:
            held = holding
        if error >= 0.0:
            held = max(held, 0.0)
        return ramps, rises, hold, held, rises and not ramps, coasts, rolls, crest

    @inlined
    def control(
        v: float,
        desired: float,
        static: float,
        integral: float,
        filtered: float,
        rise: float,
        stands: tuple,
        known: tuple,
        d: tuple,
    ) -> tuple:
        """Both pedals, and the output of the controller with the brakes' part of it.

        In this order: output, what the brakes see of it, accelerator, braking, and two rates.
        """
        (
            kp,
            ki,
            kd_per_s,
            tracking,
            ramp_gain,
            band_output,
            tolerance_output,
            _,
            _,
            dead_zone,
            balances,
        ) = d
        ramps, rises, hold, held, gathers, coasts, _, _ = stands
        holding, ramp, peak, _, holding_back, _, _, _ = known
        error, lag = desired - v, v - filtered
        corrected = kp * (error - clip(error, -dead_zone, dead_zone))
        if ramps:
            output = min(ramp, 0.0) + ramp_gain * error
        elif hold:
            output = held + corrected
        elif gathers:
            output = rise + kp * error
        else:
            output = corrected + (holding if balances else integral) - kd_per_s * lag
        if coasts:
            output = min(output, 0.0)
        accelerator = clip(min(output, (limiter_end - v) * per_limiter, peak), 0.0, 1.0)
        if ramps:  # a small one is coasted
            demand = max(
                output, output + ramp_gain * max(desired - braked_share * abs(static), 0.0)
            )
        elif v > band_from and static > 0.0:
            demand = max(output, kp * error + band_output)
        else:
            demand = max(output, kp * error + tolerance_output)
        if rises:
            demand = min(demand, holding_back)
        braking = clip(-demand, 0.0, most_braking)
        if gathers:  # behind a rise the integral part goes on from the pedal that keeps the speed
            integral_rate = tracking * (holding - integral)
        else:
            integral_rate = ki * error + tracking * (accelerator - braking - output)
        return output, demand, accelerator, braking, integral_rate, lag * per_filter

    @jit
    def couple(
        v: float, per_m: float, launches: bool, drives: bool, shifts: bool, rolls: bool
    ) -> tuple:
        """Say whether the clutch is closed and torque passes, and how fast a free engine turns."""
        turns = v * per_m
        slips = launches and drives and turns < launch_w
        closed = not slips and turns >= open_w and not rolls
        return closed, (slips or closed) and not shifts and not rolls, launch_w if slips else idle_w

    @inlined
    def forces(
        v: float,
        torque: float,
        response: float,
        accelerator: float,
        braking: float,
        coupling: tuple,
        per_m: float,
        loss: float,
        most: float,
        here: tuple,
        truck: tuple,
    ) -> tuple:
        """Net force, torques and forces of a stage.

        In this order: net force, command of the torque and its bounds, torques of gears and
        auxiliaries, forces of wheels and air.

        The torque is the one given and `response` times its command.
        """
        closed, engaged, free_w = coupling
        road, half_density, head, cross, grip = here
        mass, _, driven_mass, drag_area, auxiliary_w, _, _, _, _ = truck
        w = v * per_m if closed else free_w
        k = cell(w)
        full, lowest = curves[k, 0] + curves[k, 1] * w, curves[k, 2] + curves[k, 3] * w
        command = lowest + accelerator * (full - lowest)
        auxiliary = auxiliary_w / max(w, open_w)
        # what the driven axle does not hold, and what the driver does not let
        traction = min(driven_mass * max(grip, LEAST_TRACTION_MPS2), max(most, 0.0))
        full = min(full, driving_torque(per_m, loss, v, traction) + auxiliary)
        driving = (
            min(max(torque + response * command, lowest), full) - auxiliary if engaged else 0.0
        )
        if not closed:
            driving = max(driving, 0.0)
        wheel = wheel_force(per_m, loss, v, driving)

        relative = v + head
        t = min(cross / max(relative, 1.0), largest_tangent)
        area = drag_area + (((t * c4 + c3) * t + c2) * t + c1) * t
        drag = half_density * (relative * relative + cross * cross) * area
        if relative < 0.0:
            drag = -drag
        net = wheel - drag - road - mass * min(braking * brake_mps2, grip)
        return net, command, lowest, full, driving, auxiliary, wheel, drag

    @jit
    def start_gear(grade: float) -> int:
        return steep_gear if grade > steep_mps2 else flat_gear

    @inlined
    def wanted_gear(
        gear: int,
        v: float,
        pedal: float,
        slowing: bool,
        gathers: bool,
        kick: bool,
        closed: bool,
        may_up: bool,
        may_down: bool,
        road_n: float,
        open_mass: float,
    ) -> int:
        """Choose a gear by the strategy; `road_n`: force that the road asks for."""
        cannot_launch = not closed and not launches_of[gear] and pedal > 0.0
        if v <= minimum_v:  # a truck that has rolled to rest in a high gear
            return 0 if cannot_launch else gear
        up_line = up_w + up_pedal * pedal
        w_up = v * (skip_per_m[gear] if gathers else up_per_m[gear])
        needed = v * max(road_n * reserve, road_n + open_mass * least_mps2)
        if may_up and w_up >= up_line and w_up * most_power_nm >= needed:
            # while no torque passes the road slows the truck
            after = v - shift_s * max(road_n, 0.0) / open_mass
            for g in range(min(gear + most_up, top), gear, -1):
                w, w_after = per_m_of[g] * v, per_m_of[g] * after
                mass = open_mass + inertia * per_m_of[g] * per_m_of[g]
                strong = share_of_power * full_load(w) * w >= reserve * road_n * v
                wanted = (road_n + least_mps2 * mass) * after
                if (
                    w >= up_line
                    and strong
                    and after > 0.0
                    and share_of_power * full_load(w_after) * w_after >= wanted
                ):
                    return g
        w = per_m_of[gear] * v
        if gear < top and w > overspeed:
            return gear + 1
        if gear == 0 or not slowing or not (may_down or w < idle_w):
            return gear
        if w < down_w + down_pedal * pedal and (closed or cannot_launch):
            for g in range(gear - 1, -1, -1):
                if per_m_of[g] * v >= up_line:
                    return g
            return 0
        if kick and w < kick_w and per_m_of[gear - 1] * v < overspeed:
            return gear - 1
        return gear

    return Rules(
        driver,
        cell,
        forecast,
        rising_pedal,
        desired_speed,
        ceiling_after,
        coasting_function,
        near_ramp,
        stance,
        control,
        couple,
        forces,
        fuel_rate,
        idle_rate,
        start_gear,
        wanted_gear,
    )
