//! The law of curve speeds behind a measured table, through a study.

use super::{FitAnswer, of_driver};
use crate::error::Error;
use crate::source::{Mapping, Source};
use crate::text::table;
use crate::watch::{Progress, Watch};
use ocmc_core::study::StudyModel;
use ocmc_estimation::calibration::curve_speed::{
    CalibrationError, CalibrationOptions, CurveSpeedCalibration, CurveSpeedNumbers, MeasuredCurves,
    calibrate,
};
use ocmc_io::curve_table;
use ocmc_io::number_text::{count_of, grouped};
use ocmc_io::study::{FittedPart, LoadedStudy};
use serde_json::to_value;
use std::ops::ControlFlow;

/// Table of measurements.
#[derive(Clone, Debug)]
pub enum MeasuredTable<'a> {
    /// One row a curve, and which column is what.
    Curves(Source, Vec<Mapping>),
    /// The numbers that a study's law was printed with.
    Law(&'a StudyModel),
}

/// A measured table of curves, and the study that is to give it back.
#[derive(Clone, Debug)]
pub struct CalibrateCurveSpeedRequest<'a> {
    /// Table of measurements.
    pub table: MeasuredTable<'a>,
    /// The study.
    pub study: &'a LoadedStudy,
    /// How.
    pub options: CalibrationOptions,
}

/// Finds the law of curve speeds with which a study gives a measured table back.
///
/// ```no_run
/// use ocmc_api::{
///     CalibrateCurveSpeedRequest, CalibrationOptions, MeasuredTable, calibrate_curve_speed, go_on,
///     study,
/// };
/// let study = &study::load("field-truck", &[] as &[&str])?;
/// let printed = study::load("field-truck-printed", &[] as &[&str])?.model;
/// let (table, options) = (MeasuredTable::Law(&printed), CalibrationOptions::default());
/// let request = CalibrateCurveSpeedRequest { table, study, options };
/// let answer = calibrate_curve_speed(&request, &mut go_on)?;
/// assert!(answer.fit.law.reference_speed_mps > printed.driver.curve_speed.reference_speed_mps);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where the table cannot be read, [`Error::Calibration`] where it does not
/// determine a law, [`Error::Interrupted`].
pub fn calibrate_curve_speed(
    request: &CalibrateCurveSpeedRequest,
    watch: &mut Watch,
) -> Result<FitAnswer<CurveSpeedCalibration>, Error> {
    let CalibrateCurveSpeedRequest { table, study, options } = request;
    let measured = match table {
        MeasuredTable::Curves(curves, mappings) => {
            let (table, _) = curve_table::read(curves.lent(), mappings)?;
            MeasuredCurves::of_curves(&table, &options.fit)?
        }
        MeasuredTable::Law(model) => MeasuredCurves::of_law(&model.driver.curve_speed)?,
    };
    let progress =
        |done: usize| Progress { what: "drives of the study", done: done as u64, total: 0 };
    let mut last = progress(0);
    let mut look = |done: usize| -> ControlFlow<()> {
        last = progress(done);
        watch(last)
    };
    let fit = match calibrate(&measured, &study.study, options, &mut look) {
        Err(CalibrationError::Ended) => return Err(Error::Interrupted(last)),
        ended => ended?,
    };
    let law = fit.population(&study.model.driver.curve_speed);
    let [.., driver_error, residual_error] = fit.standard_errors;
    let errors = [
        ("driver_sd", law.driver_sd, driver_error),
        ("residual_sd", law.residual_sd, residual_error),
    ];
    let errors = errors.map(|error| of_driver("curve_speed", error));
    let part = FittedPart::new(&study.model, &["driver", "curve_speed"], &law);
    // the errors of the other two are those of the law itself
    let together = |_: &str, _: &str| fit.error_correlation[2][3];
    let part = part.with_correlated_errors(&study.model, "curve_speed", errors, &together);
    let (text, warnings) = (text(&fit), warnings(&fit));
    Ok(FitAnswer::new(fit, &text, warnings, &part))
}

/// Limits of the law that a reader has to know.
fn warnings(fit: &CurveSpeedCalibration) -> Vec<String> {
    let mut warnings = Vec::new();
    if !fit.solved {
        warnings.push("the search ended before the table was met: more trips may help".to_owned());
    }
    for name in &fit.at_bound {
        warnings.push(format!(
            "`{name}` stays on its bound: no law brings this study to the table in it; the table \
             below shows what of the study is the rest"
        ));
    }
    warnings
}

/// The four numbers as cells: v₀ in km/h, δ, the SDs in %.
fn cells(numbers: &CurveSpeedNumbers) -> [String; 4] {
    [
        format!("{:.1}", 3.6 * numbers.reference_speed_mps),
        format!("{:.3}", numbers.exponent),
        format!("{:.1}", 100.0 * numbers.driver_sd),
        format!("{:.1}", 100.0 * numbers.residual_sd),
    ]
}

/// The same with errors.
fn with_errors(numbers: &CurveSpeedNumbers, errors: &[f64; 4]) -> [String; 4] {
    let scale = [3.6 * numbers.reference_speed_mps, 1.0, 100.0, 100.0];
    let digits = [1, 3, 1, 1];
    let cells = cells(numbers);
    std::array::from_fn(|k| format!("{} ± {:.*}", cells[k], digits[k], errors[k] * scale[k]))
}

fn text(fit: &CurveSpeedCalibration) -> String {
    let head = ["", "v0, km/h", "exponent", "drivers, SD, %", "residual, SD, %"];
    let line = |name: &str, cells: [String; 4]| -> Vec<String> {
        std::iter::once(name.to_owned()).chain(cells).collect()
    };
    let mut rows = vec![
        line("measured", with_errors(&fit.measured.numbers, &fit.measured.standard_errors)),
        line("simulated with the study's law", cells(&fit.before)),
        line("law, calibrated", with_errors(&fit.law, &fit.standard_errors)),
        line("simulated with it", cells(&fit.simulated)),
    ];
    for part in &fit.surroundings {
        let names = part.without.iter().filter_map(|switch| to_value(switch).ok());
        let names: Vec<String> =
            names.filter_map(|name| Some(name.as_str()?.replace('_', " "))).collect();
        let name = match names.as_slice() {
            [one] => format!("  without {one}"),
            many if many.iter().any(|name| name == "signs") => {
                "  without all of these, and signs".into()
            }
            many if many.iter().any(|name| name == "traffic") => "  without both".into(),
            _ => "  without stops and bumps".into(),
        };
        rows.push(line(&name, cells(&part.numbers)));
    }
    let trips = match fit.trips_per_driver {
        1 => count_of(fit.drivers, "trip"),
        many => format!("{} of {} each", count_of(fit.drivers, "driver"), count_of(many, "trip")),
    };
    format!(
        "{} curves in {trips}, driven {} times\n\n{}",
        grouped(fit.curves as u64),
        fit.evaluations,
        table(&[34, 14, 16, 16, 16], &head, rows)
    )
}
