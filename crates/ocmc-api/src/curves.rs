//! The curves that were driven, from measured logs.

use crate::error::Error;
use crate::source::{Mapping, Source};
use crate::watch::{Progress, Watch};
use ocmc_estimation::log::curve::CurveDetection;
use ocmc_estimation::log::signal::LogCounts;
use ocmc_io::intake::FileAccount;
use ocmc_io::log::curves::{FoundCurves, needs, write_csv};
use ocmc_io::number_text::{count_of, grouped, rounded};
use serde::Serialize;
use std::fmt::Write;
use std::io;

pub use ocmc_estimation::log::curve::{
    Correction, CurveOptions, Detector, DrivenCurve, RadiusDefinition,
};
pub use ocmc_estimation::log::hidden_markov::HiddenMarkov;
pub use ocmc_estimation::log::threshold::Threshold;
pub use ocmc_io::log::curves::{
    COLUMNS as CURVE_COLUMNS, CurveCell, Steering, TripCurves, TripError,
};

/// Logs, and how curves are found in them.
#[derive(Clone, Debug)]
pub struct CurvesRequest<'a> {
    /// The logs.
    pub logs: &'a [Source],
    /// Columns of the quantities.
    pub mappings: Vec<Mapping>,
    /// How curves are found.
    pub options: CurveOptions,
    /// Steering ratio and wheelbase, for logs that only have the steering wheel's angle.
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
    /// Files that were read.
    pub inputs: Vec<FileAccount>,
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
    let mut detected = FoundCurves::default();
    for (done, log) in logs.iter().enumerate() {
        let progress = Progress::of_logs(done, logs.len());
        let file = log.log(mappings, &needs, warn)?;
        progress.ended(detected.add(&file, options, *steering, || watch(progress)))?;
    }
    if let Some((place, fault)) = detected.failed() {
        return Err(Error::Drive { place: place.clone(), fault: fault.clone() });
    }
    for (place, fault) in &detected.left_out {
        warn(&format!("{place} is left out: {fault}"));
    }
    let FoundCurves { drives, left_out, inputs } = detected;
    Ok(CurvesAnswer { options: *options, left_out: left_out.len(), drives, inputs })
}

impl CurvesAnswer {
    /// Account of the curves found, and of everything that was not used, for people; without a line
    /// end.
    pub fn account(&self) -> String {
        let Self { drives, left_out, .. } = self;
        let mut text = FileAccount::told_of(&self.inputs).join("\n");
        text.push('\n');
        if drives.len() <= MOST_LINES {
            for drive in drives {
                let detection = &drive.detection;
                let curves = count_of(detection.curves.len() as u64, "curve");
                let _ = write!(
                    text,
                    "{}: {} km, {curves}",
                    drive.drive,
                    rounded(detection.way_m / 1e3)
                );
                if drive.turning != "yaw_rate" {
                    let _ = write!(text, ", turning by its {}", drive.turning.replace('_', " "));
                }
                if let Some(bias) = detection.gyro_bias_radps.filter(|bias| *bias != 0.0) {
                    let _ = write!(text, ", yaw rate less {bias:.5} rad/s");
                }
                if let Some(lag) = detection.speed_lag_s {
                    let _ = write!(text, ", speed {lag:.2} s late");
                }
                let LogCounts { rows, used, gaps, gap_s, .. } = &detection.counts;
                if used < rows {
                    let _ = write!(text, ", {} not used", count_of((rows - used) as u64, "row"));
                }
                if *gaps > 0 {
                    let gaps = count_of(*gaps as u64, "gap");
                    let _ = write!(text, ", {gaps} of {} s", rounded(*gap_s));
                }
                text.push('\n');
            }
        }
        let sum = |count: fn(&CurveDetection) -> usize| {
            drives.iter().map(|drive| count(&drive.detection)).sum::<usize>() as u64
        };
        let way_km: f64 = drives.iter().map(|drive| drive.detection.way_m / 1000.0).sum();
        let slow_km: f64 = drives.iter().map(|drive| drive.detection.slow_m / 1000.0).sum();
        let _ = write!(
            text,
            "{} on {} km of {} ({} km of it too slow to tell)\n{} of {} rows used",
            count_of(sum(|detection| detection.curves.len()), "curve"),
            rounded(way_km),
            count_of(drives.len() as u64, "drive"),
            rounded(slow_km),
            grouped(sum(|detection| detection.counts.used)),
            grouped(sum(|detection| detection.counts.rows))
        );
        for (what, count) in [
            ("rows without time", sum(|detection| detection.counts.missing_time)),
            ("rows without speed", sum(|detection| detection.counts.missing_speed)),
            ("rows without yaw rate", sum(|detection| detection.counts.missing_yaw_rate)),
            (
                "rows with the time of the row before",
                sum(|detection| detection.counts.repeated_time),
            ),
            (
                "rows in reverse (is the sign of the speed right?)",
                sum(|detection| detection.counts.reversing),
            ),
            ("gaps in time", sum(|detection| detection.counts.gaps)),
            ("curves too short", sum(|detection| detection.too_short)),
            ("curves that turn too little", sum(|detection| detection.too_straight)),
            ("curves in which the vehicle crept or stood", sum(|detection| detection.too_slow)),
            ("curves whose radius cannot be measured", sum(|detection| detection.without_radius)),
            ("drives left out", *left_out as u64),
            (
                "drives without standstill, so the bias of the gyro is not known",
                sum(|detection| usize::from(detection.gyro_bias_radps.is_none())),
            ),
        ] {
            if count > 0 {
                let _ = write!(text, "; {what}: {}", grouped(count));
            }
        }
        for (what, count) in [
            ("faster than 70 m/s", sum(|detection| detection.counts.implausible_speed)),
            (
                "turning by more than 2 rad/s",
                sum(|detection| detection.counts.implausible_yaw_rate),
            ),
        ] {
            if count > 0 {
                let rows = grouped(count);
                let _ = write!(text, "\nwarning: {rows} rows are {what}: is the unit right?");
            }
        }
        text
    }

    /// Writes the curves as comma-separated values, one row a curve.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_csv(&self, out: impl io::Write) -> io::Result<()> {
        write_csv(out, &self.drives)
    }
}

/// Most drives that get a line of their own.
const MOST_LINES: usize = 40;
