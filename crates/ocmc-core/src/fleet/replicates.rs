//! How sure the fleet's mean is when the parameters of the study are themselves uncertain.
//!
//! Cycles are dealt out to G replicates (`cycle_id mod G`), each with its own draw of the uncertain
//! parameters. With R_r the mean of replicate r and s_r its standard error (see [`super::ratio`]),
//! the variance that the parameters cause is what the replicates' means differ by beyond their
//! sampling,
//!
//! - σ² = Var(R_r) − mean s_r²   (0 where it is negative)
//! - interval R ± t₀.₉₇₅(G − 1) √(σ² (1 + 1/G) + se²)
//!
//! with se the standard error of the mean R of all cycles. The interval is for the fleet's mean
//! under the one true value of the parameters, which is another draw from their law: σ² is the
//! variance of that draw, σ²/G that of the mean of the G draws which R is made of, as in the
//! prediction interval of a further observation. With se = 0 its coverage is exact for normal
//! draws. More cycles shrink se, and leave σ: that needs more measurements behind the parameters.
//! The spread between cycles is neither of the two.

use super::dependence::Dependence;
use super::ratio::{Ratio, student_975};
use serde::Serialize;

/// What the mean of a fleet owes to uncertain parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ParameterUncertainty {
    /// Name of the quantity.
    pub column: &'static str,
    /// Draws of the parameters.
    pub replicates: u64,
    /// Standard deviation of the fleet's mean over the parameters.
    pub sd: f64,
    /// 95 % interval of the mean, sampling and parameters together.
    pub ci95: [f64; 2],
}

impl ParameterUncertainty {
    /// Estimates it from cycles (id, y, x); none without replicates, and where one of them has
    /// fewer than two cycles.
    pub fn estimate(
        column: &'static str,
        dependence: Dependence,
        cycles: &[(u64, f64, f64)],
    ) -> Option<Self> {
        let replicates = dependence.replicates?;
        let batches = dependence.batch_totals(cycles.iter().copied());
        let whole = Ratio::estimate(batches.iter().copied())?;
        let mut groups = vec![Vec::new(); replicates as usize];
        for (cycle_id, y, x) in cycles {
            groups[(cycle_id % replicates) as usize].push((*y, *x));
        }
        let estimate = |group: &Vec<(f64, f64)>| {
            let ratio = Ratio::estimate(group.iter().copied())?;
            Some((ratio.ratio, standard_error(&ratio, group.len())?))
        };
        let means = groups.iter().map(estimate).collect::<Option<Vec<_>>>()?;
        let error = standard_error(&whole, batches.len())?;
        Self::of_replicates(column, (whole.ratio, error), &means)
    }

    /// Estimates it from the mean of all cycles and those of the replicates, each with its standard
    /// error; none from fewer than two replicates. The mean may as well be a difference of two.
    pub(super) fn of_replicates(
        column: &'static str,
        (whole, error): (f64, f64),
        means: &[(f64, f64)],
    ) -> Option<Self> {
        if means.len() < 2 {
            return None;
        }
        let g = means.len() as f64;
        let centre = means.iter().map(|(mean, _)| mean).sum::<f64>() / g;
        let between = means.iter().map(|(mean, _)| (mean - centre) * (mean - centre)).sum::<f64>()
            / (g - 1.0);
        let sampling = means.iter().map(|(_, error)| error * error).sum::<f64>() / g;
        let variance = (between - sampling).max(0.0);
        let square = variance * (1.0 + 1.0 / g) + error * error;
        let half_width = student_975(g - 1.0) * libm::sqrt(square);
        Some(Self {
            column,
            replicates: means.len() as u64,
            sd: libm::sqrt(variance),
            ci95: [whole - half_width, whole + half_width],
        })
    }
}

/// The standard error behind an interval of so many pairs.
fn standard_error(ratio: &Ratio, pairs: usize) -> Option<f64> {
    let [low, high] = ratio.ci95?;
    Some((high - low) / 2.0 / student_975(pairs as f64 - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Draws, Stream};

    /// A fleet whose mean is 30 plus what the parameters of each of 64 replicates do.
    fn fleet(seed: u64, parameter_sd: f64, cycles: u64) -> ParameterUncertainty {
        let mut draws = Draws::new(seed, 0, Stream::Curve);
        let shifts: Vec<f64> = (0..64).map(|_| parameter_sd * draws.normal()).collect();
        let rows: Vec<(u64, f64, f64)> = (0..cycles)
            .map(|k| {
                let x = libm::exp(0.3 * draws.normal());
                (k, x * (30.0 + shifts[(k % 64) as usize] + 4.0 * draws.normal()), x)
            })
            .collect();
        let dependence = Dependence { replicates: Some(64), ..Dependence::default() };
        ParameterUncertainty::estimate("x", dependence, &rows).expect("enough cycles")
    }

    #[test]
    fn what_the_parameters_do_is_told_from_sampling() {
        for seed in 1..=3 {
            let found = fleet(seed, 0.5, 12_800);
            // an SD from 64 replicates has a standard error of 9 %; sampling adds 0.3² to the 0.5²
            // that are looked for
            assert!((found.sd / 0.5 - 1.0).abs() < 4.0 * 0.09 * 1.36, "{found:?}");
            let half_width = (found.ci95[1] - found.ci95[0]) / 2.0;
            assert!(half_width > 1.9 * found.sd, "the parameters are in the interval: {found:?}");
            assert!(found.ci95[0] < 30.0 && 30.0 < found.ci95[1], "{found:?}");
        }
    }

    #[test]
    fn the_interval_covers_the_mean_under_another_draw_of_the_parameters() {
        // four draws, and next to no sampling: without σ²/G the share would be that of t(3) within
        // 3.18/√1.25, 93.5 %
        const RUNS: u64 = 20_000;
        let dependence = Dependence { replicates: Some(4), ..Dependence::default() };
        let mut covered = 0;
        for run in 0..RUNS {
            let mut draws = Draws::new(1, run, Stream::Curve);
            let shifts: Vec<f64> = (0..4).map(|_| 0.5 * draws.normal()).collect();
            let truth = 30.0 + 0.5 * draws.normal();
            let rows: Vec<(u64, f64, f64)> = (0..400)
                .map(|k| (k, 30.0 + shifts[(k % 4) as usize] + 1e-3 * draws.normal(), 1.0))
                .collect();
            let found = ParameterUncertainty::estimate("x", dependence, &rows).expect("enough");
            covered += u64::from(found.ci95[0] <= truth && truth <= found.ci95[1]);
        }
        let share = covered as f64 / RUNS as f64;
        let standard_error = libm::sqrt(0.95 * 0.05 / RUNS as f64);
        assert!((share - 0.95).abs() < 4.0 * standard_error, "{share}");
    }

    #[test]
    fn more_cycles_shrink_sampling_and_not_the_parameters() {
        let (few, many) = (fleet(1, 0.5, 6400), fleet(1, 0.5, 64_000));
        assert!(many.sd > 0.3 && few.sd > 0.3, "{few:?} {many:?}");
        let none = fleet(1, 0.0, 64_000);
        assert!(none.sd < 0.1, "{none:?}");
        let half_width = (none.ci95[1] - none.ci95[0]) / 2.0;
        assert!(half_width < 0.25, "{none:?}");
    }

    #[test]
    fn too_few_cycles_say_nothing() {
        let rows: Vec<(u64, f64, f64)> = (0..200).map(|k| (k, 30.0, 1.0)).collect();
        let dependence = Dependence { replicates: Some(64), ..Dependence::default() };
        assert_eq!(ParameterUncertainty::estimate("x", dependence, &rows[..100]), None);
        assert_eq!(ParameterUncertainty::estimate("x", dependence, &[]), None);
        assert_eq!(ParameterUncertainty::estimate("x", Dependence::default(), &rows), None);
        assert!(ParameterUncertainty::estimate("x", dependence, &rows).is_some());
    }
}
