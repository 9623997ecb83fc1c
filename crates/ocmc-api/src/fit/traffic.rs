//! Traffic densities by the hour and road type.

use super::parameter_table::parameters_text;
use super::{FitAnswer, no_fit};
use crate::error::Error;
use crate::source::{Mapping, Source};
use ocmc_core::study::StudyModel;
use ocmc_estimation::fit::traffic::{TrafficFit, fit};
use ocmc_io::study::FittedPart;
use ocmc_io::traffic_table;

/// Measured traffic.
#[derive(Clone, Debug)]
pub struct TrafficRequest<'a> {
    /// One row a measurement.
    pub table: Source,
    /// Which column is what.
    pub mappings: Vec<Mapping>,
    /// The study that keeps what was not measured.
    pub base: &'a StudyModel,
    /// Hours by which the place's standard time is ahead of UTC.
    pub utc_offset_h: Option<f64>,
}

/// Fits traffic densities.
///
/// ```
/// use ocmc_api::{Error, Source, TrafficRequest, fit_traffic, study};
/// let folder = tempfile::tempdir().expect("a directory");
/// let file = folder.path().join("traffic.csv");
/// std::fs::write(&file, "time_s,road_type,density_share\n0,rural,0.1\n").expect("space");
/// let base = study::load("field-truck", &[] as &[&str])?.model;
/// let (table, mappings) = (Source::File(file), Vec::new());
/// let request = TrafficRequest { table, mappings, base: &base, utc_offset_h: None };
/// // one measurement is not enough
/// assert!(matches!(fit_traffic(&request), Err(Error::Fit { .. })));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where the table cannot be read, [`Error::Fit`] where it does not determine a
/// density.
pub fn fit_traffic(request: &TrafficRequest) -> Result<FitAnswer<TrafficFit>, Error> {
    let TrafficRequest { table, mappings, base, utc_offset_h } = request;
    let records = traffic_table::read(table.lent(), mappings, &base.traffic, *utc_offset_h)?;
    let fit = fit(&records, &base.traffic).map_err(|error| no_fit(table.path(), error))?;
    let part = FittedPart::new(base, &["traffic"], &fit.model);
    let text = parameters_text(&format!("{} densities", fit.n), &fit.parameters, &part.text());
    let warnings = fit.warnings.clone();
    Ok(FitAnswer::new(fit, text, &warnings, &part))
}
