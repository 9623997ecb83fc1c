//! Messages to users about a failure: the fault, and the remedy.

use crate::failure::Failure;
use crate::output::width;
use miette::{
    GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report,
};
use ocmc_api::printable::{is_hidden, printable};
use ocmc_api::shell_word::resume_command;
use ocmc_api::study::{Fault, StudyFileError};
use ocmc_api::{Error, GivenDriveError, RunDirectoryError, SensitivityError};
use std::io::{self, IsTerminal};
use terminal_size::terminal_size_of;

/// Most faults that are drawn at once.
const SHOWN_FAULTS: usize = 20;

/// Longest line of a study file that is drawn; longer ones are cut in the plain text.
const LONGEST_LINE: usize = 120;

/// The whole report.
pub(crate) fn report(failure: &Failure) -> String {
    let help = match failure {
        Failure::Question(Error::Study(error)) => return study_report(error),
        Failure::Question(error) => help_of(error),
        Failure::Exists { .. } => Some("give another name, or remove the file".to_owned()),
        Failure::Interrupted { help, .. } => Some(help.clone()),
        _ => None,
    };
    let help = help.map_or_else(String::new, |help| format!("\n  help: {help}"));
    printable(&format!("error: {failure}{help}")).into_owned()
}

/// Remedy for a question without an answer.
fn help_of(error: &Error) -> Option<String> {
    let help = match error {
        Error::RunDirectory(RunDirectoryError::Exists { unfinished: true, path, .. }) => {
            let resume = resume_command(path);
            return Some(format!(
                "`{resume}` finishes it; or give another directory, or remove this one"
            ));
        }
        Error::RunDirectory(RunDirectoryError::NotWhole(path, _)) => {
            let resume = resume_command(path);
            return Some(format!("if it was ended by force, `{resume}` finishes it"));
        }
        Error::RunDirectory(RunDirectoryError::Exists { .. }) => {
            "give another directory with --out, or remove this one"
        }
        Error::RunDirectory(RunDirectoryError::Changed(_)) => {
            "`ocmc verify` says of every file whether it is whole; a copy of it can take its \
             place, or the same command into another directory: it gives the same bytes"
        }
        Error::RunDirectory(RunDirectoryError::NotOneRun { .. }) => {
            "parts have the same study, seed and program, and each begins where another one ends"
        }
        Error::RunDirectory(RunDirectoryError::NotADirectory { .. }) => {
            "give a directory with --out; it is created where it does not exist"
        }
        Error::RunDirectory(RunDirectoryError::NotFinished { help, .. }) => help,
        Error::Table(error) | Error::GivenDrive(GivenDriveError::File(error)) => error.help()?,
        Error::Unwritten(_) => {
            "what was finished is kept: --out with this directory and --resume goes on"
        }
        Error::Sensitivity(SensitivityError::TooFewRows { .. }) => {
            "more --cycles, or another --column; `ocmc` with this study says why cycles fail"
        }
        Error::Sensitivity(SensitivityError::TooFewCrossed { .. }) => {
            "more cycles with --crossed, or another --column; `ocmc` with this study says why \
             cycles fail"
        }
        Error::Sensitivity(SensitivityError::NotIndependent) => {
            "add --set simulation.sampling=independent, or leave --crossed out"
        }
        Error::Interrupted(progress) if progress.what == "trips" => {
            "there is no answer without the rest; fewer --trips take less time"
        }
        Error::Interrupted(_) => {
            "there is no answer without the rest; fewer --cycles take less time"
        }
        _ => return None,
    };
    Some(help.to_owned())
}

/// Report of the faults in a study, drawn around the lines where it is written. Without a terminal,
/// the same as plain text.
fn study_report(error: &StudyFileError) -> String {
    let stderr = io::stderr();
    let width = width(terminal_size_of(&stderr));
    let drawn = || error.faults.iter().take(SHOWN_FAULTS).map(|fault| draw(fault, width)).collect();
    let drawn: Option<Vec<String>> = stderr.is_terminal().then(drawn).flatten();
    let Some(mut drawn) = drawn else { return format!("error: {error}") };
    if error.faults.len() > SHOWN_FAULTS {
        drawn.push(format!("and {} more", error.faults.len() - SHOWN_FAULTS));
    }
    drawn.join("\n")
}

/// One fault; none where it cannot be drawn.
fn draw(fault: &Fault, width: usize) -> Option<String> {
    let lines: Vec<&str> = fault.help.iter().chain(&fault.note).map(String::as_str).collect();
    let help = (!lines.is_empty()).then(|| printable(&lines.join("\n")).into_owned());
    let message = MietteDiagnostic { help, ..MietteDiagnostic::new(fault.message()) };
    let report = match &fault.place {
        Some(place) => {
            let text = &place.source.text;
            let line = text.lines().nth(place.line() - 1).unwrap_or_default();
            if line.chars().count() > LONGEST_LINE || line.chars().any(is_hidden) {
                return None;
            }
            let message = message.with_label(LabeledSpan::underline(place.span.clone()));
            let source = NamedSource::new(place.source.label(), text.clone());
            Report::new(message).with_source_code(source)
        }
        None => message.into(),
    };
    let colours = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let theme = if colours { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
    let mut text = String::new();
    let handler = GraphicalReportHandler::new_themed(theme).with_width(width);
    handler.render_report(&mut text, report.as_ref()).ok()?;
    Some(text)
}
