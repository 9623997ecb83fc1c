//! Data that a report takes from the records, group by group: a report of a million cycles does not
//! hold them.

use super::charging::{Course, keep};
use super::energy::losses;
use super::{EXPLAINING, PAYLOAD, number};
use ocmc_core::energy::Carrier;
use ocmc_core::record::{Outcome, Record};
use ocmc_fleet::quantity::{CONSUMPTIONS, RecordQuantity, quantity};
use ocmc_fleet::range::{RangeTrip, SEASONS, season_of};

/// Cycles that are listed at each end, and of each kind of failure.
pub(super) const LISTED: usize = 5;

/// Candidates for the ends that wait until they are sorted.
const WAITING: usize = 512;

/// Data that were taken from the records.
#[derive(Clone, Debug, Default)]
pub struct Gathered {
    /// Sums over the completed cycles.
    pub(super) sums: Sums,
    /// The same of each season, in their order, of trips that were charged by a policy.
    pub(super) by_season: [Sums; SEASONS.len()],
    /// Evidence of such trips on the range.
    pub(super) range_trips: Vec<RangeTrip>,
    /// The state of charge along some of them.
    pub(super) courses: Vec<Course>,
    /// The columns that may explain the consumption, NaN where a cycle has none.
    explaining: [Vec<f64>; EXPLAINING.len()],
    consumptions: [Consumption; CONSUMPTIONS.len()],
    /// Ids of the first cycles of each outcome.
    first: [Vec<u64>; Outcome::ALL.len()],
}

/// Sums over the completed cycles; none where no cycle has a number.
#[derive(Clone, Debug, Default)]
pub(super) struct Sums {
    pub(super) trips: u64,
    /// Energy that all stores gave, in J, and whether a carrier is among them.
    pub(super) stored_energy_j: Option<f64>,
    pub(super) stores: [bool; Carrier::COUNT],
    /// Energy that batteries gave, in J.
    pub(super) charge_j: Option<f64>,
    pub(super) distance_m: Option<f64>,
    pub(super) duration_s: Option<f64>,
    pub(super) standstill_s: Option<f64>,
    /// Energy of each kind of loss, in their order.
    pub(super) losses_j: Vec<(&'static str, Option<f64>)>,
    /// Distance on urban, rural and motorway roads.
    pub(super) on_m: [Option<f64>; 3],
    /// Whether work was missing at the wheels of any cycle.
    pub(super) is_missing: bool,
}

/// One of the consumptions.
#[derive(Clone, Debug, Default)]
struct Consumption {
    /// Consumption of each cycle, NaN where it has none.
    values: Vec<f64>,
    /// The lowest and the highest ones, and what waits to be sorted among them.
    ends: Vec<(f64, Record)>,
}

impl Gathered {
    /// Takes what is needed of these records.
    pub fn add(&mut self, records: &[Record]) {
        for record in records {
            self.sums.add(record);
            if record.charging_events.is_some() {
                self.by_season[season_of(record.departure_s_of_year)].add(record);
                self.range_trips.extend(RangeTrip::of(record));
                keep(&mut self.courses, record);
            }
            for (column, (name, ..)) in self.explaining.iter_mut().zip(EXPLAINING) {
                column.push(explaining(record, name).unwrap_or(f64::NAN));
            }
            for (consumption, name) in self.consumptions.iter_mut().zip(CONSUMPTIONS) {
                consumption.add(quantity(name).and_then(|q| q.of_cycle(record)), record);
            }
            let place = Outcome::ALL.iter().position(|outcome| *outcome == record.outcome);
            let first = &mut self.first[place.expect("all outcomes")];
            if first.len() < LISTED {
                first.push(record.cycle_id);
            }
        }
    }

    /// The payload, a column that may explain the consumption, by its place, and the consumption.
    pub(super) fn triples(&self, column: usize, quantity: &RecordQuantity) -> Vec<(f64, f64, f64)> {
        let values =
            self.consumption(quantity).into_iter().flat_map(|consumption| &consumption.values);
        let columns = self.explaining[PAYLOAD].iter().zip(&self.explaining[column]);
        let triples = columns.zip(values).map(|((z, x), y)| (*z, *x, *y));
        triples.filter(|(z, x, y)| (z + x + y).is_finite()).collect()
    }

    /// The cycles with the lowest and the highest consumption, from the lowest.
    pub(super) fn ends(&self, quantity: &RecordQuantity) -> Vec<(f64, Record)> {
        let Some(consumption) = self.consumption(quantity) else { return Vec::new() };
        let mut ends = consumption.ends.clone();
        keep_ends(&mut ends);
        ends
    }

    /// The cycle in the middle of a quantity, and its value; `first` is the id of the first cycle.
    pub(super) fn middle(&self, quantity: &RecordQuantity, first: u64) -> Option<(u64, f64)> {
        let values = &self.consumption(quantity)?.values;
        let mut places: Vec<usize> = (0..values.len()).filter(|k| values[*k].is_finite()).collect();
        places.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
        let place = *places.get(places.len() / 2)?;
        Some((first + place as u64, values[place]))
    }

    /// Ids of the first cycles that ended so.
    pub(super) fn first(&self, outcome: Outcome) -> &[u64] {
        let place = Outcome::ALL.iter().position(|known| *known == outcome);
        &self.first[place.expect("all outcomes")]
    }

    fn consumption(&self, quantity: &RecordQuantity) -> Option<&Consumption> {
        let place = CONSUMPTIONS.iter().position(|name| *name == quantity.column)?;
        Some(&self.consumptions[place])
    }
}

/// The value of a column that may explain the consumption, per km where it grows with the distance.
pub(super) fn explaining(record: &Record, name: &str) -> Option<f64> {
    let per_distance = EXPLAINING.iter().any(|(column, .., per_km)| *column == name && *per_km);
    let x = number(record, name)?;
    Some(if per_distance { x / (record.distance_m / 1000.0) } else { x })
}

impl Consumption {
    fn add(&mut self, value: Option<f64>, record: &Record) {
        self.values.push(value.unwrap_or(f64::NAN));
        let Some(value) = value else { return };
        self.ends.push((value, record.clone()));
        if self.ends.len() == WAITING {
            keep_ends(&mut self.ends);
        }
    }
}

/// Sorts, and keeps what is listed at each end; of equal values those that came first are lower.
fn keep_ends(ends: &mut Vec<(f64, Record)>) {
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    if ends.len() > 2 * LISTED {
        ends.drain(LISTED..ends.len() - LISTED);
    }
}

impl Sums {
    fn add(&mut self, record: &Record) {
        if record.outcome != Outcome::Completed {
            return;
        }
        self.trips += 1;
        sum(&mut self.stored_energy_j, record.stored_energy_j());
        sum(&mut self.charge_j, record.amount(Carrier::Electricity));
        for declared in record.carriers() {
            self.stores[declared.carrier as usize] = true;
        }
        sum(&mut self.distance_m, Some(record.distance_m));
        sum(&mut self.duration_s, Some(record.duration_s));
        sum(&mut self.standstill_s, Some(record.standstill_s));
        if self.losses_j.is_empty() {
            self.losses_j.extend(losses(record).map(|(name, _)| (name, None)));
        }
        for ((_, total), (_, energy)) in self.losses_j.iter_mut().zip(losses(record)) {
            sum(total, energy);
        }
        let shares = [record.urban_share, record.rural_share, record.motorway_share];
        for (total, share) in self.on_m.iter_mut().zip(shares) {
            sum(total, share.map(|share| share * record.distance_m));
        }
        self.is_missing |= record.missing_energy_j > Some(0.0);
    }
}

fn sum(total: &mut Option<f64>, value: Option<f64>) {
    if let Some(value) = value {
        *total = Some(total.map_or(value, |total| total + value));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::examples;
    use ocmc_fleet::quantity::WHEEL;

    #[test]
    fn the_ends_are_those_of_all_cycles_however_they_arrive() {
        let mut records = examples::records(5000);
        for (k, record) in records.iter_mut().enumerate() {
            record.outcome = Outcome::Completed;
            record.wheel_kwh_per_km = ((k * 7919) % 640) as f64;
        }
        let wheel = quantity(WHEEL).expect("a quantity");
        let mut sorted: Vec<(f64, Record)> =
            records.iter().map(|r| (r.wheel_kwh_per_km, r.clone())).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        sorted.drain(LISTED..5000 - LISTED);
        let mut gathered = Gathered::default();
        records.chunks(997).for_each(|group| gathered.add(group));
        assert!(gathered.ends(wheel) == sorted);
        assert_eq!(gathered.triples(PAYLOAD, wheel).len(), 5000);
    }
}
