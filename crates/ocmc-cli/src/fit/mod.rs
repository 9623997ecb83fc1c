//! `ocmc fit`: from measurements to the numbers of a study.

mod curve_speed;
mod curve_speed_text;
mod operating_cycle;
mod speed_change;
mod traffic;
mod weather;

pub use curve_speed::curve_speed_answer;
pub use operating_cycle::operating_cycle_answer;
pub use speed_change::speed_change_answer;
pub use traffic::traffic_answer;
pub use weather::weather_answer;

use crate::answer::Answer;
use crate::arguments::{FitCommand, FittedArguments};
use crate::failure::Failure;
use crate::{output, study};
use ocmc_estimation::fit::operating_cycle::StudyParameterFit;
use ocmc_io::shell_word::shell_word;
use ocmc_io::study::{FittedPart, fitted_study};
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Most files that a study names as its sources.
const MOST_NAMED: usize = 4;

/// Fits what was asked for.
pub(crate) fn fit(command: &FitCommand) -> Result<(), Failure> {
    match command {
        FitCommand::CurveSpeed(arguments) => curve_speed::curve_speed(arguments),
        FitCommand::OperatingCycle(arguments) => operating_cycle::operating_cycle(arguments),
        FitCommand::SpeedChange(arguments) => speed_change::speed_change(arguments),
        FitCommand::Traffic(arguments) => traffic::traffic(arguments),
        FitCommand::Weather(arguments) => weather::weather(arguments),
    }
}

/// Measurements that have no fit.
fn no_fit(path: &Path, error: impl std::error::Error + 'static) -> Failure {
    Failure::Fit { path: path.to_owned(), error: Box::new(error) }
}

/// The answer of a fit: what it tells, as JSON with the study's part, and as text.
fn answer(fit: &impl Serialize, text: String, warnings: &[String], part: &FittedPart) -> Answer {
    let mut json = serde_json::to_value(fit).expect("numbers, words and lists");
    json["study"] = part.json();
    Answer { json, text, warnings: warnings.iter().cloned().chain(part.warnings()).collect() }
}

/// As [`answer`], of a fit that is a list of numbers.
fn answer_of_parameters(
    fit: &impl Serialize,
    head: &str,
    parameters: &[StudyParameterFit],
    warnings: &[String],
    part: &FittedPart,
) -> Answer {
    let (table, values) = (parameter_table("", parameters), part.text());
    let text = format!("{head}\n{table}\nTo paste into a study:\n\n{values}");
    answer(fit, text, warnings, part)
}

/// Prints the answer of a fit.
fn print(arguments: &FittedArguments, answer: &Answer) -> Result<(), Failure> {
    for warning in &answer.warnings {
        output::note(&format!("warning: {warning}"));
    }
    if arguments.json {
        return output::answer(&format!("{:#}\n", answer.json));
    }
    output::answer(&answer.text)
}

/// Writes the study with fitted values, where one was asked for.
fn write_study(
    arguments: &FittedArguments,
    command: &str,
    sources: &[PathBuf],
    answer: &Answer,
) -> Result<(), Failure> {
    let Some(path) = &arguments.study_out else {
        return Ok(());
    };
    let name = path.file_stem().map_or("fitted".into(), |stem| stem.to_string_lossy());
    let note = format!("Written by `ocmc fit {command}` from {}.", named(sources));
    let (text, _) = fitted_study(&arguments.base, &name, &note, &answer.json["study"])?;
    study::write_new(path, &text)?;
    let (shown, word) = (path.display(), shell_word(path));
    output::note(&format!("Written: `{shown}`. Run it: ocmc --study {word}"));
    Ok(())
}

/// Files by their names; of many, the first ones.
fn named(files: &[PathBuf]) -> String {
    let names = files.iter().take(MOST_NAMED).map(|file| format!("`{}`", file.display()));
    let names = names.collect::<Vec<_>>().join(", ");
    match files.len().saturating_sub(MOST_NAMED) {
        0 => names,
        more => format!("{names} and {more} more"),
    }
}

/// A table of estimated numbers with their errors, under a title.
fn parameter_table(title: &str, parameters: &[StudyParameterFit]) -> String {
    let mut text = format!("{title:38}{:>14}{:>14}{:>10}\n", "estimate", "error", "n");
    for parameter in parameters {
        let error = parameter.standard_error.map_or("-".to_owned(), short);
        let value = short(parameter.value);
        let _ = writeln!(text, "{:38}{value:>14}{error:>14}{:>10}", parameter.key, parameter.n);
    }
    text
}

/// Four digits, in powers of ten where it is small.
fn short(number: f64) -> String {
    match number.abs() {
        0.0 => "0".to_owned(),
        size if size < 1e-2 => format!("{number:.3e}"),
        size if size < 10.0 => format!("{number:.4}"),
        _ => format!("{number:.1}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_are_named() {
        let files: Vec<PathBuf> = (1..=6).map(|k| PathBuf::from(format!("{k}.csv"))).collect();
        assert_eq!(named(&files[..1]), "`1.csv`");
        assert_eq!(named(&files[..4]), "`1.csv`, `2.csv`, `3.csv`, `4.csv`");
        assert_eq!(named(&files), "`1.csv`, `2.csv`, `3.csv`, `4.csv` and 2 more");
    }
}
