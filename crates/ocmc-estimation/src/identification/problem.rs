//! The least-squares problem of one event: residuals of the pedals in closed loop, where the search
//! starts, how far a parameter may move.
//!
//! Each pedal counts in units of its sensor's noise. Beside controller and set speed the start is
//! estimated: the integral part, which no log contains, and the speed, of which the first second of
//! the log is one more measurement. So is what is known before of the delay, the mass and the
//! resistance, where they are estimated.

use super::bounded_least_squares::{Optimum, Tolerances, minimise};
use super::closed_loop::{ClosedLoop, Controller};
use super::comparison::{Comparison, interpolated};
use super::compass_search::descend;
use super::event::PedalLog;
use super::fit_test::ComparedRow;
use super::noise::pedal_noise_sd;
use super::options::{ControllerKind, IdentifyOptions, SpeedTerm};
use super::truck_prior::TruckPrior;
use ocmc_core::kernel::drive::pedal_event::EventSeries;
use ocmc_core::lanes::WIDTH;
use ocmc_core::study::Study;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Scale of the speed term, in m/s (paper).
const SPEED_SCALE_MPS: f64 = 20.0;
/// Half width of the box of the set speed around the mean speed, in m/s.
const SET_SPEED_RANGE_MPS: f64 = 4.0;
/// The starts scatter the set speed within this, in m/s.
const START_RANGE_MPS: f64 = 1.0;
/// Time at the start in which pedals are not compared, in s.
const NOT_COMPARED_S: f64 = 1.0;
/// Half width of the box of the speed at the start, in standard errors of the log's.
const START_SPEED_ERRORS: f64 = 6.0;
/// Latest reaction that is looked for, in s [EJ].
pub(super) const LATEST_S: f64 = 2.0;
/// Largest mass that is looked for, as a multiple of the study's [EJ].
const HEAVIEST: f64 = 2.0;
/// Standard deviation of how late a driver may be before the log says so, in s [EJ].
const DELAY_SD_S: f64 = 0.3;
/// Bounds of the resistance above the study's, as a share of it [EJ].
const LARGEST_SHARE: [f64; 2] = [-0.5, 1.0];
/// Steps of the derivatives by delay, in s, and by mass, as a share of it.
const DELAY_STEP_S: f64 = 0.1;
const MASS_STEP: f64 = 0.01;
/// Points for each start among which the starts are the best: shifts of the gearbox and switched
/// drivers leave jumps in the residuals, behind which a search does not see.
pub(super) const CANDIDATES: usize = 16;
/// Seed of the scrambling.
const SCRAMBLE: u32 = 1;

/// The problem of one event.
pub(super) struct Problem<'a> {
    log: &'a PedalLog,
    pub(super) closed: ClosedLoop<'a>,
    pub(super) options: IdentifyOptions,
    /// Square root of the time that each row stands for, over its mean.
    weight: Vec<f64>,
    mean_weight_s: f64,
    /// Noise of accelerator and brake, at least their resolution.
    pub(super) noise: [f64; 2],
    pub(super) names: Vec<&'static str>,
    pub(super) bounds: Vec<[f64; 2]>,
    integral_range: [f64; 2],
    /// Knowledge of parameters before the log: place, expected value and standard deviation.
    priors: Vec<(usize, [f64; 2])>,
    /// Set once no caller waits for an answer any more.
    stop: &'a AtomicBool,
}

impl<'a> Problem<'a> {
    /// `mass`: what is known of the mass before the log is read, in kg, and its standard deviation;
    /// none: what the study says.
    pub(super) fn new(
        study: &'a Study,
        log: &'a PedalLog,
        options: IdentifyOptions,
        mass: Option<[f64; 2]>,
        stop: &'a AtomicBool,
    ) -> Self {
        let rows = log.time_s.len();
        let time = |k: usize| log.time_s[k.min(rows - 1)];
        // what engine, filter and a driver who sees late knew at the start is gone after a second
        // each: it is not compared
        let late_s = if options.unknown.delay { NOT_COMPARED_S } else { 0.0 };
        let begin_s = log.time_s[0] + NOT_COMPARED_S + late_s;
        let span = |k: usize| 0.5 * (time(k + 1) - time(k.saturating_sub(1)));
        let spans: Vec<f64> =
            (0..rows).map(|k| if time(k) < begin_s { 0.0 } else { span(k) }).collect();
        let compared = spans.iter().filter(|span| **span > 0.0).count();
        let mean_weight_s = spans.iter().sum::<f64>() / compared.max(1) as f64;
        let mean_speed_mps = log.speed_mps.iter().sum::<f64>() / rows as f64;
        let pid = &study.model().driver.pedals.pid;
        let integral_range = [pid.integral_minimum, pid.integral_maximum];
        let speed = [mean_speed_mps - SET_SPEED_RANGE_MPS, mean_speed_mps + SET_SPEED_RANGE_MPS];
        let closed = ClosedLoop::new(study, log);
        let [start_mps, error_mps] = closed.start.speed_mps;
        let room_mps = START_SPEED_ERRORS * error_mps;
        let mut boxes = match options.controller {
            ControllerKind::Pid => vec![
                ("kp", options.proportional),
                ("ki", options.integral),
                ("kd", options.derivative),
                ("set_speed_mps", speed),
                ("start_integral", integral_range),
                ("start_speed_mps", [start_mps - room_mps, start_mps + room_mps]),
            ],
            ControllerKind::Switched => vec![
                ("kp", options.proportional),
                ("threshold_mps", options.threshold_mps),
                ("set_speed_mps", speed),
            ],
        };
        let mut priors = Vec::new();
        let mut unknown = |name, bounds, prior| {
            priors.push((boxes.len(), prior));
            boxes.push((name, bounds));
        };
        let truck = TruckPrior::of(study);
        if options.unknown.delay {
            unknown("delay_s", [0.0, LATEST_S], [0.0, DELAY_SD_S]);
        }
        if options.unknown.mass {
            let [mass_kg, empty_kg] = closed.masses_kg();
            let bounds = [empty_kg, HEAVIEST * mass_kg];
            let of_study = [mass_kg, truck.mass_sd_share * mass_kg];
            unknown("mass_kg", bounds, mass.unwrap_or(of_study));
        }
        if options.unknown.resistance {
            unknown("resistance_share", LARGEST_SHARE, [0.0, truck.resistance_sd_share]);
        }
        let (names, bounds) = boxes.into_iter().unzip();
        let least = options.resolution / 12.0f64.sqrt();
        let noise = [&log.accelerator, &log.brake].map(|pedal| pedal_noise_sd(pedal).max(least));
        let noise = match options.speed_term {
            SpeedTerm::None => noise,
            // the paper's objective weighs both pedals and the speed term alike
            SpeedTerm::Measured | SpeedTerm::Simulated => [noise[0].max(noise[1]); 2],
        };
        let weight = spans.iter().map(|span| (span / mean_weight_s).sqrt()).collect();
        Self {
            log,
            closed,
            options,
            weight,
            mean_weight_s,
            noise,
            names,
            bounds,
            integral_range,
            priors,
            stop,
        }
    }

    /// Mass of the study's truck, in kg.
    pub(super) fn mass_kg(&self) -> f64 {
        self.closed.masses_kg()[0]
    }

    pub(super) fn tolerances(&self) -> Tolerances {
        let difference = match self.options.controller {
            ControllerKind::Pid => 1e-4,
            // the moments at which a switched driver acts move by whole steps
            ControllerKind::Switched => 2e-3,
        };
        Tolerances { gain: 1e-8, step: 1e-7, most_iterations: 60, difference }
    }

    /// A parameter, where it is one.
    fn value(&self, x: &[f64], name: &str) -> Option<f64> {
        self.names.iter().position(|known| *known == name).map(|k| x[k])
    }

    /// The controller of some parameters.
    fn controller(&self, x: &[f64]) -> Controller {
        let value_of = |name| self.value(x, name);
        Controller {
            proportional: x[0],
            integral: value_of("ki").unwrap_or(0.0),
            derivative: value_of("kd").unwrap_or(0.0),
            threshold_mps: value_of("threshold_mps"),
            set_speed_mps: value_of("set_speed_mps").expect("each controller has one"),
            start: value_of("start_integral").unwrap_or(0.0),
            start_speed_mps: value_of("start_speed_mps").unwrap_or(self.closed.rolling.speed_mps),
            delay_s: value_of("delay_s").unwrap_or(0.0),
            mass_kg: value_of("mass_kg"),
            resistance_share: value_of("resistance_share").unwrap_or(0.0),
        }
    }

    /// Whether anything beside the controller is estimated.
    pub(super) fn has_priors(&self) -> bool {
        !self.priors.is_empty()
    }

    /// The bounds with what is unknown beside the controller held where it is expected.
    pub(super) fn expected_bounds(&self) -> Vec<[f64; 2]> {
        let mut bounds = self.bounds.clone();
        self.priors.iter().for_each(|(k, [expected, _])| bounds[*k] = [*expected; 2]);
        bounds
    }

    /// Value expected of a parameter before the log is read, and its standard deviation.
    pub(super) fn prior(&self, name: &str) -> Option<(usize, [f64; 2])> {
        self.priors.iter().copied().find(|(k, _)| self.names[*k] == name)
    }

    /// An unknown beside the gains, of a controller.
    fn value_of(&self, controller: &Controller, name: &str) -> f64 {
        match name {
            "delay_s" => controller.delay_s,
            "mass_kg" => controller.mass_kg.unwrap_or(self.mass_kg()),
            _ => controller.resistance_share,
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
        let start_mps = self.closed.rolling.speed_mps;
        let mut point = match self.options.controller {
            ControllerKind::Pid => {
                let start = self.closed.start_output - proportional * (speed - start_mps);
                let [low, high] = self.integral_range;
                let start = start.clamp(low, high);
                vec![proportional, log(1, 2), log(2, 3), speed, start, start_mps]
            }
            ControllerKind::Switched => vec![proportional, log(1, 2), speed],
        };
        // dimensions of their own: the same points with and without
        point.extend(self.priors.iter().map(|(k, [expected, sd])| match self.names[*k] {
            "delay_s" => sd * part(4),
            "mass_kg" => expected + sd * (2.0 * part(5) - 1.0),
            _ => *expected,
        }));
        point
    }

    /// Where the searches of a round start: the best of many points of the sequence, put within
    /// `bounds`.
    pub(super) fn starts(&self, round: usize, wanted: usize, bounds: &[[f64; 2]]) -> Vec<Vec<f64>> {
        let all = wanted * CANDIDATES;
        let within = |k: usize| -> Vec<f64> {
            let point = self.start(k as u32);
            point.iter().zip(bounds).map(|(value, [low, high])| value.clamp(*low, *high)).collect()
        };
        let points: Vec<Vec<f64>> = (round * all..(round + 1) * all).map(within).collect();
        self.best_of(&points, wanted)
    }

    /// The best of some points.
    pub(super) fn best_of(&self, points: &[Vec<f64>], wanted: usize) -> Vec<Vec<f64>> {
        let values: Vec<f64> =
            points.par_chunks(WIDTH).flat_map_iter(|points| self.sums(points)).collect();
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
            from = descend(&mut |points| self.sums(points), start, bounds).0;
        }
        minimise(&mut |points| self.residuals(points), &from, bounds, tolerances)
    }

    /// Sums of squares.
    fn sums(&self, points: &[Vec<f64>]) -> Vec<f64> {
        let sum = |r: &Vec<f64>| r.iter().map(|value| value * value).sum();
        self.residuals(points).iter().map(sum).collect()
    }

    /// The residuals of some points.
    pub(super) fn residuals(&self, points: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let controllers: Vec<Controller> = points.iter().map(|x| self.controller(x)).collect();
        self.residuals_of(&self.closed, &controllers)
    }

    /// Residuals in units of their noise, for each controller: of each row both pedals and the
    /// speed term, at last the speed at the start and what else is known before.
    fn residuals_of(&self, closed: &ClosedLoop, controllers: &[Controller]) -> Vec<Vec<f64>> {
        let a_row = if self.options.speed_term == SpeedTerm::None { 2 } else { 3 };
        let rows = self.log.time_s.len() * a_row + 1 + self.priors.len();
        if self.is_stopped() {
            // a sum of squares of 0 ends every search
            return vec![vec![0.0; rows]; controllers.len()];
        }
        let drives = closed.drive_each(controllers);
        let start_s = self.log.time_s[0];
        let residuals = |(controller, drive): (&Controller, &EventSeries)| {
            let mut r = Vec::with_capacity(rows);
            let mut step = 0;
            for (k, time_s) in self.log.time_s.iter().enumerate() {
                let [accelerator, brake, speed_mps] =
                    interpolated(drive, time_s - start_s, &mut step);
                let weight = self.weight[k];
                r.push(weight * (self.log.accelerator[k] - accelerator) / self.noise[0]);
                r.push(weight * (self.log.brake[k] - brake) / self.noise[1]);
                let compared = match self.options.speed_term {
                    SpeedTerm::None => continue,
                    SpeedTerm::Measured => self.log.speed_mps[k],
                    SpeedTerm::Simulated => speed_mps,
                };
                let share = (controller.set_speed_mps - compared) / SPEED_SCALE_MPS;
                r.push(weight * share / self.noise[0]);
            }
            let [start_mps, error_mps] = self.closed.start.speed_mps;
            r.push((controller.start_speed_mps - start_mps) / error_mps);
            r.extend(self.priors.iter().map(|(k, [expected, sd])| {
                (self.value_of(controller, self.names[*k]) - expected) / sd
            }));
            r
        };
        controllers.iter().zip(&drives).map(residuals).collect()
    }

    /// How the drive with these parameters compares with the log.
    pub(super) fn compare(&self, x: &[f64]) -> Comparison {
        let controller = self.controller(x);
        let mut comparison = Comparison::default();
        if self.is_stopped() {
            return comparison;
        }
        let drive = self.closed.drive(&controller);
        let (mut step, mut pedals, mut speeds, mut objective) = (0, 0.0, 0.0, 0.0);
        let start_s = self.log.time_s[0];
        for (k, time_s) in self.log.time_s.iter().enumerate() {
            let [accelerator, brake, speed_mps] = interpolated(&drive, time_s - start_s, &mut step);
            if self.weight[k] == 0.0 {
                continue;
            }
            let measured = [self.log.accelerator[k], self.log.brake[k]];
            let row = ComparedRow { time_s: *time_s, measured, simulated: [accelerator, brake] };
            let [away, braked] = [measured[0] - accelerator, measured[1] - brake];
            let square = away * away + braked * braked;
            let error_mps = self.log.speed_mps[k] - speed_mps;
            let term = match self.options.speed_term {
                SpeedTerm::None => 0.0,
                SpeedTerm::Measured => controller.set_speed_mps - self.log.speed_mps[k],
                SpeedTerm::Simulated => controller.set_speed_mps - speed_mps,
            };
            pedals += square;
            speeds += error_mps * error_mps;
            let term = term / SPEED_SCALE_MPS;
            objective += self.weight[k] * self.weight[k] * (square + term * term);
            comparison.rows.push(row);
        }
        let rows = comparison.rows.len().max(1) as f64;
        comparison.pedal_rms = (pedals / (2.0 * rows)).sqrt();
        comparison.speed_rms_mps = (speeds / rows).sqrt();
        comparison.objective = objective * self.mean_weight_s;
        comparison
    }

    /// By how much inputs that are wrong by one standard error each move the residuals.
    pub(super) fn input_errors(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let controller = self.controller(x);
        let residuals_with = |closed: &ClosedLoop| {
            self.residuals_of(closed, &[controller]).pop().expect("one drive has its residuals")
        };
        let here = residuals_with(&self.closed);
        let moved = self.closed.one_error_off(self.log);
        let less = |other: ClosedLoop| {
            residuals_with(&other).iter().zip(&here).map(|(a, b)| a - b).collect()
        };
        moved.into_iter().map(less).collect()
    }

    /// Residuals, their derivatives by the parameters that are free, and those by the delay and by
    /// the logarithm of the mass: what a score test needs.
    pub(super) fn scores(&self, x: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>, [Vec<f64>; 2]) {
        let here = self.controller(x);
        let mass_kg = here.mass_kg.unwrap_or(self.mass_kg());
        let of_mass = |factor: f64| Controller { mass_kg: Some(factor * mass_kg), ..here };
        let late = Controller { delay_s: here.delay_s + DELAY_STEP_S, ..here };
        let mut controllers = vec![here, late, of_mass(1.0 - MASS_STEP), of_mass(1.0 + MASS_STEP)];
        let mut widths = Vec::new();
        for (k, [lower, upper]) in self.bounds.iter().enumerate() {
            let step = self.tolerances().difference * x[k].abs().max(1e-3 * (upper - lower));
            if x[k] - step > *lower && x[k] + step < *upper {
                let at = |value: f64| {
                    let mut moved = x.to_vec();
                    moved[k] = value;
                    self.controller(&moved)
                };
                controllers.extend([at(x[k] - step), at(x[k] + step)]);
                widths.push(2.0 * step);
            }
        }
        let slope = |low: &[f64], high: &[f64], wide: f64| -> Vec<f64> {
            low.iter().zip(high).map(|(low, high)| (high - low) / wide).collect()
        };
        let mut residuals = self.residuals_of(&self.closed, &controllers);
        let columns = residuals[4..].as_chunks().0.iter().zip(widths);
        let columns = columns.map(|([low, high], wide)| slope(low, high, wide)).collect();
        let extra = [
            slope(&residuals[0], &residuals[1], DELAY_STEP_S),
            slope(&residuals[2], &residuals[3], 2.0 * MASS_STEP),
        ];
        (residuals.swap_remove(0), columns, extra)
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}
