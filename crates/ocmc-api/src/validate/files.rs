//! The files of a validation: tables, pictures and a page.

use super::{ValidateAnswer, ValidatedRoad};
use crate::answer::Answer;
use crate::error::Error;
use crate::text::{cell, quoted};
use ocmc_estimation::validation::ensemble::DriveScore;
use ocmc_io::file_error::FileError;
use ocmc_io::report::{RoadPicture, ValidationPage, validation_html};
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Most roads that get a picture.
const MOST_PICTURES: usize = 40;

/// Checks that a directory, where it is there, is empty.
///
/// # Errors
/// As [`ValidateAnswer::save`].
pub fn check_empty(directory: &Path) -> Result<(), Error> {
    if !directory.exists() {
        return Ok(());
    }
    let mut entries = fs::read_dir(directory).map_err(FileError::read(directory))?;
    match entries.next() {
        Some(_) => Err(Error::NotEmpty(directory.to_owned())),
        None => Ok(()),
    }
}

/// Writes files, by their names, to a directory, which is made and has to be empty.
pub(crate) fn written(directory: &Path, files: Vec<(String, String)>) -> Result<(), Error> {
    fs::create_dir_all(directory).map_err(FileError::create(directory))?;
    check_empty(directory)?;
    for (name, text) in files {
        let path = directory.join(name);
        fs::write(&path, text).map_err(FileError::write(&path))?;
    }
    Ok(())
}

impl ValidateAnswer {
    /// Writes it to a directory, which is made and has to be empty: `validation.json`,
    /// `scores.csv`, `drives.csv`, `speed.csv`, a picture of each road (`speed.svg`, or
    /// `speed-1.svg` and so on), and `report.html`, which opens offline.
    ///
    /// # Errors
    /// [`Error::NotEmpty`] where something is in it, [`Error::File`] where it cannot be written.
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        written(directory, self.files())
    }

    /// The names of the files, and what they hold.
    fn files(&self) -> Vec<(String, String)> {
        let mut files = vec![
            ("validation.json".to_owned(), self.to_indented_json()),
            ("scores.csv".to_owned(), self.scores()),
            ("drives.csv".to_owned(), self.by_drive()),
            ("speed.csv".to_owned(), self.speeds()),
        ];
        for (k, road) in self.roads.iter().enumerate().take(MOST_PICTURES) {
            let name = match self.roads.len() {
                1 => "speed.svg".to_owned(),
                _ => format!("speed-{}.svg", k + 1),
            };
            files.push((name, road.picture.standalone()));
        }
        let scores: Vec<DriveScore> = self.drives.iter().map(|drive| drive.score.clone()).collect();
        let pictures: Vec<RoadPicture> =
            self.roads.iter().map(|road| road.picture.clone()).collect();
        let (title, facts) = (format!("{} over {}", self.study, self.over()), self.facts());
        let circular = self.circle();
        let page = ValidationPage {
            title: &title,
            facts: &facts,
            circular: circular.as_deref(),
            carrier: self.carrier,
            pooled: &self.pooled,
            drives: &scores,
            roads: &pictures,
        };
        files.push(("report.html".to_owned(), validation_html(&page)));
        files
    }

    /// Drives of the validation, in a few words.
    fn over(&self) -> String {
        match (self.roads.as_slice(), self.drives.as_slice()) {
            ([only], _) => only.name.clone(),
            (several, _) => format!("{} roads", several.len()),
        }
    }

    /// A row a quantity.
    fn scores(&self) -> String {
        let mut text = "quantity,n,mean_error,rmse,crps,coverage50,coverage50_error,coverage90,\
                        coverage90_error,ks_distance,ks_p\n"
            .to_owned();
        for pooled in &self.pooled {
            let (distance, p) = pooled.uniform.map(|u| (u.distance, u.p)).unzip();
            let numbers = [
                Some(pooled.mean_error),
                Some(pooled.rmse),
                Some(pooled.crps),
                Some(pooled.coverage50),
                pooled.coverage50_error,
                Some(pooled.coverage90),
                pooled.coverage90_error,
                distance,
                p,
            ];
            let numbers = numbers.map(cell).join(",");
            let _ = writeln!(text, "{},{},{numbers}", pooled.quantity, pooled.n);
        }
        text
    }

    /// A row a drive and quantity.
    fn by_drive(&self) -> String {
        let mut text = "drive,road,from_m,to_m,circular,quantity,measured,simulated,p5,p25,p75,\
                        p95,crps,pit\n"
            .to_owned();
        for drive in &self.drives {
            let score = &drive.score;
            let name = quoted(&score.drive);
            let road = quoted(&self.roads[drive.road].name);
            let circular = drive.circular.join(" ");
            for (quantity, value) in &score.values {
                let ([p25, p75], [p5, p95]) = (value.band50, value.band90);
                let numbers =
                    [value.measured, value.simulated, p5, p25, p75, p95, value.crps, value.pit];
                let numbers = numbers.map(|number| cell(Some(number))).join(",");
                let _ = writeln!(
                    text,
                    "{name},{road},{:?},{:?},{circular},{},{numbers}",
                    score.from_m,
                    score.to_m,
                    quantity.name()
                );
            }
        }
        text
    }

    /// A row a place.
    fn speeds(&self) -> String {
        let mut text =
            "road,position_m,limit_mps,p5_mps,p25_mps,p50_mps,p75_mps,p95_mps,drive,measured_mps\n"
                .to_owned();
        for road in &self.roads {
            let ValidatedRoad { position_m, limit_mps, p5_mps, p25_mps, .. } = road;
            let ValidatedRoad { p50_mps, p75_mps, p95_mps, .. } = road;
            let columns = [position_m, limit_mps, p5_mps, p25_mps, p50_mps, p75_mps, p95_mps];
            let name = quoted(&road.name);
            let mut rows = |drive: &str, measured: Option<&[f64]>| {
                for k in 0..position_m.len() {
                    let numbers = columns.map(|column| cell(Some(column[k]))).join(",");
                    let measured = cell(measured.map(|speeds| speeds[k]));
                    let _ = writeln!(text, "{name},{numbers},{drive},{measured}");
                }
            };
            if road.measured_mps.is_empty() {
                rows("", None);
            }
            for (drive, speeds) in &road.measured_mps {
                rows(&quoted(drive), Some(speeds));
            }
        }
        text
    }
}
