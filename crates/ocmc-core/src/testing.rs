//! Helpers that tests of laws share.

use crate::distribution::Law;
use crate::random::{Draws, Stream};

/// Draws of a law, enough for the statistical tests.
pub(crate) fn hundred_thousand(law: &Law, seed: u64) -> Vec<f64> {
    let mut draws = Draws::new(seed, 0, Stream::Vehicle);
    (0..100_000).map(|_| law.sample(&mut draws)).collect()
}
