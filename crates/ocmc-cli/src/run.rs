//! `ocmc`: runs a study and prints what its fleet adds up to.

use crate::arguments::RunArguments;
use crate::failure::Failure;
use crate::progress::watched;
use crate::{output, request};
use ocmc_api::shell_word::{quoted, resume_command, shell_word};
use ocmc_api::{
    GivenDrive, MANIFEST, Manifest, ResumeRequest, RouteModel, RunAnswer, RunEnd, RunPlan,
    RunRequest, SUMMARY, study,
};
use std::path::Path;

/// Runs the study, writes its records where asked to, and prints the answer.
pub(crate) fn run(arguments: &RunArguments) -> Result<(), Failure> {
    run_given(arguments, &GivenDrive::nothing())
}

/// As [`run`], with what is given to be driven.
pub(crate) fn run_given(arguments: &RunArguments, given: &GivenDrive) -> Result<(), Failure> {
    let level = request::level(arguments)?;
    let RunArguments { threads, chunk, .. } = *arguments;
    let answer = match (&arguments.out, arguments.resume) {
        (Some(directory), true) => {
            let request = ResumeRequest { directory, given, threads, chunk, level };
            watched(arguments.quiet, |watch| ocmc_api::resume(&request, watch))?
        }
        (out, _) => {
            let plan = RunPlan { level, ..request::plan(arguments)? };
            let study = &study::load(&arguments.study, &arguments.set)?;
            let out = out.clone().map(|path| (path, arguments.format.into()));
            let precision = arguments.precision.clone();
            let request = RunRequest { study, given, plan, precision, out };
            watched(arguments.quiet, |watch| ocmc_api::run(&request, &mut |_| (), watch))?
        }
    };
    output::print_run(&answer, arguments.json)?;
    let out = arguments.out.as_deref();
    match (answer.ended, out) {
        (RunEnd::Interrupted, out) => return Err(interrupted(&answer, out)),
        _ if arguments.quiet => {}
        (RunEnd::WasComplete, Some(path)) => {
            output::note(&format!("`{}` was complete already: nothing was run.", path.display()));
        }
        _ if arguments.json => {}
        (_, out) => output::note(&more(out, &answer, given)),
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
    let named = given.has_routes() || answer.resumed > 0;
    let routes = if named { manifest.routes() } else { Vec::new() };
    let files = routes.iter().any(|route| Path::new(&route.file).exists());
    let setting =
        if files { format!(" --set {}", quoted(&routes_setting(&routes))) } else { String::new() };
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
    format!("Written to `{}`: {}, {MANIFEST}, {SUMMARY}.", path.display(), manifest.records)
}
