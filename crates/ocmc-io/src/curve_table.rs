//! Tables of measured curves: `driver,radius_m,direction,speed_mps`, one row a curve.
//!
//! As `ocmc curves` writes them. `truck` may stand in place of `driver`; `direction` (`left` or `right`), `route_m` and
//! `limit_mps` may be absent.
//! Other columns are not looked at. An empty cell is a missing value.

use crate::column_file::{ColumnFile, ColumnFileError};
use ocmc_estimation::fit::curve_speed::CurveTable;
use std::io::Read;
use std::path::Path;

/// Reads a table of curves.
///
/// # Errors
/// [`ColumnFileError`] names the file, the place in it and what is allowed.
pub fn read(path: &Path) -> Result<CurveTable, ColumnFileError> {
    read_columns(ColumnFile::open(path)?)
}

/// Reads a table of curves whose header has been read.
///
/// # Errors
/// As [`read`].
pub fn read_columns(mut file: ColumnFile<impl Read>) -> Result<CurveTable, ColumnFileError> {
    let driver = file.need_words(&["driver", "truck"])?;
    let radius = file.need_numbers(&["radius_m"])?;
    let speed = file.need_numbers(&["speed_mps"])?;
    let direction = file.words(&["direction"])?;
    let route = file.numbers(&["route_m", "route_length_m"])?;
    let limit = file.numbers(&["limit_mps", "speed_limit_mps"])?;
    let mut table = CurveTable {
        left: direction.map(|_| Vec::new()),
        route_m: route.map(|_| Vec::new()),
        limit_mps: limit.map(|_| Vec::new()),
        ..CurveTable::default()
    };
    file.for_each(|row| {
        table.driver.push(row.text(driver).to_owned());
        table.radius_m.push(row.number(radius)?);
        table.speed_mps.push(row.number(speed)?);
        if let (Some(column), Some(left)) = (direction, &mut table.left) {
            left.push(match row.text(column).to_ascii_lowercase().as_str() {
                "left" => true,
                "right" => false,
                _ => return Err(row.refuse(column, "`left` or `right`")),
            });
        }
        for (column, values) in [(route, &mut table.route_m), (limit, &mut table.limit_mps)] {
            if let (Some(column), Some(values)) = (column, values) {
                values.push(row.number(column)?);
            }
        }
        Ok(())
    })?;
    Ok(table)
}
