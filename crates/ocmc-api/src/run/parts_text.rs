//! What road types and event kinds took, as text.

use ocmc_fleet::summary::Summary;
use ocmc_io::part_table::{PartTable, part_tables};
use std::fmt::Write;

/// Widths of the name and of each column.
const WIDTHS: [usize; 2] = [14, 11];

/// The tables of a summary; nothing where it has no parts.
pub(super) fn parts(summary: &Summary) -> String {
    part_tables(&summary.parts).iter().map(table).collect()
}

fn table(table: &PartTable) -> String {
    let [first, width] = WIDTHS;
    let line = |name: &str, cells: &[String]| {
        let mut text = format!("{name:<first$}");
        for cell in cells {
            let _ = write!(text, "{cell:>width$}");
        }
        text.trim_end().to_owned() + "\n"
    };
    let rows = table.rows.iter().map(|(name, cells)| line(name, cells));
    format!("\n{}{}", line(table.title, &table.columns), rows.collect::<String>())
}
