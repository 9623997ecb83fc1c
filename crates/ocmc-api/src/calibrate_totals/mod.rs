//! A study calibrated to the totals of a fleet's trips.

mod design;
mod expectation;
mod further;
mod judge;
mod matched;
mod question;
mod shape;
mod text;
mod written;

use crate::answer::Answer;
use crate::error::Error;
use crate::source::{Mapping, Source};
use crate::totals_rows::{Rows, per_distance};
use crate::watch::{Watch, watched};
use design::{ASKED, CHECKED_FIRST, Design, Driven, MEMBERS, TRIPS};
use further::{Further, further};
use judge::{Judged, judge};
use matched::{CHECKED, Matched, ROUNDS_TRIPS, Target};
use ocmc_estimation::calibration::totals::{
    Emulator, Known, Member, MemberEmulator, Posterior, Response, Shared, posterior, sign_of_breaks,
};
use ocmc_estimation::fit::fleet::{FleetOptions, FleetTable, fit};
use ocmc_fleet::quantity::{NamedQuantity, shared_consumption};
use ocmc_fleet::run::{RunPlan, records};
use ocmc_io::intake::FileAccount;
use ocmc_io::label::label;
use ocmc_io::number_text::count_of;
use ocmc_io::study::{FittedPart, LoadedStudy};
use ocmc_io::trip_totals::{self, TripTotal, TripTotals};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::time::Instant;
use written::Written;

pub use crate::totals_rows::Noise;
use expectation::Expectation;
pub use expectation::HeldBackTrip;
pub use question::Question;
pub use shape::Shape;
pub use written::CalibratedNumbers;

/// Fewest rows that tell anything.
pub const FEWEST_ROWS: usize = 5;
/// Most rows that count: beyond them the model's own error is the larger one.
const MOST_ROWS: f64 = 150.0;
/// Trips of the study before, which say its level.
const LEVELLED: u64 = 800;
/// Trips that say what the carrier is.
const TASTED: u64 = 16;
/// Standard normal deviate of a 90 % interval.
const NORMAL_95: f64 = 1.644_853_626_951_472_2;

/// A table, the study that it is to calibrate, and how.
#[derive(Clone, Debug)]
pub struct CalibrateTotalsRequest<'a> {
    /// One row a trip, or a fill.
    pub trips: Source,
    /// Columns of the quantities.
    pub mappings: Vec<Mapping>,
    /// The study.
    pub study: &'a LoadedStudy,
    /// Noise of the table's numbers.
    pub noise: Noise,
    /// Master seed.
    pub seed: u64,
    /// Threads; one for each processor where there is none.
    pub threads: Option<usize>,
}

/// The effect of a change.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Questioned {
    /// The change.
    pub question: Question,
    /// Change of the mean consumption, as a share.
    pub change: f64,
    /// Its 90 % interval.
    pub ci90: [f64; 2],
    /// Its 90 % interval by the judged numbers alone, without the table.
    pub judged_ci90: [f64; 2],
}

/// The answer of a calibration to totals.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct CalibrateTotalsAnswer {
    /// Rows that count.
    pub rows: usize,
    /// Rows that were left out: without a distance or an amount, or without what the others have.
    pub left_out: usize,
    /// Trucks; none where the table does not name them.
    pub trucks: Option<usize>,
    /// Drivers.
    pub drivers: Option<usize>,
    /// Rows that count as independent of each other.
    pub effective_rows: f64,
    /// Whether rows are ways between fills.
    pub of_fills: bool,
    /// Name of the consumption.
    pub column: String,
    /// Names of the quantities that explain a row.
    pub known: Vec<&'static str>,
    /// Consumption of the table.
    pub table: Shape,
    /// Consumption of the calibrated study.
    pub simulated: Shape,
    /// Mean consumption of the study, uncalibrated, with the table's loads and lengths.
    pub before: f64,
    /// Factor on the fuel map that makes the means the same; none where the powertrain has none.
    pub factor: Option<f64>,
    /// The judged numbers that the design moved, those first that the table moved most.
    pub numbers: Vec<CalibratedNumbers>,
    /// Effects of changes.
    pub questions: Vec<Questioned>,
    /// The worth of further columns.
    pub further: Vec<Further>,
    /// The part of a study that follows.
    pub study: Value,
    /// Where it is from, in words.
    pub standing: String,
    /// Accounts of the files that were read.
    pub inputs: Vec<FileAccount>,
    /// Cycles that were driven.
    pub driven: u64,
    /// How long it took, in s.
    pub wall_s: f64,
    #[serde(skip)]
    warnings: Vec<String>,
}

/// Calibrates a study to the totals of a fleet's trips.
///
/// ```no_run
/// use ocmc_api::{CalibrateTotalsRequest, Noise, Source, calibrate_totals, go_on, study};
/// let study = &study::load("field-truck", &[] as &[&str])?;
/// let request = CalibrateTotalsRequest {
///     trips: Source::File("trips.csv".into()),
///     mappings: Vec::new(),
///     study,
///     noise: Noise { amount: 0.03, weight: 0.05 },
///     seed: 1,
///     threads: None,
/// };
/// let answer = calibrate_totals(&request, &mut go_on)?;
/// assert!(answer.questions[0].change < 0.0);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where the table cannot be read, [`Error::FewTotals`], [`Error::OtherCarrier`],
/// [`Error::NothingJudged`] and [`Error::Interrupted`].
pub fn calibrate_totals(
    request: &CalibrateTotalsRequest,
    watch: &mut Watch,
) -> Result<CalibrateTotalsAnswer, Error> {
    request.noise.check()?;
    let read = trip_totals::read(request.trips.lent(), &request.mappings)?;
    calibrated(request, read, &[], watch).map(|(answer, _)| answer)
}

/// As [`calibrate_totals`], of a table that was read, and rows that are held back beside what the
/// calibrated study says of such trips.
pub(crate) fn calibrated(
    request: &CalibrateTotalsRequest,
    (table, mut account): (TripTotals, FileAccount),
    held_back: &[TripTotal],
    watch: &mut Watch,
) -> Result<(CalibrateTotalsAnswer, Vec<HeldBackTrip>), Error> {
    let clock = Instant::now();
    let CalibrateTotalsRequest { trips, study, noise, seed, threads, .. } = request;
    let threads = RunPlan::new(*seed, 0, CHECKED, *threads, None).threads;
    let taste = RunPlan::new(*seed, 0, TASTED, Some(threads), None);
    let tasted = watched(TASTED, watch, |look| records(&study.study, &taste, look))?;
    let quantity: &NamedQuantity = shared_consumption(&[&tasted]);
    let per_distance = per_distance(trips, &table, quantity, &tasted)?;
    let model = &study.model;
    let trip_m = tasted.iter().map(|record| record.distance_m).sum::<f64>() / TASTED as f64;
    let curb_kg = model.vehicle.curb_mass_kg;
    let rows = Rows::new(&table, noise, curb_kg, trip_m, &per_distance);
    if rows.totals.len() < FEWEST_ROWS {
        let (path, rows) = (trips.path().to_owned(), rows.totals.len());
        return Err(Error::FewTotals { path, rows, fewest: FEWEST_ROWS });
    }
    let design = Design::new(study, &rows, *seed, threads)?;
    let questions = Question::ALL;
    let total =
        MEMBERS * (TRIPS + ASKED * questions.len() as u64) + ROUNDS_TRIPS + CHECKED + LEVELLED;
    let table_shape = Shape::of_each(&rows.lengths(), rows.consumption.clone());
    let driven = watched(total, watch, |look| {
        let mut done = 0;
        let mut members: Vec<Driven> = Vec::new();
        for member in 0..MEMBERS {
            let look = &mut |n| look(done + n);
            match design.drive(member, quantity, &questions, noise, look) {
                Ok(driven) => members.push(driven?),
                Err(error) => return ControlFlow::Continue(Err(error)),
            }
            done += TRIPS + ASKED * questions.len() as u64;
        }
        let estimate = Estimate::of(&design, &members, &questions);
        // ways between fills hold several trips: their quantiles are not those of trips
        let target = (!table.of_fills).then(|| Target {
            rows: Shape::of_each(&rows.lengths(), rows.without_noise(noise)),
            count: estimate.effective_rows,
        });
        let matched = Matched::new(
            &design,
            &members,
            &estimate.posterior,
            quantity,
            target.as_ref(),
            &estimate.questions,
            &mut |n| look(done + n),
        );
        let judged = design.at(&vec![0.0; design.entries.len()]);
        let (matched, judged) = match matched.and_then(|matched| Ok((matched, judged?))) {
            Ok((matched, judged)) => (matched?, judged),
            Err(error) => return ControlFlow::Continue(Err(error)),
        };
        let plan = design.plan(CHECKED_FIRST, LEVELLED);
        let before = records(&judged.study, &plan, |n| look(total - LEVELLED + n))?;
        ControlFlow::Continue(Ok((members, estimate, matched, before)))
    })?;
    let (members, estimate, matched, before) = driven?;
    let Matched { scores, study: calibrated, trips: after, shape } = matched;
    let has_factor = model.to_tree().pointer(written::FACTOR_POINTER).is_some();
    let factor = has_factor.then_some(table_shape.mean / shape.mean);
    let simulated = shape.times(factor.unwrap_or(1.0));
    let before = Shape::of(quantity, &before).0.mean;
    let written = Written { design: &design, posterior: &estimate.posterior, scores: &scores };
    let part: FittedPart = written.part(study, &calibrated, factor.unwrap_or(1.0));
    let all: Vec<Member> = members.iter().map(|driven| driven.member.clone()).collect();
    let judged = Judged {
        table: &table,
        rows: &rows,
        posterior: &estimate.posterior,
        curb_kg,
        level: [table_shape.mean, before],
        breaks: sign_of_breaks(&all, &rows.totals),
        unit: label(quantity.column).0,
    };
    account.findings.extend(judge(&judged));
    let further = further(&estimate, &members, &rows);
    let (trucks, drivers) = counted(&rows);
    let warnings = account.warnings().into_iter().chain(part.warnings()).collect();
    let expectation = Expectation::new(&rows, &after, quantity, (noise, *seed), factor, curb_kg);
    let answer = CalibrateTotalsAnswer {
        rows: rows.totals.len(),
        left_out: table.left_out + rows.incomplete,
        trucks,
        drivers,
        effective_rows: estimate.effective_rows,
        of_fills: table.of_fills,
        column: quantity.column.to_owned(),
        known: estimate.known_words(),
        table: table_shape,
        simulated,
        before,
        factor,
        numbers: written.numbers(study, factor.unwrap_or(1.0)),
        questions: estimate.questioned(),
        further,
        study: part.json(),
        standing: standing(&rows, trucks, table.of_fills, trips),
        inputs: vec![account],
        driven: total + TASTED,
        wall_s: clock.elapsed().as_secs_f64(),
        warnings,
    };
    let held_back = TripTotals { rows: held_back.to_vec(), ..table };
    let held_back = Rows::new(&held_back, noise, curb_kg, trip_m, &per_distance);
    Ok((answer, expectation.of(&held_back)))
}

/// The findings of a calibration.
struct Estimate {
    known: Known,
    emulator: Emulator,
    posterior: Posterior,
    shared: Shared,
    effective_rows: f64,
    questions: Vec<(Question, MemberEmulator)>,
}

impl Estimate {
    fn of(design: &Design, driven: &[Driven], questions: &[Question]) -> Self {
        let rows = design.rows;
        let members: Vec<Member> = driven.iter().map(|driven| driven.member.clone()).collect();
        let known = Known { gross: rows.has_gross(), responses: rows.responses.clone() };
        let emulator = Emulator::fit(&members, &known).expect("members have trips");
        let count = design.entries.len();
        let n = rows.totals.len() as f64;
        let shared = |rows: f64| Shared {
            discrepancies: emulator.discrepancies(),
            weight: (rows.min(MOST_ROWS) / n).min(1.0),
        };
        let first = posterior(&emulator, &rows.totals, &shared(n), count);
        let effective_rows = effective_rows(rows, &first);
        let shared = shared(effective_rows);
        let posterior = posterior(&emulator, &rows.totals, &shared, count);
        let scores = |place: usize| {
            let has = driven.iter().filter(move |driven| driven.changes[place].is_some());
            has.map(move |driven| (driven.member.scores.clone(), driven.changes[place]))
        };
        let questions = questions.iter().enumerate().filter_map(|(place, question)| {
            let (scores, changes): (Vec<_>, Vec<_>) = scores(place).unzip();
            let changes: Vec<f64> = changes.into_iter().flatten().collect();
            (changes.len() > count).then(|| (*question, MemberEmulator::fit(&scores, &changes)))
        });
        let questions = questions.collect();
        Self { known, emulator, posterior, shared, effective_rows, questions }
    }

    fn questioned(&self) -> Vec<Questioned> {
        let one = |(question, emulator): &(Question, MemberEmulator)| {
            let (change, slopes) = emulator.at(&self.posterior.scores);
            let interval = |centre: f64, sd: f64| {
                let half = NORMAL_95 * libm::sqrt(sd * sd + emulator.lack_of_fit());
                [centre - half, centre + half]
            };
            let (judged, _) = emulator.at(&vec![0.0; self.posterior.scores.len()]);
            Questioned {
                question: *question,
                change,
                ci90: interval(change, self.posterior.sd(&slopes)),
                judged_ci90: interval(judged, slopes.norm()),
            }
        };
        self.questions.iter().map(one).collect()
    }

    fn known_words(&self) -> Vec<&'static str> {
        let gross = self.known.gross.then_some("gross weight");
        let word_of = |response: &Response| match response {
            Response::Climb => "climb",
            Response::Speed => "driving time",
            Response::Consumption => "consumption",
        };
        gross.into_iter().chain(self.known.responses.iter().map(word_of)).collect()
    }
}

/// Rows that count as independent: from what trucks and drivers differ by beyond what explains a
/// trip.
fn effective_rows(rows: &Rows, first: &Posterior) -> f64 {
    let n = rows.totals.len() as f64;
    let place = rows.responses.iter().position(|response| *response == Response::Consumption);
    let Some(place) = place else { return n };
    let names = |text_of: fn(&TripTotal) -> &String| {
        rows.of_table.iter().map(|row| text_of(row).clone()).collect::<Vec<String>>()
    };
    let driver = names(|row| &row.driver);
    let table = FleetTable {
        truck: names(|row| &row.truck),
        driver: driver.iter().any(|name| !name.is_empty()).then_some(driver),
        value: first.residuals.iter().map(|row| row[place]).collect(),
        ..FleetTable::default()
    };
    let options = FleetOptions { draws: 1, ..FleetOptions::default() };
    let Ok(fleet_fit) = fit(&table, &options) else { return n };
    let variance: f64 = fleet_fit.components.iter().map(|c| c.sd * c.sd).sum();
    let error = fleet_fit.mean_standard_error;
    (variance / (error * error)).clamp(1.0, n)
}

/// Trucks and drivers of the rows.
fn counted(rows: &Rows) -> (Option<usize>, Option<usize>) {
    let count = |names: BTreeSet<&str>| {
        let count = names.iter().filter(|name| !name.is_empty()).count();
        (count > 0).then_some(count)
    };
    (
        count(rows.of_table.iter().map(|row| row.truck.as_str()).collect()),
        count(rows.of_table.iter().map(|row| row.driver.as_str()).collect()),
    )
}

/// Where the numbers are from: `60 trips of 12 trucks in trips.csv`.
fn standing(rows: &Rows, trucks: Option<usize>, of_fills: bool, trips: &Source) -> String {
    let what = if of_fills { "full tank" } else { "trip" };
    let count = count_of(rows.totals.len() as u64, what);
    let of_trucks =
        trucks.map_or(String::new(), |trucks| format!(" of {}", count_of(trucks as u64, "truck")));
    format!("{count}{of_trucks} in `{}`", trips.path().display())
}

impl Answer for CalibrateTotalsAnswer {
    fn text(&self) -> String {
        text::totals_text(self)
    }

    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    fn notes(&self) -> Vec<String> {
        FileAccount::told_of(&self.inputs)
    }
}
