//! Totals of a fleet: a study is driven, or given drives are driven by its population.

mod charging_text;
mod parts_text;
mod requeue;
mod text;
mod trucks_text;

use crate::answer::Answer;
use crate::error::Error;
use crate::watch::{Progress, Watch};
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_fleet::precision::InterimChecks;
use ocmc_fleet::summary::{Summary, SummaryBuilder};
use ocmc_fleet::uncertainty::Effects;
use ocmc_io::given_drive::GivenDrive;
use ocmc_io::intake::FileAccount;
use ocmc_io::run_directory::{self, RunDirectory, RunStatus, RunSummary, read_manifest};
use ocmc_io::study::{Files, LoadedStudy, Origin};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Serialize, Serializer};
use std::borrow::Cow;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

pub use requeue::{Asked, RequeueRequest, requeue};
pub(crate) use text::{WIDTH, judged};

pub use ocmc_core::kernel::drive::cpu::CpuLevel;
pub use ocmc_core::random::LAST_CYCLE_ID;
pub use ocmc_fleet::precision::Precision;
pub use ocmc_fleet::run::{MOST_THREADS, RunPlan};
pub use ocmc_io::records::RecordFormat;
pub use ocmc_io::run_directory::{MANIFEST, Manifest, RunDirectoryError, SUMMARY};

/// Drives to be run.
#[derive(Clone, Debug)]
pub struct RunRequest<'a> {
    /// The study.
    pub study: &'a LoadedStudy,
    /// Drives that replace its roads.
    pub given: &'a GivenDrive,
    /// The cycles, and on what they are driven.
    pub plan: RunPlan,
    /// At which precision the run may end before its last cycle.
    pub precision: Option<Precision>,
    /// Where the run is written, and in which format its records are.
    pub out: Option<(PathBuf, RecordFormat)>,
}

/// A run that is to be finished.
#[derive(Clone, Copy, Debug)]
pub struct ResumeRequest<'a> {
    /// Its directory.
    pub directory: &'a Path,
    /// The files that its study may name.
    pub files: &'a Files,
    /// Drives that it is said to have been given; nothing has to be said.
    pub given: &'a GivenDrive,
    /// Threads; one for each CPU where there is no number.
    pub threads: Option<usize>,
    /// Cycles that a thread drives at a time.
    pub chunk: Option<u64>,
    /// Instructions to use.
    pub level: CpuLevel,
}

/// Totals of a run.
#[derive(Clone, Debug)]
pub struct RunAnswer {
    /// Manifest of the run.
    pub manifest: Manifest,
    /// Totals of its cycles.
    pub summary: RunSummary,
    /// Where its study comes from.
    pub origin: Origin,
    /// Cycles that were there before it was resumed.
    pub resumed: u64,
    /// How it ended.
    pub ended: RunEnd,
    /// Files with drives that were read.
    pub inputs: Vec<FileAccount>,
    /// Doubts about the given drives.
    pub doubts: Vec<String>,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunEnd {
    /// All that was asked for is known.
    Complete,
    /// The caller has ended it.
    Interrupted,
    /// It was complete before it was resumed: nothing was driven.
    WasComplete,
}

/// Drives a run. `sink` receives the records in the order of the cycle ids.
///
/// Where the watch breaks, the answer is that of the cycles that are done.
///
/// ```
/// use ocmc_api::{Answer, Carrier, GivenDrive, RunPlan, RunRequest, go_on, run, study};
/// let study = study::load("field-truck", &["mission.length_m=5000"])?;
/// let given = &GivenDrive::nothing();
/// let plan = RunPlan::new(1, 0, 20, None, None);
/// let request = RunRequest { study: &study, given, plan, precision: None, out: None };
/// let mut litres = Vec::new();
/// let answer = run(
///     &request,
///     &mut |records| litres.extend(records.iter().map(|r| r.consumption(Carrier::LiquidFuel))),
///     &mut go_on,
/// )?;
/// assert_eq!((litres.len(), answer.summary.summary.cycles), (20, 20));
/// assert!(answer.text().starts_with("study      field-truck\n"));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Study`] where what is given does not fit the study, [`Error::PartOfTruck`] where a
/// truck would make some of its trips only, [`Error::RunDirectory`] where the directory holds a run
/// already, and [`Error::Unwritten`] where it takes no more.
pub fn run(
    request: &RunRequest,
    sink: &mut dyn FnMut(&[Record]),
    watch: &mut Watch,
) -> Result<RunAnswer, Error> {
    run_known(request, None, sink, watch)
}

/// As [`run`], where the records may be known.
pub(crate) fn run_known(
    request: &RunRequest,
    known: Option<Vec<Record>>,
    sink: &mut dyn FnMut(&[Record]),
    watch: &mut Watch,
) -> Result<RunAnswer, Error> {
    let RunRequest { study, given, plan, precision, out } = request;
    let loaded = given.study((*study).clone())?;
    whole_trucks(&loaded.study, plan)?;
    let manifest = Manifest { precision: precision.clone(), ..Manifest::new(&loaded, plan, given) };
    let fleet = SummaryBuilder::of(&Arc::new(loaded.study.clone()), plan.seed);
    let directory = match out {
        Some((path, format)) => Some(RunDirectory::create(path, *format, manifest.clone())?),
        None => None,
    };
    let driven = drive(&loaded.study, given, known, manifest, plan, directory, fleet, sink, watch)?;
    // what a study says of its own roads it says where it is read
    let doubts = if given.is_nothing() { None } else { loaded.above_law() };
    let doubts = doubts.into_iter().collect();
    Ok(RunAnswer { origin: loaded.origin, doubts, ..driven })
}

/// Finishes a run.
///
/// ```
/// use ocmc_api::{CpuLevel, GivenDrive, RecordFormat, ResumeRequest, RunEnd, RunPlan, RunRequest};
/// use ocmc_api::{go_on, resume, run, study};
/// use std::ops::ControlFlow;
/// let study = study::load("field-truck", &["mission.length_m=3000"])?;
/// let (given, plan) = (&GivenDrive::nothing(), RunPlan::new(1, 0, 8, None, None));
/// let folder = tempfile::tempdir().expect("a directory");
/// let directory = &folder.path().join("a");
/// let out = Some((directory.clone(), RecordFormat::Csv));
/// let request = RunRequest { study: &study, given, plan, precision: None, out };
/// let begun = run(&request, &mut |_| (), &mut |_| ControlFlow::Break(()))?;
/// assert_eq!((begun.ended, begun.manifest.completed), (RunEnd::Interrupted, 0));
/// let level = CpuLevel::best();
/// let files = &study::Files::here();
/// let request = ResumeRequest { directory, files, given, threads: None, chunk: None, level };
/// assert_eq!(resume(&request, &mut go_on)?.manifest.completed, 8);
/// assert_eq!(resume(&request, &mut go_on)?.ended, RunEnd::WasComplete);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::OtherRun`] where it is a run of something else, [`Error::RunDirectory`] where there is
/// none, or one that this program cannot go on with, and
/// [`Error::Unwritten`] where its directory takes no more.
pub fn resume(request: &ResumeRequest, watch: &mut Watch) -> Result<RunAnswer, Error> {
    let ResumeRequest { directory: path, files, given, threads, chunk, level } = *request;
    if !given.is_nothing() {
        let manifest = read_manifest(path)?;
        if !given.is_that_of(manifest.followed.as_ref(), &manifest.routes())? {
            return Err(Error::OtherRun { directory: path.to_owned() });
        }
    }
    let Some(unfinished) = run_directory::unfinished(path, files)? else {
        let stored = run_directory::read(path)?;
        return Ok(RunAnswer::stored(stored.manifest, stored.summary, RunEnd::WasComplete));
    };
    let (of, seed) = (Arc::new(unfinished.study.study.clone()), unfinished.manifest.seed);
    let mut fleet = SummaryBuilder::of(&of, seed);
    let directory = RunDirectory::resume(&unfinished, |records| fleet.add(records))?;
    let run_directory::Unfinished { manifest, study, given, .. } = unfinished;
    let done = fleet.cycles();
    let (first_cycle, cycles) = (manifest.first_cycle + done, manifest.cycles - done);
    let plan = RunPlan::new(manifest.seed, first_cycle, cycles, threads, chunk);
    let plan = RunPlan { level, ..plan };
    let (study, directory) = (&study.study, Some(directory));
    drive(study, &given, None, manifest, &plan, directory, fleet, &mut |_| (), watch)
}

/// Checks that a run holds whole trucks: parts of one are no truck's year, and no part of a fleet.
pub(crate) fn whole_trucks(study: &Study, plan: &RunPlan) -> Result<(), Error> {
    let trips_per_truck = study.nesting().trips_per_truck;
    let counts = [("first_cycle", plan.first_cycle), ("cycles", plan.cycles)];
    match counts.into_iter().find(|(_, count)| !count.is_multiple_of(trips_per_truck)) {
        None => Ok(()),
        Some((name, count)) => Err(Error::PartOfTruck { name, count, trips_per_truck }),
    }
}

/// Why a run ended early.
enum Stop {
    PreciseEnough,
    Interrupted,
    Unwritten(RunDirectoryError),
}

/// Drives a run, unless its records are known: all of it, or what is left of it, where `fleet`
/// holds what was driven before.
fn drive(
    study: &Study,
    given: &GivenDrive,
    known: Option<Vec<Record>>,
    mut manifest: Manifest,
    plan: &RunPlan,
    mut directory: Option<RunDirectory>,
    mut fleet: SummaryBuilder,
    sink: &mut dyn FnMut(&[Record]),
    watch: &mut Watch,
) -> Result<RunAnswer, Error> {
    let resumed = fleet.cycles();
    let clock = Instant::now();
    let mut look = |done| {
        watch(Progress { what: "cycles", done, total: manifest.cycles })
            .map_break(|()| Stop::Interrupted)
    };
    let trips = study.nesting().trips_per_truck;
    let mut checks = InterimChecks::new(manifest.precision.as_ref(), resumed, trips);
    let mut ended = look(resumed);
    if ended.is_continue() {
        let mut take = |records: &[Record], cycles: u64| {
            sink(records);
            if let Some(directory) = &mut directory
                && let Err(error) = directory.add(records)
            {
                return ControlFlow::Break(Stop::Unwritten(error));
            }
            look(cycles)
        };
        let take = |records: Vec<Record>| {
            let taken = checks.take(&mut fleet, &records, &mut take);
            taken.map_break(|stop| stop.unwrap_or(Stop::PreciseEnough))
        };
        ended = match known {
            Some(records) => [records].into_iter().try_for_each(take),
            None => given.run(study, plan, take),
        };
    }
    let ended = match ended {
        ControlFlow::Break(Stop::Unwritten(error)) => return Err(Error::Unwritten(error)),
        ControlFlow::Break(Stop::Interrupted) => RunEnd::Interrupted,
        ControlFlow::Break(Stop::PreciseEnough) | ControlFlow::Continue(()) => RunEnd::Complete,
    };
    let wall_s = clock.elapsed().as_secs_f64();
    // whoever interrupts a run waits for no adjustment of it
    let mut fleet = if ended == RunEnd::Interrupted { fleet.plain() } else { fleet };
    let reached = manifest.precision.as_ref().map(|precision| precision.check(&mut fleet));
    let cycles = fleet.cycles();
    let mut summary = fleet.finish();
    let mut ended = ended;
    if ended == RunEnd::Complete {
        let (first_cycle, seed) = (manifest.first_cycle, manifest.seed);
        let whole = RunPlan { first_cycle, seed, cycles, ..*plan };
        if on_both_sides(study, given, &whole, &mut summary, watch).is_break() {
            ended = RunEnd::Interrupted;
            if let Some(directory) = &mut directory {
                directory.leave_open();
            }
        }
    }
    let summary = RunSummary::new(&manifest, summary, wall_s, plan.threads);
    let summary = RunSummary { precision: reached, ..summary };
    if let Some(mut directory) = directory {
        if ended == RunEnd::Complete {
            directory.end_here();
        }
        manifest = directory.finish(&summary).map_err(Error::Unwritten)?;
    } else if ended == RunEnd::Complete {
        let (status, completed) = (RunStatus::Complete, cycles);
        manifest = Manifest { status, completed, cycles, precision: None, ..manifest };
    }
    let inputs = given.inputs();
    Ok(RunAnswer { resumed, inputs, ..RunAnswer::stored(manifest, summary, ended) })
}

/// Drives the study on both sides of its uncertain numbers, where it has some.
fn on_both_sides(
    study: &Study,
    given: &GivenDrive,
    plan: &RunPlan,
    summary: &mut Summary,
    watch: &mut Watch,
) -> ControlFlow<()> {
    let (mut before, total) = (0, Effects::cycles_of(study, plan));
    summary.add_uncertainty(study, plan, |study, plan| {
        let what = "cycles with uncertain numbers moved";
        let look = |cycles| watch(Progress { what, done: before + cycles, total });
        let driven = given.records(study, plan, look)?;
        before += plan.cycles;
        ControlFlow::Continue(driven)
    })
}

impl RunAnswer {
    /// Answer of a run that is read back.
    pub(crate) fn stored(manifest: Manifest, summary: RunSummary, ended: RunEnd) -> Self {
        let origin = Origin::BuiltIn(manifest.study.clone());
        Self {
            manifest,
            summary,
            origin,
            resumed: 0,
            ended,
            inputs: Vec::new(),
            doubts: Vec::new(),
        }
    }

    /// The answer for people, for a terminal of that width.
    pub fn text_of_width(&self, width: usize) -> String {
        text::run_text(self, width)
    }
}

/// The summary, and what was read.
#[derive(Serialize, JsonSchema)]
struct WithInputs<'a> {
    #[serde(flatten)]
    summary: &'a RunSummary,
    /// Accounts of what was read; not there where no file was.
    #[serde(skip_serializing_if = "Option::is_none")]
    inputs: Option<&'a [FileAccount]>,
}

/// As it is serialised.
impl JsonSchema for RunAnswer {
    fn schema_name() -> Cow<'static, str> {
        "RunAnswer".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        WithInputs::json_schema(generator)
    }
}

impl Serialize for RunAnswer {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // without files the answer is what `summary.json` has
        let inputs = (!self.inputs.is_empty()).then_some(&self.inputs[..]);
        WithInputs { summary: &self.summary, inputs }.serialize(serializer)
    }
}

impl Answer for RunAnswer {
    fn text(&self) -> String {
        self.text_of_width(WIDTH)
    }

    fn warnings(&self) -> Vec<String> {
        self.doubts.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::watch::go_on;
    use std::fs;

    const ROAD: &str = "mission.length_m=6000";
    const LAW: &str = "driver.curve_speed.parameter_uncertainty=true";

    #[test]
    fn a_run_that_is_ended_on_the_sides_is_resumed_there() {
        let parent = tempfile::tempdir().expect("a directory");
        let study = ocmc_io::study::load("field-truck", &[ROAD, LAW]).expect("a study");
        let given = &GivenDrive::nothing();
        let ended = |name: &str, at_sides: bool| {
            let directory = parent.path().join(name);
            let plan = RunPlan::new(1, 0, 40, Some(2), None);
            let out = Some((directory.clone(), RecordFormat::Csv));
            let request = RunRequest { study: &study, given, plan, precision: None, out };
            let mut watch = |progress: Progress| match progress.what {
                "cycles" => ControlFlow::Continue(()),
                _ if at_sides => ControlFlow::Break(()),
                _ => ControlFlow::Continue(()),
            };
            let answer = run(&request, &mut |_| (), &mut watch).expect("space");
            (directory, answer)
        };
        let (whole, complete) = ended("whole", false);
        let (broken, answer) = ended("broken", true);
        assert_eq!((complete.ended, answer.ended), (RunEnd::Complete, RunEnd::Interrupted));
        assert_eq!(answer.manifest.completed, 40);
        let (files, level) = (&Files::here(), CpuLevel::best());
        let request =
            ResumeRequest { directory: &broken, files, given, threads: None, chunk: None, level };
        let resumed = resume(&request, &mut go_on).expect("a run");
        assert_eq!(resumed.ended, RunEnd::Complete);
        let [a, b] =
            [&complete, &resumed].map(|answer| &answer.summary.summary.parameter_uncertainty);
        assert!(a.is_some() && a == b, "{a:?} {b:?}");
        for file in ["records.csv", "manifest.json"] {
            let [a, b] =
                [&whole, &broken].map(|folder| fs::read(folder.join(file)).expect("written"));
            assert!(a == b, "{file}");
        }
    }
}
