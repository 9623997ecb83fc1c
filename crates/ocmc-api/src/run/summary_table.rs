//! The distribution over the fleet as a table that fits 80 columns.

use ocmc_core::fleet::statistic::Statistic;
use ocmc_io::label::label;
use ocmc_io::number_text::decimals;
use std::fmt::Write;

/// Width of the names, of the mean with its interval, and of the other columns, behind a space
/// each.
const WIDTHS: (usize, usize, usize) = (13, 17, 6);

/// The table. Quantities that the fleet does not have are left out.
pub(crate) fn summary_table(statistics: &[Statistic]) -> String {
    let (name_width, mean_width, width) = WIDTHS;
    let mut text =
        format!("{:name_width$} {:>mean_width$}  each cycle counted once\n", "", "of the fleet");
    let _ = write!(text, "{:name_width$} {:>mean_width$} {:>width$}", "", "mean ± 95 %", "SD");
    for quantile in statistics.first().iter().flat_map(|statistic| &statistic.quantiles) {
        let _ = write!(text, " {:>width$}", quantile.name.to_uppercase());
    }
    text.push('\n');
    for statistic in statistics.iter().filter(|statistic| statistic.n > 0) {
        text.push_str(&row(statistic));
    }
    text
}

fn row(statistic: &Statistic) -> String {
    let (name_width, mean_width, width) = WIDTHS;
    let (name, factor) = label(statistic.column);
    let digits = digits(statistic, factor);
    let print = |value: Option<f64>| match value {
        Some(value) => format!("{:.digits$}", factor * value),
        None => "-".to_owned(),
    };
    let half_width = statistic.ci95.map(|[low, high]| (high - low) / 2.0);
    let mean = format!("{} ± {}", print(statistic.mean), print(half_width));
    let mut text =
        format!("{name:name_width$} {mean:>mean_width$} {:>width$}", print(statistic.sd));
    for quantile in &statistic.quantiles {
        let _ = write!(text, " {:>width$}", print(quantile.value));
    }
    text.push('\n');
    text
}

/// Decimals of a row: as the mean has them, fewer where a column would be too narrow for its
/// number.
fn digits(statistic: &Statistic, factor: f64) -> usize {
    let scale = statistic.mean.or(statistic.quantiles[2].value).unwrap_or(0.0);
    let quantiles = statistic.quantiles.iter().map(|quantile| quantile.value);
    let numbers: Vec<f64> =
        quantiles.chain([statistic.sd]).flatten().map(|value| factor * value).collect();
    let fits = |&digits: &usize| {
        numbers.iter().all(|number| format!("{number:.digits$}").len() <= WIDTHS.2)
    };
    (0..=decimals(factor * scale)).rev().find(fits).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::fleet::summary::SummaryBuilder;

    #[test]
    fn columns_never_touch() {
        let mut statistics = SummaryBuilder::default().finish().statistics;
        for statistic in &mut statistics {
            statistic.n = 60;
            (statistic.mean, statistic.ci95) = (Some(7.106), Some([6.262, 7.95]));
            statistic.sd = Some(30.054);
            for (quantile, value) in
                statistic.quantiles.iter_mut().zip([4.3, 9.99, 99.9999, 1e4, 166.062, 1e7])
            {
                quantile.value = Some(value);
            }
        }
        let text = summary_table(&statistics);
        for line in text.lines().skip(2) {
            let (_, numbers) = line.split_once('±').unwrap();
            let numbers: Vec<f64> =
                numbers.split_whitespace().map(|number| number.parse().unwrap()).collect();
            assert_eq!(numbers.len(), 2 + statistics[0].quantiles.len(), "{line}");
        }
    }
}
