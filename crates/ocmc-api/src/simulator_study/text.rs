//! The study's answer for people.

use super::SimulatorStudyAnswer;
use crate::answer::Answer;
use crate::text::{fact, table, took};
use ocmc_io::number_text::{count_of, grouped, rounded};
use std::fmt::Write;

impl SimulatorStudyAnswer {
    /// Facts of the drive.
    pub(super) fn facts(&self) -> Vec<(&'static str, String)> {
        let repetitions = count_of(self.repetitions, "repetition");
        vec![
            ("study", format!("{} ({})", self.study, &self.study_hash[..12])),
            ("seed", self.seed.to_string()),
            ("drives", format!("{repetitions} with 8 drivers")),
            ("curves", grouped(self.curves.len() as u64)),
            ("changes", format!("{} of the limit", grouped(self.changes.len() as u64))),
        ]
    }
}

impl Answer for SimulatorStudyAnswer {
    fn text(&self) -> String {
        let facts = self.facts().into_iter().map(|(name, value)| fact(name, value));
        let mut text: String = facts.collect();
        let number = |value: Option<f64>| value.map_or("-".to_owned(), rounded);
        let mut before = "";
        let rows = self.compared.iter().map(|row| {
            let table = if row.table == before { "" } else { row.table };
            before = row.table;
            [
                table.to_owned(),
                row.quantity.to_owned(),
                rounded(row.paper),
                number(row.median),
                row.p5.zip(row.p95).map_or("-".to_owned(), |(low, high)| {
                    let outside = if row.within() == Some(false) { " *" } else { "" };
                    format!("{} to {}{outside}", rounded(low), rounded(high))
                }),
            ]
        });
        text.push('\n');
        let head = ["", "", "paper", "program", "90 % of repetitions"];
        text.push_str(&table(&[36, 26, 9, 9, 22], &head, rows.collect::<Vec<_>>()));
        let outside = self.compared.iter().filter(|row| row.within() == Some(false)).count();
        if outside > 0 {
            let _ = writeln!(
                text,
                "* The paper's number lies outside, in {outside} of {}.",
                self.compared.len()
            );
        }
        if !self.events.is_empty() {
            text.push('\n');
            for (name, uphill) in [("uphill", true), ("downhill", false)] {
                let side = || self.events.iter().filter(|event| (event.grade > 0.0) == uphill);
                let ended = side()
                    .filter(|event| event.at_bound.iter().any(|name| name.starts_with('k')))
                    .count();
                let events = count_of(side().count() as u64, "event");
                text.push_str(&fact(name, format!("{ended} of {events} with a gain at a bound")));
            }
        }
        text.push('\n');
        text.push_str(&took(self.wall_s, self.threads, 8 * self.repetitions));
        text
    }

    fn warnings(&self) -> Vec<String> {
        if self.left_out == 0 {
            return Vec::new();
        }
        vec![format!("{} left out: the truck did not drive", count_of(self.left_out, "drive"))]
    }
}
