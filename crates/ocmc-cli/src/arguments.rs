//! What the user typed: plain data, without side effects. Resolved in [`crate::request`].

use crate::log_arguments::{CurvesArguments, IdentifyArguments};
use clap::builder::{ArgPredicate, PossibleValuesParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use ocmc_core::fit::curve_speed::Coding;
use ocmc_core::fleet::precision::Precision;
use ocmc_core::fleet::quantity::QUANTITIES;
use ocmc_core::fleet::run::MOST_THREADS;
use ocmc_core::fleet::sensitivity::factor_groups;
use ocmc_core::operating_cycle::given::Keep;
use ocmc_core::random::LAST_CYCLE_ID;
use ocmc_core::simulation::cpu::CpuLevel;
use ocmc_io::records::RecordFormat;
use std::path::PathBuf;

/// Most cycles that can be driven at a time by a thread.
const LARGEST_CHUNK: u64 = 65_536;

/// Energy use of fleets of trucks, by simulation of many random operating cycles.
///
/// Without a sub-command, runs a study: draws roads, weathers, traffics, missions, drivers and trucks, drives each
/// cycle in closed loop, and prints how consumption, speed and duration are distributed over the fleet.
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
    /// Merges the parts of one run, from many machines, into the run that one machine would have written
    Merge(MergeArguments),
    /// Writes the report of a run: one HTML file that opens offline
    Report(ReportArguments),
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

/// What can be done with studies.
#[derive(Clone, Debug, Subcommand)]
pub(crate) enum StudyCommand {
    /// Lists the built-in studies
    List,
    /// Prints a built-in study as it is written, with its sources
    Show {
        /// Prints every value that a run uses instead, of a built-in study or a file, inherited values included
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
    /// File to write, `.csv` or `.json`; an existing one is replaced [default: CSV to standard output]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// Options of an analysis that drives many cycles.
#[derive(Clone, Debug, Args)]
pub(crate) struct AnalysisArguments {
    /// Number of cycles: in each study, or rows of the design
    #[arg(long, value_name = "N", default_value = "1000", allow_negative_numbers = true, value_parser = at_least_one)]
    pub(crate) cycles: u64,
    /// Id of the first cycle
    #[arg(long, value_name = "ID", default_value = "0", allow_negative_numbers = true, value_parser = whole_number)]
    pub(crate) first_cycle: u64,
    /// Master seed
    #[arg(long, value_name = "N", default_value = "1", allow_negative_numbers = true, value_parser = whole_number)]
    pub(crate) seed: u64,
    /// Quantity that is asked about [default: the consumption]
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(QUANTITIES.map(|quantity| quantity.column)))]
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
pub(crate) struct SensitivityArguments {
    /// Name of a built-in study, or a study file
    #[arg(long, value_name = "NAME|FILE", default_value = "field-truck")]
    pub(crate) study: String,
    /// Replaces one value of the study, as in driver.curve_speed.exponent=0.5; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Only these factors; may be repeated or joined by commas [default: all]
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = PossibleValuesParser::new(factor_groups().into_iter().map(|group| group.name)))]
    pub(crate) factor: Vec<String>,
    /// A second opinion: also drives so many cycles with each of 30 drivers, and splits the variance two ways
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = at_least_one)]
    pub(crate) crossed: Option<u64>,
    #[command(flatten)]
    pub(crate) analysis: AnalysisArguments,
}

/// Studies to compare.
#[derive(Clone, Debug, Args)]
pub(crate) struct CompareArguments {
    /// Built-in studies or study files, the baseline first; a single one is compared with itself under --set
    #[arg(value_name = "NAME|FILE", required = true)]
    pub(crate) studies: Vec<String>,
    /// Replaces one value of every study; of a single one, in its second version; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    #[command(flatten)]
    pub(crate) analysis: AnalysisArguments,
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

/// A run on given routes.
#[derive(Clone, Debug, Args)]
pub(crate) struct DriveArguments {
    /// Files with operating cycles: VECTO's `.vdri`, tracks or JSON of `ocmc cycle`, or a route as `.csv`. Of several, each cycle drives
    /// one, by the weights of the study's `mission.routes`
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// What is taken from the file instead of being drawn from the study; may be repeated or joined by commas
    #[arg(long, value_name = "WHAT", value_delimiter = ',')]
    pub(crate) keep: Vec<Kept>,
    /// Follows the speed of a drive cycle, a `.csv` with time, speed and grade; or, exactly, the speed planned on a route
    #[arg(long, value_name = "HOW")]
    pub(crate) follow_speed: Option<Follow>,
    #[command(flatten)]
    pub(crate) run: RunArguments,
}

/// How a drive cycle is followed, as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Follow {
    /// A driver of the study drives it: its speeds are limits along the road, its standstills are stops
    Driver,
    /// Nobody drives it: the exact backward force balance of the prescribed speed
    Exact,
}

/// What is taken from a file, as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kept {
    /// Temperature, pressure, humidity, precipitation, wind
    Weather,
    /// Density of traffic
    Traffic,
    /// Payload and departure
    Mission,
}

impl From<Kept> for Keep {
    fn from(kept: Kept) -> Self {
        match kept {
            Kept::Weather => Self::Weather,
            Kept::Traffic => Self::Traffic,
            Kept::Mission => Self::Mission,
        }
    }
}

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
    /// Ends the run when half of the 95 % interval of the mean consumption is that small, relative to the mean, as in 0.2%; of a
    /// quantile as in p95:1%. --cycles is then the largest number [default: 1000000]
    #[arg(long, value_name = "PRECISION", value_parser = precision)]
    pub(crate) precision: Option<Precision>,
    /// Id of the first cycle: a run can be shared out over machines
    #[arg(long, value_name = "ID", default_value = "0", allow_negative_numbers = true, value_parser = whole_number)]
    pub(crate) first_cycle: u64,
    /// Master seed: with the study and a cycle's id it fixes everything that happens in the cycle
    #[arg(long, value_name = "N", default_value = "1", allow_negative_numbers = true, value_parser = whole_number)]
    pub(crate) seed: u64,
    /// Threads [default: one for each CPU]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = threads)]
    pub(crate) threads: Option<usize>,
    /// Directory for the records, the manifest and the summary of the run; without it nothing is written
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

/// What can be fitted.
#[derive(Clone, Debug, Subcommand)]
pub(crate) enum FitCommand {
    /// Curve speeds: regression and analysis of variance of measured curves, and the driver population
    CurveSpeed(CurveSpeedArguments),
    /// Speed changes: log-normal accelerations and decelerations at changes of the speed limit
    SpeedChange(SpeedChangeArguments),
    /// Operating cycles: road types, signs, events, curves, slope and surface of given roads
    OperatingCycle(OperatingCycleArguments),
    /// Weather: the climate of hourly records
    Weather(WeatherArguments),
    /// Traffic: densities by the hour and road type
    Traffic(TrafficArguments),
}

/// Where fitted values go.
#[derive(Clone, Debug, Args)]
pub(crate) struct FittedArguments {
    /// The answer as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Study file to write: the base with the fitted values laid over it
    #[arg(long, value_name = "FILE")]
    pub(crate) study_out: Option<PathBuf>,
    /// Name of a built-in study, or a study file, that keeps what is not fitted
    #[arg(long, value_name = "NAME|FILE", default_value = "field-truck")]
    pub(crate) base: String,
}

/// Options of the fit of curve speeds.
#[derive(Clone, Debug, Args)]
pub(crate) struct CurveSpeedArguments {
    /// Table of curves: driver,radius_m,direction,speed_mps and, where known, route_m,limit_mps
    #[arg(value_name = "CURVES.csv")]
    pub(crate) file: PathBuf,
    /// Radius at which speeds are compared, in m
    #[arg(long, value_name = "M", default_value = "250", allow_negative_numbers = true)]
    pub(crate) reference_radius: f64,
    /// Smallest radius that takes part, in m
    #[arg(long, value_name = "M", default_value = "20", allow_negative_numbers = true)]
    pub(crate) minimum_radius: f64,
    /// Largest radius that takes part, in m
    #[arg(long, value_name = "M", default_value = "500", allow_negative_numbers = true)]
    pub(crate) maximum_radius: f64,
    /// Routes have to be longer than this, in m, where the table has route_m
    #[arg(long, value_name = "M", default_value = "5000", allow_negative_numbers = true)]
    pub(crate) minimum_route: f64,
    /// Exponent of the second model, and the one that is tested
    #[arg(long, value_name = "DELTA", default_value = "0.5", allow_negative_numbers = true)]
    pub(crate) fixed_exponent: f64,
    /// The direction stays in the model where its p is below this
    #[arg(long, value_name = "P", default_value = "0.05", allow_negative_numbers = true)]
    pub(crate) significance: f64,
    /// The population from the censored regression at the speed limits (needs limit_mps)
    #[arg(long)]
    pub(crate) tobit: bool,
    /// Share of the speed limit from which on a curve counts as driven at the limit
    #[arg(long, value_name = "SHARE", default_value = "0.9", allow_negative_numbers = true)]
    pub(crate) limit_share: f64,
    /// How the coefficients of drivers and directions are listed in the JSON
    #[arg(long, value_name = "CODING", default_value = "sum-to-zero")]
    pub(crate) coding: CodingName,
    #[command(flatten)]
    pub(crate) fitted: FittedArguments,
}

/// Options of the fit of speed changes.
#[derive(Clone, Debug, Args)]
pub(crate) struct SpeedChangeArguments {
    /// Tables of speed changes (acceleration_mps2 and, where known, category,driver), or logs (time, speed, limit)
    #[arg(required = true, value_name = "FILE.csv")]
    pub(crate) files: Vec<PathBuf>,
    /// Says which column of a log is what, as in speed_mph=gps_speed; may be repeated
    #[arg(long, value_name = "NAME=COLUMN")]
    pub(crate) map: Vec<String>,
    /// Length of the window with the largest change of speed in a log, in s
    #[arg(long, value_name = "S", default_value = "3", allow_negative_numbers = true)]
    pub(crate) window: f64,
    /// Smallest acceleration that counts as a change, in m/s²
    #[arg(long, value_name = "MPS2", default_value = "0.2", allow_negative_numbers = true)]
    pub(crate) smallest_acceleration: f64,
    /// Smallest deceleration that counts as a change, in m/s²
    #[arg(long, value_name = "MPS2", default_value = "0.4", allow_negative_numbers = true)]
    pub(crate) smallest_deceleration: f64,
    /// The study from the laws with the thresholds in their likelihood
    #[arg(long)]
    pub(crate) untruncated: bool,
    #[command(flatten)]
    pub(crate) fitted: FittedArguments,
}

/// Options of the fit of operating cycles.
#[derive(Clone, Debug, Args)]
pub(crate) struct OperatingCycleArguments {
    /// Operating cycles with road types, as `ocmc cycle` writes them
    #[arg(required = true, value_name = "CYCLE")]
    pub(crate) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) fitted: FittedArguments,
}

/// Options of the fit of weather.
#[derive(Clone, Debug, Args)]
pub(crate) struct WeatherArguments {
    /// Table of hours: time or time_s and any of temperature_k|_c, pressure_pa|_hpa, relative_humidity|_percent,
    /// precipitation_mps|_mm_per_h, wind_speed_mps, wind_direction_rad|_deg
    #[arg(value_name = "HOURS.csv")]
    pub(crate) file: PathBuf,
    #[command(flatten)]
    pub(crate) fitted: FittedArguments,
}

/// Options of the fit of traffic.
#[derive(Clone, Debug, Args)]
pub(crate) struct TrafficArguments {
    /// Table of measurements: road_type, time or time_s, one of density_share, density_per_m, speed_ratio, and, where
    /// there are several of a type, site
    #[arg(value_name = "TRAFFIC.csv")]
    pub(crate) file: PathBuf,
    #[command(flatten)]
    pub(crate) fitted: FittedArguments,
}

/// Codings, as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum CodingName {
    /// As deviations from their unweighted mean
    SumToZero,
    /// As differences to the first driver and to left curves
    Treatment,
}

impl From<CodingName> for Coding {
    fn from(name: CodingName) -> Self {
        match name {
            CodingName::SumToZero => Self::SumToZero,
            CodingName::Treatment => Self::Treatment,
        }
    }
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

/// Largest precision that can be asked for.
const COARSEST: f64 = 0.5;

/// A precision: `0.2%`, `0.002`, `p95:1%`.
fn precision(text: &str) -> Result<Precision, String> {
    let allowed = || {
        let names = Precision::names().collect::<Vec<_>>().join(", ");
        format!(
            "allowed is a share up to 50%, as in 0.2%, or one of {names} before it, as in p95:1%"
        )
    };
    let (of, share) = text.split_once(':').unwrap_or(("mean", text));
    let (number, unit) = share.strip_suffix('%').map_or((share, 1.0), |number| (number, 0.01));
    let wanted = number.trim().parse::<f64>().map_err(|_| allowed())? * unit;
    if !(Precision::names().any(|name| name == of) && wanted > 0.0 && wanted <= COARSEST) {
        return Err(allowed());
    }
    Ok(Precision { of: of.to_owned(), wanted })
}

/// A whole number from 0 on; `10_000` is one, too.
fn whole_number(text: &str) -> Result<u64, String> {
    let digits = text.replace('_', "");
    let allowed = || format!("allowed is a whole number from 0 to {}", u64::MAX);
    if digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(allowed());
    }
    digits.parse().map_err(|_| allowed())
}

/// A whole number from 1 on.
fn at_least_one(text: &str) -> Result<u64, String> {
    match whole_number(text) {
        Ok(number) if number >= 1 => Ok(number),
        _ => Err(format!("allowed is a whole number from 1 to {}", u64::MAX)),
    }
}

/// An id after which there is another number, so that a run of this cycle alone ends at a number.
fn cycle_id(text: &str) -> Result<u64, String> {
    match whole_number(text) {
        Ok(id) if id < LAST_CYCLE_ID => Ok(id),
        _ => Err(format!("allowed is a whole number from 0 to {}", LAST_CYCLE_ID - 1)),
    }
}

/// Cycles that a thread drives at a time: their records wait in memory.
fn chunk(text: &str) -> Result<u64, String> {
    match whole_number(text) {
        Ok(number) if (1..=LARGEST_CHUNK).contains(&number) => Ok(number),
        _ => Err(format!("allowed is a whole number from 1 to {LARGEST_CHUNK}")),
    }
}

fn threads(text: &str) -> Result<usize, String> {
    let number = whole_number(text).ok().and_then(|number| usize::try_from(number).ok());
    let number = number.filter(|number| (1..=MOST_THREADS).contains(number));
    number.ok_or_else(|| format!("allowed is a whole number from 1 to {MOST_THREADS}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definitions_are_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn precisions() {
        let read = |text| precision(text).map(|p| (p.of, p.wanted));
        assert_eq!(read("0.2%"), Ok(("mean".to_owned(), 0.002)));
        assert_eq!(read("0.25"), Ok(("mean".to_owned(), 0.25)));
        assert_eq!(read("p95:1%"), Ok(("p95".to_owned(), 0.01)));
        for text in ["", "%", "0", "-1%", "51%", "nan", "inf", "p96:1%", "p95", ":1%", "1%%"] {
            assert!(read(text).is_err_and(|told| told.contains("p95")), "{text}");
        }
    }

    #[test]
    fn numbers() {
        assert_eq!(whole_number("10_000"), Ok(10_000));
        assert_eq!(whole_number("18446744073709551615"), Ok(u64::MAX));
        for text in ["", "_", "-1", "+1", "1.5", "1e3", "18446744073709551616", "x"] {
            assert!(whole_number(text).is_err(), "{text}");
        }
        assert!(at_least_one("0").is_err());
        assert!(threads("0").is_err() && threads("1025").is_err() && threads("1024").is_ok());
    }
}
