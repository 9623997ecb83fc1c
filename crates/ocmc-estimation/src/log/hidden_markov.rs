//! The hidden Markov detector: three states along the way, left, straight and right, and Viterbi's
//! most likely path.
//!
//! Emissions of the curvature κ of a cell: straight Laplace(0, b); a curve to the left (right) has
//! κ (−κ) log-normal, truncated to [1/1000, 1/8] 1/m, and with a small share the straight's law, so
//! that no single cell rules a curve out. Transitions over a cell of length d: a curve starts with
//! probability d λ, ends with d / L, and turns into one of the other direction with 10⁻⁴.
//!
//! The detector of the paper works on lateral acceleration over time (Maghsood, 2016); states along
//! the way and the numbers here are our judgement. With [`HiddenMarkov::trained`] b, λ, L and the
//! log-normal law come from the log itself, by expectation and maximisation (Baum-Welch); the
//! truncation is left out of the maximisation.

use serde::Serialize;
use std::f64::consts::{PI, SQRT_2};

/// Number of states: left, straight, right.
const STATES: usize = 3;
/// Directions of the states.
const DIRECTIONS: [i8; STATES] = [1, 0, -1];
/// Share of a curve's cells that look like a straight.
const OUTLIER_SHARE: f64 = 0.01;
/// Most rounds of the training, and the gain of the log-likelihood per cell below which it ends.
const MOST_ROUNDS: usize = 50;
const SMALLEST_GAIN: f64 = 1e-6;
/// A straight's scale is not trained below this, in 1/m: a signal without noise would make every
/// bend of 10 km a curve.
const SMALLEST_SCALE_PER_M: f64 = 1e-4;

/// Laws of the three states.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HiddenMarkov {
    /// Scale b of a straight's curvature, in 1/m.
    pub straight_scale_per_m: f64,
    /// Median of a curve's curvature, in 1/m.
    pub curve_median_per_m: f64,
    /// Standard deviation of the logarithm of a curve's curvature.
    pub curve_log_sd: f64,
    /// Smallest curvature of a curve, in 1/m.
    pub curve_minimum_per_m: f64,
    /// Largest curvature of a curve, in 1/m.
    pub curve_maximum_per_m: f64,
    /// Curves to both sides for each m of straight.
    pub curves_per_m: f64,
    /// Mean length of a curve, in m.
    pub curve_length_m: f64,
    /// Probability that a curve's next cell belongs to a curve of the other direction.
    pub reversal: f64,
}

impl Default for HiddenMarkov {
    fn default() -> Self {
        Self {
            straight_scale_per_m: 1.0 / 2500.0,
            curve_median_per_m: 1.0 / 120.0,
            curve_log_sd: 1.0,
            curve_minimum_per_m: 1.0 / 1000.0,
            curve_maximum_per_m: 1.0 / 8.0,
            curves_per_m: 1.2e-3,
            curve_length_m: 120.0,
            reversal: 1e-4,
        }
    }
}

/// Result of the training.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Training {
    /// The trained laws.
    pub model: HiddenMarkov,
    /// Rounds.
    pub rounds: usize,
    /// Whether the likelihood stopped to grow.
    pub converged: bool,
    /// Logarithm of the likelihood.
    pub log_likelihood: f64,
}

/// Sums over the posterior of the states.
#[derive(Clone, Copy, Debug, Default)]
struct Expected {
    straight_cells: f64,
    straight_sum: f64,
    curve_cells: f64,
    curve_log_sum: f64,
    curve_log_squares: f64,
    starts: f64,
    from_straight: f64,
    ends: f64,
    from_curve: f64,
    log_likelihood: f64,
}

impl HiddenMarkov {
    /// Direction of the curve that each cell lies in, by the most likely path: 1 left, −1 right, 0
    /// none.
    pub fn directions(&self, curvature_per_m: &[f64], cell_m: f64) -> Vec<i8> {
        let transition = self.transition(cell_m).map(|row| row.map(libm::log));
        let densities = self.densities();
        let mut from: Vec<[u8; STATES]> = Vec::with_capacity(curvature_per_m.len());
        let mut score = self.start(cell_m).map(libm::log);
        for (k, curvature) in curvature_per_m.iter().enumerate() {
            let density = densities(*curvature).map(libm::log);
            let mut back = [0; STATES];
            if k > 0 {
                let mut next = [f64::NEG_INFINITY; STATES];
                for to in 0..STATES {
                    for state in 0..STATES {
                        let through = score[state] + transition[state][to];
                        if through > next[to] {
                            (next[to], back[to]) = (through, state as u8);
                        }
                    }
                }
                score = next;
            }
            for (score, density) in score.iter_mut().zip(density) {
                *score += density;
            }
            from.push(back);
        }
        let mut state =
            (0..STATES).max_by(|&a, &b| score[a].total_cmp(&score[b])).expect("there are three");
        let mut directions = vec![0; curvature_per_m.len()];
        for k in (0..curvature_per_m.len()).rev() {
            directions[k] = DIRECTIONS[state];
            state = from[k][state] as usize;
        }
        directions
    }

    /// Fits the laws to the curvature of some pieces.
    pub fn trained(&self, pieces: &[&[f64]], cell_m: f64) -> Training {
        let cells: usize = pieces.iter().map(|piece| piece.len()).sum();
        let mut training = Training {
            model: *self,
            rounds: 0,
            converged: false,
            log_likelihood: f64::NEG_INFINITY,
        };
        while training.rounds < MOST_ROUNDS {
            let mut sums = Expected::default();
            for piece in pieces {
                training.model.expect(piece, cell_m, &mut sums);
            }
            training.rounds += 1;
            let gain = sums.log_likelihood - training.log_likelihood;
            training.log_likelihood = sums.log_likelihood;
            if gain < SMALLEST_GAIN * cells as f64 {
                training.converged = true;
                break;
            }
            training.model = training.model.maximised(&sums, cell_m);
        }
        training
    }

    /// The laws that fit the expected states best; what a log does not show stays.
    fn maximised(&self, sums: &Expected, cell_m: f64) -> Self {
        let mut model = *self;
        if sums.straight_cells > 0.0 {
            let scale = sums.straight_sum / sums.straight_cells;
            model.straight_scale_per_m = scale.max(SMALLEST_SCALE_PER_M);
        }
        if sums.curve_cells > 1.0 {
            let mean = sums.curve_log_sum / sums.curve_cells;
            let variance = sums.curve_log_squares / sums.curve_cells - mean * mean;
            let log_range = [self.curve_minimum_per_m, self.curve_maximum_per_m].map(libm::log);
            model.curve_median_per_m = libm::exp(mean.clamp(log_range[0], log_range[1]));
            model.curve_log_sd = variance.max(0.0).sqrt().max(0.1);
        }
        if sums.starts > 0.0 && sums.ends > 0.0 {
            let most = 0.2 / cell_m;
            model.curves_per_m = (sums.starts / sums.from_straight / cell_m).min(most);
            model.curve_length_m = (cell_m * sums.from_curve / sums.ends).max(2.0 * cell_m);
        }
        model
    }

    /// Adds the posterior of one piece, by the forward and backward recursions with scaling.
    fn expect(&self, curvature_per_m: &[f64], cell_m: f64, sums: &mut Expected) {
        let n = curvature_per_m.len();
        if n == 0 {
            return;
        }
        let transition = self.transition(cell_m);
        let density: Vec<[f64; STATES]> =
            curvature_per_m.iter().copied().map(self.densities()).collect();
        let mut forward: Vec<[f64; STATES]> = Vec::with_capacity(n);
        let mut scale = Vec::with_capacity(n);
        for k in 0..n {
            let mut now = if k == 0 {
                self.start(cell_m)
            } else {
                let before = forward[k - 1];
                std::array::from_fn(|to| (0..STATES).map(|s| before[s] * transition[s][to]).sum())
            };
            for state in 0..STATES {
                now[state] *= density[k][state];
            }
            let total: f64 = now.iter().sum();
            scale.push(total);
            sums.log_likelihood += libm::log(total);
            forward.push(now.map(|p| p / total));
        }
        let mut backward = [1.0; STATES];
        for k in (0..n).rev() {
            let posterior: [f64; STATES] = std::array::from_fn(|s| forward[k][s] * backward[s]);
            let size = curvature_per_m[k].abs();
            sums.straight_cells += posterior[1];
            sums.straight_sum += posterior[1] * size;
            if size >= self.curve_minimum_per_m {
                let (curve, log) = (posterior[0] + posterior[2], libm::log(size));
                sums.curve_cells += curve;
                sums.curve_log_sum += curve * log;
                sums.curve_log_squares += curve * log * log;
            }
            if k == 0 {
                break;
            }
            let before = forward[k - 1];
            let mut earlier = [0.0; STATES];
            for (from, value) in earlier.iter_mut().enumerate() {
                for to in 0..STATES {
                    let step = transition[from][to] * density[k][to] * backward[to] / scale[k];
                    *value += step;
                    let share = before[from] * step;
                    if from == 1 {
                        sums.from_straight += share;
                        sums.starts += if to == 1 { 0.0 } else { share };
                    } else {
                        sums.from_curve += share;
                        sums.ends += if to == 1 { share } else { 0.0 };
                    }
                }
            }
            backward = earlier;
        }
    }

    /// Probabilities of the next cell's state, by state.
    fn transition(&self, cell_m: f64) -> [[f64; STATES]; STATES] {
        let start = 0.5 * cell_m * self.curves_per_m;
        let end = cell_m / self.curve_length_m;
        let stay = 1.0 - end - self.reversal;
        [[stay, end, self.reversal], [start, 1.0 - 2.0 * start, start], [self.reversal, end, stay]]
    }

    /// Probabilities of the first cell's state: the long-run shares.
    fn start(&self, cell_m: f64) -> [f64; STATES] {
        let curve = self.curves_per_m * self.curve_length_m.max(cell_m);
        let share = 0.5 * curve / (1.0 + curve);
        [share, 1.0 - 2.0 * share, share]
    }

    /// Densities of a curvature, by state.
    fn densities(&self) -> impl Fn(f64) -> [f64; STATES] {
        let model = *self;
        let standard = move |curvature: f64| {
            libm::log(curvature / model.curve_median_per_m) / model.curve_log_sd
        };
        let below = |curvature: f64| 0.5 * libm::erfc(-standard(curvature) / SQRT_2);
        // probability that the truncation leaves
        let inside = below(model.curve_maximum_per_m) - below(model.curve_minimum_per_m);
        let inside = inside.max(1e-12);
        let range = model.curve_minimum_per_m..=model.curve_maximum_per_m;
        let b = model.straight_scale_per_m;
        move |curvature: f64| {
            // not below what can be divided by
            let straight = libm::exp(-curvature.abs() / b).max(1e-290) / (2.0 * b);
            let curve = |curvature: f64| {
                let law = if range.contains(&curvature) {
                    let z = standard(curvature);
                    let spread = curvature * model.curve_log_sd * (2.0 * PI).sqrt() * inside;
                    libm::exp(-0.5 * z * z) / spread
                } else {
                    0.0
                };
                (1.0 - OUTLIER_SHARE) * law + OUTLIER_SHARE * straight
            };
            [curve(curvature), straight, curve(-curvature)]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    /// Curves of `median_m`, `length` cells, every `gap` cells, with Laplace noise.
    fn road(seed: u64, cells: usize, noise_per_m: f64) -> (Vec<f64>, Vec<i8>) {
        let mut draws = Draws::new(seed, 0, Stream::Curve);
        let mut truth = Vec::new();
        let mut curvature = Vec::new();
        while truth.len() < cells {
            let gap = (draws.exponential() * 100.0) as usize + 5;
            truth.extend(vec![0; gap]);
            curvature.extend(vec![0.0; gap]);
            let length = (draws.exponential() * 20.0) as usize + 4;
            let side: i8 = if draws.happens(0.5) { 1 } else { -1 };
            let size = libm::exp(0.5 * draws.normal()) / 150.0;
            truth.extend(vec![side; length]);
            curvature.extend(vec![f64::from(side) * size; length]);
        }
        for value in &mut curvature {
            let side = if draws.happens(0.5) { 1.0 } else { -1.0 };
            *value += side * noise_per_m * draws.exponential();
        }
        (curvature, truth)
    }

    #[test]
    fn finds_the_states_of_a_noisy_road() {
        for seed in 1..=3 {
            let (curvature, truth) = road(seed, 20_000, 5e-4);
            let directions = HiddenMarkov::default().directions(&curvature, 5.0);
            let wrong = directions.iter().zip(&truth).filter(|(a, b)| a != b).count();
            assert!((wrong as f64) < 0.005 * truth.len() as f64, "{wrong} of {}", truth.len());
        }
    }

    #[test]
    fn training_finds_the_laws_of_the_road() {
        for seed in 1..=3 {
            let (curvature, truth) = road(seed, 40_000, 6e-4);
            let training = HiddenMarkov::default().trained(&[&curvature], 5.0);
            let model = training.model;
            assert!(training.converged);
            let curves =
                truth.windows(2).filter(|pair| pair[0] == 0 && pair[1] != 0).count() as f64;
            let straight = truth.iter().filter(|direction| **direction == 0).count() as f64;
            let in_curves = truth.len() as f64 - straight;
            // four standard errors of counts of curves, and of the mean of 400 log radii
            let relative = 4.0 / curves.sqrt();
            assert!((model.straight_scale_per_m / 6e-4 - 1.0).abs() < 0.03, "{model:?}");
            assert!(
                (model.curves_per_m * 5.0 * straight / curves - 1.0).abs() < relative,
                "{model:?}"
            );
            let length_m = 5.0 * in_curves / curves;
            assert!((model.curve_length_m / length_m - 1.0).abs() < relative, "{model:?}");
            assert!(
                (libm::log(model.curve_median_per_m * 150.0)).abs() < 2.0 * relative,
                "{model:?}"
            );
            assert!((model.curve_log_sd - 0.5).abs() < 0.1, "{model:?}");
        }
    }

    #[test]
    fn the_likelihood_never_falls_in_training() {
        let (curvature, _) = road(7, 5_000, 8e-4);
        let mut model = HiddenMarkov { straight_scale_per_m: 2e-3, ..HiddenMarkov::default() };
        let mut last = f64::NEG_INFINITY;
        for _ in 0..10 {
            let mut sums = Expected::default();
            model.expect(&curvature, 5.0, &mut sums);
            // the maximisation leaves the truncation out: allow for it
            assert!(sums.log_likelihood > last - 1.0, "{} {last}", sums.log_likelihood);
            last = sums.log_likelihood;
            model = model.maximised(&sums, 5.0);
        }
    }

    #[test]
    fn nothing_and_noiseless_straights_are_no_trouble() {
        let model = HiddenMarkov::default();
        assert!(model.directions(&[], 5.0).is_empty());
        assert_eq!(model.trained(&[], 5.0).model, model);
        let straight = vec![0.0; 1000];
        let trained = model.trained(&[&straight], 5.0).model;
        assert_eq!(trained.directions(&straight, 5.0), vec![0; 1000]);
    }
}
