//! The road of an operating cycle: what a truck meets because of where it drives.
//!
//! Models are conditionally independent given the road type, save that curves follow the sign.

pub mod curvature;
pub mod point_event;
pub mod road_type;
pub mod route_fillet;
pub mod route_geometry;
pub mod route_noise;
pub mod speed_sign;
pub mod surface;
pub mod topography;
pub mod types_of_signs;
pub mod vehicle_class;

use crate::breakdown::is_road_type_name;
use crate::distribution::Quantity;
use crate::random::{Stream, Streams};
use crate::switch::ModelSwitch;
use crate::validation::Problems;
use curvature::{Curve, CurveModel, merge_turns};
use point_event::{
    EventKind, GiveWayModel, JunctionTurnModel, KINDS, PointEvent, RailwayCrossingModel,
    SpeedBumpModel, StopSignModel, TrafficLightModel, space_out,
};
use road_type::{RoadTypeChain, Section};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use speed_sign::{SpeedSign, SpeedSignChain, SpeedSignModel};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::num::NonZeroU32;
use surface::{Ground, GroundModel, RoughnessModel};
use topography::{ClimbRule, TopographyModel, bridge, sample_slopes};
use types_of_signs::TypesOfSigns;
use vehicle_class::VehicleClass;

/// Statistical description of roads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RoadModel {
    /// Step L_s of the slope, in m.
    #[schemars(range(min = 5.0, max = 200.0))]
    pub slope_step_m: f64,
    /// How the elevation drifts.
    pub climb_rule: ClimbRule,
    /// Net climb of a mission, in m.
    #[schemars(range(min = -5000.0, max = 5000.0))]
    pub net_climb_m: Quantity,
    /// Length of a roughness block, in m.
    #[schemars(range(min = 20.0, max = 10_000.0))]
    pub roughness_block_m: f64,
    /// Smallest distance between events, in m.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub event_spacing_m: f64,
    /// Length at both ends without events, in m.
    #[schemars(range(min = 5.0, max = 1000.0))]
    pub event_free_end_m: f64,
    /// Turns taken at junctions.
    pub junction_turn: JunctionTurnModel,
    /// Standard deviation between trucks of the logarithm of each road type's mean length; absent:
    /// all trucks have the same mix of roads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 3.0))]
    pub truck_mix_log_sd: Option<f64>,
    /// The road types.
    pub types: BTreeMap<String, RoadTypeModel>,
}

/// Statistical description of one road type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RoadTypeModel {
    /// Mean length of a stretch of this type, in m.
    #[schemars(range(min = 50.0, max = 1.0e7))]
    pub mean_length_m: f64,
    /// Shortest stretch, in m.
    #[schemars(range(min = 0.0, max = 1.0e6))]
    pub minimum_length_m: f64,
    /// Probabilities of the type that follows; empty where this is the only type.
    #[schemars(
        extend("additionalProperties" = { "type": "number", "minimum": 0.0, "maximum": 1.0 })
    )]
    pub next: BTreeMap<String, f64>,
    /// Legal limit for trucks on this type beside the signs, in m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 2.0, max = 70.0))]
    pub truck_limit_mps: Option<f64>,
    /// Legal limit for buses and coaches on this type beside the signs, in m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 2.0, max = 70.0))]
    pub coach_limit_mps: Option<f64>,
    /// Ratio of the wind beside the truck to the wind at 10 m.
    #[schemars(range(min = 0.0, max = 1.5))]
    pub wind_exposure: f64,
    /// Speed signs.
    pub speed_signs: SpeedSignModel,
    /// Curves.
    pub curves: CurveModel,
    /// Slope.
    pub topography: TopographyModel,
    /// Roughness.
    pub roughness: RoughnessModel,
    /// Ground types.
    #[schemars(
        extend("additionalProperties" = { "type": "number", "minimum": 0.0, "maximum": 1.0 })
    )]
    pub ground: GroundModel,
    /// Stop signs.
    pub stop_signs: StopSignModel,
    /// Give-way signs and roundabouts.
    pub give_ways: GiveWayModel,
    /// Traffic lights.
    pub traffic_lights: TrafficLightModel,
    /// Speed bumps.
    pub speed_bumps: SpeedBumpModel,
    /// Railway crossings; none where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub railway_crossings: Option<RailwayCrossingModel>,
}

/// A realised road.
#[derive(Clone, Debug, Default)]
pub struct Road {
    /// Length, in m.
    pub length_m: f64,
    /// Stretches of one road type.
    pub sections: Vec<Section>,
    /// Speed limits.
    pub signs: Vec<SpeedSign>,
    /// Curves, in order and disjoint.
    pub curves: Vec<Curve>,
    /// Slope (climb per metre of road) of each step.
    pub slopes: Vec<f64>,
    /// Length of a slope step, in m.
    pub slope_step_m: f64,
    /// Roughness coefficient of each block, in m³.
    pub roughness_m3: Vec<f64>,
    /// Length of a roughness block, in m.
    pub roughness_block_m: f64,
    /// Ground of each section.
    pub grounds: Vec<Ground>,
    /// Events, in order.
    pub events: Vec<PointEvent>,
    /// Compass heading at the start, in rad from north, clockwise.
    pub heading_rad: f64,
    /// Whether the limits on the slope allowed the net climb.
    pub climb_reached: bool,
    /// The given route that it is, from 1; none where it is drawn.
    pub route: Option<NonZeroU32>,
}

/// Sampler of all that the road type decides along the road; types in the order of their names.
#[derive(Clone, Debug)]
pub struct RoadSampler {
    chain: RoadTypeChain,
    sign_chains: Vec<SpeedSignChain>,
    legal_mps: Vec<f64>,
    types: Vec<RoadTypeModel>,
    model: RoadModel,
}

impl RoadModel {
    /// The rules between its numbers, and with the typical length of a mission, in m.
    pub fn validate(&self, mission_length_m: f64, problems: &mut Problems) {
        problems.require(!self.types.is_empty(), "types", "empty", "at least one road type");
        for (name, road_type) in &self.types {
            problems.part(&format!("types.{name}"), |problems| {
                let is_free = is_road_type_name(name);
                let allowed = "a name that does not begin with `kind_`, as columns of records do";
                problems.require(is_free, "", format!("`{name}`"), allowed);
                road_type.validate(name, self, problems);
            });
        }
        let limits = self.types.values().map(|road_type| road_type.topography.slope_limit);
        let steepest = limits.fold(0.0, f64::max);
        let climb_m = self.net_climb_m.centre().abs();
        problems.require(
            self.climb_rule == ClimbRule::Free || climb_m <= steepest * mission_length_m,
            "net_climb_m",
            climb_m,
            "at most the largest slope_limit of the road types times mission.length_m",
        );
    }
}

impl RoadTypeModel {
    /// The rules of the type of a name, one of those of a road.
    fn validate(&self, name: &str, road: &RoadModel, problems: &mut Problems) {
        let sum: f64 = self.next.values().sum();
        problems.require(
            if road.types.len() > 1 { (sum - 1.0).abs() < 1e-6 } else { sum == 0.0 },
            "next",
            format!("a sum of {sum}"),
            "a sum of 1 over the other road types (empty where there is only one)",
        );
        for (next, share) in &self.next {
            let known = road.types.contains_key(next) && (next != name || *share == 0.0);
            problems.require(known, "next", format!("`{next}`"), "another road type of this study");
        }
        problems.require(
            self.minimum_length_m < self.mean_length_m,
            "minimum_length_m",
            self.minimum_length_m,
            "below mean_length_m",
        );
        problems.part("speed_signs", |problems| self.speed_signs.validate(problems));
        problems.require_sum_of_one("ground", self.ground.values().sum());
        let hill_length_m = self.topography.hill_length_m;
        problems.require(
            hill_length_m > 4.0 * road.slope_step_m,
            "topography.hill_length_m",
            hill_length_m,
            "above 4 times road.slope_step_m",
        );
    }
}

impl RoadSampler {
    /// Prepares a checked model for vehicles of a class.
    pub fn new(model: &RoadModel, class: VehicleClass) -> Self {
        let types: Vec<RoadTypeModel> = model.types.values().cloned().collect();
        let names: Vec<&String> = model.types.keys().collect();
        let next = types
            .iter()
            .map(|t| names.iter().map(|n| t.next.get(*n).copied().unwrap_or(0.0)).collect())
            .collect();
        let chain = RoadTypeChain::new(
            types.iter().map(|t| t.mean_length_m).collect(),
            types.iter().map(|t| t.minimum_length_m).collect(),
            next,
        );
        Self {
            chain,
            sign_chains: types.iter().map(|t| t.speed_signs.chain()).collect(),
            legal_mps: types.iter().map(|t| class.limit_mps(t)).collect(),
            types,
            model: model.clone(),
        }
    }

    /// The road types, in the order of their names.
    pub fn types(&self) -> &[RoadTypeModel] {
        &self.types
    }

    /// Limit of the law on a road type, by its number, for the study's vehicles beside the signs,
    /// in m/s; infinite where there is none.
    pub fn legal_mps(&self, road_type: usize) -> f64 {
        self.legal_mps[road_type]
    }

    /// Step of the slope, in m.
    pub fn slope_step_m(&self) -> f64 {
        self.model.slope_step_m
    }

    /// Length of a roughness block, in m.
    pub fn roughness_block_m(&self) -> f64 {
        self.model.roughness_block_m
    }

    /// Long-run share of each type by length.
    pub fn share_by_length(&self) -> &[f64] {
        self.chain.share_by_length()
    }

    /// Draws a road into `road`, whose buffers are reused. `mission_stops` are placed first; the
    /// parts in `without` are left out, and no other draw changes. (An event that is gone makes
    /// room: what it had pushed out by the spacing of events, or by its turn, comes back.)
    pub fn sample(
        &self,
        length_m: f64,
        mission_stops: &[PointEvent],
        streams: &Streams,
        without: &[ModelSwitch],
        road: &mut Road,
    ) {
        let has = |part| !without.contains(&part);
        road.length_m = length_m;
        road.slope_step_m = self.model.slope_step_m;
        road.roughness_block_m = self.model.roughness_block_m;
        road.sections = self.sample_sections(length_m, streams);
        self.sample_signs(streams, road);
        self.sample_events(mission_stops, &[], streams, without, road);
        road.curves.clear();
        if has(ModelSwitch::Curves) {
            self.sample_curves(streams, road);
        }
        self.sample_slopes(streams, without, road);

        self.sample_roughness(streams, road);
        self.sample_grounds(streams, road);
        road.heading_rad = Self::sample_heading_rad(streams);
    }

    /// See [`RoadTypeChain::expected_lengths_m`]; none where trucks have mixes of their own.
    pub fn expected_lengths_m(&self, step_m: f64, steps: usize) -> Option<Vec<Vec<f64>>> {
        let one_mix = self.model.truck_mix_log_sd.is_none();
        one_mix.then(|| self.chain.expected_lengths_m(step_m, steps))
    }

    /// Draws the stretches of road types alone.
    pub fn sample_sections(&self, length_m: f64, streams: &Streams) -> Vec<Section> {
        let mut draws = streams.open(Stream::RoadType);
        match self.model.truck_mix_log_sd {
            None => self.chain.sample(length_m, &mut draws),
            Some(log_sd) => self.chain.of_truck(log_sd, streams).sample(length_m, &mut draws),
        }
    }

    /// The law of the road types of signs that are known; none where trucks have mixes of their
    /// own, and each a law.
    pub fn types_of_signs(&self, limits: &[(f64, f64)], length_m: f64) -> Option<TypesOfSigns> {
        let one_mix = self.model.truck_mix_log_sd.is_none();
        one_mix.then(|| TypesOfSigns::new(&self.chain, &self.sign_chains, limits, length_m))
    }

    /// Draws the road types of signs that are known, by their law where it is prepared.
    pub fn sample_types_of_signs(
        &self,
        law: Option<&TypesOfSigns>,
        limits: &[(f64, f64)],
        length_m: f64,
        streams: &Streams,
    ) -> Vec<Section> {
        let mut draws = streams.open(Stream::RoadType);
        if let Some(law) = law {
            return law.sample(&mut draws);
        }
        let chain = match self.model.truck_mix_log_sd {
            None => &self.chain,
            Some(log_sd) => &self.chain.of_truck(log_sd, streams),
        };
        TypesOfSigns::new(chain, &self.sign_chains, limits, length_m).sample(&mut draws)
    }

    /// Draws the signs of a road whose sections are known.
    pub fn sample_signs(&self, streams: &Streams, road: &mut Road) {
        let mut draws = streams.open(Stream::SpeedSign);
        road.signs.clear();
        for section in &road.sections {
            self.sign_chains[section.road_type].sample(section, &mut draws, &mut road.signs);
        }
    }

    /// Draws the compass heading at the start, in rad from north, clockwise.
    pub fn sample_heading_rad(streams: &Streams) -> f64 {
        TAU * streams.open(Stream::Heading).uniform()
    }

    /// Draws the roughness of a road whose sections are known.
    pub fn sample_roughness(&self, streams: &Streams, road: &mut Road) {
        let mut draws = streams.open(Stream::Roughness);
        let blocks = &mut road.roughness_m3;
        blocks.clear();
        for section in &road.sections {
            let model = &self.types[section.road_type].roughness;
            model.sample(self.model.roughness_block_m, section.end_m, &mut draws, blocks);
        }
    }

    /// Draws the ground of a road whose sections are known.
    pub fn sample_grounds(&self, streams: &Streams, road: &mut Road) {
        let mut draws = streams.open(Stream::Ground);
        let ground = |section: &Section| {
            let model = &self.types[section.road_type].ground;
            let weights: Vec<f64> = model.values().copied().collect();
            *model.keys().nth(draws.index(&weights)).expect("a ground model is not empty")
        };
        road.grounds = road.sections.iter().map(ground).collect();
    }

    /// Draws the events of a road whose sections are known, of all kinds that none of the `given`
    /// ones is of, and away from those.
    pub fn sample_events(
        &self,
        mission_stops: &[PointEvent],
        given: &[PointEvent],
        streams: &Streams,
        without: &[ModelSwitch],
        road: &mut Road,
    ) {
        road.events.clear();
        road.events.extend_from_slice(mission_stops);
        for kind in KINDS {
            let is_known = given.iter().any(|event| kind.includes(&event.kind));
            let model = kind.model.filter(|model| !without.contains(&model.switch) && !is_known);
            let Some(model) = model else { continue };
            let mut draws = streams.open(model.stream);
            for section in &road.sections {
                let road_type = &self.types[section.road_type];
                (model.sample)(road_type, section, &mut draws, &mut road.events);
            }
        }
        let (spacing_m, free_m) = (self.model.event_spacing_m, self.model.event_free_end_m);
        road.events.retain(|event| {
            let near = |given: &PointEvent| (given.position_m - event.position_m).abs() < spacing_m;
            matches!(event.kind, EventKind::MissionStop { .. }) || !given.iter().any(near)
        });
        space_out(&mut road.events, road.length_m, spacing_m, free_m);
    }

    /// Draws the curves of a road whose signs and events are known.
    pub fn sample_curves(&self, streams: &Streams, road: &mut Road) {
        let mut draws = streams.open(Stream::Curve);
        let mut sign = 0;
        for section in &road.sections {
            let model = &self.types[section.road_type].curves;
            while sign < road.signs.len() && road.signs[sign].start_m < section.end_m {
                let here = road.signs[sign];
                let end_m = road.signs.get(sign + 1).map_or(section.end_m, |next| next.start_m);
                model.sample(here.start_m, end_m, here.speed_mps, &mut draws, &mut road.curves);
                sign += 1;
            }
        }
        // a turn belongs to its place, so that it stays when another event goes
        let mut draws = streams.open(Stream::JunctionTurn);
        let turns: Vec<Curve> = road
            .events
            .iter()
            .filter(|event| event.turns)
            .map(|event| {
                let draws = draws.at(event.position_m as u64);
                self.model.junction_turn.sample(event.position_m, draws)
            })
            .collect();
        merge_turns(&mut road.curves, &turns);
        while road.curves.last().is_some_and(|curve| curve.start_m >= road.length_m) {
            road.curves.pop();
        }
        if let Some(last) = road.curves.last_mut() {
            last.end_m = last.end_m.min(road.length_m);
        }
    }

    /// Draws the slopes of a road whose sections are known.
    pub fn sample_slopes(&self, streams: &Streams, without: &[ModelSwitch], road: &mut Road) {
        let step_m = self.model.slope_step_m;
        if without.contains(&ModelSwitch::Slope) {
            road.slopes.clear();
            road.slopes.resize(libm::ceil(road.length_m / step_m) as usize, 0.0);
            road.climb_reached = true;
            return;
        }
        let mut draws = streams.open(Stream::Topography);
        let model = |section: &Section| &self.types[section.road_type].topography;
        sample_slopes(model, step_m, &road.sections, &mut draws, &mut road.slopes);
        road.climb_reached = true;
        if self.model.climb_rule == ClimbRule::Bridge {
            let net_climb_m = self.model.net_climb_m.sample(&mut draws);
            let count = road.slopes.len();
            let limit = |section: &Section| {
                let end = (libm::ceil(section.end_m / step_m) as usize).min(count);
                (end, model(section).slope_limit)
            };
            let limits: Vec<(usize, f64)> = road.sections.iter().map(limit).collect();
            road.climb_reached =
                bridge(&mut road.slopes, step_m, road.length_m, net_climb_m, &limits);
        }
    }
}
