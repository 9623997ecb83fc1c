//! How sure the fleet's mean is when the parameters of the study are themselves uncertain.
//!
//! Cycles are dealt out to G replicates (`cycle_id mod G`), each with its own draw of the uncertain parameters. With R_r
//! the mean of replicate r and s_r its standard error (see [`super::ratio`]), the variance that the parameters cause is
//! what the replicates' means differ by beyond their sampling,
//!
//! σ² = Var(R_r) − mean s_r²   (0 where it is negative),   interval R ± t₀.₉₇₅(G − 1) √(σ² + se²)
//!
//! with se the standard error of the mean R of all cycles. More cycles shrink se, and leave σ: that needs more
//! measurements behind the parameters. The spread between cycles is neither of the two.

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
    /// Estimates it from cycles (id, y, x); none without replicates, and where one of them has fewer than two cycles.
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
        let means: Vec<(f64, f64)> = groups
            .iter()
            .map(|group| {
                let ratio = Ratio::estimate(group.iter().copied())?;
                let standard_error = standard_error(&ratio, group.len())?;
                Some((ratio.ratio, standard_error * standard_error))
            })
            .collect::<Option<_>>()?;
        let g = means.len() as f64;
        if g < 2.0 {
            return None;
        }
        let centre = means.iter().map(|(mean, _)| mean).sum::<f64>() / g;
        let between = means.iter().map(|(mean, _)| (mean - centre) * (mean - centre)).sum::<f64>()
            / (g - 1.0);
        let sampling = means.iter().map(|(_, square)| square).sum::<f64>() / g;
        let variance = (between - sampling).max(0.0);
        let error = standard_error(&whole, batches.len())?;
        let half_width = student_975(g - 1.0) * libm::sqrt(variance + error * error);
        Some(Self {
            column,
            replicates,
            sd: libm::sqrt(variance),
            ci95: [whole.ratio - half_width, whole.ratio + half_width],
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
            // an SD from 64 replicates has a standard error of 9 %; sampling adds 0.3² to the 0.5² that are looked for
            assert!((found.sd / 0.5 - 1.0).abs() < 4.0 * 0.09 * 1.36, "{found:?}");
            let half_width = (found.ci95[1] - found.ci95[0]) / 2.0;
            assert!(half_width > 1.9 * found.sd, "the parameters are in the interval: {found:?}");
            assert!(found.ci95[0] < 30.0 && 30.0 < found.ci95[1], "{found:?}");
        }
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
