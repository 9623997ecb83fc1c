//! A sweep as a table, for people and as CSV.

use super::{SweepAnswer, SweptPoint};
use crate::text::{cell, decimals_for, fact, quoted, table, took};
use ocmc_io::label::label;
use ocmc_io::number_text::{grouped, percent};
use serde_json::Value;
use std::fmt::Write;
use std::io;

/// Widest table, in characters, where a narrower one can be made.
const WIDEST: usize = 80;

/// Whether the head has numbers of keys instead of their names, and the longest value that is
/// shown, in characters: the first with which the table is narrow enough, or the last.
const LAYOUTS: [(bool, usize); 4] = [(false, 24), (true, 24), (true, 12), (true, 6)];

/// Columns of the CSV behind those of the keys.
const COLUMNS: &str = "study_hash,column,mean,mean_low,mean_high,difference,difference_low,\
                       difference_high,relative_difference,adjusted_difference,\
                       adjusted_difference_low,adjusted_difference_high,pairs,cycles,\
                       not_completed,share_not_completed";

/// A value as it is written in a study, words without their marks.
fn shown(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(word) => word.clone(),
        value => value.to_string(),
    }
}

/// The end of a key that tells it from the others, two steps at least.
fn short_name(key: &str, all: &[String]) -> String {
    let steps: Vec<&str> = key.split('.').collect();
    let ends = (2..steps.len()).map(|count| steps[steps.len() - count..].join("."));
    let is_its_own = |end: &String| {
        let as_end = format!(".{end}");
        all.iter().filter(|other| *other == end || other.ends_with(&as_end)).count() == 1
    };
    ends.into_iter().find(is_its_own).unwrap_or_else(|| key.to_owned())
}

/// The name of a key by its place.
fn number_name(place: usize) -> String {
    format!("key {}", place + 1)
}

impl SweepAnswer {
    pub(super) fn lines(&self) -> String {
        let (plan, wall_s, driven) = self.driven;
        let (label, factor) = label(&self.column);
        let (is_numbered, table) = self.narrow_table(factor);
        let mut text = fact("study", &self.study);
        let name = |(k, key): (usize, &String)| {
            if is_numbered { format!("{}: {key}", number_name(k)) } else { key.clone() }
        };
        let keys: Vec<String> = self.keys.iter().enumerate().map(name).collect();
        text.push_str(&fact("keys", keys.join("\n           ")));
        text.push_str(&fact("seed", plan.seed));
        let (first, last) = (plan.first_cycle, plan.first_cycle + (plan.cycles - 1));
        let cycles = format!("{} at each point, ids {first} to {last}", grouped(plan.cycles));
        text.push_str(&fact("cycles", cycles));
        text.push_str(&took(wall_s, plan.threads, driven));
        if self.is_common {
            let note = format!("compared by {label}, the first that all points have");
            text.push_str(&fact("note", note));
        }
        let reference = if self.base.is_some() { "the study" } else { "the first point" };
        let _ = writeln!(text, "\n{label}, mean of the fleet, and how it differs from {reference}");
        text.push_str(&table);
        if self.rows().any(|point| point.mean.is_none()) {
            let _ = writeln!(text, "\nA mean is - where no completed cycle has {}.", self.column);
        }
        text
    }

    fn rows(&self) -> impl Iterator<Item = &SweptPoint> {
        self.base.iter().chain(&self.points)
    }

    /// The table, and whether its head has numbers of keys.
    fn narrow_table(&self, factor: f64) -> (bool, String) {
        let laid_out = |(numbered, longest)| (numbered, self.table(factor, numbered, longest));
        let is_narrow = |text: &str| text.lines().all(|line| line.chars().count() <= WIDEST);
        let mut table = laid_out(LAYOUTS[0]);
        for layout in &LAYOUTS[1..] {
            if is_narrow(&table.1) {
                break;
            }
            table = laid_out(*layout);
        }
        table
    }

    fn table(&self, factor: f64, is_numbered: bool, longest: usize) -> String {
        let half = |ci95: [f64; 2]| factor * (ci95[1] - ci95[0]) / 2.0;
        let digits_of = |intervals: &dyn Fn(&SweptPoint) -> Option<[f64; 2]>| {
            let widths = self.rows().filter_map(intervals).map(half).filter(|width| *width > 0.0);
            decimals_for(widths.fold(f64::INFINITY, f64::min))
        };
        let (of_mean, of_change) = (digits_of(&|p| p.ci95), digits_of(&|p| p.difference_ci95));
        let known = |number: Option<String>| number.unwrap_or_else(|| "-".to_owned());
        let cells = |point: &SweptPoint| -> Vec<String> {
            let value = |key: &String| {
                let mut value = shown(&point.values[key]);
                if let Some((end, _)) = value.char_indices().nth(longest) {
                    value.truncate(end);
                    value.push('…');
                }
                value
            };
            let mean = |mean: f64| format!("{:.of_mean$}", factor * mean);
            let change = |change: f64| format!("{:+.of_change$}", factor * change);
            let relative = |share: f64| format!("{:+.2}", 100.0 * share);
            let of_point = [
                known(point.mean.map(mean)),
                known(point.ci95.map(|ci95| format!("{:.of_mean$}", half(ci95)))),
                known(point.difference.map(change)),
                known(point.difference_ci95.map(|ci95| format!("{:.of_change$}", half(ci95)))),
                known(point.relative_difference.map(relative)),
                percent(point.share_not_completed),
            ];
            self.keys.iter().map(value).chain(of_point).collect()
        };
        let mut rows: Vec<Vec<String>> = self.rows().map(cells).collect();
        if let (Some(_), Some(first)) = (&self.base, rows.first_mut()) {
            "the study".clone_into(&mut first[0]);
        }
        let name = |(k, key): (usize, &String)| {
            if is_numbered { number_name(k) } else { short_name(key, &self.keys) }
        };
        let names: Vec<String> = self.keys.iter().enumerate().map(name).collect();
        let head: Vec<&str> = names.iter().map(String::as_str).chain(HEAD).collect();
        let wide = |column: usize| {
            let cells = rows.iter().map(|row| row[column].chars().count());
            let widest = cells.chain([head[column].chars().count()]).max().unwrap_or(0);
            widest + if column == 0 { 0 } else { 2 }
        };
        let widths: Vec<usize> = (0..head.len()).map(wide).collect();
        table(&widths, &head, rows)
    }

    /// Writes the table as CSV: the keys, then what each point takes, in the unit of the column.
    /// Where the points are compared with the study, it is the first row, its keys empty.
    ///
    /// # Errors
    /// Whatever the writer gives.
    pub fn write_csv(&self, out: &mut impl io::Write) -> io::Result<()> {
        let keys: Vec<String> = self.keys.iter().map(|key| quoted(key)).collect();
        writeln!(out, "{},{COLUMNS}", keys.join(","))?;
        for point in self.rows() {
            for key in &self.keys {
                match &point.values[key] {
                    Value::Number(number) => write!(out, "{number},")?,
                    value => write!(out, "{},", quoted(&shown(value)))?,
                }
            }
            let interval = |ci95: Option<[f64; 2]>| {
                let [low, high] = [0, 1].map(|end| cell(ci95.map(|ci95| ci95[end])));
                format!("{low},{high}")
            };
            let adjusted = point.adjusted;
            writeln!(
                out,
                "{},{},{},{},{},{},{},{},{},{},{},{},{}",
                point.study_hash,
                self.column,
                cell(point.mean),
                interval(point.ci95),
                cell(point.difference),
                interval(point.difference_ci95),
                cell(point.relative_difference),
                cell(adjusted.map(|adjusted| adjusted.difference)),
                interval(adjusted.map(|adjusted| adjusted.ci95)),
                point.pairs.map_or(String::new(), |pairs| pairs.to_string()),
                self.cycles,
                point.not_completed,
                cell(Some(point.share_not_completed)),
            )?;
        }
        Ok(())
    }
}

/// Columns of the table behind those of the keys.
const HEAD: [&str; 6] = ["mean", "± 95 %", "difference", "± 95 %", "%", "failed %"];
