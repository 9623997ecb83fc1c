//! Curves under a speed limit: censored regression, and the regression of the slow curves alone.
//!
//! A curve in whose middle the truck still gains speed is censored, too: where it drives behind
//! another bend or a junction its speed is what its acceleration allows, and the driver would take
//! the curve at least that fast. To leave such curves out instead would favour slow wishes, which
//! are reached sooner.

use super::curves::{Curve, Curves};
use super::estimate::{CurveSpeedEstimate, Determined, Regression};
use super::{CurveSpeedOptions, LEVEL};
use crate::fit::p_value::t_of_interval;
use crate::fit::profile_interval::between_groups;
use crate::fit::tobit::{TobitFit, TobitRow, fit};
use crate::moments::Moments;

/// The censored regression, the curves at the limit, and the regression of those below it.
pub(super) type Limited = (Option<CurveSpeedEstimate>, Option<usize>, Option<CurveSpeedEstimate>);

/// Curves a driver below which a censored regression of many levels is seen to be too sure.
const FEW_CURVES: usize = 10;

/// Fits with curves from `limit_share` of the limit on as "at least that fast". A curve whose limit
/// is not known may be at it or not: it takes no part.
pub(super) fn limited(
    curves: &Curves,
    direction: bool,
    options: &CurveSpeedOptions,
    warnings: &mut Vec<String>,
) -> Limited {
    let all = curves.rows.len();
    let curves = &curves.only(|curve| !curve.log_limit.is_nan());
    let unknown = all - curves.rows.len();
    if curves.rows.is_empty() {
        warnings.push(
            "no curve has a known speed limit (above 0): there is no censored regression".into(),
        );
        return Limited::default();
    }
    if unknown > 0 {
        warnings.push(format!(
            "{unknown} of {all} curves have no known speed limit (above 0): the censored \
             regression and that below the limits leave them out"
        ));
    }
    let log_share = libm::log(options.limit_share);
    let kept = |curve: &Curve| curve.log_speed >= curve.log_limit + log_share;
    let at_limit = curves.rows.iter().filter(|curve| kept(curve)).count();
    let slow = curves.only(|curve| !kept(curve));
    // a truck that still accelerates shows no more than one that keeps to the limit
    let cut = |curve: &Curve| kept(curve) || curve.accelerating;
    let accelerating =
        curves.rows.iter().filter(|curve| curve.accelerating && !kept(curve)).count();
    if accelerating > 0 {
        warnings.push(format!(
            "in {accelerating} curves below the limit the truck still gained speed in the middle: \
             the censored regression takes them as at least that fast"
        ));
    }
    let below_limit = (!slow.rows.is_empty())
        .then(|| Regression::new(&slow, direction, &mut Vec::new()).ok())
        .flatten()
        .map(|regression| regression.estimate(&slow));
    // a driver who is at the limit in every curve has no level
    let mut has_slow = vec![false; curves.drivers.len()];
    for curve in curves.rows.iter().filter(|curve| !cut(curve)) {
        has_slow[curve.driver] = true;
    }
    let seen = curves.only(|curve| has_slow[curve.driver]);
    let left_out = curves.drivers.len() - seen.drivers.len();
    if left_out > 0 {
        warnings.push(format!(
            "{left_out} drivers are at the limit in every curve, {} curves: the censored \
             regression leaves them out",
            curves.rows.len() - seen.rows.len()
        ));
    }
    let limit = |curve: &Curve| {
        let limit = curve.log_limit + log_share;
        cut(curve).then_some(if curve.accelerating { limit.min(curve.log_speed) } else { limit })
    };
    let tobit = if direction { censored::<2>(&seen, limit) } else { censored::<1>(&seen, limit) };
    if tobit.is_none() {
        warnings.push("the curves below the limit do not determine a censored regression".into());
    }
    let tobit = tobit.map(|fit| estimate(&fit, &seen, direction, warnings));
    if tobit.is_some() && at_limit > 0 && seen.rows.len() < FEW_CURVES * seen.drivers.len() {
        warnings.push(format!(
            "with less than {FEW_CURVES} curves a driver the censored regression's intervals of \
             exponent and residual cover some 90 %, not 95 %"
        ));
    }
    (tobit, Some(at_limit), below_limit)
}

/// The regression on ln R and, with two predictors, on the direction; `limit` is ln v of a curve
/// that was driven at the limit.
fn censored<const X: usize>(
    curves: &Curves,
    limit: impl Fn(&Curve) -> Option<f64>,
) -> Option<TobitFit> {
    let row = |curve: &Curve| {
        let predictors = [curve.log_radius, if curve.left { 1.0 } else { -1.0 }];
        let (y, cut) = limit(curve).map_or((curve.log_speed, false), |limit| (limit, true));
        TobitRow { group: curve.driver, x: std::array::from_fn(|j| predictors[j]), y, cut }
    };
    let rows: Vec<TobitRow<X>> = curves.rows.iter().map(row).collect();
    fit(&rows, curves.drivers.len())
}

fn estimate(
    fit: &TobitFit,
    curves: &Curves,
    direction: bool,
    warnings: &mut Vec<String>,
) -> CurveSpeedEstimate {
    let drivers = curves.drivers.len();
    let error = |j: usize| libm::sqrt(fit.covariance[(j, j)]);
    let df = curves.rows.len().saturating_sub(drivers + fit.coefficients.len());
    let estimate = Determined {
        df,
        level: (Moments::of(&fit.levels).mean, libm::sqrt(fit.mean_level_variance)),
        exponent: fit.coefficients[0],
        exponent_error: Some(error(0)),
        clustered: fit.clustered,
        level_clustered: fit.clustered_mean_level,
        direction: direction.then(|| (fit.coefficients[1], error(1))),
        effects: &fit.levels,
        residual_sd: fit.sigma,
    };
    let reach = t_of_interval(LEVEL, df as f64) * fit.sigma_standard_error / fit.sigma;
    let ci95 = [-reach, reach].map(|reach| fit.sigma * libm::exp(reach));
    // the sample SD of the levels also holds the error of each level
    let between = between_groups(&fit.levels, &fit.own_variances);
    if between.is_some_and(|between| between.sd == 0.0) {
        warnings.push(
            "in the censored regression the drivers differ by no more than their curves do: its \
             `driver_sd` is 0"
                .into(),
        );
    }
    CurveSpeedEstimate {
        residual_sd_ci95: Some(ci95),
        driver_sd_corrected: between.map(|between| between.sd),
        driver_sd_corrected_ci95: between.map(|between| between.ci95),
        ..estimate.estimate(curves)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CurveSpeedOptions, CurveTable, fit};
    use ocmc_core::random::{Draws, Stream};

    /// Drivers with the exponent 0.5 who keep to 16 m/s; every third curve has a limit of `other`,
    /// which they keep to, too.
    fn table(other: f64) -> CurveTable {
        let mut draws = Draws::new(3, 0, Stream::Curve);
        let mut table = CurveTable { limit_mps: Some(vec![]), ..CurveTable::default() };
        for k in 0..600 {
            let radius_m = 30.0 + 400.0 * draws.uniform();
            let speed = 20.0 * libm::sqrt(radius_m / 250.0) * libm::exp(0.08 * draws.normal());
            table.driver.push(format!("driver {}", k % 6));
            table.radius_m.push(radius_m);
            table.speed_mps.push(speed.min(16.0));
            table.limit_mps.as_mut().unwrap().push(if k % 3 == 0 { other } else { 16.0 });
        }
        table
    }

    #[test]
    fn curves_with_an_unknown_limit_take_no_part() {
        for unknown in [f64::NAN, 0.0] {
            let curve_fit = fit(&table(unknown), &CurveSpeedOptions::default()).unwrap();
            let tobit = curve_fit.tobit.unwrap();
            let error = tobit.exponent_standard_error.unwrap();
            assert!((tobit.exponent - 0.5).abs() < 4.0 * error && error < 0.02, "{tobit:?}");
            assert_eq!(tobit.n, 400);
            assert!(curve_fit.below_limit.unwrap().n < 400 && curve_fit.at_limit.unwrap() < 400);
            let message = "200 of 600 curves have no known speed limit";
            assert!(
                curve_fit.warnings.iter().any(|text| text.contains(message)),
                "{:?}",
                curve_fit.warnings
            );
        }
        // no limit at all is known, and never censors
        let free = fit(&table(f64::INFINITY), &CurveSpeedOptions::default()).unwrap();
        assert_eq!(free.tobit.unwrap().n, 600);
    }

    #[test]
    fn without_a_known_limit_there_is_no_censored_regression() {
        let mut none = table(f64::NAN);
        none.limit_mps = Some(vec![f64::NAN; 600]);
        let curve_fit = fit(&none, &CurveSpeedOptions::default()).unwrap();
        assert_eq!(
            (curve_fit.tobit, curve_fit.at_limit, curve_fit.below_limit),
            (None, None, None)
        );
        let message = "no curve has a known speed limit";
        assert!(
            curve_fit.warnings.iter().any(|text| text.contains(message)),
            "{:?}",
            curve_fit.warnings
        );
    }
}
