//! The scalar laws that a study file names, and the number-or-distribution that uses them.
//!
//! One file a law: what it is for, its formula, how it samples, how its parameters are estimated
//! from data (`fit`, beside `sample`), its quantile where there is a closed form, and the tests of
//! all three. Every law samples with elementary operations and `libm`, so that the bits are the
//! same everywhere; draws are part of the program's values and do not change without a note in the
//! changelog (`tests/it/value_stability.rs`).

pub mod beta;
pub mod empirical;
pub mod exponential;
pub mod gamma;
mod law;
pub mod levelled;
pub mod log_normal;
pub mod mixture;
pub mod normal;
mod quantity;
pub mod uniform;
pub mod weibull;

use crate::random::Draws;

pub use gamma::standard_gamma;
pub use law::Law;
pub use levelled::LevelledLaw;
pub use quantity::Quantity;

/// Probability beyond which no value is drawn: the check of a study looks as far as that
/// ([`Law::practical_range`]).
const RARE: f64 = 1e-6;

/// A probability, not nearer to 0 or 1 than that.
fn practical(p: f64) -> f64 {
    p.clamp(RARE, 1.0 - RARE)
}

/// An exponential of mean 1 between its quantiles of [`RARE`] and 1 − [`RARE`].
fn practical_exponential(draws: &mut Draws) -> f64 {
    const LOW: f64 = 1.000_000_500_000_333_4e-6;
    const HIGH: f64 = 13.815_510_557_935_518;
    draws.exponential().clamp(LOW, HIGH)
}

/// Mean and standard deviation (divisor n − 1); none for fewer than two values, or where one is not
/// finite.
fn moments(values: impl Iterator<Item = f64> + Clone) -> Option<(f64, f64)> {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    let squares: f64 = values.map(|x| (x - mean) * (x - mean)).sum();
    let sd = (squares / (n - 1.0)).sqrt();
    sd.is_finite().then_some((mean, sd))
}

/// Whether all values are finite and above zero.
fn all_positive(values: &[f64]) -> bool {
    values.iter().all(|x| *x > 0.0 && x.is_finite())
}
