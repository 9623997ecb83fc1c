//! The rows of a table beside what is expected of them.

use super::covariates::{Covariate, Expectation, Known, lengths_differ, places, tells_season};
use super::level::Levels;
use super::{AdjustedFor, BenchmarkAnswer, BenchmarkRequest, BenchmarkTrip, FarTrip, contrasts};
use crate::error::Error;
use crate::totals_rows::Rows;
use ocmc_estimation::fit::far_rows::{WithinGroups, near_rows, variances};
use ocmc_estimation::fit::fleet::FleetTable;
use ocmc_io::trip_totals::{TripTotal, TripTotals};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Rows, beside a level of each truck, for each slope that the table tells itself.
const ROWS_A_SLOPE: usize = 10;
/// Share of the rows that name a date from which on the season is known.
const DATED: f64 = 0.9;
/// Most routes that are told apart.
const MOST_ROUTES: usize = 60;

/// The rows that are set beside what is expected of them.
pub(super) struct Asked {
    pub(super) rows: Vec<TripTotal>,
    /// ln consumption.
    measured: Vec<f64>,
    trips: Vec<Known>,
    pub(super) known: Vec<Covariate>,
    /// Whether trucks are named, and drivers.
    has_trucks: bool,
    has_drivers: bool,
}

impl Asked {
    pub(super) fn new(table: &TripTotals, rows: &Rows, names: bool) -> Self {
        let all = rows.of_table.len();
        let dated = rows.of_table.iter().filter(|row| row.s_of_year.is_finite()).count();
        let has_season = dated as f64 >= DATED * all as f64;
        let named = |text_of: fn(&TripTotal) -> &String| {
            2 * rows.of_table.iter().filter(|row| !text_of(row).is_empty()).count() > all
        };
        let (has_trucks, has_drivers) = (named(|row| &row.truck), named(|row| &row.driver));
        let counts = |row: &TripTotal| {
            (!has_season || row.s_of_year.is_finite())
                && (!has_trucks || !row.truck.is_empty())
                && (!has_drivers || !row.driver.is_empty())
        };
        let kept: Vec<usize> = (0..all).filter(|k| counts(&rows.of_table[*k])).collect();
        let trips: Vec<Known> = (kept.iter())
            .map(|k| Known::of_row(&rows.of_table[*k], rows.totals[*k].gross_kg))
            .collect();
        let mut known = Vec::new();
        known.extend(rows.has_gross().then_some(Covariate::Weight));
        let lengths: Vec<f64> = trips.iter().map(|trip| trip.length_m).collect();
        let has_lengths = !table.of_fills && lengths_differ(&lengths);
        known.extend(has_lengths.then_some(Covariate::Length));
        let has_climb = trips.iter().all(|trip| trip.climb_m.is_finite());
        known.extend((has_climb && !table.of_fills).then_some(Covariate::Climb));
        let has_speed = !table.of_fills && trips.iter().all(|trip| trip.driving_s > 0.0);
        known.extend(has_speed.then_some(Covariate::Speed));
        known.extend(has_season.then_some(Covariate::Season));
        let mut of_table: Vec<TripTotal> = kept.iter().map(|k| rows.of_table[*k].clone()).collect();
        if !names {
            pseudonyms(&mut of_table);
        }
        Self {
            measured: kept.iter().map(|k| libm::log(rows.consumption[*k])).collect(),
            rows: of_table,
            trips,
            known,
            has_trucks,
            has_drivers,
        }
    }

    /// The number of each row's truck; of each driver's, where only drivers are named; all the same
    /// where nobody is.
    fn groups(&self) -> Vec<usize> {
        let mut numbers: BTreeMap<&str, usize> = BTreeMap::new();
        let number = |row| {
            let name = self.member(row);
            let next = numbers.len();
            *numbers.entry(name).or_insert(next)
        };
        self.rows.iter().map(number).collect()
    }

    fn member<'a>(&self, row: &'a TripTotal) -> &'a str {
        match (self.has_trucks, self.has_drivers) {
            (true, _) => &row.truck,
            (false, true) => &row.driver,
            (false, false) => "",
        }
    }

    pub(super) fn answer(
        &self,
        expectation: &Expectation,
        request: &BenchmarkRequest,
    ) -> Result<BenchmarkAnswer, Error> {
        let expected: Vec<f64> = self.trips.iter().map(|trip| expectation.of(trip)).collect();
        let ln_ratio: Vec<f64> =
            self.measured.iter().zip(&expected).map(|(measured, e)| measured - e).collect();
        let (columns, routes) = self.columns();
        let group = self.groups();
        let sd: Vec<f64> = self.trips.iter().map(|trip| expectation.sd_of(trip)).collect();
        let near = near_rows(&ln_ratio, &columns, &group, &sd);
        let kept: Vec<usize> = (0..near.len()).filter(|k| near[*k]).collect();
        let kept_values =
            |values: &[f64]| -> Vec<f64> { kept.iter().map(|k| values[*k]).collect() };
        let truck: Vec<usize> = kept.iter().map(|k| group[*k]).collect();
        let count = truck.iter().collect::<BTreeSet<_>>().len();
        let mut remarks = Vec::new();
        let own = own_slopes(&kept_values, &columns, &ln_ratio, &truck, count);
        let all_columns = columns;
        let columns: Vec<Vec<f64>> =
            own.columns.iter().map(|place| kept_values(&all_columns[*place])).collect();
        if self.known.contains(&Covariate::Season) && !self.tells_season() {
            remarks.push(
                "the dates are not spread over the year: the season is the study's alone"
                    .to_owned(),
            );
        }
        if self.known.contains(&Covariate::Speed) {
            remarks.push(
                "trips are adjusted for their mean speed, which tells the roads: a driver is \
                 compared at the speed that was driven"
                    .to_owned(),
            );
        }
        let rows: Vec<TripTotal> = kept.iter().map(|k| self.rows[*k].clone()).collect();
        let ln_ratio_kept = kept_values(&ln_ratio);
        let by_driver = !self.has_trucks && self.has_drivers;
        let variances = variances(&ln_ratio_kept, &columns, &truck, &kept_values(&sd));
        let table = FleetTable {
            truck: rows.iter().map(|row| self.member(row).to_owned()).collect(),
            driver: (self.has_trucks && self.has_drivers)
                .then(|| rows.iter().map(|row| row.driver.clone()).collect()),
            value: ln_ratio_kept.clone(),
            weight: Some(variances.iter().map(|variance| 1.0 / variance).collect()),
            covariates: columns.clone(),
            ..FleetTable::default()
        };
        let levels = Levels::of(&table, by_driver, request.seed);
        if levels.is_none() {
            remarks.push(
                "trucks or drivers are not named, or have one trip each: they are not compared"
                    .to_owned(),
            );
        }
        let compared = contrasts::Rows {
            of_table: &rows,
            has_routes: own.columns.iter().any(|place| routes.contains(place)),
            ln_ratio: &ln_ratio_kept,
            columns: &columns,
            truck: &truck,
        };
        let compared = match &request.contrast {
            Some(asked) => compared.compared(asked)?,
            None => Vec::new(),
        };
        let mean_of = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let mean = levels.as_ref().map_or(mean_of(&ln_ratio_kept), |levels| levels.mean[0]);
        let adjusted: Vec<f64> = (0..kept.len())
            .map(|k| {
                let moved = |(column, slope): (&Vec<f64>, &f64)| slope * column[k];
                ln_ratio_kept[k] - columns.iter().zip(&own.slopes).map(moved).sum::<f64>()
            })
            .collect();
        let between = |values: &[f64]| (count > 2).then(|| sd_between(values, &truck));
        let trips = (0..self.rows.len()).map(|k| BenchmarkTrip {
            place: self.rows[k].place.to_string(),
            truck: self.rows[k].truck.clone(),
            driver: self.rows[k].driver.clone(),
            measured: libm::exp(self.measured[k]),
            expected: libm::exp(expected[k]),
            counts: near[k],
        });
        let far = (0..near.len()).filter(|k| !near[*k]).map(|k| FarTrip {
            place: self.rows[k].place.to_string(),
            ratio: libm::exp(ln_ratio[k] - mean),
        });
        let number = |text_of: fn(&TripTotal) -> &String, is: bool| {
            is.then(|| rows.iter().map(text_of).collect::<BTreeSet<_>>().len())
        };
        Ok(BenchmarkAnswer {
            study: String::new(),
            column: String::new(),
            rows: kept.len(),
            left_out: 0,
            doubled: 0,
            far: far.collect(),
            of_fills: false,
            trucks: number(|row| &row.truck, self.has_trucks),
            drivers: number(|row| &row.driver, self.has_drivers),
            measured: libm::exp(mean_of(&kept_values(&self.measured))),
            expected: libm::exp(mean_of(&kept_values(&expected))),
            ratio: libm::exp(mean),
            ratio_ci95: levels.as_ref().map(|l| [l.mean[1], l.mean[2]].map(libm::exp)),
            expected_sd: expectation.sd,
            trip_sd: levels.as_ref().map(|levels| levels.trip_sd),
            measured_sd_between: between(&kept_values(&self.measured)),
            unexplained_sd_between: between(&adjusted),
            adjusted_for: self.adjusted_for(
                expectation,
                (&kept, &truck),
                &own,
                (&all_columns, routes),
            ),
            levels: levels.as_ref().map_or_else(Vec::new, |levels| levels.all.clone()),
            compared,
            remarks: remarks.into_iter().chain(levels.map_or(Vec::new(), |l| l.notes)).collect(),
            inputs: Vec::new(),
            driven: 0,
            seed: request.seed,
            wall_s: 0.0,
            trips: trips.collect(),
            warnings: Vec::new(),
        })
    }

    fn tells_season(&self) -> bool {
        tells_season(self.trips.iter().map(|trip| trip.s_of_year))
    }

    /// Columns whose slopes the table may tell itself: one each, 0 in all rows of what it does not;
    /// and which of them are routes.
    fn columns(&self) -> (Vec<Vec<f64>>, Range<usize>) {
        let rows: Vec<Vec<f64>> = self.trips.iter().map(|trip| trip.columns(&self.known)).collect();
        let ranges = places(&self.known);
        let width = ranges.last().map_or(0, |(_, range)| range.end);
        let season = ranges.iter().find(|(covariate, _)| *covariate == Covariate::Season);
        let hidden = season.filter(|_| !self.tells_season()).map(|(_, range)| range.clone());
        let column = |place: usize| -> Vec<f64> {
            let mean = rows.iter().map(|row| row[place]).sum::<f64>() / rows.len() as f64;
            let is_hidden = hidden.as_ref().is_some_and(|hidden| hidden.contains(&place));
            rows.iter().map(|row| if is_hidden { 0.0 } else { row[place] - mean }).collect()
        };
        let mut columns: Vec<Vec<f64>> = (0..width).map(column).collect();
        columns.extend(self.routes(width));
        let end = columns.len();
        (columns, width..end)
    }

    /// A column a route but for the first; none where most rows name none, or too many for the
    /// rows.
    fn routes(&self, others: usize) -> Vec<Vec<f64>> {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for row in &self.rows {
            *counts.entry(&row.route).or_default() += 1;
        }
        let unnamed = counts.get("").copied().unwrap_or(0);
        let needed = 2 * ROWS_A_SLOPE * (others + counts.len());
        let fits = (2..=MOST_ROUTES).contains(&counts.len()) && needed <= self.rows.len();
        if 2 * unnamed > self.rows.len() || !fits {
            return Vec::new();
        }
        let column = |route: &str| -> Vec<f64> {
            self.rows.iter().map(|row| f64::from(u8::from(row.route == route))).collect()
        };
        counts.keys().skip(1).map(|route| column(route)).collect()
    }

    /// How far trucks differ by each covariate.
    fn adjusted_for(
        &self,
        expectation: &Expectation,
        (kept, truck): (&[usize], &[usize]),
        own: &WithinGroups,
        (columns, routes): (&[Vec<f64>], Range<usize>),
    ) -> Vec<AdjustedFor> {
        let known = |k: usize| self.trips[k].columns(&self.known);
        let rows: Vec<(usize, Vec<f64>)> = kept.iter().map(|k| (*k, known(*k))).collect();
        let own_of = |place: usize| {
            let at = own.columns.iter().position(|own| *own == place);
            at.map(|at| own.slopes[at])
        };
        let one = |(covariate, range): (Covariate, Range<usize>)| {
            let moved = |(k, x): &(usize, Vec<f64>)| -> f64 {
                let effect_of = |place: usize| {
                    let by_study = expectation.slopes.get(place).map_or(0.0, |s| s * x[place]);
                    by_study + own_of(place).map_or(0.0, |slope| slope * columns[place][*k])
                };
                range.clone().map(effect_of).sum()
            };
            let moved: Vec<f64> = rows.iter().map(moved).collect();
            let by_table = range.clone().any(|place| own_of(place).is_some());
            let by_study = covariate != Covariate::Route;
            AdjustedFor { covariate, by_study, by_table, sd_between: sd_between(&moved, truck) }
        };
        let mut all = places(&self.known);
        if !routes.is_empty() {
            all.push((Covariate::Route, routes));
        }
        all.into_iter().map(one).collect()
    }
}

/// The columns that have slopes of their own within trucks, and these; none of few rows.
fn own_slopes(
    kept_values: &dyn Fn(&[f64]) -> Vec<f64>,
    columns: &[Vec<f64>],
    ln_ratio: &[f64],
    truck: &[usize],
    count: usize,
) -> WithinGroups {
    let kept: Vec<Vec<f64>> = columns.iter().map(|column| kept_values(column)).collect();
    let n = truck.len();
    if n < count + ROWS_A_SLOPE * kept.len().max(1) {
        return WithinGroups { columns: Vec::new(), slopes: Vec::new() };
    }
    WithinGroups::fit(&kept_values(ln_ratio), &kept, truck, &vec![true; n])
}

/// Numbers drivers in the order in which they come.
fn pseudonyms(rows: &mut [TripTotal]) {
    let mut numbers: BTreeMap<String, usize> = BTreeMap::new();
    for row in rows.iter().filter(|row| !row.driver.is_empty()) {
        let next = numbers.len() + 1;
        numbers.entry(row.driver.clone()).or_insert(next);
    }
    let digits = numbers.len().to_string().len().max(2);
    for row in rows {
        if let Some(number) = numbers.get(&row.driver) {
            row.driver = format!("driver {number:0digits$}");
        }
    }
}

/// SD between the means of groups; 0 of a single one.
fn sd_between(values: &[f64], group: &[usize]) -> f64 {
    let mut sums: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
    for (value, group) in values.iter().zip(group) {
        let sum = sums.entry(*group).or_default();
        *sum = (sum.0 + value, sum.1 + 1.0);
    }
    let means: Vec<f64> = sums.values().map(|(sum, n)| sum / n).collect();
    let n = means.len() as f64;
    if means.len() < 2 {
        return 0.0;
    }
    let mean = means.iter().sum::<f64>() / n;
    libm::sqrt(means.iter().map(|m| (m - mean) * (m - mean)).sum::<f64>() / (n - 1.0))
}
