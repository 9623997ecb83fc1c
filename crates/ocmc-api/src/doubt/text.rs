//! The answer about judged numbers as text: a table of the largest effects, and the commands whose
//! data would replace the numbers.

use super::{DoubtAnswer, DoubtedNumbers, root};
use crate::text::{as_many, fact, row, took};
use ocmc_fleet::doubt::Changes;
use ocmc_io::label::label;
use ocmc_io::number_text::{count_of, decimals, grouped};
use ocmc_io::study::ReplacedNumber;
use std::fmt::Write;

/// Entries that the table shows.
const SHOWN: usize = 15;
/// Widths of the name, of the changes of mean, standard deviation and percentile at both ends, and
/// of the share.
const WIDTHS: [usize; 8] = [25, 8, 8, 8, 8, 8, 8, 6];
/// Width of the whole text.
const WIDTH: usize = 80;

pub(super) fn doubt_text(answer: &DoubtAnswer) -> String {
    let DoubtAnswer { numbers, together: all, .. } = answer;
    let (unit, factor) = label(answer.column);
    let mut text = heading(answer);
    let digits = answer.is.map_or(2, |is| match answer.against {
        None => decimals(factor * is.mean),
        Some(_) => decimals(factor * all.mean.max(is.mean.abs() / 10.0)),
    });
    let signed = |value: f64| format!("{:+.digits$}", factor * value);
    let plain = |value: f64| format!("{:.digits$}", factor * value);
    let what = if answer.against.is_some() { ", B less A" } else { "" };
    if let Some(is) = answer.is {
        let print =
            if answer.against.is_some() { &signed as &dyn Fn(f64) -> String } else { &plain };
        let [mean, sd, p95] = [is.mean, is.sd, is.p95].map(print);
        let _ = writeln!(text, "\n{unit}{what}: mean {mean}, SD {sd}, P95 {p95}.");
    }
    // what is within chance is no zero
    let known = |value: f64| if value > 0.0 { plain(value) } else { "unknown".to_owned() };
    let [mean, sd, p95] = [all.mean, all.sd, all.p95].map(known);
    let _ = writeln!(
        text,
        "From judged numbers: mean ± {mean}, SD ± {sd}, P95 ± {p95}.\n\
         Roots of the sums of squares of {}. No confidence interval.\n",
        count_of(numbers.len() as u64, "effect")
    );
    text.push_str(&row("", &WIDTHS, &["", "mean", "", "SD", "", "P95", "", ""]));
    let head = ["", "low", "high", "low", "high", "low", "high", "share"];
    text.push_str(&row("", &WIDTHS, &head));
    for entry in numbers.iter().take(SHOWN) {
        let cell = |changes: Option<Changes>, value_of: fn(&Changes) -> f64| {
            changes.map_or("-".to_owned(), |changes| signed(value_of(&changes)))
        };
        let (low, high) = (entry.low, entry.high);
        let cells = [
            entry.name.replace('_', " "),
            cell(low, |c| c.mean.by),
            cell(high, |c| c.mean.by),
            cell(low, |c| c.sd.by),
            cell(high, |c| c.sd.by),
            cell(low, |c| c.p95.by),
            cell(high, |c| c.p95.by),
            percent(entry.share),
        ];
        text.push_str(&row("", &WIDTHS, &cells));
    }
    if let Some(others) = numbers.get(SHOWN..).filter(|others| !others.is_empty()) {
        let name = format!("{} others", others.len());
        let all = plain(root(others.iter().map(|entry| entry.squares)).mean);
        let share: f64 = others.iter().map(|entry| entry.share).sum();
        let _ = writeln!(text, "{name:25}   together ± {all}, {}", percent(share));
    }
    text + &own_data(numbers) + &replaced(&answer.replaced) + &refused(numbers)
}

fn heading(answer: &DoubtAnswer) -> String {
    let DoubtAnswer { numbers, cycles, screened_cycles, .. } = answer;
    let names = match &answer.against {
        None => fact("study", &answer.study),
        Some([b, _]) => fact("A", &answer.study) + &fact("B", b),
    };
    let sides = format!(
        "{} on each side of the twelve that matter most, {} of all {}",
        grouped(*cycles),
        grouped(*screened_cycles),
        numbers.len()
    );
    [
        names,
        fact("seed", answer.seed),
        fact("cycles", sides),
        took(answer.wall_s, answer.threads, answer.driven),
    ]
    .concat()
}

/// The commands, that whose numbers matter most first, with the entries that its data replace.
fn own_data(numbers: &[DoubtedNumbers]) -> String {
    let mut commands: Vec<(&str, Vec<&DoubtedNumbers>)> = Vec::new();
    for entry in numbers {
        let command = entry.replaced_by.unwrap_or(TYPED);
        match commands.iter_mut().find(|(known, _)| *known == command) {
            Some((_, entries)) => entries.push(entry),
            None => commands.push((command, vec![entry])),
        }
    }
    let share = |entries: &[&DoubtedNumbers]| entries.iter().map(|entry| entry.share).sum::<f64>();
    commands.sort_by(|a, b| share(&b.1).total_cmp(&share(&a.1)));
    let mut text = "\nYour own data instead of them, with the shares that would go:\n".to_owned();
    for (command, entries) in commands {
        let names: Vec<String> = entries.iter().map(|entry| entry.name.replace('_', " ")).collect();
        let start = format!("  {:>5}  {command}: ", percent(share(&entries)));
        let room = WIDTH - start.chars().count();
        let _ = writeln!(text, "{start}{}", as_many(&names, room));
    }
    text
}

/// A share; what chance makes smaller than nothing is nothing.
fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share.max(0.0))
}

const TYPED: &str = "--set, or your study file";

/// Numbers that are judged no longer, and where they are from.
fn replaced(numbers: &[ReplacedNumber]) -> String {
    let mut sources: Vec<(&str, u64)> = Vec::new();
    for number in numbers {
        match sources.iter_mut().find(|(known, _)| *known == number.standing) {
            Some((_, count)) => *count += 1,
            None => sources.push((&number.standing, 1)),
        }
    }
    let lines = sources.iter().map(|(standing, count)| {
        format!("{} that {} judged: {standing}\n", count_of(*count, "number"), was(*count))
    });
    let lines: String = lines.collect();
    if lines.is_empty() { lines } else { format!("\n{lines}") }
}

fn was(count: u64) -> &'static str {
    if count == 1 { "was" } else { "were" }
}

/// Entries that the study cannot be moved to the ends of.
fn refused(numbers: &[DoubtedNumbers]) -> String {
    let refused = numbers.iter().filter_map(|entry| Some((entry, entry.refused.as_ref()?)));
    let lines = refused.map(|(entry, why)| {
        let why = why.lines().next().unwrap_or_default();
        format!("\nNot moved to an end: {}: {why}\n", entry.name.replace('_', " "))
    });
    lines.collect()
}
