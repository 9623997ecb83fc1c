//! The answer of a calibration as text.

use super::CalibrateTotalsAnswer;
use crate::text::{all_of, table};
use ocmc_io::label::label;
use ocmc_io::number_text::{count_of, grouped, percent, rounded, short};
use std::fmt::Write;

/// Numbers that are shown.
const SHOWN: usize = 12;
/// Number below which digits are lost.
const SMALL: f64 = 0.01;
/// Room for names in a line.
const ROOM: usize = 60;

pub(super) fn totals_text(answer: &CalibrateTotalsAnswer) -> String {
    let CalibrateTotalsAnswer { table: rows, simulated, .. } = answer;
    let (unit, factor) = label(&answer.column);
    let number = |value: f64| format!("{:.2}", factor * value);
    let what = if answer.of_fills { "full tank" } else { "trip" };
    let mut text = count_of(answer.rows as u64, what);
    if let Some(trucks) = answer.trucks {
        let _ = write!(text, " of {}", count_of(trucks as u64, "truck"));
    }
    if let Some(drivers) = answer.drivers {
        let _ = write!(text, " by {}", count_of(drivers as u64, "driver"));
    }
    let _ = writeln!(text, "; {} left out", answer.left_out);
    let _ = writeln!(text, "known      {}", answer.known.join(", "));
    let independent = grouped(libm::round(answer.effective_rows) as u64);
    let _ = writeln!(text, "count      as {independent} independent rows");
    let (driven, wall) = (grouped(answer.driven), short(answer.wall_s));
    let _ = writeln!(text, "driven     {driven} cycles in {wall} s\n");
    let widths = [34, 10, 10, 10];
    let cells = |name: &str, [a, b, c]: [String; 3]| [name.to_owned(), a, b, c];
    let shown = [
        cells("the table", [rows.mean, rows.p5, rows.p95].map(number)),
        cells("calibrated study", [simulated.mean, simulated.p5, simulated.p95].map(number)),
        cells(
            "study with the table's loads",
            [number(answer.before), String::new(), String::new()],
        ),
    ];
    text.push_str(&table(&widths, &[unit, "mean", "P5", "P95"], shown));
    if answer.of_fills {
        text.push_str("P5 and P95 of the table are of ways between fills, not of trips.\n");
    }
    match answer.factor {
        Some(times) => {
            let _ =
                writeln!(text, "One factor on the fuel map, {times:.4}, makes the means the same.");
        }
        None => text.push_str("This powertrain has no factor on consumption: the means differ.\n"),
    }
    text.push_str("\nChange of the mean, %\n");
    let interval = |[low, high]: [f64; 2]| format!("({:+.1} ; {:+.1})", 100.0 * low, 100.0 * high);
    let questions = answer.questions.iter().map(|asked| {
        let change = format!("{:+.2}", 100.0 * asked.change);
        [
            asked.question.words().to_owned(),
            change,
            interval(asked.ci90),
            interval(asked.judged_ci90),
        ]
    });
    let head = ["", "change", "90 %", "without the table"];
    text.push_str(&table(&[28, 10, 18, 20], &head, questions));
    text.push_str("\nJudged numbers that it moved; at a score of 1 the plausible range ends\n");
    let moved: Vec<_> = answer.numbers.iter().filter(|numbers| numbers.is_moved).collect();
    let numbers = moved.iter().take(SHOWN).map(|numbers| {
        [
            numbers.name.replace('_', " "),
            size(numbers.before),
            size(numbers.after),
            format!("{:+.2}", numbers.score),
            format!("{:.2}", numbers.score_sd),
        ]
    });
    text.push_str(&table(&[26, 12, 12, 9, 8], &["", "judged", "now", "score", "SD"], numbers));
    text.push_str(
        "None of these is measured: many others together give the same table, and a\n\
         single number is hardly known better than before. Use them together.\n",
    );
    let still: Vec<String> = (answer.numbers.iter().filter(|numbers| !numbers.is_moved))
        .map(|numbers| numbers.name.replace('_', " "))
        .collect();
    if !still.is_empty() {
        let _ = writeln!(text, "It says nothing of {}", all_of(&still, ROOM));
    }
    for further in &answer.further {
        let _ = writeln!(
            text,
            "A column {} would narrow `{}` to {} %.",
            further.column,
            further.question.words(),
            percent(further.sd_ratio)
        );
    }
    text
}

/// A number of a study, whatever its size.
fn size(number: f64) -> String {
    if number.abs() < SMALL { format!("{number:.2e}") } else { rounded(number) }
}
