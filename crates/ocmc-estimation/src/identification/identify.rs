//! The gains of a driver from one event: the paper's objective, bounds, many starts, and what the
//! data do not determine.
//!
//! min ∫ (a_p − â_p)² + (b_p − b̂_p)² + ((v_d − v) / 20 m/s)² dt
//!
//! over the gains and the set speed v_d, with the truck in closed loop and the slope as its input
//! (paper, Eq. optimization). The paper does not say whether v in the last term is simulated or
//! measured: either pulls the gains, the simulated speed since the term is not zero at the truth,
//! the measured one by the set speed, which is estimated, too. Both can be chosen; none is the
//! default, and each pedal counts in units of its sensor's noise. Integral part and speed at the
//! start are estimated, too, and so are the driver's delay, the truck's mass and its resistance:
//! each counts as one more measurement, of what the study says, with its spread (`truck_prior.rs`).
//!
//! How the best fit is looked for is told in `search.rs`: K_D is at least 0 until the fit has
//! passed its tests, and then free, for a bound at 0 would make the mean of small ones too large.
//! Values are those of the best fit less its bias, which is of second order in
//! the noise. Intervals are those of the profile: a parameter is moved away and held while
//! all others follow, until the sum of squares has grown by 1.96² s². s is the standard deviation
//! of the pedal residuals, but at least that of a pedal sensor's resolution: a fit to noiseless
//! data is not infinitely sure of itself. Inputs that are not certain (slopes, the state at the
//! start) widen them. There is none where the residuals are not the noise of sensors ([`FitTest`]),
//! or with a speed term.

use super::bias::bias;
use super::bounded_least_squares::Optimum;
use super::event::{EventError, EventSummary, PedalLog};
use super::options::{IdentifyOptions, SpeedTerm};
use super::problem::Problem;
use super::search::{Best, Searched, is_smooth};
use nalgebra::{DMatrix, DVector};
use ocmc_core::study::Study;
use ocmc_fleet::run::pool;
use rayon::prelude::*;
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};

pub use super::fit_test::FitTest;

/// Half width of a 95 % interval in standard deviations.
pub(super) const NORMAL_95: f64 = 1.959964;
/// An optimum that no larger share of the starts has found is flagged.
const FEW_STARTS: f64 = 0.25;

/// Fit of one parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriverParameterFit {
    /// Its name.
    pub name: &'static str,
    /// Its value: the best fit less its bias.
    pub value: f64,
    /// The bias of the best fit that was taken off its value; 0 where none is known.
    pub bias: f64,
    /// Profile interval, 95 %; ends that reach a bound stand at the bound. None where the fit is no
    /// ground for one.
    pub interval: Option<[f64; 2]>,
    /// Smallest and largest value of the starts that fit as well.
    pub spread: [f64; 2],
    /// Whether it ended at a bound.
    pub at_bound: bool,
    /// Why the data do not determine it; none where they do.
    pub not_identifiable: Option<&'static str>,
}

/// The fit of one event.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EventFit {
    /// The driver.
    pub driver: String,
    /// The event.
    pub event: String,
    /// Largest slope.
    pub grade: f64,
    /// K_P, in s/m.
    pub kp: f64,
    /// K_I, in 1/m; none for a switched driver.
    pub ki: Option<f64>,
    /// K_D, in s²/m; none for a switched driver.
    pub kd: Option<f64>,
    /// Threshold, in m/s; none for a PID.
    pub threshold_mps: Option<f64>,
    /// Set speed, in m/s.
    pub set_speed_mps: f64,
    /// How late the driver sees the speed, in s, where that was asked for.
    pub delay_s: Option<f64>,
    /// Mass of the truck, in kg, where that was asked for.
    pub mass_kg: Option<f64>,
    /// Rolling resistance and air drag of the truck above the study's, as a share of them, where
    /// that was asked for.
    pub resistance_share: Option<f64>,
    /// Names of the parameters at a bound.
    pub at_bound: Vec<&'static str>,
    /// Names of the parameters that the data do not determine.
    pub not_identifiable: Vec<&'static str>,
    /// The objective, in s.
    pub objective: f64,
    /// Root mean square of the pedal residuals.
    pub pedal_rms: f64,
    /// Root mean square of measured less simulated speed, in m/s.
    pub speed_rms_mps: f64,
    /// Whether the residuals are the noise of sensors.
    pub test: FitTest,
    /// Why there are no intervals; nothing where there is no reason against them.
    pub no_intervals: Vec<String>,
    /// Further facts that have to be known of the fit.
    pub warnings: Vec<String>,
    /// Starts.
    pub starts: usize,
    /// Starts that ended in the best optimum; 0 where only a look around has found it.
    pub starts_converged: usize,
    /// Condition number of the derivatives with columns of length 1.
    pub condition: f64,
    /// Time with a fully pressed pedal, in s.
    pub saturated_s: f64,
    /// Duration, in s.
    pub duration_s: f64,
    /// Each parameter.
    pub parameters: Vec<DriverParameterFit>,
}

impl EventFit {
    /// A parameter by its name.
    pub fn parameter(&self, name: &str) -> Option<&DriverParameterFit> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }
}

/// Identifies the controller of one event.
///
/// # Errors
/// [`EventError`] where the log cannot be used, and soon after `stop` is set.
pub fn identify_event(
    study: &Study,
    driver: &str,
    event: &str,
    log: &PedalLog,
    options: &IdentifyOptions,
    stop: &AtomicBool,
) -> Result<EventFit, EventError> {
    let identify = || identified(study, [driver, event], log, options, None, stop);
    pool(options.threads).install(identify).map(|(fit, _)| fit)
}

/// Identifies an event, where `mass` is known of the truck before its log is read (kg, standard
/// deviation); and what this log alone says of the mass.
pub(super) fn identified(
    study: &Study,
    [driver, event]: [&str; 2],
    log: &PedalLog,
    options: &IdentifyOptions,
    mass: Option<[f64; 2]>,
    stop: &AtomicBool,
) -> Result<(EventFit, Option<[f64; 2]>), EventError> {
    let kind = log.check()?;
    let (log, scatter) = log.clone().with_even_slopes();
    let stopped = || stop.load(Ordering::Relaxed);
    let searched = Searched::of(study, &log, *options, mass, stop);
    if stopped() {
        return Err(EventError::Stopped);
    }
    let Searched { problem, optima, starts, best } = searched;
    let Best { good, comparison, test, mut misfits } = best;
    let best = &optima[*good.first().expect("the best one is as good as itself")];
    let deviation = test.deviation(resolution_sd(options));
    if options.speed_term != SpeedTerm::None {
        misfits.insert(0, "the speed term biases the gains".to_owned());
    }
    let intervals = options.intervals && misfits.is_empty();
    let errors = standard_errors(&best.jacobian, deviation);
    let wider = widening(&best.jacobian, &problem.input_errors(&best.parameters), &errors);
    let biases = biases(&problem, best, &test, options);
    let parameters: Vec<DriverParameterFit> = (0..best.parameters.len())
        .into_par_iter()
        .map(|k| {
            let value = best.parameters[k];
            let at_bound = problem.is_at_bound(k, &best.parameters);
            let of_good = good.iter().map(|place| optima[*place].parameters[k]);
            let spread = of_good.fold([value, value], |[low, high], v| [low.min(v), high.max(v)]);
            let interval = intervals.then(|| {
                let [error, deviation] = [errors[k] * wider[k], deviation * wider[k]];
                [-1.0, 1.0].map(|side| problem.profile_end(best, k, side, error, deviation))
            });
            let name = problem.names[k];
            let mut fit = DriverParameterFit {
                name,
                value,
                bias: biases[k],
                interval,
                spread,
                at_bound,
                not_identifiable: None,
            };
            fit.not_identifiable = problem.verdict(k, &fit);
            fit.value -= fit.bias;
            fit
        })
        .collect();
    if stopped() {
        return Err(EventError::Stopped);
    }
    let mut warnings = Vec::new();
    let agree = good.iter().filter(|place| **place < starts).count();
    if starts > 1 && agree as f64 <= FEW_STARTS * starts as f64 {
        warnings.push(format!(
            "only {agree} of {starts} starts found this optimum: there may be a better one, try \
             more starts"
        ));
    }
    if parameters.iter().any(|fit| fit.name == "kd" && fit.value < 0.0) {
        warnings.push(
            "K_D came out below 0, where no gain lies: noise moves a small one to both sides"
                .to_owned(),
        );
    }
    if let Some(why) = problem.closed.start.unsettled() {
        let estimated = if parameters.iter().any(|fit| fit.name == "start_integral") {
            "speed and integral part at the start are estimated with the gains"
        } else {
            "since when the driver holds a pedal is not in a log"
        };
        warnings.push(format!("it begins unsettled, {why}: {estimated}"));
    }
    if let Some(setter) = log.ended_by {
        warnings.push(format!("it ends after {:.0} s, where {}", kind.duration_s, setter.text()));
    }
    if let Some(scatter) = scatter {
        warnings.push(scatter.text());
    }
    let EventSummary { grade, saturated_s, duration_s } = kind;
    let named = |wanted: &dyn Fn(&DriverParameterFit) -> bool| -> Vec<&'static str> {
        parameters.iter().filter(|fit| wanted(fit)).map(|fit| fit.name).collect()
    };
    let told = problem
        .prior("mass_kg")
        .filter(|_| misfits.is_empty())
        .and_then(|(k, prior)| without_prior([best.parameters[k], errors[k] * wider[k]], prior));
    let value = |name: &str| parameters.iter().find(|fit| fit.name == name).map(|fit| fit.value);
    let fit = EventFit {
        driver: driver.to_owned(),
        event: event.to_owned(),
        grade,
        kp: value("kp").unwrap_or(f64::NAN),
        ki: value("ki"),
        kd: value("kd"),
        threshold_mps: value("threshold_mps"),
        set_speed_mps: value("set_speed_mps").unwrap_or(f64::NAN),
        delay_s: value("delay_s"),
        mass_kg: value("mass_kg"),
        resistance_share: value("resistance_share"),
        at_bound: named(&|fit| fit.at_bound),
        not_identifiable: named(&|fit| fit.not_identifiable.is_some()),
        objective: comparison.objective,
        pedal_rms: comparison.pedal_rms,
        speed_rms_mps: comparison.speed_rms_mps,
        test,
        no_intervals: misfits,
        warnings,
        starts,
        starts_converged: agree,
        condition: condition(&best.jacobian),
        saturated_s,
        duration_s,
        parameters,
    };
    Ok((fit, told))
}

/// Estimate without the prior: both with their standard errors. None where it says hardly more.
fn without_prior(
    [estimate, error]: [f64; 2],
    [expected, prior_error]: [f64; 2],
) -> Option<[f64; 2]> {
    let [both, prior] = [error, prior_error].map(|error| 1.0 / (error * error));
    let own = both - prior;
    (own > prior).then(|| [(estimate * both - expected * prior) / own, 1.0 / own.sqrt()])
}

/// Standard deviation of a pedal sensor's resolution.
pub(super) fn resolution_sd(options: &IdentifyOptions) -> f64 {
    options.resolution / 12.0f64.sqrt()
}

/// Biases of the parameters at an optimum; 0 where they are not known: where one is larger than its
/// standard error the next order of the noise is as large, and none of them is taken off. The
/// residuals of a switched driver jump, and those with a speed term are no noise.
fn biases(
    problem: &Problem,
    best: &Optimum,
    test: &FitTest,
    options: &IdentifyOptions,
) -> Vec<f64> {
    let Optimum { parameters, jacobian, .. } = best;
    let biases = is_smooth(options).then(|| {
        let residuals = &mut |points: &[Vec<f64>]| problem.residuals(points);
        bias(residuals, parameters, jacobian, &problem.bounds, test.noise_ratio)
    });
    let errors = standard_errors(jacobian, test.noise_ratio);
    let is_small = |biases: &Vec<f64>| biases.iter().zip(&errors).all(|(b, e)| b.abs() <= *e);
    biases.flatten().filter(is_small).unwrap_or_else(|| vec![0.0; parameters.len()])
}

/// Standard errors from the derivatives; infinite where they do not determine.
fn standard_errors(jacobian: &DMatrix<f64>, deviation: f64) -> Vec<f64> {
    let count = jacobian.ncols();
    let free: Vec<usize> = (0..count).filter(|k| jacobian.column(*k).norm() > 0.0).collect();
    let mut errors = vec![f64::INFINITY; count];
    let identity = DMatrix::identity(free.len(), free.len());
    let upper = jacobian.select_columns(&free).qr().r();
    if let Some(inverse) = upper.solve_upper_triangular(&identity) {
        for (place, k) in free.iter().enumerate() {
            errors[*k] = deviation * inverse.row(place).norm();
        }
    }
    errors
}

/// The factor by which uncertain inputs widen the interval of each parameter: `inputs` is how one
/// standard error of each moves the residuals, and the parameters follow to first order. It is the
/// sandwich (JᵀJ)⁻¹ Jᵀ (s² + Σ g gᵀ) J (JᵀJ)⁻¹ over its first term.
fn widening(jacobian: &DMatrix<f64>, inputs: &[Vec<f64>], errors: &[f64]) -> Vec<f64> {
    let free: Vec<usize> = (0..errors.len()).filter(|k| jacobian.column(*k).norm() > 0.0).collect();
    let factors = jacobian.select_columns(&free).qr();
    let (q, upper) = (factors.q(), factors.r());
    let mut squares = vec![0.0; errors.len()];
    for input in inputs {
        let projected = q.tr_mul(&DVector::from_column_slice(input));
        if let Some(moved) = upper.solve_upper_triangular(&projected) {
            for (place, k) in free.iter().enumerate() {
                squares[*k] += moved[place] * moved[place];
            }
        }
    }
    let factor = |(square, error): (&f64, &f64)| {
        let ratio = square / (error * error);
        if ratio.is_finite() { (1.0 + ratio).sqrt() } else { 1.0 }
    };
    squares.iter().zip(errors).map(factor).collect()
}

/// Largest over smallest singular value of the derivatives with columns of length 1.
fn condition(jacobian: &DMatrix<f64>) -> f64 {
    let mut scaled = jacobian.clone();
    for mut column in scaled.column_iter_mut() {
        let norm = column.norm();
        if norm == 0.0 {
            return f64::INFINITY;
        }
        column /= norm;
    }
    let values = scaled.qr().r().singular_values();
    values.max() / values.min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_known_before_is_taken_off_an_estimate() {
        // 48 ± 2 of the log, 40 ± 8 before: together (48 / 4 + 40 / 64) / (1 / 4 + 1 / 64)
        let both: f64 = 0.25 + 1.0 / 64.0;
        let together = [(12.0 + 40.0 / 64.0) / both, 1.0 / both.sqrt()];
        let [own, error] = without_prior(together, [40.0, 8.0]).expect("the log says more");
        assert!((own - 48.0).abs() < 1e-9 && (error - 2.0).abs() < 1e-9, "{own} ± {error}");
        // a log that says less than was known
        assert_eq!(without_prior([40.0, 7.0], [40.0, 8.0]), None);
    }
}
