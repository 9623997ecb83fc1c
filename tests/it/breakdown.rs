//! Parts of road types and event kinds add up to the whole, whatever else is asked of a cycle.

use crate::common::{run, study};
use ocmc_core::breakdown::Axis;
use ocmc_core::kernel::drive::scheduler::drive_scenario;
use ocmc_core::record::{COLUMNS, Record};

const BOTH: &str = "simulation.columns_by=[\"road_type\", \"event_kind\"]";

#[test]
fn parts_add_up_to_the_whole() {
    for name in ["field-truck", "battery-truck", "urban-delivery"] {
        let records = run(&study(name, &[BOTH]), 60);
        for record in &records {
            let columns = record.breakdown.columns().unwrap();
            for axis in Axis::ALL {
                let of_axis =
                    columns.parts().iter().enumerate().filter(|(_, part)| part.axis == axis);
                let parts: Vec<usize> = of_axis.map(|(k, _)| k).collect();
                assert!(!parts.is_empty(), "{name}");
                for (place, amount) in columns.amounts().iter().enumerate() {
                    let whole = record.whole(*amount).unwrap();
                    let amounts =
                        parts.iter().map(|k| record.breakdown.of_part(*k).unwrap()[place]);
                    let sum: f64 = amounts.sum();
                    let error = (sum - whole).abs() / whole.abs().max(1e-9);
                    assert!(error < 1e-9, "{name} {amount:?}: {sum} {whole}");
                }
            }
        }
    }
}

#[test]
fn road_types_are_those_of_the_road() {
    let records = run(&study("field-truck", &[]), 60);
    for record in records.iter().filter(|record| record.outcome.counts()) {
        let columns = record.breakdown.columns().unwrap();
        let shares = [
            ("urban", record.urban_share),
            ("rural", record.rural_share),
            ("motorway", record.motorway_share),
        ];
        for (name, share) in shares {
            let k = columns.parts().iter().position(|part| part.name == name).unwrap();
            let distance_m = record.breakdown.of_part(k).unwrap()[0];
            // within reach of a stop line it is told at the line, a few metres each time
            let error_m = (distance_m - share.unwrap() * record.distance_m).abs();
            assert!(error_m < 10.0, "{name}: {error_m} m");
        }
    }
}

#[test]
fn what_is_asked_for_changes_nothing_else() {
    let whole = |record: &Record| -> Vec<_> { COLUMNS.iter().map(|c| c.get(record)).collect() };
    let of =
        |by: &str| -> Vec<_> { run(&study("field-truck", &[by]), 40).iter().map(whole).collect() };
    let none = of("simulation.columns_by=[]");
    assert!(none == of("simulation.columns_by=[\"road_type\"]"));
    assert!(none == of(BOTH));
}

#[test]
fn the_mean_limit_is_that_of_all_places_along_the_road() {
    const PLACES: u32 = 20_000;
    let study = study("field-truck", &["mission.length_m=20000"]);
    for id in 0..4 {
        let scenario = study.sample(1, id);
        let road = scenario.cycle.road.clone();
        let limit_mps = |place_m: f64| {
            let passed = road.signs.iter().rev().find(|sign| sign.start_m <= place_m);
            passed.expect("a sign at the start").speed_mps
        };
        let places = (0..PLACES).map(|k| road.length_m * (f64::from(k) + 0.5) / f64::from(PLACES));
        let mean_mps = places.map(limit_mps).sum::<f64>() / f64::from(PLACES);
        let found_mps = drive_scenario(&study, scenario).mean_limit_mps.unwrap();
        // a place too far for each sign, at most
        let error_mps = 30.0 * road.signs.len() as f64 / f64::from(PLACES);
        assert!((found_mps - mean_mps).abs() <= error_mps, "{id}: {found_mps} {mean_mps}");
    }
}
