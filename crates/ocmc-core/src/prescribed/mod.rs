//! Prescribed speed: the exact backward force balance of a drive cycle, without a driver, for
//! comparison with tools that have none.
//!
//! Over each step the vehicle is taken at its mean speed: F = (m + J_w/r²) a + drag + rolling +
//! grade, with a = Δv/Δt; the driveline gives what it can, the brakes take the rest. What the
//! engine cannot give is counted and reported, and the speed is kept all the same: a
//! prescribed-speed tool does not slow down. This is the quasi-static convention of FASTSim and
//! VECTO; finer steps make it exact.
//!
//! Air is still and of one density: drive cycles know no place. The fuel is what the map says at
//! the step's mean engine speed.

mod drive_cycle;
mod planned;

pub use drive_cycle::{CycleStep, DriveCycle, DriveCycleError};
pub use planned::planned_cycle;

use crate::breakdown::Breakdown;
use crate::energy::ledger::{Ledger, Mode, Term};
use crate::powertrain::{InversePowertrain, Powertrain, PowertrainTask, ShiftConvention};
use crate::record::{Outcome, Record};
use crate::study::{Scenario, Study};
use crate::vehicle::Vehicle;
use crate::vehicle::resistance::{
    DragBySpeed, GRAVITY_MPS2, drag_force_n, rolling_temperature_factor, rolling_wet_factor,
};
use std::sync::Arc;

/// A vehicle as the road sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Mass, in kg.
    pub mass_kg: f64,
    /// Inertia of the wheels as a mass at the rim, in kg.
    pub wheel_mass_kg: f64,
    /// Drag area, in m².
    pub drag_area_m2: f64,
    /// Its change with speed.
    pub drag_by_speed: DragBySpeed,
    /// Rolling coefficient, temperature and wet road included.
    pub rolling_coefficient: f64,
    /// Density of the air, in kg/m³.
    pub air_density_kgpm3: f64,
}

/// Forces on a body at a speed and on a slope, in N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoadForces {
    /// Force of the air, in N.
    pub drag_n: f64,
    /// Force of the tyres, in N.
    pub rolling_n: f64,
    /// Force of gravity, in N.
    pub grade_n: f64,
}

impl RoadForces {
    /// Their sum, in N.
    pub fn sum_n(&self) -> f64 {
        self.drag_n + self.rolling_n + self.grade_n
    }
}

impl Body {
    /// The truck of a scenario with its payload, in the air of its departure.
    pub fn of(study: &Study, scenario: &Scenario) -> Self {
        let (vehicle, shared) = (&scenario.vehicle, study.vehicle());
        let weather = &scenario.cycle.weather[0].weather;
        let temperature = rolling_temperature_factor(
            weather.temperature_k,
            shared.model.rolling_temperature_coefficient_per_k,
        );
        let wet = rolling_wet_factor(weather.precipitation_mps, weather.snow);
        Self {
            mass_kg: vehicle.mass_kg,
            wheel_mass_kg: shared.model.wheel_mass_kg(),
            drag_area_m2: vehicle.drag_area_m2,
            drag_by_speed: shared.drag_by_speed,
            rolling_coefficient: vehicle.rolling_coefficient * temperature * wet,
            air_density_kgpm3: weather.air_density_kgpm3(0.0),
        }
    }

    /// The forces at a speed in m/s; `slope`: climb per metre of road.
    pub fn road_forces(&self, speed_mps: f64, slope: f64) -> RoadForces {
        let half_density = 0.5 * self.air_density_kgpm3;
        let area_m2 = self.drag_area_m2 * self.drag_by_speed.factor(speed_mps);
        let weight_n = self.mass_kg * GRAVITY_MPS2;
        RoadForces {
            drag_n: drag_force_n(half_density, speed_mps, 0.0, area_m2),
            rolling_n: weight_n * (1.0 - slope * slope).sqrt() * self.rolling_coefficient,
            grade_n: weight_n * slope,
        }
    }
}

/// Totals of a drive cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct FollowedCycle {
    /// The integrals.
    pub ledger: Ledger<f64>,
    /// Duration, in s.
    pub duration_s: f64,
    /// Time at rest, in s.
    pub standstill_s: f64,
    /// Stops: times that the vehicle comes to rest, the last one excluded.
    pub n_stops: u32,
    /// Kinetic energy at the end less at the start, in J.
    pub kinetic_j: f64,
    /// Sum of the climbs, in m.
    pub climb_m: f64,
    /// Work at the shaft of engine or motor in the steps in which it drives, in J.
    pub driving_j: f64,
}

/// Follows a cycle with a body and a powertrain.
pub fn follow(
    cycle: &DriveCycle,
    body: &Body,
    powertrain: &mut dyn InversePowertrain,
) -> FollowedCycle {
    follow_observed(cycle, body, powertrain, &mut |_, _| ())
}

/// As [`follow`]; after each step `observe` is shown it and the integrals so far.
pub fn follow_observed(
    cycle: &DriveCycle,
    body: &Body,
    powertrain: &mut dyn InversePowertrain,
    observe: &mut dyn FnMut(&CycleStep, &Ledger<f64>),
) -> FollowedCycle {
    let mut ledger = Ledger::EMPTY;
    let (mut standstill_s, mut n_stops, mut kinetic_j, mut climb_m) = (0.0, 0_u32, 0.0, 0.0);
    let (mut moving, mut driving_j) = (false, 0.0);
    let before_j = powertrain.kinetic_j();
    let rotating_kg = powertrain.rotating_mass_kg();
    let inertia_kg = body.mass_kg + (body.wheel_mass_kg + rotating_kg);
    for step in cycle.steps() {
        let CycleStep { speed, slope } = step;
        let (v, distance_m) = (speed.mean_mps(), speed.distance_m());
        let RoadForces { drag_n, rolling_n, grade_n } = body.road_forces(v, slope);
        let wanted_n = inertia_kg * speed.acceleration_mps2() + drag_n + rolling_n + grade_n;
        let done = powertrain.step(&speed, wanted_n, &mut ledger);
        driving_j += done.shaft_j.max(0.0);

        if distance_m > 0.0 {
            let brake_n = (done.wheel_n - wanted_n).max(0.0);
            let engine_brake_n = brake_n.min(done.engine_brake_reach_n);
            // at the hubs: what speeds up the motor does not come through them
            let hub_n = done.wheel_n - rotating_kg * speed.acceleration_mps2();
            ledger[Term::Wheel] += hub_n.max(0.0) * distance_m;
            ledger[Term::EngineBrake] += engine_brake_n * distance_m;
            ledger[Term::ServiceBrake] += (brake_n - engine_brake_n) * distance_m;
            ledger[Term::Missing] += (wanted_n - done.wheel_n).max(0.0) * distance_m;
            if done.limited {
                ledger[Term::Limited] += speed.dt_s;
            }
        } else {
            standstill_s += speed.dt_s;
        }
        if moving && speed.end_mps <= 0.0 {
            n_stops += 1;
        }
        moving = speed.end_mps > 0.0;
        ledger[Term::Distance] += distance_m;
        ledger[Term::Drag] += drag_n * distance_m;
        ledger[Term::Rolling] += rolling_n * distance_m;
        ledger[Term::Grade] += grade_n * distance_m;
        climb_m += slope.max(0.0) * distance_m;
        kinetic_j += inertia_kg * speed.acceleration_mps2() * distance_m;
        observe(&step, &ledger);
    }
    // the end of the trip is no stop
    if !moving {
        n_stops = n_stops.saturating_sub(1);
    }
    let duration_s = cycle.duration_s();
    ledger[Term::Time] = duration_s;
    kinetic_j += powertrain.kinetic_j() - before_j;
    FollowedCycle { ledger, duration_s, standstill_s, n_stops, kinetic_j, climb_m, driving_j }
}

/// Follows a cycle with the truck, payload and air of one cycle of a study. Drivers, roads and
/// traffic have no part in it.
pub fn follow_study(
    study: &Study,
    seed: u64,
    cycle_id: u64,
    cycle: &DriveCycle,
) -> (Record, FollowedCycle) {
    let scenario = study.sample(seed, cycle_id);
    follow_scenario(study, &scenario, cycle, ShiftConvention::default())
}

/// Follows the speed that the driver of one cycle of a study wants along its road, exactly. Air is
/// that of the departure, the road smooth.
pub fn follow_planned(study: &Study, seed: u64, cycle_id: u64) -> (Record, FollowedCycle) {
    let scenario = study.sample(seed, cycle_id);
    let cycle = planned_cycle(study, &scenario);
    follow_scenario(study, &scenario, &cycle, ShiftConvention::default())
}

/// Follows a cycle with a truck that has been drawn.
pub fn follow_scenario(
    study: &Study,
    scenario: &Scenario,
    cycle: &DriveCycle,
    convention: ShiftConvention,
) -> (Record, FollowedCycle) {
    let vehicle = &scenario.vehicle;
    let body = Body::of(study, scenario);
    let weather = &scenario.cycle.weather[0].weather;
    let mission = &scenario.cycle.mission;
    // without a driver what a record says of the driver and of the road is none
    let known = Record {
        cycle_id: scenario.cycle_id,
        truck_id: scenario.trip.truck_id,
        trip: scenario.trip.trip,
        route_id: scenario.cycle.road.route.map(|route| route.get() - 1),
        payload_kg: mission.payload_kg,
        mean_payload_kg: mission.payload_kg,
        payload_cut_kg: scenario.payload_cut_kg,
        breakdown: study
            .breakdown()
            .map_or_else(Breakdown::default, |columns| Breakdown::new(Arc::clone(columns), None)),
        air_temperature_k: weather.temperature_k,
        departure_s_of_year: mission.day_of_year * 86_400.0 + mission.departure_s,
        departure_charge: vehicle.initial_charge,
        drag_area_m2: vehicle.drag_area_m2,
        rolling_coefficient: vehicle.rolling_coefficient,
        ..Record::default()
    };
    let task = FollowTask { vehicle, cycle, body, convention, known };
    let (mut record, followed) = study.vehicle().powertrain.dispatch(task);
    study.emission_factors().fill(&mut record);
    (record, followed)
}

/// Follows a cycle with the powertrain of a study.
struct FollowTask<'a> {
    vehicle: &'a Vehicle,
    cycle: &'a DriveCycle,
    body: Body,
    convention: ShiftConvention,
    /// Values of a record beside those of the cycle.
    known: Record,
}

impl PowertrainTask for FollowTask<'_> {
    type Answer = (Record, FollowedCycle);

    fn run<P: Powertrain>(self, powertrain: &P) -> Self::Answer {
        let climate_w = powertrain.climate_w(self.known.air_temperature_k);
        let mut inverse = powertrain.inverse(&self.vehicle.powertrain_inputs(climate_w));
        inverse.set_convention(self.convention);
        let followed = follow(self.cycle, &self.body, &mut *inverse);
        let depleted = inverse.depleted_s() > 0.0;
        let known = Record {
            outcome: if depleted { Outcome::Depleted } else { Outcome::Completed },
            duration_s: followed.duration_s,
            standstill_s: followed.standstill_s,
            n_stops: followed.n_stops,
            n_gear_shifts: inverse.n_shifts(),
            climb_m: followed.climb_m,
            kinetic_change_j: followed.kinetic_j,
            ..self.known
        };
        let ledger = &followed.ledger;
        let mut record = Record::from_ledger(known, ledger, Mode::Followed, inverse.terms());
        inverse.record(ledger, &mut record);
        record.take_all(Mode::Followed);
        (record, followed)
    }
}
