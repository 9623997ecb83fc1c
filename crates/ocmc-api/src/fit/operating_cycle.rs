//! The road model of given operating cycles or logs, and their bird's-eye view.

use super::operating_cycle_text::roads_text;
use super::{FitAnswer, no_fit};
use crate::cycle::RealisedCycle;
use crate::error::Error;
use crate::progress::{Progress, Watch};
use crate::source::{Mapping, Source};
use ocmc_core::study::StudyModel;
use ocmc_estimation::fit::operating_cycle::{RoadFit, fit_with_coverage};
use ocmc_io::given_cycle;
use ocmc_io::log::curves::Steering;
use ocmc_io::log::roads::{FoundRoads, NEEDS, is_log};
use ocmc_io::study::FittedPart;
use std::path::Path;

pub use ocmc_estimation::log::road::RoadOptions;

/// Roads, and what is asked of them.
#[derive(Clone, Debug)]
pub struct OperatingCycleRequest<'a> {
    /// Operating cycles and logs.
    pub roads: &'a [RoadSource<'a>],
    /// Which column of a log is what; where one is said, all files are logs.
    pub mappings: Vec<Mapping>,
    /// The study with these road types that keeps what roads do not tell.
    pub base: &'a StudyModel,
    /// How logs are read.
    pub options: RoadOptions,
    /// Radii of the curves that are known; those of `options` for logs, all for operating cycles
    /// where there are none.
    pub radius_range_m: Option<[f64; 2]>,
    /// What the steering wheel does, for logs that only have its angle.
    pub steering: Option<Steering>,
}

/// A road.
#[derive(Clone, Debug)]
pub enum RoadSource<'a> {
    /// An operating cycle of a study.
    Cycle(&'a RealisedCycle),
    /// A file or a table: a log, or, where it has no column of one, an operating cycle.
    Measured(Source),
}

/// Fits the road model. `warn` receives what is odd in a log, and what is left out of it.
///
/// ```
/// use ocmc_api::{OperatingCycleRequest, RoadOptions, RoadSource, fit_operating_cycle, go_on};
/// use ocmc_api::{operating_cycle, study};
/// let study = study::load("field-truck", &["mission.length_m=5000"])?;
/// let cycles: Vec<_> = (0..20).map(|id| operating_cycle(&study, 1, id)).collect();
/// let roads: Vec<_> = cycles.iter().map(RoadSource::Cycle).collect();
/// let request = OperatingCycleRequest {
///     roads: &roads,
///     mappings: Vec::new(),
///     base: &study.model,
///     options: RoadOptions::default(),
///     radius_range_m: None,
///     steering: None,
/// };
/// let fit = fit_operating_cycle(&request, &mut |_| (), &mut go_on)?.fit;
/// assert_eq!((fit.cycles, fit.length_m), (20, 100_000.0));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where something cannot be read, [`Error::Drive`]
/// where no drive can be used, [`Error::Fit`] where the roads do not determine the model,
/// [`Error::Interrupted`].
pub fn fit_operating_cycle(
    request: &OperatingCycleRequest,
    warn: &mut dyn FnMut(&str),
    watch: &mut Watch,
) -> Result<FitAnswer<RoadFit>, Error> {
    let OperatingCycleRequest { roads, mappings, base, options, radius_range_m, steering } =
        request;
    let mut found = FoundRoads::default();
    for (done, road) in roads.iter().enumerate() {
        let progress = Progress::of_logs(done, roads.len());
        progress.look(watch)?;
        match road {
            RoadSource::Cycle(cycle) => {
                found.add_cycle(cycle.given().map_err(|error| no_fit(source(roads), error))?);
            }
            RoadSource::Measured(Source::File(path))
                if mappings.is_empty() && !is_log(path, mappings) =>
            {
                found.add_cycle(given_cycle::read(path, &[])?);
            }
            RoadSource::Measured(log) => {
                let file = log.log(mappings, &NEEDS, warn)?;
                progress.ended(found.add(&file, options, *steering, || watch(progress)))?;
            }
        }
    }
    if let Some((place, fault)) = found.failed() {
        return Err(Error::Drive { place: place.clone(), fault: fault.clone() });
    }
    found.notes.iter().for_each(|note| warn(note));
    for (place, fault) in &found.left_out {
        warn(&format!("{place} is left out: {fault}"));
    }
    let coverage = found.coverage(*radius_range_m);
    let fit = fit_with_coverage(&found.roads, &coverage, base)
        .map_err(|error| no_fit(source(roads), error))?;
    let part = FittedPart::new(base, &[], &fit.study());
    let (text, warnings) = (roads_text(&fit, &part.text()), fit.warnings.clone());
    Ok(FitAnswer::new(fit, text, &warnings, &part))
}

/// What messages call the roads: by the first one.
fn source<'a>(roads: &'a [RoadSource]) -> &'a Path {
    match roads.first() {
        Some(RoadSource::Measured(source)) => source.path(),
        _ => "cycles".as_ref(),
    }
}
