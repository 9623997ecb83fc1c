//! The studies and vehicles that are part of the program.

use super::error::{Cause, Fault, StudyFileError};
use super::read::{Kind, read};
use std::path::Path;

/// A study or vehicle that is part of the program.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// Its name.
    pub name: &'static str,
    /// What it is, in one line.
    pub description: &'static str,
    /// Its text.
    pub text: &'static str,
}

/// The name of the default study.
pub const DEFAULT: &str = "field-truck";

/// The built-in studies, the default one first.
pub const STUDIES: &[BuiltIn] = &[
    BuiltIn {
        name: DEFAULT,
        description: "Tractor-semitrailers with mixed payloads on mixed roads, drivers of the field data",
        text: include_str!("../../../../configs/field-truck.toml"),
    },
    BuiltIn {
        name: "field-truck-loaded",
        description: "The default study with every truck loaded to 40 t",
        text: include_str!("../../../../configs/field-truck-loaded.toml"),
    },
    BuiltIn {
        name: "field-truck-table",
        description: "The default study with the curve speeds of the 25 single trucks of the field data",
        text: include_str!("../../../../configs/field-truck-table.toml"),
    },
    BuiltIn {
        name: "simulator-truck",
        description: "Trucks loaded to 40 t with the drivers of the driving simulator",
        text: include_str!("../../../../configs/simulator-truck.toml"),
    },
    BuiltIn {
        name: "simulator-study",
        description: "Eight drivers on the six slopes of the driving simulator, to identify their pedal gains",
        text: include_str!("../../../../configs/simulator-study.toml"),
    },
    BuiltIn {
        name: "long-haul",
        description: "Missions of 300 km, four fifths of them on motorways",
        text: include_str!("../../../../configs/long-haul.toml"),
    },
    BuiltIn {
        name: "regional",
        description: "Missions of 100 km on mixed roads with the payloads of regional delivery",
        text: include_str!("../../../../configs/regional.toml"),
    },
    BuiltIn {
        name: "urban-delivery",
        description: "Missions of 40 km in towns with a stop every two kilometres",
        text: include_str!("../../../../configs/urban-delivery.toml"),
    },
    BuiltIn {
        name: "battery-truck",
        description: "The default study with battery-electric tractors",
        text: include_str!("../../../../configs/battery-truck.toml"),
    },
    BuiltIn {
        name: "passenger-car",
        description: "Passenger cars with a petrol engine on the roads of the default study",
        text: include_str!("../../../../configs/passenger-car.toml"),
    },
];

/// The built-in vehicles.
pub const VEHICLES: &[BuiltIn] = &[
    BuiltIn {
        name: "tractor-40t",
        description: "Tractor-semitrailer of the 40 t class, 325 kW diesel engine, 12 gears",
        text: include_str!("../../../../configs/vehicles/tractor-40t.toml"),
    },
    BuiltIn {
        name: "rigid-12t",
        description: "Rigid 4x2 truck of 12 t for delivery, 185 kW diesel engine, 6 gears",
        text: include_str!("../../../../configs/vehicles/rigid-12t.toml"),
    },
    BuiltIn {
        name: "city-bus-12m",
        description: "City bus of 12 m, 185 kW diesel engine",
        text: include_str!("../../../../configs/vehicles/city-bus-12m.toml"),
    },
    BuiltIn {
        name: "tractor-electric-40t",
        description: "Tractor-semitrailer of the 40 t class, battery of 540 kWh, 490 kW, 3 gears",
        text: include_str!("../../../../configs/vehicles/tractor-electric-40t.toml"),
    },
    BuiltIn {
        name: "city-bus-electric-12m",
        description: "City bus of 12 m, battery of 350 kWh, 200 kW",
        text: include_str!("../../../../configs/vehicles/city-bus-electric-12m.toml"),
    },
    BuiltIn {
        name: "car-electric",
        description: "Passenger car of the compact class, battery of 77 kWh, 150 kW",
        text: include_str!("../../../../configs/vehicles/car-electric.toml"),
    },
    BuiltIn {
        name: "car-petrol",
        description: "Passenger car of the middle class, 130 kW petrol engine, 6 gears",
        text: include_str!("../../../../configs/vehicles/car-petrol.toml"),
    },
];

/// The routes that built-in studies name, by the name in the study, as `ocmc cycle` would write
/// them.
const ROUTES: &[(&str, &str)] =
    &[("built-in/simulator-slopes.csv", include_str!("../../../../configs/simulator-slopes.csv"))];

/// The text of a built-in route.
pub(crate) fn route(name: &str) -> Option<&'static str> {
    ROUTES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The built-in studies, the default one first.
pub fn list() -> &'static [BuiltIn] {
    STUDIES
}

/// The text of a built-in study or vehicle.
///
/// # Errors
/// [`StudyFileError`] names the nearest built-in name.
pub fn show(name: &str) -> Result<&'static str, StudyFileError> {
    find(name).ok_or_else(|| unknown(name, Cause::NotBuiltIn { name: name.to_owned() }))
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
    Ok(read(name_or_path, Kind::Study, None)?.source.text.clone())
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
    Box::new(Fault::new(cause).suggest(name, &names)).into()
}
