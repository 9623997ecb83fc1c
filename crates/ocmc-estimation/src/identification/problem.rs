//! The least-squares problem of one event: residuals of the pedals in closed loop, where the search
//! starts, how far a parameter may move.

use super::bounded_least_squares::{Optimum, Tolerances, minimise};
use super::closed_loop::{ClosedLoop, Controller};
use super::compass_search::descend;
use super::event::PedalLog;
use super::identify::{ControllerKind, DriverParameterFit, IdentifyOptions, NORMAL_95, SpeedTerm};
use ocmc_core::kernel::pedal_event::EventSeries;
use ocmc_core::study::Study;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Scale of the speed term, in m/s (paper).
const SPEED_SCALE_MPS: f64 = 20.0;
/// A parameter is identified where its interval is not wider than this share of it, to either side.
const WIDEST: f64 = 0.5;
/// Half width of the box of the set speed around the mean speed, in m/s.
const SET_SPEED_RANGE_MPS: f64 = 4.0;
/// The starts scatter the set speed within this, in m/s.
const START_RANGE_MPS: f64 = 1.0;
/// Rounds in which the end of a profile interval is looked for.
const PROFILE_ROUNDS: usize = 6;
/// Time at the start in which pedals are not compared, in s.
const NOT_COMPARED_S: f64 = 1.0;
/// Points for each start among which the starts are the best: shifts of the gearbox and switched
/// drivers leave jumps in the residuals, behind which a search does not see.
const CANDIDATES: usize = 16;
/// Seed of the scrambling.
const SCRAMBLE: u32 = 1;

/// The problem of one event.
pub(super) struct Problem<'a> {
    log: &'a PedalLog,
    closed: ClosedLoop<'a>,
    options: &'a IdentifyOptions,
    /// Square root of the time that each row stands for, over its mean.
    weight: Vec<f64>,
    pub(super) mean_weight_s: f64,
    /// Rows that count.
    pub(super) compared: usize,
    pub(super) names: Vec<&'static str>,
    pub(super) bounds: Vec<[f64; 2]>,
    integral_range: [f64; 2],
    /// Set once no caller waits for an answer any more.
    stop: &'a AtomicBool,
}

impl<'a> Problem<'a> {
    pub(super) fn new(
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
        let (names, bounds) = boxes.into_iter().unzip();
        let closed = ClosedLoop::new(study, log);
        let weight = spans.iter().map(|span| (span / mean_weight_s).sqrt()).collect();
        Self {
            log,
            closed,
            options,
            weight,
            mean_weight_s,
            compared,
            names,
            bounds,
            integral_range,
            stop,
        }
    }

    pub(super) fn tolerances(&self) -> Tolerances {
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
            ControllerKind::Pid => Controller {
                proportional: x[0],
                integral: x[1],
                derivative: x[2],
                threshold_mps: None,
                set_speed_mps: x[3],
                start: x[4],
            },
            ControllerKind::Switched => Controller {
                proportional: x[0],
                threshold_mps: Some(x[1]),
                set_speed_mps: x[2],
                ..Controller::default()
            },
        }
    }

    /// A point of the box: gains evenly over the logarithm, the set speed around the mean.
    fn start(&self, index: u32) -> Vec<f64> {
        let part = |dimension: u32| f64::from(sobol_burley::sample(index, dimension, SCRAMBLE));
        let [slowest_mps, fastest_mps] = self.bounds[match self.options.controller {
            ControllerKind::Pid => 3,
            ControllerKind::Switched => 2,
        }];
        let mean_speed_mps = 0.5 * (slowest_mps + fastest_mps);
        let speed = mean_speed_mps + START_RANGE_MPS * (2.0 * part(0) - 1.0);
        // not the outermost corners of the box
        let log = |k: usize, dimension: u32| {
            let [lower, upper] = self.bounds[k];
            let (low, high) = (lower.max(0.02 * upper), 0.5 * upper);
            low * libm::exp(part(dimension) * libm::log(high / low))
        };
        let proportional = log(0, 1);
        match self.options.controller {
            ControllerKind::Pid => {
                let error = speed - self.closed.rolling.speed_mps;
                let start = self.closed.start_output - proportional * error;
                let [low, high] = self.integral_range;
                vec![proportional, log(1, 2), log(2, 3), speed, start.clamp(low, high)]
            }
            ControllerKind::Switched => vec![proportional, log(1, 2), speed],
        }
    }

    /// Where the searches start: the best of many points of the sequence.
    pub(super) fn starts(&self) -> Vec<Vec<f64>> {
        let wanted = self.options.starts.max(1);
        let points: Vec<Vec<f64>> =
            (0..wanted * CANDIDATES).map(|k| self.start(k as u32)).collect();
        let values: Vec<f64> = points.par_iter().map(|x| self.sum(x, &mut Vec::new())).collect();
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        order[..wanted].iter().map(|&k| points[k].clone()).collect()
    }

    pub(super) fn search(
        &self,
        start: &[f64],
        bounds: &[[f64; 2]],
        tolerances: &Tolerances,
    ) -> Optimum {
        let mut from = start.to_vec();
        if self.is_stopped() {
            return Optimum { parameters: from, ..Optimum::default() };
        }
        if self.options.controller == ControllerKind::Switched {
            let mut r = Vec::new();
            from = descend(&mut |x| self.sum(x, &mut r), start, bounds).0;
        }
        minimise(&mut |x, r| self.residuals(x, r), &from, bounds, tolerances)
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
        let drive = self.closed.drive(&controller);
        let mut step = 0;
        let start_s = self.log.time_s[0];
        for (k, time_s) in self.log.time_s.iter().enumerate() {
            let [accelerator, brake, speed_mps] = interpolated(&drive, time_s - start_s, &mut step);
            let weight = self.weight[k];
            r.push(weight * (self.log.accelerator[k] - accelerator));
            r.push(weight * (self.log.brake[k] - brake));
            let compared = match self.options.speed_term {
                SpeedTerm::None => continue,
                SpeedTerm::Measured => self.log.speed_mps[k],
                SpeedTerm::Simulated => speed_mps,
            };
            r.push(weight * (controller.set_speed_mps - compared) / SPEED_SCALE_MPS);
        }
    }

    /// Sum of squares of the pedals alone.
    pub(super) fn pedal_sum(&self, x: &[f64]) -> f64 {
        let mut r = Vec::new();
        self.residuals(x, &mut r);
        r.chunks(self.residuals_a_row()).map(|row| row[0] * row[0] + row[1] * row[1]).sum()
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn residuals_a_row(&self) -> usize {
        if self.options.speed_term == SpeedTerm::None { 2 } else { 3 }
    }

    /// Where the profile of parameter `k` has grown by 1.96² s², to one side; the bound where it
    /// does not before.
    pub(super) fn profile_end(
        &self,
        best: &Optimum,
        k: usize,
        side: f64,
        error: f64,
        deviation: f64,
    ) -> f64 {
        let value = best.parameters[k];
        let bound = self.bounds[k][usize::from(side > 0.0)];
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
            let here = value + side * away;
            let mut bounds = self.bounds.clone();
            bounds[k] = [here; 2];
            warm[k] = here;
            let optimum = self.search(&warm, &bounds, &tolerances);
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

    /// Why a parameter is not determined by the data.
    pub(super) fn verdict(&self, k: usize, fit: &DriverParameterFit) -> Option<&'static str> {
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
        if interval[0] <= self.bounds[k][0] && interval[1] >= self.bounds[k][1] {
            return Some("its interval is the whole box");
        }
        (width(interval) > WIDEST * size).then_some("its interval is wider than half of it")
    }
}

/// Accelerator, brake and speed of a drive at rising times, from step to step.
fn interpolated(drive: &EventSeries, time_s: f64, step: &mut usize) -> [f64; 3] {
    let times = &drive.time_s;
    if times.is_empty() {
        return [f64::NAN; 3];
    }
    while *step + 1 < times.len() && times[*step + 1] < time_s {
        *step += 1;
    }
    let (k, next) = (*step, (*step + 1).min(times.len() - 1));
    let width = times[next] - times[k];
    let part = if width > 0.0 { ((time_s - times[k]) / width).clamp(0.0, 1.0) } else { 0.0 };
    [&drive.accelerator, &drive.brake, &drive.speed_mps]
        .map(|values| values[k] + part * (values[next] - values[k]))
}
