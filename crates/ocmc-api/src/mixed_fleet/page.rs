//! The page of a fleet of groups.

use super::{ARRIVALS, CONSUMPTIONS, GroupAnswer, MixedFleetAnswer};
use crate::answer::Answer;
use crate::error::Error;
use crate::named_total::{NamedTotal, amount};
use ocmc_io::file_error::FileError;
use ocmc_io::number_text::{count_of, grouped, short};
use ocmc_io::report::{MixedFleetPage, PageTable, REPORT, mixed_fleet_html};
use ocmc_io::run_directory::{FLEET, now};
use ocmc_io::shell_word::shell_word;
use std::fs;
use std::path::Path;

/// The total whose shares are drawn: all groups have it.
const SHARED: &str = "WTW CO2e";

impl MixedFleetAnswer {
    /// Writes the answer and its page, one HTML file that opens offline, beside the runs of the
    /// groups.
    pub(super) fn save(&self, directory: &Path) -> Result<(), Error> {
        for (name, text) in [(FLEET, self.to_indented_json()), (REPORT, self.page())] {
            let path = directory.join(name);
            fs::write(&path, text).map_err(FileError::write(&path))?;
        }
        Ok(())
    }

    fn page(&self) -> String {
        let study = shell_word(Path::new(&self.study));
        let is_answer = |total: &&NamedTotal| !["distance", "time"].contains(&total.name.as_str());
        let keys = self.totals.iter().filter(is_answer).map(|total| {
            [amount(total), format!("{} of {}", total.name, count_of(self.trucks, "truck"))]
        });
        let shares: Vec<(String, f64, String)> = self
            .groups
            .iter()
            .filter_map(|group| {
                let total = group.totals.iter().find(|total| total.name == SHARED)?;
                Some((group.group.clone(), total.total.total, amount(total)))
            })
            .collect();
        let shares = if shares.len() == self.groups.len() { &shares[..] } else { &[] };
        let mut tables = vec![self.by_group()];
        let mut add = |heading, note, head: &[&str], rows: Vec<Vec<String>>| {
            if !rows.is_empty() {
                let head = head.iter().map(|name| (*name).to_owned()).collect();
                tables.push(PageTable { heading, note, head, rows });
            }
        };
        add(
            "How many can be electric",
            "Trucks of a group of which all trips, or 95 % of them, arrive with the battery of \
             another one.",
            &ARRIVALS,
            self.arrivals().into_iter().map(Vec::from).collect(),
        );
        add(
            "Trips",
            "Mean of the trips of a group, total over total, with its 95 % interval, and quantiles \
             that count each trip once.",
            &CONSUMPTIONS,
            self.consumptions().into_iter().map(Vec::from).collect(),
        );
        let groups =
            self.groups.iter().map(|group| format!("{} {}", grouped(group.trucks), group.group));
        let groups = groups.collect::<Vec<_>>().join(", ");
        let trips: u64 = self.groups.iter().map(|group| group.run.summary.summary.cycles).sum();
        let facts = [
            ("program", format!("ocmc {}", env!("CARGO_PKG_VERSION"))),
            ("study", self.study.clone()),
            ("seed", self.seed.to_string()),
            ("trips", grouped(trips)),
            ("ended", now()),
            ("took", format!("{} s on {} threads", short(self.wall_s), self.threads)),
        ];
        mixed_fleet_html(&MixedFleetPage {
            study: &self.study,
            said: &format!(
                "{} in {}, {groups}: what they use, emit and cost in {}.",
                count_of(self.trucks, "truck"),
                count_of(self.groups.len() as u64, "group"),
                count_of(trips, "trip")
            ),
            keys: &keys.collect::<Vec<_>>(),
            shared: SHARED,
            shares,
            tables: &tables,
            command: &format!("ocmc --study {study} --seed {}", self.seed),
            facts: &facts,
        })
    }

    /// Totals of the fleet and of its groups, side by side.
    fn by_group(&self) -> PageTable {
        let names = self.groups.iter().map(|group| group.group.clone());
        let head = ["", "all"].map(str::to_owned).into_iter().chain(names).collect();
        let row = |name: &str, all: String, text_of: &dyn Fn(&GroupAnswer) -> String| {
            [name.to_owned(), all].into_iter().chain(self.groups.iter().map(text_of)).collect()
        };
        let mut rows: Vec<Vec<String>> = vec![
            row("trucks", grouped(self.trucks), &|group| grouped(group.trucks)),
            row("trips of each", String::new(), &|group| grouped(group.trips_per_truck)),
        ];
        for total in &self.totals {
            let same = |own: &&NamedTotal| (&own.name, &own.unit) == (&total.name, &total.unit);
            rows.push(row(&total.name, amount(total), &|group| {
                group.totals.iter().find(same).map_or("–".to_owned(), amount)
            }));
        }
        PageTable {
            heading: "By group",
            note: "Totals of the fleet, and of each group.",
            head,
            rows,
        }
    }
}
