//! `ocmc identify`: the pedal gains of drivers, one fit for each driver and event.

use crate::arguments::{ControllerName, IdentifyArguments, SpeedTermName};
use crate::failure::Failure;
use crate::fit::sources;
use crate::output::{self, warn};
use crate::progress::shown;
use ocmc_api::{
    Answer, ControllerKind, IdentifyOptions, IdentifyRequest, SpeedTerm, mappings, study,
};

/// Fits each event of each log, and the population behind them.
pub(crate) fn identify(arguments: &IdentifyArguments) -> Result<(), Failure> {
    let request = IdentifyRequest {
        logs: &sources(&arguments.files.logs),
        study: &study::load(&arguments.study, &arguments.set)?,
        mappings: mappings(&arguments.files.map)?,
        options: options(arguments),
        warn_of_rows: !arguments.quiet,
    };
    let answer = shown(arguments.quiet, |watch| ocmc_api::identify(&request, &mut warn, watch))?;
    if !arguments.quiet {
        answer.warnings().iter().for_each(|warning| warn(warning));
    }
    output::answer(&if arguments.json { format!("{}\n", answer.to_json()) } else { answer.text() })
}

fn options(arguments: &IdentifyArguments) -> IdentifyOptions {
    let standard = IdentifyOptions::default();
    let range = |given: Option<&Vec<f64>>, standard: [f64; 2]| {
        given.map_or(standard, |ends| [ends[0], ends[1]])
    };
    IdentifyOptions {
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
    }
}
