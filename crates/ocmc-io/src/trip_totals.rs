//! Totals of a fleet's trips, one row a trip: distance, fuel or energy, and what else a table has.
//!
//! Fills of fuel cards are rows, too: a fill is no trip, and its litres belong to the kilometres
//! since the last full tank.

use crate::intake::table::date;
use crate::intake::table::formats::TRIP_TOTALS;
use crate::intake::table::given::RowPlace;
use crate::intake::table::{Mapping, Quantity, Row, Source, Table, TableError};
use crate::intake::{FileAccount, Finding};
use ocmc_core::energy::Carrier;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Density with which the table's reader takes litres for kilograms ([`Quantity::FuelAmount`]), in
/// kg/L.
const READ_KG_PER_L: f64 = 0.835;
const JOULE_PER_KWH: f64 = 3.6e6;
/// A row that is twice in a table: the place of the second one.
const DOUBLED: &str = "doubled-row";
/// How a full tank is written, beside 1.
const FULL: [&str; 7] = ["1", "yes", "y", "true", "full", "x", "ja"];

/// Amounts of a fleet's trips.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TripTotals {
    /// The trips whose distance and amount are known, in the order of the table; of fills, the ways
    /// between two full tanks.
    pub rows: Vec<TripTotal>,
    /// Unit of the amounts.
    pub amount: Amount,
    /// Whether the rows are ways between fills, which hold several trips.
    pub of_fills: bool,
    /// Rows without a distance or an amount above zero.
    pub left_out: usize,
}

/// Unit of the amounts of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Amount {
    /// Litres.
    #[default]
    Litres,
    /// Kilograms of fuel.
    Kilograms,
    /// Kilowatt-hours from the battery.
    KilowattHours,
}

impl Amount {
    /// The carrier that it is of.
    pub fn is_of(self, carrier: Carrier) -> bool {
        (self == Self::KilowattHours) == carrier.declaration().filled.is_none()
    }
}

/// Totals of a trip; NaN where the table does not have them.
#[derive(Clone, Debug, PartialEq)]
pub struct TripTotal {
    /// Where it stands.
    pub place: RowPlace,
    /// Distance, in m.
    pub distance_m: f64,
    /// Amount of fuel or energy, in the unit of [`TripTotals::amount`].
    pub amount: f64,
    /// Gross weight, in kg.
    pub gross_kg: f64,
    /// Payload, in kg.
    pub payload_kg: f64,
    /// Driving time, in s.
    pub driving_s: f64,
    /// Time from start to end, in s.
    pub duration_s: f64,
    /// Sum of the climbs, in m.
    pub climb_m: f64,
    /// The truck; empty where it is missing.
    pub truck: String,
    /// The driver; empty where it is missing.
    pub driver: String,
    /// The route; empty where it is missing.
    pub route: String,
    /// The group; empty where it is missing.
    pub group: String,
    /// When it departed, in s since 1900.
    pub time_s: f64,
    /// When it departed, in s from the beginning of the year.
    pub s_of_year: f64,
}

/// Time since 1900, in s, of a date such as `2024-03-01` or `2024-03-01T14:00`.
pub fn time_of(date: &str) -> Option<f64> {
    date::time_of(date)
}

/// A row as it is read.
struct Read {
    total: TripTotal,
    date: String,
    odometer_m: f64,
    is_full: bool,
}

/// Reads a table of trips, or of fills.
///
/// # Errors
/// [`TableError`] names the file, the place in it and what is allowed.
pub fn read(source: Source, mappings: &[Mapping]) -> Result<(TripTotals, FileAccount), TableError> {
    let file = Table::open(source, &TRIP_TOTALS, mappings)?;
    file.need_any("distance", &[Quantity::Distance, Quantity::Odometer])?;
    let amounts = [Quantity::FuelAmount, Quantity::EnergyAmount];
    file.need_any("amount of fuel or energy", &amounts)?;
    let amount_is = match file.column(Quantity::FuelAmount) {
        None => Amount::KilowattHours,
        Some(column) if ["l", "ml"].contains(&column.unit.suffix) => Amount::Litres,
        Some(_) => Amount::Kilograms,
    };
    let of_fills = file.column(Quantity::Distance).is_none();
    let says_full = file.column(Quantity::FullTank).is_some();
    if of_fills {
        file.need(&[Quantity::Truck])?;
    }
    let mut read = Vec::new();
    let mut account = file.for_each(|row| {
        read.push(read_row(row, amount_is, says_full)?);
        Ok(())
    })?;
    account.findings.extend(doubled(&read));
    let rows =
        if of_fills { between_fills(&read) } else { read.into_iter().map(|r| r.total).collect() };
    let all = rows.len();
    let known = |row: &TripTotal| row.distance_m > 0.0 && row.amount > 0.0;
    let rows: Vec<TripTotal> = rows.into_iter().filter(known).collect();
    let left_out = all - rows.len();
    Ok((TripTotals { rows, amount: amount_is, of_fills, left_out }, account))
}

fn read_row(row: &Row, amount: Amount, says_full: bool) -> Result<Read, TableError> {
    let fuel = row.number(Quantity::FuelAmount)?;
    let amount = match amount {
        Amount::Litres => fuel / READ_KG_PER_L,
        Amount::Kilograms => fuel,
        Amount::KilowattHours => row.number(Quantity::EnergyAmount)? / JOULE_PER_KWH,
    };
    let full = row.text(Quantity::FullTank).to_lowercase();
    let total = TripTotal {
        place: row.place(),
        distance_m: row.number(Quantity::Distance)?,
        amount,
        gross_kg: row.number(Quantity::GrossWeight)?,
        payload_kg: row.number(Quantity::Payload)?,
        driving_s: row.number(Quantity::DrivingTime)?,
        duration_s: row.number(Quantity::Duration)?,
        climb_m: row.number(Quantity::Climb)?,
        truck: row.text(Quantity::Truck).to_owned(),
        driver: row.text(Quantity::Driver).to_owned(),
        route: row.text(Quantity::RouteName).to_owned(),
        group: row.text(Quantity::Group).to_owned(),
        time_s: date::time_of(row.text(Quantity::Date)).unwrap_or(f64::NAN),
        s_of_year: date::second_of_year(row.text(Quantity::Date)).unwrap_or(f64::NAN),
    };
    Ok(Read {
        total,
        date: row.text(Quantity::Date).to_owned(),
        odometer_m: row.number(Quantity::Odometer)?,
        is_full: !says_full || FULL.contains(&full.as_str()),
    })
}

/// Names rows that are the same as one before: truck, date, distance and amount.
fn doubled(rows: &[Read]) -> Option<Finding> {
    let mut seen = BTreeMap::new();
    let mut pairs = Vec::new();
    for row in rows {
        let TripTotal { truck, distance_m, amount, gross_kg, driving_s, .. } = &row.total;
        let numbers =
            [distance_m, amount, gross_kg, driving_s, &row.odometer_m].map(|x| x.to_bits());
        let key = (truck.as_str(), row.date.as_str(), numbers);
        match seen.entry(key) {
            Entry::Occupied(first) => pairs.push((*first.get(), row.total.place)),
            Entry::Vacant(place) => {
                place.insert(row.total.place);
            }
        }
    }
    let (first, second) = pairs.first()?;
    let count = pairs.len();
    let text = format!(
        "{count} of {} rows are the same as one before, first that in {second} as that in {first}",
        rows.len()
    );
    let remedy = "each counts as a trip of its own: leave the second one out if it is none";
    Some(Finding::warned(DOUBLED, [count as f64, 0.0], text, remedy))
}

/// The ways between full tanks: the litres of a fill, and of the fills in part before it, belong to
/// the kilometres since the last full one.
fn between_fills(rows: &[Read]) -> Vec<TripTotal> {
    let mut of_truck: BTreeMap<&str, Vec<&Read>> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.odometer_m.is_finite()) {
        of_truck.entry(&row.total.truck).or_default().push(row);
    }
    let mut ways = Vec::new();
    for fills in of_truck.values_mut() {
        fills.sort_by(|a, b| a.odometer_m.total_cmp(&b.odometer_m));
        let mut since: Option<f64> = None;
        let mut amount = 0.0;
        let mut weights = Vec::new();
        for fill in fills.iter() {
            amount += fill.total.amount;
            weights.push(fill.total.gross_kg);
            if !fill.is_full {
                continue;
            }
            if let Some(start_m) = since {
                let known: Vec<f64> = weights.iter().copied().filter(|w| w.is_finite()).collect();
                let gross_kg = known.iter().sum::<f64>() / known.len() as f64;
                let distance_m = fill.odometer_m - start_m;
                ways.push(TripTotal { distance_m, amount, gross_kg, ..fill.total.clone() });
            }
            (since, amount) = (Some(fill.odometer_m), 0.0);
            weights.clear();
        }
    }
    ways
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn table(text: &str) -> Result<(TripTotals, FileAccount), TableError> {
        read(Source::Text(Path::new("trips.csv"), text), &[])
    }

    #[test]
    fn trips_in_the_units_of_their_columns() {
        let text = "truck,date,km,litres,gross_weight_t,driving_h\n\
                    a,2024-03-01,100,30,30,1.5\na,2024-03-02,,30,30,1.5\n";
        let (totals, account) = table(text).unwrap();
        assert_eq!((totals.rows.len(), totals.left_out, totals.amount), (1, 1, Amount::Litres));
        let row = &totals.rows[0];
        assert_eq!((row.distance_m, row.gross_kg, row.driving_s), (1e5, 3e4, 5400.0));
        assert!((row.amount - 30.0).abs() < 1e-12 && row.climb_m.is_nan());
        assert!(account.findings.is_empty(), "{:?}", account.findings);
        let electric = table("distance_km,energy_kwh\n100,130\n").unwrap().0;
        assert!(electric.amount == Amount::KilowattHours && electric.rows[0].amount == 130.0);
        let kilograms = table("distance_km,fuel_kg\n100,25\n").unwrap().0;
        assert!(kilograms.amount == Amount::Kilograms && kilograms.rows[0].amount == 25.0);
    }

    #[test]
    fn a_german_table_is_read_as_it_is() {
        let text = "Kennzeichen;Fahrer;Datum;km;Liter;Gesamtgewicht [t];Fahrzeit [h]\n\
                    A;X;01.03.2024;312,4;98,2;31,2;4,5\n";
        let (totals, _) = table(text).unwrap();
        let row = &totals.rows[0];
        assert_eq!((row.distance_m, row.gross_kg, row.driving_s), (312_400.0, 31_200.0, 16_200.0));
        assert!((row.amount - 98.2).abs() < 1e-9 && row.truck == "A" && row.driver == "X");
        let day = row.s_of_year / 86_400.0;
        assert_eq!(day, 59.0, "1 March of a year of 365 days");
        let fills = "Fahrzeug;Kilometerstand;Liter;vollgetankt\nA;1000;300;ja\nA;1600;170;ja\n";
        let (totals, _) = table(fills).unwrap();
        assert!(totals.of_fills && totals.rows[0].distance_m == 6e5, "{:?}", totals.rows);
    }

    #[test]
    fn litres_of_fills_belong_to_the_kilometres_since_the_last_full_tank() {
        // by hand: 600 km with 90 + 80 L, then 500 km with 150 L; the first fill only starts
        let text = "truck,date,odometer_km,litres,full\na,1,1000,300,yes\na,2,1300,90,no\n\
                    a,3,1600,80,yes\na,4,2100,150,yes\nb,1,70,100,yes\n";
        let (totals, _) = table(text).unwrap();
        assert!(totals.of_fills);
        let ways: Vec<(f64, f64)> =
            totals.rows.iter().map(|row| (row.distance_m, libm::round(row.amount))).collect();
        assert_eq!(ways, [(6e5, 170.0), (5e5, 150.0)]);
        let error = table("odometer_km,litres\n1,2\n").unwrap_err().to_string();
        assert!(error.contains("no column for the truck"), "{error}");
    }

    #[test]
    fn a_row_that_is_twice_is_named() {
        let text = "truck,date,km,litres\na,1,100,30\na,2,90,31\na,1,100,30\n";
        let (totals, account) = table(text).unwrap();
        assert_eq!(totals.rows.len(), 3);
        let text = account.findings[0].to_string();
        assert!(text.contains("line 4") && text.contains("doubled-row"), "{text}");
        for (text, words) in [
            ("truck,litres\na,1\n", "no column for the distance"),
            ("truck,km\na,1\n", "no column for the amount of fuel or energy"),
            ("km,litres\n100,much\n", "line 2"),
            ("km,litres\n-100,3\n", "from 0"),
        ] {
            let error = table(text).unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}
