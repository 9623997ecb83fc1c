//! `ocmc`, `ocmc drive`, `ocmc merge`: runs a study or what is given, and prints what its fleet
//! adds up to.

use crate::arguments::{
    AnswerOptions, FileOptions, TruckOptions, check_range, one_of, whole_number,
};
use crate::failure::Failure;
use crate::mixed_fleet::{FleetRun, check_options, run_fleet};
use crate::output::{self, warn};
use crate::progress::{busy, kept};
use crate::report::own_file;
use clap::Args;
use ocmc_api::shell_word::{quoted, resume_command, shell_word};
use ocmc_api::study::{self, Files, Given, Opened};
use ocmc_api::{
    Answer, Asked, CpuLevel, DRAWS, Draw, Error, FOLLOWS, FORMATS, Follow, GivenDrive, KEEPS, Keep,
    LAST_CYCLE_ID, MANIFEST, MOST_THREADS, Manifest, MergeRequest, Precision, RUN_FORMATS,
    RecordFormat, RequeueRequest, RouteModel, RunAnswer, RunEnd, RunFormat, RunRequest, SUMMARY,
    WORKBOOK, check_cycles, mappings, precision, stored_workbook,
};
use std::path::{Path, PathBuf};

/// Description of the study where none was asked for.
const DEFAULT_STUDY: &str = "`field-truck` has trucks of the 40 t class with 28 t in the mean, on \
    urban, rural and motorway roads. Others: --study long-haul, `ocmc study list`.";

/// Most cycles that can be driven at a time by a thread: their records wait in memory.
const LARGEST_CHUNK: u64 = 65_536;

/// Options of a run.
#[derive(Clone, Debug, Args)]
pub(crate) struct RunArguments {
    /// Name of a built-in study, a study file, or `-` for standard input; a built-in study wins
    /// over a file of its name [default: field-truck]
    #[arg(long, value_name = "NAME|FILE")]
    study: Option<PathBuf>,
    /// Replaces one value of the study, as in driver.curve_speed.exponent=0.5; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    files: FileOptions,
    /// Number of cycles [default: 1000]
    #[arg(
        long, value_name = "N", allow_negative_numbers = true,
        value_parser = whole_number(1..=LAST_CYCLE_ID)
    )]
    cycles: Option<u64>,
    #[command(flatten)]
    fleet: TruckOptions,
    /// Ends the run when half of the 95 % interval of the mean consumption is that small, relative
    /// to the mean, as in 0.2%; of a quantile as in p95:1%. --cycles is then the largest number,
    /// and 1000000 unless it is given
    #[arg(long, value_name = "PRECISION", value_parser = precision)]
    precision: Option<Precision>,
    /// Id of the first cycle: a run can be shared out over machines [default: 0]
    #[arg(
        long, value_name = "ID", allow_negative_numbers = true,
        value_parser = whole_number(0..=LAST_CYCLE_ID - 1)
    )]
    first_cycle: Option<u64>,
    /// Master seed: with the study and a cycle's id it fixes everything that happens in the cycle
    /// [default: 1]
    #[arg(
        long, value_name = "N", allow_negative_numbers = true,
        value_parser = whole_number(0..=u64::MAX)
    )]
    seed: Option<u64>,
    /// Threads [default: one for each CPU]
    #[arg(
        long, value_name = "N", allow_negative_numbers = true,
        value_parser = whole_number(1..=MOST_THREADS)
    )]
    threads: Option<usize>,
    /// Directory for the records, the manifest and the summary of the run; without it nothing is
    /// written
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Finishes the run in --out, or begins it where there is none: one command for the first start
    /// and every restart. What is not typed is that of the run; what is typed has to be
    #[arg(long, requires = "out")]
    resume: bool,
    /// Format of the records [default: parquet]
    #[arg(long, value_name = "FORMAT", requires = "out", value_parser = one_of(RUN_FORMATS))]
    format: Option<RunFormat>,
    /// No progress, no hints and no account of what was read
    #[arg(long)]
    quiet: bool,
    /// The answer as JSON
    #[arg(long)]
    json: bool,
    /// Instructions to use: the records do not depend on it
    #[arg(
        long, hide = true,
        value_parser = one_of(CpuLevel::ALL.map(|level| (level.name(), "", level)))
    )]
    cpu_level: Option<CpuLevel>,
    /// Cycles that a thread drives at a time: the records do not depend on it
    #[arg(
        long, hide = true, allow_negative_numbers = true,
        value_parser = whole_number(1..=LARGEST_CHUNK)
    )]
    chunk: Option<u64>,
}

/// A run on given routes.
#[derive(Clone, Debug, Args)]
pub(crate) struct DriveArguments {
    /// Files with operating cycles: VECTO's `.vdri`, tracks or JSON of `ocmc cycle`, or a route as
    /// `.csv`. Of several, each cycle drives one, by the weights of the study's `mission.routes`
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Says which column of a table is what, as in speed_limit_kmh=vmax; may be repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    map: Vec<String>,
    /// Parts that are taken from the file instead of being drawn from the study; may be repeated or
    /// joined by commas
    #[arg(long, value_name = "WHAT", value_delimiter = ',', value_parser = one_of(KEEPS))]
    keep: Vec<Keep>,
    /// Parts that are drawn from the study's laws of each road type, anew in each cycle, where the
    /// file lacks them; may be repeated or joined by commas
    #[arg(long, value_name = "WHAT", value_delimiter = ',', value_parser = one_of(DRAWS))]
    draw: Vec<Draw>,
    /// The stop plan that is driven on the route: a table of places with dwells, loads and times
    #[arg(long, value_name = "FILE")]
    stop_plan: Option<PathBuf>,
    /// Follows the speed of a drive cycle, a `.csv` with time, speed and grade; or, exactly, the
    /// speed planned on a route
    #[arg(long, value_name = "HOW", value_parser = one_of(FOLLOWS))]
    follow_speed: Option<Follow>,
    #[command(flatten)]
    run: RunArguments,
}

/// Parts to merge.
#[derive(Clone, Debug, Args)]
pub(crate) struct MergeArguments {
    /// Run directories of the parts, in any order
    #[arg(value_name = "PART", required = true)]
    parts: Vec<PathBuf>,
    /// Directory for the whole run
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Format of the records [default: that of the first part]
    #[arg(long, value_name = "FORMAT", value_parser = one_of(FORMATS))]
    format: Option<RecordFormat>,
    #[command(flatten)]
    answer: AnswerOptions,
}

/// Runs the study, writes its records where asked to, and prints the answer.
pub(crate) fn run(arguments: &RunArguments) -> Result<(), Failure> {
    run_given(arguments, &GivenDrive::nothing())
}

/// As [`run`], with what is given to be driven.
fn run_given(arguments: &RunArguments, given: &GivenDrive) -> Result<(), Failure> {
    let RunArguments { seed, first_cycle, cycles, fleet, threads, chunk, .. } = *arguments;
    let RunArguments { quiet, json, .. } = *arguments;
    let has_workbook = arguments.format == Some(RunFormat::Workbook);
    let format = arguments.format.and_then(RunFormat::records);
    let level = level(arguments.cpu_level)?;
    let mut sets = arguments.set.clone();
    sets.extend(fleet.setting());
    let precision = arguments.precision.clone();
    let files = arguments.files.files();
    let opened = arguments
        .study
        .as_deref()
        .map(|study| study::open_all(&Given::Named(study), &files, &sets).map_err(Error::from));
    let loaded = match opened.transpose()? {
        None => None,
        Some(Opened::Study(study)) => Some(study),
        Some(Opened::Fleet(groups)) => {
            let given = [
                ("--cycles", cycles.is_some()),
                ("--trucks", fleet.trucks.is_some()),
                ("--first-cycle", first_cycle.is_some()),
                ("--precision", precision.is_some()),
                ("--chunk", chunk.is_some()),
                ("drive", !given.is_nothing()),
            ];
            check_options(&groups, &given)?;
            let (out, resume) = (arguments.out.as_deref(), arguments.resume);
            let (seed, format) = (seed.unwrap_or(1), arguments.format);
            let fleet_run = FleetRun { seed, threads, level, out, format, resume, quiet, json };
            return run_fleet(&groups, &fleet_run);
        }
    };
    // what was set is in the study that was read
    let sets = if loaded.is_some() { &[] } else { &sets[..] };
    let asked = Asked {
        loaded: loaded.as_deref(),
        files,
        sets,
        seed,
        first_cycle,
        cycles,
        trucks: fleet.trucks,
        precision,
        format,
        ..Asked::default()
    };
    let answer = match (&arguments.out, arguments.resume) {
        (Some(directory), true) => {
            check_range(first_cycle.unwrap_or(0), cycles.unwrap_or(1000))?;
            check_workbook(has_workbook, cycles.unwrap_or(0))?;
            let request = RequeueRequest { directory, asked, given, threads, chunk, level };
            kept(quiet, |watch| ocmc_api::requeue(&request, watch))?
        }
        (out, _) => {
            let study = &asked.load()?;
            study.warnings().iter().for_each(|warning| warn(warning));
            let plan = asked.plan(study, threads, chunk, level);
            check_range(plan.first_cycle, plan.cycles)?;
            check_workbook(has_workbook, plan.cycles)?;
            let out = out.clone().map(|path| (path, format.unwrap_or_default()));
            let request = RunRequest { study, given, plan, precision: asked.precision, out };
            kept(quiet, |watch| ocmc_api::run(&request, &mut |_| (), watch))?
        }
    };
    answer.warnings().iter().for_each(|warning| warn(warning));
    output::print_run(&answer, json)?;
    let out = arguments.out.as_deref();
    if let Some(directory) = out.filter(|_| has_workbook && answer.ended != RunEnd::Interrupted) {
        own_file(directory, WORKBOOK, "`ocmc report --xlsx FILE` where the workbook goes")?;
        busy(quiet, "writing the workbook", || stored_workbook(directory, None))?;
    }
    match (answer.ended, out) {
        (RunEnd::Interrupted, out) => return Err(interrupted(&answer, out)),
        _ if quiet => {}
        (RunEnd::WasComplete, Some(path)) => {
            output::note(&format!("`{}` was complete already: nothing was run.", path.display()));
        }
        _ if json => {}
        (_, out) => {
            output::note(&more(out, &answer, given));
            if arguments.study.is_none() && given.is_nothing() && !arguments.resume {
                output::note(DEFAULT_STUDY);
            }
        }
    }
    Ok(())
}

/// Checks before the first cycle that a run fits into its workbook, where it has one.
fn check_workbook(has_workbook: bool, cycles: u64) -> Result<(), Failure> {
    if !has_workbook {
        return Ok(());
    }
    check_cycles(cycles).map_err(|error| Failure::Usage(format!("--format xlsx: {error}")))
}

/// The instructions to use.
fn level(asked: Option<CpuLevel>) -> Result<CpuLevel, Failure> {
    let level = asked.unwrap_or_else(CpuLevel::best);
    if level.is_available() {
        return Ok(level);
    }
    let available = CpuLevel::ALL.into_iter().filter(|level| level.is_available());
    let available = available.map(CpuLevel::name).collect::<Vec<_>>().join(", ");
    let name = level.name();
    Err(Failure::Usage(format!("this CPU has no {name}; allowed is one of: {available}")))
}

/// Reads what is given, runs the study on it, and prints the answer.
pub(crate) fn drive(arguments: &DriveArguments) -> Result<(), Failure> {
    let DriveArguments { files, map, keep, draw, stop_plan, follow_speed, run } = arguments;
    if run.files.files() == Files::Refused {
        let text = "`drive` reads files, which --no-files does not allow";
        return Err(Failure::Usage(text.to_owned()));
    }
    let (keep, draw, plan) = (keep.clone(), draw.clone(), stop_plan.clone());
    let given = GivenDrive::read(files.clone(), mappings(map)?, keep, draw, plan, *follow_speed)
        .map_err(Error::from)?;
    given.warnings().iter().for_each(|warning| warn(warning));
    for setting in &run.set {
        let key = setting.split('=').next().unwrap_or_default().trim();
        if let Some(why) = given.without_effect(key) {
            warn(&format!("--set {key} has no effect here: {why} [setting-without-effect]"));
        }
    }
    if let Some(read) = given.cycle_account() {
        if !run.quiet {
            read.told().iter().for_each(|told| output::note(told));
        }
        read.warnings().iter().for_each(|warning| warn(warning));
    }
    for account in given.accounts() {
        if !run.quiet {
            account.told.iter().for_each(|told| output::note(told));
        }
        account.warnings.iter().for_each(|warning| warn(warning));
    }
    run_given(run, &given)
}

/// Merges the parts of one run, from many machines, and prints what their fleet adds up to.
pub(crate) fn merge(arguments: &MergeArguments) -> Result<(), Failure> {
    let MergeArguments { parts, out, format, answer: AnswerOptions { quiet, json } } = arguments;
    let request = MergeRequest { parts, out, format: *format };
    let answer = busy(*quiet, "merging", || ocmc_api::merge(&request))?;
    output::print_run(&answer, *json)?;
    if !quiet && !json {
        output::note(&written(out, &answer.manifest));
    }
    Ok(())
}

fn interrupted(answer: &RunAnswer, out: Option<&Path>) -> Failure {
    let (done, manifest) = (answer.summary.summary.cycles, &answer.manifest);
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

/// How to see more of a run; on its routes, where it was not the study that named them.
fn more(out: Option<&Path>, answer: &RunAnswer, given: &GivenDrive) -> String {
    let manifest = &answer.manifest;
    let kept = match out {
        Some(path) => {
            let (written, word) = (written(path, manifest), shell_word(path));
            format!("{written} `ocmc report {word}` makes a page of it.")
        }
        None => "More: --out DIR keeps a record of each cycle.".to_owned(),
    };
    // `trace` knows no followed speed
    if manifest.followed.is_some() {
        return kept;
    }
    let named = given.has_routes() || answer.resumed > 0;
    let routes = if named { manifest.routes() } else { Vec::new() };
    let files = routes.iter().any(|route| Path::new(&route.file).exists());
    let setting =
        if files { format!(" --set {}", quoted(&routes_setting(&routes))) } else { String::new() };
    format!(
        "{kept} `ocmc trace --cycle-id ID{setting}`, with the same study and seed, shows one \
         cycle step by step."
    )
}

/// The setting that gives a study these routes.
fn routes_setting(routes: &[RouteModel]) -> String {
    let route = |route: &RouteModel| {
        let file = std::path::absolute(&route.file).unwrap_or_else(|_| route.file.clone().into());
        let keep: Vec<&str> = route.keep.iter().map(|keep| keep.name()).collect();
        let keep = if keep.is_empty() { String::new() } else { format!(", keep = {keep:?}") };
        let draw: Vec<&str> = route.draw.iter().map(|draw| draw.name()).collect();
        let draw = if draw.is_empty() { String::new() } else { format!(", draw = {draw:?}") };
        let plan = route.stop_plan.as_ref().map(|plan| {
            let plan = std::path::absolute(plan).unwrap_or_else(|_| plan.clone().into());
            format!(", stop_plan = {:?}", plan.display().to_string())
        });
        let plan = plan.unwrap_or_default();
        let columns = route.columns.iter().map(|(name, column)| format!("{name} = {column:?}"));
        let columns: Vec<String> = columns.collect();
        let columns = if columns.is_empty() {
            String::new()
        } else {
            format!(", columns = {{{}}}", columns.join(", "))
        };
        let file = file.display().to_string();
        format!("{{file = {file:?}, weight = {}{keep}{draw}{plan}{columns}}}", route.weight)
    };
    let all: Vec<String> = routes.iter().map(route).collect();
    format!("mission.routes=[{}]", all.join(", "))
}

/// Report of the files written, and their place.
fn written(path: &Path, manifest: &Manifest) -> String {
    let records = &manifest.records;
    let beside = ["trucks", "chargings", "loads"].map(|name| records.replace("records", name));
    let there = |file: &String| path.join(file).is_file();
    let beside = beside.into_iter().chain([WORKBOOK.to_owned()]).filter(there);
    let files: Vec<String> = [records.clone()].into_iter().chain(beside).collect();
    let files = files.join(", ");
    format!("Written to `{}`: {files}, {MANIFEST}, {SUMMARY}.", path.display())
}
