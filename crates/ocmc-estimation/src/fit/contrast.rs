//! How far rows of one kind lie above those of another: before and after a date, with a tyre and
//! without it.
//!
//! y = cluster + Xβ + δ z + e, z = 1 for the rows of the one kind. Clusters have levels of their
//! own where at least two of them have rows of both kinds, so that δ is what changed within them;
//! else there is one level, and δ compares clusters. The error is CR2 over the clusters with its
//! own degrees of freedom (`super::cluster_robust`).

use super::cluster_robust::{Cluster, ClusterMoves};
use super::far_rows::WithinGroups;
use super::p_value::{around, t_of_interval};
use nalgebra::DVector;
use serde::Serialize;
use std::collections::BTreeSet;

/// Fewest clusters of both kinds that δ is within.
const FEWEST_BOTH: usize = 2;

/// A difference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contrast {
    /// Mean of the rows of the kind above that of the others, all else equal.
    pub difference: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Degrees of freedom.
    pub degrees: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
    /// Rows of the others, and of the kind.
    pub rows: [usize; 2],
    /// Clusters with rows of both.
    pub clusters_of_both: usize,
    /// Whether it is within clusters.
    pub is_within: bool,
}

/// The difference; none where other columns, or the clusters, determine the kind, or where too few
/// clusters say something of it.
pub fn contrast(
    value: &[f64],
    is_of: &[bool],
    columns: &[Vec<f64>],
    cluster: &[usize],
) -> Option<Contrast> {
    let n = value.len();
    let clusters_of = |kind: bool| -> BTreeSet<usize> {
        (0..n).filter(|k| is_of[*k] == kind).map(|k| cluster[k]).collect()
    };
    let (with, without) = (clusters_of(true), clusters_of(false));
    let both = with.intersection(&without).count();
    let is_within = both >= FEWEST_BOTH;
    // a single cluster has independent rows
    let clusters: BTreeSet<usize> = with.union(&without).copied().collect();
    let own: Vec<usize> = (0..n).collect();
    let cluster = if clusters.len() < FEWEST_BOTH { &own } else { cluster };
    let level: Vec<usize> = if is_within { cluster.to_vec() } else { vec![0; n] };
    let mut all = columns.to_vec();
    all.push(is_of.iter().map(|is| f64::from(u8::from(*is))).collect());
    let within = WithinGroups::fit(value, &all, &level, &vec![true; n]);
    let place = within.columns.iter().position(|column| *column == columns.len())?;
    let width = within.columns.len();
    let levels = level.iter().max()? + 1;
    let mut means = vec![(vec![0.0; width + 1], 0.0); levels];
    let row = |k: usize| -> Vec<f64> {
        let x = within.columns.iter().map(|column| all[*column][k]);
        x.chain([value[k]]).collect()
    };
    for k in 0..n {
        let (sums, count) = &mut means[level[k]];
        sums.iter_mut().zip(row(k)).for_each(|(sum, x)| *sum += x);
        *count += 1.0;
    }
    let mut parts = vec![Cluster::nothing(width); cluster.iter().max()? + 1];
    for k in 0..n {
        let (sums, count) = &means[level[k]];
        let centred: Vec<f64> = row(k).iter().zip(sums).map(|(x, sum)| x - sum / count).collect();
        let x = DVector::from_column_slice(&centred[..width]);
        let fitted: f64 = x.iter().zip(&within.slopes).map(|(x, slope)| x * slope).sum();
        parts[cluster[k]].add(&x, centred[width] - fitted);
    }
    let mut unit = DVector::zeros(width);
    unit[place] = 1.0;
    let error = ClusterMoves::of(&parts)?.error_of(&unit);
    if error.informative < FEWEST_BOTH || !(error.degrees > 0.0) {
        return None;
    }
    let difference = within.slopes[place];
    let t = t_of_interval(0.95, error.degrees);
    let of_kind = is_of.iter().filter(|is| **is).count();
    Some(Contrast {
        difference,
        standard_error: error.standard_error,
        degrees: error.degrees,
        ci95: around(difference, error.standard_error, t),
        rows: [n - of_kind, of_kind],
        clusters_of_both: both,
        is_within,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::random::{Draws, Stream};

    /// Trucks with levels and own changes since a date: their mean change is known.
    fn rows(seed: u64) -> (Vec<f64>, Vec<bool>, Vec<Vec<f64>>, Vec<usize>) {
        let mut draws = Draws::new(seed, 0, Stream::Bootstrap);
        let (mut y, mut is_of, mut x, mut cluster) = (vec![], vec![], vec![], vec![]);
        for truck in 0..12 {
            let (level, change) = (0.03 * draws.normal(), -0.03 + 0.01 * draws.normal());
            for k in 0..4 + 2 * truck {
                let (after, load) = (k % 3 == 0, draws.normal());
                let own = if after { change } else { 0.0 };
                y.push(level + own + 0.2 * load + 0.04 * draws.normal());
                is_of.push(after);
                x.push(load);
                cluster.push(truck);
            }
        }
        (y, is_of, vec![x], cluster)
    }

    #[test]
    fn the_interval_of_a_known_saving_covers() {
        let mut covered = 0;
        for seed in 0..400 {
            let (y, is_of, x, cluster) = rows(seed);
            let contrast = contrast(&y, &is_of, &x, &cluster).unwrap();
            assert!(contrast.is_within && contrast.clusters_of_both == 12);
            covered += usize::from(contrast.ci95[0] <= -0.03 && -0.03 <= contrast.ci95[1]);
        }
        // 95 % of 400 with three binomial errors
        assert!((367..=393).contains(&covered), "{covered}");
    }

    #[test]
    fn clusters_of_one_kind_are_compared_and_a_kind_that_is_another_column_is_none() {
        let (y, _, x, cluster) = rows(1);
        let even: Vec<bool> = cluster.iter().map(|truck| truck % 2 == 0).collect();
        let compared = contrast(&y, &even, &x, &cluster).unwrap();
        assert!(!compared.is_within && compared.clusters_of_both == 0 && compared.degrees < 11.0);
        let same = even.iter().map(|is| f64::from(u8::from(*is))).collect();
        assert_eq!(contrast(&y, &even, &[same], &cluster), None);
    }
}
