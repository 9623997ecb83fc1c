//! Rows of a log on their way into drives: rows with the same labels are of one drive.

use super::LoggedTrip;
use crate::table::{Column, Quantity};
use arrow_array::Float64Array;
use std::collections::BTreeMap;
use std::path::Path;

/// Drives whose rows are being read.
pub(super) struct Trips {
    /// What stands for a label that is not there.
    name: String,
    known: BTreeMap<[String; 3], usize>,
    found: Vec<LoggedTrip>,
    /// Values of each drive, by the place of their quantity.
    values: Vec<Vec<Vec<f64>>>,
}

impl Trips {
    /// No drives yet, of a file that lends them its name.
    pub(super) fn new(path: &Path) -> Self {
        Self { name: stem(path), known: BTreeMap::new(), found: Vec::new(), values: Vec::new() }
    }

    /// Place of the drive with these labels: driver, drive, event.
    pub(super) fn place(&mut self, labels: [String; 3]) -> usize {
        *self.known.entry(labels).or_insert_with_key(|[driver, drive, event]| {
            let or_name =
                |text: &String| if text.is_empty() { self.name.clone() } else { text.clone() };
            self.found.push(LoggedTrip {
                driver: or_name(driver),
                drive: or_name(drive),
                event: (!event.is_empty()).then(|| event.clone()),
                columns: BTreeMap::new(),
                words: BTreeMap::new(),
            });
            self.values.push(Vec::new());
            self.found.len() - 1
        })
    }

    /// Adds the next value of a quantity to a drive.
    pub(super) fn push(&mut self, drive: usize, quantity: usize, value: f64) {
        let values = &mut self.values[drive];
        if values.len() <= quantity {
            values.resize_with(quantity + 1, Vec::new);
        }
        values[quantity].push(value);
    }

    /// Adds the next word of a column to a drive.
    pub(super) fn push_word(&mut self, drive: usize, which: Quantity, word: &str) {
        self.found[drive].words.entry(which).or_default().push(word);
    }

    /// The drives with the values that were added, or with whole columns that stand for them.
    pub(super) fn finish(
        self,
        columns: &[Column],
        whole: &[Option<Float64Array>],
    ) -> Vec<LoggedTrip> {
        let mut drives = self.found;
        for (drive, mut values) in drives.iter_mut().zip(self.values) {
            values.resize_with(columns.len(), Vec::new);
            let arrays = values.into_iter().zip(whole);
            let arrays =
                arrays.map(|(values, whole)| whole.clone().unwrap_or_else(|| values.into()));
            drive.columns = columns.iter().map(|column| column.quantity).zip(arrays).collect();
        }
        drives
    }
}

/// The name of a file without its extensions.
fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let name = name.trim_end_matches(".gz").trim_end_matches(".zst");
    name.trim_end_matches(".parquet").trim_end_matches(".csv").to_owned()
}
