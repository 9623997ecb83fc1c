//! Words that stand for options: on the command line as they are here, in Python with `_` for `-`.

use crate::size::Season;
use crate::sweep::Against;
use ocmc_core::operating_cycle::drawn_part::Draw;
use ocmc_core::operating_cycle::route::Keep;
use ocmc_estimation::fit::curve_speed::Coding;
use ocmc_estimation::fit::fleet::Best;
use ocmc_estimation::identification::options::SpeedTerm::{self, Measured, Simulated};
use ocmc_estimation::identification::options::{ControllerKind, Unknown};
use ocmc_estimation::log::curve::Detector::{self, TrainedHiddenMarkov};
use ocmc_estimation::log::curve::RadiusDefinition::{
    self, InverseMeanCurvature, MeanRadius, Positions,
};
use ocmc_estimation::log::hidden_markov::HiddenMarkov;
use ocmc_estimation::log::threshold::Threshold;
use ocmc_fleet::sensitivity::Over;
use ocmc_io::given_drive::Follow::{self, Driver, Exact};
use ocmc_io::records::RecordFormat;

/// A word, what it says, and what it stands for.
pub type Word<T> = (&'static str, &'static str, T);

/// Formats of records.
pub const FORMATS: [Word<RecordFormat>; 2] = [
    ("parquet", "Apache Parquet", RecordFormat::Parquet),
    ("csv", "Comma-separated values", RecordFormat::Csv),
];

/// How a run is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunFormat {
    /// With its records in this format.
    Records(RecordFormat),
    /// With its records in the format that is the default, and a workbook beside them.
    Workbook,
}

impl RunFormat {
    /// Format of the records, where one is said.
    pub fn records(self) -> Option<RecordFormat> {
        match self {
            Self::Records(format) => Some(format),
            Self::Workbook => None,
        }
    }
}

/// Formats of a run.
pub const RUN_FORMATS: [Word<RunFormat>; 3] = [
    ("parquet", "Apache Parquet", RunFormat::Records(RecordFormat::Parquet)),
    ("csv", "Comma-separated values", RunFormat::Records(RecordFormat::Csv)),
    (
        "xlsx",
        "Apache Parquet, and a workbook `run.xlsx` beside it once the run is complete",
        RunFormat::Workbook,
    ),
];

/// Good end of a quantity.
pub const BESTS: [Word<Best>; 2] = [
    ("lowest", "Less is better, as of consumption", Best::Lowest),
    ("highest", "More is better, as of speed", Best::Highest),
];

/// Parts that can be taken from the file of a route.
pub const KEEPS: [Word<Keep>; 3] = [
    ("weather", "Temperature, pressure, humidity, precipitation, wind", Keep::Weather),
    ("traffic", "Density of traffic", Keep::Traffic),
    ("mission", "Payload and departure", Keep::Mission),
];

/// Parts that can be drawn where the file of a route lacks them.
pub const DRAWS: [Word<Draw>; 4] = [
    ("stops", "Signs, give ways, lights, bumps, railway crossings", Draw::Stops),
    ("limits", "Speed limits, and road types where there are none either", Draw::Limits),
    ("hills", "Slopes, also between altitudes that are far apart", Draw::Hills),
    ("curves", "Curves", Draw::Curves),
];

/// How a drive cycle is followed.
pub const FOLLOWS: [Word<Follow>; 2] = [
    (
        "driver",
        "A driver of the study drives it: its speeds are limits along the road, its standstills \
         are stops",
        Driver,
    ),
    ("exact", "Without a driver: the exact backward force balance of the prescribed speed", Exact),
];

/// How the coefficients of drivers and directions are listed.
pub const CODINGS: [Word<Coding>; 2] = [
    ("sum-to-zero", "As deviations from their unweighted mean", Coding::SumToZero),
    ("treatment", "As differences to the first driver and to left curves", Coding::Treatment),
];

/// Definitions of the radius of a curve.
pub const RADII: [Word<RadiusDefinition>; 3] = [
    ("turn", "Length over heading change: 1 / mean |curvature|", InverseMeanCurvature),
    ("mean", "Mean of 1 / |curvature|, as in the paper; noise biases it upwards", MeanRadius),
    ("positions", "Circle through the positions (latitude and longitude)", Positions),
];

/// How curves are distinguished from straights.
pub fn detectors() -> [Word<Detector>; 3] {
    let states = HiddenMarkov::default();
    [
        ("hidden-markov", "Hidden Markov states", Detector::HiddenMarkov(states)),
        (
            "trained",
            "Hidden Markov states whose laws are fitted to each drive first",
            TrainedHiddenMarkov(states),
        ),
        ("threshold", "Thresholds with hysteresis", Detector::Threshold(Threshold::default())),
    ]
}

/// Controllers that can be fitted.
pub const CONTROLLERS: [Word<ControllerKind>; 2] = [
    ("pid", "PID", ControllerKind::Pid),
    ("switched", "Switched proportional", ControllerKind::Switched),
];

/// Speeds that the objective of an identification can compare with the set speed.
pub const SPEED_TERMS: [Word<SpeedTerm>; 3] = [
    ("measured", "The measured speed, as the paper may mean; it biases the gains", Measured),
    (
        "simulated",
        "The simulated speed, as the paper may mean, too; it biases the gains as much",
        Simulated,
    ),
    ("none", "No speed term; unbiased", SpeedTerm::None),
];

/// Units over which a variance can be taken.
pub const OVERS: [Word<Over>; 2] = [
    ("trip", "Trips, each by itself", Over::Trip),
    ("truck", "Trucks, each by its total over its total", Over::Truck),
];

/// References that the points of a sweep can have.
pub const AGAINSTS: [Word<Against>; 2] =
    [("first", "The first point", Against::First), ("base", "The study as it is", Against::Base)];

/// Seasons of the north in which trips depart.
pub const SEASONS: [Word<Season>; 4] = [
    ("winter", "December to February", Season::Winter),
    ("spring", "March to May", Season::Spring),
    ("summer", "June to August", Season::Summer),
    ("autumn", "September to November", Season::Autumn),
];

/// Unknowns that an identification can estimate beside the controller.
pub const UNKNOWNS: [Word<Unknown>; 4] = [
    ("delay", "How late the driver sees the speed", Unknown::Delay),
    ("mass", "The mass of the truck", Unknown::Mass),
    ("resistance", "Rolling resistance and air drag of the truck", Unknown::Resistance),
    ("none", "Nothing: the truck is the study's, its driver reacts at once", Unknown::Nothing),
];
