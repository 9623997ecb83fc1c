//! The answer of a run as text: what was run, the distribution over the fleet, a histogram, and
//! what failed.

use super::{RunAnswer, histogram_chart, summary_table};
use crate::cost::threads_text;
use ocmc_core::fleet::precision::{Precision, Reached};
use ocmc_core::fleet::summary::{OUTSIDE_MAP_SHARE, Summary};
use ocmc_core::record::Outcome;
use ocmc_io::label::label;
use ocmc_io::number_text::{count_of, grouped, rough, rounded, short};
use ocmc_io::run_directory::RunSummary;
use ocmc_io::study::Origin;
use std::fmt::Write;

/// The quantity that empty trips do not have.
const PER_TONNE: &str = "consumption_l_per_100tkm";

/// The whole answer, so many columns wide.
pub(crate) fn run_text(answer: &RunAnswer, width: usize) -> String {
    let run = &answer.summary;
    let mut text = heading(answer, run);
    if run.summary.outcomes.of(Outcome::Completed) > 0 {
        text.push('\n');
        text.push_str(&summary_table::summary_table(&run.summary.statistics));
        text.push_str(&empty(&run.summary));
        text.push_str(&uncertain(&run.summary));
        if let Some(statistic) = run.summary.consumption() {
            text.push('\n');
            text.push_str(&histogram_chart::histogram_chart(statistic, width));
        }
    }
    text.push_str(&saturated(&run.summary));
    text.push_str(&failed(run));
    text
}

fn heading(answer: &RunAnswer, run: &RunSummary) -> String {
    let summary = &run.summary;
    let mut lines = Vec::new();
    lines.push((
        "study",
        match &answer.origin {
            Origin::File(path) => format!("{} ({})", run.study, path.display()),
            _ => run.study.clone(),
        },
    ));
    lines.push(("seed", run.seed.to_string()));
    let ids = match summary.cycles {
        0 => String::new(),
        n => format!(", ids {} to {}", run.first_cycle, run.first_cycle + (n - 1)),
    };
    lines.push(("cycles", format!("{}{ids}", grouped(summary.cycles))));
    lines.push((
        "simulated",
        format!(
            "{} km, {} h of driving",
            rounded(summary.distance_m / 1000.0),
            rounded(summary.simulated_s / 3600.0)
        ),
    ));
    if let Some(reached) = &run.precision {
        lines.push(("precision", precision(reached)));
    }
    let took = format!("{} s on {}", short(run.wall_s), threads_text(run.threads));
    let rate = |cycles: u64| rough(cycles as f64 / run.wall_s);
    let took = match answer.resumed {
        0 => {
            let real = rough(summary.simulated_s / run.wall_s);
            format!("{took}: {} cycles/s, {real} times real time", rate(summary.cycles))
        }
        before => {
            // a run that was ended while its files were put together has no cycle left to drive
            let rest = summary.cycles - before;
            format!("{took} for the last {} cycles: {} cycles/s", grouped(rest), rate(rest))
        }
    };
    lines.push(("took", took));
    let mut text = String::new();
    for (name, value) in lines {
        let _ = writeln!(text, "{name:<10} {value}");
    }
    text
}

/// What was asked for, and what came of it.
fn precision(reached: &Reached) -> String {
    let Precision { of, wanted } = &reached.precision;
    let percent = |share: f64| format!("{} %", rounded_share(100.0 * share));
    let wanted = percent(*wanted);
    match (reached.met, reached.reached) {
        (true, Some(share)) => format!("{of} ± {}, asked for was {wanted}", percent(share)),
        (false, Some(share)) => {
            format!("{of} ± {}: {wanted} was asked for, more --cycles are needed", percent(share))
        }
        (_, None) => format!("{of}: no interval yet, {wanted} was asked for"),
    }
}

/// A percentage to two digits.
fn rounded_share(percent: f64) -> String {
    format!("{percent:.1e}").parse::<f64>().unwrap_or(percent).to_string()
}

/// How empty trips were counted, where there are any.
fn empty(summary: &Summary) -> String {
    let completed = summary.outcomes.of(Outcome::Completed);
    let carrying = summary.statistic(PER_TONNE).map_or(0, |statistic| statistic.n);
    if carrying == 0 || carrying == completed {
        return String::new();
    }
    let empty = completed - carrying;
    let trips = count_of(empty, "empty trip");
    let count = if empty == 1 { "counts" } else { "count" };
    format!("L/100 tkm: {trips} {count} in the mean, not in the other columns.\n")
}

/// How sure the mean is when the parameters are not, where the study says how uncertain they are.
fn uncertain(summary: &Summary) -> String {
    let Some(uncertainty) = summary.parameter_uncertainty else { return String::new() };
    let (name, factor) = label(uncertainty.column);
    let [low, high] = uncertainty.ci95;
    let sampling = summary.statistic(uncertainty.column).and_then(|statistic| statistic.ci95);
    let half = |[low, high]: [f64; 2]| short(factor * (high - low) / 2.0);
    format!(
        "{name}: mean ± {} with the uncertain parameters of the curve-speed fit ({} draws),\n\
         ± {} from sampling alone. More cycles shrink only the latter.\n",
        half([low, high]),
        uncertainty.replicates,
        sampling.map_or("-".to_owned(), half)
    )
}

/// Work a cycle, in J, below which nothing is missing at the wheels but digits.
const ROUNDING_J: f64 = 1.0;

/// Where powertrains could not do what a followed speed asked for, and left their maps.
fn saturated(summary: &Summary) -> String {
    let saturation = &summary.saturation;
    let outside_s = saturation.outside_map_s;
    let (cycles, of) = (grouped(saturation.cycles), grouped(summary.cycles));
    let limited_s = saturation.limited_s.unwrap_or(0.0);
    let missing_j = saturation.missing_energy_j.unwrap_or(0.0);
    // the balance of a step is exact but for rounding
    if !(limited_s > 0.0 || missing_j > ROUNDING_J * summary.cycles as f64) {
        if outside_s <= OUTSIDE_MAP_SHARE * summary.simulated_s {
            return String::new();
        }
        let percent = rounded_share(100.0 * outside_s / summary.simulated_s);
        return format!(
            "\nBeyond the points of the powertrain's maps for {percent} % of the driving,\nin {cycles} of {of} cycles.\n"
        );
    }
    let mut text = format!(
        "\nSaturated in {cycles} of {of} cycles: {} s at the powertrain's limit, {} kWh missing at the wheels",
        rounded(limited_s),
        rounded(missing_j / 3.6e6),
    );
    if outside_s > 0.0 {
        let _ = write!(text, ",\n{} s beyond the points of its map", rounded(outside_s));
    }
    text.push_str(".\n");
    text
}

/// Cycles that could not be driven, by reason, and how they were counted.
fn failed(run: &RunSummary) -> String {
    let summary = &run.summary;
    let failed = summary.outcomes.failed();
    if failed == 0 {
        return String::new();
    }
    let reasons: Vec<String> = Outcome::ALL
        .into_iter()
        .filter(|outcome| *outcome != Outcome::Completed && summary.outcomes.of(*outcome) > 0)
        .map(|outcome| format!("{} {}", grouped(summary.outcomes.of(outcome)), outcome.name()))
        .collect();
    let share = 100.0 * failed as f64 / summary.cycles as f64;
    let mut text = format!(
        "\nNot completed: {} of {} cycles ({share:.2} %): {}.\n{} in the records, but in no mean and no quantile above.\n",
        grouped(failed),
        grouped(summary.cycles),
        reasons.join(", "),
        if failed == 1 { "It is" } else { "They are" }
    );
    if let Some(worst) = summary.worst_case {
        let (label, factor) = label(worst.column);
        let _ = writeln!(
            text,
            "Worst case: had each of them been as long as the mean completed cycle and consumed like\n\
             the worst one, or like its own record where that is more, the mean would be\n{} {label}.",
            rounded(factor * worst.mean)
        );
    }
    text
}
