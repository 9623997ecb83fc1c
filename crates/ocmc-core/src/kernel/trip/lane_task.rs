//! The task of one lane: its scenario, its road, its gear, and how the events of the lane are
//! handled outside of the hot loop: stops, shifts, checks of progress and the end of the mission.

use super::charging_site::{cuts_m, sites};
use super::charging_stops::ChargingStops;
use super::marks::{Marking, Marks};
use super::parts::{Parts, kinds_of_plan, mark_m};
use super::rest_stops::{RestStops, halts_m};
use super::stop_ahead::StopAhead;
use crate::breakdown::Axis;
use crate::energy::ledger::Ledger;
use crate::kernel::step::road_row::{RoadRow, RoadRows};
use crate::study::{Scenario, Study};
use crate::tactical::{SpeedProfile, plan_braking, plan_cut};

/// Counters of a trip.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Progress {
    pub gear: usize,
    pub standstill_s: f64,
    /// Elapsed part of a standstill, in s: work of the body, then charging.
    pub stood_s: f64,
    pub n_stops: u32,
    pub n_gear_shifts: u32,
    /// Payload behind the last stop, in kg; none where it is that of the departure.
    pub payload_kg: Option<f64>,
    /// Sum of its payloads times their ways, in kg m, up to a way, in m.
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
    pub(crate) progress: Progress,
    /// Rows of lines that have been served, as they were.
    pub(super) served: Vec<(usize, RoadRow)>,
    pub(super) initial_energy_j: f64,
    /// Rests, where the study has a law on them.
    pub(super) rests: Option<RestStops>,
    /// Amounts that road types and event kinds have taken.
    pub(super) parts: Parts,
    /// Charging, where the study has a policy.
    pub(super) charging: Option<Box<ChargingStops>>,
    /// Stops that its driver has decided on, on his way.
    pub(super) stops_ahead: Vec<StopAhead>,
    /// Where its driver decides, or the powertrain's temperature is looked at.
    pub(super) marks: Marks,
    /// Additions of the last event to the ledger, in one addition each: a trace has to be able to
    /// repeat it.
    pub(crate) added_by_event: Ledger<f64>,
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

    /// Plans a scenario, in the buffers of a used task where there is one. The profile is needed
    /// for the planning only: a scheduler lends the same one to all its tasks, so that it stays in
    /// the CPU's cache.
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

    /// Scenario that is driven.
    pub(crate) fn scenario(&self) -> &Scenario {
        &self.scenario
    }
}
