//! `ocmc study`: lists, shows, writes and checks study files.

use crate::arguments::{AnswerOptions, FileOptions, QuietOption, RangeArguments};
use crate::failure::Failure;
use crate::output;
use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand};
use ocmc_api::shell_word::shell_word;
use ocmc_api::study::{self, BuiltIn, LoadedStudy};
use ocmc_api::{Answer, BirdsEyeRequest, study_difference};
use serde::Serialize;
use serde_json::Value;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Commands on studies.
#[derive(Clone, Debug, Subcommand)]
pub(crate) enum StudyCommand {
    /// Lists the built-in studies
    List(AnswerOptions),
    /// Lists the built-in vehicles, which a study takes by `vehicle.base`
    Vehicles(AnswerOptions),
    /// Prints a study or vehicle, a built-in one or a file, as it is written, with its sources
    Show {
        /// Prints every value of the study that a run uses instead, those inherited or given by
        /// --set included, with its meaning and its allowed range
        #[arg(long)]
        resolved: bool,
        #[command(flatten)]
        study: StudyArguments,
        #[command(flatten)]
        quiet: QuietOption,
    },
    /// Writes a new study file, with every key, its unit, its source and its range
    Init {
        /// File to write
        file: PathBuf,
        /// Built-in study that the new one inherits from: its keys stand in the file as comments
        /// [default: every key of field-truck is written]
        #[arg(
            long, value_name = "NAME",
            value_parser = PossibleValuesParser::new(study::list().iter().map(|study| study.name))
        )]
        base: Option<String>,
        #[command(flatten)]
        quiet: QuietOption,
    },
    /// Checks a study file
    Check {
        #[command(flatten)]
        study: StudyArguments,
        #[command(flatten)]
        answer: AnswerOptions,
    },
    /// Lists the keys in which two studies differ, what differs most first
    Diff {
        /// Study A: name of a built-in one, a study file, or `-` for standard input
        #[arg(value_name = "A")]
        a: PathBuf,
        /// Study B
        #[arg(value_name = "B")]
        b: PathBuf,
        #[command(flatten)]
        files: FileOptions,
        #[command(flatten)]
        answer: AnswerOptions,
    },
    /// Looks at the roads that a study draws from above: hilliness, transport cycle, how dense
    /// stops and curves are
    BirdsEye(BirdsEyeArguments),
    /// Prints the JSON schema of study files
    Schema(QuietOption),
}

/// A study as a positional argument.
#[derive(Clone, Debug, Args)]
pub(crate) struct StudyArguments {
    /// Name of a built-in study, a study file, or `-` for standard input
    #[arg(value_name = "NAME|FILE")]
    study: PathBuf,
    /// Replaces one value of the study, as in driver.curve_speed.exponent=0.5; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    files: FileOptions,
}

impl StudyArguments {
    fn load(&self) -> Result<LoadedStudy, Failure> {
        self.files.load(&self.study, &self.set)
    }
}

/// Roads of a study.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("cycles", |cycles| {
    cycles.default_value("100").help("Number of operating cycles that are drawn")
}))]
pub(crate) struct BirdsEyeArguments {
    #[command(flatten)]
    study: StudyArguments,
    #[command(flatten)]
    range: RangeArguments,
    /// Draws no road: the classes of infinitely many, by the laws of the study
    #[arg(long, conflicts_with_all = ["cycles", "seed", "first_cycle"])]
    laws: bool,
    #[command(flatten)]
    answer: AnswerOptions,
}

/// Does what was asked for.
pub(crate) fn study(command: &StudyCommand) -> Result<(), Failure> {
    match command {
        StudyCommand::List(answer) => answer.show(&BuiltIns::of(study::list())),
        StudyCommand::Vehicles(answer) => answer.show(&BuiltIns::of(study::vehicles())),
        StudyCommand::Show { resolved: true, study, .. } => {
            let resolved = study::resolved_toml(&study.load()?.model);
            output::answer(&study::commented(&resolved))
        }
        // as it is written: what is set is no part of that
        StudyCommand::Show { study, .. } if !study.set.is_empty() => Err(Failure::Usage(
            "--set changes values, which a study as it is written does not show; add --resolved"
                .to_owned(),
        )),
        StudyCommand::Show { study, .. } => {
            output::answer(&study::text(&study.study, &study.files.files())?)
        }
        StudyCommand::Init { file, base, quiet } => init(file, base.as_deref(), quiet.quiet),
        StudyCommand::Check { study, answer } => {
            let all = study.files.load_all(&study.study, &study.set)?;
            answer.show(&Checked(all.iter().map(CheckedStudy::of).collect()))
        }
        StudyCommand::Diff { a, b, files, answer } => {
            let load = |path: &PathBuf| files.load(path, &[]);
            let (study_a, study_b) = (load(a)?, load(b)?);
            let [a, b] = [a, b].map(|path| path.display().to_string());
            answer.show(&study_difference((&a, &study_a), (&b, &study_b)))
        }
        StudyCommand::BirdsEye(BirdsEyeArguments { study, range, laws, answer }) => {
            let study = &study.load()?;
            let plan = if *laws { None } else { Some(range.plan(None)?) };
            let request = BirdsEyeRequest { study, plan };
            answer.print(|watch| ocmc_api::birds_eye(&request, watch))
        }
        StudyCommand::Schema(_) => output::answer(&format!("{:#}\n", study::schema())),
    }
}

/// Built-in studies or vehicles.
#[derive(Serialize)]
struct BuiltIns(Vec<Described>);

/// One of them.
#[derive(Serialize)]
struct Described {
    name: &'static str,
    description: String,
}

impl BuiltIns {
    fn of(all: &[BuiltIn]) -> Self {
        let described =
            |one: &BuiltIn| Described { name: one.name, description: one.description() };
        Self(all.iter().map(described).collect())
    }
}

impl Answer for BuiltIns {
    fn text(&self) -> String {
        let width = self.0.iter().map(|one| one.name.len()).max().unwrap_or(0);
        let line = |one: &Described| format!("{:width$}  {}\n", one.name, one.description);
        self.0.iter().map(line).collect()
    }
}

/// Studies of a file that are valid: one, or those of its groups.
#[derive(Serialize)]
struct Checked(Vec<CheckedStudy>);

/// One of them.
#[derive(Serialize)]
struct CheckedStudy {
    origin: String,
    name: String,
    study_hash: String,
}

impl CheckedStudy {
    fn of(LoadedStudy { origin, model, .. }: &LoadedStudy) -> Self {
        let (name, study_hash) = (model.study.name.clone(), study::study_hash(model));
        Self { origin: origin.to_string(), name, study_hash }
    }
}

impl Answer for Checked {
    fn text(&self) -> String {
        let line = |CheckedStudy { origin, name, study_hash }: &CheckedStudy| {
            format!("{origin}: a valid study, `{name}`, hash {study_hash}\n")
        };
        self.0.iter().map(line).collect()
    }
}

fn init(path: &Path, base: Option<&str>, quiet: bool) -> Result<(), Failure> {
    let text = base.map_or_else(|| Ok(study::init_text()), study::init_text_of)?;
    write_new(path, &text)?;
    let (shown, word) = (path.display(), shell_word(path));
    if !quiet {
        output::note(&format!(
            "Written: `{shown}`. Change it, then: ocmc study check {word}; ocmc --study {word}"
        ));
    }
    Ok(())
}

/// Writes a study with fitted values laid over its base, named after its file, and says how to run
/// it. `by`: the command that has fitted the values, and from what; `standard` is the name where
/// the file has none.
pub(crate) fn write_fitted(
    path: &Path,
    base: &str,
    standard: &str,
    by: (&str, &str),
    fitted: &Value,
    quiet: bool,
) -> Result<(), Failure> {
    let name = path.file_stem().map_or(standard.into(), |stem| stem.to_string_lossy());
    let (text, _) = study::fitted_study(base, &name, by, fitted)?;
    written_study(path, &text, quiet)
}

/// Writes the text of a study, and says how to run it.
pub(crate) fn written_study(path: &Path, text: &str, quiet: bool) -> Result<(), Failure> {
    write_new(path, text)?;
    let (shown, word) = (path.display(), shell_word(path));
    if !quiet {
        output::note(&format!("Written: `{shown}`. Run it: ocmc --study {word}"));
    }
    Ok(())
}

/// Writes a study file. Never replaces one: it may hold hours of work.
fn write_new(path: &Path, text: &str) -> Result<(), Failure> {
    let file = OpenOptions::new().write(true).create_new(true).open(path);
    let written = file.and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|source| match source.kind() {
        ErrorKind::AlreadyExists => Failure::Exists { path: path.to_owned() },
        _ => Failure::File { path: path.to_owned(), source },
    })
}
