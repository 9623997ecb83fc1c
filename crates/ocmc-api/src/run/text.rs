//! The answer of a run as text: what was run, the distribution over the fleet as a table that fits
//! 80 columns, a histogram of bars that fit the terminal, and what failed.

use super::RunAnswer;
use super::charging_text::charging;
use super::parts_text::parts;
use super::trucks_text::{fleet, trucks};
use crate::text::{as_many, effects, fact, row, threads_text};
use ocmc_core::record::Outcome;
use ocmc_fleet::histogram::Histogram;
use ocmc_fleet::precision::{Precision, Reached};
use ocmc_fleet::statistic::Statistic;
use ocmc_fleet::summary::Summary;
use ocmc_io::label::{label, remarks, saturation};
use ocmc_io::number_text::{
    count_of, decimals, grouped, rough, rounded, rounded_share, short, two_digits,
};
use ocmc_io::run_directory::RunSummary;
use ocmc_io::study::{NumbersShare, Origin};
use std::fmt::Write;
use std::iter::once;

/// The whole answer, so many columns wide.
pub(crate) fn run_text(answer: &RunAnswer, width: usize) -> String {
    let run = &answer.summary;
    let mut text = heading(answer, run) + &fleet(&run.summary) + &trucks(&run.summary);
    if run.summary.outcomes.counted() > 0 {
        let table = summary_table(&run.summary) + &adjusted(&run.summary) + &judged(run, WIDTH);
        let few = run.note.map_or_else(String::new, |note| format!("Intervals: {note}.\n"));
        let remarks: String =
            remarks(&run.summary).into_iter().map(|remark| remark + "\n").collect();
        let _ = write!(text, "\n{table}{few}{remarks}{}", uncertain(answer));
        if let Some(statistic) = run.summary.consumption() {
            let _ = write!(text, "\n{}", histogram_chart(statistic, width));
        }
    }
    text + &parts(&run.summary)
        + &charging(&run.summary)
        + &saturated(&run.summary)
        + &failed(&run.summary)
}

fn heading(answer: &RunAnswer, run: &RunSummary) -> String {
    let summary = &run.summary;
    let study = match &answer.origin {
        Origin::File(path) => format!("{} ({})", run.study, path.display()),
        _ => run.study.clone(),
    };
    let ids = match summary.cycles {
        0 => String::new(),
        n => format!(", ids {} to {}", run.first_cycle, run.first_cycle + (n - 1)),
    };
    let (km, h) = (rounded(summary.distance_m / 1000.0), rounded(summary.simulated_s / 3600.0));
    let precision = run.precision.as_ref().map(|reached| fact("precision", precision(reached)));
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
    [
        fact("study", study),
        fact("seed", run.seed),
        fact("cycles", format!("{}{ids}", grouped(summary.cycles))),
        fact("simulated", format!("{km} km, {h} h of driving")),
        precision.unwrap_or_default(),
        fact("took", took),
    ]
    .concat()
}

/// Precision that was asked for, and that was reached.
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

/// How sure the mean is when the parameters are not, where the study says how uncertain they are.
fn uncertain(answer: &RunAnswer) -> String {
    let summary = &answer.summary.summary;
    let Some(uncertainty) = &summary.parameter_uncertainty else { return String::new() };
    let (name, factor) = label(&uncertainty.column);
    let [low, high] = uncertainty.ci95;
    let sampling = summary.statistic(&uncertainty.column).and_then(|statistic| statistic.ci95);
    let half = |[low, high]: [f64; 2]| short(factor * (high - low) / 2.0);
    let mut text = format!(
        "{name}: mean ± {} with the errors of the study's uncertain numbers, ± {} from\n\
         sampling alone. More cycles shrink only the latter. One standard error does\n",
        half([low, high]),
        sampling.map_or("-".to_owned(), half)
    );
    for effect in effects(uncertainty, factor) {
        let _ = writeln!(text, "  {effect}");
    }
    let known: Vec<&str> = uncertainty.parameters.iter().map(|number| &*number.key).collect();
    let without = answer.manifest.numbers_without_error(&known);
    let count: usize = without.iter().map(|(_, count)| count).sum();
    let tables: Vec<String> =
        without.iter().map(|(table, count)| format!("{count} of `{table}`")).collect();
    let driven = 2 * uncertainty.cycles * uncertainty.parameters.len() as u64;
    let _ = writeln!(
        text,
        "It took {} more cycles, on both sides of the numbers, which are not counted above.\n\
         Not in it: how right the models are, and {} without a standard error,\n{}.",
        grouped(driven),
        count_of(count as u64, "number"),
        tables.join(", ")
    );
    text
}

/// Where powertrains left their maps, or could not hold a speed that was followed.
fn saturated(summary: &Summary) -> String {
    saturation(summary).map_or_else(String::new, |text| format!("\n{text}\n"))
}

/// How trips that a battery cut short are counted.
const CUT_SHORT: &str = "Trips whose battery ran empty count with the kilometres that they drove. \
As heavy
consumers drive fewer, the first kWh/km is low for the trips asked for: \"whole\" \
is
that of all trips to their end, with a battery that never empties.
";

/// Cycles that could not be driven, by reason, and how they were counted.
fn failed(summary: &Summary) -> String {
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
        "\nNot completed: {} of {} cycles ({share:.2} %): {}.\n",
        grouped(failed),
        grouped(summary.cycles),
        reasons.join(", "),
    );
    if summary.outcomes.of(Outcome::Depleted) > 0 {
        text.push_str(CUT_SHORT);
    }
    let uncounted = summary.outcomes.uncounted();
    let who = match (uncounted == failed, uncounted) {
        (_, 0) => None,
        (true, 1) => Some("It is"),
        (true, _) => Some("They are"),
        (false, 1) => Some("The other one is"),
        (false, _) => Some("The others are"),
    };
    if let Some(who) = who {
        let _ = writeln!(text, "{who} in the records, but in no mean and no quantile above.");
    }
    if let Some(worst) = summary.worst_case {
        let (label, factor) = label(worst.column);
        let _ = writeln!(
            text,
            "Worst case: had each of them been as long as the mean completed cycle and consumed \
             like\n\
             the worst one, or like its own record where that is more, the mean would be\n{} \
             {label}.",
            rounded(factor * worst.mean)
        );
    }
    text
}

/// The most precise mean of the consumption, beside the plain one.
fn adjusted(summary: &Summary) -> String {
    let line = |statistic: &Statistic| {
        let (name, factor) = label(statistic.column);
        let adjusted = statistic.adjusted.as_ref()?;
        let (plain, ci95) = (statistic.mean?, statistic.ci95?);
        let half = |[low, high]: [f64; 2]| (high - low) / 2.0;
        let print = |value: f64| format!("{:.1$}", factor * value, digits(statistic, factor));
        Some(format!(
            "{name}: {} ± {} adjusted for what was drawn, {} ± {} plain.\n",
            print(adjusted.mean),
            print(half(adjusted.ci95)),
            print(plain),
            print(half(ci95))
        ))
    };
    summary.consumption().and_then(line).unwrap_or_default()
}

/// The effect of judged numbers on the mean.
pub(crate) fn judged(run: &RunSummary, width: usize) -> String {
    let (Some(judged), Some(own)) = (&run.judged, run.summary.consumption()) else {
        return String::new();
    };
    let (_, factor) = label(own.column);
    match (judged.plus_minus, &judged.doubt.stored) {
        (Some(plus_minus), Some(stored)) => {
            let about = if stored.is_same { "" } else { "about " };
            let half = two_digits(factor * plus_minus);
            let start = format!("{about}± {half} from judged numbers (");
            let room = width.saturating_sub(start.chars().count() + SEE.len());
            let shares = stored.largest.iter().map(NumbersShare::words);
            format!("{start}{}{SEE}\n", as_many(&shares.collect::<Vec<_>>(), room))
        }
        _ if judged.doubt.entries == 0 => {
            "± unknown from judged numbers: the study does not say which they are\n".to_owned()
        }
        _ => "± unknown from judged numbers: ocmc doubt finds it\n".to_owned(),
    }
}

/// Behind the names of judged numbers.
const SEE: &str = "): see ocmc doubt";
/// Width of a line.
pub(crate) const WIDTH: usize = 80;

/// Widths of the names, of the mean with its interval, of the spread and the quantiles, behind a
/// space each.
const WIDTHS: [usize; 9] = [15, 15, 6, 6, 6, 6, 6, 6, 6];

/// The table over cycles. Quantities that the fleet does not have are left out.
pub(crate) fn summary_table(summary: &Summary) -> String {
    let shown: Vec<Statistic> = summary.told().cloned().collect();
    table_over(&shown, ["of the fleet", " each cycle counted once"])
}

/// The table, with what its mean and its other columns are over.
pub(crate) fn table_over(statistics: &[Statistic], [mean, others]: [&str; 2]) -> String {
    let quantiles = statistics.first().into_iter().flat_map(|statistic| &statistic.quantiles);
    let names = quantiles.map(|quantile| quantile.name.to_uppercase());
    let head = ["", "mean ± 95 %", "SD"].map(str::to_owned).into_iter().chain(names).collect();
    let rows = statistics.iter().filter(|statistic| statistic.n > 0).map(cells);
    let rows = once(head).chain(rows).map(|cells: Vec<String>| row(" ", &WIDTHS, &cells));
    let over = row(" ", &WIDTHS, &["", mean, others]);
    once(over).chain(rows).collect()
}

/// Its name, the mean of the fleet with half its interval, the spread and the quantiles.
fn cells(statistic: &Statistic) -> Vec<String> {
    let (name, factor) = label(statistic.column);
    let digits = digits(statistic, factor);
    let print = |value: Option<f64>| match value {
        Some(value) => format!("{:.digits$}", factor * value),
        None => "-".to_owned(),
    };
    let half_width = statistic.ci95.map(|[low, high]| (high - low) / 2.0);
    let mean = format!("{} ± {}", print(statistic.mean), print(half_width));
    let quantiles = statistic.quantiles.iter().map(|quantile| print(quantile.value));
    [name.to_owned(), mean, print(statistic.sd)].into_iter().chain(quantiles).collect()
}

/// Decimals of a row: as the mean has them, fewer where a column would be too narrow for its
/// number.
fn digits(statistic: &Statistic, factor: f64) -> usize {
    let scale = statistic.mean.or(statistic.quantiles[2].value).unwrap_or(0.0);
    let quantiles = statistic.quantiles.iter().map(|quantile| quantile.value);
    let numbers: Vec<f64> =
        quantiles.chain([statistic.sd]).flatten().map(|value| factor * value).collect();
    let fits = |&digits: &usize| {
        numbers.iter().all(|number| format!("{number:.digits$}").len() <= WIDTHS[2])
    };
    (0..=decimals(factor * scale)).rev().find(fits).unwrap_or(0)
}

/// Bars from an eighth of a character to seven of them.
const PARTS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];

/// The histogram of a quantity that is printed in its own unit.
pub(crate) fn histogram_chart(statistic: &Statistic, width: usize) -> String {
    let Some(histogram) = &statistic.histogram else {
        return String::new();
    };
    let (name, _) = label(statistic.column);
    let rows = rows(histogram);
    let label_width = rows.iter().map(|row| row.0.chars().count()).max().unwrap_or(0);
    let count_width = rows.iter().map(|row| grouped(row.1).len()).max().unwrap_or(0);
    let bar_width = width.saturating_sub(label_width + count_width + 4).max(1);
    let largest = rows.iter().map(|row| row.1).max().unwrap_or(0).max(1);
    let mut text = format!("{name}, number of cycles\n");
    for (label, count) in rows {
        let bar = bar(count, largest, bar_width);
        let row = format!(" {label:>label_width$} {:>count_width$} {bar}", grouped(count));
        let _ = writeln!(text, "{}", row.trim_end());
    }
    text
}

/// Names and counts of the bins, from the lowest, tails included where they hold something.
fn rows(histogram: &Histogram) -> Vec<(String, u64)> {
    let digits = histogram.decimals;
    let edges = &histogram.edges;
    let mut rows = Vec::new();
    if histogram.below > 0 {
        rows.push((format!("below {:.digits$}", edges[0]), histogram.below));
    }
    for (edge, count) in edges.windows(2).zip(&histogram.counts) {
        rows.push((format!("{:.digits$} - {:.digits$}", edge[0], edge[1]), *count));
    }
    if histogram.above > 0 {
        rows.push((format!("above {:.digits$}", edges[edges.len() - 1]), histogram.above));
    }
    rows
}

/// A bar in eighths of a character; what is not 0 shows.
fn bar(count: u64, largest: u64, width: usize) -> String {
    let eighths = (8 * width) as f64 * count as f64 / largest as f64;
    let eighths = (eighths.round() as usize).max(usize::from(count > 0));
    format!("{}{}", "█".repeat(eighths / 8), PARTS[eighths % 8])
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_fleet::dependence::Dependence;
    use ocmc_fleet::summary::SummaryBuilder;

    #[test]
    fn columns_never_touch() {
        let mut summary = SummaryBuilder::default().finish();
        for statistic in &mut summary.statistics {
            statistic.n = 60;
            (statistic.mean, statistic.ci95) = (Some(7.106), Some([6.262, 7.95]));
            statistic.sd = Some(30.054);
            for (quantile, value) in
                statistic.quantiles.iter_mut().zip([4.3, 9.99, 99.9999, 1e4, 166.062, 1e7])
            {
                quantile.value = Some(value);
            }
        }
        let text = summary_table(&summary);
        for line in text.lines().skip(2) {
            let (_, numbers) = line.split_once('±').unwrap();
            let numbers: Vec<f64> =
                numbers.split_whitespace().map(|number| number.parse().unwrap()).collect();
            assert_eq!(numbers.len(), 2 + summary.statistics[0].quantiles.len(), "{line}");
        }
    }

    #[test]
    fn fits_the_width_and_shows_every_cycle() {
        let mut values: Vec<f64> = (0..2000).map(|k| 20.0 + f64::from(k % 97) * 0.1).collect();
        values.push(99.0);
        let cycles = (0..).zip(values);
        let statistic =
            Statistic::new("consumption_l_per_100km", None, &cycles, &Dependence::default().into());
        for width in [40, 80, 120] {
            let chart = histogram_chart(&statistic, width);
            assert!(chart.lines().all(|line| line.chars().count() <= width), "{chart}");
            assert!(chart.contains("above"), "{chart}");
        }
    }
}
