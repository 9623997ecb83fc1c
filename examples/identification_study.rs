//! Repeats the virtual Table I study (`simulator-slopes`): traces of eight drivers on six slopes
//! are taken as logs, get the noise of sensors and what else the arguments say, and are identified.
//! Prints bias, coverage, refusals and warnings: the tables of docs/src/theory/identification.md.
//! `cargo run --release --example identification_study [KEY=VALUE]...`
//!
//! study=simulator-slopes   the study, driven and fitted
//! drivers=8      drivers of a seed
//! seeds=101,102  seeds of the drivers and of the noise
//! noise=0.02     standard deviation of the noise, of the range of each signal: pedals 1, speed and
//!                slope that of range=drive or of range=event (largest less smallest value)
//! signals=pedals,speed,slope   which signals are noisy
//! wrong=delay    drivers react 0.5 s late; shift: pedals are logged 0.5 s late; mass: the truck
//!                carries 7 t more than the study's; truck: it is 20 % heavier, rolling resistance
//!                and drag are 10 % larger, the driver reacts 0.2 s late; slope: 0.002 on the
//!                slope; nothing
//! unknown=delay,mass,resistance   what is estimated with the gains
//! term=none      or measured, simulated: the speed term
//! starts=8       starts of a search
//! least=0        lower bound of K_D, in s²/m
//! only=+5.5      events whose names have this
//! clip=false     whether pedals are cut at 0 and 1
//! mirror=false   each event once more with the same noise of the other sign: in the mean of both
//! the noise itself is gone, and what is left is bias intervals=true whether intervals are worked
//! out; without them a run takes a fifth of the time events=false   a line for each event
#![allow(clippy::print_stdout, reason = "its output is the guide's text")]

use ocmc_core::kernel::drive::trace::trace;
use ocmc_core::random::{Draws, Stream};
use ocmc_core::study::Study;
use ocmc_estimation::identification::closed_loop::{ClosedLoop, Controller};
use ocmc_estimation::identification::event::{EventError, PedalLog};
use ocmc_estimation::identification::identify::EventFit;
use ocmc_estimation::identification::one_truck::{NamedEvent, identify_log};
use ocmc_estimation::identification::options::{IdentifyOptions, SpeedTerm, Unknowns};
use ocmc_estimation::identification::speed_ahead::until_speed_is_set;
use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

const GAINS: [&str; 3] = ["kp", "ki", "kd"];

/// An event of a driver whose gains are known.
struct Known {
    name: String,
    drive: String,
    log: PedalLog,
    gains: [f64; 3],
    mass_kg: f64,
}

/// The arguments, by key.
struct Arguments(BTreeMap<String, String>);

impl Arguments {
    fn read() -> Self {
        let pair = |text: String| {
            let (key, value) = text.split_once('=').expect("arguments are KEY=VALUE");
            (key.to_owned(), value.to_owned())
        };
        Self(std::env::args().skip(1).map(pair).collect())
    }

    fn get<'a>(&'a self, key: &str, standard: &'a str) -> &'a str {
        self.0.get(key).map_or(standard, String::as_str)
    }

    fn number(&self, key: &str, standard: &str) -> f64 {
        self.get(key, standard).parse().expect("a number")
    }
}

/// The drive of a driver as a log without noise.
fn drive(study: &Study, seed: u64, driver: u64) -> PedalLog {
    let trace = trace(study, seed, driver);
    let column = |name: &str| {
        let column = trace.columns.iter().find(|column| column.name == name);
        column.unwrap_or_else(|| panic!("a column {name}")).values.clone()
    };
    let speed_mps = column("speed_mps");
    let yaw_rate_radps = column("yaw_rate_radps");
    let curvature = |(yaw, speed): (&f64, &f64)| yaw / speed.max(2.0);
    PedalLog {
        time_s: column("time_s"),
        limit_mps: Some(column("limit_mps")),
        curvature_per_m: Some(yaw_rate_radps.iter().zip(&speed_mps).map(curvature).collect()),
        speed_mps,
        accelerator: column("accelerator"),
        brake: column("brake"),
        grade: column("grade"),
        position_m: Some(column("position_m")),
        gear: Some(column("gear")),
        ..PedalLog::default()
    }
}

/// How late the driver is, in s.
fn delay_s(wrong: &str) -> f64 {
    match wrong {
        "delay" | "shift" => 0.5,
        "truck" => 0.2,
        _ => 0.0,
    }
}

/// The same event with a driver who reacts late.
fn driven_late(
    study: &Study,
    log: &PedalLog,
    gains: [f64; 3],
    set_speed_mps: f64,
    delay_s: f64,
) -> PedalLog {
    let closed = ClosedLoop::new(study, log);
    let start_speed_mps = log.speed_mps[0];
    let series = closed.drive(&Controller {
        proportional: gains[0],
        integral: gains[1],
        derivative: gains[2],
        set_speed_mps,
        start: closed.start_output - gains[0] * (set_speed_mps - start_speed_mps),
        start_speed_mps,
        delay_s,
        ..Controller::default()
    });
    let mut late = PedalLog {
        last_shift: log.last_shift,
        time_s: series.time_s,
        speed_mps: series.speed_mps,
        accelerator: series.accelerator,
        brake: series.brake,
        ..PedalLog::default()
    };
    let origin_m = log.positions_m();
    late.position_m = Some(late.positions_m().iter().map(|at_m| at_m + origin_m[0]).collect());
    let slope = |at_m: &f64| {
        let row = origin_m.partition_point(|known_m| known_m < at_m);
        log.grade[row.min(log.grade.len() - 1)]
    };
    late.grade = late.positions_m().iter().map(slope).collect();
    let gear = log.gear.as_ref().expect("traces have gears")[0];
    late.gear = Some(vec![gear; late.grade.len()]);
    late
}

fn range(values: &[f64]) -> f64 {
    let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    highest - values.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Adds noise to a log, of that sign.
fn add_noise(log: &mut PedalLog, arguments: &Arguments, draws: &mut Draws, sign: f64) {
    let noise = sign * arguments.number("noise", "0.02");
    let signals = arguments.get("signals", "pedals,speed,slope");
    let mut add = |values: &mut Vec<f64>, sd: f64| {
        for value in values.iter_mut() {
            *value += sd * draws.normal();
        }
    };
    if signals.contains("pedals") {
        add(&mut log.accelerator, noise);
        add(&mut log.brake, noise);
    }
    if signals.contains("speed") {
        let sd_mps = noise * range(&log.speed_mps);
        add(&mut log.speed_mps, sd_mps);
    }
    if signals.contains("slope") {
        let sd = noise * range(&log.grade);
        add(&mut log.grade, sd);
    } else if arguments.get("wrong", "nothing") == "slope" {
        add(&mut log.grade, sign * 0.002);
    }
    if arguments.get("clip", "false") == "true" {
        for pedal in [&mut log.accelerator, &mut log.brake] {
            for value in pedal.iter_mut() {
                *value = value.clamp(0.0, 1.0);
            }
        }
    }
}

fn events(study: &Study, seed: u64, sign: f64, arguments: &Arguments) -> Vec<Known> {
    let wrong = arguments.get("wrong", "nothing");
    let whole = arguments.get("range", "drive") == "drive";
    let mut known = Vec::new();
    let is_late = matches!(wrong, "delay" | "truck");
    for driver in 0..arguments.number("drivers", "8") as u64 {
        let mut draws = Draws::new(seed, driver, Stream::Pedals);
        let scenario = study.sample(seed, driver);
        let pedals = scenario.driver.pedals;
        let gains = [pedals.proportional, pedals.integral, pedals.derivative];
        let set_speed_mps = scenario.driver.speed_limit.compliance * 70.0 / 3.6;
        let mut log = drive(study, seed, driver);
        if wrong == "shift" {
            let rows =
                log.time_s.partition_point(|time_s| *time_s < log.time_s[0] + delay_s(wrong));
            for pedal in [&mut log.accelerator, &mut log.brake] {
                pedal.rotate_right(rows);
            }
        }
        let clean = log.clone();
        if whole && !is_late {
            add_noise(&mut log, arguments, &mut draws, sign);
        }
        let (log, _) = log.with_even_slopes();
        let found = log.slope_events(5.0, 18.0);
        if found.len() != 6 {
            println!("seed {seed}, driver {driver}: {} events are found", found.len());
        }
        let only = arguments.get("only", "");
        for (name, rows) in found.into_iter().filter(|(name, _)| name.contains(only)) {
            let mut log = until_speed_is_set(&log, &rows, study);
            if is_late {
                let first = clean.time_s.partition_point(|at_s| *at_s < log.time_s[0]);
                let part = clean.part(first, first + log.time_s.len());
                log = driven_late(study, &part, gains, set_speed_mps, delay_s(wrong));
            }
            if !whole || is_late {
                add_noise(&mut log, arguments, &mut draws, sign);
            }
            let drive = format!("{seed}-{driver}");
            let name = format!("{drive} {name}");
            known.push(Known { name, drive, log, gains, mass_kg: scenario.vehicle.mass_kg });
        }
    }
    known
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Mean and its standard error.
fn mean(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (n - 1.0) / n).sqrt())
}

/// Within its interval, of all that have one.
fn coverage(pairs: &[(&EventFit, f64)], name: &str) -> (usize, usize) {
    let interval = |fit: &&(&EventFit, f64)| fit.0.parameter(name).and_then(|found| found.interval);
    let all = pairs.iter().filter(|pair| interval(pair).is_some());
    let within = |pair: &&(&EventFit, f64)| {
        interval(pair).is_some_and(|[low, high]| (low..=high).contains(&pair.1))
    };
    (all.clone().filter(within).count(), all.count())
}

fn main() {
    let arguments = Arguments::read();
    let load = |sets: &[&str]| {
        let loaded = ocmc_io::study::load(arguments.get("study", "simulator-slopes"), sets);
        loaded.unwrap_or_else(|fault| panic!("{fault}")).study
    };
    let study = load(&[]);
    let wrong = arguments.get("wrong", "nothing");
    let more_kg = if wrong == "truck" { 8000.0 } else { 7000.0 };
    let payload_kg = study.sample(1, 0).cycle.mission.payload_kg + more_kg;
    let heavy = format!("mission.payload_kg={payload_kg}");
    // more than it may weigh
    let limit_kg = study.model().vehicle.curb_mass_kg + payload_kg;
    let allowed = format!("vehicle.gross_mass_limit_kg={limit_kg}");
    let resists = ["vehicle.rolling_factor=1.1", "vehicle.drag_area_m2=5.83"];
    let driven = match wrong {
        "mass" => load(&[&heavy, &allowed]),
        "truck" => load(&[&heavy, &allowed, resists[0], resists[1]]),
        _ => load(&[]),
    };
    let seeds = arguments.get("seeds", "101").split(',').map(|seed| seed.parse().expect("a seed"));
    let seeds: Vec<u64> = seeds.collect();
    let of = |sign: f64| -> Vec<Known> {
        seeds.iter().flat_map(|seed| events(&driven, *seed, sign, &arguments)).collect()
    };
    let known = of(1.0);
    let unknown = arguments.get("unknown", "");
    let options = IdentifyOptions {
        speed_term: match arguments.get("term", "none") {
            "measured" => SpeedTerm::Measured,
            "simulated" => SpeedTerm::Simulated,
            _ => SpeedTerm::None,
        },
        unknown: Unknowns {
            delay: unknown.contains("delay"),
            mass: unknown.contains("mass"),
            resistance: unknown.contains("resistance"),
        },
        starts: arguments.number("starts", "8") as usize,
        derivative: [arguments.number("least", "0"), 2.0],
        intervals: arguments.get("intervals", "true") == "true",
        ..IdentifyOptions::default()
    };
    let fits = identified(&study, &known, &options);
    let fitted: Vec<(&Known, &EventFit)> =
        known.iter().zip(&fits).filter_map(|(known, fit)| Some((known, fit.as_ref()?))).collect();
    if arguments.get("mirror", "false") == "true" {
        let mirrored = of(-1.0);
        let others = identified(&study, &mirrored, &options);
        pairs(&known, &fits, &mirrored, &others);
    }
    if arguments.get("events", "false") == "true" {
        for (known, fit) in &fitted {
            line(known, fit);
        }
    }
    println!("{} events, {} fits", known.len(), fitted.len());
    let bare = fitted.iter().filter(|(_, fit)| !fit.no_intervals.is_empty()).count();
    println!("without intervals: {bare}; for (each reason counts)");
    counts(fitted.iter().flat_map(|(_, fit)| &fit.no_intervals));
    for uphill in [true, false] {
        let side = fitted.iter().filter(|(_, fit)| (fit.grade > 0.0) == uphill);
        let gain = |name: &&str| GAINS.contains(name);
        let ended = side.clone().filter(|(_, fit)| fit.at_bound.iter().any(&gain));
        let at = |name| side.clone().filter(move |(_, fit)| fit.at_bound.contains(&name)).count();
        println!(
            "{}: {} of {} fits with a gain at a bound (K_P {}, K_I {}, K_D {})",
            if uphill { "uphill" } else { "downhill" },
            ended.count(),
            side.clone().count(),
            at("kp"),
            at("ki"),
            at("kd"),
        );
    }
    println!("warnings");
    counts(fitted.iter().flat_map(|(_, fit)| &fit.warnings));
    if options.intervals {
        for (k, name) in GAINS.into_iter().enumerate() {
            let pairs: Vec<_> = fitted.iter().map(|(known, fit)| (*fit, known.gains[k])).collect();
            bound_of_mean(&pairs, name);
        }
    }
    println!("| gain | bias, mean ± SE | median | all fits, median | covered | lost |");
    println!("|---|---|---|---|---|---|");
    for (k, name) in GAINS.into_iter().enumerate() {
        let error = |(known, fit): &&(&Known, &EventFit)| error_of(known, fit, k);
        let has = |(_, fit): &&(&Known, &EventFit)| fit.no_intervals.is_empty();
        let told = |(_, fit): &&(&Known, &EventFit)| !fit.not_identifiable.contains(&name);
        // to leave out what is not identified would choose by the noise
        let good: Vec<f64> = fitted.iter().filter(has).map(|pair| error(&pair)).collect();
        let lost = fitted.iter().filter(has).filter(|pair| !told(pair)).count();
        let all: Vec<f64> = fitted.iter().map(|pair| error(&pair)).collect();
        let pairs: Vec<_> = fitted.iter().map(|(known, fit)| (*fit, known.gains[k])).collect();
        let (within, of) = coverage(&pairs, name);
        let (bias, error) = mean(&good);
        println!(
            "| {name} | {bias:+.2} ± {error:.2} % | {:+.2} % | {:+.2} % | {within} of {of}: {:.1} \
             % | {} |",
            median(&good),
            median(&all),
            100.0 * within as f64 / of as f64,
            lost,
        );
    }
    for (name, truth) in [("delay_s", Some(delay_s(wrong))), ("mass_kg", None)] {
        let pairs: Vec<_> =
            fitted.iter().map(|(known, fit)| (*fit, truth.unwrap_or(known.mass_kg))).collect();
        let errors: Vec<f64> = pairs
            .iter()
            .filter_map(|(fit, truth)| Some(fit.parameter(name)?.value - truth))
            .collect();
        if !errors.is_empty() {
            let ((within, of), (bias, error)) = (coverage(&pairs, name), mean(&errors));
            println!("{name}: off by {bias:+.3} ± {error:.3}, covered {within} of {of}");
        }
    }
}

/// The fits of some events, those of a drive together; none where there is none, which is said.
fn identified(study: &Study, known: &[Known], options: &IdentifyOptions) -> Vec<Option<EventFit>> {
    let stay = AtomicBool::new(false);
    let fits = |drive: &[Known]| -> Vec<Option<EventFit>> {
        let named = |known: &Known| NamedEvent {
            driver: known.drive.clone(),
            event: known.name.clone(),
            log: known.log.clone(),
        };
        let events: Vec<NamedEvent> = drive.iter().map(named).collect();
        let found = identify_log(study, &events, options, &stay, &mut || ());
        let told = |(fit, known): (Result<EventFit, EventError>, &Known)| {
            fit.map_err(|fault| println!("{}: {fault}", known.name)).ok()
        };
        found.fits.into_iter().zip(drive).map(told).collect()
    };
    known.chunk_by(|a, b| a.drive == b.drive).flat_map(fits).collect()
}

/// Relative error of a gain, in %.
fn error_of(known: &Known, fit: &EventFit, k: usize) -> f64 {
    let found = fit.parameter(GAINS[k]).map_or(f64::NAN, |found| found.value);
    100.0 * (found / known.gains[k] - 1.0)
}

/// The bias of the gains from events with some noise and with the same noise of the other sign:
/// what is linear in the noise is gone in the mean of both.
fn pairs(
    known: &[Known],
    fits: &[Option<EventFit>],
    mirrored: &[Known],
    others: &[Option<EventFit>],
) {
    let other = |name: &str| mirrored.iter().position(|known| known.name == name);
    let both: Vec<(&Known, [&EventFit; 2])> = known
        .iter()
        .zip(fits)
        .filter_map(|(known, fit)| {
            Some((known, [fit.as_ref()?, others[other(&known.name)?].as_ref()?]))
        })
        .collect();
    println!(
        "| pairs of events | gain | mean of both, mean ± SE | median | half their difference, SD |"
    );
    println!("|---|---|---|---|---|");
    for refused in [true, false] {
        let counts = |(_, fits): &&(&Known, [&EventFit; 2])| {
            refused || fits.iter().all(|fit| fit.no_intervals.is_empty())
        };
        for (k, name) in GAINS.into_iter().enumerate() {
            let errors: Vec<[f64; 2]> = both
                .iter()
                .filter(counts)
                .map(|(known, fits)| fits.map(|fit| error_of(known, fit, k)))
                .collect();
            let sums: Vec<f64> = errors.iter().map(|[a, b]| 0.5 * (a + b)).collect();
            let squares: f64 = errors.iter().map(|[a, b]| 0.25 * (a - b) * (a - b)).sum();
            let (bias, error) = mean(&sums);
            println!(
                "| {}: {} | {name} | {bias:+.2} ± {error:.2} % | {:+.2} % | {:.1} % |",
                if refused { "all" } else { "neither refused" },
                sums.len(),
                median(&sums),
                (squares / sums.len() as f64).sqrt(),
            );
        }
    }
    // all that have an answer, also where the other one of the pair has none
    for (k, name) in GAINS.into_iter().enumerate() {
        let told = |(known, fits): &(&Known, [&EventFit; 2])| -> [f64; 2] {
            let told = fits.iter().filter(|fit| fit.no_intervals.is_empty());
            let errors: Vec<f64> = told.map(|fit| error_of(known, fit, k)).collect();
            [errors.iter().sum(), errors.len() as f64]
        };
        let sums: Vec<[f64; 2]> = both.iter().map(told).collect();
        let all: f64 = sums.iter().map(|[_, count]| count).sum();
        let bias = sums.iter().map(|[sum, _]| sum).sum::<f64>() / all;
        let squares = sums.iter().map(|[sum, count]| (sum - bias * count).powi(2));
        let error = squares.sum::<f64>().sqrt() / all;
        println!("| {all} fits with an answer | {name} | {bias:+.2} ± {error:.2} % | | |");
    }
}

/// How well the mean error of a gain can be known at best from these fits, in %: what each interval
/// says of its error (Cramér and Rao's bound, near the optimum), of their mean.
fn bound_of_mean(pairs: &[(&EventFit, f64)], name: &str) {
    let error = |(fit, truth): &(&EventFit, f64)| {
        let found = fit.parameter(name)?;
        let [low, high] = found.interval?;
        // where an end stands at a bound the other one tells
        Some((high - found.value).max(found.value - low) / (1.96 * truth))
    };
    let errors: Vec<f64> = pairs.iter().filter_map(error).collect();
    let squares: f64 = errors.iter().map(|error| error * error).sum();
    let bound = 100.0 * squares.sqrt() / errors.len() as f64;
    println!("{name}: no mean of {} errors is known better than to ± {bound:.2} %", errors.len());
}

/// How often each text occurs, numbers left out.
fn counts<'a>(texts: impl Iterator<Item = &'a String>) {
    let mut found: BTreeMap<String, usize> = BTreeMap::new();
    for text in texts {
        let start: String = text.chars().filter(|c| !c.is_ascii_digit()).take(44).collect();
        *found.entry(start).or_default() += 1;
    }
    for (text, count) in &found {
        println!("  {count} {text}");
    }
}

fn line(known: &Known, fit: &EventFit) {
    let gains: Vec<String> = GAINS
        .iter()
        .zip(known.gains)
        .map(|(name, truth)| {
            let found = fit.parameter(name).expect("a PID");
            let [low, high] = found.interval.unwrap_or([f64::NAN; 2]);
            let (value, half) = (100.0 * (found.value / truth - 1.0), 50.0 * (high - low) / truth);
            let outside = if truth < low || truth > high { "!" } else { "" };
            format!("{name} {value:+.1}±{half:.1}{outside}")
        })
        .collect();
    let test = &fit.test;
    let score = |score: Option<[f64; 2]>| {
        score.map_or("-".to_owned(), |[value, error]| format!("{value:+.3}±{error:.3}"))
    };
    println!(
        "{}: {} rms {:.4} noise {:.4} {:.4} ratio {:.2} F {:.1} delay {} mass {} good {}/{} {}",
        known.name,
        gains.join(" "),
        fit.pedal_rms,
        test.pedal_noise[0],
        test.pedal_noise[1],
        test.noise_ratio,
        test.slow_f,
        score(test.delay_s),
        score(test.mass_share),
        fit.starts_converged,
        fit.starts,
        if fit.no_intervals.is_empty() { "" } else { "REFUSED" },
    );
}
