//! Stop signs: every vehicle stands for a drawn time.

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

/// Declaration of stop signs for other modules.
pub(super) const STOP_SIGN: EventDeclaration = EventDeclaration {
    map_object: "stop_sign",
    forms: &[EventForm {
        tracks: &[track("stop_sign_s", STANDSTILLS_S, |kind| match kind {
            EventKind::StopSign { standstill_s } => Some(*standstill_s),
            _ => None,
        })],
        event: |values| EventKind::StopSign { standstill_s: values[0] },
        purpose: "",
    }],
    rare: false,
    stops: true,
    of_log: |standstill_s, _| EventKind::StopSign { standstill_s: standstill_s.unwrap_or(0.0) },
    model: Some(EventModel {
        table: "stop_signs",
        stream: Stream::StopSign,
        switch: ModelSwitch::StopSigns,
        sample: |road_type, section, draws, events| {
            road_type.stop_signs.sample(section, draws, events);
        },
        mark: |road_type, draws| Some(road_type.stop_signs.mark(draws)),
        estimation: |road_type| {
            let model = &mut road_type.stop_signs;
            let standstill_s = STOP_SIGN.forms[0].tracks[0].value;
            Some(EventEstimation {
                per_m: &mut model.per_m,
                parameters: vec![
                    EventParameter::Law("standstill_s", &mut model.standstill_s, standstill_s),
                    EventParameter::TurnShare(&mut model.turn_share),
                ],
            })
        },
    }),
};

/// Stop signs of one road type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StopSignModel {
    /// Intensity, per m.
    #[schemars(range(min = 0.0, max = 0.02))]
    pub per_m: f64,
    /// Standstill, in s.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub standstill_s: Quantity,
    /// Share that carries a junction turn.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub turn_share: f64,
}

impl StopSignModel {
    /// Appends the stop signs of one section.
    pub fn sample(&self, section: &Section, draws: &mut Draws, events: &mut Vec<PointEvent>) {
        poisson(self.per_m, section, draws, events, |draws| self.mark(draws));
    }

    /// Draws what one stop sign is, and whether the vehicle turns there.
    pub fn mark(&self, draws: &mut Draws) -> (EventKind, bool) {
        let kind = EventKind::StopSign { standstill_s: self.standstill_s.sample(draws) };
        (kind, draws.happens(self.turn_share))
    }
}
