//! Totals of trucks that make several trips: each in a month and in a year, and their fleet in a
//! year.
//!
//! A truck's value of a quantity is its total over its total, as the fleet's is: Σ y / Σ x over the
//! trips of the time that count ([`super::quantity::RecordQuantity::of_cycle`]). Means and
//! quantiles over truck-years count each of them once.
//!
//! The total of the fleet's year is T = Σ t over its trucks; that of another fleet of as many
//! trucks lies in T ± t₀.₉₇₅(n − 1) s √(2 n), s the standard deviation of the trucks' totals: the
//! drawn trucks are no more than a sample of those that there could be, either time.
//!
//! Where trucks share drivers of a pool, or days, the truck-years depend on one another through
//! their trips. A mean v̄ over N truck-years moves by u_i = (y_i − v̄ x_i)/(X_t N) with a trip of a
//! truck-year whose Σ x is X_t, and by Σ u_i over the clusters of [`super::clustering`]. What is
//! shared moves all trucks alike, so that it widens the interval of a quantile by as much as that
//! of the mean. The total of the fleet's year moves by u_i = t_i − (T/n)/m with a trip of a truck
//! that makes m of them, and that of another fleet, with drivers and days of its own, by √2 as
//! much.

use super::clustering::{Clusters, Spread as Error};
use super::components::{Components, Spread, components};
use super::dependence::Dependence;
use super::parts::add_known;
use super::quantity::{CONSUMPTIONS, QUANTITIES, quantity};
use super::ratio::{Ratio, student_975};
use super::statistic::{Statistic, by_name, standard_deviation};
use ocmc_core::energy::carrier::{CARRIERS, Carrier};
use ocmc_core::random::nesting::DAYS_OF_YEAR;
use ocmc_core::record::{Outcome, Record};
use schemars::JsonSchema;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;

/// Totals of the trips of one truck in a month or a year, of what they drove where a battery cut
/// them short.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TruckTime {
    /// The truck.
    pub truck_id: u64,
    /// The year, from 0; there is but one where trips draw their days.
    pub year: u64,
    /// The month, from 0 for January; of a year none.
    pub month: Option<u64>,
    /// Completed trips.
    pub n_trips: u64,
    /// Trips that were not completed; those that stalled or timed out are not in the totals.
    pub n_failed: u64,
    /// Distance, in m.
    pub distance_m: f64,
    /// Duration, in s.
    pub duration_s: f64,
    /// Payload times distance, in kg m.
    pub payload_distance_kgm: f64,
    /// Work at the wheels, in J.
    pub wheel_energy_j: f64,
    /// Amount taken of each carrier.
    pub taken: [Option<f64>; Carrier::COUNT],
    /// The same in the unit of sale.
    pub sold: [Option<f64>; Carrier::COUNT],
    /// Carbon dioxide from burning the fuel, in kg.
    pub co2_kg: Option<f64>,
    /// Greenhouse gases from the well to the wheel, in kg of CO2 equivalents.
    pub well_to_wheel_kg: Option<f64>,
    /// Cost in the currency of the study, at the centres of its prices.
    pub cost: Option<f64>,
    /// Trips in the totals.
    n_counted: u64,
    /// Both totals of each quantity's mean.
    totals: [(f64, f64); QUANTITIES.len()],
    /// Σ y², Σ x y and Σ x² of the consumption's totals, for its interval.
    products: [f64; 3],
}

impl TruckTime {
    fn add(&mut self, record: &Record, cost: Option<f64>) {
        let completed = record.outcome == Outcome::Completed;
        self.n_trips += u64::from(completed);
        self.n_failed += u64::from(!completed);
        if !record.outcome.counts() {
            return;
        }
        self.n_counted += 1;
        self.distance_m += record.distance_m;
        self.duration_s += record.duration_s;
        self.payload_distance_kgm += record.payload_kg * record.distance_m;
        self.wheel_energy_j += record.wheel_energy_j;
        let km = record.distance_m / 1000.0;
        for (k, declared) in CARRIERS.iter().enumerate() {
            let amount = record.amount(declared.carrier);
            let consumption = record.consumption(declared.carrier);
            add_known(&mut self.taken[k], amount);
            let in_litres = consumption.map(|litres| litres * km / 100.0);
            add_known(&mut self.sold[k], if declared.sold.is_some() { in_litres } else { amount });
        }
        let kg = |grams: Option<f64>| grams.map(|grams| grams * km / 1000.0);
        add_known(&mut self.co2_kg, kg(record.co2_g_per_km));
        add_known(&mut self.well_to_wheel_kg, kg(record.well_to_wheel_g_per_km));
        add_known(&mut self.cost, cost);
        let consumption = CONSUMPTIONS.iter().find_map(|column| quantity(column)?.totals(record));
        if let Some((y, x)) = consumption {
            for (product, part) in self.products.iter_mut().zip([y * y, x * y, x * x]) {
                *product += part;
            }
        }
        for (quantity, total) in QUANTITIES.iter().zip(&mut self.totals) {
            if let Some((y, x)) = quantity.totals(record) {
                total.0 += y;
                total.1 += x;
            }
        }
    }

    /// A quantity of the truck: total over total.
    pub(crate) fn value(&self, quantity: usize) -> Option<f64> {
        let (y, x) = self.totals[quantity];
        (x > 0.0).then(|| y / x)
    }

    /// Its consumption, and the 95 % interval that the chance of its trips leaves: of other trips
    /// of the same truck, as of a ratio of totals ([`super::ratio`]). None below two trips.
    pub fn consumption(&self) -> Option<(f64, [f64; 2])> {
        let places = CONSUMPTIONS
            .iter()
            .map(|column| QUANTITIES.iter().position(|quantity| quantity.column == *column));
        let (value, (_, sum_x)) =
            places.flatten().find_map(|k| Some((self.value(k)?, self.totals[k])))?;
        let n = self.n_counted as f64;
        if n < 2.0 {
            return None;
        }
        let [yy, xy, xx] = self.products;
        // Σ (y − R x)², which rounding may bring below zero
        let squares = (yy - 2.0 * value * xy + value * value * xx).max(0.0);
        let error = libm::sqrt(n / (n - 1.0) * squares) / sum_x;
        let far = student_975(n - 1.0) * error;
        Some((value, [value - far, value + far]))
    }
}

/// Last days of the months of a year of 365 days.
const MONTH_ENDS: [u64; 12] = [31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334, 365];

/// Seconds of a day.
const DAY_S: f64 = 86_400.0;

/// Collects trips, in the order of their cycles, into months and years of trucks.
#[derive(Clone, Debug, Default)]
pub struct TruckYearBuilder {
    years: Vec<TruckTime>,
    months: Vec<TruckTime>,
    /// Value of the consumption of each trip that counts: count, sum and squares about a truck's
    /// own first value, by truck.
    spread: Vec<Spread>,
    /// The trips that count, where trucks share drivers or days.
    trips: Vec<SharedTrip>,
}

/// A trip of trucks that share drivers or days.
#[derive(Clone, Copy, Debug)]
struct SharedTrip {
    /// Places of its year and its month in the tables.
    places: [usize; 2],
    /// Contributions to the totals of the fleet's year, in their order; NaN where it has none.
    amounts: [f64; Totals::COUNT],
}

/// Contributions of trips to the two totals of each quantity's mean.
pub(super) struct TripTotals<'a> {
    /// In which clusters they are.
    pub(super) clusters: &'a Clusters,
    /// Ids of the trips that count, in their order.
    pub(super) cycle_ids: &'a [u64],
    /// Contributions to a quantity, (cycle id, y, x) of the trips that have it.
    pub(super) parts: &'a dyn Fn(usize) -> Vec<(u64, f64, f64)>,
}

impl SharedTrip {
    fn of(record: &Record, cost: Option<f64>, places: [usize; 2]) -> Self {
        let mut time = TruckTime::default();
        time.add(record, cost);
        let amounts = Totals::amounts(&time).map(|amount| amount.unwrap_or(f64::NAN));
        Self { places, amounts }
    }
}

impl TruckYearBuilder {
    /// Adds the next trip, and what it cost.
    pub fn add(&mut self, record: &Record, cost: Option<f64>, dependence: Dependence) {
        let trips = dependence.trips_per_truck;
        let (truck_id, trip) = (record.cycle_id / trips, record.cycle_id % trips);
        let year = dependence.days.map_or(0, |days| days.day_of(trip) / DAYS_OF_YEAR);
        let day = (record.departure_s_of_year / DAY_S) as u64 % DAYS_OF_YEAR;
        let month = MONTH_ENDS.iter().position(|end| day < *end).unwrap_or(11) as u64;
        let mut places = [0; 2];
        let tables = [(&mut self.years, None), (&mut self.months, Some(month))];
        for ((times, month), place) in tables.into_iter().zip(&mut places) {
            // trips that draw their days come in no order of months
            let own = times.iter().rev().take_while(|time| time.truck_id == truck_id);
            let own = own.take_while(|time| time.year == year);
            let before = own.clone().position(|time| time.month == month);
            let before = before.unwrap_or_else(|| {
                times.push(TruckTime { truck_id, year, month, ..TruckTime::default() });
                0
            });
            *place = times.len() - 1 - before;
            times[*place].add(record, cost);
        }
        if dependence.is_shared() && record.outcome.counts() {
            self.trips.push(SharedTrip::of(record, cost, places));
        }
        let value = CONSUMPTIONS.iter().find_map(|column| quantity(column)?.of_cycle(record));
        if let Some(value) = value {
            if self.spread.last().is_none_or(|last| !last.is_of(truck_id)) {
                self.spread.push(Spread::of(truck_id));
            }
            self.spread.last_mut().expect("pushed").add(value);
        }
    }

    /// Sums up; none where no truck has a trip.
    pub(super) fn finish(
        self,
        dependence: Dependence,
        totals: &TripTotals,
        currency: Option<&str>,
    ) -> Option<TruckSummary> {
        let trucks = self.years.iter().map(|time| time.truck_id);
        let mut trucks: Vec<u64> = trucks.collect();
        trucks.dedup();
        if trucks.is_empty() {
            return None;
        }
        let trucks_of_batch = dependence.batch / dependence.trips_per_truck;
        let years = 1 + self.years.iter().map(|time| time.year).max().unwrap_or(0);
        // a truck's months and years are not independent of one another
        let statistics = |times: &[TruckTime], each: u64, table: usize| {
            let batch = trucks_of_batch.max(1) * each;
            let of_trucks = Dependence { batch, ..Dependence::default() };
            let of_quantity = |k: usize| {
                let values = times.iter().filter_map(|time| {
                    let number = time.month.map_or(time.year, |month| 12 * time.year + month);
                    Some((time.truck_id * each + number, time.value(k)?))
                });
                let pairs = of_trucks.batch_totals(values.clone().map(|(id, v)| (id, v, 1.0)));
                let mean = Ratio::estimate(pairs.into_iter());
                let statistic =
                    Statistic::new(QUANTITIES[k].column, mean, &values, &of_trucks.into());
                if !dependence.is_shared() {
                    return statistic;
                }
                statistic.with(self.error_of_mean(times, table, k, totals))
            };
            (0..QUANTITIES.len()).map(of_quantity).collect::<Vec<_>>()
        };
        let truck_months = statistics(&self.months, 12 * years, 1);
        let truck_years = statistics(&self.years, years, 0);
        let is_shared = dependence.is_shared();
        let totals = Totals::of(&self.years, trucks.len(), years, is_shared, |k, total| {
            self.error_of_total(k, total, trucks.len(), years, totals)
        });
        let components = components(&self.spread);
        Some(TruckSummary {
            trucks: trucks.len() as u64,
            years,
            truck_months,
            truck_years,
            totals,
            currency: currency.map(str::to_owned),
            components,
            by_month: by_month(&self.months),
            note: SHARED[usize::from(dependence.pool.is_some())]
                [usize::from(dependence.shares_days)],
            rows: self.years,
        })
    }

    /// How sure the mean of a quantity over truck-years, or truck-months, is.
    fn error_of_mean(
        &self,
        times: &[TruckTime],
        table: usize,
        quantity: usize,
        totals: &TripTotals,
    ) -> Option<Error> {
        let values: Vec<f64> = times.iter().filter_map(|time| time.value(quantity)).collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let mut row = 0;
        let influences = (totals.parts)(quantity).into_iter().map(|(id, y, x)| {
            while totals.cycle_ids[row] < id {
                row += 1;
            }
            let (_, sum_x) = times[self.trips[row].places[table]].totals[quantity];
            let of_truck = if sum_x > 0.0 { (y - mean * x) / sum_x } else { 0.0 };
            (id, of_truck / n)
        });
        totals.clusters.spread(influences)
    }

    /// How sure a total of the fleet's year is.
    fn error_of_total(
        &self,
        amount: usize,
        total: f64,
        trucks: usize,
        years: u64,
        totals: &TripTotals,
    ) -> Option<Error> {
        let trips = self.trips.iter().zip(totals.cycle_ids).map(|(trip, id)| {
            let truck_id = self.years[trip.places[0]].truck_id;
            (truck_id, *id, trip.amounts[amount] / years as f64)
        });
        error_of_total(&trips.collect::<Vec<_>>(), total / trucks as f64, totals.clusters)
    }
}

/// How sure a total of trips is, (truck, cycle id, amount) in the order of their trucks, of which
/// each has `of_truck` in the mean. A trip differs by its amount less its share of that.
fn error_of_total(trips: &[(u64, u64, f64)], of_truck: f64, clusters: &Clusters) -> Option<Error> {
    let by_truck = trips.chunk_by(|a, b| a.0 == b.0);
    clusters.spread(by_truck.flat_map(|trips| {
        let each = of_truck / trips.len() as f64;
        trips.iter().map(move |(_, id, amount)| (*id, amount - each))
    }))
}

/// The consumption of all trucks in each month, total over total.
fn by_month(months: &[TruckTime]) -> [Option<f64>; 12] {
    let own = CONSUMPTIONS.iter().find_map(|column| {
        let place = QUANTITIES.iter().position(|quantity| quantity.column == *column)?;
        months.iter().any(|time| time.totals[place].1 > 0.0).then_some(place)
    });
    let mut sums = [(0.0, 0.0); 12];
    for time in months {
        if let (Some(month), Some(own)) = (time.month, own) {
            let (y, x) = time.totals[own];
            let sum = &mut sums[month as usize % 12];
            *sum = (sum.0 + y, sum.1 + x);
        }
    }
    sums.map(|(y, x)| (x > 0.0).then(|| y / x))
}

/// Summary of the trucks of a fleet.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct TruckSummary {
    /// Trucks.
    pub trucks: u64,
    /// Years that they drive.
    pub years: u64,
    /// The quantities over truck-months.
    #[serde(serialize_with = "by_name")]
    #[schemars(with = "BTreeMap<String, Statistic>")]
    pub truck_months: Vec<Statistic>,
    /// The quantities over truck-years.
    #[serde(serialize_with = "by_name")]
    #[schemars(with = "BTreeMap<String, Statistic>")]
    pub truck_years: Vec<Statistic>,
    /// Totals of the fleet's year.
    #[serde(rename = "fleet_year")]
    #[schemars(with = "BTreeMap<String, Option<Total>>")]
    pub totals: Totals,
    /// Currency of the cost; none of a study without prices.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub currency: Option<String>,
    /// How the consumption of trips is spread; none without two trucks and two trips of one.
    pub components: Option<Components>,
    /// The fleet's consumption in each month of the year, total over total; none where no trip is.
    #[serde(skip)]
    pub by_month: [Option<f64>; 12],
    /// Remark on the intervals that has to be known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<&'static str>,
    /// Each truck-year.
    #[serde(skip)]
    pub rows: Vec<TruckTime>,
}

/// Notes on fleets whose trucks share drivers, days, both.
const SHARED: [[Option<&str>; 2]; 2] = [
    [None, Some("counted by trucks and by the days that they share")],
    [
        Some("counted by trucks and by the drivers of the pool"),
        Some("counted by trucks, by the drivers of the pool and by the days that they share"),
    ],
];

/// Totals of the fleet in a year, the mean over the years that were driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Totals {
    /// Distance, in m.
    pub distance_m: Option<Total>,
    /// Duration, in s.
    pub duration_s: Option<Total>,
    /// Amount taken of each carrier, in the unit of sale.
    pub sold: [Option<Total>; Carrier::COUNT],
    /// Carbon dioxide from burning the fuel, in kg.
    pub co2_kg: Option<Total>,
    /// Greenhouse gases from the well to the wheel, in kg of CO2 equivalents.
    pub well_to_wheel_kg: Option<Total>,
    /// Cost in the currency of the study, at the centres of its prices.
    pub cost: Option<Total>,
}

/// One total of the fleet's year.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Total {
    /// The total.
    pub total: f64,
    /// Where that of another fleet of as many trucks lies, in 95 of 100 cases; none from one truck.
    pub prediction95: Option<[f64; 2]>,
}

impl Total {
    /// Sum of the totals of trucks that share nothing.
    fn of_trucks(totals: &[f64]) -> Self {
        let n = totals.len() as f64;
        let total: f64 = totals.iter().sum();
        let sd = standard_deviation(totals);
        let far = sd.map(|sd| student_975(n - 1.0) * sd * libm::sqrt(2.0 * n));
        Self { total, prediction95: far.map(|far| [total - far, total + far]) }
    }

    /// The same total of trucks that share drivers or days; `error` tells how sure it is.
    fn of_shared(self, error: Option<Error>) -> Self {
        let far = error.map(|error| libm::sqrt(2.0) * error.half_width());
        let prediction95 = far.map(|far| [self.total - far, self.total + far]);
        Self { prediction95, ..self }
    }

    /// Total of trips, (cycle id, amount) in the order of their ids, of trucks that make several.
    pub(super) fn of_trips(
        trips: &[(u64, f64)],
        clusters: &Clusters,
        dependence: Dependence,
    ) -> Self {
        let with_truck =
            |(id, amount): &(u64, f64)| (id / dependence.trips_per_truck, *id, *amount);
        let trips: Vec<(u64, u64, f64)> = trips.iter().map(with_truck).collect();
        let by_truck = trips.chunk_by(|a, b| a.0 == b.0);
        let amount = |trips: &[(u64, u64, f64)]| trips.iter().map(|(_, _, amount)| amount).sum();
        let totals: Vec<f64> = by_truck.map(amount).collect();
        let of_trucks = Self::of_trucks(&totals);
        if !dependence.is_shared() {
            return of_trucks;
        }
        let of_truck = of_trucks.total / totals.len() as f64;
        of_trucks.of_shared(error_of_total(&trips, of_truck, clusters))
    }
}

impl Serialize for Totals {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("distance_m", &self.distance_m)?;
        map.serialize_entry("duration_s", &self.duration_s)?;
        for (declared, total) in CARRIERS.iter().zip(&self.sold) {
            map.serialize_entry(declared.sold().name, total)?;
        }
        map.serialize_entry("co2_kg", &self.co2_kg)?;
        map.serialize_entry("well_to_wheel_kg", &self.well_to_wheel_kg)?;
        if self.cost.is_some() {
            map.serialize_entry("cost", &self.cost)?;
        }
        map.end()
    }
}

impl Totals {
    /// The totals.
    const COUNT: usize = 5 + Carrier::COUNT;

    /// Amounts of a truck: distance, duration, greenhouse gases, cost, then what it took.
    fn amounts(time: &TruckTime) -> [Option<f64>; Self::COUNT] {
        let mut amounts = [None; Self::COUNT];
        let (way_m, time_s) = (Some(time.distance_m), Some(time.duration_s));
        let common = [way_m, time_s, time.co2_kg, time.well_to_wheel_kg, time.cost];
        for (amount, value) in amounts.iter_mut().zip(common.iter().chain(&time.sold)) {
            *amount = *value;
        }
        amounts
    }

    /// `error` tells how sure a total is where trucks share drivers or days.
    fn of(
        years: &[TruckTime],
        trucks: usize,
        count: u64,
        is_shared: bool,
        error: impl Fn(usize, f64) -> Option<Error>,
    ) -> Self {
        let total = |k: usize| {
            let mut totals: Vec<(u64, f64)> = Vec::with_capacity(trucks);
            for time in years {
                let value = Self::amounts(time)[k]? / count as f64;
                match totals.last_mut() {
                    Some((truck_id, sum)) if *truck_id == time.truck_id => *sum += value,
                    _ => totals.push((time.truck_id, value)),
                }
            }
            let total: f64 = totals.iter().map(|(_, value)| value).sum();
            let totals: Vec<f64> = totals.into_iter().map(|(_, value)| value).collect();
            let of_trucks = Total::of_trucks(&totals);
            Some(if is_shared { of_trucks.of_shared(error(k, total)) } else { of_trucks })
        };
        Self {
            distance_m: total(0),
            duration_s: total(1),
            co2_kg: total(2),
            well_to_wheel_kg: total(3),
            cost: total(4),
            sold: std::array::from_fn(|k| total(5 + k)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::assert_share;
    use crate::summary::{Summary, SummaryBuilder};
    use ocmc_core::random::nesting::OperatingDays;
    use ocmc_core::random::{Draws, Stream};

    const TRIPS: u64 = 50;

    fn of_trucks(trips_per_truck: u64) -> Dependence {
        Dependence { batch: trips_per_truck, trips_per_truck, ..Dependence::default() }
    }

    fn trip(cycle_id: u64, litres: f64, km: f64) -> Record {
        Record {
            cycle_id,
            distance_m: 1000.0 * km,
            duration_s: 60.0 * km,
            co2_g_per_km: Some(26.0 * litres),
            ..Record::default()
                .with(Carrier::LiquidFuel, [Some(0.836 * litres * km / 100.0), Some(litres), None])
        }
    }

    /// Trips of trucks whose mean is normal with SD `between` around 30, each trip with SD 5 more.
    fn fleet(seed: u64, trucks: u64, between: f64) -> Vec<Record> {
        let mut draws = Draws::new(seed, 0, Stream::Curve);
        let mut records = Vec::new();
        for truck in 0..trucks {
            let own = 30.0 + between * draws.normal();
            for k in 0..TRIPS {
                records.push(trip(truck * TRIPS + k, own + 5.0 * draws.normal(), 1.0));
            }
        }
        records
    }

    fn summary(records: &[Record], dependence: Dependence) -> Summary {
        let mut fleet = SummaryBuilder::new(dependence);
        fleet.add(records);
        fleet.finish()
    }

    #[test]
    fn what_is_sold_in_its_own_unit_is_what_was_taken() {
        // 125 kWh on 100 km
        let taken = [Some(4.5e8), Some(1.25), None];
        let trip = |cycle_id| Record {
            cycle_id,
            distance_m: 1e5,
            ..Record::default().with(Carrier::Electricity, taken)
        };
        let found = summary(&[0, 1, 2, 3].map(trip), of_trucks(2)).trucks.expect("two trucks");
        for row in &found.rows {
            let k = Carrier::Electricity as usize;
            assert_eq!((row.taken[k], row.sold[k]), (Some(9e8), Some(9e8)));
        }
    }

    #[test]
    fn a_small_fleet_by_hand() {
        let failed = Record { outcome: Outcome::Stalled, ..trip(3, 90.0, 9.0) };
        let records = [trip(0, 20.0, 100.0), trip(1, 40.0, 300.0), trip(2, 30.0, 200.0), failed];
        let trucks = summary(&records, of_trucks(2)).trucks.expect("two trucks");
        // 20 + 120 L over 400 km; 60 L over 200 km
        let values: Vec<_> = trucks.rows.iter().map(|row| row.value(0)).collect();
        assert_eq!(values, [Some(35.0), Some(30.0)]);
        let counts: Vec<_> = trucks.rows.iter().map(|row| (row.n_trips, row.n_failed)).collect();
        assert_eq!(counts, [(2, 0), (1, 1)]);
        // R = 35; residuals 100 (20 − 35) and 300 (40 − 35): se = √(2 · 2 · 1500²)/400 = 7.5
        let (value, [low, high]) = trucks.rows[0].consumption().expect("two trips");
        assert!((value - 35.0).abs() < 1e-12 && ((high - low) / 2.0 / 7.5 - 12.7062).abs() < 1e-3);
        assert_eq!(trucks.rows[1].consumption(), None);
        // 200 L over 600 km, all in January
        assert!((trucks.by_month[0].expect("trips") - 200.0 / 6.0).abs() < 1e-12);
        assert_eq!(trucks.by_month[1..], [None; 11]);
        let fuel = trucks.totals.sold[Carrier::LiquidFuel as usize].expect("fuel");
        assert!((fuel.total - 200.0).abs() < 1e-9);
        // totals 140 and 60: s = 80/√2, t₀.₉₇₅(1) = 12.706, √(2 · 2): 12.706 · 56.569 · 2
        let [low, high] = fuel.prediction95.expect("two trucks");
        assert!(((high - low) / 2.0 - 1437.54).abs() < 0.01, "{low} {high}");
        // truck 0: 20 and 40, truck 1: 30; within 200/1; means 30 and 30: between 0
        let components = trucks.components.expect("three trips");
        assert!((components.within_variance - 200.0).abs() < 1e-9);
        // trips of a truck: 3 - 5/3 = 4/3
        assert!((components.between_variance + 200.0 / (4.0 / 3.0)).abs() < 1e-9);
        assert_eq!((components.between_sd, components.share_of_means), (0.0, 0.0));
    }

    #[test]
    fn trips_fall_into_their_months_and_years() {
        let days = Some(OperatingDays { per_week: 7, trips: 1, departure_interval_s: 0.0 });
        let dependence = Dependence { days, ..of_trucks(730) };
        let records: Vec<Record> = (0..2 * 730)
            .map(|id| Record {
                departure_s_of_year: (id % 730 % 365) as f64 * 86_400.0 + 3600.0,
                ..trip(id, 30.0, 1.0)
            })
            .collect();
        let trucks = summary(&records, dependence).trucks.expect("two trucks");
        assert_eq!((trucks.trucks, trucks.years, trucks.rows.len()), (2, 2, 4));
        assert!(trucks.rows.iter().all(|row| row.n_trips == 365));
        assert_eq!(trucks.truck_months[0].n, 48);
        // the fleet's year, not its two years
        assert!((trucks.totals.distance_m.expect("known").total - 730e3).abs() < 1e-6);
    }

    #[test]
    fn components_are_those_that_were_put_in() {
        const RUNS: u64 = 200;
        let (mut between, mut within) = (0.0, 0.0);
        for seed in 0..RUNS {
            let trucks = summary(&fleet(seed, 40, 2.0), of_trucks(TRIPS)).trucks.expect("trucks");
            let components = trucks.components.expect("40 trucks");
            between += components.between_variance / RUNS as f64;
            within += components.within_variance / RUNS as f64;
        }
        // of one run: var(s_b²) = 2 (4 + 25/50)²/39, so of the mean of 200 runs 0.072
        assert!((between - 4.0).abs() < 4.0 * 0.072, "{between}");
        assert!((within - 25.0).abs() < 4.0 * 25.0 * (2.0 / (RUNS as f64 * 1960.0)).sqrt());
    }

    #[test]
    fn intervals_know_that_trips_of_a_truck_belong_together() {
        const RUNS: u64 = 600;
        let (mut mean, mut alone, mut p95, mut annual) = (0, 0, 0, 0);
        // P95 of N(30, 4 + 25): 30 + 1.644854 √29
        let truth = 30.0 + 1.644_853_627 * 29_f64.sqrt();
        for seed in 0..RUNS {
            let records = fleet(seed, 60, 2.0);
            let summed = summary(&records, of_trucks(TRIPS));
            let naive = summary(&records, Dependence::default());
            let holds = |ci: Option<[f64; 2]>, truth: f64| {
                let [low, high] = ci.expect("3000 trips");
                usize::from(low <= truth && truth <= high)
            };
            let own = summed.consumption().expect("fuel");
            mean += holds(own.ci95, 30.0);
            alone += holds(naive.consumption().expect("fuel").ci95, 30.0);
            p95 += holds(own.quantiles[4].ci95, truth);
            let trucks = summed.trucks.as_ref().expect("trucks");
            annual += holds(trucks.truck_years[0].ci95, 30.0);
        }
        assert_share("mean", mean, RUNS as usize, 0.95);
        assert_share("annual mean", annual, RUNS as usize, 0.95);
        let p95 = p95 as f64 / RUNS as f64;
        assert!((0.92..0.98).contains(&p95), "{p95}");
        // the design effect is 1 + 49 · 4/29 = 7.8: the interval is 2.8 times too narrow
        let alone = alone as f64 / RUNS as f64;
        assert!(alone < 0.6, "{alone}");
    }
}
