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
//! \[PK\]). Where y does not go with x at all, n (1 − SS_within/SS) follows χ²(k − 1) for large n:
//! the share is above (q − (k − 1))/n once in 2000 times, with q the 99.95 % quantile of that law
//! by Wilson and Hilferty (*Proc. Natl. Acad. Sci.* 17 (1931) 684 \[PK\]). So much is chance, and
//! among twenty columns it is exceeded in one of a hundred reports. It says what goes together, not
//! what causes what: columns that go with one another share their shares. [`super::sensitivity`]
//! separates causes.

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
    /// Share that chance gives once in 2000 times.
    pub by_chance: f64,
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
    let groups = groups(&sorted);
    let mean = |group: &[(f64, f64)]| mean_of(group.iter().map(|pair| pair.1));
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
    let by_chance = by_chance(groups.len(), n);
    Some(Association { share, by_chance, bands: groups.iter().map(band).collect() })
}

/// The normal quantile of 99.95 %.
const RARE: f64 = 3.290_526_731_491_926;

/// Share that chance gives once in 2000 times with so many bands and cycles.
fn by_chance(bands: usize, n: usize) -> f64 {
    let df = bands as f64 - 1.0;
    let spread = 2.0 / (9.0 * df);
    let cube_root = 1.0 - spread + RARE * libm::sqrt(spread);
    df * (cube_root * cube_root * cube_root - 1.0) / n as f64
}

/// Tenths of sorted pairs.
fn groups(sorted: &[(f64, f64)]) -> Vec<&[(f64, f64)]> {
    let n = sorted.len();
    let half_a_tenth = n.div_ceil(2 * BANDS);
    let mut groups = Vec::new();
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
    groups
}

fn mean_of(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

/// How y goes with x at equal z, of triples (z, x, y) of finite numbers: in each tenth of z a
/// straight line of y over z is taken off, and the mean of y is left. The share is one of the whole
/// variance of y. What goes with y only because it goes with z, as a tyre's coefficient does with
/// the payload, is not shown as its own; of what goes with both, only a part is.
pub fn association_beside(triples: &[(f64, f64, f64)]) -> Option<Association> {
    let mut all: Vec<(f64, f64, f64)> = triples.to_vec();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let by_z: Vec<(f64, f64)> = all.iter().map(|(z, _, y)| (*z, *y)).collect();
    let mean = mean_of(by_z.iter().map(|pair| pair.1));
    let mut left = Vec::with_capacity(all.len());
    for group in groups(&by_z) {
        let [z_mean, y_mean] =
            [mean_of(group.iter().map(|pair| pair.0)), mean_of(group.iter().map(|pair| pair.1))];
        let sum = |term: fn(f64, f64) -> f64| {
            group.iter().map(|(z, y)| term(z - z_mean, y - y_mean)).sum::<f64>()
        };
        let (zz, zy) = (sum(|z, _| z * z), sum(|z, y| z * y));
        let slope = if zz > 0.0 { zy / zz } else { 0.0 };
        left.extend(group.iter().map(|(z, y)| mean + y - y_mean - slope * (z - z_mean)));
    }
    let squares = |values: &mut dyn Iterator<Item = f64>| {
        values.map(|y| (y - mean) * (y - mean)).sum::<f64>()
    };
    let whole = squares(&mut by_z.iter().map(|pair| pair.1));
    let rest = squares(&mut left.iter().copied());
    let pairs: Vec<(f64, f64)> = all.iter().zip(left).map(|((_, x, _), y)| (*x, y)).collect();
    let mut associated = association(&pairs)?;
    associated.share *= rest / whole;
    associated.by_chance *= rest / whole;
    Some(associated)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    #[test]
    fn a_step_is_all_of_the_variance_and_noise_is_none() {
        let step: Vec<(f64, f64)> =
            (0..100).map(|k| (f64::from(k), if k < 50 { 1.0 } else { 3.0 })).collect();
        let associated = association(&step).expect("it varies");
        assert_eq!(associated.share, 1.0);
        assert_eq!(associated.bands.len(), BANDS);
        assert_eq!((associated.bands[0].x, associated.bands[9].y), ([0.0, 9.0], [3.0; 3]));
        let mut draws = Draws::new(1, 0, Stream::Curve);
        let noise: Vec<(f64, f64)> = (0..5000).map(|_| (draws.normal(), draws.normal())).collect();
        // the share of ten bands of noise has a standard error of about √(2·9)/5000
        let share = association(&noise).expect("it varies").share;
        assert!(share.abs() < 4.0 * 18f64.sqrt() / 5000.0, "{share}");
    }

    #[test]
    fn noise_is_rarely_more_than_chance() {
        // the 99.95 % quantiles of χ²(9) and χ²(1), 29.666 and 12.116; the cube root is up to 5 %
        // high
        let above = [by_chance(10, 1) / (29.666 - 9.0), by_chance(2, 1) / (12.116 - 1.0)];
        assert!(above.iter().all(|ratio| (1.0..1.05).contains(ratio)), "{above:?}");
        let mut draws = Draws::new(4, 0, Stream::Curve);
        let mut more = 0;
        for _ in 0..4000 {
            let noise: Vec<(f64, f64)> =
                (0..200).map(|_| (draws.normal(), draws.normal())).collect();
            let associated = association(&noise).expect("it varies");
            more += usize::from(associated.share > associated.by_chance);
        }
        // two are to be expected, of an F law with few rows some more
        assert!(more <= 12, "{more}");
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
    fn what_goes_along_with_a_third_is_not_shown_as_its_own() {
        let mut draws = Draws::new(3, 0, Stream::Curve);
        let mut triples = |pair_of: fn(f64, f64, f64) -> (f64, f64)| -> Vec<(f64, f64, f64)> {
            let mut triple = || {
                // a fifth without any z, as trips without payload
                let z = (draws.normal() + 0.84).max(0.0);
                let (x, y) = pair_of(z, draws.normal(), draws.normal());
                (z, x, y + 2.0 * z * z.sqrt())
            };
            (0..20_000).map(|_| triple()).collect()
        };
        let plain = |triples: &[(f64, f64, f64)]| {
            let pairs: Vec<(f64, f64)> = triples.iter().map(|(_, x, y)| (*x, *y)).collect();
            association(&pairs).expect("it varies").share
        };
        let beside = |triples: &[_]| association_beside(triples).expect("it varies").share;
        // x has nothing to do with z: its share is what it was
        let own = triples(|_, a, _| (a, a));
        assert!((plain(&own) - beside(&own)).abs() < 0.01, "{} {}", plain(&own), beside(&own));
        assert!(beside(&own) > 0.05);
        // x falls with z, and that is all it has to do with y
        let through = triples(|z, a, b| (a - 3.0 * z, 0.2 * b));
        assert!(plain(&through) > 0.5, "{}", plain(&through));
        assert!(beside(&through).abs() < 0.005, "{}", beside(&through));
        assert_eq!(association_beside(&own[..49]), None);
        assert_eq!(association_beside(&[]), None);
    }

    #[test]
    fn equal_values_stay_together() {
        let pairs: Vec<(f64, f64)> =
            (0..200).map(|k| (f64::from(k.max(90)), f64::from(k))).collect();
        let associated = association(&pairs).expect("it varies");
        assert_eq!(associated.bands[0].x, [90.0, 90.0]);
        assert_eq!(associated.bands.iter().map(|band| band.n).sum::<u64>(), 200);
        // 91 equal values; half a tenth up to the next place where a tenth ends; then tenths: no
        // band of a few cycles
        let sizes: Vec<u64> = associated.bands.iter().map(|band| band.n).collect();
        assert_eq!(sizes, [91, 10, 19, 20, 20, 20, 20]);
        assert_eq!(association(&vec![(1.0, 2.0); 100]), None);
        assert_eq!(association(&pairs[..49]), None);
        let constant: Vec<(f64, f64)> = (0..100).map(|k| (f64::from(k), 2.0)).collect();
        assert_eq!(association(&constant), None);
    }
}
