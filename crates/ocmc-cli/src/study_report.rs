//! What is wrong with a study, drawn around the lines where it is written. Without a terminal, the
//! same as plain text.

use crate::output::width;
use miette::{
    GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report,
};
use ocmc_api::study::{Fault, StudyFileError};
use std::io::{self, IsTerminal};
use terminal_size::terminal_size_of;

/// Most faults that are drawn at once.
const SHOWN_FAULTS: usize = 20;

/// Longest line of a study file that is drawn; longer ones are cut in the plain text.
const LONGEST_LINE: usize = 120;

/// The whole report.
pub(crate) fn study_report(error: &StudyFileError) -> String {
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
    let help = (!lines.is_empty()).then(|| lines.join("\n"));
    let message = MietteDiagnostic { help, ..MietteDiagnostic::new(fault.cause.to_string()) };
    let report = match &fault.place {
        Some(place) => {
            let text = &place.source.text;
            let line = text.lines().nth(place.line() - 1).unwrap_or_default();
            if line.chars().count() > LONGEST_LINE || line.chars().any(char::is_control) {
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
