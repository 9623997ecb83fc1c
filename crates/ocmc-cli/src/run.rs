//! `ocmc`: runs a study and prints what its fleet adds up to.

use crate::arguments::RunArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::run_text::{self, Circumstances};
use crate::{interrupt, output, request};
use ocmc_core::fleet::precision::run_until;
use ocmc_core::fleet::run::RunPlan;
use ocmc_core::fleet::summary::SummaryBuilder;
use ocmc_io::run_directory::{self, Manifest, RunDirectory};
use ocmc_io::run_summary::RunSummary;
use ocmc_io::study::{self, LoadedStudy, Origin};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

/// Why a run ended early.
enum Stop {
    Interrupted,
    Failed(Failure),
}

/// A run that is to be driven: all of it, or what is left of it.
struct Job {
    loaded: LoadedStudy,
    manifest: Manifest,
    plan: RunPlan,
    directory: Option<RunDirectory>,
    /// Holds what was driven before.
    fleet: SummaryBuilder,
}

/// Runs the study, writes its records where asked to, and prints the answer.
pub(crate) fn run(arguments: &RunArguments) -> Result<(), Failure> {
    run_study(arguments, || Ok(study::load(&arguments.study, &arguments.set)?))
}

/// As [`run`], of the study that `load` gives.
pub(crate) fn run_study(
    arguments: &RunArguments,
    load: impl FnOnce() -> Result<LoadedStudy, Failure>,
) -> Result<(), Failure> {
    let job = match (&arguments.out, arguments.resume) {
        (Some(path), true) => resume(arguments, path)?,
        _ => Some(begin(arguments, load)?),
    };
    let Some(job) = job else {
        return complete_already(arguments);
    };
    drive(arguments, job)
}

fn begin(
    arguments: &RunArguments,
    load: impl FnOnce() -> Result<LoadedStudy, Failure>,
) -> Result<Job, Failure> {
    let plan = request::plan(arguments)?;
    let loaded = load()?;
    let precision = arguments.precision.clone();
    let manifest = Manifest { precision, ..Manifest::new(&loaded.model, &plan) };
    let fleet = SummaryBuilder::new(loaded.model.driver.curve_speed.uncertain_replicates());
    let directory = match &arguments.out {
        Some(path) => Some(RunDirectory::create(path, arguments.format.into(), manifest.clone())?),
        None => None,
    };
    Ok(Job { loaded, manifest, plan, directory, fleet })
}

/// What is left of the run in a directory; none where it is complete.
fn resume(arguments: &RunArguments, path: &Path) -> Result<Option<Job>, Failure> {
    let Some(unfinished) = run_directory::unfinished(path)? else {
        return Ok(None);
    };
    let study = &unfinished.study.model;
    let mut fleet = SummaryBuilder::new(study.driver.curve_speed.uncertain_replicates());
    let directory = RunDirectory::resume(&unfinished, |records| fleet.add(records))?;
    let manifest = unfinished.manifest;
    let done = fleet.cycles();
    let (first, rest) = (manifest.first_cycle + done, manifest.cycles - done);
    let plan = request::plan_of(arguments, manifest.seed, first, rest)?;
    // the study is that of the run, not the file that its manifest is
    let mut loaded = unfinished.study;
    loaded.origin = Origin::BuiltIn(manifest.study.clone());
    Ok(Some(Job { loaded, manifest, plan, directory: Some(directory), fleet }))
}

fn drive(arguments: &RunArguments, job: Job) -> Result<(), Failure> {
    let Job { loaded, manifest, plan, mut directory, mut fleet } = job;
    let resumed = fleet.cycles();
    interrupt::listen();
    let clock = Instant::now();
    let progress = Progress::new(manifest.cycles, resumed, arguments.quiet);
    let precision = manifest.precision.as_ref();
    let ended = run_until(&loaded.study, &plan, precision, &mut fleet, |records, cycles| {
        if let Some(directory) = &mut directory
            && let Err(error) = directory.add(records)
        {
            return ControlFlow::Break(Stop::Failed(error.into()));
        }
        progress.reach(cycles);
        if interrupt::asked() && cycles < manifest.cycles {
            return ControlFlow::Break(Stop::Interrupted);
        }
        ControlFlow::Continue(())
    });
    progress.finish();
    if let ControlFlow::Break(Stop::Failed(failure)) = ended {
        return Err(failure);
    }

    let wall_s = clock.elapsed().as_secs_f64();
    let reached = precision.map(|precision| precision.look(&fleet));
    let summary = RunSummary::new(&manifest, fleet.finish(), wall_s, plan.threads);
    let summary = RunSummary { precision: reached, ..summary };
    if let Some(mut directory) = directory {
        if ended.is_continue() {
            directory.end_here();
        }
        directory.finish(&summary)?;
    }
    print(arguments, &summary, &loaded.origin, resumed)?;
    if ended.is_break() {
        return Err(interrupted(&summary, &manifest, arguments.out.as_deref()));
    }
    if !arguments.quiet && !arguments.json {
        output::note(&more(arguments.out.as_deref(), &manifest));
    }
    Ok(())
}

fn print(
    arguments: &RunArguments,
    summary: &RunSummary,
    origin: &Origin,
    resumed: u64,
) -> Result<(), Failure> {
    if arguments.json {
        return output::answer(&summary.to_json());
    }
    let circumstances = Circumstances { origin, width: output::width(), resumed };
    output::answer(&run_text::run_text(summary, &circumstances))
}

/// Prints what a complete run adds up to.
fn complete_already(arguments: &RunArguments) -> Result<(), Failure> {
    let Some(path) = arguments.out.as_deref() else { return Ok(()) };
    let stored = run_directory::read(path)?;
    print(arguments, &stored.summary, &Origin::BuiltIn(stored.manifest.study.clone()), 0)?;
    if !arguments.quiet {
        output::note(&format!("`{}` was complete already: nothing was run.", path.display()));
    }
    Ok(())
}

fn interrupted(summary: &RunSummary, manifest: &Manifest, out: Option<&Path>) -> Failure {
    let done = summary.summary.cycles;
    let finished = format!("{done} of {} cycles finished", manifest.cycles);
    match out {
        Some(path) => Failure::Interrupted {
            finished: format!("{finished} and kept in `{}`", path.display()),
            help: format!("ocmc --out {} --resume runs the rest", path.display()),
        },
        None => Failure::Interrupted {
            finished,
            help: format!(
                "--first-cycle {} --cycles {} runs the rest",
                manifest.first_cycle + done,
                manifest.cycles - done
            ),
        },
    }
}

/// How to see more.
fn more(out: Option<&Path>, manifest: &Manifest) -> String {
    let kept = match out {
        Some(path) => written(path, manifest),
        None => "More: --out DIR keeps a record of each cycle.".to_owned(),
    };
    format!(
        "{kept} `ocmc trace --cycle-id ID`, with the same study and seed, shows one cycle step by step."
    )
}

/// What was written, and where.
pub(crate) fn written(path: &Path, manifest: &Manifest) -> String {
    let (manifest_file, summary) = (run_directory::MANIFEST, run_directory::SUMMARY);
    format!("Written to `{}`: {}, {manifest_file}, {summary}.", path.display(), manifest.records)
}
