//! The events of one log, all driven with the same truck: each is fitted with what the others say
//! of its mass.
//!
//! Every event is identified twice. The first fits tell the mass of the truck, each by itself. For
//! the second fit of an event it is expected at the median of the other ones. A median, since
//! shifts of the gearbox leave wrong optima, whose masses are far off and look certain. Its
//! standard error is the median of the stated ones, or what the masses scatter by (their median
//! absolute deviation over 0.6745), whichever is larger. No root of their number is taken: what is
//! expected of resistance and delay draws all of them to the same side. It is at least 1 % of the
//! mass, for the truck of the closed loop is not exactly the one that was driven (a judgement).

use super::event::{EventError, PedalLog};
use super::identify::{EventFit, identified};
use super::noise::{MEDIAN_ABSOLUTE, median};
use super::options::IdentifyOptions;
use ocmc_core::study::Study;
use ocmc_fleet::run::pool;
use std::sync::atomic::AtomicBool;

/// Fewest other events whose masses are taken.
const FEWEST: usize = 3;
/// Smallest standard error of a mass, as a share of it.
const LEAST_SHARE: f64 = 0.01;

/// The log of an event, with its names.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedEvent {
    /// The driver.
    pub driver: String,
    /// The event.
    pub event: String,
    /// Its log.
    pub log: PedalLog,
}

/// Fits of the events of one log, and the mass that they agree on.
#[derive(Debug, Default)]
pub struct LogFit {
    /// The fit of each event, in their order; fewer where it was stopped.
    pub fits: Vec<Result<EventFit, EventError>>,
    /// Mass of the truck by all events, in kg, and its standard error; none where too few tell it.
    pub mass_kg: Option<[f64; 2]>,
}

/// Identifies the events of one truck; `done` counts them.
pub fn identify_log(
    study: &Study,
    events: &[NamedEvent],
    options: &IdentifyOptions,
    stop: &AtomicBool,
    done: &mut dyn FnMut(),
) -> LogFit {
    let fit = |event: &NamedEvent, options: &IdentifyOptions, mass: Option<[f64; 2]>| {
        let names = [&event.driver[..], &event.event];
        pool(options.threads).install(|| identified(study, names, &event.log, options, mass, stop))
    };
    let together = options.unknown.mass && events.len() > FEWEST;
    let first_options = IdentifyOptions { intervals: false, ..*options };
    let masses: Vec<Option<[f64; 2]>> = if together {
        events.iter().map(|event| fit(event, &first_options, None).ok()?.1).collect()
    } else {
        Vec::new()
    };
    let mut log_fit = LogFit { mass_kg: of_all(masses.iter().flatten()), ..LogFit::default() };
    for (k, event) in events.iter().enumerate() {
        let others = masses.iter().enumerate().filter(|(other, _)| *other != k);
        let answer = fit(event, options, of_all(others.filter_map(|(_, mass)| mass.as_ref())));
        let stopped = matches!(answer, Err(EventError::Stopped));
        if stopped {
            return log_fit;
        }
        log_fit.fits.push(answer.map(|(fit, _)| fit));
        done();
    }
    log_fit
}

/// The mass by some events, and its standard error; none where they are too few.
fn of_all<'a>(masses: impl Iterator<Item = &'a [f64; 2]>) -> Option<[f64; 2]> {
    let (values, errors): (Vec<f64>, Vec<f64>) = masses.map(|&[mass, error]| (mass, error)).unzip();
    if values.len() < FEWEST {
        return None;
    }
    let middle = median(values.clone());
    let away = median(values.iter().map(|mass| (mass - middle).abs()).collect());
    let error = median(errors).max(away / MEDIAN_ABSOLUTE);
    Some([middle, error.max(LEAST_SHARE * middle)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_wrong_optimum_does_not_move_the_mass_of_all() {
        let right = [[48e3, 1500.0], [47e3, 1500.0], [48.5e3, 1500.0], [47.5e3, 1500.0]];
        let wrong = [[42e3, 100.0]];
        let [mass_kg, error_kg] = of_all(right.iter().chain(&wrong)).expect("five are enough");
        assert!(mass_kg == 47.5e3 && error_kg == 1500.0, "{mass_kg} {error_kg}");
        assert_eq!(of_all(right[..2].iter()), None);
    }
}
