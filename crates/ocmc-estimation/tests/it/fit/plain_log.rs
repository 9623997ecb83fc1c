//! Slopes and missions of plain logs: trucks drive on the roads of fleets with other laws than the
//! built-in ones, a logger writes time, position, speed and a noisy altitude each second, and the
//! laws come back.

use crate::common::field_truck;
use ocmc_core::distribution::{Law, Quantity};
use ocmc_core::operating_cycle::coverage::Coverage;
use ocmc_core::operating_cycle::mission::MissionStopModel;
use ocmc_core::random::{Draws, Stream};
use ocmc_core::study::Study;
use ocmc_estimation::fit::operating_cycle::{RoadFit, fit_with_coverage};
use ocmc_estimation::fit::study_parameter::StudyParameterFit;
use ocmc_estimation::log::TripLog;
use ocmc_estimation::log::road::{LoggedRoad, RoadLog, RoadOptions, roads};

/// SD and hill length, in m, of urban, rural and motorway roads of two fleets.
const FLEETS: [[(f64, f64); 3]; 2] = [
    [(0.009, 380.0), (0.031, 900.0), (0.014, 1600.0)],
    [(0.02, 520.0), (0.015, 640.0), (0.024, 1100.0)],
];
const TYPES: [&str; 3] = ["urban", "rural", "motorway"];

fn fleet(laws: &[(f64, f64); 3], length_m: f64) -> Study {
    field_truck(|model| {
        model.mission.length_m = Quantity::Number(length_m);
        for (name, (slope_sd, hill_length_m)) in TYPES.into_iter().zip(*laws) {
            let topography = &mut model.road.types.get_mut(name).unwrap().topography;
            (topography.slope_sd, topography.hill_length_m) = (slope_sd, hill_length_m);
        }
    })
}

/// Rows that a logger writes once a second.
#[derive(Clone, Default)]
struct Logged {
    time_s: Vec<f64>,
    position_m: Vec<f64>,
    speed_mps: Vec<f64>,
    altitude_m: Vec<f64>,
    road_type: Vec<String>,
}

/// A drive on a road of the study: speeds from 8 to 24 m/s, and a stop of up to 40 s about each 2
/// km. Altitudes scatter by `noise_m`, wander by `wander_m` each second, and have an error of
/// `drift_m` that fades over 30 s.
fn logged(study: &Study, seed: u64, id: u64, [noise_m, wander_m, drift_m]: [f64; 3]) -> Logged {
    let road = study.sample(seed, id).cycle.road;
    let mut draws = Draws::new(seed ^ 0xabcd, id, Stream::Vehicle);
    let mut log = Logged::default();
    let (mut at_m, mut speed_mps, mut wanders_m) = (0.0, 0.0, 0.0);
    let fades = f64::exp(-1.0 / 30.0);
    let mut drifts_m = if drift_m > 0.0 { drift_m * draws.normal() } else { 0.0 };
    let (mut wish_mps, mut wait_s) = (14.0, 0);
    let mut stop_m = 2000.0 * draws.exponential();
    while at_m < road.length_m {
        let section = road.sections.iter().rfind(|section| section.start_m <= at_m).unwrap();
        log.time_s.push(log.time_s.len() as f64);
        log.position_m.push(at_m);
        log.speed_mps.push(speed_mps);
        let error_m = wanders_m + drifts_m + noise_m * draws.normal();
        log.altitude_m.push(road.climb_m([0.0, at_m]) + error_m);
        log.road_type.push(study.road_types()[section.road_type].clone());
        wanders_m += wander_m * draws.normal();
        if drift_m > 0.0 {
            drifts_m = fades * drifts_m + (1.0 - fades * fades).sqrt() * drift_m * draws.normal();
        }
        if wait_s > 0 {
            wait_s -= 1;
            continue;
        }
        if at_m > stop_m {
            (speed_mps, wait_s) = (0.0, (40.0 * draws.uniform()) as u32);
            stop_m = at_m + 2000.0 * draws.exponential();
            wish_mps = 8.0 + 16.0 * draws.uniform();
            continue;
        }
        speed_mps = f64::min(speed_mps + 0.8, wish_mps);
        at_m += speed_mps;
    }
    log
}

/// The roads of a log, without the rows from one to before another.
fn roads_of(log: &Logged, average_m: f64, gap: [usize; 2]) -> (Vec<LoggedRoad>, Coverage) {
    let keep = |k: &usize| !(gap[0]..gap[1]).contains(k);
    let rows: Vec<usize> = (0..log.time_s.len()).filter(keep).collect();
    let of = |column: &[f64]| rows.iter().map(|k| column[*k]).collect::<Vec<f64>>().into();
    let road_log = RoadLog {
        drive: TripLog {
            time_s: of(&log.time_s),
            speed_mps: of(&log.speed_mps),
            yaw_rate_radps: vec![f64::NAN; rows.len()].into(),
            ..TripLog::default()
        },
        position_m: Some(of(&log.position_m)),
        altitude_m: Some(of(&log.altitude_m)),
        road_type: Some(rows.iter().map(|k| log.road_type[*k].as_str()).collect()),
        ..RoadLog::default()
    };
    let options = RoadOptions { altitude_average_m: average_m, ..RoadOptions::default() };
    let found = roads(&road_log, &options).unwrap();
    (found.roads, found.coverage)
}

fn fitted(study: &Study, logs: &[Logged], average_m: f64) -> RoadFit {
    let mut coverage = None;
    let mut all = Vec::new();
    for log in logs {
        let (roads, of) = roads_of(log, average_m, [0, 0]);
        coverage = Some(of);
        all.extend(roads);
    }
    // the built-in laws are where the search begins
    assert_eq!(study.road_types().len(), 3);
    fit_with_coverage(&all, &coverage.unwrap(), field_truck(|_| {}).model()).unwrap()
}

fn parameter<'a>(fit: &'a RoadFit, name: &str, key: &str) -> Option<&'a StudyParameterFit> {
    let of_type = fit.types.iter().find(|of_type| of_type.road_type == name)?;
    of_type.parameters.iter().find(|parameter| parameter.key == key)
}

#[test]
fn hills_do_not_follow_the_average_nor_the_noise() {
    for (laws, seed) in FLEETS.iter().zip([11, 12]) {
        let study = fleet(laws, 40.0e3);
        for (noise_m, drift_m) in [(0.0, 0.0), (4.0, 0.0), (0.0, 2.0)] {
            let logs: Vec<Logged> =
                (0..12).map(|id| logged(&study, seed, id, [noise_m, 0.0, drift_m])).collect();
            let fit = fitted(&study, &logs, 200.0);
            for (name, (sd, hill_m)) in TYPES.into_iter().zip(*laws) {
                for (key, truth) in
                    [("topography.slope_sd", sd), ("topography.hill_length_m", hill_m)]
                {
                    let found = parameter(&fit, name, key).unwrap();
                    let (value, error) = (found.value, found.standard_error.unwrap());
                    assert!(
                        (value - truth).abs() <= 4.0 * error,
                        "{noise_m} m, {drift_m} m {name}: {found:?}"
                    );
                    assert!(error < 0.25 * truth, "{noise_m} m, {drift_m} m {name}: {found:?}");
                }
            }
            if noise_m == 4.0 {
                // the average is for the road that is shown, not for its laws
                assert_eq!(fitted(&study, &logs, 25.0).types, fit.types);
            }
        }
    }
}

#[test]
fn what_is_stated_of_hills_is_how_they_scatter() {
    // sets of logs of two fleets with noise and a receiver that wanders, pooled
    let (mut covered, mut all) = (0, 0);
    let mut ratios = Vec::new();
    for (laws, seed) in FLEETS.iter().zip([100, 200]) {
        let study = fleet(laws, 40.0e3);
        let mut found = vec![Vec::new(); 6];
        for set in 0..8 {
            let log = |id: u64| logged(&study, seed, 10 * set + id, [3.0, 0.05, 0.0]);
            let logs: Vec<Logged> = (0..6).map(log).collect();
            let fit = fitted(&study, &logs, 200.0);
            for (k, name) in TYPES.into_iter().enumerate() {
                let truths = [laws[k].0, laws[k].1];
                for (j, key) in
                    ["topography.slope_sd", "topography.hill_length_m"].into_iter().enumerate()
                {
                    let Some(of) = parameter(&fit, name, key) else { continue };
                    let Some(error) = of.standard_error else { continue };
                    all += 1;
                    covered += usize::from((of.value - truths[j]).abs() <= 1.96 * error);
                    found[2 * k + j].push((of.value, error));
                }
            }
        }
        for values in found {
            let n = values.len() as f64;
            let mean = values.iter().map(|value| value.0).sum::<f64>() / n;
            let squares: f64 = values.iter().map(|value| (value.0 - mean).powi(2)).sum();
            let stated: f64 = values.iter().map(|value| value.1 * value.1).sum();
            ratios.push((stated / n).sqrt() / (squares / (n - 1.0)).sqrt());
        }
    }
    let share = covered as f64 / all as f64;
    // nothing is left out for being badly known
    assert!(all >= 88, "{all}");
    let reach = 4.0 * (0.95_f64 * 0.05 / all as f64).sqrt();
    assert!((share - 0.95).abs() < reach, "{covered} of {all}");
    let mean = ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64;
    // an SD of 8 values has an error of 27 %, their mean over 12 one of 8 %
    assert!(mean.abs() < 0.31, "{ratios:?}");
}

#[test]
fn a_gap_splits_no_mission() {
    let study = fleet(&FLEETS[0], 30.0e3);
    let logs: Vec<Logged> = (0..4).map(|id| logged(&study, 5, id, [1.0, 0.0, 0.0])).collect();
    let lengths = |gap: [usize; 2]| {
        let mut all = Vec::new();
        let mut coverage = Coverage::ALL;
        for log in &logs {
            let (roads, of) = roads_of(log, 200.0, gap);
            coverage = of;
            all.extend(roads);
        }
        let parts = all.len();
        let fit = fit_with_coverage(&all, &coverage, field_truck(|_| {}).model()).unwrap();
        let length = fit.mission.iter().find(|parameter| parameter.key == "length_m, mean");
        (parts, fit.cycles, length.unwrap().value)
    };
    let whole = lengths([0, 0]);
    assert_eq!((whole.0, whole.1), (4, 4));
    // five minutes without rows: two roads, one mission, whose length the positions tell
    let cut = lengths([600, 900]);
    assert_eq!((cut.0, cut.1), (8, 4));
    assert!((cut.2 - whole.2).abs() < 1e-6, "{cut:?} {whole:?}");
    // what is too short for a road counts for the mission
    let late = lengths([15, 400]);
    assert_eq!((late.0, late.1), (4, 4));
    assert!((late.2 - whole.2).abs() < 1e-6, "{late:?} {whole:?}");
}

#[test]
fn without_positions_a_gap_was_driven_at_the_mean_speed() {
    let study = fleet(&FLEETS[1], 30.0e3);
    let log = logged(&study, 6, 0, [1.0, 0.0, 0.0]);
    let rows: Vec<usize> = (0..log.time_s.len()).filter(|k| !(700..760).contains(k)).collect();
    let of = |column: &[f64]| rows.iter().map(|k| column[*k]).collect::<Vec<f64>>().into();
    let drive = TripLog {
        time_s: of(&log.time_s),
        speed_mps: of(&log.speed_mps),
        yaw_rate_radps: vec![f64::NAN; rows.len()].into(),
        ..TripLog::default()
    };
    let options = RoadOptions { road_type: Some("rural".to_owned()), ..RoadOptions::default() };
    let found = roads(&RoadLog { drive, ..RoadLog::default() }, &options).unwrap();
    assert_eq!((found.roads.len(), found.counts.cuts, found.counts.cuts_by_speed), (2, 1, 1));
    let logged_m: f64 = found.roads.iter().map(|road| road.cycle.length_m).sum();
    let logged_s: f64 = found.roads.iter().map(|road| road.way.duration_s()).sum();
    let [first, second] = [0, 1].map(|k| found.roads[k].part.unwrap());
    assert!(first.is_first && !second.is_first);
    let gap_s = 61.0;
    assert!((found.counts.cut_way_m - gap_s * logged_m / logged_s).abs() < 1e-6);
    assert!((first.drive_m - logged_m - found.counts.cut_way_m).abs() < 1e-6);
    assert!((second.start_m - found.roads[0].cycle.length_m - found.counts.cut_way_m).abs() < 1e-6);
}

#[test]
fn stops_that_a_log_does_not_see_leave_the_laws_of_stops_alone() {
    let base = field_truck(|model| {
        model.mission.stops = Some(MissionStopModel {
            spacing_m: Quantity::Law(Law::Exponential { mean: 1.0e3 }),
            dwell_s: Quantity::Law(Law::LogNormal {
                median: 100.0,
                log_sd: 0.3,
                lower: None,
                upper: None,
            }),
            cargo: None,
            power_take_off: None,
        });
    });
    // a drive of 15 m/s with a stop each 3 km, whose dwells are log-normal
    let fit_of = |median_s: f64| {
        let mut draws = Draws::new(9, 0, Stream::Vehicle);
        let (mut time_s, mut speed_mps, mut at_s) = (Vec::new(), Vec::new(), 0.0);
        let mut drive = |seconds: f64, mps: f64| {
            for _ in 0..seconds as usize {
                time_s.push(at_s);
                speed_mps.push(mps);
                at_s += 1.0;
            }
        };
        drive(200.0, 15.0);
        for _ in 0..60 {
            drive(median_s * (0.4 * draws.normal()).exp(), 0.0);
            drive(200.0, 15.0);
        }
        let yaw_rate_radps = vec![f64::NAN; time_s.len()].into();
        let (time_s, speed_mps) = (time_s.into(), speed_mps.into());
        let drive = TripLog { time_s, speed_mps, yaw_rate_radps, ..TripLog::default() };
        let options = RoadOptions { road_type: Some("rural".to_owned()), ..RoadOptions::default() };
        let found = roads(&RoadLog { drive, ..RoadLog::default() }, &options).unwrap();
        fit_with_coverage(&found.roads, &found.coverage, base.model()).unwrap()
    };
    // half of the stops are shorter than the five minutes from which on a standstill is one
    let half = fit_of(300.0);
    assert_eq!(half.mission_model.stops, base.model().mission.stops);
    let is_said = |fit: &RoadFit| fit.warnings.iter().any(|text| text.contains("are shorter"));
    assert!(is_said(&half), "{:?}", half.warnings);
    // hardly any is
    let all = fit_of(1500.0);
    assert!(!is_said(&all), "{:?}", all.warnings);
    let stops = all.mission_model.stops.unwrap();
    let Quantity::Law(Law::Exponential { mean }) = stops.spacing_m else { panic!("{stops:?}") };
    assert!((mean - 3000.0).abs() < 100.0, "{mean}");
    let Quantity::Law(Law::LogNormal { median, .. }) = stops.dwell_s else { panic!("{stops:?}") };
    assert!((median / 1500.0 - 1.0).abs() < 4.0 * 0.4 / 60.0_f64.sqrt(), "{median}");
}
