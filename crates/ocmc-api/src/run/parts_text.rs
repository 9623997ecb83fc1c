//! Tables of routes, road types and event kinds as text.

use ocmc_fleet::summary::Summary;
use ocmc_io::part_table::{PartTable, part_tables};
use std::fmt::Write;

/// Least widths of the name and of each column, and the width that all of them are to keep to.
const WIDTHS: [usize; 2] = [14, 11];
const WIDTH: usize = 80;
/// Longest name that is not cut.
const LONGEST: usize = 24;

/// The tables of a summary; nothing where it has no parts.
pub(super) fn parts(summary: &Summary) -> String {
    part_tables(summary).iter().map(table).collect()
}

fn table(table: &PartTable) -> String {
    let name = |name: &str| -> String { name.chars().take(LONGEST).collect() };
    let count = |text: &str| text.chars().count();
    let own = |k: usize| {
        let cells = table.rows.iter().map(|(_, cells)| count(&cells[k]));
        2 + cells.max().unwrap_or(0).max(count(&table.columns[k]))
    };
    let names = table.rows.iter().map(|(own, _)| count(&name(own)));
    let own_first = names.max().unwrap_or(0).max(count(table.title));
    let own: Vec<usize> = (0..table.columns.len()).map(own).collect();
    let wide = |k: &usize| (*k - 1).max(WIDTHS[1]);
    let is_wide = own_first.max(WIDTHS[0]) + own.iter().map(wide).sum::<usize>() <= WIDTH;
    let first = if is_wide { own_first.max(WIDTHS[0]) } else { own_first };
    let widths: Vec<usize> = own.iter().map(|k| if is_wide { wide(k) } else { *k }).collect();
    let line = |name: &str, cells: &[String]| {
        let mut text = format!("{name:<first$}");
        for (cell, width) in cells.iter().zip(&widths) {
            let _ = write!(text, "{cell:>width$}");
        }
        text.trim_end().to_owned() + "\n"
    };
    let rows = table.rows.iter().map(|(own, cells)| line(&name(own), cells));
    format!("\n{}{}", line(table.title, &table.columns), rows.collect::<String>())
}
