//! The account of a file: rows, what each column was taken for, what was left out, and what the
//! checks found.

use super::{End, Finding};
use crate::intake::table::TableError;
use crate::intake::table::error::Fault;
use crate::number_text::{count_of, rounded};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Most files whose columns are told one by one.
const MOST_TOLD: usize = 5;

/// A column, and the quantity that it was taken for.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ReadColumn {
    /// Its name in the file.
    pub name: String,
    /// The quantity, as the vocabulary calls it.
    pub quantity: &'static str,
    /// The suffix of its unit; empty where there is none.
    pub unit: &'static str,
}

/// How long what was read is, and how densely it was sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Extent {
    /// Length, in m, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_m: Option<f64>,
    /// From the first row to the last, in s, where there is a time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duration_s: Option<f64>,
    /// Median step of the time, in s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval_s: Option<f64>,
    /// Median step of the position, in m, of what has no time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval_m: Option<f64>,
    /// Steps of the time that are more than 2.5 times the median one, and more than 2 s.
    pub gaps: usize,
    /// The longest of these, in s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub longest_gap_s: Option<f64>,
}

impl Extent {
    /// Extent of drives over time, each with its times in s and its speeds in m/s, where it has
    /// some.
    pub fn of_drives<'a>(drives: impl Iterator<Item = (&'a [f64], Option<&'a [f64]>)>) -> Self {
        let mut steps = DriveSteps::default();
        drives.for_each(|(time_s, speed_mps)| steps.add(time_s, speed_mps));
        steps.extent()
    }

    /// Extent of positions along a road, in m.
    pub fn of_way(position_m: &[f64]) -> Self {
        let mut steps_m: Vec<f64> = position_m.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let length_m = position_m.last().zip(position_m.first()).map(|(last, first)| last - first);
        Self { length_m, interval_m: median(&mut steps_m), ..Self::default() }
    }

    fn told(&self) -> String {
        let mut parts = Vec::new();
        if let Some(interval_s) = self.interval_s {
            parts.push(format!("every {} s", rounded(interval_s)));
        }
        if let Some(interval_m) = self.interval_m {
            parts.push(format!("every {} m", rounded(interval_m)));
        }
        if let Some(length_m) = self.length_m {
            parts.push(format!("{} km", rounded(length_m / 1000.0)));
        }
        if let Some(duration_s) = self.duration_s {
            let minutes = duration_s / 60.0;
            parts.push(if minutes < 120.0 {
                format!("{} min", rounded(minutes))
            } else {
                format!("{} h", rounded(minutes / 60.0))
            });
        }
        if let Some(longest_s) = self.longest_gap_s {
            let gaps = count_of(self.gaps as u64, "gap");
            parts.push(format!("{gaps}, the longest {} s", rounded(longest_s)));
        }
        if parts.is_empty() { String::new() } else { format!(" ({})", parts.join(", ")) }
    }
}

/// The steps of drives over time.
#[derive(Clone, Debug, Default)]
pub(crate) struct DriveSteps {
    /// How many there are of each, in µs: drives of any length have few.
    counts: BTreeMap<u64, usize>,
    duration_s: f64,
    length_m: f64,
    has_speed: bool,
}

impl DriveSteps {
    /// Adds a drive: its times in s, and its speeds in m/s, where it has some.
    pub(crate) fn add(&mut self, time_s: &[f64], speed_mps: Option<&[f64]>) {
        let steps_s = time_s.windows(2).map(|pair| pair[1] - pair[0]);
        if let Some(speed_mps) = speed_mps {
            self.has_speed = true;
            let means = speed_mps.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
            let ways = means.zip(steps_s.clone()).map(|(mps, step_s)| mps * step_s);
            self.length_m += ways.filter(|way_m| way_m.is_finite()).sum::<f64>();
        }
        for step_s in steps_s.filter(|step_s| *step_s > 0.0 && step_s.is_finite()) {
            self.duration_s += step_s;
            *self.counts.entry((1e6 * step_s).round() as u64).or_insert(0) += 1;
        }
    }

    /// Sums up the steps.
    pub(crate) fn extent(&self) -> Extent {
        let all: usize = self.counts.values().sum();
        let mut below = 0;
        let interval_us = self.counts.iter().find_map(|(step_us, count)| {
            below += count;
            (below > all / 2).then_some(*step_us)
        });
        let Some(interval_s) = interval_us.map(|us| us as f64 / 1e6) else {
            return Extent::default();
        };
        let steps = self.counts.iter().map(|(us, count)| (*us as f64 / 1e6, *count));
        let mut gaps = steps.filter(|(step_s, _)| *step_s > (2.5 * interval_s).max(2.05));
        Extent {
            length_m: self.has_speed.then_some(self.length_m),
            duration_s: Some(self.duration_s),
            interval_s: Some(interval_s),
            interval_m: None,
            gaps: gaps.clone().map(|(_, count)| count).sum(),
            longest_gap_s: gaps.next_back().map(|(step_s, _)| step_s),
        }
    }
}

/// The median of some numbers, which are sorted.
fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// The account of what was read of a file, and of what is odd in it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct FileAccount {
    /// The file, or what a table is called.
    pub file: String,
    /// Rows.
    pub rows: usize,
    /// How long it is, and how densely sampled.
    pub extent: Extent,
    /// The columns, as they were taken.
    pub columns: Vec<ReadColumn>,
    /// Columns that were left out.
    pub left_out: Vec<String>,
    /// Findings of the checks.
    pub findings: Vec<Finding>,
}

impl FileAccount {
    /// Takes up what checks found.
    ///
    /// # Errors
    /// [`Fault::Check`] with the first finding that refuses the file.
    pub fn judged(
        &mut self,
        path: &Path,
        findings: impl IntoIterator<Item = Finding>,
    ) -> Result<(), TableError> {
        for finding in findings {
            if finding.end == End::Refused {
                return Err(TableError::of(path, Fault::Check(finding)));
            }
            self.findings.push(finding);
        }
        Ok(())
    }

    /// Whether the name of the column of slopes has a unit.
    pub(crate) fn has_slope_with_unit(&self) -> bool {
        self.columns.iter().any(|c| c.quantity.starts_with("grad") && !c.unit.is_empty())
    }

    /// A few lines on rows and columns, then on what was mended or is worth knowing.
    pub fn told(&self) -> Vec<String> {
        if self.columns.is_empty() {
            return Vec::new();
        }
        let file = &self.file;
        let column = |column: &ReadColumn| {
            let ReadColumn { name, quantity, unit } = column;
            // a name of the vocabulary speaks for itself
            let spelt = if unit.is_empty() {
                quantity == name
            } else {
                *name == format!("{quantity}_{unit}")
            };
            if spelt {
                format!("`{name}`")
            } else if unit.is_empty() {
                format!("`{name}` as {quantity}")
            } else {
                format!("`{name}` as {quantity} in {unit}")
            }
        };
        let columns: Vec<String> = self.columns.iter().map(column).collect();
        let mut told = format!(
            "`{file}`: {}{}, columns {}",
            count_of(self.rows as u64, "row"),
            self.extent.told(),
            columns.join(", ")
        );
        if !self.left_out.is_empty() {
            told.push_str("; not used: `");
            told.push_str(&self.left_out.join("`, `"));
            told.push('`');
        }
        let mended = |finding: &&Finding| matches!(finding.end, End::Mended | End::Noted);
        let mended = self.findings.iter().filter(mended);
        std::iter::once(told).chain(mended.map(|finding| format!("`{file}`: {finding}"))).collect()
    }

    /// The lines of several files: of many only what was mended in them.
    pub fn told_of(accounts: &[Self]) -> Vec<String> {
        if accounts.len() <= MOST_TOLD {
            return accounts.iter().flat_map(Self::told).collect();
        }
        let rows: usize = accounts.iter().map(|account| account.rows).sum();
        let files = count_of(accounts.len() as u64, "file");
        let first = format!("{files}, {}: the first one is", count_of(rows as u64, "row"));
        let mended = accounts.iter().skip(1).flat_map(|account| account.told().into_iter().skip(1));
        std::iter::once(first).chain(accounts[0].told()).chain(mended).collect()
    }

    /// Warnings of the checks.
    pub fn warnings(&self) -> Vec<String> {
        let file = &self.file;
        let warned = self.findings.iter().filter(|finding| finding.end == End::Warned);
        warned.map(|finding| format!("`{file}`: {finding}")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extents_of_drives_and_ways() {
        let time_s = [0.0, 1.0, 2.0, 12.0, 13.0];
        let drive = (&time_s[..], Some(&[10.0; 5][..]));
        let extent = Extent::of_drives([drive].into_iter());
        assert_eq!((extent.length_m, extent.duration_s), (Some(130.0), Some(13.0)));
        assert_eq!((extent.gaps, extent.longest_gap_s), (1, Some(10.0)));
        assert_eq!(
            extent.told(),
            " (every 1.000 s, 0.1300 km, 0.2167 min, 1 gap, the longest 10.00 s)"
        );
        let way = Extent::of_way(&[5.0, 15.0, 25.0, 1005.0]);
        assert_eq!((way.length_m, way.interval_m), (Some(1000.0), Some(10.0)));
        assert_eq!(Extent::of_drives([].into_iter()), Extent::default());
    }
}
