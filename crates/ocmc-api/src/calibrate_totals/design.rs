//! The design of a calibration: simulated fleets whose judged numbers lie over their ranges and
//! somewhat beyond, on the loads and lengths of the table, with the rows' noise.

use super::question::Question;
use crate::error::Error;
use crate::totals_rows::{Noise, Rows, totals};
use ocmc_core::random::{Draws, Stream};
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_estimation::calibration::totals::Member;
use ocmc_fleet::quantity::NamedQuantity;
use ocmc_fleet::run::{RunPlan, records};
use ocmc_io::study::{JudgedNumbers, LoadedStudy};
use serde_json::json;
use std::ops::ControlFlow;

/// Simulated fleets.
pub(super) const MEMBERS: u64 = 120;
/// Trips of each: whole batches of the cycles that are spread evenly.
pub(super) const TRIPS: u64 = 128;
/// Cycle from which on others are driven: none of theirs.
pub(super) const CHECKED_FIRST: u64 = MEMBERS * TRIPS;
/// Trips of each that drive the questions, too.
pub(super) const ASKED: u64 = 24;
/// Entries of judged numbers that move: the largest.
const ENTRIES: usize = 20;
/// Ends of a range, in scores, whose prior is N(0, 1): an end is one SD, as `doubt` adds its ends
/// up.
pub(super) const END: f64 = 1.0;
/// How far the design reaches, in scores.
const REACH: f64 = 2.0;
/// How much nearer to what was judged scores become where no study has them, and how often.
const NEARER: f64 = 0.9;
const MOST_NEARER: usize = 20;
/// How often a member is drawn again that no study is.
const MOST_REDRAWS: u64 = 20;
/// Entries that the table itself replaces.
const LENGTH: &str = "mission.length_m";
const PAYLOAD: &str = "mission.payload_kg";

/// A study, and the rows of the table that its fleets are driven like.
pub(super) struct Design<'a> {
    pub(super) study: &'a LoadedStudy,
    pub(super) entries: Vec<&'a JudgedNumbers>,
    pub(super) rows: &'a Rows,
    pub(super) seed: u64,
    pub(super) threads: usize,
}

/// A member, and what its trips take less or more under the questions, as a share.
pub(super) struct Driven {
    pub(super) member: Member,
    pub(super) changes: Vec<Option<f64>>,
}

impl<'a> Design<'a> {
    pub(super) fn new(
        study: &'a LoadedStudy,
        rows: &'a Rows,
        seed: u64,
        threads: usize,
    ) -> Result<Self, Error> {
        let is_of_table = |numbers: &&JudgedNumbers| {
            let has = |path: &str| numbers.keys.iter().any(|key| key.path == path);
            (has(LENGTH) && rows.lengths_m.is_some()) || (has(PAYLOAD) && rows.gross_kg.is_some())
        };
        let mut entries = study.judged_by_effect();
        entries.retain(|numbers| !is_of_table(numbers));
        entries.truncate(ENTRIES);
        if entries.is_empty() {
            return Err(Error::NothingJudged);
        }
        Ok(Self { study, entries, rows, seed, threads })
    }

    /// The study with its judged numbers at scores, on the loads and lengths of the table.
    pub(super) fn at(&self, scores: &[f64]) -> Result<LoadedStudy, Error> {
        let places = scores.iter().map(|score| score / END);
        let moved: Vec<_> = self.entries.iter().copied().zip(places).collect();
        let even = ("simulation.sampling".to_owned(), json!("sobol"));
        let study = self.study.at_places(&moved, &[even])?;
        let curb_kg = study.model.vehicle.curb_mass_kg;
        let most_kg = study.model.vehicle.gross_mass_limit_kg;
        Ok(study.with_values(self.rows.laws(curb_kg, most_kg))?)
    }

    /// The study at scores, or as near to them as there is one; and the scores.
    pub(super) fn nearest(&self, scores: &[f64]) -> Result<(Vec<f64>, LoadedStudy), Error> {
        let mut scores = scores.to_vec();
        for _ in 0..MOST_NEARER {
            if let Ok(study) = self.at(&scores) {
                return Ok((scores, study));
            }
            for score in &mut scores {
                *score *= NEARER;
            }
        }
        Ok((scores.clone(), self.at(&scores)?))
    }

    pub(super) fn plan(&self, first_cycle: u64, cycles: u64) -> RunPlan {
        RunPlan::new(self.seed, first_cycle, cycles, Some(self.threads), None)
    }

    /// A member's scores and study: drawn again where no study has them.
    fn drawn(&self, member: u64) -> Result<(Vec<f64>, LoadedStudy), Error> {
        let mut draws = Draws::new(self.seed, member, Stream::Calibration);
        let mut draw = || -> Vec<f64> {
            self.entries.iter().map(|_| draws.uniform_between(-REACH, REACH)).collect()
        };
        for _ in 1..MOST_REDRAWS {
            let scores = draw();
            if let Ok(study) = self.at(&scores) {
                return Ok((scores, study));
            }
        }
        let scores: Vec<f64> = draw().iter().map(|score| score / 2.0).collect();
        let study = self.at(&scores)?;
        Ok((scores, study))
    }

    /// Drives a member: its trips, and some of them under each question.
    pub(super) fn drive(
        &self,
        member: u64,
        quantity: &NamedQuantity,
        questions: &[Question],
        noise: &Noise,
        look: &mut dyn FnMut(u64) -> ControlFlow<()>,
    ) -> Result<ControlFlow<(), Driven>, Error> {
        let (scores, study) = self.drawn(member)?;
        let first = member * TRIPS;
        let mut done = 0;
        let mut driven = |study: &Study, cycles: u64| {
            let all = records(study, &self.plan(first, cycles), |n| look(done + n));
            done += cycles;
            all
        };
        let ControlFlow::Continue(before) = driven(&study.study, TRIPS) else {
            return Ok(ControlFlow::Break(()));
        };
        let mut changes = Vec::with_capacity(questions.len());
        for question in questions {
            let Some(asked) = question.study(&study.study) else {
                changes.push(None);
                continue;
            };
            let ControlFlow::Continue(after) = driven(&asked, ASKED) else {
                return Ok(ControlFlow::Break(()));
            };
            changes.push(change(quantity, &before[..after.len()], &after));
        }
        let mut draws = Draws::new(self.seed, MEMBERS + member, Stream::Calibration);
        let curb_kg = study.model.vehicle.curb_mass_kg;
        let trips = before.iter().filter_map(|record| {
            let errors = [draws.normal(), draws.normal()];
            totals(record, curb_kg, quantity, noise, errors)
        });
        let trips = trips.collect();
        Ok(ControlFlow::Continue(Driven { member: Member { scores, trips }, changes }))
    }
}

/// Change of the mean consumption between the same trips, as a share.
pub(super) fn change(quantity: &NamedQuantity, before: &[Record], after: &[Record]) -> Option<f64> {
    let pairs = before.iter().zip(after);
    let totals = pairs.filter_map(|(a, b)| Some((quantity.totals(a)?, quantity.totals(b)?)));
    let sums = totals.fold([0.0; 4], |sum, ((a, da), (b, db))| {
        [sum[0] + a, sum[1] + da, sum[2] + b, sum[3] + db]
    });
    let change = (sums[2] / sums[3]) / (sums[0] / sums[1]) - 1.0;
    change.is_finite().then_some(change)
}
