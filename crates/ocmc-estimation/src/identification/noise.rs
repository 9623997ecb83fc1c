//! How much a sensor scatters, from its signal alone.
//!
//! Second differences take a signal away that hardly bends between three rows and leave the noise:
//! of white noise with the standard deviation σ they have σ √6. The median of their absolute values
//! does not see the few rows at which a pedal jumps. It is the difference estimator of Gasser,
//! Sroka and Jennen-Steinmetz (Biometrika 73 (1986) 625-633) for even steps, made robust.

/// Median of the absolute value of a standard normal number.
pub(super) const MEDIAN_ABSOLUTE: f64 = 0.674490;
/// Fewest differences.
const FEWEST: usize = 30;
/// Rows to either side of one that its average takes, and averages that are away from the stops.
const AROUND: usize = 10;
const FREE: std::ops::RangeInclusive<f64> = 0.04..=0.96;

/// The median; 0 of nothing.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Standard deviation of the noise of a signal.
pub(super) fn noise_sd(values: &[f64]) -> f64 {
    scatter(values.windows(3))
}

/// Standard deviation of the noise of a pedal: from the rows that on average are away from its
/// stops, where there are enough of them, for at a stop a sensor may show less.
pub(super) fn pedal_noise_sd(values: &[f64]) -> f64 {
    let mut sums = vec![0.0];
    for (row, value) in values.iter().enumerate() {
        sums.push(sums[row] + value);
    }
    let free = |middle: &usize| {
        let (first, end) = (middle.saturating_sub(AROUND), (middle + AROUND + 1).min(values.len()));
        FREE.contains(&((sums[end] - sums[first]) / (end - first) as f64))
    };
    let rows: Vec<usize> = (1..values.len().saturating_sub(1)).filter(free).collect();
    if rows.len() < FEWEST {
        return noise_sd(values);
    }
    scatter(rows.iter().map(|middle| &values[middle - 1..=middle + 1]))
}

fn scatter<'a>(triples: impl Iterator<Item = &'a [f64]>) -> f64 {
    let bend = |rows: &[f64]| (rows[0] - 2.0 * rows[1] + rows[2]).abs();
    median(triples.map(bend).collect()) / (MEDIAN_ABSOLUTE * 6.0f64.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    #[test]
    fn the_noise_of_a_moving_pedal() {
        for seed in 1..=3 {
            let mut draws = Draws::new(seed, 0, Stream::Pedals);
            let pedal: Vec<f64> = (0..900)
                .map(|row| 0.5 + 0.3 * libm::sin(0.01 * f64::from(row)) + 0.02 * draws.normal())
                .collect();
            assert!((noise_sd(&pedal) / 0.02 - 1.0).abs() < 0.15);
            // a sensor that shows nothing below 0
            let stopped: Vec<f64> = (0..900)
                .map(|row| if row < 500 { 0.0 } else { 0.3 + 0.02 * draws.normal() })
                .collect();
            assert!((pedal_noise_sd(&stopped) / 0.02 - 1.0).abs() < 0.15);
        }
        assert_eq!(pedal_noise_sd(&[0.0; 5]), 0.0);
    }
}
