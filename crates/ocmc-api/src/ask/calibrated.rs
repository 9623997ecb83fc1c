//! A study calibrated to a table of trips, as a study that can be asked next.

use super::study::laid_over;
use crate::calibrate_totals::CalibrateTotalsAnswer;
use crate::study::LoadedStudy;
use ocmc_io::study::study_text;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;

/// A calibration, and the study that it makes.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CalibratedAnswer {
    /// The calibration.
    #[serde(flatten)]
    pub calibration: CalibrateTotalsAnswer,
    /// Text of the calibrated study.
    pub study_toml: String,
}

impl CalibratedAnswer {
    /// The study with what was calibrated laid over it; where its numbers are from is said in it.
    pub(super) fn new(study: &LoadedStudy, calibration: CalibrateTotalsAnswer) -> Self {
        let mut own = study.own();
        laid_over(&mut own, &calibration.study);
        let standing = json!({ "calibrate totals": calibration.standing });
        laid_over(&mut own, &json!({ "judged": { "fitted": standing } }));
        Self { study_toml: study_text(&own), calibration }
    }
}
