//! Curves: radius and length; and turns at junctions, with radii R = r₀ + exp(N(ln m,
//! σ²)) and angles π/2 U(f, 1).

use super::curve_intensity::fit_intensity;
use super::{SignedCurve, TypeRoads};
use crate::fit::nelder_mead::minimise;
use crate::fit::p_value::ln_normal_tail;
use crate::fit::study_parameter::Estimates;
use crate::moments::Moments;
use ocmc_core::operating_cycle::coverage::{Coverage, CurveCoverage};
use ocmc_core::operating_cycle::road::curvature::{Curve, CurveModel};
use ocmc_core::operating_cycle::road::point_event::JunctionTurnModel;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

/// Fewest curves, and fewest turns, from which laws are estimated.
const FEWEST: usize = 5;

/// How close to its largest heading a curve counts as cut off there.
const CUT: f64 = 1.0 - 1e-6;

pub(super) fn length_m(curve: &Curve) -> f64 {
    curve.end_m - curve.start_m
}

/// Intensity, radius and length; the smallest radius, the highest intensity and the largest heading
/// stay those of `model`.
pub(super) fn fit_curves(roads: &TypeRoads, model: &mut CurveModel, estimates: &mut Estimates) {
    let n = roads.curves.len();
    fit_intensity(roads, |_| 1.0, Some(0.0), model, estimates);
    if n < FEWEST {
        estimates.warn("fewer than five curves: radius and length stay those of the base study");
        return;
    }
    let scale = |sign_mps: f64| model.reference_sign_mps.map_or(1.0, |sign| sign_mps / sign);
    let logs: Vec<f64> = roads
        .curves
        .iter()
        .filter(|signed| !signed.may_be_pushed)
        .map(|signed| (signed.curve.radius_m - model.turn_radius_m) / scale(signed.sign_mps))
        .filter(|beyond| *beyond > 0.0)
        .map(libm::log)
        .collect();
    let tighter = roads.curves.iter().filter(|signed| signed.curve.radius_m <= model.turn_radius_m);
    let tighter = tighter.count();
    if tighter > 0 {
        estimates.warn(format_args!(
            "{tighter} curves are tighter than the smallest radius of the base study and are left \
             out of the law of radii"
        ));
    }
    if logs.len() >= FEWEST {
        let (median, log_sd) = (&mut model.median_radius_m, &mut model.radius_log_sd);
        fit_radius("curves", &logs, median, log_sd, estimates);
    }
    fit_length(roads, model, estimates);
}

/// Median and SD of log-normal radii beyond the smallest one, from the logarithms.
fn fit_radius(
    table: &str,
    logs: &[f64],
    median: &mut f64,
    log_sd: &mut f64,
    estimates: &mut Estimates,
) {
    let moments = Moments::of(logs);
    let (radius_m, sd) = (libm::exp(moments.mean), moments.sd());
    let error = Some(radius_m * sd / libm::sqrt(moments.n));
    estimates.set(&format!("{table}.median_radius_m"), median, radius_m, error, logs.len());
    let error = Some(sd / libm::sqrt(2.0 * moments.n));
    estimates.set(&format!("{table}.radius_log_sd"), log_sd, sd, error, logs.len());
}

/// Standard errors of two parameters from the curvature of the profile likelihood, by differences.
pub(super) fn profile_errors(
    function: &impl Fn(&[f64; 2]) -> f64,
    best: [f64; 2],
    value: f64,
) -> [Option<f64>; 2] {
    let h = 0.05;
    [0, 1].map(|j| {
        let profile = |step: f64| {
            let one = |other: &[f64; 1]| {
                let mut theta = [other[0]; 2];
                theta[j] = best[j] + step;
                function(&theta)
            };
            minimise(one, [best[1 - j]], 0.1).1
        };
        let bend = profile(h) + profile(-h) - 2.0 * value;
        (bend > 0.0 && bend.is_finite()).then(|| h / libm::sqrt(bend))
    })
}

/// A normal value, which may be censored.
pub(super) struct CensoredNormal {
    pub value: f64,
    /// Whether it is known to be at least so large only.
    pub is_cut: bool,
    /// For how many it stands.
    pub weight: f64,
}

/// Minus log-likelihood of normal values of mean and ln SD; less a constant.
pub(super) fn minus_log_likelihood_of_cut(normals: &[CensoredNormal], theta: &[f64; 2]) -> f64 {
    let sigma = libm::exp(theta[1]);
    normals
        .iter()
        .map(|normal| {
            let z = (normal.value - theta[0]) / sigma;
            normal.weight * if normal.is_cut { -ln_normal_tail(z) } else { 0.5 * z * z + theta[1] }
        })
        .sum()
}

/// Log-normal length with the lengths that the largest heading or the end of the road cut off as
/// "at least so long". A turn removes the curves that it overlaps, the longer the likelier: a curve
/// of length L stands for exp(L turns per m) of those that were there. Curves that the road type
/// before may have pushed over its end have the lengths of that one and are left out.
fn fit_length(roads: &TypeRoads, model: &mut CurveModel, estimates: &mut Estimates) {
    let turns_per_m = roads.turns.len() as f64 / roads.length_m;
    let mut normals: Vec<CensoredNormal> = roads
        .curves
        .iter()
        .filter(|signed| !signed.may_be_pushed)
        .map(|SignedCurve { curve, is_cut, .. }| {
            let (length, bound) = (length_m(curve), model.maximum_heading_rad * curve.radius_m);
            let is_cut = *is_cut || length >= CUT * bound;
            CensoredNormal {
                value: libm::log(length),
                is_cut,
                weight: libm::exp(turns_per_m * length),
            }
        })
        .filter(|normal| normal.value.is_finite())
        .collect();
    let mean_weight =
        normals.iter().map(|normal| normal.weight).sum::<f64>() / normals.len() as f64;
    for normal in &mut normals {
        normal.weight /= mean_weight;
    }
    let whole: Vec<f64> =
        normals.iter().filter(|normal| !normal.is_cut).map(|normal| normal.value).collect();
    if whole.len() < FEWEST {
        estimates.warn(
            "almost all curves turn as far as they may: their lengths stay those of the base study",
        );
        return;
    }
    let moments = Moments::of(&whole);
    let start = [moments.mean, libm::log(moments.sd().max(1e-3))];
    let minus_log_likelihood = |theta: &[f64; 2]| minus_log_likelihood_of_cut(&normals, theta);
    let (theta, value) = minimise(minus_log_likelihood, start, 0.3);
    let errors = profile_errors(&minus_log_likelihood, theta, value);
    let [median, log_sd] = theta.map(libm::exp);
    let error = |j: usize, value: f64| errors[j].map(|e| e * value);
    let (n, into) = (normals.len(), &mut model.median_length_m);
    estimates.set("curves.median_length_m", into, median, error(0, median), n);
    let into = &mut model.length_log_sd;
    estimates.set("curves.length_log_sd", into, log_sd, error(1, log_sd), n);
}

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
            "many are tighter than the curves that a detector is made for: their radii and their \
             shares of events stay those of the base study",
        );
        return;
    }
    let turns = roads.values().flat_map(|roads| roads.turns.iter().map(|(turn, _)| *turn));
    let turns: Vec<_> = turns.filter(|turn| turn.radius_m > model.turn_radius_m).collect();
    let n = turns.len();
    if n < FEWEST {
        return estimates
            .warn(format_args!("{n} of them: their radii stay those of the base study"));
    }
    let count = n as f64;
    let logs: Vec<f64> =
        turns.iter().map(|turn| libm::log(turn.radius_m - model.turn_radius_m)).collect();
    let (median, log_sd) = (&mut model.median_radius_m, &mut model.radius_log_sd);
    fit_radius("junction_turn", &logs, median, log_sd, estimates);
    let angles = turns.iter().map(|turn| length_m(turn) / turn.radius_m);
    let smallest = angles.fold(f64::INFINITY, f64::min) / FRAC_PI_2;
    let share = (((count + 1.0) * smallest - 1.0) / count).clamp(0.0, 1.0);
    let error = Some((1.0 - share) / libm::sqrt(count * (count + 2.0)));
    estimates.set("junction_turn.minimum_share", &mut model.minimum_share, share, error, n);
}
