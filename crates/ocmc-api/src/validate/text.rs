//! A validation for people.

use super::{ValidateAnswer, ValidatedDrive};
use crate::answer::Answer;
use crate::text::{fact, table, took};
use ocmc_io::intake::FileAccount;
use ocmc_io::number_text::{count_of, grouped, percent, rounded};
use ocmc_io::report::{quantity_label, score_text};
use std::fmt::Write;

/// Widths of the columns of the tables.
const WIDTHS: [usize; 8] = [27, 8, 11, 10, 10, 13, 13, 8];
const OF_DRIVE: [usize; 6] = [29, 11, 11, 20, 10, 8];
/// Most drives that get a table of their own.
const MOST_SHOWN: usize = 5;

impl ValidateAnswer {
    /// Parts that come from the validated logs themselves, in words; nothing where there are none.
    pub(super) fn circle(&self) -> Option<String> {
        if self.circular.is_empty() {
            return None;
        }
        let what = self.circular.join(" and ");
        let is_circular = |drive: &&ValidatedDrive| !drive.circular.is_empty();
        let n = self.drives.iter().filter(is_circular).count();
        Some(format!(
            "the {what} of the road come from the validated log itself ({} of {}): {}",
            n,
            count_of(self.drives.len() as u64, "drive"),
            if self.circular.contains(&"limits") {
                "no speed and no time of it is a validation"
            } else {
                "its standstills and its whole time are no validation, its speed between stops is"
            }
        ))
    }

    /// Facts of the validation, each with its name.
    pub(super) fn facts(&self) -> Vec<(&'static str, String)> {
        let roads = match self.roads.as_slice() {
            [only] => format!("{}, {} km", only.name, rounded(only.length_m / 1000.0)),
            several => count_of(several.len() as u64, "road"),
        };
        let completed: usize = self.roads.iter().map(|road| road.completed).sum();
        let lost = self.trips * self.roads.len() as u64 - completed as u64;
        let arrived = match lost {
            0 => String::new(),
            lost => format!(", {} of them did not arrive and do not count", grouped(lost)),
        };
        let left_out = match self.left_out {
            0 => String::new(),
            n => format!(", {} left out", grouped(n as u64)),
        };
        let scored_m: f64 = self.drives.iter().map(|d| d.score.to_m - d.score.from_m).sum();
        vec![
            ("study", format!("{} (seed {})", self.study, self.seed)),
            ("road", roads),
            ("trips", format!("{} independent ones a road{arrived}", grouped(self.trips))),
            (
                "drives",
                format!(
                    "{} scored over {} km{left_out}",
                    grouped(self.drives.len() as u64),
                    rounded(scored_m / 1000.0)
                ),
            ),
        ]
    }
}

impl Answer for ValidateAnswer {
    fn notes(&self) -> Vec<String> {
        FileAccount::told_of(&self.inputs)
    }

    fn warnings(&self) -> Vec<String> {
        self.circle().into_iter().map(|circle| format!("circular: {circle}")).collect()
    }

    fn text(&self) -> String {
        let circle = self.circle().map(|circle| ("CIRCULAR", circle));
        let facts = self.facts().into_iter().chain(circle);
        let mut text: String = facts.map(|(name, value)| fact(name, value)).collect();
        text.push_str(&took(self.wall_s, self.threads, self.trips * self.roads.len() as u64));
        text.push('\n');
        let head =
            ["", "values", "mean error", "RMSE", "CRPS", "in half, %", "in 90 %, %", "p even"];
        let rows = self.pooled.iter().map(|pooled| {
            let (label, factor) = quantity_label(&pooled.quantity, self.carrier);
            let with = |share: f64, error: Option<f64>| match error {
                Some(error) => format!("{} ± {:>4}", percent(share), percent(error)),
                None => percent(share),
            };
            [
                label,
                grouped(pooled.n as u64),
                score_text(factor * pooled.mean_error),
                score_text(factor * pooled.rmse),
                score_text(factor * pooled.crps),
                with(pooled.coverage50, pooled.coverage50_error),
                with(pooled.coverage90, pooled.coverage90_error),
                pooled.uniform.map_or("-".to_owned(), |uniform| format!("{:.3}", uniform.p)),
            ]
        });
        text.push_str(&table(&WIDTHS, &head, rows));
        for drive in self.drives.iter().take(MOST_SHOWN) {
            let part = [drive.score.from_m, drive.score.to_m].map(|at_m| rounded(at_m / 1000.0));
            let head = ["", "measured", "simulated", "90 % of the trips", "CRPS", "rank"];
            let rows = drive.score.values.iter().map(|(quantity, score)| {
                let (label, factor) = quantity_label(quantity.name(), self.carrier);
                let [low, high] = score.band90.map(|value| score_text(factor * value));
                [
                    label,
                    score_text(factor * score.measured),
                    score_text(factor * score.simulated),
                    format!("{low} to {high}"),
                    score_text(factor * score.crps),
                    format!("{:.3}", score.pit),
                ]
            });
            let _ = writeln!(text, "\n{}, km {} to {}", drive.score.drive, part[0], part[1]);
            text.push_str(&table(&OF_DRIVE, &head, rows));
        }
        if let Some(more) = self.drives.len().checked_sub(MOST_SHOWN).filter(|more| *more > 0) {
            let more = count_of(more as u64, "more drive");
            let _ = writeln!(text, "\n{more}: --json or --out has them");
        }
        text
    }
}
