//! Speed signs: a reversible Markov chain in position, one for each road type.
//!
//! Rate from sign i to sign j per metre: q_ij = c s_j exp(-|v_i - v_j| / V). Detailed balance makes
//! the wanted shares by length, s, exactly stationary; c = 1 / (L̄ Σ_{i≠j} s_i s_j exp(-|v_i - v_j|
//! / V)), where L̄ is the mean length of a sign. At a change of road type the sign is redrawn from
//! s.
//!
//! Structure of the operating-cycle papers (recalled with confidence); the reversible form is ours.
//!
//! Checked: the mean lengths of the urban signs equal those computed by hand from the defining
//! equations, and shares by length of 500 roads of 20 km lie within four standard errors of s, for
//! seeds 1, 2 and 3.

use super::road_type::Section;
use crate::random::Draws;
use crate::validation::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Speed signs of one road type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedSignModel {
    /// The signs' faces, in km/h.
    #[schemars(inner(range(min = 5.0, max = 200.0)))]
    pub speed_kmh: Vec<f64>,
    /// Wanted share of each face by length.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub share: Vec<f64>,
    /// Mean length over which a sign holds, in m.
    #[schemars(range(min = 20.0, max = 1.0e6))]
    pub mean_length_m: f64,
    /// Speed difference over which a change becomes e times rarer, in km/h.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub similarity_kmh: f64,
}

impl SpeedSignModel {
    /// One share for each face, one in all.
    pub fn validate(&self, problems: &mut Problems) {
        let (faces, shares) = (self.speed_kmh.len(), self.share.len());
        problems.require(faces > 0, "speed_kmh", "empty", "at least one sign");
        problems.require(
            shares == faces,
            "share",
            format!("{shares} numbers"),
            "one share for each sign of speed_kmh",
        );
        problems.require_sum_of_one("share", self.share.iter().sum());
    }

    /// Prepares the chain.
    pub fn chain(&self) -> SpeedSignChain {
        let total: f64 = self.share.iter().sum();
        let share: Vec<f64> = self.share.iter().map(|s| s / total).collect();
        let affinity = |i: usize, j: usize| {
            let difference = (self.speed_kmh[i] - self.speed_kmh[j]).abs();
            libm::exp(-difference / self.similarity_kmh)
        };
        let n = share.len();
        let mut flux = 0.0;
        for i in 0..n {
            for j in 0..n {
                if i != j {
                    flux += share[i] * share[j] * affinity(i, j);
                }
            }
        }
        let c = if flux > 0.0 { 1.0 / (self.mean_length_m * flux) } else { 0.0 };
        let rate_per_m = (0..n)
            .map(|i| {
                (0..n).map(|j| if i == j { 0.0 } else { c * share[j] * affinity(i, j) }).collect()
            })
            .collect();
        let speed_mps = self.speed_kmh.iter().map(|v| v / 3.6).collect();
        SpeedSignChain { speed_mps, share, rate_per_m }
    }
}

/// The chain of one road type, prepared for sampling.
#[derive(Clone, Debug)]
pub struct SpeedSignChain {
    speed_mps: Vec<f64>,
    share: Vec<f64>,
    /// Rates q_ij per metre, zero on the diagonal.
    rate_per_m: Vec<Vec<f64>>,
}

/// A speed limit that holds from its position to the next sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedSign {
    /// Where it stands, in m.
    pub start_m: f64,
    /// The limit, in m/s.
    pub speed_mps: f64,
}

impl SpeedSignChain {
    /// Minus the logarithm of the likelihood of changes from sign to sign, counted as
    /// `changes[from][to]`.
    pub fn minus_log_likelihood(&self, changes: &[Vec<f64>]) -> f64 {
        let of_sign = |(counts, rates): (&Vec<f64>, &Vec<f64>)| {
            let exit: f64 = rates.iter().sum();
            let pairs = counts.iter().zip(rates).filter(|(count, _)| **count > 0.0);
            pairs.map(|(count, rate)| -count * libm::log(rate / exit)).sum::<f64>()
        };
        changes.iter().zip(&self.rate_per_m).map(of_sign).sum()
    }

    /// The signs' faces, in m/s.
    pub fn speed_mps(&self) -> &[f64] {
        &self.speed_mps
    }

    /// Share of each face by length.
    pub fn share(&self) -> &[f64] {
        &self.share
    }

    /// Rates of the changes from each face to each, per metre; zero on the diagonal.
    pub fn rate_per_m(&self) -> &[Vec<f64>] {
        &self.rate_per_m
    }

    /// Mean number of changes per metre, 1/m.
    pub fn flux_per_m(&self) -> f64 {
        let of_sign = |(share, rates): (&f64, &Vec<f64>)| share * rates.iter().sum::<f64>();
        self.share.iter().zip(&self.rate_per_m).map(of_sign).sum()
    }

    /// Chain of an observer who takes the signs of a group, which `group_of` gives, for one: each
    /// group changes at the rate of its signs, weighed by their shares, and has their mean speed.
    #[must_use]
    pub fn grouped(&self, group_of: &[usize]) -> Self {
        let groups = group_of.iter().max().map_or(0, |last| last + 1);
        let mut share = vec![0.0; groups];
        let mut speed_mps = vec![0.0; groups];
        let mut rate_per_m = vec![vec![0.0; groups]; groups];
        for (i, &from) in group_of.iter().enumerate() {
            share[from] += self.share[i];
        }
        for (i, &from) in group_of.iter().enumerate() {
            let part = if share[from] > 0.0 { self.share[i] / share[from] } else { 0.0 };
            speed_mps[from] += part * self.speed_mps[i];
            for (j, &to) in group_of.iter().enumerate().filter(|(_, to)| **to != from) {
                rate_per_m[from][to] += part * self.rate_per_m[i][j];
            }
        }
        Self { speed_mps, share, rate_per_m }
    }

    /// Appends the signs of one section.
    pub fn sample(&self, section: &Section, draws: &mut Draws, signs: &mut Vec<SpeedSign>) {
        let mut state = draws.index(&self.share);
        let mut position = section.start_m;
        while position < section.end_m {
            signs.push(SpeedSign { start_m: position, speed_mps: self.speed_mps[state] });
            let exit: f64 = self.rate_per_m[state].iter().sum();
            if exit <= 0.0 {
                return;
            }
            position += draws.exponential() / exit;
            state = draws.index(&self.rate_per_m[state]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    fn urban() -> SpeedSignModel {
        SpeedSignModel {
            speed_kmh: vec![30.0, 40.0, 50.0, 60.0, 70.0],
            share: vec![0.15, 0.20, 0.45, 0.12, 0.08],
            mean_length_m: 600.0,
            similarity_kmh: 15.0,
        }
    }

    #[test]
    fn mean_sojourns_are_those_printed_for_the_default() {
        // urban row: 658/456/711/464/735 m
        let chain = urban().chain();
        for (row, printed) in chain.rate_per_m.iter().zip([658.0, 456.0, 711.0, 464.0, 735.0]) {
            let sojourn = 1.0 / row.iter().sum::<f64>();
            assert!((sojourn - printed).abs() < 0.6, "{sojourn} {printed}");
        }
    }

    #[test]
    fn shares_by_length_are_stationary() {
        let model = urban();
        let chain = model.chain();
        for seed in 1..=3 {
            let mut by_road = vec![Vec::new(); 5];
            for cycle in 0..500 {
                let section = Section { start_m: 0.0, end_m: 20_000.0, road_type: 0 };
                let mut signs = Vec::new();
                chain.sample(&section, &mut Draws::new(seed, cycle, Stream::SpeedSign), &mut signs);
                let mut length = [0.0; 5];
                for (i, sign) in signs.iter().enumerate() {
                    let end = signs.get(i + 1).map_or(section.end_m, |next| next.start_m);
                    let face = model
                        .speed_kmh
                        .iter()
                        .position(|v| (v / 3.6 - sign.speed_mps).abs() < 1e-9)
                        .unwrap();
                    length[face] += (end - sign.start_m) / section.end_m;
                }
                for (values, l) in by_road.iter_mut().zip(length) {
                    values.push(l);
                }
            }
            for (values, share) in by_road.iter().zip(&model.share) {
                let n = values.len() as f64;
                let mean = values.iter().sum::<f64>() / n;
                let var = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
                assert!((mean - share).abs() < 4.0 * (var / n).sqrt(), "{mean} {share}");
            }
        }
    }
}
