//! The intensity of curves: Poisson regression of their starts on the sign, λ(v) = λ_ref
//! (v_ref/v)^p, at most λ_max.
//!
//! λ_ref holds at the reference sign and is written with p or not at all: ln λ_ref = ln λ(v̄) − p
//! ln(v_ref/v̄), so that under signs that are all slower than the reference an error of p is one of
//! λ_ref. The search stays within what a study takes. Where the signs do not determine p, it is the
//! base study's, λ_ref is estimated beside that, and both are said; so is the direction in which
//! the likelihood is flat.

use super::TypeRoads;
use super::curve::{length_m, profile_errors};
use crate::fit::nelder_mead::minimise;
use crate::fit::study_parameter::Estimates;
use ocmc_core::operating_cycle::road::curvature::CurveModel;

/// Fewest curves from which an exponent is estimated.
const FEWEST_OF_EXPONENT: usize = 30;
/// Exponents that a study takes.
const EXPONENTS: std::ops::RangeInclusive<f64> = 0.0..=10.0;
/// Highest intensity that a study takes, per m.
const HIGHEST_PER_M: f64 = 0.05;
/// Lowest intensity of the search, per m: a curve in 1000 km.
const LOWEST_PER_M: f64 = 1e-6;
/// Largest standard error of ln λ_ref with which it is written: an interval from a third of it to
/// three times it (judgement).
const LARGEST_ERROR: f64 = 0.5;
/// Exponents at which the search begins, beside that of the base study.
const STARTS: [f64; 2] = [0.5, 4.0];
/// Distance of an exponent from the ends of its range at which it is no estimate.
const AT_END: f64 = 0.01;
/// Signs on whose mean the curves are this close to the reference, in ln, need no exponent.
const AT_REFERENCE: f64 = 0.05;
/// Standard deviations by which curves are too many for the highest intensity.
const TOO_MANY: f64 = 3.0;

/// Curves under the signs of one face.
struct UnderSign {
    speed_mps: f64,
    /// Way on which they would be seen, in m.
    length_m: f64,
    count: f64,
}

/// Fits λ_ref and p. `seen` is the share of all curves under a sign's face that are seen;
/// `seen_error` is the standard error of its logarithm, none where it is that of the base study.
pub(super) fn fit_intensity(
    roads: &TypeRoads,
    seen: impl Fn(i64) -> f64,
    seen_error: Option<f64>,
    model: &mut CurveModel,
    estimates: &mut Estimates,
) {
    let rows = under_signs(roads, seen);
    let n = roads.curves.len();
    let length_m: f64 = rows.iter().map(|row| row.length_m).sum();
    if n == 0 {
        let error = Some(1.0 / length_m);
        return estimates.set("curves.per_m", &mut model.per_m, 0.0, error, 0);
    }
    let crude = (n as f64 / length_m).clamp(LOWEST_PER_M, HIGHEST_PER_M);
    let of_count = 1.0 / libm::sqrt(n as f64);
    let with_seen = |error: f64| seen_error.map(|seen| libm::hypot(error, seen));
    let Some(reference_mps) = model.reference_sign_mps else {
        model.maximum_per_m = model.maximum_per_m.max(crude);
        let error = with_seen(of_count).map(|error| error * crude);
        return estimates.set("curves.per_m", &mut model.per_m, crude, error, n);
    };
    raise_highest(&rows, model, estimates);
    let base = model.clone();
    let minus_log_likelihood = |theta: &[f64; 2]| {
        let (per_m, sign_exponent) = (libm::exp(theta[0]), theta[1]);
        let allowed = (LOWEST_PER_M..=HIGHEST_PER_M).contains(&per_m);
        if !(allowed && EXPONENTS.contains(&sign_exponent)) {
            return f64::INFINITY;
        }
        let model = CurveModel { per_m, sign_exponent, ..base.clone() };
        let term = |row: &UnderSign| {
            let expected = model.intensity_per_m(row.speed_mps) * row.length_m;
            // a curve that begins where no way counts determines nothing
            let informative = row.count > 0.0 && row.length_m > 0.0;
            expected - if informative { row.count * libm::log(expected) } else { 0.0 }
        };
        rows.iter().map(term).sum()
    };
    // as many curves as there are, were there no highest intensity: where that holds, the
    // likelihood is flat, and a search that begins there stays
    let start = |exponent: f64| {
        let exposure =
            |row: &UnderSign| row.length_m * libm::pow(reference_mps / row.speed_mps, exponent);
        let per_m =
            n as f64 / rows.iter().filter(|row| row.speed_mps > 0.0).map(exposure).sum::<f64>();
        [libm::log(per_m.clamp(LOWEST_PER_M, HIGHEST_PER_M)), exponent]
    };
    let signs = rows.iter().filter(|row| row.length_m > 0.0).count();
    if n >= FEWEST_OF_EXPONENT && signs >= 2 {
        let starts = STARTS.into_iter().chain([base.sign_exponent]).map(start);
        let minima = starts.map(|start| minimise(minus_log_likelihood, start, 0.3));
        let best = minima.min_by(|a, b| a.1.total_cmp(&b.1));
        let (theta, value) = best.expect("there are starts");
        let errors = profile_errors(&minus_log_likelihood, theta, value);
        let inside = theta[1] > EXPONENTS.start() + AT_END && theta[1] < EXPONENTS.end() - AT_END;
        if let [Some(error), Some(of_exponent)] = errors
            && inside
            && error <= LARGEST_ERROR
        {
            let per_m = libm::exp(theta[0]);
            let error = with_seen(error).map(|error| error * per_m);
            estimates.set("curves.per_m", &mut model.per_m, per_m, error, n);
            let into = &mut model.sign_exponent;
            estimates.set("curves.sign_exponent", into, theta[1], Some(of_exponent), n);
            return;
        }
    }
    let [first, exponent] = start(base.sign_exponent);
    let one = |theta: &[f64; 1]| minus_log_likelihood(&[theta[0], exponent]);
    let per_m = libm::exp(minimise(one, [first], 0.3).0[0]);
    let away = |row: &UnderSign| row.count * libm::log(reference_mps / row.speed_mps);
    let away = rows.iter().filter(|row| row.speed_mps > 0.0).map(away).sum::<f64>() / n as f64;
    let at_reference = away.abs() <= AT_REFERENCE;
    if !at_reference {
        estimates.warn(format_args!(
            "{n} curves under {signs} signs do not tell how their number follows the sign: the \
             exponent, {}, stays that of the base study, and `curves.per_m`, which holds at {:.0} \
             km/h, is what goes with it (another exponent p changes it by the factor {:.2}^({} - \
             p)) and has no standard error",
            exponent,
            3.6 * reference_mps,
            libm::exp(away),
            exponent
        ));
    }
    let error = with_seen(of_count).filter(|_| at_reference).map(|error| error * per_m);
    estimates.set("curves.per_m", &mut model.per_m, per_m, error, n);
    say_highest(&rows, model, estimates);
}

/// Curves and the way on which they would be seen. A turn removes the curves that it overlaps:
/// those that begin in it, or less than their length before it.
fn under_signs(roads: &TypeRoads, seen: impl Fn(i64) -> f64) -> Vec<UnderSign> {
    let lengths: Vec<f64> = roads.curves.iter().map(|signed| length_m(&signed.curve)).collect();
    let mean_length = lengths.iter().sum::<f64>() / (lengths.len() as f64).max(1.0);
    let under_sign = |(&face, &length): (&i64, &f64)| {
        let at = |sign: f64| super::stretch::face(sign) == face;
        let count = roads.curves.iter().filter(|signed| at(signed.sign_mps)).count();
        let turns = roads.turns.iter().filter(|turn| turn.1 == face);
        let lost: f64 = turns.map(|(turn, _)| length_m(turn) + mean_length).sum();
        let length_m = (length - lost).max(0.0) * seen(face);
        UnderSign { speed_mps: face as f64 / 36.0, length_m, count: count as f64 }
    };
    roads.curve_way_m.iter().map(under_sign).collect()
}

/// Raises the highest intensity to that under the sign with the most curves, where the base study's
/// does not explain their number.
fn raise_highest(rows: &[UnderSign], model: &mut CurveModel, estimates: &mut Estimates) {
    let base = model.maximum_per_m;
    let too_many = rows.iter().filter(|row| {
        let expected = base * row.length_m;
        row.length_m > 0.0 && row.count - expected > TOO_MANY * libm::sqrt(expected.max(1.0))
    });
    let densest = too_many.max_by(|a, b| (a.count / a.length_m).total_cmp(&(b.count / b.length_m)));
    let Some(densest) = densest else { return };
    let highest = (densest.count / densest.length_m).min(HIGHEST_PER_M);
    let error = highest / libm::sqrt(densest.count);
    let n = densest.count as usize;
    let into = &mut model.maximum_per_m;
    estimates.set("curves.maximum_per_m", into, highest, Some(error), n);
}

/// Says under which signs the highest intensity holds, where the exponent is not determined: these
/// roads do not help.
fn say_highest(rows: &[UnderSign], model: &CurveModel, estimates: &mut Estimates) {
    let at_highest = |row: &&UnderSign| {
        row.length_m > 0.0 && model.intensity_per_m(row.speed_mps) >= model.maximum_per_m
    };
    let fastest = rows.iter().filter(at_highest).map(|row| row.speed_mps).fold(0.0, f64::max);
    if fastest > 0.0 {
        estimates.warn(format_args!(
            "under signs up to {:.0} km/h its curves have the highest intensity, {} per m: such \
             roads do not tell the exponent",
            3.6 * fastest,
            model.maximum_per_m
        ));
    }
}
