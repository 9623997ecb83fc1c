//! The calibrated study with the quantiles of the table, as far as its rows know them.
//!
//! The likelihood of the rows knows the spread of trips by their variances alone, of at most 150 rows:
//! P5 and P95 of the study are some 3 % off. Its scores then move, the most probable way, to where the
//! quantiles are those of the rows and of the study, weighed by their errors.

use super::design::{CHECKED_FIRST, Design, Driven};
use super::shape::Shape;
use super::written::kept;
use crate::error::Error;
use ocmc_core::record::Record;
use ocmc_estimation::calibration::totals::{MemberEmulator, Posterior, Response};
use ocmc_fleet::quantity::NamedQuantity;
use ocmc_fleet::run::records;
use ocmc_io::study::LoadedStudy;
use std::ops::ControlFlow;

/// Trips of the calibrated study: whole batches of the cycles that are spread evenly.
pub(super) const CHECKED: u64 = 3200;
/// How often it is moved: what is linear in the scores is so nearly.
pub(super) const ROUNDS: u64 = 2;
/// Most that a score moves.
const MOST_MOVE: f64 = 1.0;

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
    /// The study at the most probable scores, and at those where its quantiles are the target's; no
    /// target: as it is. `look` is told how many trips are driven.
    pub(super) fn new(
        design: &Design,
        members: &[Driven],
        posterior: &Posterior,
        quantity: &NamedQuantity,
        target: Option<&Target>,
        look: &mut dyn FnMut(u64) -> ControlFlow<()>,
    ) -> Result<ControlFlow<(), Self>, Error> {
        let quantiles = quantiles(members);
        let mut scores = kept(posterior);
        let takes_part: Vec<bool> = scores.iter().map(|score| *score != 0.0).collect();
        for round in 0.. {
            let (nearest, study) = design.nearest(&scores)?;
            let plan = design.plan(CHECKED_FIRST, CHECKED);
            let driven = records(&study.study, &plan, |n| look(round * CHECKED + n));
            let ControlFlow::Continue(trips) = driven else { return Ok(ControlFlow::Break(())) };
            let (shape, sorted) = Shape::of(quantity, &trips);
            let Some(target) = target.filter(|_| round < ROUNDS) else {
                return Ok(ControlFlow::Continue(Self { scores: nearest, study, trips, shape }));
            };
            let relative = target.rows.times(shape.mean / target.rows.mean);
            let asked = relative.together(&shape, &sorted, target.count);
            let by = [asked.p5 / shape.p5, asked.p95 / shape.p95].map(libm::log);
            let moved = posterior.moved(&nearest, &quantiles, &by, |k| takes_part[k]);
            let within = |(to, from): (&f64, &f64)| from + (to - from).clamp(-MOST_MOVE, MOST_MOVE);
            scores = moved.iter().zip(&nearest).map(within).collect();
        }
        unreachable!("the last round returns")
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
    let over_scores = |of: fn(&Shape) -> f64| {
        let numbers: Vec<f64> = shapes.iter().map(|s| libm::log(of(s) / s.mean)).collect();
        MemberEmulator::fit(&scores, &numbers)
    };
    [over_scores(|s| s.p5), over_scores(|s| s.p95)]
}
