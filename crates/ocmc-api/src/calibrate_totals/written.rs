//! The part of a study that a calibration writes: judged numbers with their errors, the loads and
//! lengths of the table, and the factor on consumption.

use super::design::{Design, END};
use super::question::scale;
use ocmc_estimation::calibration::totals::Posterior;
use ocmc_io::study::{Estimate, FittedPart, JudgedNumbers, LoadedStudy, MovedNumber};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};

/// The factor on the fuel map.
const FACTOR: &str = "vehicle.powertrain.combustion.engine.fuel_factor";
pub(super) const FACTOR_POINTER: &str = "/vehicle/powertrain/combustion/engine/fuel_factor";
/// Name of the errors' table.
const NAME: &str = "totals";
/// Scores and errors of numbers that the data moved or narrowed: others stay as they were judged.
const LEAST_SCORE: f64 = 0.15;
const MOST_SD: f64 = 0.9;
/// The share of correlations that is kept, so that those of numbers that move together stay
/// possible when they are rounded.
const KEPT: f64 = 0.995;

/// Judged numbers of a calibration.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct CalibratedNumbers {
    /// Name of the entry.
    pub name: String,
    /// One of its numbers, before and after.
    pub key: String,
    /// Before.
    pub before: f64,
    /// After.
    pub after: f64,
    /// How far it went: 0 where it was judged, ±1 at the ends of the range.
    pub score: f64,
    /// SD of that; 1 where the table says nothing.
    pub score_sd: f64,
    /// Whether the table moved it or narrowed it: others stay as they were judged.
    pub is_moved: bool,
}

/// The scores that are written: 0 where the table neither moved a number nor narrowed it.
pub(super) fn kept(posterior: &Posterior) -> Vec<f64> {
    let sd = |k: usize| libm::sqrt(posterior.covariance[(k, k)].max(0.0));
    let is_kept = |k: usize, score: f64| score.abs() > LEAST_SCORE || sd(k) < MOST_SD;
    let scores = posterior.scores.iter().enumerate();
    scores.map(|(k, &score)| if is_kept(k, score) { score } else { 0.0 }).collect()
}

/// The numbers to write, and where they are from.
pub(super) struct Written<'a> {
    pub(super) design: &'a Design<'a>,
    pub(super) posterior: &'a Posterior,
    /// The scores that a study has.
    pub(super) scores: &'a [f64],
}

impl Written<'_> {
    fn sd(&self, k: usize) -> f64 {
        libm::sqrt(self.posterior.covariance[(k, k)].max(0.0))
    }

    fn is_moved(&self, k: usize) -> bool {
        self.scores[k] != 0.0 || self.sd(k) < MOST_SD
    }

    fn moving(&self, k: usize) -> Vec<MovedNumber> {
        self.design.entries[k].moving(self.scores[k] / END)
    }

    /// The numbers, those first that went furthest or are known best.
    pub(super) fn numbers(&self, study: &LoadedStudy, factor: f64) -> Vec<CalibratedNumbers> {
        let tree = study.model.to_tree();
        let one = |(k, entry): (usize, &&JudgedNumbers)| {
            let number = self.moving(k).into_iter().next()?;
            let pointer = format!("/{}", number.path.replace('.', "/"));
            let times = if number.path.starts_with(FACTOR) { factor } else { 1.0 };
            Some(CalibratedNumbers {
                name: entry.name.clone(),
                before: tree.pointer(&pointer)?.as_f64()?,
                after: times * number.value,
                key: number.path,
                score: self.scores[k],
                score_sd: self.sd(k),
                is_moved: self.is_moved(k),
            })
        };
        let mut all: Vec<_> = self.design.entries.iter().enumerate().filter_map(one).collect();
        let size = |n: &CalibratedNumbers| n.score.abs().max(1.0 - n.score_sd);
        all.sort_by(|a, b| size(b).total_cmp(&size(a)));
        all
    }

    /// The part.
    pub(super) fn part(
        &self,
        study: &LoadedStudy,
        calibrated: &LoadedStudy,
        factor: f64,
    ) -> FittedPart {
        let moved = || (0..self.scores.len()).filter(|k| self.is_moved(*k));
        let mut values: Vec<(String, Value)> = Vec::new();
        for k in moved() {
            values.extend(self.design.entries[k].at(self.scores[k] / END));
        }
        let vehicle = &calibrated.model.vehicle;
        let (curb_kg, most_kg) = (vehicle.curb_mass_kg, vehicle.gross_mass_limit_kg);
        values.extend(self.design.rows.laws(curb_kg, most_kg));
        if let Some(law) = calibrated.model.to_tree().pointer(FACTOR_POINTER) {
            let mut law = law.clone();
            scale(&mut law, factor);
            values.retain(|(path, _)| path != FACTOR);
            values.push((FACTOR.to_owned(), law));
        }
        let mut tree = Value::Object(Map::new());
        for (path, value) in &values {
            let mut place = &mut tree;
            for key in path.split('.') {
                if !place.is_object() {
                    *place = Value::Object(Map::new());
                }
                let table = place.as_object_mut().expect("it is one");
                place = table.entry(key).or_insert(Value::Null);
            }
            *place = value.clone();
        }
        let part = FittedPart::new(&study.model, &[], &tree);
        let written = part.json();
        let numbers: Vec<(usize, MovedNumber)> = moved()
            .flat_map(|k| self.moving(k).into_iter().map(move |number| (k, number)))
            .collect();
        let estimates = numbers.iter().filter_map(|(k, number)| {
            let value = written.pointer(&format!("/{}", number.path.replace('.', "/")))?;
            let times = if number.path.starts_with(FACTOR) { factor } else { 1.0 };
            let standard_error = (times * number.slope / END).abs() * self.sd(*k);
            Some(Estimate { key: number.path.clone(), value: value.as_f64()?, standard_error })
        });
        let correlation = |a: &str, b: &str| {
            let entry = |path: &str| numbers.iter().find(|(_, number)| number.path == path);
            let (Some((i, a)), Some((j, b))) = (entry(a), entry(b)) else { return 0.0 };
            let covariance = self.posterior.covariance[(*i, *j)];
            let sign = a.slope.signum() * b.slope.signum();
            KEPT * sign * covariance / (self.sd(*i) * self.sd(*j))
        };
        let estimates: Vec<Estimate> = estimates.collect();
        part.with_correlated_errors(&study.model, NAME, estimates, &correlation)
    }
}
