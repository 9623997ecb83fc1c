//! The bird's-eye view: coarse classes of roads and missions.
//!
//! Hilliness: flat where the slope is below 3 % on more than 98 % of the way, predominantly flat below 6 %, hilly below 9 %, else
//! very hilly. Transport cycle by the mean distance between mission stops: stop and go below 0.5 km, local below 5 km, regional
//! below 50 km, else long distance. Both \[PK\]: Volvo's global transport application, P. Edlund, P.-O. Fryk, SAE 2004-01-2645.

use crate::log::road::LoggedRoad;
use crate::road::point_event::EventKind;
use serde::Serialize;
use std::collections::BTreeMap;

/// Slopes that divide the classes of hilliness.
const SLOPES: [f64; 3] = [0.03, 0.06, 0.09];

/// Share of the way on which the slope has to stay below.
const SHARE: f64 = 0.98;

/// Stops per km that divide the classes of their density: geometric means of what VECTO's cycles for long haul (0.06), regional
/// delivery (0.23) and urban delivery (0.97) have \[D\].
const STOPS_PER_KM: [f64; 2] = [0.12, 0.47];

/// Curves per km below 500 m of radius that divide the classes of theirs: geometric means of what an OpenStreetMap extract has at limits
/// of 100 km/h and more (0.5), 60 to 80 (1.0) and up to 50 (2.75) \[D\].
const CURVES_PER_KM: [f64; 2] = [0.71, 1.66];

/// Radius below which a curve slows a truck down, in m: the end of the curve-speed law.
const SLOWING_RADIUS_M: f64 = 500.0;

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
    /// Class of hilliness.
    pub hilliness: Hilliness,
    /// Shares of the way with slopes below 3, 6 and 9 %.
    pub share_below: [f64; 3],
    /// Class of the distance between mission stops; the end of a road counts as one.
    pub transport_cycle: TransportCycle,
    /// Places per km at which a truck has to stop; of a log, at which it stood.
    pub stops_per_km: f64,
    /// Class of the density of stops.
    pub stop_density: Density,
    /// Curves per km with radii below 500 m.
    pub curves_per_km: f64,
    /// Class of the density of curves.
    pub curve_density: Density,
    /// Share of each road type by length; empty where no road has types.
    pub road_type_share: BTreeMap<String, f64>,
}

/// Looks at roads on steps of `step_m`.
pub fn birds_eye(roads: &[LoggedRoad], step_m: f64) -> BirdsEye {
    let length_m: f64 = roads.iter().map(|road| road.cycle.length_m).sum();
    let mut below = [0usize; 3];
    let mut steps = 0;
    let (mut stops, mut mission_stops, mut curves) = (0, 0, 0);
    let mut shares: BTreeMap<String, f64> = BTreeMap::new();
    for LoggedRoad { cycle, standstills } in roads {
        for k in 0..(cycle.length_m / step_m) as usize {
            let at = k as f64 * step_m;
            let slope = (cycle.altitude_m(at + step_m) - cycle.altitude_m(at)) / step_m;
            steps += 1;
            for (count, limit) in below.iter_mut().zip(SLOPES) {
                *count += usize::from(slope.abs() < limit);
            }
        }
        stops += standstills.len();
        stops += cycle.events.iter().filter(|event| event.kind.standstill_s().is_some()).count();
        let mission = |kind: &EventKind| matches!(kind, EventKind::MissionStop { .. });
        mission_stops += 1 + cycle.events.iter().filter(|event| mission(&event.kind)).count();
        curves += cycle.curves.iter().filter(|curve| curve.radius_m < SLOWING_RADIUS_M).count();
        let types = cycle.road_types.as_deref().unwrap_or_default();
        let ends = types.iter().skip(1).map(|start| start.0).chain([cycle.length_m]);
        for ((start, name), end) in types.iter().zip(ends) {
            *shares.entry(name.clone()).or_insert(0.0) += (end - start) / length_m;
        }
    }
    let share_below = below.map(|count| count as f64 / f64::from(steps).max(1.0));
    let hilliness = match share_below.iter().position(|share| *share > SHARE) {
        Some(0) => Hilliness::Flat,
        Some(1) => Hilliness::PredominantlyFlat,
        Some(_) => Hilliness::Hilly,
        None => Hilliness::VeryHilly,
    };
    let transport_cycle = match length_m / mission_stops as f64 {
        spacing if spacing < 500.0 => TransportCycle::StopAndGo,
        spacing if spacing < 5.0e3 => TransportCycle::Local,
        spacing if spacing < 50.0e3 => TransportCycle::Regional,
        _ => TransportCycle::LongDistance,
    };
    let per_km = |count: usize| count as f64 / length_m * 1000.0;
    BirdsEye {
        hilliness,
        share_below,
        transport_cycle,
        stops_per_km: per_km(stops),
        stop_density: Density::of(per_km(stops), STOPS_PER_KM),
        curves_per_km: per_km(curves),
        curve_density: Density::of(per_km(curves), CURVES_PER_KM),
        road_type_share: shares,
    }
}
