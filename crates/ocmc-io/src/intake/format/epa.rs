//! Driving schedules as the Environmental Protection Agency of the United States publishes them: a
//! title, a heading of time in s and speed in mph, and two numbers a line.

use super::{Content, Format, text_of};
use crate::intake::Finding;

/// The format.
pub(super) const EPA: Format = Format {
    name: "a driving schedule of the EPA",
    is_track: false,
    is_one: |start| text_of(start).lines().take(HEADING).any(is_heading),
    read: |_, bytes| Ok(cells_of(bytes)),
};

/// Lines within which the heading stands.
const HEADING: usize = 6;

/// Whether a line is the heading, whose two names may stand in one cell.
fn is_heading(line: &str) -> bool {
    let line = line.to_lowercase();
    line.starts_with("test time, secs") && line.contains("target speed, mph")
}

/// The schedule as separated cells, each line in its place.
fn cells_of(bytes: &[u8]) -> Content {
    let text = text_of(bytes);
    let heading = text.lines().position(is_heading).unwrap_or(0);
    let title = text.lines().take(heading).collect::<Vec<_>>().join(" ");
    let title: String = title.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut cells = String::with_capacity(text.len());
    for (k, line) in text.lines().enumerate() {
        // a line stays in its place, so that messages name it
        if k == heading {
            cells.push_str("time_s,speed_mph");
        } else if k > heading {
            let row: Vec<&str> = line
                .split(|c: char| c.is_whitespace() || c == ',')
                .filter(|c| !c.is_empty())
                .collect();
            cells.push_str(&row.join(","));
        }
        cells.push('\n');
    }
    let title: String = title.chars().take(80).collect();
    let text = format!("a driving schedule of the EPA, `{title}`: s and mph");
    Content::Cells(cells, vec![Finding::noted("schedule", [1.0, 0.0], text, "")])
}
