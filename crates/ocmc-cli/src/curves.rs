//! `ocmc curves`: the curves that were driven, from measured logs.

use crate::arguments::{CurvesArguments, DetectorName};
use crate::failure::Failure;
use crate::fit::sources;
use crate::output::{self, warn};
use crate::table_file;
use ocmc_api::{
    Correction, CurveOptions, CurvesRequest, Detector, HiddenMarkov, Threshold, go_on, mappings,
};

/// Finds the curves of all drives of the logs and writes them down.
pub(crate) fn curves(arguments: &CurvesArguments) -> Result<(), Failure> {
    let target = table_file::target(arguments.out.as_deref())?;
    let request = CurvesRequest {
        logs: &sources(&arguments.files.logs),
        mappings: mappings(&arguments.files.map)?,
        options: options(arguments),
        steering: arguments.steering.steering()?,
    };
    let answer = ocmc_api::curves(&request, &mut warn, &mut go_on)?;
    if !arguments.quiet {
        output::note(&answer.account());
    }
    table_file::write(&target, &answer, |bytes| answer.write_csv(bytes))
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
