//! The worth of training the drivers who stand worst in a benchmark of measured trips.
//!
//! Chosen are the drivers with the largest shrunken ratios: what chance adds to a mean is taken off
//! already. Training brings them to the middle fifth, as in [`crate::training`]; the study says how
//! far a driver goes in a year and what that takes.

use crate::answer::Answer;
use crate::error::Error;
use crate::text::fact;
use crate::training::years;
use crate::watch::{Watch, watched};
use ocmc_fleet::quantity::{LITRES, NamedQuantity, shared_consumption};
use ocmc_fleet::run::{RunPlan, records};
use ocmc_io::file_error::FileError;
use ocmc_io::label::label;
use ocmc_io::number_text::{percent, rounded};
use ocmc_io::study::LoadedStudy;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Standard normal deviate of a 95 % interval.
const NORMAL_975: f64 = 1.959_963_984_540_054;
/// Fewest drivers that a share is chosen of.
const FEWEST_DRIVERS: usize = 5;

/// Drivers whose training is asked about.
#[derive(Clone, Debug)]
pub struct MeasuredTrainingRequest<'a> {
    /// `benchmark.json`, as `ocmc benchmark --out` or `--json` writes it.
    pub benchmark: PathBuf,
    /// The study, and how the answer calls it.
    pub study: (String, &'a LoadedStudy),
    /// Share of the drivers who are trained: those with the largest ratios.
    pub share: f64,
    /// The cycles: whole trucks.
    pub plan: RunPlan,
}

/// The worth of training.
#[derive(Clone, Debug, Serialize)]
pub struct MeasuredTrainingAnswer {
    /// Name of the study.
    pub study: String,
    /// Drivers of the benchmark.
    pub drivers: usize,
    /// The chosen, as the benchmark calls them, the worst first.
    pub chosen: Vec<String>,
    /// Saving of a chosen driver who comes to the middle fifth, as a share.
    pub saving: f64,
    /// Its 95 % interval, the drivers' errors taken as independent.
    pub saving_ci95: [f64; 2],
    /// Name of the consumption.
    pub column: String,
    /// Mean consumption of the study.
    pub mean: f64,
    /// Distance of a truck in a year, in m.
    pub distance_m_per_a: f64,
    /// Saving a year for each chosen driver: litres, or kWh.
    pub amount_per_a: f64,
    /// Its 95 % interval.
    pub amount_per_a_ci95: [f64; 2],
}

#[derive(Deserialize)]
struct Benchmark {
    levels: Vec<Level>,
}

#[derive(Deserialize)]
struct Level {
    level: String,
    members: Vec<Member>,
}

#[derive(Clone, Deserialize)]
struct Member {
    name: String,
    ratio: f64,
    ci95: [f64; 2],
}

/// Finds what the training of the worst drivers of a benchmark is worth.
///
/// # Errors
/// [`Error::File`] where the file cannot be read, [`Error::NoRankedDrivers`] where it is no
/// benchmark or its drivers do not differ beyond chance; [`Error::Interrupted`].
pub fn measured_training(
    request: &MeasuredTrainingRequest,
    watch: &mut Watch,
) -> Result<MeasuredTrainingAnswer, Error> {
    let MeasuredTrainingRequest { benchmark: path, study: (name, loaded), share, plan } = request;
    let text = std::fs::read_to_string(path).map_err(FileError::read(path))?;
    let unranked = |why: &'static str| Error::NoRankedDrivers { path: path.clone(), why };
    let read: Benchmark = serde_json::from_str(&text)
        .map_err(|_| unranked("it is no `benchmark.json` of `ocmc benchmark`"))?;
    let of_drivers = |level: &&Level| level.level.contains("driver");
    let level =
        (read.levels.iter().find(of_drivers)).ok_or_else(|| unranked("it names no drivers"))?;
    if level.members.is_empty() {
        return Err(unranked("its drivers do not differ beyond chance"));
    }
    if level.members.len() < FEWEST_DRIVERS {
        return Err(unranked("it has fewer than 5 drivers"));
    }
    let (chosen, saving, saving_ci95) = saving(&level.members, *share);
    let driven = watched(plan.cycles, watch, |look| records(&loaded.study, plan, look))?;
    let quantity: &NamedQuantity = shared_consumption(&[&driven]);
    let totals = driven.iter().filter_map(|record| quantity.totals(record));
    let [amount, distance] = totals.fold([0.0; 2], |sum, (a, d)| [sum[0] + a, sum[1] + d]);
    let mean = amount / distance;
    let metres: f64 = driven.iter().map(|record| record.distance_m).sum();
    let trucks = (plan.cycles / loaded.study.nesting().trips_per_truck).max(1) as f64;
    let distance_m_per_a = metres / trucks / years(loaded) as f64;
    let km = distance_m_per_a / 1000.0;
    let each = mean * if quantity.column == LITRES { km / 100.0 } else { km };
    Ok(MeasuredTrainingAnswer {
        study: name.clone(),
        drivers: level.members.len(),
        chosen,
        saving,
        saving_ci95,
        column: quantity.column.to_owned(),
        mean,
        distance_m_per_a,
        amount_per_a: each * saving,
        amount_per_a_ci95: saving_ci95.map(|saving| each * saving),
    })
}

/// The chosen, the worst first, and what they save by coming to the middle fifth, with its 95 %
/// interval.
fn saving(members: &[Member], share: f64) -> (Vec<String>, f64, [f64; 2]) {
    let mut all = members.to_vec();
    all.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    let n = all.len();
    let count = (libm::round(share * n as f64) as usize).clamp(1, n);
    let fifth = (n / 5).max(1);
    let first = (n - fifth) / 2;
    let mean = |members: &[Member]| {
        members.iter().map(|m| libm::log(m.ratio)).sum::<f64>() / members.len() as f64
    };
    let variance = |members: &[Member]| {
        let square = |m: &Member| {
            let error = libm::log(m.ci95[1] / m.ci95[0]) / (2.0 * NORMAL_975);
            error * error
        };
        members.iter().map(square).sum::<f64>() / (members.len() * members.len()) as f64
    };
    let (worst, middle) = (&all[..count], &all[first..first + fifth]);
    let ln = mean(worst) - mean(middle);
    let half = NORMAL_975 * libm::sqrt(variance(worst) + variance(middle));
    let share = |ln: f64| 1.0 - libm::exp(-ln);
    let names = worst.iter().map(|member| member.name.clone()).collect();
    (names, share(ln), [share(ln - half), share(ln + half)])
}

impl Answer for MeasuredTrainingAnswer {
    fn text(&self) -> String {
        let unit = if self.column == LITRES { "L" } else { "kWh" };
        let (per_way, factor) = label(&self.column);
        let mut text = fact("study", &self.study);
        let chosen = format!("{} of {} drivers, measured", self.chosen.len(), self.drivers);
        text.push_str(&fact("chosen", chosen));
        text.push_str(&fact("mean", format!("{} {per_way}", rounded(factor * self.mean))));
        let km = rounded(self.distance_m_per_a / 1000.0);
        text.push_str(&fact("a year", format!("{km} km a truck")));
        let [low, high] = self.saving_ci95.map(percent);
        let saving = format!("{} %  ({low} to {high})", percent(self.saving));
        text.push_str(&fact("saving", saving));
        let [low, high] = self.amount_per_a_ci95.map(rounded);
        let amount = rounded(self.amount_per_a);
        let amount = format!("{amount} {unit} a year for each of them  ({low} to {high})");
        text.push_str(&fact("", amount));
        text.push_str(
            "\nThey come to the middle fifth of the drivers, if the training works. The ratios\n\
             are shrunken: what chance adds is taken off.\n",
        );
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_come_to_the_middle() {
        // by hand: the worst of five is at 1.10, the middle one at 1
        let member = |(k, ratio): (usize, &f64)| {
            let name = format!("driver {k:02}");
            Member { name, ratio: *ratio, ci95: [ratio / 1.02, ratio * 1.02] }
        };
        let members: Vec<Member> =
            [0.9, 1.1, 1.0, 0.95, 1.05].iter().enumerate().map(member).collect();
        let (chosen, saved, [low, high]) = saving(&members, 0.2);
        assert_eq!(chosen, ["driver 01"]);
        assert!((saved - (1.0 - 1.0 / 1.1)).abs() < 1e-12);
        // two errors of 2 % each
        let half = (1.0 - saved).ln() - (1.0 - high).ln();
        assert!((half - 2.0_f64.sqrt() * 1.02_f64.ln()).abs() < 1e-12 && low < saved);
    }
}
