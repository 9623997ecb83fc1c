//! A mission: target speed, gradient, stops and added power along the road.

use super::error::VectoError;
use super::result::Columns;
use std::path::Path;

/// A row of a mission; it holds until the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MissionRow {
    /// Position, in m.
    pub position_m: f64,
    /// Target speed, in m/s.
    pub speed_mps: f64,
    /// Gradient, rise over run.
    pub gradient: f64,
    /// Time for which the truck stands there, in s.
    pub stop_s: f64,
    /// Power of auxiliaries beside the truck's, in W.
    pub added_power_w: f64,
}

/// A `.vdri` file over distance.
#[derive(Clone, Debug, PartialEq)]
pub struct Mission {
    /// Its rows, in order.
    pub rows: Vec<MissionRow>,
}

impl Mission {
    /// Reads a mission.
    ///
    /// # Errors
    /// [`VectoError`] names the file, the place and what is allowed.
    pub fn read(path: &Path) -> Result<Self, VectoError> {
        let columns = Columns::read(path)?;
        let position_m = columns.numbers("s")?;
        let speed_kmh = columns.numbers("v")?;
        let or_zero = |name| columns.numbers_or(name, 0.0);
        let (gradient, stop_s) = (or_zero("grad")?, or_zero("stop")?);
        let added_kw = or_zero("Padd")?;
        let rises = position_m.windows(2).all(|pair| pair[1] >= pair[0]);
        let bad = position_m.iter().chain(&speed_kmh).chain(&gradient).any(|x| !x.is_finite());
        if position_m.len() < 2 || !rises || bad || speed_kmh.iter().any(|v| *v < 0.0) {
            let problem =
                "it is no mission; allowed are at least 2 rows of rising positions, with \
                           speeds from 0 on"
                    .to_owned();
            return Err(VectoError::Row { path: path.to_owned(), line: 2, problem });
        }
        let row = |k: usize| MissionRow {
            position_m: position_m[k],
            speed_mps: speed_kmh[k] / 3.6,
            gradient: gradient[k] / 100.0,
            stop_s: stop_s[k],
            added_power_w: 1000.0 * added_kw[k],
        };
        Ok(Self { rows: (0..position_m.len()).map(row).collect() })
    }

    /// Length of the road, in m.
    pub fn length_m(&self) -> f64 {
        self.rows[self.rows.len() - 1].position_m - self.rows[0].position_m
    }
}
