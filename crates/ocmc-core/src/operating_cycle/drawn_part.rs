//! Parts that a route lacks and has drawn: from the study's laws of each road type, anew in each
//! cycle, and from the streams of the study's own roads.
//!
//! What the route has stays. Kinds of events that it has are known and not drawn; those that are
//! drawn keep the study's spacing from its own. Altitudes up to 200 m apart are taken as they are;
//! between those farther apart slopes are drawn and shifted to the difference that is known, or go
//! on evenly where the limits on slopes leave no other way. Signs follow the types of the road;
//! where neither is given the types are those of the chain, and where signs are given and types are
//! not, the types are drawn given the signs ([`super::road::types_of_signs`]).

use super::given::{GivenCycle, held, merge_events};
use super::road::point_event::{EventDeclaration, EventKind, KINDS, PointEvent, is_left_out};
use super::road::road_type::Section;
use super::road::speed_sign::SpeedSign;
use super::road::surface::Ground;
use super::road::topography::{bridge, sample_slopes};
use super::road::types_of_signs::TypesOfSigns;
use super::road::{Road, RoadSampler};
use crate::random::{Stream, Streams};
use crate::switch::ModelSwitch;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Altitudes that are farther apart leave room for hills, in m.
const HILLS_FROM_M: f64 = 200.0;
/// Rounding of places, as a share of a step.
const ROUNDING: f64 = 1.0e-9;

/// Parts that are drawn where a route lacks them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Draw {
    /// Point events: signs, give ways, lights, bumps, railway crossings.
    Stops,
    /// Speed limits, and the road types where there are none either.
    Limits,
    /// Slopes.
    Hills,
    /// Curves.
    Curves,
}

impl Draw {
    /// All that can be drawn.
    pub const ALL: [Self; 4] = [Self::Stops, Self::Limits, Self::Hills, Self::Curves];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stops => "stops",
            Self::Limits => "limits",
            Self::Hills => "hills",
            Self::Curves => "curves",
        }
    }
}

/// Parts that a file lacks of a route: stops always, for no file has all kinds of them.
pub fn lacking(cycle: &GivenCycle) -> Vec<Draw> {
    let lacks = |part: &Draw| match part {
        Draw::Stops => true,
        Draw::Limits => cycle.limits.is_empty(),
        Draw::Hills => hills_of(cycle).is_some(),
        Draw::Curves => cycle.lacks_curves,
    };
    Draw::ALL.into_iter().filter(lacks).collect()
}

/// The parts of one route that are drawn.
#[derive(Clone, Debug)]
pub(super) struct DrawnParts {
    types: Types,
    limits: bool,
    stops: bool,
    curves: bool,
    hills: Option<Hills>,
}

/// Where road types come from.
#[derive(Clone, Debug)]
enum Types {
    /// The file, or a study with one type.
    Given,
    /// The chain of the study.
    Chain,
    /// The signs; the law is that of each truck where none is prepared.
    OfSigns(Option<Box<TypesOfSigns>>),
}

#[derive(Clone, Debug)]
enum Hills {
    /// Without any altitude.
    All,
    /// Between altitudes.
    Between(Vec<Gap>),
}

/// A stretch between altitudes, in m; one at an end of the road has an altitude on one side.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Gap {
    from_m: f64,
    to_m: f64,
    has_both: bool,
}

impl DrawnParts {
    /// The parts that are to be drawn and are lacking; none where there is nothing to draw.
    pub(super) fn of(cycle: &GivenCycle, draw: &[Draw], road: &RoadSampler) -> Option<Self> {
        let lacking = lacking(cycle);
        if !lacking.iter().any(|part| draw.contains(part)) {
            return None;
        }
        let has = |part| draw.contains(&part) && lacking.contains(&part);
        let [limits, stops, curves] = [Draw::Limits, Draw::Stops, Draw::Curves].map(has);
        let hills = if has(Draw::Hills) { hills_of(cycle) } else { None };
        let types = if cycle.road_types.is_some() || road.types().len() == 1 {
            Types::Given
        } else if cycle.limits.is_empty() {
            Types::Chain
        } else {
            let law = road.types_of_signs(&cycle.limits, cycle.length_m);
            Types::OfSigns(law.map(Box::new))
        };
        Some(Self { types, limits, stops, curves, hills })
    }

    /// Whether road types are drawn.
    pub(super) fn draws_types(&self) -> bool {
        !matches!(self.types, Types::Given)
    }

    /// Draws the stretches of road types, each of one ground where the file has grounds; none where
    /// the types are given.
    pub(super) fn sections(
        &self,
        cycle: &GivenCycle,
        road: &RoadSampler,
        streams: &Streams,
    ) -> Option<Vec<Section>> {
        let length_m = cycle.length_m;
        let sections = match &self.types {
            Types::Given => return None,
            Types::Chain => road.sample_sections(length_m, streams),
            Types::OfSigns(law) => {
                road.sample_types_of_signs(law.as_deref(), &cycle.limits, length_m, streams)
            }
        };
        Some(match &cycle.grounds {
            Some(grounds) => cut(&sections, grounds),
            None => sections,
        })
    }

    /// Lays signs, events, curves and slopes on a road whose sections are known. `given` are the
    /// signs and slopes of the file.
    pub(super) fn lay(
        &self,
        cycle: &GivenCycle,
        (signs, slopes): (&[SpeedSign], &[f64]),
        sampler: &RoadSampler,
        mission_stops: &[PointEvent],
        (streams, without): (&Streams, &[ModelSwitch]),
        road: &mut Road,
    ) {
        if self.limits {
            lay_signs(sampler, streams, road);
        } else if self.draws_types() {
            road.signs = signs_of(cycle, &road.sections);
        } else {
            road.signs = signs.to_vec();
        }
        self.lay_events(cycle, sampler, mission_stops, (streams, without), road);
        road.curves.clear();
        if !without.contains(&ModelSwitch::Curves) {
            if self.curves {
                sampler.sample_curves(streams, road);
            } else {
                road.curves.extend_from_slice(&cycle.curves);
            }
        }
        match &self.hills {
            Some(Hills::All) => sampler.sample_slopes(streams, without, road),
            Some(Hills::Between(gaps)) if !without.contains(&ModelSwitch::Slope) => {
                lay_slopes(cycle, gaps, slopes, sampler, streams, road);
            }
            _ => {
                road.slopes.clear();
                road.slopes.extend_from_slice(slopes);
                if without.contains(&ModelSwitch::Slope) {
                    road.slopes.fill(0.0);
                }
                road.climb_reached = true;
            }
        }
    }

    /// Lays the events of the file, and those that are drawn.
    fn lay_events(
        &self,
        cycle: &GivenCycle,
        sampler: &RoadSampler,
        mission_stops: &[PointEvent],
        (streams, without): (&Streams, &[ModelSwitch]),
        road: &mut Road,
    ) {
        let mut given = cycle.events.clone();
        if self.curves {
            for event in &mut given {
                let kind = KINDS.into_iter().find(|kind| kind.includes(&event.kind));
                let mark =
                    kind.and_then(|kind| mark_at(kind, event.position_m, sampler, streams, road));
                event.turns = mark.is_some_and(|(_, turns)| turns);
            }
        }
        given.extend(cycle.open_places.iter().filter_map(|&(position_m, object)| {
            let kind = KINDS.into_iter().find(|kind| kind.map_object == object)?;
            let (kind, turns) = mark_at(kind, position_m, sampler, streams, road)?;
            Some(PointEvent { position_m, kind, turns })
        }));
        if self.stops {
            sampler.sample_events(mission_stops, &given, streams, without, road);
        } else {
            road.events.clear();
            road.events.extend_from_slice(mission_stops);
        }
        given.retain(|event| !is_left_out(&event.kind, without));
        if !given.is_empty() || !self.stops {
            road.events.extend(given);
            merge_events(&mut road.events);
        }
    }
}

/// Draws what happens at a known place, a function of the place alone.
fn mark_at(
    kind: &EventDeclaration,
    position_m: f64,
    sampler: &RoadSampler,
    streams: &Streams,
    road: &Road,
) -> Option<(EventKind, bool)> {
    let model = kind.model?;
    let section = road.sections.iter().find(|section| position_m < section.end_m)?;
    let mut draws = streams.open(model.stream);
    (model.mark)(&sampler.types()[section.road_type], draws.at(position_m as u64))
}

/// A sign at each limit, and one where a section begins: there the free-flow clock reads the road
/// type.
pub(super) fn signs_of(cycle: &GivenCycle, sections: &[Section]) -> Vec<SpeedSign> {
    let mut starts: Vec<f64> = cycle.limits.iter().map(|limit| limit.0).collect();
    starts.extend(sections.iter().map(|section| section.start_m));
    starts.retain(|start_m| *start_m < cycle.length_m);
    starts.sort_by(f64::total_cmp);
    starts.dedup();
    let sign = |start_m| SpeedSign { start_m, speed_mps: held(&cycle.limits, start_m) };
    starts.into_iter().map(sign).collect()
}

/// Draws the signs of each road type's stretches, and puts one where a section begins: there the
/// free-flow clock reads the road type.
fn lay_signs(sampler: &RoadSampler, streams: &Streams, road: &mut Road) {
    let mut of_type: Vec<Section> = Vec::with_capacity(road.sections.len());
    for section in &road.sections {
        match of_type.last_mut().filter(|last| last.road_type == section.road_type) {
            Some(last) => last.end_m = section.end_m,
            None => of_type.push(*section),
        }
    }
    let sections = std::mem::replace(&mut road.sections, of_type);
    sampler.sample_signs(streams, road);
    for section in &sections {
        let k = road.signs.partition_point(|sign| sign.start_m <= section.start_m);
        let before = road.signs[k.saturating_sub(1)];
        if before.start_m < section.start_m {
            road.signs.insert(k, SpeedSign { start_m: section.start_m, ..before });
        }
    }
    road.sections = sections;
}

/// Sections that end where the ground changes, too.
fn cut(sections: &[Section], grounds: &[(f64, Ground)]) -> Vec<Section> {
    let mut parts = Vec::with_capacity(sections.len() + grounds.len());
    for section in sections {
        let mut rest = *section;
        for &(at_m, _) in grounds {
            if at_m > rest.start_m && at_m < rest.end_m {
                parts.push(Section { end_m: at_m, ..rest });
                rest.start_m = at_m;
            }
        }
        parts.push(rest);
    }
    parts
}

/// The ground of each section, by the file.
pub(super) fn grounds_of(grounds: &[(f64, Ground)], sections: &[Section]) -> Vec<Ground> {
    sections.iter().map(|section| held(grounds, section.start_m)).collect()
}

/// Where a route has room for hills; none where its altitudes or slopes leave none.
fn hills_of(cycle: &GivenCycle) -> Option<Hills> {
    if cycle.has_slopes {
        return None;
    }
    let (points, length_m) = (&cycle.altitude, cycle.length_m);
    let ([(first_m, _), .., (last_m, _)], false) = (points.as_slice(), points.len() < 2) else {
        return Some(Hills::All);
    };
    let mut gaps = vec![Gap { from_m: 0.0, to_m: *first_m, has_both: false }];
    let between = points.windows(2);
    gaps.extend(between.map(|p| Gap { from_m: p[0].0, to_m: p[1].0, has_both: true }));
    gaps.push(Gap { from_m: *last_m, to_m: length_m, has_both: false });
    gaps.retain(|gap| gap.to_m - gap.from_m > HILLS_FROM_M);
    (!gaps.is_empty()).then_some(Hills::Between(gaps))
}

/// Draws slopes between known altitudes, which the road meets; elsewhere they are the `given` ones.
fn lay_slopes(
    cycle: &GivenCycle,
    gaps: &[Gap],
    given: &[f64],
    sampler: &RoadSampler,
    streams: &Streams,
    road: &mut Road,
) {
    let (step_m, count) = (sampler.slope_step_m(), given.len());
    let model = |section: &Section| &sampler.types()[section.road_type].topography;
    let mut draws = streams.open(Stream::Topography);
    let mut drawn = Vec::with_capacity(count);
    sample_slopes(model, step_m, &road.sections, &mut draws, &mut drawn);
    road.slopes.clear();
    road.slopes.extend_from_slice(given);
    road.climb_reached = true;
    // the steps that begin within a gap
    let step_from = |at_m: f64| (libm::ceil(at_m / step_m - ROUNDING) as usize).min(count);
    // the altitude at the step where the last gap ended
    let mut reached: Option<(usize, f64)> = None;
    for (k, gap) in gaps.iter().enumerate() {
        let (first, end) = (step_from(gap.from_m), step_from(gap.to_m));
        if first >= end {
            continue;
        }
        let from_m = first as f64 * step_m;
        let here = reached.filter(|(step, _)| *step == first).map(|(_, altitude_m)| altitude_m);
        let altitude_m = here.unwrap_or_else(|| cycle.altitude_m(from_m));
        let goes_on = gaps.get(k + 1).is_some_and(|next| next.from_m <= gap.to_m);
        // altitudes that are close are met where steps meet
        let to_m = if goes_on { gap.to_m } else { (end as f64 * step_m).min(cycle.length_m) };
        let slopes = &mut road.slopes[first..end];
        slopes.copy_from_slice(&drawn[first..end]);
        if gap.has_both {
            let limit = |section: &Section| {
                let last = step_from(section.end_m).clamp(first, end) - first;
                (last, model(section).slope_limit)
            };
            let limits: Vec<(usize, f64)> = road.sections.iter().map(limit).collect();
            let climb_m = cycle.altitude_m(to_m) - altitude_m;
            if !bridge(slopes, step_m, to_m - from_m, climb_m, &limits) {
                slopes.fill(climb_m / (to_m - from_m));
            }
        }
        let end_m = end as f64 * step_m;
        let beyond_m = slopes[slopes.len() - 1] * (end_m - to_m);
        reached = goes_on.then(|| (end, cycle.altitude_m(to_m) + beyond_m));
    }
}
