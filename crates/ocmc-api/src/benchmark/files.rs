//! The files of an answer: the answer, its trips and a page.

use super::text::of_level;
use super::{BenchmarkAnswer, BenchmarkMember};
use crate::answer::Answer;
use crate::error::Error;
use crate::validate::written;
use ocmc_io::label::label;
use ocmc_io::number_text::{grouped, short};
use ocmc_io::report::{BenchmarkBar, BenchmarkPage, BenchmarkRanking, REPORT, benchmark_html};
use ocmc_io::run_directory::now;
use std::fmt::Write;
use std::path::Path;

impl BenchmarkAnswer {
    /// Writes it to a directory, which is made and has to be empty: `benchmark.json`, `trips.csv`
    /// with what was measured and expected of each trip, and `report.html`, which opens offline.
    ///
    /// # Errors
    /// [`Error::NotEmpty`] where something is in it, [`Error::File`] where it cannot be written.
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        let files = vec![
            ("benchmark.json".to_owned(), self.to_indented_json()),
            ("trips.csv".to_owned(), self.table()),
            (REPORT.to_owned(), self.page()),
        ];
        written(directory, files)
    }

    /// A row a trip.
    fn table(&self) -> String {
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let mut text = format!("place,truck,driver,{0},expected_{0},ratio,counts\n", self.column);
        for trip in &self.trips {
            let _ = writeln!(
                text,
                "{},{},{},{:.4},{:.4},{:.5},{}",
                quoted(&trip.place),
                quoted(&trip.truck),
                quoted(&trip.driver),
                trip.measured,
                trip.expected,
                trip.measured / trip.expected,
                trip.counts
            );
        }
        text
    }

    fn page(&self) -> String {
        let facts = [
            ("program", format!("ocmc {}", env!("CARGO_PKG_VERSION"))),
            ("study", self.study.clone()),
            ("seed", self.seed.to_string()),
            ("driven", format!("{} cycles", grouped(self.driven))),
            ("ended", now()),
            ("took", format!("{} s", short(self.wall_s))),
        ];
        let bar = |member: &BenchmarkMember| BenchmarkBar {
            name: member.name.clone(),
            trips: member.trips,
            raw: member.raw_ratio,
            ratio: member.ratio,
            ci95: member.ci95,
            better: member.better_than_median,
        };
        let rankings: Vec<BenchmarkRanking> = (self.levels.iter())
            .map(|level| BenchmarkRanking {
                what: of_level(level.level)[1],
                count: level.count,
                p: level.p,
                bars: level.members.iter().map(bar).collect(),
            })
            .collect();
        let changes = self.compared.iter().map(|compared| {
            let change = compared.change.zip(compared.ci95);
            (compared.what.clone(), compared.against.clone(), compared.trips, change)
        });
        benchmark_html(&BenchmarkPage {
            study: &self.study,
            unit: label(&self.column).0,
            ratio: self.ratio,
            trips: self.rows,
            far: self.far.len(),
            rankings: &rankings,
            changes: &changes.collect::<Vec<_>>(),
            text: &self.text(),
            facts: &facts,
        })
    }
}
