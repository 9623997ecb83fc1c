//! Trips as they were measured beside what a study expects of them: which trucks and drivers take
//! more or less, beyond chance, and what a date or a group changed.

mod contrasts;
mod covariates;
mod files;
mod level;
mod text;

use crate::answer::Answer;
use crate::error::Error;
use crate::source::{Mapping, Source};
use crate::totals_rows::{Noise, Rows, per_distance};
use crate::watch::{Watch, watched};
use covariates::{Expectation, Known, lengths_differ, places, tells_season};
use level::Levels;
use ocmc_estimation::fit::far_rows::{WithinGroups, near_rows};
use ocmc_estimation::fit::fleet::FleetTable;
use ocmc_fleet::quantity::{NamedQuantity, shared_consumption};
use ocmc_fleet::run::{RunPlan, records};
use ocmc_io::intake::FileAccount;
use ocmc_io::study::LoadedStudy;
use ocmc_io::trip_totals::{self, TripTotal, TripTotals};
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::Instant;

pub use contrasts::Compared;
pub use covariates::Covariate;
pub use level::{BenchmarkLevel, BenchmarkMember};

/// Fewest rows that tell anything.
const FEWEST_ROWS: usize = 10;
/// Trips that say what the carrier is.
const TASTED: u64 = 16;
/// Rows, beside a level of each truck, for each slope that the table tells itself.
const ROWS_A_SLOPE: usize = 10;
/// Share of the rows that name a date from which on the season is known.
const DATED: f64 = 0.9;

/// What is set beside what.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BenchmarkContrast {
    /// Trips since a date, beside those before.
    Since(String),
    /// Groups of the table's column `group`, beside the one with most trips.
    Group,
}

/// A table, the study that expects, and how.
#[derive(Clone, Debug)]
pub struct BenchmarkRequest<'a> {
    /// One row a trip, or a fill.
    pub trips: Source,
    /// Which column is what.
    pub mappings: Vec<Mapping>,
    /// The study, and what it is called.
    pub study: (String, &'a LoadedStudy),
    /// What else is compared.
    pub contrast: Option<BenchmarkContrast>,
    /// Whether drivers keep their names; else they are numbered.
    pub names: bool,
    /// Whether trips are adjusted for their mean speed, where driving times are known.
    pub speed: bool,
    /// Trips of the study.
    pub cycles: u64,
    /// Master seed.
    pub seed: u64,
    /// Threads; one for each processor where there is none.
    pub threads: Option<usize>,
}

/// A covariate, and how far it makes trucks differ.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct AdjustedFor {
    /// What.
    pub covariate: Covariate,
    /// Whether the table's own slope is added to the study's.
    pub by_table: bool,
    /// SD between trucks of ln consumption that goes with it.
    pub sd_between: f64,
}

/// A trip far from all others of its truck.
#[derive(Clone, Debug, Serialize)]
pub struct FarTrip {
    /// Where it stands.
    pub place: String,
    /// Measured over expected, over the ratio of all.
    pub ratio: f64,
}

/// A trip beside what was expected of it.
#[derive(Clone, Debug)]
pub(crate) struct BenchmarkTrip {
    place: String,
    truck: String,
    driver: String,
    measured: f64,
    expected: f64,
    counts: bool,
}

/// What measured trips are beside what a study expects.
#[derive(Clone, Debug, Serialize)]
pub struct BenchmarkAnswer {
    /// What the study is called.
    pub study: String,
    /// Name of the consumption.
    pub column: String,
    /// Rows that count.
    pub rows: usize,
    /// Rows without a distance or an amount, or without what the others have.
    pub left_out: usize,
    /// Rows far from all others, which do not count.
    pub far: Vec<FarTrip>,
    /// Whether rows are ways between fills.
    pub of_fills: bool,
    /// Trucks; none where the table does not name them.
    pub trucks: Option<usize>,
    /// Drivers.
    pub drivers: Option<usize>,
    /// Geometric mean of the consumption.
    pub measured: f64,
    /// The same of what the study expects.
    pub expected: f64,
    /// Measured over expected: the level, which the comparison of trucks does not have in it.
    pub ratio: f64,
    /// Its 95 % interval by the trips and trucks alone: the study's own error is not in it.
    pub ratio_ci95: Option<[f64; 2]>,
    /// SD of ln consumption of the study's trips beside what is known of them.
    pub expected_sd: f64,
    /// SD of the ln ratio of a trip beside its truck and driver.
    pub trip_sd: Option<f64>,
    /// SD between the means of trucks of ln consumption, as measured.
    pub measured_sd_between: Option<f64>,
    /// The same of the ratio, adjusted: what is not explained, chance included.
    pub unexplained_sd_between: Option<f64>,
    /// What is adjusted for.
    pub adjusted_for: Vec<AdjustedFor>,
    /// Trucks and drivers.
    pub levels: Vec<BenchmarkLevel>,
    /// What a date or a group changed.
    pub compared: Vec<Compared>,
    /// What has to be known to read this.
    pub remarks: Vec<String>,
    /// What was read.
    pub inputs: Vec<FileAccount>,
    /// Cycles that were driven.
    pub driven: u64,
    /// Master seed.
    pub seed: u64,
    /// How long it took, in s.
    pub wall_s: f64,
    #[serde(skip)]
    trips: Vec<BenchmarkTrip>,
    #[serde(skip)]
    warnings: Vec<String>,
}

/// Sets measured trips beside what a study expects of them.
///
/// ```no_run
/// use ocmc_api::{BenchmarkRequest, Source, benchmark, go_on, study};
/// let request = BenchmarkRequest {
///     trips: Source::File("trips.csv".into()),
///     mappings: Vec::new(),
///     study: ("field-truck".to_owned(), &study::load("field-truck", &[] as &[&str])?),
///     contrast: None,
///     names: false,
///     speed: true,
///     cycles: 3200,
///     seed: 1,
///     threads: None,
/// };
/// let answer = benchmark(&request, &mut go_on)?;
/// assert!(answer.levels.iter().all(|level| level.differ || level.members.is_empty()));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where the table cannot be read, [`Error::FewTotals`], [`Error::OtherCarrier`],
/// [`Error::NoDates`], [`Error::NotADate`], [`Error::NoGroups`] and [`Error::Interrupted`].
pub fn benchmark(request: &BenchmarkRequest, watch: &mut Watch) -> Result<BenchmarkAnswer, Error> {
    let clock = Instant::now();
    let BenchmarkRequest { trips, mappings, study: (name, study), seed, .. } = request;
    let (mut table, mut account) = trip_totals::read(trips.lent(), mappings)?;
    check_contrast(request, &table)?;
    if !request.speed {
        table.rows.iter_mut().for_each(|row| row.driving_s = f64::NAN);
    }
    let plan = |first, cycles| RunPlan::new(*seed, first, cycles, request.threads, None);
    let taste = plan(0, TASTED);
    let tasted = watched(TASTED, watch, |look| records(&study.study, &taste, look))?;
    let quantity: &NamedQuantity = shared_consumption(&[&tasted]);
    let per_distance = per_distance(trips, &table, quantity, &tasted)?;
    let trip_m = tasted.iter().map(|record| record.distance_m).sum::<f64>() / TASTED as f64;
    let vehicle = &study.model.vehicle;
    let curb_kg = vehicle.curb_mass_kg;
    let noise = Noise { amount: 0.0, weight: 0.0 };
    let rows = Rows::new(&table, &noise, curb_kg, trip_m, per_distance);
    let few =
        |rows: usize| Error::FewTotals { path: trips.path().to_owned(), rows, fewest: FEWEST_ROWS };
    if rows.totals.len() < FEWEST_ROWS {
        return Err(few(rows.totals.len()));
    }
    let mut laws = rows.laws(curb_kg, vehicle.gross_mass_limit_kg);
    laws.push(("simulation.sampling".to_owned(), "sobol".into()));
    let driven_study = study.with_values(laws)?;
    let run = plan(TASTED, request.cycles);
    let driven = watched(request.cycles, watch, |look| records(&driven_study.study, &run, look))?;
    let asked = Asked::new(&table, &rows, request.names);
    if asked.rows.len() < FEWEST_ROWS {
        return Err(few(asked.rows.len()));
    }
    let expectation =
        Expectation::fit(&driven, quantity, curb_kg, &asked.known).ok_or_else(|| few(0))?;
    let mut answer = asked.answer(&expectation, request)?;
    answer.study.clone_from(name);
    quantity.column.clone_into(&mut answer.column);
    answer.left_out = table.rows.len() + table.left_out - asked.rows.len();
    answer.of_fills = table.of_fills;
    answer.driven = request.cycles + TASTED;
    answer.warnings.extend(account.warnings());
    account.findings.retain(|finding| !finding.is_refusal());
    answer.inputs = vec![account];
    answer.wall_s = clock.elapsed().as_secs_f64();
    Ok(answer)
}

/// Checks that the table has what is compared.
fn check_contrast(request: &BenchmarkRequest, table: &TripTotals) -> Result<(), Error> {
    match &request.contrast {
        Some(BenchmarkContrast::Since(date)) => {
            trip_totals::time_of(date).ok_or_else(|| Error::NotADate(date.clone()))?;
            let has_dates = table.rows.iter().any(|row| row.time_s.is_finite());
            has_dates.then_some(()).ok_or_else(|| Error::NoDates(request.trips.path().to_owned()))
        }
        Some(BenchmarkContrast::Group) if table.rows.iter().all(|row| row.group.is_empty()) => {
            Err(Error::NoGroups(0))
        }
        _ => Ok(()),
    }
}

/// The rows that are set beside what is expected of them.
struct Asked {
    rows: Vec<TripTotal>,
    /// ln consumption.
    measured: Vec<f64>,
    trips: Vec<Known>,
    known: Vec<Covariate>,
    /// Whether trucks are named, and drivers.
    has_trucks: bool,
    has_drivers: bool,
}

impl Asked {
    fn new(table: &TripTotals, rows: &Rows, names: bool) -> Self {
        let all = rows.of_table.len();
        let dated = rows.of_table.iter().filter(|row| row.s_of_year.is_finite()).count();
        let has_season = dated as f64 >= DATED * all as f64;
        let named = |of: fn(&TripTotal) -> &String| {
            2 * rows.of_table.iter().filter(|row| !of(row).is_empty()).count() > all
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

    fn answer(
        &self,
        expectation: &Expectation,
        request: &BenchmarkRequest,
    ) -> Result<BenchmarkAnswer, Error> {
        let expected: Vec<f64> = self.trips.iter().map(|trip| expectation.of(trip)).collect();
        let ln_ratio: Vec<f64> =
            self.measured.iter().zip(&expected).map(|(measured, e)| measured - e).collect();
        let columns = self.columns();
        let group = self.groups();
        let near = near_rows(&ln_ratio, &columns, &group);
        let kept: Vec<usize> = (0..near.len()).filter(|k| near[*k]).collect();
        let of = |values: &[f64]| -> Vec<f64> { kept.iter().map(|k| values[*k]).collect() };
        let truck: Vec<usize> = kept.iter().map(|k| group[*k]).collect();
        let count = truck.iter().collect::<std::collections::BTreeSet<_>>().len();
        let mut remarks = Vec::new();
        let own = self.own_slopes(&of, &columns, &ln_ratio, &truck, count);
        let columns = own.columns.iter().map(|place| of(&columns[*place])).collect::<Vec<_>>();
        if self.known.contains(&Covariate::Season) && !self.tells_season() {
            remarks.push(
                "the dates are not spread over the year: the season is the study's alone"
                    .to_owned(),
            );
        }
        if self.known.contains(&Covariate::Speed) {
            remarks.push(
                "trips are adjusted for their mean speed, which tells the roads: a driver is compared \
                 at the speed that was driven"
                    .to_owned(),
            );
        }
        let rows: Vec<TripTotal> = kept.iter().map(|k| self.rows[*k].clone()).collect();
        let ln_ratio_kept = of(&ln_ratio);
        let by_driver = !self.has_trucks && self.has_drivers;
        let weight = |trip: &Known| 1.0 / (expectation.sd_of(trip) * expectation.sd_of(trip));
        let table = FleetTable {
            truck: rows.iter().map(|row| self.member(row).to_owned()).collect(),
            driver: (self.has_trucks && self.has_drivers)
                .then(|| rows.iter().map(|row| row.driver.clone()).collect()),
            value: ln_ratio_kept.clone(),
            weight: Some(kept.iter().map(|k| weight(&self.trips[*k])).collect()),
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
            rows: &rows,
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
        let number = |of: fn(&TripTotal) -> &String, is: bool| {
            is.then(|| rows.iter().map(of).collect::<std::collections::BTreeSet<_>>().len())
        };
        Ok(BenchmarkAnswer {
            study: String::new(),
            column: String::new(),
            rows: kept.len(),
            left_out: 0,
            far: far.collect(),
            of_fills: false,
            trucks: number(|row| &row.truck, self.has_trucks),
            drivers: number(|row| &row.driver, self.has_drivers),
            measured: libm::exp(mean_of(&of(&self.measured))),
            expected: libm::exp(mean_of(&of(&expected))),
            ratio: libm::exp(mean),
            ratio_ci95: levels.as_ref().map(|l| [l.mean[1], l.mean[2]].map(|ln| libm::exp(ln))),
            expected_sd: expectation.sd,
            trip_sd: levels.as_ref().map(|levels| levels.trip_sd),
            measured_sd_between: between(&of(&self.measured)),
            unexplained_sd_between: between(&adjusted),
            adjusted_for: self.adjusted_for(expectation, &kept, &truck, &own),
            levels: levels.as_ref().map_or_else(Vec::new, |levels| levels.levels.clone()),
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

    /// What the table may tell slopes of itself: a column each, 0 in all rows of what it does not.
    fn columns(&self) -> Vec<Vec<f64>> {
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
        (0..width).map(column).collect()
    }

    /// The columns that have slopes of their own within trucks, and these; none of few rows.
    fn own_slopes(
        &self,
        of: &dyn Fn(&[f64]) -> Vec<f64>,
        columns: &[Vec<f64>],
        ln_ratio: &[f64],
        truck: &[usize],
        count: usize,
    ) -> WithinGroups {
        let kept: Vec<Vec<f64>> = columns.iter().map(|column| of(column)).collect();
        let n = truck.len();
        if n < count + ROWS_A_SLOPE * kept.len().max(1) {
            return WithinGroups { columns: Vec::new(), slopes: Vec::new() };
        }
        WithinGroups::fit(&of(ln_ratio), &kept, truck, &vec![true; n])
    }

    /// How far trucks differ by each covariate.
    fn adjusted_for(
        &self,
        expectation: &Expectation,
        kept: &[usize],
        truck: &[usize],
        own: &WithinGroups,
    ) -> Vec<AdjustedFor> {
        let rows: Vec<Vec<f64>> =
            kept.iter().map(|k| self.trips[*k].columns(&self.known)).collect();
        let own_of = |place: usize| {
            own.columns.iter().position(|own| *own == place).map(|at| own.slopes[at])
        };
        let one = |(covariate, range): (Covariate, std::ops::Range<usize>)| {
            let moved: Vec<f64> = (rows.iter())
                .map(|row| {
                    let of = |place: usize| {
                        let slope = expectation.slopes[place] + own_of(place).unwrap_or(0.0);
                        slope * row[place]
                    };
                    range.clone().map(of).sum()
                })
                .collect();
            let by_table = range.clone().any(|place| own_of(place).is_some());
            AdjustedFor { covariate, by_table, sd_between: sd_between(&moved, truck) }
        };
        places(&self.known).into_iter().map(one).collect()
    }
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

impl Answer for BenchmarkAnswer {
    fn text(&self) -> String {
        text::benchmark_text(self)
    }

    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    fn notes(&self) -> Vec<String> {
        FileAccount::told_of(&self.inputs)
    }
}
