//! From measurements to the numbers of a study.

mod curve_speed;
mod curve_speed_text;
mod operating_cycle;
mod operating_cycle_text;
mod parameter_table;
mod speed_change;
mod speed_change_text;
mod traffic;
mod weather;

pub use curve_speed::{Coding, CurveSpeedOptions, CurveSpeedRequest, fit_curve_speed};
pub use operating_cycle::{OperatingCycleRequest, RoadOptions, RoadSource, fit_operating_cycle};
pub use speed_change::{SpeedChangeOptions, SpeedChangeRequest, fit_speed_change};
pub use traffic::{TrafficRequest, fit_traffic};
pub use weather::{WeatherRequest, fit_weather};

use crate::answer::Answer;
use crate::error::{Error, FitError};
use ocmc_io::study::FittedPart;
use serde::Serialize;
use serde_json::Value;
use std::path::Path;

/// What measurements tell.
#[derive(Clone, Debug, Serialize)]
pub struct FitAnswer<Fit> {
    /// The estimates.
    #[serde(flatten)]
    pub fit: Fit,
    /// The part of a study that follows from them.
    pub study: Value,
    #[serde(skip)]
    text: String,
    #[serde(skip)]
    warnings: Vec<String>,
}

impl<Fit> FitAnswer<Fit> {
    fn new(fit: Fit, text: String, warnings: &[String], part: &FittedPart) -> Self {
        let warnings = warnings.iter().cloned().chain(part.warnings()).collect();
        Self { fit, study: part.json(), text, warnings }
    }
}

impl<Fit: Serialize> Answer for FitAnswer<Fit> {
    fn text(&self) -> String {
        self.text.clone()
    }

    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }
}

/// Measurements that have no fit.
fn no_fit(source: &Path, error: impl Into<FitError>) -> Error {
    Error::Fit { path: source.to_owned(), error: error.into() }
}
