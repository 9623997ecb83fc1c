//! Records of a fleet, one row a trip: which truck, which driver, and the quantity that is
//! compared.

use crate::intake::table::date;
use crate::intake::table::formats::FLEET;
use crate::intake::table::{Mapping, Quantity, Row, Source, Table, TableError};
use crate::intake::{FileAccount, trip};
use ocmc_estimation::fit::fleet::FleetTable;

/// Names of a column with the distance of a trip.
const DISTANCES: [&str; 14] = [
    "distance",
    "trip_distance",
    "trip_length",
    "dist",
    "trip",
    "route",
    "driven",
    "mileage",
    "km",
    "kilometres",
    "kilometers",
    "kilometer",
    "strecke",
    "distancia",
];

/// Word in `outcome` for a trip that arrived.
const COMPLETED: &str = "completed";

/// Reads records. `column` is the one whose numbers are compared, `weight` the one that says how
/// much a trip counts; `month` needs departures.
///
/// # Errors
/// [`TableError`] names the file, the place in it and what is allowed.
pub fn read(
    source: Source,
    mappings: &[Mapping],
    column: &str,
    weight: Option<&str>,
    month: bool,
) -> Result<(FleetTable, FileAccount), TableError> {
    let mut mappings = mappings.to_vec();
    let assigned = Mapping::columns(&mappings);
    let assign = |name: &str, column: Option<&str>| {
        let column = column.filter(|_| !assigned.contains_key(name));
        column.map(|column| Mapping::parse(&format!("{name}={column}"))).transpose()
    };
    mappings.extend(assign("response", Some(column))?);
    mappings.extend(assign("weight", weight)?);
    let file = Table::open(source, &FLEET, &mappings)?;
    file.need(&[Quantity::Truck])?;
    let dated = month && file.column(Quantity::Departure).is_none();
    if month {
        file.need_any("departure", &[Quantity::Departure, Quantity::Date])?;
    }
    let has = |quantity: Quantity| file.column(quantity).map(|_| Vec::new());
    let mut table = FleetTable {
        driver: file.column(Quantity::Driver).map(|_| Vec::new()),
        // a column that is called so and is not asked for counts nothing
        weight: has(Quantity::Weight)
            .filter(|_| weight.is_some() || assigned.contains_key("weight")),
        departure_s_of_year: month.then(Vec::new),
        completed: file.column(Quantity::Outcome).map(|_| Vec::new()),
        ..FleetTable::default()
    };
    let (mut trips, mut impossible) = (Vec::new(), Vec::new());
    let mut account = file.for_each(|row| {
        table.truck.push(row.text(Quantity::Truck).to_owned());
        if let Some(driver) = &mut table.driver {
            driver.push(row.text(Quantity::Driver).to_owned());
        }
        let value = row.number(Quantity::Response)?;
        let possible = trip::is_possible(column, value);
        trips.push((row.place(), value));
        if !possible {
            impossible.push((row.place(), value));
        }
        table.value.push(if possible { value } else { f64::NAN });
        if let Some(weight) = &mut table.weight {
            weight.push(row.number(Quantity::Weight)?);
        }
        if let Some(departure) = &mut table.departure_s_of_year {
            departure.push(if dated { date_of(row)? } else { row.number(Quantity::Departure)? });
        }
        if let Some(completed) = &mut table.completed {
            completed.push(row.text(Quantity::Outcome) == COMPLETED);
        }
        Ok(())
    })?;
    let all = trips.iter().filter(|trip| trip.1.is_finite()).count();
    account.judged(source.path(), trip::impossible(column, &impossible, all))?;
    trips.retain(|(_, value)| trip::is_possible(column, *value));
    account.findings.extend(trip::unusual(column, &trips));
    if is_over_distance(column) {
        account.findings.extend(trip::far(column, &trips));
    }
    Ok((table, account))
}

/// The time of a date since the beginning of its year, in s; NaN of an empty cell.
fn date_of(row: &Row) -> Result<f64, TableError> {
    let text = row.text(Quantity::Date);
    if text.is_empty() {
        return Ok(f64::NAN);
    }
    let second = date::second_of_year(text);
    second
        .ok_or_else(|| row.refuse(Quantity::Date, "a date such as 2024-03-01 or 2024-03-01T14:00"))
}

/// The column with the distance of each trip, where there is one.
///
/// # Errors
/// As [`read`].
pub fn distance_column(source: Source, mappings: &[Mapping]) -> Result<Option<String>, TableError> {
    let file = Table::open(source, &FLEET, mappings)?;
    Ok(file.names().iter().find(|name| is_distance(name)).cloned())
}

/// The one column with a consumption over the distance, whatever its carrier; none where there are
/// several.
///
/// # Errors
/// As [`read`].
pub fn consumption_column(
    source: Source,
    mappings: &[Mapping],
) -> Result<Option<String>, TableError> {
    let file = Table::open(source, &FLEET, mappings)?;
    let mut columns = file.names().iter().filter(|name| trip::is_consumption(name));
    Ok(match (columns.next(), columns.next()) {
        (Some(name), None) => Some(name.clone()),
        _ => None,
    })
}

/// Whether a name is that of the distance of a trip: one of [`DISTANCES`], with or without a unit.
fn is_distance(name: &str) -> bool {
    let name = name.to_lowercase();
    let text = name.split(['[', '(']).next().unwrap_or_default().trim().replace([' ', '-'], "_");
    let base = text.trim_end_matches("_km").trim_end_matches("_m");
    // a trip or a route without a unit is its name
    DISTANCES.contains(&base) && (base != text || !["trip", "route"].contains(&base))
}

/// Whether a column is an amount over the distance, of which longer trips know more.
pub fn is_over_distance(column: &str) -> bool {
    let column = column.to_lowercase();
    trip::is_consumption(&column)
        || ["per_100km", "per_km", "per_m", "per_100tkm", "/100km", "/100 km", "/km"]
            .iter()
            .any(|end| column.contains(end))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn table(text: &str, weight: Option<&str>, month: bool) -> Result<FleetTable, TableError> {
        let source = Source::Text(Path::new("records.csv"), text);
        read(source, &[], "consumption_l_per_100km", weight, month).map(|(table, _)| table)
    }

    #[test]
    fn records_by_their_names() {
        let text = "vehicle_id,driver,outcome,consumption_l_per_100km,\
                    distance_m,departure_s_of_year\n\
                    7,x,completed,31.5,1000,0\n7,,stalled,,2000,86400\n";
        let records = table(text, Some("distance_m"), true).unwrap();
        assert_eq!(records.truck, ["7", "7"]);
        assert_eq!(records.driver.unwrap(), ["x", ""]);
        assert!(records.value[0] == 31.5 && records.value[1].is_nan());
        assert_eq!(records.weight.unwrap(), [1000.0, 2000.0]);
        assert_eq!(records.departure_s_of_year.unwrap(), [0.0, 86_400.0]);
        assert_eq!(records.completed.unwrap(), [true, false]);
        let plain = table("truck,consumption_l_per_100km\na,30\n", None, false).unwrap();
        assert!(plain.driver.is_none() && plain.weight.is_none() && plain.completed.is_none());
    }

    #[test]
    fn what_is_missing_is_said() {
        for (text, weight, month, words) in [
            ("driver,consumption_l_per_100km\na,30\n", None, false, "no column for the truck"),
            ("truck,fuel\na,30\n", None, false, "no column `consumption_l_per_100km`"),
            ("truck,consumption_l_per_100km\na,30\n", Some("km"), false, "no column `km`"),
            ("truck,consumption_l_per_100km\na,30\n", None, true, "no column for the departure"),
            ("truck,consumption_l_per_100km\na,much\n", None, false, "line 2"),
        ] {
            let message = table(text, weight, month).unwrap_err().to_string();
            assert!(message.contains(words), "{text}: {message}");
        }
    }
}
