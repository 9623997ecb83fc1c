//! The climate of hourly records.

use super::parameter_table::parameters_text;
use super::{FitAnswer, no_fit};
use crate::error::Error;
use crate::source::{Mapping, Source};
use ocmc_core::study::StudyModel;
use ocmc_estimation::fit::weather::{WeatherFit, fit};
use ocmc_io::study::FittedPart;
use ocmc_io::weather_table;

/// Recorded weather.
#[derive(Clone, Debug)]
pub struct WeatherRequest<'a> {
    /// One row an hour.
    pub table: Source,
    /// Which column is what.
    pub mappings: Vec<Mapping>,
    /// The study that keeps what was not recorded.
    pub base: &'a StudyModel,
    /// Hours by which the place's standard time is ahead of UTC.
    pub utc_offset_h: Option<f64>,
}

/// Fits the weather model.
///
/// ```
/// use ocmc_api::{Error, Source, WeatherRequest, fit_weather, study};
/// let folder = tempfile::tempdir().expect("a directory");
/// let file = folder.path().join("weather.csv");
/// std::fs::write(&file, "time_s,temperature_k\n0,281\n").expect("space");
/// let base = study::load("field-truck", &[] as &[&str])?.model;
/// let (table, mappings) = (Source::File(file), Vec::new());
/// let request = WeatherRequest { table, mappings, base: &base, utc_offset_h: None };
/// // one hour is not enough
/// assert!(matches!(fit_weather(&request), Err(Error::Fit { .. })));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where the table cannot be read, [`Error::Fit`] where it determines nothing.
pub fn fit_weather(request: &WeatherRequest) -> Result<FitAnswer<WeatherFit>, Error> {
    let WeatherRequest { table, mappings, base, utc_offset_h } = request;
    let records = weather_table::read(table.lent(), mappings, *utc_offset_h)?;
    let fit = fit(&records, &base.weather).map_err(|error| no_fit(table.path(), error))?;
    let part = FittedPart::new(base, &["weather"], &fit.model);
    let head = format!("{} hours over {:.1} years", fit.hours, fit.years);
    let text = parameters_text(&head, &fit.parameters, &part.text());
    let warnings = fit.warnings.clone();
    Ok(FitAnswer::new(fit, text, &warnings, &part))
}
