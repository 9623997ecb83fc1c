//! Conventional vehicles of FASTSim 2 (`.yaml`) as vehicles of studies.
//!
//! Source: FASTSim 2 (NREL), `vehicle.rs` and the files of its `vehdb`: the mass is
//! `veh_override_kg`, or else `veh_kg`, both with the cargo; the engine is a peak power and an
//! efficiency over the share of it; the driveline is an efficiency. What it does not say is that of
//! a built-in vehicle: engine speeds and the shape of full load, scaled to the peak power, gears by
//! the wheels' radius.

use super::builtin::{VEHICLE, read as built_in};
use super::files::{Files, ForeignVehicle};
use super::node::Node;
use crate::intake::table::source::{ending, read_text};
use ocmc_core::powertrain::efficiency::EfficiencyCurve;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// Built-in vehicles that lend what a file does not say, up to a mass in kg with the cargo.
const BASES: [(f64, &str); 3] =
    [(3500.0, "van-3500kg"), (12_000.0, "rigid-12t"), (f64::INFINITY, "tractor-40t")];
/// Torques of the fuel map over the highest one: FASTSim's efficiencies bend at low power.
const TORQUE_SHARES: [f64; 16] =
    [0.0, 0.01, 0.02, 0.04, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];
/// Test load of a tyre, in N: of no meaning where the rolling coefficient holds at every load.
const ANY_LOAD_N: f64 = 20_000.0;

/// Reads a vehicle of FASTSim; none where a file is no YAML by its ending.
pub(super) fn read(path: &Path) -> Option<Result<ForeignVehicle, String>> {
    ["yaml", "yml"].contains(&ending(path).as_str()).then(|| {
        let text = read_text(path).map_err(|error| error.to_string())?;
        vehicle(&Keys::of(&text)).map_err(|reason| format!("`{}`: {reason}", path.display()))
    })
}

/// Keys of a flat YAML file with their values; of a list its numbers, which may stand under `data`.
struct Keys<'a> {
    values: BTreeMap<&'a str, &'a str>,
    lists: BTreeMap<&'a str, Vec<f64>>,
}

impl<'a> Keys<'a> {
    fn of(text: &'a str) -> Self {
        let mut keys = Self { values: BTreeMap::new(), lists: BTreeMap::new() };
        let (mut key, mut is_data) = ("", true);
        for line in text.lines() {
            let inside = line.trim();
            if let Some(item) = inside.strip_prefix("- ").filter(|_| is_data) {
                keys.lists.entry(key).or_default().extend(item.trim().parse::<f64>());
            } else if let Some((name, value)) = inside.split_once(':') {
                let is_top = !line.starts_with(char::is_whitespace);
                is_data = is_top || name == "data";
                if is_top {
                    key = name;
                    keys.values.insert(key, value.trim().trim_matches(['"', '\'']));
                }
                if let Some(row) = value.trim().strip_prefix('[').filter(|_| is_data) {
                    let cells = row.trim_end_matches(']').split(',');
                    let numbers = cells.filter_map(|cell| cell.trim().parse::<f64>().ok());
                    keys.lists.insert(key, numbers.collect());
                }
            }
        }
        keys
    }

    /// A number, where it is there.
    fn some(&self, key: &str) -> Option<f64> {
        self.values.get(key)?.parse().ok()
    }

    /// A number between two bounds.
    fn number(&self, key: &str, [low, high]: [f64; 2]) -> Result<f64, String> {
        let value = self.values.get(key).copied().unwrap_or("missing");
        self.some(key).filter(|number| *number > low && *number <= high).ok_or_else(|| {
            format!("`{key}` is {value}, allowed is a number above {low} and up to {high}")
        })
    }

    fn list(&self, key: &str) -> Vec<f64> {
        self.lists.get(key).cloned().unwrap_or_default()
    }

    /// The engine.
    fn engine(&self) -> Result<EfficiencyCurve, String> {
        let rated_power_w = 1000.0 * self.number("fc_max_kw", [1.0, 2000.0])?;
        let (power_share, efficiency) = (self.list("fc_pwr_out_perc"), self.list("fc_eff_map"));
        let is_sound = power_share.len() > 1
            && power_share.len() == efficiency.len()
            && power_share.windows(2).all(|pair| pair[1] > pair[0])
            && power_share[0] >= 0.0
            && efficiency.iter().all(|share| *share > 0.0 && *share < 1.0);
        let allowed = "`fc_pwr_out_perc` and `fc_eff_map` have to be equally many rising shares of \
                       the power and efficiencies above 0 and below 1";
        is_sound
            .then_some(EfficiencyCurve { rated_power_w, power_share, efficiency })
            .ok_or_else(|| allowed.to_owned())
    }
}

fn vehicle(keys: &Keys) -> Result<ForeignVehicle, String> {
    match keys.values.get("veh_pt_type").copied() {
        Some("Conv") => {}
        Some(kind) => {
            return Err(format!(
                "`veh_pt_type` is `{kind}`, allowed is `Conv`: its battery and motor are not read"
            ));
        }
        None => {
            return Err(
                "it lacks `veh_pt_type`: allowed are vehicles of FASTSim 2 in YAML (those of \
                        FASTSim 3 are not read)"
                    .to_owned(),
            );
        }
    }
    let above = |high| [0.0, high];
    let cargo_kg = keys.some("cargo_kg").filter(|kg| *kg > 0.0).unwrap_or(0.0);
    let own = keys.some("veh_override_kg").is_some_and(|kg| kg > 0.0);
    let mass_kg = keys.number(if own { "veh_override_kg" } else { "veh_kg" }, above(150e3))?;
    if cargo_kg >= mass_kg {
        return Err(format!("`cargo_kg` is {cargo_kg}, allowed is less than the mass, {mass_kg}"));
    }
    let drag_area_m2 =
        keys.number("drag_coef", above(5.0))? * keys.number("frontal_area_m2", above(30.0))?;
    let rolling = keys.number("wheel_rr_coef", above(0.1))?;
    let radius_m = keys.number("wheel_radius_m", above(2.0))?;
    let inertia_kgm2 = keys.number("wheel_inertia_kg_m2", above(1000.0))?
        * keys.number("num_wheels", above(100.0))?;
    let driven = keys.number("drive_axle_weight_frac", above(1.0))?.min(0.999);
    let loss_share = 1.0 - keys.number("trans_eff", above(1.0))?;
    let alternator = keys.number("alt_eff", above(1.0))?;
    let auxiliary_w = 1000.0 * keys.number("aux_kw", [-1.0, 200.0])?.max(0.0) / alternator;
    let curve = keys.engine()?;
    let base = BASES.into_iter().find(|(most_kg, _)| mass_kg <= *most_kg);
    let base = base.map_or("tractor-40t", |(_, name)| name);
    let beneath = built_in(Path::new(base), "vehicle.base", VEHICLE, &Files::Refused)
        .and_then(|text| Node::parse(&text.source))
        .map_err(|fault| fault.message())?
        .to_json();
    let (engine, scale) = engine_keys(&curve, &beneath["powertrain"]["combustion"]["engine"]);
    let axle = |share: f64, driven: bool| {
        json!({
            "load_share": share, "driven": driven, "iso_rolling_coefficient": rolling,
            "iso_load_n": ANY_LOAD_N, "tyres": 4,
        })
    };
    let of_base = |key: &str| beneath[key].as_f64().unwrap_or(1.0);
    let axle_ratio = &beneath["powertrain"]["combustion"]["gearbox"]["axle_ratio"];
    let axle_ratio = axle_ratio.as_f64().unwrap_or(1.0) * radius_m / of_base("wheel_radius_m");
    let vehicle = json!({
        "curb_mass_kg": mass_kg - cargo_kg,
        "drag_area_m2": drag_area_m2,
        "axles": [axle(1.0 - driven, false), axle(driven, true)],
        "rolling_factor": 1.0,
        // the coefficient is that at every load
        "rolling_load_exponent": 1.0,
        "wheel_radius_m": radius_m,
        "wheel_inertia_kgm2": inertia_kgm2,
        "auxiliary_power_w": auxiliary_w,
        "powertrain": { "combustion": {
            "engine": engine,
            "gearbox": {
                "axle_ratio": axle_ratio,
                "loss_torque_nm": 0.0, "loss_torque_nms": 0.0, "loss_floor_nm": 0.0,
                "direct_loss_share": loss_share, "indirect_loss_share": loss_share,
                "axle_loss_torque_nm": 0.0, "axle_loss_share": 0.0,
                "retarder_torque_nm": 0.0, "retarder_torque_nms2": 0.0,
            },
        } },
    });
    Ok(ForeignVehicle { keys: vehicle, base, notes: notes(keys, base, scale, cargo_kg) })
}

/// Keys of an engine whose full load is that of another one scaled to a peak power, with the scale.
fn engine_keys(curve: &EfficiencyCurve, of_base: &Value) -> (Value, f64) {
    let list = |key: &str| -> Vec<f64> {
        let values = of_base[key].as_array().into_iter().flatten();
        values.filter_map(Value::as_f64).collect()
    };
    let (speeds, torques) = (list("full_load_speed_radps"), list("full_load_torque_nm"));
    let peak_w = speeds.iter().zip(&torques).map(|(radps, nm)| radps * nm).fold(1.0, f64::max);
    let scale = curve.rated_power_w / peak_w;
    let drag_nm: Vec<f64> = list("drag_torque_nm").iter().map(|nm| scale * nm).collect();
    let most_nm = scale * torques.iter().copied().fold(0.0, f64::max);
    let map_nm = TORQUE_SHARES.map(|share| share * most_nm);
    let heat_jpkg = of_base["fuel"]["heating_value_jpkg"].as_f64().unwrap_or(f64::INFINITY);
    let fuel_kgps = |radps: &f64| map_nm.map(|nm| curve.input_w(radps * nm) / heat_jpkg);
    let map_radps = list("map_speed_radps");
    let keys = json!({
        "inertia_kgm2": scale * of_base["inertia_kgm2"].as_f64().unwrap_or(0.0),
        // the end of a curve is at least the model's smallest torque
        "full_load_torque_nm": torques.iter().map(|nm| (scale * nm).max(1.0)).collect::<Vec<_>>(),
        "drag_torque_nm": drag_nm,
        "map_torque_nm": map_nm,
        "map_fuel_kgps": map_radps.iter().map(fuel_kgps).collect::<Vec<_>>(),
        "fuel_factor": 1.0,
    });
    (keys, scale)
}

/// Notes on what of a file is not used, and on what is assumed.
fn notes(keys: &Keys, base: &str, scale: f64, cargo_kg: f64) -> Vec<String> {
    let mut notes = vec![format!(
        "assumed, as of `{base}`: engine speeds, the shape of full load, drag torque and inertia \
         of the engine (times {scale:.3}, so that the peak power is that of the file), gears, \
         shifting, brakes, cross wind, growth of the rolling resistance in cold, diesel as the fuel"
    )];
    if cargo_kg > 0.0 {
        notes.push(format!("`cargo_kg` {cargo_kg}: set `mission.payload_kg` to carry it"));
    }
    let unused = ["fc_sec_to_peak_pwr", "idle_fc_kw", "wheel_coef_of_fric"];
    let there = unused.into_iter().filter(|key| keys.some(key).is_some());
    let there: Vec<String> = there.map(|key| format!("`{key}`")).collect();
    if !there.is_empty() {
        notes.push(format!("{}: without a counterpart, not used", there.join(", ")));
    }
    if keys.values.get("stop_start") == Some(&"true") {
        notes.push("`stop_start`: the engine idles at standstill".to_owned());
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intake::table::Source;
    use crate::study::{LoadedStudy, load};
    use ocmc_core::energy::Carrier;
    use ocmc_core::energy::ledger::Term;
    use ocmc_core::operating_cycle::weather::STANDARD_WEATHER;
    use ocmc_core::powertrain::efficiency::EfficiencyDriveline;
    use ocmc_core::prescribed::{Body, DriveCycle, follow, follow_study};
    use ocmc_core::vehicle::resistance::{DragBySpeed, GRAVITY_MPS2};

    /// A vehicle with the keys that are needed, lists in both spellings.
    const FILE: &str = "---\nscenario_name: a truck\nveh_pt_type: Conv\ndrag_coef: 0.5\n\
        frontal_area_m2: 10.0\ncargo_kg: 1000.0\nveh_override_kg: \nveh_kg: 11000.0\n\
        drive_axle_weight_frac: 0.6\nfc_max_kw: 200.0\n\
        fc_pwr_out_perc:\n  v: 1\n  dim:\n    - 3\n  data:\n    - 0.0\n    - 0.5\n    - 1.0\n\
        fc_eff_map: [0.36, 0.4, 0.38]\nidle_fc_kw: 0.5\n\
        wheel_inertia_kg_m2: 5.0\nnum_wheels: 6.0\nwheel_rr_coef: 0.007\nwheel_radius_m: 0.45\n\
        alt_eff: 0.5\naux_kw: 2.0\ntrans_eff: 0.9\nval_range_miles: .nan\n";

    /// Neither spread nor weather, the cargo of the file, and no cold.
    const SETS: [&str; 3] = [
        "simulation.without=[\"driver_spread\", \"vehicle_spread\", \"weather\", \"traffic\"]",
        "mission.payload_kg=1000",
        "vehicle.rolling_temperature_coefficient_per_k=0",
    ];

    fn loaded(text: &str, sets: &[&str]) -> Result<LoadedStudy, String> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("truck.yaml"), text).unwrap();
        let study =
            "study.name = \"a\"\nstudy.base = \"field-truck\"\nvehicle.base = \"truck.yaml\"";
        std::fs::write(folder.path().join("study.toml"), study).unwrap();
        let path = folder.path().join("study.toml");
        load(&path.to_string_lossy(), sets).map_err(|error| error.to_string())
    }

    #[test]
    fn a_vehicle_has_the_numbers_of_its_file() {
        let loaded = loaded(FILE, &[]).unwrap();
        let vehicle = &loaded.model.vehicle;
        assert_eq!(vehicle.curb_mass_kg, 10_000.0);
        assert_eq!((vehicle.wheel_radius_m, vehicle.wheel_inertia_kgm2), (0.45, 30.0));
        assert_eq!(vehicle.auxiliary_power_w.centre(), 4000.0);
        let warnings = loaded.warnings().join("\n");
        for words in ["as of `rigid-12t`", "`cargo_kg` 1000", "`idle_fc_kw`: without a counterpart"]
        {
            assert!(warnings.contains(words), "{warnings}");
        }
    }

    #[test]
    fn forces_and_fuel_are_those_of_fastsims_equations() {
        let study = loaded(FILE, &SETS).unwrap().study;
        let (speed_mps, slope, rows) = (20.0, 0.02, 101);
        let time_s = (0..rows).map(f64::from).collect();
        let cycle = DriveCycle::new(time_s, vec![speed_mps; 101], vec![slope; 101]).unwrap();
        let (_, followed) = follow_study(&study, 1, 0, &cycle);
        let way_m = speed_mps * f64::from(rows - 1);
        let (mass_kg, cosine) = (11_000.0, (1.0 - slope * slope).sqrt());
        let drag_n = 0.5 * STANDARD_WEATHER.air_density_kgpm3(0.0) * 5.0 * speed_mps * speed_mps;
        let rolling_n = 0.007 * mass_kg * GRAVITY_MPS2 * cosine;
        let force_n = drag_n + rolling_n + mass_kg * GRAVITY_MPS2 * slope;
        let curve = Keys::of(FILE).engine().unwrap();
        let fuel_n = curve.input_w(force_n * speed_mps / 0.9 + 4000.0) / speed_mps;
        for (term, wanted_n, apart) in [
            (Term::Drag, drag_n, 1e-3),
            (Term::Rolling, rolling_n, 1e-6),
            (Term::Wheel, force_n, 1e-3),
            (Term::FuelEnergy, fuel_n, 0.01),
        ] {
            let found_n = followed.ledger[term] / way_m;
            assert!((found_n / wanted_n - 1.0).abs() < apart, "{term:?}: {found_n} {wanted_n}");
        }
    }

    #[test]
    #[expect(clippy::print_stdout, reason = "a test that compares nothing says so")]
    fn over_cycles_the_published_trucks_burn_what_fastsims_equations_say() {
        let beside = || concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data").into();
        let data = std::env::var_os("OCMC_DATA").map_or_else(beside, std::path::PathBuf::from);
        let cycles = ["long_haul_cyc", "regional_haul"];
        // what the guide says, in L/100 km
        for (truck, said) in [
            ("Line_Haul_Conv", [38.25, 42.62]),
            ("Regional_Delivery_Class_8_Truck", [43.14, 45.41]),
            ("Class_4_Box_Truck", [24.91, 22.15]),
        ] {
            let file = data.join(format!("vehicles/fastsim/{truck}.yaml"));
            let Ok(text) = std::fs::read_to_string(&file) else {
                println!("skipped: no {}", file.display());
                return;
            };
            let keys = Keys::of(&text);
            let number = |key| keys.some(key).unwrap();
            let payload = format!("mission.payload_kg={}", number("cargo_kg"));
            let study = loaded(&text, &[SETS[0], SETS[2], &payload]).unwrap().study;
            let radius_m = number("wheel_radius_m");
            let body = Body {
                mass_kg: number("veh_kg"),
                wheel_mass_kg: number("wheel_inertia_kg_m2") * number("num_wheels")
                    / (radius_m * radius_m),
                drag_area_m2: number("drag_coef") * number("frontal_area_m2"),
                drag_by_speed: DragBySpeed::NONE,
                rolling_coefficient: number("wheel_rr_coef"),
                air_density_kgpm3: STANDARD_WEATHER.air_density_kgpm3(0.0),
            };
            let driveline = EfficiencyDriveline {
                transmission_efficiency: number("trans_eff"),
                engine: keys.engine().unwrap(),
                auxiliary_power_w: 1000.0 * number("aux_kw"),
            };
            for (cycle, l_per_100km) in cycles.into_iter().zip(said) {
                let file = data.join(format!("cycles/t3co/{cycle}.csv.gz"));
                let cycle_of = crate::drive_cycle::read(Source::File(&file), &[]).unwrap();
                let (record, ours) = follow_study(&study, 1, 0, &cycle_of);
                let theirs = follow(&cycle_of, &body, &mut driveline.clone());
                let apart = |term: Term| ours.ledger[term] / theirs.ledger[term] - 1.0;
                let consumption = record.consumption(Carrier::LiquidFuel).unwrap();
                assert!(
                    (consumption - l_per_100km).abs() < 0.006,
                    "{truck} {cycle}: {consumption}"
                );
                for (term, bound) in [
                    (Term::Drag, 1e-3),
                    (Term::Rolling, 1e-3),
                    (Term::Wheel, 0.01),
                    (Term::FuelEnergy, 0.025),
                ] {
                    assert!(apart(term).abs() < bound, "{truck} {cycle} {term:?}: {}", apart(term));
                }
            }
        }
    }

    #[test]
    fn what_is_no_such_vehicle_is_refused_by_its_key() {
        for (old, new, words) in [
            ("veh_pt_type: Conv", "veh_pt_type: HEV", "`veh_pt_type` is `HEV`"),
            ("veh_pt_type: Conv", "a: 1", "FASTSim 2"),
            ("trans_eff: 0.9", "trans_eff: 1.9", "`trans_eff` is 1.9, allowed"),
            ("wheel_radius_m: 0.45\n", "", "`wheel_radius_m` is missing"),
            ("[0.36, 0.4, 0.38]", "[0.36, 0.4]", "`fc_eff_map`"),
            ("cargo_kg: 1000.0", "cargo_kg: 12000", "`cargo_kg` is 12000"),
        ] {
            let message = loaded(&FILE.replace(old, new), &[]).unwrap_err();
            assert!(message.contains(words) && message.contains("truck.yaml"), "{message}");
        }
    }
}
