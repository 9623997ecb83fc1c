//! The files of an answer about judged numbers: the studies, the table, and a page.

use super::DoubtAnswer;
use crate::answer::Answer;
use crate::error::Error;
use crate::text::{cell, range};
use crate::validate::written;
use ocmc_fleet::doubt::Change;
use ocmc_fleet::run::RunPlan;
use ocmc_io::number_text::{grouped, short};
use ocmc_io::report::{DoubtBar, DoubtPage, REPORT, doubt_html};
use ocmc_io::run_directory::now;
use ocmc_io::study::commented;
use std::fmt::Write;
use std::path::Path;

/// The studies and the plan that the files are made from.
#[derive(Clone, Debug)]
pub(crate) struct KeptStudies {
    pub(crate) plan: RunPlan,
    pub(crate) column: Option<String>,
    /// The resolved studies.
    pub(crate) resolved: Vec<String>,
}

impl DoubtAnswer {
    /// Writes it to a directory, which is made and has to be empty: `doubt.json`, `doubt.csv` with
    /// a row an entry, the studies, and `report.html`, which opens offline.
    ///
    /// # Errors
    /// [`Error::NotEmpty`] where something is in it, [`Error::File`] where it cannot be written.
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        let mut files = vec![
            ("doubt.json".to_owned(), self.to_indented_json()),
            ("doubt.csv".to_owned(), self.table()),
            (REPORT.to_owned(), self.page()),
        ];
        for (name, resolved) in ["study.toml", "against.toml"].iter().zip(&self.kept.resolved) {
            files.push(((*name).to_owned(), commented(resolved)));
        }
        written(directory, files)
    }

    /// A row an entry, a column a change and its standard error.
    fn table(&self) -> String {
        let mut head =
            "name,standing,replaced_by,cycles,effect_mean,effect_sd,effect_p95,share".to_owned();
        for what in ["mean", "sd", "p95"] {
            for end in ["low", "high"] {
                let _ = write!(head, ",{what}_{end},{what}_{end}_standard_error");
            }
        }
        let mut text = head + "\n";
        for entry in &self.numbers {
            let cycles = entry.low.or(entry.high).map_or(0, |changes| changes.cycles);
            let effect = entry.effect;
            let _ = write!(
                text,
                "{},{},{},{cycles},{:?},{:?},{:?},{:?}",
                entry.name,
                entry.standing,
                entry.replaced_by.unwrap_or_default(),
                effect.mean,
                effect.sd,
                effect.p95,
                entry.share
            );
            for what in
                [|c| c.mean, |c| c.sd, |c| c.p95] as [fn(&ocmc_fleet::doubt::Changes) -> Change; 3]
            {
                for end in [&entry.low, &entry.high] {
                    let change = end.as_ref().map(what);
                    let error = change.and_then(|change| change.standard_error);
                    let _ = write!(text, ",{},{}", cell(change.map(|c| c.by)), cell(error));
                }
            }
            text.push('\n');
        }
        text
    }

    fn page(&self) -> String {
        let plan = &self.kept.plan;
        let mut command = format!("ocmc doubt --study study.toml{}", range(plan));
        if self.against.is_some() {
            command.push_str(" --against against.toml");
        }
        if let Some(column) = &self.kept.column {
            let _ = write!(command, " --column {column}");
        }
        let mut facts = vec![
            ("program", format!("ocmc {}", env!("CARGO_PKG_VERSION"))),
            ("hash of the study", self.study_hash.clone()),
        ];
        if let Some([_, hash]) = &self.against {
            facts.push(("hash of the other", hash.clone()));
        }
        facts.extend([
            ("seed", self.seed.to_string()),
            ("driven", format!("{} cycles", grouped(self.driven))),
            ("ended", now()),
            ("took", format!("{} s on {} threads", short(self.wall_s), self.threads)),
        ]);
        let bars = self.numbers.iter().map(|entry| DoubtBar {
            name: &entry.name,
            reason: &entry.reason,
            replaced_by: entry.replaced_by,
            ends: [&entry.low, &entry.high].map(|end| end.as_ref().map(|changes| changes.mean.by)),
            share: entry.share,
        });
        doubt_html(&DoubtPage {
            study: &self.study,
            against: self.against.as_ref().map(|[name, _]| name.as_str()),
            column: self.column,
            mean: self.is.map(|is| is.mean),
            together: self.together.mean,
            bars: &bars.collect::<Vec<_>>(),
            facts: &facts,
            command: &command,
        })
    }
}
