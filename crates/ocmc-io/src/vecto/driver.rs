//! The driver of a job: accelerations over speed, looking ahead, overspeed.

use super::error::VectoError;
use super::job::JobBody;
use super::part::{beside, names_file};
use super::result::Columns;
use serde::Deserialize;
use std::path::Path;

/// VECTO's accelerations over speed, at points of rising speed.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedDependentAcceleration {
    /// Speeds, in m/s.
    pub speed_mps: Vec<f64>,
    /// Largest acceleration, in m/s².
    pub acceleration_mps2: Vec<f64>,
    /// Deceleration, without sign, in m/s².
    pub deceleration_mps2: Vec<f64>,
}

impl SpeedDependentAcceleration {
    /// The driver of trucks in VECTO's declaration mode [F: Truck.vacc].
    pub fn truck() -> Self {
        Self {
            speed_mps: [0.0, 25.0, 50.0, 60.0, 120.0].map(|kmh| kmh / 3.6).to_vec(),
            acceleration_mps2: vec![1.0, 1.0, 0.642_857_143, 0.5, 0.5],
            deceleration_mps2: vec![1.0, 1.0, 1.0, 0.5, 0.5],
        }
    }

    fn read(path: &Path) -> Result<Self, VectoError> {
        let columns = Columns::read(path)?;
        let speed_mps = columns.numbers("v")?.iter().map(|v| v / 3.6).collect();
        let deceleration = columns.numbers("dec")?;
        Ok(Self {
            speed_mps,
            acceleration_mps2: columns.numbers("acc")?,
            deceleration_mps2: deceleration.iter().map(|a| a.abs()).collect(),
        })
    }
}

/// How a job says that it is driven.
#[derive(Clone, Debug, PartialEq)]
pub struct DriverSettings {
    /// Accelerations over speed.
    pub accelerations: SpeedDependentAcceleration,
    /// Deceleration, without sign, in m/s², of the look-ahead coasting and the speed from which on
    /// it is done, in m/s; none where it is off.
    pub look_ahead: Option<(f64, f64)>,
    /// Speed from which on the truck may roll above its target, and by how much, both in m/s; none
    /// where it may not.
    pub overspeed: Option<(f64, f64)>,
    /// Whether it rolls with the clutch open then.
    pub eco_roll: bool,
}

impl DriverSettings {
    /// The driver of VECTO's declaration mode: coasting, and 5 km/h of overspeed from 50 km/h on.
    pub fn declared() -> Self {
        Self {
            accelerations: SpeedDependentAcceleration::truck(),
            look_ahead: Some((0.5, 50.0 / 3.6)),
            overspeed: Some((50.0 / 3.6, 5.0 / 3.6)),
            eco_roll: false,
        }
    }

    pub(super) fn of(body: &JobBody, path: &Path) -> Result<Self, VectoError> {
        let accelerations = if names_file(&body.vacc) {
            SpeedDependentAcceleration::read(&beside(path, &body.vacc)?)?
        } else {
            SpeedDependentAcceleration::truck()
        };
        let LookAhead { enabled, dec, min_speed } = body.lac;
        let over = &body.over_speed_eco_roll;
        let mode = over.mode.to_lowercase();
        Ok(Self {
            accelerations,
            look_ahead: enabled.then_some((dec.abs(), min_speed / 3.6)),
            overspeed: (mode != "off").then_some((over.min_speed / 3.6, over.over_speed / 3.6)),
            eco_roll: mode == "ecoroll",
        })
    }
}

/// Look-ahead coasting, as a job has it.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct LookAhead {
    enabled: bool,
    #[serde(default)]
    dec: f64,
    #[serde(default)]
    min_speed: f64,
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
