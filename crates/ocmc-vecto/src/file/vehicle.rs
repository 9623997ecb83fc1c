//! The vehicle of a job.

use super::error::VectoError;
use super::part::{Part, beside, names_file};
use super::result::Columns;
use super::tyre::dynamic_radius_m;
use serde::Deserialize;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Revolutions a minute in a rad/s.
pub(super) const RADPS_PER_RPM: f64 = std::f64::consts::PI / 30.0;

/// A `.vveh` file.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct VehicleFile {
    /// Older files do not say it.
    saved_in_decl_mode: Option<bool>,
    veh_cat: String,
    curb_weight: f64,
    #[serde(default)]
    curb_weight_extra: f64,
    #[serde(default)]
    loading: f64,
    #[serde(rename = "CdA")]
    cda: Option<f64>,
    /// Drag coefficient of older files, which state coefficient and area apart.
    #[serde(rename = "Cd")]
    cd: Option<f64>,
    cross_sec_area: Option<f64>,
    /// Allowed mass, in t.
    #[serde(default)]
    mass_max: f64,
    /// In mm; none or 0 in declaration mode, where the tyre says it.
    #[serde(rename = "rdyn")]
    rdyn: Option<f64>,
    #[serde(default)]
    cd_corr_mode: String,
    #[serde(default)]
    cd_corr_file: String,
    retarder: Retarder,
    axle_config: AxleConfig,
    #[serde(default)]
    angledrive: Kind,
    #[serde(rename = "PTO", default)]
    pto: Kind,
    /// Highest torques by gear.
    #[serde(default)]
    torque_limits: Value,
}

/// Something of which only the kind is asked.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Kind {
    #[serde(rename = "Type", default)]
    kind: String,
}

impl Kind {
    fn is_there(&self) -> bool {
        !["", "none"].contains(&self.kind.trim().to_lowercase().as_str())
    }
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
    /// Size of the tyres.
    #[serde(default)]
    wheels: String,
    /// `VehicleDriven` or not, in newer files.
    #[serde(rename = "Type", default)]
    kind: String,
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
    wheels: String::new(),
    kind: String::new(),
    weight_share: 0.0,
    twin_tyres: false,
    rrc_iso: 0.005_55,
    fz_iso: 37_500.0,
};
/// Its mass, in kg [F: the same].
const TRAILER_KG: f64 = 7500.0;
/// Shares of the axles of a tractor with it on long haul [F: the same, segment table].
const DECLARED_SHARES: [f64; 5] = [0.2, 0.25, 0.55 / 3.0, 0.55 / 3.0, 0.55 / 3.0];

/// A rigid truck of the declaration mode on its missions without a trailer [F: VECTO 3, segment
/// table and weights of bodies]: its axles, its mass in t up to which it holds, shares of the
/// axles, and the mass of its body in kg.
const DECLARED_RIGIDS: [(&str, f64, &[f64], f64); 7] = [
    ("4x2", 7.5, &[0.45, 0.55], 1600.0),
    ("4x2", 10.0, &[0.45, 0.55], 1600.0),
    ("4x2", 12.0, &[0.45, 0.55], 1900.0),
    ("4x2", 16.0, &[0.4, 0.6], 2000.0),
    ("4x2", f64::INFINITY, &[0.45, 0.55], 2100.0),
    ("6x2", f64::INFINITY, &[0.35, 0.4, 0.25], 2200.0),
    ("6x4", f64::INFINITY, &[0.35, 0.35, 0.3], 2200.0),
];
/// Categories of whole buses, in small letters.
const BUSES: [&str; 3] = ["citybus", "interurbanbus", "coach"];
/// Modes of the correction for cross wind.
const CORRECTIONS: [&str; 4] = ["off", "cdofvdecl", "cdofveng", "cdofv"];
/// Relative change of the drag area that is none.
const SAME_DRAG: f64 = 1e-4;

/// Least version of a vehicle's file whose axles have what is asked.
const LEAST_VERSION: u32 = 3;

impl VehicleFile {
    pub(super) fn read(path: &Path) -> Result<Self, VectoError> {
        let part = Part::read(path)?;
        if let Some(version) = part.version.filter(|version| *version < LEAST_VERSION) {
            let allowed = "allowed is 3 and higher: open the job in VECTO 2.2 and save it";
            return part.refused("`FileVersion`", version.to_string(), allowed);
        }
        let vehicle: Self = part.keys()?;
        vehicle.check(path)?;
        Ok(vehicle)
    }

    /// Whether it is one of the declaration mode; where it does not say so: without shares of
    /// axles.
    fn is_declared(&self) -> bool {
        let shares: f64 = self.axle_config.axles.iter().map(|axle| axle.weight_share).sum();
        self.saved_in_decl_mode.unwrap_or(shares == 0.0)
    }

    /// The mode of the correction for cross wind: the declaration mode has one.
    fn correction(&self) -> String {
        if self.is_declared() { "cdofvdecl".to_owned() } else { self.cd_corr_mode.to_lowercase() }
    }

    /// Values that are not used.
    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let asked = self.cd_corr_mode.to_lowercase();
        if self.is_declared() && !["", "cdofvdecl"].contains(&asked.as_str()) {
            notes.push(format!(
                "`CdCorrMode` `{}`: declaration mode has the cross wind of `CdOfVdecl`",
                self.cd_corr_mode
            ));
        }
        if self.pto.is_there() {
            notes.push(format!("`PTO` `{}`: its losses are left out", self.pto.kind));
        }
        if self.torque_limits.as_object().is_some_and(|limits| !limits.is_empty()) {
            notes.push("`TorqueLimits`: the engine's full load holds in all gears".to_owned());
        }
        notes
    }

    fn check(&self, path: &Path) -> Result<(), VectoError> {
        let refused = |what, found, allowed| {
            Err(VectoError::Unsupported { path: path.to_owned(), what, found, allowed })
        };
        let kind = self.veh_cat.to_lowercase();
        if kind.contains("bus") && !BUSES.contains(&kind.as_str()) {
            let allowed = "allowed are `Tractor`, `RigidTruck`, `CityBus`, `InterurbanBus` and \
                           `Coach`; buses in stages are not computed";
            return refused("`VehCat`", format!("`{}`", self.veh_cat), allowed);
        }
        if !CORRECTIONS.contains(&self.correction().as_str()) {
            let allowed = "allowed are `Off`, `CdOfVdecl` and `CdOfVeng`: give the drag area of \
                           still air";
            return refused("`CdCorrMode`", format!("`{}`", self.cd_corr_mode), allowed);
        }
        let shares: f64 = self.axles().iter().map(|axle| axle.weight_share).sum();
        if (shares - 1.0).abs() > 1e-3 {
            let allowed = "allowed are shares with a sum of 1, and in declaration mode a tractor \
                           or a rigid truck of 4x2, 6x2 or 6x4";
            return refused("the sum of `AxleWeightShare`", shares.to_string(), allowed);
        }
        if self.radius_m().is_none() {
            let allowed = "allowed is a radius above 0, and in declaration mode a size of tyres \
                           (`Wheels`) of VECTO's table";
            return refused("`rdyn`", "missing".to_owned(), allowed);
        }
        if self.angledrive.is_there() {
            let quoted = format!("`{}`", self.angledrive.kind);
            return refused("`Angledrive`", quoted, "allowed is `None`: it is not computed");
        }
        if self.drag_area_m2().is_none() {
            let allowed = "allowed is `CdA`, or `Cd` and `CrossSecArea`; a declared vehicle \
                           without it has a default that is not known here";
            return refused("`CdA`", "missing".to_owned(), allowed);
        }
        Ok(())
    }

    /// Drag area in still air, in m².
    fn drag_area_m2(&self) -> Option<f64> {
        let product = self.cd.zip(self.cross_sec_area).map(|(cd, area_m2)| cd * area_m2);
        self.cda.or(product).filter(|cda_m2| *cda_m2 > 0.0)
    }

    /// The dynamic radius of the wheels in m: its own, else that of the driven tyres.
    fn radius_m(&self) -> Option<f64> {
        let own = self.rdyn.filter(|radius_mm| *radius_mm > 0.0).map(|mm| mm / 1000.0);
        own.or_else(|| {
            let axles = &self.axle_config.axles;
            let driven =
                (0..axles.len()).find(|k| self.is_driven(*k)).filter(|_| self.is_declared());
            dynamic_radius_m(&axles[driven?].wheels)
        })
    }

    /// Whether an axle is driven: as it says, else the second.
    fn is_driven(&self, place: usize) -> bool {
        let says = |axle: &Axle| axle.kind.eq_ignore_ascii_case("VehicleDriven");
        let axles = &self.axle_config.axles;
        if axles.iter().any(says) { axles.get(place).is_some_and(says) } else { place == 1 }
    }

    /// The row of a rigid truck in declaration mode.
    fn declared_rigid(&self) -> Option<&'static (&'static str, f64, &'static [f64], f64)> {
        let is_rigid = self.is_declared() && self.veh_cat.to_lowercase() == "rigidtruck";
        let axles = self.axle_config.axles.len();
        let mut rows = DECLARED_RIGIDS.iter().filter(|_| is_rigid);
        rows.find(|(kind, most_t, shares, _)| {
            *kind == self.axle_config.kind && self.mass_max <= *most_t && shares.len() == axles
        })
    }

    fn is_declared_tractor(&self) -> bool {
        self.is_declared() && self.veh_cat.to_lowercase() == "tractor"
    }

    pub(super) fn gross_mass_kg(&self) -> Option<f64> {
        let gross_kg = self.curb_weight + self.curb_weight_extra + self.loading;
        (!self.is_declared()).then_some(gross_kg)
    }

    pub(super) fn base_vehicle(&self) -> &'static str {
        match self.veh_cat.to_lowercase().as_str() {
            "tractor" => "tractor-40t-vecto",
            kind if BUSES.contains(&kind) => "city-bus-12m",
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
                    "load_share": axle.weight_share / sum, "driven": self.is_driven(k),
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
        let coefficients = match self.correction().as_str() {
            "cdofvdecl" => self.cross_wind(),
            _ => [0.0; 3],
        };
        let (at_rest, by_speed) = match self.correction().as_str() {
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
            "wheel_radius_m": self.radius_m(),
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
            kind if BUSES.contains(&kind) => [-0.000_794, 0.021_09, -0.001_09],
            _ => [0.013_526, 0.017_746, -0.000_666],
        }
    }

    /// The file of the retarder's losses, and its ratio to the shaft; none without one.
    pub(super) fn retarder(&self, path: &Path) -> Result<Option<(PathBuf, f64)>, VectoError> {
        let kind = self.retarder.kind.to_lowercase();
        // losses that are included in those of the gearbox are not counted twice
        let apart = kind != "none" && !kind.contains("included");
        let there = apart && names_file(&self.retarder.file);
        there.then(|| Ok((beside(path, &self.retarder.file)?, self.retarder.ratio))).transpose()
    }
}

/// The factor on the drag area at rest, and how it changes with the speed, of a table of factors
/// (`.vcdv`): a parabola from where it begins to change, by least squares.
fn drag_by_speed(path: &Path) -> Result<(f64, Value), VectoError> {
    let columns = Columns::read(path)?;
    let speed_kmh = columns.numbers_of_or_at(&["v_veh"], 0)?;
    let speed_mps: Vec<f64> = speed_kmh.iter().map(|kmh| kmh / 3.6).collect();
    // VECTO 2.2 takes the columns by their places
    let factor = columns.numbers_of_or_at(&["Cd", "Cd factor"], 1)?;
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
