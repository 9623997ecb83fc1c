//! Trips as they were measured beside what a study expects of them: which trucks and drivers take
//! more or less, beyond chance, and what a date or a group changed.

mod asked;
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
use asked::Asked;
use covariates::Expectation;
use ocmc_fleet::quantity::{NamedQuantity, shared_consumption};
use ocmc_fleet::run::{RunPlan, records};
use ocmc_io::intake::FileAccount;
use ocmc_io::study::LoadedStudy;
use ocmc_io::trip_totals::{self, TripTotal, TripTotals};
use serde::Serialize;
use std::collections::BTreeSet;
use std::time::Instant;

pub use contrasts::Compared;
pub use covariates::Covariate;
pub use level::{BenchmarkLevel, BenchmarkMember};

/// Fewest rows that tell anything.
const FEWEST_ROWS: usize = 10;
/// Trips that say what the carrier is.
const TASTED: u64 = 16;

/// A comparison of trips.
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
    /// Columns of the quantities.
    pub mappings: Vec<Mapping>,
    /// The study, and what it is called.
    pub study: (String, &'a LoadedStudy),
    /// A further comparison.
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
    /// Covariate.
    pub covariate: Covariate,
    /// Whether the study expects something of it.
    pub by_study: bool,
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

/// Measured trips beside those that a study expects.
#[derive(Clone, Debug, Serialize)]
pub struct BenchmarkAnswer {
    /// Name of the study.
    pub study: String,
    /// Name of the consumption.
    pub column: String,
    /// Rows that count.
    pub rows: usize,
    /// Rows without a distance or an amount, or without what the others have.
    pub left_out: usize,
    /// Rows that were the same as one before: truck, date, distance, amount and weight.
    pub doubled: usize,
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
    /// Quantities that are adjusted for.
    pub adjusted_for: Vec<AdjustedFor>,
    /// Trucks and drivers.
    pub levels: Vec<BenchmarkLevel>,
    /// Changes by a date or a group.
    pub compared: Vec<Compared>,
    /// Remarks that a reader needs.
    pub remarks: Vec<String>,
    /// Accounts of the files that were read.
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
/// [`Error::NothingExpected`], [`Error::NoDates`], [`Error::NotADate`],
/// [`Error::NoGroups`] and [`Error::Interrupted`].
pub fn benchmark(request: &BenchmarkRequest, watch: &mut Watch) -> Result<BenchmarkAnswer, Error> {
    let clock = Instant::now();
    let BenchmarkRequest { trips, mappings, study: (name, study), seed, .. } = request;
    let (mut table, mut account) = trip_totals::read(trips.lent(), mappings)?;
    check_contrast(request, &table)?;
    let doubled = without_doubled(&mut table.rows);
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
    let expectation = Expectation::fit(&driven, quantity, curb_kg, &asked.known)
        .ok_or_else(|| Error::NothingExpected(name.clone()))?;
    let mut answer = asked.answer(&expectation, request)?;
    answer.study.clone_from(name);
    quantity.column.clone_into(&mut answer.column);
    answer.left_out = table.rows.len() + table.left_out - asked.rows.len();
    answer.doubled = doubled;
    answer.of_fills = table.of_fills;
    answer.driven = request.cycles + TASTED;
    answer.warnings.extend(account.warnings());
    account.findings.retain(|finding| !finding.is_refusal());
    answer.inputs = vec![account];
    answer.wall_s = clock.elapsed().as_secs_f64();
    Ok(answer)
}

/// Takes out rows that are the same as one before, where trips are dated, and counts them.
fn without_doubled(rows: &mut Vec<TripTotal>) -> usize {
    let mut seen = BTreeSet::new();
    let all = rows.len();
    rows.retain(|row| {
        let numbers = [row.time_s, row.distance_m, row.amount, row.gross_kg].map(f64::to_bits);
        !row.time_s.is_finite() || seen.insert((row.truck.clone(), numbers))
    });
    all - rows.len()
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
