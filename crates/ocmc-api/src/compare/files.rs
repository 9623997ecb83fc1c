//! The files of a comparison: what each study has driven as a run directory, the studies, the
//! values pair by pair, and a page.

use super::CompareAnswer;
use crate::answer::Answer;
use crate::error::Error;
use crate::text::range;
use crate::validate::written;
use ocmc_core::record::Record;
use ocmc_fleet::comparison::paired_values;
use ocmc_fleet::quantity::{NamedQuantity, quantity_of_column};
use ocmc_fleet::run::RunPlan;
use ocmc_fleet::summary::SummaryBuilder;
use ocmc_io::given_drive::GivenDrive;
use ocmc_io::number_text::{grouped, short};
use ocmc_io::records::RecordFormat;
use ocmc_io::report::{ComparisonPage, PairPicture, REPORT, comparison_html};
use ocmc_io::run_directory::{Manifest, RunDirectory, RunSummary, now};
use ocmc_io::study::{LoadedStudy, commented};
use std::fmt::Write;
use std::path::Path;

/// Run of one study.
#[derive(Clone, Debug)]
pub(crate) struct KeptRun {
    manifest: Manifest,
    records: Vec<Record>,
    /// How long it took, in s.
    wall_s: f64,
}

/// The runs of the studies. Of the time that all took each has its share.
pub(crate) fn kept_runs(
    studies: &[(String, &LoadedStudy)],
    plan: &RunPlan,
    fleets: Vec<Vec<Record>>,
    wall_s: f64,
    driven: u64,
) -> Vec<KeptRun> {
    let wall_s = wall_s * plan.cycles as f64 / driven as f64;
    let runs = studies.iter().zip(fleets).map(|((_, loaded), records)| {
        let manifest = Manifest::new(loaded, plan, &GivenDrive::nothing());
        KeptRun { manifest, records, wall_s }
    });
    runs.collect()
}

/// Letter of a study's files: `a`, `b` and so on.
fn letter(study: usize) -> String {
    match u8::try_from(study) {
        Ok(place @ 0..26) => char::from(b'a' + place).to_string(),
        _ => format!("study-{}", study + 1),
    }
}

impl CompareAnswer {
    /// Writes it to a directory, which is made and has to be empty: `comparison.json`, `pairs.csv`
    /// with the values of each cycle, `report.html`, which opens offline, and of each study, the
    /// baseline being `a`, its file (`a.toml`) and the run directory of what it has driven (`a`).
    ///
    /// # Errors
    /// [`Error::NotEmpty`] where something is in it, [`Error::File`] and [`Error::RunDirectory`]
    /// where it cannot be written.
    pub fn save(&self, directory: &Path, format: RecordFormat) -> Result<(), Error> {
        let mut files = vec![
            ("comparison.json".to_owned(), self.to_indented_json()),
            (REPORT.to_owned(), self.page()),
        ];
        files.extend(
            self.quantity().map(|quantity| ("pairs.csv".to_owned(), self.pairs(&quantity))),
        );
        for (k, run) in self.kept.iter().enumerate() {
            files.push((format!("{}.toml", letter(k)), commented(&run.manifest.resolved_study)));
        }
        written(directory, files)?;
        for (k, run) in self.kept.iter().enumerate() {
            let path = directory.join(letter(k));
            let mut fleet =
                SummaryBuilder::new(run.manifest.dependence()).priced(run.manifest.prices());
            fleet.add(&run.records);
            let summary =
                RunSummary::new(&run.manifest, fleet.finish(), run.wall_s, self.plan.threads);
            let mut directory = RunDirectory::create(&path, format, run.manifest.clone())?;
            directory.add(&run.records)?;
            directory.finish(&summary)?;
        }
        Ok(())
    }

    fn quantity(&self) -> Option<NamedQuantity<'_>> {
        let first = self.comparisons.first()?;
        let records = self.kept.iter().filter_map(|run| run.records.first());
        let parts = records.flat_map(|record| record.breakdown.names()).map(String::as_str);
        quantity_of_column(&first.comparison.column, parts)
    }

    /// The values of each cycle in each study, and how they differ from those of the first one.
    fn pairs(&self, quantity: &NamedQuantity) -> String {
        let letters: Vec<String> = (0..self.kept.len()).map(letter).collect();
        let mut text = format!("cycle_id,{}", letters.join(","));
        for letter in &letters[1..] {
            let _ = write!(text, ",{letter}_less_a");
        }
        text.push('\n');
        let cell = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        for row in 0..self.plan.cycles {
            let values: Vec<Option<f64>> = self
                .kept
                .iter()
                .map(|run| quantity.of_cycle(run.records.get(row as usize)?))
                .collect();
            let _ = write!(text, "{}", self.plan.first_cycle + row);
            for value in &values {
                let _ = write!(text, ",{}", cell(*value));
            }
            for value in &values[1..] {
                let change = value.zip(values[0]).map(|(b, a)| b - a);
                let _ = write!(text, ",{}", cell(change));
            }
            text.push('\n');
        }
        text
    }

    fn page(&self) -> String {
        let plan = &self.plan;
        let pairs: Vec<_> = self
            .kept
            .iter()
            .skip(1)
            .map(|other| {
                let pairs =
                    |quantity| paired_values(&quantity, &self.kept[0].records, &other.records);
                self.quantity().map_or_else(Vec::new, pairs)
            })
            .collect();
        let pictures: Vec<PairPicture> = self
            .comparisons
            .iter()
            .zip(&pairs)
            .map(|(compared, pairs)| PairPicture {
                names: [&compared.study_a, &compared.study_b],
                comparison: &compared.comparison,
                cost: compared.cost.as_deref(),
                keys: &compared.differing_keys,
                pairs,
                baseline: &self.kept[0].records,
            })
            .collect();
        let files = (0..self.kept.len()).map(|k| letter(k) + ".toml").collect::<Vec<_>>();
        let mut command = format!("ocmc compare {}{}", files.join(" "), range(plan));
        if let Some(quantity) = self.quantity() {
            let _ = write!(command, " --column {}", quantity.column);
        }
        let last = plan.first_cycle + (plan.cycles - 1);
        let mut facts = vec![
            ("program", format!("ocmc {}", env!("CARGO_PKG_VERSION"))),
            ("seed", plan.seed.to_string()),
            ("cycle ids", format!("{} to {last}", plan.first_cycle)),
            ("driven", format!("{} cycles", grouped(self.driven))),
            ("ended", now()),
            ("took", format!("{} s on {} threads", short(self.wall_s), plan.threads)),
        ];
        if !self.without_fuel.is_empty() {
            let names = self.without_fuel.join(", ");
            facts.push(("note", format!("{names}: no fuel, compared by work at the wheels")));
        }
        comparison_html(&ComparisonPage { facts: &facts, pictures: &pictures, command: &command })
    }
}
