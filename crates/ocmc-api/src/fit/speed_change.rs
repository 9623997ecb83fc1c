//! Log-normal accelerations and decelerations at changes of the speed limit.

use super::speed_change_text::speed_change_text;
use super::{FitAnswer, no_fit};
use crate::error::Error;
use crate::progress::{Progress, Watch};
use crate::source::{Mapping, Source};
use ocmc_core::study::StudyModel;
use ocmc_estimation::fit::speed_change::{SpeedChangeFit, SpeedChangeTable, fit};
use ocmc_io::speed_change_table::append;
use ocmc_io::study::FittedPart;

pub use ocmc_estimation::fit::speed_change::SpeedChangeOptions;

/// Speed changes, and what is asked of them.
#[derive(Clone, Debug)]
pub struct SpeedChangeRequest<'a> {
    /// Tables with one row a change, or logs; one at least.
    pub tables: &'a [Source],
    /// Which column of a log is what.
    pub mappings: Vec<Mapping>,
    /// The study that keeps what was not measured.
    pub base: &'a StudyModel,
    /// What counts as a change.
    pub options: SpeedChangeOptions,
    /// The study from the laws with the thresholds in their likelihood.
    pub untruncated: bool,
}

/// Fits accelerations and decelerations. `warn` receives what is odd in a log.
///
/// ```
/// use ocmc_api::{SpeedChangeOptions, SpeedChangeRequest, Source, fit_speed_change, go_on, study};
/// let folder = tempfile::tempdir().expect("a directory");
/// let file = folder.path().join("changes.csv");
/// std::fs::write(&file, "acceleration_mps2\n0.4\n0.5\n0.8\n-0.5\n-0.6\n-0.9\n").expect("space");
/// let base = study::load("field-truck", &[] as &[&str])?.model;
/// let request = SpeedChangeRequest {
///     tables: &[Source::File(file)],
///     mappings: Vec::new(),
///     base: &base,
///     options: SpeedChangeOptions::default(),
///     untruncated: false,
/// };
/// let fit = fit_speed_change(&request, &mut |_| (), &mut go_on)?.fit;
/// assert_eq!(fit.deceleration.expect("three of them").n, 3);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::SpeedChange`] where a table or a log cannot be read, [`Error::Fit`] where no change is
/// left, [`Error::Interrupted`].
pub fn fit_speed_change(
    request: &SpeedChangeRequest,
    warn: &mut dyn FnMut(&str),
    watch: &mut Watch,
) -> Result<FitAnswer<SpeedChangeFit>, Error> {
    let SpeedChangeRequest { tables, mappings, base, options, untruncated } = request;
    let mut changes = SpeedChangeTable::default();
    for (done, source) in tables.iter().enumerate() {
        Progress::of_logs(done, tables.len()).look(watch)?;
        let notes = append(&mut changes, source.lent(), mappings, options)?;
        for note in notes {
            warn(&note);
        }
    }
    let source = tables.first().map_or("".as_ref(), Source::path);
    let fit = fit(&changes, options).map_err(|error| no_fit(source, error))?;
    let population = fit.population(&base.driver.speed_change, *untruncated);
    let part = FittedPart::new(base, &["driver", "speed_change"], &population);
    let laws = [("acceleration", &fit.acceleration), ("deceleration", &fit.deceleration)];
    let missing = laws.into_iter().filter(|(_, law)| law.is_none());
    let warning = |name| format!("no {name} was measured: the study keeps the one of its base");
    let mut warnings: Vec<String> = missing.map(|(name, _)| warning(name)).collect();
    if fit.drivers == 1 {
        warnings.push("there is one driver only: nothing is known about how drivers differ".into());
    }
    let text = speed_change_text(&fit, &part.text());
    Ok(FitAnswer::new(fit, text, &warnings, &part))
}
