//! Parts that answers as text have in common.

use ocmc_fleet::run::RunPlan;
use ocmc_fleet::uncertainty::{ParameterEffect, ParameterUncertainty};
use ocmc_io::number_text::{rough, short};
use ocmc_io::table::spreadsheet;

/// A line about a fact: its name, and what it is.
pub(crate) fn fact(name: &str, value: impl std::fmt::Display) -> String {
    format!("{name:<10} {value}\n")
}

/// Time that an answer has taken.
pub(crate) fn took(wall_s: f64, threads: usize, cycles: u64) -> String {
    let rate = rough(cycles as f64 / wall_s);
    fact("took", format!("{} s on {}: {rate} cycles/s", short(wall_s), threads_text(threads)))
}

/// So many threads.
pub(crate) fn threads_text(threads: usize) -> String {
    if threads == 1 { "1 thread".to_owned() } else { format!("{threads} threads") }
}

/// Effect on a mean of one standard error of each uncertain number, the largest first.
pub(crate) fn effects(uncertainty: &ParameterUncertainty, factor: f64) -> Vec<String> {
    let mut parameters: Vec<_> = uncertainty.parameters.iter().collect();
    let size = |parameter: &ParameterEffect| parameter.effect.map_or(f64::INFINITY, f64::abs);
    parameters.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let sd = (factor * uncertainty.sd).abs();
    let digits = decimals_for(sd);
    let line = |parameter: &&ParameterEffect| {
        let number = format!("{} ± {}", parameter.key, rough(parameter.standard_error));
        match parameter.effect {
            Some(effect) => format!("{:+.digits$}  {number}", factor * effect),
            None => format!("not known, no cycle is completed on both sides  {number}"),
        }
    };
    parameters.iter().map(line).collect()
}

/// A row of a table: the first cell on the left of its column, the others on the right.
pub(crate) fn row(between: &str, widths: &[usize], cells: &[impl AsRef<str>]) -> String {
    let cells = cells.iter().map(AsRef::as_ref).zip(widths).enumerate();
    let cells = cells.map(|(column, (cell, &width))| match column {
        0 => format!("{cell:width$}"),
        _ => format!("{cell:>width$}"),
    });
    format!("{}\n", cells.collect::<Vec<_>>().join(between).trim_end())
}

/// A table whose columns are that wide.
pub(crate) fn table<Row: AsRef<[String]>>(
    widths: &[usize],
    head: &[&str],
    rows: impl IntoIterator<Item = Row>,
) -> String {
    let rows = rows.into_iter().map(|cells| row("", widths, cells.as_ref()));
    std::iter::once(row("", widths, head)).chain(rows).collect()
}

/// The first of the names, as many as there is room for.
pub(crate) fn as_many(names: &[String], room: usize) -> String {
    let mut text = String::new();
    for (k, name) in names.iter().enumerate() {
        let comma = if k == 0 { "" } else { ", " };
        let last = k + 1 == names.len();
        let more = if last { 0 } else { ", ...".len() };
        if text.chars().count() + comma.len() + name.chars().count() + more > room {
            return text + ", ...";
        }
        text = text + comma + name;
    }
    text
}

/// The same names at the end of a sentence.
pub(crate) fn all_of(names: &[String], room: usize) -> String {
    let text = as_many(names, room);
    if text.ends_with("...") { text } else { text + "." }
}

/// The options of a range of cycles.
pub(crate) fn range(plan: &RunPlan) -> String {
    let first = match plan.first_cycle {
        0 => String::new(),
        first => format!(" --first-cycle {first}"),
    };
    format!(" --seed {}{first} --cycles {}", plan.seed, plan.cycles)
}

/// A number, or an empty cell.
pub(crate) fn cell(number: Option<f64>) -> String {
    number.filter(|number| number.is_finite()).map_or(String::new(), |number| format!("{number:?}"))
}

/// A word as a cell of CSV.
pub(crate) fn quoted(word: &str) -> String {
    let word = spreadsheet::written(word);
    if word.contains([',', '"', '\n', '\r', ';']) {
        format!("\"{}\"", word.replace('"', "\"\""))
    } else {
        word.into_owned()
    }
}

/// Decimals that show half the width of an interval with two digits.
pub(crate) fn decimals_for(half_width: f64) -> usize {
    let is_known = half_width > 0.0 && half_width.is_finite();
    if is_known { (1.0 - half_width.log10().floor()).clamp(0.0, 6.0) as usize } else { 3 }
}

/// Letters of a line that is folded.
const WIDTH: usize = 80;

/// Text in lines of at most 80 letters, each but the first behind an indent. A word that is longer
/// stays whole.
pub(crate) fn folded(text: &str, indent: &str) -> String {
    let (mut lines, mut line) = (Vec::new(), String::new());
    for word in text.split(' ') {
        let is_begun = !line.trim().is_empty();
        if is_begun && line.chars().count() + 1 + word.chars().count() > WIDTH {
            lines.push(std::mem::replace(&mut line, indent.to_owned()));
        } else if is_begun || word.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    lines.push(line);
    lines.join("\n")
}
