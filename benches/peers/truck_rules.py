"""The rules of ocmc's driver and truck for one truck, in numba: what a step of any integrator asks.

They are those that `field-truck` has turned on, as docs/src/theory/closed-loop-rules.md and the theory pages say them: the
forecast of a driver who knows his truck, feed-forward on braking ramps, the held pedal in balance, launches by the driver's
acceleration, the gearbox that looks ahead, grip by the driven axle. Nothing is here for what that study has turned off.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scenarios import CELLS, CELLS_PER_NM, CELLS_PER_RADPS, FAR, curve_cells, fuel_cells

GRAVITY_MPS2 = 9.80665
# judgements of the engine, which are no keys of a study
LEAST_TRACTION_MPS2 = 0.4 * GRAVITY_MPS2
LIFTS_AT = 1.2
ENTRY_SHARE = 0.25


class Rules(NamedTuple):
    """The compiled functions."""

    driver: Callable
    cell: Callable
    forecast: Callable
    desired_speed: Callable
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
    looks = any(ahead[name] for name in ("coasting", "eco_roll", "predictive_cruise", "engine_stop"))
    balances = pedals["switched"]["hold"] == "balance"
    if looks or not balances or not pedals["feed_forward"] or driver["speed_change"]["rise"] != "ramp":
        raise ValueError("the numba loop drives by the rules of field-truck alone")


def rules(model: dict[str, Any], jit: Callable, inlined: Callable) -> Rules:
    """Compile the rules of a study; its numbers become constants of the machine code.

    `inlined` compiles into the caller what the compiler would call: pedals, forces and gears, a sixth of the time.
    """
    study = model["study"]
    vehicle, driver_model = study["vehicle"], study["driver"]
    pedals, pid, brakes = driver_model["pedals"], driver_model["pedals"]["pid"], vehicle["brakes"]
    engine, gearbox = (
        vehicle["powertrain"]["combustion"]["engine"],
        vehicle["powertrain"]["combustion"]["gearbox"],
    )
    shift = gearbox["shift"]
    refuse_others(driver_model)

    idle_w, open_w, launch_w = model["idle_radps"], model["open_radps"], shift["launch_speed_radps"]
    axle = model["axle_per_m"]
    box_nm, box_nms = gearbox["loss_torque_nm"], gearbox["loss_torque_nms"]
    box_floor = gearbox["loss_floor_nm"]
    retarder_n = gearbox["retarder_torque_nm"] * axle
    retarder_kgpm = gearbox["retarder_torque_nms2"] * axle**3
    axle_n, axle_share = gearbox["axle_loss_torque_nm"] * axle, gearbox["axle_loss_share"]
    per_kept_by_axle = 1.0 / (1.0 - axle_share)
    per_lag = 1.0 / engine["torque_lag_s"]
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
    flat_gear, steep_gear = shift["start_gear"] - 1, shift["steep_start_gear"] - 1
    steep_mps2 = shift["steep_slope"] * GRAVITY_MPS2
    inertia = engine["inertia_kgm2"]
    per_m_of = np.array([gear["speed_ratio_per_m"] for gear in model["gears"]])
    launches_of = np.array([gear["launches"] for gear in model["gears"]])
    top = len(per_m_of) - 1
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
    def forecast(
        v: float, k: int, per_m: float, loss: float, launches: bool, drag: float, road: float, truck: tuple
    ) -> tuple:
        """Give what the driver knows by feel; `k`: cell of the engine's speed in the last step, `drag`: of the air then.

        It is outputs that keep the speed, follow a braking ramp, and give his peak acceleration; the push at which he lifts his
        foot; and the output that holds back a truck which a descent pushes harder.
        """
        mass, open_mass, _, _, auxiliary_w, deceleration, peak_acceleration = truck
        turns = v * per_m
        w = max(turns, open_w)
        moving = open_mass + inertia * per_m * per_m
        if launches and turns < launch_w:
            w, moving = launch_w, open_mass
        pressed = wheel_force(per_m, loss, v, curves[k, 0] + curves[k, 1] * w)
        released = wheel_force(per_m, loss, v, curves[k, 2] + curves[k, 3] * w)
        per_force = 1.0 / max(pressed - released, 1.0)
        released -= auxiliary_w * per_m / w
        coasting = released if turns >= open_w else 0.0
        per_brake = 1.0 / (brake_mps2 * mass)

        steady = drag + road
        slower = steady - moving * deceleration
        wanted = moving * peak_acceleration
        most = steady + LIFTS_AT * wanted
        holding = (steady - released) * per_force if steady > coasting else (steady - coasting) * per_brake
        ramp = (slower - released) * per_force if slower > coasting else (slower - coasting) * per_brake
        holding_back = (most - coasting) * per_brake if most < coasting else FAR
        return holding, ramp, (steady + wanted - released) * per_force, most, holding_back

    @jit
    def desired_speed(
        left: float, limit: float, backward: float, ceiling: float, deceleration: float
    ) -> tuple:
        """Desired speed, and three functions of it.

        They rise through zero where the driver leaves the accelerator before a braking ramp, where he shifts up no more
        before one (but for the truck's own speed), and where the rise with his acceleration has come to the plan.
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
        )

    @jit
    def near_ramp(to_ramp: float, v: float, deceleration: float) -> bool:
        """Say whether the driver soon brakes: no upshift then."""
        return to_ramp + 2.0 * deceleration * before_ramp_s * v > 0.0

    @jit
    def stance(
        error: float,
        v: float,
        to_lead: float,
        to_plan: float,
        was_holding: bool,
        held: float,
        holding: float,
        d: tuple,
    ) -> tuple:
        """Decide for a step: whether a ramp is there, the speed rises, a pedal is held, and which."""
        _, _, _, _, _, _, _, threshold, entry, _, _ = d
        ramps, rises = to_lead >= 0.0, to_plan < 0.0
        within = abs(error) < (threshold if was_holding else entry) and v > 0.0
        hold = within and not ramps and not rises
        if not was_holding:
            held = holding
        if error >= 0.0:
            held = max(held, 0.0)
        return ramps, rises, hold, held

    @inlined
    def control(
        v: float,
        desired: float,
        static: float,
        integral: float,
        filtered: float,
        stands: tuple,
        known: tuple,
        d: tuple,
    ) -> tuple:
        """Both pedals: output of the controller, what the brakes see of it, accelerator, braking, and two rates."""
        kp, ki, kd_per_s, tracking, ramp_gain, band_output, tolerance_output, _, _, dead_zone, balances = d
        ramps, rises, hold, held = stands
        holding, ramp, peak, _, holding_back = known
        error, lag = desired - v, v - filtered
        corrected = kp * (error - clip(error, -dead_zone, dead_zone))
        if ramps:
            output = min(ramp, 0.0) + ramp_gain * error
        elif hold:
            output = held + corrected
        else:
            output = corrected + (holding if balances else integral) - kd_per_s * lag
        accelerator = clip(min(output, (limiter_end - v) * per_limiter, peak), 0.0, 1.0)
        if ramps:  # a small one is coasted
            demand = max(output, output + ramp_gain * max(desired - braked_share * abs(static), 0.0))
        elif v > band_from and static > 0.0:
            demand = max(output, kp * error + band_output)
        else:
            demand = max(output, kp * error + tolerance_output)
        if rises:
            demand = min(demand, holding_back)
        braking = clip(-demand, 0.0, most_braking)
        integral_rate = ki * error + tracking * (accelerator - braking - output)
        return output, demand, accelerator, braking, integral_rate, lag * per_filter

    @jit
    def couple(v: float, per_m: float, launches: bool, drives: bool, shifts: bool) -> tuple:
        """Say whether the clutch is closed, whether torque passes, and how fast a free engine turns."""
        turns = v * per_m
        slips = launches and drives and turns < launch_w
        closed = not slips and turns >= open_w
        return closed, (slips or closed) and not shifts, launch_w if slips else idle_w

    @inlined
    def forces(
        v: float,
        torque: float,
        accelerator: float,
        braking: float,
        coupling: tuple,
        per_m: float,
        loss: float,
        most: float,
        here: tuple,
        truck: tuple,
    ) -> tuple:
        """Net force, rate of the torque and its bounds, torques of gears and auxiliaries, forces of wheels and air."""
        closed, engaged, free_w = coupling
        road, half_density, head, cross, grip = here
        mass, _, driven_mass, drag_area, auxiliary_w, _, _ = truck
        w = v * per_m if closed else free_w
        k = cell(w)
        full, lowest = curves[k, 0] + curves[k, 1] * w, curves[k, 2] + curves[k, 3] * w
        rate = (lowest + accelerator * (full - lowest) - torque) * per_lag
        auxiliary = auxiliary_w / max(w, open_w)
        # what the driven axle does not hold, and what the driver does not let
        traction = min(driven_mass * max(grip, LEAST_TRACTION_MPS2), max(most, 0.0))
        full = min(full, driving_torque(per_m, loss, v, traction) + auxiliary)
        driving = min(max(torque, lowest), full) - auxiliary if engaged else 0.0
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
        return net, rate, lowest, full, driving, auxiliary, wheel, drag

    @jit
    def start_gear(grade: float) -> int:
        return steep_gear if grade > steep_mps2 else flat_gear

    @inlined
    def wanted_gear(
        gear: int,
        v: float,
        pedal: float,
        slowing: bool,
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
        if may_up and gear < top and per_m_of[gear + 1] * v >= up_line:
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
        desired_speed,
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
