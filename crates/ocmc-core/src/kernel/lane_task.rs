//! The task of one lane: its scenario, its road, its gear, and how the events of the lane are handled outside of the hot
//! loop: stops, shifts, checks of progress and the end of the mission.

use super::pedal_event::InitialMotion;
use super::powertrain::Powertrain;
use super::record::{Outcome, Record};
use super::road_row::{RoadRow, RoadRows, UNBOUNDED};
use super::state::{KernelParameters, State, Total};
use super::step::FAST_STEP;
use crate::powertrain::gearbox::ShiftInputs;
use crate::study::{Scenario, Study};
use crate::tactical::{SpeedProfile, plan};
use crate::vehicle::resistance::GRAVITY_MPS2;
use fearless_simd::Simd;
use std::mem::swap;

/// Steps, as they are counted, for each whole step's time that cuts can make of it before a cycle is given up.
const MOST_CUTS: f64 = 10.0;

/// The cycle that one lane drives.
#[derive(Clone, Debug)]
pub struct LaneTask {
    scenario: Scenario,
    /// Twice the deceleration and the acceleration of the plan, in m/s².
    twice_changes: [f64; 2],
    road: RoadRows,
    gear: usize,
    /// Rows of lines that have been served, as they were.
    served: Vec<(usize, RoadRow)>,
    standstill_s: f64,
    n_stops: u32,
    n_gear_shifts: u32,
    /// Time and position of the last check of progress.
    checked_at_s: f64,
    checked_at_m: f64,
    /// Steps counted at the checks so far: a cycle whose steps become ever shorter has to end, too.
    counted: f64,
    /// Steps until the next check.
    until_check: f64,
    initial_energy_j: f64,
    /// What the last event added to the totals, in one addition each: a trace has to be able to repeat it.
    added_by_event: [f64; Total::COUNT],
}

/// An event of one lane: what the step knows that its handling needs.
#[derive(Clone, Copy, Debug)]
pub struct LaneEvent {
    /// Accelerator pedal.
    pub accelerator: f64,
    /// Whether the strategy may want another gear.
    pub wants_shift: bool,
    /// Whether the truck slows.
    pub slowing: bool,
    /// Whether the clutch is closed.
    pub closed: bool,
    /// Steady power that the road asks for, in W.
    pub road_power_w: f64,
}

impl LaneTask {
    /// Plans a scenario.
    pub fn new(study: &Study, scenario: Scenario) -> Self {
        let mut task = Self {
            scenario,
            twice_changes: [0.0; 2],
            road: RoadRows::default(),
            gear: 0,
            served: Vec::new(),
            standstill_s: 0.0,
            n_stops: 0,
            n_gear_shifts: 0,
            checked_at_s: 0.0,
            checked_at_m: 0.0,
            counted: 0.0,
            until_check: 0.0,
            initial_energy_j: 0.0,
            added_by_event: [0.0; Total::COUNT],
        };
        task.plan(study, &mut SpeedProfile::default());
        task
    }

    /// Takes the next cycle; the buffers of the last one are reused. The profile is needed for the planning only: a scheduler lends
    /// the same one to all its tasks, so that it stays in the CPU's cache.
    pub fn reuse(&mut self, study: &Study, seed: u64, cycle_id: u64, profile: &mut SpeedProfile) {
        study.resample(seed, cycle_id, &mut self.scenario);
        self.plan(study, profile);
    }

    fn plan(&mut self, study: &Study, profile: &mut SpeedProfile) {
        plan(study, &self.scenario, profile);
        self.road.fill(study, &self.scenario, profile);
        self.twice_changes = [profile.twice_deceleration, profile.twice_acceleration];
    }

    /// The scenario.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Gear, from 0.
    pub fn gear(&self) -> usize {
        self.gear
    }

    /// What the last event added to the totals.
    pub fn added_by_event(&self) -> &[f64; Total::COUNT] {
        &self.added_by_event
    }

    fn add(&mut self, total: Total, amount: f64) {
        self.added_by_event[total as usize] += amount;
    }

    /// Time at stops so far, in s.
    pub fn standstill_s(&self) -> f64 {
        self.standstill_s
    }

    /// Loads the truck into a lane, standing at the start of its road.
    pub fn enter<S: Simd, T: Powertrain>(
        &mut self,
        state: &mut State<S>,
        lane: usize,
        parameters: &KernelParameters<T>,
    ) {
        let (driver, vehicle) = (&self.scenario.driver, &self.scenario.vehicle);
        state.mass[lane] = vehicle.mass_kg;
        state.drag_area[lane] = vehicle.drag_area_m2;
        let climate_w = parameters.powertrain.climate_w(self.road.air_temperature_k);
        state.auxiliary_power[lane] = vehicle.auxiliary_power_w + climate_w;
        parameters.powertrain.enter(state, lane, vehicle);
        let (gains, pid) = (&driver.pedals, &parameters.pedals.pid);
        state.proportional[lane] = gains.proportional;
        state.integral_gain[lane] = gains.integral;
        state.derivative_over_filter[lane] = gains.derivative / pid.derivative_filter_s;
        // T_t = r K_P / K_I, so that K_I (1 / (K_I T_t)) = K_I / (r K_P) for J; 0 without an integral part
        state.tracking[lane] = gains.integral / (pid.tracking_ratio * gains.proportional);
        state.brake_step[lane] = 1.0 / (parameters.brake_mps2 * gains.proportional);
        state.band_output[lane] = gains.proportional * parameters.pedals.overspeed_band_mps;
        state.threshold[lane] = gains.threshold_mps.unwrap_or(-UNBOUNDED);
        state.lowest_held[lane] = if gains.holds_brake { -UNBOUNDED } else { 0.0 };
        let [twice_deceleration, twice_acceleration] = self.twice_changes;
        state.twice_deceleration[lane] = twice_deceleration;
        state.twice_acceleration[lane] = twice_acceleration;
        for total in &mut state.totals {
            total[lane] = 0.0;
        }
        state.engine_speed[lane] = parameters.idle_radps;
        self.standstill_s = 0.0;
        self.n_stops = 0;
        self.n_gear_shifts = 0;
        self.checked_at_s = 0.0;
        self.checked_at_m = 0.0;
        self.counted = 0.0;
        swap(&mut state.roads[lane], &mut self.road.rows);
        state.at[lane] = 0;
        state.left[lane] = state.row(lane).0[RoadRow::LENGTH];
        self.start(state, lane, parameters);
        self.initial_energy_j = kinetic_energy_j(state, lane, parameters);
    }

    /// Prepares a truck at rest to start: gear by the slope, the controller reset.
    fn start<S: Simd, T: Powertrain>(
        &mut self,
        state: &mut State<S>,
        lane: usize,
        parameters: &KernelParameters<T>,
    ) {
        let shift = &parameters.vehicle.shift;
        let steep = slope(state, lane) > shift.steep_slope;
        let gear = if steep { shift.steep_start_gear } else { shift.start_gear };
        self.gear = gear as usize - 1;
        state.speed[lane] = 0.0;
        state.set_gear(lane, self.gear, parameters);
        for column in
            [&mut state.torque, &mut state.integral, &mut state.filtered, &mut state.holding]
        {
            column[lane] = 0.0;
        }
        state.shift_left[lane] = 0.0;
        state.hold_left[lane] = 0.0;
        state.kick_left[lane] = shift.kickdown_s;
        self.schedule_check(state, lane, parameters);
        state.longest[lane] = parameters.short_step_s;
    }

    /// Puts the truck that has just entered onto its road as it rolls, instead of standing.
    pub(super) fn roll<S: Simd, T: Powertrain>(
        &mut self,
        state: &mut State<S>,
        lane: usize,
        rolling: &InitialMotion,
        parameters: &KernelParameters<T>,
    ) {
        self.gear = rolling.gear;
        state.set_gear(lane, self.gear, parameters);
        let engine_speed = rolling.speed_mps * state.gear_speed[lane];
        state.speed[lane] = rolling.speed_mps;
        state.engine_speed[lane] = engine_speed.max(parameters.idle_radps);
        state.torque[lane] =
            parameters.powertrain.settled_torque_nm(engine_speed, rolling.accelerator);
        state.integral[lane] = rolling.integral;
        state.filtered[lane] = rolling.filtered_mps;
        state.held[lane] = rolling.held;
        state.holding[lane] = if rolling.holds { 1.0 } else { 0.0 };
        state.left[lane] -= rolling.offset_m;
        self.initial_energy_j = kinetic_energy_j(state, lane, parameters);
    }

    /// Takes the road back from a lane whose cycle has ended, as it was before.
    pub fn leave<S: Simd>(&mut self, state: &mut State<S>, lane: usize) {
        // a row between two lines was taken off twice: what it was at first comes last
        for (at, row) in self.served.drain(..).rev() {
            state.roads[lane][at] = row;
        }
        swap(&mut state.roads[lane], &mut self.road.rows);
    }

    /// Handles the event of a lane; returns the outcome where the cycle has ended.
    #[cold]
    pub fn handle_event<S: Simd, T: Powertrain>(
        &mut self,
        state: &mut State<S>,
        lane: usize,
        event: LaneEvent,
        parameters: &KernelParameters<T>,
    ) -> Option<Outcome> {
        self.added_by_event = [0.0; Total::COUNT];
        if is_captured(state, lane, parameters) {
            self.stop(state, lane, parameters);
            let ends = stop_row(state, lane) + 1 == state.roads[lane].len();
            if !ends {
                self.dwell(state, lane, parameters);
            }
            for (total, amount) in state.totals.iter_mut().zip(self.added_by_event) {
                total[lane] += amount;
            }
            if ends {
                return Some(Outcome::Completed);
            }
        } else if event.wants_shift {
            self.shift(state, lane, event, parameters);
        }
        if parameters.powertrain.is_stranded(state, lane) {
            return Some(Outcome::Depleted);
        }
        if state.steps_left[lane] <= 0.0 { self.check(state, lane, parameters) } else { None }
    }

    /// The truck comes to rest: its kinetic energy goes into the service brakes, the engine returns to idle.
    fn stop<S: Simd, T: Powertrain>(
        &mut self,
        state: &mut State<S>,
        lane: usize,
        parameters: &KernelParameters<T>,
    ) {
        let speed = state.speed[lane];
        let inertia = parameters.engine_inertia_kgm2;
        let engine_speed = state.engine_speed[lane];
        let mut braked = 0.5 * (state.mass[lane] + parameters.wheel_mass_kg) * speed * speed;
        let idle = parameters.idle_radps;
        // a closed clutch brakes the engine with the wheels; it is restarted to idle
        let closed = engine_speed == speed * state.gear_speed[lane];
        let left_over = if closed {
            braked += 0.5 * inertia * engine_speed * engine_speed;
            0.0
        } else {
            engine_speed
        };
        self.add(Total::ServiceBrake, braked);
        self.add(Total::Shift, 0.5 * inertia * (left_over * left_over - idle * idle));
        state.speed[lane] = 0.0;
        state.engine_speed[lane] = idle;
    }

    /// Stands for the drawn time with the engine idling, then prepares to start.
    fn dwell<S: Simd, T: Powertrain>(
        &mut self,
        state: &mut State<S>,
        lane: usize,
        parameters: &KernelParameters<T>,
    ) {
        let dwell_s = state.roads[lane][stop_row(state, lane)].0[RoadRow::DWELL];
        let mut add = |total, amount| self.add(total, amount);
        parameters.powertrain.stand(state, lane, dwell_s, &mut add);
        self.standstill_s += dwell_s;
        self.n_stops += 1;
        self.leave_line(state, lane);
        self.start(state, lane, parameters);
        self.checked_at_s = state.total(lane, Total::Time);
        self.checked_at_m = state.total(lane, Total::Distance);
    }

    /// Takes a line that has been served off the road: up to it nothing but the launch speed holds.
    fn leave_line<S: Simd>(&mut self, state: &mut State<S>, lane: usize) {
        let (here, line) = (state.at[lane], stop_row(state, lane));
        for (k, row) in state.roads[lane][here..=line].iter_mut().enumerate() {
            self.served.push((here + k, *row));
            row.0[RoadRow::BACKWARD] = UNBOUNDED;
            row.0[RoadRow::FORWARD] = -UNBOUNDED;
            row.0[RoadRow::TO_STOP] = UNBOUNDED;
            row.0[RoadRow::DWELL] = -1.0;
        }
    }

    fn shift<S: Simd, T: Powertrain>(
        &mut self,
        state: &mut State<S>,
        lane: usize,
        event: LaneEvent,
        parameters: &KernelParameters<T>,
    ) {
        let shift = &parameters.vehicle.shift;
        let inputs = ShiftInputs {
            gear: self.gear,
            speed_mps: state.speed[lane],
            pedal: event.accelerator,
            slowing: event.slowing,
            kickdown: state.kick_left[lane] <= 0.0,
            closed: event.closed,
            road_power_w: event.road_power_w,
        };
        let full_load_nm = |w| parameters.powertrain.full_load_nm(w);
        let gear = shift.wanted_gear(&inputs, &parameters.vehicle.gears, full_load_nm);
        if gear != self.gear {
            self.gear = gear;
            self.n_gear_shifts += 1;
            state.set_gear(lane, gear, parameters);
            state.shift_left[lane] = shift.duration_s;
            state.hold_left[lane] = shift.interval_s;
            // torque comes back after the shift: only then a pressed pedal tells that it is not enough
            state.kick_left[lane] = shift.duration_s + shift.kickdown_s;
            state.longest[lane] = parameters.short_step_s;
        }
    }

    /// Checks whether the truck makes progress and whether its time is over.
    fn check<S: Simd, T: Powertrain>(
        &mut self,
        state: &mut State<S>,
        lane: usize,
        parameters: &KernelParameters<T>,
    ) -> Option<Outcome> {
        let simulation = parameters.simulation;
        let (time, way) = (state.total(lane, Total::Time), state.total(lane, Total::Distance));
        self.counted += self.until_check;
        let most = MOST_CUTS * simulation.longest_duration_s / simulation.step_s;
        if time > simulation.longest_duration_s || self.counted > most {
            return Some(Outcome::TimedOut);
        }
        let passed = time - self.checked_at_s;
        self.schedule_check(state, lane, parameters);
        // steps that were cut are shorter: wait until the whole time has passed
        if passed >= simulation.stall_time_s * (1.0 - 1e-9) {
            if way - self.checked_at_m < simulation.stall_distance_m {
                return Some(Outcome::Stalled);
            }
            self.checked_at_s = time;
            self.checked_at_m = way;
        }
        None
    }

    /// The next check is due when a truck that makes no progress has been standing long enough, and no later than the longest
    /// duration.
    fn schedule_check<S: Simd, T: Powertrain>(
        &mut self,
        state: &mut State<S>,
        lane: usize,
        parameters: &KernelParameters<T>,
    ) {
        let simulation = parameters.simulation;
        let left_s = (simulation.longest_duration_s - state.total(lane, Total::Time)).max(0.0);
        let steps = |time_s: f64| libm::ceil(time_s / simulation.step_s);
        let at_end = (steps(left_s) * FAST_STEP).max(FAST_STEP);
        self.until_check = steps(simulation.stall_time_s).min(at_end);
        state.steps_left[lane] = self.until_check;
    }

    /// The record of the cycle as it stands.
    pub fn record<S: Simd, T: Powertrain>(
        &self,
        study: &Study,
        state: &State<S>,
        lane: usize,
        outcome: Outcome,
        parameters: &KernelParameters<T>,
    ) -> Record {
        let total = |total| state.total(lane, total);
        let (cycle, driver, vehicle) =
            (&self.scenario.cycle, &self.scenario.driver, &self.scenario.vehicle);
        let distance_m = total(Total::Distance);
        let duration_s = total(Total::Time) + self.standstill_s;
        let road = &cycle.road;
        let share = |name: &str| {
            let wanted = study.road_types().iter().position(|n| n == name)?;
            let sections = road.sections.iter().filter(|s| s.road_type == wanted);
            // not `sum`: that of nothing is -0
            let length_m = sections.fold(0.0, |sum, s| sum + (s.end_m - s.start_m));
            Some(length_m / road.length_m)
        };
        let mut limit_sum = 0.0;
        for (k, sign) in road.signs.iter().enumerate() {
            let end_m = road.signs.get(k + 1).map_or(road.length_m, |next| next.start_m);
            limit_sum += sign.speed_mps * (end_m - sign.start_m);
        }
        let is_pid = driver.pedals.threshold_mps.is_none();
        let plain = Record {
            cycle_id: self.scenario.cycle_id,
            outcome,
            distance_m,
            duration_s,
            standstill_s: self.standstill_s,
            simulated_s: total(Total::Time),
            mean_speed_mps: if duration_s > 0.0 { distance_m / duration_s } else { 0.0 },
            n_stops: self.n_stops,
            n_gear_shifts: self.n_gear_shifts,
            wheel_energy_j: total(Total::Wheel),
            auxiliary_energy_j: total(Total::Auxiliary),
            climb_m: self.road.climb_m,
            payload_kg: cycle.mission.payload_kg,
            air_temperature_k: self.road.air_temperature_k,
            head_wind_mps: self.road.head_wind_mps,
            driver_curve_speed_mps: Some(driver.curve_speed.reference_speed_mps),
            driver_curve_exponent: Some(driver.curve_speed.exponent),
            driver_effect: Some(driver.curve_speed.driver_effect),
            driver_deceleration_mps2: Some(driver.speed_change.deceleration_mps2),
            driver_acceleration_mps2: Some(driver.speed_change.acceleration_mps2),
            driver_compliance: Some(driver.speed_limit.compliance),
            driver_kp: Some(driver.pedals.proportional),
            driver_ki: is_pid.then_some(driver.pedals.integral),
            driver_kd: is_pid.then_some(driver.pedals.derivative),
            driver_switch_threshold_mps: driver.pedals.threshold_mps,
            driver_gain_redraws: Some(driver.pedals.redraws),
            transmission_loss_j: total(Total::Transmission),
            shift_loss_j: Some(total(Total::Shift)),
            drag_energy_j: total(Total::Drag),
            rolling_energy_j: total(Total::InitialMotion),
            service_brake_energy_j: total(Total::ServiceBrake),
            kinetic_change_j: kinetic_energy_j(state, lane, parameters) - self.initial_energy_j,
            potential_change_j: total(Total::Grade),
            moving_s: duration_s - self.standstill_s,
            departure_s_of_year: cycle.mission.day_of_year * 86_400.0 + cycle.mission.departure_s,
            urban_share: share("urban"),
            rural_share: share("rural"),
            motorway_share: share("motorway"),
            mean_limit_mps: Some(limit_sum / road.length_m),
            n_curves: Some(road.curves.len() as u32),
            drag_area_m2: vehicle.drag_area_m2,
            rolling_coefficient: vehicle.rolling_coefficient,
            outside_map_s: Some(total(Total::OutsideMap)),
            ..Record::default()
        };
        let wheel_kwh_per_km = plain.per_distance(plain.wheel_energy_j) / 3600.0;
        parameters.powertrain.record(state, lane, Record { wheel_kwh_per_km, ..plain })
    }
}

/// Translational energy, and rotational energy of wheels and engine, in J.
fn kinetic_energy_j<S: Simd, T: Powertrain>(
    state: &State<S>,
    lane: usize,
    parameters: &KernelParameters<T>,
) -> f64 {
    let (speed, engine) = (state.speed[lane], state.engine_speed[lane]);
    0.5 * (state.mass[lane] + parameters.wheel_mass_kg) * speed * speed
        + 0.5 * parameters.engine_inertia_kgm2 * engine * engine
}

fn is_captured<S: Simd, T: Powertrain>(
    state: &State<S>,
    lane: usize,
    parameters: &KernelParameters<T>,
) -> bool {
    let simulation = parameters.simulation;
    let slow = state.speed[lane] < simulation.creep_speed_mps;
    let reach = if slow { simulation.creep_distance_m } else { simulation.capture_distance_m };
    state.left[lane] + state.row(lane).0[RoadRow::TO_STOP] <= reach
}

/// Slope of the road under the truck, as climb per metre.
pub(super) fn slope<S: Simd>(state: &State<S>, lane: usize) -> f64 {
    state.row(lane).0[RoadRow::GRADE] / GRAVITY_MPS2
}

/// The row at whose end the next stop line is.
fn stop_row<S: Simd>(state: &State<S>, lane: usize) -> usize {
    let predicted = state.roads[lane][state.at[lane]..].iter();
    state.at[lane] + predicted.take_while(|row| row.0[RoadRow::DWELL] < 0.0).count()
}
