//! `ocmc sensitivity`: which factors the spread between cycles comes from.

use crate::analysis::Analysis;
use crate::answer::Answer;
use crate::arguments::SensitivityArguments;
use crate::failure::Failure;
use crate::number_text::{grouped, percent, rounded};
use crate::{output, request};
use ocmc_core::fleet::random_effects::{TwoWay, two_way};
use ocmc_core::fleet::run::RunPlan;
use ocmc_core::fleet::sensitivity::{
    self, FactorGroup, FactorShare, Sensitivity, SensitivityError, factor_groups,
};
use ocmc_core::fleet::variance_share::LEAST_GROUPS;
use ocmc_core::random::sampling::Sampling;
use ocmc_io::label::label;
use ocmc_io::study::{self, LoadedStudy, study_hash};
use serde::Serialize;
use std::fmt::Write;

/// Width of the names, and of a share with its interval.
const WIDTHS: (usize, usize) = (17, 21);

/// Drivers of the second opinion.
const DRIVERS: u64 = 30;

/// Width of the bars.
const BAR: usize = 18;

/// The answer, as `--json` prints it.
#[derive(Serialize)]
struct Content<'a> {
    study: &'a str,
    study_hash: String,
    seed: u64,
    first_cycle: u64,
    #[serde(flatten)]
    sensitivity: &'a Sensitivity,
    #[serde(skip_serializing_if = "Option::is_none")]
    two_way: Option<&'a TwoWay>,
    wall_s: f64,
    threads: usize,
}

/// Drives the design and prints the shares.
pub(crate) fn sensitivity(arguments: &SensitivityArguments) -> Result<(), Failure> {
    let loaded = study::load(&arguments.study, &arguments.set)?;
    let groups = groups(&arguments.factor);
    let (plan, quantity) = request::analysis(&arguments.analysis)?;
    if let Some(cycles) = arguments.crossed {
        check_crossed(&loaded, plan.first_cycle, cycles)?;
    }
    let cycles = plan.cycles * (2 + groups.len() as u64);
    let analysis = Analysis::begin(cycles, &arguments.analysis);
    let shares = sensitivity::sensitivity(&loaded.study, &plan, &groups, quantity, |cycles| {
        analysis.reach(cycles)
    });
    let (shares, wall_s) = analysis.end(shares)?;
    let shares = shares?;
    let two_way = match arguments.crossed {
        Some(cycles) => Some(crossed(arguments, &loaded, cycles)?),
        None => None,
    };
    let answer = sensitivity_answer(&loaded, &plan, &shares, two_way.as_ref(), wall_s);
    if arguments.analysis.json {
        return output::answer_json(&answer.json);
    }
    output::answer(&answer.text)
}

/// What the shares of the factors tell.
pub fn sensitivity_answer(
    loaded: &LoadedStudy,
    plan: &RunPlan,
    shares: &Sensitivity,
    two_way: Option<&TwoWay>,
    wall_s: f64,
) -> Answer {
    let content = Content {
        study: &loaded.model.study.name,
        study_hash: study_hash(&loaded.model),
        seed: plan.seed,
        first_cycle: plan.first_cycle,
        sensitivity: shares,
        two_way,
        wall_s,
        threads: plan.threads,
    };
    let mut text = heading(loaded, plan.seed, shares);
    text.push_str(&Analysis::took(wall_s, plan.threads, shares.cycles));
    text.push('\n');
    text.push_str(&table(shares));
    if let Some(two_way) = two_way {
        text.push_str(&two_way_text(two_way));
    }
    let json = serde_json::to_value(&content).expect("numbers and words");
    Answer { json, text, warnings: Vec::new() }
}

/// What the second opinion would be refused for, before the first one is driven.
fn check_crossed(loaded: &LoadedStudy, first_cycle: u64, cycles: u64) -> Result<(), Failure> {
    request::check_range(first_cycle, cycles).map_err(|_| {
        request::usage("--first-cycle with --crossed goes beyond the largest cycle id")
    })?;
    if loaded.model.simulation.sampling != Sampling::Independent {
        return Err(SensitivityError::NotIndependent.into());
    }
    Ok(())
}

/// Every cycle with every driver.
fn crossed(
    arguments: &SensitivityArguments,
    loaded: &LoadedStudy,
    cycles: u64,
) -> Result<TwoWay, Failure> {
    let (plan, quantity) = request::analysis(&arguments.analysis)?;
    let plan = RunPlan { cycles, ..plan };
    let analysis = Analysis::begin(cycles * DRIVERS, &arguments.analysis);
    let shares = two_way(&loaded.study, &plan, DRIVERS, quantity, |done| analysis.reach(done));
    Ok(analysis.end(shares)?.0?)
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

/// The groups that were asked for, all where none was.
fn groups(names: &[String]) -> Vec<FactorGroup> {
    let mut groups = factor_groups();
    groups.retain(|group| names.is_empty() || names.iter().any(|name| name == group.name));
    groups
}

fn heading(loaded: &LoadedStudy, seed: u64, shares: &Sensitivity) -> String {
    let mut text = String::new();
    let mut lines = vec![
        ("study", loaded.origin.to_string()),
        ("seed", seed.to_string()),
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
        let told = row(&share);
        assert!(told.contains("108.3 (77.1 to 136.5) 106.1 (83.8 to 129.0)  █"), "{told}");
        assert!(told.chars().count() <= 80, "{told}");
        let unsure = row(&FactorShare { first_ci95: None, total_ci95: None, ..share });
        assert!(unsure.contains(" 108.3 ") && !unsure.contains('('), "{unsure}");
    }
}
