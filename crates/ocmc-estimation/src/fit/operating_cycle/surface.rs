//! Roughness and ground.

use super::TypeRoads;
use crate::fit::study_parameter::Estimates;
use crate::moments::Moments;
use ocmc_core::operating_cycle::road::RoadTypeModel;

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
