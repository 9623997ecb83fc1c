//! A given operating cycle: a route that was measured or prescribed, instead of a drawn one.
//!
//! It is read from tracks, the same that a drawn cycle is written as ([`super::tracks`]). The road
//! comes from the file; what the file lacks (roughness, ground, heading) and what varies from trip
//! to trip (weather, traffic, payload, departure) is drawn from the study, unless a route says that
//! it keeps the file's own ([`super::route`]).

pub use super::given_error::GivenCycleError;
use super::mission_part::{MOST_POWER_W, MissionPart, PAYLOAD, POWER_TAKE_OFF, parts_of};
use super::tracks::{LIMIT_SOURCE, Rule, SOURCE_LOG, Track, Values};
use super::{TrafficStretch, WeatherStretch};
use crate::operating_cycle::road::curvature::Curve;
use crate::operating_cycle::road::point_event::{EventKind, KINDS, Passage, PointEvent};
use crate::operating_cycle::road::surface::{GROUNDS, Ground};
use crate::operating_cycle::weather::{STANDARD_WEATHER, Weather};

/// Events closer than this act at one place, in m.
pub(super) const SAME_PLACE_M: f64 = 1.0;
/// Two slow places at one place are so far apart, in m: each begins a segment.
const APART_M: f64 = 0.01;
/// Steepest road, as climb per metre.
pub(super) const STEEPEST: f64 = 0.5;
/// Curves of a larger radius are straight road, in m.
const STRAIGHT_M: f64 = 1.0e5;

/// A given operating cycle, checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GivenCycle {
    /// Length, in m.
    pub length_m: f64,
    /// Where road types begin, in m, and their names; none where the file has none.
    pub road_types: Option<Vec<(f64, String)>>,
    /// Where speed limits begin, in m, and the limits, in m/s; empty where they have to be drawn.
    pub limits: Vec<(f64, f64)>,
    /// Altitude over position, linear between the points, both in m.
    pub altitude: Vec<(f64, f64)>,
    /// Whether the climb is that of slopes, which are known everywhere, and not of altitudes.
    pub has_slopes: bool,
    /// Curves.
    pub curves: Vec<Curve>,
    /// Whether the file says nothing of curves.
    pub lacks_curves: bool,
    /// Roughness coefficients, in m³, from their positions on; none where the file has none.
    pub roughness: Option<Vec<(f64, f64)>>,
    /// Grounds from their positions on; none where the file has none.
    pub grounds: Option<Vec<(f64, Ground)>>,
    /// Compass heading at the start, in rad; none where the file has none.
    pub heading_rad: Option<f64>,
    /// Events, in order.
    pub events: Vec<PointEvent>,
    /// Places of which it is known what stands there, by its name as an object of a map, and not
    /// what happens.
    pub open_places: Vec<(f64, &'static str)>,
    /// Weather; none where the file has none.
    pub weather: Option<Vec<WeatherStretch>>,
    /// Traffic; none where the file has none.
    pub traffic: Option<Vec<TrafficStretch>>,
    /// Payload at departure, in kg; none where the file has none.
    pub payload_kg: Option<f64>,
    /// Parts of the mission behind its stops; none where nothing changes there.
    pub parts: Vec<MissionPart>,
    /// Departure, in s of the day and in days of the year; none where the file has none.
    pub departure: Option<(f64, f64)>,
    /// Departure of a stop plan; none where there is no plan.
    pub planned: Option<PlannedMission>,
    /// The log from which the road was made; none where it was not.
    pub source_log: Option<String>,
    /// Where the limits of such a road come from.
    pub limit_source: Option<String>,
    /// How much the points scattered from which it was made.
    pub noise: PointNoise,
}

/// Departure of a stop plan. It holds without being kept, and so does the plan's payload.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlannedMission {
    /// Departure, in s of the day; none: drawn from the study.
    pub departure_s: Option<f64>,
    /// Day of the year, from 0; none: drawn from the study.
    pub day_of_year: Option<f64>,
}

/// How much the points of a route scatter, in m; 0 where it is not made of points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointNoise {
    /// Across the road.
    pub positions_m: f64,
    /// In height.
    pub altitudes_m: f64,
}

impl GivenCycle {
    /// Reads a cycle from its tracks. `speed_limit_mps` has to be there; its length is the largest
    /// position of any track where `length_m` does not say it.
    ///
    /// # Errors
    /// [`GivenCycleError`] names the track, the place and what is allowed.
    pub fn from_tracks(tracks: &[Track], length_m: Option<f64>) -> Result<Self, GivenCycleError> {
        let cycle = Self::from_partial_tracks(tracks, length_m)?;
        if cycle.limits.is_empty() { Err(GivenCycleError::no_limits()) } else { Ok(cycle) }
    }

    /// As [`Self::from_tracks`], of a road whose limits may have to be drawn.
    ///
    /// # Errors
    /// As [`Self::from_tracks`].
    pub fn from_partial_tracks(
        tracks: &[Track],
        length_m: Option<f64>,
    ) -> Result<Self, GivenCycleError> {
        for (k, track) in tracks.iter().enumerate() {
            if tracks[..k].iter().any(|other| other.name == track.name) {
                return Err(GivenCycleError::Twice { track: track.name.to_owned() });
            }
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
        let limits = numbers("speed_limit_mps", 1.0, 70.0)?.unwrap_or_default();
        let road_types = find("road_type").map(words_of).transpose()?;
        let roughness = numbers("roughness_m3", 0.0, 0.1)?;
        let grounds = find("ground").map(grounds_of).transpose()?;
        let grades = numbers("grade", -STEEPEST, STEEPEST)?;
        let has_slopes = grades.is_some();
        // beside slopes altitudes tell nothing more, and those of a drawn road begin at 0
        let altitude = match grades {
            Some(grades) => climbed(&grades, length_m),
            None => numbers("altitude_m", -500.0, 9000.0)?.unwrap_or(vec![(0.0, 0.0)]),
        };
        let curvature = numbers("curvature_per_m", -0.5, 0.5)?;
        let lacks_curves = curvature.is_none();
        let curvature = curvature.unwrap_or_default();
        let traffic = numbers("traffic_density_per_m", 0.0, 0.5)?.map(|points| {
            let stretch = |(start_m, density_per_m)| TrafficStretch { start_m, density_per_m };
            points.into_iter().map(stretch).collect()
        });
        let payload = numbers(PAYLOAD, 0.0, 1.0e5)?;
        let [power, duration] = POWER_TAKE_OFF;
        let power = numbers(power, 0.0, MOST_POWER_W)?.unwrap_or_default();
        let duration = numbers(duration, 0.0, 86_400.0)?.unwrap_or_default();
        let events = events_of(&numbers, length_m)?;
        let points = payload.as_deref().unwrap_or_default();
        let parts = parts_of(&events, points, [&power, &duration])
            .map_err(|(track, position_m)| GivenCycleError::NoMissionStop { track, position_m })?;
        let word = |name: &str| {
            let words = find(name).map(words_of).transpose()?;
            Ok(words.and_then(|words| words.into_iter().next()).map(|first| first.1))
        };
        Ok(Self {
            length_m,
            road_types,
            limits,
            altitude,
            has_slopes,
            curves: curves_of(&curvature, length_m),
            lacks_curves,
            roughness,
            grounds,
            heading_rad: None,
            events,
            open_places: Vec::new(),
            weather: weather_of(&numbers)?,
            traffic,
            payload_kg: payload.map(|points| points[0].1),
            parts,
            departure: None,
            planned: None,
            source_log: word(SOURCE_LOG)?,
            limit_source: word(LIMIT_SOURCE)?,
            noise: PointNoise::default(),
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

fn check_positions(track: &Track) -> Result<(), GivenCycleError> {
    let positions = track.position_m.len();
    let values = match &track.value {
        Values::Numbers(numbers) => numbers.len(),
        Values::Names(names) => names.len(),
    };
    if positions != values {
        let track = track.name.to_owned();
        return Err(GivenCycleError::Lengths { track, positions, values });
    }
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
    for form in KINDS.iter().flat_map(|kind| kind.forms) {
        let mut tracks = Vec::with_capacity(form.tracks.len());
        for track in form.tracks {
            let [minimum, maximum] = track.range;
            tracks.push(numbers(track.name, minimum, maximum)?.unwrap_or_default());
        }
        for &(position_m, first) in &tracks[0] {
            let mut values = vec![first];
            for (track, points) in form.tracks.iter().zip(&tracks).skip(1) {
                let point = points.iter().find(|point| point.0 == position_m);
                let (_, value) = *point.ok_or_else(|| GivenCycleError::Missing {
                    track: track.name.to_owned(),
                    purpose: form.purpose,
                })?;
                values.push(value);
            }
            // a vehicle starts and ends at rest
            if position_m > 0.0 && position_m < length_m {
                events.push(PointEvent { position_m, kind: (form.event)(&values), turns: false });
            }
        }
    }
    merge_events(&mut events);
    Ok(events)
}

/// Puts events in order; of two at one place the standstills add up, and of two without a
/// standstill both speeds hold.
pub(super) fn merge_events(events: &mut Vec<PointEvent>) {
    events.sort_by(|a, b| a.position_m.total_cmp(&b.position_m));
    let mut kept: Vec<PointEvent> = Vec::with_capacity(events.len());
    for event in events.drain(..) {
        let before = kept.last_mut().filter(|b| event.position_m - b.position_m < SAME_PLACE_M);
        let Some(before) = before else {
            kept.push(event);
            continue;
        };
        // a green light is passed as if it were not there
        if event.kind.passage() == Passage::Free {
            continue;
        }
        if before.kind.passage() == Passage::Free {
            *before = event;
            continue;
        }
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
            // a slow place at a stop line does nothing more
            (Some(_), None) => {}
            (None, None) => {
                let position_m = event.position_m.max(before.position_m + APART_M);
                kept.push(PointEvent { position_m, ..event });
            }
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
pub(super) fn held<T: Copy>(points: &[(f64, T)], position_m: f64) -> T {
    let k = points.partition_point(|point| point.0 <= position_m);
    points[k.saturating_sub(1)].1
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
        assert!(a.has_slopes && !b.has_slopes);
        // a drawn road of 300 km may end far below its start
        let below = track("altitude_m", Rule::Linear, &[(0.0, 0.0), (1000.0, -900.0)]);
        let grades = track("grade", Rule::Constant, &[(0.0, 0.02), (300.0, -0.01)]);
        let both = GivenCycle::from_tracks(&[limit(), grades, below.clone()], None).unwrap();
        assert_eq!(both.altitude, a.altitude);
        assert!(GivenCycle::from_tracks(&[limit(), below], None).is_err());
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
    fn a_slow_place_beside_another_event_stays_slow() {
        let track = |name, value| track(name, Rule::Event, &[(500.0, value)]);
        let bump = [track("speed_bump_length_m", 4.0), track("speed_bump_height_m", 0.1)];
        let kinds = |other: Track| -> Vec<EventKind> {
            let tracks = [vec![limit(), other], bump.to_vec()].concat();
            let cycle = GivenCycle::from_tracks(&tracks, Some(1000.0)).unwrap();
            assert!(cycle.events.windows(2).all(|pair| pair[1].position_m > pair[0].position_m));
            cycle.events.iter().map(|event| event.kind).collect()
        };
        let bump_kind = EventKind::SpeedBump { length_m: 4.0, height_m: 0.1 };
        assert_eq!(kinds(track("green_light", 1.0)), [bump_kind]);
        let pass = EventKind::GiveWayPass { speed_mps: 12.0 };
        assert_eq!(kinds(track("give_way_pass_mps", 12.0)), [pass, bump_kind]);
        let stop = EventKind::StopSign { standstill_s: 9.0 };
        assert_eq!(kinds(track("stop_sign_s", 9.0)), [stop]);
    }

    #[test]
    fn events_at_the_ends_of_the_road_and_beyond_are_dropped() {
        let places: [f64; 4] = [0.0, 500.0, 1000.0, 1500.0];
        let at = |name, value: f64| track(name, Rule::Event, &places.map(|x| (x, value)));
        for tracks in [
            vec![at("speed_bump_length_m", 4.0), at("speed_bump_height_m", 0.1)],
            vec![at("stop_sign_s", 5.0)],
        ] {
            let cycle = GivenCycle::from_tracks(&[vec![limit()], tracks].concat(), Some(1000.0));
            let events = cycle.unwrap().events;
            assert_eq!(events.iter().map(|event| event.position_m).collect::<Vec<_>>(), [500.0]);
        }
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
        let text = wrong(&[limit(), limit()]).to_string();
        assert!(text.contains("two tracks `speed_limit_mps`"), "{text}");
        let mut short = limit();
        short.position_m.push(900.0);
        let text = wrong(&[short]).to_string();
        assert!(text.contains("`speed_limit_mps` has 3 positions and 2 values"), "{text}");
        let text =
            wrong(&[track("grade", Rule::Constant, &[(0.0, 0.0), (900.0, 0.0)])]).to_string();
        assert!(text.contains("speed_limit_mps"), "{text}");
    }
}
