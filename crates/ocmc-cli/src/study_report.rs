//! What is wrong with a study, drawn around the lines where it is written. Without a terminal, the
//! same as plain text.

use crate::terminal::error_terminal_width;
use miette::{
    Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, NamedSource, SourceCode,
};
use ocmc_api::study::{Fault, StudyFileError};
use std::fmt::{self, Display};

/// Most faults that are drawn at once.
const SHOWN_FAULTS: usize = 20;

/// Longest line of a study file that is drawn; longer ones are cut in the plain text.
const LONGEST_LINE: usize = 120;

/// The whole report.
pub(crate) fn study_report(error: &StudyFileError) -> String {
    let Some(width) = error_terminal_width() else {
        return format!("error: {error}");
    };
    let drawn: Option<Vec<String>> =
        error.faults.iter().take(SHOWN_FAULTS).map(|fault| draw(fault, width)).collect();
    let Some(mut drawn) = drawn else {
        return format!("error: {error}");
    };
    if error.faults.len() > SHOWN_FAULTS {
        drawn.push(format!("and {} more", error.faults.len() - SHOWN_FAULTS));
    }
    drawn.join("\n")
}

/// One fault; none where it cannot be drawn.
fn draw(fault: &Fault, width: usize) -> Option<String> {
    let drawing = Drawing::new(fault)?;
    let colours = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let theme = if colours { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
    let mut text = String::new();
    let handler = GraphicalReportHandler::new_themed(theme).with_width(width);
    handler.render_report(&mut text, &drawing).ok()?;
    Some(text)
}

/// A fault as miette wants it.
#[derive(Debug)]
struct Drawing<'a> {
    fault: &'a Fault,
    source: Option<NamedSource<String>>,
}

impl<'a> Drawing<'a> {
    fn new(fault: &'a Fault) -> Option<Self> {
        let source = match &fault.place {
            Some(place) => {
                let text = &place.source.text;
                let line = text.lines().nth(place.line() - 1).unwrap_or_default();
                if line.chars().count() > LONGEST_LINE || line.chars().any(char::is_control) {
                    return None;
                }
                Some(NamedSource::new(place.source.label(), text.clone()))
            }
            None => None,
        };
        Some(Self { fault, source })
    }
}

impl Display for Drawing<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}", self.fault.cause)
    }
}

impl std::error::Error for Drawing<'_> {}

impl Diagnostic for Drawing<'_> {
    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|source| source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let span = self.fault.place.as_ref()?.span.clone();
        Some(Box::new(std::iter::once(LabeledSpan::underline(span))))
    }

    fn help(&self) -> Option<Box<dyn Display + '_>> {
        let lines: Vec<&str> =
            self.fault.help.iter().chain(&self.fault.note).map(String::as_str).collect();
        (!lines.is_empty()).then(|| Box::new(lines.join("\n")) as Box<dyn Display>)
    }
}
