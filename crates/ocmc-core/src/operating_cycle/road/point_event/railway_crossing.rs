//! Railway crossings: a vehicle waits where the barrier is closed, and passes slowly where it is
//! open. Some vehicles have to stop even then: buses with passengers and dangerous goods, for
//! example in the United States (49 CFR 392.10 \[PK\]).

use super::{
    EventDeclaration, EventEstimation, EventForm, EventKind, EventModel, EventParameter,
    PASSING_SPEEDS_MPS, PointEvent, STANDSTILLS_S, poisson, track,
};
use crate::distribution::Quantity;
use crate::operating_cycle::road::road_type::Section;
use crate::random::{Draws, Stream};
use crate::switch::ModelSwitch;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Declaration of railway crossings for other modules.
pub(super) const RAILWAY_CROSSING: EventDeclaration = EventDeclaration {
    map_object: "railway_crossing",
    forms: &[
        EventForm {
            tracks: &[track("railway_crossing_wait_s", STANDSTILLS_S, wait_s)],
            event: |values| EventKind::ClosedCrossing { standstill_s: values[0] },
            purpose: "",
        },
        EventForm {
            tracks: &[
                track("railway_crossing_pass_mps", PASSING_SPEEDS_MPS, pass_speed_mps),
                track("railway_crossing_stop_s", STANDSTILLS_S, stop_s),
            ],
            event: |values| EventKind::OpenCrossing {
                speed_mps: values[0],
                standstill_s: values[1],
            },
            purpose: "each open railway crossing has a speed and, at the same position, the \
                      standstill of vehicles that have to stop",
        },
    ],
    rare: true,
    stops: true,
    // a log does not show whether a vehicle stood because it had to: it counts as a closed barrier
    of_log: |standstill_s, slowest_mps| match standstill_s {
        Some(standstill_s) => EventKind::ClosedCrossing { standstill_s },
        None => EventKind::OpenCrossing { speed_mps: slowest_mps, standstill_s: f64::NAN },
    },
    model: Some(EventModel {
        table: "railway_crossings",
        stream: Stream::RailwayCrossing,
        switch: ModelSwitch::RailwayCrossings,
        sample: |road_type, section, draws, events| {
            if let Some(model) = &road_type.railway_crossings {
                model.sample(section, draws, events);
            }
        },
        mark: |road_type, draws| road_type.railway_crossings.as_ref().map(|m| m.mark(draws)),
        estimation: |road_type| {
            let model = road_type.railway_crossings.as_mut()?;
            let closed = |kind: &EventKind| wait_s(kind).is_some();
            Some(EventEstimation {
                per_m: &mut model.per_m,
                parameters: vec![
                    EventParameter::Share(
                        "closed_probability",
                        &mut model.closed_probability,
                        closed,
                    ),
                    EventParameter::Law("wait_s", &mut model.wait_s, wait_s),
                    EventParameter::Law(
                        "pass_speed_mps",
                        &mut model.pass_speed_mps,
                        pass_speed_mps,
                    ),
                    EventParameter::Law("stop_s", &mut model.stop_s, stop_s),
                ],
            })
        },
    }),
};

fn wait_s(kind: &EventKind) -> Option<f64> {
    let EventKind::ClosedCrossing { standstill_s } = kind else { return None };
    Some(*standstill_s)
}

fn pass_speed_mps(kind: &EventKind) -> Option<f64> {
    let EventKind::OpenCrossing { speed_mps, .. } = kind else { return None };
    Some(*speed_mps)
}

fn stop_s(kind: &EventKind) -> Option<f64> {
    let EventKind::OpenCrossing { standstill_s, .. } = kind else { return None };
    Some(*standstill_s)
}

/// Railway crossings of one road type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RailwayCrossingModel {
    /// Intensity, per m.
    #[schemars(range(min = 0.0, max = 0.02))]
    pub per_m: f64,
    /// Probability that the barrier is closed.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub closed_probability: f64,
    /// Wait at a closed barrier, in s.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub wait_s: Quantity,
    /// Speed at which an open crossing is passed, in m/s.
    #[schemars(range(min = 1.0, max = 40.0))]
    pub pass_speed_mps: Quantity,
    /// Standstill at an open crossing of vehicles that have to stop there, in s.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub stop_s: Quantity,
}

impl RailwayCrossingModel {
    /// Appends the railway crossings of one section.
    pub fn sample(&self, section: &Section, draws: &mut Draws, events: &mut Vec<PointEvent>) {
        poisson(self.per_m, section, draws, events, |draws| self.mark(draws));
    }

    /// Draws what one railway crossing is, and whether the vehicle turns there.
    pub fn mark(&self, draws: &mut Draws) -> (EventKind, bool) {
        let kind = if draws.happens(self.closed_probability) {
            EventKind::ClosedCrossing { standstill_s: self.wait_s.sample(draws) }
        } else {
            let speed_mps = self.pass_speed_mps.sample(draws);
            EventKind::OpenCrossing { speed_mps, standstill_s: self.stop_s.sample(draws) }
        };
        (kind, false)
    }
}
