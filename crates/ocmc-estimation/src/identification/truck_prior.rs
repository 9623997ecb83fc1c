//! Spread of the trucks of a study before a log of one of them is read: how much their masses and
//! their resistances differ.
//!
//! Standard deviations of draws of the study's own laws, payload, rolling factor and drag area. A
//! study that names one payload and one truck does not know the load of the logged one, so that
//! neither spread is below a floor.

use crate::moments::Moments;
use ocmc_core::random::Streams;
use ocmc_core::study::Study;

/// Draws.
const DRAWS: u64 = 256;
/// Length of their roads, in m, where a law of the payload asks for it.
const ROAD_M: f64 = 10_000.0;
/// Smallest standard deviations of mass and resistance, as shares [EJ].
const LEAST_MASS_SHARE: f64 = 0.2;
const LEAST_RESISTANCE_SHARE: f64 = 0.1;

/// Spread of the trucks of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TruckPrior {
    /// Standard deviation of the mass, as a share of its mean.
    pub(super) mass_sd_share: f64,
    /// Standard deviation of rolling resistance and air drag, as a share of them.
    pub(super) resistance_sd_share: f64,
}

impl TruckPrior {
    /// Draws the trucks of a study.
    pub(super) fn of(study: &Study) -> Self {
        let model = study.model();
        let (mut masses, mut rolling, mut drag) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..DRAWS {
            let streams = Streams::new(0, k);
            let payload_kg = model.mission.sample(Some(ROAD_M), &streams, &[]).payload_kg;
            let truck = model.vehicle.sample(payload_kg, &streams, &[]);
            masses.push(truck.mass_kg);
            rolling.push(truck.rolling_factor);
            drag.push(truck.drag_area_m2);
        }
        let share = |values: &[f64]| {
            let moments = Moments::of(values);
            moments.sd() / moments.mean
        };
        Self {
            mass_sd_share: share(&masses).max(LEAST_MASS_SHARE),
            resistance_sd_share: share(&rolling).max(share(&drag)).max(LEAST_RESISTANCE_SHARE),
        }
    }
}
