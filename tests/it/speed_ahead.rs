//! Events of identification end where something ahead may set the speed: checked against the speed
//! that the simulated drivers want.

use ocmc_core::kernel::drive::trace::trace;
use ocmc_core::study::Study;
use ocmc_estimation::identification::event::PedalLog;
use ocmc_estimation::identification::identify::identify_event;
use ocmc_estimation::identification::options::{IdentifyOptions, Unknowns};
use ocmc_estimation::identification::speed_ahead::until_speed_is_set;
use std::sync::atomic::AtomicBool;

/// The trace of a driver as a log, and the speed that he wants in each row.
fn logged(study: &Study, seed: u64, driver: u64) -> (PedalLog, Vec<f64>) {
    let trace = trace(study, seed, driver);
    let column = |name: &str| {
        let found = trace.columns.iter().find(|column| column.name == name);
        found.expect("a column of the trace").values.clone()
    };
    let (speed_mps, yaw_radps) = (column("speed_mps"), column("yaw_rate_radps"));
    let curvature = |(yaw, speed): (&f64, &f64)| yaw / speed.max(2.0);
    let log = PedalLog {
        time_s: column("time_s"),
        accelerator: column("accelerator"),
        brake: column("brake"),
        grade: column("grade"),
        position_m: Some(column("position_m")),
        gear: Some(column("gear")),
        limit_mps: Some(column("limit_mps")),
        curvature_per_m: Some(yaw_radps.iter().zip(&speed_mps).map(curvature).collect()),
        speed_mps,
        ..PedalLog::default()
    };
    (log, column("desired_speed_mps"))
}

#[test]
fn an_event_ends_where_something_ahead_may_set_the_speed() {
    let set = ["simulation.step_s=0.1"];
    let study = ocmc_io::study::load("simulator-study", &set).expect("it is built in").study;
    let (mut all, mut without, mut cut, mut shown) = (0, 0, 0, 0);
    for driver in 0..16 {
        let (log, wanted_mps) = logged(&study, 3, driver);
        let blind = PedalLog { limit_mps: None, curvature_per_m: None, ..log.clone() };
        for (_, rows) in log.slope_events(5.0, 18.0) {
            let is_one = |part: &PedalLog| {
                let first = log.time_s.partition_point(|at_s| *at_s < part.time_s[0]);
                let wanted = &wanted_mps[first..first + part.time_s.len()];
                wanted.iter().all(|speed_mps| (speed_mps - wanted[0]).abs() < 1e-6)
            };
            let whole = log.part(rows.start, rows.end);
            let with = until_speed_is_set(&log, &rows, &study);
            assert!(is_one(&with), "driver {driver}: {:?}", with.ended_by);
            assert!(with.duration_s() > 22.0, "driver {driver}: {} s", with.duration_s());
            let seen = until_speed_is_set(&blind, &rows, &study);
            all += 1;
            without += usize::from(!is_one(&whole));
            cut += usize::from(with.ended_by.is_some());
            shown += usize::from(is_one(&seen));
            // what needs no cut by the columns is hardly ever cut by what the speed shows
            assert!(seen.duration_s() > 12.0, "driver {driver}: {} s", seen.duration_s());
        }
    }
    println!("{all} events, {without} with two speeds, {cut} cut; {shown} with one, seen alone");
    assert!(all == 96 && without >= 16 && cut < all / 2);
    assert!(shown as f64 >= 0.85 * all as f64, "{shown} of {all}");
}

#[test]
fn gains_come_back_between_limits_and_curves_and_after_a_shift() {
    let set = ["simulation.step_s=0.1"];
    let study = ocmc_io::study::load("simulator-study", &set).expect("it is built in").study;
    let options = IdentifyOptions {
        unknown: Unknowns::NONE,
        intervals: false,
        starts: 4,
        ..IdentifyOptions::default()
    };
    let stay = AtomicBool::new(false);
    // an upshift shortly before the climb of 5.5 % keeps the gear for 12 s
    let (log, _) = logged(&study, 11, 4);
    let truth = study.sample(11, 4).driver.pedals;
    for (event, rows) in log.slope_events(5.0, 18.0) {
        let part = until_speed_is_set(&log, &rows, &study);
        let fit = identify_event(&study, "4", &event, &part, &options, &stay).expect("a log");
        let ki = fit.ki.expect("a PID has one");
        let errors = [fit.kp / truth.proportional - 1.0, ki / truth.integral - 1.0];
        assert!(errors.iter().all(|error| error.abs() < 0.01), "{event}: {errors:?}");
        assert!(fit.no_intervals.is_empty(), "{event}: {:?}", fit.no_intervals);
        let says = fit.warnings.iter().any(|warning| warning.contains("it ends after"));
        assert_eq!(says, part.ended_by.is_some());
    }
}
