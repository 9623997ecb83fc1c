//! The rows of a table of totals as a question takes them, and the trips of a simulated fleet as
//! such rows.

use crate::error::Error;
use crate::source::Source;
use ocmc_core::record::{self, Record};
use ocmc_estimation::calibration::totals::{Response, TotalsRow};
use ocmc_fleet::quantity::{LITRES, NamedQuantity};
use ocmc_io::label::label;
use ocmc_io::trip_totals::{Amount, TripTotal, TripTotals};
use serde_json::{Value, json};

/// Most values of a law that is written: quantiles of more rows.
const MOST_VALUES: usize = 200;
/// Share of lengths within which a table has one length.
const SAME_LENGTH: f64 = 0.01;
/// Longest distance of a trip over which a truck neither stalls nor idles, in m: shorter rows are
/// no trips.
const SHORTEST_M: f64 = 2000.0;

/// Noise of a table's numbers, SD as a share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Noise of the amount of fuel or energy.
    pub amount: f64,
    /// Noise of the gross weight.
    pub weight: f64,
}

/// 3 % of an amount are what a tank's gauge or a pump's rounding leave, 5 % of a weight those of a
/// truck's axles (judgement).
impl Default for Noise {
    fn default() -> Self {
        Self { amount: 0.03, weight: 0.05 }
    }
}

impl Noise {
    pub(crate) fn check(&self) -> Result<(), Error> {
        for (name, value) in [("amount_noise", self.amount), ("weight_noise", self.weight)] {
            if !(0.0..=0.5).contains(&value) {
                return Err(Error::SmallShare { name, value });
            }
        }
        Ok(())
    }
}

/// The rows that count.
pub(crate) struct Rows {
    pub(crate) totals: Vec<TotalsRow>,
    /// The rows of the table, in the same order.
    pub(crate) of_table: Vec<TripTotal>,
    /// Consumption of each, in the unit of the quantity.
    pub(crate) consumption: Vec<f64>,
    /// Gross weights, their spread without that of their noise.
    pub(crate) gross_kg: Option<Vec<f64>>,
    /// Payloads that the table has instead.
    pub(crate) payload_kg: Option<Vec<f64>>,
    /// Lengths; none of ways between fills, which are no trips.
    pub(crate) lengths_m: Option<Vec<f64>>,
    /// The responses that the table has.
    pub(crate) responses: Vec<Response>,
    /// Rows without what the others have.
    pub(crate) incomplete: usize,
}

impl Rows {
    /// The rows of a table; `per_distance`: consumption of an amount over a metre. `trip_m`: the
    /// length of a trip, where a row is a way between fills.
    pub(crate) fn new(
        table: &TripTotals,
        noise: &Noise,
        curb_kg: f64,
        trip_m: f64,
        consumption: impl Fn(Amount, f64) -> f64,
    ) -> Self {
        let most = |has: &dyn Fn(&TripTotal) -> bool| {
            2 * table.rows.iter().filter(|row| has(row)).count() > table.rows.len()
        };
        let has_payload = |row: &TripTotal| row.payload_kg.is_finite();
        let has_gross = |row: &TripTotal| row.gross_kg > 0.0 || row.payload_kg.is_finite();
        let of_payload = most(&has_payload) && !most(&|row| row.gross_kg > 0.0);
        let weights = most(&has_gross);
        let speed = !table.of_fills && most(&|row| row.driving_s > 0.0);
        let climb = !table.of_fills && most(&|row| row.climb_m > 0.0);
        let known = |row: &&TripTotal| {
            row.distance_m >= SHORTEST_M
                && (!weights || has_gross(row))
                && (!speed || row.driving_s > 0.0)
                && (!climb || row.climb_m > 0.0)
        };
        let of_table: Vec<TripTotal> = table.rows.iter().filter(known).cloned().collect();
        let consumption: Vec<f64> = (of_table.iter())
            .map(|row| consumption(table.amount, row.amount / row.distance_m))
            .collect();
        let gross = |row: &TripTotal| {
            if row.gross_kg > 0.0 { row.gross_kg } else { row.payload_kg + curb_kg }
        };
        let rows: Vec<TotalsRow> = (of_table.iter().zip(&consumption))
            .map(|(row, consumption)| TotalsRow {
                gross_kg: if weights { gross(row) } else { 0.0 },
                length_m: row.distance_m,
                responses: [
                    libm::log(row.climb_m / row.distance_m),
                    libm::log(row.distance_m / row.driving_s),
                    libm::log(*consumption),
                ],
                trips: if table.of_fills { (row.distance_m / trip_m).max(1.0) } else { 1.0 },
            })
            .collect();
        let mut responses = vec![Response::Consumption];
        responses.extend(speed.then_some(Response::Speed));
        responses.extend(climb.then_some(Response::Climb));
        responses.sort();
        let net = || shrunk(&rows.iter().map(|row| row.gross_kg).collect::<Vec<_>>(), noise.weight);
        let lengths = || rows.iter().map(|row| row.length_m).collect::<Vec<f64>>();
        let gross_kg = (weights && !table.of_fills && !of_payload).then(net);
        let payload_kg = (of_payload && !table.of_fills)
            .then(|| of_table.iter().map(|row| row.payload_kg.max(0.0)).collect());
        let incomplete = table.rows.len() - of_table.len();
        let lengths_m = (!table.of_fills).then(lengths);
        Self {
            totals: rows,
            of_table,
            consumption,
            gross_kg,
            payload_kg,
            lengths_m,
            responses,
            incomplete,
        }
    }

    /// Lengths of the rows, in m.
    pub(crate) fn lengths(&self) -> Vec<f64> {
        self.totals.iter().map(|row| row.length_m).collect()
    }

    /// Consumptions, their spread without that of the noise of the amounts.
    pub(crate) fn without_noise(&self, noise: &Noise) -> Vec<f64> {
        shrunk(&self.consumption, noise.amount)
    }

    /// Whether the gross weights are known.
    pub(crate) fn has_gross(&self) -> bool {
        self.totals.first().is_some_and(|row| row.gross_kg > 0.0)
    }

    /// The laws of payload and length that the table has, for a truck of this mass.
    pub(crate) fn laws(&self, curb_kg: f64, most_kg: Option<f64>) -> Vec<(String, Value)> {
        let mut laws = Vec::new();
        let payload = match (&self.gross_kg, &self.payload_kg) {
            (Some(gross), _) => {
                let most_kg = most_kg.unwrap_or(f64::INFINITY) - curb_kg;
                let payload = |gross: &f64| (gross - curb_kg).clamp(0.0, most_kg);
                Some(gross.iter().map(payload).collect::<Vec<f64>>())
            }
            (None, payload) => payload.clone(),
        };
        if let Some(payload) = payload {
            laws.push(("mission.payload_kg".to_owned(), empirical(&thinned(payload, 1.0))));
        }
        if let Some(lengths) = &self.lengths_m {
            let thinned = thinned(lengths.clone(), 10.0);
            let (first, last) = (thinned[0], thinned[thinned.len() - 1]);
            let law = if last - first <= SAME_LENGTH * last {
                Value::from(lengths.iter().sum::<f64>() / lengths.len() as f64)
            } else {
                empirical(&thinned)
            };
            laws.push(("mission.length_m".to_owned(), law));
        }
        laws
    }
}

/// Consumption, in the unit of the quantity, of an amount over a metre.
pub(crate) fn per_distance(
    trips: &Source,
    table: &TripTotals,
    quantity: &NamedQuantity,
    tasted: &[Record],
) -> Result<impl Fn(Amount, f64) -> f64 + use<>, Error> {
    let electric = label(quantity.column).0.starts_with("kWh");
    if electric != (table.amount == Amount::KilowattHours)
        || (table.amount == Amount::Litres && quantity.column != LITRES)
    {
        let (path, column) = (trips.path().to_owned(), quantity.column.to_owned());
        return Err(Error::OtherCarrier { path, column });
    }
    // litres of the study's fuel for each kilogram
    let of_kg = tasted.iter().find_map(|record| {
        let kg = record::column("fuel_kg")?.get(record).number()?;
        Some(quantity.of_cycle(record)? * record.distance_m / kg / 1e5)
    });
    let litres_per_kg = if quantity.column == LITRES { of_kg.unwrap_or(1.0) } else { 1.0 };
    Ok(move |amount, per_m| match amount {
        Amount::Litres => 1e5 * per_m,
        Amount::Kilograms => 1e5 * litres_per_kg * per_m,
        Amount::KilowattHours => 1e3 * per_m,
    })
}

/// An empirical law of values.
pub(crate) fn empirical(values: &[f64]) -> Value {
    json!({ "distribution": "empirical", "values": values })
}

/// Values with the spread that noise of this SD, as a share of each, has added taken off, about
/// their mean.
fn shrunk(values: &[f64], noise: f64) -> Vec<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n;
    let added = values.iter().map(|v| noise * noise * v * v).sum::<f64>() / n;
    let factor =
        if variance > 0.0 { libm::sqrt((1.0 - added / variance).clamp(0.0, 1.0)) } else { 0.0 };
    values.iter().map(|v| mean + factor * (v - mean)).collect()
}

/// The values in order, rounded to a step; of many, as many means of neighbours as a law may have.
pub(crate) fn thinned(mut values: Vec<f64>, step: f64) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    let count = values.len().min(MOST_VALUES);
    let bound = |k: usize| k * values.len() / count;
    let mean = |k: usize| {
        let group = &values[bound(k)..bound(k + 1)];
        let mean = group.iter().sum::<f64>() / group.len() as f64;
        step * libm::round(mean / step)
    };
    (0..count).map(mean).collect()
}

/// A simulated trip as a row of a table with noise; none where it did not arrive. `errors`: normal
/// draws for the amount and the weight.
pub(crate) fn totals(
    record: &Record,
    curb_kg: f64,
    quantity: &NamedQuantity,
    noise: &Noise,
    errors: [f64; 2],
) -> Option<TotalsRow> {
    let consumption = quantity.of_cycle(record)?;
    let [amount, weight] = errors;
    let driving_s = record.duration_s - record.rest_s.unwrap_or(0.0);
    let gross_kg = (curb_kg + record.mean_payload_kg) * (1.0 + noise.weight * weight);
    Some(TotalsRow {
        gross_kg,
        length_m: record.distance_m,
        responses: [
            libm::log((record.climb_m / record.distance_m).max(1e-6)),
            libm::log(record.distance_m / driving_s),
            libm::log(consumption.max(1e-9)) + noise.amount * amount,
        ],
        trips: 1.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_of_noise_is_taken_off_and_the_mean_stays() {
        // by hand: mean 20, variance 100, noise of 10 % adds 0.01 × 500 = 5: √0.95 of the spread
        let shrunk_values = shrunk(&[10.0, 30.0], 0.1);
        let half = 10.0 * libm::sqrt(0.95);
        assert!(
            (shrunk_values[0] - (20.0 - half)).abs() < 1e-12
                && (shrunk_values[1] - 20.0 - half).abs() < 1e-12
        );
        assert_eq!(shrunk(&[5.0, 5.0], 0.1), [5.0, 5.0]);
        let many: Vec<f64> = (0..1000).map(f64::from).collect();
        let few = thinned(many, 0.5);
        assert!(few.len() == 200 && few[0] == 2.0 && few[199] == 997.0);
    }
}
