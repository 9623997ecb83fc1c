//! The `ocmc` command as a library: arguments, calls, printing. The native program and the wheel's
//! script are both one call of [`run_from`].

mod analysis;
mod arguments;
mod ask;
mod benchmark;
mod bound;
mod calibrate;
mod cost;
mod cycle;
mod failure;
mod failure_report;
mod fit;
mod interrupt;
mod learn;
mod log;
mod mixed_fleet;
mod output;
mod page;
mod progress;
mod range;
mod report;
mod road;
mod run;
mod shell;
mod simulator_study;
mod size;
mod study;
mod sweep;
#[cfg(test)]
mod tests;
mod training;
mod vecto;
mod verify;

use analysis::{CompareArguments, DoubtArguments, SensitivityArguments};
use arguments::QuietOption;
use ask::AskArguments;
use benchmark::BenchmarkArguments;
use bound::BoundArguments;
use calibrate::CalibrateCommand;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::Shell;
use cost::CostArguments;
use cycle::CycleArguments;
use failure::Failure;
use fit::FitCommand;
use learn::LearnArguments;
use log::{CurvesArguments, IdentifyArguments};
use ocmc_api::Error;
use ocmc_api::shell_word::shell_word;
use ocmc_api::study::list;
use page::PageArguments;
use range::BatteryRangeArguments;
use report::ReportArguments;
use road::{RoadArguments, ValidateArguments};
use run::{DriveArguments, MergeArguments, RunArguments};
use simulator_study::SimulatorStudyArguments;
use size::SizeArguments;
use std::ffi::OsString;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use study::StudyCommand;
use sweep::SweepArguments;
use training::TrainingArguments;
use vecto::VectoArguments;
use verify::VerifyArguments;

/// Done.
pub const DONE: i32 = 0;
/// The input or the run failed.
pub const FAILED: i32 = 1;
/// Wrong usage.
pub const WRONG_USAGE: i32 = 2;

/// Energy use of fleets of trucks, by simulation of many random operating cycles.
///
/// Without a sub-command, runs a study: draws roads, weathers, traffics, missions, drivers and
/// trucks, and drives each cycle in closed loop. Prints how consumption, speed and duration are
/// distributed over the fleet.
#[derive(Clone, Debug, Parser)]
#[command(name = "ocmc", version, args_conflicts_with_subcommands = true, after_help = EXAMPLES)]
struct Arguments {
    #[command(flatten)]
    run: RunArguments,
    #[command(subcommand)]
    command: Option<Command>,
}

const EXAMPLES: &str = "\
Examples:
  ocmc --cycles 10000                                  the built-in study `field-truck`
  ocmc --study my-fleet.toml --seed 7 --out runs/a     a study file, each cycle's record in runs/a
  ocmc --out runs/a --resume                           finish what an interrupted run began
  ocmc --set driver.curve_speed.exponent=0.5 --json    one value changed, the answer as JSON

Exit status: 0 done, 1 the input or the run failed, 2 wrong usage, 128 + N stopped by
signal N.";

/// The sub-commands by what a person wants of them, in the order of the help.
const GROUPS: [(&str, &[&str]); 4] = [
    (
        "Ask",
        &[
            "drive",
            "compare",
            "sweep",
            "sensitivity",
            "doubt",
            "cost",
            "range",
            "size",
            "bound",
            "training",
            "trace",
            "vecto",
            "ask",
            "page",
        ],
    ),
    ("Describe", &["study", "cycle", "road"]),
    (
        "Measure",
        &[
            "learn",
            "benchmark",
            "calibrate",
            "fit",
            "curves",
            "identify",
            "validate",
            "simulator-study",
        ],
    ),
    ("Keep", &["report", "merge", "verify", "completions", "man"]),
];

/// The command, with its sub-commands in groups.
fn command() -> clap::Command {
    let command = Arguments::command();
    let about = |name: &str| {
        let about = command.find_subcommand(name).and_then(clap::Command::get_about);
        about.map(ToString::to_string).unwrap_or_default()
    };
    let mut groups = String::new();
    for (group, names) in GROUPS {
        let _ = writeln!(groups, "{group}:");
        for name in names {
            let text = textwrap_at(&about(name), 80 - INDENT);
            let _ = writeln!(groups, "  {name:<width$}{text}", width = INDENT - 2);
        }
        groups.push('\n');
    }
    let template = format!(
        "{{before-help}}{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{groups}Options:\n\
         {{options}}{{after-help}}"
    );
    command.help_template(template)
}

/// Columns in front of what a sub-command does.
const INDENT: usize = 19;

/// A text in lines of that width, each but the first behind the indent.
fn textwrap_at(text: &str, width: usize) -> String {
    let (mut lines, mut line) = (Vec::new(), String::new());
    for word in text.split_whitespace() {
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > width {
            lines.push(std::mem::take(&mut line));
        }
        line += if line.is_empty() { "" } else { " " };
        line += word;
    }
    lines.push(line);
    lines.join(&format!("\n{:INDENT$}", ""))
}

/// The sub-commands.
#[derive(Clone, Debug, Subcommand)]
enum Command {
    /// Lists, shows, writes and checks study files
    #[command(subcommand)]
    Study(StudyCommand),
    /// Writes one operating cycle: road, events, weather and traffic, as CSV tracks or JSON
    Cycle(CycleArguments),
    /// Drives given operating cycles with drivers, weathers, payloads and trucks of a study
    Drive(DriveArguments),
    /// Writes the simulated time series of one cycle: speed, pedals, gear, fuel, forces
    Trace(CycleArguments),
    /// Shares out the variance between cycles: which factors the spread comes from
    Sensitivity(SensitivityArguments),
    /// Compares studies under common random numbers: the paired difference and its interval
    Compare(CompareArguments),
    /// Drives a study at many points, values of its keys, on the same cycles: the mean of each and
    /// the paired difference to the first
    Sweep(SweepArguments),
    /// Answers a question that is JSON, in lines of JSON: for pages and other programs
    Ask(AskArguments),
    /// Opens a page in the browser to ask with: drop routes and tables of trips, choose trucks, see
    /// what the fleet uses
    Page(PageArguments),
    /// Finds what the answer owes to numbers that nobody measured: each at both ends of its range
    Doubt(DoubtArguments),
    /// Costs a study: per trip, km, tkm, truck-year and whole life, item by item; or two of them
    /// against each other: which is cheaper, from where on, and what decides
    Cost(CostArguments),
    /// Finds what it is worth a year to train the drivers who stand worst in a fleet's records, and
    /// how sure it is who they are
    Training(TrainingArguments),
    /// Finds how far battery trucks come: which share arrives, by length of the trip, season and
    /// payload
    Range(BatteryRangeArguments),
    /// Finds how large a battery has to be for a share of the trips to arrive
    Size(SizeArguments),
    /// Compares with VECTO, from its own files: on VECTO's speed, by VECTO's driver and by ours
    Vecto(VectoArguments),
    /// Finds the least energy for the same road, truck and trip time, and how far drivers are from
    /// it
    Bound(BoundArguments),
    /// Merges the parts of one run, from many machines, into the run that one machine would have
    /// written
    Merge(MergeArguments),
    /// Writes the report of a run: one HTML file that opens offline
    Report(ReportArguments),
    /// Checks every file of a run directory against its checksum
    Verify(VerifyArguments),
    /// Estimates the numbers of a study from measurements
    #[command(subcommand)]
    Fit(FitCommand),
    /// Finds the laws with which a study gives measured tables back
    #[command(subcommand)]
    Calibrate(CalibrateCommand),
    /// Learns a study from the files of a fleet: fits what can be fitted, calibrates the rest to
    /// its trips, and checks it on trips that were held back
    Learn(LearnArguments),
    /// Sets measured trips beside what a study expects of them: trucks and drivers that differ
    /// beyond chance, and what a date or a group changed
    Benchmark(BenchmarkArguments),
    /// Finds the curves that were driven, from logs of speed and yaw rate
    Curves(CurvesArguments),
    /// Identifies the pedal gains of drivers, from logs of speed, pedals and slope
    Identify(IdentifyArguments),
    /// Makes an operating cycle of the road that a log was driven on
    Road(RoadArguments),
    /// Lays measured drives over simulated ones on the same road: bands, scores, picture
    Validate(ValidateArguments),
    /// Repeats the paper's driving-simulator study: its tables and pictures, beside the paper's
    SimulatorStudy(SimulatorStudyArguments),
    /// Prints a script that completes the command line of a shell
    Completions {
        /// The shell
        shell: Shell,
        #[command(flatten)]
        quiet: QuietOption,
    },
    /// Writes the manual pages
    Man {
        /// Directory to write them to
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
        #[command(flatten)]
        quiet: QuietOption,
    },
}

/// Runs the command with these arguments, the program's name first, and returns its exit status.
pub fn run_from(arguments: impl IntoIterator<Item = OsString>) -> i32 {
    let typed: Vec<OsString> = arguments.into_iter().collect();
    let (arguments, path) = match parsed(typed.iter().cloned()) {
        Ok(parsed) => parsed,
        Err(answer) => return usage(&with_studies(answer, &typed)),
    };
    let done = match &arguments.command {
        None => run::run(&arguments.run),
        Some(Command::Study(command)) => study::study(command),
        Some(Command::Cycle(arguments)) => cycle::cycle(arguments),
        Some(Command::Drive(arguments)) => run::drive(arguments),
        Some(Command::Trace(arguments)) => cycle::trace(arguments),
        Some(Command::Fit(command)) => fit::fit(command),
        Some(Command::Calibrate(command)) => calibrate::calibrate(command),
        Some(Command::Learn(arguments)) => learn::learn(arguments),
        Some(Command::Benchmark(arguments)) => benchmark::benchmark(arguments),
        Some(Command::Curves(arguments)) => log::curves(arguments),
        Some(Command::Identify(arguments)) => log::identify(arguments),
        Some(Command::Road(arguments)) => road::road(arguments),
        Some(Command::Validate(arguments)) => road::validate(arguments),
        Some(Command::Sensitivity(arguments)) => analysis::sensitivity(arguments),
        Some(Command::Compare(arguments)) => analysis::compare(arguments),
        Some(Command::Sweep(arguments)) => sweep::sweep(arguments),
        Some(Command::Ask(arguments)) => ask::ask_question(arguments),
        Some(Command::Page(arguments)) => page::page(arguments),
        Some(Command::Doubt(arguments)) => analysis::doubt(arguments),
        Some(Command::Cost(arguments)) => cost::cost(arguments),
        Some(Command::SimulatorStudy(arguments)) => simulator_study::simulator_study(arguments),
        Some(Command::Training(arguments)) => training::training(arguments),
        Some(Command::Range(arguments)) => range::range(arguments),
        Some(Command::Size(arguments)) => size::size(arguments),
        Some(Command::Vecto(arguments)) => vecto::vecto(arguments),
        Some(Command::Bound(arguments)) => bound::bound(arguments),
        Some(Command::Merge(arguments)) => run::merge(arguments),
        Some(Command::Report(arguments)) => report::report(arguments),
        Some(Command::Verify(arguments)) => verify::verify(arguments),
        Some(Command::Completions { shell, .. }) => {
            output::answer(&shell::completions(*shell, Arguments::command()))
        }
        Some(Command::Man { out, .. }) => shell::man(out, Arguments::command()),
    };
    match done {
        Ok(()) => DONE,
        Err(Failure::Usage(message)) => usage(&wrong_usage(&path, &message)),
        Err(failure) => {
            output::drawn(&failure_report::report(&failure));
            match failure {
                Failure::Interrupted { .. } | Failure::Question(Error::Interrupted(_)) => {
                    interrupt::exit_status()
                }
                _ => FAILED,
            }
        }
    }
}

/// Arguments that were typed, and the names of the sub-commands that they were typed to.
fn parsed(
    arguments: impl IntoIterator<Item = OsString>,
) -> Result<(Arguments, Vec<String>), clap::Error> {
    let mut matches = command().try_get_matches_from(arguments)?;
    let mut path = Vec::new();
    let mut here = &matches;
    while let Some((name, below)) = here.subcommand() {
        path.push(name.to_owned());
        here = below;
    }
    let arguments = Arguments::from_arg_matches_mut(&mut matches);
    Ok((arguments.map_err(|error| error.format(&mut Arguments::command()))?, path))
}

/// How a value of a study is set.
const SETTING: &str = "a value of the study is set without blanks around the sign: --set KEY=5";

/// Wrong usage, with the option of studies where the name of one was typed as a sub-command.
fn with_studies(mut error: clap::Error, all: &[OsString]) -> clap::Error {
    let typed = match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(typed)) => typed.clone(),
        _ => return error,
    };
    let hint = match typed.as_str() {
        "run" | "simulate" | "start" => {
            Some("to run a study, type: ocmc --study NAME --cycles 1000")
        }
        "=" => Some(SETTING),
        _ if typed.contains('=') => Some(SETTING),
        _ if all.iter().any(|word| word == "=") => Some(SETTING),
        _ => None,
    };
    if let Some(hint) = hint {
        error.remove(ContextKind::SuggestedSubcommand);
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![hint.into()]));
    }
    let is_file = Path::new(&typed).extension().is_some_and(|extension| extension == "toml");
    if is_file || list().iter().any(|study| study.name == typed) {
        let hint =
            format!("to run this study, type: ocmc --study {}", shell_word(Path::new(&typed)));
        error.remove(ContextKind::SuggestedSubcommand);
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![hint.into()]));
    }
    error
}

/// Wrong usage that shows after parsing, with the usage of the sub-command at the end of the path.
fn wrong_usage(path: &[String], message: &str) -> clap::Error {
    let mut command = Arguments::command();
    command.build();
    let mut here = &mut command;
    for name in path {
        here = here.find_subcommand_mut(name).expect("a sub-command that was typed");
    }
    here.error(ErrorKind::ValueValidation, message)
}

/// Prints help, version or what is wrong with the arguments.
fn usage(answer: &clap::Error) -> i32 {
    match answer.print() {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => FAILED,
        _ if answer.use_stderr() => WRONG_USAGE,
        _ => DONE,
    }
}
