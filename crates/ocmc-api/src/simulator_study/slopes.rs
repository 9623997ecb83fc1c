//! The slopes of the recorded drives, and the gains that are identified on them.

use super::recorded::Signals;
use ocmc_core::study::Study;
use ocmc_estimation::identification::closed_loop::{ClosedLoop, Controller};
use ocmc_estimation::identification::event::PedalLog;
use ocmc_estimation::identification::identify::{EventFit, identify_event};
use ocmc_estimation::identification::options::IdentifyOptions;
use ocmc_io::report::{DriveSeries, SimulatorEvent};
use std::ops::Range;
use std::sync::atomic::AtomicBool;

/// An event begins so long before its slope, and goes on so long behind it, in s: behind that
/// drivers who brake softly begin to brake for what comes next, 350 m behind the slope.
const BEFORE_S: f64 = 5.0;
const AFTER_S: f64 = 8.0;

/// A slope of a driver.
pub(super) struct Slope {
    driver: usize,
    name: String,
    log: PedalLog,
    wanted_mps: f64,
    gains: [f64; 3],
}

/// The slopes of drives.
pub(super) fn of(drives: &[(usize, Signals)]) -> Vec<Slope> {
    let slopes = drives.iter().flat_map(|(driver, signals)| {
        let events = signals.log.slope_events(BEFORE_S, AFTER_S).into_iter();
        events.map(|(name, rows)| Slope {
            driver: *driver,
            name,
            log: signals.log.part(rows.start, rows.end),
            wanted_mps: signals.wanted_mps,
            gains: signals.gains,
        })
    });
    slopes.collect()
}

/// Identifies the driver of each slope; those that cannot be are left out.
pub(super) fn identified(
    study: &Study,
    slopes: Vec<Slope>,
    options: &IdentifyOptions,
    stop: &AtomicBool,
    done: &mut dyn FnMut(usize),
) -> Vec<SimulatorEvent> {
    let mut events = Vec::with_capacity(slopes.len());
    for (k, slope) in slopes.into_iter().enumerate() {
        let driver = slope.driver.to_string();
        let fit = identify_event(study, &driver, &slope.name, &slope.log, options, stop);
        events.extend(fit.ok().map(|fit| event(study, slope, &fit, options)));
        done(k + 1);
    }
    events
}

fn event(study: &Study, slope: Slope, fit: &EventFit, options: &IdentifyOptions) -> SimulatorEvent {
    let value_of = |name: &str| fit.parameter(name).map(|parameter| parameter.value);
    let closed = ClosedLoop::new(study, &slope.log);
    let driven = closed.drive(&Controller {
        proportional: fit.kp,
        integral: fit.ki.unwrap_or(0.0),
        derivative: fit.kd.unwrap_or(0.0),
        set_speed_mps: fit.set_speed_mps,
        start: value_of("start_integral").unwrap_or(0.0),
        start_speed_mps: value_of("start_speed_mps").unwrap_or(closed.rolling.speed_mps),
        ..Controller::default()
    });
    let recorded = series(&slope.log, 0..slope.log.time_s.len());
    let start_m = recorded.position_m.first().copied().unwrap_or(0.0);
    let simulated = PedalLog {
        time_s: driven.time_s,
        speed_mps: driven.speed_mps,
        accelerator: driven.accelerator,
        brake: driven.brake,
        ..PedalLog::default()
    };
    let way_m = simulated.positions_m().into_iter().map(|at_m| at_m + start_m).collect();
    let simulated = PedalLog { position_m: Some(way_m), ..simulated };
    SimulatorEvent {
        driver: slope.driver,
        event: slope.name,
        grade: fit.grade,
        gains: [fit.kp, fit.ki.unwrap_or(f64::NAN), fit.kd.unwrap_or(f64::NAN)],
        true_gains: slope.gains,
        bounds: [options.proportional[1], options.integral[1], options.derivative[1]],
        at_bound: fit.at_bound.clone(),
        set_speed_mps: fit.set_speed_mps,
        wanted_mps: slope.wanted_mps,
        recorded,
        simulated: series(&simulated, 0..simulated.time_s.len()),
    }
}

/// The signals of a log over the way.
pub(super) fn series(log: &PedalLog, rows: Range<usize>) -> DriveSeries {
    DriveSeries {
        position_m: log.positions_m()[rows.clone()].to_vec(),
        speed_mps: log.speed_mps[rows.clone()].to_vec(),
        accelerator: log.accelerator[rows.clone()].to_vec(),
        brake: log.brake[rows].to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator_study::recorded::Recorded;
    use ocmc_estimation::identification::options::{SpeedTerm, Unknowns};

    #[test]
    fn a_driver_comes_back_from_one_slope_and_drives_it_alike() {
        let study = ocmc_io::study::load::<&str>("simulator-study", &[]).unwrap().study;
        let signals = Recorded::of(&study, 1, 0, true).unwrap().signals.unwrap();
        let mut slopes = of(&[(1, signals)]);
        let names: Vec<&str> = slopes.iter().map(|slope| slope.name.as_str()).collect();
        assert_eq!(names, ["+5.5 %", "-5.5 %", "+1.5 %", "-1.5 %", "+3.5 %", "-3.5 %"]);
        slopes.retain(|slope| slope.name == "-1.5 %");
        let speed_term = SpeedTerm::None;
        let options = IdentifyOptions {
            speed_term,
            unknown: Unknowns::NONE,
            intervals: false,
            starts: 4,
            ..IdentifyOptions::default()
        };
        let stop = AtomicBool::new(false);
        let event = identified(&study, slopes, &options, &stop, &mut |_| ()).remove(0);
        for k in 0..2 {
            let error = event.gains[k] / event.true_gains[k] - 1.0;
            assert!(error.abs() < 0.02, "{:?} for {:?}", event.gains, event.true_gains);
        }
        assert!((event.set_speed_mps - event.wanted_mps).abs() < 0.05);
        let last = |series: &DriveSeries| series.speed_mps[series.speed_mps.len() - 1];
        assert!((last(&event.recorded) - last(&event.simulated)).abs() < 0.05);
    }
}
