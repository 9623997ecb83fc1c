//! One step of `W` trucks: controller, powertrain, resistances, and the books.
//!
//! Heun's method: v₁ = v + dt (a₁ + a₂)/2, dx = dt (v + v₁)/2. Each force's work is the mean of its two stage forces
//! times dx, so m (v₁² − v²)/2 equals the net work exactly and the energy balance closes without a remainder. The
//! crankshaft's work is the mean torque times the crank angle, which is k dx with the clutch closed and w dt while it
//! slips or is open. Fuel is the map at the step's mean speed and torque.
//!
//! The step is cut where the segment ends, where a shift or the time until the next one ends, where the truck comes to
//! rest, and where a driver or the gearbox changes its mind. Gear, clutch and
//! hold are decided at the step's start and frozen over both stages.

use super::road_row::RoadRow;
use super::state::{Shared, State, Total};
use crate::lanes::Lanes;

/// What one step did, for a trace. Means are over the step.
#[derive(Clone, Debug)]
pub struct StepView<const W: usize> {
    /// Length of the step, in s.
    pub dt: Lanes<W>,
    /// Way, in m.
    pub dx: Lanes<W>,
    /// Desired speed at the start, in m/s.
    pub desired: Lanes<W>,
    /// Accelerator pedal at the end.
    pub accelerator: Lanes<W>,
    /// Brake pedal at the end.
    pub brake: Lanes<W>,
    /// Mean engine speed, in rad/s.
    pub engine_speed: Lanes<W>,
    /// Mean engine torque, in Nm.
    pub engine_torque: Lanes<W>,
    /// Fuel, in kg/s.
    pub fuel_rate: Lanes<W>,
    /// Mean acceleration, in m/s².
    pub acceleration: Lanes<W>,
    /// Flag: the clutch is closed.
    pub closed: Lanes<W>,
    /// What was added to each total.
    pub added: [Lanes<W>; Total::COUNT],
    /// Above zero where the lane needs a look: segment end, stop, shift, check of progress.
    pub alarm: Lanes<W>,
    /// Flag: the strategy wants another gear.
    pub wants_shift: Lanes<W>,
    /// Flag: the truck slows.
    pub slowing: Lanes<W>,
    /// Steady power that the road asks for, in W.
    pub road_power: Lanes<W>,
}

/// What the driver does in one stage.
struct Control<const W: usize> {
    desired: Lanes<W>,
    accelerator: Lanes<W>,
    brake: Lanes<W>,
    integral_rate: Lanes<W>,
    filter_rate: Lanes<W>,
}

/// What is decided at the step's start.
struct Decision<const W: usize> {
    hold: Lanes<W>,
    held: Lanes<W>,
    closed: Lanes<W>,
    engaged: Lanes<W>,
    /// Engine speed where the clutch is not closed.
    free_speed: Lanes<W>,
    inverse_mass: Lanes<W>,
    /// Full-load and drag curve: value at zero speed and slope of the piece at the step's start.
    curves: [Lanes<W>; 4],
}

/// Torques and forces of one stage.
struct Forces<const W: usize> {
    acceleration: Lanes<W>,
    torque_rate: Lanes<W>,
    full: Lanes<W>,
    drag_torque: Lanes<W>,
    engine_torque: Lanes<W>,
    auxiliary_torque: Lanes<W>,
    gearbox_torque: Lanes<W>,
    wheel: Lanes<W>,
    transmission: Lanes<W>,
    drag: Lanes<W>,
    rolling: Lanes<W>,
    service_brake: Lanes<W>,
    engine_brake: Lanes<W>,
}

/// The slowest pace at which a step is cut for a segment's end, in m/s.
const SMALLEST_SPEED: f64 = 1e-9;
/// How far beyond the zero of a switching function a step goes, as a share of what is left of it.
const PASSING: f64 = 2e-3;

impl<const W: usize> State<W> {
    /// The desired speed, in m/s, and the braking branch of its square.
    #[inline(always)]
    fn desired(&self, left: Lanes<W>, shared: &Shared) -> (Lanes<W>, Lanes<W>) {
        let limit = self.row[RoadRow::LIMIT];
        let backward = self.row[RoadRow::BACKWARD] + self.twice_deceleration * left;
        let forward = (self.row[RoadRow::FORWARD] - self.twice_acceleration * left)
            .max(Lanes::all(shared.launch));
        (limit.min(backward).min(forward).sqrt(), backward)
    }

    /// The operational module at one stage.
    #[inline(always)]
    fn control(
        &self,
        speed: Lanes<W>,
        left: Lanes<W>,
        integral: Lanes<W>,
        filtered: Lanes<W>,
        hold: Lanes<W>,
        held: Lanes<W>,
        shared: &Shared,
    ) -> Control<W> {
        let pedals = shared.pedals;
        let (desired, backward) = self.desired(left, shared);
        let error = desired - speed;
        let lag = speed - filtered;
        let continuous = self.proportional * error + integral - self.derivative_over_filter * lag;
        let output = hold.choose(held, continuous);

        let vehicle = &shared.powertrain.model;
        let end_mps = vehicle.limiter_speed_mps + vehicle.limiter_range_mps;
        let fade =
            ((Lanes::all(end_mps) - speed) * (1.0 / vehicle.limiter_range_mps)).clip(0.0, 1.0);
        let accelerator = output.clip(0.0, 1.0) * fade;

        // downhill, above a static limit, the driver lets the truck run up to the edge of a band
        let over = self.proportional * (speed - desired - Lanes::all(pedals.overspeed_band_mps));
        let in_band = Lanes::flag_lt(Lanes::all(pedals.overspeed_from_mps), speed)
            .and(Lanes::flag_lt(backward, self.row[RoadRow::LIMIT]).not());
        let demand = in_band.choose(over.min(-output), -output);
        let brake = (demand * pedals.brake_scale).clip(0.0, 1.0);
        let realised = accelerator - brake * (1.0 / pedals.brake_scale);
        Control {
            desired,
            accelerator,
            brake,
            integral_rate: self.integral_gain * error + self.tracking * (realised - output),
            filter_rate: lag * (1.0 / pedals.pid.derivative_filter_s),
        }
    }

    /// Clutch and hold at the step's start.
    #[inline(always)]
    fn decide(&self, shared: &Shared) -> (Decision<W>, Control<W>) {
        let (desired, _) = self.desired(self.left, shared);
        let error = desired - self.speed;
        let hold = Lanes::flag_lt(error.abs(), self.threshold);
        // what is held is the output at the moment when holding began
        let held = self.holding.choose(self.held, self.proportional * error);
        // a held brake is released when e >= 0, unless the driver holds as printed in the paper
        let released = Lanes::select_lt(error, Lanes::ZERO, held, held.max(Lanes::ZERO));
        let held = self.holds_brake.choose(held, released);
        let control =
            self.control(self.speed, self.left, self.integral, self.filtered, hold, held, shared);

        let launch = Lanes::all(shared.powertrain.model.gearbox.shift.launch_speed_radps);
        let speed = self.speed * self.gear_speed;
        let pressed = Lanes::flag_lt(Lanes::ZERO, control.accelerator);
        let slips = Lanes::select_lt(speed, launch, self.gear_launches.and(pressed), Lanes::ZERO);
        let slow = Lanes::flag_lt(speed, Lanes::all(shared.open_radps));
        let closed = slips.or(slow).not();
        let shifting = Lanes::flag_lt(Lanes::ZERO, self.shift_left);
        let engaged = slips.or(closed).and(shifting.not());
        let free_speed = slips.choose(launch, Lanes::all(shared.idle_radps));
        let inverse_mass = closed.choose(self.inverse_mass_closed, self.inverse_mass_open);
        let curves = shared.powertrain.engine.curve_rows(closed.choose(speed, free_speed));
        (Decision { hold, held, closed, engaged, free_speed, inverse_mass, curves }, control)
    }

    /// Torques and forces at one stage.
    #[inline(always)]
    fn forces(
        &self,
        speed: Lanes<W>,
        torque: Lanes<W>,
        control: &Control<W>,
        decision: &Decision<W>,
        shared: &Shared,
    ) -> Forces<W> {
        let zero = Lanes::ZERO;
        let vehicle = &shared.powertrain.model;
        let engine_speed = decision.closed.choose(speed * self.gear_speed, decision.free_speed);

        // one division serves the torque of the auxiliaries and the angle of the wind
        let relative = speed + self.row[RoadRow::HEAD_WIND];
        let air = relative.max(Lanes::all(1.0));
        let inverse = Lanes::all(1.0) / (engine_speed * air);

        let [full_0, full_1, drag_0, drag_1] = decision.curves;
        let full = full_0 + full_1 * engine_speed;
        let drag_torque = drag_0 + drag_1 * engine_speed;
        let available = torque.max(drag_torque).min(full);
        let command = drag_torque + control.accelerator * (full - drag_torque);
        let torque_rate = (command - available) * (1.0 / vehicle.engine.torque_lag_s);
        let auxiliary_torque = self.auxiliary_power * air * inverse;
        let gearbox_torque = decision.engaged.choose(available - auxiliary_torque, zero);
        let engine_torque = gearbox_torque + auxiliary_torque;

        let gearbox = &vehicle.gearbox;
        let before = gearbox_torque * self.gear_speed;
        let shaft = self.gear_ratio
            * (gearbox_torque
                - Lanes::all(gearbox.loss_torque_nm)
                - self.gear_loss * gearbox_torque.abs())
            - Lanes::all(gearbox.retarder_torque_nm);
        let wheel = (shaft
            - Lanes::all(gearbox.axle_loss_torque_nm)
            - shaft.abs() * gearbox.axle_loss_share)
            * shared.axle_per_m;

        let wind = &shared.powertrain.cross_wind;
        let tangent = (self.row[RoadRow::CROSS_WIND] * engine_speed * inverse)
            .min(Lanes::all(wind.maximum_tangent));
        let [c1, c2, c3, c4, c5] = wind.coefficients_m2;
        let increment = ((((tangent * c5 + Lanes::all(c4)) * tangent + Lanes::all(c3)) * tangent
            + Lanes::all(c2))
            * tangent
            + Lanes::all(c1))
            * tangent;
        let cross = self.row[RoadRow::CROSS_WIND];
        let pressure = self.row[RoadRow::HALF_DENSITY] * (relative * relative + cross * cross);
        let towards = Lanes::select_lt(relative, zero, -pressure, pressure);
        let drag = towards * (self.drag_area + increment);

        let rolling = self.mass * self.row[RoadRow::ROLLING];
        let grade = self.mass * self.row[RoadRow::GRADE];
        let wanted = self.mass
            * (control.brake * vehicle.brakes.full_deceleration_mps2).min(self.row[RoadRow::GRIP]);
        let reach = decision.engaged * engine_speed * self.gear_speed * shared.engine_brake_nms;
        let engine_brake = wanted.min(reach);
        let net = wheel - drag - rolling - grade - wanted;
        Forces {
            acceleration: net * decision.inverse_mass,
            torque_rate,
            full,
            drag_torque,
            engine_torque,
            auxiliary_torque,
            gearbox_torque,
            wheel,
            transmission: before - wheel,
            drag,
            rolling,
            service_brake: wanted - engine_brake,
            engine_brake,
        }
    }

    /// Advances all lanes by one step, cut for each lane where something ends.
    #[inline(always)]
    pub fn step(&mut self, shared: &Shared) -> StepView<W> {
        let zero = Lanes::ZERO;
        let half = 0.5;
        let (decision, first_control) = self.decide(shared);
        let start_speed = decision.closed.choose(self.speed * self.gear_speed, decision.free_speed);
        let first = self.forces(self.speed, self.torque, &first_control, &decision, shared);

        // how far this step may go
        let longest = Lanes::all(shared.simulation.step_s);
        let whole = Lanes::select_lt(zero, self.shift_left, self.shift_left.min(longest), longest);
        let whole = Lanes::select_lt(zero, self.hold_left, self.hold_left.min(whole), whole);
        let pace = (self.speed + first.acceleration * whole * half).max(Lanes::all(SMALLEST_SPEED));
        let to_end = self.left / pace;
        let dt = whole.min(to_end);

        // second stage, at the predicted end
        let speed_2 = (self.speed + dt * first.acceleration).max(zero);
        let left_2 = (self.left - dt * (self.speed + speed_2) * half).max(zero);
        let torque_2 = self.torque + dt * first.torque_rate;
        let integral_2 =
            self.clamp_integral(self.integral + dt * first_control.integral_rate, shared);
        let filtered_2 = self.filtered + dt * first_control.filter_rate;
        let second_control = self.control(
            speed_2,
            left_2,
            integral_2,
            filtered_2,
            decision.hold,
            decision.held,
            shared,
        );
        let second = self.forces(speed_2, torque_2, &second_control, &decision, shared);

        // where the driver or the gearbox changes its mind within the step, and how far into it that is
        let (mind, mind_of) =
            self.change_of_mind(speed_2, &decision, &first_control, &second_control, shared);

        // a truck at rest does not roll back: the brakes hold it, without work
        let free = (first.acceleration + second.acceleration) * half;
        let mean = Lanes::select_lt(zero, self.speed, free, free.max(zero));
        // the ends of a step: its time is over, a mind changes, the segment ends, the truck comes to rest
        let way = dt * (self.speed + mean * dt * half);
        let square = self.speed * self.speed + mean * self.left * 2.0;
        let at_end = square.max(zero).sqrt();
        let far = Lanes::flag_lt(self.left, way).or(Lanes::flag_lt(to_end, whole));
        let reaches = Lanes::flag_lt(zero, square).and(far);
        let timed = self.speed + mean * dt;
        let rests = Lanes::flag_lt(timed, zero).and(reaches.not());
        let stays = rests.or(reaches).not();
        let over = reaches.choose(self.left * 2.0, rests.choose(self.speed, dt * mind));
        let under = reaches.choose(self.speed + at_end, rests.choose(-mean, mind_of));
        let dt = over / under;
        let timed = stays.choose(self.speed + mean * dt, zero);
        let end = reaches.choose(at_end, timed.max(zero));
        let dx = reaches.choose(self.left, dt * (self.speed + end) * half);

        // the books
        let angle = decision.closed.choose(dx * self.gear_speed, dt * decision.free_speed);
        let torque = (first.engine_torque + second.engine_torque) * half;
        let gearbox_torque = (first.gearbox_torque + second.gearbox_torque) * half;
        let auxiliary = (first.auxiliary_torque + second.auxiliary_torque) * half;
        let mean_speed = decision
            .closed
            .choose((self.speed + end) * self.gear_speed * half, decision.free_speed);
        let fuel_rate = shared.powertrain.engine.fuel_rates(mean_speed, torque) * self.fuel_factor;
        let half_way = dx * half;
        let jump = self.engine_speed * self.engine_speed - start_speed * start_speed;
        let drag = first.drag + second.drag;
        let rolling = first.rolling + second.rolling;
        let grade = self.mass * self.row[RoadRow::GRADE];
        let mut added = [zero; Total::COUNT];
        added[Total::Time as usize] = dt;
        added[Total::Distance as usize] = dx;
        added[Total::Fuel as usize] = fuel_rate * dt;
        added[Total::Crankshaft as usize] = torque * angle;
        added[Total::Auxiliary as usize] = auxiliary * angle;
        added[Total::Clutch as usize] = gearbox_torque * (angle - dx * self.gear_speed);
        added[Total::Transmission as usize] = (first.transmission + second.transmission) * half_way;
        added[Total::Shift as usize] = jump * (0.5 * shared.engine_inertia_kgm2);
        added[Total::Drag as usize] = drag * half_way;
        added[Total::Rolling as usize] = rolling * half_way;
        added[Total::Grade as usize] = grade * dx;
        added[Total::ServiceBrake as usize] =
            (first.service_brake + second.service_brake) * half_way;
        added[Total::EngineBrake as usize] = (first.engine_brake + second.engine_brake) * half_way;
        // of a force that changes its sign the mean of the positive parts is too much, the positive part of the
        // mean too little, by the same amount
        let both = (first.wheel + second.wheel).max(zero);
        let each = first.wheel.max(zero) + second.wheel.max(zero);
        added[Total::Wheel as usize] = (both + each) * half_way * half;
        for (total, amount) in self.totals.iter_mut().zip(&added) {
            *total = *total + *amount;
        }

        // the new state
        let half_dt = dt * half;
        let driven = (self.torque + half_dt * (first.torque_rate + second.torque_rate))
            .max(second.drag_torque)
            .min(second.full);
        self.torque = decision.engaged.choose(driven, zero);
        self.integral = self.clamp_integral(
            self.integral + half_dt * (first_control.integral_rate + second_control.integral_rate),
            shared,
        );
        self.filtered =
            self.filtered + half_dt * (first_control.filter_rate + second_control.filter_rate);
        self.holding = decision.hold;
        self.held = decision.held;
        self.speed = end;
        self.left = reaches.choose(zero, self.left - dx);
        self.engine_speed = decision.closed.choose(end * self.gear_speed, decision.free_speed);
        self.shift_left = (self.shift_left - dt).max(zero);
        self.hold_left = (self.hold_left - dt).max(zero);
        let shift = &shared.powertrain.model.gearbox.shift;
        let pressed = Lanes::flag_lt(Lanes::all(shift.kickdown_pedal), second_control.accelerator);
        self.kick_left =
            pressed.choose((self.kick_left - dt).max(zero), Lanes::all(shift.kickdown_s));
        self.steps_left = self.steps_left - Lanes::all(1.0);

        let slowing = Lanes::flag_lt(mean, zero);
        let road_power = ((drag + rolling) * half + grade) * end;
        let wants_shift = self.wants_shift(
            second_control.accelerator,
            slowing,
            decision.closed,
            road_power,
            shared,
        );
        let alarm = self.alarm(wants_shift, shared);
        StepView {
            dt,
            dx,
            desired: first_control.desired,
            accelerator: second_control.accelerator,
            brake: second_control.brake,
            engine_speed: mean_speed,
            engine_torque: torque,
            fuel_rate,
            acceleration: mean,
            closed: decision.closed,
            added,
            alarm,
            wants_shift,
            slowing,
            road_power,
        }
    }

    /// The share of the step, as numerator and denominator, after which a switched driver begins or ends to hold, or
    /// an engine speed crosses a shifting line; 1/1 where neither happens. Without this cut both are decided up to a
    /// step too late, and the error is of first order in the step.
    #[inline(always)]
    fn change_of_mind(
        &self,
        speed_2: Lanes<W>,
        decision: &Decision<W>,
        first: &Control<W>,
        second: &Control<W>,
        shared: &Shared,
    ) -> (Lanes<W>, Lanes<W>) {
        let zero = Lanes::ZERO;
        let shift = &shared.powertrain.model.gearbox.shift;
        // functions that rise through zero where a mind changes
        let (error_1, error_2) = (first.desired - self.speed, second.desired - speed_2);
        let outside = |error: Lanes<W>| error.abs() - self.threshold;
        let releases = decision
            .hold
            .and(Lanes::flag_lt(decision.held, zero))
            .and(self.holds_brake.not())
            .and(Lanes::flag_lt(error_1, error_2));
        let hold_of = |error| {
            let switches = decision.hold.choose(outside(error), -outside(error));
            releases.choose(error, switches)
        };
        let up_of = |speed: Lanes<W>, control: &Control<W>| {
            speed * self.gear_speed_up
                - Lanes::all(shift.up_speed_radps)
                - control.accelerator * shift.up_pedal_radps
        };
        let down_of = |speed: Lanes<W>, control: &Control<W>| {
            Lanes::all(shift.down_speed_radps) + control.accelerator * shift.down_pedal_radps
                - speed * self.gear_speed
        };
        let mut over = Lanes::all(1.0);
        let mut under = Lanes::all(1.0);
        for (before, after) in [
            (hold_of(error_1), hold_of(error_2)),
            (up_of(self.speed, first), up_of(speed_2, second)),
            (down_of(self.speed, first), down_of(speed_2, second)),
        ] {
            // the zero of the line between both, and a little more, so that the change is seen
            let part = after * PASSING - before;
            let whole = after - before;
            let crosses = Lanes::flag_lt(before, zero)
                .and(Lanes::flag_lt(zero, after))
                .and(Lanes::flag_lt(part * under, over * whole));
            over = crosses.choose(part, over);
            under = crosses.choose(whole, under);
        }
        (over, under)
    }

    #[inline(always)]
    fn clamp_integral(&self, integral: Lanes<W>, shared: &Shared) -> Lanes<W> {
        let pid = &shared.pedals.pid;
        let clamped = integral.clip(pid.integral_minimum, pid.integral_maximum);
        // a driver without an integral part keeps none
        Lanes::select_lt(Lanes::ZERO, self.integral_gain, clamped, Lanes::ZERO)
    }

    /// Whether the strategy may want another gear: the exact answer is [`crate::vehicle::gearbox::ShiftModel::wanted_gear`].
    #[inline(always)]
    fn wants_shift(
        &self,
        accelerator: Lanes<W>,
        slowing: Lanes<W>,
        closed: Lanes<W>,
        road_power: Lanes<W>,
        shared: &Shared,
    ) -> Lanes<W> {
        let zero = Lanes::ZERO;
        let shift = &shared.powertrain.model.gearbox.shift;
        let speed = self.speed * self.gear_speed;
        let up_speed = self.speed * self.gear_speed_up;
        let up_line = Lanes::all(shift.up_speed_radps) + accelerator * shift.up_pedal_radps;
        let down_line = Lanes::all(shift.down_speed_radps) + accelerator * shift.down_pedal_radps;
        let ready = Lanes::flag_lt(Lanes::all(shift.minimum_speed_mps), self.speed)
            .and(Lanes::flag_lt(zero, self.hold_left.max(self.shift_left)).not());

        let fast = Lanes::flag_lt(up_speed, up_line).not().and(ready);
        let up = if fast.any() {
            let [full_0, full_1, _, _] = shared.powertrain.engine.curve_rows(up_speed);
            let power = (full_0 + full_1 * up_speed) * up_speed * shift.power_share;
            fast.and(Lanes::flag_lt(power, road_power * shift.power_reserve).not())
        } else {
            zero
        };
        let over = Lanes::flag_lt(Lanes::all(shift.overspeed_radps), speed)
            .and(Lanes::flag_lt(zero, self.gear_speed_up));
        let has_down = Lanes::flag_lt(self.gear_speed_down, Lanes::all(super::road_row::FAR));
        // a truck that rolls to a stop with an open clutch shifts when it is driven again, not before
        let pressed = Lanes::flag_lt(zero, accelerator);
        let low =
            Lanes::flag_lt(speed, down_line).and(closed.or(self.gear_launches.not().and(pressed)));
        let kick = Lanes::flag_lt(zero, self.kick_left)
            .not()
            .and(Lanes::flag_lt(speed, Lanes::all(shift.kickdown_speed_radps)))
            .and(Lanes::flag_lt(
                self.speed * self.gear_speed_down,
                Lanes::all(shift.overspeed_radps),
            ));
        let down = has_down.and(slowing).and(low.or(kick));
        up.or(ready.and(over.or(down)))
    }

    /// Above zero where a lane needs a look.
    #[inline(always)]
    fn alarm(&self, wants_shift: Lanes<W>, shared: &Shared) -> Lanes<W> {
        let simulation = shared.simulation;
        let ended = Lanes::flag_lt(Lanes::ZERO, self.left).not();
        let to_line = self.left + self.row[RoadRow::TO_STOP];
        let reach = Lanes::select_lt(
            self.speed,
            Lanes::all(simulation.creep_speed_mps),
            Lanes::all(simulation.creep_distance_m),
            Lanes::all(simulation.capture_distance_m),
        );
        let captured = Lanes::flag_lt(reach, to_line).not();
        let due = Lanes::flag_lt(Lanes::ZERO, self.steps_left).not();
        ended.or(captured).or(due).or(wants_shift)
    }
}
