//! The search for the best fit of an event: from many starts, around what they have found, and once
//! more with K_D free below 0.
//!
//! Starts are the best of many points (Sobol sequence, Owen-scrambled) within the box, and as many
//! others where one start alone has found the best optimum or where it does not explain the pedals.
//! Shifts of the gearbox cut the sum of squares into pieces, each with an optimum of its own. Where
//! fewer than half of the searches agree, more of them begin at the best of some points around the
//! best optimum, as far as its standard errors reach.
//!
//! A gain is not negative, but its estimate may be: noise moves it to both sides, and a box that
//! ends at 0 makes the mean of many too large. A K_D below 0 explains a driver who reacts late,
//! too. So the fit is tested with K_D at least 0 first. If it passes, all searches go on with K_D
//! free. If what they find passes, too, it is the fit; if not, the fit has no intervals.

use super::bounded_least_squares::Optimum;
use super::comparison::Comparison;
use super::event::PedalLog;
use super::fit_test::{FitTest, score};
use super::identify::{NORMAL_95, resolution_sd};
use super::options::{ControllerKind, IdentifyOptions, SpeedTerm};
use super::problem::{CANDIDATES, Problem};
use nalgebra::{DMatrix, DVector};
use ocmc_core::study::Study;
use rayon::prelude::*;
use std::sync::atomic::AtomicBool;

/// Fits with a sum of squares this close to the best are as good.
const AS_GOOD: f64 = 1e-3;
/// Rounds of starts.
const ROUNDS: usize = 2;
/// Looks around the best optimum, and searches of each [EJ].
const LOOKS: usize = 4;
const AROUND: usize = 4;
/// How far from it they begin along each direction, in standard errors [EJ].
const REACH: f64 = 2.5;
/// Share of the searches that have to agree [EJ].
const AGREED: f64 = 0.5;
/// Seed of the scrambling.
const SCRAMBLE: u32 = 2;

/// Where the searches of an event ended, and the best of it.
pub(super) struct Searched<'a> {
    pub(super) problem: Problem<'a>,
    /// Optima of the starts, then of the looks around.
    pub(super) optima: Vec<Optimum>,
    /// How many of them are of starts.
    pub(super) starts: usize,
    pub(super) best: Best,
}

impl<'a> Searched<'a> {
    /// Searches; what it gives once `stop` is set has no meaning.
    pub(super) fn of(
        study: &'a Study,
        log: &'a PedalLog,
        options: IdentifyOptions,
        mass: Option<[f64; 2]>,
        stop: &'a AtomicBool,
    ) -> Self {
        let problem = Problem::new(study, log, options, mass, stop);
        let (mut optima, mut best) = (Vec::new(), Best::default());
        let wanted = options.starts.max(1);
        for round in 0..ROUNDS {
            // the truck that is expected leads half of them through the shifts of its gearbox
            let led = if round == 0 && problem.has_priors() { wanted.div_ceil(2) } else { 0 };
            let expected = problem.expected_bounds();
            let points = problem.starts(round, led, &expected);
            let led_to = ends(&problem, &points, &expected).into_iter();
            let mut from: Vec<Vec<f64>> = led_to.map(|end| end.parameters).collect();
            if problem.is_stopped() {
                break;
            }
            from.extend(problem.starts(round, wanted - led, &problem.bounds));
            optima.extend(ends(&problem, &from, &problem.bounds));
            if problem.is_stopped() {
                break;
            }
            best = Best::of(&problem, &optima);
            let agreed = best.good.len() > 1 || options.starts == 1;
            if agreed && best.misfits.is_empty() {
                break;
            }
        }
        let starts = optima.len();
        let mut within = Self { problem, optima, starts, best }.looked_around();
        match within.free(study, log, mass, stop) {
            Some(free) if free.best.misfits.is_empty() => free,
            // the bound of K_D alone has hidden that the fit does not explain the pedals
            Some(free) => {
                within.best.misfits = free.best.misfits;
                within
            }
            None => within,
        }
    }

    /// With what is found around the best optimum: until enough searches agree, and once where it
    /// does not explain the pedals.
    fn looked_around(mut self) -> Self {
        let options = self.problem.options;
        if options.starts == 1 || !is_smooth(&options) {
            return self;
        }
        for look in 0..LOOKS {
            if self.problem.is_stopped() {
                break;
            }
            let agreed = self.best.good.len() as f64 >= AGREED * self.optima.len() as f64;
            let explained = look > 0 || self.best.misfits.is_empty();
            if agreed && explained {
                break;
            }
            let deviation = self.best.test.deviation(resolution_sd(&options));
            let points = around(&self.problem, self.best(), deviation, look);
            self.optima.extend(ends(&self.problem, &points, &self.problem.bounds));
            self.best = Best::of(&self.problem, &self.optima);
        }
        self
    }

    /// The same with K_D free below 0, where the fit passes.
    fn free(
        &self,
        study: &'a Study,
        log: &'a PedalLog,
        mass: Option<[f64; 2]>,
        stop: &'a AtomicBool,
    ) -> Option<Self> {
        let options = self.problem.options;
        let [least, most] = options.derivative;
        // a delay explains what a K_D below 0 does
        let may_be = is_smooth(&options) && !options.unknown.delay && least == 0.0;
        if !may_be || !self.best.misfits.is_empty() || self.problem.is_stopped() {
            return None;
        }
        let options = IdentifyOptions { derivative: [-most, most], ..options };
        let problem = Problem::new(study, log, options, mass, stop);
        let from: Vec<Vec<f64>> = self.optima.iter().map(|end| end.parameters.clone()).collect();
        let optima = ends(&problem, &from, &problem.bounds);
        let best = Best::of(&problem, &optima);
        let free = Self { problem, optima, starts: self.starts, best }.looked_around();
        let gain = free.problem.names.iter().position(|name| *name == "kd")?;
        let inside = !free.problem.is_at_bound(gain, &free.best().parameters);
        inside.then_some(free)
    }

    fn best(&self) -> &Optimum {
        &self.optima[self.best.good[0]]
    }
}

/// Whether the residuals are those of a PID without a speed term: their derivatives tell how sure
/// the parameters are.
pub(super) fn is_smooth(options: &IdentifyOptions) -> bool {
    options.controller == ControllerKind::Pid && options.speed_term == SpeedTerm::None
}

/// Where the searches from some points end, within these bounds.
fn ends(problem: &Problem, points: &[Vec<f64>], bounds: &[[f64; 2]]) -> Vec<Optimum> {
    let tolerances = problem.tolerances();
    let search = |point: &Vec<f64>| problem.search(point, bounds, &tolerances);
    points.par_iter().map(search).collect()
}

/// Where to search around an optimum: the best of some points of an even cloud, of the shape that
/// the derivatives and the scatter of the residuals give the estimates.
fn around(problem: &Problem, optimum: &Optimum, deviation: f64, look: usize) -> Vec<Vec<f64>> {
    let count = optimum.parameters.len();
    let identity = DMatrix::identity(count, count);
    let upper = optimum.jacobian.clone().qr().r();
    let Some(directions) = upper.solve_upper_triangular(&identity) else {
        return Vec::new();
    };
    let point = |index: usize| -> Vec<f64> {
        let part = |k: usize| f64::from(sobol_burley::sample(index as u32, k as u32, SCRAMBLE));
        let along = DVector::from_fn(count, |k, _| REACH * deviation * (2.0 * part(k) - 1.0));
        let away = &directions * along;
        let moved = |k: usize| {
            let [lower, upper] = problem.bounds[k];
            (optimum.parameters[k] + away[k]).clamp(lower, upper)
        };
        (0..count).map(moved).collect()
    };
    let all = AROUND * CANDIDATES;
    let points: Vec<Vec<f64>> = (look * all..(look + 1) * all).map(point).collect();
    problem.best_of(&points, AROUND)
}

/// The best of some optima, and whether it explains the pedals.
#[derive(Default)]
pub(super) struct Best {
    /// Places of the optima that are as good, the best one first.
    pub(super) good: Vec<usize>,
    pub(super) comparison: Comparison,
    pub(super) test: FitTest,
    pub(super) misfits: Vec<String>,
}

impl Best {
    fn of(problem: &Problem, optima: &[Optimum]) -> Self {
        let options = &problem.options;
        let mut order: Vec<usize> = (0..optima.len()).collect();
        order.sort_by(|&a, &b| optima[a].sum_of_squares.total_cmp(&optima[b].sum_of_squares));
        let best = &optima[order[0]];
        let comparison = problem.compare(&best.parameters);
        let (residuals, columns, [late, heavy]) = problem.scores(&best.parameters);
        // the residuals of a switched driver jump: a step says nothing about what is missing
        let jumps = options.controller == ControllerKind::Switched;
        let score_of = |unknown: bool, extra: &[f64]| {
            if unknown || jumps { None } else { score(&residuals, &columns, extra) }
        };
        let scores =
            [score_of(options.unknown.delay, &late), score_of(options.unknown.mass, &heavy)];
        let (least, count) = (resolution_sd(options), best.parameters.len());
        let test = FitTest::of(&comparison.rows, problem.noise, least, count, scores);
        let growth = NORMAL_95 * test.deviation(least);
        let growth = growth * growth;
        let sum = best.sum_of_squares;
        let limit = (sum * (1.0 + AS_GOOD)).max(sum + 0.01 * growth);
        order.retain(|&place| optima[place].sum_of_squares <= limit);
        let mut misfits = test.misfits();
        misfits.extend(problem.edges(&best.parameters));
        Self { good: order, comparison, test, misfits }
    }
}
