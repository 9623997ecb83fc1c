//! Curves: intensity, radius and length.

use super::{Estimates, TypeRoads};
use crate::fit::nelder_mead::minimise;
use crate::fit::p_value::ln_normal_tail;
use ocmc_core::operating_cycle::road::curvature::CurveModel;

/// Fewest curves from which laws are estimated.
const FEWEST: usize = 5;

/// How close to its largest heading a curve counts as cut off there.
const CUT: f64 = 1.0 - 1e-6;

/// Intensity, radius and length; the smallest radius, the highest intensity and the largest heading
/// stay those of `model`.
pub(super) fn fit_curves(roads: &TypeRoads, model: &mut CurveModel, estimates: &mut Estimates) {
    let n = roads.curves.len();
    fit_intensity(roads, |_| 1.0, model, estimates);
    if n < FEWEST {
        estimates.warn("fewer than five curves: radius and length stay those of the base study");
        return;
    }
    let scale = |sign_mps: f64| model.reference_sign_mps.map_or(1.0, |sign| sign_mps / sign);
    let logs: Vec<f64> = roads
        .curves
        .iter()
        .map(|(curve, sign_mps)| (curve.radius_m - model.turn_radius_m) / scale(*sign_mps))
        .filter(|beyond| *beyond > 0.0)
        .map(libm::log)
        .collect();
    if logs.len() < n {
        estimates.warn(&format!(
            "{} curves are tighter than the smallest radius of the base study and are left out of the law of radii",
            n - logs.len()
        ));
    }
    if logs.len() >= FEWEST {
        let (mean, sd) = moments(&logs);
        let count = logs.len() as f64;
        model.median_radius_m = libm::exp(mean);
        model.radius_log_sd = sd;
        let error = model.median_radius_m * sd / libm::sqrt(count);
        estimates.push("curves.median_radius_m", model.median_radius_m, Some(error), logs.len());
        estimates.push("curves.radius_log_sd", sd, Some(sd / libm::sqrt(2.0 * count)), logs.len());
    }
    fit_length(roads, model, estimates);
}

/// Poisson regression of the starts on the sign: λ_ref (v_ref/v)^p, at most λ_max; `seen` is the
/// share of all curves under a sign's face that are seen.
pub(super) fn fit_intensity(
    roads: &TypeRoads,
    seen: impl Fn(i64) -> f64,
    model: &mut CurveModel,
    estimates: &mut Estimates,
) {
    let lengths: Vec<f64> = roads.curves.iter().map(|(c, _)| c.end_m - c.start_m).collect();
    let mean_length = lengths.iter().sum::<f64>() / (lengths.len() as f64).max(1.0);
    // a turn removes the curves that it overlaps: those that begin in it, or less than their length
    // before it
    let exposure: Vec<(f64, f64, f64)> = roads
        .curve_way_m
        .iter()
        .map(|(&face, &length)| {
            let speed = face as f64 / 36.0;
            let at = |sign: f64| super::stretch::face(sign) == face;
            let count = roads.curves.iter().filter(|(_, sign)| at(*sign)).count();
            let turns = roads.turns.iter().filter(|turn| turn.1 == face);
            let lost: f64 = turns.map(|(turn, _)| turn.end_m - turn.start_m + mean_length).sum();
            (speed, (length - lost).max(0.0) * seen(face), count as f64)
        })
        .collect();
    let n = roads.curves.len();
    let of = |theta: &[f64; 2]| CurveModel {
        per_m: libm::exp(theta[0]),
        sign_exponent: theta[1],
        ..model.clone()
    };
    let minus_log_likelihood = |theta: &[f64; 2]| {
        let model = of(theta);
        exposure
            .iter()
            .map(|&(speed, length, count)| {
                let expected = model.intensity_per_m(speed) * length;
                // a curve that begins where no way counts determines nothing
                let informative = count > 0.0 && length > 0.0;
                expected - if informative { count * libm::log(expected) } else { 0.0 }
            })
            .sum::<f64>()
    };
    let length: f64 = exposure.iter().map(|row| row.1).sum();
    let crude = n as f64 / length;
    if n == 0 {
        model.per_m = 0.0;
        estimates.push("curves.per_m", 0.0, Some(1.0 / length), 0);
        return;
    }
    let relative = 1.0 / libm::sqrt(n as f64);
    let signs = exposure.iter().filter(|row| row.1 > 0.0).count();
    if model.reference_sign_mps.is_none() {
        model.per_m = crude;
        model.maximum_per_m = model.maximum_per_m.max(crude);
        estimates.push("curves.per_m", crude, Some(crude * relative), n);
        return;
    }
    let start = [libm::log(crude), model.sign_exponent];
    if n >= 30 && signs >= 2 {
        let (theta, value) = minimise(minus_log_likelihood, start, 0.3);
        let error = |j: usize| profile_error(&minus_log_likelihood, theta, value, j);
        let errors = [error(0), error(1)];
        (model.per_m, model.sign_exponent) = (libm::exp(theta[0]), theta[1]);
        estimates.push("curves.per_m", model.per_m, errors[0].map(|e| e * model.per_m), n);
        estimates.push("curves.sign_exponent", theta[1], errors[1], n);
    } else {
        let one = |theta: &[f64; 1]| minus_log_likelihood(&[theta[0], start[1]]);
        let (theta, _) = minimise(one, [start[0]], 0.3);
        model.per_m = libm::exp(theta[0]);
        estimates.push("curves.per_m", model.per_m, Some(model.per_m * relative), n);
    }
}

/// Standard error of one of two parameters from the curvature of the profile likelihood, by
/// differences.
fn profile_error(
    function: &impl Fn(&[f64; 2]) -> f64,
    best: [f64; 2],
    value: f64,
    j: usize,
) -> Option<f64> {
    let h = 0.05;
    let profile = |step: f64| {
        let at = best[j] + step;
        let one = |other: &[f64; 1]| {
            let mut theta = [other[0]; 2];
            theta[j] = at;
            function(&theta)
        };
        minimise(one, [best[1 - j]], 0.1).1
    };
    let bend = profile(h) + profile(-h) - 2.0 * value;
    (bend > 0.0).then(|| h / libm::sqrt(bend))
}

/// Minus log-likelihood of normal values, some cut off and known to be at least so large, of mean
/// and ln SD; less a constant.
pub(super) fn minus_log_likelihood_of_cut(rows: &[(f64, bool)], theta: &[f64; 2]) -> f64 {
    let sigma = libm::exp(theta[1]);
    rows.iter()
        .map(|&(y, cut)| {
            let z = (y - theta[0]) / sigma;
            if cut { -ln_normal_tail(z) } else { 0.5 * z * z + theta[1] }
        })
        .sum()
}

/// Log-normal length with the lengths that the largest heading cut off as "at least so long".
fn fit_length(roads: &TypeRoads, model: &mut CurveModel, estimates: &mut Estimates) {
    let rows: Vec<(f64, bool)> = roads
        .curves
        .iter()
        .map(|(curve, _)| {
            let (length, bound) =
                (curve.end_m - curve.start_m, model.maximum_heading_rad * curve.radius_m);
            (libm::log(length), length >= CUT * bound)
        })
        .filter(|row| row.0.is_finite())
        .collect();
    let whole: Vec<f64> = rows.iter().filter(|row| !row.1).map(|row| row.0).collect();
    if whole.len() < FEWEST {
        estimates.warn(
            "almost all curves turn as far as they may: their lengths stay those of the base study",
        );
        return;
    }
    let (mean, sd) = moments(&whole);
    let minus_log_likelihood = |theta: &[f64; 2]| minus_log_likelihood_of_cut(&rows, theta);
    let (theta, value) = minimise(minus_log_likelihood, [mean, libm::log(sd.max(1e-3))], 0.3);
    let error = |j: usize| profile_error(&minus_log_likelihood, theta, value, j);
    let (errors, log_sd) = ([error(0), error(1)], libm::exp(theta[1]));
    model.median_length_m = libm::exp(theta[0]);
    model.length_log_sd = log_sd;
    let n = rows.len();
    let median = model.median_length_m;
    estimates.push("curves.median_length_m", median, errors[0].map(|e| e * median), n);
    estimates.push("curves.length_log_sd", log_sd, errors[1].map(|e| e * log_sd), n);
}

/// Mean and SD with n − 1.
fn moments(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    (mean, libm::sqrt(squares / (n - 1.0)))
}
