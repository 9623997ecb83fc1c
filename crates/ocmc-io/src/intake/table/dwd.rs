//! Series of the German weather service (DWD, Climate Data Center, hourly observations): a file for
//! each parameter, known by its column `MESS_DATUM`.
//!
//! Source: the descriptions of the hourly station observations of temperature, wind, pressure and
//! precipitation, DWD Climate Data Center. `P`, the pressure reduced to sea level, is not read.

/// The clock of its series, in UTC.
const CLOCK: &str = "MESS_DATUM";
/// Number that stands for a missing value in its series.
const MISSING: f64 = -999.0;
/// Names that mean something in its series alone.
const NAMES: [(&str, &str); 3] =
    [("STATIONS_ID", "site"), ("F", "wind_speed_mps"), ("D", "wind_direction_deg")];

/// Whether a column is its clock, whose times are UTC although nothing says so.
pub(super) fn is_clock(name: &str) -> bool {
    name.eq_ignore_ascii_case(CLOCK)
}

/// Whether a table is one of its series.
fn is_one(header: &[String]) -> bool {
    header.iter().any(|name| is_clock(name))
}

/// The code for a missing value, where a table is one of its series.
pub(super) fn missing(header: &[String]) -> Option<f64> {
    is_one(header).then_some(MISSING)
}

/// The names of a table's columns, in one of its series those of the vocabulary.
pub(super) fn names(header: &[String]) -> impl Iterator<Item = &str> {
    let is_one = is_one(header);
    header.iter().map(move |name| {
        let known = NAMES.iter().find(|(own, _)| is_one && name.eq_ignore_ascii_case(own));
        known.map_or(name.as_str(), |(_, known)| known)
    })
}
