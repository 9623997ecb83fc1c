//! The vehicle and the engine of a job.

use super::error::VectoError;
use super::part::{beside, names_file};
use super::result::Columns;
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
    cda: Option<f64>,
    /// Of older files: coefficient and area apart.
    #[serde(rename = "Cd")]
    cd: Option<f64>,
    cross_sec_area: Option<f64>,
    /// Allowed mass, in t.
    #[serde(default)]
    mass_max: f64,
    #[serde(rename = "rdyn")]
    rdyn: f64,
    cd_corr_mode: String,
    #[serde(default)]
    cd_corr_file: String,
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
    #[serde(rename = "Type", default)]
    kind: String,
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

/// A rigid truck of the declaration mode on its missions without a trailer [F: VECTO 3, segment table
/// and weights of bodies]: its axles, its mass in t up to which it holds, shares of the axles, and the
/// mass of its body in kg.
const DECLARED_RIGIDS: [(&str, f64, &[f64], f64); 7] = [
    ("4x2", 7.5, &[0.45, 0.55], 1600.0),
    ("4x2", 10.0, &[0.45, 0.55], 1600.0),
    ("4x2", 12.0, &[0.45, 0.55], 1900.0),
    ("4x2", 16.0, &[0.4, 0.6], 2000.0),
    ("4x2", f64::INFINITY, &[0.45, 0.55], 2100.0),
    ("6x2", f64::INFINITY, &[0.35, 0.4, 0.25], 2200.0),
    ("6x4", f64::INFINITY, &[0.35, 0.35, 0.3], 2200.0),
];
/// Modes of the correction for cross wind.
const CORRECTIONS: [&str; 4] = ["off", "cdofvdecl", "cdofveng", "cdofv"];
/// Relative change of the drag area that is none.
const SAME_DRAG: f64 = 1e-4;

impl VehicleFile {
    pub(super) fn check(&self, path: &Path) -> Result<(), VectoError> {
        let refused = |what, found, allowed| {
            Err(VectoError::Unsupported { path: path.to_owned(), what, found, allowed })
        };
        if !CORRECTIONS.contains(&self.cd_corr_mode.to_lowercase().as_str()) {
            let allowed = "allowed are `Off`, `CdOfVdecl` and `CdOfVeng`: give the drag area of still \
                           air";
            return refused("`CdCorrMode`", format!("`{}`", self.cd_corr_mode), allowed);
        }
        let shares: f64 = self.axles().iter().map(|axle| axle.weight_share).sum();
        if (shares - 1.0).abs() > 1e-3 {
            let allowed = "allowed are shares with a sum of 1, and in declaration mode a tractor or \
                           a rigid truck of 4x2, 6x2 or 6x4";
            return refused("the sum of `AxleWeightShare`", shares.to_string(), allowed);
        }
        if self.drag_area_m2().is_none() {
            let allowed = "allowed is `CdA`, or `Cd` and `CrossSecArea`; a declared vehicle without \
                           it has a default that is not known here";
            return refused("`CdA`", "missing".to_owned(), allowed);
        }
        Ok(())
    }

    /// Drag area in still air, in m².
    fn drag_area_m2(&self) -> Option<f64> {
        let product = self.cd.zip(self.cross_sec_area).map(|(cd, area_m2)| cd * area_m2);
        self.cda.or(product).filter(|cda_m2| *cda_m2 > 0.0)
    }

    /// The row of a rigid truck in declaration mode.
    fn declared_rigid(&self) -> Option<&'static (&'static str, f64, &'static [f64], f64)> {
        let is_rigid = self.saved_in_decl_mode && self.veh_cat.to_lowercase() == "rigidtruck";
        let axles = self.axle_config.axles.len();
        let mut rows = DECLARED_RIGIDS.iter().filter(|_| is_rigid);
        rows.find(|(kind, most_t, shares, _)| {
            *kind == self.axle_config.kind && self.mass_max <= *most_t && shares.len() == axles
        })
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
        } else if let Some((_, _, shares, _)) = self.declared_rigid() {
            axles.iter_mut().zip(*shares).for_each(|(axle, share)| axle.weight_share = *share);
        }
        axles
    }

    /// Keys of a study's vehicle.
    pub(super) fn keys(&self, path: &Path) -> Result<Value, VectoError> {
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
        let body_kg = match self.declared_rigid() {
            Some((.., body_kg)) => *body_kg,
            None if self.is_declared_tractor() => TRAILER_KG,
            None => 0.0,
        };
        let coefficients = match self.cd_corr_mode.to_lowercase().as_str() {
            "cdofvdecl" => self.cross_wind(),
            _ => [0.0; 3],
        };
        let (at_rest, by_speed) = match self.cd_corr_mode.to_lowercase().as_str() {
            "cdofveng" | "cdofv" => drag_by_speed(&beside(path, &self.cd_corr_file)?)?,
            _ => (1.0, Value::Null),
        };
        let mut keys = json!({
            "curb_mass_kg": self.curb_weight + self.curb_weight_extra + body_kg,
            "drag_area_m2": self.drag_area_m2().unwrap_or_default() * at_rest,
            "cross_wind": { "coefficients": coefficients, "maximum_angle_deg": 14.0 },
            "axles": rows,
            "rolling_factor": 1.0,
            "rolling_load_exponent": 0.9,
            "wheel_radius_m": self.rdyn / 1000.0,
            "wheel_inertia_kgm2": inertia,
        });
        if !by_speed.is_null() {
            keys["drag_by_speed"] = by_speed;
        }
        Ok(keys)
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

/// The factor on the drag area at rest, and how it changes with the speed, of a table of factors
/// (`.vcdv`): a parabola from where it begins to change, by least squares.
fn drag_by_speed(path: &Path) -> Result<(f64, Value), VectoError> {
    let columns = Columns::read(path)?;
    let speed_mps: Vec<f64> = columns.numbers("v_veh")?.iter().map(|kmh| kmh / 3.6).collect();
    let factor = columns.numbers_of(&["Cd", "Cd factor"])?;
    let at_rest = factor.first().copied().unwrap_or(1.0);
    let same = |factor: &&f64| (**factor / at_rest - 1.0).abs() < SAME_DRAG;
    let from_mps = speed_mps[factor.iter().take_while(same).count().saturating_sub(1)];
    let [mut uu, mut uw, mut ww, mut uy, mut wy] = [0.0; 5];
    for (speed, factor) in speed_mps.iter().zip(&factor).filter(|(speed, _)| **speed > from_mps) {
        let (u, y) = (speed - from_mps, factor / at_rest - 1.0);
        let w = u * u;
        uu += u * u;
        uw += u * w;
        ww += w * w;
        uy += u * y;
        wy += w * y;
    }
    let determinant = uu * ww - uw * uw;
    let (linear, quadratic) = if determinant > 0.0 {
        ((uy * ww - wy * uw) / determinant, (uu * wy - uw * uy) / determinant)
    } else {
        (0.0, 0.0)
    };
    let (linear, quadratic) = if quadratic < 0.0 {
        (if uu > 0.0 { uy / uu } else { 0.0 }, 0.0)
    } else {
        (linear, quadratic)
    };
    let by_speed = json!({
        "from_mps": from_mps, "linear_s_per_m": linear, "quadratic_s2_per_m2": quadratic,
    });
    Ok((at_rest, by_speed))
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
