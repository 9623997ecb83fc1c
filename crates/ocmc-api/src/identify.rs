//! The pedal gains of drivers, one fit for each driver and event.

use crate::answer::Answer;
use crate::error::Error;
use crate::source::{Mapping, Source};
use crate::watch::{Progress, Watch, aside};
use ocmc_estimation::identification::identify::{DriverParameterFit, EventFit};
use ocmc_estimation::identification::population::Population;
use ocmc_io::intake::FileAccount;
use ocmc_io::log::identification::{Identification, LeftOut, TruckMass};
use ocmc_io::log::pedals::NEEDS;
use ocmc_io::study::{LoadedStudy, Origin};
use serde::Serialize;
use std::fmt::Write;

pub use ocmc_estimation::identification::options::{
    ControllerKind, IdentifyOptions, SpeedTerm, Unknown, Unknowns,
};

/// Logs, and what is asked of them.
#[derive(Clone, Debug)]
pub struct IdentifyRequest<'a> {
    /// The logs.
    pub logs: &'a [Source],
    /// The study with the truck that was driven.
    pub study: &'a LoadedStudy,
    /// Columns of the quantities.
    pub mappings: Vec<Mapping>,
    /// Parameters to be fitted, and the method.
    pub options: IdentifyOptions,
    /// Whether to warn of rows that are not used; the answer's notes name them anyway.
    pub warn_of_rows: bool,
}

/// The pedal gains.
#[derive(Clone, Debug, Serialize)]
pub struct IdentifyAnswer {
    /// Name of the study.
    pub study: String,
    /// Parameters that were fitted, and the method.
    pub options: IdentifyOptions,
    /// A fit for each driver and event.
    pub fits: Vec<EventFit>,
    /// Mass of the truck of each log of four events or more, by all of them.
    pub trucks: Vec<TruckMass>,
    /// The population behind them, of three drivers or more.
    pub population: Option<Population>,
    /// Drives without a fit.
    pub left_out: Vec<LeftOut>,
    /// Rows that are not used.
    pub notes: Vec<String>,
    /// Files that were read.
    pub inputs: Vec<FileAccount>,
    #[serde(skip)]
    warnings: Vec<String>,
}

/// Fits each event of each log, and the population behind them. `warn` receives what is odd in a
/// log.
///
/// ```
/// use ocmc_api::{Error, IdentifyOptions, IdentifyRequest, Source, go_on, identify, study};
/// let folder = tempfile::tempdir().expect("a directory");
/// let file = folder.path().join("log.csv");
/// let rows = "time_s,speed_mps,accelerator,brake,grade\n0,20,0.3,0,0\n1,20,0.3,0,0\n";
/// std::fs::write(&file, rows).expect("space");
/// let study = &study::load("simulator-slopes", &[] as &[&str])?;
/// let (logs, options) = (&[Source::File(file)], IdentifyOptions::default());
/// let mappings = Vec::new();
/// let request = IdentifyRequest { logs, study, mappings, options, warn_of_rows: true };
/// // on a level road there is no event
/// let answer = identify(&request, &mut |_| (), &mut go_on);
/// assert!(matches!(answer, Err(Error::NoDrive { .. })));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Bounds`] where the bounds of a gain are none, [`Error::Table`] where a log cannot be
/// read, [`Error::NoDrive`] where no event has a fit, [`Error::Interrupted`].
pub fn identify(
    request: &IdentifyRequest,
    warn: &mut dyn FnMut(&str),
    watch: &mut Watch,
) -> Result<IdentifyAnswer, Error> {
    let IdentifyRequest { logs, study, mappings, options, warn_of_rows } = request;
    options.check()?;
    let mut identification = Identification::default();
    for (done, log) in logs.iter().enumerate() {
        Progress::of_logs(done, logs.len()).look(watch)?;
        identification.add(&log.log(mappings, &NEEDS, warn)?, &study.study);
    }
    if *warn_of_rows {
        identification.notes.iter().for_each(|note| warn(note));
    }
    let start = Progress { what: "events", done: 0, total: identification.waiting() as u64 };
    aside(start, watch, |stop, done| identification.identify(&study.study, options, stop, done))?;
    if let Some(LeftOut { place, reason, .. }) = identification.failed() {
        return Err(Error::NoDrive(place, reason));
    }
    let study = match &study.origin {
        Origin::Dictionary => study.model.study.name.clone(),
        other => other.to_string(),
    };
    let (population, warnings) = (identification.population(), identification.left_out_warnings());
    let Identification { fits, trucks, left_out, notes, inputs, .. } = identification;
    Ok(IdentifyAnswer {
        study,
        options: *options,
        fits,
        trucks,
        population,
        left_out,
        notes,
        inputs,
        warnings,
    })
}

impl Answer for IdentifyAnswer {
    fn notes(&self) -> Vec<String> {
        FileAccount::told_of(&self.inputs)
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for fit in &self.fits {
            let EventFit { driver, event, duration_s, pedal_rms, condition, .. } = fit;
            let (agree, starts) = (fit.starts_converged, fit.starts);
            let _ = writeln!(
                text,
                "driver {driver}, event {event} ({duration_s:.0} s): pedals within {pedal_rms:.4} \
                 rms, {agree} of {starts} starts agree, condition {condition:.0}",
            );
            for parameter in &fit.parameters {
                line(&mut text, parameter);
            }
            if fit.saturated_s > 0.0 {
                let _ = writeln!(
                    text,
                    "  saturated: a pedal is fully pressed for {:.1} s, in which it says nothing",
                    fit.saturated_s
                );
            }
            for why in &fit.no_intervals {
                let _ = writeln!(text, "  no interval: {why}");
            }
            for warning in &fit.warnings {
                let _ = writeln!(text, "  {warning}");
            }
        }
        if !self.trucks.is_empty() {
            text.push('\n');
        }
        for truck in &self.trucks {
            let _ = writeln!(text, "{}", truck.text());
        }
        match &self.population {
            None => {
                text.push_str(
                    "\nno population: it takes three drivers with a PID whose K_P and K_I are \
                     identified\n",
                );
            }
            Some(population) => table(&mut text, population),
        }
        text
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = self.warnings.clone();
        if self.options.speed_term != SpeedTerm::None {
            warnings.push(
                "the speed term of the paper biases the gains, so that no intervals are given: \
                 without it they are unbiased"
                    .to_owned(),
            );
        }
        let term = usize::from(self.options.speed_term != SpeedTerm::None);
        let unexplained = self.fits.iter().filter(|fit| fit.no_intervals.len() > term).count();
        if unexplained > 0 {
            warnings.push(format!(
                "{unexplained} of {} fits do not explain their pedals and have no intervals: below \
                 each stands why (--json: `no_intervals`)",
                self.fits.len()
            ));
        }
        warnings
    }
}

fn line(text: &mut String, parameter: &DriverParameterFit) {
    let (label, unit) = match parameter.name {
        "kp" => ("K_P", "s/m"),
        "ki" => ("K_I", "1/m"),
        "kd" => ("K_D", "s²/m"),
        "threshold_mps" => ("threshold", "m/s"),
        "set_speed_mps" => ("set speed", "m/s"),
        "start_integral" => ("integral part at the start", ""),
        "start_speed_mps" => ("speed at the start", "m/s"),
        "delay_s" => ("delay", "s"),
        "mass_kg" => ("mass", "kg"),
        "resistance_share" => ("rolling resistance and drag above the study's", ""),
        name => (name, ""),
    };
    let _ = write!(text, "  {label} = {:.4}", parameter.value);
    if let Some([low, high]) = parameter.interval {
        let _ = write!(text, " ({low:.4}; {high:.4})");
    }
    if !unit.is_empty() {
        let _ = write!(text, " {unit}");
    }
    if let Some(why) = parameter.not_identifiable {
        let _ = write!(text, ": not identifiable, {why}");
    }
    text.push('\n');
}

/// The population as a table of a study.
fn table(text: &mut String, population: &Population) {
    // bounds that hardly cut the law
    let three = (3.0 * population.proportional_log_sd).exp();
    let _ = write!(
        text,
        "\n# {} drivers, {} fits; {} left out because K_P or K_I is not identified\n\
         # spread of ln K_P between the events of a driver: {:.2}\n\
         [driver.pedals.pid]\n\
         proportional_median = {:.4}\n\
         proportional_log_sd = {:.3}\n\
         proportional_minimum = {:.4}\n\
         proportional_maximum = {:.4}\n\
         integral_time_median_s = {:.2}\n\
         integral_time_log_sd = {:.3}\n",
        population.drivers,
        population.fits,
        population.left_out,
        population.proportional_within_log_sd,
        population.proportional_median,
        population.proportional_log_sd,
        population.proportional_median / three,
        population.proportional_median * three,
        population.integral_time_median_s,
        population.integral_time_log_sd,
    );
    match (population.derivative_median, population.derivative_log_sd) {
        (Some(median), Some(sd)) => {
            let _ = writeln!(text, "derivative_median = {median:.4}\nderivative_log_sd = {sd:.3}");
        }
        _ => text.push_str("# K_D is identified for too few drivers: the study's own law stays\n"),
    }
    let [pi, pd, id] = population.correlation;
    let _ = writeln!(text, "correlation = [{pi:.2}, {pd:.2}, {id:.2}]");
}
