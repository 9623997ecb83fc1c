//! The places of a route or a track, for a sketch of it.

use crate::intake::table::formats::ROUTE;
use crate::intake::table::{Quantity, Source, Table};
use std::path::Path;

/// Latitudes and longitudes of a file's rows, in degrees; none of a file without them.
pub fn places_deg(path: &Path) -> Option<[Vec<f64>; 2]> {
    let table = Table::open(Source::File(path), &ROUTE, &[]).ok()?;
    table.numbers([Quantity::Latitude, Quantity::Longitude]).ok()
}
