//! The files of a sensitivity analysis: the study, what each cycle of the design gave, and a page.

use super::SensitivityAnswer;
use crate::answer::Answer;
use crate::error::Error;
use crate::text::range;
use crate::validate::written;
use ocmc_fleet::run::RunPlan;
use ocmc_fleet::sensitivity::{Design, Over};
use ocmc_io::number_text::{grouped, short};
use ocmc_io::report::{REPORT, SensitivityPage, sensitivity_html};
use ocmc_io::run_directory::now;
use ocmc_io::study::commented;
use std::fmt::Write;
use std::path::Path;

/// Sources of the files of an analysis.
#[derive(Clone, Debug)]
pub(crate) struct KeptDesign {
    pub(crate) design: Design,
    /// The resolved study.
    pub(crate) resolved: String,
    pub(crate) plan: RunPlan,
    pub(crate) factors: Option<Vec<String>>,
    pub(crate) crossed: Option<u64>,
}

impl SensitivityAnswer {
    /// Writes it to a directory, which is made and has to be empty: `sensitivity.json`,
    /// `design.csv` with what each cycle of the design gave, `study.toml`, and `report.html`, which
    /// opens offline.
    ///
    /// # Errors
    /// [`Error::NotEmpty`] where something is in it, [`Error::File`] where it cannot be written.
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        let files = [
            ("sensitivity.json", self.to_indented_json()),
            ("design.csv", self.design()),
            ("study.toml", commented(&self.kept.resolved)),
            (REPORT, self.page()),
        ];
        written(directory, files.map(|(name, text)| (name.to_owned(), text)).into())
    }

    /// A row a row of the design, a column a sample.
    fn design(&self) -> String {
        let Design { columns, first_row, values } = &self.kept.design;
        let row_id = match self.sensitivity.over {
            Over::Trip => "cycle_id",
            Over::Truck => "truck_id",
        };
        let mut text = format!("{row_id},{}\n", columns.join(","));
        for row in 0..values.first().map_or(0, Vec::len) {
            let _ = write!(text, "{}", first_row + row as u64);
            for column in values {
                let value = column[row].map_or(String::new(), |value| value.to_string());
                let _ = write!(text, ",{value}");
            }
            text.push('\n');
        }
        text
    }

    fn page(&self) -> String {
        let KeptDesign { plan, factors, crossed, .. } = &self.kept;
        let shares = &self.sensitivity;
        let mut command = format!(
            "ocmc sensitivity --study study.toml{} --column {}",
            range(plan),
            shares.column
        );
        if let Some(factors) = factors {
            let _ = write!(command, " --factor {}", factors.join(","));
        }
        if shares.over == Over::Truck {
            command.push_str(" --over truck");
        }
        if let Some(crossed) = crossed {
            let _ = write!(command, " --crossed {crossed}");
        }
        if self.shapley.is_some() {
            command.push_str(" --shapley");
        }
        let driven = shares.cycles + self.shapley.as_ref().map_or(0, |effects| effects.cycles);
        let mut facts = vec![
            ("program", format!("ocmc {}", env!("CARGO_PKG_VERSION"))),
            ("hash of the study", self.study_hash.clone()),
            ("seed", self.seed.to_string()),
            ("rows", grouped(shares.rows)),
            ("rows that were dropped", grouped(shares.dropped_rows)),
            ("driven", format!("{} cycles", grouped(driven))),
            ("ended", now()),
            ("took", format!("{} s on {} threads", short(self.wall_s), self.threads)),
        ];
        if let Some(replicates) = shares.replicates {
            facts.push(("replicates of uncertain parameters", grouped(replicates)));
        }
        sensitivity_html(&SensitivityPage {
            study: &self.study,
            sensitivity: shares,
            shapley: self.shapley.as_ref(),
            two_way: self.two_way.as_ref(),
            facts: &facts,
            command: &command,
        })
    }
}
