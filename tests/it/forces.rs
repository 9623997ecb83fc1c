//! Forces, pedals and fuel of single rows of a trace, each against its formula.

use crate::common::{GivenRoad, column, diesel, typical};
use ocmc_core::kernel::drive::trace::trace_scenario;
use ocmc_core::operating_cycle::weather::{STANDARD_WEATHER, Weather};
use ocmc_core::vehicle::resistance::GRAVITY_MPS2;

#[test]
fn tyres_bound_the_brake() {
    // friction 0.8 on a dry road, 0.25 on snow; a driver who wants 4 m/s² at once
    let wet = Weather { precipitation_mps: 1e-7, ..STANDARD_WEATHER };
    let snow = Weather { snow: true, ..wet };
    for (weather, friction) in [(STANDARD_WEATHER, 0.8), (wet, 0.5), (snow, 0.25)] {
        for slope in [0.0, -0.1] {
            let study = typical(&[
                "driver.speed_change.deceleration_mps2=4.0",
                "driver.pedals.pid.proportional_median=1.0",
                "vehicle.brakes.full_deceleration_mps2=9.0",
                "road.types.motorway.topography.slope_limit=0.2",
                "simulation.step_s=0.05",
            ]);
            let mut scenario = GivenRoad::flat(1000.0, 22.0).slope(slope).scenario(&study);
            scenario.cycle.weather[0].weather = weather;
            let mass_kg = scenario.vehicle.mass_kg;
            let trace = trace_scenario(&study, scenario);
            let [way, service, engine] =
                ["distance_added_m", "service_brake_energy_added_j", "engine_brake_energy_added_j"]
                    .map(|name| column(&trace, name));
            let force =
                |k: usize| if way[k] > 0.0 { (service[k] + engine[k]) / way[k] } else { 0.0 };
            let most_n = (0..way.len()).map(force).fold(0.0, f64::max);
            let grip_n = mass_kg * GRAVITY_MPS2 * friction * (1.0f64 - slope * slope).sqrt();
            if friction == 0.25 {
                assert!((most_n / grip_n - 1.0).abs() < 1e-9, "{slope}: {most_n} {grip_n}");
            } else {
                assert!(most_n < grip_n * (1.0 + 1e-9), "{friction}: {most_n} {grip_n}");
            }
        }
    }
}

#[test]
fn the_engine_brakes_first_with_its_power_at_the_square_of_its_speed() {
    let study = typical(&[
        "simulation.step_s=0.05",
        "road.types.motorway.topography.slope_limit=0.2",
        "driver.speed_change.deceleration_mps2=1.0",
    ]);
    let brakes = study.model().vehicle.brakes.clone();
    let scenario = GivenRoad::flat(3000.0, 20.0).slope(-0.09).scenario(&study);
    let trace = trace_scenario(&study, scenario);
    let [dt, engine_radps, engine, service] = [
        "step_s",
        "engine_speed_radps",
        "engine_brake_energy_added_j",
        "service_brake_energy_added_j",
    ]
    .map(|name| column(&trace, name));
    let mut rows = 0;
    for k in 1..dt.len() {
        let change = engine_radps[k] - engine_radps[k - 1];
        // the service brakes take only what the engine cannot; while gears change it is not there
        // and where a ramp begins, they do not brake all along the row
        let along = service[k - 1] > 0.0 && engine[k - 1] > 0.0;
        if along && service[k] > 0.0 && engine[k] > 0.0 && change.abs() < 0.5 {
            let mean_radps = engine_radps[k] - 0.5 * change;
            let share = mean_radps / brakes.engine_brake_speed_radps;
            let wanted_w = brakes.engine_brake_power_w * share * share;
            let found_w = engine[k] / dt[k];
            assert!((found_w / wanted_w - 1.0).abs() < 0.01, "{found_w} {wanted_w}");
            rows += 1;
        }
    }
    assert!(rows > 100, "{rows}");
}

#[test]
fn drag_in_a_cross_wind_is_the_formula_with_the_increment_up_to_its_largest_angle() {
    let study = typical(&["simulation.step_s=0.1", "road.types.motorway.wind_exposure=1.0"]);
    let mut scenario = GivenRoad::flat(3000.0, 70.0 / 3.6).stop(700.0, 5.0).scenario(&study);
    // 5.5 m/s from the front and 6 m/s from the side: 45 degrees at rest, 13.5 degrees at 70 km/h
    let wind = Weather {
        wind_speed_mps: 5.5f64.hypot(6.0),
        wind_direction_rad: 6.0f64.atan2(5.5),
        ..STANDARD_WEATHER
    };
    scenario.cycle.weather[0].weather = wind;
    let (area_m2, half_density) =
        (scenario.vehicle.drag_area_m2, 0.5 * wind.air_density_kgpm3(0.0));
    let trace = trace_scenario(&study, scenario);
    let [speed, way, work] =
        ["speed_mps", "distance_added_m", "drag_energy_added_j"].map(|name| column(&trace, name));
    let cross_wind = &study.model().vehicle.cross_wind;
    let (mut held, mut below) = (0, 0);
    for k in (1..way.len()).filter(|k| way[*k] > 1e-3) {
        let relative_mps = 0.5 * (speed[k - 1] + speed[k]) + 5.5;
        let angle_deg = (6.0 / relative_mps).atan().to_degrees();
        // the step has a polynomial in the tangent, within 0.0015 m² of this
        let increment_m2 = cross_wind.increment_m2(angle_deg);
        let square = relative_mps * relative_mps + 36.0;
        let wanted = half_density * square * (area_m2 + increment_m2);
        let found = work[k] / way[k];
        assert!((found / wanted - 1.0).abs() < 1e-3, "{angle_deg}: {found} {wanted}");
        *(if angle_deg > 14.0 { &mut held } else { &mut below }) += 1;
    }
    assert!(held > 100 && below > 100, "{held} {below}");
}

#[test]
fn the_limiter_takes_the_pedal_back_over_its_range() {
    // 25 to 25.5 m/s; the driver wants 28 m/s
    let study = typical(&[
        "driver.speed_limit.maximum_speed_mps=28",
        "road.types.motorway.truck_limit_mps=40",
        "driver.speed_change.peak_acceleration_ratio=100",
        "simulation.step_s=0.1",
    ]);
    let road = GivenRoad { payload_kg: 0.0, ..GivenRoad::flat(5000.0, 130.0 / 3.6).slope(-0.005) };
    let trace = trace_scenario(&study, road.scenario(&study));
    let [speed, desired, accelerator] =
        ["speed_mps", "desired_speed_mps", "accelerator"].map(|name| column(&trace, name));
    let mut limited = 0;
    for k in 1..speed.len() {
        // far below the desired speed nothing but the limiter takes the pedal back
        if speed[k] > 24.0 && desired[k] > 27.0 {
            let allowed = ((25.5 - speed[k]) / 0.5).clamp(0.0, 1.0);
            assert!((accelerator[k] - allowed).abs() < 0.02, "{} {allowed}", accelerator[k]);
            limited += usize::from(allowed < 0.95);
        }
    }
    assert!(limited > 100, "{limited}");
}

#[test]
fn a_standing_engine_burns_what_its_auxiliaries_take() {
    let study = typical(&[]);
    let scenario = GivenRoad::flat(1000.0, 50.0 / 3.6).stop(500.0, 60.0).scenario(&study);
    let vehicle = scenario.vehicle;
    let trace = trace_scenario(&study, scenario);
    let stop = column(&trace, "step_s").iter().position(|dt| *dt == 60.0).unwrap();
    let drive = diesel(&study);
    let idle_radps = drive.engine_model.idle_speed_radps;
    let rate_kgps = drive.engine.fuel_kgps(idle_radps, vehicle.auxiliary_power_w / idle_radps);
    let wanted_kg = rate_kgps * vehicle.map_factor * 60.0;
    let found_kg = column(&trace, "fuel_added_kg")[stop];
    assert!((found_kg / wanted_kg - 1.0).abs() < 1e-12, "{found_kg} {wanted_kg}");
}
