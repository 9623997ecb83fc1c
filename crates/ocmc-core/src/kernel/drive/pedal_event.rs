//! Events of a drive: trucks that already roll, for a given time, from the same step function as a
//! fleet.
//!
//! It is what the identification of a driver's gains simulates again and again, with other gains in
//! each lane.

use super::cpu::CpuLevel;
use super::observer::Observer;
use super::rolling_truck::RollingTrucks;
use super::scheduler::{Driving, drive_lanes};
use crate::kernel::step::state::KernelParameters;
use crate::kernel::trip::InitialMotion;
use crate::kernel::trip::lane_task::LaneTask;
use crate::powertrain::{Powertrain, PowertrainTask};
use crate::study::{Scenario, Study};
use crate::threads::deep;
use std::sync::atomic::AtomicBool;

pub use super::rolling_truck::EventSeries;

/// A truck that rolls into an event: its scenario, and how it rolls.
pub type RollingStart = (Scenario, InitialMotion);

/// Drives events for some time each, in s, or until their roads end, side by side. The
/// series are in the order of the starts, and none depends on the others.
pub fn simulate_events(
    study: &Study,
    starts: Vec<RollingStart>,
    duration_s: f64,
) -> Vec<EventSeries> {
    deep(|| study.vehicle().powertrain.dispatch(EventsTask { study, starts, duration_s }))
}

struct EventsTask<'a> {
    study: &'a Study,
    starts: Vec<RollingStart>,
    duration_s: f64,
}

impl PowertrainTask for EventsTask<'_> {
    type Answer = Vec<EventSeries>;

    fn run<P: Powertrain>(self, powertrain: &P) -> Vec<EventSeries> {
        let Self { study, starts, duration_s } = self;
        if duration_s <= 0.0 {
            return vec![EventSeries::default(); starts.len()];
        }
        let (scenarios, rolling): (Vec<_>, Vec<_>) = starts.into_iter().unzip();
        let mut trucks = RollingTrucks::new(rolling, duration_s);
        let mut scenarios = scenarios.into_iter();
        let mut next = |_| scenarios.next().map(|scenario| LaneTask::new(study, scenario));
        let (level, stop) = (CpuLevel::best(), &AtomicBool::new(false));
        let driving = Driving { study, level, stop, whole_trips: false };
        let parameters = KernelParameters::new(study, powertrain);
        let observer = Observer::Events(&mut trucks);
        drive_lanes(driving, &parameters, &mut next, &mut |_, _| {}, observer);
        trucks.into_series()
    }
}
