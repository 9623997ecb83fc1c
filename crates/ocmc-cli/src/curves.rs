//! `ocmc curves`: the curves that were driven, from measured logs.

use crate::arguments::{CurvesArguments, DetectorName};
use crate::failure::Failure;
use crate::log::{mappings, read_logs, tell_left_out};
use crate::log_text;
use crate::{output, table_file};
use ocmc_estimation::log::curve::{Correction, CurveOptions, Detector};
use ocmc_estimation::log::hidden_markov::HiddenMarkov;
use ocmc_estimation::log::threshold::Threshold;
use ocmc_io::log::curves::{FoundCurves, needs, write_csv};
use serde_json::json;
use std::convert::Infallible;
use std::ops::ControlFlow;
use std::path::PathBuf;

/// Finds the curves of all drives of the logs and writes them down.
pub(crate) fn curves(arguments: &CurvesArguments) -> Result<(), Failure> {
    let target = table_file::target(arguments.out.as_deref())?;
    let options = options(arguments);
    let mappings = mappings(&arguments.files.map)?;
    let steering = arguments.steering.steering()?;
    let mut found = FoundCurves::default();
    let logs = arguments.files.logs.iter().map(PathBuf::as_path);
    read_logs(logs, &mappings, &needs(options.radius), |file| {
        let go_on = || ControlFlow::<Infallible>::Continue(());
        let ControlFlow::Continue(()) = found.add(file, &options, steering, go_on);
    })?;
    tell_left_out(found.failed(), &found.left_out)?;
    let FoundCurves { drives, left_out } = found;
    let left_out = left_out.len();
    if !arguments.quiet {
        output::note(&log_text::curves_account(&drives, left_out));
    }
    table_file::write_either(
        &target,
        |bytes| write_csv(bytes, &drives),
        || json!({ "options": options, "left_out": left_out, "drives": drives }),
    )
}

fn options(arguments: &CurvesArguments) -> CurveOptions {
    let given = |value: Option<f64>| value.map_or(Correction::Estimated, Correction::Given);
    let standard = CurveOptions::default();
    CurveOptions {
        detector: match arguments.detector {
            DetectorName::HiddenMarkov => Detector::HiddenMarkov(HiddenMarkov::default()),
            DetectorName::Trained => Detector::TrainedHiddenMarkov(HiddenMarkov::default()),
            DetectorName::Threshold => Detector::Threshold(Threshold::default()),
        },
        radius: arguments.radius.into(),
        central_share: arguments.central_share.unwrap_or(standard.central_share),
        split_ratio: arguments.split,
        gyro_bias_radps: given(arguments.gyro_bias_radps),
        speed_lag_s: given(arguments.speed_lag_s),
        ..standard
    }
}
