//! The report's tables of what routes, road types and event kinds took.

use super::svg::escaped;
use super::tables::{self, cells};
use crate::part_table::{PartTable, part_tables};
use ocmc_fleet::summary::Summary;
use std::iter::once;

/// The tables; nothing where there are no parts.
pub(super) fn parts(summary: &Summary) -> String {
    part_tables(summary).iter().map(table).collect()
}

fn table(table: &PartTable) -> String {
    let line = |name: &str, others: &[String]| -> Vec<String> {
        once(name).chain(others.iter().map(String::as_str)).map(escaped).collect()
    };
    let rows = table.rows.iter().map(|(name, others)| cells(&line(name, others)));
    format!(
        "<h2>{}</h2>\n<p class=\"soft\">{}</p>\n{}",
        table.title,
        table.caption,
        tables::table(&line(table.first, &table.columns), rows)
    )
}
