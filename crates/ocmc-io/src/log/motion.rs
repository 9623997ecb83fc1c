//! The motion of a drive that a log does not tell row by row: the way and the speed of positions,
//! and rows between those that are more than a second apart.
//!
//! A track has places and times. Points of a receiver at standstill become one place; the others
//! lie on the road behind them ([`Path2d::smoothed`], [`Path2d::rounded`]), and the way up to each
//! never falls. Between rows the way over time is the monotone cubic of Fritsch and Carlson (SIAM
//! J. Numer. Anal. 17, 1980), whose slope is the speed: it passes through each row and stands where
//! the rows stand. Rows are put in only where the receiver was not lost; of what was measured they
//! have nothing but the way, the place and the speed.

use super::{LoggedTrip, Words};
use crate::intake::Finding;
use crate::intake::drift::standing;
use crate::intake::table::Quantity;
use crate::number_text::rounded;
use ocmc_core::operating_cycle::road::route_fillet::Rounding;
use ocmc_core::operating_cycle::road::route_geometry::Path2d;
use ocmc_core::operating_cycle::road::route_noise::{LEAST_NOISE_M, MOST_NOISE_M};

/// Longest interval of rows that stand as they are, in s; the slowest log has 1 Hz.
const LONGEST_S: f64 = 1.1;
/// Median interval beyond which nothing is put between rows, in s (judgement: a vehicle starts and
/// stops within it).
const SLOWEST_S: f64 = 20.0;
/// Times of the median interval from which on the receiver was lost, as everywhere in logs.
const LOST: f64 = 2.5;
/// Most rows that a drive may come to.
const MOST_ROWS: f64 = 2e7;
/// Fewest points of a track.
const FEWEST: usize = 3;
/// Quantities that hold since the row before.
const SINCE_BEFORE: [Quantity; 3] = [Quantity::Grade, Quantity::FuelRate, Quantity::BatteryPower];
/// Quantities that hold until the next row.
const UNTIL_NEXT: [Quantity; 4] =
    [Quantity::Limit, Quantity::Payload, Quantity::TimeOfDay, Quantity::DayOfYear];
/// Quantities that are straight between rows.
const STRAIGHT: [Quantity; 2] = [Quantity::Latitude, Quantity::Longitude];

/// Whether a drive with these columns has a motion that its rows only imply.
pub(super) fn is_implied(has: impl Fn(Quantity) -> bool) -> bool {
    let places = has(Quantity::Latitude) && has(Quantity::Longitude);
    !has(Quantity::Speed) && (places || has(Quantity::Position))
}

/// Gives a drive the speed that its places imply, and rows of a second where its own are farther
/// apart; says so.
pub(super) fn complete(drive: &mut LoggedTrip) -> Vec<Finding> {
    let mut findings = Vec::new();
    if is_implied(|quantity| drive.column(quantity).is_some()) {
        findings.extend(imply(drive));
    }
    findings.extend(refine(drive));
    findings
}

/// The rows whose time and place are known, each later than the one before.
fn known_rows(drive: &LoggedTrip, is_known: impl Fn(usize) -> bool) -> Vec<usize> {
    let time_s = drive.column(Quantity::Time).unwrap_or_default();
    let mut rows: Vec<usize> = Vec::new();
    for k in (0..time_s.len()).filter(|k| time_s[*k].is_finite() && is_known(*k)) {
        if rows.last().is_none_or(|last| time_s[k] > time_s[*last]) {
            rows.push(k);
        }
    }
    rows
}

/// Makes way and speed of places.
fn imply(drive: &mut LoggedTrip) -> Option<Finding> {
    let column = |quantity| drive.column(quantity).unwrap_or_default();
    let [time_s, latitude, longitude, position_m] =
        [Quantity::Time, Quantity::Latitude, Quantity::Longitude, Quantity::Position].map(column);
    let by_odometer = !position_m.is_empty();
    let rows = known_rows(drive, |k| {
        if by_odometer {
            position_m[k].is_finite()
        } else {
            latitude[k].is_finite() && longitude[k].is_finite()
        }
    });
    if rows.len() < FEWEST {
        return None;
    }
    let selected = |values: &[f64]| rows.iter().map(|k| values[*k]).collect::<Vec<f64>>();
    let at_s = selected(time_s);
    let (way_m, noise_m) = if by_odometer {
        (never_falling(selected(position_m)), 0.0)
    } else {
        way_of_places(&selected(latitude), &selected(longitude))
    };
    let speed_mps = speeds(&at_s, &way_m);
    let count = time_s.len();
    let spread = |values: &[f64]| {
        let mut all = vec![f64::NAN; count];
        for (row, value) in rows.iter().zip(values) {
            all[*row] = *value;
        }
        all
    };
    let (speed_mps, way_m) = (spread(&speed_mps), spread(&way_m));
    drive.columns.insert(Quantity::Speed, speed_mps.into());
    if !by_odometer {
        drive.columns.insert(Quantity::Position, way_m.into());
    }
    let source = if by_odometer { "its positions" } else { "its latitudes and longitudes" };
    let smooth = if noise_m >= LEAST_NOISE_M {
        format!(", smoothed: they scatter by {} m", rounded(noise_m))
    } else {
        String::new()
    };
    let text = format!("no speed: that of {source}{smooth}");
    Some(Finding::mended("implied-speed", [noise_m, LEAST_NOISE_M], text))
}

/// The way up to each place, in m, and how much the places scatter, in m.
fn way_of_places(latitude: &[f64], longitude: &[f64]) -> (Vec<f64>, f64) {
    let path = Path2d::new(latitude, longitude);
    let (x_m, y_m) = path.points_m();
    let clusters = standing(x_m, y_m);
    // of each place where the vehicle stands one point
    let mut kept: Vec<usize> = Vec::with_capacity(latitude.len());
    let mut of_point: Vec<usize> = Vec::with_capacity(latitude.len());
    let mut clusters = clusters.iter().peekable();
    for k in 0..latitude.len() {
        while clusters.next_if(|cluster| cluster.end <= k).is_some() {}
        let is_again =
            clusters.peek().is_some_and(|cluster| cluster.contains(&k) && k > cluster.start);
        if !is_again {
            kept.push(k);
        }
        of_point.push(kept.len() - 1);
    }
    if kept.len() < FEWEST {
        return (vec![0.0; latitude.len()], 0.0);
    }
    let selected = |values: &[f64]| kept.iter().map(|k| values[*k]).collect::<Vec<f64>>();
    let path = Path2d::of_points(selected(x_m), selected(y_m));
    let noise_m = path.noise_m();
    let given_m = if (LEAST_NOISE_M..=MOST_NOISE_M).contains(&noise_m) {
        path.smoothed(None, noise_m).1
    } else {
        let rounded = path.rounded(None, Rounding::LIKELY).map(|(_, given_m)| given_m);
        let rounded = rounded.filter(|given_m| is_even(given_m, &path.position_m));
        rounded.unwrap_or_else(|| path.position_m.clone())
    };
    let way_m = of_point.iter().map(|point| given_m[*point] - given_m[0]).collect();
    (never_falling(way_m), noise_m)
}

/// Whether places lie on a rounded road as far apart as they were, within a half: those of a
/// receiver with a scatter of decimetres, each second, are bends that no road has.
fn is_even(given_m: &[f64], position_m: &[f64]) -> bool {
    let steps = given_m.windows(2).zip(position_m.windows(2));
    let mut steps = steps.map(|(given, before)| (given[1] - given[0], before[1] - before[0]));
    steps.all(|(given, before)| before < LEAST_NOISE_M || given > 0.5 * before)
}

/// The largest value up to each place.
fn never_falling(mut values: Vec<f64>) -> Vec<f64> {
    let mut most = f64::NEG_INFINITY;
    for value in &mut values {
        most = most.max(*value);
        *value = most;
    }
    values
}

/// Slopes of the monotone cubic through points whose values never fall.
fn speeds(at: &[f64], value: &[f64]) -> Vec<f64> {
    let step = |k: usize| at[k + 1] - at[k];
    let secant = |k: usize| (value[k + 1] - value[k]) / step(k);
    let last = at.len() - 1;
    let slope = |k: usize| {
        if k == 0 || k == last {
            return secant(if k == 0 { 0 } else { last - 1 });
        }
        let (before, behind) = (secant(k - 1), secant(k));
        if before <= 0.0 || behind <= 0.0 {
            return 0.0;
        }
        // the weighted harmonic mean of Fritsch and Butland, which keeps the cubic monotone
        let (w1, w2) = (2.0 * step(k) + step(k - 1), step(k) + 2.0 * step(k - 1));
        (w1 + w2) / (w1 / before + w2 / behind)
    };
    (0..at.len()).map(slope).collect()
}

/// Value and slope of a cubic over a step at a share of it, from values and slopes at its ends.
fn cubic(step: f64, [from, to]: [f64; 2], [slope_from, slope_to]: [f64; 2], t: f64) -> [f64; 2] {
    let rise = to - from;
    let (a, b) = (slope_from * step, slope_to * step);
    let value = from + t * (a + t * (3.0 * rise - 2.0 * a - b + t * (a + b - 2.0 * rise)));
    let slope = a + t * (2.0 * (3.0 * rise - 2.0 * a - b) + 3.0 * t * (a + b - 2.0 * rise));
    [value, slope / step]
}

/// Puts rows of a second between those that are farther apart.
fn refine(drive: &mut LoggedTrip) -> Option<Finding> {
    let speed_mps = drive.column(Quantity::Speed)?;
    let rows = known_rows(drive, |k| speed_mps[k].is_finite());
    let time_s = drive.column(Quantity::Time)?;
    let mut steps_s: Vec<f64> = rows.windows(2).map(|w| time_s[w[1]] - time_s[w[0]]).collect();
    steps_s.sort_by(f64::total_cmp);
    let usual_s = *steps_s.get(steps_s.len() / 2)?;
    let all: f64 = steps_s.iter().sum();
    if usual_s <= LONGEST_S || usual_s > SLOWEST_S || all > MOST_ROWS {
        return None;
    }
    let way_m = way_of_rows(drive, &rows);
    let longest_s = LOST * usual_s;
    // rows, each with the one of the log before it and its share of the way in time to the next
    let mut places: Vec<(usize, f64)> = Vec::new();
    for (k, row) in rows.iter().enumerate() {
        places.push((k, 0.0));
        let Some(next) = rows.get(k + 1) else { break };
        let step_s = time_s[*next] - time_s[*row];
        if step_s <= longest_s {
            let parts = step_s.ceil().max(1.0);
            places.extend((1..parts as usize).map(|part| (k, part as f64 / parts)));
        }
    }
    let between = |values: &[f64], k: usize, share: f64| {
        let from = values[rows[k]];
        if share == 0.0 { from } else { from + share * (values[rows[k + 1]] - from) }
    };
    let slopes: Vec<f64> = rows.iter().map(|row| speed_mps[*row].max(0.0)).collect();
    let at = |k: usize, share: f64| {
        if share == 0.0 {
            return [way_m[k], speed_mps[rows[k]]];
        }
        let step_s = time_s[rows[k + 1]] - time_s[rows[k]];
        cubic(step_s, [way_m[k], way_m[k + 1]], [slopes[k], slopes[k + 1]], share)
    };
    let mut columns = std::collections::BTreeMap::new();
    for quantity in drive.columns.keys().copied() {
        let values = drive.column(quantity).unwrap_or_default();
        let value = |&(k, share): &(usize, f64)| match quantity {
            Quantity::Time => between(values, k, share),
            Quantity::Position => at(k, share)[0],
            Quantity::Speed => at(k, share)[1].max(0.0),
            _ if share == 0.0 => values[rows[k]],
            _ if STRAIGHT.contains(&quantity) => between(values, k, share),
            _ if SINCE_BEFORE.contains(&quantity) => values[rows[k + 1]],
            _ if UNTIL_NEXT.contains(&quantity) => values[rows[k]],
            _ => f64::NAN,
        };
        let values: Vec<f64> = places.iter().map(value).collect();
        columns.insert(quantity, values.into());
    }
    for words in drive.words.values_mut() {
        let own: Vec<&str> = words.rows().collect();
        let mut refined = Words::default();
        for (k, _) in &places {
            refined.push(own[rows[*k]]);
        }
        *words = refined;
    }
    drive.columns = columns;
    drive.measured_each_s = Some(usual_s);
    let text = format!(
        "rows are {} s apart: between them the way is the smoothest that never goes back, each \
         second",
        rounded(usual_s)
    );
    let remedy = "how a vehicle started and stopped between rows is not known: speeds, pedals and \
                  standstills are those of a calm driver";
    Some(Finding::warned("rows-far-apart", [usual_s, LONGEST_S], text, remedy))
}

/// The way up to some rows, in m: of the positions where they never fall, otherwise of the speed.
fn way_of_rows(drive: &LoggedTrip, rows: &[usize]) -> Vec<f64> {
    if let Some(position_m) = drive.column(Quantity::Position) {
        let way_m: Vec<f64> = rows.iter().map(|row| position_m[*row]).collect();
        if way_m.windows(2).all(|pair| pair[1] >= pair[0]) {
            return way_m;
        }
    }
    let [time_s, speed_mps] =
        [Quantity::Time, Quantity::Speed].map(|q| drive.column(q).unwrap_or_default());
    let mut sum_m = 0.0;
    let mut way_m = vec![0.0];
    for pair in rows.windows(2) {
        let mean_mps = 0.5 * (speed_mps[pair[0]] + speed_mps[pair[1]]).max(0.0);
        sum_m += mean_mps * (time_s[pair[1]] - time_s[pair[0]]);
        way_m.push(sum_m);
    }
    way_m
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A way of 2 km to the east with a standstill of a minute, a row each `step_s`.
    fn track(step_s: f64) -> (LoggedTrip, f64) {
        let way_m = |t: f64| {
            if t < 60.0 {
                10.0 * t
            } else if t < 120.0 {
                600.0
            } else {
                600.0 + 20.0 * (t - 120.0)
            }
        };
        let time_s: Vec<f64> = (0..=(190.0 / step_s) as usize).map(|k| k as f64 * step_s).collect();
        let longitude = time_s.iter().map(|t| way_m(*t) / 111_194.93).collect();
        let latitude = vec![0.0; time_s.len()];
        let drive = LoggedTrip::new(
            "a",
            "a",
            [
                (Quantity::Time, time_s),
                (Quantity::Latitude, latitude),
                (Quantity::Longitude, longitude),
            ],
        );
        (drive, way_m(190.0))
    }

    #[test]
    fn places_a_second_apart_with_errors_of_decimetres_have_their_speed() {
        // errors of 1.5 m that fade over a minute: 0.3 m a second, in bends that no road has
        let mut state = 1_u64;
        let mut draw = || {
            let sum: f64 = (0..12)
                .map(|_| {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    (state >> 11) as f64 / libm::exp2(53.0)
                })
                .sum();
            sum - 6.0
        };
        let keep = libm::exp(-1.0 / 60.0);
        let (mut east_m, mut north_m) = (0.0, 0.0);
        let places = (0..1200).map(|k| {
            for error_m in [&mut east_m, &mut north_m] {
                *error_m = keep * *error_m + 1.5 * libm::sqrt(1.0 - keep * keep) * draw();
            }
            [north_m / 111_194.93, (25.0 * f64::from(k) + east_m) / 111_194.93]
        });
        let places: Vec<[f64; 2]> = places.collect();
        let [latitude, longitude] = [0, 1].map(|k| places.iter().map(|p| p[k]).collect::<Vec<_>>());
        let (way_m, noise_m) = way_of_places(&latitude, &longitude);
        let at_s: Vec<f64> = (0..1200).map(f64::from).collect();
        let by_speed_m: f64 = speeds(&at_s, &way_m).iter().sum();
        assert!(noise_m < LEAST_NOISE_M && (way_m[1199] / 29_975.0 - 1.0).abs() < 2e-3);
        assert!((by_speed_m / way_m[1199] - 1.0).abs() < 5e-3, "{by_speed_m} {}", way_m[1199]);
    }

    #[test]
    fn places_tell_way_and_speed() {
        for step_s in [1.0, 5.0, 10.0] {
            let (mut drive, length_m) = track(step_s);
            let findings = complete(&mut drive);
            let checks: Vec<&str> = findings.iter().map(|finding| finding.check).collect();
            let wanted: &[&str] = if step_s > 1.0 {
                &["implied-speed", "rows-far-apart"]
            } else {
                &["implied-speed"]
            };
            assert_eq!(checks, wanted);
            let column = |quantity| drive.column(quantity).unwrap();
            let way_m = column(Quantity::Position);
            assert!((way_m.last().unwrap() - length_m).abs() < 0.5, "{way_m:?}");
            assert!(way_m.windows(2).all(|pair| pair[1] >= pair[0]));
            let (time_s, speed_mps) = (column(Quantity::Time), column(Quantity::Speed));
            assert_eq!(time_s.len(), 191, "a row a second");
            let at = |t: usize| speed_mps[t];
            assert!(at(90) == 0.0 && (at(30) - 10.0).abs() < 0.01 && (at(160) - 20.0).abs() < 0.01);
            let by_speed: f64 = speed_mps.windows(2).map(|w| 0.5 * (w[0] + w[1])).sum();
            assert!((by_speed / length_m - 1.0).abs() < 0.01, "{by_speed}");
        }
    }

    #[test]
    fn a_lost_receiver_leaves_a_gap() {
        let (drive, _) = track(5.0);
        let keep = |values: &[f64]| [&values[..5], &values[15..]].concat();
        let kept = |quantity| keep(drive.column(quantity).unwrap());
        let mut drive = LoggedTrip::new(
            "a",
            "a",
            [Quantity::Time, Quantity::Latitude, Quantity::Longitude].map(|q| (q, kept(q))),
        );
        complete(&mut drive);
        let time_s = drive.column(Quantity::Time).unwrap();
        let longest_s = time_s.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        assert_eq!(longest_s, 55.0);
    }
}
