//! The study: the one place that knows all domains.
//!
//! [`StudyModel`] is the study file as it is written; [`Study`] is a checked one, prepared for
//! sampling.

mod check;
pub mod fleet;
pub mod handover;
pub mod keys;
pub mod outline;
pub mod tree;
pub mod uncertainty;

pub use crate::validation::Problem;
pub use check::{StudyError, Unusual, outside_bounds, outside_usual};

use crate::breakdown::{Axis, BreakdownColumns, Part};
use crate::charging::{Charger, ChargingPolicy};
use crate::cost::CostModel;
use crate::cost::emissions::EmissionFactors;
use crate::driver::{Driver, DriverModel};
use crate::energy::emission_model::EmissionModel;
use crate::event_kind::Kind;
use crate::operating_cycle::drawn_part::Draw;
use crate::operating_cycle::given::{GivenCycle, GivenCycleError};
use crate::operating_cycle::mission::MissionModel;
use crate::operating_cycle::mission_part::MissionPart;
use crate::operating_cycle::road::RoadModel;
use crate::operating_cycle::road::point_event::Passage;
use crate::operating_cycle::route::{Keep, Route};
use crate::operating_cycle::traffic::TrafficModel;
use crate::operating_cycle::weather::WeatherModel;
use crate::operating_cycle::{OperatingCycle, OperatingCycleSampler};
use crate::random::nesting::{Nesting, Trip};
use crate::random::sampling::Sampling;
use crate::random::{Factor, PickFreeze, Stream, Streams};
use crate::rest::RestModel;
use crate::switch::ModelSwitch;
use crate::vehicle::resistance::GRAVITY_MPS2;
use crate::vehicle::{Vehicle, VehicleModel, VehicleParameters};
use fleet::FleetModel;
use handover::Handover;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use uncertainty::Estimates;

/// A study file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyModel {
    /// Name, description and base of the study.
    pub study: Description,
    /// Length, payload, departure, stops.
    pub mission: MissionModel,
    /// Road types and what is on them.
    pub road: RoadModel,
    /// Weather.
    pub weather: WeatherModel,
    /// Traffic.
    pub traffic: TrafficModel,
    /// Drivers.
    pub driver: DriverModel,
    /// Vehicles.
    pub vehicle: VehicleModel,
    /// Numerics and switches.
    #[serde(default)]
    pub simulation: SimulationModel,
    /// Standard errors of numbers of the study that are estimates, by the name of the estimation.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub uncertainty: BTreeMap<String, Estimates>,
    /// Trucks that make several trips, their drivers and their days.
    #[serde(default, skip_serializing_if = "FleetModel::is_absent")]
    pub fleet: FleetModel,
    /// Prices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost: Option<CostModel>,
    /// Greenhouse gases from the well to the wheel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub emissions: Option<EmissionModel>,
    /// Rests that the law asks of drivers; absent: none are taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest: Option<RestModel>,
    /// Charging of battery trucks; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub charging: Option<ChargingPolicy>,
}

/// Name, description and sources of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// Name; it appears in answers and manifests.
    pub name: String,
    /// Description of the study, in one line.
    pub description: String,
    /// Where its numbers come from, one source an entry. May be left out.
    #[serde(default)]
    pub sources: Vec<String>,
}

/// Numerics and switches: the only table of a study with silent defaults.
///
/// | Name | Default | Purpose |
/// |---|---|---|
/// | `step_s` | 1.5 | longest time step: that of a truck whose acceleration is steady |
/// | `longest_duration_s` | 172800 | a cycle that drives longer is `timed_out` |
/// | `stall_time_s`, `stall_distance_m` | 60, 1 | less progress than this in this time is `stalled` |
/// | `capture_distance_m` | 0.5 | a truck this close to its stop line has stopped |
/// | `creep_distance_m`, `creep_speed_mps` | 3, 0.3 | so has a slower truck this close |
/// | `without` | none | parts that are turned off |
/// | `frozen` | none | factors that every cycle takes from cycle 0 |
/// | `sampling` | `independent` | whether batches of cycles spread evenly |
/// | `columns_by` | `road_type` | what records break cycles down by |
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SimulationModel {
    /// Longest time step, in s: that of a truck whose acceleration is steady.
    #[schemars(range(min = 0.0005, max = 2.0))]
    pub step_s: f64,
    /// Driving time after which a cycle is given up, in s.
    #[schemars(range(min = 10.0, max = 1.0e8))]
    pub longest_duration_s: f64,
    /// Time without progress after which a truck has stalled, in s.
    #[schemars(range(min = 5.0, max = 86_400.0))]
    pub stall_time_s: f64,
    /// Progress that a truck has to make in that time, in m.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub stall_distance_m: f64,
    /// Distance from a stop line at which a truck has stopped, in m.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub capture_distance_m: f64,
    /// Distance from a stop line at which a slow truck has stopped, in m.
    #[schemars(range(min = 0.05, max = 10.0))]
    pub creep_distance_m: f64,
    /// Speed below which a truck is slow, in m/s.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub creep_speed_mps: f64,
    /// Parts that are turned off.
    pub without: Vec<ModelSwitch>,
    /// Factors that every cycle takes from cycle 0.
    pub frozen: Vec<Factor>,
    /// Whether batches of cycles spread evenly over the numbers that describe a whole cycle.
    pub sampling: Sampling,
    /// By which parts the records break each cycle down: columns of distance, time, work at the
    /// wheels and fuel or electricity.
    pub columns_by: Vec<Axis>,
}

impl SimulationModel {
    /// The short step as a share of the longest one.
    pub const SHORT_STEP_SHARE: f64 = 0.25;

    /// Step that may always be taken but right after a jump of the pedals, in s.
    pub fn short_step_s(&self) -> f64 {
        Self::SHORT_STEP_SHARE * self.step_s
    }
}

impl Default for SimulationModel {
    fn default() -> Self {
        Self {
            step_s: 1.5,
            longest_duration_s: 172_800.0,
            stall_time_s: 60.0,
            stall_distance_m: 1.0,
            capture_distance_m: 0.5,
            creep_distance_m: 3.0,
            creep_speed_mps: 0.3,
            without: Vec::new(),
            frozen: Vec::new(),
            sampling: Sampling::Independent,
            columns_by: vec![Axis::RoadType],
        }
    }
}

/// A checked study, prepared for sampling.
#[derive(Clone, Debug)]
pub struct Study {
    model: StudyModel,
    operating_cycle: OperatingCycleSampler,
    vehicle: VehicleParameters,
    road_types: Vec<String>,
    stability_limit: f64,
    nesting: Nesting,
    breakdown: Option<Arc<BreakdownColumns>>,
    emission_factors: EmissionFactors,
}

/// One cycle to be driven: operating cycle, driver and vehicle.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Index of the cycle in the run.
    pub cycle_id: u64,
    /// Its truck, its driver, and which trip of the truck it is.
    pub trip: Trip,
    /// Road, weather, traffic, mission.
    pub cycle: OperatingCycle,
    /// The driver.
    pub driver: Driver,
    /// Standard normal residual of each curve.
    pub curve_residuals: Vec<f64>,
    /// The truck, with the payload of its departure.
    pub vehicle: Vehicle,
    /// The truck behind the stops at which its load changes or its body works, in order.
    pub loads: Vec<Load>,
    /// Driving time of its driver at departure without a break, in s.
    pub driven_before_s: f64,
    /// Mass by which the legal gross mass cut the payload that was drawn, in kg.
    pub payload_cut_kg: f64,
    /// Public chargers along the way, in order; none for a truck without a battery.
    pub chargers: Vec<Charger>,
    /// State that the truck brings from the trip before; none where each trip stands alone.
    pub handover: Option<Handover>,
}

/// A truck from a stop of its mission on.
#[derive(Clone, Copy, Debug)]
pub struct Load {
    /// The part of the mission that begins there.
    pub part: MissionPart,
    /// The truck with the payload of this part.
    pub vehicle: Vehicle,
}

impl Scenario {
    /// The load that begins at a stop; none where nothing changes there.
    pub fn load_from(&self, stop_m: f64) -> Option<&Load> {
        self.loads.iter().find(|load| load.part.start_m == stop_m)
    }

    /// The truck as it is loaded at a place.
    pub fn vehicle_at(&self, position_m: f64) -> &Vehicle {
        let before = self.loads.partition_point(|load| load.part.start_m <= position_m);
        before.checked_sub(1).map_or(&self.vehicle, |k| &self.loads[k].vehicle)
    }

    /// Energy of a way that does not depend on its consumption, in J: the potential energy of its
    /// climb, and the work of the body at the stops on it. `climb_m`: the whole climb, in m.
    pub fn fixed_energy_j(&self, [from_m, to_m]: [f64; 2], climb_m: f64) -> f64 {
        let lifted_j = |vehicle: &Vehicle, climb_m| vehicle.mass_kg * GRAVITY_MPS2 * climb_m;
        let within = |at_m: f64| at_m > from_m && at_m <= to_m;
        let road = &self.cycle.road;
        let (mut at_m, mut left_m, mut sum_j) = (from_m, climb_m, 0.0);
        for load in self.loads.iter().filter(|load| within(load.part.start_m)) {
            let next_m = load.part.start_m;
            let climbed_m = road.climb_m([at_m, next_m]);
            sum_j += lifted_j(self.vehicle_at(at_m), climbed_m) + load.part.power_take_off_j();
            (at_m, left_m) = (next_m, left_m - climbed_m);
        }
        sum_j + lifted_j(self.vehicle_at(at_m), left_m)
    }

    /// How this vehicle passes an event of the road.
    pub fn passage(&self, event: usize) -> Passage {
        let stops = self.vehicle.stops_at_railway_crossings;
        self.cycle.road.events[event].kind.passage_of(stops)
    }
}

/// The columns that the breakdown of a study has; its parts are in the order of their numbers.
fn breakdown_columns(model: &StudyModel, road_types: &[String]) -> Option<Arc<BreakdownColumns>> {
    let by = &model.simulation.columns_by;
    let part = |axis: Axis, name: String| Part { axis, name };
    let mut parts = Vec::new();
    if by.contains(&Axis::RoadType) {
        parts.extend(road_types.iter().map(|name| part(Axis::RoadType, name.clone())));
    }
    if by.contains(&Axis::EventKind) {
        parts.extend(Kind::ALL.map(|kind| part(Axis::EventKind, kind.name().to_owned())));
    }
    let carriers = model.vehicle.powertrain.carriers();
    (!parts.is_empty()).then(|| Arc::new(BreakdownColumns::new(parts, carriers)))
}

impl Study {
    /// Checks a study file and prepares it.
    ///
    /// # Errors
    /// [`StudyError`] lists every value that is out of its bounds or does not fit the others.
    pub fn new(model: StudyModel) -> Result<Self, StudyError> {
        check::check(&model)?;
        let operating_cycle = OperatingCycleSampler::new(
            &model.road,
            &model.weather,
            &model.traffic,
            &model.mission,
            model.vehicle.class,
        );
        let mut vehicle = model.vehicle.prepare();
        if let Some(charging) = &model.charging {
            vehicle.powertrain.follow(charging);
        }
        let road_types: Vec<String> = model.road.types.keys().cloned().collect();
        // brake stability limit: 5 m/s² × brake scale × K_P × step <= 1
        let brake = model.vehicle.brakes.full_deceleration_mps2 * model.driver.pedals.brake_scale;
        let stability_limit = 1.0 / (brake * model.simulation.short_step_s());
        let nesting = model.fleet.nesting();
        let breakdown = breakdown_columns(&model, &road_types);
        let StudyModel { emissions, cost, charging, .. } = &model;
        let plugs_in = model.vehicle.powertrain.plugs_in();
        let emission_factors =
            EmissionFactors::of(emissions.as_ref(), cost.as_ref(), charging.as_ref(), plugs_in);
        Ok(Self {
            model,
            operating_cycle,
            vehicle,
            road_types,
            stability_limit,
            nesting,
            breakdown,
            emission_factors,
        })
    }

    /// Drives given cycles instead of drawn roads, each with its weight, what it keeps of its file
    /// and what is drawn where its file lacks it.
    ///
    /// # Errors
    /// The number of the cycle, from 0, and what does not fit this study.
    pub fn with_routes(
        mut self,
        cycles: Vec<(GivenCycle, f64, Vec<Keep>, Vec<Draw>)>,
    ) -> Result<Self, (usize, GivenCycleError)> {
        let mut routes = Vec::with_capacity(cycles.len());
        let public = self.model.charging.as_ref().and_then(|charging| charging.public.as_ref());
        for (k, (cycle, weight, keep, draw)) in cycles.into_iter().enumerate() {
            let length_m = cycle.length_m;
            if let Some(position_m) = public.and_then(|public| public.beyond(length_m)) {
                return Err((k, GivenCycleError::ChargerBeyond { position_m, length_m }));
            }
            let road = self.operating_cycle.road();
            let route = Route::new(cycle, weight, &keep, &draw, &self.road_types, road);
            routes.push(route.map_err(|error| (k, error))?);
        }
        self.operating_cycle.routes = routes;
        Ok(self)
    }

    /// The same roads, given ones among them, with other numbers.
    ///
    /// # Errors
    /// [`StudyError`], as of [`Study::new`].
    pub fn with_model(&self, model: StudyModel) -> Result<Self, StudyError> {
        let mut study = Self::new(model)?;
        study.operating_cycle.routes.clone_from(&self.operating_cycle.routes);
        Ok(study)
    }

    /// The study as it is written.
    pub fn model(&self) -> &StudyModel {
        &self.model
    }

    /// The operating-cycle models.
    pub fn operating_cycle(&self) -> &OperatingCycleSampler {
        &self.operating_cycle
    }

    /// Parameters that all trucks share.
    pub fn vehicle(&self) -> &VehicleParameters {
        &self.vehicle
    }

    /// How cycles belong to trucks, drivers and days.
    pub fn nesting(&self) -> &Nesting {
        &self.nesting
    }

    /// Whether the trips of a truck chain.
    pub fn chains(&self) -> bool {
        self.model.fleet.calendar.as_ref().is_some_and(|calendar| calendar.chain)
    }

    /// Names of the road types, in the order of their numbers.
    pub fn road_types(&self) -> &[String] {
        &self.road_types
    }

    /// The columns of the breakdown of its cycles, where it has any.
    pub fn breakdown(&self) -> Option<&Arc<BreakdownColumns>> {
        self.breakdown.as_ref()
    }

    /// Factors from litres and kWh to greenhouse gases.
    pub fn emission_factors(&self) -> &EmissionFactors {
        &self.emission_factors
    }

    /// Draws the scenario of one cycle: a pure function of (study, seed, cycle id).
    pub fn sample(&self, seed: u64, cycle_id: u64) -> Scenario {
        self.sample_pick_freeze(seed, cycle_id, PickFreeze::NONE)
    }

    /// As [`Study::sample`], some of the streams taken from the second sample.
    pub fn sample_pick_freeze(
        &self,
        seed: u64,
        cycle_id: u64,
        pick_freeze: PickFreeze,
    ) -> Scenario {
        self.sample_into(seed, cycle_id, pick_freeze, OperatingCycle::default())
    }

    /// As [`Study::sample`], into a scenario whose buffers are reused.
    pub fn resample(&self, seed: u64, cycle_id: u64, scenario: &mut Scenario) {
        let cycle = std::mem::take(&mut scenario.cycle);
        *scenario = self.sample_into(seed, cycle_id, PickFreeze::NONE, cycle);
    }

    /// Draws the driver of one cycle.
    fn sample_driver(&self, streams: &Streams) -> Driver {
        let limiter_mps = self.model.vehicle.limiter_speed_mps;
        let without = &self.model.simulation.without;
        self.model.driver.sample(streams, without, self.stability_limit, limiter_mps)
    }

    /// Where the draws of one cycle come from.
    pub(crate) fn streams(&self, seed: u64, cycle_id: u64, pick_freeze: PickFreeze) -> Streams<'_> {
        let SimulationModel { frozen, sampling, .. } = &self.model.simulation;
        let nesting = &self.nesting;
        Streams { seed, cycle_id, frozen, pick_freeze, sampling: *sampling, nesting }
    }

    fn sample_into(
        &self,
        seed: u64,
        cycle_id: u64,
        pick_freeze: PickFreeze,
        mut cycle: OperatingCycle,
    ) -> Scenario {
        let simulation = &self.model.simulation;
        let streams = self.streams(seed, cycle_id, pick_freeze);
        self.operating_cycle.sample(&streams, &simulation.without, &mut cycle);
        let driver = self.sample_driver(&streams);
        // a residual belongs to the curve's place, so that it stays when another curve goes
        let mut draws = streams.open(Stream::CurveResidual);
        let curve_residuals =
            cycle.road.curves.iter().map(|c| draws.at(c.start_m as u64).normal()).collect();
        let drawn_kg = cycle.mission.payload_kg;
        let payload_kg = drawn_kg.min(self.model.vehicle.most_payload_kg());
        cycle.mission.payload_kg = payload_kg;
        let vehicle = self.model.vehicle.sample(payload_kg, &streams, &simulation.without);
        let most_kg = self.model.vehicle.most_payload_kg();
        let load = |part: &mut MissionPart| {
            part.payload_kg = part.payload_kg.min(most_kg);
            let vehicle = self.model.vehicle.loaded(&vehicle, part.payload_kg);
            Load { part: *part, vehicle }
        };
        let loads = cycle.mission.parts.iter_mut().map(load).collect();
        let trip = streams.trip();
        let driven_before_s = self.model.rest.as_ref().map_or(0.0, |rest| rest.sample(&streams));
        let chargers = self.chargers(&cycle, &streams);
        Scenario {
            cycle_id,
            trip,
            cycle,
            driver,
            curve_residuals,
            vehicle,
            loads,
            driven_before_s,
            payload_cut_kg: drawn_kg - payload_kg,
            chargers,
            handover: None,
        }
    }

    /// Draws the public chargers that a battery truck meets.
    fn chargers(&self, cycle: &OperatingCycle, streams: &Streams) -> Vec<Charger> {
        let public = self.model.charging.as_ref().and_then(|charging| charging.public.as_ref());
        let Some(public) = public.filter(|_| self.vehicle.powertrain.plugs_in()) else {
            return Vec::new();
        };
        let events_m: Vec<f64> = cycle.road.events.iter().map(|event| event.position_m).collect();
        public.sample(cycle.road.length_m, &events_m, streams)
    }
}
