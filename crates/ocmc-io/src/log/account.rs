//! What has to be said of a log that was read: where a drive stands, and what is odd.

use super::{LogFile, LoggedDrive};
use crate::number_text::grouped;
use ocmc_core::log::signal::LogCounts;

/// What there is of something at a place, each with its number.
pub(crate) fn counted<const N: usize>(place: &str, counts: [(usize, &str); N]) -> Vec<String> {
    let some = counts.into_iter().filter(|(count, _)| *count > 0);
    some.map(|(count, what)| format!("{place}: {} {what}", grouped(count as u64))).collect()
}

/// Rows that are not used, or doubtful.
pub(crate) fn row_notes(place: &str, rows: &LogCounts) -> Vec<String> {
    let reversing = if rows.reversing > rows.used {
        "rows in reverse are not used: is the sign of the speed right?"
    } else {
        "rows in reverse are not used"
    };
    counted(
        place,
        [
            (rows.missing_time, "rows without time are not used"),
            (rows.missing_speed, "rows without speed are not used"),
            (rows.repeated_time, "rows with the time of the row before are not used"),
            (rows.reversing, reversing),
            (rows.implausible_speed, "rows are faster than 70 m/s: is the unit right?"),
        ],
    )
}

impl LogFile {
    /// Where a drive stands.
    pub fn place(&self, drive: &LoggedDrive) -> String {
        let path = self.path.display();
        if self.drives.len() == 1 {
            return format!("`{path}`");
        }
        match &drive.event {
            Some(event) => format!("drive `{}`, event `{event}` of `{path}`", drive.drive),
            None => format!("drive `{}` of `{path}`", drive.drive),
        }
    }

    /// What is odd in it.
    pub fn warnings(&self) -> Vec<String> {
        let path = self.path.display();
        let mut warnings = Vec::new();
        if self.ragged_rows > 0 {
            let (ragged, rows) = (grouped(self.ragged_rows as u64), grouped(self.rows as u64));
            warnings.push(format!(
                "{ragged} of {rows} rows of `{path}` have too few or too many cells: what is there is used"
            ));
        }
        for cells in &self.unreadable {
            warnings.push(format!(
                "{} cells of `{}` in `{path}` are no numbers, first `{}` in {}: they count as missing",
                grouped(cells.cells as u64),
                cells.column,
                cells.text,
                cells.place
            ));
        }
        warnings
    }
}
