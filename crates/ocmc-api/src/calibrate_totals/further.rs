//! The worth of further columns of a table.

use super::design::Driven;
use super::{Estimate, Question};
use crate::totals_rows::Rows;
use ocmc_estimation::calibration::totals::{
    Emulator, Known, Member, Response, Shared, TotalsRow, expected,
};
use schemars::JsonSchema;
use serde::Serialize;

/// Least that a column tells to be named: 2 % of an SD.
const LEAST_GAIN: f64 = 0.02;

/// A column that the table does not have.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Further {
    /// Name of the column, in words.
    pub column: &'static str,
    /// The question of which it would tell most.
    pub question: Question,
    /// SD of that with the column over that without.
    pub sd_ratio: f64,
}

/// The columns, that which would tell most first.
pub(super) fn further(estimate: &Estimate, driven: &[Driven], rows: &Rows) -> Vec<Further> {
    let members: Vec<Member> = driven.iter().map(|driven| driven.member.clone()).collect();
    // rows as the design has them
    let count = rows.totals.len();
    let invented: Vec<TotalsRow> = (0..count)
        .filter_map(|k| {
            let trips = &members[k % members.len()].trips;
            trips.get(k / members.len() % trips.len().max(1)).cloned()
        })
        .collect();
    let sds = |emulator: &Emulator| -> Vec<f64> {
        let shared =
            Shared { discrepancies: emulator.discrepancies(), weight: estimate.shared.weight };
        let scores = &estimate.posterior.scores;
        let then = expected(emulator, &invented, &shared, scores);
        estimate.questions.iter().map(|(_, question)| then.sd(&question.at(scores).1)).collect()
    };
    let now = sds(&estimate.emulator);
    let known = &estimate.known;
    let mut candidates = Vec::new();
    if !known.gross {
        candidates.push(("gross_weight_kg", Known { gross: true, ..known.clone() }));
    }
    for (column, response) in [("driving_time_h", Response::Speed), ("climb_m", Response::Climb)] {
        if !known.responses.contains(&response) {
            let mut responses = known.responses.clone();
            responses.push(response);
            responses.sort();
            candidates.push((column, Known { responses, ..known.clone() }));
        }
    }
    let mut all: Vec<Further> = (candidates.into_iter())
        .filter_map(|(column, known)| {
            let emulator = Emulator::fit(&members, &known)?;
            let ratios = sds(&emulator).into_iter().zip(&now).map(|(then, now)| then / now);
            let best = ratios.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
            let question = estimate.questions[best.0].0;
            (best.1 < 1.0 - LEAST_GAIN).then_some(Further { column, question, sd_ratio: best.1 })
        })
        .collect();
    all.sort_by(|a, b| a.sd_ratio.total_cmp(&b.sd_ratio));
    all
}
