//! Trips of a fleet: consumptions that no vehicle has, and trips far from all others.

use super::Finding;
use crate::intake::table::given::RowPlace;
use crate::number_text::{grouped, rounded};

/// Ends of columns, and the consumptions that road vehicles can have: none makes fuel, and the
/// heaviest combinations uphill take some 300 L/100 km.
const POSSIBLE: [(&str, [f64; 2]); 3] =
    [("l_per_100km", [0.0, 500.0]), ("kg_per_100km", [0.0, 400.0]), ("kwh_per_km", [-5.0, 50.0])];
/// Distance from the median, in standard deviations by the median deviation, from which on a trip
/// is far from all others (judgement: of a law with heavy tails one in millions).
const FAR: f64 = 20.0;
/// A median deviation times this is the standard deviation of a normal law.
const MAD_SD: f64 = 1.4826;
/// Fewest trips of which a spread is known.
const FEWEST: usize = 10;

/// Whether a trip can have taken so much.
pub fn is_possible(column: &str, value: f64) -> bool {
    let range = POSSIBLE.iter().find(|(end, _)| column.ends_with(end));
    range.is_none_or(|(_, [low, high])| !(value < *low || value > *high))
}

/// Names trips that were left out because they cannot be.
pub fn impossible(column: &str, trips: &[(RowPlace, f64)]) -> Option<Finding> {
    let (place, value) = trips.first()?;
    let (_, [low, high]) = POSSIBLE.iter().find(|(end, _)| column.ends_with(end))?;
    let bound = if value < low { *low } else { *high };
    let text = format!(
        "{} of column `{column}` outside {low} to {high}, left out, first {value} in {place}",
        if trips.len() == 1 {
            "1 trip".to_owned()
        } else {
            format!("{} trips", grouped(trips.len() as u64))
        }
    );
    let remedy = "no road vehicle takes that: correct the row, or the unit";
    Some(Finding::warned("impossible-trip", [*value, bound], text, remedy))
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
    let found: Vec<_> = trips.iter().filter(is_far).collect();
    // of a fleet of vans and trucks some are far from the median, and right
    let few = found.len() <= 1.max(values.len() / 100);
    let (place, value) = found.first().filter(|_| sd > 0.0 && few)?;
    let times = (value - middle).abs() / sd;
    let text = format!(
        "{} of column `{column}` far from all others, first {value} in {place}: {} SDs from the \
         median of {}",
        grouped(found.len() as u64),
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
        let found = impossible("consumption_l_per_100km", &[(place, -30.0)]).unwrap();
        assert!(found.text.contains("-30 in line 7"), "{found}");
        let mut trips: Vec<_> = (0..20).map(|k| (place, 30.0 + f64::from(k % 5))).collect();
        assert!(far("x", &trips).is_none());
        trips.push((RowPlace::Line(30), 300.0));
        assert!(far("x", &trips).unwrap().text.contains("300 in line 30"));
    }
}
