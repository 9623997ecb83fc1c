//! Prescribed speed: the exact backward force balance of a drive cycle, without a driver, for comparison with tools that have none.
//!
//! Over each step the vehicle is taken at its mean speed: F = (m + J_w/r²) a + drag + rolling + grade, with a = Δv/Δt; the driveline gives what it
//! can, the brakes take the rest. What the engine cannot give is counted and reported, and the speed is kept all the same: a
//! prescribed-speed tool does not slow down. This is the quasi-static convention of FASTSim and VECTO; finer steps make it exact.
//!
//! Air is still and of one density: drive cycles know no place. The fuel is what the map says at the step's mean engine speed.

mod drive_cycle;
mod driveline;
mod electric;
mod planned;

pub use drive_cycle::{CycleStep, DriveCycle, DriveCycleError};
pub use driveline::EfficiencyDriveline;
pub use electric::ElectricSums;
pub use planned::planned_cycle;

use crate::kernel::record::{Outcome, Record};
use crate::powertrain::battery_electric::BatteryElectricPowertrain;
use crate::study::{Scenario, Study};
use crate::vehicle::resistance::{
    GRAVITY_MPS2, drag_force_n, rolling_temperature_factor, rolling_wet_factor,
};
use crate::vehicle::{DieselPowertrain, PowertrainKind, Vehicle};
use driveline::{DrivelineStep, GearedDriveline};
use electric::ElectricDriveline;

/// A vehicle as the road sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Mass, in kg.
    pub mass_kg: f64,
    /// Inertia of the wheels as a mass at the rim, in kg.
    pub wheel_mass_kg: f64,
    /// Drag area, in m².
    pub drag_area_m2: f64,
    /// Rolling coefficient, temperature and wet road included.
    pub rolling_coefficient: f64,
    /// Density of the air, in kg/m³.
    pub air_density_kgpm3: f64,
}

/// What a drive cycle takes, in J unless a name says otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Followed {
    /// Distance, in m.
    pub distance_m: f64,
    /// Duration, in s.
    pub duration_s: f64,
    /// Time at rest, in s.
    pub standstill_s: f64,
    /// Stops: times that the vehicle comes to rest, the last one excluded.
    pub n_stops: u32,
    /// Gear shifts.
    pub n_shifts: u32,
    /// Positive work of the driveline at the wheels.
    pub wheel_j: f64,
    /// Work against the air.
    pub drag_j: f64,
    /// Work against rolling resistance.
    pub rolling_j: f64,
    /// Work against gravity.
    pub grade_j: f64,
    /// Work of the service brakes.
    pub service_brake_j: f64,
    /// Work of the engine brake.
    pub engine_brake_j: f64,
    /// Kinetic energy at the end less at the start, engine included.
    pub kinetic_j: f64,
    /// Work of the engine at the crankshaft.
    pub crankshaft_j: f64,
    /// Work of the auxiliaries.
    pub auxiliary_j: f64,
    /// Loss of the slipping clutch.
    pub clutch_j: f64,
    /// Loss of gearbox, retarder and axle.
    pub transmission_j: f64,
    /// Kinetic energy of the engine lost in jumps of its speed, signed.
    pub shift_j: f64,
    /// Energy of the fuel.
    pub fuel_j: f64,
    /// Time at the engine's limit, in s: the cycle asked for more than it can.
    pub limited_s: f64,
    /// Work at the wheels that the engine could not give.
    pub missing_j: f64,
    /// Time that engine or motor spent beyond the points of its map, in s.
    pub outside_map_s: f64,
    /// Sum of the climbs, in m.
    pub climb_m: f64,
    /// What the battery and the motor did; none for an engine.
    pub electric: Option<ElectricSums>,
}

/// Follows a cycle with a vehicle of which only efficiencies are known.
pub fn follow(cycle: &DriveCycle, body: &Body, driveline: &EfficiencyDriveline) -> Followed {
    balance(cycle, body, |step, force_n| driveline.step(step, force_n))
}

/// The force balance over a cycle; `carry` is the driveline.
fn balance(
    cycle: &DriveCycle,
    body: &Body,
    mut carry: impl FnMut(&CycleStep, f64) -> DrivelineStep,
) -> Followed {
    let mut sum = Followed { duration_s: cycle.duration_s(), ..Followed::default() };
    let mut moving = false;
    let inertia_kg = body.mass_kg + body.wheel_mass_kg;
    for step in cycle.steps() {
        let (v, way_m) = (step.mean_mps(), step.distance_m());
        let half_density = 0.5 * body.air_density_kgpm3;
        let drag_n = drag_force_n(half_density, v, 0.0, body.drag_area_m2);
        let cosine = (1.0 - step.slope * step.slope).sqrt();
        let rolling_n = body.mass_kg * GRAVITY_MPS2 * cosine * body.rolling_coefficient;
        let grade_n = body.mass_kg * GRAVITY_MPS2 * step.slope;
        let wanted_n = inertia_kg * step.acceleration_mps2() + drag_n + rolling_n + grade_n;
        let done = carry(&step, wanted_n);

        if way_m > 0.0 {
            let brake_n = (done.wheel_n - wanted_n).max(0.0);
            let engine_brake_n = brake_n.min(done.engine_brake_reach_n);
            sum.wheel_j += done.wheel_n.max(0.0) * way_m;
            sum.engine_brake_j += engine_brake_n * way_m;
            sum.service_brake_j += (brake_n - engine_brake_n) * way_m;
            sum.missing_j += (wanted_n - done.wheel_n).max(0.0) * way_m;
            if done.limited {
                sum.limited_s += step.dt_s;
            }
        } else {
            sum.standstill_s += step.dt_s;
        }
        if done.outside_map {
            sum.outside_map_s += step.dt_s;
        }
        if moving && step.end_mps <= 0.0 {
            sum.n_stops += 1;
        }
        moving = step.end_mps > 0.0;
        sum.distance_m += way_m;
        sum.drag_j += drag_n * way_m;
        sum.rolling_j += rolling_n * way_m;
        sum.grade_j += grade_n * way_m;
        sum.climb_m += step.slope.max(0.0) * way_m;
        sum.kinetic_j += inertia_kg * step.acceleration_mps2() * way_m;
        sum.crankshaft_j += done.crankshaft_j;
        sum.auxiliary_j += done.auxiliary_j;
        sum.clutch_j += done.clutch_j;
        sum.transmission_j += done.transmission_j;
        sum.shift_j += done.shift_j;
        sum.fuel_j += done.fuel_j;
    }
    // the end of the trip is no stop
    if !moving {
        sum.n_stops = sum.n_stops.saturating_sub(1);
    }
    sum
}

/// Follows a cycle with the truck, payload and air of one cycle of a study. Drivers, roads and traffic have no part in it.
pub fn follow_study(
    study: &Study,
    seed: u64,
    cycle_id: u64,
    cycle: &DriveCycle,
) -> (Record, Followed) {
    follow_scenario(study, &study.sample(seed, cycle_id), cycle)
}

/// Follows the speed that the driver of one cycle of a study wants along its road, exactly. Air is that of the departure, the road smooth.
pub fn follow_planned(study: &Study, seed: u64, cycle_id: u64) -> (Record, Followed) {
    let scenario = study.sample(seed, cycle_id);
    follow_scenario(study, &scenario, &planned_cycle(study, &scenario))
}

fn follow_scenario(study: &Study, scenario: &Scenario, cycle: &DriveCycle) -> (Record, Followed) {
    let (vehicle, model) = (&scenario.vehicle, &study.vehicle().model);
    let weather = &scenario.cycle.weather[0].weather;
    let temperature = rolling_temperature_factor(
        weather.temperature_k,
        model.rolling_temperature_coefficient_per_k,
    );
    let wet = rolling_wet_factor(weather.precipitation_mps, weather.snow);
    let body = Body {
        mass_kg: vehicle.mass_kg,
        wheel_mass_kg: model.wheel_mass_kg(),
        drag_area_m2: vehicle.drag_area_m2,
        rolling_coefficient: vehicle.rolling_coefficient * temperature * wet,
        air_density_kgpm3: weather.air_density_kgpm3(0.0),
    };
    let mission = &scenario.cycle.mission;
    // nobody drives: what a record says of the driver and of the road is none
    let plain = Record {
        cycle_id: scenario.cycle_id,
        payload_kg: mission.payload_kg,
        air_temperature_k: weather.temperature_k,
        departure_s_of_year: mission.day_of_year * 86_400.0 + mission.departure_s,
        drag_area_m2: vehicle.drag_area_m2,
        rolling_coefficient: vehicle.rolling_coefficient,
        ..Record::default()
    };
    match &study.vehicle().powertrain {
        PowertrainKind::Diesel(diesel) => {
            follow_with_engine(study, diesel, scenario, cycle, &body, &plain)
        }
        PowertrainKind::BatteryElectric(electric) => {
            follow_with_battery(electric, model.wheel_radius_m, vehicle, cycle, &body, &plain)
        }
    }
}

fn follow_with_engine(
    study: &Study,
    diesel: &DieselPowertrain,
    scenario: &Scenario,
    cycle: &DriveCycle,
    body: &Body,
    plain: &Record,
) -> (Record, Followed) {
    let mut driveline = GearedDriveline::new(study.vehicle(), diesel, &scenario.vehicle);
    let before_j = driveline.kinetic_j();
    let mut sum = balance(cycle, body, |step, force_n| driveline.step(step, force_n));
    sum.kinetic_j += driveline.kinetic_j() - before_j;
    sum.n_shifts = driveline.n_shifts;
    let fuel = &diesel.engine_model.fuel;
    let fuel_kg = sum.fuel_j / fuel.heating_value_jpkg;
    let per_100km = sum.per_m(fuel_kg / fuel.density_kgpm3 * 1000.0).map(|per_m| per_m * 1e5);
    let payload_t = plain.payload_kg / 1000.0;
    let record = Record {
        fuel_kg: Some(fuel_kg),
        consumption_l_per_100km: per_100km,
        consumption_l_per_100tkm: per_100km.filter(|_| payload_t > 0.0).map(|all| all / payload_t),
        co2_g_per_km: sum.per_m(fuel_kg * fuel.co2_kg_per_kg).map(|per_m| per_m * 1e6),
        fuel_energy_j: Some(sum.fuel_j),
        engine_loss_j: Some(sum.fuel_j - sum.crankshaft_j),
        crankshaft_work_j: Some(sum.crankshaft_j),
        clutch_loss_j: Some(sum.clutch_j),
        engine_brake_energy_j: Some(sum.engine_brake_j),
        ..sum.record(plain)
    };
    (record, sum)
}

fn follow_with_battery(
    electric: &BatteryElectricPowertrain,
    wheel_radius_m: f64,
    vehicle: &Vehicle,
    cycle: &DriveCycle,
    body: &Body,
    plain: &Record,
) -> (Record, Followed) {
    let charge = vehicle.initial_charge.unwrap_or(0.0);
    let climate = electric.model.climate.as_ref();
    let climate_w = climate.map_or(0.0, |c| c.power_w(plain.air_temperature_k));
    let auxiliary_w = vehicle.auxiliary_power_w + climate_w;
    let mut driveline = ElectricDriveline::new(electric, wheel_radius_m, auxiliary_w, charge);
    let rotating_kg = driveline.rotating_mass_kg();
    let body = Body { wheel_mass_kg: body.wheel_mass_kg + rotating_kg, ..*body };
    let mut sum = balance(cycle, &body, |step, force_n| driveline.step(step, force_n));
    sum.n_shifts = driveline.n_shifts;
    let sums = driveline.electric;
    sum.electric = Some(sums);
    let depleted = sums.depleted_s > 0.0;
    let record = Record {
        outcome: if depleted { Outcome::Depleted } else { Outcome::Completed },
        battery_energy_j: Some(sums.store_j),
        battery_loss_j: Some(sums.battery_loss_j),
        motor_loss_j: Some(sums.motor_loss_j),
        regenerated_energy_j: Some(sums.regenerated_j),
        charged_energy_j: Some(sums.charged_j),
        charging_loss_j: Some(sums.charging_loss_j),
        final_charge: Some(sums.final_charge),
        consumption_kwh_per_km: sum.per_m(sums.store_j).map(|per_m| per_m / 3600.0),
        ..sum.record(plain)
    };
    (record, sum)
}

impl Followed {
    /// An amount per metre; none where nothing moved.
    fn per_m(&self, amount: f64) -> Option<f64> {
        (self.distance_m > 0.0).then(|| amount / self.distance_m)
    }

    /// The columns that every vehicle has.
    fn record(&self, plain: &Record) -> Record {
        Record {
            distance_m: self.distance_m,
            duration_s: self.duration_s,
            standstill_s: self.standstill_s,
            simulated_s: self.duration_s,
            mean_speed_mps: self.distance_m / self.duration_s,
            n_stops: self.n_stops,
            n_gear_shifts: self.n_shifts,
            wheel_energy_j: self.wheel_j,
            brake_energy_j: self.service_brake_j + self.engine_brake_j,
            auxiliary_energy_j: self.auxiliary_j,
            // a column without null: 0, as in the closed loop
            wheel_kwh_per_km: self.per_m(self.wheel_j).unwrap_or(0.0) / 3600.0,
            climb_m: self.climb_m,
            transmission_loss_j: self.transmission_j,
            drag_energy_j: self.drag_j,
            rolling_energy_j: self.rolling_j,
            service_brake_energy_j: self.service_brake_j,
            // a motor's speed does not jump here: its inertia moves with the mass
            shift_loss_j: Some(self.shift_j),
            kinetic_change_j: self.kinetic_j,
            potential_change_j: self.grade_j,
            moving_s: self.duration_s - self.standstill_s,
            limited_s: Some(self.limited_s),
            missing_energy_j: Some(self.missing_j),
            outside_map_s: Some(self.outside_map_s),
            ..plain.clone()
        }
    }
}
