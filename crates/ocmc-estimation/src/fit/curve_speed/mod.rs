//! Curve speed from measured curves: the regression and the analysis of variance of the paper, and
//! what stands beside them.
//!
//! ln v = ln v₀ + δ (ln R − ln R₀) + α_driver + β_direction + e, Σ α = 0, β = + for left and − for
//! right.
//!
//! - the table of the analysis of variance, of the model with all terms;
//! - the model with the direction kept where it is significant (`estimated`), and with δ fixed
//!   (`fixed`);
//! - the regression of each driver alone;
//! - drivers as random effects (REML), with the share of the variance that they explain;
//! - the censored regression at known speed limits (Tobit). Where a driver keeps to the limit, the
//!   curve only shows that the driver would take it at least that fast. Leaving such curves out
//!   instead cuts the response off and bends δ; the fit of the slow curves alone is given as a
//!   diagnostic.
//!
//! ln v₀ is the unweighted mean over drivers (sum-to-zero coding), and SD(α) the sample SD of the
//! drivers' effects. Beside it stands the SD over curves, in which a driver counts as often as it
//! has curves.
//!
//! Source: Romano, Godio, Bruzelius, Johannesson, the paper in hand. The clustered errors take the
//! curves of one driver as one observation (`cluster_robust.rs`): those of the paper take all
//! curves as independent.

mod curves;
mod drivers;
mod estimate;
mod limited;

pub use curves::{CurveTable, Dropped};
pub use drivers::{DriverFit, DriverSpread, RandomEffects};
pub use estimate::{Coefficient, CurveSpeedEstimate, DriverEffect, ExponentTest};

use super::analysis_of_variance::VarianceRow;
use super::p_value::{NORMAL_975, t_of_interval};
use crate::option_check::{OptionError, above_0, check_options};
use curves::select;
use estimate::Regression;
use ocmc_core::driver::curve_speed::{CurveSpeedForm, CurveSpeedModel, CurveSpeedTable};
use serde::Serialize;
use thiserror::Error;

/// Level of all intervals.
pub const LEVEL: f64 = 0.95;

/// Law to fit, and the curves for it.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveSpeedOptions {
    /// Reference radius R₀, in m.
    pub reference_radius_m: f64,
    /// Radii that take part, in m.
    pub radius_range_m: [f64; 2],
    /// Routes have to be longer than this, in m, where their lengths are known.
    pub minimum_route_m: f64,
    /// Curves have to lie at least this far from other curves, standstills, and the ends of the
    /// log, in m, and the truck must nowhere near have been slower than in them; none takes all
    /// curves.
    pub isolated_m: Option<f64>,
    /// Curves with a smaller lateral acceleration v²/R are left out, in m/s²; 0 takes all. A
    /// detector that works on lateral acceleration does not see them.
    pub least_lateral_mps2: f64,
    /// The exponent that `fixed` takes, and that is tested.
    pub fixed_exponent: f64,
    /// The direction stays where its p is below this.
    pub significance: f64,
    /// Share of the speed limit from which on a curve counts as driven at the limit.
    pub limit_share: f64,
    /// How the coefficients are listed.
    pub coding: Coding,
}

impl Default for CurveSpeedOptions {
    /// The paper's choices; the share of the limit is ours.
    fn default() -> Self {
        Self {
            reference_radius_m: 250.0,
            radius_range_m: [20.0, 500.0],
            minimum_route_m: 5000.0,
            isolated_m: None,
            least_lateral_mps2: 0.0,
            fixed_exponent: 0.5,
            significance: 0.05,
            limit_share: 0.9,
            coding: Coding::SumToZero,
        }
    }
}

/// How the coefficients of drivers and directions are listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Coding {
    /// As deviations from their unweighted mean.
    SumToZero,
    /// As differences to the first driver and to left curves.
    Treatment,
}

/// Why curves have no fit.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CurveSpeedFitError {
    /// An option out of its range.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// Columns of different lengths.
    #[error("column {column} has {length} values, column driver has {wanted}")]
    UnequalColumns {
        /// The column.
        column: &'static str,
        /// Its length.
        length: usize,
        /// The length of the first column.
        wanted: usize,
    },
    /// Nothing is left.
    #[error("no curve is left of {rows} rows{}", dropped_text(dropped))]
    NoCurves {
        /// Rows that came in.
        rows: usize,
        /// Rows left out, by reason.
        dropped: Dropped,
    },
    /// Fewer curves than the model needs.
    #[error(
        "{curves} curves of {drivers} drivers are too few{}; allowed are {needed} or more of as \
         many drivers",
        one_each(*curves, *drivers)
    )]
    TooFewCurves {
        /// Curves that take part.
        curves: usize,
        /// Drivers that take part.
        drivers: usize,
        /// The smallest number that leaves a degree of freedom for the residual.
        needed: usize,
    },
    /// No two radii differ.
    #[error(
        "all curves have the same radius, so that they tell nothing about the exponent; allowed \
         are two radii or more"
    )]
    OneRadius,
    /// Radius and driver cannot be separated.
    #[error(
        "the radius is the same in all curves of a driver, so that exponent and drivers cannot be \
         separated; allowed are drivers of whom at least one drove two radii"
    )]
    RadiusOfDriver,
    /// Free curves are asked for, and nothing says which are free.
    #[error(
        "nothing says how far the curves are from others: columns gap_before_m and gap_after_m, as \
         `ocmc curves` writes them"
    )]
    NoGaps,
}

/// The reason where each driver has one curve.
fn one_each(curves: usize, drivers: usize) -> &'static str {
    if curves == drivers { ": one curve a driver does not part drivers from curves" } else { "" }
}

/// Reasons and rows in words, such as `: 3 radius_too_large, 1 missing_value`.
fn dropped_text(dropped: &Dropped) -> String {
    let reasons: Vec<String> =
        dropped.iter().map(|(reason, rows)| format!("{rows} {reason}")).collect();
    if reasons.is_empty() { String::new() } else { format!(": {}", reasons.join(", ")) }
}

/// Everything that measured curves determine about curve speeds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CurveSpeedFit {
    /// Curves that take part.
    pub n: usize,
    /// Drivers that take part.
    pub drivers: usize,
    /// Reference radius, in m.
    pub reference_radius_m: f64,
    /// Smallest and largest radius that takes part, in m.
    pub radius_range_m: [f64; 2],
    /// Radii that were asked for, in m.
    pub radius_filter_m: [f64; 2],
    /// Rows left out, by reason.
    pub dropped: Dropped,
    /// Facts that do not stop the fit and have to be known.
    pub warnings: Vec<String>,
    /// Analysis of variance with sequential sums of squares, of the model with all terms.
    pub anova: Vec<VarianceRow>,
    /// The same with marginal sums of squares.
    pub anova_marginal: Vec<VarianceRow>,
    /// The model with the direction only where it is significant.
    pub estimated: CurveSpeedEstimate,
    /// The same terms with the exponent fixed.
    pub fixed: CurveSpeedEstimate,
    /// The model with the direction, where directions are known.
    pub with_direction: Option<CurveSpeedEstimate>,
    /// Test of the fixed exponent.
    pub exponent_test: ExponentTest,
    /// How the coefficients are listed.
    pub coding: Coding,
    /// Coefficients of `estimated`.
    pub coefficients: Vec<Coefficient>,
    /// Effect of each driver in `estimated`.
    pub driver_effects: Vec<DriverEffect>,
    /// The regression of each driver alone.
    pub by_driver: Vec<DriverFit>,
    /// How the drivers' own regressions spread.
    pub between_drivers: Option<DriverSpread>,
    /// Drivers as random levels.
    pub random_intercept: Option<RandomEffects>,
    /// Drivers as random levels and exponents.
    pub random_slope: Option<RandomEffects>,
    /// The regression that takes curves at the limit as censored, where limits are known.
    pub tobit: Option<CurveSpeedEstimate>,
    /// Curves that count as driven at the limit.
    pub at_limit: Option<usize>,
    /// Diagnostic only: the regression of the curves below the limit. It cuts the response off.
    pub below_limit: Option<CurveSpeedEstimate>,
}

/// Fits curve speeds.
///
/// # Errors
/// [`CurveSpeedFitError`] says what the curves lack.
pub fn fit(
    table: &CurveTable,
    options: &CurveSpeedOptions,
) -> Result<CurveSpeedFit, CurveSpeedFitError> {
    check(options)?;
    let (curves, dropped) = select(table, options)?;
    let mut warnings = Vec::new();
    let full = Regression::new(&curves, table.left.is_some(), &mut warnings)?;
    let anova = full.sequential();
    let kept = full.direction
        && anova.iter().any(|row| {
            row.term == "direction"
                && row.ln_p.is_some_and(|ln_p| ln_p < libm::log(options.significance))
        });
    let chosen = full.with_direction(kept);
    let fixed = chosen.with_exponent(options.fixed_exponent);
    if curves.drivers.len() == 1 {
        warnings.push(
            "there is one driver only: how drivers differ is not determined, `driver_sd` stays \
             that of the base study"
                .into(),
        );
    }
    let mut estimated = chosen.estimate(&curves);
    let exponent_test = estimate::exponent_test(&estimated, options.fixed_exponent);
    let by_driver = drivers::by_driver(&curves, options.reference_radius_m, &mut warnings);
    let (random_intercept, random_slope) = drivers::random_effects(&curves, kept, &mut warnings);
    if let Some(mixed) = random_intercept.as_ref().filter(|_| estimated.lacks_clusters()) {
        warnings.push(
            "fewer than three drivers say something of how well the exponent is known: its \
             interval by drivers is that of the mixed model (REML), which takes the exponent as \
             one for all"
                .into(),
        );
        estimated = estimated.with_errors_of(mixed);
    }
    let limits = table.limit_mps.is_some();
    let limited = limits.then(|| limited::limited(&curves, kept, options, &mut warnings));
    let (tobit, at_limit, below_limit) = limited.unwrap_or_default();
    Ok(CurveSpeedFit {
        n: curves.rows.len(),
        drivers: curves.drivers.len(),
        reference_radius_m: options.reference_radius_m,
        radius_range_m: [curves.smallest_radius_m, curves.largest_radius_m],
        radius_filter_m: options.radius_range_m,
        dropped,
        anova_marginal: full.marginal(),
        anova,
        fixed: fixed.estimate(&curves),
        with_direction: full.direction.then(|| full.estimate(&curves)),
        exponent_test,
        coding: options.coding,
        coefficients: chosen.coefficients(&curves, options.coding),
        driver_effects: chosen.driver_effects(&curves),
        between_drivers: drivers::spread(&by_driver),
        estimated,
        by_driver,
        random_intercept,
        random_slope,
        tobit,
        at_limit,
        below_limit,
        warnings,
    })
}

fn check(options: &CurveSpeedOptions) -> Result<(), CurveSpeedFitError> {
    let [smallest, largest] = options.radius_range_m;
    let (route_m, exponent) = (options.minimum_route_m, options.fixed_exponent);
    let share = |option, share: f64| {
        (option, share, "a number above 0 and up to 1", share > 0.0 && share <= 1.0)
    };
    let isolated_m = options.isolated_m.unwrap_or(0.0);
    let (wider, lateral_mps2) = (largest > smallest, options.least_lateral_mps2);
    let lateral = "the smallest lateral acceleration, in m/s²,";
    Ok(check_options([
        above_0("the reference radius", options.reference_radius_m),
        ("the smallest radius", smallest, "a number from 0 on", smallest >= 0.0),
        ("the largest radius", largest, "a number above the smallest radius", wider),
        ("the way around a free curve, in m,", isolated_m, "a number from 0 on", isolated_m >= 0.0),
        (lateral, lateral_mps2, "a number from 0 on", lateral_mps2 >= 0.0),
        ("the shortest route", route_m, "a number from 0 on", route_m >= 0.0),
        ("the fixed exponent", exponent, "a number", exponent.is_finite()),
        share("the significance", options.significance),
        share("the share of the limit", options.limit_share),
    ])?)
}

impl CurveSpeedFit {
    /// The population of drivers as a study has it: that of the `censored` regression where it is
    /// given, otherwise that of `estimated`, both with the spread between drivers by REML. What
    /// curves do not determine (the guard's lateral acceleration, the uncertainty switch, the
    /// replicates, with one driver the spread between drivers) stays as it is in `model`.
    pub fn population(
        &self,
        censored: Option<&CurveSpeedEstimate>,
        model: &CurveSpeedModel,
    ) -> CurveSpeedModel {
        let best = censored.unwrap_or(&self.estimated);
        // the sample SD of the effects holds the error of each of them, too
        let reml = self.random_intercept.as_ref().filter(|_| censored.is_none());
        let reml = reml.map(|drivers| drivers.driver_sd).or(best.driver_sd_corrected);
        let driver_sd = reml.or(best.driver_sd);
        // drivers whose curves show no exponents of their own have one
        let slope = self.random_slope.as_ref();
        let of_slope = |number: fn(&RandomEffects) -> Option<f64>| {
            slope.map(|drivers| if drivers.singular { 0.0 } else { number(drivers).unwrap_or(0.0) })
        };
        let exponent_sd = of_slope(|drivers| drivers.exponent_sd);
        let driver_correlation = of_slope(|drivers| drivers.correlation);
        let fitted = self.by_driver.iter().filter(|driver| driver.exponent.is_some());
        let table = CurveSpeedTable {
            truck: fitted.clone().map(|driver| driver.driver.clone()).collect(),
            exponent: fitted.clone().filter_map(|driver| driver.exponent).collect(),
            reference_speed_mps: fitted.filter_map(|driver| driver.reference_speed_mps).collect(),
        };
        let [exponent_error, log_error] = best.written_errors(self.drivers);
        // where curves stop to limit the speed: as asked for, for no curve shows it
        let [_, asked] = self.radius_filter_m;
        let [smallest, largest] = self.radius_range_m;
        CurveSpeedModel {
            form: CurveSpeedForm::Pooled,
            reference_radius_m: self.reference_radius_m,
            reference_speed_mps: best.reference_speed_mps,
            exponent: best.exponent,
            exponent_standard_error: exponent_error,
            reference_speed_log_standard_error: log_error,
            error_correlation: best.error_correlation.unwrap_or(0.0),
            parameter_uncertainty: true,
            driver_sd: driver_sd.unwrap_or(model.driver_sd),
            exponent_sd: exponent_sd.unwrap_or(model.exponent_sd),
            driver_correlation: driver_correlation.unwrap_or(model.driver_correlation),
            direction_effect: best.direction_effect.unwrap_or(0.0),
            residual_sd: best.residual_sd,
            maximum_radius_m: if asked.is_finite() { asked } else { largest },
            guard_radius_m: smallest,
            table: (table.truck.len() >= 3).then_some(table),
            ..model.clone()
        }
    }

    /// Standard errors of the other numbers of a population, each with its key and the number: half
    /// of a 95 % interval over its quantile, and s / √(2 df) of the residual's SD s.
    pub fn errors_of(
        &self,
        population: &CurveSpeedModel,
        censored: Option<&CurveSpeedEstimate>,
    ) -> Vec<(&'static str, f64, f64)> {
        let best = censored.unwrap_or(&self.estimated);
        let df = best.residual_df as f64;
        let half = |[low, high]: [f64; 2]| (high - low) / 2.0;
        let reml = self.random_intercept.as_ref().filter(|_| censored.is_none());
        let between = reml.map_or(best.driver_sd_corrected_ci95, |drivers| drivers.driver_sd_ci95);
        let direction = best.direction_effect_ci95.map(|ci95| half(ci95) / t_of_interval(0.95, df));
        let residual = (df > 0.0).then(|| best.residual_sd / libm::sqrt(2.0 * df));
        let errors = [
            ("driver_sd", population.driver_sd, between.map(|ci95| half(ci95) / NORMAL_975)),
            ("direction_effect", population.direction_effect, direction),
            ("residual_sd", population.residual_sd, residual),
        ];
        let known = errors.into_iter().filter_map(|(key, value, error)| Some((key, value, error?)));
        known.filter(|(.., error)| error.is_finite()).collect()
    }
}
