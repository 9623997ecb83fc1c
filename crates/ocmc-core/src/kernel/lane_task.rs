//! The task of one lane: its scenario, its road, its gear, and how the events of the lane are
//! handled outside of the hot loop: stops, shifts, checks of progress and the end of the mission.

use super::charging_decision::{cuts_m, sites};
use super::charging_stops::ChargingStops;
use super::marks::{Marking, Marks};
use super::parts::{Parts, kinds_of_plan, mark_m};
use super::pedal_event::InitialMotion;
use super::rest_decision::halts_m;
use super::rest_stops::RestStops;
use super::road_row::{RoadRow, RoadRows};
use super::state::Lane;
use super::stop_ahead::StopAhead;
use crate::breakdown::Axis;
use crate::charging::ChargeCourse;
use crate::driver::pedal::Hold;
use crate::driver::speed_change::Rise;
use crate::energy_ledger::{Ledger, Mode, Term};
use crate::lanes::UNBOUNDED;
use crate::powertrain::{Plug, Powertrain};
use crate::record::{Outcome, Record};
use crate::study::{Scenario, Study};
use crate::tactical::{SpeedProfile, plan_braking, plan_cut};
use crate::vehicle::Vehicle;
use fearless_simd::Simd;
use std::mem::swap;

/// Error at which a driver who holds in balance begins to hold, as a share of the threshold
/// (judgement): a driver who began at the threshold would leave it at once.
const ENTRY_SHARE: f64 = 0.25;

/// Counters of a trip.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Progress {
    pub gear: usize,
    pub standstill_s: f64,
    pub n_stops: u32,
    pub n_gear_shifts: u32,
    /// What the truck carries behind the last stop, in kg; none where it is the payload of its
    /// departure.
    pub payload_kg: Option<f64>,
    /// What its payloads were multiplied by their ways, in kg m, up to a way, in m.
    pub carried_kgm: f64,
    pub carried_to_m: f64,
    /// Work of the body at stops, in J.
    pub power_take_off_j: f64,
    /// Time and position of the last check of progress.
    pub checked_at_s: f64,
    pub checked_at_m: f64,
    /// Steps counted at the checks so far: a cycle whose steps become ever shorter has to end, too.
    pub counted: f64,
    /// Steps until the next check.
    pub until_check: f64,
}

/// The cycle that one lane drives.
#[derive(Clone, Debug)]
pub struct LaneTask {
    pub(super) scenario: Scenario,
    pub(super) road: RoadRows,
    pub(super) progress: Progress,
    /// Rows of lines that have been served, as they were.
    pub(super) served: Vec<(usize, RoadRow)>,
    initial_energy_j: f64,
    /// Rests, where the study has a law on them.
    pub(super) rests: Option<RestStops>,
    /// What road types and event kinds have taken.
    pub(super) parts: Parts,
    /// Charging, where the study has a policy.
    pub(super) charging: Option<Box<ChargingStops>>,
    /// Stops that its driver has decided on, on his way.
    pub(super) stops_ahead: Vec<StopAhead>,
    /// Where its driver decides, or the powertrain's temperature is looked at.
    pub(super) marks: Marks,
    /// What the last event added to the ledger, in one addition each: a trace has to be able to
    /// repeat it.
    pub(super) added_by_event: Ledger<f64>,
}

impl LaneTask {
    /// Plans a scenario.
    pub fn new(study: &Study, scenario: Scenario) -> Self {
        let mut task = Self {
            rests: RestStops::new(study, &scenario),
            charging: ChargingStops::new(study),
            scenario,
            road: RoadRows::default(),
            progress: Progress::default(),
            served: Vec::new(),
            initial_energy_j: 0.0,
            parts: Parts::default(),
            stops_ahead: Vec::new(),
            marks: Marks::default(),
            added_by_event: Ledger::EMPTY,
        };
        task.plan(study, &mut SpeedProfile::default());
        task
    }

    /// Plans a scenario, in the buffers of a used task where there is one. The profile is needed for
    /// the planning only: a scheduler lends the same one to all its tasks, so that it stays in the
    /// CPU's cache.
    pub fn of(
        study: &Study,
        scenario: Scenario,
        used: Option<Self>,
        profile: &mut SpeedProfile,
    ) -> Self {
        let Some(mut task) = used else { return Self::new(study, scenario) };
        task.scenario = scenario;
        task.prepare(study, profile);
        task
    }

    /// Takes the next cycle; the buffers of the last one are reused, those of its road as well.
    pub fn reuse(&mut self, study: &Study, seed: u64, cycle_id: u64, profile: &mut SpeedProfile) {
        study.resample(seed, cycle_id, &mut self.scenario);
        self.prepare(study, profile);
    }

    fn prepare(&mut self, study: &Study, profile: &mut SpeedProfile) {
        self.rests = RestStops::new(study, &self.scenario);
        self.charging = ChargingStops::new(study);
        self.plan(study, profile);
    }

    fn plan(&mut self, study: &Study, profile: &mut SpeedProfile) {
        let scenario = &self.scenario;
        let mut places_m = Vec::new();
        if self.charging.is_some() {
            places_m.extend(cuts_m(study, scenario).filter(|at_m| *at_m > 0.0));
        }
        if self.rests.is_some() {
            places_m.extend(halts_m(&scenario.cycle.road));
        }
        places_m.sort_unstable_by(f64::total_cmp);
        if study.model().simulation.columns_by.contains(&Axis::EventKind) {
            plan_cut(study, scenario, &places_m, profile);
        } else {
            plan_braking(study, scenario, &places_m, profile);
        }
        self.road.fill(study, scenario, profile);
        self.lay_parts(study, profile);
        let mut decides_m = Vec::new();
        if let (Some(charging), Some(policy)) = (&mut self.charging, &study.model().charging) {
            let stop_rows = self.road.stop_rows_and_events();
            charging.sites = sites(study, policy, &self.scenario, profile, &stop_rows);
            decides_m.extend(charging.sites.iter().map(|site| site.decided_at_m));
        }
        let mark_m = mark_m(&study.model().simulation);
        let looks = study.vehicle().powertrain.has_temperature();
        let marking = Marking { mark_m, decides_m, looks };
        let length_m = self.scenario.cycle.road.length_m;
        self.marks.lay(&marking, length_m, profile, &mut self.road.rows);
    }

    fn lay_parts(&mut self, study: &Study, profile: &SpeedProfile) {
        let simulation = &study.model().simulation;
        if study.breakdown().is_none() {
            return self.parts.clear();
        }
        let kinds = if simulation.columns_by.contains(&Axis::EventKind) {
            kinds_of_plan(profile, &self.scenario.cycle.road, &self.road.stop_rows())
        } else {
            Vec::new()
        };
        self.parts.lay(simulation, &self.road.road_types, &kinds, &mut self.road.rows);
    }

    /// What is driven.
    pub(super) fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Looks at the temperature of the powertrain at a place.
    pub(super) fn look_at_temperature<S: Simd, P: Powertrain>(
        &self,
        lane: &mut Lane<S, P>,
        position_m: f64,
    ) {
        let (powertrain, number) = (lane.parameters.powertrain, lane.number);
        let ledger = lane.state.ledger.lane(number);
        let to_m = position_m + powertrain.preconditions_from_m();
        let charging = self.charging.as_ref();
        let preconditions = charging.is_some_and(|stops| stops.are_within(position_m, to_m));
        powertrain.look_at_temperature(&mut lane.state.powertrain, number, &ledger, preconditions);
    }

    /// Where the truck is, in m.
    pub(super) fn position_m<S: Simd, P: Powertrain>(lane: &Lane<S, P>) -> f64 {
        let (motion, number) = (&lane.state.motion, lane.number);
        let passed = &motion.roads[number][..=motion.at[number]];
        let end_m: f64 = passed.iter().map(|row| row.0[RoadRow::LENGTH]).sum();
        end_m - motion.left[number]
    }

    /// Loads the truck into a lane, standing at the start of its road.
    pub(super) fn enter<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>) {
        let (driver, vehicle) = (&self.scenario.driver, &self.scenario.vehicle);
        Self::carry(lane, vehicle);
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
        constants.peak_acceleration[lane.number] = change.peak_acceleration_mps2;
        let (rise, least_ceiling) = match change.rise {
            Rise::Ramp => (change.acceleration_mps2, 0.0),
            Rise::Paper => (0.0, UNBOUNDED),
        };
        constants.rise[lane.number] = rise;
        constants.least_ceiling[lane.number] = least_ceiling;
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

    /// A truck at rest gets its load.
    pub(super) fn carry<S: Simd, P: Powertrain>(lane: &mut Lane<S, P>, vehicle: &Vehicle) {
        let constants = &mut lane.state.constants;
        constants.mass[lane.number] = vehicle.mass_kg;
        constants.driven_mass[lane.number] = vehicle.driven_mass_kg;
        constants.per_brake_force[lane.number] =
            1.0 / (lane.parameters.brake_mps2 * vehicle.mass_kg);
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
    pub(super) fn roll<S: Simd, P: Powertrain>(
        &mut self,
        lane: &mut Lane<S, P>,
        rolling: &InitialMotion,
    ) {
        self.progress.gear = rolling.gear;
        lane.state.set_gear(lane.number, self.progress.gear, lane.parameters);
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

    /// Takes the road back from a lane whose cycle has ended, as it was before.
    pub(super) fn leave<S: Simd, P: Powertrain>(&mut self, lane: &mut Lane<S, P>) {
        // a row between two lines was taken off twice: what it was at first comes last
        for (at, row) in self.served.drain(..).rev() {
            lane.state.motion.roads[lane.number][at] = row;
        }
        swap(&mut lane.state.motion.roads[lane.number], &mut self.road.rows);
    }

    /// The mean payload along the way so far.
    fn mean_payload_kg(&self, way_m: f64) -> f64 {
        let Progress { payload_kg, carried_kgm, carried_to_m, .. } = self.progress;
        match payload_kg {
            Some(payload_kg) if way_m > 0.0 => {
                (carried_kgm + payload_kg * (way_m - carried_to_m)) / way_m
            }
            _ => self.scenario.cycle.mission.payload_kg,
        }
    }

    /// The record of the cycle as it stands.
    pub(super) fn record<S: Simd, P: Powertrain>(
        &self,
        study: &Study,
        lane: &Lane<S, P>,
        outcome: Outcome,
    ) -> Record {
        let ledger = lane.state.ledger.lane(lane.number);
        let (cycle, driver, vehicle) =
            (&self.scenario.cycle, &self.scenario.driver, &self.scenario.vehicle);
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
        let known = Record {
            cycle_id: self.scenario.cycle_id,
            outcome,
            truck_id: Some(self.scenario.trip.truck_id),
            driver_id: Some(self.scenario.trip.driver_id),
            trip: Some(self.scenario.trip.trip),
            duration_s: ledger[Term::Time] + self.progress.standstill_s,
            standstill_s: self.progress.standstill_s,
            n_stops: self.progress.n_stops,
            n_gear_shifts: self.progress.n_gear_shifts,
            climb_m: self.road.climb_m,
            payload_kg: cycle.mission.payload_kg,
            mean_payload_kg: Some(self.mean_payload_kg(ledger[Term::Distance])),
            power_take_off_energy_j: Some(self.progress.power_take_off_j),
            payload_cut_kg: Some(self.scenario.payload_cut_kg),
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
            kinetic_change_j: lane.kinetic_energy_j() - self.initial_energy_j,
            departure_s_of_year: cycle.mission.day_of_year * 86_400.0 + cycle.mission.departure_s,
            urban_share: share("urban"),
            rural_share: share("rural"),
            motorway_share: share("motorway"),
            mean_limit_mps: Some(limit_sum / road.length_m),
            n_curves: Some(road.curves.len() as u32),
            drag_area_m2: vehicle.drag_area_m2,
            rolling_coefficient: vehicle.rolling_coefficient,
            departure_charge: vehicle.initial_charge,
            rest_s: self.rests.as_ref().map(|rests| rests.added_s),
            n_rests: self.rests.as_ref().map(|rests| rests.taken),
            breakdown: self.parts.breakdown(study, lane, self.progress.standstill_s),
            ..Record::default()
        };
        let mut record = Record::from_ledger(known, &ledger, Mode::Driven, P::TERMS);
        lane.parameters.powertrain.record(
            &lane.state.powertrain,
            lane.number,
            &ledger,
            &mut record,
        );
        if let (Some(stops), Some(policy)) = (&self.charging, lane.parameters.charging) {
            let powertrain = lane.parameters.powertrain;
            let charged_by = |plug: &Plug, charge, course: &mut ChargeCourse| {
                let charge = powertrain.charged_by(plug, charge, course)?;
                Some((charge, powertrain.rise(charge.gained_j)))
            };
            stops.fill(policy, &self.scenario, charged_by, &mut record);
        }
        if let (Some(rests), Some(_)) = (&self.rests, &self.scenario.handover) {
            record.clock_at_end = Some(rests.clock_at_end(ledger[Term::Time]));
        }
        study.emission_factors().fill(&mut record);
        record
    }
}
