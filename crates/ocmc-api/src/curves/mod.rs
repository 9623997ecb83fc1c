//! The curves that were driven, from measured logs.

mod text;

use crate::error::Error;
use crate::progress::{Progress, Watch};
use crate::source::{Mapping, Source};
use ocmc_io::log::curves::{FoundCurves, needs, write_csv};
use serde::Serialize;
use std::io;

pub use ocmc_estimation::log::curve::{
    Correction, CurveOptions, Detector, DrivenCurve, RadiusDefinition,
};
pub use ocmc_estimation::log::hidden_markov::HiddenMarkov;
pub use ocmc_estimation::log::threshold::Threshold;
pub use ocmc_io::log::curves::{Steering, TripCurves, TripError};

/// Logs, and how curves are found in them.
#[derive(Clone, Debug)]
pub struct CurvesRequest<'a> {
    /// The logs.
    pub logs: &'a [Source],
    /// Which column is what.
    pub mappings: Vec<Mapping>,
    /// How curves are found.
    pub options: CurveOptions,
    /// What the steering wheel does, for logs that only have its angle.
    pub steering: Option<Steering>,
}

/// The curves that were driven.
#[derive(Clone, Debug, Serialize)]
pub struct CurvesAnswer {
    /// How they were found.
    pub options: CurveOptions,
    /// Number of drives that could not be used.
    pub left_out: usize,
    /// The curves of the others.
    pub drives: Vec<TripCurves>,
}

/// Finds the curves of all drives of the logs. `warn` receives what is odd in a log, and what is
/// left out.
///
/// ```
/// use ocmc_api::{CurveOptions, CurvesRequest, Source, curves, go_on};
/// // 10 m/s, and for 10 s a left turn with a radius of 100 m
/// let row = |k: u32| (f64::from(k) / 10.0, if (200..300).contains(&k) { 0.1 } else { 0.0 });
/// let rows = (0..600).map(row).map(|(time, yaw)| format!("{time},10,{yaw}\n"));
/// let text = format!("time_s,speed_mps,yaw_rate_radps\n{}", rows.collect::<String>());
/// let folder = tempfile::tempdir().expect("a directory");
/// let file = folder.path().join("log.csv");
/// std::fs::write(&file, text).expect("space");
/// let (logs, options) = (&[Source::File(file)], CurveOptions::default());
/// let request = CurvesRequest { logs, mappings: Vec::new(), options, steering: None };
/// let answer = curves(&request, &mut |_| (), &mut go_on)?;
/// let curve = &answer.drives[0].detection.curves[0];
/// assert!(curve.left && (curve.radius_m - 100.0).abs() < 1.0);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where a log cannot be read, [`Error::Drive`] where no drive can be used,
/// [`Error::Interrupted`].
pub fn curves(
    request: &CurvesRequest,
    warn: &mut dyn FnMut(&str),
    watch: &mut Watch,
) -> Result<CurvesAnswer, Error> {
    let CurvesRequest { logs, mappings, options, steering } = request;
    let needs = needs(options.radius);
    let mut found = FoundCurves::default();
    for (done, log) in logs.iter().enumerate() {
        let progress = Progress::of_logs(done, logs.len());
        let file = log.log(mappings, &needs, warn)?;
        progress.ended(found.add(&file, options, *steering, || watch(progress)))?;
    }
    if let Some((place, fault)) = found.failed() {
        return Err(Error::Drive { place: place.clone(), fault: fault.clone() });
    }
    for (place, fault) in &found.left_out {
        warn(&format!("{place} is left out: {fault}"));
    }
    let FoundCurves { drives, left_out } = found;
    Ok(CurvesAnswer { options: *options, left_out: left_out.len(), drives })
}

impl CurvesAnswer {
    /// What was found, and everything that was not used, for people; without a line end.
    pub fn account(&self) -> String {
        text::curves_account(&self.drives, self.left_out)
    }

    /// Writes the curves as comma-separated values, one row a curve.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_csv(&self, out: impl io::Write) -> io::Result<()> {
        write_csv(out, &self.drives)
    }
}
