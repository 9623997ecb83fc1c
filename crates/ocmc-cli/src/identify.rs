//! `ocmc identify`: the pedal gains of drivers, one fit for each driver and event.

use crate::arguments::{ControllerName, IdentifyArguments, SpeedTermName};
use crate::failure::Failure;
use crate::{identify_text, log_text, output, request};
use ocmc_core::identification::identify::{
    ControllerKind, EventFit, IdentifyOptions, SpeedTerm, identify_event,
};
use ocmc_core::identification::population::Population;
use ocmc_io::log::mapping::Mapping;
use ocmc_io::log::pedals::{NEEDS, events};
use ocmc_io::log::read;
use ocmc_io::study;
use serde_json::json;

/// Fits each event of each log, and the population behind them.
pub(crate) fn identify(arguments: &IdentifyArguments) -> Result<(), Failure> {
    let options = options(arguments)?;
    let loaded = study::load(&arguments.study, &arguments.set)?;
    let mappings: Vec<Mapping> =
        arguments.files.map.iter().map(|text| Mapping::parse(text)).collect::<Result<_, _>>()?;
    let mut fits: Vec<EventFit> = Vec::new();
    let mut faults = Vec::new();
    for path in &arguments.files.logs {
        let file = read(path, &mappings, &NEEDS)?;
        for warning in log_text::file_warnings(&file) {
            output::note(&warning);
        }
        for drive in &file.drives {
            let place = log_text::place(&file, drive);
            let (events, dropped) = events(drive);
            if dropped > 0 && !arguments.quiet {
                output::note(&format!(
                    "{place}: {dropped} of {} rows lack a number that is needed, or repeat the time before: they are not used",
                    drive.rows()
                ));
            }
            if events.is_empty() {
                let reason = "no event: a log needs the label `event`, or slopes of 0.5 % or more";
                faults.push((place.clone(), reason.to_owned()));
            }
            for event in events {
                let name = &event.event;
                match identify_event(&loaded.study, &event.driver, name, &event.log, &options) {
                    Ok(fit) => fits.push(fit),
                    Err(fault) => {
                        faults.push((format!("event `{name}` of {place}"), fault.to_string()));
                    }
                }
            }
        }
    }
    if fits.is_empty() && !faults.is_empty() {
        let (place, reason) = faults.remove(0);
        return Err(Failure::NoEvent { place, reason });
    }
    for (place, reason) in &faults {
        output::note(&format!("warning: {place} is left out: {reason}"));
    }
    let population = Population::of(&fits);
    if arguments.json {
        let left_out: Vec<_> = faults
            .iter()
            .map(|(place, reason)| json!({ "place": place, "reason": reason }))
            .collect();
        let answer = json!({
            "study": arguments.study,
            "options": options,
            "fits": fits,
            "population": population,
            "left_out": left_out,
        });
        return output::answer(&format!("{answer}\n"));
    }
    output::answer(&identify_text::text(&fits, population.as_ref()))
}

fn options(arguments: &IdentifyArguments) -> Result<IdentifyOptions, Failure> {
    let standard = IdentifyOptions::default();
    let range = |name: &str, given: Option<&Vec<f64>>, standard: [f64; 2], least: f64| {
        let Some(ends) = given else { return Ok(standard) };
        if !(ends[0] >= least && ends[1] > ends[0] && ends[1].is_finite()) {
            let allowed = format!("the bounds of --{name} have to rise, from {least} on");
            return Err(request::usage(&allowed));
        }
        Ok([ends[0], ends[1]])
    };
    Ok(IdentifyOptions {
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
        proportional: range("kp", arguments.kp.as_ref(), standard.proportional, 1e-3)?,
        integral: range("ki", arguments.ki.as_ref(), standard.integral, 1e-6)?,
        derivative: range("kd", arguments.kd.as_ref(), standard.derivative, 0.0)?,
        ..standard
    })
}
