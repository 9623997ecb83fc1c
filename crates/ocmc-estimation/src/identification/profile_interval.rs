//! Profile intervals of the parameters of one event: how far one may move before the others can no
//! longer make up for it.

use super::bounded_least_squares::{Optimum, Tolerances};
use super::identify::NORMAL_95;
use super::problem::Problem;

/// Rounds in which the end of an interval is looked for.
const ROUNDS: usize = 6;
/// Nearest end of an interval, as a share of the one that the derivatives give [EJ].
const NEAREST: f64 = 0.7;

impl Problem<'_> {
    /// How the other parameters follow parameter `k` away from the optimum, to first order: each
    /// for a unit of it.
    fn followers(best: &Optimum, k: usize) -> Vec<f64> {
        let count = best.parameters.len();
        let mut rates = vec![0.0; count];
        let free = |j: &usize| *j != k && best.jacobian.column(*j).norm() > 0.0;
        let others: Vec<usize> = (0..count).filter(free).collect();
        let factors = best.jacobian.select_columns(&others).qr();
        let projected = factors.q().transpose() * best.jacobian.column(k);
        if let Some(solution) = factors.r().solve_upper_triangular(&projected) {
            for (place, j) in others.into_iter().enumerate() {
                rates[j] = if solution[place].is_finite() { -solution[place] } else { 0.0 };
            }
        }
        rates
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
        // where the sum of squares jumps with a shift it tells nothing about the parameter
        let nearest = if error.is_finite() { NEAREST * away } else { 0.0 };
        let mut warm = best.parameters.clone();
        let tolerances = Tolerances { most_iterations: 15, ..self.tolerances() };
        let mut inside = 0.0;
        let followers = Self::followers(best, k);
        for _ in 0..ROUNDS {
            if !(away > 0.0) {
                return bound;
            }
            let here = value + side * away;
            let mut bounds = self.bounds.clone();
            bounds[k] = [here; 2];
            warm[k] = here;
            let led = |j: usize| {
                let value = best.parameters[j] + side * away * followers[j];
                value.clamp(bounds[j][0], bounds[j][1])
            };
            let led: Vec<f64> = (0..warm.len()).map(led).collect();
            // a search does not see behind the jumps of shifts: from both sides
            let optimum = [&led, &warm]
                .map(|start| self.search(start, &bounds, &tolerances))
                .into_iter()
                .min_by(|a, b| a.sum_of_squares.total_cmp(&b.sum_of_squares))
                .expect("there are two");
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
            if deviations > NORMAL_95 && next <= nearest {
                return value + side * nearest;
            }
            away = if deviations > NORMAL_95 { next.max(inside) } else { next.min(room) };
        }
        value + side * away.min(room)
    }
}
