//! What a question is answered.

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

/// What is answered on a line of its own, told by its key `message`.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(tag = "message", rename_all = "kebab-case")]
pub enum Message {
    /// How far the work is: several times a second.
    Progress(Progress),
    /// The answer: the last message.
    Answer(Box<Reply>),
    /// Why there is no answer: the last message.
    Refused {
        /// What is wrong, where, and what is allowed.
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
    /// What does not stop the answer and has to be known.
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
    /// Of a run.
    Run(RunAnswer),
    /// Of a run of groups.
    Fleet(MixedFleetAnswer),
    /// Of a comparison.
    Compare(CompareAnswer),
    /// Of a sweep.
    Sweep(SweepAnswer),
    /// Of an analysis of variance.
    Sensitivity(SensitivityAnswer),
    /// Of judged numbers.
    Doubt(DoubtAnswer),
    /// Of costs.
    Cost(CostAnswer),
    /// Of ranges.
    Range(RangeAnswer),
    /// Of batteries.
    Size(SizeAnswer),
    /// Of least energies.
    Bound(BoundAnswer),
    /// Of files.
    Files(FilesAnswer),
    /// Of a study's keys.
    Study(StudyAnswer),
    /// Of a trip.
    Trip(TripAnswer),
    /// Of a calibration.
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
