//! The engine's side of `benches/peers`: exports planned scenarios with the engine's answers,
//! drives them again and again, and follows given speeds.
//!
//! `peers export FOLDER CYCLES`, `peers drive CYCLES ROUNDS LEVEL [KEY=VALUE]...`,
//! `peers steps CYCLES [KEY=VALUE]...`, `peers follow < DRIVE.json`
#![allow(clippy::print_stdout, reason = "its output is read by the benches' scripts")]

use ocmc_core::energy::Carrier;
use ocmc_core::energy::ledger::Term;
use ocmc_core::kernel::drive::cpu::CpuLevel;
use ocmc_core::kernel::drive::scheduler::drive_tasks;
use ocmc_core::kernel::drive::trace::trace;
use ocmc_core::kernel::step::road_row::RoadRows;
use ocmc_core::kernel::trip::lane_task::LaneTask;
use ocmc_core::powertrain::PowertrainKind;
use ocmc_core::powertrain::efficiency::{EfficiencyCurve, EfficiencyDriveline};
use ocmc_core::prescribed::{Body, DriveCycle, follow};
use ocmc_core::record::Record;
use ocmc_core::study::Study;
use ocmc_core::tactical::{SpeedProfile, plan};
use serde_json::{Value, json};
use std::fs::{File, write};
use std::io::{BufWriter, Write, stdin};
use std::path::Path;

const SEED: u64 = 1;
/// Steps, in s, for which the engine's answers are exported; the last one is the truth.
const STEPS_S: [f64; 13] = [1.5, 1.0, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.001];
/// Cycles whose speed over time is exported.
const TRACES: u64 = 16;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match *words {
        ["export", folder, cycles] => export(Path::new(folder), cycles.parse()?),
        ["drive", cycles, rounds, level, ref sets @ ..] => {
            drive_again(cycles.parse()?, rounds.parse()?, level, sets)
        }
        ["steps", cycles, ref sets @ ..] => count_steps(cycles.parse()?, sets),
        ["follow"] => follow_given(),
        _ => Err("arguments: export FOLDER CYCLES, drive CYCLES ROUNDS LEVEL [KEY=VALUE]..., \
            steps CYCLES [KEY=VALUE]..., follow"
            .into()),
    }
}

fn study(sets: &[&str]) -> Result<Study, Failure> {
    Ok(ocmc_io::study::load("field-truck", sets).map_err(|error| error.to_string())?.study)
}

/// Planned cycles of a study.
fn tasks(study: &Study, cycles: u64) -> Vec<LaneTask> {
    (0..cycles).map(|id| LaneTask::new(study, study.sample(SEED, id))).collect()
}

/// Writes `scenarios.json`, and the road rows and traces as plain doubles, little end first.
fn export(folder: &Path, cycles: u64) -> Result<(), Failure> {
    let study = study(&[])?;
    let parameters = study.vehicle();
    let PowertrainKind::Combustion(diesel) = &parameters.powertrain else {
        return Err("the rivals' model is that of a diesel truck".into());
    };
    let (gearbox, vehicle_model) = (&diesel.gearbox, &parameters.model);
    let idle_radps = diesel.engine_model.idle_speed_radps;
    let mut rows_file = BufWriter::new(File::create(folder.join("rows.f64"))?);
    let (mut profile, mut road) = (SpeedProfile::default(), RoadRows::default());
    let (mut first_row, mut scenarios) = (0, Vec::new());
    for id in 0..cycles {
        let scenario = study.sample(SEED, id);
        plan(&study, &scenario, &mut profile);
        road.fill(&study, &scenario, &profile);
        for number in road.rows.iter().flat_map(|row| row.0) {
            rows_file.write_all(&number.to_le_bytes())?;
        }
        let (vehicle, pedals) = (&scenario.vehicle, &scenario.driver.pedals);
        let change = &scenario.driver.speed_change;
        let rise = change.acceleration(parameters.rated_power_w, vehicle.mass_kg);
        scenarios.push(json!({
            "cycle_id": id,
            "first_row": first_row,
            "rows": road.rows.len(),
            "mass_kg": vehicle.mass_kg,
            "driven_mass_kg": vehicle.driven_mass_kg,
            "drag_area_m2": vehicle.drag_area_m2,
            "auxiliary_power_w": vehicle.auxiliary_power_w,
            "fuel_factor": vehicle.map_factor,
            "proportional": pedals.proportional,
            "integral": pedals.integral,
            "derivative": pedals.derivative,
            "threshold_mps": pedals.threshold_mps,
            "deceleration_mps2": change.deceleration_mps2,
            "rise_from_rest": rise.from_rest,
            "rise_per_mps": rise.per_mps,
            "peak_ratio": change.peak_ratio,
            "slips_from": diesel.slips_from(vehicle.auxiliary_power_w),
        }));
        first_row += road.rows.len();
    }
    rows_file.flush()?;
    let answers: Result<Vec<Value>, Failure> =
        STEPS_S.iter().map(|step_s| answers(cycles, *step_s)).collect();
    let gears: Vec<Value> = parameters
        .gears
        .iter()
        .map(|gear| {
            json!({ "speed_ratio_per_m": gear.speed_ratio_per_m, "ratio": gear.ratio,
                "loss_share": gear.loss_share, "launches": gear.launches })
        })
        .collect();
    let cross_wind = &parameters.cross_wind;
    let scenarios = json!({
        "seed": SEED,
        "study": study.model(),
        "gears": gears,
        "cross_wind": { "coefficients_m2": cross_wind.coefficients_m2,
            "maximum_tangent": cross_wind.maximum_tangent },
        "idle_radps": idle_radps,
        "open_radps": gearbox.shift.open_share * idle_radps,
        "axle_per_m": gearbox.axle_ratio / vehicle_model.wheel_radius_m,
        "wheel_mass_kg": vehicle_model.wheel_mass_kg(),
        "scenarios": scenarios,
        "answers": answers?,
        "traces": traces(&study, folder, cycles.min(TRACES))?,
    });
    write(folder.join("scenarios.json"), serde_json::to_vec(&scenarios)?)?;
    Ok(())
}

/// The engine's answers at one step.
fn answers(cycles: u64, step_s: f64) -> Result<Value, Failure> {
    let study = study(&[&format!("simulation.step_s={step_s}")])?;
    let mut left = tasks(&study, cycles);
    let records = drive_tasks(&study, &mut |_| left.pop(), CpuLevel::best());
    let column = |of: fn(&Record) -> f64| -> Vec<f64> { records.iter().map(of).collect() };
    Ok(json!({
        "step_s": step_s,
        "simulated_s": column(|r| r.simulated_s),
        "distance_m": column(|r| r.distance_m),
        "wheel_energy_j": column(|r| r.wheel_energy_j),
        "fuel_kg": column(|r| r.amount(Carrier::LiquidFuel).unwrap_or(f64::NAN)),
    }))
}

/// Writes time without standstill, distance, speed and slope at the steps of some cycles.
fn traces(study: &Study, folder: &Path, cycles: u64) -> Result<Vec<usize>, Failure> {
    let mut file = BufWriter::new(File::create(folder.join("traces.f64"))?);
    let mut lengths = Vec::new();
    for id in 0..cycles {
        let trace = trace(study, SEED, id);
        let names = ["simulated_added_s", "position_m", "speed_mps", "grade"];
        let columns: Vec<&[f64]> = names
            .iter()
            .filter_map(|name| trace.columns.iter().find(|column| column.name == *name))
            .map(|column| column.values.as_slice())
            .collect();
        let mut time_s = 0.0;
        for k in 0..columns[0].len() {
            time_s += columns[0][k];
            for number in [time_s, columns[1][k], columns[2][k], columns[3][k]] {
                file.write_all(&number.to_le_bytes())?;
            }
        }
        lengths.push(columns[0].len());
    }
    file.flush()?;
    Ok(lengths)
}

/// Drives the same planned cycles again and again; prints what one round simulates.
fn drive_again(cycles: u64, rounds: u32, level: &str, sets: &[&str]) -> Result<(), Failure> {
    let study = study(sets)?;
    let level = CpuLevel::ALL
        .into_iter()
        .find(|known| known.name() == level && known.is_available())
        .ok_or("this CPU has no such level")?;
    // the same roads for each round: a task that comes back is driven again
    let mut ready = tasks(&study, cycles);
    let mut records = Vec::new();
    for _ in 0..rounds {
        let mut used = Vec::with_capacity(ready.len());
        records = drive_tasks(
            &study,
            &mut |back| {
                used.extend(back);
                ready.pop()
            },
            level,
        );
        ready = used;
    }
    let sum = |of: fn(&Record) -> f64| -> f64 { records.iter().map(of).sum() };
    let answer = json!({
        "simulated_s": sum(|r| r.simulated_s),
        "distance_m": sum(|r| r.distance_m),
        "wheel_energy_j": sum(|r| r.wheel_energy_j),
        "fuel_kg": sum(|r| r.amount(Carrier::LiquidFuel).unwrap_or(f64::NAN)),
    });
    println!("{answer}");
    Ok(())
}

/// Prints the lane-steps of one round: a trace has one row a step, and one a stop.
fn count_steps(cycles: u64, sets: &[&str]) -> Result<(), Failure> {
    let study = study(sets)?;
    let steps: usize = (0..cycles).map(|id| trace(&study, SEED, id).columns[0].values.len()).sum();
    println!("{steps}");
    Ok(())
}

/// The exact prescribed-speed mode for another program's vehicle and speed.
fn follow_given() -> Result<(), Failure> {
    let given: Value = serde_json::from_reader(stdin().lock())?;
    let list = |key: &str| serde_json::from_value::<Vec<f64>>(given[key].clone());
    let number = |key: &str| given[key].as_f64().ok_or_else(|| format!("no number `{key}`"));
    let cycle = DriveCycle::new(list("time_s")?, list("speed_mps")?, list("slope")?)?;
    let body = Body {
        mass_kg: number("mass_kg")?,
        wheel_mass_kg: number("wheel_mass_kg")?,
        drag_area_m2: number("drag_area_m2")?,
        drag_by_speed: ocmc_core::vehicle::resistance::DragBySpeed::NONE,
        rolling_coefficient: number("rolling_coefficient")?,
        air_density_kgpm3: number("air_density_kgpm3")?,
    };
    // only the wheels are looked at: an engine without limit and loss
    let engine = EfficiencyCurve {
        rated_power_w: 1e9,
        power_share: vec![0.0, 1.0],
        efficiency: vec![1.0, 1.0],
    };
    let mut driveline =
        EfficiencyDriveline { transmission_efficiency: 1.0, engine, auxiliary_power_w: 0.0 };
    let sum = follow(&cycle, &body, &mut driveline).ledger;
    println!("{}", json!({ "wheel_j": sum[Term::Wheel], "distance_m": sum[Term::Distance] }));
    Ok(())
}
