//! The operating cycle of one trip: road, weather, traffic and mission together, and its tracks.
//!
//! Traffic and weather are evaluated along the road at the free-flow passing time, the integral of
//! dx / min(sign, legal truck limit) plus the drawn standstill: no driver and no truck enter, so
//! under one seed all trucks and drivers meet the same cycle, and the speed profile is a function
//! of position alone.

pub mod coverage;
pub mod drawn_part;
pub mod given;
mod given_error;
pub mod mission;
pub mod mission_part;
pub mod outline;
pub mod road;
pub mod route;
pub mod segments;
pub mod tracks;
pub mod traffic;
pub mod weather;

use crate::operating_cycle::mission::{Mission, MissionModel};
use crate::operating_cycle::road::point_event::PointEvent;
use crate::operating_cycle::road::vehicle_class::VehicleClass;
use crate::operating_cycle::road::{Road, RoadModel, RoadSampler};
use crate::operating_cycle::traffic::{TrafficModel, TrafficTypeModel};
use crate::operating_cycle::weather::{STANDARD_WEATHER, Weather, WeatherModel};
use crate::random::Streams;
use crate::switch::ModelSwitch;
use mission_part::set_parts;
use route::Route;
use std::num::NonZeroU32;

/// How far a sign may lie above the law by rounding, in m/s.
const ROUNDED_MPS: f64 = 0.1;

/// A limit that no truck reaches, in m/s: what a road without signs shows.
pub const UNLIMITED_MPS: f64 = 130.0 / 3.6;

/// Weather that holds from a position on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeatherStretch {
    /// Where it begins, in m.
    pub start_m: f64,
    /// The weather.
    pub weather: Weather,
}

/// Traffic density that holds from a position on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrafficStretch {
    /// Where it begins, in m.
    pub start_m: f64,
    /// Density, in vehicles per m and lane.
    pub density_per_m: f64,
}

/// A realised operating cycle.
#[derive(Clone, Debug, Default)]
pub struct OperatingCycle {
    /// The mission.
    pub mission: Mission,
    /// The road.
    pub road: Road,
    /// Weather along the road.
    pub weather: Vec<WeatherStretch>,
    /// Traffic along the road.
    pub traffic: Vec<TrafficStretch>,
    /// Free-flow duration, drawn standstill included, in s.
    pub free_flow_s: f64,
}

/// The models of an operating cycle, prepared for sampling.
#[derive(Clone, Debug)]
pub struct OperatingCycleSampler {
    road: RoadSampler,
    weather: WeatherModel,
    traffic: TrafficModel,
    /// In the order of the road types.
    traffic_types: Vec<TrafficTypeModel>,
    mission: MissionModel,
    /// Given cycles, with their weights and what they keep, to choose from instead of drawing a
    /// road.
    pub(crate) routes: Vec<Route>,
}

/// One change along the road that the free-flow clock has to know.
enum Change {
    Speed { section: usize, speed_mps: f64 },
    Standstill(f64),
}

impl OperatingCycleSampler {
    /// Prepares checked models for vehicles of a class.
    pub fn new(
        road: &RoadModel,
        weather: &WeatherModel,
        traffic: &TrafficModel,
        mission: &MissionModel,
        class: VehicleClass,
    ) -> Self {
        let traffic_types = road.types.keys().map(|name| traffic.types[name].clone()).collect();
        Self {
            road: RoadSampler::new(road, class),
            weather: weather.clone(),
            traffic: traffic.clone(),
            traffic_types,
            mission: mission.clone(),
            routes: Vec::new(),
        }
    }

    /// Signs of given routes above what the law allows the study's vehicles there: the way along
    /// them, in m, the highest of them and its limit, in m/s; none where there is no such sign.
    pub fn above_law(&self) -> Option<[f64; 3]> {
        let stretches = self.routes.iter().flat_map(Route::signed_stretches);
        let above = stretches.filter_map(|(way_m, sign_mps, road_type)| {
            let legal_mps = self.road.legal_mps(road_type);
            (sign_mps > legal_mps + ROUNDED_MPS).then_some([way_m, sign_mps, legal_mps])
        });
        above.reduce(|sum, next| {
            let [_, highest_mps, legal_mps] = if next[1] > sum[1] { next } else { sum };
            [sum[0] + next[0], highest_mps, legal_mps]
        })
    }

    /// Whether it draws roads, and not from given ones.
    pub fn draws_roads(&self) -> bool {
        self.routes.is_empty()
    }

    /// The road models.
    pub fn road(&self) -> &RoadSampler {
        &self.road
    }

    /// The traffic model.
    pub fn traffic(&self) -> &TrafficModel {
        &self.traffic
    }

    /// Draws one operating cycle into `cycle`, whose buffers are reused.
    pub fn sample(&self, streams: &Streams, without: &[ModelSwitch], cycle: &mut OperatingCycle) {
        let chosen = route::choose(&self.routes, self.mission.routes_in_turn, streams);
        let route = chosen.map(|(_, route)| route);
        let given_length_m = route.map(|route| route.cycle.length_m);
        cycle.mission = self.mission.sample(given_length_m, streams, without);
        if let Some(route) = route {
            route.give_mission(&mut cycle.mission);
        }
        let (mission, road) = (&cycle.mission, &mut cycle.road);
        match route {
            None => self.road.sample(mission.length_m, &mission.stops, streams, without, road),
            Some(route) => route.lay(&self.road, &mission.stops, streams, without, road),
        }
        cycle.road.route = chosen.and_then(|(place, _)| NonZeroU32::new(place as u32 + 1));
        if without.contains(&ModelSwitch::Signs) {
            for sign in &mut cycle.road.signs {
                sign.speed_mps = UNLIMITED_MPS;
            }
        }
        let given = route.map(|route| (&route.cycle, route.keeps_mission()));
        let (events, mission) = (&cycle.road.events, &mut cycle.mission);
        set_parts(&self.mission, events, given, streams, without, mission);
        self.pass(streams, without, cycle);
        if let Some(route) = route {
            route.give_clock(without, cycle);
        }
    }

    /// Runs the free-flow clock along the road and writes down what it meets.
    fn pass(&self, streams: &Streams, without: &[ModelSwitch], cycle: &mut OperatingCycle) {
        let changes = self.changes(&cycle.road);
        let length_m = cycle.road.length_m;
        cycle.free_flow_s = free_flow_s(&changes, length_m);
        let mission = &cycle.mission;

        let weather = (!without.contains(&ModelSwitch::Weather)).then(|| {
            let (day, second) = (mission.day_of_year, mission.departure_s);
            self.weather.sample(day, second, cycle.free_flow_s, streams)
        });
        let traffic = (!without.contains(&ModelSwitch::Traffic))
            .then(|| self.traffic.sample(mission.departure_s, cycle.free_flow_s, streams));
        let weather_at = |time_s: f64| weather.as_ref().map_or(STANDARD_WEATHER, |w| w.at(time_s));
        let step_s = self.traffic.step_s;
        let middle_s = |block: f64| (block + 0.5) * step_s;
        let density_at = |section: usize, block: f64| {
            traffic.as_ref().map_or(0.0, |series| {
                let model = &self.traffic_types[cycle.road.sections[section].road_type];
                self.traffic.density_per_m(model, series, mission.departure_s, middle_s(block))
            })
        };

        cycle.weather.clear();
        cycle.traffic.clear();
        let (mut time_s, mut position_m, mut section, mut speed_mps) = (0.0, 0.0, 0, 1.0);
        // the block of the clock that the truck is in, and the one whose weather and traffic are
        // written down
        let (mut block, mut written): (f64, f64) = (0.0, -1.0);
        for (k, (start_m, change)) in changes.iter().enumerate() {
            position_m = f64::max(position_m, *start_m);
            match change {
                Change::Standstill(wait_s) => time_s += wait_s,
                Change::Speed { section: s, speed_mps: v } => {
                    if section != *s || k == 0 {
                        section = *s;
                        block = block.max(libm::floor(time_s / step_s));
                        let density_per_m = density_at(section, block);
                        cycle.traffic.push(TrafficStretch { start_m: position_m, density_per_m });
                    }
                    speed_mps = *v;
                }
            }
            let end_m = changes.get(k + 1).map_or(length_m, |next| next.0);
            loop {
                // a new block of the clock begins here, or at the moment it is reached
                block = block.max(libm::floor(time_s / step_s));
                if block > written {
                    written = block;
                    // weather at the block's middle; its first moment may lie before this place
                    let weather = weather_at(middle_s(block));
                    cycle.weather.push(WeatherStretch { start_m: position_m, weather });
                    let density_per_m = density_at(section, block);
                    if cycle.traffic.last().is_some_and(|last| last.start_m >= position_m) {
                        cycle.traffic.pop();
                    }
                    cycle.traffic.push(TrafficStretch { start_m: position_m, density_per_m });
                }
                let next_block_s = (block + 1.0) * step_s;
                let reach_m = position_m + (next_block_s - time_s) * speed_mps;
                if reach_m >= end_m {
                    time_s += (end_m - position_m) / speed_mps;
                    position_m = end_m;
                    break;
                }
                // counted, not divided: seven times 90.7 s, divided by 90.7 s, is less than seven
                block += 1.0;
                time_s = next_block_s;
                position_m = reach_m;
            }
        }
    }

    /// Signs and standstills in order of position.
    fn changes(&self, road: &Road) -> Vec<(f64, Change)> {
        let mut changes = Vec::with_capacity(road.signs.len() + road.events.len());
        let mut section = 0;
        let standstill = |event: &PointEvent| {
            event.kind.standstill_s().map(|s| (event.position_m, Change::Standstill(s)))
        };
        let mut events = road.events.iter().peekable();
        for sign in &road.signs {
            while let Some(event) = events.next_if(|e| e.position_m < sign.start_m) {
                changes.extend(standstill(event));
            }
            while road.sections[section].end_m <= sign.start_m {
                section += 1;
            }
            let legal_mps = self.road.legal_mps(road.sections[section].road_type);
            let speed_mps = sign.speed_mps.min(legal_mps);
            changes.push((sign.start_m, Change::Speed { section, speed_mps }));
        }
        changes.extend(events.filter_map(standstill));
        changes
    }
}

/// Duration of the free-flow passage, in s.
fn free_flow_s(changes: &[(f64, Change)], length_m: f64) -> f64 {
    let (mut time_s, mut position_m, mut speed_mps) = (0.0, 0.0, 1.0);
    for (start_m, change) in changes {
        time_s += (start_m - position_m) / speed_mps;
        position_m = *start_m;
        match change {
            Change::Standstill(wait_s) => time_s += wait_s,
            Change::Speed { speed_mps: v, .. } => speed_mps = *v,
        }
    }
    time_s + (length_m - position_m) / speed_mps
}
