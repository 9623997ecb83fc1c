//! Questions that can be asked as JSON.

use crate::size::Season;
use crate::sweep::Against;
use ocmc_fleet::sensitivity::Over;
use schemars::JsonSchema;
use serde::Deserialize;

/// A question, told by its key `ask`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(tag = "ask", rename_all = "kebab-case")]
pub enum Ask {
    /// How consumption, speed and duration are distributed over a fleet, which may have groups: as
    /// `ocmc` does.
    Run(AskRun),
    /// Paired differences of studies, as of `ocmc compare`.
    Compare(AskCompare),
    /// A study at many points, as of `ocmc sweep`.
    Sweep(AskSweep),
    /// Factors that the spread comes from, as of `ocmc sensitivity`.
    Sensitivity(AskSensitivity),
    /// Share of the answer's uncertainty that judged numbers cause, as of `ocmc doubt`.
    Doubt(AskPair),
    /// Cost of a study, or of two against each other, as of `ocmc cost`.
    Cost(AskPair),
    /// How far battery trucks come, as of `ocmc range`.
    Range(AskStudy),
    /// How large a battery has to be, as of `ocmc size`.
    Size(AskSize),
    /// The least energy for the same trips, as of `ocmc bound`.
    Bound(AskStudy),
    /// Kinds and contents of files.
    Files(AskFiles),
    /// Contents of a study.
    Study(AskStudyText),
    /// One trip step by step, as of `ocmc trace`.
    Trip(AskTrip),
    /// A study calibrated to a table of trips, as of `ocmc calibrate totals`.
    CalibrateTotals(AskCalibrateTotals),
}

/// A study: the name of a built-in one or of a file, or more than that.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum AskedStudy {
    /// Name of a built-in study, or a study file.
    Named(String),
    /// A study with what is set in it.
    Given(GivenStudy),
}

/// A study with what is set in it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GivenStudy {
    /// The study.
    pub study: StudySource,
    /// Settings such as `vehicle.drag_area_m2.median=4.5`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Name in the answer; that of the study and what is set by default.
    #[serde(default)]
    pub name: Option<String>,
}

/// Where a study comes from.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum StudySource {
    /// Name of a built-in study, or a study file.
    Named(String),
    /// The keys of a study file; `ocmc study schema` has their schema.
    Keys(serde_json::Map<String, serde_json::Value>),
}

impl AskedStudy {
    /// Keys that are set in it, as `KEY=VALUE`.
    pub(super) fn set(&self) -> &[String] {
        match self {
            Self::Named(_) => &[],
            Self::Given(given) => &given.set,
        }
    }

    /// Name of the study in the answer.
    pub(super) fn name(&self) -> String {
        let (source, set) = match self {
            Self::Named(name) | Self::Given(GivenStudy { name: Some(name), .. }) => {
                return name.clone();
            }
            Self::Given(given) => (&given.study, &given.set),
        };
        let named = match source {
            StudySource::Named(name) => name.clone(),
            StudySource::Keys(keys) => {
                let own = keys.get("study").and_then(|study| study.get("name"));
                own.and_then(|name| name.as_str()).unwrap_or("given").to_owned()
            }
        };
        [vec![named], set.clone()].concat().join(" with ")
    }
}

/// Cycles to drive, and the number of threads.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AskPlan {
    /// Number of cycles, of `sensitivity` of rows of the design; 1000 by default, or as many as
    /// `ocmc` takes of a study whose trucks make several trips.
    #[schemars(range(min = 1))]
    pub cycles: Option<u64>,
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// Threads; one for each processor where there is no number.
    #[schemars(range(min = 1))]
    pub threads: Option<usize>,
}

impl Default for AskPlan {
    fn default() -> Self {
        Self { cycles: None, seed: 1, first_cycle: 0, threads: None }
    }
}

/// A run.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AskRun {
    /// The study, which may be one of groups.
    pub study: AskedStudy,
    /// Number of trucks in place of cycles. Not with groups.
    #[serde(default)]
    #[schemars(range(min = 1))]
    pub trucks: Option<u64>,
    /// Precision at which the run ends, such as `0.2%`. Not with groups.
    #[serde(default)]
    pub precision: Option<String>,
    /// Cycles. Groups say their number themselves.
    #[serde(default)]
    pub plan: AskPlan,
}

/// A comparison.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AskCompare {
    /// Studies, the baseline first; two at least.
    #[schemars(length(min = 2))]
    pub studies: Vec<AskedStudy>,
    /// Cycles of each study.
    #[serde(default)]
    pub plan: AskPlan,
    /// Quantity, or another column of the records.
    #[serde(default)]
    pub column: Option<String>,
}

/// A sweep.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AskSweep {
    /// The study.
    pub study: AskedStudy,
    /// Settings with several values, such as `vehicle.drag_area_m2.median=5,4.5,4`.
    pub points: Vec<String>,
    /// Reference of the comparison.
    #[serde(default)]
    pub against: Against,
    /// Cycles of each point.
    #[serde(default)]
    pub plan: AskPlan,
    /// Quantity, or another column of the records.
    #[serde(default)]
    pub column: Option<String>,
}

/// An analysis of variance.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AskSensitivity {
    /// The study.
    pub study: AskedStudy,
    /// Rows of the design.
    #[serde(default)]
    pub plan: AskPlan,
    /// Quantity.
    #[serde(default)]
    pub column: Option<String>,
    /// Factors; all by default.
    #[serde(default)]
    pub factors: Option<Vec<String>>,
    /// Unit over which the variance is taken.
    #[serde(default)]
    pub over: Over,
    /// Shares that add up to one, too.
    #[serde(default)]
    pub shapley: bool,
}

/// A study, and perhaps another one.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AskPair {
    /// The study.
    pub study: AskedStudy,
    /// The study that it is compared with.
    #[serde(default)]
    pub against: Option<AskedStudy>,
    /// Cycles of each study.
    #[serde(default)]
    pub plan: AskPlan,
    /// Quantity that is doubted; costs have none.
    #[serde(default)]
    pub column: Option<String>,
}

/// A study by itself.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AskStudy {
    /// The study.
    pub study: AskedStudy,
    /// Cycles.
    #[serde(default)]
    pub plan: AskPlan,
}

/// The size of a battery.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AskSize {
    /// The study.
    pub study: AskedStudy,
    /// Shares of the trips that are to arrive, each above 0 and below 1.
    pub arrive: Vec<f64>,
    /// Mass of the truck that a kWh of battery adds, in kg; 0: all batteries weigh the same.
    #[serde(default)]
    pub kg_per_kwh: f64,
    /// Season in which trips depart that count; all by default.
    #[serde(default)]
    pub season: Option<Season>,
    /// Cycles.
    #[serde(default)]
    pub plan: AskPlan,
}

/// Files.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AskFiles {
    /// Their names; all of the folder that the program runs in by default.
    #[serde(default)]
    pub files: Option<Vec<String>>,
}

/// A study, and perhaps another one that it is compared with.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AskStudyText {
    /// The study.
    pub study: AskedStudy,
    /// The study of which the differences are told.
    #[serde(default)]
    pub against: Option<AskedStudy>,
}

/// A trip.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AskTrip {
    /// The study.
    pub study: AskedStudy,
    /// Id of the cycle.
    pub cycle: u64,
    /// Master seed.
    #[serde(default = "first_seed")]
    pub seed: u64,
}

/// A calibration.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AskCalibrateTotals {
    /// The study.
    pub study: AskedStudy,
    /// Name of the file with the table: one row a trip, or a fill.
    pub table: String,
    /// Columns of the quantities, as of `--map`.
    #[serde(default)]
    pub map: Vec<String>,
    /// Master seed.
    #[serde(default = "first_seed")]
    pub seed: u64,
}

fn first_seed() -> u64 {
    AskPlan::default().seed
}
