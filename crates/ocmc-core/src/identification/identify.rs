//! The gains of a driver from one event: the paper's objective, bounds, many starts, and what the data do not tell.
//!
//! min ∫ (a_p − â_p)² + (b_p − b̂_p)² + ((v_d − v) / 20 m/s)² dt
//!
//! over the gains and the set speed v_d, with the truck in closed loop and the slope as its input (paper, Eq. optimization). The
//! paper does not say whether v in the last term is simulated or measured: with the simulated speed the term is not zero at
//! the truth and pulls the gains, with the measured one it only draws v_d to the mean speed. All three, with none, can be
//! chosen. The integral part at the start is estimated, too: no log tells it.
//!
//! The search starts from many points (Sobol sequence, Owen-scrambled) within the box. Intervals are those of the profile: a parameter is moved away
//! and held while all others follow, until the sum of squares has grown by 1.96² s². s is the standard deviation of the pedal residuals,
//! but at least that of a pedal sensor's resolution: a fit to noiseless data is not infinitely sure of itself. The residuals are taken as
//! independent; where they are not, the intervals are too short.

use super::bounded_least_squares::{Optimum, Tolerances, minimise};
use super::closed_loop::{ClosedLoop, Controller};
use super::compass_search::descend;
use super::event::{EventError, PedalLog};
use crate::simulation::event::EventDrive;
use crate::study::Study;
use nalgebra::DMatrix;
use rayon::prelude::*;
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// Scale of the speed term, in m/s (paper).
const SPEED_SCALE_MPS: f64 = 20.0;
/// Half width of a 95 % interval in standard deviations.
const NORMAL_95: f64 = 1.959964;
/// A parameter is identified where its interval is not wider than this share of it, to either side.
const WIDEST: f64 = 0.5;
/// Fits with a sum of squares this close to the best are as good.
const AS_GOOD: f64 = 1e-3;
/// Half width of the box of the set speed around the mean speed, in m/s.
const SET_SPEED_RANGE_MPS: f64 = 4.0;
/// The starts scatter the set speed within this, in m/s.
const START_RANGE_MPS: f64 = 1.0;
/// Rounds in which the end of a profile interval is looked for.
const PROFILE_ROUNDS: usize = 6;
/// Time at the start in which pedals are not compared, in s.
const NOT_COMPARED_S: f64 = 1.0;
/// Points for each start among which the starts of a switched driver are the best.
const CANDIDATES: usize = 16;
/// Seed of the scrambling.
const SCRAMBLE: u32 = 1;

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
            speed_term: SpeedTerm::Measured,
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
pub struct ParameterFit {
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
    /// Why the data do not tell it; none where they do.
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
    /// Names of the parameters that the data do not tell.
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
    pub parameters: Vec<ParameterFit>,
}

impl EventFit {
    /// A parameter by its name.
    pub fn parameter(&self, name: &str) -> Option<&ParameterFit> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }
}

/// The problem of one event.
struct Problem<'a> {
    log: &'a PedalLog,
    closed: ClosedLoop<'a>,
    options: &'a IdentifyOptions,
    /// Square root of the time that each row stands for, over its mean.
    weight: Vec<f64>,
    mean_weight_s: f64,
    /// Rows that count.
    compared: usize,
    names: Vec<&'static str>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    integral_range: [f64; 2],
    /// Set once nobody waits for an answer any more.
    stop: &'a AtomicBool,
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
        .map(|start| problem.search(start, &problem.lower, &problem.upper, &tolerances))
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
    let parameters: Vec<ParameterFit> = (0..count)
        .into_par_iter()
        .map(|k| {
            let value = best.parameters[k];
            let width = problem.upper[k] - problem.lower[k];
            let near = |bound: f64| (value - bound).abs() <= 1e-6 * width;
            let at_bound = near(problem.lower[k]) || near(problem.upper[k]);
            let of_good = good.iter().map(|optimum| optimum.parameters[k]);
            let spread = of_good.fold([value, value], |[low, high], v| [low.min(v), high.max(v)]);
            let interval = options.intervals.then(|| {
                [-1.0, 1.0].map(|side| problem.profile_end(best, k, side, errors[k], deviation))
            });
            let mut fit = ParameterFit {
                name: problem.names[k],
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
    let named = |wanted: &dyn Fn(&ParameterFit) -> bool| -> Vec<&'static str> {
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

impl<'a> Problem<'a> {
    fn new(
        study: &'a Study,
        log: &'a PedalLog,
        options: &'a IdentifyOptions,
        stop: &'a AtomicBool,
    ) -> Self {
        let rows = log.time_s.len();
        let time = |k: usize| log.time_s[k.min(rows - 1)];
        // what engine and filter knew at the start is gone after a second: it is not compared
        let begin_s = log.time_s[0] + NOT_COMPARED_S;
        let span = |k: usize| 0.5 * (time(k + 1) - time(k.saturating_sub(1)));
        let spans: Vec<f64> =
            (0..rows).map(|k| if time(k) < begin_s { 0.0 } else { span(k) }).collect();
        let compared = spans.iter().filter(|span| **span > 0.0).count();
        let mean_weight_s = spans.iter().sum::<f64>() / compared.max(1) as f64;
        let mean_speed_mps = log.speed_mps.iter().sum::<f64>() / rows as f64;
        let pid = &study.model().driver.pedals.pid;
        let integral_range = [pid.integral_minimum, pid.integral_maximum];
        let speed = [mean_speed_mps - SET_SPEED_RANGE_MPS, mean_speed_mps + SET_SPEED_RANGE_MPS];
        let boxes = match options.controller {
            ControllerKind::Pid => vec![
                ("kp", options.proportional),
                ("ki", options.integral),
                ("kd", options.derivative),
                ("set_speed_mps", speed),
                ("start_integral", integral_range),
            ],
            ControllerKind::Switched => vec![
                ("kp", options.proportional),
                ("threshold_mps", options.threshold_mps),
                ("set_speed_mps", speed),
            ],
        };
        Self {
            log,
            closed: ClosedLoop::new(study, log),
            options,
            weight: spans.iter().map(|span| (span / mean_weight_s).sqrt()).collect(),
            mean_weight_s,
            compared,
            names: boxes.iter().map(|(name, _)| *name).collect(),
            lower: boxes.iter().map(|(_, range)| range[0]).collect(),
            upper: boxes.iter().map(|(_, range)| range[1]).collect(),
            integral_range,
            stop,
        }
    }

    fn tolerances(&self) -> Tolerances {
        let difference = match self.options.controller {
            ControllerKind::Pid => 1e-4,
            // the moments at which a switched driver acts move by whole steps
            ControllerKind::Switched => 2e-3,
        };
        Tolerances { gain: 1e-8, step: 1e-7, most_iterations: 60, difference }
    }

    /// The controller of some parameters.
    fn controller(&self, x: &[f64]) -> Controller {
        match self.options.controller {
            ControllerKind::Pid => Controller::Pid {
                proportional: x[0],
                integral: x[1],
                derivative: x[2],
                set_speed_mps: x[3],
                start: x[4],
            },
            ControllerKind::Switched => Controller::Switched {
                proportional: x[0],
                threshold_mps: x[1],
                set_speed_mps: x[2],
            },
        }
    }

    /// A point of the box: gains evenly over the logarithm, the set speed around the mean.
    fn start(&self, index: u32) -> Vec<f64> {
        let part = |dimension: u32| f64::from(sobol_burley::sample(index, dimension, SCRAMBLE));
        let mean_speed_mps =
            0.5 * (self.lower_of("set_speed_mps") + self.upper_of("set_speed_mps"));
        let speed = mean_speed_mps + START_RANGE_MPS * (2.0 * part(0) - 1.0);
        // not the outermost corners of the box
        let log = |k: usize, dimension: u32| {
            let (low, high) = (self.lower[k].max(0.02 * self.upper[k]), 0.5 * self.upper[k]);
            low * libm::exp(part(dimension) * libm::log(high / low))
        };
        let proportional = log(0, 1);
        match self.options.controller {
            ControllerKind::Pid => {
                let error = speed - self.closed.start_speed_mps();
                let start = self.closed.start_output - proportional * error;
                let [low, high] = self.integral_range;
                vec![proportional, log(1, 2), log(2, 3), speed, start.clamp(low, high)]
            }
            ControllerKind::Switched => vec![proportional, log(1, 2), speed],
        }
    }

    fn lower_of(&self, name: &str) -> f64 {
        self.names.iter().position(|known| *known == name).map_or(f64::NAN, |k| self.lower[k])
    }

    fn upper_of(&self, name: &str) -> f64 {
        self.names.iter().position(|known| *known == name).map_or(f64::NAN, |k| self.upper[k])
    }

    /// Where the searches start: the first points of the sequence; of a switched driver, whose residuals jump, the best of
    /// many points.
    fn starts(&self) -> Vec<Vec<f64>> {
        let wanted = self.options.starts.max(1);
        if self.options.controller == ControllerKind::Pid {
            return (0..wanted).map(|k| self.start(k as u32)).collect();
        }
        let points: Vec<Vec<f64>> =
            (0..wanted * CANDIDATES).map(|k| self.start(k as u32)).collect();
        let values: Vec<f64> = points.par_iter().map(|x| self.sum(x, &mut Vec::new())).collect();
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        order[..wanted].iter().map(|&k| points[k].clone()).collect()
    }

    fn search(
        &self,
        start: &[f64],
        lower: &[f64],
        upper: &[f64],
        tolerances: &Tolerances,
    ) -> Optimum {
        let mut from = start.to_vec();
        if self.is_stopped() {
            return Optimum { parameters: from, ..Optimum::default() };
        }
        if self.options.controller == ControllerKind::Switched {
            let mut r = Vec::new();
            from = descend(&mut |x| self.sum(x, &mut r), start, lower, upper).0;
        }
        minimise(&mut |x, r| self.residuals(x, r), &from, lower, upper, tolerances)
    }

    /// Sum of squares.
    fn sum(&self, x: &[f64], r: &mut Vec<f64>) -> f64 {
        self.residuals(x, r);
        r.iter().map(|value| value * value).sum()
    }

    /// Weighted residuals: both pedals, then the speed term.
    fn residuals(&self, x: &[f64], r: &mut Vec<f64>) {
        r.clear();
        if self.is_stopped() {
            // a sum of squares of 0 ends every search
            r.resize(self.log.time_s.len() * self.residuals_a_row(), 0.0);
            return;
        }
        let controller = self.controller(x);
        let set_speed_mps = match controller {
            Controller::Pid { set_speed_mps, .. } | Controller::Switched { set_speed_mps, .. } => {
                set_speed_mps
            }
        };
        let drive = self.closed.drive(&controller);
        let mut at = Interpolation::new(&drive);
        let start_s = self.log.time_s[0];
        for (k, time_s) in self.log.time_s.iter().enumerate() {
            let (accelerator, brake, speed_mps) = at.at(time_s - start_s);
            let weight = self.weight[k];
            r.push(weight * (self.log.accelerator[k] - accelerator));
            r.push(weight * (self.log.brake[k] - brake));
            let compared = match self.options.speed_term {
                SpeedTerm::None => continue,
                SpeedTerm::Measured => self.log.speed_mps[k],
                SpeedTerm::Simulated => speed_mps,
            };
            r.push(weight * (set_speed_mps - compared) / SPEED_SCALE_MPS);
        }
    }

    /// Sum of squares of the pedals alone.
    fn pedal_sum(&self, x: &[f64]) -> f64 {
        let mut r = Vec::new();
        self.residuals(x, &mut r);
        r.chunks(self.residuals_a_row()).map(|row| row[0] * row[0] + row[1] * row[1]).sum()
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn residuals_a_row(&self) -> usize {
        if self.options.speed_term == SpeedTerm::None { 2 } else { 3 }
    }

    /// Where the profile of parameter `k` has grown by 1.96² s², to one side; the bound where it does not before.
    fn profile_end(&self, best: &Optimum, k: usize, side: f64, error: f64, deviation: f64) -> f64 {
        let value = best.parameters[k];
        let bound = if side < 0.0 { self.lower[k] } else { self.upper[k] };
        let room = (bound - value).abs();
        let first = if error.is_finite() { NORMAL_95 * error } else { 0.1 * value.abs() };
        let mut away = first.min(room);
        let mut warm = best.parameters.clone();
        let tolerances = Tolerances { most_iterations: 15, ..self.tolerances() };
        let mut inside = 0.0;
        for _ in 0..PROFILE_ROUNDS {
            if !(away > 0.0) {
                return bound;
            }
            let (mut lower, mut upper) = (self.lower.clone(), self.upper.clone());
            let here = value + side * away;
            (lower[k], upper[k]) = (here, here);
            warm[k] = here;
            let optimum = self.search(&warm, &lower, &upper, &tolerances);
            let rise = (optimum.sum_of_squares - best.sum_of_squares).max(0.0);
            let deviations = rise.sqrt() / deviation;
            if (deviations / NORMAL_95 - 1.0).abs() < 0.03 {
                return here;
            }
            if deviations < NORMAL_95 {
                if away >= room {
                    return bound;
                }
                inside = away;
                warm.clone_from(&optimum.parameters);
            }
            // the root of the rise is nearly linear
            let next = away * (NORMAL_95 / deviations.max(1e-3)).min(4.0);
            away = if deviations > NORMAL_95 { next.max(inside) } else { next.min(room) };
        }
        value + side * away.min(room)
    }

    /// Why a parameter is not told by the data.
    fn verdict(&self, k: usize, fit: &ParameterFit) -> Option<&'static str> {
        if fit.at_bound {
            return Some("it ended at a bound");
        }
        // what matters of a speed is the error: its scale is 1 m/s; of a start 1
        let size = match fit.name {
            "set_speed_mps" | "start_integral" => 1.0,
            _ => fit.value.abs(),
        };
        let width = |ends: [f64; 2]| (ends[1] - fit.value).max(fit.value - ends[0]);
        if width(fit.spread) > WIDEST * size {
            return Some("different values fit equally well");
        }
        let interval = fit.interval?;
        if interval[0] <= self.lower[k] && interval[1] >= self.upper[k] {
            return Some("its interval is the whole box");
        }
        (width(interval) > WIDEST * size).then_some("its interval is wider than half of it")
    }
}

/// Reads a drive at rising times.
struct Interpolation<'a> {
    drive: &'a EventDrive,
    step: usize,
}

impl<'a> Interpolation<'a> {
    fn new(drive: &'a EventDrive) -> Self {
        Self { drive, step: 0 }
    }

    /// Accelerator, brake and speed.
    fn at(&mut self, time_s: f64) -> (f64, f64, f64) {
        let times = &self.drive.time_s;
        if times.is_empty() {
            return (f64::NAN, f64::NAN, f64::NAN);
        }
        while self.step + 1 < times.len() && times[self.step + 1] < time_s {
            self.step += 1;
        }
        let (k, next) = (self.step, (self.step + 1).min(times.len() - 1));
        let width = times[next] - times[k];
        let part = if width > 0.0 { ((time_s - times[k]) / width).clamp(0.0, 1.0) } else { 0.0 };
        let of = |values: &[f64]| values[k] + part * (values[next] - values[k]);
        (of(&self.drive.accelerator), of(&self.drive.brake), of(&self.drive.speed_mps))
    }
}

/// Standard errors from the derivatives; infinite where they do not tell.
fn standard_errors(jacobian: &DMatrix<f64>, deviation: f64) -> Vec<f64> {
    let count = jacobian.ncols();
    let free: Vec<usize> = (0..count).filter(|k| jacobian.column(*k).norm() > 0.0).collect();
    let mut errors = vec![f64::INFINITY; count];
    let upper = jacobian.select_columns(&free).qr().r();
    if let Some(inverse) = upper.solve_upper_triangular(&DMatrix::identity(free.len(), free.len()))
    {
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
