//! A given operating cycle: a route that somebody has measured or prescribed, instead of a drawn one.
//!
//! It is read from tracks, the same that a drawn cycle is written as ([`super::tracks`]). The road comes from the file;
//! what the file lacks (roughness, ground, heading) and what varies from trip to trip (weather, traffic, payload, departure) is
//! drawn from the study, unless a route says that it keeps the file's own ([`Keep`]).
//!
//! Slopes are laid on the study's steps: the mean climb of each step, so that the altitude is exact where steps meet.
//! Where the file names no road types they follow from the speed limit: urban up to 55 km/h, motorway from 82 km/h, rural
//! between (judgement: European general limits, trucks at 80 to 90 km/h on motorways).

use super::tracks::{Rule, Track, Values};
use super::{OperatingCycle, TrafficStretch, WeatherStretch};
use crate::mission::Mission;
use crate::random::{Stream, Streams};
use crate::road::curvature::Curve;
use crate::road::point_event::{EventKind, PointEvent};
use crate::road::road_type::Section;
use crate::road::speed_sign::SpeedSign;
use crate::road::surface::{GROUNDS, Ground};
use crate::road::{Road, RoadSampler};
use crate::study::Part;
use crate::weather::{STANDARD_WEATHER, Weather};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Speed limit up to which an unnamed road is urban, in m/s.
const URBAN_UP_TO_MPS: f64 = 55.0 / 3.6;
/// Speed limit from which an unnamed road is a motorway, in m/s.
const MOTORWAY_FROM_MPS: f64 = 82.0 / 3.6;
/// Events closer than this act at one place, in m.
const SAME_PLACE_M: f64 = 1.0;
/// Curves of a larger radius are straight road, in m.
const STRAIGHT_M: f64 = 1.0e5;

/// A route of a study: a file with a given operating cycle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RouteModel {
    /// The file.
    pub file: String,
    /// How often it is driven, relative to the other routes.
    pub weight: f64,
    /// What is taken from the file instead of being drawn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub keep: Vec<Keep>,
    /// SHA-256 of the file; filled in when a study is loaded, so that a run names what it drove.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
}

/// What a route takes from its file instead of having it drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Keep {
    /// Weather.
    Weather,
    /// Traffic density.
    Traffic,
    /// Payload and departure.
    Mission,
}

impl Keep {
    /// All that can be kept.
    pub const ALL: [Self; 3] = [Self::Weather, Self::Traffic, Self::Mission];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Weather => "weather",
            Self::Traffic => "traffic",
            Self::Mission => "mission",
        }
    }
}

/// What is wrong with a given operating cycle.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GivenCycleError {
    /// No such track.
    #[error("there is no track `{track}`: {purpose}")]
    Missing {
        /// Name of the track.
        track: String,
        /// Why it is needed.
        purpose: &'static str,
    },
    /// A track of another kind.
    #[error("the values of track `{track}` are {found}, allowed are {wanted}")]
    Kind {
        /// Name of the track.
        track: String,
        /// What they are.
        found: &'static str,
        /// What they have to be.
        wanted: &'static str,
    },
    /// Positions out of order.
    #[error(
        "in track `{track}`, position {position_m} m (entry {entry}) is not above the one before it; \
         positions have to grow, from 0 m on"
    )]
    Order {
        /// Name of the track.
        track: String,
        /// Entry, from 1.
        entry: usize,
        /// Its position, in m.
        position_m: f64,
    },
    /// A value out of range.
    #[error(
        "in track `{track}`, the value at {position_m} m is {value}, allowed is {minimum} to {maximum}"
    )]
    Range {
        /// Name of the track.
        track: String,
        /// Its position, in m.
        position_m: f64,
        /// The value.
        value: f64,
        /// Smallest allowed value.
        minimum: f64,
        /// Largest allowed value.
        maximum: f64,
    },
    /// A word that means nothing here.
    #[error(
        "in track `{track}`, the value at {position_m} m is `{value}`, allowed is one of: {allowed}"
    )]
    Word {
        /// Name of the track.
        track: String,
        /// Its position, in m.
        position_m: f64,
        /// The word.
        value: String,
        /// The words that are known.
        allowed: String,
    },
    /// A road that is too short or too long.
    #[error("the road is {length_m} m long, allowed is 200 m to 5000000 m")]
    Length {
        /// Its length, in m.
        length_m: f64,
    },
}

/// A given operating cycle, checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GivenCycle {
    /// Length, in m.
    pub length_m: f64,
    /// Where road types begin, in m, and their names; none where the file has none.
    pub road_types: Option<Vec<(f64, String)>>,
    /// Where speed limits begin, in m, and the limits, in m/s.
    pub limits: Vec<(f64, f64)>,
    /// Altitude over position, linear between the points, both in m.
    pub altitude: Vec<(f64, f64)>,
    /// Curves.
    pub curves: Vec<Curve>,
    /// Roughness coefficients, in m³, from their positions on; none where the file has none.
    pub roughness: Option<Vec<(f64, f64)>>,
    /// Grounds from their positions on; none where the file has none.
    pub grounds: Option<Vec<(f64, Ground)>>,
    /// Compass heading at the start, in rad; none where the file has none.
    pub heading_rad: Option<f64>,
    /// Events, in order.
    pub events: Vec<PointEvent>,
    /// Weather; none where the file has none.
    pub weather: Option<Vec<WeatherStretch>>,
    /// Traffic; none where the file has none.
    pub traffic: Option<Vec<TrafficStretch>>,
    /// Payload, in kg; none where the file has none.
    pub payload_kg: Option<f64>,
    /// Departure, in s of the day and in days of the year; none where the file has none.
    pub departure: Option<(f64, f64)>,
}

impl GivenCycle {
    /// Reads a cycle from its tracks. `speed_limit_mps` has to be there; its length is the largest position of any track where
    /// `length_m` does not say it.
    ///
    /// # Errors
    /// [`GivenCycleError`] names the track, the place and what is allowed.
    pub fn from_tracks(tracks: &[Track], length_m: Option<f64>) -> Result<Self, GivenCycleError> {
        for track in tracks {
            check_positions(track)?;
        }
        let find = |name: &str| tracks.iter().find(|t| t.name == name && !t.position_m.is_empty());
        let last = tracks.iter().filter_map(|t| t.position_m.last()).copied();
        let length_m = length_m.unwrap_or_else(|| last.fold(0.0, f64::max));
        if !(200.0..=5.0e6).contains(&length_m) {
            return Err(GivenCycleError::Length { length_m });
        }
        let numbers = |name: &str, minimum: f64, maximum: f64| -> Result<Option<_>, _> {
            find(name).map(|track| numbers_of(track, minimum, maximum)).transpose()
        };
        let limits = numbers("speed_limit_mps", 1.0, 70.0)?.ok_or(GivenCycleError::Missing {
            track: "speed_limit_mps".to_owned(),
            purpose: "without a limit nobody knows how fast to drive",
        })?;
        let road_types = find("road_type").map(words_of).transpose()?;
        let roughness = numbers("roughness_m3", 0.0, 0.1)?;
        let grounds = find("ground").map(grounds_of).transpose()?;
        let altitude = match (numbers("grade", -0.5, 0.5)?, numbers("altitude_m", -500.0, 9000.0)?)
        {
            (Some(grades), _) => climbed(&grades, length_m),
            (None, Some(points)) => points,
            (None, None) => vec![(0.0, 0.0)],
        };
        let curvature = numbers("curvature_per_m", -0.5, 0.5)?.unwrap_or_default();
        let traffic = numbers("traffic_density_per_m", 0.0, 0.5)?.map(|points| {
            let stretch = |(start_m, density_per_m)| TrafficStretch { start_m, density_per_m };
            points.into_iter().map(stretch).collect()
        });
        let payload = numbers("payload_kg", 0.0, 1.0e5)?;
        Ok(Self {
            length_m,
            road_types,
            limits,
            altitude,
            curves: curves_of(&curvature, length_m),
            roughness,
            grounds,
            heading_rad: None,
            events: events_of(&numbers, length_m)?,
            weather: weather_of(&numbers)?,
            traffic,
            payload_kg: payload.map(|points| points[0].1),
            departure: None,
        })
    }

    /// Altitude at a position, in m.
    pub fn altitude_m(&self, position_m: f64) -> f64 {
        let k = self.altitude.partition_point(|point| point.0 <= position_m);
        let Some(&(x1, z1)) = self.altitude.get(k) else {
            return self.altitude.last().map_or(0.0, |last| last.1);
        };
        let Some(&(x0, z0)) = k.checked_sub(1).and_then(|before| self.altitude.get(before)) else {
            return z1;
        };
        z0 + (z1 - z0) * (position_m - x0) / (x1 - x0)
    }
}

/// A route of a study, laid on the study's grid of slopes and its road types.
#[derive(Clone, Debug)]
pub struct Route {
    weight: f64,
    keep: Vec<Keep>,
    sections: Vec<Section>,
    signs: Vec<SpeedSign>,
    slopes: Vec<f64>,
    /// Roughness coefficient of each block, in m³; none: drawn.
    roughness_m3: Option<Vec<f64>>,
    /// Ground of each section; none: drawn.
    grounds: Option<Vec<Ground>>,
    cycle: GivenCycle,
}

impl Route {
    /// Lays a given cycle on a study's road. `names` are the study's road types, in the order of their numbers.
    ///
    /// # Errors
    /// Of road types that the study does not have, and of what is to be kept and is not in the file.
    pub fn new(
        cycle: GivenCycle,
        weight: f64,
        keep: &[Keep],
        names: &[String],
        road: &RoadSampler,
    ) -> Result<Self, GivenCycleError> {
        let missing = |track: &str| GivenCycleError::Missing {
            track: track.to_owned(),
            purpose: "it is to be kept instead of being drawn",
        };
        if keep.contains(&Keep::Weather) && cycle.weather.is_none() {
            return Err(missing("air_temperature_k"));
        }
        if keep.contains(&Keep::Traffic) && cycle.traffic.is_none() {
            return Err(missing("traffic_density_per_m"));
        }
        if keep.contains(&Keep::Mission) && cycle.payload_kg.is_none() {
            return Err(missing("payload_kg"));
        }
        let (sections, grounds) = sections_of(&cycle, names)?;
        let signs = signs_of(&cycle, &sections);
        let (step_m, block_m) = (road.slope_step_m(), road.roughness_block_m());
        let steps = libm::ceil(cycle.length_m / step_m) as usize;
        let slopes = (0..steps).map(|k| {
            let (from_m, to_m) = (k as f64 * step_m, ((k + 1) as f64 * step_m).min(cycle.length_m));
            (cycle.altitude_m(to_m) - cycle.altitude_m(from_m)) / (to_m - from_m)
        });
        let slopes = slopes.collect();
        let roughness_m3 = cycle.roughness.as_ref().map(|points| {
            let blocks = libm::ceil(cycle.length_m / block_m) as usize;
            (0..blocks).map(|k| held(points, (k as f64 + 0.5) * block_m)).collect()
        });
        let keep = keep.to_vec();
        Ok(Self { weight, keep, sections, signs, slopes, roughness_m3, grounds, cycle })
    }

    /// How often it is driven, relative to the other routes.
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// The given cycle.
    pub fn cycle(&self) -> &GivenCycle {
        &self.cycle
    }

    /// Whether this is taken from the file.
    pub fn keeps(&self, what: Keep) -> bool {
        self.keep.contains(&what)
    }

    /// Puts what the file says of the mission in place of what was drawn.
    pub fn give_mission(&self, mission: &mut Mission) {
        mission.length_m = self.cycle.length_m;
        if self.keeps(Keep::Mission) {
            mission.payload_kg = self.cycle.payload_kg.unwrap_or(mission.payload_kg);
            if let Some((second, day)) = self.cycle.departure {
                (mission.departure_s, mission.day_of_year) = (second, day);
            }
        }
        let own = |e: &PointEvent| matches!(e.kind, EventKind::MissionStop { .. });
        if self.cycle.events.iter().any(own) {
            mission.stops.clear();
        }
    }

    /// Lays the road down; what the file lacks is drawn, and the parts in `without` are left out.
    pub fn lay(
        &self,
        sampler: &RoadSampler,
        mission_stops: &[PointEvent],
        streams: &Streams,
        without: &[Part],
        road: &mut Road,
    ) {
        let has = |part| !without.contains(&part);
        road.length_m = self.cycle.length_m;
        road.slope_step_m = sampler.slope_step_m();
        road.roughness_block_m = sampler.roughness_block_m();
        road.sections.clone_from(&self.sections);
        road.signs.clone_from(&self.signs);
        road.curves.clear();
        if has(Part::Curves) {
            road.curves.extend_from_slice(&self.cycle.curves);
        }
        road.slopes.clone_from(&self.slopes);
        if !has(Part::Slope) {
            road.slopes.fill(0.0);
        }
        match &self.roughness_m3 {
            Some(blocks) => road.roughness_m3.clone_from(blocks),
            None => sampler.sample_roughness(streams, road),
        }
        match &self.grounds {
            Some(grounds) => road.grounds.clone_from(grounds),
            None => sampler.sample_grounds(streams, road),
        }
        road.heading_rad = self
            .cycle
            .heading_rad
            .unwrap_or_else(|| std::f64::consts::TAU * streams.open(Stream::Heading).uniform());
        road.climb_reached = true;
        let events = self.cycle.events.iter().filter(|event| match event.kind {
            EventKind::StopSign { .. } => has(Part::StopSigns),
            EventKind::GiveWayStop { .. } | EventKind::GiveWayPass { .. } => has(Part::GiveWays),
            EventKind::RedLight { .. } | EventKind::GreenLight => has(Part::TrafficLights),
            EventKind::SpeedBump { .. } => has(Part::SpeedBumps),
            EventKind::MissionStop { .. } => true,
        });
        road.events.clear();
        road.events.extend(events);
        road.events.extend_from_slice(mission_stops);
        merge_events(&mut road.events);
    }

    /// Puts the file's weather and traffic in place of what was drawn, where they are kept.
    pub fn give_clock(&self, cycle: &mut OperatingCycle) {
        if self.keeps(Keep::Weather)
            && let Some(weather) = &self.cycle.weather
        {
            cycle.weather.clone_from(weather);
        }
        if self.keeps(Keep::Traffic)
            && let Some(traffic) = &self.cycle.traffic
        {
            cycle.traffic.clone_from(traffic);
        }
    }
}

/// Chooses a route by its weight.
pub fn choose<'a>(routes: &'a [Route], streams: &Streams) -> Option<&'a Route> {
    match routes {
        [] => None,
        [only] => Some(only),
        several => {
            let weights: Vec<f64> = several.iter().map(Route::weight).collect();
            several.get(streams.open(Stream::Route).index(&weights))
        }
    }
}

fn check_positions(track: &Track) -> Result<(), GivenCycleError> {
    let mut before = -1.0;
    for (k, position_m) in track.position_m.iter().enumerate() {
        let rises = *position_m > before || (track.rule == Rule::Event && *position_m >= before);
        if !(rises && *position_m >= 0.0 && position_m.is_finite()) {
            let (track, entry) = (track.name.to_owned(), k + 1);
            return Err(GivenCycleError::Order { track, entry, position_m: *position_m });
        }
        before = *position_m;
    }
    Ok(())
}

fn numbers_of(
    track: &Track,
    minimum: f64,
    maximum: f64,
) -> Result<Vec<(f64, f64)>, GivenCycleError> {
    let Values::Numbers(values) = &track.value else {
        let (found, wanted) = ("words", "numbers");
        return Err(GivenCycleError::Kind { track: track.name.to_owned(), found, wanted });
    };
    let points = track.position_m.iter().copied().zip(values.iter().copied());
    for (position_m, value) in points.clone() {
        if !(value >= minimum && value <= maximum) {
            let track = track.name.to_owned();
            return Err(GivenCycleError::Range { track, position_m, value, minimum, maximum });
        }
    }
    Ok(points.collect())
}

fn words_of(track: &Track) -> Result<Vec<(f64, String)>, GivenCycleError> {
    let Values::Names(names) = &track.value else {
        let (found, wanted) = ("numbers", "words");
        return Err(GivenCycleError::Kind { track: track.name.to_owned(), found, wanted });
    };
    Ok(track.position_m.iter().copied().zip(names.iter().cloned()).collect())
}

fn grounds_of(track: &Track) -> Result<Vec<(f64, Ground)>, GivenCycleError> {
    let parse = |(position_m, value): (f64, String)| {
        let ground = GROUNDS.into_iter().find(|ground| ground.name() == value);
        ground.map(|ground| (position_m, ground)).ok_or_else(|| GivenCycleError::Word {
            track: track.name.to_owned(),
            position_m,
            value,
            allowed: GROUNDS.map(Ground::name).join(", "),
        })
    };
    words_of(track)?.into_iter().map(parse).collect()
}

/// The altitude that slopes (climb per metre of road) add up to.
fn climbed(grades: &[(f64, f64)], length_m: f64) -> Vec<(f64, f64)> {
    let mut points = Vec::with_capacity(grades.len() + 1);
    let mut altitude_m = 0.0;
    for (k, (from_m, grade)) in grades.iter().enumerate() {
        points.push((*from_m, altitude_m));
        let to_m = grades.get(k + 1).map_or(length_m, |next| next.0);
        altitude_m += grade * (to_m - from_m);
    }
    if points.last().is_some_and(|last| last.0 < length_m) {
        points.push((length_m, altitude_m));
    }
    points
}

/// A curve for each stretch of constant curvature.
fn curves_of(curvature: &[(f64, f64)], length_m: f64) -> Vec<Curve> {
    let mut curves = Vec::new();
    for (k, (start_m, curvature_per_m)) in curvature.iter().enumerate() {
        let end_m = curvature.get(k + 1).map_or(length_m, |next| next.0).min(length_m);
        let radius_m = 1.0 / curvature_per_m.abs();
        if radius_m < STRAIGHT_M && *start_m < end_m {
            let (start_m, left) = (*start_m, *curvature_per_m > 0.0);
            curves.push(Curve { start_m, end_m, radius_m, left });
        }
    }
    curves
}

/// Reads one track as numbers within a range.
type Numbers<'a> = dyn Fn(&str, f64, f64) -> Result<Option<Vec<(f64, f64)>>, GivenCycleError> + 'a;

fn events_of(numbers: &Numbers, length_m: f64) -> Result<Vec<PointEvent>, GivenCycleError> {
    let mut events = Vec::new();
    let mut add = |name: &str,
                   (minimum, maximum): (f64, f64),
                   kind: &dyn Fn(f64) -> EventKind|
     -> Result<(), GivenCycleError> {
        for (position_m, value) in numbers(name, minimum, maximum)?.unwrap_or_default() {
            // a truck starts and ends at rest
            if position_m > 0.0 && position_m < length_m {
                events.push(PointEvent { position_m, kind: kind(value), turns: false });
            }
        }
        Ok(())
    };
    let wait = (0.0, 172_800.0);
    add("stop_sign_s", wait, &|standstill_s| EventKind::StopSign { standstill_s })?;
    add("give_way_stop_s", wait, &|standstill_s| EventKind::GiveWayStop { standstill_s })?;
    add("give_way_pass_mps", (1.0, 40.0), &|speed_mps| EventKind::GiveWayPass { speed_mps })?;
    add("red_light_s", wait, &|standstill_s| EventKind::RedLight { standstill_s })?;
    add("green_light", (0.0, 1.0), &|_| EventKind::GreenLight)?;
    add("mission_stop_s", wait, &|standstill_s| EventKind::MissionStop { standstill_s })?;
    let lengths = numbers("speed_bump_length_m", 0.1, 50.0)?.unwrap_or_default();
    let heights = numbers("speed_bump_height_m", 0.005, 0.5)?.unwrap_or_default();
    for (position_m, length_m) in lengths {
        let height = heights.iter().find(|height| height.0 == position_m);
        let (_, height_m) = *height.ok_or_else(|| GivenCycleError::Missing {
            track: "speed_bump_height_m".to_owned(),
            purpose: "each speed bump has a length and, at the same position, a height",
        })?;
        let kind = EventKind::SpeedBump { length_m, height_m };
        events.push(PointEvent { position_m, kind, turns: false });
    }
    merge_events(&mut events);
    Ok(events)
}

/// Puts events in order; of two at one place the standstills add up, the lower speed holds.
fn merge_events(events: &mut Vec<PointEvent>) {
    events.sort_by(|a, b| a.position_m.total_cmp(&b.position_m));
    let mut kept: Vec<PointEvent> = Vec::with_capacity(events.len());
    for event in events.drain(..) {
        let before = kept.last_mut().filter(|b| event.position_m - b.position_m < SAME_PLACE_M);
        let Some(before) = before else {
            kept.push(event);
            continue;
        };
        match (before.kind.standstill_s(), event.kind.standstill_s()) {
            (Some(a), Some(b)) => {
                let standstill_s = a + b;
                let mission = |kind| matches!(kind, EventKind::MissionStop { .. });
                before.kind = if mission(before.kind) || mission(event.kind) {
                    EventKind::MissionStop { standstill_s }
                } else {
                    EventKind::StopSign { standstill_s }
                };
            }
            (None, Some(_)) => before.kind = event.kind,
            // a light or a bump at a stop line does nothing more; of two slow places the second has little left to do
            (_, None) => {}
        }
    }
    *events = kept;
}

fn weather_of(numbers: &Numbers) -> Result<Option<Vec<WeatherStretch>>, GivenCycleError> {
    let temperature = numbers("air_temperature_k", 200.0, 340.0)?;
    let Some(temperature) = temperature else { return Ok(None) };
    let standard = STANDARD_WEATHER;
    let all = |points: Option<Vec<(f64, f64)>>, value: f64| points.unwrap_or(vec![(0.0, value)]);
    let pressure = all(numbers("air_pressure_pa", 4.0e4, 1.2e5)?, standard.pressure_pa);
    let humidity = all(numbers("relative_humidity", 0.0, 1.0)?, standard.relative_humidity);
    let rain = all(numbers("precipitation_mps", 0.0, 1.0e-3)?, 0.0);
    let snow = all(numbers("snow", 0.0, 1.0)?, 0.0);
    let wind = all(numbers("wind_speed_mps", 0.0, 60.0)?, 0.0);
    let direction = all(numbers("wind_direction_rad", -6.3, 6.3)?, 0.0);
    let tracks = [&temperature, &pressure, &humidity, &rain, &snow, &wind, &direction];
    let mut starts: Vec<f64> = tracks.iter().flat_map(|t| t.iter().map(|p| p.0)).collect();
    starts.sort_by(f64::total_cmp);
    starts.dedup();
    if let Some(first) = starts.first_mut() {
        *first = 0.0;
    }
    let stretch = |start_m: f64| WeatherStretch {
        start_m,
        weather: Weather {
            temperature_k: held(&temperature, start_m),
            pressure_pa: held(&pressure, start_m),
            relative_humidity: held(&humidity, start_m),
            precipitation_mps: held(&rain, start_m),
            snow: held(&snow, start_m) > 0.5,
            wind_speed_mps: held(&wind, start_m),
            wind_direction_rad: held(&direction, start_m),
        },
    };
    Ok(Some(starts.into_iter().map(stretch).collect()))
}

/// The value that holds at a position; before the first point, the first one.
fn held<T: Copy>(points: &[(f64, T)], position_m: f64) -> T {
    let k = points.partition_point(|point| point.0 <= position_m);
    points[k.saturating_sub(1)].1
}

/// Sections of one road type and one ground each.
fn sections_of(
    cycle: &GivenCycle,
    names: &[String],
) -> Result<(Vec<Section>, Option<Vec<Ground>>), GivenCycleError> {
    let types = match &cycle.road_types {
        Some(types) => types.clone(),
        None if names.len() == 1 => vec![(0.0, names[0].clone())],
        None => cycle.limits.iter().map(|(x, v)| (*x, type_by_limit(*v).to_owned())).collect(),
    };
    let mut numbered: Vec<(f64, usize)> = Vec::with_capacity(types.len());
    for (position_m, name) in types {
        let number = names.iter().position(|have| *have == name);
        let number = number.ok_or_else(|| GivenCycleError::Word {
            track: "road_type".to_owned(),
            position_m,
            value: name,
            allowed: names.join(", "),
        })?;
        // limits that change within a road type begin no section
        if cycle.road_types.is_some() || numbered.last().is_none_or(|last| last.1 != number) {
            numbered.push((position_m, number));
        }
    }
    let grounds = cycle.grounds.as_deref().unwrap_or_default();
    let mut starts: Vec<f64> =
        numbered.iter().map(|p| p.0).chain(grounds.iter().map(|p| p.0)).collect();
    starts.retain(|start_m| *start_m > 0.0 && *start_m < cycle.length_m);
    starts.push(0.0);
    starts.sort_by(f64::total_cmp);
    starts.dedup();
    let end_of = |k: usize| starts.get(k + 1).copied().unwrap_or(cycle.length_m);
    let section = |(k, start_m): (usize, &f64)| Section {
        start_m: *start_m,
        end_m: end_of(k),
        road_type: held(&numbered, *start_m),
    };
    let sections: Vec<Section> = starts.iter().enumerate().map(section).collect();
    let grounds = (!grounds.is_empty())
        .then(|| sections.iter().map(|section| held(grounds, section.start_m)).collect());
    Ok((sections, grounds))
}

/// The road type of a limit.
pub(crate) fn type_by_limit(limit_mps: f64) -> &'static str {
    if limit_mps <= URBAN_UP_TO_MPS {
        "urban"
    } else if limit_mps < MOTORWAY_FROM_MPS {
        "rural"
    } else {
        "motorway"
    }
}

/// A sign at each limit, and one where a section begins: there the free-flow clock looks for the road type.
fn signs_of(cycle: &GivenCycle, sections: &[Section]) -> Vec<SpeedSign> {
    let mut starts: Vec<f64> = cycle.limits.iter().map(|limit| limit.0).collect();
    starts.extend(sections.iter().map(|section| section.start_m));
    starts.retain(|start_m| *start_m < cycle.length_m);
    starts.sort_by(f64::total_cmp);
    starts.dedup();
    let sign = |start_m| SpeedSign { start_m, speed_mps: held(&cycle.limits, start_m) };
    starts.into_iter().map(sign).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(name: &'static str, rule: Rule, points: &[(f64, f64)]) -> Track {
        let (position_m, value) = points.iter().copied().unzip();
        Track { name, rule, position_m, value: Values::Numbers(value) }
    }

    fn limit() -> Track {
        track("speed_limit_mps", Rule::Constant, &[(0.0, 13.9), (500.0, 22.2)])
    }

    #[test]
    fn grades_and_altitudes_agree() {
        let grades = track("grade", Rule::Constant, &[(0.0, 0.02), (300.0, -0.01)]);
        let points = [(0.0, 100.0), (300.0, 106.0), (1000.0, 99.0)];
        let altitudes = track("altitude_m", Rule::Linear, &points);
        let a = GivenCycle::from_tracks(&[limit(), grades], Some(1000.0)).unwrap();
        let b = GivenCycle::from_tracks(&[limit(), altitudes], None).unwrap();
        for x in [0.0, 10.0, 299.0, 300.0, 301.0, 999.0, 1000.0] {
            assert!((b.altitude_m(x) - 100.0 - a.altitude_m(x)).abs() < 1e-9, "{x}");
        }
        assert_eq!((a.length_m, b.length_m), (1000.0, 1000.0));
    }

    #[test]
    fn curvature_becomes_curves_and_events_at_one_place_merge() {
        let curvature =
            track("curvature_per_m", Rule::Constant, &[(0.0, 0.0), (100.0, -0.01), (150.0, 0.0)]);
        let stops = track("stop_sign_s", Rule::Event, &[(400.0, 5.0), (400.5, 7.0)]);
        let cycle = GivenCycle::from_tracks(&[limit(), curvature, stops], Some(1000.0)).unwrap();
        let curve = Curve { start_m: 100.0, end_m: 150.0, radius_m: 100.0, left: false };
        assert_eq!(cycle.curves, [curve]);
        assert_eq!(cycle.events.len(), 1);
        assert_eq!(cycle.events[0].kind.standstill_s(), Some(12.0));
    }

    #[test]
    fn what_is_wrong_is_named() {
        let wrong = |tracks: &[Track]| GivenCycle::from_tracks(tracks, None).unwrap_err();
        assert!(wrong(&[]).to_string().contains("0 m long"));
        let falling = track("grade", Rule::Constant, &[(0.0, 0.0), (50.0, 0.0), (40.0, 0.0)]);
        let text = wrong(&[limit(), falling]).to_string();
        assert!(text.contains("`grade`") && text.contains("entry 3"), "{text}");
        let steep = track("grade", Rule::Constant, &[(0.0, 0.0), (50.0, 2.0)]);
        let text = wrong(&[limit(), steep]).to_string();
        assert!(text.contains("50 m is 2, allowed is -0.5 to 0.5"), "{text}");
        let nan = track("grade", Rule::Constant, &[(0.0, f64::NAN)]);
        assert!(wrong(&[limit(), nan]).to_string().contains("NaN"));
        let text =
            wrong(&[track("grade", Rule::Constant, &[(0.0, 0.0), (900.0, 0.0)])]).to_string();
        assert!(text.contains("speed_limit_mps"), "{text}");
    }
}
