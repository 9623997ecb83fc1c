//! The default study, and statistics.

pub(crate) mod statistics;

use ocmc_core::study::{Study, StudyModel};
use std::fs;
use std::path::Path;

/// `configs/field-truck.toml` with its vehicle. It names no other base, so that reading both files
/// is enough.
pub(crate) fn field_truck_model() -> StudyModel {
    let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs");
    let read = |name: &str| fs::read_to_string(configs.join(name)).unwrap();
    let mut study: toml::Table = read("field-truck.toml").parse().unwrap();
    let mut vehicle: toml::Table = read("vehicles/tractor-40t-vecto.toml").parse().unwrap();
    // ranges of judged numbers are the files' own
    study.remove("judged");
    vehicle.remove("judged");
    study.insert("vehicle".to_owned(), vehicle.into());
    // by the core's reader: what serde makes of a whole study for another one takes half a minute
    // to compile
    StudyModel::from_tree(&serde_json::to_value(study).unwrap()).unwrap()
}

/// The default study with some changes.
pub(crate) fn field_truck(change: impl FnOnce(&mut StudyModel)) -> Study {
    let mut model = field_truck_model();
    change(&mut model);
    Study::new(model).unwrap()
}
