//! The tracks of a realised operating cycle: what a route planner, another simulator or a plot
//! needs of it.
//!
//! Tracks need not share a grid. A constant track holds from its position to the next one, a linear
//! one is interpolated, an event acts at its position alone. Weather and traffic are given where
//! the free-flow clock meets them.

use super::given::GivenCycle;
use super::mission_part::{MissionPart, PAYLOAD, POWER_TAKE_OFF, points_of};
use super::{OperatingCycle, TrafficStretch, WeatherStretch};
use crate::operating_cycle::road::RoadTypeModel;
use crate::operating_cycle::road::curvature::Curve;
use crate::operating_cycle::road::point_event::{KINDS, PointEvent};
use crate::operating_cycle::road::road_type::Section;
use crate::operating_cycle::road::surface::Ground;
use serde::Serialize;

/// How a track is read between its positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Rule {
    /// A value holds up to the next position.
    Constant,
    /// Values are interpolated.
    Linear,
    /// A value acts at its position.
    Event,
}

impl Rule {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Linear => "linear",
            Self::Event => "event",
        }
    }
}

/// The values of a track.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Values {
    /// Numbers.
    Numbers(Vec<f64>),
    /// Names.
    Names(Vec<String>),
}

/// One track.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Track {
    /// Name, with its unit as a suffix.
    pub name: &'static str,
    /// How it is read.
    pub rule: Rule,
    /// Positions, in m.
    pub position_m: Vec<f64>,
    /// Values, one a position.
    pub value: Values,
}

/// The track that names the log from which a road was made.
pub const SOURCE_LOG: &str = "source_log";
/// The track that says where the limits of such a road come from.
pub const LIMIT_SOURCE: &str = "limit_source";

/// Tracks of the road, before those of the events.
const OF_ROAD: [&str; 10] = [
    SOURCE_LOG,
    LIMIT_SOURCE,
    "road_type",
    "speed_limit_mps",
    "curvature_per_m",
    "grade",
    "altitude_m",
    "roughness_m3",
    "ground",
    "wind_exposure",
];

/// Tracks of weather, traffic and mission, behind those of the events.
const OF_TRIP: [&str; 11] = [
    "air_temperature_k",
    "air_pressure_pa",
    "relative_humidity",
    "precipitation_mps",
    "snow",
    "wind_speed_mps",
    "wind_direction_rad",
    "traffic_density_per_m",
    PAYLOAD,
    POWER_TAKE_OFF[0],
    POWER_TAKE_OFF[1],
];

/// Names of all tracks that an operating cycle is written as, in order.
pub fn names() -> Vec<&'static str> {
    let of_events = KINDS.iter().flat_map(|kind| kind.tracks()).map(|track| track.name);
    OF_ROAD.into_iter().chain(of_events).chain(OF_TRIP).collect()
}

/// How the track of a name is read.
pub fn rule_of(name: &str) -> Rule {
    if name == "altitude_m" {
        Rule::Linear
    } else if POWER_TAKE_OFF.contains(&name)
        || KINDS.iter().flat_map(|kind| kind.tracks()).any(|track| track.name == name)
    {
        Rule::Event
    } else {
        Rule::Constant
    }
}

impl Track {
    /// A track of numbers without a value yet.
    pub fn empty(name: &'static str, rule: Rule) -> Self {
        Self { name, rule, position_m: Vec::new(), value: Values::Numbers(Vec::new()) }
    }

    /// Appends a number.
    pub fn push(&mut self, position_m: f64, value: f64) {
        if let Values::Numbers(values) = &mut self.value {
            self.position_m.push(position_m);
            values.push(value);
        }
    }

    /// Drops the entries of a constant track that repeat the value before them.
    pub fn merge_equal(&mut self) {
        if self.rule != Rule::Constant {
            return;
        }
        let repeats = |k: usize| match &self.value {
            Values::Numbers(values) => k > 0 && values[k] == values[k - 1],
            Values::Names(names) => k > 0 && names[k] == names[k - 1],
        };
        let keep: Vec<bool> = (0..self.position_m.len()).map(|k| !repeats(k)).collect();
        let mut kept = keep.iter().cycle();
        let mut next = || kept.next() == Some(&true);
        self.position_m.retain(|_| next());
        match &mut self.value {
            Values::Numbers(values) => values.retain(|_| next()),
            Values::Names(names) => names.retain(|_| next()),
        }
    }

    fn numbers(name: &'static str, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let (position_m, value) = points.into_iter().unzip();
        Self { name, rule: rule_of(name), position_m, value: Values::Numbers(value) }
    }

    fn names(name: &'static str, points: impl IntoIterator<Item = (f64, String)>) -> Self {
        let (position_m, value) = points.into_iter().unzip();
        Self { name, rule: Rule::Constant, position_m, value: Values::Names(value) }
    }
}

/// The curvature over the way; of two curves that overlap the second one begins where the first one
/// ends.
fn of_curves(curves: &[Curve], length_m: f64) -> Track {
    let mut curvature = vec![(0.0, 0.0)];
    let mut free_from_m = 0.0;
    for curve in curves {
        let start_m = curve.start_m.max(free_from_m);
        if !(start_m < curve.end_m.min(length_m)) {
            continue;
        }
        if curvature.last().is_some_and(|last| last.0 == start_m) {
            curvature.pop();
        }
        curvature.push((start_m, curve.curvature_per_m()));
        free_from_m = curve.end_m;
        if curve.end_m < length_m {
            curvature.push((curve.end_m, 0.0));
        }
    }
    Track::numbers("curvature_per_m", curvature)
}

/// The tracks of events; those of rare kinds only where there are some.
fn of_events(events: &[PointEvent]) -> impl Iterator<Item = Track> {
    KINDS.into_iter().flat_map(move |kind| {
        let of_kind = kind.tracks().map(move |track| {
            let value = |e: &PointEvent| (track.value)(&e.kind).map(|v| (e.position_m, v));
            Track::numbers(track.name, events.iter().filter_map(value))
        });
        of_kind.filter(|track| !(kind.rare && track.position_m.is_empty()))
    })
}

/// The tracks of weather.
fn of_weather(stretches: &[WeatherStretch]) -> [Track; 7] {
    let weather = |name, value: fn(&super::Weather) -> f64| {
        Track::numbers(name, stretches.iter().map(|w| (w.start_m, value(&w.weather))))
    };
    [
        weather("air_temperature_k", |w| w.temperature_k),
        weather("air_pressure_pa", |w| w.pressure_pa),
        weather("relative_humidity", |w| w.relative_humidity),
        weather("precipitation_mps", |w| w.precipitation_mps),
        weather("snow", |w| if w.snow { 1.0 } else { 0.0 }),
        weather("wind_speed_mps", |w| w.wind_speed_mps),
        weather("wind_direction_rad", super::Weather::wrapped_direction_rad),
    ]
}

/// The tracks of the mission; those of the body only where it works.
fn of_mission(payload_kg: f64, parts: &[MissionPart]) -> impl Iterator<Item = Track> + use<> {
    let names = [PAYLOAD, POWER_TAKE_OFF[0], POWER_TAKE_OFF[1]];
    let points = points_of(payload_kg, parts);
    let tracks = names.into_iter().zip(points).map(|(name, points)| Track::numbers(name, points));
    tracks.filter(|track| !track.position_m.is_empty())
}

/// The track of traffic.
fn of_traffic(stretches: &[TrafficStretch]) -> Track {
    let points = stretches.iter().map(|t| (t.start_m, t.density_per_m));
    Track::numbers("traffic_density_per_m", points)
}

impl OperatingCycle {
    /// All tracks. `names` and `types` are the study's road types, in the order of their numbers.
    pub fn tracks(&self, names: &[String], types: &[RoadTypeModel]) -> Vec<Track> {
        let road = &self.road;
        let sections = || road.sections.iter();
        let step = |k: usize| k as f64 * road.slope_step_m;
        let mut altitude_m = 0.0;
        let altitude = road.slopes.iter().enumerate().map(|(k, slope)| {
            let point = (step(k), altitude_m);
            altitude_m += slope * (road.length_m - step(k)).min(road.slope_step_m);
            point
        });
        let mut altitude: Vec<(f64, f64)> = altitude.collect();
        altitude.push((road.length_m, altitude_m));
        let slopes = road.slopes.iter().enumerate().map(|(k, slope)| (step(k), *slope));
        let block = |(k, roughness): (usize, &f64)| (k as f64 * road.roughness_block_m, *roughness);
        let grounds = sections().zip(&road.grounds);
        let exposure = |section: &Section| types[section.road_type].wind_exposure;
        let mut tracks = vec![
            Track::names("road_type", sections().map(|s| (s.start_m, names[s.road_type].clone()))),
            Track::numbers("speed_limit_mps", road.signs.iter().map(|s| (s.start_m, s.speed_mps))),
            of_curves(&road.curves, road.length_m),
            Track::numbers("grade", slopes),
            Track::numbers("altitude_m", altitude),
            Track::numbers("roughness_m3", road.roughness_m3.iter().enumerate().map(block)),
            Track::names("ground", grounds.map(|(s, g)| (s.start_m, g.name().to_owned()))),
            Track::numbers("wind_exposure", sections().map(|s| (s.start_m, exposure(s)))),
        ];
        tracks.extend(of_events(&road.events));
        tracks.extend(of_weather(&self.weather));
        tracks.push(of_traffic(&self.traffic));
        tracks.extend(of_mission(self.mission.payload_kg, &self.mission.parts));
        tracks
    }
}

impl GivenCycle {
    /// Its tracks, from which [`GivenCycle::from_tracks`] makes it again, but for departure and
    /// heading. What it lacks has no track.
    pub fn tracks(&self) -> Vec<Track> {
        let word = |name, word: &Option<String>| {
            word.iter().map(move |word| Track::names(name, [(0.0, word.clone())])).next()
        };
        let mut tracks: Vec<Track> = word(SOURCE_LOG, &self.source_log)
            .into_iter()
            .chain(word(LIMIT_SOURCE, &self.limit_source))
            .collect();
        let types = self.road_types.iter().map(|types| Track::names("road_type", types.clone()));
        tracks.extend(types);
        tracks.push(Track::numbers("speed_limit_mps", self.limits.iter().copied()));
        tracks.push(of_curves(&self.curves, self.length_m));
        let mut altitude = self.altitude.clone();
        // the last position of all tracks is the length of the road
        if let Some(last) = altitude.last().copied().filter(|last| last.0 < self.length_m) {
            altitude.push((self.length_m, last.1));
        }
        tracks.push(Track::numbers("altitude_m", altitude));
        let roughness = self.roughness.iter();
        tracks.extend(roughness.map(|points| Track::numbers("roughness_m3", points.clone())));
        let ground = |points: &Vec<(f64, Ground)>| {
            let named = points.iter().map(|(at_m, ground)| (*at_m, ground.name().to_owned()));
            Track::names("ground", named)
        };
        tracks.extend(self.grounds.iter().map(ground));
        tracks.extend(of_events(&self.events).filter(|track| !track.position_m.is_empty()));
        tracks.extend(self.weather.iter().flat_map(|stretches| of_weather(stretches)));
        tracks.extend(self.traffic.iter().map(|stretches| of_traffic(stretches)));
        let has_payload = self.payload_kg.is_some();
        let of_mission = of_mission(self.payload_kg.unwrap_or(0.0), &self.parts);
        tracks.extend(of_mission.filter(|track| has_payload || track.name != PAYLOAD));
        tracks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operating_cycle::road::point_event::EventKind;

    #[test]
    fn a_given_cycle_is_what_its_tracks_give() {
        let stop = EventKind::StopSign { standstill_s: 12.0 };
        let curve = |start_m, end_m, left| Curve { start_m, end_m, radius_m: 64.0, left };
        let cycle = GivenCycle {
            length_m: 1000.0,
            road_types: Some(vec![(0.0, "urban".to_owned()), (400.0, "rural".to_owned())]),
            limits: vec![(0.0, 13.9), (400.0, 22.2)],
            altitude: vec![(0.0, 0.0), (500.0, 12.0), (1000.0, 3.0)],
            curves: vec![curve(100.0, 150.0, true), curve(150.0, 220.0, false)],
            events: vec![PointEvent { position_m: 600.0, kind: stop, turns: false }],
            payload_kg: Some(900.0),
            source_log: Some("log-1".to_owned()),
            limit_source: Some("column".to_owned()),
            ..GivenCycle::default()
        };
        assert_eq!(GivenCycle::from_tracks(&cycle.tracks(), None), Ok(cycle.clone()));
        // measured curves may overlap, and reach over the end
        let overlapping = vec![curve(100.0, 160.0, true), curve(150.0, 1200.0, false)];
        let again = GivenCycle { curves: overlapping, ..cycle };
        let curves = GivenCycle::from_tracks(&again.tracks(), None).map(|cycle| cycle.curves);
        let wanted = vec![curve(100.0, 160.0, true), curve(160.0, 1000.0, false)];
        assert_eq!(curves, Ok(wanted));
    }
}
