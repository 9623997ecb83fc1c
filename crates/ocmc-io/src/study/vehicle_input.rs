//! Vehicles as engineers have them: keys of a study that stand for others, worked out when the
//! study is loaded.
//!
//! | key | stands for |
//! |---|---|
//! | `vehicle.tyre_code` | `wheel_radius_m` |
//! | `vehicle.coast_down` | `drag_area_m2`, `axles`, `rolling_load_exponent` |
//! | `vehicle.powertrain.combustion.engine.full_load_file` (`.vfld`: speed in rpm, full-load and drag torque in Nm) | full-load and drag curves |
//! | `vehicle.powertrain.combustion.engine.map_file` (`.vmap`: speed in rpm, torque in Nm, fuel in g/h) | the fuel map |
//! | `vehicle.powertrain.combustion.gearbox.direct_loss_file`, `indirect_loss_file`, `axle_loss_file` (`.vtlm`: speed, torque, loss) | loss torques and shares, by least squares |
//! | `vehicle.powertrain.combustion.gearbox.retarder_loss_file` (`.vrlm`: speed, loss) | `retarder_torque_nm`, `retarder_torque_nms2`, by least squares |
//!
//! Files lie relative to the study. In place of a file stands `{ file, columns }` where columns
//! have other names.

use super::error::{Cause, Fault};
use super::files::Files;
use super::node::Node;
use crate::intake::fuel_map::judge as judge_fuel_map;
use crate::intake::table::formats::{ENGINE_CURVES, FUEL_MAP, LOSS_MAP};
use crate::intake::table::{Mapping, Quantity, Schema, Source, Table, TableError};
use crate::loss_law;
use ocmc_core::powertrain::component::engine::MOST_KNOTS;
use ocmc_core::powertrain::component::fuel_map::{FuelPoint, on_grid};
use ocmc_core::vehicle::coast_down::CoastDown;
use ocmc_core::vehicle::tyre::TyreSize;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, from_value, json};
use std::collections::BTreeMap;

/// Works out the keys that stand for others, in a tree whose bases are resolved.
pub(super) fn expand(tree: &mut Node, files: &Files) -> Result<(), Box<Fault>> {
    let Some(vehicle) = tree.get_mut("vehicle") else { return Ok(()) };
    if let Some(node) = take(vehicle, "tyre_code") {
        let code = text(&node, "vehicle.tyre_code")?;
        let size: TyreSize = code.parse().map_err(|error| file_fault(&node, &error))?;
        put(vehicle, &json!({ "wheel_radius_m": size.dynamic_radius_m() }))?;
    }
    if let Some(node) = take(vehicle, "coast_down") {
        let test = read_keys(&node, "vehicle.coast_down")?;
        put(vehicle, &coast_down(&test).map_err(|message| file_fault(&node, &message))?)?;
    }
    let powertrain = vehicle.get_mut("powertrain");
    let Some(combustion) = powertrain.and_then(|powertrain| powertrain.get_mut("combustion"))
    else {
        return Ok(());
    };
    if let Some(engine) = combustion.get_mut("engine") {
        engine_files(engine, files)?;
    }
    if let Some(gearbox) = combustion.get_mut("gearbox") {
        gearbox_files(gearbox, files)?;
    }
    Ok(())
}

fn coast_down(test: &CoastDown) -> Result<Value, &'static str> {
    let sound = test.mass_kg > 0.0 && test.air_density_kgpm3 > 0.0 && test.from_mps >= 0.0;
    if !(sound && test.to_mps > test.from_mps) {
        return Err("`vehicle.coast_down` needs a mass and a density above 0, and `to_mps` above \
             `from_mps`");
    }
    let (drag_area_m2, rolling) = test.resistance();
    // one axle of exponent 1 has the coefficient of the test at every load
    let axle = json!({
        "load_share": 1.0, "iso_rolling_coefficient": rolling, "iso_load_n": 10_000.0, "tyres": 4
    });
    Ok(json!({ "drag_area_m2": drag_area_m2, "axles": [axle], "rolling_load_exponent": 1.0 }))
}

fn engine_files(engine: &mut Node, files: &Files) -> Result<(), Box<Fault>> {
    let columns = [Quantity::EngineSpeed, Quantity::FullLoadTorque, Quantity::DragTorque];
    let path = "vehicle.powertrain.combustion.engine.full_load_file";
    let curves = numbers_of(engine, path, files, &ENGINE_CURVES, columns)?;
    if let Some([speed, full, _]) = &curves {
        put(engine, &full_load(speed, full))?;
    }
    let columns = [Quantity::EngineSpeed, Quantity::Torque, Quantity::FuelRate];
    let map = numbers_of(
        engine,
        "vehicle.powertrain.combustion.engine.map_file",
        files,
        &FUEL_MAP,
        columns,
    )?;
    if let Some([speed, torque, fuel]) = map {
        if let Some(finding) = judge_fuel_map(&speed, &torque, &fuel) {
            return Err(file_fault(engine, &finding));
        }
        put(engine, &fuel_map(&speed, &torque, &fuel))?;
    }
    if let Some([speed, _, drag]) = curves {
        let points: Vec<(f64, f64)> = speed.into_iter().zip(drag).collect();
        let speeds = engine.get("map_speed_radps").map(|speeds| from_value(speeds.to_json()));
        let speeds: Vec<f64> = speeds.and_then(Result::ok).unwrap_or_default();
        let torques: Vec<f64> = speeds.iter().map(|w| interpolate(&points, *w).min(-0.1)).collect();
        put(engine, &json!({ "drag_torque_nm": torques }))?;
    }
    Ok(())
}

/// The full-load curve as keys.
fn full_load(speed: &[f64], full: &[f64]) -> Value {
    // a curve may end at zero torque; the model's torques are above 0
    let points: Vec<(f64, f64)> =
        speed.iter().copied().zip(full.iter().copied()).filter(|p| p.1 >= 1.0).collect();
    let step = points.len().div_ceil(MOST_KNOTS).max(1);
    let last = points.len().saturating_sub(1);
    let kept = points.iter().enumerate().filter(|(k, _)| k % step == 0 || *k == last);
    let (speeds, torques): (Vec<f64>, Vec<f64>) = kept.map(|(_, point)| *point).unzip();
    json!({ "full_load_speed_radps": speeds, "full_load_torque_nm": torques })
}

fn fuel_map(speed: &[f64], torque: &[f64], fuel: &[f64]) -> Value {
    let points: Vec<FuelPoint> = (0..speed.len())
        .map(|k| FuelPoint { speed_radps: speed[k], torque_nm: torque[k], fuel_kgps: fuel[k] })
        .collect();
    // a map of one row comes back as empty lists, which the study's check refuses by name
    let grid = on_grid(&points);
    let (speeds, torques, rows) = grid
        .map_or_else(Default::default, |grid| (grid.speed_radps, grid.torque_nm, grid.fuel_kgps));
    json!({ "map_speed_radps": speeds, "map_torque_nm": torques, "map_fuel_kgps": rows })
}

fn gearbox_files(gearbox: &mut Node, files: &Files) -> Result<(), Box<Fault>> {
    let columns = [Quantity::EngineSpeed, Quantity::InputTorque, Quantity::LossTorque];
    let mut laws = Vec::new();
    for (path, share) in [
        ("vehicle.powertrain.combustion.gearbox.direct_loss_file", "direct_loss_share"),
        ("vehicle.powertrain.combustion.gearbox.indirect_loss_file", "indirect_loss_share"),
    ] {
        if let Some(losses) = numbers_of(gearbox, path, files, &LOSS_MAP, columns)? {
            let [constant, growth, slope] = loss_law::of_gear(&losses);
            laws.push([constant, growth]);
            put(gearbox, &json!({ share: slope }))?;
        }
    }
    if !laws.is_empty() {
        let [constant, growth] = [0, 1].map(|k| mean(laws.iter().map(|law| law[k])));
        put(gearbox, &json!({ "loss_torque_nm": constant, "loss_torque_nms": growth }))?;
    }
    let path = "vehicle.powertrain.combustion.gearbox.axle_loss_file";
    let columns = [Quantity::InputTorque, Quantity::LossTorque];
    if let Some([torque, loss]) = numbers_of(gearbox, path, files, &LOSS_MAP, columns)? {
        let [constant, _, slope] = loss_law::of_gear(&[vec![0.0; loss.len()], torque, loss]);
        put(gearbox, &json!({ "axle_loss_torque_nm": constant, "axle_loss_share": slope }))?;
    }
    let path = "vehicle.powertrain.combustion.gearbox.retarder_loss_file";
    let columns = [Quantity::EngineSpeed, Quantity::LossTorque];
    if let Some(losses) = numbers_of(gearbox, path, files, &LOSS_MAP, columns)? {
        let [constant, growth] = loss_law::of_retarder(&losses);
        let keys = json!({ "retarder_torque_nm": constant, "retarder_torque_nms2": growth });
        put(gearbox, &keys)?;
    }
    Ok(())
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

/// A table that a key names: its file alone, or `{ file, columns }` with what its columns are.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TableFile {
    file: String,
    #[serde(default)]
    columns: BTreeMap<String, String>,
}

/// Takes the key at the end of a path out of its table, and reads some columns of the file that it
/// names, all of which are needed, in SI. What is wrong with them names the key's place.
fn numbers_of<const N: usize>(
    table: &mut Node,
    path: &str,
    files: &Files,
    schema: &'static Schema,
    quantities: [Quantity; N],
) -> Result<Option<[Vec<f64>; N]>, Box<Fault>> {
    let Some(node) = take(table, path.rsplit('.').next().unwrap_or(path)) else { return Ok(None) };
    let TableFile { file, columns } = match node.get("file") {
        Some(_) => read_keys(&node, path)?,
        None => TableFile { file: text(&node, path)?, columns: BTreeMap::new() },
    };
    let file = files.path(path, file).map_err(|fault| fault.at(node.any_place()))?;
    let read = || {
        let mappings = Mapping::of_columns(&columns)?;
        Table::open(Source::File(&file), schema, &mappings)?.numbers(quantities)
    };
    read().map(Some).map_err(|error: TableError| file_fault(&node, &error))
}

/// The value of a key as a struct.
fn read_keys<T: DeserializeOwned>(node: &Node, key: &str) -> Result<T, Box<Fault>> {
    from_value(node.to_json()).map_err(|error| file_fault(node, &format!("`{key}`: {error}")))
}

fn file_fault(node: &Node, message: &impl ToString) -> Box<Fault> {
    Fault::new(Cause::File(message.to_string())).at(node.any_place())
}

fn text(node: &Node, key: &str) -> Result<String, Box<Fault>> {
    node.as_str().map(str::to_owned).ok_or_else(|| {
        Fault::not_allowed(key, node.shown(), "a text in quotation marks").at(node.any_place())
    })
}

fn take(node: &mut Node, key: &str) -> Option<Node> {
    node.entries_mut()?.remove(key)
}

/// Lays keys over a table.
fn put(node: &mut Node, keys: &Value) -> Result<(), Box<Fault>> {
    node.overlay(Node::from_json(keys)?)
}

/// Linear between points, held beyond them.
fn interpolate(points: &[(f64, f64)], x: f64) -> f64 {
    let k = points.partition_point(|point| point.0 <= x);
    match (k.checked_sub(1).map(|k| points[k]), points.get(k)) {
        (Some((x0, y0)), Some((x1, y1))) => y0 + (y1 - y0) * (x - x0) / (x1 - x0),
        (Some((_, y)), None) | (None, Some(&(_, y))) => y,
        (None, None) => 0.0,
    }
}
