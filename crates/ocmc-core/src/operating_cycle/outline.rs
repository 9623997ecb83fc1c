//! The outline of an operating cycle: its mission, and of its road, weather and traffic what is
//! known without laying the road down.
//!
//! Weather and traffic are those half-way, at a nominal speed: near to what the trip meets, and a
//! function of the draws alone.

use super::OperatingCycleSampler;
use super::mission::Mission;
use super::road::RoadSampler;
use super::road::road_type::Section;
use super::route;
use super::weather::{STANDARD_WEATHER, Weather};
use crate::random::Streams;
use crate::switch::ModelSwitch;
use std::borrow::Cow;

/// Speed at which half of the way is taken to be driven, in m/s.
const NOMINAL_SPEED_MPS: f64 = 16.7;

/// The part of an operating cycle that is known without its road.
#[derive(Clone, Debug)]
pub struct CycleOutline {
    /// The mission, without its parts.
    pub mission: Mission,
    /// Share of each road type by length.
    pub type_shares: Vec<f64>,
    /// Sum of the climbs that a given route's file has, in m; 0 where the road is drawn.
    pub route_climb_m: f64,
    /// The weather half-way.
    pub weather: Weather,
    /// Component of the wind half-way from where the road leads at its start, in m/s.
    pub head_wind_mps: f64,
    /// Traffic density half-way, as the long-run mean over the road types, in vehicles per m and
    /// lane.
    pub density_per_m: f64,
}

impl OperatingCycleSampler {
    /// Draws the outline of a cycle: from the streams, and as, [`Self::sample`] draws the whole.
    pub fn outline(&self, streams: &Streams, without: &[ModelSwitch]) -> CycleOutline {
        let route = route::choose(&self.routes, self.mission.routes_in_turn, streams);
        let route = route.map(|(_, route)| route);
        let given_length_m = route.map(|route| route.cycle.length_m);
        let mut mission = self.mission.sample(given_length_m, streams, without);
        let mut route_climb_m = 0.0;
        let (sections, heading_rad) = match route {
            None => {
                let sections = self.road.sample_sections(mission.length_m, streams);
                (Cow::Owned(sections), RoadSampler::sample_heading_rad(streams))
            }
            Some(route) => {
                route.give_mission(&mut mission);
                route_climb_m = route.climb_m(self.road.slope_step_m());
                (route.sections(&self.road, streams), route.heading_rad(streams))
            }
        };
        let type_shares = type_shares(&sections, mission.length_m, self.traffic_types.len());
        let half_s = 0.5 * mission.length_m / NOMINAL_SPEED_MPS;
        let weather = if without.contains(&ModelSwitch::Weather) {
            STANDARD_WEATHER
        } else {
            let (day, second) = (mission.day_of_year, mission.departure_s);
            self.weather.sample(day, second, half_s, streams).at(half_s)
        };
        let density_per_m = if without.contains(&ModelSwitch::Traffic) {
            0.0
        } else {
            let series = self.traffic.sample(mission.departure_s, half_s, streams);
            let types = self.traffic_types.iter().zip(self.road.share_by_length());
            let density = |(model, share)| {
                share * self.traffic.density_per_m(model, &series, mission.departure_s, half_s)
            };
            types.map(density).sum()
        };
        let (head_wind_mps, _) = weather.wind_components_mps(heading_rad);
        CycleOutline { mission, type_shares, route_climb_m, weather, head_wind_mps, density_per_m }
    }
}

/// Share of each road type by length.
fn type_shares(sections: &[Section], length_m: f64, types: usize) -> Vec<f64> {
    let mut shares = vec![0.0; types];
    for section in sections {
        shares[section.road_type] += (section.end_m - section.start_m) / length_m;
    }
    shares
}
