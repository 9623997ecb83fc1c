//! Queues at public chargers.
//!
//! Trucks come to a site as a Poisson process of rate λ, each takes one of its c chargers for an
//! exponential time of mean 1/μ, and waits in turn (M/M/c). A truck waits with the probability
//! C = p_c / (1 − ρ) / (Σ_{k<c} a^k/k! + p_c / (1 − ρ)), p_c = a^c/c!, a = λ/μ, ρ = a/c < 1
//! (Erlang, 1917), and then for an exponential time of mean 1 / (c μ − λ). Each truck of a fleet
//! meets the queue of all others: it does not lengthen it.

use crate::random::Draws;
use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A queue before the chargers of a site.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct QueueModel {
    /// Chargers of a site.
    #[schemars(range(min = 1.0, max = 200.0))]
    pub chargers: u32,
    /// Vehicles that come to a site, per s.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub arrivals_per_s: f64,
    /// Mean time for which each takes a charger, in s.
    #[schemars(range(min = 1.0, max = 86_400.0))]
    pub mean_charging_s: f64,
}

impl QueueModel {
    /// A queue that does not grow without end.
    pub fn validate(&self, problems: &mut Problems) {
        let most = f64::from(self.chargers) / self.mean_charging_s;
        let allowed = format!("below {most}: what `chargers` and `mean_charging_s` can serve");
        problems.require(
            self.arrivals_per_s < most,
            "arrivals_per_s",
            self.arrivals_per_s,
            &allowed,
        );
    }

    /// Probability that one has to wait.
    pub fn waiting_probability(&self) -> f64 {
        let load = self.arrivals_per_s * self.mean_charging_s;
        let (mut term, mut sum) = (1.0, 0.0);
        for k in 0..self.chargers {
            sum += term;
            term *= load / f64::from(k + 1);
        }
        let all_taken = term / (1.0 - load / f64::from(self.chargers));
        all_taken / (sum + all_taken)
    }

    /// Mean time that those wait who have to, in s.
    pub fn mean_wait_s(&self) -> f64 {
        1.0 / (f64::from(self.chargers) / self.mean_charging_s - self.arrivals_per_s)
    }

    /// Draws a wait, in s.
    pub fn sample(&self, draws: &mut Draws) -> f64 {
        let waits = draws.uniform() < self.waiting_probability();
        let wait_s = draws.exponential() * self.mean_wait_s();
        if waits { wait_s } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    #[test]
    fn the_probability_is_erlangs() {
        // C(1, a) = a; C(2, 1) = 1/3; C(3, 2) = 4/9
        for (chargers, load, said) in [(1, 0.7, 0.7), (2, 1.0, 1.0 / 3.0), (3, 2.0, 4.0 / 9.0)] {
            let queue =
                QueueModel { chargers, arrivals_per_s: load / 100.0, mean_charging_s: 100.0 };
            assert!((queue.waiting_probability() - said).abs() < 1e-12, "{chargers} {load}");
        }
        let nobody = QueueModel { chargers: 4, arrivals_per_s: 0.0, mean_charging_s: 60.0 };
        assert_eq!(nobody.waiting_probability(), 0.0);
    }

    /// Waits of a site that is simulated customer by customer.
    fn simulated(queue: &QueueModel, seed: u64, customers: usize) -> Vec<f64> {
        let mut draws = Draws::new(seed, 0, Stream::Bootstrap);
        let mut free_at = vec![0.0f64; queue.chargers as usize];
        let mut now_s = 0.0;
        let mut waits = Vec::with_capacity(customers);
        for _ in 0..customers {
            now_s += draws.exponential() / queue.arrivals_per_s;
            free_at.sort_unstable_by(f64::total_cmp);
            let begins_s = f64::max(now_s, free_at[0]);
            waits.push(begins_s - now_s);
            free_at[0] = begins_s + draws.exponential() * queue.mean_charging_s;
        }
        waits
    }

    #[test]
    fn waits_are_those_of_customers_who_queue() {
        let queue =
            QueueModel { chargers: 4, arrivals_per_s: 0.7 * 4.0 / 1500.0, mean_charging_s: 1500.0 };
        let said_s = queue.waiting_probability() * queue.mean_wait_s();
        let share = queue.waiting_probability();
        for seed in 1..=3 {
            let n = 40_000;
            let mut draws = Draws::new(seed, 0, Stream::Charger);
            let drawn: Vec<f64> = (0..n).map(|_| queue.sample(&mut draws)).collect();
            let mean = |waits: &[f64]| waits.iter().sum::<f64>() / waits.len() as f64;
            // variance of a wait that is 0, or exponential of mean w
            let w_s = queue.mean_wait_s();
            let sd_s = (share * (2.0 - share)).sqrt() * w_s;
            assert!((mean(&drawn) - said_s).abs() < 4.0 * sd_s / f64::from(n).sqrt());
            // customers depend on one another: batches of 2000 hardly do
            let waits = simulated(&queue, seed, n as usize);
            let batches: Vec<f64> = waits.chunks(2000).map(mean).collect();
            let (m, center) = (batches.len() as f64, mean(&batches));
            let spread = batches.iter().map(|b| (b - center).powi(2)).sum::<f64>() / (m - 1.0);
            assert!((center - said_s).abs() < 4.0 * (spread / m).sqrt(), "{center} {said_s}");
        }
    }
}
