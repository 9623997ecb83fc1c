//! `ocmc identify`: the pedal gains of drivers, one fit for each driver and event.

use crate::answer::Answer;
use crate::arguments::{ControllerName, IdentifyArguments, SpeedTermName};
use crate::failure::Failure;
use crate::log::{mappings, read_logs};
use crate::progress::Progress;
use crate::{identify_text, output, request};
use ocmc_estimation::identification::identify::{ControllerKind, IdentifyOptions, SpeedTerm};
use ocmc_io::log::identification::{Identification, LeftOut};
use ocmc_io::log::pedals::NEEDS;
use ocmc_io::study;
use serde_json::json;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// Fits each event of each log, and the population behind them.
pub(crate) fn identify(arguments: &IdentifyArguments) -> Result<(), Failure> {
    let options = options(arguments)?;
    let loaded = study::load(&arguments.study, &arguments.set)?;
    let mappings = mappings(&arguments.files.map)?;
    let mut found = Identification::default();
    let logs = arguments.files.logs.iter().map(PathBuf::as_path);
    read_logs(logs, &mappings, &NEEDS, |file| found.add(file))?;
    if !arguments.quiet {
        found.notes.iter().for_each(|note| output::note(&format!("warning: {note}")));
    }
    let progress = Progress::over("events", found.waiting() as u64, 0, arguments.quiet);
    found.identify(&loaded.study, &options, &AtomicBool::new(false), |done| {
        progress.reach(done as u64);
    });
    progress.finish();
    let answer = identification_answer(&arguments.study, &options, &found);
    let answer =
        answer.map_err(|LeftOut { place, reason, .. }| Failure::NoEvent { place, reason })?;
    if !arguments.quiet {
        answer.warnings.iter().for_each(|text| output::note(&format!("warning: {text}")));
    }
    if arguments.json {
        return output::answer(&format!("{}\n", answer.json));
    }
    output::answer(&answer.text)
}

/// What an identification with the truck of the study of that name tells.
///
/// # Errors
/// What was left out first, where no event has a fit.
pub fn identification_answer(
    study: &str,
    options: &IdentifyOptions,
    found: &Identification,
) -> Result<Answer, LeftOut> {
    if let Some(first) = found.failed() {
        return Err(first);
    }
    let population = found.population();
    let json = json!({
        "study": study,
        "options": options,
        "fits": found.fits,
        "population": population,
        "left_out": found.left_out,
        "notes": found.notes,
    });
    Ok(Answer {
        json,
        text: identify_text::text(&found.fits, population.as_ref()),
        warnings: found.left_out_warnings(),
    })
}

fn options(arguments: &IdentifyArguments) -> Result<IdentifyOptions, Failure> {
    let standard = IdentifyOptions::default();
    let range = |given: Option<&Vec<f64>>, standard: [f64; 2]| {
        given.map_or(standard, |ends| [ends[0], ends[1]])
    };
    let options = IdentifyOptions {
        controller: match arguments.controller {
            ControllerName::Pid => ControllerKind::Pid,
            ControllerName::Switched => ControllerKind::Switched,
        },
        speed_term: match arguments.speed_term {
            SpeedTermName::Measured => SpeedTerm::Measured,
            SpeedTermName::Simulated => SpeedTerm::Simulated,
            SpeedTermName::None => SpeedTerm::None,
        },
        starts: usize::from(arguments.starts),
        intervals: !arguments.no_intervals,
        proportional: range(arguments.kp.as_ref(), standard.proportional),
        integral: range(arguments.ki.as_ref(), standard.integral),
        derivative: range(arguments.kd.as_ref(), standard.derivative),
        ..standard
    };
    options.check().map_err(|error| request::usage(&error.to_string()))?;
    Ok(options)
}
