//! The gains of a driver from one event: the paper's objective, bounds, many starts, and what the
//! data do not determine.
//!
//! min ∫ (a_p − â_p)² + (b_p − b̂_p)² + ((v_d − v) / 20 m/s)² dt
//!
//! over the gains and the set speed v_d, with the truck in closed loop and the slope as its input
//! (paper, Eq. optimization). The paper does not say whether v in the last term is simulated or
//! measured: either pulls the gains, the simulated speed since the term is not zero at the truth,
//! the measured one by the set speed, which is estimated, too. Both can be chosen; none is the
//! default. The integral part at the start is estimated, too: no log contains it.
//!
//! The search starts from the best of many points (Sobol sequence, Owen-scrambled) within the box.
//! Intervals are those of the profile: a parameter is moved away and held while all others follow,
//! until the sum of squares has grown by 1.96² s². s is the standard deviation of the pedal
//! residuals, but at least that of a pedal sensor's resolution: a fit to noiseless data is not
//! infinitely sure of itself. The residuals are taken as independent; where they are not, the
//! intervals are too short.

use super::bounded_least_squares::Optimum;
use super::event::{EventError, PedalLog};
use super::problem::Problem;
use nalgebra::DMatrix;
use ocmc_core::study::Study;
use rayon::prelude::*;
use serde::Serialize;
use std::sync::atomic::AtomicBool;
use thiserror::Error;

/// Half width of a 95 % interval in standard deviations.
pub(super) const NORMAL_95: f64 = 1.959964;
/// Fits with a sum of squares this close to the best are as good.
const AS_GOOD: f64 = 1e-3;

/// Which controller is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ControllerKind {
    /// PID.
    Pid,
    /// Switched proportional.
    Switched,
}

/// Which speed the speed term compares with the set speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SpeedTerm {
    /// No speed term.
    None,
    /// The measured speed.
    Measured,
    /// The simulated speed.
    Simulated,
}

/// Options of the identification.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct IdentifyOptions {
    /// Which controller.
    pub controller: ControllerKind,
    /// Which speed term.
    pub speed_term: SpeedTerm,
    /// Number of starts.
    pub starts: usize,
    /// Resolution of the pedal sensors.
    pub resolution: f64,
    /// Whether intervals are worked out; they take several times as long as the fit.
    pub intervals: bool,
    /// Bounds of K_P, in s/m.
    pub proportional: [f64; 2],
    /// Bounds of K_I, in 1/m.
    pub integral: [f64; 2],
    /// Bounds of K_D, in s²/m.
    pub derivative: [f64; 2],
    /// Bounds of a switched driver's threshold, in m/s.
    pub threshold_mps: [f64; 2],
}

impl Default for IdentifyOptions {
    fn default() -> Self {
        Self {
            controller: ControllerKind::Pid,
            // the paper's readings bias the gains
            speed_term: SpeedTerm::None,
            starts: 8,
            resolution: 0.01,
            intervals: true,
            proportional: [0.01, 2.0],
            integral: [1e-4, 0.2],
            derivative: [0.0, 2.0],
            threshold_mps: [0.0, 3.0],
        }
    }
}

/// Bounds between which nothing can be looked for.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("the bounds of {name} are {} and {}: they have to rise, from {least} on", bounds[0], bounds[1])]
pub struct BoundsError {
    /// Name of the gain.
    name: &'static str,
    /// Its bounds.
    bounds: [f64; 2],
    /// Smallest lower bound.
    least: f64,
}

impl IdentifyOptions {
    /// Whether the bounds of the gains are bounds.
    ///
    /// # Errors
    /// [`BoundsError`] for the first gain whose bounds are none.
    pub fn check(&self) -> Result<(), BoundsError> {
        for (name, bounds, least) in [
            ("kp", self.proportional, 1e-3),
            ("ki", self.integral, 1e-6),
            ("kd", self.derivative, 0.0),
        ] {
            if !(bounds[0] >= least && bounds[1] > bounds[0] && bounds[1].is_finite()) {
                return Err(BoundsError { name, bounds, least });
            }
        }
        Ok(())
    }
}

/// What was found for one parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriverParameterFit {
    /// Its name.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Profile interval, 95 %; ends that reach a bound stand at the bound.
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
    /// Names of the parameters at a bound.
    pub at_bound: Vec<&'static str>,
    /// Names of the parameters that the data do not determine.
    pub not_identifiable: Vec<&'static str>,
    /// The objective, in s.
    pub objective: f64,
    /// Root mean square of the pedal residuals.
    pub pedal_rms: f64,
    /// Starts.
    pub starts: usize,
    /// Starts that ended in the best optimum.
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
    let kind = log.check()?;
    let problem = Problem::new(study, log, options, stop);
    let starts = problem.starts();
    let tolerances = problem.tolerances();
    let optima: Vec<Optimum> = starts
        .par_iter()
        .map(|start| problem.search(start, &problem.bounds, &tolerances))
        .collect();
    let go_on = || if problem.is_stopped() { Err(EventError::Stopped) } else { Ok(()) };
    go_on()?;
    let best = optima
        .iter()
        .min_by(|a, b| a.sum_of_squares.total_cmp(&b.sum_of_squares))
        .expect("there is at least one start");
    let count = best.parameters.len();
    let rows = problem.compared;
    let pedal_sum = problem.pedal_sum(&best.parameters);
    let freedom = (2 * rows).saturating_sub(count).max(1) as f64;
    let floor = options.resolution / 12.0f64.sqrt();
    let deviation = (pedal_sum / freedom).sqrt().max(floor);
    let growth = NORMAL_95 * NORMAL_95 * deviation * deviation;

    let as_good = |optimum: &&Optimum| {
        let limit = best.sum_of_squares * (1.0 + AS_GOOD);
        optimum.sum_of_squares <= limit.max(best.sum_of_squares + 0.01 * growth)
    };
    let good: Vec<&Optimum> = optima.iter().filter(as_good).collect();
    let errors = standard_errors(&best.jacobian, deviation);
    let parameters: Vec<DriverParameterFit> = (0..count)
        .into_par_iter()
        .map(|k| {
            let value = best.parameters[k];
            let [lower, upper] = problem.bounds[k];
            let near = |bound: f64| (value - bound).abs() <= 1e-6 * (upper - lower);
            let at_bound = near(lower) || near(upper);
            let of_good = good.iter().map(|optimum| optimum.parameters[k]);
            let spread = of_good.fold([value, value], |[low, high], v| [low.min(v), high.max(v)]);
            let interval = options.intervals.then(|| {
                [-1.0, 1.0].map(|side| problem.profile_end(best, k, side, errors[k], deviation))
            });
            let name = problem.names[k];
            let mut fit = DriverParameterFit {
                name,
                value,
                interval,
                spread,
                at_bound,
                not_identifiable: None,
            };
            fit.not_identifiable = problem.verdict(k, &fit);
            fit
        })
        .collect();
    go_on()?;
    let named = |wanted: &dyn Fn(&DriverParameterFit) -> bool| -> Vec<&'static str> {
        parameters.iter().filter(|fit| wanted(fit)).map(|fit| fit.name).collect()
    };
    let value = |name: &str| parameters.iter().find(|fit| fit.name == name).map(|fit| fit.value);
    Ok(EventFit {
        driver: driver.to_owned(),
        event: event.to_owned(),
        grade: kind.grade,
        kp: value("kp").unwrap_or(f64::NAN),
        ki: value("ki"),
        kd: value("kd"),
        threshold_mps: value("threshold_mps"),
        set_speed_mps: value("set_speed_mps").unwrap_or(f64::NAN),
        at_bound: named(&|fit| fit.at_bound),
        not_identifiable: named(&|fit| fit.not_identifiable.is_some()),
        objective: best.sum_of_squares * problem.mean_weight_s,
        pedal_rms: (pedal_sum / (2.0 * rows as f64)).sqrt(),
        starts: optima.len(),
        starts_converged: good.len(),
        condition: condition(&best.jacobian),
        saturated_s: kind.saturated_s,
        duration_s: kind.duration_s,
        parameters,
    })
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
