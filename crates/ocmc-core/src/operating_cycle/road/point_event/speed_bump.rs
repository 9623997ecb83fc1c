//! Speed bumps: passed at the speed that the driver finds comfortable.

use super::{
    EventDeclaration, EventEstimation, EventForm, EventKind, EventModel, EventParameter,
    PointEvent, poisson, track,
};
use crate::distribution::Quantity;
use crate::operating_cycle::road::road_type::Section;
use crate::random::{Draws, Stream};
use crate::switch::ModelSwitch;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Declaration of speed bumps for other modules.
pub(super) const SPEED_BUMP: EventDeclaration = EventDeclaration {
    map_object: "speed_bump",
    forms: &[EventForm {
        tracks: &[
            track("speed_bump_length_m", [0.1, 50.0], length_m),
            track("speed_bump_height_m", [0.005, 0.5], height_m),
        ],
        event: |values| EventKind::SpeedBump { length_m: values[0], height_m: values[1] },
        purpose: "each speed bump has a length and, at the same position, a height",
    }],
    rare: false,
    stops: false,
    // a log contains neither its length nor its height
    of_log: |_, _| EventKind::SpeedBump { length_m: f64::NAN, height_m: f64::NAN },
    model: Some(EventModel {
        table: "speed_bumps",
        stream: Stream::SpeedBump,
        switch: ModelSwitch::SpeedBumps,
        sample: |road_type, section, draws, events| {
            road_type.speed_bumps.sample(section, draws, events);
        },
        mark: |road_type, draws| Some(road_type.speed_bumps.mark(draws)),
        estimation: |road_type| {
            let model = &mut road_type.speed_bumps;
            Some(EventEstimation {
                per_m: &mut model.per_m,
                parameters: vec![
                    EventParameter::Law("length_m", &mut model.length_m, length_m),
                    EventParameter::Law("height_m", &mut model.height_m, height_m),
                ],
            })
        },
    }),
};

fn length_m(kind: &EventKind) -> Option<f64> {
    let EventKind::SpeedBump { length_m, .. } = kind else { return None };
    Some(*length_m)
}

fn height_m(kind: &EventKind) -> Option<f64> {
    let EventKind::SpeedBump { height_m, .. } = kind else { return None };
    Some(*height_m)
}

/// Speed bumps of one road type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedBumpModel {
    /// Intensity, per m.
    #[schemars(range(min = 0.0, max = 0.02))]
    pub per_m: f64,
    /// Length, in m.
    #[schemars(range(min = 0.1, max = 50.0))]
    pub length_m: Quantity,
    /// Height, in m.
    #[schemars(range(min = 0.005, max = 0.5))]
    pub height_m: Quantity,
}

impl SpeedBumpModel {
    /// Appends the speed bumps of one section.
    pub fn sample(&self, section: &Section, draws: &mut Draws, events: &mut Vec<PointEvent>) {
        poisson(self.per_m, section, draws, events, |draws| self.mark(draws));
    }

    /// Draws what one speed bump is, and whether the vehicle turns there.
    pub fn mark(&self, draws: &mut Draws) -> (EventKind, bool) {
        let length_m = self.length_m.sample(draws);
        let height_m = self.height_m.sample(draws);
        (EventKind::SpeedBump { length_m, height_m }, false)
    }
}
