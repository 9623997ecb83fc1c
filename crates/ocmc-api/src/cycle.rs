//! One realised operating cycle.

use ocmc_io::study::LoadedStudy;

pub use ocmc_core::operating_cycle::tracks::{Track, Values};
pub use ocmc_io::operating_cycle::RealisedCycle;

/// The operating cycle that a study draws, without the driver and the truck.
///
/// ```
/// use ocmc_api::{operating_cycle, study};
/// let study = study::load("field-truck", &["mission.length_m=3000"])?;
/// let cycle = operating_cycle(&study, 1, 17);
/// assert_eq!((cycle.length_m, cycle.tracks[0].name), (3000.0, "road_type"));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
pub fn operating_cycle(study: &LoadedStudy, seed: u64, cycle_id: u64) -> RealisedCycle {
    RealisedCycle::new(study, seed, cycle_id)
}
