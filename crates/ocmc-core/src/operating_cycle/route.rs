//! The routes of a study: given operating cycles on the study's grid and road types, and what is
//! drawn where a file says nothing.
//!
//! Slopes are laid on the study's steps: the mean climb of each step, so that the altitude is exact
//! where steps meet. Where the file names no road types they follow from the speed limit: urban up
//! to 55 km/h, motorway from 82 km/h, rural between (judgement: European general limits, trucks at
//! 80 to 90 km/h on motorways).

use super::OperatingCycle;
use super::drawn_part::{Draw, DrawnParts, grounds_of, signs_of};
use super::given::{GivenCycle, GivenCycleError, STEEPEST, held, merge_events};
use crate::operating_cycle::mission::Mission;
use crate::operating_cycle::road::point_event::{EventKind, KINDS, PointEvent, is_left_out};
use crate::operating_cycle::road::road_type::Section;
use crate::operating_cycle::road::speed_sign::SpeedSign;
use crate::operating_cycle::road::surface::Ground;
use crate::operating_cycle::road::{Road, RoadSampler};
use crate::random::{Stream, Streams};
use crate::switch::ModelSwitch;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Speed limit up to which an unnamed road is urban, in m/s.
const URBAN_UP_TO_MPS: f64 = 55.0 / 3.6;
/// Speed limit from which an unnamed road is a motorway, in m/s.
const MOTORWAY_FROM_MPS: f64 = 82.0 / 3.6;

/// A route of a study: a file with a given operating cycle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RouteModel {
    /// A file, relative to the folder of the study.
    pub file: String,
    /// How often it is driven, relative to the other routes.
    #[schemars(range(min = 1.0e-6, max = 1.0e6))]
    pub weight: f64,
    /// Parts that are taken from the file instead of being drawn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub keep: Vec<Keep>,
    /// Parts that are drawn from the study where the file lacks them, instead of being absent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub draw: Vec<Draw>,
    /// Columns of its table: name of a quantity with its unit, and the column.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub columns: BTreeMap<String, String>,
    /// SHA-256 of the file; a run fills it in, and a file with another one is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
    /// A stop plan that is driven on it, as a file: places, dwells, loads and departure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop_plan: Option<String>,
    /// SHA-256 of the stop plan, likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop_plan_sha256: Option<String>,
    /// Content of the file, in CSV, where it is a table that a Python program gave.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<String>,
}

/// Parts that a route takes from its file instead of having them drawn.
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

/// A route of a study, laid on the study's grid of slopes and its road types.
#[derive(Clone, Debug)]
pub struct Route {
    weight: f64,
    keep: Vec<Keep>,
    /// Parts that it lacks and has drawn; none where it has all.
    drawn: Option<DrawnParts>,
    /// Stretches of road types; empty where they are drawn.
    sections: Vec<Section>,
    signs: Vec<SpeedSign>,
    slopes: Vec<f64>,
    /// Roughness coefficient of each block, in m³; none: drawn.
    roughness_m3: Option<Vec<f64>>,
    /// Ground of each section; none: drawn.
    grounds: Option<Vec<Ground>>,
    pub(super) cycle: GivenCycle,
}

impl Route {
    /// Stretches of one sign and one road type that are both known: their length, in m, the sign's
    /// speed, in m/s, and the number of the type.
    pub(super) fn signed_stretches(&self) -> impl Iterator<Item = (f64, f64, usize)> {
        let ends_m = self.signs.iter().skip(1).map(|sign| sign.start_m);
        let ends_m = ends_m.chain(self.sections.last().map(|section| section.end_m));
        self.signs.iter().zip(ends_m).flat_map(|(sign, end_m)| {
            self.sections.iter().filter_map(move |section| {
                let way_m = end_m.min(section.end_m) - sign.start_m.max(section.start_m);
                (way_m > 0.0).then_some((way_m, sign.speed_mps, section.road_type))
            })
        })
    }

    /// Lays a given cycle on a study's road. `names` are the study's road types, in the order of
    /// their numbers.
    ///
    /// # Errors
    /// Of road types that the study does not have, of what is to be kept and is not in the file, of
    /// what it needs, lacks and does not have drawn, and of altitudes that no road climbs.
    pub fn new(
        cycle: GivenCycle,
        weight: f64,
        keep: &[Keep],
        draw: &[Draw],
        names: &[String],
        road: &RoadSampler,
    ) -> Result<Self, GivenCycleError> {
        for (what, track, given) in [
            (Keep::Weather, "air_temperature_k", cycle.weather.is_some()),
            (Keep::Traffic, "traffic_density_per_m", cycle.traffic.is_some()),
            (Keep::Mission, "payload_kg", cycle.payload_kg.is_some() || cycle.planned.is_some()),
        ] {
            if keep.contains(&what) && !given {
                let purpose = "it is to be kept instead of being drawn";
                return Err(GivenCycleError::Missing { track: track.to_owned(), purpose });
            }
        }
        if cycle.limits.is_empty() && !draw.contains(&Draw::Limits) {
            return Err(GivenCycleError::no_limits());
        }
        for &(position_m, object) in &cycle.open_places {
            let can = KINDS.iter().any(|kind| kind.map_object == object && kind.model.is_some());
            if !(can && draw.contains(&Draw::Stops)) {
                let or_draw = if can { ", or have it drawn, `--draw stops`" } else { "" };
                return Err(GivenCycleError::OpenPlace { object, position_m, or_draw });
            }
        }
        let drawn = DrawnParts::of(&cycle, draw, road);
        let (sections, grounds) = match &drawn {
            Some(drawn) if drawn.draws_types() => (Vec::new(), None),
            _ => sections_of(&cycle, names)?,
        };
        let signs = if cycle.limits.is_empty() { Vec::new() } else { signs_of(&cycle, &sections) };
        let (step_m, block_m) = (road.slope_step_m(), road.roughness_block_m());
        let steps = libm::ceil(cycle.length_m / step_m) as usize;
        let slopes = (0..steps).map(|k| {
            let (from_m, to_m) = (k as f64 * step_m, ((k + 1) as f64 * step_m).min(cycle.length_m));
            (cycle.altitude_m(to_m) - cycle.altitude_m(from_m)) / (to_m - from_m)
        });
        let slopes: Vec<f64> = slopes.collect();
        if let Some(k) = slopes.iter().position(|slope| slope.abs() > STEEPEST) {
            return Err(GivenCycleError::Range {
                track: "altitude_m, as climb per metre".to_owned(),
                position_m: k as f64 * step_m,
                value: slopes[k],
                minimum: -STEEPEST,
                maximum: STEEPEST,
            });
        }
        let roughness_m3 = cycle.roughness.as_ref().map(|points| {
            let blocks = libm::ceil(cycle.length_m / block_m) as usize;
            (0..blocks).map(|k| held(points, (k as f64 + 0.5) * block_m)).collect()
        });
        let keep = keep.to_vec();
        Ok(Self { weight, keep, drawn, sections, signs, slopes, roughness_m3, grounds, cycle })
    }

    /// Whether payload and departure are those of the file.
    pub(super) fn keeps_mission(&self) -> bool {
        self.keep.contains(&Keep::Mission) || self.cycle.planned.is_some()
    }

    /// Puts what the file says of the mission in place of what was drawn.
    pub fn give_mission(&self, mission: &mut Mission) {
        mission.length_m = self.cycle.length_m;
        if self.keeps_mission() {
            mission.payload_kg = self.cycle.payload_kg.unwrap_or(mission.payload_kg);
            if let Some((second, day)) = self.cycle.departure {
                (mission.departure_s, mission.day_of_year) = (second, day);
            }
            if let Some(planned) = self.cycle.planned {
                mission.departure_s = planned.departure_s.unwrap_or(mission.departure_s);
                mission.day_of_year = planned.day_of_year.unwrap_or(mission.day_of_year);
            }
        }
        let own = |e: &PointEvent| matches!(e.kind, EventKind::MissionStop { .. });
        if self.cycle.events.iter().any(own) {
            mission.stops.clear();
        }
    }

    /// Compass heading at the start, in rad: its own, or a drawn one.
    pub(super) fn heading_rad(&self, streams: &Streams) -> f64 {
        self.cycle.heading_rad.unwrap_or_else(|| RoadSampler::sample_heading_rad(streams))
    }

    /// Stretches of road types, as [`Self::lay`] has them.
    pub(super) fn sections(&self, sampler: &RoadSampler, streams: &Streams) -> Cow<'_, [Section]> {
        let drawn = self.drawn.as_ref();
        let drawn = drawn.and_then(|drawn| drawn.sections(&self.cycle, sampler, streams));
        drawn.map_or(Cow::Borrowed(&self.sections), Cow::Owned)
    }

    /// Sum of the climbs that the file has, in m.
    pub(super) fn climb_m(&self, step_m: f64) -> f64 {
        self.slopes.iter().map(|slope| slope.max(0.0) * step_m).sum()
    }

    /// Lays the road down; what the file lacks is drawn, and the parts in `without` are left out.
    pub fn lay(
        &self,
        sampler: &RoadSampler,
        mission_stops: &[PointEvent],
        streams: &Streams,
        without: &[ModelSwitch],
        road: &mut Road,
    ) {
        let has = |part| !without.contains(&part);
        road.length_m = self.cycle.length_m;
        road.slope_step_m = sampler.slope_step_m();
        road.roughness_block_m = sampler.roughness_block_m();
        road.heading_rad = self.heading_rad(streams);
        if let Some(drawn) = &self.drawn {
            road.sections = self.sections(sampler, streams).into_owned();
            let given = (&self.signs[..], &self.slopes[..]);
            let from = (streams, without);
            drawn.lay(&self.cycle, given, sampler, mission_stops, from, road);
            self.lay_surface(sampler, streams, road);
            return;
        }
        road.sections.clone_from(&self.sections);
        road.signs.clone_from(&self.signs);
        road.curves.clear();
        if has(ModelSwitch::Curves) {
            road.curves.extend_from_slice(&self.cycle.curves);
        }
        road.slopes.clone_from(&self.slopes);
        if !has(ModelSwitch::Slope) {
            road.slopes.fill(0.0);
        }
        self.lay_surface(sampler, streams, road);
        road.climb_reached = true;
        let events = self.cycle.events.iter().filter(|e| !is_left_out(&e.kind, without));
        road.events.clear();
        road.events.extend(events);
        road.events.extend_from_slice(mission_stops);
        merge_events(&mut road.events);
    }

    /// Lays roughness and grounds, the file's or drawn ones.
    fn lay_surface(&self, sampler: &RoadSampler, streams: &Streams, road: &mut Road) {
        match &self.roughness_m3 {
            Some(blocks) => road.roughness_m3.clone_from(blocks),
            None => sampler.sample_roughness(streams, road),
        }
        match (&self.grounds, &self.cycle.grounds) {
            (Some(grounds), _) => road.grounds.clone_from(grounds),
            (None, Some(grounds)) => road.grounds = grounds_of(grounds, &road.sections),
            (None, None) => sampler.sample_grounds(streams, road),
        }
    }

    /// Puts the file's weather and traffic in place of what was drawn, where they are kept; the
    /// parts in `without` stay left out.
    pub fn give_clock(&self, without: &[ModelSwitch], cycle: &mut OperatingCycle) {
        if self.keep.contains(&Keep::Weather)
            && !without.contains(&ModelSwitch::Weather)
            && let Some(weather) = &self.cycle.weather
        {
            cycle.weather.clone_from(weather);
        }
        if self.keep.contains(&Keep::Traffic)
            && !without.contains(&ModelSwitch::Traffic)
            && let Some(traffic) = &self.cycle.traffic
        {
            cycle.traffic.clone_from(traffic);
        }
    }
}

/// Chooses a route by its weight, or the next one in turn, and says which it is, from 0.
pub fn choose<'a>(
    routes: &'a [Route],
    in_turn: bool,
    streams: &Streams,
) -> Option<(usize, &'a Route)> {
    let place = match routes {
        [] | [_] => 0,
        several if in_turn => (streams.cycle_of(Stream::Route) % several.len() as u64) as usize,
        several => {
            let weights: Vec<f64> = several.iter().map(|route| route.weight).collect();
            streams.open(Stream::Route).index(&weights)
        }
    };
    Some((place, routes.get(place)?))
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
pub fn type_by_limit(limit_mps: f64) -> &'static str {
    if limit_mps <= URBAN_UP_TO_MPS {
        "urban"
    } else if limit_mps < MOTORWAY_FROM_MPS {
        "rural"
    } else {
        "motorway"
    }
}
