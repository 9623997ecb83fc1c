//! One measured value over simulated ones: rank, continuous ranked probability score, intervals.
//!
//! - PIT: the randomised rank u = (#{x < y} + V (#{x = y} + 1)) / (m + 1), V uniform: uniform on
//!   (0, 1) where y is one more draw of the x, ties and small m included.
//!   Source: Czado, Gneiting and Held, *Biometrics* 65 (2009) 1254; for ensembles Hamill, *Monthly
//!   Weather Review* 129 (2001) 550.
//! - a band of a share p covers y where |u − 1/2| <= p / 2.
//! - CRPS = mean |x − y| − Σᵢⱼ |xᵢ − xⱼ| / (2 m (m − 1)): the fair form, without bias of m.
//!   Sources: Gneiting and Raftery, *Journal of the American Statistical Association* 102 (2007)
//!   359; Ferro, *Quarterly Journal of the Royal Meteorological Society* 140 (2014) 1917.

use ocmc_fleet::quantile::quantile;
use serde::Serialize;

/// A measured value over the simulated ones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Score {
    /// Measured.
    pub measured: f64,
    /// Mean of the simulated values.
    pub simulated: f64,
    /// Half of the simulated values lie in here.
    pub band50: [f64; 2],
    /// 90 % of the simulated values lie in here.
    pub band90: [f64; 2],
    /// Continuous ranked probability score, in the unit of the values.
    pub crps: f64,
    /// Rank among the simulated values, from 0 to 1, randomised among equal ones.
    pub pit: f64,
}

impl Score {
    /// Simulated less measured.
    pub fn error(&self) -> f64 {
        self.simulated - self.measured
    }
}

/// A sorted sample, prepared for scores.
#[derive(Clone, Debug)]
pub struct Sample {
    sorted: Vec<f64>,
    mean: f64,
    /// Half of the mean difference of two of them.
    half_spread: f64,
}

impl Sample {
    /// The finite ones of some values; none where there are fewer than two.
    pub fn new(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
        if sorted.len() < 2 {
            return None;
        }
        sorted.sort_by(f64::total_cmp);
        let m = sorted.len() as f64;
        let mean = sorted.iter().sum::<f64>() / m;
        let weighted = sorted.iter().enumerate().map(|(k, x)| (2.0 * k as f64 - m + 1.0) * x);
        let half_spread = weighted.sum::<f64>() / (m * (m - 1.0));
        Some(Self { sorted, mean, half_spread })
    }

    /// Their mean.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// How many.
    pub fn size(&self) -> usize {
        self.sorted.len()
    }

    /// A quantile.
    pub fn quantile(&self, level: f64) -> f64 {
        quantile(&self.sorted, level).expect("there are two values at least")
    }

    /// The randomised rank of a value; `v`: uniform on (0, 1).
    pub fn pit(&self, value: f64, v: f64) -> f64 {
        let below = self.sorted.partition_point(|x| *x < value);
        let up_to = self.sorted.partition_point(|x| *x <= value);
        let equal = (up_to - below) as f64;
        (below as f64 + v * (equal + 1.0)) / (self.sorted.len() as f64 + 1.0)
    }

    /// The continuous ranked probability score of a value.
    pub fn crps(&self, value: f64) -> f64 {
        let sum: f64 = self.sorted.iter().map(|x| (x - value).abs()).sum();
        sum / self.sorted.len() as f64 - self.half_spread
    }

    /// Everything about a measured value.
    pub fn score(&self, measured: f64, v: f64) -> Score {
        Score {
            measured,
            simulated: self.mean,
            band50: [self.quantile(0.25), self.quantile(0.75)],
            band90: [self.quantile(0.05), self.quantile(0.95)],
            crps: self.crps(measured),
            pit: self.pit(measured, v),
        }
    }
}

/// Whether a band of this share covers what has this rank.
pub fn covers(share: f64, pit: f64) -> bool {
    (pit - 0.5).abs() <= 0.5 * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    #[test]
    fn scores_of_a_small_sample() {
        let sample = Sample::new([4.0, 1.0, f64::NAN, 2.0, 2.0]).unwrap();
        assert_eq!((sample.size(), sample.mean()), (4, 2.25));
        // below all, among equal ones, above all
        assert_eq!(sample.pit(0.0, 0.5), 0.1);
        assert_eq!(sample.pit(2.0, 0.5), (1.0 + 0.5 * 3.0) / 5.0);
        assert_eq!(sample.pit(9.0, 0.5), 0.9);
        // pairs differ by 3, 1, 1, 2, 2, 0
        let by_pairs = (1.0 + 2.0 + 2.0 + 5.0) / 4.0 - 9.0 / 12.0;
        assert!((sample.crps(-1.0) - (by_pairs + 0.75)).abs() < 1e-12, "{}", sample.crps(-1.0));
        assert_eq!(sample.score(2.0, 0.5).error(), 0.25);
        assert!(covers(0.5, 0.25) && covers(0.5, 0.75) && !covers(0.5, 0.76));
        assert!(Sample::new([1.0]).is_none());
    }

    #[test]
    fn the_crps_of_a_normal_law_is_its_closed_form() {
        // standard normal, y = 0: (√2 − 1) / √π (Gneiting and Raftery, eq. 21)
        let mut draws = Draws::new(1, 0, Stream::Route);
        let sample = Sample::new((0..40_000).map(|_| draws.normal())).unwrap();
        let wanted = (2f64.sqrt() - 1.0) / std::f64::consts::PI.sqrt();
        assert!((sample.crps(0.0) - wanted).abs() < 0.004, "{}", sample.crps(0.0));
    }

    #[test]
    fn ranks_are_uniform_where_a_value_is_one_more_draw() {
        for seed in 1..=3 {
            let mut draws = Draws::new(seed, 0, Stream::Route);
            // counts with many ties, in samples of nine
            let ranks: Vec<f64> = (0..4000)
                .map(|_| {
                    let mut count = || f64::from((4.0 * draws.uniform()) as u8);
                    let sample = Sample::new((0..9).map(|_| count())).unwrap();
                    let value = count();
                    sample.pit(value, draws.uniform())
                })
                .collect();
            let test = super::super::uniformity::Uniformity::of(&ranks, None).unwrap();
            assert!(test.p > 0.01, "seed {seed}: {test:?}");
        }
    }
}
