//! Questions as JSON, for pages and other programs: one object asks, and lines of objects answer:
//! how far the work is, then the answer, which is that of the command's `--json`.

mod calibrated;
mod files;
mod message;
pub mod part;
mod question;
mod schema;
mod study;
mod thinned;
mod trip;

use crate::bound::{BoundRequest, bound};
use crate::calibrate_totals::{CalibrateTotalsRequest, Noise, calibrate_totals};
use crate::compare::{CompareRequest, compare_known};
use crate::cost::{CostRequest, cost};
use crate::doubt::{DoubtRequest, doubt};
use crate::drive::GivenDrive;
use crate::error::Error;
use crate::mixed_fleet::{MixedFleetRequest, mixed_fleet};
use crate::precision::precision;
use crate::progress::{Progress, Watch};
use crate::range::{RangeRequest, range};
use crate::run::{
    Asked, CpuLevel, LAST_CYCLE_ID, MOST_THREADS, Precision, RecordFormat, RunAnswer, RunEnd,
    RunPlan, RunRequest, run_known,
};
use crate::sensitivity::{SensitivityRequest, sensitivity};
use crate::size::{SizeRequest, size};
use crate::source::{Source, mappings};
use crate::study::{Files, Given, LoadedStudy, Opened, open, open_all};
use crate::sweep::{SweepPoints, SweepRequest, sweep};
pub use calibrated::CalibratedAnswer;
use files::accounted;
pub use files::{AccountedFile, FileKind, FilesAnswer, RouteEntry, RouteMap, RouteProfile};
pub use message::{AskAnswer, Message, Reply, VERSION};
use ocmc_core::record::Record;
pub use question::{
    Ask, AskCalibrateTotals, AskCompare, AskFiles, AskPair, AskPlan, AskRun, AskSensitivity,
    AskSize, AskStudy, AskStudyText, AskSweep, AskTrip, AskedStudy, GivenStudy, StudySource,
};
pub use schema::ask_schema;
use std::path::{Path, PathBuf};
pub use study::{StudyAnswer, study_answer};
pub use trip::TripAnswer;
use trip::trip;

/// Cycles where their number is not said.
const CYCLES: u64 = 1000;

/// Answers a question, of studies that may name these files.
///
/// ```
/// use ocmc_api::ask::{Ask, ask};
/// use ocmc_api::{go_on, study::Files};
/// let question = r#"{"ask": "run", "study": {"study": "field-truck",
///     "set": ["mission.length_m=5000"]}, "plan": {"cycles": 10}}"#;
/// let question: Ask = serde_json::from_str(question).expect("a question");
/// let reply = ask(&question, &Files::here(), &mut go_on)?;
/// let text = serde_json::to_string(&reply).expect("numbers and words");
/// assert!(text.contains("\"version\":1") && text.contains("\"consumption_l_per_100km\""));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// Those of the function that answers it, and of the study.
pub fn ask(question: &Ask, files: &Files, watch: &mut Watch) -> Result<Reply, Error> {
    ask_known(question, files, None, watch)
}

/// As [`ask`], where the records of each study may be known.
fn ask_known(
    question: &Ask,
    files: &Files,
    known: Option<Vec<Vec<Record>>>,
    watch: &mut Watch,
) -> Result<Reply, Error> {
    let mut warnings = Vec::new();
    let mut load = |study: &AskedStudy| {
        let loaded = opened(study, files)?;
        warnings.extend(loaded.warnings());
        Ok::<_, Error>(loaded)
    };
    let mut named = |study: &AskedStudy| Ok::<_, Error>((study.name(), load(study)?));
    let answer = match question {
        Ask::Run(asked) => return run_of(asked, files, known, watch),
        Ask::Compare(AskCompare { studies, plan, column }) => {
            let studies = studies.iter().map(&mut named).collect::<Result<Vec<_>, _>>()?;
            let lent = studies.iter().map(|(name, study)| (name.clone(), study)).collect();
            let plan = planned(plan)?;
            let request =
                CompareRequest { studies: lent, plan, column: column.clone(), keep: false };
            AskAnswer::Compare(compare_known(&request, known, watch)?)
        }
        Ask::Sweep(AskSweep { study, points, against, plan, column }) => {
            let (fixed, points) = SweepPoints::of_settings(points)?;
            let (name, loaded) = named(study)?;
            let loaded = loaded.set(&fixed)?;
            let request = SweepRequest {
                study: (name, &loaded),
                points,
                against: *against,
                plan: planned(plan)?,
                column: column.clone(),
            };
            AskAnswer::Sweep(sweep(&request, watch)?)
        }
        Ask::Sensitivity(asked) => {
            let AskSensitivity { study, plan, column, factors, over, shapley } = asked;
            let request = SensitivityRequest {
                study: &named(study)?.1,
                plan: planned(plan)?,
                column: column.clone(),
                factors: factors.clone(),
                over: *over,
                crossed: None,
                shapley: *shapley,
            };
            AskAnswer::Sensitivity(sensitivity(&request, watch)?)
        }
        Ask::Doubt(AskPair { study, against, plan, column }) => {
            let (name, loaded) = named(study)?;
            let against = against.as_ref().map(&mut named).transpose()?;
            let request = DoubtRequest {
                study: (name, &loaded),
                against: against.as_ref().map(|(name, study)| (name.clone(), study)),
                plan: planned(plan)?,
                column: column.clone(),
            };
            AskAnswer::Doubt(doubt(&request, watch)?)
        }
        Ask::Cost(AskPair { study, against, plan, .. }) => {
            let (name, loaded) = named(study)?;
            let against = against.as_ref().map(&mut named).transpose()?;
            let request = CostRequest {
                study: (name, &loaded),
                against: against.as_ref().map(|(name, study)| (name.clone(), study)),
                plan: planned(plan)?,
            };
            AskAnswer::Cost(cost(&request, watch)?)
        }
        Ask::Range(AskStudy { study, plan }) => {
            let (name, loaded) = named(study)?;
            let request = RangeRequest { study: (name, &loaded), plan: planned(plan)? };
            AskAnswer::Range(range(&request, watch)?)
        }
        Ask::Size(AskSize { study, arrive, kg_per_kwh, season, plan }) => {
            let (name, loaded) = named(study)?;
            let request = SizeRequest {
                study: (name, &loaded),
                arrive: arrive.clone(),
                kg_per_kwh: *kg_per_kwh,
                season: *season,
                plan: planned(plan)?,
            };
            AskAnswer::Size(size(&request, watch)?)
        }
        Ask::Bound(AskStudy { study, plan }) => {
            let request = BoundRequest { study: &named(study)?.1, plan: planned(plan)? };
            AskAnswer::Bound(bound(&request, watch)?)
        }
        Ask::Files(AskFiles { files: names }) => {
            AskAnswer::Files(accounted(names.as_deref(), files)?)
        }
        Ask::Study(AskStudyText { study, against }) => {
            AskAnswer::Study(study_answer(study, against.as_ref(), files)?)
        }
        Ask::Trip(AskTrip { study, cycle, seed }) => {
            let one = AskPlan { cycles: Some(1), first_cycle: *cycle, ..AskPlan::default() };
            planned(&one)?;
            AskAnswer::Trip(trip(&named(study)?.1, *seed, *cycle))
        }
        Ask::CalibrateTotals(AskCalibrateTotals { study, table, map, seed }) => {
            let (_, loaded) = named(study)?;
            let request = CalibrateTotalsRequest {
                trips: Source::File(files.path_of("table", table)?),
                mappings: mappings(map)?,
                study: &loaded,
                noise: Noise::default(),
                seed: *seed,
                threads: None,
            };
            let answer = calibrate_totals(&request, watch)?;
            AskAnswer::CalibrateTotals(CalibratedAnswer::new(&loaded, answer))
        }
    };
    Ok(Reply::new(warnings, answer))
}

/// A run of a study, or of the groups of one.
fn run_of(
    asked: &AskRun,
    files: &Files,
    known: Option<Vec<Vec<Record>>>,
    watch: &mut Watch,
) -> Result<Reply, Error> {
    let AskRun { study, trucks, precision: end, plan } = asked;
    let AskPlan { cycles, seed, first_cycle, threads } = *plan;
    let loaded = match of_run(study, files)? {
        Opened::Study(loaded) => loaded,
        Opened::Fleet(groups) => {
            for (key, is_there) in [
                ("cycles", cycles.is_some()),
                ("trucks", trucks.is_some()),
                ("first_cycle", first_cycle != 0),
                ("precision", end.is_some()),
            ] {
                if is_there {
                    return Err(Error::NotOfGroups(key));
                }
            }
            let warnings = groups.iter().flat_map(|group| group.study.warnings()).collect();
            let request = MixedFleetRequest {
                groups: &groups,
                seed,
                threads,
                level: CpuLevel::best(),
                out: None,
                resume: false,
            };
            let answer = mixed_fleet(&request, watch)?;
            return Ok(Reply::new(warnings, AskAnswer::Fleet(answer)));
        }
    };
    let known = known.and_then(|known| known.into_iter().next());
    let answer = run_loaded(asked, &loaded, known, None, watch)?;
    Ok(Reply::new(loaded.warnings(), AskAnswer::Run(answer)))
}

/// Drives a run that was asked for, not one of groups, and keeps it in a directory.
///
/// # Errors
/// Those of [`run`](crate::run::run), and of the study.
pub fn keep_run(
    asked: &AskRun,
    files: &Files,
    directory: &Path,
    watch: &mut Watch,
) -> Result<RunAnswer, Error> {
    let out = (directory.to_owned(), RecordFormat::Parquet);
    run_loaded(asked, &opened(&asked.study, files)?, None, Some(out), watch)
}

/// Drives a run of a study, unless its records are known.
fn run_loaded(
    asked: &AskRun,
    loaded: &LoadedStudy,
    known: Option<Vec<Record>>,
    out: Option<(PathBuf, RecordFormat)>,
    watch: &mut Watch,
) -> Result<RunAnswer, Error> {
    let end = &asked.precision;
    let wrong = |error| Error::Precision(format!("`precision`: {error}"));
    let precision = end.as_deref().map(|text| precision(text).map_err(wrong)).transpose()?;
    let plan = planned_run(asked, loaded, precision.clone())?;
    let given = &GivenDrive::nothing();
    let request = RunRequest { study: loaded, given, plan, precision, out };
    let answer = run_known(&request, known, &mut |_| (), watch)?;
    if answer.ended == RunEnd::Interrupted {
        let (done, total) = (answer.summary.summary.cycles, plan.cycles);
        return Err(Error::Interrupted(Progress { what: "cycles", done, total }));
    }
    Ok(answer)
}

/// The study of a run, or its groups.
fn of_run(study: &AskedStudy, files: &Files) -> Result<Opened, Error> {
    given(study, |given| Ok(open_all(given, files, study.set())?))
}

/// The cycles of a run, and on what they are driven.
fn planned_run(
    asked: &AskRun,
    loaded: &LoadedStudy,
    precision: Option<Precision>,
) -> Result<RunPlan, Error> {
    let AskPlan { cycles, seed, first_cycle, threads } = asked.plan;
    let (seed, first_cycle, trucks) = (Some(seed), Some(first_cycle), asked.trucks);
    let asked = Asked {
        loaded: Some(loaded),
        seed,
        first_cycle,
        cycles,
        trucks,
        precision,
        ..Asked::default()
    };
    within(asked.plan(loaded, threads, None, CpuLevel::best()))
}

/// The study.
fn opened(study: &AskedStudy, files: &Files) -> Result<LoadedStudy, Error> {
    given(study, |given| Ok(open(given, files, study.set())?))
}

/// Makes something of a study that is named, or whose keys are given.
fn given<T>(study: &AskedStudy, made: impl FnOnce(&Given) -> Result<T, Error>) -> Result<T, Error> {
    match study {
        AskedStudy::Named(name)
        | AskedStudy::Given(GivenStudy { study: StudySource::Named(name), .. }) => {
            made(&Given::Named(Path::new(name)))
        }
        AskedStudy::Given(GivenStudy { study: StudySource::Keys(keys), .. }) => {
            made(&Given::Dictionary(&keys.clone().into()))
        }
    }
}

/// The cycles, and on what they are driven.
fn planned(asked: &AskPlan) -> Result<RunPlan, Error> {
    let AskPlan { cycles, seed, first_cycle, threads } = *asked;
    within(RunPlan::new(seed, first_cycle, cycles.unwrap_or(CYCLES), threads, None))
}

/// The plan, where there are such cycles.
fn within(plan: RunPlan) -> Result<RunPlan, Error> {
    let end = plan.first_cycle.checked_add(plan.cycles).filter(|end| *end <= LAST_CYCLE_ID);
    match end {
        Some(_) if plan.cycles > 0 && plan.threads <= MOST_THREADS => Ok(plan),
        _ => Err(Error::NoSuchCycles(plan)),
    }
}
