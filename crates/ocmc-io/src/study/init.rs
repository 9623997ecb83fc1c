//! The default study as one commented file to start from, each number with its allowed range.

use super::builtin::{DEFAULT, find};
use super::node::{Content, Node};
use super::source::{Source, SourceKind};
use ocmc_core::study::keys::{Bounds, Key, declarations};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Column at which comments begin where the key and value leave room.
pub(super) const COMMENT_COLUMN: usize = 44;

/// Legend above the written study.
const LEGEND: &str = "# Written by `ocmc study init`: the default study, complete. Change what \
differs for you; `ocmc study check FILE` tells
# whether it fits. At the end of a number's \
comment, behind the bar, stands its allowed range.
#
";

/// The default study with every key, its comments, and the allowed range of every number.
///
/// The vehicle's file stands in place of `vehicle.base`.
pub fn init_text() -> String {
    let [study, vehicle] = [DEFAULT, "tractor-40t"].map(|name| find(name).unwrap_or_default());
    with_ranges(LEGEND.to_owned() + &with_vehicle(study, vehicle))
}

/// Puts the vehicle's keys under `[vehicle]`, in place of its base.
fn with_vehicle(study: &str, vehicle: &str) -> String {
    // the comment on top of the vehicle's file stays out: the study has the same legend
    let body = vehicle.split_once("\n\n").map_or(vehicle, |(_, body)| body);
    let body = body.lines().map(|line| match line.strip_prefix('[') {
        Some(header) => format!("[vehicle.{header}\n"),
        None => format!("{line}\n"),
    });
    let body: String = body.collect();
    let line = |line: &str| {
        if line.starts_with("base = ") { body.clone() } else { format!("{line}\n") }
    };
    study.lines().map(line).collect()
}

/// Appends to the line of each key the ranges of the numbers in its value.
fn with_ranges(text: String) -> String {
    let source = Arc::new(Source { kind: SourceKind::BuiltIn, name: DEFAULT.to_owned(), text });
    let Ok(root) = Node::parse(&source) else {
        return source.text.clone();
    };
    let mut notes = BTreeMap::new();
    collect(&root, Key(declarations()), &mut notes);
    let mut text = String::new();
    for (k, line) in source.text.lines().enumerate() {
        match notes.get(&(k + 1)) {
            Some((end, range)) => text.push_str(&aligned(line, *end, range)),
            None => text.push_str(line),
        }
        text.push('\n');
    }
    text
}

/// Notes for each line where the value on it ends, in characters, and the ranges of its numbers.
fn collect(node: &Node, key: Key, notes: &mut BTreeMap<usize, (usize, String)>) {
    let Content::Table(entries) = &node.content else { return };
    for (name, below) in entries {
        let Some(key) = key.below(name) else { continue };
        let written = below.place.as_ref().map_or("", |p| &p.source.text[p.span.clone()]);
        if matches!(below.content, Content::Table(_)) && !written.starts_with('{') {
            collect(below, key, notes);
        } else if let (Some(place), Some(value)) = (&below.key_place, &below.place) {
            let ranges = ranges_in(below, key);
            if !ranges.is_empty() {
                let first_line = written.lines().next().unwrap_or_default();
                let end = value.column() - 1 + first_line.chars().count();
                notes.insert(place.line(), (end, ranges.join("; ")));
            }
        }
    }
}

/// The range of a value, or of each key in it.
pub(super) fn ranges_in(node: &Node, key: Key) -> Vec<String> {
    if let Some(bounds) = key.bounds() {
        return vec![range(bounds)];
    }
    match &node.content {
        // names that a user chooses, such as road types, share one range
        Content::Table(_) if key.any_name().is_some() => {
            let bounds = key.any_name().and_then(Key::bounds);
            bounds.map(|bounds| format!("each {}", range(bounds))).into_iter().collect()
        }
        Content::Table(entries) => entries
            .keys()
            .filter_map(|name| Some(format!("{name} {}", range(key.below(name)?.bounds()?))))
            .collect(),
        Content::List(items) => items.first().map_or_else(Vec::new, |item| ranges_in(item, key)),
        Content::Scalar(_) => Vec::new(),
    }
}

/// A range in words.
pub(super) fn range(bounds: Bounds) -> String {
    format!("{} to {}", number(bounds.minimum), number(bounds.maximum))
}

/// A number without rows of zeros.
fn number(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e6).contains(&size) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

/// Appends a range to a line's comment, which begins at the comment column where there is room.
fn aligned(line: &str, value_end: usize, range: &str) -> String {
    let code: String = line.chars().take(value_end).collect();
    let rest: String = line.chars().skip(value_end).collect();
    let comment = rest.trim_start().trim_start_matches('#').trim();
    let gap = " ".repeat(COMMENT_COLUMN.saturating_sub(value_end).max(2));
    let blank = if comment.is_empty() { "" } else { " " };
    format!("{code}{gap}# {comment}{blank}| {range}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{load, load_text};

    const NO_SETS: &[&str] = &[];

    #[test]
    fn the_written_study_is_the_default_one() {
        let text = init_text();
        let written = load_text("new.toml", &text, NO_SETS).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(written.model, load(DEFAULT, NO_SETS).unwrap().model);
    }

    #[test]
    fn every_number_has_its_range_in_a_comment() {
        let text = init_text();
        for (key, range) in [
            ("curb_mass_kg = 15250.0", "| 500 to 100000"),
            ("length_m = 100.0e3 ", "| 200 to 5e6"),
            ("drag_area_m2 = {", "| 0.1 to 20"),
            ("next = { rural", "| each 0 to 1"),
            ("axles = [", "load_share 0 to 1; tyres 1 to 16"),
            ("map_fuel_kgps = [", "| 0 to 1"),
            ("correlation = [0.3", "| -0.99 to 0.99"),
        ] {
            let line = text.lines().find(|line| line.starts_with(key)).unwrap();
            assert!(line.contains(range), "{line}");
        }
        let numbers = text.lines().filter(|line| {
            let (key, value) = line.split_once(" = ").unwrap_or_default();
            !key.starts_with(' ') && value.starts_with(|c: char| c.is_ascii_digit() || c == '-')
        });
        for line in numbers {
            assert!(line.contains("# ") && line.contains(" to "), "{line}");
        }
        assert!(text.lines().all(|line| !line.starts_with("base = ")));
    }
}
