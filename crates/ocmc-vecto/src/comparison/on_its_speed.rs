//! VECTO's speed as a drive cycle.

use super::error::ComparisonError;
use crate::file::Series;
use ocmc_core::powertrain::GearOrder;
use ocmc_core::prescribed::DriveCycle;
use std::path::Path;

/// Rounding of a series' speeds, in m/s: below it a truck stands.
const ROUNDING_MPS: f64 = 1e-4;

/// The speed of a time series, second by second, with the slopes and gears of its rows. The speeds
/// of rows are means; those between rows follow from the accelerations.
pub(super) fn drive_cycle(path: &Path, series: &Series) -> Result<DriveCycle, ComparisonError> {
    let first = series.seconds[0];
    let mut node_mps = first.speed_mps - 0.5 * first.acceleration_mps2;
    let plain = |speed_mps: f64| if speed_mps < ROUNDING_MPS { 0.0 } else { speed_mps };
    let (mut time, mut speed) = (vec![0.0], vec![plain(node_mps)]);
    let (mut slope, mut gears) = (vec![0.0], vec![GearOrder::Open]);
    for (k, second) in series.seconds.iter().enumerate() {
        node_mps += second.acceleration_mps2;
        time.push(k as f64 + 1.0);
        speed.push(plain(node_mps));
        slope.push(second.gradient / (1.0 + second.gradient * second.gradient).sqrt());
        gears.push(match second.gear.checked_sub(1) {
            Some(gear) => GearOrder::Engaged(gear),
            None => GearOrder::Open,
        });
    }
    let cycle = DriveCycle::new(time, speed, slope)
        .map_err(|error| ComparisonError::Speed(path.to_owned(), error))?;
    Ok(cycle.with_gears(gears))
}
