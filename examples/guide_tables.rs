//! Prints the measured tables of the guide (docs/src/results.md): effects of the parts, errors of
//! the time step, the held brake, and how plausible the default study is.
//! `cargo run --release --example guide_tables [CYCLES]`
#![allow(clippy::print_stdout, reason = "its output is the guide's text")]

use ocmc_core::energy::Carrier;
use ocmc_core::kernel::drive::cpu::CpuLevel;
use ocmc_core::powertrain::PowertrainKind;
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_fleet::run::{RunPlan, chunk_for, run};
use std::ops::ControlFlow;

const THREADS: usize = 2;

fn records(name: &str, sets: &[&str], cycles: u64) -> Vec<Record> {
    let study: Study = ocmc_io::study::load(name, sets).expect("built-in studies load").study;
    let chunk = chunk_for(cycles, THREADS);
    let level = CpuLevel::best();
    let plan = RunPlan { level, ..RunPlan::new(1, 0, cycles, Some(THREADS), Some(chunk)) };
    let mut all = Vec::new();
    let end: ControlFlow<()> = run(&study, &plan, |mut records| {
        all.append(&mut records);
        ControlFlow::Continue(())
    });
    assert!(end.is_continue());
    all
}

fn litres(record: &Record) -> f64 {
    record.consumption(Carrier::LiquidFuel).expect("a diesel truck")
}

fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt())
}

/// Paired difference of the mean with its 95 % half-width, and of the SD by the jackknife over
/// pairs.
fn effect_row(label: &str, all: &[Record], other: &[Record]) {
    let (a, b): (Vec<f64>, Vec<f64>) =
        (all.iter().map(litres).collect(), other.iter().map(litres).collect());
    let differences: Vec<f64> = a.iter().zip(&b).map(|(a, b)| b - a).collect();
    let n = a.len() as f64;
    let (mean, sd) = mean_and_sd(&differences);
    let ((mean_a, sd_a), (mean_b, sd_b)) = (mean_and_sd(&a), mean_and_sd(&b));
    // influence of one pair on the difference of the two SDs
    let influence: Vec<f64> = a
        .iter()
        .zip(&b)
        .map(|(a, b)| {
            ((b - mean_b).powi(2) - sd_b * sd_b) / (2.0 * sd_b)
                - ((a - mean_a).powi(2) - sd_a * sd_a) / (2.0 * sd_a)
        })
        .collect();
    let (_, spread) = mean_and_sd(&influence);
    let minutes =
        other.iter().zip(all).map(|(b, a)| b.duration_s - a.duration_s).sum::<f64>() / n / 60.0;
    println!(
        "| {label} | {:+.2} ± {:.2} | {:+.2} ± {:.2} | {minutes:+.1} |",
        mean,
        1.96 * sd / n.sqrt(),
        sd_b - sd_a,
        1.96 * spread / n.sqrt()
    );
}

fn effects(cycles: u64) {
    let all = records("field-truck", &[], cycles);
    let (mean, sd) = mean_and_sd(&all.iter().map(litres).collect::<Vec<_>>());
    println!(
        "## effects\n\nAll parts on: mean of the cycles {mean:.2}, SD {sd:.2} L/100 km ({cycles} \
         cycles, seed 1).\n"
    );
    println!(
        "| turned off | change of the mean, L/100 km | change of the SD, L/100 km | change of the \
         mean duration, min |"
    );
    println!("|---|---|---|---|");
    for part in [
        "slope",
        "curves",
        "signs",
        "stop_signs",
        "give_ways",
        "traffic_lights",
        "speed_bumps",
        "weather",
        "traffic",
        "payload_spread",
        "driver_spread",
        "vehicle_spread",
    ] {
        let set = format!("simulation.without=[\"{part}\"]");
        effect_row(&format!("`{part}`"), &all, &records("field-truck", &[&set], cycles));
    }
    println!(
        "\n| instead of the default | change of the mean, L/100 km | change of the SD, L/100 km | \
         change of the mean duration, min |"
    );
    println!("|---|---|---|---|");
    for (label, set) in [
        ("all in January (day 15)", "mission.departure_day_of_year=15"),
        ("all in July (day 196)", "mission.departure_day_of_year=196"),
        ("all at 01:00", "mission.departure_s_of_day=3600"),
        ("all at 07:00", "mission.departure_s_of_day=25200"),
        ("desired speed jumps up (`rise = \"paper\"`)", "driver.speed_change.rise=paper"),
        ("only PID drivers", "driver.pedals.pid_share=1.0"),
        ("only switched drivers", "driver.pedals.pid_share=0.0"),
        ("held brake as printed (`hold = \"paper\"`)", "driver.pedals.switched.hold=paper"),
    ] {
        effect_row(label, &all, &records("field-truck", &[set], cycles));
    }
    println!();
}

fn steps(cycles: u64) {
    let at = |step: f64| records("field-truck", &[&format!("simulation.step_s={step}")], cycles);
    let fine = at(0.001);
    println!("## dt\n\nAgainst steps of 1 ms, {cycles} cycles, seed 1.\n");
    println!(
        "| longest step, s | wheel energy: mean, mean absolute, % | fuel: mean, mean absolute, % | \
         duration, mean absolute, % |"
    );
    println!("|---|---|---|---|");
    for step in [2.0, 1.5, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.005] {
        let coarse = at(step);
        let error = |value: fn(&Record) -> f64| {
            let all: Vec<f64> = coarse
                .iter()
                .zip(&fine)
                .map(|(a, b)| 100.0 * (value(a) / value(b) - 1.0))
                .collect();
            let n = all.len() as f64;
            (all.iter().sum::<f64>() / n, all.iter().map(|e| e.abs()).sum::<f64>() / n)
        };
        let (wheel, fuel, time) = (
            error(|r| r.wheel_energy_j),
            error(|r| r.amount(Carrier::LiquidFuel).expect("a diesel truck")),
            error(|r| r.duration_s),
        );
        println!(
            "| {step} | {:+.4}, {:.4} | {:+.4}, {:.4} | {:.4} |",
            wheel.0, wheel.1, fuel.0, fuel.1, time.1
        );
    }
    println!();
}

fn hold(cycles: u64) {
    let run = |hold: &str| {
        // as printed: no feed-forward, no tolerance
        let hold = format!("switched.hold={hold}");
        let sets = ["pid_share=0.0", "feed_forward=false", "brake_tolerance_mps=0", &hold];
        let sets = sets.map(|set| format!("driver.pedals.{set}"));
        records("field-truck", &sets.each_ref().map(String::as_str), cycles)
    };
    println!(
        "## hold\n\nSwitched drivers only, without feed-forward and tolerance, {cycles} cycles, \
         seed 1.\n"
    );
    println!("| what is held | L/100 km | cycles not completed |\n|---|---|---|");
    for name in ["throttle", "paper"] {
        let records = run(name);
        let done: Vec<&Record> =
            records.iter().filter(|r| r.outcome.name() == "completed").collect();
        let (mean, _) = mean_and_sd(&done.iter().map(|r| litres(r)).collect::<Vec<_>>());
        println!("| `{name}` | {mean:.2} | {} of {cycles} |", records.len() - done.len());
    }
    println!();
}

fn plausibility(cycles: u64) {
    println!(
        "## plausibility\n\n{cycles} cycles each, seed 1. Fleet mean: total over total distance.\n"
    );
    println!(
        "| study | mean gross mass, t | L/100 km, fleet mean | SD over cycles | wheel kWh/km | \
         km/h | stops per km | shifts per km | service brake, % of wheel energy |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for built_in in ocmc_io::study::list() {
        let study = ocmc_io::study::load::<&str>(built_in.name, &[]).expect("it loads").study;
        let PowertrainKind::Combustion(diesel) = &study.vehicle().powertrain else { continue };
        let records = records(built_in.name, &[], cycles);
        let sum = |value: fn(&Record) -> f64| records.iter().map(value).sum::<f64>();
        let km = sum(|r| r.distance_m) / 1000.0;
        let fuel = &diesel.engine_model.fuel;
        let per_100km = sum(|r| r.amount(Carrier::LiquidFuel).expect("a diesel truck"))
            / fuel.density_kgpm3
            * 1e5
            / km;
        let (_, sd) = mean_and_sd(&records.iter().map(litres).collect::<Vec<_>>());
        let gross =
            study.model().vehicle.curb_mass_kg + sum(|r| r.payload_kg) / records.len() as f64;
        println!(
            "| `{}` | {:.1} | {per_100km:.1} | {sd:.1} | {:.2} | {:.1} | {:.2} | {:.1} | {:.1} |",
            built_in.name,
            gross / 1000.0,
            sum(|r| r.wheel_energy_j) / 3.6e6 / km,
            km / (sum(|r| r.duration_s) / 3600.0),
            sum(|r| f64::from(r.n_stops)) / km,
            sum(|r| f64::from(r.n_gear_shifts)) / km,
            100.0 * sum(|r| r.service_brake_energy_j) / sum(|r| r.wheel_energy_j)
        );
    }
    println!();
}

fn main() {
    let cycles = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(4000);
    plausibility(cycles / 2);
    effects(cycles);
    hold(cycles / 4);
    steps(cycles / 40);
}
