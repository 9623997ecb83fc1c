//! Tables of measured curves, one row a curve, as `ocmc curves` writes them.

use crate::table::formats::CURVES;
use crate::table::{Mapping, Quantity, Source, Table, TableError};
use ocmc_estimation::fit::curve_speed::CurveTable;

/// Reads a table of curves.
///
/// # Errors
/// [`TableError`] names the file, the place in it and what is allowed.
pub fn read(source: Source, mappings: &[Mapping]) -> Result<CurveTable, TableError> {
    let file = Table::open(source, &CURVES, mappings)?;
    file.refuse_other_units()?;
    file.need(&[Quantity::Driver, Quantity::Radius, Quantity::Speed])?;
    let mut table = CurveTable {
        left: file.column(Quantity::Direction).map(|_| Vec::new()),
        route_m: file.column(Quantity::RouteLength).map(|_| Vec::new()),
        limit_mps: file.column(Quantity::Limit).map(|_| Vec::new()),
        ..CurveTable::default()
    };
    file.for_each(|row| {
        table.driver.push(row.text(Quantity::Driver).to_owned());
        table.radius_m.push(row.number(Quantity::Radius)?);
        table.speed_mps.push(row.number(Quantity::Speed)?);
        if let Some(left) = &mut table.left {
            left.push(match row.text(Quantity::Direction).to_ascii_lowercase().as_str() {
                "left" => true,
                "right" => false,
                _ => return Err(row.refuse(Quantity::Direction, "`left` or `right`")),
            });
        }
        if let Some(route_m) = &mut table.route_m {
            route_m.push(row.number(Quantity::RouteLength)?);
        }
        if let Some(limit_mps) = &mut table.limit_mps {
            limit_mps.push(row.number(Quantity::Limit)?);
        }
        Ok(())
    })?;
    Ok(table)
}
