//! The distribution over the fleet as a table that fits 80 columns.

use crate::number_text::decimals;
use ocmc_core::fleet::statistic::Statistic;
use ocmc_io::label::label;
use std::fmt::Write;

/// Width of the names, of the mean with its interval, and of the other columns.
const WIDTHS: (usize, usize, usize) = (13, 18, 7);

/// The table. Quantities that the fleet does not have are left out.
pub(crate) fn summary_table(statistics: &[Statistic]) -> String {
    let (name_width, mean_width, width) = WIDTHS;
    let mut text =
        format!("{:name_width$}{:>mean_width$}  each cycle counted once\n", "", "of the fleet");
    let _ = write!(text, "{:name_width$}{:>mean_width$}{:>width$}", "", "mean ± 95 %", "SD");
    for quantile in statistics.first().iter().flat_map(|statistic| &statistic.quantiles) {
        let _ = write!(text, "{:>width$}", quantile.name.to_uppercase());
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
    let scale = statistic.mean.or(statistic.quantiles[2].value).unwrap_or(0.0);
    let digits = decimals(factor * scale);
    let print = |value: Option<f64>| match value {
        Some(value) => format!("{:.digits$}", factor * value),
        None => "-".to_owned(),
    };
    let half_width = statistic.ci95.map(|[low, high]| (high - low) / 2.0);
    let mean = format!("{} ± {}", print(statistic.mean), print(half_width));
    let mut text = format!("{name:name_width$}{mean:>mean_width$}{:>width$}", print(statistic.sd));
    for quantile in &statistic.quantiles {
        let _ = write!(text, "{:>width$}", print(quantile.value));
    }
    text.push('\n');
    text
}
