//! A time series of VECTO (`.vmod`) as a log: what VECTO's driver drove, and its fuel.
//!
//! A row of it is the mean over a second, with the distance at its end. The speed at that end is
//! the mean of the two seconds that meet there. Limits are not in it: those of its mission are.

use super::{Second, VectoError, read_series};
use ocmc_io::intake::FileAccount;
use ocmc_io::log::{LogFile, LoggedTrip, stem};
use ocmc_io::table::Quantity;
use ocmc_io::table::source::ending;
use std::path::Path;

/// Whether a file is one, by its name.
pub fn is_one(path: &Path) -> bool {
    ending(path) == "vmod"
}

/// Reads a time series.
///
/// # Errors
/// [`VectoError`] names the file, the place and what is allowed.
pub fn read(path: &Path) -> Result<LogFile, VectoError> {
    let seconds = read_series(path)?.seconds;
    let column = |value: &dyn Fn(usize, &Second) -> f64| {
        seconds.iter().enumerate().map(|(k, second)| value(k, second)).collect::<Vec<f64>>()
    };
    let next = |k: usize| seconds.get(k + 1).map_or(seconds[k].speed_mps, |next| next.speed_mps);
    let columns = [
        (Quantity::Time, column(&|k, _| (k + 1) as f64)),
        (Quantity::Position, column(&|_, second| second.end_m)),
        (Quantity::Speed, column(&|k, second| 0.5 * (second.speed_mps + next(k)))),
        (Quantity::Grade, column(&|_, s| s.gradient / (1.0 + s.gradient * s.gradient).sqrt())),
        (Quantity::FuelRate, column(&|_, second| second.fuel_kgps)),
    ];
    let name = stem(path);
    let drive = LoggedTrip::new(&name, name.trim_end_matches(".vmod"), columns);
    Ok(LogFile {
        is_part: false,
        path: path.to_owned(),
        read: FileAccount::default(),
        rows: seconds.len(),
        drives: vec![drive],
        columns: Vec::new(),
        ragged_rows: 0,
        unreadable: Vec::new(),
    })
}
