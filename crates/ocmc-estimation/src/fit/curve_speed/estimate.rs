//! The regression with drivers and directions as fixed effects, and its estimates with their
//! intervals.

use super::curves::{Curve, Curves};
use super::drivers::RandomEffects;
use super::{Coding, CurveSpeedFitError, LEVEL};
use crate::fit::absorbed::{Absorbed, Combination};
use crate::fit::analysis_of_variance::{VarianceRow, rows};
use crate::fit::cluster_robust::{Cluster, ClusterMoves, ClusteredError, with_correlation};
use crate::fit::least_squares::Collinear;
use crate::fit::p_value::{NORMAL_975, around, ln_t_tails, sd_interval, t_of_interval};
use crate::moments::Moments;
use nalgebra::DVector;
use serde::Serialize;

/// Fewest drivers that say something of the exponent's error for an interval by drivers.
const FEWEST_DRIVERS: usize = 3;

/// Estimates of one model. Effects are those of ln v, so that 0.05 is about 5 %.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CurveSpeedEstimate {
    /// Curves that take part.
    pub n: usize,
    /// Exponent δ.
    pub exponent: f64,
    /// Standard error of δ with independent curves; none where δ is fixed.
    pub exponent_standard_error: Option<f64>,
    /// 95 % interval of δ with independent curves.
    pub exponent_ci95: Option<[f64; 2]>,
    /// Standard error of δ with the curves of a driver as one observation.
    pub exponent_clustered_standard_error: Option<f64>,
    /// 95 % interval of δ with the curves of a driver as one observation; that of the mixed model
    /// where fewer than three drivers say something of δ.
    pub exponent_clustered_ci95: Option<[f64; 2]>,
    /// Degrees of freedom of that.
    pub exponent_clustered_degrees: Option<f64>,
    /// Speed v₀ at the reference radius, in m/s: the unweighted mean over drivers in ln v.
    pub reference_speed_mps: f64,
    /// 95 % interval of v₀ for these drivers, in m/s.
    pub reference_speed_ci95: [f64; 2],
    /// Standard error of ln v₀ for these drivers.
    pub reference_speed_log_standard_error: f64,
    /// Standard error of ln v₀ for the drivers that these stand for: with the curves of a driver as
    /// one observation, the error of the exponent included.
    pub reference_speed_log_clustered_standard_error: Option<f64>,
    /// Correlation of the errors of δ and ln v₀ with the curves of a driver as one observation.
    pub error_correlation: Option<f64>,
    /// Sample SD of the drivers' effects, each counted once; none with one driver.
    pub driver_sd: Option<f64>,
    /// SD between drivers without the error of each effect, by REML of the effects with their
    /// errors; only of the censored regression, for the others have `random_intercept`.
    pub driver_sd_corrected: Option<f64>,
    /// Its 95 % interval by the profile likelihood.
    pub driver_sd_corrected_ci95: Option<[f64; 2]>,
    /// SD of the drivers' effects with each counted as often as it has curves.
    pub driver_sd_weighted: Option<f64>,
    /// Share of the variance of ln v at one radius that lies between drivers: SD(α)² / (SD(α)² +
    /// SD(e)²).
    pub driver_share: Option<f64>,
    /// Direction effect β, + for left and − for right; none where it is left out.
    pub direction_effect: Option<f64>,
    /// 95 % interval of β.
    pub direction_effect_ci95: Option<[f64; 2]>,
    /// Standard deviation of the residual.
    pub residual_sd: f64,
    /// 95 % interval of the residual's standard deviation.
    pub residual_sd_ci95: Option<[f64; 2]>,
    /// Degrees of freedom of the residual.
    pub residual_df: usize,
}

impl CurveSpeedEstimate {
    /// Whether too few drivers say something of the exponent's error for an interval by drivers.
    pub(super) fn lacks_clusters(&self) -> bool {
        self.exponent_standard_error.is_some() && self.exponent_clustered_ci95.is_none()
    }

    /// The same with the mixed model's errors of exponent and level as those by drivers.
    pub(super) fn with_errors_of(self, mixed: &RandomEffects) -> Self {
        let (error, df) = (mixed.exponent_standard_error, self.residual_df as f64);
        Self {
            exponent_clustered_standard_error: Some(error),
            exponent_clustered_ci95: Some(around(mixed.exponent, error, t_of_interval(LEVEL, df))),
            exponent_clustered_degrees: Some(df),
            reference_speed_log_clustered_standard_error: Some(
                mixed.reference_speed_log_standard_error,
            ),
            ..self
        }
    }

    /// Errors of the exponent and of ln v₀ as a study has them: those by drivers where they are
    /// given, each as the error whose 1.96 are half of the 95 % interval.
    pub(super) fn written_errors(&self, drivers: usize) -> [f64; 2] {
        let df = self.residual_df as f64;
        let half = |[low, high]: [f64; 2]| (high - low) / 2.0;
        let exponent = self.exponent_clustered_ci95.or(self.exponent_ci95).map_or(0.0, half);
        let level = match self.reference_speed_log_clustered_standard_error {
            Some(error) => error * t_of_interval(LEVEL, drivers as f64 - 1.0),
            None => self.reference_speed_log_standard_error * t_of_interval(LEVEL, df),
        };
        [exponent, level].map(|half| half / NORMAL_975)
    }
}

/// Test of one value of the exponent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExponentTest {
    /// The value.
    pub exponent: f64,
    /// t with independent curves.
    pub t: f64,
    /// Its degrees of freedom.
    pub df: usize,
    /// P(|T| > |t|), 0 where it is below the smallest number.
    pub p: f64,
    /// ln p.
    pub ln_p: f64,
    /// t with the curves of a driver as one observation.
    pub t_clustered: Option<f64>,
    /// ln p of it, with the degrees of freedom of its 95 % interval.
    pub ln_p_clustered: Option<f64>,
}

/// One coefficient of the regression.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coefficient {
    /// Name, as `driver D1`.
    pub name: String,
    /// Estimate.
    pub estimate: f64,
    /// Standard error.
    pub standard_error: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
    /// ln P(|T| > |t|) of no effect.
    pub ln_p: f64,
}

/// Effect of one driver.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriverEffect {
    /// Name.
    pub driver: String,
    /// Curves.
    pub n: usize,
    /// Deviation of ln v from the mean over drivers.
    pub effect: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
}

/// A fitted regression: a level for each driver, the exponent where it is estimated, and the
/// direction where it is kept.
#[derive(Clone, Debug)]
pub(super) struct Regression {
    /// The exponent, where it is not estimated.
    fixed_exponent: Option<f64>,
    pub direction: bool,
    fit: Absorbed,
}

/// The columns of a curve: ln R − ln R₀, and ±1 for the direction.
fn columns(curve: &Curve, row: &mut [f64]) {
    row[0] = curve.log_radius;
    if let Some(direction) = row.get_mut(1) {
        *direction = if curve.left { 1.0 } else { -1.0 };
    }
}

impl Regression {
    /// Fits all terms. A direction that the curves do not determine is left out, with a warning.
    pub(super) fn new(
        curves: &Curves,
        mut direction: bool,
        warnings: &mut Vec<String>,
    ) -> Result<Self, CurveSpeedFitError> {
        let (n, drivers) = (curves.rows.len(), curves.drivers.len());
        let first = curves.rows[0].log_radius;
        if curves.rows.iter().all(|curve| curve.log_radius == first) {
            return Err(CurveSpeedFitError::OneRadius);
        }
        let left = curves.rows.iter().filter(|curve| curve.left).count();
        if direction && (left == 0 || left == n) {
            warnings
                .push("all curves turn the same way: nothing is known about the direction".into());
            direction = false;
        }
        loop {
            let width = 1 + usize::from(direction);
            if n <= drivers + width {
                let needed = drivers + width + 1;
                return Err(CurveSpeedFitError::TooFewCurves { curves: n, drivers, needed });
            }
            let fit = Absorbed::reduce(n, width, drivers, |k, row| {
                columns(&curves.rows[k], row);
                (curves.rows[k].driver, curves.rows[k].log_speed)
            });
            match fit {
                Ok(fit) => return Ok(Self { fixed_exponent: None, direction, fit }),
                Err(Collinear { column: 1 }) => {
                    warnings.push("every driver drove one direction only: it is left out".into());
                    direction = false;
                }
                Err(_) if drivers == 1 => return Err(CurveSpeedFitError::OneRadius),
                Err(_) => return Err(CurveSpeedFitError::RadiusOfDriver),
            }
        }
    }

    /// The table of the analysis of variance in the order of the paper's, each term beside those
    /// above it.
    pub(super) fn sequential(&self) -> Vec<VarianceRow> {
        self.table(
            self.fit.sum_sq_without_groups(0),
            self.fit.sum_sq_of_groups(&[0]),
            self.direction.then(|| self.fit.sum_sq_beside_groups(1)),
        )
    }

    /// The same with each term beside all others.
    pub(super) fn marginal(&self) -> Vec<VarianceRow> {
        let all: Vec<usize> = (0..self.fit.width()).collect();
        let turned: Vec<usize> = all.iter().rev().copied().collect();
        self.table(
            self.fit.with_columns(&turned).sum_sq_beside_groups(all.len() - 1),
            self.fit.sum_sq_of_groups(&all),
            self.direction.then(|| self.fit.sum_sq_beside_groups(1)),
        )
    }

    fn table(&self, radius: f64, driver: f64, direction: Option<f64>) -> Vec<VarianceRow> {
        let drivers = self.fit.groups();
        let mut terms = vec![("radius", 1, radius)];
        if drivers > 1 {
            terms.push(("driver", drivers - 1, driver));
        }
        terms.extend(direction.map(|direction| ("direction", 1, direction)));
        rows(terms, self.fit.residual_df(), self.fit.residual_sum_sq)
    }

    /// The same with or without the direction.
    pub(super) fn with_direction(&self, direction: bool) -> Self {
        if direction == self.direction {
            return self.clone();
        }
        Self { direction: false, fit: self.fit.with_columns(&[0]), ..*self }
    }

    /// The same with the exponent fixed.
    pub(super) fn with_exponent(&self, exponent: f64) -> Self {
        let fit = self.fit.with_fixed(0, exponent);
        Self { fixed_exponent: Some(exponent), fit, ..*self }
    }

    /// The column of the direction.
    fn direction_column(&self) -> usize {
        self.fit.width() - 1
    }

    /// A combination of one coefficient alone, or of none.
    fn unit(&self, column: Option<usize>) -> Vec<f64> {
        (0..self.fit.width()).map(|j| f64::from(Some(j) == column)).collect()
    }

    /// The effect of a driver: its level less the mean of all levels.
    fn effect(&self, driver: usize) -> Combination {
        let every = -1.0 / self.fit.groups() as f64;
        Combination { every, groups: vec![(driver, 1.0)], columns: self.unit(None) }
    }

    pub(super) fn estimate(&self, curves: &Curves) -> CurveSpeedEstimate {
        let (coefficients, df) = (self.fit.coefficients(), self.fit.residual_df());
        let residual_sd = self.fit.residual_sd();
        let gram = self.fit.inverse_gram();
        let value_and_error = |column: usize| {
            (coefficients[column], libm::sqrt(gram[(column, column)]) * residual_sd)
        };
        let drivers = self.fit.groups();
        let estimated = self.fixed_exponent.is_none().then(|| value_and_error(0));
        let clustered = (drivers > 1).then(|| self.clustered_errors(curves));
        let every = 1.0 / drivers as f64;
        let mean = Combination { every, groups: Vec::new(), columns: self.unit(None) };
        Determined {
            df,
            level: self.fit.combine([mean]).next().unwrap_or((f64::NAN, f64::NAN)),
            exponent: self.fixed_exponent.unwrap_or_else(|| coefficients[0]),
            exponent_error: estimated.map(|exponent| exponent.1),
            clustered: estimated.and(clustered).and_then(|(exponent, _)| exponent),
            level_clustered: clustered.map(|(_, level)| level),
            direction: self.direction.then(|| value_and_error(self.direction_column())),
            effects: self.fit.levels().as_slice(),
            residual_sd,
        }
        .estimate(curves)
    }

    /// Errors of the first coefficient and of the mean level with the curves of a driver as one
    /// observation, that of the level with the correlation of the two. It is SD(α)/√G where the
    /// coefficients do not move it.
    fn clustered_errors(&self, curves: &Curves) -> (Option<ClusteredError>, (f64, f64)) {
        let (width, groups) = (self.fit.width(), self.fit.groups());
        let (levels, coefficients) = (self.fit.levels(), self.fit.coefficients());
        let means: Vec<DVector<f64>> =
            (0..groups).map(|group| DVector::from_vec(self.fit.group_mean(group))).collect();
        let mut clusters = vec![Cluster::nothing(width); groups];
        let mut row = vec![0.0; 1 + usize::from(self.direction)];
        // without a free exponent its column is known and the direction stands first
        let free = row.len() - width;
        for curve in &curves.rows {
            columns(curve, &mut row);
            let group = curve.driver;
            let x = DVector::from_column_slice(&row[free..]);
            let known = self.fixed_exponent.map_or(0.0, |exponent| exponent * curve.log_radius);
            let residual = curve.log_speed - known - levels[group] - x.dot(&coefficients);
            clusters[group].add(&(x - &means[group]), residual);
        }
        let moves = if width > 0 { ClusterMoves::of(&clusters) } else { None };
        let count = groups as f64;
        let mean_level = levels.sum() / count;
        let mean = means.iter().fold(DVector::zeros(width), |sum, means| sum + means) / count;
        let of_level = (0..groups).map(|group| {
            let own = (levels[group] - mean_level) / count * libm::sqrt(count / (count - 1.0));
            let moved = moves.as_ref().map(|moves| &moves.moves[group]);
            let through = moved.map_or(0.0, |moved| mean.dot(moved));
            (own - through, moved.map_or(0.0, |moved| moved[0]))
        });
        let first = DVector::from_fn(width, |j, _| f64::from(j == 0));
        let of_exponent = moves.as_ref().map(|moves| moves.error_of(&first));
        (of_exponent, with_correlation(of_level))
    }

    /// The coefficients as they are listed.
    pub(super) fn coefficients(&self, curves: &Curves, coding: Coding) -> Vec<Coefficient> {
        let drivers = self.fit.groups();
        let treatment = coding == Coding::Treatment;
        let direction = self.direction.then(|| self.direction_column());
        let level = if treatment {
            let columns = self.unit(direction);
            Combination { every: 0.0, groups: vec![(0, 1.0)], columns }
        } else {
            let every = 1.0 / drivers as f64;
            Combination { every, groups: Vec::new(), columns: self.unit(None) }
        };
        let coefficient =
            |column| Combination { columns: self.unit(column), ..Combination::default() };
        let mut listed = vec![
            ("ln reference speed".to_owned(), level),
            ("exponent".to_owned(), coefficient(Some(0))),
        ];
        // one driver alone has no effect
        let first = usize::from(treatment || drivers == 1);
        for (driver, name) in curves.drivers.iter().enumerate().skip(first) {
            let effect = if treatment {
                let groups = vec![(driver, 1.0), (0, -1.0)];
                Combination { groups, ..coefficient(None) }
            } else {
                self.effect(driver)
            };
            listed.push((format!("driver {name}"), effect));
        }
        if direction.is_some() {
            let mut side = coefficient(direction);
            if treatment {
                side.columns.iter_mut().for_each(|weight| *weight *= -2.0);
            }
            let name = if treatment { "direction right" } else { "direction left" };
            listed.push((name.to_owned(), side));
        }
        let df = self.fit.residual_df() as f64;
        let t = t_of_interval(LEVEL, df);
        let (names, combinations): (Vec<String>, Vec<Combination>) = listed.into_iter().unzip();
        let combined = self.fit.combine(combinations);
        let as_coefficient =
            |(name, (estimate, standard_error)): (String, (f64, f64))| Coefficient {
                name,
                estimate,
                standard_error,
                ci95: around(estimate, standard_error, t),
                ln_p: ln_t_tails(estimate / standard_error, df),
            };
        names.into_iter().zip(combined).map(as_coefficient).collect()
    }

    /// Effect of each driver.
    pub(super) fn driver_effects(&self, curves: &Curves) -> Vec<DriverEffect> {
        let t = t_of_interval(LEVEL, self.fit.residual_df() as f64);
        let effects = self.fit.combine((0..self.fit.groups()).map(|driver| self.effect(driver)));
        let named = curves.drivers.iter().zip(curves.counts()).zip(effects);
        let effect = |((driver, n), (effect, standard_error)): ((&String, usize), (f64, f64))| {
            DriverEffect {
                driver: driver.clone(),
                n,
                effect,
                standard_error,
                ci95: around(effect, standard_error, t),
            }
        };
        named.map(effect).collect()
    }
}

/// Estimates that a regression with levels of drivers determines, with their standard errors.
pub(super) struct Determined<'a> {
    /// Degrees of freedom of the residual.
    pub df: usize,
    /// ln v₀.
    pub level: (f64, f64),
    pub exponent: f64,
    pub exponent_error: Option<f64>,
    /// Error of the exponent with the curves of a driver as one observation.
    pub clustered: Option<ClusteredError>,
    /// Standard error of ln v₀ by drivers, and the correlation of the two errors.
    pub level_clustered: Option<(f64, f64)>,
    pub direction: Option<(f64, f64)>,
    /// Effects of the drivers, up to a common number.
    pub effects: &'a [f64],
    pub residual_sd: f64,
}

impl Determined<'_> {
    pub(super) fn estimate(self, curves: &Curves) -> CurveSpeedEstimate {
        let Self { df, level, exponent, exponent_error, residual_sd, .. } = self;
        let clustered = self.clustered.filter(|error| error.informative >= FEWEST_DRIVERS);
        let fixed_or_clustered = exponent_error.is_none() || clustered.is_some();
        let level_clustered = self.level_clustered.filter(|_| fixed_or_clustered);
        let t = t_of_interval(LEVEL, df as f64);
        let spread = Spread::of(self.effects, &curves.counts());
        CurveSpeedEstimate {
            n: curves.rows.len(),
            exponent,
            exponent_standard_error: exponent_error,
            exponent_ci95: exponent_error.map(|error| around(exponent, error, t)),
            exponent_clustered_standard_error: clustered.map(|error| error.standard_error),
            exponent_clustered_ci95: clustered.map(|error| {
                around(exponent, error.standard_error, t_of_interval(LEVEL, error.degrees))
            }),
            exponent_clustered_degrees: clustered.map(|error| error.degrees),
            reference_speed_mps: libm::exp(level.0),
            reference_speed_ci95: around(level.0, level.1, t).map(libm::exp),
            reference_speed_log_standard_error: level.1,
            reference_speed_log_clustered_standard_error: level_clustered.map(|(error, _)| error),
            error_correlation: level_clustered.filter(|_| clustered.is_some()).map(|(_, r)| r),
            driver_sd: spread.map(|spread| spread.sd),
            driver_sd_corrected: None,
            driver_sd_corrected_ci95: None,
            driver_sd_weighted: spread.map(|spread| spread.weighted),
            driver_share: spread.map(|spread| spread.share(residual_sd)),
            direction_effect: self.direction.map(|(effect, _)| effect),
            direction_effect_ci95: self.direction.map(|(effect, error)| around(effect, error, t)),
            residual_sd,
            residual_sd_ci95: sd_interval(residual_sd, df as f64, LEVEL),
            residual_df: df,
        }
    }
}

/// How drivers' effects spread.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    pub sd: f64,
    pub weighted: f64,
}

impl Spread {
    /// Spread of effects, with the number of curves of each; none with one driver.
    pub(super) fn of(effects: &[f64], counts: &[usize]) -> Option<Self> {
        if effects.len() < 2 {
            return None;
        }
        let curves: f64 = counts.iter().map(|&count| count as f64).sum();
        let weighted = |value: &dyn Fn(f64) -> f64| {
            let rows = effects.iter().zip(counts);
            rows.map(|(&effect, &count)| value(effect) * count as f64).sum::<f64>() / curves
        };
        let centre = weighted(&|effect| effect);
        let spread = weighted(&|effect| (effect - centre) * (effect - centre));
        Some(Self { sd: Moments::of(effects).sd(), weighted: libm::sqrt(spread) })
    }

    /// Share of the variance between drivers.
    pub(super) fn share(self, residual_sd: f64) -> f64 {
        let between = self.sd * self.sd;
        between / (between + residual_sd * residual_sd)
    }
}

/// Tests one value of the exponent.
pub(super) fn exponent_test(estimate: &CurveSpeedEstimate, exponent: f64) -> ExponentTest {
    let off = estimate.exponent - exponent;
    let t = estimate.exponent_standard_error.map_or(f64::NAN, |error| off / error);
    let ln_p = ln_t_tails(t, estimate.residual_df as f64);
    let t_clustered = estimate.exponent_clustered_standard_error.map(|error| off / error);
    ExponentTest {
        exponent,
        t,
        df: estimate.residual_df,
        p: libm::exp(ln_p),
        ln_p,
        t_clustered,
        ln_p_clustered: t_clustered
            .zip(estimate.exponent_clustered_degrees)
            .map(|(t, degrees)| ln_t_tails(t, degrees)),
    }
}
