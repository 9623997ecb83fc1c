//! The parts of one run, from many machines, as one run.

use crate::error::Error;
use crate::run::{RunAnswer, RunEnd};
use ocmc_io::records::RecordFormat;
use ocmc_io::run_directory::{self, read_manifest};
use std::path::{Path, PathBuf};

/// The parts, and where the whole goes.
#[derive(Clone, Debug)]
pub struct MergeRequest<'a> {
    /// Run directories of the parts, in any order.
    pub parts: &'a [PathBuf],
    /// Directory for the whole run.
    pub out: &'a Path,
    /// Format of the records; that of the first part where there is none.
    pub format: Option<RecordFormat>,
}

/// Merges the parts into the run that one machine would have written.
///
/// ```
/// use ocmc_api::{GivenDrive, MergeRequest, RecordFormat, RunPlan, RunRequest};
/// use ocmc_api::{go_on, merge, run, study};
/// let study = study::load("field-truck", &["mission.length_m=3000"])?;
/// let folder = tempfile::tempdir().expect("a directory");
/// let parts = [folder.path().join("a"), folder.path().join("b")];
/// for (path, first_cycle) in parts.iter().zip([0, 4]) {
///     let (given, plan) = (&GivenDrive::nothing(), RunPlan::new(1, first_cycle, 4, None, None));
///     let out = Some((path.clone(), RecordFormat::Csv));
///     let request = RunRequest { study: &study, given, plan, precision: None, out };
///     run(&request, &mut |_| (), &mut go_on)?;
/// }
/// let out = &folder.path().join("whole");
/// let whole = merge(&MergeRequest { parts: &parts, out, format: None })?;
/// assert_eq!((whole.manifest.first_cycle, whole.manifest.cycles), (0, 8));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::RunDirectory`] names the parts that are not those of one run.
pub fn merge(request: &MergeRequest) -> Result<RunAnswer, Error> {
    let MergeRequest { parts, out, format } = request;
    let summary = run_directory::merge(parts, out, *format)?;
    Ok(RunAnswer::stored(read_manifest(out)?, summary, RunEnd::Complete))
}
