//! Prescribed speed: the exact backward force balance of a drive cycle, without a driver, for comparison with tools that have none.
//!
//! Over each step the vehicle is taken at its mean speed: F = (m + J_w/r²) a + drag + rolling + grade, with a = Δv/Δt; the driveline gives what it
//! can, the brakes take the rest. What the engine cannot give is counted and reported, and the speed is kept all the same: a
//! prescribed-speed tool does not slow down. This is the quasi-static convention of FASTSim and VECTO; finer steps make it exact.
//!
//! Air is still and of one density: drive cycles know no place. The fuel is what the map says at the step's mean engine speed.

mod drive_cycle;
mod driveline;

pub use drive_cycle::{DriveCycle, DriveCycleError, DriveStep};
pub use driveline::EfficiencyDriveline;

use crate::simulation::record::{Outcome, Record};
use crate::study::Study;
use crate::vehicle::resistance::{
    GRAVITY_MPS2, drag_force_n, rolling_temperature_factor, rolling_wet_factor,
};
use driveline::{DrivelineStep, GearedDriveline};

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
    /// Sum of the climbs, in m.
    pub climb_m: f64,
}

/// Follows a cycle with a vehicle of which only efficiencies are known.
pub fn follow(cycle: &DriveCycle, body: &Body, driveline: &EfficiencyDriveline) -> Followed {
    balance(cycle, body, |step, force_n| driveline.step(step, force_n))
}

/// The force balance over a cycle; `carry` is the driveline.
fn balance(
    cycle: &DriveCycle,
    body: &Body,
    mut carry: impl FnMut(&DriveStep, f64) -> DrivelineStep,
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
    let scenario = study.sample(seed, cycle_id);
    let (vehicle, model) = (&scenario.vehicle, &study.powertrain().model);
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
    let mut driveline = GearedDriveline::new(study.powertrain(), vehicle);
    let before_j = driveline.kinetic_j();
    let mut sum = balance(cycle, &body, |step, force_n| driveline.step(step, force_n));
    sum.kinetic_j += driveline.kinetic_j() - before_j;
    sum.n_shifts = driveline.n_shifts;
    let fuel = &model.engine.fuel;
    let fuel_kg = sum.fuel_j / fuel.heating_value_jpkg;
    let per_distance =
        |amount: f64| if sum.distance_m > 0.0 { amount / sum.distance_m } else { 0.0 };
    let per_100km = per_distance(fuel_kg / fuel.density_kgpm3 * 1000.0) * 1e5;
    let mission = &scenario.cycle.mission;
    let payload_t = mission.payload_kg / 1000.0;
    let record = Record {
        cycle_id,
        outcome: Outcome::Completed,
        distance_m: sum.distance_m,
        duration_s: sum.duration_s,
        standstill_s: sum.standstill_s,
        simulated_s: sum.duration_s,
        mean_speed_mps: sum.distance_m / sum.duration_s,
        n_stops: sum.n_stops,
        n_gear_shifts: sum.n_shifts,
        wheel_energy_j: sum.wheel_j,
        brake_energy_j: sum.service_brake_j + sum.engine_brake_j,
        auxiliary_energy_j: sum.auxiliary_j,
        fuel_kg: Some(fuel_kg),
        consumption_l_per_100km: Some(per_100km),
        consumption_l_per_100tkm: (payload_t > 0.0).then(|| per_100km / payload_t),
        wheel_kwh_per_km: per_distance(sum.wheel_j) / 3600.0,
        co2_g_per_km: Some(per_distance(fuel_kg * fuel.co2_kg_per_kg) * 1e6),
        climb_m: sum.climb_m,
        payload_kg: mission.payload_kg,
        air_temperature_k: weather.temperature_k,
        fuel_energy_j: Some(sum.fuel_j),
        engine_loss_j: Some(sum.fuel_j - sum.crankshaft_j),
        crankshaft_work_j: Some(sum.crankshaft_j),
        transmission_loss_j: sum.transmission_j,
        shift_loss_j: Some(sum.shift_j),
        clutch_loss_j: Some(sum.clutch_j),
        drag_energy_j: sum.drag_j,
        rolling_energy_j: sum.rolling_j,
        service_brake_energy_j: sum.service_brake_j,
        engine_brake_energy_j: Some(sum.engine_brake_j),
        kinetic_change_j: sum.kinetic_j,
        potential_change_j: sum.grade_j,
        moving_s: sum.duration_s - sum.standstill_s,
        departure_s_of_year: mission.day_of_year * 86_400.0 + mission.departure_s,
        drag_area_m2: vehicle.drag_area_m2,
        rolling_coefficient: vehicle.rolling_coefficient,
        ..Record::default()
    };
    (record, sum)
}
