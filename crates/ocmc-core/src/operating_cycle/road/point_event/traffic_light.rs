//! Traffic lights, which are not coordinated: a vehicle waits at red and passes at green.

use super::{
    EventDeclaration, EventEstimation, EventForm, EventKind, EventModel, EventParameter,
    PointEvent, STANDSTILLS_S, poisson, track,
};
use crate::distribution::Quantity;
use crate::operating_cycle::road::road_type::Section;
use crate::random::{Draws, Stream};
use crate::switch::ModelSwitch;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Declaration of traffic lights for other modules.
pub(super) const TRAFFIC_LIGHT: EventDeclaration = EventDeclaration {
    map_object: "traffic_light",
    forms: &[
        EventForm {
            tracks: &[track("red_light_s", STANDSTILLS_S, wait_s)],
            event: |values| EventKind::RedLight { standstill_s: values[0] },
            purpose: "",
        },
        EventForm {
            tracks: &[track("green_light", [0.0, 1.0], |kind| {
                matches!(kind, EventKind::GreenLight).then_some(1.0)
            })],
            event: |_| EventKind::GreenLight,
            purpose: "",
        },
    ],
    rare: false,
    stops: true,
    of_log: |standstill_s, _| match standstill_s {
        Some(standstill_s) => EventKind::RedLight { standstill_s },
        None => EventKind::GreenLight,
    },
    model: Some(EventModel {
        table: "traffic_lights",
        stream: Stream::TrafficLight,
        switch: ModelSwitch::TrafficLights,
        sample: |road_type, section, draws, events| {
            road_type.traffic_lights.sample(section, draws, events);
        },
        mark: |road_type, draws| Some(road_type.traffic_lights.mark(draws)),
        estimation: |road_type| {
            let model = &mut road_type.traffic_lights;
            let red = |kind: &EventKind| wait_s(kind).is_some();
            Some(EventEstimation {
                per_m: &mut model.per_m,
                parameters: vec![
                    EventParameter::Share("red_probability", &mut model.red_probability, red),
                    EventParameter::Law("wait_s", &mut model.wait_s, wait_s),
                    EventParameter::TurnShare(&mut model.turn_share),
                ],
            })
        },
    }),
};

fn wait_s(kind: &EventKind) -> Option<f64> {
    let EventKind::RedLight { standstill_s } = kind else { return None };
    Some(*standstill_s)
}

/// Traffic lights of one road type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrafficLightModel {
    /// Intensity, per m.
    #[schemars(range(min = 0.0, max = 0.02))]
    pub per_m: f64,
    /// Probability of red.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub red_probability: f64,
    /// Wait at red, in s.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub wait_s: Quantity,
    /// Share that carries a junction turn.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub turn_share: f64,
}

impl TrafficLightModel {
    /// Appends the traffic lights of one section.
    pub fn sample(&self, section: &Section, draws: &mut Draws, events: &mut Vec<PointEvent>) {
        poisson(self.per_m, section, draws, events, |draws| self.mark(draws));
    }

    /// Draws what one traffic light is, and whether the vehicle turns there.
    pub fn mark(&self, draws: &mut Draws) -> (EventKind, bool) {
        let kind = if draws.happens(self.red_probability) {
            EventKind::RedLight { standstill_s: self.wait_s.sample(draws) }
        } else {
            EventKind::GreenLight
        };
        (kind, draws.happens(self.turn_share))
    }
}
