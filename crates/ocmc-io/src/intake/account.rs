//! The account of a file: rows, what each column was taken for, what was left out, and what the
//! checks found.

use super::{End, Finding};
use crate::intake::table::TableError;
use crate::intake::table::error::Fault;
use crate::number_text::count_of;
use serde::Serialize;
use std::path::Path;

/// A column, and the quantity that it was taken for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReadColumn {
    /// Its name in the file.
    pub name: String,
    /// The quantity, as the vocabulary calls it.
    pub quantity: &'static str,
    /// The suffix of its unit; empty where there is none.
    pub unit: &'static str,
}

/// The account of what was read of a file, and of what is odd in it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FileAccount {
    /// The file, or what a table is called.
    pub file: String,
    /// Rows.
    pub rows: usize,
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

    /// A few lines on rows and columns, then on what was mended.
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
            "`{file}`: {}, columns {}",
            count_of(self.rows as u64, "row"),
            columns.join(", ")
        );
        if !self.left_out.is_empty() {
            told.push_str("; not used: `");
            told.push_str(&self.left_out.join("`, `"));
            told.push('`');
        }
        let mended = self.findings.iter().filter(|finding| finding.end == End::Mended);
        std::iter::once(told).chain(mended.map(|finding| format!("`{file}`: {finding}"))).collect()
    }

    /// Warnings of the checks.
    pub fn warnings(&self) -> Vec<String> {
        let file = &self.file;
        let warned = self.findings.iter().filter(|finding| finding.end == End::Warned);
        warned.map(|finding| format!("`{file}`: {finding}")).collect()
    }
}
