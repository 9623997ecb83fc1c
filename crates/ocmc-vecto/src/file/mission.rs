//! A mission: target speed, gradient, stops and added power along the road.

use super::error::VectoError;
use super::result::Columns;
use crate::driver::{Mission, MissionRow};
use std::path::Path;

/// A `.vdri` file over distance.
#[derive(Clone, Debug, PartialEq)]
pub struct MissionFile {
    /// The mission.
    pub mission: Mission,
    /// Whether it begins with a truck at rest.
    pub begins_at_rest: bool,
    /// Mean over the rows of the power that it adds to the auxiliaries, in W.
    pub added_power_w: f64,
}

impl MissionFile {
    /// Reads a mission.
    ///
    /// # Errors
    /// [`VectoError`] names the file, the place and what is allowed.
    pub fn read(path: &Path) -> Result<Self, VectoError> {
        let columns = Columns::read(path)?;
        let (position_m, speed_kmh) = (columns.numbers("s")?, columns.numbers("v")?);
        let or_zero = |name| columns.numbers_or(name, 0.0);
        let (gradient, stop_s) = (or_zero("grad")?, or_zero("stop")?);
        let added_kw = or_zero("Padd")?;
        let row = |k: usize| MissionRow {
            distance_m: position_m[k],
            target_mps: speed_kmh[k] / 3.6,
            gradient: gradient[k] / 100.0,
            stop_s: stop_s[k],
            auxiliary_w: 1000.0 * added_kw[k],
        };
        let rows: Vec<MissionRow> = (0..position_m.len()).map(row).collect();
        let mission =
            Mission::new(&rows).map_err(|error| VectoError::Mission(path.to_owned(), error))?;
        let sum_w: f64 = rows.iter().map(|row| row.auxiliary_w).sum();
        Ok(Self {
            mission,
            begins_at_rest: rows[0].target_mps <= 0.0,
            added_power_w: sum_w / rows.len() as f64,
        })
    }
}
