//! Tables of measured curves, one row a curve, as `ocmc curves` writes them.

use crate::table::{Column, Field, Mapping, Quantity, Schema, Source, Style, Table, TableError};
use ocmc_estimation::fit::curve_speed::CurveTable;

/// What a table of curves holds. Driver, radius and speed are needed.
pub const SCHEMA: Schema = Schema {
    what: "a table of curves",
    style: Style::Measurements,
    fields: &[
        Field::named(Quantity::Driver, &[("driver", ""), ("truck", "")]),
        Field::named(Quantity::Radius, &[("radius_m", "m")]),
        Field::named(Quantity::Speed, &[("speed_mps", "mps")]),
        Field::of(Quantity::Direction),
        Field::named(Quantity::RouteLength, &[("route_m", "m"), ("route_length_m", "m")]),
        Field::named(Quantity::Limit, &[("limit_mps", "mps"), ("speed_limit_mps", "mps")]),
    ],
};

/// Reads a table of curves.
///
/// # Errors
/// [`TableError`] names the file, the place in it and what is allowed.
pub fn read(source: Source, mappings: &[Mapping]) -> Result<CurveTable, TableError> {
    let file = Table::open(source, &SCHEMA, mappings)?;
    file.refuse_other_units()?;
    let driver = file.need(Quantity::Driver)?;
    let radius = file.need(Quantity::Radius)?;
    let speed = file.need(Quantity::Speed)?;
    let [direction, route, limit] =
        [Quantity::Direction, Quantity::RouteLength, Quantity::Limit].map(|q| file.column(q));
    let mut table = CurveTable {
        left: direction.map(|_| Vec::new()),
        route_m: route.map(|_| Vec::new()),
        limit_mps: limit.map(|_| Vec::new()),
        ..CurveTable::default()
    };
    file.for_each(|row| {
        table.driver.push(row.text(&driver).to_owned());
        table.radius_m.push(row.number(&radius)?);
        table.speed_mps.push(row.number(&speed)?);
        if let (Some(column), Some(left)) = (&direction, &mut table.left) {
            left.push(match row.text(column).to_ascii_lowercase().as_str() {
                "left" => true,
                "right" => false,
                _ => return Err(row.refuse(column, "`left` or `right`")),
            });
        }
        let optional: [(&Option<Column>, _); 2] =
            [(&route, &mut table.route_m), (&limit, &mut table.limit_mps)];
        for (column, values) in optional {
            if let (Some(column), Some(values)) = (column, values) {
                values.push(row.number(column)?);
            }
        }
        Ok(())
    })?;
    Ok(table)
}
