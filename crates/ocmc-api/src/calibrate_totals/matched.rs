//! The calibrated study with the quantiles of the table, as far as its rows know them, and with the
//! answers that are printed.
//!
//! The likelihood of the rows knows the spread of trips by their variances alone, of at most 150
//! rows: P5 and P95 of the study are some 3 % off. What a change does is known better over all
//! members of the design than at any one study. So its scores move, the most probable way, to where
//! the quantiles are those of the rows and of the study, weighed by their errors, and changes do
//! what is printed.

use super::design::{CHECKED_FIRST, Design, Driven, change};
use super::question::Question;
use super::shape::Shape;
use super::written::kept;
use crate::error::Error;
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_estimation::calibration::totals::{MemberEmulator, Posterior, Response};
use ocmc_fleet::quantity::NamedQuantity;
use ocmc_fleet::run::records;
use ocmc_io::study::LoadedStudy;
use std::ops::ControlFlow;

/// Trips of the calibrated study: whole batches of the cycles that are spread evenly.
pub(super) const CHECKED: u64 = 3200;
/// How often it is moved: what is linear in the scores is so nearly.
const ROUNDS: u64 = 2;
/// Most that a score moves.
const MOST_MOVE: f64 = 0.5;
/// Errors of quantiles and of changes, as shares, that are small enough: more would follow
/// directions that the table does not know.
const TOLERANCES: [f64; 2] = [0.01, 1e-3];
/// Trips of a round, and of each question in it.
const ROUND: u64 = 1600;
const ASKED: u64 = 400;
/// Trips of all rounds.
pub(super) const ROUNDS_TRIPS: u64 = ROUNDS * (ROUND + ASKED * Question::ALL.len() as u64);

/// The rows of a table by their shape, and how many count as independent.
pub(super) struct Target {
    pub(super) rows: Shape,
    pub(super) count: f64,
}

/// A calibrated study, and its trips.
pub(super) struct Matched {
    /// The scores that a study has.
    pub(super) scores: Vec<f64>,
    pub(super) study: LoadedStudy,
    pub(super) trips: Vec<Record>,
    pub(super) shape: Shape,
}

impl Matched {
    /// The study at the most probable scores, moved to where its quantiles are the target's, where
    /// there is one, and questions have these answers. `look` is told how many trips are driven.
    pub(super) fn new(
        design: &Design,
        members: &[Driven],
        posterior: &Posterior,
        quantity: &NamedQuantity,
        target: Option<&Target>,
        questions: &[(Question, MemberEmulator)],
        look: &mut dyn FnMut(u64) -> ControlFlow<()>,
    ) -> Result<ControlFlow<(), Self>, Error> {
        let quantiles = quantiles(members);
        let asked: Vec<f64> =
            questions.iter().map(|(_, emulator)| emulator.at(&posterior.scores).0).collect();
        let mut done = 0;
        let mut drive = |study: &Study, trips: u64| {
            let driven = records(study, &design.plan(CHECKED_FIRST, trips), |n| look(done + n));
            done += trips;
            driven
        };
        let mut scores = kept(posterior);
        let takes_part: Vec<bool> = scores.iter().map(|score| *score != 0.0).collect();
        // P5 and P95 over the mean, by the rows and by the study before it moved
        let mut wanted: Option<[f64; 2]> = None;
        for _ in 0..ROUNDS {
            let (nearest, study) = design.nearest(&scores)?;
            let ControlFlow::Continue(trips) = drive(&study.study, ROUND) else {
                return Ok(ControlFlow::Break(()));
            };
            let mut numbers: Vec<MemberEmulator> = Vec::new();
            let (mut by, mut tolerances) = (Vec::new(), Vec::new());
            if let Some(target) = target {
                let (shape, sorted) = Shape::of(quantity, &trips);
                let over_mean =
                    |shape: &Shape| [shape.p5, shape.p95].map(|quantile| quantile / shape.mean);
                let [low, high] = *wanted.get_or_insert_with(|| {
                    let relative = target.rows.times(shape.mean / target.rows.mean);
                    over_mean(&relative.together(&shape, &sorted, target.count))
                });
                let [own_low, own_high] = over_mean(&shape);
                numbers.extend(quantiles.clone());
                by.extend([low / own_low, high / own_high].map(libm::log));
                tolerances.extend([TOLERANCES[0]; 2]);
            }
            for ((question, emulator), asked) in questions.iter().zip(&asked) {
                let Some(changed) = question.study(&study.study) else { continue };
                let ControlFlow::Continue(after) = drive(&changed, ASKED) else {
                    return Ok(ControlFlow::Break(()));
                };
                let Some(reached) = change(quantity, &trips[..after.len()], &after) else {
                    continue;
                };
                numbers.push(emulator.clone());
                by.push(asked - reached);
                tolerances.push(TOLERANCES[1]);
            }
            let moved = posterior.moved(&nearest, &numbers, &by, &tolerances, |k| takes_part[k]);
            let within = |(to, from): (&f64, &f64)| from + (to - from).clamp(-MOST_MOVE, MOST_MOVE);
            scores = moved.iter().zip(&nearest).map(within).collect();
        }
        let (scores, study) = design.nearest(&scores)?;
        let driven = drive(&study.study, CHECKED);
        Ok(driven.map_continue(|trips| {
            let shape = Shape::of(quantity, &trips).0;
            Self { scores, study, trips, shape }
        }))
    }
}

/// ln P5 and ln P95 over the mean, over the scores.
fn quantiles(members: &[Driven]) -> [MemberEmulator; 2] {
    let consumption = Response::Consumption as usize;
    let shapes = members.iter().map(|driven| {
        let trips = &driven.member.trips;
        let each = trips.iter().map(|trip| libm::exp(trip.responses[consumption]));
        let each: Vec<f64> = each.collect();
        let lengths: Vec<f64> = trips.iter().map(|trip| trip.length_m).collect();
        Shape::of_each(&lengths, each)
    });
    let shapes: Vec<Shape> = shapes.collect();
    let scores: Vec<Vec<f64>> = members.iter().map(|d| d.member.scores.clone()).collect();
    let over_scores = |value_of: fn(&Shape) -> f64| {
        let numbers: Vec<f64> = shapes.iter().map(|s| libm::log(value_of(s) / s.mean)).collect();
        MemberEmulator::fit(&scores, &numbers)
    };
    [over_scores(|s| s.p5), over_scores(|s| s.p95)]
}
