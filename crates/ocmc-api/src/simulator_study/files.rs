//! The files of the study: tables, pictures and a page.

use super::SimulatorStudyAnswer;
use crate::answer::Answer;
use crate::error::Error;
use crate::text::cell;
use crate::validate::written;
use ocmc_io::report::{DriveSeries, SimulatorPage, pictures, simulator_html};
use std::fmt::Write;
use std::path::Path;

impl SimulatorStudyAnswer {
    /// Writes it to a directory, which is made and has to be empty: `simulator-study.json`, the
    /// tables `compared.csv`, `anova.csv`, `curves.csv`, `accelerations.csv`, `gains.csv` and
    /// `events.csv`, the pictures, and `report.html`, which opens offline.
    ///
    /// # Errors
    /// [`Error::NotEmpty`] where something is in it, [`Error::File`] where it cannot be written.
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        written(directory, self.files())
    }

    /// The names of the files, and what they hold.
    fn files(&self) -> Vec<(String, String)> {
        let mut files: Vec<(String, String)> = [
            ("simulator-study.json", self.to_indented_json()),
            ("compared.csv", self.compared_csv()),
            ("anova.csv", self.anova_csv()),
            ("curves.csv", self.curves_csv()),
            ("accelerations.csv", self.accelerations_csv()),
        ]
        .map(|(name, text)| (name.to_owned(), text))
        .into();
        if !self.events.is_empty() {
            files.push(("gains.csv".to_owned(), self.gains_csv()));
            files.push(("events.csv".to_owned(), self.events_csv()));
        }
        let pictures = pictures(&self.first);
        files.extend(
            pictures.iter().map(|picture| (format!("{}.svg", picture.name), picture.standalone())),
        );
        let facts = self.facts();
        let page = SimulatorPage {
            title: &self.study,
            facts: &facts,
            compared: &self.compared,
            anova: &self.curve_speed.anova,
            pictures: &pictures,
        };
        files.push(("report.html".to_owned(), simulator_html(&page)));
        files
    }

    /// A row a number of the paper.
    fn compared_csv(&self) -> String {
        let mut text = "table,quantity,paper,median,p5,p95,n\n".to_owned();
        for row in &self.compared {
            let numbers = [Some(row.paper), row.median, row.p5, row.p95].map(cell).join(",");
            let _ = writeln!(text, "\"{}\",\"{}\",{numbers},{}", row.table, row.quantity, row.n);
        }
        text
    }

    /// A row a term, of the first repetition.
    fn anova_csv(&self) -> String {
        let mut text = "term,df,sum_sq,mean_sq,f,p\n".to_owned();
        for row in &self.curve_speed.anova {
            let numbers = [Some(row.sum_sq), Some(row.mean_sq), row.f, row.p].map(cell).join(",");
            let _ = writeln!(text, "{},{},{numbers}", row.term, row.df);
        }
        text
    }

    /// A row a curve, as `ocmc fit curve-speed` reads it.
    fn curves_csv(&self) -> String {
        let mut text = "repetition,driver,direction,radius_m,speed_mps\n".to_owned();
        for curve in &self.curves {
            let direction = if curve.left { "left" } else { "right" };
            let (radius_m, speed_mps) = (curve.radius_m, curve.speed_mps);
            let _ = writeln!(
                text,
                "{},{},{direction},{radius_m:?},{speed_mps:?}",
                curve.repetition, curve.driver
            );
        }
        text
    }

    /// A row a change, as `ocmc fit speed-change` reads it.
    fn accelerations_csv(&self) -> String {
        let mut text = "repetition,driver,category,acceleration_mps2\n".to_owned();
        for change in &self.changes {
            let _ = writeln!(
                text,
                "{},{},{},{:?}",
                change.repetition, change.driver, change.change, change.acceleration_mps2
            );
        }
        text
    }

    /// A row a slope.
    fn gains_csv(&self) -> String {
        let mut text = "driver,event,kp,ki,kd,set_speed_mps,at_bound,true_kp,true_ki,true_kd,\
                        wanted_mps\n"
            .to_owned();
        for event in &self.events {
            let gains = event.gains.map(|gain| cell(Some(gain))).join(",");
            let truth = event.true_gains.map(|gain| cell(Some(gain))).join(",");
            let _ = writeln!(
                text,
                "{},{},{gains},{:?},{},{truth},{:?}",
                event.driver,
                event.event,
                event.set_speed_mps,
                event.at_bound.join(" "),
                event.wanted_mps
            );
        }
        text
    }

    /// A row a step of each slope, recorded and simulated.
    fn events_csv(&self) -> String {
        let mut text = "driver,event,source,position_m,speed_mps,accelerator,brake\n".to_owned();
        for event in &self.events {
            let mut rows = |source: &str, series: &DriveSeries| {
                for (k, position_m) in series.position_m.iter().enumerate() {
                    let signals = [&series.speed_mps, &series.accelerator, &series.brake];
                    let signals = signals.map(|signal| format!("{:.5}", signal[k])).join(",");
                    let (driver, name) = (event.driver, &event.event);
                    let _ = writeln!(text, "{driver},{name},{source},{position_m:.3},{signals}");
                }
            };
            rows("recorded", &event.recorded);
            rows("simulated", &event.simulated);
        }
        text
    }
}
