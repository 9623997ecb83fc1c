//! Receivers at standstill, whose points wander.
//!
//! A track is given row by row in time. Where the vehicle stands, the points move slowly around one
//! place: the way grows, and each turn looks like a curve of some metres. Rows are such a cluster
//! where they stay within a few metres, with short steps, on a way more than twice the distance of
//! its ends, and turn by more than once around in all, to either side added up; no road does so. A
//! slow drift turns little: there the steps tell it, of 1 m at most where those of the track are
//! ten times as long, over 40 m at most. Of a cluster the first row is left.
//!
//! The speed of a log may be that of such points. Where it stays below 0.6 m/s for 8 s or more, and
//! the positions do not go along, or the log knows no standstill at all, the vehicle stands.

use super::Finding;
use crate::number_text::{count_of, grouped, rounded};
use ocmc_core::operating_cycle::road::route_fillet::turns;
use std::ops::Range;

/// Radii within which a cluster may stay, in m.
const WITHIN_M: [f64; 3] = [3.0, 8.0, 20.0];
/// Fewest rows.
const FEWEST: usize = 6;
/// Mean steps below this are short, over the usual step of the track (judgement): points that are
/// close everywhere scatter on the way, too.
const SHORT: f64 = 0.2;
/// Way over the distance of the ends.
const DETOUR: f64 = 2.0;
/// Turns in all, to either side added up, in rad.
const TURNED_RAD: f64 = 7.0;
/// Rows of a slow drift, its steps in m and over the usual ones, its extent in m, and its turns in
/// all in rad (judgement).
const SLOW_ROWS: usize = 8;
const SLOW_M: f64 = 1.0;
const SLOW: f64 = 0.1;
const SLOW_WITHIN_M: f64 = 40.0;
const SLOW_TURNED_RAD: f64 = 1.0;
/// Speeds of a receiver at standstill, in m/s, and how long they last, in s (judgement).
const STANDING_MPS: f64 = 0.6;
const STANDING_S: f64 = 8.0;
/// Speeds below this are a standstill, in m/s.
const ZERO_MPS: f64 = 0.02;
/// Way along which positions go less than this share is none.
const ALONG: f64 = 0.5;
/// Rows that are looked at from one on: a longer standstill becomes several points.
const MOST_ROWS: usize = 4000;
/// Points closer than this are one, in m: the last digit of a coordinate.
const ONE_PLACE_M: f64 = 0.02;

/// The rows of a track of points that wander around one place, and those of points that are
/// repeated; each range has two rows at least.
pub fn standing(x_m: &[f64], y_m: &[f64]) -> Vec<Range<usize>> {
    let (turns, steps_m) = turns(x_m, y_m);
    let mut sorted = steps_m.clone();
    sorted.sort_by(f64::total_cmp);
    let usual_m = sorted.get(9 * sorted.len() / 10).copied().unwrap_or(0.0);
    let short_m = SHORT * usual_m;
    let apart_m = |a: usize, b: usize| {
        ((x_m[b] - x_m[a]) * (x_m[b] - x_m[a]) + (y_m[b] - y_m[a]) * (y_m[b] - y_m[a])).sqrt()
    };
    let turned = |first: usize, last: usize| {
        turns[first + 1..last].iter().map(|turn| turn.abs()).sum::<f64>()
    };
    let wanders = |rows: &Range<usize>| {
        if rows.len() < FEWEST {
            return false;
        }
        let (first, last) = (rows.start, rows.end - 1);
        let way_m: f64 = steps_m[first..last].iter().sum();
        way_m >= DETOUR * apart_m(first, last)
            && way_m <= short_m * (last - first) as f64
            && turned(first, last) > TURNED_RAD
    };
    let slow_m = SLOW_M.min(SLOW * usual_m);
    let drifts = |first: usize| {
        let is_slow = |k: &usize| steps_m[*k] <= slow_m && apart_m(first, k + 1) <= SLOW_WITHIN_M;
        let rows = first..steps_m.len().min(first + MOST_ROWS);
        let last = rows.take_while(is_slow).last().map_or(first, |k| k + 1);
        let long = last - first + 1 >= SLOW_ROWS && turned(first, last) > SLOW_TURNED_RAD;
        long.then_some(first..last + 1)
    };
    let mut clusters: Vec<Range<usize>> = Vec::new();
    let mut first = 0;
    while first + 1 < x_m.len() {
        let within = WITHIN_M.into_iter().rev().find_map(|within_m| {
            let near = |k: &usize| apart_m(first, *k) <= within_m;
            let rows = first..x_m.len().min(first + MOST_ROWS);
            let end = rows.take_while(near).last().map_or(first, |last| last + 1);
            Some(first..end).filter(wanders)
        });
        let cluster = drifts(first).or(within);
        let end = cluster.map_or(first + 1, |cluster| cluster.end);
        let repeated = steps_m[end - 1..].iter().take_while(|step_m| **step_m < ONE_PLACE_M);
        let end = end + repeated.count();
        if end > first + 1 {
            clusters.push(first..end);
        }
        first = end;
    }
    clusters
}

/// Names clusters that became one row each; none where points are repeated only.
pub fn standstill_drift(x_m: &[f64], y_m: &[f64], clusters: &[Range<usize>]) -> Option<Finding> {
    let (_, steps_m) = turns(x_m, y_m);
    let way_of = |rows: &Range<usize>| steps_m[rows.start..rows.end - 1].iter().sum::<f64>();
    let wandering: Vec<&Range<usize>> =
        clusters.iter().filter(|rows| way_of(rows) > ONE_PLACE_M * rows.len() as f64).collect();
    if wandering.is_empty() {
        return None;
    }
    let way_m: f64 = wandering.iter().map(|rows| way_of(rows)).sum();
    let rows: usize = wandering.iter().map(|rows| rows.len()).sum();
    let text = format!(
        "{} rows wander by {} m in all around {}, as of a receiver at standstill: each place \
         became one point",
        grouped(rows as u64),
        rounded(way_m),
        count_of(wandering.len() as u64, "place")
    );
    Some(Finding::mended("standstill-drift", [way_m, 0.0], text))
}

/// Rows of a log at which the vehicle stands while its speed is not 0. `apart_m` tells how far
/// apart the positions of two rows are, NaN where they are not known.
pub fn standing_speeds(
    time_s: &[f64],
    speed_mps: &[f64],
    apart_m: impl Fn(usize, usize) -> f64,
) -> Vec<Range<usize>> {
    let knows_standstill = speed_mps.iter().any(|speed| speed.abs() < ZERO_MPS);
    let count = time_s.len().min(speed_mps.len());
    let is_slow = |k: &usize| speed_mps[*k].abs() <= STANDING_MPS;
    let mut ranges = Vec::new();
    let mut first = 0;
    while first < count {
        let end = (first..count).take_while(is_slow).last().map_or(first, |last| last + 1);
        if end > first + 1 && time_s[end - 1] - time_s[first] >= STANDING_S {
            let step = |k: usize| speed_mps[k].abs() * (time_s[k] - time_s[k - 1]).max(0.0);
            let way_m: f64 = (first + 1..end).map(step).sum();
            let stays = apart_m(first, end - 1) < ALONG * way_m;
            if way_m > ZERO_MPS * STANDING_S && (stays || !knows_standstill) {
                ranges.push(first..end);
            }
        }
        first = end.max(first + 1);
    }
    ranges
}

/// Names rows whose speed became 0.
pub fn standing_speed(rows: &[Range<usize>], speed_mps: &[f64]) -> Option<Finding> {
    let speeds = rows.iter().flat_map(|rows| &speed_mps[rows.clone()]);
    let most_mps = speeds.map(|speed| speed.abs()).fold(0.0, f64::max);
    let all: usize = rows.iter().map(ExactSizeIterator::len).sum();
    (all > 0).then(|| {
        let text = format!(
            "{} rows at {} have speeds of up to {} m/s and do not move on, as of a receiver at \
             standstill: they count as 0",
            grouped(all as u64),
            count_of(rows.len() as u64, "place"),
            rounded(most_mps)
        );
        Finding::mended("standstill-drift", [most_mps, STANDING_MPS], text)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    /// A way of steps of 15 m with a standstill of 120 s, at which the points move on by `step_m`
    /// each second, in directions that change by `spread` rad.
    fn way(seed: u64, step_m: f64, spread: f64) -> (Vec<f64>, Vec<f64>) {
        let mut draws = Draws::new(seed, 0, Stream::Pedals);
        let (mut x, mut y, mut heading) = (vec![0.0], vec![0.0], 0.0);
        for k in 0..240 {
            let stands = (60..180).contains(&k);
            heading = if stands { heading + spread * draws.normal() } else { 0.01 * f64::from(k) };
            let step_m = if stands { step_m } else { 15.0 };
            x.push(x[x.len() - 1] + step_m * f64::cos(heading));
            y.push(y[y.len() - 1] + step_m * f64::sin(heading));
        }
        (x, y)
    }

    #[test]
    fn a_standstill_becomes_few_points() {
        for seed in 1..=20 {
            for (step_m, spread) in [(0.1, 1.5), (0.4, 1.5), (0.1, 0.3), (0.2, 0.3)] {
                let (x, y) = way(seed, step_m, spread);
                let clusters = standing(&x, &y);
                let merged: usize = clusters.iter().map(|rows| rows.len() - 1).sum();
                assert!((109..125).contains(&merged), "{seed} {step_m} {clusters:?}");
                let finding = standstill_drift(&x, &y, &clusters).expect("wanders");
                assert!(finding.figure > 0.8 * step_m * 120.0 && !finding.is_refusal());
            }
        }
    }

    #[test]
    fn speeds_at_standstill_are_none() {
        let time_s: Vec<f64> = (0..100).map(f64::from).collect();
        let drive = |standing_mps: f64| -> Vec<f64> {
            (0..100).map(|k| if (40..70).contains(&k) { standing_mps } else { 12.0 }).collect()
        };
        let unknown = |_, _| f64::NAN;
        let ranges = standing_speeds(&time_s, &drive(0.4), unknown);
        assert_eq!((ranges.len(), ranges[0].clone()), (1, 40..70), "no row stands still");
        // a log that knows a standstill, whose truck creeps, or wanders around its place
        let mut creeps = drive(0.4);
        creeps[99] = 0.0;
        assert_eq!(standing_speeds(&time_s, &creeps, unknown), []);
        assert_eq!(standing_speeds(&time_s, &creeps, |a, b| 0.4 * (b - a) as f64), []);
        let ranges = standing_speeds(&time_s, &creeps, |_, _| 2.0);
        assert_eq!(ranges.len(), 1);
        assert!(
            standing_speed(&ranges, &creeps).expect("is said").text.contains("30 rows at 1 place")
        );
        // one that stands still
        assert_eq!(standing_speeds(&time_s, &drive(0.0), |_, _| 0.0), []);
    }

    #[test]
    fn driven_ways_are_no_standstill() {
        // a hairpin of 6 m radius with a point each metre, and slow steps straight on
        let hairpin = |k: usize| match k {
            0..=30 => (k as f64, 0.0),
            31..=48 => {
                let angle = (k - 30) as f64 / 6.0;
                (30.0 + 6.0 * f64::sin(angle), 6.0 - 6.0 * f64::cos(angle))
            }
            _ => (30.0 - (k - 48) as f64, 12.0),
        };
        let (x, y): (Vec<f64>, Vec<f64>) = (0..80).map(hairpin).unzip();
        assert!(standing(&x, &y).is_empty());
        let (x, y): (Vec<f64>, Vec<f64>) = (0..200).map(|k| (0.2 * f64::from(k), 0.0)).unzip();
        assert!(standing(&x, &y).is_empty());
        // a point that is repeated is one, and nothing is said
        let (x, y) = (vec![0.0, 10.0, 10.0, 20.0], vec![0.0; 4]);
        let clusters = standing(&x, &y);
        assert_eq!((clusters.len(), clusters[0].clone()), (1, 1..3));
        assert_eq!(standstill_drift(&x, &y, &clusters), None);
    }
}
