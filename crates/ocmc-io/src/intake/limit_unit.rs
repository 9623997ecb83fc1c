//! Limits of a route whose numbers are those of another unit.
//!
//! Signs have round numbers: those of km/h end in 0 almost everywhere, half of those of miles an
//! hour end in 5, and in m/s none is round. Where most of the way has limits that are round in
//! another unit, and not in that of the column, the unit is probably wrong.

use super::Finding;
use crate::intake::table::Column;
use crate::intake::table::unit::KMH;
use crate::number_text::rounded;

const NAME: &str = "limit-unit";
/// Share of the way from which on a unit is said (judgement).
const MOST: f64 = 0.6;
/// Limits that are seldom slower than this all along, in m/s (judgement): a yard, or m/s under
/// km/h.
const SLOW_MPS: f64 = 7.0;
const SLOW_WAY_M: f64 = 2000.0;
/// How near to a round number is round, in the unit.
const NEAR: f64 = 0.06;

/// Looks at limits, each with the way that it holds, in m, in a column.
pub fn judge(limits: &[(f64, f64)], column: &Column) -> Option<Finding> {
    let all_m: f64 = limits.iter().map(|(way_m, _)| way_m).sum();
    let share = |holds: &dyn Fn(f64) -> bool| {
        let matching = limits.iter().filter(|(_, limit_mps)| holds(*limit_mps));
        matching.map(|(way_m, _)| way_m).sum::<f64>() / all_m.max(1.0)
    };
    let suffix = column.unit.suffix;
    let written = |limit_mps: f64| column.written(limit_mps);
    let ends_in_5 = |x: f64| is_multiple(x, 5.0) && !is_multiple(x, 10.0);
    let (figure, likely) = if suffix == KMH {
        let of_mps = |mps: f64| {
            let x = written(mps);
            !is_multiple(x, 5.0) && is_multiple(3.6 * x, 10.0)
        };
        let of_miles = |mps: f64| ends_in_5(written(mps));
        if share(&of_mps) > MOST {
            (share(&of_mps), "they are round in km/h when taken for m/s: `speed_limit_mps`?")
        } else if share(&of_miles) > MOST {
            (share(&of_miles), "most end in 5, as in miles an hour: `speed_limit_mph`?")
        } else {
            return slow(limits, all_m);
        }
    } else if suffix == "mph" {
        let of_kmh = |mps: f64| is_multiple(written(mps), 10.0) && written(mps) > 75.0;
        if share(&of_kmh) <= MOST {
            return slow(limits, all_m);
        }
        (share(&of_kmh), "no sign has so many miles an hour: `speed_limit_kmh`?")
    } else {
        return slow(limits, all_m);
    };
    let first = limits.first().map_or(0.0, |(_, limit_mps)| written(*limit_mps));
    let text = format!(
        "its limits, such as {}, are hardly those of its unit on {} % of the way",
        rounded(first),
        rounded(100.0 * figure)
    );
    Some(Finding::warned(NAME, [figure, MOST], text, likely))
}

fn slow(limits: &[(f64, f64)], all_m: f64) -> Option<Finding> {
    let highest_mps = limits.iter().fold(0.0, |most: f64, (_, limit_mps)| most.max(*limit_mps));
    if highest_mps >= SLOW_MPS || all_m < SLOW_WAY_M {
        return None;
    }
    let text = format!(
        "no limit of its {} km is above {} km/h",
        rounded(all_m / 1000.0),
        rounded(3.6 * highest_mps)
    );
    Some(Finding::warned(NAME, [highest_mps, SLOW_MPS], text, "is the unit right?"))
}

fn is_multiple(x: f64, step: f64) -> bool {
    (x - step * (x / step).round()).abs() < NEAR
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intake::table::Quantity;
    use crate::intake::table::unit::with_suffix;

    fn found(suffix: &str, numbers: &[f64]) -> Option<String> {
        let quantity = Quantity::Limit;
        let unit = with_suffix(quantity.units(), suffix).unwrap();
        let column = Column { quantity, place: 0, unit, sign: 1.0, bounds: None };
        let limits: Vec<_> = numbers.iter().map(|x| (1000.0, column.si(*x))).collect();
        judge(&limits, &column).map(|finding| finding.to_string())
    }

    #[test]
    fn limits_of_another_unit_are_named() {
        for clean in [&[50.0, 70.0, 90.0][..], &[30.0, 50.0, 65.0, 80.0], &[100.0; 3]] {
            assert_eq!(found("kmh", clean), None, "{clean:?}");
        }
        assert_eq!(found("mps", &[13.89, 22.22, 25.0]), None);
        assert_eq!(found("mph", &[25.0, 35.0, 55.0, 70.0]), None);
        assert!(found("kmh", &[13.89, 19.44, 25.0]).unwrap().contains("`speed_limit_mps`"));
        assert!(found("kmh", &[25.0, 35.0, 55.0, 65.0]).unwrap().contains("`speed_limit_mph`"));
        assert!(found("mph", &[80.0, 100.0, 120.0]).unwrap().contains("`speed_limit_kmh`"));
        assert!(found("mps", &[5.0, 5.0, 5.0]).unwrap().contains("is the unit right"));
    }
}
