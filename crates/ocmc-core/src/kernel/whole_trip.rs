//! The whole trips of cycles that a battery cut short: driven again from their start, with a battery
//! that never empties.

use super::lane_task::LaneTask;
use super::scheduler::{Deliver, Driving, LaneScheduler, StopFlag};
use super::state::KernelParameters;
use crate::powertrain::Powertrain;
use crate::record::{Outcome, Record};
use crate::study::Scenario;
use std::collections::BTreeMap;

/// Cycles that are driven again together: enough to fill the lanes a few times.
const TOGETHER: usize = 64;

/// Ids by which the others may be ahead of a record that waits for its whole trip: all of them are in
/// memory until it is there.
const FURTHEST_AHEAD: u64 = 4096;

/// Cycles that were cut short, until their whole trips are driven.
pub(super) struct WholeTrips<'a, P> {
    driving: Driving<'a>,
    /// The powertrain that never empties; none where trips are not driven again.
    deep: Option<P>,
    waiting: BTreeMap<u64, (Record, Scenario)>,
}

impl<'a, P: Powertrain> WholeTrips<'a, P> {
    pub(super) fn new(driving: Driving<'a>, powertrain: &P) -> Self {
        let deep = if driving.whole_trips { powertrain.never_emptying() } else { None };
        Self { driving, deep, waiting: BTreeMap::new() }
    }

    /// Passes on a record that is whole, and keeps any other for a while.
    pub(super) fn take(&mut self, record: Record, scenario: &Scenario, deliver: Deliver) {
        let cycle_id = record.cycle_id;
        if record.outcome == Outcome::Depleted && self.deep.is_some() {
            self.waiting.insert(cycle_id, (record, scenario.clone()));
        } else {
            deliver(record);
        }
        let first = self.waiting.keys().next();
        let is_behind = first.is_some_and(|first| first + FURTHEST_AHEAD < cycle_id);
        if is_behind || self.waiting.len() == TOGETHER {
            self.drive(deliver);
        }
    }

    /// Drives the whole trips of those that wait, and passes their records on.
    pub(super) fn drive(&mut self, deliver: Deliver) {
        let waiting = std::mem::take(&mut self.waiting);
        let (Some(deep), false) = (&self.deep, waiting.is_empty()) else { return };
        let Driving { study, level, stop, .. } = self.driving;
        let parameters = KernelParameters::new(study, deep);
        let (mut cut_short, mut scenarios) = (BTreeMap::new(), Vec::new());
        for (cycle_id, (record, scenario)) in waiting {
            cut_short.insert(cycle_id, record);
            scenarios.push(scenario);
        }
        let mut scenarios = scenarios.into_iter();
        let mut next = |_| scenarios.next().map(|scenario| LaneTask::new(study, scenario));
        let mut ended = |whole: Record, _: &Scenario| {
            let mut record = cut_short.remove(&whole.cycle_id).expect("each is driven once");
            if whole.outcome == Outcome::Completed {
                record.drove_whole_trip(whole.distance_m, whole.consumption_kwh_per_km);
            }
            deliver(record);
        };
        let observer = &mut StopFlag(stop);
        level.run(LaneScheduler::new(study, &parameters, &mut next, &mut ended, observer));
    }
}
