//! Why a question has no answer.

use crate::progress::Progress;
use ocmc_core::operating_cycle::given::GivenCycleError;
use ocmc_core::random::LAST_CYCLE_ID;
use ocmc_estimation::calibration::curve_speed::CalibrationError;
use ocmc_estimation::fit::curve_speed::CurveSpeedFitError;
use ocmc_estimation::fit::fleet::FleetFitError;
use ocmc_estimation::fit::operating_cycle::RoadFitError;
use ocmc_estimation::fit::speed_change::SpeedChangeError;
use ocmc_estimation::fit::traffic::TrafficFitError;
use ocmc_estimation::fit::weather::WeatherFitError;
use ocmc_estimation::identification::options::BoundsError;
use ocmc_fleet::bound::BoundError;
use ocmc_fleet::quantity::{QUANTITIES, numeric_columns};
use ocmc_fleet::run::{MOST_THREADS, RunPlan};
use ocmc_fleet::sensitivity::{SensitivityError, factor_groups};
use ocmc_io::file_error::FileError;
use ocmc_io::given_drive::GivenDriveError;
use ocmc_io::log::curves::TripError;
use ocmc_io::records::RecordsError;
use ocmc_io::run_directory::RunDirectoryError;
use ocmc_io::shell_word::resume_command;
use ocmc_io::speed_change_table::SpeedChangeFileError;
use ocmc_io::study::StudyFileError;
use ocmc_io::table::TableError;
use ocmc_io::workbook::WorkbookError;
use ocmc_vecto::comparison::ComparisonError;
use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// Why a question has no answer.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// A study that is not one.
    #[error(transparent)]
    Study(#[from] StudyFileError),
    /// Something that cannot be driven.
    #[error(transparent)]
    GivenDrive(#[from] GivenDriveError),
    /// A run directory that cannot be written or read.
    #[error(transparent)]
    RunDirectory(#[from] RunDirectoryError),
    /// A run that is to be resumed and was given something else to drive.
    #[error(
        "`{}` holds a run of other files, or of another --keep or --follow-speed; `{}` finishes it \
         as it was begun",
        directory.display(),
        resume_command(directory)
    )]
    OtherRun {
        /// Its directory.
        directory: PathBuf,
    },
    /// A run that is to be resumed, and is another one than is said.
    #[error(
        "`{}` holds another run: {}; `{}` finishes it as it was begun",
        directory.display(),
        differences.join("; "),
        resume_command(directory)
    )]
    Differs {
        /// Its directory.
        directory: PathBuf,
        /// Differences from the run.
        differences: Vec<String>,
    },
    /// A run that would hold a part of a truck's trips.
    #[error(
        "`{name}` is {count}, allowed are multiples of {trips_per_truck}, such as {}: each truck \
         of the study makes so many trips (`fleet.trips_per_truck`), and a run holds whole trucks",
        count.next_multiple_of(*trips_per_truck)
    )]
    PartOfTruck {
        /// Name of the part that was asked for.
        name: &'static str,
        /// How much of it.
        count: u64,
        /// Trips of each truck.
        trips_per_truck: u64,
    },
    /// A run directory that takes no more of a run that is under way.
    #[error(transparent)]
    Unwritten(RunDirectoryError),
    /// A range of trucks without a battery.
    #[error(
        "{0} has no battery, and so no range: give a study of battery trucks, such as \
         battery-truck, or a run of one"
    )]
    NoBattery(String),
    /// The roads of a study are given, not drawn from laws.
    #[error("{0} drives given routes, which no law describes: look at them without laws")]
    GivenRoads(String),
    /// No trip departs in the season that was asked for.
    #[error(
        "none of the {cycles} trips departs in {season}: ask for more of them, or for another \
         season"
    )]
    NoTripInSeason {
        /// The season.
        season: &'static str,
        /// Trips that were drawn.
        cycles: u64,
    },
    /// A share of trips that cannot be asked for.
    #[error("`arrive` is {0}, allowed is a share above 0 and below 1")]
    Share(f64),
    /// A mass that no battery has, in kg for each kWh.
    #[error("`kg_per_kwh` is {0}, allowed is 0 to 100")]
    Mass(f64),
    /// A quantity that there is not.
    #[error("`column` is {:?}, allowed is one of: {}", .0, columns().join(", "))]
    UnknownColumn(String),
    /// A column that no study has, or that is no number.
    #[error(
        "`column` is {name:?}{}: allowed are the columns of the records that are numbers, and \
         stops_per_km",
        nearest.as_ref().map_or(String::new(), |name| format!(" (did you mean `{name}`?)"))
    )]
    NoColumn {
        /// Its name.
        name: String,
        /// The one that was probably meant.
        nearest: Option<String>,
    },
    /// A factor that there is not.
    #[error("`factors` has {:?}, allowed are: {}", .0, factors().join(", "))]
    UnknownFactor(String),
    /// A comparison with VECTO that is not made.
    #[error(transparent)]
    Vecto(ComparisonError),
    /// A measured table that no law of a study gives back.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// Something that a run of groups has of each group.
    #[error("`{0}` does not go with `fleet.group`: the study says it of each group")]
    NotOfGroups(&'static str),
    /// A precision that cannot be read.
    #[error("{0}")]
    Precision(String),
    /// Cycles that there are not.
    #[error(
        "{} cycles from {} on {} threads: allowed are ids below {LAST_CYCLE_ID}, one cycle at \
         least, and at most {MOST_THREADS} threads",
        .0.cycles, .0.first_cycle, .0.threads
    )]
    NoSuchCycles(RunPlan),
    /// A comparison of fewer than two studies.
    #[error("a study is compared with another one: give two at least")]
    NothingToCompare,
    /// A sweep without two studies that differ.
    #[error(
        "nothing to compare: give a key several values, as in KEY=A,B,C, or a list of points; a \
         single point is compared with the study as it is by --against base (in Python against)"
    )]
    NothingToSweep,
    /// A sweep of too many points.
    #[error("the sweep has {points} points, allowed are at most {most}: give fewer values")]
    ManyPoints {
        /// Points that were asked for.
        points: usize,
        /// Most that are allowed.
        most: usize,
    },
    /// A key of a sweep that is given twice.
    #[error("`{0}` is given twice: give all of its values at once, as in KEY=A,B,C")]
    SweptTwice(String),
    /// Two points of a sweep that are the same study.
    #[error("{second} is the same study as {first}: leave one of them out")]
    SamePoints {
        /// Name of the first one.
        first: String,
        /// Name of the other one.
        second: String,
    },
    /// A point of a sweep that is no study.
    #[error("{point}: {source}")]
    SweptPoint {
        /// Its name.
        point: String,
        /// Fault of it.
        source: StudyFileError,
    },
    /// A question about judged numbers to studies that have none.
    #[error(
        "no number of the study is judged: a study file says in its tables `[judged.NAME]` between \
         which values they lie, and a number that is typed or fitted is not in doubt"
    )]
    NothingJudged,
    /// A table of totals with too few rows.
    #[error(
        "`{}`: {rows} of its rows have a distance of at least 2 km, an amount and what the others \
         have; allowed is a table of at least {fewest}",
        path.display()
    )]
    FewTotals {
        /// The table.
        path: PathBuf,
        /// Rows that count.
        rows: usize,
        /// Fewest that are allowed.
        fewest: usize,
    },
    /// A folder in which nothing tells anything of a study.
    #[error(
        "`{}`: nothing in it can be learnt from: {reason}; allowed are tables of trips (distance \
         and fuel or energy), logs and tracks, tables of weather, traffic, curves and speed \
         changes",
        folder.display()
    )]
    NothingToLearn {
        /// The folder.
        folder: PathBuf,
        /// Why.
        reason: String,
    },
    /// A table of totals of another carrier than the study's.
    #[error(
        "`{}`: its amounts are of another carrier than the study's, whose consumption is {column}: \
         give a study of such trucks, or assign the column with --map, such as \
         fuel_amount_l=COLUMN or energy_kwh=COLUMN",
        path.display()
    )]
    OtherCarrier {
        /// The table.
        path: PathBuf,
        /// The study's consumption.
        column: String,
    },
    /// A benchmark without a ranking of drivers.
    #[error(
        "`{}`: {why}; allowed is the `benchmark.json` of a table whose drivers are ranked",
        path.display()
    )]
    NoRankedDrivers {
        /// The file.
        path: PathBuf,
        /// Fault of it.
        why: &'static str,
    },
    /// A study of which hardly a trip arrives with the loads and lengths of a table.
    #[error(
        "hardly a trip of {0} arrives with the weights and lengths of the table: give a study of \
         such trucks, or check the units of distance and weight"
    )]
    NothingExpected(String),
    /// A date that is none.
    #[error("`since` is {0:?}, allowed is a date such as 2024-03-01 or 2024-03-01T14:00")]
    NotADate(String),
    /// A table without dates, of which before and after a date are asked.
    #[error(
        "`{}`: no row has a date that can be read: give the departures a column `date`, such as \
         2024-03-01, or assign it with --map departure=COLUMN",
        .0.display()
    )]
    NoDates(PathBuf),
    /// Groups that cannot be compared.
    #[error(
        "the column `group` has {0} values in the rows that count, allowed are 2 to 20: assign \
         another one with --map group=COLUMN"
    )]
    NoGroups(usize),
    /// A noise, or what is held back, that is no share up to a half.
    #[error("`{name}` is {value}, allowed is a share from 0 to 0.5")]
    SmallShare {
        /// Name of the number.
        name: &'static str,
        /// The number.
        value: f64,
    },
    /// Costs of a study, of this name, without prices.
    #[error(
        "`{0}` has no prices: give it a table `[cost]`, or `--set cost.currency=EUR` and prices"
    )]
    NoPrices(String),
    /// Costs in two currencies, of the first study and of the second.
    #[error("`cost.currency` is {0} and {1}: give both studies prices in one currency")]
    Currencies(String, String),
    /// Costs of a study without a completed trip.
    #[error("{study}: of {cycles} cycles none was completed, so that nothing has a cost")]
    NothingToCost {
        /// Its name.
        study: String,
        /// Cycles that were driven.
        cycles: u64,
    },
    /// Drivers who cannot be told apart, because there are fewer than two.
    #[error(
        "{0}: fewer than two drivers completed a trip; allowed is a fleet of at least two trucks"
    )]
    NobodyToTrain(String),
    /// A table, a log or an operating cycle that cannot be read.
    #[error(transparent)]
    Table(#[from] TableError),
    /// Speed changes that cannot be read.
    #[error(transparent)]
    SpeedChange(#[from] SpeedChangeFileError),
    /// Logs without a drive that can be used.
    #[error("{place}: {fault}")]
    Drive {
        /// Where the first drive stands.
        place: String,
        /// Fault of it.
        fault: TripError,
    },
    /// Bounds of a gain that are none.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// A censored regression that is asked for and not determined.
    #[error(
        "needs a column limit_mps with limits above 0, and curves below them that determine the \
         regression"
    )]
    Tobit,
    /// Measurements that have no fit, and why.
    #[error("`{}`: {}", .0.display(), .1)]
    Fit(PathBuf, FitError),
    /// Shares that cannot be estimated.
    #[error(transparent)]
    Sensitivity(#[from] SensitivityError),
    /// A cycle without a bound.
    #[error(transparent)]
    Bound(#[from] BoundError),
    /// Logs without a drive that lies on the road, or without an event that can be identified:
    /// where the first one stands, and why it has no score or fit.
    #[error("{0}: {1}")]
    NoDrive(String, String),
    /// A road on which no simulated trip arrives.
    #[error("no trip of the study arrives on {road}: of {trips} none was completed")]
    NoTrip {
        /// The road.
        road: String,
        /// Number of trips.
        trips: u64,
    },
    /// A run that does not fit into a workbook.
    #[error(transparent)]
    Workbook(WorkbookError),
    /// A file that cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A directory that holds something already.
    #[error("`{}` is not empty; give another directory, or remove it", .0.display())]
    NotEmpty(PathBuf),
    /// A group of a fleet whose trucks make one trip each: its name.
    #[error(
        "trucks of group `{0}` make one trip each, and a fleet adds up what trucks do in several: \
         give `fleet.trips_per_truck`, or --trips"
    )]
    GroupWithoutTrips(String),
    /// The caller has ended it.
    #[error("interrupted: {} of {} {} finished", .0.done, .0.total, .0.what)]
    Interrupted(Progress),
}

impl From<ComparisonError> for Error {
    fn from(error: ComparisonError) -> Self {
        match error {
            ComparisonError::Study(error) => Self::Study(error),
            error => Self::Vecto(error),
        }
    }
}

impl From<WorkbookError> for Error {
    fn from(error: WorkbookError) -> Self {
        match error {
            WorkbookError::File(error) => Self::File(error),
            WorkbookError::RunDirectory(error) => Self::RunDirectory(error),
            error => Self::Workbook(error),
        }
    }
}

impl Error {
    /// Error of the system, where a file cannot be read or written.
    pub fn system(&self) -> Option<&io::Error> {
        match self {
            Self::Table(error)
            | Self::SpeedChange(SpeedChangeFileError::Table(error))
            | Self::GivenDrive(GivenDriveError::File(error)) => error.reason(),
            Self::File(file) => Some(&file.source),
            Self::RunDirectory(error) | Self::Unwritten(error) => match error {
                RunDirectoryError::NotARun { source, .. } => Some(source),
                RunDirectoryError::File(file)
                | RunDirectoryError::Records(RecordsError::File(file)) => Some(&file.source),
                _ => None,
            },
            _ => None,
        }
    }
}

/// Why measurements have no fit.
#[derive(Debug, Error)]
#[error(transparent)]
#[non_exhaustive]
pub enum FitError {
    /// Error in fitting curve speeds.
    CurveSpeed(#[from] CurveSpeedFitError),
    /// Error in fitting speed changes.
    SpeedChange(#[from] SpeedChangeError),
    /// Error in fitting roads.
    Road(#[from] RoadFitError),
    /// An operating cycle that is no road.
    Cycle(#[from] GivenCycleError),
    /// Error in fitting traffic.
    Traffic(#[from] TrafficFitError),
    /// Error in fitting weather.
    Weather(#[from] WeatherFitError),
    /// Error in fitting the records of a fleet.
    Fleet(#[from] FleetFitError),
}

/// Names of the quantities that can be asked about.
pub fn columns() -> Vec<&'static str> {
    QUANTITIES.iter().map(|quantity| quantity.column).collect()
}

/// Names of the columns that studies can be compared by and that all have.
pub fn compared_columns() -> Vec<&'static str> {
    numeric_columns().collect()
}

/// Names of the factors that a variance is shared out to.
pub fn factors() -> Vec<&'static str> {
    factor_groups().into_iter().map(|group| group.name).collect()
}
