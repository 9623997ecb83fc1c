//! The driver of a job: accelerations over speed, looking ahead, overspeed.

use super::error::VectoError;
use super::job::JobBody;
use super::part::{beside, names_file};
use super::result::Columns;
use crate::driver::{AccelerationTable, LookAhead, Overspeed, VectoDriver};
use serde::Deserialize;
use std::path::Path;

/// Speed from which on VECTO's declaration mode coasts and rolls too fast, in km/h [F: VECTO 2.2].
const FROM_KMH: f64 = 50.0;
/// By how much it rolls too fast, in km/h [F: the same].
const OVERSPEED_KMH: f64 = 5.0;

/// How long it waits with a shift in the other direction, in s [F: VECTO 3, user manual, AMT].
const OPPOSITE_S: f64 = 10.0;

/// Numbers of the look-ahead of VECTO 3, as `driver::ahead` has them [F: VECTO 3, user manual].
const FACTOR_OFFSET: f64 = 2.5;
const FACTOR_SCALING: f64 = 1.5;
const PREVIEW_FACTOR: f64 = 10.0;

/// The accelerations of trucks in VECTO's declaration mode [F: Truck.vacc].
fn declared_accelerations() -> AccelerationTable {
    AccelerationTable {
        speed_mps: [0.0, 25.0, 50.0, 60.0, 120.0].map(|kmh| kmh / 3.6).to_vec(),
        acceleration_mps2: vec![1.0, 1.0, 0.642_857_143, 0.5, 0.5],
        deceleration_mps2: vec![-1.0, -1.0, -1.0, -0.5, -0.5],
    }
}

/// The driver of VECTO 3's declaration mode, for a truck without a job.
pub fn declared_driver() -> VectoDriver {
    VectoDriver {
        look_ahead: Some(LookAhead::DecisionFactor { minimum_speed_mps: FROM_KMH / 3.6 }),
        overspeed: Some(Overspeed {
            minimum_speed_mps: FROM_KMH / 3.6,
            above_mps: OVERSPEED_KMH / 3.6,
        }),
        opposite_shift_time_s: OPPOSITE_S,
        ..VectoDriver::new(declared_accelerations())
    }
}

/// The driver of a job, without what the gearbox says of him.
pub(super) fn of_job(body: &JobBody, path: &Path) -> Result<VectoDriver, VectoError> {
    let accelerations = match beside(path, &body.vacc) {
        Ok(file) => read(&file)?,
        Err(_) if !names_file(&body.vacc) || is_vectos_own(&body.vacc) => declared_accelerations(),
        Err(error) => return Err(error),
    };
    let Some(over) = &body.over_speed_eco_roll else {
        return Ok(VectoDriver { acceleration: accelerations, ..declared_driver() });
    };
    let look_ahead = body.lac.as_ref().map_or(declared_driver().look_ahead, Coasting::look_ahead);
    let overspeed = match over.mode.to_lowercase().as_str() {
        "off" => None,
        "overspeed" => Some(Overspeed {
            minimum_speed_mps: over.min_speed / 3.6,
            above_mps: over.over_speed / 3.6,
        }),
        _ => {
            return Err(VectoError::Unsupported {
                path: path.to_owned(),
                what: "`OverSpeedEcoRoll.Mode`",
                found: format!("`{}`", over.mode),
                allowed: "allowed are `Off` and `OverSpeed`: eco-roll is not in this driver",
            });
        }
    };
    Ok(VectoDriver { look_ahead, overspeed, ..VectoDriver::new(accelerations) })
}

/// Whether a table of accelerations is that of trucks which VECTO 3 takes where there is no such
/// file.
fn is_vectos_own(vacc: &str) -> bool {
    let name = vacc.rsplit(['/', '\\']).next().unwrap_or(vacc);
    ["truck", "truck.vacc"].contains(&name.trim().to_lowercase().as_str())
}

/// How long a driver waits with a shift in the other direction where the gearbox does not say it,
/// in s: VECTO 2.2's does not wait.
pub(super) fn opposite_shift_time_s(driver: &VectoDriver) -> f64 {
    match driver.look_ahead {
        Some(LookAhead::DecisionFactor { .. }) => OPPOSITE_S,
        _ => 0.0,
    }
}

fn read(path: &Path) -> Result<AccelerationTable, VectoError> {
    let columns = Columns::read(path)?;
    Ok(AccelerationTable {
        speed_mps: columns.numbers("v")?.iter().map(|v| v / 3.6).collect(),
        acceleration_mps2: columns.numbers("acc")?,
        deceleration_mps2: columns.numbers("dec")?.iter().map(|a| -a.abs()).collect(),
    })
}

/// Look-ahead coasting, as a job has it.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct Coasting {
    enabled: bool,
    /// VECTO 2.2: the deceleration of the window.
    dec: Option<f64>,
    min_speed: Option<f64>,
    /// VECTO 3: what the decision factor is made of.
    #[serde(rename = "DF_offset")]
    factor_offset: Option<f64>,
    #[serde(rename = "DF_scaling")]
    factor_scaling: Option<f64>,
    preview_distance_factor: Option<f64>,
}

impl Coasting {
    fn look_ahead(&self) -> Option<LookAhead> {
        let minimum_speed_mps = self.min_speed.unwrap_or(FROM_KMH) / 3.6;
        // a job of VECTO 3 has factors of its decision, and may have what 2.2 asked beside them
        let decides = self.factor_offset.is_some() || self.factor_scaling.is_some();
        self.enabled.then_some(match self.dec.filter(|_| !decides) {
            Some(dec) => LookAhead::Window { deceleration_mps2: -dec.abs(), minimum_speed_mps },
            None => LookAhead::DecisionFactor { minimum_speed_mps },
        })
    }

    /// Values that are not used.
    pub(super) fn notes(&self) -> Vec<String> {
        let asked = [
            ("DF_offset", self.factor_offset, FACTOR_OFFSET),
            ("DF_scaling", self.factor_scaling, FACTOR_SCALING),
            ("PreviewDistanceFactor", self.preview_distance_factor, PREVIEW_FACTOR),
        ];
        let other = asked.into_iter().filter_map(|(name, asked, own)| {
            let asked = asked.filter(|asked| (asked - own).abs() > 1e-9)?;
            Some(format!("`{name}` {asked}: VECTO's driver here has {own}"))
        });
        if self.enabled { other.collect() } else { Vec::new() }
    }
}

/// Overspeed and eco-roll, as a job has them.
#[derive(Clone, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct OverSpeedEcoRoll {
    mode: String,
    #[serde(default)]
    min_speed: f64,
    #[serde(default)]
    over_speed: f64,
}
