//! Stops of the mission, which the mission draws (`operating_cycle/mission.rs`) and no road type.

use super::{EventDeclaration, EventForm, EventKind, STANDSTILLS_S, track};

/// Declaration of stops of the mission for other modules.
pub(super) const MISSION_STOP: EventDeclaration = EventDeclaration {
    map_object: "mission_stop",
    forms: &[EventForm {
        tracks: &[track("mission_stop_s", STANDSTILLS_S, |kind| match kind {
            EventKind::MissionStop { standstill_s } => Some(*standstill_s),
            _ => None,
        })],
        event: |values| EventKind::MissionStop { standstill_s: values[0] },
        purpose: "",
    }],
    rare: false,
    stops: true,
    of_log: |standstill_s, _| EventKind::MissionStop { standstill_s: standstill_s.unwrap_or(0.0) },
    model: None,
};
