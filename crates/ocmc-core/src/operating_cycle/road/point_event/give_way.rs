//! Give-way signs and roundabouts: some vehicles have to wait, the others pass slowly.

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

/// Declaration of give-way signs for other modules.
pub(super) const GIVE_WAY: EventDeclaration = EventDeclaration {
    map_object: "give_way",
    forms: &[
        EventForm {
            tracks: &[track("give_way_stop_s", STANDSTILLS_S, wait_s)],
            event: |values| EventKind::GiveWayStop { standstill_s: values[0] },
            purpose: "",
        },
        EventForm {
            tracks: &[track("give_way_pass_mps", PASSING_SPEEDS_MPS, pass_speed_mps)],
            event: |values| EventKind::GiveWayPass { speed_mps: values[0] },
            purpose: "",
        },
    ],
    rare: false,
    stops: true,
    of_log: |standstill_s, slowest_mps| match standstill_s {
        Some(standstill_s) => EventKind::GiveWayStop { standstill_s },
        None => EventKind::GiveWayPass { speed_mps: slowest_mps },
    },
    model: Some(EventModel {
        table: "give_ways",
        stream: Stream::GiveWay,
        switch: ModelSwitch::GiveWays,
        sample: |road_type, section, draws, events| {
            road_type.give_ways.sample(section, draws, events);
        },
        mark: |road_type, draws| Some(road_type.give_ways.mark(draws)),
        estimation: |road_type| {
            let model = &mut road_type.give_ways;
            let stops = |kind: &EventKind| wait_s(kind).is_some();
            Some(EventEstimation {
                per_m: &mut model.per_m,
                parameters: vec![
                    EventParameter::Share("stop_probability", &mut model.stop_probability, stops),
                    EventParameter::Law("wait_s", &mut model.wait_s, wait_s),
                    EventParameter::Law(
                        "pass_speed_mps",
                        &mut model.pass_speed_mps,
                        pass_speed_mps,
                    ),
                    EventParameter::TurnShare(&mut model.turn_share),
                ],
            })
        },
    }),
};

fn wait_s(kind: &EventKind) -> Option<f64> {
    let EventKind::GiveWayStop { standstill_s } = kind else { return None };
    Some(*standstill_s)
}

fn pass_speed_mps(kind: &EventKind) -> Option<f64> {
    let EventKind::GiveWayPass { speed_mps } = kind else { return None };
    Some(*speed_mps)
}

/// Give-way signs (roundabouts included) of one road type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GiveWayModel {
    /// Intensity, per m.
    #[schemars(range(min = 0.0, max = 0.02))]
    pub per_m: f64,
    /// Probability that the truck has to stop.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub stop_probability: f64,
    /// Wait when it stops, in s.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub wait_s: Quantity,
    /// Speed at which it passes when it does not stop, in m/s.
    #[schemars(range(min = 1.0, max = 40.0))]
    pub pass_speed_mps: Quantity,
    /// Share that carries a junction turn.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub turn_share: f64,
}

impl GiveWayModel {
    /// Appends the give-way signs of one section.
    pub fn sample(&self, section: &Section, draws: &mut Draws, events: &mut Vec<PointEvent>) {
        poisson(self.per_m, section, draws, events, |draws| self.mark(draws));
    }

    /// Draws what one give-way sign is, and whether the vehicle turns there.
    pub fn mark(&self, draws: &mut Draws) -> (EventKind, bool) {
        let kind = if draws.happens(self.stop_probability) {
            EventKind::GiveWayStop { standstill_s: self.wait_s.sample(draws) }
        } else {
            EventKind::GiveWayPass { speed_mps: self.pass_speed_mps.sample(draws) }
        };
        (kind, draws.happens(self.turn_share))
    }
}
