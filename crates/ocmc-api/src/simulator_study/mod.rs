//! The paper's driving-simulator study, driven again: its tables and pictures, with the paper's
//! numbers beside those of many repetitions.

mod files;
mod paper;
mod recorded;
mod slopes;
mod text;

use crate::error::{Error, FitError};
use crate::watch::{Progress, Watch, aside};
use ocmc_estimation::fit::curve_speed::{
    CurveSpeedFit, CurveSpeedOptions, CurveTable, fit as fit_curve_speed,
};
use ocmc_estimation::fit::speed_change::{
    SpeedChangeFit, SpeedChangeOptions, SpeedChangeTable, fit as fit_speed_change,
};
use ocmc_estimation::identification::options::{IdentifyOptions, SpeedTerm, Unknowns};
use ocmc_fleet::quantile::quantile;
use ocmc_fleet::run::{RunPlan, each};
use ocmc_io::report::{
    ComparedNumber, SimulatorChange, SimulatorCurve, SimulatorDrive, SimulatorEvent,
    SimulatorRepetition,
};
use ocmc_io::study::{LoadedStudy, study_hash};
use paper::PRINTED;
use recorded::Recorded;
use serde::Serialize;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Drivers of a repetition: one for each route of the study.
pub const SIMULATOR_DRIVERS: u64 = 8;
/// Fewest repetitions of which nine tenths are a range.
const FEWEST_FOR_RANGE: usize = 20;
/// Most repetitions: the curves and changes of all of them are held.
pub const MOST_REPETITIONS: u64 = 10_000;

/// The study, and how often it is repeated.
#[derive(Clone, Debug)]
pub struct SimulatorStudyRequest<'a> {
    /// The study: cycle 8 r + d is driver d of repetition r.
    pub study: &'a LoadedStudy,
    /// Master seed.
    pub seed: u64,
    /// Repetitions, each with drivers of its own.
    pub repetitions: u64,
    /// Threads; none: one for each CPU.
    pub threads: Option<usize>,
    /// Whether the gains of the first repetition are identified, which takes most of the time, and
    /// with which speed term.
    pub identify: Option<SpeedTerm>,
}

/// The paper's tables, of the study.
#[derive(Clone, Debug, Serialize)]
pub struct SimulatorStudyAnswer {
    /// Name of the study.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Master seed.
    pub seed: u64,
    /// Repetitions.
    pub repetitions: u64,
    /// Drives whose log cannot be read: their repetitions lack them.
    pub left_out: u64,
    /// The paper's numbers beside those of the repetitions.
    pub compared: Vec<ComparedNumber>,
    /// Curve speeds of the first repetition.
    pub curve_speed: CurveSpeedFit,
    /// Speed changes of the first repetition.
    pub speed_change: SpeedChangeFit,
    /// Slopes of the first repetition with the gains that were identified.
    pub events: Vec<SimulatorEvent>,
    /// All curves.
    pub curves: Vec<SimulatorCurve>,
    /// All changes of the limit.
    pub changes: Vec<SimulatorChange>,
    /// How long it took, in s.
    pub wall_s: f64,
    /// Threads that it took.
    pub threads: usize,
    #[serde(skip)]
    first: SimulatorRepetition,
}

/// Drives the study and makes the paper's tables.
///
/// ```
/// use ocmc_api::{Answer, SimulatorStudyRequest, go_on, simulator_study, study};
/// let study = &study::load("simulator-study", &["simulation.step_s=0.5"])?;
/// let request =
///     SimulatorStudyRequest { study, seed: 1, repetitions: 2, threads: None, identify: None };
/// let answer = simulator_study(&request, &mut go_on)?;
/// // eight drivers, six curves and four changes of the limit each
/// assert_eq!((answer.curves.len(), answer.changes.len()), (96, 64));
/// let degrees: Vec<usize> = answer.curve_speed.anova.iter().map(|row| row.df).collect();
/// assert_eq!(degrees, [1, 7, 1, 38]);
/// assert!(answer.text().contains("exponent"));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Fit`] where curves or changes have no fit, [`Error::Interrupted`].
pub fn simulator_study(
    request: &SimulatorStudyRequest,
    watch: &mut Watch,
) -> Result<SimulatorStudyAnswer, Error> {
    let SimulatorStudyRequest { study, seed, repetitions, threads, identify } = *request;
    let clock = Instant::now();
    let cycles = SIMULATOR_DRIVERS * repetitions;
    let plan = RunPlan::new(seed, 0, cycles, threads, None);
    let progress = |done| Progress { what: "drives", done, total: cycles };
    progress(0).look(watch)?;
    let one =
        |id: u64, _: &AtomicBool| Recorded::of(&study.study, seed, id, id < SIMULATOR_DRIVERS);
    let drives = progress(0).ended(each(&plan, &one, |done| watch(progress(done))))?;
    let mut all = Vec::with_capacity(drives.len());
    let (mut curves, mut changes, mut left_out) = (Vec::new(), Vec::new(), 0);
    for (id, drive) in drives.into_iter().enumerate() {
        let Some(drive) = drive else {
            left_out += 1;
            continue;
        };
        let (repetition, driver) = place(id as u64);
        curves.extend(drive.curves.iter().map(|curve| SimulatorCurve {
            repetition,
            driver,
            radius_m: curve.radius_m,
            left: curve.left,
            speed_mps: curve.speed_mps,
        }));
        changes.extend(drive.changes.iter().map(|(change, acceleration_mps2)| SimulatorChange {
            repetition,
            driver,
            change: change.clone(),
            acceleration_mps2: *acceleration_mps2,
        }));
        all.push((driver, drive.signals));
    }
    let named = |error| Error::Fit(PathBuf::from(&study.model.study.name), error);
    let mut fits = Vec::new();
    for repetition in 0..repetitions {
        Progress { what: "repetitions", done: repetition, total: repetitions }.look(watch)?;
        let own = curves.iter().filter(|curve| curve.repetition == repetition);
        let speeds = curve_table(own);
        let speeds = fit_curve_speed(&speeds, &CurveSpeedOptions::default())
            .map_err(|error| named(FitError::CurveSpeed(error)))?;
        let own = changes.iter().filter(|change| change.repetition == repetition);
        let accelerations = fit_speed_change(&change_table(own), &SpeedChangeOptions::default())
            .map_err(|error| named(FitError::SpeedChange(error)))?;
        fits.push((speeds, accelerations));
    }
    let compared = PRINTED
        .into_iter()
        .map(|(table, quantity, paper, value_of)| {
            let values = fits.iter().filter_map(|(curves, changes)| value_of(curves, changes));
            let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
            values.sort_by(f64::total_cmp);
            let n = values.len();
            let at = |share| quantile(&values, share);
            let end = |share| at(share).filter(|_| n >= FEWEST_FOR_RANGE);
            let (median, p5, p95) = (at(0.5), end(0.05), end(0.95));
            ComparedNumber { table, quantity, paper, median, p5, p95, n }
        })
        .collect();
    let signals: Vec<_> =
        all.into_iter().filter_map(|(driver, signals)| Some((driver, signals?))).collect();
    let events = match identify {
        None => Vec::new(),
        Some(speed_term) => {
            let options = IdentifyOptions {
                speed_term,
                unknown: Unknowns::NONE,
                intervals: false,
                threads: threads.unwrap_or(0),
                ..IdentifyOptions::default()
            };
            let events = slopes::of(&signals);
            let start = Progress { what: "events", done: 0, total: events.len() as u64 };
            aside(start, watch, |stop, done| {
                slopes::identified(&study.study, events, &options, stop, done)
            })?
        }
    };
    let (curve_speed, speed_change) = fits.swap_remove(0);
    let first = first(&curve_speed, &speed_change, &curves, &changes, &events, signals);
    Ok(SimulatorStudyAnswer {
        study: study.model.study.name.clone(),
        study_hash: study_hash(&study.model),
        seed,
        repetitions,
        left_out,
        compared,
        curve_speed,
        speed_change,
        events,
        curves,
        changes,
        wall_s: clock.elapsed().as_secs_f64(),
        threads: plan.threads,
        first,
    })
}

/// Repetition, from 0, and driver, from 1, of a cycle.
fn place(cycle_id: u64) -> (u64, usize) {
    (cycle_id / SIMULATOR_DRIVERS, (cycle_id % SIMULATOR_DRIVERS) as usize + 1)
}

fn curve_table<'a>(curves: impl Iterator<Item = &'a SimulatorCurve>) -> CurveTable {
    let (mut table, mut left) = (CurveTable::default(), Vec::new());
    for curve in curves {
        table.driver.push(curve.driver.to_string());
        table.radius_m.push(curve.radius_m);
        table.speed_mps.push(curve.speed_mps);
        left.push(curve.left);
    }
    CurveTable { left: Some(left), ..table }
}

fn change_table<'a>(changes: impl Iterator<Item = &'a SimulatorChange>) -> SpeedChangeTable {
    let mut table = SpeedChangeTable::default();
    for change in changes {
        table.driver.push(change.driver.to_string());
        table.category.push(change.change.clone());
        table.acceleration_mps2.push(change.acceleration_mps2);
    }
    table
}

/// Quantities in the pictures.
fn first(
    curve_speed: &CurveSpeedFit,
    speed_change: &SpeedChangeFit,
    curves: &[SimulatorCurve],
    changes: &[SimulatorChange],
    events: &[SimulatorEvent],
    signals: Vec<(usize, recorded::Signals)>,
) -> SimulatorRepetition {
    let options = SpeedChangeOptions::default();
    let law = |change: &str| speed_change.by_category.iter().find(|law| law.category == change);
    let medians = paper::MEDIANS_MPS2
        .map(|(change, paper)| (change, law(change).map(|law| law.median_mps2), paper));
    let law = |estimate: &ocmc_estimation::fit::curve_speed::CurveSpeedEstimate| {
        [estimate.exponent, estimate.reference_speed_mps]
    };
    let drive = |(_, signals): (usize, recorded::Signals)| SimulatorDrive {
        series: slopes::series(&signals.log, 0..signals.log.time_s.len()),
        limit_mps: signals.limit_mps,
    };
    SimulatorRepetition {
        curves: curves.iter().filter(|curve| curve.repetition == 0).cloned().collect(),
        curve_laws: [law(&curve_speed.estimated), law(&curve_speed.fixed)],
        reference_radius_m: curve_speed.reference_radius_m,
        changes: changes.iter().filter(|change| change.repetition == 0).cloned().collect(),
        medians_mps2: medians.to_vec(),
        within_mps2: [-options.smallest_deceleration_mps2, options.smallest_acceleration_mps2],
        events: events.to_vec(),
        drives: signals.into_iter().map(drive).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_lie_between_the_values() {
        let values = [1.0, 2.0, 4.0];
        let at = |share| quantile(&values, share).unwrap();
        assert!((at(0.0), at(0.5), at(1.0)) == (1.0, 2.0, 4.0));
        assert!((at(0.75) - 3.0).abs() < 1e-12 && quantile(&[], 0.5).is_none());
    }

    #[test]
    fn cycles_are_drivers_of_repetitions() {
        assert_eq!([place(0), place(7), place(8), place(23)], [(0, 1), (0, 8), (1, 1), (2, 8)]);
    }
}
