//! The vehicle and the engine of a job.

use super::error::VectoError;
use super::part::{beside, names_file};
use ocmc_io::table::formats::ENGINE_CURVES;
use ocmc_io::table::{Quantity, Source, Table};
use serde::Deserialize;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Revolutions a minute in a rad/s.
pub(super) const RADPS_PER_RPM: f64 = std::f64::consts::PI / 30.0;

/// A `.vveh` file.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct VehicleFile {
    #[serde(default)]
    saved_in_decl_mode: bool,
    veh_cat: String,
    curb_weight: f64,
    #[serde(default)]
    curb_weight_extra: f64,
    #[serde(default)]
    loading: f64,
    #[serde(rename = "CdA")]
    cda: f64,
    #[serde(rename = "rdyn")]
    rdyn: f64,
    cd_corr_mode: String,
    retarder: Retarder,
    axle_config: AxleConfig,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Retarder {
    #[serde(rename = "Type")]
    kind: String,
    ratio: f64,
    #[serde(default)]
    file: String,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
struct AxleConfig {
    axles: Vec<Axle>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Axle {
    inertia: f64,
    #[serde(rename = "AxleWeightShare")]
    weight_share: f64,
    twin_tyres: bool,
    #[serde(rename = "RRCISO")]
    rrc_iso: f64,
    #[serde(rename = "FzISO")]
    fz_iso: f64,
}

/// The semitrailer of the declaration mode [F: VECTO 2.2, `Declaration/`, as in the truck's files
/// of the engineering mode]: three axles of single wide tyres.
const TRAILER_AXLE: Axle = Axle {
    inertia: 19.2,
    weight_share: 0.0,
    twin_tyres: false,
    rrc_iso: 0.005_55,
    fz_iso: 37_500.0,
};
/// Its mass, in kg [F: the same].
const TRAILER_KG: f64 = 7500.0;
/// Shares of the axles of a tractor with it on long haul [F: the same, segment table].
const DECLARED_SHARES: [f64; 5] = [0.2, 0.25, 0.55 / 3.0, 0.55 / 3.0, 0.55 / 3.0];

impl VehicleFile {
    pub(super) fn check(&self, path: &Path) -> Result<(), VectoError> {
        let refused = |what, found, allowed| {
            Err(VectoError::Unsupported { path: path.to_owned(), what, found, allowed })
        };
        if !["off", "cdofvdecl"].contains(&self.cd_corr_mode.to_lowercase().as_str()) {
            let allowed = "allowed are `Off` and `CdOfVdecl`: give the drag area of still air";
            return refused("`CdCorrMode`", format!("`{}`", self.cd_corr_mode), allowed);
        }
        let shares: f64 = self.axles().iter().map(|axle| axle.weight_share).sum();
        if (shares - 1.0).abs() > 1e-3 {
            let allowed = "allowed are shares with a sum of 1, and in declaration mode a tractor";
            return refused("the sum of `AxleWeightShare`", shares.to_string(), allowed);
        }
        Ok(())
    }

    fn is_declared_tractor(&self) -> bool {
        self.saved_in_decl_mode && self.veh_cat.to_lowercase() == "tractor"
    }

    pub(super) fn gross_mass_kg(&self) -> Option<f64> {
        let gross_kg = self.curb_weight + self.curb_weight_extra + self.loading;
        (!self.saved_in_decl_mode).then_some(gross_kg)
    }

    pub(super) fn base_vehicle(&self) -> &'static str {
        match self.veh_cat.to_lowercase().as_str() {
            "tractor" => "tractor-40t",
            "citybus" | "interurbanbus" | "coach" => "city-bus-12m",
            _ => "rigid-12t",
        }
    }

    /// Its axles; those of a tractor in declaration mode with the trailer's.
    fn axles(&self) -> Vec<Axle> {
        let mut axles = self.axle_config.axles.clone();
        if self.is_declared_tractor() && axles.len() == 2 {
            axles.extend(std::iter::repeat_n(TRAILER_AXLE, 3));
            axles.iter_mut().zip(DECLARED_SHARES).for_each(|(axle, share)| {
                axle.weight_share = share;
            });
        }
        axles
    }

    pub(super) fn keys(&self) -> Value {
        let axles = self.axles();
        let sum: f64 = axles.iter().map(|axle| axle.weight_share).sum();
        let inertia: f64 = axles.iter().map(|axle| axle.inertia * axle.tyres()).sum();
        let rows: Vec<Value> = axles
            .iter()
            .enumerate()
            .map(|(k, axle)| {
                json!({
                    // the second axle of a truck is driven
                    "load_share": axle.weight_share / sum, "driven": k == 1,
                    "iso_rolling_coefficient": axle.rrc_iso, "iso_load_n": axle.fz_iso,
                    "tyres": axle.tyres(),
                })
            })
            .collect();
        let trailer_kg = if self.is_declared_tractor() { TRAILER_KG } else { 0.0 };
        let coefficients = match self.cd_corr_mode.to_lowercase().as_str() {
            "off" => [0.0; 3],
            _ => self.cross_wind(),
        };
        json!({
            "curb_mass_kg": self.curb_weight + self.curb_weight_extra + trailer_kg,
            "drag_area_m2": self.cda,
            "cross_wind": { "coefficients": coefficients, "maximum_angle_deg": 14.0 },
            "axles": rows,
            "rolling_factor": 1.0,
            "rolling_load_exponent": 0.9,
            "wheel_radius_m": self.rdyn / 1000.0,
            "wheel_inertia_kgm2": inertia,
        })
    }

    /// Coefficients of the growth of the drag area with the wind's angle [F: VECTO 2.2,
    /// `VCDV/parameters.csv`].
    fn cross_wind(&self) -> [f64; 3] {
        match self.veh_cat.to_lowercase().as_str() {
            "tractor" => [0.034_767, 0.039_367, -0.001_897],
            "citybus" | "interurbanbus" | "coach" => [-0.000_794, 0.021_09, -0.001_09],
            _ => [0.013_526, 0.017_746, -0.000_666],
        }
    }

    /// The file of the retarder's losses, and its ratio to the shaft; none without one.
    pub(super) fn retarder(&self, path: &Path) -> Result<Option<(PathBuf, f64)>, VectoError> {
        let there = self.retarder.kind.to_lowercase() != "none" && names_file(&self.retarder.file);
        there.then(|| Ok((beside(path, &self.retarder.file)?, self.retarder.ratio))).transpose()
    }
}

impl Axle {
    fn tyres(&self) -> f64 {
        if self.twin_tyres { 4.0 } else { 2.0 }
    }
}

/// A `.veng` file.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct EngineFile {
    idling_speed: f64,
    inertia: f64,
    full_load_curve: String,
    fuel_map: String,
}

impl EngineFile {
    /// The highest torque of its full-load curve, in Nm.
    pub(super) fn peak_torque_nm(&self, path: &Path) -> Result<f64, VectoError> {
        let file = beside(path, &self.full_load_curve)?;
        let curve = Table::open(Source::File(&file), &ENGINE_CURVES, &[])?;
        let [torque_nm] = curve.numbers([Quantity::FullLoadTorque])?;
        Ok(torque_nm.into_iter().fold(0.0, f64::max))
    }

    pub(super) fn keys(&self, path: &Path) -> Result<Value, VectoError> {
        let file = |name: &str| Ok::<_, VectoError>(beside(path, name)?.display().to_string());
        Ok(json!({
            "inertia_kgm2": self.inertia,
            "idle_speed_radps": self.idling_speed * RADPS_PER_RPM,
            "full_load_file": file(&self.full_load_curve)?,
            "map_file": file(&self.fuel_map)?,
            "fuel_factor": 1.0,
        }))
    }
}
