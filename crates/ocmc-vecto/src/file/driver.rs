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
    let accelerations = if names_file(&body.vacc) {
        read(&beside(path, &body.vacc)?)?
    } else {
        declared_accelerations()
    };
    let coasting = &body.lac;
    let over = &body.over_speed_eco_roll;
    let minimum_speed_mps = coasting.min_speed.unwrap_or(FROM_KMH) / 3.6;
    let look_ahead = coasting.enabled.then_some(match coasting.dec {
        Some(dec) => LookAhead::Window { deceleration_mps2: -dec.abs(), minimum_speed_mps },
        // a job of VECTO 3 has factors of its decision instead
        None => LookAhead::DecisionFactor { minimum_speed_mps },
    });
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

fn read(path: &Path) -> Result<AccelerationTable, VectoError> {
    let columns = Columns::read(path)?;
    Ok(AccelerationTable {
        speed_mps: columns.numbers("v")?.iter().map(|v| v / 3.6).collect(),
        acceleration_mps2: columns.numbers("acc")?,
        deceleration_mps2: columns.numbers("dec")?.iter().map(|a| -a.abs()).collect(),
    })
}

/// Look-ahead coasting, as a job has it.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct Coasting {
    enabled: bool,
    dec: Option<f64>,
    min_speed: Option<f64>,
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
