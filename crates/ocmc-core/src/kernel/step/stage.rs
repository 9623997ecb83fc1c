//! The two stages of a step: what driver, powertrain, air and road do at its start, and where that
//! would lead.

use super::control::{Control, DesiredSpeed, Stance, clamp_integral};
use super::road_row::{RoadRow, RoadRowLanes};
use super::state::{KernelParameters, State};
use crate::first_order_lag::first_order_lags;
use crate::lanes::{Bounded, Lanes, WIDTH, columns, scheduling_barrier};
use crate::powertrain::component::gearbox::GearLanes;
use crate::powertrain::{Coupling, Demand, Powertrain, TractiveEffort};
use crate::vehicle::resistance::{GRAVITY_MPS2, LEAST_TRACTION_FRICTION, drag_forces_n};
use fearless_simd::prelude::*;

/// The target of the driver at the step's start.
#[derive(Clone, Copy)]
pub(super) struct SpeedTarget<S: Simd> {
    pub row: RoadRowLanes<S>,
    pub desired: DesiredSpeed<S>,
    pub stance: Stance<S>,
}

/// Decision at the step's start.
#[derive(Clone, Copy)]
pub(super) struct Decision<S: Simd> {
    pub row: RoadRowLanes<S>,
    pub desired: DesiredSpeed<S>,
    pub stance: Stance<S>,
    pub control: Control<S>,
    pub coupling: Coupling<S>,
    /// Inverse of the moving mass, in 1/kg.
    pub inverse_mass: Lanes<S>,
    /// Drag area without cross wind, in m².
    pub drag_area: Lanes<S>,
    /// Forces of the road, in N, and their sum: the same over the step.
    pub rolling: Lanes<S>,
    pub grade: Lanes<S>,
    pub road: Lanes<S>,
}

/// The effort of a powertrain at one stage.
pub(super) type Effort<S, P> = TractiveEffort<S, <P as Powertrain>::Stage<S>>;

/// Torques and forces of one stage.
pub(super) struct Forces<S: Simd, P: Powertrain> {
    pub acceleration: Lanes<S>,
    pub drag: Lanes<S>,
    pub effort: Effort<S, P>,
}

/// The state at the end of a step that follows its first stage all the way.
pub(super) struct Predicted<S: Simd, P: Powertrain> {
    /// Time to the segment's end, in s.
    pub to_end: Lanes<S>,
    pub dt: Lanes<S>,
    pub speed: Lanes<S>,
    pub desired: DesiredSpeed<S>,
    pub powertrain: P::Predicted<S>,
    pub integral: Lanes<S>,
    pub filtered: Lanes<S>,
}

/// Acceleration that the least friction gives a truck that drives with all axles, in m/s².
const LEAST_TRACTION_MPS2: f64 = LEAST_TRACTION_FRICTION * GRAVITY_MPS2;

/// The slowest pace at which a step is cut for a segment's end, in m/s.
const SMALLEST_SPEED: f64 = 1e-9;

impl<S: Simd, P: Powertrain> State<S, P> {
    /// Advances to the next segment where one has ended; returns the rows under the trucks.
    #[inline(always)]
    pub(super) fn advance_segment(&mut self) -> RoadRowLanes<S> {
        let simd = self.motion.left.simd;
        let turns = self.motion.left.simd_le(0.0);
        let bits = turns.to_bitmask() as usize;
        for lane in 0..WIDTH {
            self.motion.at[lane] += bits >> lane & 1;
        }
        let rows: [_; WIDTH] = std::array::from_fn(
            #[inline(always)]
            |lane| self.row(lane).quads(),
        );
        let [a, b, c, d] = columns(
            simd,
            #[inline(always)]
            |lane| &rows[lane][0],
        );
        let [e, f, g, h] = columns(
            simd,
            #[inline(always)]
            |lane| &rows[lane][1],
        );
        let [i, j, k, l] = columns(
            simd,
            #[inline(always)]
            |lane| &rows[lane][2],
        );
        let row = [a, b, c, d, e, f, g, h, i, j, k, l];
        self.motion.left = turns.select(row[RoadRow::LENGTH], self.motion.left);
        row
    }

    /// The target of the driver at the step's start.
    #[inline(always)]
    pub(super) fn speed_target(
        &self,
        row: RoadRowLanes<S>,
        parameters: &KernelParameters<P>,
    ) -> SpeedTarget<S> {
        let desired = self.desired(&row, self.motion.left, self.motion.ceiling);
        let stance = self.stance(&row, &desired, parameters);
        scheduling_barrier(stance.held);
        SpeedTarget { row, desired, stance }
    }

    #[inline(always)]
    pub(super) fn control_at_start(
        &self,
        speed_target: &SpeedTarget<S>,
        parameters: &KernelParameters<P>,
    ) -> Control<S> {
        let SpeedTarget { row, desired, stance } = speed_target;
        let control = self.control(
            row,
            self.motion.speed,
            desired.speed,
            self.motion.integral,
            self.motion.filtered,
            stance.forecast.rise,
            stance,
            parameters,
        );
        scheduling_barrier(control.accelerator);
        control
    }

    /// Pedals, clutch and hold at the step's start.
    #[inline(always)]
    pub(super) fn decide(
        &mut self,
        speed_target: SpeedTarget<S>,
        control: Control<S>,
        parameters: &KernelParameters<P>,
    ) -> Decision<S> {
        let motion = &self.motion;
        let coupling = parameters.powertrain.couple(
            &mut self.powertrain,
            &self.gear,
            motion.speed,
            motion.shift_left.simd_gt(0.0),
            speed_target.stance.look_ahead.rolls,
            control.accelerator,
        );
        let constants = &self.constants;
        let (closed, open) = (constants.inverse_mass_closed, constants.inverse_mass_open);
        let inverse_mass = coupling.closed.select(closed, open);
        let SpeedTarget { row, desired, stance } = speed_target;
        let rolling = self.constants.mass * row[RoadRow::ROLLING];
        let grade = self.constants.mass * row[RoadRow::GRADE];
        let road = rolling + grade;
        let by_speed = parameters.vehicle.drag_by_speed.factors(self.motion.speed);
        let drag_area = self.constants.drag_area * by_speed;
        scheduling_barrier(coupling.start_speed);
        Decision {
            row,
            desired,
            stance,
            control,
            coupling,
            inverse_mass,
            drag_area,
            rolling,
            grade,
            road,
        }
    }

    #[inline(always)]
    pub(super) fn tractive_effort(
        &self,
        speed: Lanes<S>,
        shaft_speed: Lanes<S>,
        predicted: Option<&P::Predicted<S>>,
        control: &Control<S>,
        decision: &Decision<S>,
        parameters: &KernelParameters<P>,
    ) -> Effort<S, P> {
        let row = &decision.row;
        let relative = speed + row[RoadRow::HEAD_WIND];
        let cross = row[RoadRow::CROSS_WIND];
        let grip = self.constants.driven_mass * row[RoadRow::GRIP].at_least(LEAST_TRACTION_MPS2);
        let demand = Demand {
            speed,
            shaft_speed,
            accelerator: control.accelerator,
            brake: self.constants.mass
                * (control.braking * parameters.brake_mps2).at_most(row[RoadRow::GRIP]),
            traction: grip.at_most(decision.stance.forecast.most.at_least(0.0)),
            air: relative.at_least(1.0),
            cross,
        };
        let (state, gear, coupling) = (&self.powertrain, &self.gear, &decision.coupling);
        let effort =
            parameters.powertrain.tractive_effort(state, gear, coupling, &demand, predicted);
        scheduling_barrier(effort.wheel);
        effort
    }

    /// Forces at one stage.
    #[inline(always)]
    pub(super) fn net(
        speed: Lanes<S>,
        effort: Effort<S, P>,
        decision: &Decision<S>,
        parameters: &KernelParameters<P>,
    ) -> Forces<S, P> {
        let row = &decision.row;
        let relative = speed + row[RoadRow::HEAD_WIND];
        let cross = row[RoadRow::CROSS_WIND];
        let increment = parameters.vehicle.cross_wind.increment_m2(effort.wind_tangent);
        let half_density = row[RoadRow::HALF_DENSITY];
        let drag = drag_forces_n(half_density, relative, cross, decision.drag_area + increment);

        let net = effort.wheel - drag - decision.road - effort.brake;
        let acceleration = net * decision.inverse_mass;
        scheduling_barrier(acceleration);
        Forces { acceleration, drag, effort }
    }

    #[inline(always)]
    pub(super) fn first_effort(
        &self,
        decision: &Decision<S>,
        parameters: &KernelParameters<P>,
    ) -> Effort<S, P> {
        let (speed, shaft_speed) = (self.motion.speed, decision.coupling.start_speed);
        let control = &decision.control;
        self.tractive_effort(speed, shaft_speed, None, control, decision, parameters)
    }

    #[inline(always)]
    pub(super) fn second_effort(
        &self,
        decision: &Decision<S>,
        predicted: &Predicted<S, P>,
        control: &Control<S>,
        parameters: &KernelParameters<P>,
    ) -> Effort<S, P> {
        let shaft_speed = engine_speed_at(predicted.speed, &self.gear, &decision.coupling);
        let torque = Some(&predicted.powertrain);
        self.tractive_effort(predicted.speed, shaft_speed, torque, control, decision, parameters)
    }

    /// How far the step may go, and the state there.
    #[inline(always)]
    pub(super) fn predict(
        &self,
        decision: &Decision<S>,
        first: &Forces<S, P>,
        parameters: &KernelParameters<P>,
    ) -> Predicted<S, P> {
        let half = 0.5;
        let longest = self.motion.longest;
        let whole = self
            .motion
            .shift_left
            .simd_gt(0.0)
            .select(self.motion.shift_left.at_most(longest), longest);
        let up_left = self.motion.up_left;
        let whole = up_left.simd_gt(0.0).select(up_left.at_most(whole), whole);
        let down_left = self.motion.down_left;
        let whole = down_left.simd_gt(0.0).select(down_left.at_most(whole), whole);
        let pace = (self.motion.speed + first.acceleration * whole * half).at_least(SMALLEST_SPEED);
        let to_end = self.motion.left / pace;
        let dt = whole.at_most(to_end);

        let speed = (self.motion.speed + dt * first.acceleration).at_least(0.0);
        let left = (self.motion.left - dt * (self.motion.speed + speed) * half).at_least(0.0);
        let [engine, filter] = first_order_lags(dt, parameters.per_lag_s);
        let own = &first.effort.own;
        let powertrain = parameters.powertrain.predict(&self.powertrain, engine, own);
        let rates = &decision.control;
        let integral = clamp_integral(self.motion.integral + dt * rates.integral_rate, parameters);
        let filtered = self.motion.filtered
            + filter.response(self.motion.speed - self.motion.filtered, speed - self.motion.speed);
        let ceiling = self.ceiling_after(decision.desired.speed, dt);
        let desired = self.desired(&decision.row, left, ceiling);
        Predicted { to_end, dt, speed, desired, powertrain, integral, filtered }
    }

    /// The pedals there.
    #[inline(always)]
    pub(super) fn control_at_end(
        &self,
        decision: &Decision<S>,
        predicted: &Predicted<S, P>,
        parameters: &KernelParameters<P>,
    ) -> Control<S> {
        let Predicted { speed, desired, integral, filtered, .. } = *predicted;
        let (row, stance) = (&decision.row, &decision.stance);
        let rise = self.rising_pedal(row, speed, parameters);
        let control =
            self.control(row, speed, desired.speed, integral, filtered, rise, stance, parameters);
        scheduling_barrier(control.accelerator);
        control
    }
}

/// Speed of the engine or motor at a speed of the truck.
#[inline(always)]
pub(super) fn engine_speed_at<S: Simd>(
    speed: Lanes<S>,
    gear: &GearLanes<S>,
    coupling: &Coupling<S>,
) -> Lanes<S> {
    coupling.closed.select(speed * gear.speed_ratio, coupling.free_speed)
}
