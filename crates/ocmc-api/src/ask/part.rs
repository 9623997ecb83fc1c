//! Parts of the cycles of a question, driven apart from each other and from the answer: by workers
//! of a browser, which share no memory.
//!
//! ```
//! use ocmc_api::ask::{Ask, ask, part};
//! use ocmc_api::{go_on, study::Files};
//! let question = r#"{"ask": "run", "study": {"study": "field-truck",
//!     "set": ["mission.length_m=2000"]}, "plan": {"cycles": 64}}"#;
//! let question: Ask = serde_json::from_str(question).expect("a question");
//! let files = &Files::here();
//! let folder = tempfile::tempdir().expect("a directory");
//! let mut names = Vec::new();
//! for part in part::parts(&question, files, 2)? {
//!     let name = folder.path().join(part.first_cycle.to_string());
//!     names.extend(part::drive(&question, files, part, &name, &mut go_on)?);
//! }
//! assert_eq!(names.len(), 2);
//! let together = part::answer(&question, files, &names, &mut go_on)?;
//! let alone = ask(&question, files, &mut go_on)?;
//! let json =
//!     [together, alone].map(|reply| serde_json::to_value(reply).expect("numbers and words"));
//! assert!(json[0]["answer"]["statistics"].is_object());
//! assert_eq!(json[0]["answer"]["statistics"], json[1]["answer"]["statistics"]);
//! # Ok::<(), ocmc_api::Error>(())
//! ```

use super::{Ask, AskCompare, Reply, ask_known, of_run, opened, planned, planned_run};
use crate::error::Error;
use crate::progress::Watch;
use crate::run::RunPlan;
use crate::study::{Files, LoadedStudy, Opened};
use crate::watch::watched;
use ocmc_core::record::Record;
use ocmc_fleet::run::records;
use ocmc_io::records::{Compression, EncodedGroup, GROUP_ROWS, RecordFormat, RecordWriter};
use ocmc_io::records::{RecordsError, read};
use ocmc_io::run_directory::RunDirectoryError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Fewest cycles with which it is worth sharing: they fill the lanes.
const FEWEST: u64 = 32;

/// Consecutive cycles of a question.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// Id of the first one.
    pub first_cycle: u64,
    /// Number of cycles.
    pub cycles: u64,
}

/// Parts of a question for that many workers, of whole trucks; none where it is not shared: that is
/// all but runs and comparisons, and runs that end at a precision.
///
/// # Errors
/// Those of the studies.
pub fn parts(question: &Ask, files: &Files, workers: u64) -> Result<Vec<Part>, Error> {
    let Some((studies, plan)) = shared(question, files)? else { return Ok(Vec::new()) };
    let trips = studies.iter().map(|study| study.study.nesting().trips_per_truck);
    let truck = trips.max().unwrap_or(1).max(1);
    let is_whole = |count: u64| {
        studies.iter().all(|study| count.is_multiple_of(study.study.nesting().trips_per_truck))
    };
    let workers = workers.min(plan.cycles / FEWEST.max(truck));
    if workers < 2 || ![plan.first_cycle, plan.cycles, truck].into_iter().all(is_whole) {
        return Ok(Vec::new());
    }
    let trucks = plan.cycles / truck;
    let begin = |worker: u64| worker * trucks / workers * truck;
    let parts = (0..workers).map(|worker| {
        let (begin, end) = (begin(worker), begin(worker + 1));
        let end = if worker + 1 == workers { plan.cycles } else { end };
        Part { first_cycle: plan.first_cycle + begin, cycles: end - begin }
    });
    Ok(parts.collect())
}

/// Drives a part in each study, and writes the records of each to a file whose name begins so.
///
/// # Errors
/// Those of the studies, and [`Error::Unwritten`].
pub fn drive(
    question: &Ask,
    files: &Files,
    part: Part,
    name: &Path,
    watch: &mut Watch,
) -> Result<Vec<PathBuf>, Error> {
    let Some((studies, plan)) = shared(question, files)? else { return Ok(Vec::new()) };
    let Part { first_cycle, cycles } = part;
    let plan = RunPlan::new(plan.seed, first_cycle, cycles, Some(plan.threads), None);
    let mut written = Vec::new();
    for (k, study) in studies.iter().enumerate() {
        let before = k as u64 * cycles;
        let driven = watched(cycles * studies.len() as u64, watch, |look| {
            records(&study.study, &plan, |done| look(before + done))
        })?;
        let mut path = name.as_os_str().to_owned();
        path.push(format!(".{k}.csv"));
        let path = PathBuf::from(path);
        write(&path, &driven).map_err(unwritten)?;
        written.push(path);
    }
    Ok(written)
}

/// Answers a question of the records that [`drive`] has written of all its parts, in the order of
/// these.
///
/// # Errors
/// Those of [`ask`](super::ask), and [`Error::RunDirectory`] where a file has no records.
pub fn answer(
    question: &Ask,
    files: &Files,
    written: &[PathBuf],
    watch: &mut Watch,
) -> Result<Reply, Error> {
    let Some((studies, _)) = shared(question, files)? else {
        return ask_known(question, files, None, watch);
    };
    let mut known = vec![Vec::new(); studies.len()];
    for (k, path) in written.iter().enumerate() {
        let known: &mut Vec<Record> = &mut known[k % studies.len()];
        read(path, |group| known.extend(group.records)).map_err(RunDirectoryError::from)?;
    }
    ask_known(question, files, Some(known), watch)
}

/// The studies whose cycles are shared, and these.
fn shared(question: &Ask, files: &Files) -> Result<Option<(Vec<LoadedStudy>, RunPlan)>, Error> {
    match question {
        Ask::Run(asked) if asked.precision.is_none() => match of_run(&asked.study, files)? {
            Opened::Study(loaded) => {
                let plan = planned_run(asked, &loaded, None)?;
                Ok(Some((vec![*loaded], plan)))
            }
            Opened::Fleet(_) => Ok(None),
        },
        Ask::Compare(AskCompare { studies, plan, .. }) => {
            let studies = studies.iter().map(|study| opened(study, files));
            Ok(Some((studies.collect::<Result<_, _>>()?, planned(plan)?)))
        }
        _ => Ok(None),
    }
}

fn write(path: &Path, driven: &[Record]) -> Result<(), RecordsError> {
    let mut file = RecordWriter::create(path)?;
    for group in driven.chunks(GROUP_ROWS) {
        let group: [Result<_, RecordsError>; 1] = [Ok(group)];
        file.add(EncodedGroup::new(group, RecordFormat::Csv, Compression::Snappy)?)?;
    }
    file.finish()
}

fn unwritten(error: RecordsError) -> Error {
    Error::Unwritten(error.into())
}
