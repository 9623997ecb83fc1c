//! What the user typed: plain data, without side effects. Resolved in [`crate::request`].

mod analysis;
mod drive;
mod fit;
mod log;
mod run;
mod study;
mod value;

pub(crate) use analysis::{AnalysisArguments, CompareArguments, SensitivityArguments};
pub(crate) use drive::{DriveArguments, Follow};
pub(crate) use fit::{
    CurveSpeedArguments, FitCommand, FittedArguments, OperatingCycleArguments,
    SpeedChangeArguments, TrafficArguments, WeatherArguments,
};
pub(crate) use log::{
    ControllerName, CurvesArguments, DetectorName, IdentifyArguments, SpeedTermName,
};
pub(crate) use run::{MergeArguments, ReportArguments, RunArguments, VerifyArguments};
pub(crate) use study::{BirdsEyeArguments, CycleArguments, StudyArguments, StudyCommand};

use clap::{Parser, Subcommand};
use clap_complete::Shell;
use std::path::PathBuf;

/// Energy use of fleets of trucks, by simulation of many random operating cycles.
///
/// Without a sub-command, runs a study: draws roads, weathers, traffics, missions, drivers and
/// trucks, drives each cycle in closed loop, and prints how consumption, speed and duration are
/// distributed over the fleet.
#[derive(Clone, Debug, Parser)]
#[command(name = "ocmc", version, args_conflicts_with_subcommands = true, after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) run: RunArguments,
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

const EXAMPLES: &str = "\
Examples:
  ocmc --cycles 10000                                  the built-in study `field-truck`
  ocmc --study my-fleet.toml --seed 7 --out runs/a     a study file, each cycle's record in runs/a
  ocmc --out runs/a --resume                           finish what an interrupted run began
  ocmc --set driver.curve_speed.exponent=0.5 --json    one value changed, the answer as JSON

Exit status: 0 done, 1 the input or the run failed or was interrupted, 2 wrong usage.";

/// The sub-commands.
#[derive(Clone, Debug, Subcommand)]
pub(crate) enum Command {
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
    /// Finds the curves that were driven, from logs of speed and yaw rate
    Curves(CurvesArguments),
    /// Identifies the pedal gains of drivers, from logs of speed, pedals and slope
    Identify(IdentifyArguments),
    /// Prints a script that completes the command line of a shell
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Writes the manual pages
    Man {
        /// Directory to write them to
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definitions_are_consistent() {
        Arguments::command().debug_assert();
    }
}
