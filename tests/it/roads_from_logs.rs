//! From a study to logs and back to its roads: trucks are driven, their traces written as a logger
//! would, the roads found in them, and the road model fitted. It has to be the one that drew the
//! roads.

use ocmc_core::kernel::drive::trace::trace;
use ocmc_core::operating_cycle::coverage::Coverage;
use ocmc_core::operating_cycle::road::point_event::{KINDS, PointEvent};
use ocmc_core::study::Study;
use ocmc_estimation::fit::operating_cycle::{Density, Hilliness, RoadFit, fit_with_coverage};
use ocmc_estimation::fit::study_parameter::StudyParameterFit;
use ocmc_estimation::log::TripLog;
use ocmc_estimation::log::road::{LoggedRoad, RoadLog, RoadOptions, roads};
use ocmc_io::study::load_text;

const TRUCKS: u64 = 24;
const SEED: u64 = 1;
const RATE_HZ: f64 = 10.0;
/// Rows this close to an object of the map name it, in m.
const AT_OBJECT_M: f64 = 15.0;

/// Towns and country roads. No sign above the legal speed of trucks, which a trace shows instead of
/// it; curves far enough apart that two of one direction are seldom taken for one.
const ROADS: &str = r#"
[study]
name = "roads"
base = "field-truck"
drop = ["road.types.motorway", "road.types.rural.next", "road.types.urban.next", "traffic.types.motorway",
        "road.types.rural.speed_signs", "road.types.urban.speed_signs"]
[mission]
length_m = 100.0e3
payload_kg = 0.0
[road.types.urban]
next = { rural = 1.0 }
[road.types.urban.speed_signs]
speed_kmh = [30.0, 50.0, 60.0]
share = [0.2, 0.6, 0.2]
mean_length_m = 600.0
similarity_kmh = 15.0
[road.types.urban.curves]
per_m = 0.1e-3
[road.types.rural]
next = { urban = 1.0 }
mean_length_m = 8.0e3
[road.types.rural.speed_signs]
speed_kmh = [50.0, 60.0, 70.0, 80.0]
share = [0.1, 0.1, 0.4, 0.4]
mean_length_m = 2500.0
similarity_kmh = 15.0
[road.types.rural.curves]
per_m = 0.2e-3
[simulation]
without = ["weather", "traffic", "vehicle_spread"]
"#;

/// Log of a truck's drive, ten times a second.
struct Logged {
    time_s: Vec<f64>,
    speed_mps: Vec<f64>,
    yaw_rate_radps: Vec<f64>,
    limit_mps: Vec<f64>,
    grade: Vec<f64>,
    position_m: Vec<f64>,
    road_type: Vec<String>,
    map_object: Vec<&'static str>,
}

fn logged(study: &Study, truck: u64) -> Logged {
    let trace = trace(study, SEED, truck);
    let column = |name: &str| -> &[f64] {
        &trace.columns.iter().find(|column| column.name == name).unwrap().values
    };
    let (time, step, position) = (column("time_s"), column("step_s"), column("position_m"));
    let (speed, yaw) = (column("speed_mps"), column("yaw_rate_radps"));
    let (limit, grade) = (column("limit_mps"), column("grade"));
    let road = study.sample(SEED, truck).cycle.road;
    let mut log = Logged {
        time_s: vec![],
        speed_mps: vec![],
        yaw_rate_radps: vec![],
        limit_mps: vec![],
        grade: vec![],
        position_m: vec![],
        road_type: vec![],
        map_object: vec![],
    };
    let mut row = 1;
    let (mut climb, mut climbed_at) = (0.0, 0.0);
    let rows = (time[time.len() - 1] * RATE_HZ) as usize;
    for k in 0..rows {
        let at_s = k as f64 / RATE_HZ;
        while row + 1 < time.len() && time[row] <= at_s {
            climb += grade[row] * (position[row] - position[row - 1]);
            row += 1;
        }
        let part = if step[row] > 0.0 {
            ((at_s - time[row - 1]) / step[row]).clamp(0.0, 1.0)
        } else {
            1.0
        };
        // a row at rest lasts as long as the truck stands
        let between = |values: &[f64]| {
            if speed[row] == 0.0 && position[row] == position[row - 1] {
                values[row]
            } else {
                values[row - 1] + part * (values[row] - values[row - 1])
            }
        };
        let at_m = between(position);
        let climb_now = climb + grade[row] * (at_m - position[row - 1]).max(0.0);
        let way = log.position_m.last().map_or(at_m, |last| at_m - last);
        let slope = if way > 0.0 { (climb_now - climbed_at) / way } else { 0.0 };
        climbed_at = climb_now;
        let section = road.sections.iter().rfind(|section| section.start_m <= at_m).unwrap();
        let object = road.events.iter().find(|event| (event.position_m - at_m).abs() < AT_OBJECT_M);
        log.time_s.push(at_s);
        log.speed_mps.push(between(speed));
        log.yaw_rate_radps.push(between(yaw));
        log.limit_mps.push(limit[row]);
        log.grade.push(slope);
        log.position_m.push(at_m);
        log.road_type.push(study.road_types()[section.road_type].clone());
        let declared = |event: &PointEvent| KINDS.iter().find(|kind| kind.includes(&event.kind));
        log.map_object.push(object.and_then(declared).map_or("", |kind| kind.map_object));
    }
    log
}

fn roads_of(log: &Logged) -> (Vec<LoggedRoad>, Coverage) {
    let found = roads(
        &RoadLog {
            drive: TripLog {
                time_s: log.time_s.as_slice().into(),
                speed_mps: log.speed_mps.as_slice().into(),
                yaw_rate_radps: log.yaw_rate_radps.as_slice().into(),
                limit_mps: Some(log.limit_mps.as_slice().into()),
                ..TripLog::default()
            },
            position_m: Some(log.position_m.as_slice().into()),
            grade: Some(log.grade.as_slice().into()),
            road_type: Some(log.road_type.iter().map(String::as_str).collect()),
            map_object: Some(log.map_object.clone()),
            ..RoadLog::default()
        },
        &RoadOptions::default(),
    )
    .unwrap();
    assert_eq!(found.roads.len(), 1);
    (found.roads, found.coverage)
}

/// All trucks, on two threads.
fn fitted(study: &Study) -> RoadFit {
    let halves = std::thread::scope(|scope| {
        let half = |parity: u64| {
            scope.spawn(move || {
                let trucks = (0..TRUCKS).filter(|truck| truck % 2 == parity);
                trucks.map(|truck| roads_of(&logged(study, truck))).collect::<Vec<_>>()
            })
        };
        let (even, odd) = (half(0), half(1));
        [even.join().unwrap(), odd.join().unwrap()]
    });
    let all: Vec<(Vec<LoggedRoad>, Coverage)> = halves.into_iter().flatten().collect();
    let coverage = all[0].1;
    let roads: Vec<LoggedRoad> = all.into_iter().flat_map(|(roads, _)| roads).collect();
    fit_with_coverage(&roads, &coverage, study.model()).unwrap()
}

fn parameter<'a>(fit: &'a RoadFit, road_type: &str, key: &str) -> &'a StudyParameterFit {
    let of_type = fit.types.iter().find(|of_type| of_type.road_type == road_type).unwrap();
    let found = of_type.parameters.iter().find(|parameter| parameter.key == key);
    found.unwrap_or_else(|| panic!("{road_type}: no {key} in {:?}", fit.warnings))
}

#[test]
fn the_roads_that_were_driven_come_back() {
    let loaded = load_text("roads", ROADS, &[] as &[&str]).unwrap();
    let fit = fitted(&loaded.study);
    // the truck is below 0.3 m/s for at most a second on either side of a standstill: it brakes and
    // starts with 0.3 m/s² and more
    let edge_s = 2.0;
    for (name, model) in &loaded.model.road.types {
        let curves = &model.curves;
        for (key, wanted, allowed) in [
            ("mean_length_m", model.mean_length_m, 0.0),
            ("speed_signs.mean_length_m", model.speed_signs.mean_length_m, 0.0),
            ("stop_signs.per_m", model.stop_signs.per_m, 0.0),
            ("stop_signs.standstill_s, mean", 5.0, edge_s),
            ("give_ways.per_m", model.give_ways.per_m, 0.0),
            ("give_ways.stop_probability", model.give_ways.stop_probability, 0.0),
            ("give_ways.wait_s, mean", 6.0, edge_s),
            ("traffic_lights.per_m", model.traffic_lights.per_m, 0.0),
            ("traffic_lights.red_probability", model.traffic_lights.red_probability, 0.0),
            ("traffic_lights.wait_s, mean", 20.0, edge_s),
            ("speed_bumps.per_m", model.speed_bumps.per_m, 0.0),
            ("curves.per_m", curves.per_m, 0.0),
            ("curves.sign_exponent", curves.sign_exponent, 0.0),
            ("curves.median_radius_m", curves.median_radius_m, 0.0),
            ("curves.radius_log_sd", curves.radius_log_sd, 0.0),
            ("curves.median_length_m", curves.median_length_m, 0.0),
            ("curves.length_log_sd", curves.length_log_sd, 0.0),
        ] {
            let found = parameter(&fit, name, key);
            let error = found.standard_error.unwrap();
            let off = (found.value - wanted).abs();
            assert!(off <= 4.0 * error + allowed, "{name}: {found:?}, wanted {wanted}");
        }
        // the bridge to the net climb moves the slopes by some per cent, as in the fit of tracks
        let topography = &model.topography;
        for (key, wanted) in [
            ("topography.slope_sd", topography.slope_sd),
            ("topography.hill_length_m", topography.hill_length_m),
        ] {
            let found = parameter(&fit, name, key);
            let off = (found.value - wanted).abs();
            let allowed = 4.0 * found.standard_error.unwrap() + 0.03 * wanted;
            assert!(off <= allowed, "{name}: {found:?}, wanted {wanted}");
        }
    }
    // what a log does not tell stays, and is said
    assert_eq!(fit.model.junction_turn, loaded.model.road.junction_turn);
    assert!(fit.warnings.iter().any(|text| text.starts_with("turns at junctions")));
    let view = &fit.birds_eye;
    let stops: f64 = loaded
        .model
        .road
        .types
        .iter()
        .map(|(name, road)| {
            let per_m = road.stop_signs.per_m
                + road.give_ways.per_m * road.give_ways.stop_probability
                + road.traffic_lights.per_m * road.traffic_lights.red_probability;
            1000.0 * per_m * view.road_type_share[name]
        })
        .sum();
    let error = (stops / 2400.0).sqrt();
    assert!((view.stops_per_km - stops).abs() < 4.0 * error, "{} {stops}", view.stops_per_km);
    assert_eq!(
        (view.hilliness, view.stop_density),
        (Some(Hilliness::PredominantlyFlat), Density::Medium)
    );
}
