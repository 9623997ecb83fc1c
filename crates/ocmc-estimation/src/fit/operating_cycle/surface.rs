//! Slope, roughness and ground.

use super::TypeRoads;
use crate::fit::p_value::NORMAL_975;
use crate::fit::study_parameter::Estimates;
use crate::moments::Moments;
use ocmc_core::fleet::ratio::Ratio;
use ocmc_core::operating_cycle::road::RoadTypeModel;
use ocmc_core::operating_cycle::road::topography::TopographyModel;

/// SD of the slope, and hill length by the share of steps at which the slope changes its sign: L_h
/// = 2 L_s / share. The errors take roads as independent.
pub(super) fn fit_slopes(
    roads: &TypeRoads,
    step_m: f64,
    model: &mut TopographyModel,
    estimates: &mut Estimates,
) {
    // of each road: squares, steps, changes of sign, pairs
    let cycles = roads.slopes.iter().map(|(cycle, _)| cycle + 1).max().unwrap_or(0);
    let mut sums = vec![[0.0; 4]; cycles];
    for (cycle, slopes) in &roads.slopes {
        let squares: f64 = slopes.iter().map(|slope| slope * slope).sum();
        let changes = slopes.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count();
        let of =
            [squares, slopes.len() as f64, changes as f64, slopes.len().saturating_sub(1) as f64];
        for (sum, value) in sums[*cycle].iter_mut().zip(of) {
            *sum += value;
        }
    }
    let ratio = |over: usize, under: usize| {
        let pairs = sums.iter().filter(|sums| sums[under] > 0.0).map(|s| (s[over], s[under]));
        Ratio::estimate(pairs)
    };
    let (Some(variance), Some(changes)) = (ratio(0, 1), ratio(2, 3)) else {
        estimates.warn("it is too short to tell about slopes, or none of them is known: they stay those of the base study");
        return;
    };
    let relative = |ratio: &Ratio| {
        let half = ratio.ci95.map(|[low, high]| 0.5 * (high - low));
        half.map(|half| half / NORMAL_975 / ratio.ratio)
    };
    let steps = roads.slopes.iter().map(|slopes| slopes.1.len()).sum();
    let sd = libm::sqrt(variance.ratio);
    if !(sd > 0.0) {
        return estimates.warn("it is flat: its slopes stay those of the base study");
    }
    let error = relative(&variance).map(|e| 0.5 * e * sd);
    estimates.set("topography.slope_sd", &mut model.slope_sd, sd, error, steps);
    let hill = 2.0 * step_m / changes.ratio;
    if hill.is_finite() && hill > 4.0 * step_m {
        let error = relative(&changes).map(|e| e * hill);
        estimates.set("topography.hill_length_m", &mut model.hill_length_m, hill, error, steps);
    } else {
        estimates.warn("the hill length of its slopes is below four steps, or endless: it stays that of the base study");
    }
}

/// Roughness by moments of its blocks, ground by its stretches.
pub(super) fn fit_surface(roads: &TypeRoads, model: &mut RoadTypeModel, estimates: &mut Estimates) {
    let (n, blocks) = (roads.blocks.len(), Moments::of(&roads.blocks));
    let (mean, variance) = (blocks.mean, blocks.variance());
    if n >= 2 && mean > 0.0 && variance > 0.0 {
        let (error, into) = (blocks.standard_error(), &mut model.roughness.mean_coefficient_m3);
        estimates.set("roughness.mean_coefficient_m3", into, mean, Some(error), n);
        let shape = variance / (mean * mean);
        estimates.set("roughness.shape", &mut model.roughness.shape, shape, None, n);
    }
    let stretches: usize = roads.grounds.values().sum();
    if stretches > 0 {
        for share in model.ground.values_mut() {
            *share = 0.0;
        }
        for (ground, &count) in &roads.grounds {
            let into = model.ground.entry(*ground).or_default();
            estimates.share(&format!("ground.{}", ground.name()), into, count, stretches);
        }
    }
}
