//! The studies and vehicles that are part of the program.

use super::error::{Cause, Fault, StudyFileError};
use super::read::{STUDY, read};
use std::path::Path;

/// A study or vehicle that is part of the program.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// Its name.
    pub name: &'static str,
    /// Its text.
    pub text: &'static str,
}

const fn built_in(name: &'static str, text: &'static str) -> BuiltIn {
    BuiltIn { name, text }
}

impl BuiltIn {
    /// What a study is, in one line, as it says itself.
    pub fn description(&self) -> &'static str {
        let said = |line: &'static str| line.strip_prefix("description = \"")?.strip_suffix('"');
        self.text.lines().find_map(said).unwrap_or_default()
    }
}

/// The name of the default study.
pub const DEFAULT: &str = "field-truck";

/// The built-in studies, the default one first.
pub const STUDIES: &[BuiltIn] = &[
    built_in(DEFAULT, include_str!("../../../../configs/field-truck.toml")),
    built_in("field-truck-loaded", include_str!("../../../../configs/field-truck-loaded.toml")),
    built_in("field-truck-table", include_str!("../../../../configs/field-truck-table.toml")),
    built_in("simulator-truck", include_str!("../../../../configs/simulator-truck.toml")),
    built_in("simulator-study", include_str!("../../../../configs/simulator-study.toml")),
    built_in("long-haul", include_str!("../../../../configs/long-haul.toml")),
    built_in("regional", include_str!("../../../../configs/regional.toml")),
    built_in("urban-delivery", include_str!("../../../../configs/urban-delivery.toml")),
    built_in("battery-truck", include_str!("../../../../configs/battery-truck.toml")),
    built_in("passenger-car", include_str!("../../../../configs/passenger-car.toml")),
];

/// The built-in vehicles.
pub const VEHICLES: &[BuiltIn] = &[
    built_in("tractor-40t", include_str!("../../../../configs/vehicles/tractor-40t.toml")),
    built_in("rigid-12t", include_str!("../../../../configs/vehicles/rigid-12t.toml")),
    built_in("city-bus-12m", include_str!("../../../../configs/vehicles/city-bus-12m.toml")),
    built_in(
        "tractor-electric-40t",
        include_str!("../../../../configs/vehicles/tractor-electric-40t.toml"),
    ),
    built_in(
        "city-bus-electric-12m",
        include_str!("../../../../configs/vehicles/city-bus-electric-12m.toml"),
    ),
    built_in("car-electric", include_str!("../../../../configs/vehicles/car-electric.toml")),
    built_in("car-petrol", include_str!("../../../../configs/vehicles/car-petrol.toml")),
];

/// The built-in studies, the default one first.
pub fn list() -> &'static [BuiltIn] {
    STUDIES
}

/// The text of a built-in study or vehicle.
///
/// # Errors
/// [`StudyFileError`] names the nearest built-in name.
pub fn show(name: &str) -> Result<&'static str, StudyFileError> {
    find(name).ok_or_else(|| unknown(name, Cause::NotBuiltIn(name.to_owned())))
}

/// The text of a built-in study or vehicle, or of a file, as it is written. A built-in name wins
/// over a file.
///
/// # Errors
/// [`StudyFileError`] names the nearest built-in name, or says why the file cannot be read.
pub fn text(name_or_path: &str) -> Result<String, StudyFileError> {
    if let Some(text) = find(name_or_path) {
        return Ok(text.to_owned());
    }
    if !Path::new(name_or_path).exists() {
        let (what, name) = ("study or vehicle", name_or_path.to_owned());
        return Err(unknown(name_or_path, Cause::UnknownName { what, name }));
    }
    Ok(read(name_or_path, STUDY, None)?.source.text.clone())
}

fn all() -> impl Iterator<Item = &'static BuiltIn> {
    STUDIES.iter().chain(VEHICLES)
}

fn find(name: &str) -> Option<&'static str> {
    all().find(|built_in| built_in.name == name).map(|built_in| built_in.text)
}

/// The fault of a name that is not built in, with the nearest one that is.
fn unknown(name: &str, cause: Cause) -> StudyFileError {
    let names: Vec<&str> = all().map(|built_in| built_in.name).collect();
    Fault::new(cause).suggest(name, &names).into()
}
