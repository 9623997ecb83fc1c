//! Points of a track and altitudes that jump.
//!
//! A receiver that loses its satellites puts a point aside and comes back: there and back again,
//! and on as before. Such a point is left out. A step that is longer than those around, to one
//! side, or back, after which the points go on as before is a jump that stays: it is warned of,
//! because it is not known which side is right; a gap ahead likewise. Both count where they are far
//! beyond the scatter of the points. An altitude that lies above or below both of its neighbours,
//! up one side and down the other steeper than any road, is left out, too.

use super::Finding;
use crate::number_text::{count_of, rounded};
use ocmc_core::operating_cycle::road::route_fillet::turns;
use std::f64::consts::TAU;

/// Distance from the line of the neighbours, in m, and over the scatter of the points, from which
/// on a point or a jump is none of the road (judgement).
const OFF_M: f64 = 3.0;
const OFF: f64 = 6.0;
/// Way over a point aside, over that between its neighbours.
const DETOUR: f64 = 1.2;
/// Turn at a point aside, and those that are left without it at most, in rad.
const BACK_RAD: f64 = 1.2;
const SMOOTH_RAD: f64 = 0.5;
/// Most of the points that may lie aside: beyond that they tell no road.
const MOST_ASIDE: f64 = 0.02;
/// A jump that stays over the steps around it, how many of these, and the turns at its ends, in
/// rad: sideways, or nearly ahead where it is longer. The turns around are smaller by a factor.
const AROUND: usize = 4;
const SIDEWAYS: [f64; 2] = [1.3, 0.6];
const AHEAD: [f64; 2] = [2.5, 0.1];
const SHARPER: f64 = 3.0;
/// Turn that is left at both ends, over the smaller one: a road goes on as before.
const LEFT: f64 = 0.5;
/// A gap, in m, and over nine of ten steps (judgement): the straights of maps are shorter.
const GAP_M: f64 = 400.0;
const GAP: f64 = 20.0;
/// Slope of an altitude that lies aside on both sides, beyond that of any road.
const SPIKE_SLOPE: f64 = 0.2;
/// The same over the usual slope of the altitudes around.
const SPIKE: f64 = 5.0;
/// A spike down to 0 of a road higher than this, in m, is no altitude: 0 stands for none.
const ABOVE_ZERO_M: f64 = 40.0;

/// How far a point or a jump lies off a road whose points scatter so, in m, from which on it is
/// none of it.
fn least_off_m(noise_m: f64) -> f64 {
    OFF_M.max(OFF * noise_m)
}

/// An angle the short way around, in rad.
fn short_way(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// How far a point lies off the straight way between its neighbours, in m.
fn off_segment_m(k: usize, x_m: &[f64], y_m: &[f64]) -> f64 {
    let (bx, by) = (x_m[k + 1] - x_m[k - 1], y_m[k + 1] - y_m[k - 1]);
    let (px, py) = (x_m[k] - x_m[k - 1], y_m[k] - y_m[k - 1]);
    let along = ((px * bx + py * by) / (bx * bx + by * by).max(1e-9)).clamp(0.0, 1.0);
    libm::hypot(px - along * bx, py - along * by)
}

/// Whether each point lies aside, of points that scatter so, in m.
pub fn points_aside(x_m: &[f64], y_m: &[f64], noise_m: f64) -> Vec<bool> {
    let mut aside = vec![false; x_m.len()];
    let (turns, steps_m) = turns(x_m, y_m);
    let least_m = least_off_m(noise_m);
    let course = |a: usize, b: usize| libm::atan2(y_m[b] - y_m[a], x_m[b] - x_m[a]);
    for k in 2..x_m.len().saturating_sub(2) {
        let chord_m = libm::hypot(x_m[k + 1] - x_m[k - 1], y_m[k + 1] - y_m[k - 1]);
        let longer_m = steps_m[k - 1] + steps_m[k] - chord_m;
        // without it the road goes on nearly straight, with it it turns back
        let across = course(k - 1, k + 1);
        let smooth = [across - course(k - 2, k - 1), course(k + 1, k + 2) - across];
        let smooth = smooth.map(|turn| short_way(turn).abs());
        let sharp = turns[k - 1..=k + 1].iter().fold(0.0, |most: f64, turn| most.max(turn.abs()));
        aside[k] = longer_m > (DETOUR - 1.0) * chord_m
            && off_segment_m(k, x_m, y_m) > least_m
            && sharp > BACK_RAD
            && smooth[0].max(smooth[1]) < SMOOTH_RAD
            && !aside[k - 1];
    }
    let count = aside.iter().filter(|aside| **aside).count();
    if count as f64 > 1.0 + MOST_ASIDE * x_m.len() as f64 {
        aside.fill(false);
    }
    aside
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

/// Names jumps that stay, of points that scatter so, in m.
pub fn lasting_jump(
    x_m: &[f64],
    y_m: &[f64],
    noise_m: f64,
    name: impl Fn(usize) -> String,
) -> Option<Finding> {
    let (turns, steps_m) = turns(x_m, y_m);
    let least_m = least_off_m(noise_m);
    let is_jump = |k: &usize| {
        let [before, behind] = [turns[*k], turns[k + 1]];
        let least = before.abs().min(behind.abs());
        let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let beside = |values: &[f64], first: usize, behind: usize| {
            let before = largest(&values[first.saturating_sub(AROUND)..first]);
            before.max(largest(&values[behind..values.len().min(behind + AROUND)]))
        };
        let longest_m = beside(&steps_m, *k, k + 1);
        let sharpest = beside(&turns, *k, k + 2);
        let is_beyond = |[long, turn]: [f64; 2]| steps_m[*k] > long * longest_m && least > turn;
        (is_beyond(SIDEWAYS) || is_beyond(AHEAD))
            && least > SHARPER * sharpest
            && short_way(before + behind).abs() < LEFT * least
            && steps_m[*k] > least_m
            // how far beside the line it is, but for a step back
            && (steps_m[*k] * libm::sin(least) > least_m || least > BACK_RAD)
    };
    let jumps: Vec<usize> = (1..steps_m.len().saturating_sub(1)).filter(is_jump).collect();
    let first = *jumps.first()?;
    let text = format!(
        "its points jump {}, first by {} m to {}, and go on from there",
        count_of(jumps.len() as u64, "time"),
        rounded(steps_m[first]),
        name(first + 1)
    );
    let remedy = "no road does: the curves and the way there are not right; split it, or correct \
                  the points on the wrong side";
    Some(Finding::warned("position-jump", [steps_m[first], least_m], text, remedy))
}

/// Names the longest gap among points that are close to each other.
pub fn gap(x_m: &[f64], y_m: &[f64], name: impl Fn(usize) -> String) -> Option<Finding> {
    let (_, steps_m) = turns(x_m, y_m);
    let mut sorted = steps_m.clone();
    sorted.sort_by(f64::total_cmp);
    let usual_m = *sorted.get(9 * sorted.len() / 10)?;
    let bound_m = GAP_M.max(GAP * usual_m);
    let longest_m = *sorted.last()?;
    let first = steps_m.iter().position(|step_m| *step_m == longest_m)?;
    if longest_m <= bound_m {
        return None;
    }
    let text = format!(
        "no point lies on {} m before {}, although they are close otherwise: what the road does \
         there is not known",
        rounded(longest_m),
        name(first + 1)
    );
    let remedy = "add the points that are missing, or split the file there";
    Some(Finding::warned("track-gap", [longest_m, bound_m], text, remedy))
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
    let mut spikes: Vec<(usize, f64)> = Vec::new();
    for k in 1..altitude_m.len() - 1 {
        let [up, down] = [slope(altitude_m, k - 1, k), slope(altitude_m, k, k + 1)];
        if up * down >= 0.0 || up.abs().min(down.abs()) < steep {
            continue;
        }
        let across = slope(altitude_m, k - 1, k + 1);
        let between = altitude_m[k - 1] + across * (position_m[k] - position_m[k - 1]);
        let off_m = altitude_m[k] - between;
        if altitude_m[k] == 0.0 && between > ABOVE_ZERO_M {
            return None;
        }
        spikes.push((k, off_m));
        altitude_m[k] = between;
    }
    let (first, off_m) = *spikes.first()?;
    let text = format!(
        "{} between its neighbours and were put there, first by {} m in {}",
        if spikes.len() == 1 {
            "1 altitude does not lie".to_owned()
        } else {
            format!("{} altitudes do not lie", spikes.len())
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
        assert!(points_aside(&x_m, &y_m, 0.0).iter().all(|aside| !aside));
        assert_eq!(lasting_jump(&x_m, &y_m, 0.0, row), None);
        y_m[100] += 300.0;
        let aside = points_aside(&x_m, &y_m, 0.0);
        assert_eq!(aside.iter().filter(|aside| **aside).count(), 1);
        assert!(position_jump(&aside, row).unwrap().text.contains("row 100"));
        y_m[100] -= 300.0;
        for k in 150..300 {
            y_m[k] += 300.0;
            x_m[k] -= 20.0;
        }
        let finding = lasting_jump(&x_m, &y_m, 0.0, row).unwrap();
        assert!(finding.end == End::Warned && finding.text.contains("row 150"), "{finding}");
    }

    #[test]
    fn a_gap_among_close_points_is_named() {
        let at = |x_m: &[f64]| gap(x_m, &vec![0.0; x_m.len()], row);
        let mut x_m: Vec<f64> = (0..200).map(|k| 10.0 * f64::from(k)).collect();
        assert_eq!(at(&x_m), None);
        x_m[80..].iter_mut().for_each(|x_m| *x_m += 700.0);
        assert!(at(&x_m).unwrap().text.contains("row 80"));
        assert_eq!(at(&[0.0, 600.0, 1300.0, 1900.0]), None);
    }

    #[test]
    fn spikes_of_altitudes_are_put_between_their_neighbours() {
        let position_m: Vec<f64> = (0..100).map(|k| 25.0 * f64::from(k)).collect();
        let clean: Vec<f64> = position_m.iter().map(|x_m| 10.0 * (x_m / 200.0).sin()).collect();
        let mut altitude_m = clean.clone();
        assert_eq!(altitude_spikes(&position_m, &mut altitude_m, row), None);
        altitude_m[40] += 9.0;
        altitude_m[70] -= 12.0;
        let finding = altitude_spikes(&position_m, &mut altitude_m, row).unwrap();
        assert!(
            finding.text.starts_with("2 altitudes") && finding.text.contains("row 40"),
            "{finding}"
        );
        for k in 0..100 {
            assert!((altitude_m[k] - clean[k]).abs() < 0.2, "{k}");
        }
        let high: Vec<f64> = clean.iter().map(|height_m| height_m + 300.0).collect();
        altitude_m.copy_from_slice(&high);
        altitude_m[50] = 0.0;
        assert_eq!(altitude_spikes(&position_m, &mut altitude_m, row), None);
    }
}
