//! `ocmc report`: a run, or each of several, as one HTML file or one workbook.

use crate::arguments::QuietOption;
use crate::failure::Failure;
use crate::output;
use crate::progress::busy;
use clap::Args;
use ocmc_api::number_text::count_of;
use ocmc_api::shell_word::shell_word;
use ocmc_api::{
    Error, REPORT, Reported, WORKBOOK, directory_of, note_report, runs_in, stored_workbook,
};
use std::path::{Path, PathBuf};

/// The run to report on.
#[derive(Clone, Debug, Args)]
pub(crate) struct ReportArguments {
    /// Directory of a run, as --out wrote it, or of a fleet's groups, each of which gets a report
    #[arg(value_name = "RUN_DIR")]
    directory: PathBuf,
    /// File to write; an existing one is replaced [default: report.html in the run directory]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Writes a workbook for spreadsheets instead: answer, routes, trucks, records, study; an
    /// existing one is replaced [default: run.xlsx in the run directory]
    #[arg(long, value_name = "FILE", num_args = 0..=1, conflicts_with = "out")]
    #[allow(
        clippy::option_option,
        reason = "clap's form of an option whose value may be left out"
    )]
    xlsx: Option<Option<PathBuf>>,
    #[command(flatten)]
    quiet: QuietOption,
}

/// Reads a run and writes its report: one HTML file, or a workbook.
pub(crate) fn report(arguments: &ReportArguments) -> Result<(), Failure> {
    let ReportArguments { directory, out, xlsx, quiet: QuietOption { quiet } } = arguments;
    let runs = runs_in(directory);
    let file = out.as_deref().or(xlsx.as_ref().and_then(Option::as_deref));
    if let (Some(file), Some(first)) = (file, runs.first()) {
        return Err(Failure::Usage(format!(
            "`{}` is for one run, and `{}` holds {}: take one of them, as in `ocmc report {}`, or \
             give no file",
            file.display(),
            directory.display(),
            count_of(runs.len() as u64, "run"),
            shell_word(first)
        )));
    }
    let runs = if runs.is_empty() { vec![directory.clone()] } else { runs };
    let write = |run: &PathBuf| match xlsx {
        Some(file) => workbook(run, file.as_deref(), *quiet),
        None => page(run, out.as_deref(), *quiet),
    };
    let written = runs.iter().map(write).collect::<Result<Vec<_>, _>>()?;
    let named: Vec<String> = written.iter().map(|path| format!("`{}`", path.display())).collect();
    let program = if xlsx.is_some() { "spreadsheet" } else { "browser" };
    let them = if named.len() > 1 { "them" } else { "it" };
    if !quiet {
        output::note(&format!("Written: {}. Any {program} opens {them}.", named.join(", ")));
    }
    Ok(())
}

/// Reads a run, writes its page, and says where it is.
fn page(directory: &Path, out: Option<&Path>, quiet: bool) -> Result<PathBuf, Failure> {
    let run = busy(quiet, "reading the run", || Reported::read(directory)).map_err(Error::from)?;
    let path = match out {
        Some(path) => path.to_owned(),
        None => own_file(directory, REPORT, "--out where the report goes")?,
    };
    output::write(&path, ocmc_api::report(&run))?;
    if out.is_none() {
        note_report(directory_of(directory)).map_err(Error::from)?;
    }
    Ok(path)
}

/// A file of a run directory that is to be written; one that leads elsewhere is not. `otherwise`
/// says with what another one is named.
pub(crate) fn own_file(
    directory: &Path,
    name: &str,
    otherwise: &'static str,
) -> Result<PathBuf, Failure> {
    let path = directory_of(directory).join(name);
    if path.is_symlink() {
        return Err(Failure::Link { path, otherwise });
    }
    Ok(path)
}

/// Reads a run, writes its workbook, and says where it is.
fn workbook(directory: &Path, file: Option<&Path>, quiet: bool) -> Result<PathBuf, Failure> {
    match file {
        None => drop(own_file(directory, WORKBOOK, "--xlsx FILE where the workbook goes")?),
        Some(file) if file.extension().is_some_and(|ending| ending == "xlsx") => {}
        Some(_) => {
            let text = "the name after --xlsx has to end in `.xlsx`";
            return Err(Failure::Usage(text.to_owned()));
        }
    }
    Ok(busy(quiet, "writing the workbook", || stored_workbook(directory, file))?)
}
