//! A study learnt from the files of a fleet: what can be fitted is fitted, the rest is calibrated
//! to the totals of its trips, and what nothing tells stays as it was.

mod doubted;
mod fitted;
mod held_back;
mod page;
mod read;
mod text;

use crate::answer::Answer;
use crate::calibrate_totals::{
    CalibrateTotalsAnswer, CalibrateTotalsRequest, HeldBackTrip, Noise, calibrated,
};
use crate::error::Error;
use crate::source::{Mapping, Source};
use crate::watch::Watch;
use fitted::{Fits, laid};
use ocmc_io::export::ExportKind;
use ocmc_io::intake::FileAccount;
use ocmc_io::log::roads::told_once;
use ocmc_io::study::{LoadedStudy, ReplacedNumber, StudyPart};
use ocmc_io::trip_totals::{TripTotal, TripTotals};
use read::Read;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

pub use doubted::Doubted;
pub use fitted::LearntPart;
pub use held_back::HeldBack;

/// The files of a fleet, and what keeps what they do not tell.
#[derive(Clone, Debug)]
pub struct LearnRequest<'a> {
    /// The folder.
    pub folder: PathBuf,
    /// Columns of the quantities, in all tables that have such a column.
    pub mappings: Vec<Mapping>,
    /// The study that keeps what is not learnt, and its name or file.
    pub base: (String, &'a LoadedStudy),
    /// Name of the new study.
    pub name: String,
    /// Noise of the totals.
    pub noise: Noise,
    /// Share of the trips that are held back for the check, by truck and date; 0 for none.
    pub hold_back: f64,
    /// Master seed.
    pub seed: u64,
    /// Threads; one for each processor where there is none.
    pub threads: Option<usize>,
}

/// A file of the folder.
#[derive(Clone, Debug, Serialize)]
pub struct LearntFile {
    /// Its path below the folder.
    pub path: PathBuf,
    /// Kind of the file; none where no reader takes it.
    pub kind: Option<ExportKind>,
    /// Why it is not used.
    pub left_out: Option<String>,
}

/// The answer of learning from the files of a fleet.
#[derive(Clone, Debug, Serialize)]
pub struct LearnAnswer {
    /// The files, in the order of their names.
    pub files: Vec<LearntFile>,
    /// The fits that were tried; where one was refused, the reason.
    pub parts: Vec<LearntPart>,
    /// The calibration to all totals; none where there are none.
    pub totals: Option<CalibrateTotalsAnswer>,
    /// Why there is none.
    pub no_totals: Option<String>,
    /// The study that was learnt from the other trips, on those that were held back.
    pub held_back: Option<HeldBack>,
    /// The parts of the base's mean, and of the new study's, that hang on judged numbers.
    pub doubt: [Doubted; 2],
    /// The judged numbers that others have replaced, each with its standing.
    pub replaced: Vec<ReplacedNumber>,
    /// Entries of judged numbers that nothing replaces.
    pub judged: Vec<String>,
    /// The study, as the text of its file.
    pub study_toml: String,
    /// Accounts of the files that were read.
    pub inputs: Vec<FileAccount>,
    /// How long it took, in s.
    pub wall_s: f64,
    #[serde(skip)]
    warnings: Vec<String>,
}

/// Learns a study from the files of a fleet.
///
/// ```no_run
/// use ocmc_api::{LearnRequest, Noise, go_on, learn, study};
/// let base = &study::load("field-truck", &[] as &[&str])?;
/// let request = LearnRequest {
///     folder: "export".into(),
///     mappings: Vec::new(),
///     base: ("field-truck".to_owned(), base),
///     name: "my-fleet".to_owned(),
///     noise: Noise { amount: 0.03, weight: 0.05 },
///     hold_back: 0.2,
///     seed: 1,
///     threads: None,
/// };
/// let answer = learn(&request, &mut go_on)?;
/// assert!(answer.study_toml.contains("my-fleet"));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::SmallShare`] where a share is out of its range, [`Error::File`] where the folder cannot
/// be read, [`Error::NothingToLearn`] where nothing in it tells anything, [`Error::Interrupted`].
pub fn learn(request: &LearnRequest, watch: &mut Watch) -> Result<LearnAnswer, Error> {
    request.noise.check()?;
    if !(0.0..=0.5).contains(&request.hold_back) {
        return Err(Error::SmallShare { name: "hold_back", value: request.hold_back });
    }
    let clock = Instant::now();
    let (base_name, base) = &request.base;
    let mut read = Read::of(request, watch)?;
    let mut warnings = std::mem::take(&mut read.warnings);
    let kept = Fits::of(request, &read, false, watch)?;
    let held_back = match read.totals.as_ref().filter(|_| request.hold_back > 0.0) {
        Some((table, source)) => {
            let (held, others) = read.apart(request, table);
            let table = TripTotals { rows: others, ..table.clone() };
            let with = Calibration { request, study: &kept.study, source };
            match with.calibrated(table, &held, watch) {
                Ok((answer, trips)) => HeldBack::new(&answer, &trips),
                Err(error @ Error::Interrupted(_)) => return Err(error),
                Err(error) => {
                    warnings.push(format!("there is no check on trips held back: {error}"));
                    None
                }
            }
        }
        None => None,
    };
    let mut all = Fits::of(request, &read, true, watch)?;
    warnings.append(&mut all.warnings);
    let (mut totals, mut no_totals) = (None, None);
    match &read.totals {
        Some((table, source)) => {
            let with = Calibration { request, study: &all.study, source };
            match with.calibrated(table.clone(), &[], watch) {
                Ok((answer, _)) => totals = Some(answer),
                Err(error @ Error::Interrupted(_)) => return Err(error),
                Err(error) => no_totals = Some(error.to_string()),
            }
        }
        None => no_totals = Some("no file has distances and amounts of trips".to_owned()),
    }
    if let Some(answer) = &totals {
        warnings.extend(answer.warnings());
        all.written.push(StudyPart {
            command: "calibrate totals",
            sources: answer.standing.clone(),
            values: answer.study.clone(),
        });
    }
    if all.written.is_empty() {
        let folder = request.folder.clone();
        return Err(Error::NothingToLearn { folder, reason: no_totals.unwrap_or_default() });
    }
    let (study_toml, study) = laid(request, &all.written)?;
    let doubt = [
        Doubted::of(base_name, base, request, watch)?,
        Doubted::of(&request.name, &study, request, watch)?,
    ];
    Ok(LearnAnswer {
        files: read.files,
        parts: all.parts,
        totals,
        no_totals,
        held_back,
        doubt,
        replaced: study.replaced().to_vec(),
        judged: study.judged_by_effect().iter().map(|entry| entry.name.clone()).collect(),
        study_toml,
        inputs: read.inputs,
        wall_s: clock.elapsed().as_secs_f64(),
        warnings,
    })
}

/// A calibration to the totals that were read.
struct Calibration<'a> {
    request: &'a LearnRequest<'a>,
    study: &'a LoadedStudy,
    source: &'a Path,
}

impl Calibration<'_> {
    fn calibrated(
        &self,
        table: TripTotals,
        held_back: &[TripTotal],
        watch: &mut Watch,
    ) -> Result<(CalibrateTotalsAnswer, Vec<HeldBackTrip>), Error> {
        let LearnRequest { noise, seed, threads, .. } = self.request;
        let request = CalibrateTotalsRequest {
            trips: Source::File(self.source.to_owned()),
            mappings: Vec::new(),
            study: self.study,
            noise: *noise,
            seed: *seed,
            threads: *threads,
        };
        let account =
            FileAccount { file: self.source.display().to_string(), ..FileAccount::default() };
        calibrated(&request, (table, account), held_back, watch)
    }
}

impl Answer for LearnAnswer {
    fn text(&self) -> String {
        text::learn_text(self)
    }

    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    fn notes(&self) -> Vec<String> {
        told_once(FileAccount::told_of(&self.inputs).into_iter())
    }
}
