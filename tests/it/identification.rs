//! The virtual simulator study: drivers on six slopes, their traces taken as logs, their gains
//! identified.
//!
//! Prints the figures of `docs/src/theory/identification.md`, of a part of the drivers:
//! `cargo test --test it identification -- --nocapture`. The whole study, with noise on all signals
//! and over hundreds of events, is `examples/identification_study.rs`.

use ocmc_core::kernel::drive::trace::trace;
use ocmc_core::random::{Draws, Stream};
use ocmc_core::study::Study;
use ocmc_estimation::identification::closed_loop::{ClosedLoop, Controller};
use ocmc_estimation::identification::event::PedalLog;
use ocmc_estimation::identification::identify::{EventFit, identify_event};
use ocmc_estimation::identification::one_truck::{NamedEvent, identify_log};
use ocmc_estimation::identification::options::{
    ControllerKind, IdentifyOptions, SpeedTerm, Unknowns,
};
use ocmc_estimation::identification::population::Population;
use std::sync::atomic::AtomicBool;

const DRIVERS: u64 = 3;
static STAY: AtomicBool = AtomicBool::new(false);

/// An event of a driver whose gains are known.
struct Known {
    driver: u64,
    event: String,
    log: PedalLog,
    kp: f64,
    ki: f64,
    kd: f64,
    threshold_mps: f64,
    set_speed_mps: f64,
}

fn study(sets: &[&str]) -> Study {
    ocmc_io::study::load("simulator-slopes", sets).unwrap_or_else(|e| panic!("{e}")).study
}

/// The events of the drivers of a study, with noise on the pedals.
fn events(study: &Study, drivers: u64, noise: f64) -> Vec<Known> {
    let mut events = Vec::new();
    for driver in 0..drivers {
        let trace = trace(study, 1, driver);
        let gains = study.sample(1, driver).driver.pedals;
        let column =
            |name: &str| trace.columns.iter().find(|c| c.name == name).unwrap().values.clone();
        let mut draws = Draws::new(1, driver, Stream::Pedals);
        let mut noisy = |name| -> Vec<f64> {
            column(name).iter().map(|value| value + noise * draws.normal()).collect()
        };
        let log = PedalLog {
            time_s: column("time_s"),
            speed_mps: column("speed_mps"),
            accelerator: noisy("accelerator"),
            brake: noisy("brake"),
            grade: column("grade"),
            position_m: Some(column("position_m")),
            gear: Some(column("gear")),
            ..PedalLog::default()
        };
        for (event, rows) in log.slope_events(5.0, 18.0) {
            events.push(Known {
                driver,
                event,
                set_speed_mps: column("desired_speed_mps")[rows.start],
                log: log.part(rows.start, rows.end),
                kp: gains.proportional,
                ki: gains.integral,
                kd: gains.derivative,
                threshold_mps: gains.threshold_mps.unwrap_or(f64::NAN),
            });
        }
    }
    assert_eq!(events.len(), 6 * drivers as usize);
    events
}

fn fit(study: &Study, known: &Known, options: &IdentifyOptions) -> EventFit {
    identify_event(study, &known.driver.to_string(), &known.event, &known.log, options, &STAY)
        .unwrap()
}

/// Error of a gain, in percent.
fn percent(found: f64, known: f64) -> f64 {
    100.0 * (found / known - 1.0)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The truck is the study's, and the driver reacts at once.
fn known_truck() -> IdentifyOptions {
    IdentifyOptions { unknown: Unknowns::NONE, ..IdentifyOptions::default() }
}

fn without_speed_term(intervals: bool) -> IdentifyOptions {
    IdentifyOptions { intervals, ..known_truck() }
}

#[test]
fn noise_free_gains_come_back() {
    let study = study(&[]);
    let options = without_speed_term(false);
    println!("| driver, event | K_P | K_I | K_D | rms | pressed |");
    println!("|---|---|---|---|---|---|");
    let (mut free, mut failed, mut determined) = (0, Vec::new(), 0);
    let mut fits = Vec::new();
    for known in events(&study, DRIVERS, 0.0) {
        let fit = fit(&study, &known, &options);
        let (kp, ki, kd) = (
            percent(fit.kp, known.kp),
            percent(fit.ki.unwrap(), known.ki),
            percent(fit.kd.unwrap(), known.kd),
        );
        println!(
            "| {}, {} | {kp:+.2} % | {ki:+.2} % | {kd:+.1} % | {:.5} | {:.1} s |",
            known.driver, known.event, fit.pedal_rms, fit.saturated_s,
        );
        if fit.saturated_s == 0.0 {
            free += 1;
            let determines_kd = !fit.not_identifiable.contains(&"kd");
            determined += usize::from(determines_kd);
            if !(kp.abs() < 1.0 && ki.abs() < 1.0 && (kd.abs() < 1.0 || !determines_kd)) {
                failed.push(format!("{}, {}", known.driver, known.event));
            }
        }
        fits.push(fit);
    }
    println!(
        "{free} events without a fully pressed pedal; K_D is determined in {determined} of them"
    );
    // an upshift that waits for power comes where a step ends, and the log of a trip has other
    // steps than its event: in one of 30, of eight drivers, that is seen
    assert!(free as u64 >= 3 * DRIVERS && failed.len() <= 1, "{failed:?} of {free}");
    assert!(determined as f64 >= 0.75 * free as f64);
    let population = Population::of(&fits).unwrap();
    println!("{population:?}");
    let known: Vec<f64> =
        (0..DRIVERS).map(|k| study.sample(1, k).driver.pedals.proportional.ln()).collect();
    let mean = known.iter().sum::<f64>() / DRIVERS as f64;
    assert!((population.proportional_median.ln() - mean).abs() < 0.02);
}

#[test]
fn uphill_runs_to_the_bounds_and_downhill_does_not() {
    // the slope alone, as a fit to the event sees it: uphill the pedal is on the floor nearly all
    // the time
    let study = study(&[]);
    let options = IdentifyOptions { starts: 4, ..without_speed_term(true) };
    let (mut uphill, mut downhill) = (Vec::new(), Vec::new());
    for known in events(&study, 4, 0.02) {
        if !["+5.5 %", "-3.5 %", "-5.5 %"].contains(&known.event.as_str()) {
            continue;
        }
        let slope: Vec<usize> =
            (0..known.log.grade.len()).filter(|&k| known.log.grade[k].abs() > 0.005).collect();
        let log = known.log.part(slope[0], slope[slope.len() - 1] + 1);
        let fit = identify_event(&study, "", &known.event, &log, &options, &STAY).unwrap();
        let lost = !fit.at_bound.is_empty()
            || fit.not_identifiable.iter().any(|name| *name == "kp" || *name == "ki");
        match known.event.as_str() {
            "+5.5 %" => uphill.push(lost),
            "-3.5 %" | "-5.5 %" => downhill.push([fit.not_identifiable.contains(&"kp"), lost]),
            _ => {}
        }
    }
    println!("K_P or K_I lost uphill: {uphill:?}; K_P, either downhill: {downhill:?}");
    let share =
        |values: &[bool]| values.iter().filter(|lost| **lost).count() as f64 / values.len() as f64;
    let downhill: Vec<bool> = downhill.iter().map(|lost: &[bool; 2]| lost[0]).collect();
    assert!(share(&uphill) >= 0.75 && share(&downhill) <= 0.25);
}

#[test]
fn the_speed_term_pulls_the_gains() {
    let study = study(&[]);
    println!("| speed term | bias of K_P, median and range | bias of K_I |");
    println!("|---|---|---|");
    let known: Vec<Known> = events(&study, 3, 0.0)
        .into_iter()
        .filter(|known| known.log.accelerator.iter().all(|pedal| *pedal < 0.99))
        .collect();
    let mut worst = Vec::new();
    for speed_term in [SpeedTerm::None, SpeedTerm::Measured, SpeedTerm::Simulated] {
        let options = IdentifyOptions { speed_term, intervals: false, starts: 4, ..known_truck() };
        let fits: Vec<EventFit> = known.iter().map(|known| fit(&study, known, &options)).collect();
        let bias = |of: &dyn Fn(&EventFit, &Known) -> f64| -> Vec<f64> {
            fits.iter().zip(&known).map(|(fit, known)| of(fit, known)).collect()
        };
        let kp = bias(&|fit, known| percent(fit.kp, known.kp));
        let ki = bias(&|fit, known| percent(fit.ki.unwrap(), known.ki));
        let range = |values: &[f64]| {
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            format!("{:+.2} % ({low:+.2} to {high:+.2})", median(values.to_vec()))
        };
        println!("| {speed_term:?} | {} | {} |", range(&kp), range(&ki));
        worst.push(median(ki.iter().map(|error| error.abs()).collect()));
    }
    // both readings of the paper bias the gains; without the term they come back
    assert!(worst[0] < 0.5 && worst[1] > 2.0 && worst[2] > 2.0, "{worst:?}");
}

#[test]
fn switched_drivers_come_back() {
    let study = study(&["driver.pedals.pid_share=0.0"]);
    let options = IdentifyOptions {
        controller: ControllerKind::Switched,
        starts: 12,
        ..without_speed_term(false)
    };
    println!("| driver, event | K_P | threshold | set speed | pressed | rms |");
    println!("|---|---|---|---|---|---|");
    let (mut good, mut all) = (0, 0);
    for known in events(&study, 2, 0.0) {
        if known.log.accelerator.iter().any(|pedal| *pedal >= 0.99) {
            continue;
        }
        let fit = fit(&study, &known, &options);
        let kp = percent(fit.kp, known.kp);
        println!(
            "| {}, {} | {kp:+.2} % | {:.3} for {:.3} m/s | {:+.3} m/s | {:.1} s | {:.4} |",
            known.driver,
            known.event,
            fit.threshold_mps.unwrap(),
            known.threshold_mps,
            fit.set_speed_mps - known.set_speed_mps,
            fit.saturated_s,
            fit.pedal_rms,
        );
        all += 1;
        good += usize::from(kp.abs() < 2.0);
    }
    // where the driver holds a pedal when the event begins, a log does not tell since when
    assert!(all >= 5 && good as f64 >= 0.7 * all as f64, "{good} of {all}");
}

/// Adds white noise to all signals of an event: pedals 0.02, speed and slope 2 % of their range.
fn noisy(known: &mut Known, seed: u64) {
    let mut draws = Draws::new(seed, known.driver, Stream::SpeedChange);
    let range = |values: &[f64]| {
        let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        highest - values.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let log = &mut known.log;
    let sds = [0.02, 0.02, 0.02 * range(&log.speed_mps), 0.02 * range(&log.grade)];
    for (column, sd) in [&mut log.accelerator, &mut log.brake, &mut log.speed_mps, &mut log.grade]
        .into_iter()
        .zip(sds)
    {
        for value in column.iter_mut() {
            *value += sd * draws.normal();
        }
    }
}

/// Intervals that hold a gain, and all of them.
fn held(fit: &EventFit, known: &Known) -> [usize; 2] {
    let gains = [("kp", known.kp), ("ki", known.ki), ("kd", known.kd)];
    let within = gains.iter().filter_map(|(name, truth)| {
        let [low, high] = fit.parameter(name)?.interval?;
        Some(usize::from((low..=high).contains(truth)))
    });
    within.fold([0, 0], |[holds, all], within| [holds + within, all + 1])
}

#[test]
fn noise_on_all_signals_is_covered() {
    let study = study(&[]);
    let (mut holds, mut all, mut refused, mut errors) = (0, 0, 0, Vec::new());
    for mut known in events(&study, 3, 0.0) {
        noisy(&mut known, 21);
        let fit = fit(&study, &known, &IdentifyOptions { starts: 4, ..known_truck() });
        let [inside, intervals] = held(&fit, &known);
        (holds, all) = (holds + inside, all + intervals);
        refused += usize::from(intervals == 0);
        errors.push(percent(fit.kp, known.kp));
    }
    println!("{holds} of {all} gains within their intervals, {refused} of 18 events without");
    // at 95 % fewer than 85 % of 40 and more come once in a hundred times
    assert!(all >= 30 && refused <= 8, "{all} intervals, {refused} without");
    assert!(holds as f64 >= 0.85 * all as f64, "{holds} of {all}");
    assert!(median(errors).abs() < 2.0);
}

/// The same event with a driver who sees the speed so much late.
fn driven_late(study: &Study, known: &Known, delay_s: f64) -> PedalLog {
    let closed = ClosedLoop::new(study, &known.log);
    let start_speed_mps = known.log.speed_mps[0];
    let series = closed.drive(&Controller {
        proportional: known.kp,
        integral: known.ki,
        derivative: known.kd,
        set_speed_mps: known.set_speed_mps,
        start: closed.start_output - known.kp * (known.set_speed_mps - start_speed_mps),
        start_speed_mps,
        delay_s,
        ..Controller::default()
    });
    let mut late = PedalLog {
        last_shift: known.log.last_shift,
        time_s: series.time_s,
        speed_mps: series.speed_mps,
        accelerator: series.accelerator,
        brake: series.brake,
        ..PedalLog::default()
    };
    let from_m = known.log.positions_m();
    let way_m: Vec<f64> = late.positions_m().iter().map(|at_m| at_m + from_m[0]).collect();
    let slope = |at_m: &f64| {
        let row = from_m.partition_point(|known_m| known_m < at_m);
        known.log.grade[row.min(known.log.grade.len() - 1)]
    };
    late.grade = way_m.iter().map(slope).collect();
    late.gear = known.log.gear.as_ref().map(|gear| vec![gear[0]; way_m.len()]);
    late.position_m = Some(way_m);
    late
}

#[test]
fn drivers_side_by_side_drive_as_each_would_alone() {
    let study = study(&[]);
    let known = &events(&study, 1, 0.0)[0];
    let closed = ClosedLoop::new(&study, &known.log);
    // more than the lanes of two blocks, some late or heavy: they end at other steps
    let controller = |k: u32| Controller {
        proportional: known.kp * (0.5 + 0.1 * f64::from(k)),
        integral: known.ki,
        set_speed_mps: known.set_speed_mps + 0.2 * f64::from(k % 3),
        start: closed.start_output,
        start_speed_mps: known.log.speed_mps[0],
        delay_s: if k % 4 == 1 { 0.3 } else { 0.0 },
        mass_kg: (k % 5 == 2).then_some(30_000.0),
        ..Controller::default()
    };
    let controllers: Vec<Controller> = (0..21).map(controller).collect();
    let together = closed.drive_each(&controllers);
    let alone: Vec<_> = controllers.iter().map(|controller| closed.drive(controller)).collect();
    assert!(alone.windows(2).all(|pair| pair[0] != pair[1] && !pair[0].time_s.is_empty()));
    assert!(together == alone);
    assert!(closed.drive_each(&[]).is_empty());
}

#[test]
fn noise_moves_a_gain_of_zero_to_both_sides() {
    let study = study(&[]);
    let options = IdentifyOptions { starts: 4, ..known_truck() };
    let known = events(&study, 1, 0.0).into_iter().find(|known| known.event == "-3.5 %");
    let mut known = Known { kd: 0.0, ..known.expect("it is in Table I") };
    let clean = driven_late(&study, &known, 0.0);
    let mut found = Vec::new();
    for sign in [1.0, -1.0] {
        let mut draws = Draws::new(26, 0, Stream::SpeedChange);
        known.log = clean.clone();
        for pedal in [&mut known.log.accelerator, &mut known.log.brake] {
            for value in pedal.iter_mut() {
                *value += sign * 0.02 * draws.normal();
            }
        }
        let fit = fit(&study, &known, &options);
        assert!(fit.no_intervals.is_empty(), "{:?}", fit.no_intervals);
        let gain = fit.parameter("kd").expect("a PID has one");
        let [low, high] = gain.interval.expect("nothing is against it");
        println!("K_D = {:.4} ({low:.4}; {high:.4})", gain.value);
        assert!(!gain.at_bound && low < gain.value && gain.value < high);
        let says = fit.warnings.iter().any(|warning| warning.contains("came out below 0"));
        assert_eq!(says, gain.value < 0.0);
        found.push(gain.value);
    }
    let [a, b] = found[..] else { panic!("{found:?}") };
    // with a box that ends at 0 one of them would stand there, and their sum be the other one
    assert!(a.min(b) < 0.0 && (a + b).abs() < 0.6 * a.max(b), "{found:?}");
}

#[test]
fn a_late_driver_is_found_or_refused() {
    let study = study(&[]);
    let options = IdentifyOptions { starts: 4, ..known_truck() };
    let asked = Unknowns { delay: true, ..Unknowns::NONE };
    let mut found = Vec::new();
    for mut known in events(&study, 1, 0.0) {
        known.log = driven_late(&study, &known, 0.5);
        let clean = known.log.clone();
        noisy(&mut known, 22);
        let refused = fit(&study, &known, &options);
        assert!(!refused.no_intervals.is_empty(), "{}: {:?}", known.event, refused.test);
        assert!(refused.parameters.iter().all(|parameter| parameter.interval.is_none()));
        if known.event.starts_with('-') {
            let without = IdentifyOptions { unknown: asked, intervals: false, ..options };
            known.log = clean;
            let fit = fit(&study, &known, &without);
            println!(
                "{} {}: {:.3} s, K_P {:+.2} %, K_I {:+.2} %, K_D {:+.1} %",
                known.driver,
                known.event,
                fit.delay_s.unwrap(),
                percent(fit.kp, known.kp),
                percent(fit.ki.unwrap(), known.ki),
                percent(fit.kd.unwrap(), known.kd),
            );
            found.push((fit.delay_s.unwrap() - 0.5).abs());
            assert!(percent(fit.kp, known.kp).abs() < 2.0);
        }
    }
    assert!(found.len() == 3 && median(found.clone()) < 0.02, "{found:?}");
}

#[test]
fn a_wrong_mass_is_refused_and_found() {
    let beyond_the_law = "vehicle.gross_mass_limit_kg=60000";
    let heavy = study(&["mission.payload_kg=31300", beyond_the_law]);
    let study = study(&[]);
    let [heavy_kg, mass_kg] = [&heavy, &study].map(|study| study.sample(1, 0).vehicle.mass_kg);
    assert!((heavy_kg - mass_kg - 7000.0).abs() < 1.0, "{heavy_kg} {mass_kg}");
    let options = IdentifyOptions { starts: 4, ..known_truck() };
    let unknown = Unknowns { mass: true, ..Unknowns::NONE };
    let mut errors = Vec::new();
    for mut known in events(&heavy, 1, 0.0) {
        noisy(&mut known, 23);
        let refused = fit(&study, &known, &options);
        let bare = refused.no_intervals.len();
        assert!(bare > 0, "{}: {:?}", known.event, refused.test);
        if known.event.contains("1.5") {
            continue;
        }
        let without = IdentifyOptions { unknown, intervals: false, ..options };
        let found = fit(&study, &known, &without);
        println!("{}: {bare} misfits, {:.0} kg", known.event, found.mass_kg.unwrap());
        errors.push(found.mass_kg.unwrap() / heavy_kg - 1.0);
    }
    assert!(median(errors.iter().map(|error: &f64| error.abs()).collect()) < 0.02, "{errors:?}");
}

#[test]
fn gains_are_covered_whatever_truck_was_driven() {
    let sets = [
        "mission.payload_kg=32300",
        "vehicle.gross_mass_limit_kg=60000",
        "vehicle.rolling_factor=1.1",
        "vehicle.drag_area_m2=5.83",
    ];
    let (driven, study) = (study(&sets), study(&[]));
    let options = IdentifyOptions { starts: 4, ..IdentifyOptions::default() };
    let mut events = events(&driven, 1, 0.0);
    for known in &mut events {
        known.log = driven_late(&driven, known, 0.2);
        noisy(known, 25);
    }
    let named = |known: &Known| NamedEvent {
        driver: "0".to_owned(),
        event: known.event.clone(),
        log: known.log.clone(),
    };
    let named: Vec<NamedEvent> = events.iter().map(named).collect();
    let found = identify_log(&study, &named, &options, &STAY, &mut || ());
    let (mut holds, mut all, mut given) = (0, 0, 0);
    for (fit, known) in found.fits.iter().zip(&events) {
        let fit = fit.as_ref().expect("each event can be fitted");
        let [inside, intervals] = held(fit, known);
        println!("{}: {inside} of {intervals}, {:?} kg", known.event, fit.mass_kg);
        (holds, all) = (holds + inside, all + intervals);
        given += usize::from(intervals > 0);
    }
    let [mass_kg, error_kg] = found.mass_kg.expect("six events");
    println!("{holds} of {all} gains within their intervals, {mass_kg:.0} ± {error_kg:.0} kg");
    // a truck of 48 t for one of 40 t, 10 % more resistance, 0.2 s late: at 95 % two of eighteen
    // and more are outside in one of four logs, three in 6 %
    assert!(given >= 4 && holds + 2 >= all, "{holds} of {all}, {given} events");
    assert!((mass_kg - 48e3).abs() < 3.0 * error_kg && error_kg < 3e3, "{mass_kg} ± {error_kg}");
}

#[test]
fn noise_of_the_slope_alone_gives_no_interval_that_is_too_short() {
    let study = study(&[]);
    let options = IdentifyOptions { starts: 4, ..known_truck() };
    let (mut holds, mut all) = (0, 0);
    for mut known in events(&study, 1, 0.0) {
        let mut draws = Draws::new(24, known.driver, Stream::SpeedChange);
        known.log.grade.iter_mut().for_each(|grade| *grade += 0.002 * draws.normal());
        let fit = fit(&study, &known, &options);
        assert!(fit.warnings.iter().any(|warning| warning.contains("the slope scatters")));
        let [inside, intervals] = held(&fit, &known);
        (holds, all) = (holds + inside, all + intervals);
    }
    println!("{holds} of {all} gains within their intervals");
    assert!(holds as f64 >= 0.85 * all as f64, "{holds} of {all}");
}
