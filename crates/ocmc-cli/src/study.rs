//! `ocmc study`: lists, shows, writes and checks study files.

use crate::arguments::{BirdsEyeArguments, StudyArguments, StudyCommand};
use crate::failure::Failure;
use crate::{output, request};
use ocmc_api::shell_word::shell_word;
use ocmc_api::{BirdsEyeRequest, RunPlan, go_on, study};
use std::fmt::Write as _;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write as _};
use std::path::Path;

/// Does what was asked for.
pub(crate) fn study(command: &StudyCommand) -> Result<(), Failure> {
    match command {
        StudyCommand::List => list(),
        StudyCommand::Show { resolved: false, study } => show(study),
        StudyCommand::Show { resolved: true, study } => show_resolved(study),
        StudyCommand::Init { file } => init(file),
        StudyCommand::Check { study } => check(study),
        StudyCommand::BirdsEye(arguments) => birds_eye(arguments),
        StudyCommand::Schema => output::answer(&format!("{:#}\n", study::schema())),
    }
}

fn list() -> Result<(), Failure> {
    let width = study::list().iter().map(|study| study.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for study in study::list() {
        let _ = writeln!(text, "{:width$}  {}", study.name, study.description());
    }
    output::answer(&text)
}

/// As it is written: what is set is no part of that.
fn show(arguments: &StudyArguments) -> Result<(), Failure> {
    if !arguments.set.is_empty() {
        return Err(request::usage(
            "--set changes values, which a study as it is written does not show; add --resolved",
        ));
    }
    output::answer(&study::text(&arguments.study)?)
}

fn show_resolved(arguments: &StudyArguments) -> Result<(), Failure> {
    let loaded = study::load(&arguments.study, &arguments.set)?;
    output::answer(&study::resolved_toml(&loaded.model))
}

fn init(path: &Path) -> Result<(), Failure> {
    write_new(path, &study::init_text())?;
    let (shown, word) = (path.display(), shell_word(path));
    output::note(&format!(
        "Written: `{shown}`. Change it, then: ocmc study check {word}; ocmc --study {word}"
    ));
    Ok(())
}

/// Writes a study file. Never replaces one: it may hold hours of work.
pub(crate) fn write_new(path: &Path, text: &str) -> Result<(), Failure> {
    let file = OpenOptions::new().write(true).create_new(true).open(path);
    let written = file.and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|source| match source.kind() {
        ErrorKind::AlreadyExists => Failure::Exists { path: path.to_owned() },
        _ => Failure::File { path: path.to_owned(), source },
    })
}

fn check(arguments: &StudyArguments) -> Result<(), Failure> {
    let loaded = study::load(&arguments.study, &arguments.set)?;
    output::answer(&format!(
        "{}: a valid study, `{}`, hash {}\n",
        loaded.origin,
        loaded.model.study.name,
        study::study_hash(&loaded.model)
    ))
}

fn birds_eye(arguments: &BirdsEyeArguments) -> Result<(), Failure> {
    let loaded = study::load(&arguments.study.study, &arguments.study.set)?;
    let BirdsEyeArguments { seed, first_cycle, cycles, json, .. } = *arguments;
    request::check_range(first_cycle, cycles)?;
    let plan = RunPlan::new(seed, first_cycle, cycles, None, None);
    let answer = ocmc_api::birds_eye(&BirdsEyeRequest { study: &loaded, plan }, &mut go_on)?;
    output::print(&answer, json)
}
