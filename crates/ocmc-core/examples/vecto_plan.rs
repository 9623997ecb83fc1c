//! Compares plans of VECTO's driver with the time series that VECTO 2.2 itself wrote.
//! `cargo run --release -p ocmc-core --example vecto_plan [TRACE [PART_OF_NAME]]`: with a TRACE of 1
//! the seconds of both are printed side by side. The data are looked for in `OCMC_DATA` or
//! `../shared/data`.
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "its output is a table, and a file that is not as expected ends it"
)]

use flate2::read::GzDecoder;
use ocmc_core::powertrain::GearOrder;
use ocmc_core::powertrain::diesel::DieselPowertrain;
use ocmc_core::prescribed::Body;
use ocmc_core::prescribed::vecto::{
    AccelerationTable, LookAhead, Mission, MissionRow, Overspeed, Plan, ShiftLine, ShiftPolygon,
    VectoDriver, plan,
};
use ocmc_core::vehicle::resistance::{DragBySpeed, DragBySpeedModel, GRAVITY_MPS2};
use serde_json::{Value, json};
use std::io::Read;
use std::path::{Path, PathBuf};

const RPM: f64 = std::f64::consts::PI / 30.0;
const KMPH: f64 = 1.0 / 3.6;
/// VECTO's gravity, in m/s².
const VECTO_GRAVITY_MPS2: f64 = 9.81;

/// Columns of a text file by name, without a mark of byte order, in latin-1 or UTF-8.
struct Table {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn read(path: &Path) -> Self {
        let bytes =
            std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let mut raw = Vec::new();
        if path.extension().is_some_and(|end| end == "gz") {
            GzDecoder::new(&bytes[..]).read_to_end(&mut raw).unwrap();
        } else {
            raw = bytes;
        }
        let text: String = raw.iter().filter(|byte| byte.is_ascii()).map(|b| *b as char).collect();
        let mut lines = text.lines();
        let names = lines.next().unwrap().split(',').map(|name| name.trim().to_owned()).collect();
        let number = |field: &str| field.trim().parse().unwrap_or(f64::NAN);
        let rows = lines.map(|line| line.split(',').map(number).collect());
        Self { names, rows: rows.collect() }
    }

    fn column(&self, name: &str) -> Vec<f64> {
        let k = self.names.iter().position(|have| have.starts_with(name)).unwrap();
        self.rows.iter().filter(|row| row.len() > k).map(|row| row[k]).collect()
    }

    fn try_column(&self, name: &str) -> Option<Vec<f64>> {
        self.names.iter().any(|have| have.starts_with(name)).then(|| self.column(name))
    }

    fn numbered(&self, k: usize) -> Vec<f64> {
        self.rows.iter().filter(|row| row.len() > k).map(|row| row[k]).collect()
    }
}

fn read_json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap();
    let value: Value = serde_json::from_str(text.trim_start_matches('\u{feff}')).unwrap();
    value["Body"].clone()
}

fn scaled(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|value| value * factor).collect()
}

/// Least squares of T_loss = c0 + c2 w + c1 |T| over a loss map: c0 in Nm, c2 in Nm s, c1. Torques
/// beyond those of the engine are left out: there the maps of the declaration bend.
fn loss_law(path: &Path, most_nm: f64) -> [f64; 3] {
    let table = Table::read(path);
    let [speed, torque, loss] = [0, 1, 2].map(|k| table.numbered(k));
    let mut matrix = [[0.0; 4]; 3];
    for ((n, t), y) in speed.iter().zip(&torque).zip(&loss) {
        if *t > most_nm {
            continue;
        }
        let x = [1.0, n * RPM, t.abs()];
        for (i, row) in matrix.iter_mut().enumerate() {
            for j in 0..3 {
                row[j] += x[i] * x[j];
            }
            row[3] += x[i] * y;
        }
    }
    for i in 0..3 {
        for k in 0..3 {
            if k != i {
                let factor = matrix[k][i] / matrix[i][i];
                for j in 0..4 {
                    matrix[k][j] -= factor * matrix[i][j];
                }
            }
        }
    }
    // beyond rounding there is no sign
    [0, 1, 2].map(|i| (matrix[i][3] / matrix[i][i]).max(0.0))
}

fn powertrain(folder: &Path, radius_m: f64) -> DieselPowertrain {
    let engine = read_json(&folder.join("40t_Long_Haul_Truck.veng"));
    let gearbox = read_json(&folder.join("40t_Long_Haul_Truck.vgbx"));
    let curve = Table::read(&folder.join("40t_Long_Haul_Truck.vfld"));
    let speed = scaled(&curve.numbered(0), RPM);
    let (full, drag) = (curve.numbered(1), curve.numbered(2));
    let map: Vec<Vec<f64>> = speed
        .iter()
        .map(|w| [0.0, 1000.0, 2500.0].map(|t| 5.5e-8 * w * t + 3e-4).to_vec())
        .collect();
    let engine_model = json!({
        "inertia_kgm2": engine["Inertia"], "idle_speed_radps": engine["IdlingSpeed"].as_f64().unwrap() * RPM,
        "torque_lag_s": 0.5, "full_load_speed_radps": speed, "full_load_torque_nm": full,
        "map_speed_radps": speed, "drag_torque_nm": drag,
        "map_torque_nm": [0.0, 1000.0, 2500.0], "map_fuel_kgps": map, "fuel_factor": 1.0,
        "fuel": { "density_kgpm3": 832.0, "heating_value_jpkg": 4.28e7, "co2_kg_per_kg": 3.16 },
    });
    let gears = gearbox["Gears"].as_array().unwrap();
    let file = |k: usize| folder.join(gears[k]["LossMap"].as_str().unwrap().replace(' ', "_"));
    let most_nm = full.iter().copied().fold(0.0, f64::max);
    let axle = loss_law(&file(0), f64::INFINITY);
    let [first, last] = [1, gears.len() - 1].map(|k| loss_law(&file(k), most_nm));
    let ratio: Vec<f64> = gears[1..].iter().map(|gear| gear["Ratio"].as_f64().unwrap()).collect();
    let gearbox_model = json!({
        "ratio": ratio, "loss_torque_nm": first[0], "loss_torque_nms": first[1],
        "indirect_loss_share": first[2], "direct_loss_share": last[2],
        "retarder_torque_nm": 0.0, "axle_ratio": gears[0]["Ratio"],
        "axle_loss_torque_nm": axle[0], "axle_loss_share": axle[2],
        "shift": { "duration_s": 1.0, "interval_s": 2.0, "minimum_speed_mps": 0.5,
            "opposite_interval_s": 10.0, "before_ramp_s": 4.0, "minimum_acceleration_mps2": 0.1,
            "up_speed_radps": 95.0, "up_pedal_radps": 32.0, "down_speed_radps": 88.0,
            "down_pedal_radps": 20.0, "overspeed_radps": 219.0, "power_share": 0.95,
            "power_reserve": 1.1, "most_steps": 3, "kickdown_pedal": 0.99, "kickdown_s": 2.0,
            "kickdown_speed_radps": 136.0, "start_gear": 1, "steep_start_gear": 1,
            "steep_slope": 0.05, "launch_gears": 1, "launch_speed_radps": 84.0, "open_share": 0.9 },
    });
    DieselPowertrain::new(
        &serde_json::from_value(engine_model).unwrap(),
        &serde_json::from_value(gearbox_model).unwrap(),
        radius_m,
        0.0,
    )
}

/// A tyre's axle: share of the weight, twin tyres, coefficient and load of the test, inertia.
struct Axle {
    share: f64,
    twin: bool,
    coefficient: f64,
    load_n: f64,
    inertia_kgm2: f64,
}

fn body(mass_kg: f64, axles: &[Axle], radius_m: f64, drag: (f64, DragBySpeed)) -> Body {
    let weight_n = mass_kg * VECTO_GRAVITY_MPS2;
    let rolling = |axle: &Axle| {
        let tyres = if axle.twin { 4.0 } else { 2.0 };
        axle.share
            * axle.coefficient
            * libm::pow(axle.share * weight_n / (axle.load_n * tyres), -0.1)
    };
    let wheels = |axle: &Axle| {
        (if axle.twin { 4.0 } else { 2.0 }) * axle.inertia_kgm2 / (radius_m * radius_m)
    };
    // VECTO's gravity is another one: the weight is kept, and the inertia
    let mass = mass_kg * VECTO_GRAVITY_MPS2 / GRAVITY_MPS2;
    Body {
        mass_kg: mass,
        wheel_mass_kg: axles.iter().map(wheels).sum::<f64>() - (mass - mass_kg),
        drag_area_m2: drag.0,
        drag_by_speed: drag.1,
        rolling_coefficient: axles.iter().map(rolling).sum(),
        air_density_kgpm3: 1.188,
    }
}

fn axles_of(vehicle: &Value, share: Option<&[f64]>) -> Vec<Axle> {
    let axle = |(k, axle): (usize, &Value)| Axle {
        share: share.map_or_else(|| axle["AxleWeightShare"].as_f64().unwrap(), |share| share[k]),
        twin: axle["TwinTyres"].as_bool().unwrap(),
        coefficient: axle["RRCISO"].as_f64().unwrap(),
        load_n: axle["FzISO"].as_f64().unwrap(),
        inertia_kgm2: axle["Inertia"].as_f64().unwrap(),
    };
    vehicle["AxleConfig"]["Axles"].as_array().unwrap().iter().enumerate().map(axle).collect()
}

fn driver(data: &Path, folder: &Path, job: &str) -> VectoDriver {
    let job = read_json(&folder.join(job));
    let gearbox = read_json(&folder.join("40t_Long_Haul_Truck.vgbx"));
    let table = Table::read(&data.join("vecto/Truck.vacc"));
    let mut driver = VectoDriver::new(AccelerationTable {
        speed_mps: scaled(&table.numbered(0), KMPH),
        acceleration_mps2: table.numbered(1),
        deceleration_mps2: table.numbered(2),
    });
    let number = |value: &Value| value.as_f64().unwrap();
    if job["LAC"]["Enabled"] == true {
        driver.look_ahead = Some(LookAhead::Window {
            deceleration_mps2: number(&job["LAC"]["Dec"]),
            minimum_speed_mps: number(&job["LAC"]["MinSpeed"]) * KMPH,
        });
    }
    let over = &job["OverSpeedEcoRoll"];
    if over["Mode"] == "OverSpeed" {
        driver.overspeed = Some(Overspeed {
            minimum_speed_mps: number(&over["MinSpeed"]) * KMPH,
            above_mps: number(&over["OverSpeed"]) * KMPH,
        });
    }
    let polygon = gearbox["Gears"][1]["ShiftPolygon"].as_str().unwrap();
    if polygon != "-" {
        let lines = Table::read(&folder.join(polygon));
        let line = |k: usize| ShiftLine {
            torque_nm: lines.numbered(0),
            speed_radps: scaled(&lines.numbered(k), RPM),
        };
        driver.shift_polygons = vec![ShiftPolygon { down: line(1), up: line(2) }];
    }
    driver
}

fn mission(path: &Path) -> Mission {
    let table = Table::read(path);
    let added = table.try_column("<Padd>");
    let [s, v, grad, stop] = ["<s>", "<v>", "<grad>", "<stop>"].map(|name| table.column(name));
    let rows: Vec<MissionRow> = (0..s.len())
        .map(|k| MissionRow {
            distance_m: s[k],
            target_mps: v[k] * KMPH,
            gradient: grad[k] / 100.0,
            stop_s: stop[k],
            auxiliary_w: added.as_ref().map_or(0.0, |added| added[k] * 1000.0),
        })
        .collect();
    Mission::new(&rows).unwrap()
}

/// A time series of VECTO: node speeds in m/s, and the gears, 0 for none.
struct Series {
    speed_mps: Vec<f64>,
    gear: Vec<usize>,
    table: Table,
}

fn series(path: &Path) -> Series {
    let table = Table::read(path);
    let (mean, change) = (table.column("v_act"), table.column("acc"));
    let mut speed_mps = vec![mean[0] * KMPH - 0.5 * change[0]];
    for a in &change {
        speed_mps.push(speed_mps[speed_mps.len() - 1] + a);
    }
    let gear = table.column("Gear").iter().map(|gear| *gear as usize).collect();
    Series { speed_mps, gear, table }
}

fn gear_number(order: GearOrder) -> usize {
    if let GearOrder::Engaged(gear) = order { gear + 1 } else { 0 }
}

/// Speeds on a grid of a metre.
fn over_distance(speed_mps: &[f64]) -> Vec<f64> {
    let (mut grid, mut way_m) = (Vec::new(), 0.0);
    for pair in speed_mps.windows(2) {
        let end_m = way_m + 0.5 * (pair[0] + pair[1]);
        while (grid.len() as f64) < end_m {
            let share = (grid.len() as f64 - way_m) / (end_m - way_m);
            grid.push(pair[0] + (pair[1] - pair[0]) * share.max(0.0));
        }
        way_m = end_m;
    }
    grid
}

fn shifts(gears: &[usize]) -> usize {
    let engaged: Vec<usize> = gears.iter().copied().filter(|gear| *gear > 0).collect();
    engaged.windows(2).filter(|pair| pair[0] != pair[1]).count()
}

/// Prints a line, and the seconds where they are asked for; the RMS of speed in km/h.
fn compare(name: &str, plan: &Plan, mission: &Mission, want: &Series, trace: bool) -> f64 {
    let gears: Vec<usize> = plan.seconds.iter().map(|second| gear_number(second.gear)).collect();
    let (have, reference) = (over_distance(&plan.speed_mps), over_distance(&want.speed_mps));
    let squares: f64 = have.iter().zip(&reference).map(|(a, b)| (a - b) * (a - b)).sum();
    let common = have.len().min(reference.len()).max(1);
    let rms_kmph = (squares / common as f64).sqrt() / KMPH;
    let same = gears.iter().zip(&want.gear).filter(|(a, b)| a == b).count();
    let seconds = gears.len().max(want.gear.len());
    let way: f64 = want.speed_mps.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).sum();
    println!(
        "{name:48} {rms_kmph:6.3} {:5.1} {:6} {:6} {:5} {:5} {:9.1} {way:9.1} {:8.1}",
        100.0 * same as f64 / seconds as f64,
        gears.len(),
        want.gear.len(),
        shifts(&gears),
        shifts(&want.gear),
        plan.distance_m(),
        mission.length_m(),
    );
    if trace {
        let column = |name| want.table.column(name);
        let (grad, n, target) = (column("grad"), column("n ["), column("v_targ"));
        let mut lines = 0;
        for k in 0..seconds.min(want.gear.len()).min(gears.len()) {
            let v = [&plan.speed_mps, &want.speed_mps].map(|v| v[k + 1] / KMPH);
            let second = &plan.seconds[k];
            let off = (v[0] - v[1]).abs() > 0.01 || gears[k] != want.gear[k];
            lines += usize::from(off);
            let range = std::env::args().nth(3).and_then(|from| from.parse::<usize>().ok());
            let show = range.map_or(k < 20 || off, |from| k >= from);
            if show && lines < 40 {
                println!(
                    "{k:5} v {:8.3} {:8.3} gear {:2} {:2} slope {:8.4} {:8.4} target {:7.2} {:7.2} n {:7.1} {}",
                    v[0],
                    v[1],
                    gears[k],
                    want.gear[k],
                    second.gradient * 100.0,
                    grad[k],
                    second.target_mps / KMPH,
                    target[k],
                    n[k],
                    if off { "*" } else { "" }
                );
            }
        }
    }
    rms_kmph
}

/// CdA in m² by VECTO's correction for cross wind of a tractor-semitrailer: constant up to 60 km/h,
/// a parabola above that meets VECTO's values at 75 and 90 km/h.
fn declared_drag() -> (f64, DragBySpeed) {
    let (base, [(u, y), (x, z)]) = (7.9553, [(15.0 * KMPH, 7.5075), (30.0 * KMPH, 7.2150)]);
    let (p, q) = ((y / base - 1.0) / u, (z / base - 1.0) / x);
    let per_mps2 = (q - p) / (x - u);
    let model = DragBySpeedModel { from_mps: 60.0 * KMPH, per_mps: p - per_mps2 * u, per_mps2 };
    (base, model.prepare())
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.to_string_lossy().contains(".vmod"))
        .collect();
    found.sort();
    found
}

fn main() {
    let data = std::env::var("OCMC_DATA").unwrap_or_else(|_| "../shared/data".to_owned());
    let data = PathBuf::from(data);
    let trace = std::env::args().nth(1).is_some_and(|argument| argument == "1");
    let part = std::env::args().nth(2).unwrap_or_default();
    let results = data.join("vecto/results");
    println!(
        "series: RMS km/h, same gear %, s, s of VECTO, shifts, of VECTO, m, of VECTO, of the mission"
    );
    let (mut runs, mut good) = (0, 0);
    for set in ["manoeuvres_40t", "manoeuvres_40t_overspeed"] {
        let folder = results.join(set);
        let vehicle = read_json(&folder.join("40t_Long_Haul_Truck.vveh"));
        let radius_m = vehicle["rdyn"].as_f64().unwrap() / 1000.0;
        let truck = powertrain(&folder, radius_m);
        let mass_kg = ["CurbWeight", "CurbWeightExtra", "Loading"]
            .iter()
            .map(|key| vehicle[*key].as_f64().unwrap())
            .sum();
        let drag = (vehicle["CdA"].as_f64().unwrap(), DragBySpeed::NONE);
        let body = body(mass_kg, &axles_of(&vehicle, None), radius_m, drag);
        let driver = driver(&data, &folder, "40t_Long_Haul_Truck.vecto");
        for path in files(&folder) {
            let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
            let cycle = stem.trim_start_matches("40t_Long_Haul_Truck_");
            if !format!("{set}/{stem}").contains(&part) {
                continue;
            }
            let mission = mission(&results.join("manoeuvre_cycles").join(format!("{cycle}.vdri")));
            let plan = plan(&mission, &body, &truck, 0.0, &driver);
            runs += 1;
            let name = cycle.trim_start_matches("Cycle_");
            good += usize::from(compare(name, &plan, &mission, &series(&path), trace) <= 2.0);
        }
    }
    println!("{good} of {runs} manoeuvres within 2 km/h");

    let folder = results.join("declaration_40t");
    let vehicle = read_json(&folder.join("40t_Long_Haul_Truck.vveh"));
    let radius_m = 0.4882675;
    let truck = powertrain(&folder, radius_m);
    let driver = driver(&data, &folder, "40t_Long_Haul_Truck.vecto");
    let trailer = |share: f64| Axle {
        share,
        twin: false,
        coefficient: 0.00555,
        load_n: 37_500.0,
        inertia_kgm2: 19.2,
    };
    for (file, cycle, payload_kg, front, auxiliary_w) in [
        ("Long_Haul_Full", "LongHaul", 25_400.0, [0.2, 0.25], 4893.429),
        ("Long_Haul_Reference", "LongHaul", 19_300.0, [0.2, 0.25], 4893.429),
        ("Regional_Delivery_Reference", "RegionalDelivery", 12_900.0, [0.25, 0.25], 5105.143),
        ("Regional_Delivery_Empty", "RegionalDelivery", 0.0, [0.25, 0.25], 5105.143),
    ] {
        if !file.contains(&part) {
            continue;
        }
        let mut axles = axles_of(&vehicle, Some(&front));
        let rest = 1.0 - front[0] - front[1];
        axles.extend([trailer(rest / 3.0), trailer(rest / 3.0), trailer(rest / 3.0)]);
        let body = body(14_600.0 + payload_kg, &axles, radius_m, declared_drag());
        let mission = mission(&data.join(format!("vecto/cycles/{cycle}.vdri")));
        let clock = std::time::Instant::now();
        let plan = plan(&mission, &body, &truck, auxiliary_w, &driver);
        let took = clock.elapsed();
        let path = folder.join(format!("40t_Long_Haul_Truck_{file}_Loading.vmod.gz"));
        compare(file, &plan, &mission, &series(&path), trace);
        println!("    planned in {took:.1?}");
    }
}
