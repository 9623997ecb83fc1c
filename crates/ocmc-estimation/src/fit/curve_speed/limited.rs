//! Curves under a speed limit: censored regression, and the regression of the slow curves alone.

use super::curves::{Curve, Curves};
use super::estimate::{CurveSpeedEstimate, Regression, Spread};
use super::{CurveSpeedOptions, LEVEL};
use crate::fit::p_value::t_of_interval;
use crate::fit::tobit::{TobitFit, TobitRow, fit};

/// What the limits determine.
#[derive(Clone, Debug, Default)]
pub(super) struct Limited {
    pub tobit: Option<CurveSpeedEstimate>,
    pub at_limit: Option<usize>,
    pub below_limit: Option<CurveSpeedEstimate>,
}

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
            "{unknown} of {all} curves have no known speed limit (above 0): the censored regression and that below the limits leave them out"
        ));
    }
    let log_share = libm::log(options.limit_share);
    let cut = |curve: &Curve| curve.log_speed >= curve.log_limit + log_share;
    let at_limit = curves.rows.iter().filter(|curve| cut(curve)).count();
    let slow = curves.only(|curve| !cut(curve));
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
            "{left_out} drivers are at the limit in every curve, {} curves: the censored regression leaves them out",
            curves.rows.len() - seen.rows.len()
        ));
    }
    let row = |curve: &Curve| {
        let cut = cut(curve);
        let y = if cut { curve.log_limit + log_share } else { curve.log_speed };
        (curve.driver, curve.log_radius, if curve.left { 1.0 } else { -1.0 }, y, cut)
    };
    let tobit = if direction {
        let rows: Vec<TobitRow<2>> = seen
            .rows
            .iter()
            .map(row)
            .map(|(group, x, side, y, cut)| TobitRow { group, x: [x, side], y, cut })
            .collect();
        fit(&rows, seen.drivers.len())
    } else {
        let rows: Vec<TobitRow<1>> = seen
            .rows
            .iter()
            .map(row)
            .map(|(group, x, _, y, cut)| TobitRow { group, x: [x], y, cut })
            .collect();
        fit(&rows, seen.drivers.len())
    };
    if tobit.is_none() {
        warnings.push("the curves below the limit do not determine a censored regression".into());
    }
    let tobit = tobit.map(|fit| estimate(&fit, &seen, direction));
    Limited { tobit, at_limit: Some(at_limit), below_limit }
}

fn estimate(fit: &TobitFit, curves: &Curves, direction: bool) -> CurveSpeedEstimate {
    let drivers = curves.drivers.len();
    let (slope, last) = (drivers, fit.parameters.len() - 1);
    let levels: Vec<f64> = (0..drivers).map(|k| fit.parameters[k]).collect();
    let level = levels.iter().sum::<f64>() / drivers as f64;
    let residual_sd = fit.parameters[last];
    let df = curves.rows.len().saturating_sub(last);
    let t = t_of_interval(LEVEL, df as f64);
    let error = |k: usize| libm::sqrt(fit.covariance[(k, k)]);
    let around = |b: f64, error: f64, t: f64| [b - t * error, b + t * error];
    let exponent = fit.parameters[slope];
    let clustered = (drivers > 1).then(|| libm::sqrt(fit.clustered_covariance[(slope, slope)]));
    let level_variance = fit.covariance.view((0, 0), (drivers, drivers)).sum();
    let level_error = libm::sqrt(level_variance) / drivers as f64;
    let spread = Spread::of(&levels, &curves.counts());
    CurveSpeedEstimate {
        n: curves.rows.len(),
        exponent,
        exponent_standard_error: Some(error(slope)),
        exponent_ci95: Some(around(exponent, error(slope), t)),
        exponent_clustered_standard_error: clustered,
        exponent_clustered_ci95: clustered
            .map(|error| around(exponent, error, t_of_interval(LEVEL, drivers as f64 - 1.0))),
        reference_speed_mps: libm::exp(level),
        reference_speed_ci95: around(level, level_error, t).map(libm::exp),
        reference_speed_log_standard_error: level_error,
        reference_speed_log_clustered_standard_error: spread
            .map(|spread| spread.sd / libm::sqrt(drivers as f64)),
        driver_sd: spread.map(|spread| spread.sd),
        driver_sd_weighted: spread.map(|spread| spread.weighted),
        driver_share: spread.map(|spread| spread.share(residual_sd)),
        direction_effect: direction.then(|| fit.parameters[slope + 1]),
        direction_effect_ci95: direction
            .then(|| around(fit.parameters[slope + 1], error(slope + 1), t)),
        residual_sd,
        residual_sd_ci95: Some(around(residual_sd, error(last), t)),
        residual_df: df,
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
            let found = fit(&table(unknown), &CurveSpeedOptions::default()).unwrap();
            let tobit = found.tobit.unwrap();
            let error = tobit.exponent_standard_error.unwrap();
            assert!((tobit.exponent - 0.5).abs() < 4.0 * error && error < 0.02, "{tobit:?}");
            assert_eq!(tobit.n, 400);
            assert!(found.below_limit.unwrap().n < 400 && found.at_limit.unwrap() < 400);
            let message = "200 of 600 curves have no known speed limit";
            assert!(
                found.warnings.iter().any(|text| text.contains(message)),
                "{:?}",
                found.warnings
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
        let found = fit(&none, &CurveSpeedOptions::default()).unwrap();
        assert_eq!((found.tobit, found.at_limit, found.below_limit), (None, None, None));
        let message = "no curve has a known speed limit";
        assert!(found.warnings.iter().any(|text| text.contains(message)), "{:?}", found.warnings);
    }
}
