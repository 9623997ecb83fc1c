//! Parts of a mission: with how much cargo a truck leaves each of its stops, and the work of its
//! body there.
//!
//! The payload holds from a stop to the next one, as the operating-cycle format has it (a track
//! that is constant between stops). Stream `MissionPart`. Checked by hand, and by whole runs: a
//! round with parts takes what its legs take one by one (`tests/it/mission_parts.rs`).

use super::given::{GivenCycle, SAME_PLACE_M};
use super::mission::{Mission, MissionModel};
use super::road::point_event::{EventKind, PointEvent};
use crate::distribution::Quantity;
use crate::random::{Stream, Streams};
use crate::switch::ModelSwitch;
use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Cargo that is unloaded and loaded at the stops of a mission; one of its keys is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CargoModel {
    /// Share of the payload that has been unloaded behind the last stop, in equal parts at all
    /// stops.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub delivered_share: Option<f64>,
    /// Payload with which the truck leaves a stop, in kg, drawn for each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 0.0, max = 100_000.0))]
    pub payload_kg: Option<Quantity>,
}

/// Work of a body at the stops of a mission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PowerTakeOffModel {
    /// Power that the body takes, in W: of a diesel truck from its engine, which runs meanwhile, of
    /// a battery truck from its battery.
    #[schemars(range(min = 0.0, max = 300_000.0))]
    pub power_w: Quantity,
    /// For how long, in s, at most as long as the truck stands; absent: as long as the mission says
    /// that it stands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Quantity", range(min = 0.0, max = 86_400.0))]
    pub duration_s: Option<Quantity>,
}

/// A part of a mission. It begins with a stop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MissionPart {
    /// Where it begins, in m: the position of the stop.
    pub start_m: f64,
    /// Payload behind the stop, in kg.
    pub payload_kg: f64,
    /// Power that the body takes at the stop, in W.
    pub power_take_off_w: f64,
    /// For how long, in s.
    pub power_take_off_s: f64,
}

impl CargoModel {
    /// One of the keys is given.
    pub fn validate(&self, problems: &mut Problems) {
        let given =
            usize::from(self.delivered_share.is_some()) + usize::from(self.payload_kg.is_some());
        problems.require(
            given == 1,
            "",
            format!("with {given} of its keys"),
            "one of `delivered_share` and `payload_kg`",
        );
    }
}

impl MissionPart {
    /// Work of the body at the stop, in J.
    pub fn power_take_off_j(&self) -> f64 {
        self.power_take_off_w * self.power_take_off_s
    }
}

/// The track of the payload.
pub(super) const PAYLOAD: &str = "payload_kg";
/// The tracks of the body's power, in W, and of its duration, in s.
pub(super) const POWER_TAKE_OFF: [&str; 2] = ["power_take_off_w", "power_take_off_s"];
/// The most that a body takes, in W.
pub(super) const MOST_POWER_W: f64 = 300.0e3;

/// The parts of a given cycle, from the points of its tracks: payload, and the body's power and its
/// duration. None where nothing changes.
///
/// # Errors
/// The track and the place of what is not at a stop of the mission.
pub(super) fn parts_of(
    events: &[PointEvent],
    payload: &[(f64, f64)],
    [power, duration]: [&[(f64, f64)]; 2],
) -> Result<Vec<MissionPart>, (&'static str, f64)> {
    let stops: Vec<(f64, f64)> = events.iter().filter_map(mission_stop).collect();
    let later = payload.get(1..).unwrap_or_default();
    let tracks = [(PAYLOAD, later), (POWER_TAKE_OFF[0], power), (POWER_TAKE_OFF[1], duration)];
    let is_at = |at_m: f64, stop_m: f64| (at_m - stop_m).abs() < SAME_PLACE_M;
    for (name, points) in tracks {
        let off = points.iter().find(|point| !stops.iter().any(|stop| is_at(point.0, stop.0)));
        if let Some((at_m, _)) = off {
            return Err((name, *at_m));
        }
    }
    if later.is_empty() && power.is_empty() {
        return Ok(Vec::new());
    }
    let at = |points: &[(f64, f64)], start_m: f64| {
        points.iter().find(|point| is_at(point.0, start_m)).map(|point| point.1)
    };
    let part = |&(start_m, standstill_s): &(f64, f64)| MissionPart {
        start_m,
        payload_kg: payload
            .iter()
            .rfind(|point| point.0 < start_m + SAME_PLACE_M)
            .map_or(0.0, |point| point.1),
        power_take_off_w: at(power, start_m).unwrap_or(0.0),
        power_take_off_s: at(duration, start_m).unwrap_or(standstill_s).min(standstill_s),
    };
    Ok(stops.iter().map(part).collect())
}

/// The points of the tracks that parts are written as: payload, and the body's power and duration.
pub(super) fn points_of(payload_kg: f64, parts: &[MissionPart]) -> [Vec<(f64, f64)>; 3] {
    let mut payload = vec![(0.0, payload_kg)];
    for part in parts {
        if payload.last().is_some_and(|last| last.1 != part.payload_kg) {
            payload.push((part.start_m, part.payload_kg));
        }
    }
    let works = parts.iter().filter(|part| part.power_take_off_j() > 0.0);
    let power = works.clone().map(|part| (part.start_m, part.power_take_off_w)).collect();
    let duration = works.map(|part| (part.start_m, part.power_take_off_s)).collect();
    [payload, power, duration]
}

/// Where a stop of the mission is, in m, and its dwell, in s.
fn mission_stop(event: &PointEvent) -> Option<(f64, f64)> {
    match event.kind {
        EventKind::MissionStop { standstill_s } => Some((event.position_m, standstill_s)),
        _ => None,
    }
}

/// Writes down the parts of a mission whose stops are on the road. `given`: the operating cycle
/// that is driven, where one is; `keeps`: whether the payload is its own.
pub(super) fn set_parts(
    model: &MissionModel,
    events: &[PointEvent],
    given: Option<(&GivenCycle, bool)>,
    streams: &Streams,
    without: &[ModelSwitch],
    mission: &mut Mission,
) {
    mission.parts.clear();
    let own = given.map_or(&[][..], |(cycle, _)| cycle.parts.as_slice());
    let stops = model.stops.as_ref();
    let cargo = stops.and_then(|stops| stops.cargo.as_ref());
    let power_take_off = stops.and_then(|stops| stops.power_take_off.as_ref());
    let keeps = given.is_some_and(|(_, keeps)| keeps) && !own.is_empty();
    let gives_power = own.iter().any(|part| part.power_take_off_w > 0.0);
    if !keeps && !gives_power && cargo.is_none() && power_take_off.is_none() {
        return;
    }
    let stops: Vec<(f64, f64)> = events.iter().filter_map(mission_stop).collect();
    let spread = !without.contains(&ModelSwitch::PayloadSpread);
    let mut draws = streams.open(Stream::MissionPart);
    let mut payload_kg = mission.payload_kg;
    for (k, &(start_m, standstill_s)) in stops.iter().enumerate() {
        let given = own.iter().find(|part| part.start_m == start_m);
        let share = (k + 1) as f64 / stops.len() as f64;
        match cargo {
            _ if keeps => payload_kg = given.map_or(payload_kg, |part| part.payload_kg),
            Some(CargoModel { delivered_share: Some(delivered), .. }) => {
                payload_kg = mission.payload_kg * (1.0 - delivered * share);
            }
            Some(CargoModel { payload_kg: Some(law), .. }) => {
                let drawn_kg = law.sample(&mut draws);
                payload_kg = if spread { drawn_kg } else { law.centre() };
            }
            _ => {}
        }
        let [power_take_off_w, power_take_off_s] = match (gives_power, given, power_take_off) {
            (true, Some(part), _) => [part.power_take_off_w, part.power_take_off_s],
            (false, _, Some(model)) => {
                let power_w = model.power_w.sample(&mut draws).max(0.0);
                let duration = model.duration_s.as_ref();
                let duration_s = duration.map_or(standstill_s, |law| law.sample(&mut draws));
                [power_w, duration_s.clamp(0.0, standstill_s)]
            }
            _ => [0.0; 2],
        };
        mission.parts.push(MissionPart {
            start_m,
            payload_kg: payload_kg.max(0.0),
            power_take_off_w,
            power_take_off_s,
        });
    }
}
