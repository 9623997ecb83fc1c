//! Trips of a fleet: consumptions that no vehicle has, and trips far from all others.

use super::Finding;
use crate::intake::table::given::RowPlace;
use crate::number_text::{count_of, grouped, rounded};

/// A unit of consumption over the distance.
struct Unit {
    /// Ends of names of columns, without blanks, brackets and case, `per` as `/`.
    forms: &'static [&'static str],
    /// Possible range for road vehicles: none makes fuel, and the heaviest combinations uphill take
    /// some 300 L/100 km.
    possible: [f64; 2],
    /// Medians of fleets, from small cars to road trains (judgement).
    usual: [f64; 2],
    /// Probable units below and above that.
    likely: [&'static str; 2],
}

const UNITS: [Unit; 4] = [
    Unit {
        forms: &["l/100km", "litres/100km", "liters/100km", "liter/100km", "litre/100km"],
        possible: [0.0, 500.0],
        usual: [3.0, 90.0],
        likely: ["L/km, or km/L", "L/1000 km, or L an hour"],
    },
    Unit {
        forms: &["kg/100km"],
        possible: [0.0, 400.0],
        usual: [0.5, 80.0],
        likely: ["kg/km", "kg/1000 km"],
    },
    Unit {
        forms: &["kwh/km"],
        possible: [-5.0, 50.0],
        usual: [0.08, 5.0],
        likely: ["MWh/km", "kWh/100 km"],
    },
    Unit {
        forms: &["kwh/100km"],
        possible: [-500.0, 5000.0],
        usual: [8.0, 500.0],
        likely: ["kWh/km", "Wh/km"],
    },
];
/// Share of impossible trips from which on the unit is another one.
const MOST: f64 = 0.5;
/// Distance from the median, in standard deviations by the median deviation, from which on a trip
/// is far from all others (judgement: of a law with heavy tails one in millions).
const FAR: f64 = 20.0;
/// A median deviation times this is the standard deviation of a normal law.
const MAD_SD: f64 = 1.4826;
/// Fewest trips of which a spread is known.
const FEWEST: usize = 10;

/// The unit in the name of a column.
fn unit_of(column: &str) -> Option<&'static Unit> {
    let is_part = |c: &char| !c.is_whitespace() && !['_', '(', ')', '[', ']'].contains(c);
    let name = column.to_lowercase().replace("_per_", "/").replace(" per ", "/");
    let name: String = name.chars().filter(is_part).collect();
    // fuel of no unit is no litre
    let ends = |form: &&str| name.ends_with(*form) && !name.ends_with("fuel/100km");
    UNITS.iter().find(|unit| unit.forms.iter().any(ends))
}

/// Whether the name of a column is that of a consumption over the distance, with its unit.
pub fn is_consumption(column: &str) -> bool {
    unit_of(column).is_some()
}

/// Whether a trip can have taken so much.
pub fn is_possible(column: &str, value: f64) -> bool {
    let range = unit_of(column).map(|unit| unit.possible);
    range.is_none_or(|[low, high]| !(value < low || value > high))
}

/// Names trips that were left out because they cannot be, of `all` trips; where most of them are,
/// the unit is refused.
pub fn impossible(column: &str, trips: &[(RowPlace, f64)], all: usize) -> Option<Finding> {
    let (place, value) = trips.first()?;
    let [low, high] = unit_of(column)?.possible;
    let bound = if *value < low { low } else { high };
    let count = count_of(trips.len() as u64, "trip");
    if trips.len() as f64 > MOST * all as f64 {
        let text = format!(
            "{count} of {} of column `{column}` lie outside {low} to {high}, first {value} in \
             {place}",
            grouped(all as u64)
        );
        let remedy = "it has another unit than its name says: convert it, or rename it";
        return Some(Finding::refused("impossible-trip", [*value, bound], text, remedy));
    }
    let text = format!(
        "{count} of column `{column}` outside {low} to {high}, left out, first {value} in {place}"
    );
    let remedy = "no road vehicle takes that: correct the row, or the unit";
    Some(Finding::warned("impossible-trip", [*value, bound], text, remedy))
}

/// Names a fleet whose trips take what none does in the mean.
pub fn unusual(column: &str, trips: &[(RowPlace, f64)]) -> Option<Finding> {
    let unit = unit_of(column)?;
    let mut values: Vec<f64> = trips.iter().map(|trip| trip.1).filter(|v| v.is_finite()).collect();
    if values.is_empty() {
        return None;
    }
    let middle = median(&mut values);
    let [low, high] = unit.usual;
    let (bound, likely) = match middle {
        _ if middle < low => (low, unit.likely[0]),
        _ if middle > high => (high, unit.likely[1]),
        _ => return None,
    };
    let text = format!(
        "the median of column `{column}` is {}: fleets have {low} to {high}",
        rounded(middle)
    );
    let remedy = format!("is it in {likely}?");
    Some(Finding::warned("unusual-consumption", [middle, bound], text, &remedy))
}

/// Names the trip that is far from all others.
pub fn far(column: &str, trips: &[(RowPlace, f64)]) -> Option<Finding> {
    let mut values: Vec<f64> = trips.iter().map(|trip| trip.1).filter(|v| v.is_finite()).collect();
    if values.len() < FEWEST {
        return None;
    }
    let middle = median(&mut values);
    let mut off: Vec<f64> = values.iter().map(|value| (value - middle).abs()).collect();
    let sd = MAD_SD * median(&mut off);
    let is_far = |trip: &&(RowPlace, f64)| (trip.1 - middle).abs() > FAR * sd;
    let outliers: Vec<_> = trips.iter().filter(is_far).collect();
    // of a fleet of vans and trucks some are far from the median, and right
    let few = outliers.len() <= 1.max(values.len() / 100);
    let (place, value) = outliers.first().filter(|_| sd > 0.0 && few)?;
    let times = (value - middle).abs() / sd;
    let text = format!(
        "{} of column `{column}` far from all others, first {value} in {place}: {} SDs from the \
         median of {}",
        grouped(outliers.len() as u64),
        rounded(times),
        rounded(middle)
    );
    let remedy = "is it right? One such trip can turn a mean or a league";
    Some(Finding::warned("far-trip", [times, FAR], text, remedy))
}

/// The median of some values, at least one, which are sorted.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn consumptions_that_cannot_be_and_trips_far_off() {
        assert!(is_possible("consumption_l_per_100km", 31.0) && is_possible("cost", -7.0));
        assert!(is_possible("consumption_kwh_per_km", -0.2));
        assert!(!is_possible("consumption_l_per_100km", -30.0));
        assert!(!is_possible("fuel_l_per_100km", 3000.0));
        let place = RowPlace::Line(7);
        let finding = impossible("consumption_l_per_100km", &[(place, -30.0)], 9).unwrap();
        assert!(finding.text.contains("-30 in line 7"), "{finding}");
        let all: Vec<_> = (0..9).map(|k| (place, 120.0 + f64::from(k))).collect();
        assert!(impossible("consumption_kwh_per_km", &all, 9).unwrap().is_refusal());
        let finding = |column, value: f64| unusual(column, &[(place, value)]);
        assert!(finding("Consumption (L/100 km)", 0.31).unwrap().remedy.contains("L/km"));
        assert!(
            finding("consumption_l_per_100km", 31.0).is_none() && finding("points", 0.1).is_none()
        );
        assert!(is_consumption("L/100km") && is_consumption("Energy kWh per km"));
        assert!(!is_consumption("fuel per 100 km") && !is_consumption("km"));
        let mut trips: Vec<_> = (0..20).map(|k| (place, 30.0 + f64::from(k % 5))).collect();
        assert!(far("x", &trips).is_none());
        trips.push((RowPlace::Line(30), 300.0));
        assert!(far("x", &trips).unwrap().text.contains("300 in line 30"));
    }
}
