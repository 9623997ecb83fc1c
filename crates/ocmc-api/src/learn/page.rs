//! The page of what was learnt.

use super::LearnAnswer;
use crate::answer::Answer;
use crate::error::Error;
use ocmc_io::file_error::FileError;
use ocmc_io::report::{LearnPage, learn_html};
use std::fs;
use std::path::Path;

impl LearnAnswer {
    /// Writes the page: one HTML file that opens offline.
    ///
    /// # Errors
    /// [`Error::File`] where it cannot be written.
    pub fn save_page(&self, path: &Path) -> Result<(), Error> {
        Ok(fs::write(path, self.page()).map_err(FileError::write(path))?)
    }

    fn page(&self) -> String {
        let text = self.text();
        let held = self.held_back.as_ref();
        let trips = held.map_or(&[][..], |held| &held.trips);
        let points: Vec<[f64; 4]> = trips
            .iter()
            .map(|trip| [trip.expected, trip.measured, trip.interval90[0], trip.interval90[1]])
            .collect();
        let standings: Vec<[String; 3]> = self
            .replaced
            .iter()
            .map(|number| {
                [number.key.clone(), number.name.replace('_', " "), number.standing.clone()]
            })
            .collect();
        let accounts = self.notes();
        learn_html(&LearnPage {
            study: &self.doubt[1].study,
            column: held.map_or("", |held| &held.column),
            text: &text,
            points: &points,
            standings: &standings,
            accounts: &accounts,
        })
    }
}
