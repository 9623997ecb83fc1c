//! Estimated numbers as a table.

use ocmc_estimation::fit::study_parameter::StudyParameterFit;
use std::fmt::Write;

/// The whole answer of a fit that is a list of numbers; `values` is the part of a study.
pub(crate) fn parameters_text(
    head: &str,
    parameters: &[StudyParameterFit],
    values: &str,
) -> String {
    let table = parameter_table("", parameters);
    format!("{head}\n{table}\nTo paste into a study:\n\n{values}")
}

/// A table of estimated numbers with their errors, under a title.
pub(super) fn parameter_table(title: &str, parameters: &[StudyParameterFit]) -> String {
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
