//! Checks of a table of totals against the study that it is compared with. Some errors of tables
//! look like a fleet of its own; they are named where a figure gives them away.

use crate::totals_rows::Rows;
use ocmc_estimation::calibration::totals::{Posterior, Response};
use ocmc_io::intake::Finding;
use ocmc_io::number_text::{percent, rounded};
use ocmc_io::trip_totals::{Amount, TripTotals};

/// Largest squared length of the scores, and largest score, of a fleet that is like the study: of
/// 20 numbers one fleet in two has more than 20 by the prior alone where all are known, and hardly
/// any does where the data move a few of them (tried on 40 invented fleets: loads as gross weights
/// came to 40).
const MOST_SQUARE: f64 = 20.0;
const MOST_SCORE: f64 = 3.0;
/// Part of the empty truck's mass below which a gross weight is none, be the scales 5 % and the
/// mass 8 % off, and share of such rows.
const EMPTY: f64 = 0.8;
const MOST_BELOW: f64 = 0.03;
/// Consumption over that of the study with the same loads, outside which a unit may be another one:
/// a kilogram of diesel is 1.2 L.
const LEVELS: [f64; 2] = [0.89, 1.16];
/// Residual, in SDs, of a row that is far from all others.
const FAR: f64 = 4.0;
/// Residual of the speed that is slow, and largest share of such rows: of a normal law 0.6 %.
const SLOW: f64 = -2.5;
const MOST_SLOW: f64 = 0.04;
/// Sign of breaks, in SDs of the simulated fleets (tried on 40 invented fleets).
const MOST_BREAKS: f64 = 1.8;

/// The comparison.
pub(super) struct Judged<'a> {
    pub(super) table: &'a TripTotals,
    pub(super) rows: &'a Rows,
    pub(super) posterior: &'a Posterior,
    pub(super) curb_kg: f64,
    /// Mean consumption of the table, and of the study that nothing has been fitted of.
    pub(super) level: [f64; 2],
    /// How far speeds lie the way that breaks move them, in SDs of the fleets of the design; none
    /// without driving times.
    pub(super) breaks: Option<f64>,
    pub(super) unit: &'static str,
}

pub(super) fn judge(judged: &Judged) -> Vec<Finding> {
    let mut findings: Vec<Finding> =
        [weights(judged), level(judged), slow(judged), durations(judged), unlike(judged)]
            .into_iter()
            .flatten()
            .collect();
    findings.extend(far(judged));
    findings
}

fn weights(Judged { rows, curb_kg, .. }: &Judged) -> Option<Finding> {
    if !rows.has_gross() {
        return None;
    }
    let below = rows.totals.iter().filter(|row| row.gross_kg < EMPTY * curb_kg).count();
    let share = below as f64 / rows.totals.len() as f64;
    let text = format!(
        "{} % of the gross weights are below {} % of the empty truck's {} kg",
        percent(share),
        100.0 * EMPTY,
        rounded(*curb_kg)
    );
    let remedy = "are they payloads? Call the column payload_kg (--map payload_kg=COLUMN)";
    (share > MOST_BELOW)
        .then(|| Finding::warned("gross-below-empty", [share, MOST_BELOW], text, remedy))
}

fn level(Judged { table, level: [mean, expected], unit, .. }: &Judged) -> Option<Finding> {
    let ratio = mean / expected;
    let [low, high] = LEVELS;
    let outside = ratio < low || ratio > high;
    let text = format!(
        "the table's mean is {} {unit}: {} % of what the study takes with the same loads, {} \
         {unit}",
        rounded(*mean),
        percent(ratio),
        rounded(*expected)
    );
    let remedy = match table.amount {
        Amount::Litres if ratio < 1.0 => {
            "are the amounts kilograms? A kilogram of diesel is 1.2 L: call the column fuel_kg"
        }
        Amount::Litres => "are the amounts of other trucks, or US gallons or counts among them?",
        Amount::Kilograms if ratio > 1.0 => "are the amounts litres? Call the column fuel_l",
        Amount::Kilograms | Amount::KilowattHours => {
            "compare with what is published of such trucks"
        }
    };
    let bound = if ratio < 1.0 { low } else { high };
    outside.then(|| Finding::warned("unusual-level", [ratio, bound], text, remedy))
}

/// Breaks inside of driving times: some trips that are far too slow, or speeds as breaks leave
/// them.
fn slow(Judged { rows, posterior, breaks, .. }: &Judged) -> Option<Finding> {
    let place = rows.responses.iter().position(|response| *response == Response::Speed)?;
    let below = posterior.residuals.iter().filter(|r| r[place] < SLOW).count();
    let share = below as f64 / posterior.residuals.len() as f64;
    let breaks = breaks.unwrap_or(0.0);
    let remedy = "are breaks, loading or waiting inside? Give driving times without them, or leave \
                  the column out: too slow trips make drag look small";
    if below > 1 && share > MOST_SLOW {
        let text = format!(
            "{} % of the trips are far slower than the others with their loads and lengths",
            percent(share)
        );
        return Some(Finding::warned("slow-trips", [share, MOST_SLOW], text, remedy));
    }
    let text = format!(
        "speeds lie as breaks would have them, {} SDs of the fleets that are plausible: slow and \
         wide apart, most on short trips",
        rounded(breaks)
    );
    (breaks > MOST_BREAKS)
        .then(|| Finding::warned("slow-trips", [breaks, MOST_BREAKS], text, remedy))
}

fn durations(Judged { table, rows, .. }: &Judged) -> Option<Finding> {
    let has = table.rows.iter().any(|row| row.duration_s > 0.0);
    let text = "durations may hold breaks, and are not used".to_owned();
    let remedy = "driving times without breaks, as a tachograph has them, tell of drag and speed: \
                  driving_time_h";
    (has && !rows.responses.contains(&Response::Speed))
        .then(|| Finding::noted("durations-with-breaks", [0.0, 0.0], text, remedy))
}

fn unlike(Judged { posterior, .. }: &Judged) -> Option<Finding> {
    let square: f64 = posterior.scores.iter().map(|z| z * z).sum();
    let largest = posterior.scores.iter().fold(0.0_f64, |most, z| most.max(z.abs()));
    let text = format!(
        "the judged numbers had to go far for this table: squares of their scores {}, the largest \
         {}",
        rounded(square),
        rounded(largest)
    );
    let remedy = "is a column another quantity than its name says, or the study of other trucks?";
    let (figure, bound) =
        if largest > MOST_SCORE { (largest, MOST_SCORE) } else { (square, MOST_SQUARE) };
    (figure > bound).then(|| Finding::warned("unlike-the-study", [figure, bound], text, remedy))
}

/// Rows that are far from all others.
fn far(Judged { rows, posterior, .. }: &Judged) -> Option<Finding> {
    let place = rows.responses.iter().position(|response| *response == Response::Consumption)?;
    let all = posterior.residuals.iter().zip(&rows.of_table);
    let mut outliers: Vec<_> = all.filter(|(r, _)| r[place].abs() > FAR).collect();
    outliers.sort_by(|a, b| b.0[place].abs().total_cmp(&a.0[place].abs()));
    let (residual, _) = outliers.first()?;
    let places: Vec<String> =
        outliers.iter().take(5).map(|(_, row)| row.place.to_string()).collect();
    let text = format!(
        "{} of {} rows are far from all others, the first by {} SDs: {}",
        outliers.len(),
        rows.totals.len(),
        rounded(residual[place].abs()),
        places.join(", ")
    );
    let remedy = "are they two trips in one, or two fills for one? They count little";
    Some(Finding::warned("far-row", [residual[place].abs(), FAR], text, remedy))
}
