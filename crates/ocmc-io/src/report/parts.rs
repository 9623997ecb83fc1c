//! The report's tables of what road types and event kinds took.

use super::svg::escaped;
use crate::part_table::{PartTable, part_tables};
use ocmc_fleet::parts::FleetPart;
use std::fmt::Write;

/// The tables; nothing where there are no parts.
pub(super) fn parts(parts: &[FleetPart]) -> String {
    part_tables(parts).iter().map(table).collect()
}

fn table(table: &PartTable) -> String {
    let mut text = format!(
        "<h2>{}</h2>\n<p class=\"soft\">Shares of the whole, standstill and idling included, and \
         the consumption of each part over its own way.</p>\n<div class=\"wide\" \
         tabindex=\"0\"><table>\n\
         <thead><tr><th>part</th>",
        table.title
    );
    for column in &table.columns {
        let _ = write!(text, "<th>{}</th>", escaped(column));
    }
    text.push_str("</tr></thead>\n<tbody>\n");
    for (name, cells) in &table.rows {
        let _ = write!(text, "<tr><td>{}</td>", escaped(name));
        for cell in cells {
            let _ = write!(text, "<td>{}</td>", escaped(cell));
        }
        text.push_str("</tr>\n");
    }
    text.push_str("</tbody></table></div>\n");
    text
}
