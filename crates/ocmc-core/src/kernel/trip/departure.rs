//! The departure of a trip: its truck enters a lane, gets its load and the numbers of its driver,
//! and starts from rest, or rolls.

use super::lane_task::{LaneTask, Progress};
use crate::driver::pedal::Hold;
use crate::driver::speed_change::{Rise, SpeedChange};
use crate::kernel::step::road_row::RoadRow;
use crate::kernel::step::state::Lane;
use crate::lanes::UNBOUNDED;
use crate::powertrain::Powertrain;
use crate::vehicle::Vehicle;
use fearless_simd::Simd;
use std::mem::swap;

/// Error at which a driver who holds in balance begins to hold, as a share of the threshold
/// (judgement): a driver who began at the threshold would leave it at once.
const ENTRY_SHARE: f64 = 0.25;

/// How a truck rolls where an event begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialMotion {
    /// Way from the start of the scenario's road, in m; within its first segment.
    pub offset_m: f64,
    /// Speed, in m/s.
    pub speed_mps: f64,
    /// Gear, from 0.
    pub gear: usize,
    /// The shift into it; none where it is too long ago to matter.
    pub last_shift: Option<LastShift>,
    /// Accelerator pedal that the engine's torque has followed.
    pub accelerator: f64,
    /// Integral part J of the controller.
    pub integral: f64,
    /// Filtered speed of its derivative part, in m/s.
    pub filtered_mps: f64,
    /// Output that a switched driver holds.
    pub held: f64,
    /// Whether the switched driver is holding it.
    pub holds: bool,
    /// How late the driver sees the speed, in s: his reaction time.
    pub reaction_delay_s: f64,
    /// Acceleration before the start, in m/s²: what a driver sees late begins before the event.
    pub acceleration_mps2: f64,
}

/// The last shift of a gearbox that is between two of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastShift {
    /// Time since it began, in s.
    pub since_s: f64,
    /// Whether it was one to a higher gear.
    pub upwards: bool,
}

impl LaneTask {
    /// Loads the truck into a lane, standing at the start of its road.
    pub(crate) fn enter<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>) {
        let (driver, vehicle) = (&self.scenario.driver, &self.scenario.vehicle);
        Self::carry(lane, vehicle, &driver.speed_change);
        let constants = &mut lane.state.constants;
        constants.drag_area[lane.number] = vehicle.drag_area_m2;
        let climate_w = lane.parameters.powertrain.climate_w(self.road.air_temperature_k);
        let inputs = vehicle.powertrain_inputs(climate_w);
        let (own, air_k) = (&mut lane.state.powertrain, self.road.air_temperature_k);
        lane.parameters.powertrain.enter(own, lane.number, &inputs, air_k);
        let (gains, model) = (&driver.pedals, lane.parameters.pedals);
        let pid = &model.pid;
        constants.proportional[lane.number] = gains.proportional;
        constants.integral_gain[lane.number] = gains.integral;
        constants.derivative_over_filter[lane.number] = gains.derivative / pid.derivative_filter_s;
        // T_t = r K_P / K_I, so that K_I (1 / (K_I T_t)) = K_I / (r K_P) for J; 0 without an
        // integral part
        constants.tracking[lane.number] =
            gains.integral / (pid.tracking_ratio * gains.proportional);
        let feeds = model.feed_forward;
        let ramp_gain = gains.proportional.max(model.ramp_gain_minimum);
        let highest_gain = if feeds { ramp_gain } else { gains.proportional };
        constants.feeds[lane.number] = f64::from(u8::from(feeds));
        constants.ramp_gain[lane.number] = ramp_gain;
        constants.brake_step[lane.number] = 1.0 / (lane.parameters.brake_mps2 * highest_gain);
        constants.band_output[lane.number] = gains.proportional * model.overspeed_band_mps;
        let tolerance_mps = model.brake_tolerance_mps;
        constants.tolerance_output[lane.number] =
            if tolerance_mps > 0.0 { gains.proportional * tolerance_mps } else { -UNBOUNDED };
        let threshold_mps = gains.threshold_mps.unwrap_or(-UNBOUNDED);
        let balances = gains.threshold_mps.is_some() && gains.hold == Hold::Balance;
        constants.threshold[lane.number] = threshold_mps;
        let entry_mps = if balances { ENTRY_SHARE * threshold_mps } else { threshold_mps };
        constants.entry_threshold[lane.number] = entry_mps;
        constants.dead_zone[lane.number] = if balances { entry_mps } else { 0.0 };
        constants.balances[lane.number] = f64::from(u8::from(balances));
        constants.lowest_held[lane.number] =
            if gains.hold == Hold::Paper { -UNBOUNDED } else { 0.0 };
        let change = &driver.speed_change;
        constants.twice_deceleration[lane.number] = 2.0 * change.deceleration_mps2;
        let least_ceiling = match change.rise {
            Rise::Ramp => 0.0,
            Rise::Paper => UNBOUNDED,
        };
        constants.least_ceiling[lane.number] = least_ceiling;
        constants.peak_ratio[lane.number] = change.peak_ratio;
        let lead_s = if feeds { model.ramp_lead_s } else { 0.0 };
        constants.lead[lane.number] = 2.0 * change.deceleration_mps2 * lead_s;
        constants.before_ramp[lane.number] =
            2.0 * change.deceleration_mps2 * lane.parameters.vehicle.shift.before_ramp_s;
        lane.state.ledger.clear(lane.number);
        lane.state.motion.engine_speed[lane.number] = lane.parameters.idle_radps;
        self.progress = Progress::default();
        self.stops_ahead.clear();
        self.marks.begin();
        if let Some(rests) = &mut self.rests {
            rests.depart();
        }
        self.parts.depart(lane.parameters.road_types);
        if let Some(charging) = &mut self.charging {
            charging.depart();
        }
        swap(&mut lane.state.motion.roads[lane.number], &mut self.road.rows);
        lane.state.motion.at[lane.number] = 0;
        lane.state.motion.left[lane.number] = lane.state.row(lane.number).0[RoadRow::LENGTH];
        self.start(lane);
        self.initial_energy_j = lane.kinetic_energy_j();
        self.decide(lane, 0.0, 0);
    }

    /// A truck at rest gets its load, by which its driver accelerates.
    pub(super) fn carry<S: Simd, P: Powertrain>(
        lane: &mut Lane<S, P>,
        vehicle: &Vehicle,
        change: &SpeedChange,
    ) {
        let rated_power_w = lane.parameters.vehicle.rated_power_w;
        let rise = change.acceleration(rated_power_w, vehicle.mass_kg);
        let constants = &mut lane.state.constants;
        constants.mass[lane.number] = vehicle.mass_kg;
        constants.driven_mass[lane.number] = vehicle.driven_mass_kg;
        constants.per_brake_force[lane.number] =
            1.0 / (lane.parameters.brake_mps2 * vehicle.mass_kg);
        constants.rise_from_rest[lane.number] = rise.from_rest;
        constants.rise_per_mps[lane.number] = rise.per_mps;
    }

    /// Prepares a truck at rest to start: gear by the slope, the controller reset.
    pub(super) fn start<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>) {
        let shift = &lane.parameters.vehicle.shift;
        let steep = lane.state.slope(lane.number) > shift.steep_slope;
        let gear = if steep { shift.steep_start_gear } else { shift.start_gear };
        self.progress.gear = gear as usize - 1;
        lane.state.motion.speed[lane.number] = 0.0;
        lane.state.set_gear(lane.number, self.progress.gear, lane.parameters);
        lane.parameters.powertrain.start(&mut lane.state.powertrain, lane.number);
        let motion = &mut lane.state.motion;
        for column in [
            &mut motion.integral,
            &mut motion.filtered,
            &mut motion.holding,
            &mut motion.rolling,
            &mut motion.drag,
            &mut motion.shift_left,
            &mut motion.up_left,
            &mut motion.down_left,
        ] {
            column[lane.number] = 0.0;
        }
        motion.ceiling[lane.number] = lane.state.constants.least_ceiling[lane.number];
        lane.state.motion.kick_left[lane.number] = shift.kickdown_s;
        self.schedule_check(lane);
        lane.state.motion.longest[lane.number] = lane.parameters.short_step_s;
    }

    /// Puts the truck that has just entered onto its road as it rolls, instead of standing.
    pub(crate) fn roll<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        rolling: &InitialMotion,
    ) {
        self.progress.gear = rolling.gear;
        lane.state.set_gear(lane.number, self.progress.gear, lane.parameters);
        if let Some(LastShift { since_s, upwards }) = rolling.last_shift {
            let shift = &lane.parameters.vehicle.shift;
            let motion = &mut lane.state.motion;
            let [up_s, down_s] = shift.intervals_s(upwards);
            motion.up_left[lane.number] = (up_s - since_s).max(0.0);
            motion.down_left[lane.number] = (down_s - since_s).max(0.0);
        }
        let engine_speed = rolling.speed_mps * lane.state.gear.speed_ratio[lane.number];
        lane.state.motion.speed[lane.number] = rolling.speed_mps;
        lane.state.motion.engine_speed[lane.number] = engine_speed.max(lane.parameters.idle_radps);
        let (own, pedal) = (&mut lane.state.powertrain, rolling.accelerator);
        lane.parameters.powertrain.settle(own, lane.number, engine_speed, pedal);
        lane.state.motion.integral[lane.number] = rolling.integral;
        lane.state.motion.filtered[lane.number] = rolling.filtered_mps;
        let ceiling = &mut lane.state.motion.ceiling[lane.number];
        *ceiling = ceiling.max(rolling.speed_mps * rolling.speed_mps);
        lane.state.motion.held[lane.number] = rolling.held;
        lane.state.motion.holding[lane.number] = if rolling.holds { 1.0 } else { 0.0 };
        lane.state.motion.left[lane.number] -= rolling.offset_m;
        self.initial_energy_j = lane.kinetic_energy_j();
    }
}
