//! Turns at junctions: radii R = r₀ + exp(N(ln m, σ²)) and angles π/2 U(f, 1).

use super::{Estimates, TypeRoads};
use ocmc_core::operating_cycle::coverage::{Coverage, CurveCoverage};
use ocmc_core::operating_cycle::road::point_event::JunctionTurnModel;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

/// Fewest turns from which the law is estimated.
const FEWEST: usize = 5;

/// Radii and smallest angle of the turns of all road types; r₀ stays.
///
/// m and σ by moments of ln(R − r₀). Of n angles U(f, 1) the smallest has the mean f + (1 − f)/(n +
/// 1), so that f = ((n + 1) min − 1)/n is unbiased, with the standard error (1 − f)/√(n(n + 2)).
pub(super) fn fit_turns(
    roads: &BTreeMap<String, TypeRoads>,
    coverage: &Coverage,
    model: &mut JunctionTurnModel,
    estimates: &mut Estimates,
) {
    if coverage.curves != CurveCoverage::All {
        estimates.warn(
            "many are tighter than the curves that a detector is made for: their radii and their shares of events stay those of the base study",
        );
        return;
    }
    let turns = roads.values().flat_map(|roads| roads.turns.iter().map(|(turn, _)| *turn));
    let turns: Vec<_> = turns.filter(|turn| turn.radius_m > model.turn_radius_m).collect();
    let n = turns.len();
    if n < FEWEST {
        estimates.warn(&format!("{n} of them: their radii stay those of the base study"));
        return;
    }
    let count = n as f64;
    let logs: Vec<f64> =
        turns.iter().map(|turn| libm::log(turn.radius_m - model.turn_radius_m)).collect();
    let mean = logs.iter().sum::<f64>() / count;
    let squares: f64 = logs.iter().map(|x| (x - mean) * (x - mean)).sum();
    let sd = libm::sqrt(squares / (count - 1.0));
    model.median_radius_m = libm::exp(mean);
    model.radius_log_sd = sd;
    let error = model.median_radius_m * sd / libm::sqrt(count);
    estimates.push("junction_turn.median_radius_m", model.median_radius_m, Some(error), n);
    estimates.push("junction_turn.radius_log_sd", sd, Some(sd / libm::sqrt(2.0 * count)), n);
    let angles = turns.iter().map(|turn| (turn.end_m - turn.start_m) / turn.radius_m);
    let smallest = angles.fold(f64::INFINITY, f64::min) / FRAC_PI_2;
    let share = (((count + 1.0) * smallest - 1.0) / count).clamp(0.0, 1.0);
    model.minimum_share = share;
    let error = (1.0 - share) / libm::sqrt(count * (count + 2.0));
    estimates.push("junction_turn.minimum_share", share, Some(error), n);
}
