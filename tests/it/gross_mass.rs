//! The legal gross mass cuts the payload that is drawn, and refuses one that is fixed.

use crate::common::{run, study};

#[test]
fn no_truck_is_heavier_than_the_law_allows() {
    let records = run(&study("field-truck", &["vehicle.base=rigid-12t"]), 60);
    assert!(records.iter().all(|record| record.payload_kg <= 12_000.0 - 5850.0));
    let cut = records.iter().filter(|record| record.payload_cut_kg > 0.0);
    assert!(cut.clone().count() > 30 && cut.clone().all(|record| record.payload_kg == 6150.0));
    let fits = run(&study("field-truck", &[]), 60);
    assert!(fits.iter().all(|record| record.payload_cut_kg == 0.0));
}

#[test]
fn a_fixed_payload_above_it_is_refused() {
    let sets = ["vehicle.base=rigid-12t", "mission.payload_kg=24300"];
    let error = ocmc_io::study::load("field-truck", &sets).unwrap_err().to_string();
    assert!(error.contains("payload_kg") && error.contains("gross_mass_limit_kg"), "{error}");
}
