//! Curves of which only a window of radii and turns is seen: the laws of all curves from those
//! within it.
//!
//! R = r_turn + exp(N(ln m_v, σ²)), ln L ~ N(ln m_L, σ_L²), cut at θ_max R; seen where R_min ≤ R ≤
//! R_max and L ≥ max(L_min, θ_min R). The likelihood of a seen curve is f(R) f(L), with P(L ≥ θ_max
//! R) in place of f(L) where it is cut, over the share that is seen,
//!
//! P(v) = ∫ f(R) P(L ≥ max(L_min, θ_min R)) dR over R_min to R_max,
//!
//! under the sign v; the intensity of seen curves is λ(v) P(v). Without the window in the
//! likelihood the laws of the seen curves would be taken for those of all: too narrow, and too few
//! curves.
//!
//! Curves outside the window are what the laws say of them. Many laws of short curves give the same
//! curves within it: the flat direction of the likelihood is along P. So the search ends where less
//! than a tenth is seen, and laws that leave ln P with a standard error above 0.5 are none: they,
//! and P with them, stay those of the base study, and the intensity is what goes with that.

use super::curve_intensity::fit_intensity;
use super::{SignedCurve, TypeRoads};
use crate::fit::nelder_mead::minimise;
use crate::fit::p_value::ln_normal_tail;
use crate::fit::study_parameter::Estimates;
use nalgebra::{DMatrix, DVector};
use ocmc_core::operating_cycle::coverage::CurveWindow;
use ocmc_core::operating_cycle::road::curvature::{Curve, CurveModel};
use std::collections::BTreeMap;

/// Share of the largest heading from which on a measured turn counts as cut there.
const CUT: f64 = 0.97;
/// Fewest curves from which four parameters are estimated.
const FEWEST_OF_WINDOW: usize = 30;
/// Intervals of the integral over the radius.
const INTERVALS: usize = 64;
/// Step of the differences of the likelihood, in ln.
const DIFFERENCE: f64 = 0.02;
/// Estimates farther than this from the base study, in ln, are no estimates: the likelihood has no
/// maximum.
const FARTHEST: f64 = 4.0;

/// Smallest share of the curves that may be seen (judgement).
const LEAST_SEEN: f64 = 0.1;
/// Largest standard error of the logarithm of that share (judgement).
const LARGEST_ERROR: f64 = 0.5;

/// A base study without a spread starts the search here.
const SMALLEST: f64 = 1e-3;

/// A curve that is seen.
struct Seen {
    /// ln(R − r_turn) less that of the sign's scale.
    ln_beyond: f64,
    ln_length: f64,
    cut: bool,
    face: i64,
}

/// Laws of radius and length as the search sees them: ln median, ln SD, of both.
type Laws = [f64; 4];

/// Intensity, radius and length from the curves of a window.
pub(super) fn fit_curves(
    roads: &TypeRoads,
    window: &CurveWindow,
    model: &mut CurveModel,
    estimates: &mut Estimates,
) {
    let seen = seen_curves(roads, window, model);
    let outside = roads.curves.len() - seen.len();
    if outside > 0 {
        estimates.warn(format_args!(
            "{outside} of {} curves are outside the window of {} to {} m, or tighter than the \
             smallest radius of the base study: they are left out",
            roads.curves.len(),
            window.radius_m[0],
            window.radius_m[1]
        ));
    }
    let seen_error = if seen.len() < FEWEST_OF_WINDOW {
        estimates.warn(format_args!(
            "{} curves within the window do not tell the laws of all: radius and length stay \
             those of the base study, and `curves.per_m` is what goes with the share that they \
             let a detector see, without a standard error",
            seen.len()
        ));
        None
    } else {
        fit_laws(&seen, window, model, estimates)
    };
    let laws = laws_of(model);
    let base = model.clone();
    let share = |face: i64| seen_share(&laws, window, &base, scale(&base, face));
    let mut within = roads.clone();
    let sees = |curve: &Curve| window.sees(curve.radius_m, curve.end_m - curve.start_m);
    within.curves.retain(|signed| sees(&signed.curve));
    fit_intensity(&within, share, seen_error, model, estimates);
}

/// Factor of the median radius under a sign.
fn scale(model: &CurveModel, face: i64) -> f64 {
    model.reference_sign_mps.map_or(1.0, |reference| face as f64 / 36.0 / reference)
}

fn laws_of(model: &CurveModel) -> Laws {
    [model.median_radius_m, model.radius_log_sd, model.median_length_m, model.length_log_sd]
        .map(|value| libm::log(value.max(SMALLEST)))
}

fn seen_curves(roads: &TypeRoads, window: &CurveWindow, model: &CurveModel) -> Vec<Seen> {
    let row = |signed: &SignedCurve| {
        let SignedCurve { curve, sign_mps, is_cut, .. } = signed;
        let length_m = curve.end_m - curve.start_m;
        let face = super::stretch::face(*sign_mps);
        let beyond_m = curve.radius_m - model.turn_radius_m;
        let inside = window.sees(curve.radius_m, length_m) && beyond_m > 0.0;
        inside.then(|| Seen {
            ln_beyond: libm::log(beyond_m / scale(model, face)),
            ln_length: libm::log(length_m),
            cut: *is_cut || length_m >= CUT * model.maximum_heading_rad * curve.radius_m,
            face,
        })
    };
    roads.curves.iter().filter_map(row).collect()
}

/// Fits the laws, all four or none; the standard error of the logarithm of the share that is seen.
fn fit_laws(
    seen: &[Seen],
    window: &CurveWindow,
    model: &mut CurveModel,
    estimates: &mut Estimates,
) -> Option<f64> {
    let mut faces: BTreeMap<i64, f64> = BTreeMap::new();
    for curve in seen {
        *faces.entry(curve.face).or_insert(0.0) += 1.0;
    }
    let start = laws_of(model);
    let count = seen.len() as f64;
    let ln_share = |laws: &Laws| {
        let ln_seen = |(&face, curves): (&i64, &f64)| {
            curves * libm::log(seen_share(laws, window, model, scale(model, face)))
        };
        faces.iter().map(ln_seen).sum::<f64>() / count
    };
    // what the base study says is where the search begins, however little it lets a detector see
    let least = libm::log(LEAST_SEEN).min(ln_share(&start) - 1.0);
    let minus_log_likelihood = |laws: &Laws| {
        if laws.iter().zip(start).any(|(a, b)| (a - b).abs() > FARTHEST) {
            return f64::INFINITY;
        }
        let (sigma, sigma_length) = (libm::exp(laws[1]), libm::exp(laws[3]));
        let of_curves: f64 = seen
            .iter()
            .map(|curve| {
                let z = (curve.ln_beyond - laws[0]) / sigma;
                let y = (curve.ln_length - laws[2]) / sigma_length;
                let length = if curve.cut { -ln_normal_tail(y) } else { 0.5 * y * y + laws[3] };
                0.5 * z * z + laws[1] + length
            })
            .sum();
        let ln_share = ln_share(laws);
        if ln_share < least {
            return f64::INFINITY;
        }
        of_curves + count * ln_share
    };
    let (laws, value) = minimise(minus_log_likelihood, start, 0.3);
    let at_edge = laws.iter().zip(start).any(|(a, b)| (a - b).abs() > 0.95 * FARTHEST)
        || ln_share(&laws) < least + DIFFERENCE;
    let told = (!at_edge && value.is_finite())
        .then(|| covariance(&minus_log_likelihood, laws, value))
        .flatten()
        .map(|covariance| {
            let ln_share_beside = |k: usize, side: f64| {
                let mut at = laws;
                at[k] += side * DIFFERENCE;
                ln_share(&at)
            };
            let slope = DVector::from_fn(4, |k, _| {
                (ln_share_beside(k, 1.0) - ln_share_beside(k, -1.0)) / (2.0 * DIFFERENCE)
            });
            let variance = slope.dot(&(&covariance * &slope));
            (covariance, libm::sqrt(variance.max(0.0)))
        });
    let Some((covariance, error)) = told.filter(|(_, error)| *error <= LARGEST_ERROR) else {
        estimates.warn(format_args!(
            "the {} curves within the window fit many laws of all curves, with the more short ones \
             the shorter they are: radius and length stay those of the base study, and \
             `curves.per_m` is what goes with them, without a standard error",
            seen.len()
        ));
        return None;
    };
    for (k, (key, into)) in [
        ("curves.median_radius_m", &mut model.median_radius_m),
        ("curves.radius_log_sd", &mut model.radius_log_sd),
        ("curves.median_length_m", &mut model.median_length_m),
        ("curves.length_log_sd", &mut model.length_log_sd),
    ]
    .into_iter()
    .enumerate()
    {
        let value = libm::exp(laws[k]);
        let error = libm::sqrt(covariance[(k, k)]) * value;
        estimates.set(key, into, value, Some(error), seen.len());
    }
    Some(error)
}

/// Share of all curves under a sign that the window sees; `scale` is the sign's factor of the
/// median.
fn seen_share(laws: &Laws, window: &CurveWindow, model: &CurveModel, scale: f64) -> f64 {
    let [median, sigma, length, length_sd] =
        [laws[0] + libm::log(scale), libm::exp(laws[1]), laws[2], libm::exp(laws[3])];
    // eight SD hold all that a double sees
    let end = |radius_m: f64, side: f64| {
        let beyond_m = radius_m - model.turn_radius_m;
        let z = if beyond_m > 0.0 { (libm::log(beyond_m) - median) / sigma } else { -8.0 };
        if z.is_finite() { z.clamp(-8.0, 8.0) } else { 8.0 * side }
    };
    let (low, high) = (end(window.radius_m[0], -1.0), end(window.radius_m[1], 1.0));
    let at = |z: f64| {
        let radius_m = model.turn_radius_m + libm::exp(median + sigma * z);
        let least_m = window.least_length_m(radius_m);
        if least_m > model.maximum_heading_rad * radius_m {
            return 0.0;
        }
        let long = if least_m > 0.0 {
            libm::exp(ln_normal_tail((libm::log(least_m) - length) / length_sd))
        } else {
            1.0
        };
        libm::exp(-0.5 * z * z) * long
    };
    // Simpson's rule
    let step = (high - low) / INTERVALS as f64;
    let sum: f64 = (0..=INTERVALS)
        .map(|k| {
            let weight = match k {
                0 | INTERVALS => 1.0,
                k if k % 2 == 1 => 4.0,
                _ => 2.0,
            };
            weight * at(low + k as f64 * step)
        })
        .sum();
    (sum * step / 3.0 / libm::sqrt(std::f64::consts::TAU)).max(1e-12)
}

/// Covariance from the curvature of the likelihood; none where it has no minimum there.
fn covariance(function: &impl Fn(&Laws) -> f64, best: Laws, value: f64) -> Option<DMatrix<f64>> {
    let moved = |moves: &[(usize, f64)]| {
        let mut at = best;
        for &(k, side) in moves {
            at[k] += side * DIFFERENCE;
        }
        function(&at)
    };
    let bend = DMatrix::from_fn(4, 4, |i, j| {
        let difference = if i == j {
            moved(&[(i, 1.0)]) + moved(&[(i, -1.0)]) - 2.0 * value
        } else {
            let corner = |a: f64, b: f64| moved(&[(i, a), (j, b)]);
            0.25 * (corner(1.0, 1.0) + corner(-1.0, -1.0) - corner(1.0, -1.0) - corner(-1.0, 1.0))
        };
        difference / (DIFFERENCE * DIFFERENCE)
    });
    if !bend.iter().all(|value| value.is_finite()) {
        return None;
    }
    Some(bend.cholesky()?.inverse())
}
