//! `ocmc`: runs a study and prints what its fleet adds up to.

use crate::arguments::RunArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::run_text::{self, Circumstances};
use crate::{interrupt, output, request};
use ocmc_core::fleet::dependence::Dependence;
use ocmc_core::fleet::precision::InterimChecks;
use ocmc_core::fleet::run::RunPlan;
use ocmc_core::fleet::summary::SummaryBuilder;
use ocmc_core::operating_cycle::route::RouteModel;
use ocmc_core::record::Record;
use ocmc_io::given_drive::GivenDrive;
use ocmc_io::records::RecordFormat;
use ocmc_io::run_directory::{self, Manifest, RunDirectory};
use ocmc_io::run_summary::RunSummary;
use ocmc_io::shell_word::{quoted, resume_command, shell_word};
use ocmc_io::study::{self, LoadedStudy, Origin};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

/// Why a run ended early.
pub(crate) enum Stop {
    PreciseEnough,
    Interrupted,
    Failed(Failure),
}

/// A run that is to be driven: all of it, or what is left of it.
struct Job {
    loaded: LoadedStudy,
    given: GivenDrive,
    manifest: Manifest,
    plan: RunPlan,
    directory: Option<RunDirectory>,
    /// Holds what was driven before.
    fleet: SummaryBuilder,
}

/// Runs the study, writes its records where asked to, and prints the answer.
pub(crate) fn run(arguments: &RunArguments) -> Result<(), Failure> {
    run_study(arguments, GivenDrive::nothing())
}

/// As [`run`], with what is given to be driven.
pub(crate) fn run_study(arguments: &RunArguments, given: GivenDrive) -> Result<(), Failure> {
    let job = match (&arguments.out, arguments.resume) {
        (Some(path), true) => resume(arguments, path, &given).map_err(Failure::of_resume)?,
        _ => Some(begin(arguments, given)?),
    };
    let Some(job) = job else {
        return complete_already(arguments);
    };
    drive_job(arguments, job)
}

fn begin(arguments: &RunArguments, given: GivenDrive) -> Result<Job, Failure> {
    let plan = request::plan(arguments)?;
    let loaded = given.study(study::load(&arguments.study, &arguments.set)?)?;
    let precision = arguments.precision.clone();
    let records = RecordFormat::from(arguments.format).file_name().to_owned();
    let manifest = Manifest::new(&loaded.model, &plan, &given);
    let manifest = Manifest { precision, records, ..manifest };
    let fleet = SummaryBuilder::new(Dependence::of(&loaded.model));
    let directory = match &arguments.out {
        Some(path) => Some(RunDirectory::create(path, arguments.format.into(), manifest.clone())?),
        None => None,
    };
    Ok(Job { loaded, given, manifest, plan, directory, fleet })
}

/// What is left of the run in a directory; none where it is complete.
fn resume(
    arguments: &RunArguments,
    path: &Path,
    typed: &GivenDrive,
) -> Result<Option<Job>, Failure> {
    check_typed(typed, path)?;
    let Some(unfinished) = run_directory::unfinished(path)? else {
        return Ok(None);
    };
    let mut fleet = SummaryBuilder::new(Dependence::of(&unfinished.study.model));
    let directory = RunDirectory::resume(&unfinished, |records| fleet.add(records))?;
    let manifest = unfinished.manifest;
    let done = fleet.cycles();
    let (first, rest) = (manifest.first_cycle + done, manifest.cycles - done);
    let plan = request::plan_of(arguments, manifest.seed, first, rest)?;
    // the study is that of the run, not the file that its manifest is
    let mut loaded = unfinished.study;
    loaded.origin = Origin::BuiltIn(manifest.study.clone());
    let given = unfinished.given;
    Ok(Some(Job { loaded, given, manifest, plan, directory: Some(directory), fleet }))
}

/// Checks that files which somebody types behind `ocmc drive --resume` are those of the run; nothing has to be typed.
fn check_typed(typed: &GivenDrive, path: &Path) -> Result<(), Failure> {
    if typed.is_nothing() || typed.is_that_of(&run_directory::read_manifest(path)?)? {
        return Ok(());
    }
    let (path, resume) = (path.display(), resume_command(path));
    Err(request::usage(&format!(
        "`{path}` holds a run of other files, or of another --keep or --follow-speed; `{resume}` finishes it as it was begun"
    )))
}

fn drive_job(arguments: &RunArguments, job: Job) -> Result<(), Failure> {
    let Job { loaded, given, manifest, plan, mut directory, mut fleet } = job;
    let resumed = fleet.cycles();
    interrupt::listen();
    let clock = Instant::now();
    let progress = Progress::new(manifest.cycles, resumed, arguments.quiet);
    let precision = manifest.precision.as_ref();
    let mut checks = InterimChecks::new(precision, resumed);
    let mut take = |records: &[Record], cycles: u64| {
        if let Some(directory) = &mut directory
            && let Err(error) = directory.add(records)
        {
            return ControlFlow::Break(Stop::Failed(Failure::Unwritten(error)));
        }
        progress.reach(cycles);
        if interrupt::asked() && cycles < manifest.cycles {
            return ControlFlow::Break(Stop::Interrupted);
        }
        ControlFlow::Continue(())
    };
    let ended = given.run(&loaded.study, &plan, |records: Vec<Record>| {
        let taken = checks.take(&mut fleet, &records, &mut take);
        taken.map_break(|stop| stop.unwrap_or(Stop::PreciseEnough))
    });
    progress.finish();
    let interrupted = match ended {
        ControlFlow::Break(Stop::Failed(failure)) => return Err(failure),
        ControlFlow::Break(Stop::Interrupted) => true,
        ControlFlow::Break(Stop::PreciseEnough) | ControlFlow::Continue(()) => false,
    };

    let wall_s = clock.elapsed().as_secs_f64();
    let reached = precision.map(|precision| precision.check(&fleet));
    let summary = RunSummary::new(&manifest, fleet.finish(), wall_s, plan.threads);
    let summary = RunSummary { precision: reached, ..summary };
    if let Some(mut directory) = directory {
        if !interrupted {
            directory.end_here();
        }
        directory.finish(&summary).map_err(Failure::Unwritten)?;
    }
    print(arguments, &summary, &loaded.origin, resumed)?;
    if interrupted {
        return Err(stopped(&summary, &manifest, arguments.out.as_deref()));
    }
    if !arguments.quiet && !arguments.json {
        let shown = given.has_routes() || resumed > 0;
        let routes = if shown { &loaded.model.mission.routes[..] } else { &[] };
        output::note(&more(arguments.out.as_deref(), &manifest, routes));
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

fn stopped(summary: &RunSummary, manifest: &Manifest, out: Option<&Path>) -> Failure {
    let done = summary.summary.cycles;
    let finished = format!("{done} of {} cycles finished", manifest.cycles);
    match out {
        Some(path) => Failure::Interrupted {
            finished: format!("{finished} and kept in `{}`", path.display()),
            help: format!("{} runs the rest", resume_command(path)),
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

/// How to see more of a run; on `routes`, where it was not the study that named them.
fn more(out: Option<&Path>, manifest: &Manifest, routes: &[RouteModel]) -> String {
    let kept = match out {
        Some(path) => written(path, manifest),
        None => "More: --out DIR keeps a record of each cycle.".to_owned(),
    };
    let kept = match out {
        Some(path) => format!("{kept} `ocmc report {}` makes a page of it.", shell_word(path)),
        None => kept,
    };
    // `trace` knows no followed speed
    if manifest.followed.is_some() {
        return kept;
    }
    let files = routes.iter().any(|route| Path::new(&route.file).exists());
    let setting =
        if files { format!(" --set {}", quoted(&routes_setting(routes))) } else { String::new() };
    format!(
        "{kept} `ocmc trace --cycle-id ID{setting}`, with the same study and seed, shows one cycle step by step."
    )
}

/// The setting that gives a study these routes.
fn routes_setting(routes: &[RouteModel]) -> String {
    let route = |route: &RouteModel| {
        let file = std::path::absolute(&route.file).unwrap_or_else(|_| route.file.clone().into());
        let keep: Vec<&str> = route.keep.iter().map(|keep| keep.name()).collect();
        let keep = if keep.is_empty() { String::new() } else { format!(", keep = {keep:?}") };
        let columns = route.columns.iter().map(|(name, column)| format!("{name} = {column:?}"));
        let columns: Vec<String> = columns.collect();
        let columns = if columns.is_empty() {
            String::new()
        } else {
            format!(", columns = {{{}}}", columns.join(", "))
        };
        let file = file.display().to_string();
        format!("{{file = {file:?}, weight = {}{keep}{columns}}}", route.weight)
    };
    let all: Vec<String> = routes.iter().map(route).collect();
    format!("mission.routes=[{}]", all.join(", "))
}

/// What was written, and where.
pub(crate) fn written(path: &Path, manifest: &Manifest) -> String {
    let (manifest_file, summary) = (run_directory::MANIFEST, run_directory::SUMMARY);
    format!("Written to `{}`: {}, {manifest_file}, {summary}.", path.display(), manifest.records)
}
