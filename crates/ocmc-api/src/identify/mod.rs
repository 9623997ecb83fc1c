//! The pedal gains of drivers, one fit for each driver and event.

mod text;

use crate::answer::Answer;
use crate::error::Error;
use crate::progress::{Progress, Watch};
use crate::source::{Mapping, Source};
use crate::watch::aside;
use ocmc_estimation::identification::identify::EventFit;
use ocmc_estimation::identification::population::Population;
use ocmc_io::log::identification::{Identification, LeftOut};
use ocmc_io::log::pedals::NEEDS;
use ocmc_io::study::{LoadedStudy, Origin};
use serde::Serialize;

pub use ocmc_estimation::identification::identify::{ControllerKind, IdentifyOptions, SpeedTerm};

/// Logs, and what is asked of them.
#[derive(Clone, Debug)]
pub struct IdentifyRequest<'a> {
    /// The logs.
    pub logs: &'a [Source],
    /// The study with the truck that was driven.
    pub study: &'a LoadedStudy,
    /// Which column is what.
    pub mappings: Vec<Mapping>,
    /// What is fitted, and how.
    pub options: IdentifyOptions,
    /// Whether to warn of rows that are not used; the answer's notes name them anyway.
    pub warn_of_rows: bool,
}

/// The pedal gains.
#[derive(Clone, Debug, Serialize)]
pub struct IdentifyAnswer {
    /// What the study is called.
    pub study: String,
    /// What was fitted, and how.
    pub options: IdentifyOptions,
    /// A fit for each driver and event.
    pub fits: Vec<EventFit>,
    /// The population behind them, of three drivers or more.
    pub population: Option<Population>,
    /// What has no fit.
    pub left_out: Vec<LeftOut>,
    /// Rows that are not used.
    pub notes: Vec<String>,
    #[serde(skip)]
    warnings: Vec<String>,
}

/// Fits each event of each log, and the population behind them. `warn` receives what is odd in a
/// log.
///
/// ```
/// use ocmc_api::{Error, IdentifyOptions, IdentifyRequest, Source, go_on, identify, study};
/// let folder = tempfile::tempdir().expect("a directory");
/// let file = folder.path().join("log.csv");
/// std::fs::write(&file, "time_s,speed_mps,accelerator,brake,grade\n0,20,0.3,0,0\n1,20,0.3,0,0\n").expect("space");
/// let study = &study::load("simulator-study", &[] as &[&str])?;
/// let (logs, options) = (&[Source::File(file)], IdentifyOptions::default());
/// let request = IdentifyRequest { logs, study, mappings: Vec::new(), options, warn_of_rows: true };
/// // on a level road there is no event
/// let answer = identify(&request, &mut |_| (), &mut go_on);
/// assert!(matches!(answer, Err(Error::NoEvent { .. })));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Bounds`] where the bounds of a gain are none, [`Error::Table`] where a log cannot be
/// read, [`Error::NoEvent`] where no event has a fit, [`Error::Interrupted`].
pub fn identify(
    request: &IdentifyRequest,
    warn: &mut dyn FnMut(&str),
    watch: &mut Watch,
) -> Result<IdentifyAnswer, Error> {
    let IdentifyRequest { logs, study, mappings, options, warn_of_rows } = request;
    options.check()?;
    let mut found = Identification::default();
    for (done, log) in logs.iter().enumerate() {
        Progress::of_logs(done, logs.len()).look(watch)?;
        found.add(&log.log(mappings, &NEEDS, warn)?);
    }
    if *warn_of_rows {
        found.notes.iter().for_each(|note| warn(note));
    }
    let start = Progress { what: "events", done: 0, total: found.waiting() as u64 };
    aside(start, watch, |stop, done| found.identify(&study.study, options, stop, done))?;
    if let Some(LeftOut { place, reason, .. }) = found.failed() {
        return Err(Error::NoEvent { place, reason });
    }
    let study = match &study.origin {
        Origin::Dictionary => study.model.study.name.clone(),
        other => other.to_string(),
    };
    let (population, warnings) = (found.population(), found.left_out_warnings());
    let Identification { fits, left_out, notes, .. } = found;
    Ok(IdentifyAnswer { study, options: *options, fits, population, left_out, notes, warnings })
}

impl Answer for IdentifyAnswer {
    fn text(&self) -> String {
        text::text(&self.fits, self.population.as_ref())
    }

    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }
}
