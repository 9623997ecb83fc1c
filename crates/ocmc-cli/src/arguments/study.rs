//! What the user typed about studies and single cycles.

use super::value::{at_least_one, cycle_id, whole_number};
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// What can be done with studies.
#[derive(Clone, Debug, Subcommand)]
pub(crate) enum StudyCommand {
    /// Lists the built-in studies
    List,
    /// Prints a study or vehicle, a built-in one or a file, as it is written, with its sources
    Show {
        /// Prints every value of the study that a run uses instead, those inherited or given by
        /// --set included
        #[arg(long)]
        resolved: bool,
        #[command(flatten)]
        study: StudyArguments,
    },
    /// Writes a new study file, with every key, its unit, its source and its range
    Init {
        /// File to write
        file: PathBuf,
    },
    /// Checks a study file
    Check {
        #[command(flatten)]
        study: StudyArguments,
    },
    /// Looks at the roads that a study draws from above: hilliness, transport cycle, how dense
    /// stops and curves are
    BirdsEye(BirdsEyeArguments),
    /// Prints the JSON schema of study files
    Schema,
}

/// A study as a positional argument.
#[derive(Clone, Debug, Args)]
pub(crate) struct StudyArguments {
    /// Name of a built-in study, or a study file
    #[arg(value_name = "NAME|FILE")]
    pub(crate) study: String,
    /// Replaces one value of the study, as in driver.curve_speed.exponent=0.5; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

/// Roads of a study.
#[derive(Clone, Debug, Args)]
pub(crate) struct BirdsEyeArguments {
    #[command(flatten)]
    pub(crate) study: StudyArguments,
    /// Number of operating cycles that are drawn
    #[arg(long, value_name = "N", default_value = "100", allow_negative_numbers = true, value_parser = at_least_one)]
    pub(crate) cycles: u64,
    /// Id of the first cycle
    #[arg(long, value_name = "ID", default_value = "0", allow_negative_numbers = true, value_parser = cycle_id)]
    pub(crate) first_cycle: u64,
    /// Master seed
    #[arg(long, value_name = "N", default_value = "1", allow_negative_numbers = true, value_parser = whole_number)]
    pub(crate) seed: u64,
    /// The answer as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// One cycle of a run.
#[derive(Clone, Debug, Args)]
pub(crate) struct CycleArguments {
    /// Name of a built-in study, or a study file
    #[arg(long, value_name = "NAME|FILE", default_value = "field-truck")]
    pub(crate) study: String,
    /// Replaces one value of the study, as in driver.curve_speed.exponent=0.5; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Id of the cycle, as in the records
    #[arg(long, value_name = "ID", allow_negative_numbers = true, value_parser = cycle_id)]
    pub(crate) cycle_id: u64,
    /// Master seed of the run
    #[arg(long, value_name = "N", default_value = "1", allow_negative_numbers = true, value_parser = whole_number)]
    pub(crate) seed: u64,
    /// File to write, `.csv` or `.json`; an existing one is replaced [default: CSV to standard
    /// output]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}
