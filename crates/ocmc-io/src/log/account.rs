//! What has to be said of a log that was read: where a drive stands, and what is odd.

use super::{LogFile, LoggedDrive};
use crate::number_text::grouped;

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
