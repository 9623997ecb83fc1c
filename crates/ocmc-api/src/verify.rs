//! Whether the files of a run directory are what was written.

use crate::answer::Answer;
use crate::error::Error;
use ocmc_io::run_directory::{self, MANIFEST, RunDirectoryError, Verified, runs_in};
use serde::Serialize;
use std::path::{Path, PathBuf};

pub use ocmc_io::run_directory::CheckedFile;

/// Findings in a run directory.
#[derive(Clone, Debug, Serialize)]
pub struct VerifyAnswer {
    /// Whether every file is what was written.
    pub whole: bool,
    #[serde(flatten)]
    verified: Verified,
}

impl VerifyAnswer {
    /// Its files, in the order of their names.
    pub fn files(&self) -> &[CheckedFile] {
        &self.verified.files
    }
}

impl Answer for VerifyAnswer {
    fn text(&self) -> String {
        let line = |file: &CheckedFile| match &file.fault {
            None => format!("whole    {}\n", file.name),
            Some(fault) => format!("damaged  {}: {fault}\n", file.name),
        };
        let missing = self.verified.unfinished.iter();
        let missing = missing.map(|missing| format!("not complete: {missing}\n"));
        self.files().iter().map(line).chain(missing).collect()
    }
}

/// Checks every file that a run has written: of a run that has ended, or of one that can be
/// resumed. Of a folder with several runs, such as those of the groups of a fleet, the files of
/// all.
///
/// ```
/// use ocmc_api::{GivenDrive, RecordFormat, RunPlan, RunRequest, go_on, run, study, verify};
/// let study = study::load("field-truck", &["mission.length_m=3000"])?;
/// let folder = tempfile::tempdir().expect("a directory");
/// let path = folder.path().join("a");
/// let (given, plan) = (&GivenDrive::nothing(), RunPlan::new(1, 0, 4, None, None));
/// let out = Some((path.clone(), RecordFormat::Csv));
/// run(&RunRequest { study: &study, given, plan, precision: None, out }, &mut |_| (), &mut go_on)?;
/// assert!(verify(&path)?.whole);
/// std::fs::write(path.join("records.csv"), "changed").expect("space");
/// assert!(!verify(&path)?.whole);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::RunDirectory`] where there is no run.
pub fn verify(directory: &Path) -> Result<VerifyAnswer, Error> {
    let runs = runs_in(directory);
    let verified = if runs.is_empty() { run_directory::verify(directory)? } else { all_of(&runs)? };
    Ok(VerifyAnswer { whole: verified.is_whole(), verified })
}

/// The files of several runs, with the names of their directories in front, and the state that they
/// have in common.
fn all_of(runs: &[PathBuf]) -> Result<Verified, Error> {
    let (mut states, mut unfinished, mut files) = (Vec::new(), Vec::new(), Vec::new());
    for run in runs {
        let verified = match run_directory::verify(run) {
            Err(error @ RunDirectoryError::NotARun { .. }) => {
                let (name, fault) = (MANIFEST.to_owned(), Some(error.to_string()));
                let files = vec![CheckedFile { name, fault }];
                Verified { status: None, unfinished: Vec::new(), files }
            }
            result => result?,
        };
        states.push(verified.status);
        unfinished.extend(verified.unfinished);
        let group = run.file_name().unwrap_or_default().to_string_lossy();
        files.extend(verified.files.into_iter().map(|file| {
            let name = format!("{group}/{}", file.name);
            CheckedFile { name, ..file }
        }));
    }
    let first = states.first().copied().flatten();
    let status = first.filter(|first| states.iter().all(|state| *state == Some(*first)));
    Ok(Verified { status, unfinished, files })
}
