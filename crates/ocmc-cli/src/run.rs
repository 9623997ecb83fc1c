//! `ocmc`: runs a study and prints what its fleet adds up to.

use crate::arguments::RunArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::run_text::{self, Circumstances};
use crate::{interrupt, output, request};
use ocmc_core::fleet::run;
use ocmc_core::fleet::run::RunPlan;
use ocmc_core::fleet::summary::SummaryBuilder;
use ocmc_core::simulation::record::Record;
use ocmc_core::study::Study;
use ocmc_io::run_directory::{self, Manifest, RunDirectory};
use ocmc_io::run_summary::RunSummary;
use ocmc_io::study::{self, LoadedStudy};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

/// Takes the next records of a run.
pub(crate) type Sink<'a> = &'a mut dyn FnMut(Vec<Record>) -> ControlFlow<Stop>;

/// Why a run ended early.
pub(crate) enum Stop {
    Interrupted,
    Failed(Failure),
}

/// Runs the study, writes its records where asked to, and prints the answer.
pub(crate) fn run(arguments: &RunArguments) -> Result<(), Failure> {
    let load = || Ok(study::load(&arguments.study, &arguments.set)?);
    run_study(arguments, load, |study, plan, sink| run::run(study, plan, sink))
}

/// As [`run`], of the study that `load` gives, with what `drive` makes of it.
pub(crate) fn run_study(
    arguments: &RunArguments,
    load: impl FnOnce() -> Result<LoadedStudy, Failure>,
    drive: impl FnOnce(&Study, &RunPlan, Sink) -> ControlFlow<Stop>,
) -> Result<(), Failure> {
    let plan = request::plan(arguments)?;
    let loaded = load()?;
    let manifest = Manifest::new(&loaded.model, &plan);
    let mut directory = match &arguments.out {
        Some(path) => Some(RunDirectory::create(path, arguments.format.into(), manifest.clone())?),
        None => None,
    };

    interrupt::listen();
    let clock = Instant::now();
    let progress = Progress::new(plan.cycles, arguments.quiet);
    let mut fleet = SummaryBuilder::default();
    let ended = drive(&loaded.study, &plan, &mut |records| {
        fleet.add(&records);
        if let Some(directory) = &mut directory
            && let Err(error) = directory.add(&records)
        {
            return ControlFlow::Break(Stop::Failed(error.into()));
        }
        progress.reach(fleet.cycles());
        if interrupt::asked() && fleet.cycles() < plan.cycles {
            return ControlFlow::Break(Stop::Interrupted);
        }
        ControlFlow::Continue(())
    });
    progress.finish();
    if let ControlFlow::Break(Stop::Failed(failure)) = ended {
        return Err(failure);
    }

    let wall_s = clock.elapsed().as_secs_f64();
    let summary = RunSummary::new(&manifest, fleet.finish(), wall_s, plan.threads);
    if let Some(directory) = directory {
        directory.finish(&summary)?;
    }
    if arguments.json {
        output::answer(&summary.to_json())?;
    } else {
        let circumstances = Circumstances { origin: &loaded.origin, width: output::width() };
        output::answer(&run_text::run_text(&summary, &circumstances))?;
    }
    if ended.is_break() {
        return Err(interrupted(&summary, &plan, arguments.out.as_deref()));
    }
    if !arguments.quiet && !arguments.json {
        output::note(&more(arguments));
    }
    Ok(())
}

fn interrupted(summary: &RunSummary, plan: &RunPlan, out: Option<&Path>) -> Failure {
    let done = summary.summary.cycles;
    let kept = match out {
        Some(path) => format!(" and kept in `{}`", path.display()),
        None => String::new(),
    };
    Failure::Interrupted {
        finished: format!("{done} of {} cycles finished{kept}", plan.cycles),
        help: format!(
            "--first-cycle {} --cycles {} runs the rest",
            plan.first_cycle + done,
            plan.cycles - done
        ),
    }
}

/// How to see more.
fn more(arguments: &RunArguments) -> String {
    let kept = match &arguments.out {
        Some(path) => format!("Written to `{}`: {}.", path.display(), files(arguments)),
        None => "More: --out DIR keeps a record of each cycle.".to_owned(),
    };
    format!(
        "{kept} `ocmc trace --cycle-id ID`, with the same study and seed, shows one cycle step by step."
    )
}

fn files(arguments: &RunArguments) -> String {
    let format: ocmc_io::records::RecordFormat = arguments.format.into();
    format!("{}, {}, {}", format.file_name(), run_directory::MANIFEST, run_directory::SUMMARY)
}
