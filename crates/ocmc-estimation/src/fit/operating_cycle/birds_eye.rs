//! The bird's-eye view: coarse classes of roads and missions.
//!
//! Hilliness: flat where the slope is below 3 % on more than 98 % of the way, predominantly flat
//! below 6 %, hilly below 9 %, else very hilly. Transport cycle by the mean distance between
//! mission stops: stop and go below 0.5 km, local below 5 km, regional below 50 km, else long
//! distance. Both \[PK\]: Volvo's global transport application, P. Edlund, P.-O. Fryk, SAE
//! 2004-01-2645.

use crate::log::road::LoggedRoad;
use ocmc_core::operating_cycle::coverage::overlap_m;
use ocmc_core::operating_cycle::road::Road;
use ocmc_core::operating_cycle::road::curvature::Curve;
use ocmc_core::operating_cycle::road::point_event::{EventKind, PointEvent};
use ocmc_core::study::Study;
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::{ControlFlow, Range};

/// Slopes that divide the classes of hilliness.
pub(super) const SLOPES: [f64; 3] = [0.03, 0.06, 0.09];

/// Share of the way on which the slope has to stay below.
const SHARE: f64 = 0.98;

/// Stops per km that divide the classes of their density: geometric means of what VECTO's cycles
/// for long haul (0.06), regional delivery (0.23) and urban delivery (0.97) have \[D\].
const STOPS_PER_KM: [f64; 2] = [0.12, 0.47];

/// Curves per km below 500 m of radius that divide the classes of theirs: geometric means of what
/// an OpenStreetMap extract has at limits of 100 km/h and more (0.5), 60 to 80 (1.0) and up to 50
/// (2.75) \[D\].
const CURVES_PER_KM: [f64; 2] = [0.71, 1.66];

/// Radius below which a curve slows a truck down, in m: the end of the curve-speed law.
pub(super) const SLOWING_RADIUS_M: f64 = 500.0;

/// Classes of hilliness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Hilliness {
    /// Below 3 %.
    Flat,
    /// Below 6 %.
    PredominantlyFlat,
    /// Below 9 %.
    Hilly,
    /// The rest.
    VeryHilly,
}

/// Classes of the distance between mission stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TransportCycle {
    /// Below 0.5 km.
    StopAndGo,
    /// Below 5 km.
    Local,
    /// Below 50 km.
    Regional,
    /// The rest.
    LongDistance,
}

/// Classes of how often something comes along.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Density {
    /// Below both limits.
    Low,
    /// Between them.
    Medium,
    /// Above both.
    High,
}

impl Density {
    fn of(per_km: f64, limits: [f64; 2]) -> Self {
        match per_km {
            d if d < limits[0] => Self::Low,
            d if d < limits[1] => Self::Medium,
            _ => Self::High,
        }
    }
}

/// The bird's-eye view of roads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BirdsEye {
    /// Length of the roads, in m.
    pub length_m: f64,
    /// Class of hilliness; none where no slope is known.
    pub hilliness: Option<Hilliness>,
    /// Shares of the way with slopes below 3, 6 and 9 %, of the way whose slope is known; none
    /// where none is.
    pub share_below: Option<[f64; 3]>,
    /// Class of the distance between mission stops; the end of a road counts as one.
    pub transport_cycle: TransportCycle,
    /// Places per km at which a truck has to stop; of a log, at which it stood.
    pub stops_per_km: f64,
    /// Class of the density of stops.
    pub stop_density: Density,
    /// Curves per km with radii below 500 m, of the way whose curves are known; none where none is.
    pub curves_per_km: Option<f64>,
    /// Class of the density of curves; none where none is known.
    pub curve_density: Option<Density>,
    /// Share of each road type by length; empty where no road has types.
    pub road_type_share: BTreeMap<String, f64>,
}

/// Analyses roads on steps of `step_m`.
pub fn birds_eye(roads: &[LoggedRoad], step_m: f64) -> BirdsEye {
    let mut view = View::default();
    for road in roads {
        let LoggedRoad { cycle, standstills, unobserved, .. } = road;
        let slope = |k: usize| {
            let at = k as f64 * step_m;
            let known = overlap_m(&unobserved.slope_m, at, at + step_m) == 0.0;
            known.then(|| (cycle.altitude_m(at + step_m) - cycle.altitude_m(at)) / step_m)
        };
        view.slopes((0..(cycle.length_m / step_m) as usize).filter_map(slope));
        view.curve_way_m += cycle.length_m - overlap_m(&unobserved.curves_m, 0.0, cycle.length_m);
        view.stops += standstills.len();
        view.mission_ends += usize::from(road.begins_drive());
        let types = cycle.road_types.as_deref().unwrap_or_default();
        let ends = types.iter().skip(1).map(|start| start.0).chain([cycle.length_m]);
        let sections =
            types.iter().zip(ends).map(|((start, name), end)| (name.as_str(), end - start));
        view.road(cycle.length_m, &cycle.curves, &cycle.events, sections);
    }
    view.finish()
}

/// Analyses the roads that a study draws, or its routes. `before_each` is called before each
/// of them, and may break off.
pub fn birds_eye_of_study<B>(
    study: &Study,
    seed: u64,
    cycle_ids: Range<u64>,
    mut before_each: impl FnMut(u64) -> ControlFlow<B>,
) -> ControlFlow<B, BirdsEye> {
    let mut view = View::default();
    for (done, cycle_id) in cycle_ids.enumerate() {
        before_each(done as u64)?;
        let Road { length_m, slopes, slope_step_m, curves, events, sections, .. } =
            study.sample(seed, cycle_id).cycle.road;
        view.curve_way_m += length_m;
        view.mission_ends += 1;
        view.slopes(slopes.into_iter().take((length_m / slope_step_m) as usize));
        let names = study.road_types();
        let sections = sections.iter().map(|s| (names[s.road_type].as_str(), s.end_m - s.start_m));
        view.road(length_m, &curves, &events, sections);
    }
    ControlFlow::Continue(view.finish())
}

/// View of roads.
#[derive(Default)]
struct View {
    length_m: f64,
    /// Steps, and those with slopes below the limits.
    steps: usize,
    below: [usize; 3],
    stops: usize,
    mission_stops: usize,
    /// Ends of missions.
    mission_ends: usize,
    curves: usize,
    /// Way whose curves are known, in m.
    curve_way_m: f64,
    type_length_m: BTreeMap<String, f64>,
}

impl View {
    fn slopes(&mut self, slopes: impl Iterator<Item = f64>) {
        for slope in slopes {
            self.steps += 1;
            for (count, limit) in self.below.iter_mut().zip(SLOPES) {
                *count += usize::from(slope.abs() < limit);
            }
        }
    }

    fn road<'a>(
        &mut self,
        length_m: f64,
        curves: &[Curve],
        events: &[PointEvent],
        sections: impl Iterator<Item = (&'a str, f64)>,
    ) {
        self.length_m += length_m;
        self.stops += events.iter().filter(|event| event.kind.standstill_s().is_some()).count();
        let mission = |event: &&PointEvent| matches!(event.kind, EventKind::MissionStop { .. });
        self.mission_stops += events.iter().filter(mission).count();
        self.curves += curves.iter().filter(|curve| curve.radius_m < SLOWING_RADIUS_M).count();
        for (name, section_m) in sections {
            *self.type_length_m.entry(name.to_owned()).or_insert(0.0) += section_m;
        }
    }

    fn finish(self) -> BirdsEye {
        let per_km = |count: usize, way_m: f64| count as f64 / way_m * 1000.0;
        let share = |(name, length_m): (String, f64)| (name, length_m / self.length_m);
        BirdsEye::of(Counted {
            length_m: self.length_m,
            share_below: (self.steps > 0)
                .then(|| self.below.map(|count| count as f64 / self.steps as f64)),
            stop_spacing_m: self.length_m / (self.mission_stops + self.mission_ends) as f64,
            stops_per_km: per_km(self.stops, self.length_m),
            curves_per_km: (self.curve_way_m > 0.0).then(|| per_km(self.curves, self.curve_way_m)),
            road_type_share: self.type_length_m.into_iter().map(share).collect(),
        })
    }
}

/// Counts from which the classes come.
pub(super) struct Counted {
    pub(super) length_m: f64,
    pub(super) share_below: Option<[f64; 3]>,
    /// Way from one mission stop, or end of a road, to the next.
    pub(super) stop_spacing_m: f64,
    pub(super) stops_per_km: f64,
    pub(super) curves_per_km: Option<f64>,
    pub(super) road_type_share: BTreeMap<String, f64>,
}

impl BirdsEye {
    /// The classes of what was counted or follows from laws.
    pub(super) fn of(seen: Counted) -> Self {
        let Counted { length_m, share_below, stops_per_km, curves_per_km, .. } = seen;
        let hilliness =
            share_below.map(|shares| match shares.iter().position(|share| *share > SHARE) {
                Some(0) => Hilliness::Flat,
                Some(1) => Hilliness::PredominantlyFlat,
                Some(_) => Hilliness::Hilly,
                None => Hilliness::VeryHilly,
            });
        let transport_cycle = match seen.stop_spacing_m {
            spacing if spacing < 500.0 => TransportCycle::StopAndGo,
            spacing if spacing < 5.0e3 => TransportCycle::Local,
            spacing if spacing < 50.0e3 => TransportCycle::Regional,
            _ => TransportCycle::LongDistance,
        };
        Self {
            length_m,
            hilliness,
            share_below,
            transport_cycle,
            stops_per_km,
            stop_density: Density::of(stops_per_km, STOPS_PER_KM),
            curves_per_km,
            curve_density: curves_per_km.map(|per_km| Density::of(per_km, CURVES_PER_KM)),
            road_type_share: seen.road_type_share,
        }
    }
}
