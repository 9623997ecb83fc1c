//! Routes as a receiver logs them: 3 m of scatter in position and altitude cost no more than 5 % of
//! fuel.

use crate::common::{column, run, study};
use crate::program::ocmc;
use ocmc_core::energy::Carrier;
use ocmc_core::kernel::drive::trace::trace;
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::road::curvature::Curve;
use ocmc_core::random::{Stream, Streams};
use ocmc_core::study::Study;
use ocmc_io::given_cycle::{RouteOptions, account};
use ocmc_io::intake::FileAccount;
use ocmc_io::study as studies;
use std::fmt::Write;
use std::path::Path;

/// Points of the road of a study's cycle, one every so many metres: east, north and up, in m, and
/// the limit, in m/s.
pub(crate) fn points(study: &Study, cycle_id: u64, spacing_m: f64) -> Vec<[f64; 4]> {
    let road = study.sample(1, cycle_id).cycle.road;
    let (mut x, mut y, mut z, mut heading) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    let mut points = Vec::new();
    for metre in 0..road.length_m as usize {
        let at_m = metre as f64;
        if at_m >= points.len() as f64 * spacing_m {
            let sign = road.signs.iter().take_while(|sign| sign.start_m <= at_m).last().unwrap();
            points.push([x, y, z, sign.speed_mps]);
        }
        let curve = road.curves.iter().find(|curve| (curve.start_m..curve.end_m).contains(&at_m));
        heading -= curve.map_or(0.0, Curve::curvature_per_m);
        (x, y) = (x + heading.sin(), y + heading.cos());
        z += road.slopes[(at_m / road.slope_step_m) as usize];
    }
    points
}

/// Writes them as a route, with scatter of this SD.
fn write(path: &Path, points: &[[f64; 4]], noise_m: f64, seed: u64) {
    let mut draws = Streams::new(seed, 0).open(Stream::CurveResidual);
    let mut text = "lat,lon,altitude_m,speed_limit_mps\n".to_owned();
    for [x, y, z, limit] in points {
        let [x, y, z] = [x, y, z].map(|value| value + noise_m * draws.normal());
        let (lat, lon) = (52.0 + y / 111_195.0, 9.0 + x / (111_195.0 * 52_f64.to_radians().cos()));
        writeln!(text, "{lat:.9},{lon:.9},{z:.4},{limit:.4}").unwrap();
    }
    std::fs::write(path, text).unwrap();
}

/// Writes the drive of a cycle as a receiver logs it, once a second, with scatter of this SD.
fn write_log(path: &Path, study: &Study, cycle_id: u64, noise_m: f64) {
    let points = points(study, cycle_id, 1.0);
    let driven = trace(study, 1, cycle_id);
    let column = |name: &str| column(&driven, name);
    let (time, position) = (column("time_s"), column("position_m"));
    let (speed, limit) = (column("speed_mps"), column("limit_mps"));
    let mut draws = Streams::new(3, 0).open(Stream::CurveResidual);
    let mut text = "time_s,speed_mps,latitude_deg,longitude_deg,altitude_m,limit_mps\n".to_owned();
    let mut k = 0;
    for second in 0..time[time.len() - 1] as usize {
        let at_s = second as f64;
        while time[k] < at_s {
            k += 1;
        }
        let (before, share) = match k {
            0 => (0, 1.0),
            _ => (k - 1, (at_s - time[k - 1]) / (time[k] - time[k - 1])),
        };
        let at = |values: &[f64]| values[before] + share * (values[k] - values[before]);
        let place = (at(position) as usize).min(points.len() - 1);
        let [x, y, z, _] = points[place].map(|value| value + noise_m * draws.normal());
        let (lat, lon) = (52.0 + y / 111_195.0, 9.0 + x / (111_195.0 * 52_f64.to_radians().cos()));
        let (speed, limit) = (at(speed), limit[k]);
        writeln!(text, "{at_s},{speed:.4},{lat:.9},{lon:.9},{z:.4},{limit:.4}").unwrap();
    }
    std::fs::write(path, text).unwrap();
}

/// Fuel of 20 trips on a route, in kg/m.
fn fuel(path: &Path) -> f64 {
    let loaded = studies::load("field-truck", &[] as &[&str]).unwrap();
    let study = loaded.on_routes(&[path.to_owned()], &[], RouteOptions::default()).unwrap().study;
    let records = run(&study, 20);
    assert!(records.iter().all(|record| record.outcome.counts()), "{}", path.display());
    let total = |of: fn(&ocmc_core::record::Record) -> f64| records.iter().map(of).sum::<f64>();
    total(|record| record.amount(Carrier::LiquidFuel).unwrap()) / total(|record| record.distance_m)
}

#[test]
fn three_metres_of_scatter_cost_less_than_five_per_cent() {
    let study = study("field-truck", &["mission.length_m=30000"]);
    let folder = tempfile::tempdir().unwrap();
    for cycle_id in [1, 2] {
        for spacing_m in [10.0, 20.0, 50.0] {
            let points = points(&study, cycle_id, spacing_m);
            let path = folder.path().join("route.csv");
            write(&path, &points, 0.0, 1);
            let clean = fuel(&path);
            let read =
                |path: &Path| -> GivenCycle { ocmc_io::given_cycle::read(path, &[]).unwrap() };
            let length_m = read(&path).length_m;
            assert!(read(&path).noise.positions_m < 0.1 && read(&path).noise.altitudes_m < 0.5);
            for seed in [1, 2] {
                write(&path, &points, 3.0, seed);
                let cycle = read(&path);
                let noise_m = [cycle.noise.positions_m, cycle.noise.altitudes_m];
                assert!(noise_m.iter().all(|noise_m| (2.2..4.0).contains(noise_m)), "{noise_m:?}");
                assert!((cycle.length_m / length_m - 1.0).abs() < 0.01, "{}", cycle.length_m);
                let told = account(&path, &cycle, FileAccount::default());
                assert!(told.warnings.is_empty() && told.told.len() == 3, "{told:?}");
                let part = fuel(&path) / clean;
                println!(
                    "cycle {cycle_id}, {spacing_m} m, seed {seed}: {:+.1} %",
                    100.0 * (part - 1.0)
                );
                assert!((part - 1.0).abs() < 0.05, "{cycle_id} {spacing_m} {seed}: {part}");
            }
        }
    }
}

#[test]
fn a_route_that_only_scatters_is_refused() {
    let study = study("field-truck", &["mission.length_m=5000"]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("route.csv");
    write(&path, &points(&study, 1, 20.0), 20.0, 1);
    let error = ocmc_io::given_cycle::read(&path, &[]).unwrap_err().to_string();
    assert!(error.contains("scatter by") && error.contains("at most 8 m"), "{error}");
}

#[test]
fn the_road_of_a_noisy_log_costs_what_that_of_a_clean_one_does() {
    let study = study("field-truck", &["mission.length_m=20000", "simulation.step_s=0.5"]);
    let folder = tempfile::tempdir().unwrap();
    let (log, road) = (folder.path().join("log.csv"), folder.path().join("road.csv"));
    let made = |noise_m: f64| {
        write_log(&log, &study, 1, noise_m);
        let files = [&log, &road].map(|path| path.to_str().unwrap().to_owned());
        let output = ocmc(&["road", &files[0], "--out", &files[1]]).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        (output.status.success(), said)
    };
    let (_, said) = made(0.0);
    assert!(said.contains("of climb, at most") && !said.contains("scatter"), "{said}");
    let clean = fuel(&road);
    let (_, said) = made(3.0);
    println!("{said}");
    for what in ["positions", "altitudes"] {
        assert!(said.contains(&format!("its {what} scatter by")), "{said}");
    }
    assert!(!said.contains("hardly a road"), "{said}");
    let part = fuel(&road) / clean;
    println!("3 m: {:+.1} %", 100.0 * (part - 1.0));
    assert!((part - 1.0).abs() < 0.05, "{part}");
    let (success, said) = made(20.0);
    assert!(!success && said.contains("scatter by") && said.contains("at most 8 m"), "{said}");
}
