//! The answer as text.

use super::{Doubted, LearnAnswer};
use crate::answer::Answer;
use crate::text::{all_of, folded, table};
use ocmc_io::export::ExportKind;
use ocmc_io::label::label;
use ocmc_io::number_text::{count_of, percent, short};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Files of a kind that are named.
const NAMED: usize = 4;
/// Room for names in a line.
const ROOM: usize = 66;
/// Largest share of judged numbers that is shown.
const SHOWN: usize = 8;

pub(super) fn learn_text(answer: &LearnAnswer) -> String {
    let mut text = files(answer);
    text.push_str("\nFitted\n");
    for part in &answer.parts {
        let how = match &part.refused {
            None => part.sources.clone(),
            Some(reason) => format!("not from {}: {reason}", part.sources),
        };
        let line = format!("  {:20} {how}", part.what);
        let _ = writeln!(text, "{}", folded(&line, &" ".repeat(23)));
    }
    if answer.parts.is_empty() {
        text.push_str(
            "  nothing: there are no logs, and no tables of weather, traffic or curves\n",
        );
    }
    text.push_str("\nCalibrated\n");
    match (&answer.totals, &answer.no_totals) {
        (Some(totals), _) => text.push_str(&indented(&totals.text())),
        (None, reason) => {
            let _ = writeln!(text, "  nothing: {}", reason.as_deref().unwrap_or("no totals"));
        }
    }
    text.push_str(&held_back(answer));
    let _ = writeln!(text, "\nStays as it was judged: {}", all_of(&words(&answer.judged), ROOM));
    text.push_str("\nWhat the mean owes to judged numbers, each at both ends of its range\n");
    for doubted in &answer.doubt {
        let _ = writeln!(text, "  {}", line(doubted));
    }
    let _ = writeln!(text, "\n{} s", short(answer.wall_s));
    text
}

fn files(answer: &LearnAnswer) -> String {
    let mut by_kind: BTreeMap<Option<ExportKind>, Vec<String>> = BTreeMap::new();
    let mut left_out = Vec::new();
    for file in &answer.files {
        let path = file.path.display().to_string();
        match (&file.left_out, file.kind) {
            (Some(reason), _) => left_out.push(folded(&format!("  {path}: {reason}"), "    ")),
            (None, kind) => by_kind.entry(kind).or_default().push(path),
        }
    }
    let mut text = format!("{}\n", count_of(answer.files.len() as u64, "file"));
    let rows = by_kind.iter().filter_map(|(kind, paths)| {
        let more = paths.len().saturating_sub(NAMED);
        let mut named = paths[..paths.len().min(NAMED)].join(", ");
        if more > 0 {
            let _ = write!(named, " and {more} more");
        }
        Some([format!("  {}", kind.as_ref()?.words()), format!("{:>4}  {named}", paths.len())])
    });
    for [kind, paths] in rows {
        let _ = writeln!(text, "{}", folded(&format!("{kind:20} {paths}"), &" ".repeat(27)));
    }
    if !left_out.is_empty() {
        let _ = writeln!(text, "Not used\n{}", left_out.join("\n"));
    }
    text
}

fn held_back(answer: &LearnAnswer) -> String {
    let Some(held) = &answer.held_back else {
        return "\nNo trip was held back: nothing says how well the study foretells one.\n"
            .to_owned();
    };
    let (unit, factor) = label(&held.column);
    let mut text = format!(
        "\n{} held back, of a study learnt from the other {}\n",
        count_of(held.trips.len() as u64, "trip"),
        held.learnt_from
    );
    let number = |value: f64| format!("{:.2}", factor * value);
    let rows = [[
        "  all of them".to_owned(),
        number(held.measured),
        number(held.expected),
        format!("{:+.1} %", 100.0 * (held.expected / held.measured - 1.0)),
    ]];
    text.push_str(&table(
        &[24, 12, 12, 10],
        &[&format!("  {unit}"), "measured", "expected", ""],
        rows,
    ));
    let share = held.within as f64 / held.trips.len() as f64;
    let _ = writeln!(
        text,
        "  {} of {} lie within the interval that should hold 90 % of such trips ({} %).",
        held.within,
        held.trips.len(),
        percent(share)
    );
    text.push_str("  The written study is learnt from all trips.\n");
    text
}

fn line(doubted: &Doubted) -> String {
    let (unit, factor) = label(&doubted.column);
    let shares: Vec<String> = (doubted.largest.iter().take(SHOWN))
        .map(|(name, share)| format!("{} {} %", name.replace('_', " "), percent(*share)))
        .collect();
    format!(
        "{:20} {:.1} ± {:.1} {unit}: {}",
        doubted.study,
        factor * doubted.mean,
        factor * doubted.together,
        shares.join(", ")
    )
}

fn indented(text: &str) -> String {
    text.lines().fold(String::new(), |all, line| {
        if line.is_empty() { all + "\n" } else { all + "  " + line + "\n" }
    })
}

fn words(names: &[String]) -> Vec<String> {
    names.iter().map(|name| name.replace('_', " ")).collect()
}
