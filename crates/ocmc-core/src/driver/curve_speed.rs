//! How fast a driver takes a curve: the law that the paper fits.
//!
//! ln v = ln v₀ + δ (ln R − ln R₀) + α_driver + β_direction + e, e ~ N(0, σ_e²), one residual a
//! curve. A driver has a level α and an exponent δ of his own, which are normal together.
//!
//! Source: Romano, Godio, Bruzelius, Johannesson, the paper in hand, with R₀ = 250 m. Field data: δ
//! = 0.460, v₀ = 54.5 km/h, SD(α) = 5.6 %, β = ±0.2 % (left faster), σ_e = 17.7 %; simulator: 0.23,
//! 60 km/h, 16 %, none, 4.8 %. The field fit uses 20 m ≤ R ≤ 500 m and knows nothing beyond: there
//! a curve does not limit the speed. v₀ of the field fit contains curves under low signs, so it is
//! censored low; the mean over trucks is 57.6 km/h.
//!
//! Checked: the lateral accelerations of the field fit at 20, 50, 100, 250 and 500 m are 1.12,
//! 1.04, 0.99, 0.92 and 0.87 m/s². The bivariate fit recovers the table's moments. Draws of all
//! forms have the population's mean and SD within four standard errors, for seeds 1, 2 and 3.

use crate::random::{Draws, Stream, Streams};
use crate::validation::Problems;
use nalgebra::{Matrix2, Vector2};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where a driver's v₀ and δ come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CurveSpeedForm {
    /// ln v₀ and the exponent normal around the pooled fit.
    Pooled,
    /// The same law with numbers that give a measured table back when the study is driven (`ocmc
    /// calibrate curve-speed`): what drivers want where nothing else slows them.
    Calibrated,
    /// One of the trucks of the table.
    Table,
    /// (δ, ln v₀) bivariate normal, fitted to the table.
    Bivariate,
}

impl CurveSpeedForm {
    /// Whether the numbers of the law are those beside it, not those of a table of trucks.
    pub fn is_one_law(self) -> bool {
        matches!(self, Self::Pooled | Self::Calibrated)
    }
}

/// Statistical description of curve speeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurveSpeedModel {
    /// Where v₀ and δ come from.
    pub form: CurveSpeedForm,
    /// Reference radius R₀, in m.
    #[schemars(range(min = 10.0, max = 5000.0))]
    pub reference_radius_m: f64,
    /// Speed v₀ of the typical driver at R₀, in m/s.
    #[schemars(range(min = 3.0, max = 60.0))]
    pub reference_speed_mps: f64,
    /// Exponent δ.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub exponent: f64,
    /// Standard error of δ, clustered by truck.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub exponent_standard_error: f64,
    /// Standard error of ln v₀, clustered by truck.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub reference_speed_log_standard_error: f64,
    /// Correlation of the errors of δ and ln v₀.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -1.0, max = 1.0))]
    pub error_correlation: f64,
    /// Standard deviation of the driver effect α.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub driver_sd: f64,
    /// Standard deviation of the drivers' exponents; one exponent for all where it is left out.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 0.5))]
    pub exponent_sd: f64,
    /// Correlation of a driver's effect and exponent.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -1.0, max = 1.0))]
    pub driver_correlation: f64,
    /// Direction effect β: + for left, − for right.
    #[schemars(range(min = -0.5, max = 0.5))]
    pub direction_effect: f64,
    /// Standard deviation of the residual e.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub residual_sd: f64,
    /// Largest radius of the fit, in m; wider curves do not limit the speed.
    #[schemars(range(min = 10.0, max = 100_000.0))]
    pub maximum_radius_m: f64,
    /// Radius below which the guard acts, in m; 0 for none.
    #[schemars(range(min = 0.0, max = 100_000.0))]
    pub guard_radius_m: f64,
    /// Lateral acceleration that the guard allows, in m/s².
    #[schemars(range(min = 0.1, max = 20.0))]
    pub guard_lateral_mps2: f64,
    /// Whether v₀ and δ are uncertain (drawn for each replicate) or as given.
    pub parameter_uncertainty: bool,
    /// Number of replicates; cycle k belongs to replicate k mod replicates.
    #[schemars(range(min = 1.0, max = 1_000_000.0))]
    pub replicates: u64,
    /// The trucks of the forms `table` and `bivariate`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<CurveSpeedTable>,
}

/// Fits by truck.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurveSpeedTable {
    /// Names of the trucks.
    pub truck: Vec<String>,
    /// Exponent of each truck.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub exponent: Vec<f64>,
    /// Speed v₀ of each truck, in m/s.
    #[schemars(inner(range(min = 3.0, max = 60.0)))]
    pub reference_speed_mps: Vec<f64>,
}

/// Whether a number is zero: what a study does not say.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde lends the value")]
fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

impl CurveSpeedModel {
    /// A table of as many trucks as its form needs, one entry of each list for each truck.
    pub fn validate(&self, problems: &mut Problems) {
        if !self.form.is_one_law() {
            let rows = self.table.as_ref().map_or(0, |table| table.exponent.len());
            problems.require(
                rows >= 3,
                "table",
                format!("{rows} trucks"),
                "at least 3 trucks, for the forms `table` and `bivariate`",
            );
        }
        if let Some(table) = &self.table {
            let rows = table.exponent.len();
            problems.require(
                rows == table.reference_speed_mps.len() && rows == table.truck.len(),
                "table",
                "lists of different lengths",
                "one truck, exponent and reference_speed_mps a row",
            );
        }
    }

    /// Draws of uncertain parameters that the cycles share; none where the parameters are taken for
    /// certain.
    pub fn uncertain_replicates(&self) -> Option<u64> {
        self.parameter_uncertainty.then_some(self.replicates.max(1))
    }

    /// Standard errors of the mean exponent and speed of the trucks of the forms `table` and
    /// `bivariate`, and the correlation of the two errors; none for the other forms.
    pub fn errors_of_table(&self) -> Option<([f64; 2], f64)> {
        let table = self.table.as_ref().filter(|_| !self.form.is_one_law())?;
        let pairs = table.exponent.iter().copied().zip(table.reference_speed_mps.iter().copied());
        let pairs: Vec<(f64, f64)> = pairs.collect();
        let Bivariate { covariance, .. } = Bivariate::fit(&pairs);
        let sd = [libm::sqrt(covariance[(0, 0)]), libm::sqrt(covariance[(1, 1)])];
        let product = sd[0] * sd[1];
        let correlation = if product > 0.0 { covariance[(0, 1)] / product } else { 0.0 };
        let root = libm::sqrt(pairs.len() as f64);
        Some((sd.map(|sd| sd / root), correlation.clamp(-1.0, 1.0)))
    }

    /// Draws one driver's law; `spread` false gives the typical driver, without residuals.
    pub fn sample(&self, streams: &Streams, spread: bool) -> CurveSpeed {
        let mut draws = streams.open(Stream::CurveSpeed);
        let mut epistemic = self
            .parameter_uncertainty
            .then(|| streams.open_replicate(Stream::CurveSpeedParameters, self.replicates));
        let typical_log_speed = libm::log(self.reference_speed_mps);
        #[expect(clippy::single_match_else, reason = "two kinds of law side by side")]
        let (exponent, log_speed) = match (self.form, &self.table) {
            (CurveSpeedForm::Table | CurveSpeedForm::Bivariate, Some(table)) => {
                let mut pairs = table.pairs();
                if let Some(epistemic) = &mut epistemic {
                    pairs = resample(&pairs, epistemic);
                }
                if !spread {
                    let mean = Bivariate::fit(&pairs).mean;
                    (mean[0], mean[1])
                } else if self.form == CurveSpeedForm::Table {
                    pairs[(draws.uniform() * pairs.len() as f64) as usize]
                } else {
                    Bivariate::fit(&pairs).sample(&mut draws)
                }
            }
            _ => {
                let (mut exponent, mut log_speed) = (self.exponent, typical_log_speed);
                if let Some(epistemic) = &mut epistemic {
                    let (x, y, r) =
                        (epistemic.normal(), epistemic.normal(), self.error_correlation);
                    exponent += self.exponent_standard_error * x;
                    log_speed += self.reference_speed_log_standard_error
                        * (r * x + libm::sqrt(1.0 - r * r) * y);
                }
                if spread {
                    let level = draws.normal();
                    log_speed += self.driver_sd * level;
                    exponent += self.exponent_of_driver(level, &mut draws);
                }
                (exponent, log_speed)
            }
        };
        CurveSpeed {
            reference_speed_mps: libm::exp(log_speed),
            exponent,
            driver_effect: log_speed - typical_log_speed,
            direction_effect: self.direction_effect,
            residual_sd: if spread { self.residual_sd } else { 0.0 },
            reference_radius_m: self.reference_radius_m,
            maximum_radius_m: self.maximum_radius_m,
            guard_radius_m: self.guard_radius_m,
            guard_lateral_mps2: self.guard_lateral_mps2,
        }
    }
}

impl CurveSpeedModel {
    /// How far the exponent of a driver lies from the typical one. `level`: his effect, over its
    /// SD.
    fn exponent_of_driver(&self, level: f64, draws: &mut Draws) -> f64 {
        if self.exponent_sd == 0.0 {
            return 0.0;
        }
        let together = self.driver_correlation;
        let alone = libm::sqrt(1.0 - together * together);
        self.exponent_sd * (together * level + alone * draws.normal())
    }
}

/// One driver's curve-speed law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveSpeed {
    /// Speed at R₀, driver effect included, in m/s.
    pub reference_speed_mps: f64,
    /// Exponent.
    pub exponent: f64,
    /// Driver effect α, log scale.
    pub driver_effect: f64,
    /// Direction effect β, log scale.
    pub direction_effect: f64,
    /// Standard deviation of the residual, log scale.
    pub residual_sd: f64,
    reference_radius_m: f64,
    maximum_radius_m: f64,
    guard_radius_m: f64,
    guard_lateral_mps2: f64,
}

/// Mean and covariance of (δ, ln v₀).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bivariate {
    /// Mean of (δ, ln v₀).
    pub mean: Vector2<f64>,
    /// Covariance of (δ, ln v₀).
    pub covariance: Matrix2<f64>,
}

impl Bivariate {
    /// Fits mean and covariance (divisor n − 1) to pairs.
    pub fn fit(pairs: &[(f64, f64)]) -> Self {
        let n = pairs.len() as f64;
        let point = |&(exponent, log_speed): &(f64, f64)| Vector2::new(exponent, log_speed);
        let mean = pairs.iter().map(point).sum::<Vector2<f64>>() / n;
        let covariance = pairs
            .iter()
            .map(|pair| {
                let d = point(pair) - mean;
                d * d.transpose()
            })
            .sum::<Matrix2<f64>>()
            / (n - 1.0);
        Self { mean, covariance }
    }

    /// One draw, by the Cholesky factor written out.
    pub fn sample(&self, draws: &mut Draws) -> (f64, f64) {
        let s = &self.covariance;
        let a = s[(0, 0)].max(0.0).sqrt();
        let b = if a > 0.0 { s[(1, 0)] / a } else { 0.0 };
        let c = (s[(1, 1)] - b * b).max(0.0).sqrt();
        let (x, y) = (draws.normal(), draws.normal());
        (self.mean[0] + a * x, self.mean[1] + b * x + c * y)
    }
}

impl CurveSpeedTable {
    fn pairs(&self) -> Vec<(f64, f64)> {
        let logs = self.reference_speed_mps.iter().map(|v| libm::log(*v));
        self.exponent.iter().copied().zip(logs).collect()
    }
}

/// A bootstrap sample of the same size: the trucks are the clusters.
fn resample(pairs: &[(f64, f64)], draws: &mut Draws) -> Vec<(f64, f64)> {
    let n = pairs.len() as f64;
    (0..pairs.len()).map(|_| pairs[(draws.uniform() * n) as usize]).collect()
}

impl CurveSpeed {
    /// Speed in a curve, in m/s, for a standard normal residual; infinite beyond the fit's radii.
    pub fn speed_mps(&self, radius_m: f64, left: bool, residual: f64) -> f64 {
        if radius_m > self.maximum_radius_m {
            return f64::INFINITY;
        }
        let direction = if left { self.direction_effect } else { -self.direction_effect };
        let log_ratio = self.exponent * libm::log(radius_m / self.reference_radius_m);
        let speed = self.reference_speed_mps
            * libm::exp(log_ratio + direction + self.residual_sd * residual);
        if radius_m < self.guard_radius_m {
            speed.min((self.guard_lateral_mps2 * radius_m).sqrt())
        } else {
            speed
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn field() -> CurveSpeedModel {
        CurveSpeedModel {
            form: CurveSpeedForm::Pooled,
            reference_radius_m: 250.0,
            reference_speed_mps: 54.5 / 3.6,
            exponent: 0.46,
            exponent_standard_error: 0.0047,
            reference_speed_log_standard_error: 0.0112,
            error_correlation: 0.0,
            driver_sd: 0.056,
            exponent_sd: 0.0,
            driver_correlation: 0.0,
            direction_effect: 0.002,
            residual_sd: 0.177,
            maximum_radius_m: 500.0,
            guard_radius_m: 0.0,
            guard_lateral_mps2: 3.0,
            parameter_uncertainty: false,
            replicates: 64,
            table: None,
        }
    }

    /// The paper's table of 25 trucks: exponents, and v0 in km/h.
    fn table() -> CurveSpeedTable {
        let exponent = [
            45, 37, 42, 43, 44, 44, 42, 43, 42, 46, 42, 43, 48, 43, 46, 43, 46, 47, 41, 45, 45, 43,
            42, 45, 47,
        ];
        let speed = [
            58, 64, 58, 54, 65, 61, 49, 58, 54, 58, 47, 57, 60, 60, 56, 55, 59, 58, 60, 60, 55, 58,
            56, 59, 60,
        ];
        CurveSpeedTable {
            truck: (0..25).map(|i| i.to_string()).collect(),
            exponent: exponent.iter().map(|&e| f64::from(e) / 100.0).collect(),
            reference_speed_mps: speed.iter().map(|&v| f64::from(v) / 3.6).collect(),
        }
    }

    #[test]
    fn lateral_accelerations_of_the_field_fit() {
        // R = 20/50/100/250/500 m -> 1.12/1.04/.99/.92/.87 m/s2
        let law = field().sample(&Streams::new(1, 0), false);
        for (radius, printed) in
            [(20.0, 1.12), (50.0, 1.04), (100.0, 0.99), (250.0, 0.92), (500.0, 0.87)]
        {
            let v = law.speed_mps(radius, true, 0.0) / libm::exp(0.002);
            assert!((v * v / radius - printed).abs() < 0.0075, "{radius}: {}", v * v / radius);
        }
        assert!(law.speed_mps(501.0, true, 0.0).is_infinite());
    }

    #[test]
    fn bivariate_fit_recovers_the_tables_moments() {
        // mean .438, SD .024; mean 57.6 km/h, log-SD 7.1 %; correlation .11
        let fit = Bivariate::fit(&table().pairs());
        let (sd_e, sd_v) = (fit.covariance[(0, 0)].sqrt(), fit.covariance[(1, 1)].sqrt());
        assert!((fit.mean[0] - 0.438).abs() < 0.0006);
        assert!((sd_e - 0.024).abs() < 0.0006);
        assert!((sd_v - 0.071).abs() < 0.0006);
        assert!((fit.covariance[(0, 1)] / (sd_e * sd_v) - 0.11).abs() < 0.006);
    }

    #[test]
    fn draws_have_the_populations_moments() {
        let mut model = field();
        for seed in 1..=3 {
            for form in [CurveSpeedForm::Pooled, CurveSpeedForm::Table, CurveSpeedForm::Bivariate] {
                model.form = form;
                model.table = Some(table());
                let fit = Bivariate::fit(&table().pairs());
                let (mean, sd) = match form {
                    CurveSpeedForm::Pooled => ((54.5f64 / 3.6).ln(), 0.056),
                    _ => (fit.mean[1], fit.covariance[(1, 1)].sqrt()),
                };
                let n = 20_000;
                let logs: Vec<f64> = (0..n)
                    .map(|cycle_id| {
                        let streams = Streams::new(seed, cycle_id);
                        model.sample(&streams, true).reference_speed_mps.ln()
                    })
                    .collect();
                let m = logs.iter().sum::<f64>() / n as f64;
                let v = logs.iter().map(|x| (x - m).powi(2)).sum::<f64>() / (n - 1) as f64;
                // the table's own variance has divisor n
                let sd =
                    if form == CurveSpeedForm::Table { sd * (24.0f64 / 25.0).sqrt() } else { sd };
                assert!((m - mean).abs() < 4.0 * sd / (n as f64).sqrt(), "{form:?} {m} {mean}");
                // standard error of an SD, with room for a kurtosis of up to 6
                let error = sd * (5.0 / (4.0 * n as f64)).sqrt();
                assert!((v.sqrt() - sd).abs() < 4.0 * error, "{form:?} {} {sd}", v.sqrt());
            }
        }
    }

    #[test]
    fn exponents_of_drivers_have_their_law() {
        let mut model = field();
        (model.exponent_sd, model.driver_correlation) = (0.022, 0.12);
        let n = 20_000;
        let drivers = (0..n).map(|cycle_id| model.sample(&Streams::new(4, cycle_id), true));
        let pairs: Vec<_> = drivers.map(|d| (d.exponent, d.driver_effect)).collect();
        let fit = Bivariate::fit(&pairs);
        let sd = [fit.covariance[(0, 0)].sqrt(), fit.covariance[(1, 1)].sqrt()];
        let root = f64::from(n as u32).sqrt();
        assert!((fit.mean[0] - model.exponent).abs() < 4.0 * model.exponent_sd / root);
        assert!((sd[0] / model.exponent_sd - 1.0).abs() < 4.0 / (1.4 * root), "{sd:?}");
        assert!((sd[1] / model.driver_sd - 1.0).abs() < 4.0 / (1.4 * root), "{sd:?}");
        let correlation = fit.covariance[(0, 1)] / (sd[0] * sd[1]);
        assert!((correlation - model.driver_correlation).abs() < 4.0 / root, "{correlation}");
        // the pooled law of one exponent draws the same levels
        let pooled = field();
        let level = |model: &CurveSpeedModel| model.sample(&Streams::new(4, 7), true).driver_effect;
        assert!(level(&model) == level(&pooled));
    }

    #[test]
    fn the_defaults_law_of_exponents_is_the_tables_without_its_errors() {
        // exponents and speeds are printed to 0.01 and 1 km/h; 49,283 curves with a residual of
        // 17.7 % and an SD(ln R) of 0.97 around ln 116 m (the paper's tables)
        let fit = Bivariate::fit(&table().pairs());
        let (curves, residual, log_sd): (f64, f64, f64) = (49_283.0 / 25.0, 0.177, 0.97);
        let away = (116.0f64 / 250.0).ln();
        let rounded = |width: f64| width * width / 12.0;
        let slope = residual * residual / (log_sd * log_sd * curves);
        let errors = [
            slope + rounded(0.01),
            residual * residual / curves + slope * away * away + rounded(1.0 / 57.6),
        ];
        let variance = [0, 1].map(|k| fit.covariance[(k, k)] - errors[k]);
        // mean and slope of a regression are independent at its mean radius
        let together = fit.covariance[(0, 1)] + slope * away;
        let [exponent_sd, level_sd] = variance.map(f64::sqrt);
        let correlation = together / (exponent_sd * level_sd);
        assert!((exponent_sd - 0.023).abs() < 0.0005, "{exponent_sd}");
        assert!((level_sd - 0.0705).abs() < 0.0005, "{level_sd}");
        assert!((correlation - 0.10).abs() < 0.02, "{correlation}");
    }

    #[test]
    fn parameter_uncertainty_belongs_to_replicates() {
        let mut model = field();
        model.parameter_uncertainty = true;
        let exponent = |cycle_id| model.sample(&Streams::new(1, cycle_id), true).exponent;
        assert!(exponent(3) == exponent(3 + 64));
        assert!(exponent(3) != exponent(4));
    }
}
