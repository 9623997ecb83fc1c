//! Answers to a question.

use super::calibrated::CalibratedAnswer;
use super::files::FilesAnswer;
use super::study::StudyAnswer;
use super::trip::TripAnswer;
use crate::answer::Answer;
use crate::bound::BoundAnswer;
use crate::compare::CompareAnswer;
use crate::cost::CostAnswer;
use crate::doubt::DoubtAnswer;
use crate::mixed_fleet::MixedFleetAnswer;
use crate::progress::Progress;
use crate::range::RangeAnswer;
use crate::run::RunAnswer;
use crate::sensitivity::SensitivityAnswer;
use crate::size::SizeAnswer;
use crate::sweep::SweepAnswer;
use schemars::JsonSchema;
use serde::Serialize;

/// Version of questions and messages: another one where a key goes or changes its meaning. New keys
/// of answers may come in any version.
pub const VERSION: u32 = 1;

/// Message on a line of its own, told by its key `message`.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(tag = "message", rename_all = "kebab-case")]
pub enum Message {
    /// How far the work is: several times a second.
    Progress(Progress),
    /// The answer: the last message.
    Answer(Box<Reply>),
    /// Why there is no answer: the last message.
    Refused {
        /// Reason: the fault, its place, and the allowed values.
        reason: String,
    },
    /// The work was ended before there was an answer: the last message.
    Interrupted(Progress),
}

/// An answer, and what has to be known of it.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Reply {
    /// Version of this schema.
    pub version: u32,
    /// The program, such as `ocmc 0.2.0`.
    pub program: String,
    /// Facts that do not stop the answer and have to be known.
    pub warnings: Vec<String>,
    /// The answer.
    #[serde(flatten)]
    pub answer: AskAnswer,
}

/// The answers: `answer` is what the command prints with `--json`.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(tag = "of", content = "answer", rename_all = "kebab-case")]
#[allow(clippy::large_enum_variant, reason = "there is one of it at a time")]
pub enum AskAnswer {
    /// Answer of a run.
    Run(RunAnswer),
    /// Answer of a run of groups.
    Fleet(MixedFleetAnswer),
    /// Answer of a comparison.
    Compare(CompareAnswer),
    /// Answer of a sweep.
    Sweep(SweepAnswer),
    /// Answer of an analysis of variance.
    Sensitivity(SensitivityAnswer),
    /// Answer on judged numbers.
    Doubt(DoubtAnswer),
    /// Answer on costs.
    Cost(CostAnswer),
    /// Answer on ranges.
    Range(RangeAnswer),
    /// Answer on batteries.
    Size(SizeAnswer),
    /// Answer on least energies.
    Bound(BoundAnswer),
    /// Answer on files.
    Files(FilesAnswer),
    /// Answer on a study's keys.
    Study(StudyAnswer),
    /// Answer on a trip.
    Trip(TripAnswer),
    /// Answer of a calibration.
    CalibrateTotals(CalibratedAnswer),
}

impl AskAnswer {
    fn warnings(&self) -> Vec<String> {
        match self {
            Self::Run(answer) => answer.warnings(),
            Self::Fleet(answer) => answer.warnings(),
            Self::Compare(answer) => answer.warnings(),
            Self::Sweep(answer) => answer.warnings(),
            Self::Sensitivity(answer) => answer.warnings(),
            Self::Doubt(answer) => answer.warnings(),
            Self::Cost(answer) => answer.warnings(),
            Self::Range(answer) => answer.warnings(),
            Self::Size(answer) => answer.warnings(),
            Self::Bound(answer) => answer.warnings(),
            Self::CalibrateTotals(answer) => answer.calibration.warnings(),
            Self::Files(_) | Self::Study(_) | Self::Trip(_) => Vec::new(),
        }
    }
}

impl Reply {
    /// The reply with an answer, and what has to be known of its studies.
    pub(super) fn new(mut warnings: Vec<String>, answer: AskAnswer) -> Self {
        warnings.extend(answer.warnings());
        Self {
            version: VERSION,
            program: format!("ocmc {}", env!("CARGO_PKG_VERSION")),
            warnings,
            answer,
        }
    }
}
