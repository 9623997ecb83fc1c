//! Point events: places at which a vehicle stops, slows down or may turn, as marked Poisson
//! processes.
//!
//! Gaps are exponential with the intensity of the road type; marks are independent. A Poisson
//! process has no minimum spacing, so of two events closer than the study's spacing the later one
//! is dropped, and the first and last metres of the road stay free.
//!
//! Each kind is declared once, in its file: its names in studies, tracks and logs, its stream and
//! switch, its law, and what fits estimate of it. To add one, write such a file, add its variants
//! to [`EventKind`] and its declaration to [`KINDS`], and give it a field of [`RoadTypeModel`], a
//! [`Stream`] and a [`ModelSwitch`].
//!
//! Checked: counts, shares and waits on 10,000 km lie within four standard errors, for seeds 1, 2
//! and 3. The later one of two close events goes, and turns replace the curves that they overlap
//! (`merge_turns` in `curvature.rs`).

mod give_way;
mod junction_turn;
mod mission_stop;
mod railway_crossing;
mod speed_bump;
mod stop_sign;
mod traffic_light;

pub use give_way::GiveWayModel;
pub use junction_turn::JunctionTurnModel;
pub use railway_crossing::RailwayCrossingModel;
pub use speed_bump::SpeedBumpModel;
pub use stop_sign::StopSignModel;
pub use traffic_light::TrafficLightModel;

use super::RoadTypeModel;
use super::road_type::Section;
use crate::distribution::Quantity;
use crate::random::{Draws, Stream};
use crate::switch::ModelSwitch;

/// All kinds of point events, in the order of their tracks and fits.
pub const KINDS: [&EventDeclaration; 6] = [
    &stop_sign::STOP_SIGN,
    &give_way::GIVE_WAY,
    &traffic_light::TRAFFIC_LIGHT,
    &speed_bump::SPEED_BUMP,
    &mission_stop::MISSION_STOP,
    &railway_crossing::RAILWAY_CROSSING,
];

/// Standstills that a track may have, in s.
const STANDSTILLS_S: [f64; 2] = [0.0, 172_800.0];
/// Passing speeds that a track may have, in m/s.
const PASSING_SPEEDS_MPS: [f64; 2] = [1.0, 40.0];

/// Kind of event at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// A stop sign with its standstill, in s.
    StopSign {
        /// Standstill, in s.
        standstill_s: f64,
    },
    /// A give-way sign at which the truck stops.
    GiveWayStop {
        /// Wait, in s.
        standstill_s: f64,
    },
    /// A give-way sign that is passed slowly.
    GiveWayPass {
        /// Speed, in m/s.
        speed_mps: f64,
    },
    /// A red light.
    RedLight {
        /// Wait, in s.
        standstill_s: f64,
    },
    /// A green light: no constraint.
    GreenLight,
    /// A speed bump.
    SpeedBump {
        /// Length, in m.
        length_m: f64,
        /// Height, in m.
        height_m: f64,
    },
    /// A railway crossing with a closed barrier.
    ClosedCrossing {
        /// Wait, in s.
        standstill_s: f64,
    },
    /// An open railway crossing: passed slowly, or after a stop by vehicles that have to stop
    /// there.
    OpenCrossing {
        /// Speed, in m/s.
        speed_mps: f64,
        /// Standstill of vehicles that have to stop, in s.
        standstill_s: f64,
    },
    /// A stop of the mission: unloading, rest.
    MissionStop {
        /// Dwell, in s.
        standstill_s: f64,
    },
}

/// An event at a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointEvent {
    /// Where, in m.
    pub position_m: f64,
    /// Kind of the event.
    pub kind: EventKind,
    /// Whether the truck turns there into another road.
    pub turns: bool,
}

/// How a vehicle passes an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Passage {
    /// As if it were not there.
    Free,
    /// No faster than this, in m/s.
    Slow {
        /// Speed, in m/s.
        speed_mps: f64,
    },
    /// At the speed that the driver chooses for a bump.
    Bump {
        /// Length, in m.
        length_m: f64,
        /// Height, in m.
        height_m: f64,
    },
    /// After a standstill.
    Stop {
        /// Time at rest, in s.
        standstill_s: f64,
    },
}

impl EventKind {
    /// How a vehicle passes it that has to stop at railway crossings, or need not.
    pub fn passage_of(&self, stops_at_railway_crossings: bool) -> Passage {
        match *self {
            Self::OpenCrossing { standstill_s, .. } if stops_at_railway_crossings => {
                Passage::Stop { standstill_s }
            }
            _ => self.passage(),
        }
    }

    /// How any vehicle passes it that need not stop at railway crossings.
    pub fn passage(&self) -> Passage {
        match *self {
            Self::StopSign { standstill_s }
            | Self::GiveWayStop { standstill_s }
            | Self::RedLight { standstill_s }
            | Self::ClosedCrossing { standstill_s }
            | Self::MissionStop { standstill_s } => Passage::Stop { standstill_s },
            Self::GiveWayPass { speed_mps } | Self::OpenCrossing { speed_mps, .. } => {
                Passage::Slow { speed_mps }
            }
            Self::GreenLight => Passage::Free,
            Self::SpeedBump { length_m, height_m } => Passage::Bump { length_m, height_m },
        }
    }

    /// Time at rest of every vehicle, in s; none where one need not stop.
    pub fn standstill_s(&self) -> Option<f64> {
        self.passage().standstill_s()
    }
}

impl Passage {
    /// Time at rest, in s; none without a stop.
    pub fn standstill_s(self) -> Option<f64> {
        match self {
            Self::Stop { standstill_s } => Some(standstill_s),
            _ => None,
        }
    }
}

/// Everything that the other rooms know of one kind of event.
#[derive(Clone, Copy, Debug)]
pub struct EventDeclaration {
    /// Its name in logs, as an object of a map.
    pub map_object: &'static str,
    /// Forms that an event of the kind may have.
    pub forms: &'static [EventForm],
    /// Whether most roads have none: its tracks are written only where there are some.
    pub rare: bool,
    /// Whether a standstill in a log can belong to it.
    pub stops: bool,
    /// The event of an object in a log, from the standstill there, in s, and the lowest speed, in
    /// m/s. What the log does not contain is NaN.
    pub of_log: fn(Option<f64>, f64) -> EventKind,
    /// Its part in the model of a road type; none for what no road type draws.
    pub model: Option<EventModel>,
}

/// One form of an event, such as a red light, and the tracks that it is written as.
#[derive(Clone, Copy, Debug)]
pub struct EventForm {
    /// Its tracks: an event has a value in each of them, at the same position.
    pub tracks: &'static [EventTrack],
    /// The event of one value from each track.
    pub event: fn(&[f64]) -> EventKind,
    /// Why one track needs the others; empty for a single track.
    pub purpose: &'static str,
}

/// A track of an event.
#[derive(Clone, Copy, Debug)]
pub struct EventTrack {
    /// Name, with its unit as a suffix.
    pub name: &'static str,
    /// Smallest and largest value.
    pub range: [f64; 2],
    /// The value of an event; none for an event of another form.
    pub value: fn(&EventKind) -> Option<f64>,
}

const fn track(
    name: &'static str,
    range: [f64; 2],
    value: fn(&EventKind) -> Option<f64>,
) -> EventTrack {
    EventTrack { name, range, value }
}

/// How a road type draws events of a kind, and how fits estimate them.
#[derive(Clone, Copy, Debug)]
pub struct EventModel {
    /// Name of its table below a road type.
    pub table: &'static str,
    /// Where its draws come from.
    pub stream: Stream,
    /// Switch that turns it off.
    pub switch: ModelSwitch,
    /// Appends the events of one section.
    pub sample: fn(&RoadTypeModel, &Section, &mut Draws, &mut Vec<PointEvent>),
    /// Draws what an event at a known place is, and whether the vehicle turns there; none where the
    /// road type has no such events.
    pub mark: fn(&RoadTypeModel, &mut Draws) -> Option<(EventKind, bool)>,
    /// Parameters of a road type that a fit estimates; none where it has no such events.
    pub estimation: fn(&mut RoadTypeModel) -> Option<EventEstimation<'_>>,
}

/// Estimation of a kind's events on a road type.
#[derive(Debug)]
pub struct EventEstimation<'a> {
    /// Intensity, per m.
    pub per_m: &'a mut f64,
    /// The other numbers, in the order of the study's table.
    pub parameters: Vec<EventParameter<'a>>,
}

/// A number of a kind's table, by its key, with what it is estimated from.
#[derive(Debug)]
pub enum EventParameter<'a> {
    /// The share of events for which something holds.
    Share(&'static str, &'a mut f64, fn(&EventKind) -> bool),
    /// The law of a mark, from the events that have it.
    Law(&'static str, &'a mut Quantity, fn(&EventKind) -> Option<f64>),
    /// The share of events with a turn, `turn_share`.
    TurnShare(&'a mut f64),
}

impl EventDeclaration {
    /// Whether an event is of this kind.
    pub fn includes(&self, kind: &EventKind) -> bool {
        self.tracks().any(|track| (track.value)(kind).is_some())
    }

    /// Its tracks, in order.
    pub fn tracks(&self) -> impl Iterator<Item = &'static EventTrack> {
        self.forms.iter().flat_map(|form| form.tracks)
    }
}

/// Whether the models in `without` leave out events of a kind.
pub fn is_left_out(kind: &EventKind, without: &[ModelSwitch]) -> bool {
    let declared = KINDS.iter().find(|declared| declared.includes(kind));
    let model = declared.and_then(|declared| declared.model);
    model.is_some_and(|model| without.contains(&model.switch))
}

/// A marked Poisson process on one section.
fn poisson(
    per_m: f64,
    section: &Section,
    draws: &mut Draws,
    events: &mut Vec<PointEvent>,
    mark: impl Fn(&mut Draws) -> (EventKind, bool),
) {
    if per_m <= 0.0 {
        return;
    }
    let mut position_m = section.start_m;
    loop {
        position_m += draws.exponential() / per_m;
        if position_m >= section.end_m {
            return;
        }
        let (kind, turns) = mark(draws);
        events.push(PointEvent { position_m, kind, turns });
    }
}

/// Puts events in order, keeps the ends of the road free, and drops the later one of two events
/// that are closer than the spacing. A mission stop between the ends is never dropped; what else
/// stands too close to it is.
pub fn space_out(events: &mut Vec<PointEvent>, length_m: f64, spacing_m: f64, free_end_m: f64) {
    events.retain(|e| e.position_m >= free_end_m && e.position_m <= length_m - free_end_m);
    events.sort_by(|a, b| a.position_m.total_cmp(&b.position_m));
    let mut kept: Vec<PointEvent> = Vec::with_capacity(events.len());
    let of_mission = |event: &PointEvent| matches!(event.kind, EventKind::MissionStop { .. });
    for event in events.drain(..) {
        let close = kept.last().filter(|last| event.position_m - last.position_m < spacing_m);
        match close {
            Some(_) if !of_mission(&event) => continue,
            Some(last) if !of_mission(last) => kept.truncate(kept.len() - 1),
            _ => {}
        }
        kept.push(event);
    }
    *events = kept;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    #[test]
    fn mission_stops_stay_and_push_others_away() {
        let event = |position_m: f64, kind| PointEvent { position_m, kind, turns: false };
        let stop = |at_m| event(at_m, EventKind::MissionStop { standstill_s: 60.0 });
        let sign = |at_m| event(at_m, EventKind::StopSign { standstill_s: 2.0 });
        let mut events =
            vec![stop(5.0), sign(460.0), stop(500.0), stop(560.0), sign(600.0), sign(700.0)];
        space_out(&mut events, 1000.0, 100.0, 20.0);
        assert_eq!(events, [stop(500.0), stop(560.0), sign(700.0)]);
    }

    #[test]
    fn counts_and_marks_within_four_standard_errors() {
        let model = GiveWayModel {
            per_m: 0.5e-3,
            stop_probability: 0.3,
            wait_s: Quantity::Law(crate::distribution::Law::Exponential { mean: 6.0 }),
            pass_speed_mps: Quantity::Law(crate::distribution::Law::Uniform {
                lower: 5.5,
                upper: 7.0,
            }),
            turn_share: 0.25,
        };
        let section = Section { start_m: 0.0, end_m: 1.0e7, road_type: 0 };
        for seed in 1..=3 {
            let mut events = Vec::new();
            model.sample(&section, &mut Draws::new(seed, 0, Stream::GiveWay), &mut events);
            let n = events.len() as f64;
            assert!((n - 5000.0).abs() < 4.0 * 5000f64.sqrt());
            let waits: Vec<f64> = events.iter().filter_map(|e| e.kind.standstill_s()).collect();
            let m = waits.len() as f64;
            assert!((m / n - 0.3).abs() < 4.0 * (0.21 / n).sqrt());
            let mean = waits.iter().sum::<f64>() / m;
            assert!((mean - 6.0).abs() < 4.0 * 6.0 / m.sqrt());
            let turns = events.iter().filter(|e| e.turns).count() as f64;
            assert!((turns / n - 0.25).abs() < 4.0 * (0.1875 / n).sqrt());
        }
    }

    #[test]
    fn the_later_of_two_close_events_goes() {
        let at = |position_m| PointEvent { position_m, kind: EventKind::GreenLight, turns: false };
        let mut events = vec![at(10.0), at(100.0), at(120.0), at(131.0), at(990.0)];
        space_out(&mut events, 1000.0, 30.0, 30.0);
        let places: Vec<f64> = events.iter().map(|e| e.position_m).collect();
        assert_eq!(places, [100.0, 131.0]);
    }
}
