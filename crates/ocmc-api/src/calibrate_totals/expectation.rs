//! The expectation of a calibrated study for a trip of known weight and length, and how far a
//! measured trip is from it.

use crate::totals_rows::{Noise, Rows, totals};
use ocmc_core::random::{Draws, Stream};
use ocmc_core::record::Record;
use ocmc_estimation::calibration::totals::{Emulator, Known, Member, Response, TotalsRow};
use ocmc_fleet::quantity::NamedQuantity;
use serde::Serialize;

/// Key of the draws of noise: no member of a design has it.
const NOISE: u64 = 1 << 32;

/// Simulated trips of a study with the noise of a table, as they are expected given what is known
/// of a trip.
pub(super) struct Expectation {
    emulator: Emulator,
    /// Residuals of the simulated trips over their SDs, in order.
    residuals: Vec<f64>,
    /// Logarithm of the factor on the consumption.
    shift: f64,
    /// Variance of the level over that of a trip: the rows that it was calibrated on are few.
    of_level: f64,
}

/// A trip that a study was not learnt from, and what the study says of such a trip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HeldBackTrip {
    /// Consumption, in the unit of the quantity.
    pub measured: f64,
    /// Expectation of the study for a trip of its weight and length.
    pub expected: f64,
    /// The interval that holds 90 % of such trips.
    pub interval90: [f64; 2],
    /// Length, in m.
    pub length_m: f64,
}

impl Expectation {
    /// Expectation by the trips of a study, `factor` times as they are; `noise`: of the table, and
    /// the seed.
    pub(super) fn new(
        rows: &Rows,
        records: &[Record],
        quantity: &NamedQuantity,
        (noise, seed): (&Noise, u64),
        factor: Option<f64>,
        curb_kg: f64,
    ) -> Self {
        let mut draws = Draws::new(seed, NOISE, Stream::Calibration);
        let trips = records.iter().filter_map(|record| {
            let errors = [draws.normal(), draws.normal()];
            totals(record, curb_kg, quantity, noise, errors)
        });
        let members = [Member { scores: Vec::new(), trips: trips.collect() }];
        let known = Known { gross: rows.has_gross(), responses: vec![Response::Consumption] };
        let emulator = Emulator::fit(&members, &known).expect("trips that arrive");
        let standardised = |trip: &TotalsRow| {
            let (residual, sd) = emulator.consumption(trip);
            residual / sd
        };
        let mut residuals: Vec<f64> = members[0].trips.iter().map(standardised).collect();
        residuals.sort_by(f64::total_cmp);
        let shift = libm::log(factor.unwrap_or(1.0));
        Self { emulator, residuals, shift, of_level: 1.0 / rows.totals.len() as f64 }
    }

    /// The rows of a table, each beside what is expected of it; none where nothing is known of
    /// their weights and is of those that it was calibrated on.
    pub(super) fn of(&self, rows: &Rows) -> Vec<HeldBackTrip> {
        let is_known = rows.has_gross() || !self.emulator.known().gross;
        rows.totals.iter().filter(|_| is_known).map(|row| self.of_row(row)).collect()
    }

    fn of_row(&self, row: &TotalsRow) -> HeldBackTrip {
        let (residual, sd) = self.emulator.consumption(row);
        let sd = sd * libm::sqrt(1.0 / row.trips + self.of_level);
        let [low, high] = [0.05, 0.95].map(|p| super::shape::quantile(&self.residuals, p));
        let ln = row.responses[Response::Consumption as usize];
        let ln_expected = ln - residual + self.shift;
        HeldBackTrip {
            measured: libm::exp(ln),
            expected: libm::exp(ln_expected),
            interval90: [low, high].map(|place| libm::exp(ln_expected + sd * place)),
            length_m: row.length_m,
        }
    }
}
