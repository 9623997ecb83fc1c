//! The regression with drivers and directions as fixed effects, and its estimates with their
//! intervals.

use super::curves::{Curve, Curves};
use super::{Coding, CurveSpeedFitError, LEVEL};
use crate::fit::analysis_of_variance::Term;
use crate::fit::least_squares::{Collinear, LeastSquares};
use crate::fit::p_value::{around, ln_t_tails, sd_interval, t_of_interval};
use crate::moments::Moments;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

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
    /// 95 % interval of δ with the curves of a driver as one observation.
    pub exponent_clustered_ci95: Option<[f64; 2]>,
    /// Speed v₀ at the reference radius, in m/s: the unweighted mean over drivers in ln v.
    pub reference_speed_mps: f64,
    /// 95 % interval of v₀ for these drivers, in m/s.
    pub reference_speed_ci95: [f64; 2],
    /// Standard error of ln v₀ for these drivers.
    pub reference_speed_log_standard_error: f64,
    /// Standard error of ln v₀ for the drivers that these stand for: SD(α) over √drivers.
    pub reference_speed_log_clustered_standard_error: Option<f64>,
    /// Sample SD of the drivers' effects, each counted once; none with one driver.
    pub driver_sd: Option<f64>,
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
    /// ln p of it, with one degree of freedom less than drivers.
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

/// Which terms a regression has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Terms {
    /// The exponent, where it is not estimated.
    pub fixed_exponent: Option<f64>,
    pub drivers: usize,
    pub direction: bool,
}

impl Terms {
    fn width(self) -> usize {
        self.first_driver() + self.drivers - 1 + usize::from(self.direction)
    }

    fn first_driver(self) -> usize {
        1 + usize::from(self.fixed_exponent.is_none())
    }

    fn direction_column(self) -> usize {
        self.first_driver() + self.drivers - 1
    }

    /// The predictors of a curve: 1, ln R − ln R₀, sum-to-zero contrasts of the drivers, ±1 for the
    /// direction.
    fn row(self, curve: &Curve, row: &mut [f64]) {
        row.fill(0.0);
        row[0] = 1.0;
        let first = self.first_driver();
        if first == 2 {
            row[1] = curve.log_radius;
        }
        let contrasts = &mut row[first..first + self.drivers - 1];
        if curve.driver < contrasts.len() {
            contrasts[curve.driver] = 1.0;
        } else {
            contrasts.fill(-1.0);
        }
        if self.direction {
            row[self.direction_column()] = if curve.left { 1.0 } else { -1.0 };
        }
    }
}

/// A fitted regression.
#[derive(Clone, Debug)]
pub(super) struct Regression {
    pub terms: Terms,
    pub fit: LeastSquares,
}

impl Regression {
    /// Fits all terms. A direction that the curves do not determine is left out, with a warning.
    pub(super) fn new(
        curves: &Curves,
        direction: bool,
        warnings: &mut Vec<String>,
    ) -> Result<Self, CurveSpeedFitError> {
        let mut terms = Terms { fixed_exponent: None, drivers: curves.drivers.len(), direction };
        let n = curves.rows.len();
        let first = curves.rows[0].log_radius;
        if curves.rows.iter().all(|curve| curve.log_radius == first) {
            return Err(CurveSpeedFitError::OneRadius);
        }
        let left = curves.rows.iter().filter(|curve| curve.left).count();
        if direction && (left == 0 || left == n) {
            warnings
                .push("all curves turn the same way: nothing is known about the direction".into());
            terms.direction = false;
        }
        loop {
            if n <= terms.width() {
                let (drivers, needed) = (terms.drivers, terms.width() + 1);
                return Err(CurveSpeedFitError::TooFewCurves { curves: n, drivers, needed });
            }
            let fit = LeastSquares::reduce(n, terms.width(), |k, row| {
                terms.row(&curves.rows[k], row);
                curves.rows[k].log_speed
            });
            match fit {
                Ok(fit) => return Ok(Self { terms, fit }),
                Err(Collinear { column })
                    if terms.direction && column == terms.direction_column() =>
                {
                    warnings.push("every driver drove one direction only: it is left out".into());
                    terms.direction = false;
                }
                Err(Collinear { column: 1 }) => return Err(CurveSpeedFitError::OneRadius),
                Err(Collinear { .. }) => return Err(CurveSpeedFitError::RadiusOfDriver),
            }
        }
    }

    /// The terms with their columns, in the order of the paper's table.
    pub(super) fn terms(&self) -> Vec<Term> {
        let Terms { drivers, direction, .. } = self.terms;
        let mut terms = vec![Term { name: "radius", columns: 1..2 }];
        if drivers > 1 {
            terms.push(Term { name: "driver", columns: 2..drivers + 1 });
        }
        if direction {
            terms.push(Term { name: "direction", columns: drivers + 1..drivers + 2 });
        }
        terms
    }

    /// The same with or without the direction.
    pub(super) fn with_direction(&self, direction: bool) -> Self {
        if direction == self.terms.direction {
            return self.clone();
        }
        let terms = Terms { direction: false, ..self.terms };
        let columns: Vec<usize> = (0..terms.width()).collect();
        Self { terms, fit: self.fit.with_columns(&columns) }
    }

    /// The same with the exponent fixed.
    pub(super) fn with_exponent(&self, exponent: f64) -> Self {
        let terms = Terms { fixed_exponent: Some(exponent), ..self.terms };
        Self { terms, fit: self.fit.with_fixed(1, exponent) }
    }

    /// Sum-to-zero effects of all drivers as a linear map of the coefficients.
    fn driver_map(&self) -> DMatrix<f64> {
        let (first, drivers) = (self.terms.first_driver(), self.terms.drivers);
        DMatrix::from_fn(drivers, self.terms.width(), |driver, column| {
            let contrast = column.wrapping_sub(first);
            if contrast >= drivers - 1 {
                0.0
            } else if driver == drivers - 1 {
                -1.0
            } else {
                f64::from(driver == contrast)
            }
        })
    }

    pub(super) fn estimate(&self, curves: &Curves) -> CurveSpeedEstimate {
        let (coefficients, df) = (self.fit.coefficients(), self.fit.residual_df());
        let residual_sd = self.fit.residual_sd();
        let gram = self.fit.inverse_gram();
        let of = |column: usize| {
            (coefficients[column], libm::sqrt(gram[(column, column)]) * residual_sd)
        };
        let estimated = self.terms.fixed_exponent.is_none().then(|| of(1));
        let clustered = (estimated.is_some() && self.terms.drivers > 1)
            .then(|| self.clustered_error(curves, &coefficients, &gram, 1));
        Determined {
            df,
            level: of(0),
            exponent: self.terms.fixed_exponent.unwrap_or_else(|| coefficients[1]),
            exponent_error: estimated.map(|exponent| exponent.1),
            clustered,
            direction: self.terms.direction.then(|| of(self.terms.direction_column())),
            effects: (self.driver_map() * &coefficients).as_slice(),
            residual_sd,
        }
        .estimate(curves)
    }

    /// Standard error of a coefficient with the curves of a driver as one observation: the sandwich
    /// with the factor G/(G − 1) (n − 1)/(n − p).
    fn clustered_error(
        &self,
        curves: &Curves,
        coefficients: &DVector<f64>,
        gram: &DMatrix<f64>,
        column: usize,
    ) -> f64 {
        let (n, width, groups) = (self.fit.rows, self.fit.width(), self.terms.drivers);
        let mut sums = vec![0.0; groups];
        let mut row = vec![0.0; width];
        for curve in &curves.rows {
            self.terms.row(curve, &mut row);
            let (mut residual, mut weight) = (curve.log_speed, 0.0);
            for j in 0..width {
                residual -= row[j] * coefficients[j];
                weight += row[j] * gram[(column, j)];
            }
            sums[curve.driver] += weight * residual;
        }
        let squares: f64 = sums.iter().map(|sum| sum * sum).sum();
        let (n, p, g) = (n as f64, width as f64, groups as f64);
        libm::sqrt(squares * g / (g - 1.0) * (n - 1.0) / (n - p))
    }

    /// The coefficients as they are listed.
    pub(super) fn coefficients(&self, curves: &Curves, coding: Coding) -> Vec<Coefficient> {
        let drivers = self.driver_map();
        let unit =
            |column: usize| DMatrix::from_fn(1, self.terms.width(), |_, j| f64::from(j == column));
        let direction = self.terms.direction.then(|| unit(self.terms.direction_column()));
        let base = drivers.rows(0, 1).into_owned();
        let treatment = coding == Coding::Treatment;
        let mut level = unit(0);
        if treatment {
            level += &base;
            if let Some(direction) = &direction {
                level += direction;
            }
        }
        let mut listed =
            vec![("ln reference speed".to_owned(), level), ("exponent".to_owned(), unit(1))];
        // one driver alone has no effect
        let first = usize::from(treatment || curves.drivers.len() == 1);
        for (driver, name) in curves.drivers.iter().enumerate().skip(first) {
            let effect = drivers.rows(driver, 1).into_owned();
            let effect = if treatment { effect - &base } else { effect };
            listed.push((format!("driver {name}"), effect));
        }
        if let Some(direction) = direction {
            listed.push(if treatment {
                ("direction right".to_owned(), direction * -2.0)
            } else {
                ("direction left".to_owned(), direction)
            });
        }
        let (coefficients, gram) = (self.fit.coefficients(), self.fit.inverse_gram());
        let df = self.fit.residual_df() as f64;
        let t = t_of_interval(LEVEL, df);
        let as_coefficient = |(name, map): (String, DMatrix<f64>)| {
            let estimate = (&map * &coefficients)[0];
            let standard_error =
                libm::sqrt((&map * &gram * map.transpose())[0]) * self.fit.residual_sd();
            Coefficient {
                name,
                estimate,
                standard_error,
                ci95: around(estimate, standard_error, t),
                ln_p: ln_t_tails(estimate / standard_error, df),
            }
        };
        listed.into_iter().map(as_coefficient).collect()
    }

    /// Effect of each driver.
    pub(super) fn driver_effects(&self, curves: &Curves) -> Vec<DriverEffect> {
        let map = self.driver_map();
        let effects = &map * self.fit.coefficients();
        let covariance = &map * self.fit.inverse_gram() * map.transpose();
        let t = t_of_interval(LEVEL, self.fit.residual_df() as f64);
        let counts = curves.counts();
        let effect = |k: usize| {
            let effect = effects[k];
            let standard_error = libm::sqrt(covariance[(k, k)]) * self.fit.residual_sd();
            DriverEffect {
                driver: curves.drivers[k].clone(),
                n: counts[k],
                effect,
                standard_error,
                ci95: around(effect, standard_error, t),
            }
        };
        (0..curves.drivers.len()).map(effect).collect()
    }
}

/// What a regression with levels of drivers determines; estimates with their standard errors.
pub(super) struct Determined<'a> {
    /// Degrees of freedom of the residual.
    pub df: usize,
    /// ln v₀.
    pub level: (f64, f64),
    pub exponent: f64,
    pub exponent_error: Option<f64>,
    /// Standard error of the exponent with the curves of a driver as one observation.
    pub clustered: Option<f64>,
    pub direction: Option<(f64, f64)>,
    /// Of the drivers, up to a common number.
    pub effects: &'a [f64],
    pub residual_sd: f64,
}

impl Determined<'_> {
    pub(super) fn estimate(self, curves: &Curves) -> CurveSpeedEstimate {
        let Self { df, level, exponent, exponent_error, clustered, residual_sd, .. } = self;
        let drivers = self.effects.len() as f64;
        let t = t_of_interval(LEVEL, df as f64);
        let t_clustered = t_of_interval(LEVEL, drivers - 1.0);
        let spread = Spread::of(self.effects, &curves.counts());
        CurveSpeedEstimate {
            n: curves.rows.len(),
            exponent,
            exponent_standard_error: exponent_error,
            exponent_ci95: exponent_error.map(|error| around(exponent, error, t)),
            exponent_clustered_standard_error: clustered,
            exponent_clustered_ci95: clustered.map(|error| around(exponent, error, t_clustered)),
            reference_speed_mps: libm::exp(level.0),
            reference_speed_ci95: around(level.0, level.1, t).map(libm::exp),
            reference_speed_log_standard_error: level.1,
            reference_speed_log_clustered_standard_error: spread
                .map(|spread| spread.sd / libm::sqrt(drivers)),
            driver_sd: spread.map(|spread| spread.sd),
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
    /// Of effects, with the number of curves of each; none with one driver.
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
pub(super) fn exponent_test(
    estimate: &CurveSpeedEstimate,
    exponent: f64,
    drivers: usize,
) -> ExponentTest {
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
        ln_p_clustered: t_clustered.map(|t| ln_t_tails(t, drivers as f64 - 1.0)),
    }
}
