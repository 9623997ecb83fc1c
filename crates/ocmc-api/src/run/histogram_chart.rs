//! A histogram of bars that fit the terminal.

use ocmc_core::fleet::histogram::Histogram;
use ocmc_core::fleet::statistic::Statistic;
use ocmc_io::label::label;
use ocmc_io::number_text::grouped;
use std::fmt::Write;

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
    use ocmc_core::fleet::dependence::Dependence;

    #[test]
    fn fits_the_width_and_shows_every_cycle() {
        let mut values: Vec<f64> = (0..2000).map(|k| 20.0 + f64::from(k % 97) * 0.1).collect();
        values.push(99.0);
        let cycles = (0..).zip(values);
        let statistic =
            Statistic::new("consumption_l_per_100km", None, &cycles, Dependence::default());
        for width in [40, 80, 120] {
            let chart = histogram_chart(&statistic, width);
            assert!(chart.lines().all(|line| line.chars().count() <= width), "{chart}");
            assert!(chart.contains("above"), "{chart}");
        }
    }
}
