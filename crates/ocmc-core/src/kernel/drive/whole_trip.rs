//! The whole trips of cycles that a battery cut short: driven again from their start, with a
//! battery that never empties.

use super::observer::Observer;
use super::scheduler::{Deliver, Driving, drive_lanes};
use crate::kernel::step::state::KernelParameters;
use crate::kernel::trip::lane_task::LaneTask;
use crate::powertrain::Powertrain;
use crate::record::{Outcome, Record};
use crate::study::Scenario;
use std::mem::take;

/// Cycles that are driven again together: enough to fill the lanes a few times.
const TOGETHER: usize = 64;

/// Records that are passed on at most while one waits for its whole trip: whoever puts them in
/// order keeps them until it is there.
const MOST_MEANWHILE: usize = 1024;

/// Cycles that were cut short, until their whole trips are driven.
pub(super) struct WholeTrips<'a, P> {
    driving: Driving<'a>,
    /// The powertrain that never empties; none where trips are not driven again.
    deep: Option<P>,
    waiting: Vec<(Record, Scenario)>,
    /// Records that were passed on since the first of them waits.
    meanwhile: usize,
}

impl<'a, P: Powertrain> WholeTrips<'a, P> {
    pub(super) fn new(driving: Driving<'a>, powertrain: &P) -> Self {
        let deep = if driving.whole_trips { powertrain.never_emptying() } else { None };
        Self { driving, deep, waiting: Vec::new(), meanwhile: 0 }
    }

    /// Passes on a record that is whole, and keeps any other for a while.
    pub(super) fn take(&mut self, record: Record, scenario: &Scenario, deliver: Deliver) {
        if record.outcome == Outcome::Depleted && self.deep.is_some() {
            self.waiting.push((record, scenario.clone()));
        } else {
            self.meanwhile += usize::from(!self.waiting.is_empty());
            deliver(record);
        }
        if self.waiting.len() == TOGETHER || self.meanwhile == MOST_MEANWHILE {
            self.drive(deliver);
        }
    }

    /// Drives the whole trips of those that wait, and passes their records on.
    pub(super) fn drive(&mut self, deliver: Deliver) {
        let (mut cut_short, scenarios): (Vec<Record>, Vec<Scenario>) =
            take(&mut self.waiting).into_iter().unzip();
        self.meanwhile = 0;
        let (Some(deep), false) = (&self.deep, scenarios.is_empty()) else { return };
        let study = self.driving.study;
        let parameters = KernelParameters::new(study, deep);
        let mut scenarios = scenarios.into_iter();
        let mut next = |_| scenarios.next().map(|scenario| LaneTask::new(study, scenario));
        let mut ended = |whole: Record, _: &Scenario| {
            // a cycle that is driven twice has two equal records
            let place = cut_short.iter().position(|record| record.cycle_id == whole.cycle_id);
            let mut record = cut_short.swap_remove(place.expect("each has been cut short"));
            if whole.outcome == Outcome::Completed {
                record.drove_whole_trip(whole.distance_m, whole.drawn_kwh_per_km());
            }
            deliver(record);
        };
        drive_lanes(self.driving, &parameters, &mut next, &mut ended, Observer::Nobody);
    }
}
