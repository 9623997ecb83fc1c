//! The driver population of measured curves.

use super::curve_speed_text::curve_speed_text;
use super::{FitAnswer, no_fit};
use crate::error::Error;
use crate::source::{Mapping, Source};
use ocmc_core::study::StudyModel;
use ocmc_estimation::fit::curve_speed::{CurveSpeedFit, fit};
use ocmc_io::curve_table;
use ocmc_io::study::FittedPart;

pub use ocmc_estimation::fit::curve_speed::{Coding, CurveSpeedOptions};

/// Curves, and what is asked of them.
#[derive(Clone, Debug)]
pub struct CurveSpeedRequest<'a> {
    /// One row a curve.
    pub curves: Source,
    /// Which column is what.
    pub mappings: Vec<Mapping>,
    /// The study that keeps what curves do not tell.
    pub base: &'a StudyModel,
    /// Which curves count, and how.
    pub options: CurveSpeedOptions,
    /// The population from the censored regression at the speed limits.
    pub tobit: bool,
}

/// Fits the curve speeds of drivers: regression, analysis of variance, population.
///
/// ```
/// use ocmc_api::{CurveSpeedOptions, CurveSpeedRequest, Source, fit_curve_speed, study};
/// let folder = tempfile::tempdir().expect("a directory");
/// let file = folder.path().join("curves.csv");
/// let curves = "driver,radius_m,speed_mps\na,50,10.1\na,100,13.9\na,200,20.2\na,400,27.8\n\
///               b,50,11.1\nb,100,15.3\nb,200,22.1\nb,400,30.6\n";
/// std::fs::write(&file, curves).expect("space");
/// let base = study::load("field-truck", &[] as &[&str])?.model;
/// let (curves, mappings) = (Source::File(file), Vec::new());
/// let options = CurveSpeedOptions::default();
/// let request = CurveSpeedRequest { curves, mappings, base: &base, options, tobit: false };
/// let answer = fit_curve_speed(&request)?;
/// assert!((answer.fit.estimated.exponent - 0.49).abs() < 0.01);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Table`] where the table cannot be read, [`Error::Fit`] where the curves do not
/// determine the model, [`Error::Tobit`] where they do not determine the censored one.
pub fn fit_curve_speed(request: &CurveSpeedRequest) -> Result<FitAnswer<CurveSpeedFit>, Error> {
    let CurveSpeedRequest { curves, mappings, base, options, tobit } = request;
    let table = curve_table::read(curves.lent(), mappings)?;
    let fit = fit(&table, options).map_err(|error| no_fit(curves.path(), error))?;
    let censored = fit.tobit.as_ref().filter(|_| *tobit);
    if *tobit && censored.is_none() {
        return Err(Error::Tobit);
    }
    let population = fit.population(censored, &base.driver.curve_speed);
    let part = FittedPart::new(base, &["driver", "curve_speed"], &population);
    let text = curve_speed_text(&fit, table.driver.len(), &part.text());
    let warnings = fit.warnings.clone();
    Ok(FitAnswer::new(fit, text, &warnings, &part))
}
