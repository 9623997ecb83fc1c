//! The fit of speed changes as text: a law for each category, and all of them together.

use super::curve_speed_text::dropped;
use ocmc_estimation::fit::speed_change::{SpeedChangeFit, SpeedChangeLaw};
use ocmc_io::number_text::count_of;
use std::fmt::Write;

/// Columns of the printed table: a name, then numbers.
const COLUMNS: usize = 6;

/// The whole answer; `values` is the part of a study.
pub(crate) fn speed_change_text(fit: &SpeedChangeFit, values: &str) -> String {
    let mut text = format!("{}\n", count_of(fit.n as u64, "speed change"));
    text.push_str(&dropped(&fit.dropped, "speed change"));
    let pooled = [&fit.acceleration, &fit.deceleration].into_iter().flatten();
    let laws: Vec<&SpeedChangeLaw> = fit.by_category.iter().chain(pooled).collect();
    text.push('\n');
    text.push_str(&law_table(&laws));
    text.push_str(
        "p normal: of a log-normal law, by Anderson and Darling. With threshold: median and SD with the\n\
         changes below the threshold in the likelihood.\n",
    );
    let _ = write!(text, "\nTo paste into a study:\n\n{values}");
    text
}

/// A row a law, in columns as wide as what stands in them.
fn law_table(laws: &[&SpeedChangeLaw]) -> String {
    let head = ["", "n", "median, m/s2", "SD of ln", "p normal", "with threshold"];
    let rows: Vec<[String; COLUMNS]> =
        std::iter::once(head.map(str::to_owned)).chain(laws.iter().map(|law| row(law))).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths: [usize; COLUMNS] = std::array::from_fn(|column| width(column).unwrap_or(0));
    let between = std::iter::once(None).chain(laws.iter().map(|law| law.driver_log_sd));
    let mut text = String::new();
    for (row, between) in rows.iter().zip(between) {
        let _ = write!(text, "{:width$}", row[0], width = widths[0]);
        for (cell, width) in row.iter().zip(widths).skip(1) {
            let _ = write!(text, "  {cell:>width$}");
        }
        text.push('\n');
        if let Some(sd) = between {
            let _ = writeln!(
                text,
                "{:width$}  between drivers, SD of ln {sd:.3}",
                "",
                width = widths[0]
            );
        }
    }
    text
}

fn row(law: &SpeedChangeLaw) -> [String; COLUMNS] {
    let interval = |value: f64, ci: Option<[f64; 2]>| match ci {
        Some([low, high]) => format!("{value:.3} ({low:.3} ; {high:.3})"),
        None => format!("{value:.3}"),
    };
    let name = if law.category.is_empty() { "unnamed" } else { &law.category };
    let p = law.anderson_darling_p.map_or("-".to_owned(), |p| format!("{p:.3}"));
    let whole = law
        .untruncated
        .map_or("-".to_owned(), |law| format!("{:.3}, {:.3}", law.median_mps2, law.log_sd));
    let sd = law.log_sd.map_or("-".to_owned(), |sd| {
        let [low, high] = law.log_sd_ci95.unwrap_or([f64::NAN; 2]);
        format!("{sd:.2} ({low:.2} ; {high:.2})")
    });
    let median = interval(law.median_mps2, law.median_ci95);
    [name.to_owned(), law.n.to_string(), median, sd, p, whole]
}
