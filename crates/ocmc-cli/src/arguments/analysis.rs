//! What the user typed about sensitivities and comparisons.

use super::value::{at_least_one, crossed, cycle_id, threads, whole_number};
use clap::Args;
use clap::builder::PossibleValuesParser;
use ocmc_api::columns;
use ocmc_api::factors;

/// Options of an analysis that drives many cycles.
#[derive(Clone, Debug, Args)]
pub(crate) struct AnalysisArguments {
    /// Number of cycles
    #[arg(long, value_name = "N", default_value = "1000", allow_negative_numbers = true, value_parser = at_least_one)]
    pub(crate) cycles: u64,
    /// Id of the first cycle
    #[arg(long, value_name = "ID", default_value = "0", allow_negative_numbers = true, value_parser = cycle_id)]
    pub(crate) first_cycle: u64,
    /// Master seed
    #[arg(long, value_name = "N", default_value = "1", allow_negative_numbers = true, value_parser = whole_number)]
    pub(crate) seed: u64,
    /// Quantity that is asked about [default: the consumption; of several studies the first that
    /// all have]
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(columns()))]
    pub(crate) column: Option<String>,
    /// Threads [default: one for each CPU]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = threads)]
    pub(crate) threads: Option<usize>,
    /// No progress
    #[arg(long)]
    pub(crate) quiet: bool,
    /// The answer as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// A sensitivity analysis.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("cycles", |cycles| cycles.help("Number of rows of the design: each drives two cycles, and one more for each factor")))]
pub(crate) struct SensitivityArguments {
    /// Name of a built-in study, or a study file
    #[arg(long, value_name = "NAME|FILE", default_value = "field-truck")]
    pub(crate) study: String,
    /// Replaces one value of the study, as in driver.curve_speed.exponent=0.5; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Only these factors; may be repeated or joined by commas [default: all]
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = PossibleValuesParser::new(factors()))]
    pub(crate) factor: Vec<String>,
    /// A second opinion: also drives so many cycles with each of 30 drivers, and splits the
    /// variance two ways
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = crossed)]
    pub(crate) crossed: Option<u64>,
    #[command(flatten)]
    pub(crate) analysis: AnalysisArguments,
}

/// Studies to compare.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("cycles", |cycles| cycles.help("Number of cycles in each study")))]
pub(crate) struct CompareArguments {
    /// Built-in studies or study files, the baseline first; a single one is compared with itself
    /// under --set
    #[arg(value_name = "NAME|FILE", required = true)]
    pub(crate) studies: Vec<String>,
    /// Replaces one value of every study; of a single one, in its second version; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    #[command(flatten)]
    pub(crate) analysis: AnalysisArguments,
}
