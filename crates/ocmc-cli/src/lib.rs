//! The `ocmc` command as a library: arguments, calls, printing. The native program and the wheel's
//! script are both one call of [`run_from`].

mod arguments;
mod compare;
mod completions;
mod curves;
mod cycle;
mod drive;
mod failure;
mod fit;
mod identify;
mod interrupt;
mod man;
mod merge;
mod output;
mod progress;
mod report;
mod request;
mod run;
mod sensitivity;
mod study;
mod study_report;
mod table_file;
mod terminal;
mod trace;
mod verify;

use arguments::{Arguments, Command};
use clap::error::ErrorKind;
use clap::{CommandFactory, FromArgMatches};
use failure::Failure;
use std::ffi::OsString;

/// Done.
pub const DONE: i32 = 0;
/// The input or the run failed, or the run was interrupted.
pub const FAILED: i32 = 1;
/// Wrong usage.
pub const WRONG_USAGE: i32 = 2;

/// Runs the command with these arguments, the program's name first, and returns its exit status.
pub fn run_from(arguments: impl IntoIterator<Item = OsString>) -> i32 {
    let (arguments, path) = match parsed(arguments) {
        Ok(parsed) => parsed,
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
        Some(Command::Verify(arguments)) => verify::verify(arguments),
        Some(Command::Completions { shell }) => completions::completions(*shell),
        Some(Command::Man { out }) => man::man(out),
    };
    match done {
        Ok(()) => DONE,
        Err(Failure::Usage(message)) => usage(&wrong_usage(&path, &message)),
        Err(failure) => {
            output::note(&failure.report());
            FAILED
        }
    }
}

/// What was typed, and the names of the sub-commands that it was typed to.
fn parsed(
    arguments: impl IntoIterator<Item = OsString>,
) -> Result<(Arguments, Vec<String>), clap::Error> {
    let mut matches = Arguments::command().try_get_matches_from(arguments)?;
    let mut path = Vec::new();
    let mut here = &matches;
    while let Some((name, below)) = here.subcommand() {
        path.push(name.to_owned());
        here = below;
    }
    let arguments = Arguments::from_arg_matches_mut(&mut matches);
    Ok((arguments.map_err(|error| error.format(&mut Arguments::command()))?, path))
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
