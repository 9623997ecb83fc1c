//! How a quantity goes with what is known of each cycle: bands over tenths of the cycles.
//!
//! The cycles are sorted by x, a column of the records, and cut into tenths; equal values of x stay
//! together, and what is left of a tenth beside them goes with its neighbour where it is less than
//! half of one. In each tenth the middle and the spread of y are shown. The share of the variance
//! of y that lies between the tenths is
//!
//! ε² = 1 − (SS_within/(n − k)) / (SS/(n − 1))
//!
//! the correlation ratio, freed of its bias (T. L. Kelley, *Proc. Natl. Acad. Sci.* 21 (1935) 554
//! \[PK\]). It says what goes together, not what causes what: columns that go with one another
//! share their shares. [`super::sensitivity`] separates causes.

use super::quantile::quantile;
use serde::Serialize;

/// Bands that cycles are cut into.
pub const BANDS: usize = 10;

/// A band of cycles with similar x.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Band {
    /// Smallest and largest x.
    pub x: [f64; 2],
    /// Cycles.
    pub n: u64,
    /// 10 %, 50 % and 90 % quantiles of y.
    pub y: [f64; 3],
}

/// How y goes with x.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Association {
    /// Share of the variance of y between the bands; about 0, on either side, where y does not go
    /// with x.
    pub share: f64,
    /// The bands, from the lowest x.
    pub bands: Vec<Band>,
}

/// Cuts pairs (x, y) of finite numbers into bands; none where either does not vary, or for fewer
/// pairs than 5 a band.
pub fn association(pairs: &[(f64, f64)]) -> Option<Association> {
    let n = pairs.len();
    if n < 5 * BANDS {
        return None;
    }
    let mut sorted = pairs.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half_a_tenth = n.div_ceil(2 * BANDS);
    let mut groups: Vec<&[(f64, f64)]> = Vec::new();
    let mut start = 0;
    for place in 1..n {
        let next_tenth = place * BANDS / n > start * BANDS / n;
        let other = sorted[place - 1].0 != sorted[place].0;
        if next_tenth && other && place - start >= half_a_tenth && n - place >= half_a_tenth {
            groups.push(&sorted[start..place]);
            start = place;
        }
    }
    groups.push(&sorted[start..]);
    let mean =
        |group: &[(f64, f64)]| group.iter().map(|pair| pair.1).sum::<f64>() / group.len() as f64;
    let squares = |group: &[(f64, f64)]| {
        let mean = mean(group);
        group.iter().map(|pair| (pair.1 - mean) * (pair.1 - mean)).sum::<f64>()
    };
    let whole = squares(&sorted) / (n as f64 - 1.0);
    if groups.len() < 2 || !(whole > 0.0) {
        return None;
    }
    let within = groups.iter().map(|group| squares(group)).sum::<f64>();
    let share = 1.0 - within / (n - groups.len()) as f64 / whole;
    let band = |group: &&[(f64, f64)]| {
        let mut y: Vec<f64> = group.iter().map(|pair| pair.1).collect();
        y.sort_unstable_by(f64::total_cmp);
        Band {
            x: [group[0].0, group[group.len() - 1].0],
            n: group.len() as u64,
            y: [0.1, 0.5, 0.9].map(|level| quantile(&y, level).unwrap_or(f64::NAN)),
        }
    };
    Some(Association { share, bands: groups.iter().map(band).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Draws, Stream};

    #[test]
    fn a_step_is_all_of_the_variance_and_noise_is_none() {
        let step: Vec<(f64, f64)> =
            (0..100).map(|k| (f64::from(k), if k < 50 { 1.0 } else { 3.0 })).collect();
        let found = association(&step).expect("it varies");
        assert_eq!(found.share, 1.0);
        assert_eq!(found.bands.len(), BANDS);
        assert_eq!((found.bands[0].x, found.bands[9].y), ([0.0, 9.0], [3.0; 3]));
        let mut draws = Draws::new(1, 0, Stream::Curve);
        let noise: Vec<(f64, f64)> = (0..5000).map(|_| (draws.normal(), draws.normal())).collect();
        // the share of ten bands of noise has a standard error of about √(2·9)/5000
        let share = association(&noise).expect("it varies").share;
        assert!(share.abs() < 4.0 * 18f64.sqrt() / 5000.0, "{share}");
    }

    #[test]
    fn half_signal_half_noise() {
        let mut draws = Draws::new(2, 0, Stream::Curve);
        let pairs: Vec<(f64, f64)> = (0..20_000)
            .map(|_| {
                let x = draws.normal();
                (x, x + draws.normal())
            })
            .collect();
        // ten bands of a normal law hold 96 % of its variance, half of which is that of y: 0.48
        let share = association(&pairs).expect("it varies").share;
        assert!((share - 0.48).abs() < 0.02, "{share}");
    }

    #[test]
    fn equal_values_stay_together() {
        let pairs: Vec<(f64, f64)> =
            (0..200).map(|k| (f64::from(k.max(90)), f64::from(k))).collect();
        let found = association(&pairs).expect("it varies");
        assert_eq!(found.bands[0].x, [90.0, 90.0]);
        assert_eq!(found.bands.iter().map(|band| band.n).sum::<u64>(), 200);
        // 91 equal values; half a tenth up to the next place where a tenth ends; then tenths: no
        // band of a few cycles
        let sizes: Vec<u64> = found.bands.iter().map(|band| band.n).collect();
        assert_eq!(sizes, [91, 10, 19, 20, 20, 20, 20]);
        assert_eq!(association(&vec![(1.0, 2.0); 100]), None);
        assert_eq!(association(&pairs[..49]), None);
        let constant: Vec<(f64, f64)> = (0..100).map(|k| (f64::from(k), 2.0)).collect();
        assert_eq!(association(&constant), None);
    }
}
