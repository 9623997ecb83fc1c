//! The check on the trips that a study was not learnt from.

use crate::calibrate_totals::{CalibrateTotalsAnswer, HeldBackTrip};
use serde::Serialize;

/// A check on trips that were held back.
#[derive(Clone, Debug, Serialize)]
pub struct HeldBack {
    /// Trips that it was learnt from.
    pub learnt_from: usize,
    /// Name of the consumption.
    pub column: String,
    /// Consumption of the trips together, as measured.
    pub measured: f64,
    /// Expectation for them with their weights and lengths.
    pub expected: f64,
    /// Trips within the interval that holds 90 % of such trips.
    pub within: usize,
    /// The trips.
    pub trips: Vec<HeldBackTrip>,
}

impl HeldBack {
    /// Makes the check of trips; none where there are none.
    pub(super) fn new(answer: &CalibrateTotalsAnswer, trips: &[HeldBackTrip]) -> Option<Self> {
        let length_m: f64 = trips.iter().map(|trip| trip.length_m).sum();
        let over = |value_of: fn(&HeldBackTrip) -> f64| {
            trips.iter().map(|trip| value_of(trip) * trip.length_m).sum::<f64>() / length_m
        };
        let is_within = |trip: &&HeldBackTrip| {
            (trip.interval90[0]..=trip.interval90[1]).contains(&trip.measured)
        };
        (!trips.is_empty()).then(|| Self {
            learnt_from: answer.rows,
            column: answer.column.clone(),
            measured: over(|trip| trip.measured),
            expected: over(|trip| trip.expected),
            within: trips.iter().filter(is_within).count(),
            trips: trips.to_vec(),
        })
    }
}
