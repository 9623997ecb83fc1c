//! The answer as text.

use super::{BenchmarkAnswer, BenchmarkLevel, BenchmarkMember, Compared};
use crate::text::{fact, folded, table};
use ocmc_io::label::label;
use ocmc_io::number_text::{count_of, grouped, rounded, short};
use std::fmt::Write;

/// Members at each end of a ranking that are shown.
const SHOWN: usize = 10;
/// Far rows that are named.
const NAMED: usize = 3;

/// A logarithm, or its SD, in %.
fn percent(ln: f64) -> String {
    format!("{:.2}", 100.0 * ln)
}

fn interval([low, high]: [f64; 2]) -> String {
    format!("({low:.3} ; {high:.3})")
}

pub(super) fn of_level(level: &str) -> [&'static str; 2] {
    match level {
        "truck" => ["truck", "trucks"],
        "driver" => ["driver", "drivers"],
        _ => ["truck and driver", "trucks with their drivers"],
    }
}

pub(super) fn benchmark_text(answer: &BenchmarkAnswer) -> String {
    let (unit, factor) = label(&answer.column);
    let what = if answer.of_fills { "full tank" } else { "trip" };
    let mut text = count_of(answer.rows as u64, what);
    for (count, name) in [(answer.trucks, "truck"), (answer.drivers, "driver")] {
        if let Some(count) = count {
            let _ = write!(text, " of {}", count_of(count as u64, name));
        }
    }
    let (left_out, doubled, far) = (answer.left_out, answer.doubled, answer.far.len());
    let _ = writeln!(text, "; {left_out} left out, {doubled} doubled, {far} far off");
    if !answer.far.is_empty() {
        let named: Vec<String> = (answer.far.iter().take(NAMED))
            .map(|far| format!("{} ({:.2})", far.place, far.ratio))
            .collect();
        let more = if answer.far.len() > NAMED { ", ..." } else { "" };
        text.push_str(&fact("far off", format!("{}{more}", named.join(", "))));
    }
    let mean = |mean: f64| rounded(factor * mean);
    let (measured, expected) = (mean(answer.measured), mean(answer.expected));
    text.push_str(&fact("measured", format!("{measured} {unit}, geometric mean")));
    text.push_str(&fact("expected", format!("{expected} {unit}, by {}", answer.study)));
    let ci95 = answer.ratio_ci95.map_or(String::new(), |ci95| format!("  {}", interval(ci95)));
    text.push_str(&fact("ratio", format!("{:.3}{ci95}", answer.ratio)));
    let (driven, wall) = (grouped(answer.driven), short(answer.wall_s));
    text.push_str(&fact("driven", format!("{driven} cycles in {wall} s")));
    if answer.measured_sd_between.is_some() {
        text.push_str(&spread(answer));
    }
    for level in &answer.levels {
        text.push_str(&ranking(level));
    }
    if !answer.compared.is_empty() {
        text.push_str("\nChange, %, all else equal\n");
        let rows = answer.compared.iter().map(compared);
        let head = ["", "against", "change", "95 %", "trips", "trucks"];
        text.push_str(&table(&[21, 16, 8, 17, 11, 7], &head, rows));
        for compared in &answer.compared {
            let _ = writeln!(text, "{}", folded(&how(compared, compared_members(answer)), ""));
        }
    }
    for remark in &answer.remarks {
        let _ = writeln!(text, "\n{}", folded(&format!("Note: {remark}."), ""));
    }
    text
}

/// Members whose trips are compared: drivers where no trucks are named, and trips where nobody is.
fn compared_members(answer: &BenchmarkAnswer) -> &'static str {
    match (answer.trucks, answer.drivers) {
        (Some(_), _) => "trucks",
        (None, Some(_)) => "drivers",
        (None, None) => "trips",
    }
}

/// Where the differences between the means of trucks come from.
fn spread(answer: &BenchmarkAnswer) -> String {
    let mut rows = Vec::new();
    let mut row = |name: &str, sd: Option<f64>, words: &str| {
        if let Some(sd) = sd {
            rows.push([name.to_owned(), percent(sd), words.to_owned()]);
        }
    };
    row("as measured", answer.measured_sd_between, "");
    for adjusted in &answer.adjusted_for {
        let by = match (adjusted.by_study, adjusted.by_table) {
            (true, true) => "study and table",
            (true, false) => "study",
            (false, _) => "table",
        };
        row(adjusted.covariate.words(), Some(adjusted.sd_between), by);
    }
    row("not explained", answer.unexplained_sd_between, "chance included");
    for level in &answer.levels {
        let ci95 = level.sd_ci95.map_or(String::new(), |[low, high]| {
            let high = if high.is_finite() { percent(high) } else { "?".to_owned() };
            format!("({} ; {high})", percent(low))
        });
        let [name, _] = of_level(level.level);
        row(&format!("{name}, without chance"), Some(level.sd), &ci95);
    }
    row("a trip beside them", answer.trip_sd, "");
    let head = format!("\nDifferences between {}, SD in %", compared_members(answer));
    table(&[34, 8, 18], &[&head, "", ""], rows)
}

/// A ranking, or that there is none.
fn ranking(level: &BenchmarkLevel) -> String {
    let [one, many] = of_level(level.level);
    if !level.differ {
        return format!(
            "\nNo differences between the {} {many} beyond chance (P = {:.2}): no ranking.\n",
            level.count, level.p
        );
    }
    let p = if level.p < 1e-4 { "P < 0.0001".to_owned() } else { format!("P = {:.4}", level.p) };
    let mut text = format!("\nThe {} {many} differ beyond chance ({p})\n", level.count);
    let n = level.members.len();
    let shown = |place: &usize| n <= 2 * SHOWN + 1 || *place < SHOWN || *place >= n - SHOWN;
    let mut rows: Vec<[String; 6]> = Vec::new();
    for place in (0..n).filter(shown) {
        if n > 2 * SHOWN + 1 && place == n - SHOWN {
            let mut gap: [String; 6] = Default::default();
            gap[0] = format!("... {} others", n - 2 * SHOWN);
            rows.push(gap);
        }
        rows.push(member(&level.members[place]));
    }
    let head = [one, "trips", "raw", "ratio", "95 %", "P(better)"];
    text.push_str(&table(&[28, 7, 8, 8, 18, 11], &head, rows));
    text
}

fn member(member: &BenchmarkMember) -> [String; 6] {
    [
        member.name.clone(),
        member.trips.to_string(),
        format!("{:.3}", member.raw_ratio),
        format!("{:.3}", member.ratio),
        interval(member.ci95),
        format!("{:.2}", member.better_than_median),
    ]
}

fn compared(compared: &Compared) -> [String; 6] {
    let [before, after] = compared.trips;
    let change = compared.change.map_or("-".to_owned(), |by| format!("{:+.2}", 100.0 * by));
    let ci95 = compared.ci95.map_or("-".to_owned(), |[low, high]| {
        format!("({:+.2} ; {:+.2})", 100.0 * low, 100.0 * high)
    });
    [
        compared.what.clone(),
        compared.against.clone(),
        change,
        ci95,
        format!("{before} / {after}"),
        compared.trucks_of_both.to_string(),
    ]
}

/// How a difference was found.
fn how(compared: &Compared, members: &str) -> String {
    let what = &compared.what;
    if compared.change.is_none() {
        return format!(
            "`{what}` cannot be told from what else differs: {members}, weights, seasons or routes."
        );
    }
    let within = match (members, compared.is_within_trucks) {
        ("trips", _) => "between trips, each taken as independent".to_owned(),
        (_, true) => format!("within {} {members} with trips of both", compared.trucks_of_both),
        (_, false) => format!("between {members}: too few have trips of both"),
    };
    let routes = if compared.is_of_same_routes { ", on the same routes" } else { "" };
    format!("`{what}` is {within}{routes}; the interval is robust over {members}.")
}
