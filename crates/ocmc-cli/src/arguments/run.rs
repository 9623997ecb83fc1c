//! What the user typed about runs and their directories.

use super::value::{at_least_one, chunk, cycle_id, precision, threads, whole_number};
use clap::builder::{ArgPredicate, PossibleValuesParser};
use clap::{Args, ValueEnum};
use ocmc_api::CpuLevel;
use ocmc_api::Precision;
use ocmc_api::RecordFormat;
use std::path::PathBuf;

/// Options of a run.
#[derive(Clone, Debug, Args)]
pub(crate) struct RunArguments {
    /// Name of a built-in study, or a study file
    #[arg(long, value_name = "NAME|FILE", default_value = "field-truck")]
    pub(crate) study: String,
    /// Replaces one value of the study, as in driver.curve_speed.exponent=0.5; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Number of cycles
    #[arg(long, value_name = "N", default_value = "1000", default_value_if("precision", ArgPredicate::IsPresent, "1000000"), allow_negative_numbers = true, value_parser = at_least_one)]
    pub(crate) cycles: u64,
    /// Ends the run when half of the 95 % interval of the mean consumption is that small, relative
    /// to the mean, as in 0.2%; of a quantile as in p95:1%. --cycles is then the largest number
    /// [default: 1000000]
    #[arg(long, value_name = "PRECISION", value_parser = precision)]
    pub(crate) precision: Option<Precision>,
    /// Id of the first cycle: a run can be shared out over machines
    #[arg(long, value_name = "ID", default_value = "0", allow_negative_numbers = true, value_parser = cycle_id)]
    pub(crate) first_cycle: u64,
    /// Master seed: with the study and a cycle's id it fixes everything that happens in the cycle
    #[arg(long, value_name = "N", default_value = "1", allow_negative_numbers = true, value_parser = whole_number)]
    pub(crate) seed: u64,
    /// Threads [default: one for each CPU]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = threads)]
    pub(crate) threads: Option<usize>,
    /// Directory for the records, the manifest and the summary of the run; without it nothing is
    /// written
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Finishes the interrupted run in --out: study, seed, range and format are those of the run
    #[arg(long, requires = "out", conflicts_with_all = ["study", "set", "cycles", "precision", "first_cycle", "seed", "format"])]
    pub(crate) resume: bool,
    /// Format of the records
    #[arg(long, value_name = "FORMAT", default_value = "parquet", requires = "out")]
    pub(crate) format: Format,
    /// No progress and no hints
    #[arg(long)]
    pub(crate) quiet: bool,
    /// The answer as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Instructions to use: the records do not depend on it
    #[arg(long, hide = true, value_parser = PossibleValuesParser::new(CpuLevel::ALL.map(CpuLevel::name)))]
    pub(crate) cpu_level: Option<String>,
    /// Cycles that a thread drives at a time: the records do not depend on it
    #[arg(long, hide = true, allow_negative_numbers = true, value_parser = chunk)]
    pub(crate) chunk: Option<u64>,
}

/// The run to report on.
#[derive(Clone, Debug, Args)]
pub(crate) struct ReportArguments {
    /// Directory of a run, as --out wrote it
    #[arg(value_name = "RUN_DIR")]
    pub(crate) directory: PathBuf,
    /// File to write; an existing one is replaced [default: report.html in the run directory]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// The run to check.
#[derive(Clone, Debug, Args)]
pub(crate) struct VerifyArguments {
    /// Directory of a run, as --out wrote it
    #[arg(value_name = "RUN_DIR")]
    pub(crate) directory: PathBuf,
    /// The answer as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Parts to merge.
#[derive(Clone, Debug, Args)]
pub(crate) struct MergeArguments {
    /// Run directories of the parts, in any order
    #[arg(value_name = "PART", required = true)]
    pub(crate) parts: Vec<PathBuf>,
    /// Directory for the whole run
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Format of the records [default: that of the first part]
    #[arg(long, value_name = "FORMAT")]
    pub(crate) format: Option<Format>,
    /// No hints
    #[arg(long)]
    pub(crate) quiet: bool,
    /// The answer as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Formats of records, as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Apache Parquet
    Parquet,
    /// Comma-separated values
    Csv,
}

impl From<Format> for RecordFormat {
    fn from(format: Format) -> Self {
        match format {
            Format::Parquet => Self::Parquet,
            Format::Csv => Self::Csv,
        }
    }
}
