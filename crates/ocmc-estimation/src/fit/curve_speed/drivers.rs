//! Drivers one by one, and drivers as a population.

use super::LEVEL;
use super::curves::Curves;
use crate::fit::mixed_model::{GroupedRows, MixedFit};
use crate::fit::p_value::{around, t_of_interval};
use ocmc_core::driver::curve_speed::Bivariate;
use serde::Serialize;

/// The regression of one driver: ln v = ln v₀ + δ (ln R − ln R₀) + e.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriverFit {
    /// Name.
    pub driver: String,
    /// Curves.
    pub n: usize,
    /// Exponent; none with fewer than three curves or one radius.
    pub exponent: Option<f64>,
    /// Its standard error.
    pub exponent_standard_error: Option<f64>,
    /// Its 95 % interval.
    pub exponent_ci95: Option<[f64; 2]>,
    /// Speed at the reference radius, in m/s.
    pub reference_speed_mps: Option<f64>,
    /// Standard error of its logarithm.
    pub reference_speed_log_standard_error: Option<f64>,
    /// Residual standard deviation.
    pub residual_sd: Option<f64>,
    /// Share of the variance of ln v that the radius explains.
    pub r_squared: Option<f64>,
}

/// How the drivers' own regressions spread, each driver counted once.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriverSpread {
    /// Drivers that have a regression.
    pub drivers: usize,
    /// Mean exponent.
    pub exponent_mean: f64,
    /// Sample SD of the exponents.
    pub exponent_sd: f64,
    /// Standard error of the mean exponent.
    pub exponent_mean_standard_error: f64,
    /// Mean speed at the reference radius, in m/s: of the speeds, not of their logarithms.
    pub reference_speed_mean_mps: f64,
    /// Sample SD of the logarithms of the speeds.
    pub reference_speed_log_sd: f64,
    /// Correlation of exponent and logarithm of the speed.
    pub correlation: f64,
}

/// Drivers as random effects, by REML.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RandomEffects {
    /// Exponent of the typical driver.
    pub exponent: f64,
    /// Its standard error for the drivers that these stand for.
    pub exponent_standard_error: f64,
    /// Speed of the typical driver at the reference radius, in m/s.
    pub reference_speed_mps: f64,
    /// Standard error of its logarithm.
    pub reference_speed_log_standard_error: f64,
    /// SD of the drivers' levels at the reference radius.
    pub driver_sd: f64,
    /// Its 95 % interval by the profile likelihood, where drivers have one exponent.
    pub driver_sd_ci95: Option<[f64; 2]>,
    /// SD of the drivers' exponents; none where they have one.
    pub exponent_sd: Option<f64>,
    /// Correlation of level and exponent.
    pub correlation: Option<f64>,
    /// Direction effect, + for left; none where it is left out.
    pub direction_effect: Option<f64>,
    /// Residual standard deviation.
    pub residual_sd: f64,
    /// Share of the variance between drivers at the reference radius.
    pub driver_share_at_reference: f64,
    /// Share of the variance between drivers, mean over the radii of the curves.
    pub driver_share: f64,
    /// Minus twice the restricted log-likelihood.
    pub reml_criterion: f64,
    /// Whether the drivers' levels, or their exponents beside the levels, have no variance.
    pub singular: bool,
}

/// The regression of each driver alone.
pub(super) fn by_driver(
    curves: &Curves,
    reference_radius_m: f64,
    warnings: &mut Vec<String>,
) -> Vec<DriverFit> {
    let counts = curves.counts();
    let groups = counts.len();
    let (mut mean_x, mut mean_y) = (vec![0.0; groups], vec![0.0; groups]);
    for curve in &curves.rows {
        mean_x[curve.driver] += curve.log_radius / counts[curve.driver] as f64;
        mean_y[curve.driver] += curve.log_speed / counts[curve.driver] as f64;
    }
    let mut products = vec![[0.0; 3]; groups];
    for curve in &curves.rows {
        let g = curve.driver;
        let (x, y) = (curve.log_radius - mean_x[g], curve.log_speed - mean_y[g]);
        for (sum, product) in products[g].iter_mut().zip([x * x, x * y, y * y]) {
            *sum += product;
        }
    }
    let driver_fit =
        |g: usize| line(&curves.drivers[g], counts[g], mean_x[g], mean_y[g], products[g]);
    let fits: Vec<DriverFit> = (0..groups).map(driver_fit).collect();
    let without = fits.iter().filter(|fit| fit.exponent.is_none()).count();
    if without > 0 {
        warnings.push(format!(
            "{without} of {groups} drivers have no regression of their own: fewer than three \
             curves, or one radius"
        ));
    }
    let near = 1.0 + 1e-9;
    if reference_radius_m * near < curves.smallest_radius_m
        || reference_radius_m > curves.largest_radius_m * near
    {
        warnings.push(format!(
            "the reference radius of {reference_radius_m} m lies outside the radii of the curves: \
             the reference speed is extrapolated"
        ));
    }
    fits
}

fn line(driver: &str, n: usize, mean_x: f64, mean_y: f64, [xx, xy, yy]: [f64; 3]) -> DriverFit {
    let determined = n >= 3 && xx > 1e-20 * n as f64;
    let exponent = determined.then_some(xy / xx);
    let df = n as f64 - 2.0;
    let variance = exponent.map(|exponent| ((yy - exponent * xy) / df).max(0.0));
    let error = variance.map(|variance| libm::sqrt(variance / xx));
    let t = t_of_interval(LEVEL, df);
    DriverFit {
        driver: driver.to_owned(),
        n,
        exponent,
        exponent_standard_error: error,
        exponent_ci95: exponent.zip(error).map(|(b, error)| around(b, error, t)),
        reference_speed_mps: exponent.map(|exponent| libm::exp(mean_y - exponent * mean_x)),
        reference_speed_log_standard_error: variance
            .map(|variance| libm::sqrt(variance * (1.0 / n as f64 + mean_x * mean_x / xx))),
        residual_sd: variance.map(libm::sqrt),
        r_squared: exponent.map(|exponent| exponent * xy / yy),
    }
}

/// How the regressions spread; none with fewer than two.
pub(super) fn spread(fits: &[DriverFit]) -> Option<DriverSpread> {
    let fitted = |fit: &DriverFit| Some((fit.exponent?, fit.reference_speed_mps?));
    let pairs: Vec<(f64, f64)> = fits.iter().filter_map(fitted).collect();
    if pairs.len() < 2 {
        return None;
    }
    let n = pairs.len() as f64;
    let logs: Vec<(f64, f64)> = pairs.iter().map(|&(d, v)| (d, libm::log(v))).collect();
    let moments = Bivariate::fit(&logs);
    let (sd, log_sd) =
        (libm::sqrt(moments.covariance[(0, 0)]), libm::sqrt(moments.covariance[(1, 1)]));
    Some(DriverSpread {
        drivers: pairs.len(),
        exponent_mean: moments.mean[0],
        exponent_sd: sd,
        exponent_mean_standard_error: sd / libm::sqrt(n),
        reference_speed_mean_mps: pairs.iter().map(|pair| pair.1).sum::<f64>() / n,
        reference_speed_log_sd: log_sd,
        correlation: moments.covariance[(0, 1)] / (sd * log_sd),
    })
}

/// Random levels, and random levels and exponents; none where the curves do not determine them.
pub(super) fn random_effects(
    curves: &Curves,
    direction: bool,
    warnings: &mut Vec<String>,
) -> (Option<RandomEffects>, Option<RandomEffects>) {
    if curves.drivers.len() < 2 {
        return (None, None);
    }
    let (n, width) = (curves.rows.len(), 2 + usize::from(direction));
    let rows = GroupedRows::reduce(n, width, curves.drivers.len(), |k, x| {
        let curve = &curves.rows[k];
        x[0] = 1.0;
        x[1] = curve.log_radius;
        if direction {
            x[2] = if curve.left { 1.0 } else { -1.0 };
        }
        (curve.driver, curve.log_speed)
    });
    let log_radii = || curves.rows.iter().map(|curve| curve.log_radius);
    let x = log_radii().sum::<f64>() / n as f64;
    let xx = log_radii().map(|x| x * x).sum::<f64>() / n as f64;
    let summary = |fit: &MixedFit| summary(fit, direction, x, xx);
    let intercept = rows.random_intercept().map(|fit| {
        let driver_sd_ci95 = rows.intercept_sd_interval(&fit);
        RandomEffects { driver_sd_ci95, ..summary(&fit) }
    });
    let slope = rows.random_slope().map(|fit| summary(&fit));
    if intercept.as_ref().is_some_and(|fit| fit.singular) {
        warnings.push(
            "the REML fit is singular: drivers differ by no more than their curves do, so that its \
             SD between drivers is 0; that of the table follows from the drivers' means"
                .into(),
        );
    }
    (intercept, slope)
}

fn summary(fit: &MixedFit, direction: bool, x: f64, xx: f64) -> RandomEffects {
    let covariance = &fit.group_covariance;
    let at_reference = covariance[(0, 0)];
    let slope = (covariance.nrows() > 1).then(|| covariance[(1, 1)]);
    let together = slope.map_or(0.0, |_| covariance[(0, 1)]);
    let mean = at_reference + 2.0 * together * x + slope.unwrap_or(0.0) * xx;
    let residual = fit.residual_sd * fit.residual_sd;
    RandomEffects {
        exponent: fit.coefficients[1],
        exponent_standard_error: libm::sqrt(fit.covariance[(1, 1)]),
        reference_speed_mps: libm::exp(fit.coefficients[0]),
        reference_speed_log_standard_error: libm::sqrt(fit.covariance[(0, 0)]),
        driver_sd: libm::sqrt(at_reference),
        driver_sd_ci95: None,
        exponent_sd: slope.map(libm::sqrt),
        correlation: slope.map(|slope| together / libm::sqrt(slope * at_reference)),
        direction_effect: direction.then(|| fit.coefficients[2]),
        residual_sd: fit.residual_sd,
        driver_share_at_reference: at_reference / (at_reference + residual),
        driver_share: mean / (mean + residual),
        reml_criterion: fit.criterion,
        singular: fit.singular,
    }
}
