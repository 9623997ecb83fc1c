//! The shares of a variance as text: what was driven, and a bar for each factor.

use super::SensitivityAnswer;
use crate::cost::took;
use ocmc_core::fleet::random_effects::TwoWay;
use ocmc_core::fleet::sensitivity::{FactorShare, Sensitivity};
use ocmc_core::fleet::variance_share::LEAST_GROUPS;
use ocmc_io::label::label;
use ocmc_io::number_text::{grouped, percent, rounded};
use std::fmt::Write;

/// Width of the names, and of a share with its interval.
const WIDTHS: (usize, usize) = (17, 21);

/// Width of the bars.
const BAR: usize = 18;

/// The whole answer.
pub(crate) fn answer(answer: &SensitivityAnswer) -> String {
    let shares = &answer.sensitivity;
    let mut text = heading(answer, shares);
    text.push_str(&took(answer.wall_s, answer.threads, shares.cycles));
    text.push('\n');
    text.push_str(&table(shares));
    if let Some(two_way) = &answer.two_way {
        text.push_str(&two_way_text(two_way));
    }
    text
}

fn two_way_text(shares: &TwoWay) -> String {
    let [cycle, driver, both] = [shares.cycle, shares.driver, shares.both].map(percent);
    format!(
        "\nA second opinion, {} cycles by {} drivers, two-way random effects, in %:\n\
         cycle {cycle}, driver {driver}, both together {both}\n",
        grouped(shares.cycles),
        shares.drivers
    )
}

fn heading(answer: &SensitivityAnswer, shares: &Sensitivity) -> String {
    let mut text = String::new();
    let mut lines = vec![
        ("study", answer.origin.to_string()),
        ("seed", answer.seed.to_string()),
        ("rows", format!("{}{}", grouped(shares.rows), dropped(shares))),
        ("cycles", grouped(shares.cycles)),
    ];
    if let Some(replicates) = shares.replicates {
        let draws = grouped(replicates);
        lines.push((
            "replicates",
            format!("{draws}, each with its draw of the uncertain parameters"),
        ));
    }
    for (name, value) in lines {
        let _ = writeln!(text, "{name:<10} {value}");
    }
    text
}

/// How many rows were dropped, and why.
fn dropped(shares: &Sensitivity) -> String {
    match (shares.failed_rows, shares.rows_without_value) {
        (0, 0) => String::new(),
        (failed, 0) => format!(", {} dropped because a cycle was not completed", grouped(failed)),
        (0, without) => format!(", {} dropped because a cycle had no value", grouped(without)),
        (failed, without) => format!(
            ", {} dropped because a cycle was not completed,\n{:<10} {} because one had no value",
            grouped(failed),
            "",
            grouped(without)
        ),
    }
}

fn table(shares: &Sensitivity) -> String {
    let (name_width, width) = WIDTHS;
    let (label, factor) = label(shares.column);
    let known = shares.factors.iter().any(|share| share.total_ci95.is_some());
    let intervals = if known {
        "with 95 % intervals".to_owned()
    } else {
        format!("no intervals below {LEAST_GROUPS} independent groups of rows")
    };
    let mut text = format!(
        "{label}: mean of the cycles {}, SD {}.\nShares of the variance in %, {intervals}:\n\n",
        rounded(factor * shares.mean),
        rounded(factor * shares.variance.sqrt())
    );
    let head = format!("{:name_width$}{:>width$}{:>width$}", "", "alone", "with joint effects");
    let _ = writeln!(text, "{head}");
    for share in &shares.factors {
        let _ = writeln!(text, "{}", row(share).trim_end());
    }
    text
}

fn row(share: &FactorShare) -> String {
    let (name_width, width) = WIDTHS;
    // a part stands below its factor
    let name = match share.factor.split_once('.') {
        Some((_, part)) => format!("  {part}"),
        None => share.factor.to_owned(),
    };
    let cell = |share: f64, ci95: Option<[f64; 2]>| match ci95 {
        Some([low, high]) => {
            format!("{} ({} to {})", percent(share), percent(low), percent(high))
        }
        None => percent(share),
    };
    let first = cell(share.first, share.first_ci95);
    let total = cell(share.total, share.total_ci95);
    let bar = "█".repeat((BAR as f64 * share.total.clamp(0.0, 1.0)).round() as usize);
    // a space of its own, whatever the width of the second
    let rest = width - 1;
    format!("{name:name_width$}{first:>width$} {total:>rest$}  {bar}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_intervals_do_not_run_together() {
        let share = FactorShare {
            factor: "road",
            first: 1.083,
            first_ci95: Some([0.771, 1.365]),
            total: 1.061,
            total_ci95: Some([0.838, 1.29]),
        };
        let message = row(&share);
        assert!(message.contains("108.3 (77.1 to 136.5) 106.1 (83.8 to 129.0)  █"), "{message}");
        assert!(message.chars().count() <= 80, "{message}");
        let unsure = row(&FactorShare { first_ci95: None, total_ci95: None, ..share });
        assert!(unsure.contains(" 108.3 ") && !unsure.contains('('), "{unsure}");
    }
}
