//! Prints how a fleet is driven, from its traces: arrivals at stop lines, entries of bends,
//! launches, shifts that hunt, pedals that reverse (docs/src/results.md). `cargo run --release
//! --example driving_quality [STUDY [CYCLES [SEED [KEY=VALUE]...]]]`
#![allow(clippy::print_stdout, reason = "its output is the guide's text")]

use ocmc_core::kernel::drive::trace::{Trace, trace};
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_core::tactical::{SpeedProfile, plan};
use rayon::prelude::*;

/// Speed up to which a truck is launching, in m/s.
const LAUNCH_MPS: f64 = 6.0;
/// Time within which opposite shifts hunt, and pedals reverse, in s.
const WITHIN_S: f64 = 10.0;
/// Change of the grade that explains a shift.
const GRADE_CHANGE: f64 = 0.02;
/// Lateral accelerations that are counted, in m/s².
const LATERAL_MPS2: [f64; 2] = [3.0, 4.0];

/// Driving in one cycle.
#[derive(Default)]
struct Driving {
    switched: bool,
    distance_m: f64,
    arrival_mps: Vec<f64>,
    most_lateral_mps2: f64,
    /// Speed at the entry of a bend over the speed that the driver drew for it.
    entry_ratio: Vec<f64>,
    /// Peak acceleration of a launch over the driver's.
    launch_ratio: Vec<f64>,
    n_shifts: usize,
    n_hunting: usize,
    n_reversals: usize,
    n_brakings: usize,
}

struct Columns<'a>(&'a Trace);

impl<'a> Columns<'a> {
    fn get(&self, name: &str) -> &'a [f64] {
        let column = self.0.columns.iter().find(|column| column.name == name);
        &column.unwrap_or_else(|| panic!("a column {name}")).values
    }
}

fn driving(study: &Study, seed: u64, cycle_id: u64) -> Driving {
    let scenario = study.sample(seed, cycle_id);
    let trace = trace(study, seed, cycle_id);
    let columns = Columns(&trace);
    let record: &Record = &trace.record;
    let [time, position, speed, gear, grade] =
        ["time_s", "position_m", "speed_mps", "gear", "grade"].map(|name| columns.get(name));
    let [accelerator, brake, acceleration, yaw] =
        ["accelerator", "brake", "acceleration_mps2", "yaw_rate_radps"]
            .map(|name| columns.get(name));
    let driven = columns.get("simulated_added_s");
    let limits = static_limits(study, &scenario, position);
    let mut found = Driving {
        switched: record.driver_switch_threshold_mps.is_some(),
        distance_m: record.distance_m,
        ..Driving::default()
    };
    let wanted_mps2 = scenario.driver.speed_change.acceleration_mps2;
    let mut launch: Option<f64> = Some(0.0);
    let (mut throttle_s, mut braked_s): (Option<f64>, Option<f64>) = (None, None);
    // last shift: its row and direction
    let mut last_shift: Option<(usize, f64)> = None;
    for k in 0..time.len() {
        found.most_lateral_mps2 = found.most_lateral_mps2.max(speed[k] * yaw[k].abs());
        if driven[k] == 0.0 {
            // a stop
            if k > 0 && driven[k - 1] > 0.0 {
                found.arrival_mps.push(speed[k - 1]);
            }
            launch = Some(0.0);
            (throttle_s, braked_s, last_shift) = (None, None, None);
            continue;
        }
        if let Some(peak) = launch {
            let peak = peak.max(acceleration[k]);
            let ends = speed[k] > LAUNCH_MPS || brake[k] > 0.0;
            launch = if ends { None } else { Some(peak) };
            if ends {
                found.launch_ratio.push(peak / wanted_mps2);
            }
        }
        if brake[k] > 0.0 {
            found.n_brakings += usize::from(k > 0 && brake[k - 1] <= 0.0);
            braked_s = throttle_s.map(|_| time[k]);
        } else if accelerator[k] > 0.0 {
            if let (Some(from), Some(_)) = (throttle_s, braked_s) {
                found.n_reversals += usize::from(time[k] - from <= WITHIN_S);
            }
            (throttle_s, braked_s) = (Some(time[k]), None);
        }
        if k > 0 && driven[k - 1] > 0.0 && gear[k] != gear[k - 1] {
            found.n_shifts += 1;
            let direction = (gear[k] - gear[k - 1]).signum();
            if let Some((row, last)) = last_shift {
                let explained = (row..=k).any(|i| {
                    limits[i] != limits[row] || (grade[i] - grade[row]).abs() > GRADE_CHANGE
                });
                // a row's time is its end
                let between_s = time[k - 1] - time[row - 1];
                let opposite = direction != last && between_s <= WITHIN_S;
                found.n_hunting += usize::from(opposite && !explained);
            }
            last_shift = Some((k, direction));
        }
    }
    let road = &scenario.cycle.road;
    let driver = &scenario.driver.curve_speed;
    for (curve, z) in road.curves.iter().zip(&scenario.curve_residuals) {
        let drawn_mps = driver.speed_mps(curve.radius_m, curve.left, *z);
        let k = position.partition_point(|at| *at < curve.start_m);
        if drawn_mps.is_finite() && (1..position.len()).contains(&k) {
            let share = (curve.start_m - position[k - 1]) / (position[k] - position[k - 1]);
            let square = |v: f64| v * v;
            let entry = square(speed[k - 1]) + share * (square(speed[k]) - square(speed[k - 1]));
            found.entry_ratio.push(entry.max(0.0).sqrt() / drawn_mps);
        }
    }
    found
}

/// The static limit of v² at each row.
fn static_limits(
    study: &Study,
    scenario: &ocmc_core::study::Scenario,
    position: &[f64],
) -> Vec<f64> {
    let mut profile = SpeedProfile::default();
    plan(study, scenario, &mut profile);
    let mut at = 0;
    let limit = |x: &f64| {
        while profile.segments.get(at + 1).is_some_and(|next| next.start_m <= *x) {
            at += 1;
        }
        profile.branches[at].limit
    };
    position.iter().map(limit).collect()
}

fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    values.get((share * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
}

fn distribution(label: &str, mut values: Vec<f64>, above: &[f64]) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let [half, p99, most] = [0.5, 0.99, 1.0].map(|share| quantile(&mut values, share));
    print!(
        "{label}: {} of them, mean {mean:.3}, median {half:.3}, P99 {p99:.3}, most {most:.3}",
        values.len()
    );
    for limit in above {
        let n = values.iter().filter(|value| *value > limit).count();
        print!("; {:.2} % above {limit}", 100.0 * n as f64 / values.len() as f64);
    }
    println!();
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let text =
        |k: usize, default: &str| arguments.get(k).cloned().unwrap_or_else(|| default.to_owned());
    let name = text(0, "field-truck");
    let cycles: u64 = text(1, "300").parse().expect("a number of cycles");
    let seed: u64 = text(2, "1").parse().expect("a seed");
    let sets = arguments.get(3..).unwrap_or_default();
    let study = ocmc_io::study::load(&name, sets).expect("the study loads").study;
    let all: Vec<Driving> =
        (0..cycles).into_par_iter().map(|id| driving(&study, seed, id)).collect();
    println!("{name}, {cycles} cycles, seed {seed}, {sets:?}");
    let pooled = |values: fn(&Driving) -> &[f64]| -> Vec<f64> {
        all.iter().flat_map(|cycle| values(cycle).iter().copied()).collect()
    };
    distribution("Speed at stop lines, m/s", pooled(|c| &c.arrival_mps), &[1.6, 3.0]);
    distribution("Entry of bends over the drawn speed", pooled(|c| &c.entry_ratio), &[1.0, 1.05]);
    distribution("Peak of launches over the driver's", pooled(|c| &c.launch_ratio), &[1.3]);
    for limit in LATERAL_MPS2 {
        let n = all.iter().filter(|cycle| cycle.most_lateral_mps2 > limit).count();
        let share = 100.0 * n as f64 / all.len() as f64;
        println!("Cycles above {limit} m/s² in a bend: {share:.2} %");
    }
    let km = all.iter().map(|cycle| cycle.distance_m).sum::<f64>() / 1000.0;
    let reversals: usize = all.iter().map(|cycle| cycle.n_reversals).sum();
    let brakings: usize = all.iter().map(|cycle| cycle.n_brakings).sum();
    println!(
        "Accelerator, brake, accelerator within {WITHIN_S} s: {:.4} per km; brakings {:.3} per km",
        reversals as f64 / km,
        brakings as f64 / km
    );
    for switched in [false, true] {
        let cycles: Vec<&Driving> = all.iter().filter(|c| c.switched == switched).collect();
        if cycles.is_empty() {
            continue;
        }
        let shifts: usize = cycles.iter().map(|cycle| cycle.n_shifts).sum();
        let hunting: usize = cycles.iter().map(|cycle| cycle.n_hunting).sum();
        let per_100km = |c: &&Driving| c.n_shifts as f64 / c.distance_m * 1e5;
        let mut rates: Vec<f64> = cycles.iter().map(per_100km).collect();
        let kind = if switched { "switched" } else { "PID" };
        println!(
            "Shifts of {} {kind} drivers: mean {:.0} per 100 km, most {:.0}; hunting {:.3} %",
            cycles.len(),
            rates.iter().sum::<f64>() / rates.len() as f64,
            quantile(&mut rates, 1.0),
            100.0 * hunting as f64 / shifts as f64
        );
    }
}
