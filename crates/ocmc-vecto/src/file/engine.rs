//! The engine of a job.

use super::error::VectoError;
use super::part::{beside, number};
use super::vehicle::RADPS_PER_RPM;
use ocmc_io::table::formats::ENGINE_CURVES;
use ocmc_io::table::{Quantity, Source, Table};
use serde::Deserialize;
use serde_json::{Value, json};
use std::path::Path;

/// A `.veng` file.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct EngineFile {
    idling_speed: f64,
    inertia: f64,
    full_load_curve: Option<String>,
    /// Curves of VECTO until 2.0: one for each range of gears.
    #[serde(default)]
    full_load_curves: Vec<GearsCurve>,
    fuel_map: Option<String>,
    /// Fuel of VECTO 3: `Diesel CI` or 0; absent for diesel.
    #[serde(default)]
    fuel_type: Value,
    /// Fuels of newer files: one or two with a map each.
    #[serde(default)]
    fuels: Vec<Value>,
    #[serde(rename = "WHRType", default)]
    heat_recovery: Value,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
struct GearsCurve {
    path: String,
}

impl EngineFile {
    pub(super) fn check(&self, path: &Path) -> Result<(), VectoError> {
        let refused = |what, found: String, allowed| {
            Err(VectoError::Unsupported { path: path.to_owned(), what, found, allowed })
        };
        let alone = self.fuels.len() < 2;
        let fuel = self.fuels.first().map_or(&self.fuel_type, |fuel| &fuel["FuelType"]);
        let is_diesel = fuel.is_null()
            || number(fuel) == Some(0.0)
            || fuel.as_str().is_some_and(|fuel| fuel.to_lowercase().starts_with("diesel"));
        if !(alone && is_diesel) {
            let fuels = if alone { fuel.to_string() } else { "two fuels".to_owned() };
            return refused("`FuelType`", fuels, "allowed is diesel alone (`Diesel CI`)");
        }
        if self.full_load_curves.len() > 1 {
            let allowed = "allowed is one full-load curve for all gears";
            return refused("the number of `FullLoadCurves`", "above 1".to_owned(), allowed);
        }
        if self.full_load_name().is_none() || self.map_name().is_none() {
            let allowed = "allowed are an engine with `FullLoadCurve` and `FuelMap`";
            return refused("`FullLoadCurve` or `FuelMap`", "missing".to_owned(), allowed);
        }
        Ok(())
    }

    fn full_load_name(&self) -> Option<&str> {
        let of_gears = self.full_load_curves.first().map(|curve| &curve.path);
        self.full_load_curve.as_ref().or(of_gears).map(String::as_str)
    }

    fn map_name(&self) -> Option<&str> {
        let of_fuel = self.fuels.first().and_then(|fuel| fuel["FuelMap"].as_str());
        self.fuel_map.as_deref().or(of_fuel)
    }

    /// Values that are not used.
    pub(super) fn notes(&self) -> Vec<String> {
        let recovers = self.heat_recovery.as_str().is_some_and(|kind| kind != "None");
        let note = format!("`WHRType` {}: no waste heat is recovered", self.heat_recovery);
        recovers.then_some(note).into_iter().collect()
    }

    /// The highest torque of its full-load curve, in Nm.
    pub(super) fn peak_torque_nm(&self, path: &Path) -> Result<f64, VectoError> {
        let file = beside(path, self.full_load_name().unwrap_or_default())?;
        let curve = Table::open(Source::File(&file), &ENGINE_CURVES, &[])?;
        let [torque_nm] = curve.numbers([Quantity::FullLoadTorque])?;
        Ok(torque_nm.into_iter().fold(0.0, f64::max))
    }

    pub(super) fn keys(&self, path: &Path) -> Result<Value, VectoError> {
        let file = |name: Option<&str>| {
            Ok::<_, VectoError>(beside(path, name.unwrap_or_default())?.display().to_string())
        };
        Ok(json!({
            "inertia_kgm2": self.inertia,
            "idle_speed_radps": self.idling_speed * RADPS_PER_RPM,
            "full_load_file": file(self.full_load_name())?,
            "map_file": file(self.map_name())?,
            "fuel_factor": 1.0,
        }))
    }
}
