//! Points of a track and altitudes that jump.
//!
//! A receiver that loses its satellites puts a point aside and comes back: there and back again with
//! long steps, where the points around lie close to each other. Such a point is left out. A step to
//! one side after which the points go on where they are is a jump that stays: the road leads from one
//! line to another that lies beside it, which no road does. It is warned of, because it is not known
//! which of the two is right. An altitude that lies above or below both of its neighbours, up one side
//! and down the other steeper than any road, is left out, too.

use super::Finding;
use crate::number_text::{count_of, rounded};
use ocmc_core::operating_cycle::road::route_fillet::turns;
use std::f64::consts::PI;

/// Steps to a point aside, in m and over the usual ones of the track, and the turn there in rad
/// (judgement): roads turn back in hairpins, but not with points that far apart among close ones.
const ASIDE_M: f64 = 50.0;
const ASIDE: f64 = 5.0;
/// The same of a jump that stays: a street may lead around two corners.
const LASTING_M: f64 = 100.0;
const LASTING: f64 = 10.0;
const BACK_RAD: f64 = 0.75 * PI;
/// Most of the points that may lie aside: beyond that they tell no road.
const MOST_ASIDE: f64 = 0.02;
/// Turns to either side of a jump that stays, in rad: at least that much, to one side and back.
const SIDEWAYS_RAD: f64 = 0.8;
/// Slope of an altitude that lies aside on both sides, beyond that of any road.
const SPIKE_SLOPE: f64 = 0.2;
/// The same over the usual slope of the altitudes around.
const SPIKE: f64 = 5.0;
/// Higher spikes are not left out: they are values of something else, such as 0 for none, in m.
const HIGHEST_M: f64 = 40.0;

/// Whether each point lies aside.
pub fn points_aside(x_m: &[f64], y_m: &[f64]) -> Vec<bool> {
    let mut aside = vec![false; x_m.len()];
    let (turns, steps_m) = turns(x_m, y_m);
    let Some(least_m) = far_m(&steps_m, [ASIDE_M, ASIDE]) else { return aside };
    for k in 1..x_m.len().saturating_sub(1) {
        let far = steps_m[k - 1].min(steps_m[k]) > least_m;
        aside[k] = far && turns[k].abs() > BACK_RAD && !aside[k - 1];
    }
    let count = aside.iter().filter(|aside| **aside).count();
    if count as f64 > 1.0 + MOST_ASIDE * x_m.len() as f64 {
        aside.fill(false);
    }
    aside
}

/// A step that is far beyond the usual ones, in m.
fn far_m(steps_m: &[f64], [least_m, times]: [f64; 2]) -> Option<f64> {
    let mut sorted = steps_m.to_vec();
    sorted.sort_by(f64::total_cmp);
    let usual_m = sorted.get(9 * sorted.len() / 10)?;
    Some(least_m.max(times * usual_m))
}

/// Says which points were left out, of a table whose rows are called so.
pub fn position_jump(aside: &[bool], name: impl Fn(usize) -> String) -> Option<Finding> {
    let count = aside.iter().filter(|aside| **aside).count();
    let first = aside.iter().position(|aside| *aside)?;
    let text = format!(
        "{} aside of the track, there and back again, left out, first in {}",
        if count == 1 { "1 point lies".to_owned() } else { format!("{count} points lie") },
        name(first)
    );
    Some(Finding::mended("position-jump", [count as f64, 0.0], text))
}

/// Names a jump to one side that stays.
pub fn lasting_jump(x_m: &[f64], y_m: &[f64], name: impl Fn(usize) -> String) -> Option<Finding> {
    let (turns, steps_m) = turns(x_m, y_m);
    let least_m = far_m(&steps_m, [LASTING_M, LASTING])?;
    let is_jump = |k: &usize| {
        let [before, behind] = [turns[*k], turns[k + 1]];
        steps_m[*k] > least_m
            && before.abs().min(behind.abs()) > SIDEWAYS_RAD
            && before * behind < 0.0
            // straight on, but beside
            && (before + behind).abs() < 0.5 * before.abs().min(behind.abs())
    };
    let jumps: Vec<usize> = (1..steps_m.len().saturating_sub(1)).filter(is_jump).collect();
    let first = *jumps.first()?;
    let text = format!(
        "its points jump sideways {}, first by {} m to {}, and go on from there",
        count_of(jumps.len() as u64, "time"),
        rounded(steps_m[first]),
        name(first + 1)
    );
    let remedy = "no road does: the curves and the way there are not right; split it, or correct the \
                  points on the wrong side";
    Some(Finding::warned("position-jump", [steps_m[first], least_m], text, remedy))
}

/// Puts altitudes that lie aside between their neighbours, and says so.
pub fn altitude_spikes(
    position_m: &[f64],
    altitude_m: &mut [f64],
    name: impl Fn(usize) -> String,
) -> Option<Finding> {
    let slope = |altitude_m: &[f64], a: usize, b: usize| {
        let way_m = position_m[b] - position_m[a];
        if way_m > 0.0 { (altitude_m[b] - altitude_m[a]) / way_m } else { 0.0 }
    };
    let mut slopes: Vec<f64> =
        (1..altitude_m.len()).map(|k| slope(altitude_m, k - 1, k).abs()).collect();
    slopes.sort_by(f64::total_cmp);
    let usual = *slopes.get(9 * slopes.len() / 10)?;
    let steep = SPIKE_SLOPE.max(SPIKE * usual);
    let mut found: Vec<(usize, f64)> = Vec::new();
    for k in 1..altitude_m.len() - 1 {
        let [up, down] = [slope(altitude_m, k - 1, k), slope(altitude_m, k, k + 1)];
        if up * down >= 0.0 || up.abs().min(down.abs()) < steep {
            continue;
        }
        let across = slope(altitude_m, k - 1, k + 1);
        let between = altitude_m[k - 1] + across * (position_m[k] - position_m[k - 1]);
        let off_m = altitude_m[k] - between;
        if off_m.abs() > HIGHEST_M {
            return None;
        }
        found.push((k, off_m));
        altitude_m[k] = between;
    }
    let (first, off_m) = *found.first()?;
    let text = format!(
        "{} between its neighbours and were put there, first by {} m in {}",
        if found.len() == 1 {
            "1 altitude does not lie".to_owned()
        } else {
            format!("{} altitudes do not lie", found.len())
        },
        rounded(off_m.abs()),
        name(first)
    );
    Some(Finding::mended("altitude-spike", [off_m.abs(), 0.0], text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intake::End;

    /// A road with bends, with a point each 20 m.
    fn road() -> (Vec<f64>, Vec<f64>) {
        let [mut x, mut y] = [0.0_f64; 2];
        let mut points = (Vec::new(), Vec::new());
        for k in 0..300 {
            let course = 0.8 * f64::sin(f64::from(k) / 12.0);
            x += 20.0 * course.cos();
            y += 20.0 * course.sin();
            points.0.push(x);
            points.1.push(y);
        }
        points
    }

    fn row(k: usize) -> String {
        format!("row {k}")
    }

    #[test]
    fn a_point_aside_is_left_out_and_a_shift_is_named() {
        let (mut x_m, mut y_m) = road();
        assert!(points_aside(&x_m, &y_m).iter().all(|aside| !aside));
        assert_eq!(lasting_jump(&x_m, &y_m, row), None);
        y_m[100] += 300.0;
        let aside = points_aside(&x_m, &y_m);
        assert_eq!(aside.iter().filter(|aside| **aside).count(), 1);
        assert!(position_jump(&aside, row).unwrap().text.contains("row 100"));
        y_m[100] -= 300.0;
        for k in 150..300 {
            y_m[k] += 300.0;
            x_m[k] -= 20.0;
        }
        let found = lasting_jump(&x_m, &y_m, row).unwrap();
        assert!(found.end == End::Warned && found.text.contains("row 150"), "{found}");
    }

    #[test]
    fn spikes_of_altitudes_are_put_between_their_neighbours() {
        let position_m: Vec<f64> = (0..100).map(|k| 25.0 * f64::from(k)).collect();
        let clean: Vec<f64> = position_m.iter().map(|x_m| 10.0 * (x_m / 200.0).sin()).collect();
        let mut altitude_m = clean.clone();
        assert_eq!(altitude_spikes(&position_m, &mut altitude_m, row), None);
        altitude_m[40] += 9.0;
        altitude_m[70] -= 12.0;
        let found = altitude_spikes(&position_m, &mut altitude_m, row).unwrap();
        assert!(found.text.starts_with("2 altitudes") && found.text.contains("row 40"), "{found}");
        for k in 0..100 {
            assert!((altitude_m[k] - clean[k]).abs() < 0.2, "{k}");
        }
        altitude_m[50] = -100.0;
        assert_eq!(altitude_spikes(&position_m, &mut altitude_m, row), None);
    }
}
