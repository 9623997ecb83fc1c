//! Prints how often the 95 % interval of each number that a fit writes into a study covers what the
//! data were drawn from (docs/src/theory/coverage.md).
//! `cargo run --release --example coverage [REPLICATES] [FIT]`; FIT: a part of the titles of the
//! tables that are wanted, as `operating-cycle`
#![allow(clippy::print_stdout, reason = "its output is the guide's text")]

use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::random::{Draws, Stream, Streams};
use ocmc_core::study::{Study, StudyModel};
use ocmc_estimation::fit::curve_speed::{self, CurveSpeedEstimate, CurveSpeedOptions, CurveTable};
use ocmc_estimation::fit::operating_cycle;
use ocmc_estimation::fit::p_value::t_of_interval;
use ocmc_estimation::fit::speed_change::{self, SpeedChangeOptions, SpeedChangeTable};
use ocmc_estimation::fit::study_parameter::StudyParameterFit;
use ocmc_estimation::fit::traffic::{self, TrafficRecord};
use ocmc_estimation::fit::weather::{self, HourlyRecord};
use serde_json::Value;
use std::collections::BTreeMap;

const THREADS: u64 = 2;
const DAY_S: f64 = 86_400.0;
/// Half-width of a 95 % interval, in standard errors.
const NORMAL: f64 = 1.959_963_984_540_054;

/// A number with its interval, and what it was drawn from.
struct Interval {
    key: String,
    truth: f64,
    ends: [f64; 2],
}

impl Interval {
    fn new(key: &str, truth: f64, ends: [f64; 2]) -> Self {
        Self { key: key.to_owned(), truth, ends }
    }

    fn around(key: &str, truth: f64, value: f64, reach: f64) -> Self {
        Self::new(key, truth, [value - reach, value + reach])
    }
}

/// Counts of one number over all replicates.
#[derive(Default)]
struct Count {
    n: f64,
    covered: f64,
    /// Intervals that lie below the truth.
    below: f64,
}

/// The table of a fit.
fn table(title: &str, replicates: u64, replicate: impl Fn(u64) -> Vec<Interval> + Sync) {
    if std::env::args().nth(2).is_some_and(|wanted| !title.contains(&wanted)) {
        return;
    }
    let of_thread = |thread: u64| {
        (0..replicates).filter(|seed| seed % THREADS == thread).flat_map(&replicate).collect()
    };
    let all: Vec<Vec<Interval>> = std::thread::scope(|scope| {
        let of_thread = &of_thread;
        let threads: Vec<_> =
            (0..THREADS).map(|thread| scope.spawn(move || of_thread(thread))).collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    });
    let mut counts: BTreeMap<String, Count> = BTreeMap::new();
    let mut order: Vec<String> = Vec::new();
    for Interval { key, truth, ends: [low, high] } in all.into_iter().flatten() {
        if !counts.contains_key(&key) {
            order.push(key.clone());
        }
        let count = counts.entry(key).or_default();
        count.n += 1.0;
        count.covered += f64::from(low <= truth && truth <= high);
        count.below += f64::from(high < truth);
    }
    println!("\n{title}\n\n| number | intervals | cover, % | lie below, % |\n|---|---|---|---|");
    for key in order {
        let Count { n, covered, below } = counts[&key];
        println!("| `{key}` | {n} | {:.1} | {:.1} |", 100.0 * covered / n, 100.0 * below / n);
    }
}

const EXPONENT: f64 = 0.46;
const SPEED_MPS: f64 = 15.14;
const DRIVER_SD: f64 = 0.056;
const DIRECTION: f64 = 0.02;
const RESIDUAL: f64 = 0.177;

/// Curves of drivers; with limits of 19 m/s, which they keep to, where asked for.
fn curves(seed: u64, drivers: usize, each: usize, limits: bool) -> CurveTable {
    let mut draws = Draws::new(seed, 0, Stream::Curve);
    let mut table = CurveTable { left: Some(Vec::new()), ..CurveTable::default() };
    let mut limit = Vec::new();
    for driver in 0..drivers {
        let level = DRIVER_SD * draws.normal();
        for _ in 0..each {
            let radius_m = (150.0 * f64::exp(0.7 * draws.normal())).clamp(21.0, 499.0);
            let left = draws.uniform() < 0.5;
            let side = if left { DIRECTION } else { -DIRECTION };
            let log = EXPONENT * f64::ln(radius_m / 250.0) + level + side;
            let speed_mps = SPEED_MPS * f64::exp(log + RESIDUAL * draws.normal());
            table.driver.push(format!("driver {driver}"));
            table.radius_m.push(radius_m);
            table.speed_mps.push(if limits { speed_mps.min(19.0) } else { speed_mps });
            table.left.as_mut().expect("made above").push(left);
            limit.push(19.0);
        }
    }
    table.limit_mps = limits.then_some(limit);
    table
}

fn of_curves(fit: &CurveSpeedEstimate, drivers: usize, sd: Option<[f64; 2]>) -> Vec<Interval> {
    let mut found = Vec::new();
    if let Some(ends) = fit.exponent_clustered_ci95 {
        found.push(Interval::new("exponent", EXPONENT, ends));
    }
    if let Some(error) = fit.reference_speed_log_clustered_standard_error {
        let reach = t_of_interval(0.95, drivers as f64 - 1.0) * error;
        let log = f64::ln(fit.reference_speed_mps / SPEED_MPS);
        found.push(Interval::around("reference_speed_mps", 0.0, log, reach));
    }
    found.extend(sd.map(|ends| Interval::new("driver_sd", DRIVER_SD, ends)));
    found
        .extend(fit.direction_effect_ci95.map(|e| Interval::new("direction_effect", DIRECTION, e)));
    found.extend(fit.residual_sd_ci95.map(|ends| Interval::new("residual_sd", RESIDUAL, ends)));
    found
}

/// Accelerations of drivers.
fn changes(seed: u64, drivers: usize, each: usize) -> Vec<Interval> {
    let (median, between, within) = (0.6, 0.2, 0.25);
    let mut draws = Draws::new(seed, 0, Stream::SpeedChange);
    let mut table = SpeedChangeTable::default();
    for driver in 0..drivers {
        let level = between * draws.normal();
        // some drivers have three times as many changes as others
        for _ in 0..each * (1 + 2 * (driver % 2)) {
            table.driver.push(format!("driver {driver}"));
            table.category.push("40-to-70".to_owned());
            table.acceleration_mps2.push(median * f64::exp(level + within * draws.normal()));
        }
    }
    let options = SpeedChangeOptions { smallest_acceleration_mps2: 0.0, ..Default::default() };
    let Ok(fit) = speed_change::fit(&table, &options) else { return Vec::new() };
    let Some(law) = fit.acceleration.and_then(|law| law.between_drivers) else { return Vec::new() };
    let mut found = Vec::new();
    found.extend(law.median_ci95.map(|ends| Interval::new("median", median, ends)));
    found.extend(law.driver_log_sd_ci95.map(|ends| Interval::new("log_sd", between, ends)));
    found
}

/// Estimates that are found in a model under their keys.
fn of_parameters(parameters: &[StudyParameterFit], truth: &Value) -> Vec<Interval> {
    let interval = |parameter: &StudyParameterFit| {
        let at = parameter.key.split('.').try_fold(truth, |value, part| value.get(part))?;
        let (truth, error) = (at.as_f64()?, parameter.standard_error?);
        let mut value = parameter.value;
        if parameter.key.ends_with("direction_rad") {
            // up to whole turns
            value -= std::f64::consts::TAU * ((value - truth) / std::f64::consts::TAU).round();
        }
        Some(Interval::around(&parameter.key, truth, value, NORMAL * error))
    };
    parameters.iter().filter_map(interval).collect()
}

fn hours(seed: u64, years: usize, model: &StudyModel) -> Vec<Interval> {
    let truth = &model.weather;
    let hours = years * 365 * 24;
    let series = truth.sample(0.0, 0.0, 3600.0 * hours as f64, &Streams::new(seed, 0));
    let record = |hour: usize| {
        let time_s = 3600.0 * hour as f64;
        HourlyRecord { time_s, day_of_year: time_s / DAY_S, weather: series.at(time_s) }
    };
    let records: Vec<HourlyRecord> = (0..hours).map(record).collect();
    let Ok(fit) = weather::fit(&records, truth) else { return Vec::new() };
    of_parameters(&fit.parameters, &serde_json::to_value(truth).expect("a model is JSON"))
}

/// Detectors on each road type for 30 days; as speeds with noise of this SD, where it is given.
fn detectors(seed: u64, noise: Option<f64>, model: &StudyModel) -> Vec<Interval> {
    let truth = &model.traffic;
    let mut draws = Draws::new(seed, 99, Stream::Traffic);
    let (mut records, mut ratios) = (Vec::new(), Vec::new());
    for (site, (road_type, of_type)) in truth.types.iter().enumerate() {
        let series = truth.sample(0.0, 30.0 * DAY_S, &Streams::new(seed, site as u64));
        for step in 0..30 * 288 {
            let time_s = (step as f64 + 0.5) * truth.step_s;
            let density = truth.density_per_m(of_type, &series, 0.0, time_s);
            let share = density / truth.jam_density_per_m;
            let ratio =
                f64::exp(-0.5 * (share / truth.critical_share) * (share / truth.critical_share));
            ratios.push((ratio + noise.unwrap_or(0.0) * draws.normal()).max(0.0));
            let (site, road_type) = (site.to_string(), road_type.clone());
            records.push(TrafficRecord { site, road_type, time_s, share });
        }
    }
    let fit = match noise {
        Some(_) => traffic::fit_speeds(&records, &ratios, truth),
        None => traffic::fit(&records, truth),
    };
    let Ok(fit) = fit else { return Vec::new() };
    of_parameters(&fit.parameters, &serde_json::to_value(truth).expect("a model is JSON"))
}

/// A hundred operating cycles of the study.
fn roads(seed: u64, study: &Study) -> Vec<Interval> {
    // a road that leads below the allowed altitudes is no given one
    let cycle = |id| {
        let cycle = study.sample(seed, id).cycle;
        let tracks = cycle.tracks(study.road_types(), study.operating_cycle().road().types());
        GivenCycle::from_tracks(&tracks, Some(cycle.road.length_m)).ok()
    };
    let cycles: Vec<GivenCycle> = (0..100).filter_map(cycle).collect();
    let Ok(fit) = operating_cycle::fit(&cycles, study.model()) else { return Vec::new() };
    let mut all = Vec::new();
    for of_type in &fit.types {
        let truth = &study.model().road.types[&of_type.road_type];
        let truth = serde_json::to_value(truth).expect("a model is JSON");
        for mut interval in of_parameters(&of_type.parameters, &truth) {
            interval.key = format!("{}.{}", of_type.road_type, interval.key);
            all.push(interval);
        }
    }
    all
}

fn main() {
    let replicates = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(200);
    let study = ocmc_io::study::load("field-truck", &[] as &[&str]).expect("a built-in study");
    let (model, study) = (&study.model, &study.study);
    let options = CurveSpeedOptions::default();
    for (drivers, each) in [(25, 40), (40, 5)] {
        let title = format!("`fit curve-speed`, {drivers} drivers with {each} curves each");
        table(&title, replicates, |seed| {
            let Ok(fit) = curve_speed::fit(&curves(seed, drivers, each, false), &options) else {
                return Vec::new();
            };
            let sd = fit.random_intercept.as_ref().and_then(|reml| reml.driver_sd_ci95);
            of_curves(fit.with_direction.as_ref().unwrap_or(&fit.estimated), drivers, sd)
        });
        table(&format!("{title}, `--tobit`"), replicates, |seed| {
            let fit = curve_speed::fit(&curves(seed, drivers, each, true), &options);
            let Some(tobit) = fit.ok().and_then(|fit| fit.tobit) else { return Vec::new() };
            let sd = tobit.driver_sd_corrected_ci95;
            of_curves(&tobit, drivers, sd)
        });
    }
    for (drivers, each) in [(20, 4), (8, 3)] {
        let title =
            format!("`fit speed-change`, {drivers} drivers with {each} or {} changes", 3 * each);
        table(&title, replicates, |seed| changes(seed, drivers, each));
    }
    for years in [3, 1] {
        table(&format!("`fit weather`, years: {years}"), replicates, |seed| {
            hours(seed, years, model)
        });
    }
    table("`fit traffic`, densities of 30 days", replicates, |seed| detectors(seed, None, model));
    let title = "`fit traffic`, speeds of 30 days with noise of 5 % of the free speed";
    table(title, replicates, |seed| detectors(seed, Some(0.05), model));
    table("`fit operating-cycle`, 100 cycles", replicates, |seed| roads(seed, study));
}
