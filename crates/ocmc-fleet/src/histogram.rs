//! Counts of a sample in bins whose edges are round numbers.

use schemars::JsonSchema;
use serde::Serialize;

/// Bins that a histogram has at most, those for the tails not counted.
pub const LARGEST_NUMBER_OF_BINS: usize = 20;

/// Share of the sample on each side that may lie outside the bins, so that one odd cycle does not
/// flatten the picture.
const TAIL: f64 = 0.005;

/// A histogram: equal bins between round edges, and what lies outside them.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Histogram {
    /// Edges, one more than bins.
    pub edges: Vec<f64>,
    /// Number of values in [edge, next edge); the last bin holds its upper edge too.
    pub counts: Vec<u64>,
    /// Number of values below the first edge.
    pub below: u64,
    /// Number of values above the last edge.
    pub above: u64,
    /// Digits after the decimal point that the edges need.
    pub decimals: usize,
}

/// A round step: `factor` × 10^`exponent`, factor 1, 2 or 5.
#[derive(Clone, Copy)]
struct Step {
    factor: f64,
    exponent: i32,
}

impl Step {
    /// Multiple `k` of the step, the number nearest to its decimal form.
    fn times(self, k: f64) -> f64 {
        let power = libm::pow(10.0, f64::from(self.exponent.abs()));
        if self.exponent < 0 { k * self.factor / power } else { k * self.factor * power }
    }

    /// The next larger round step.
    fn next(self) -> Self {
        match self.factor {
            1.0 => Self { factor: 2.0, ..self },
            2.0 => Self { factor: 5.0, ..self },
            _ => Self { factor: 1.0, exponent: self.exponent + 1 },
        }
    }
}

impl Histogram {
    /// Counts a sorted sample of finite values; none where it is empty.
    pub fn of(sorted: &[f64]) -> Option<Self> {
        let last = sorted.len().checked_sub(1)?;
        let outside = (last as f64 * TAIL) as usize;
        let (low, high) = (sorted[outside], sorted[last - outside]);
        let step = round_step(low, high);
        let first = libm::floor(low / step.times(1.0));
        let mut edges = vec![step.times(first)];
        while edges.len() < 2 || edges[edges.len() - 1] < high {
            edges.push(step.times(first + edges.len() as f64));
        }
        let place = |edge: f64| sorted.partition_point(|x| *x < edge);
        let mut counts: Vec<u64> =
            edges.windows(2).map(|edge| (place(edge[1]) - place(edge[0])) as u64).collect();
        let top = edges[edges.len() - 1];
        let up_to_top = sorted.partition_point(|x| *x <= top);
        if let Some(count) = counts.last_mut() {
            *count += (up_to_top - place(top)) as u64;
        }
        let below = place(edges[0]) as u64;
        let above = (sorted.len() - up_to_top) as u64;
        let decimals = usize::try_from(-step.exponent).unwrap_or(0);
        Some(Self { edges, counts, below, above, decimals })
    }
}

/// The smallest round step that covers a range with no more bins than allowed.
fn round_step(low: f64, high: f64) -> Step {
    // values all the same, or nearly: bins as wide as a thousandth of the value, far above its last
    // digit
    let size = libm::fabs(low).max(libm::fabs(high));
    let narrow = high - low <= 1e-9 * size;
    let wanted = if !narrow {
        high - low
    } else if size > 0.0 {
        size / 50.0
    } else {
        1.0
    };
    let bins = LARGEST_NUMBER_OF_BINS as f64;
    let exponent = libm::floor(libm::log10(wanted / bins)) as i32;
    let mut step = Step { factor: 1.0, exponent };
    while libm::ceil(high / step.times(1.0)) - libm::floor(low / step.times(1.0)) > bins {
        step = step.next();
    }
    step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_round_and_every_value_is_counted_once() {
        let sample: Vec<f64> = (0..1000).map(|k| 23.4 + 0.017 * f64::from(k)).collect();
        let histogram = Histogram::of(&sample).expect("not empty");
        assert_eq!(histogram.edges, (23..=41).map(f64::from).collect::<Vec<_>>());
        assert_eq!(histogram.decimals, 0);
        assert_eq!(histogram.counts.iter().sum::<u64>() + histogram.below + histogram.above, 1000);
    }

    #[test]
    fn small_steps_are_the_nearest_decimals() {
        let sample: Vec<f64> = (0..=30).map(|k| 0.1 + 0.01 * f64::from(k)).collect();
        let histogram = Histogram::of(&sample).expect("not empty");
        assert_eq!(histogram.decimals, 2);
        assert!(histogram.edges.contains(&0.3));
        assert!(histogram.counts.len() <= LARGEST_NUMBER_OF_BINS);
    }

    #[test]
    fn one_odd_value_lies_outside() {
        let mut sample: Vec<f64> = (0..999).map(f64::from).collect();
        sample.push(1e9);
        let histogram = Histogram::of(&sample).expect("not empty");
        assert_eq!(histogram.above, 1);
        assert!(histogram.edges.iter().all(|edge| *edge <= 1000.0));
    }

    #[test]
    fn empty_single_and_constant_samples() {
        assert_eq!(Histogram::of(&[]), None);
        for sample in [&[0.0][..], &[32.5], &[32.5; 7], &[-4.0, -4.0], &[1e16, 1e16 + 2.0]] {
            let histogram = Histogram::of(sample).expect("not empty");
            assert_eq!(histogram.counts.iter().sum::<u64>(), sample.len() as u64, "{histogram:?}");
        }
    }
}
