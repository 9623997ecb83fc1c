//! The `ocmc` command as a library: arguments, calls, printing. The native program and the wheel's script are both
//! one call of [`run_from`].

mod analysis;
mod answer;
mod arguments;
mod birds_eye;
mod compare;
mod completions;
mod curves;
mod cycle;
mod drive;
mod failure;
mod fit;
mod histogram_chart;
mod identify;
mod identify_text;
mod interrupt;
mod log;
mod log_text;
mod man;
mod merge;
mod output;
mod progress;
mod report;
mod request;
mod run;
mod run_text;
mod sensitivity;
mod study;
mod study_report;
mod summary_table;
mod table_file;
mod trace;

pub use answer::Answer;
pub use birds_eye::birds_eye_answer;
pub use compare::comparison_answer;
pub use fit::{
    curve_speed_answer, operating_cycle_answer, speed_change_answer, traffic_answer, weather_answer,
};
pub use identify::identification_answer;
pub use sensitivity::sensitivity_answer;

use arguments::{Arguments, Command};
use clap::Parser;
use failure::Failure;
use ocmc_io::number_text;
use ocmc_io::run_summary::RunSummary;
use ocmc_io::study::Origin;
use std::ffi::OsString;

/// Done.
pub const DONE: i32 = 0;
/// The input or the run failed, or the run was interrupted.
pub const FAILED: i32 = 1;
/// Wrong usage.
pub const WRONG_USAGE: i32 = 2;

/// Runs the command with these arguments, the program's name first, and returns its exit status.
pub fn run_from(arguments: impl IntoIterator<Item = OsString>) -> i32 {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(answer) => return usage(&answer),
    };
    let done = match &arguments.command {
        None => run::run(&arguments.run),
        Some(Command::Study(command)) => study::study(command),
        Some(Command::Cycle(arguments)) => cycle::cycle(arguments),
        Some(Command::Drive(arguments)) => drive::drive(arguments),
        Some(Command::Trace(arguments)) => trace::trace(arguments),
        Some(Command::Fit(command)) => fit::fit(command),
        Some(Command::Curves(arguments)) => curves::curves(arguments),
        Some(Command::Identify(arguments)) => identify::identify(arguments),
        Some(Command::Sensitivity(arguments)) => sensitivity::sensitivity(arguments),
        Some(Command::Compare(arguments)) => compare::compare(arguments),
        Some(Command::Merge(arguments)) => merge::merge(arguments),
        Some(Command::Report(arguments)) => report::report(arguments),
        Some(Command::Completions { shell }) => completions::completions(*shell),
        Some(Command::Man { out }) => man::man(out),
    };
    match done {
        Ok(()) => DONE,
        Err(Failure::Usage(error)) => usage(&error),
        Err(failure) => {
            output::note(&failure.report());
            FAILED
        }
    }
}

/// What a run adds up to, as the command prints it, `width` columns wide.
pub fn run_text(run: &RunSummary, origin: &Origin, width: usize) -> String {
    run_text::run_text(run, &run_text::Circumstances { origin, width, resumed: 0 })
}

/// Prints help, version or what is wrong with the arguments.
fn usage(answer: &clap::Error) -> i32 {
    match answer.print() {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => FAILED,
        _ if answer.use_stderr() => WRONG_USAGE,
        _ => DONE,
    }
}
