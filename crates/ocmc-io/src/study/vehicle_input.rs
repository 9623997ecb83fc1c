//! Vehicles as engineers have them: keys of a study that stand for others, worked out when the
//! study is loaded.
//!
//! | key | stands for |
//! |---|---|
//! | `vehicle.tyre_code` | `wheel_radius_m` |
//! | `vehicle.coast_down` | `drag_area_m2`, `axles`, `rolling_load_exponent` |
//! | `vehicle.engine.full_load_file` (`.vfld`: speed in rpm, full-load and drag torque in Nm) | full-load and drag curves |
//! | `vehicle.engine.map_file` (`.vmap`: speed in rpm, torque in Nm, fuel in g/h) | the fuel map |
//! | `vehicle.gearbox.direct_loss_file`, `indirect_loss_file`, `axle_loss_file` (`.vtlm`: speed, torque, loss) | loss torques and shares, by least squares |
//! | `vehicle.gearbox.retarder_loss_file` (`.vrlm`: speed, loss) | `retarder_torque_nm`, the mean |
//!
//! Files lie relative to the study. In place of a file stands `{ file, columns }` where columns
//! have other names.

use super::error::{Cause, Fault};
use super::node::Node;
use crate::table::formats::{ENGINE_CURVES, FUEL_MAP, LOSS_MAP};
use crate::table::{Mapping, Quantity, Schema, Source, Table, TableError};
use ocmc_core::powertrain::diesel::engine::MOST_KNOTS;
use ocmc_core::powertrain::diesel::fuel_map::{FuelPoint, on_grid};
use ocmc_core::vehicle::coast_down::CoastDown;
use ocmc_core::vehicle::tyre::TyreSize;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Works out the keys that stand for others, in a tree whose bases are resolved.
pub(super) fn expand(tree: &mut Node, folder: Option<&Path>) -> Result<(), Box<Fault>> {
    let Some(vehicle) = tree.entries_mut().and_then(|entries| entries.get_mut("vehicle")) else {
        return Ok(());
    };
    if let Some(node) = take(vehicle, "tyre_code") {
        let code = text(&node, "vehicle.tyre_code")?;
        let size: TyreSize = code.parse().map_err(|error| file_fault(&node, &error))?;
        put(vehicle, &json!({ "wheel_radius_m": size.dynamic_radius_m() }))?;
    }
    if let Some(node) = take(vehicle, "coast_down") {
        let test = read_keys(&node, "vehicle.coast_down")?;
        put(vehicle, &coast_down(&test).map_err(|message| file_fault(&node, &message))?)?;
    }
    if let Some(engine) = vehicle.entries_mut().and_then(|entries| entries.get_mut("engine")) {
        engine_files(engine, folder)?;
    }
    if let Some(gearbox) = vehicle.entries_mut().and_then(|entries| entries.get_mut("gearbox")) {
        gearbox_files(gearbox, folder)?;
    }
    Ok(())
}

fn coast_down(test: &CoastDown) -> Result<Value, &'static str> {
    let sound = test.mass_kg > 0.0 && test.air_density_kgpm3 > 0.0 && test.from_mps >= 0.0;
    if !(sound && test.to_mps > test.from_mps) {
        return Err(
            "`vehicle.coast_down` needs a mass and a density above 0, and `to_mps` above `from_mps`",
        );
    }
    let (drag_area_m2, rolling) = test.resistance();
    // one axle of exponent 1 has the coefficient of the test at every load
    let axle = json!({ "load_share": 1.0, "iso_rolling_coefficient": rolling, "iso_load_n": 10_000.0, "tyres": 4 });
    Ok(json!({ "drag_area_m2": drag_area_m2, "axles": [axle], "rolling_load_exponent": 1.0 }))
}

fn engine_files(engine: &mut Node, folder: Option<&Path>) -> Result<(), Box<Fault>> {
    let mut drag: Option<Vec<(f64, f64)>> = None;
    if let Some(node) = take(engine, "full_load_file") {
        let (keys, curve) = in_file(&node, "vehicle.engine.full_load_file", folder, full_load)?;
        put(engine, &keys)?;
        drag = Some(curve);
    }
    if let Some(node) = take(engine, "map_file") {
        put(engine, &in_file(&node, "vehicle.engine.map_file", folder, fuel_map)?)?;
    }
    if let Some(drag) = drag {
        let speeds = numbers(engine, "map_speed_radps");
        let torques: Vec<f64> = speeds.iter().map(|w| interpolate(&drag, *w).min(-0.1)).collect();
        put(engine, &json!({ "drag_torque_nm": torques }))?;
    }
    Ok(())
}

/// Full-load curve as keys, and the drag curve: speed in rad/s, torque in Nm.
fn full_load(file: &TableFile) -> Result<(Value, Vec<(f64, f64)>), TableError> {
    let columns = [Quantity::EngineSpeed, Quantity::FullLoadTorque, Quantity::DragTorque];
    let [speed, full, drag] = file.numbers(&ENGINE_CURVES, columns)?;
    let drag = speed.iter().copied().zip(drag).collect();
    // a curve may end at zero torque; the model's torques are above 0
    let points: Vec<(f64, f64)> = speed.iter().copied().zip(full).filter(|p| p.1 >= 1.0).collect();
    let step = points.len().div_ceil(MOST_KNOTS).max(1);
    let last = points.len().saturating_sub(1);
    let kept = points.iter().enumerate().filter(|(k, _)| k % step == 0 || *k == last);
    let (speeds, torques): (Vec<f64>, Vec<f64>) = kept.map(|(_, point)| *point).unzip();
    let keys = json!({ "full_load_speed_radps": speeds, "full_load_torque_nm": torques });
    Ok((keys, drag))
}

fn fuel_map(file: &TableFile) -> Result<Value, TableError> {
    let columns = [Quantity::EngineSpeed, Quantity::Torque, Quantity::FuelRate];
    let [speed, torque, fuel] = file.numbers(&FUEL_MAP, columns)?;
    let points: Vec<FuelPoint> = (0..speed.len())
        .map(|k| FuelPoint { speed_radps: speed[k], torque_nm: torque[k], fuel_kgps: fuel[k] })
        .collect();
    // a map of one row comes back as empty lists, which the study's check refuses by name
    let grid = on_grid(&points);
    let (speeds, torques, rows) = grid
        .map_or_else(Default::default, |grid| (grid.speed_radps, grid.torque_nm, grid.fuel_kgps));
    Ok(json!({ "map_speed_radps": speeds, "map_torque_nm": torques, "map_fuel_kgps": rows }))
}

fn gearbox_files(gearbox: &mut Node, folder: Option<&Path>) -> Result<(), Box<Fault>> {
    let mut constants = Vec::new();
    for (key, share) in
        [("direct_loss_file", "direct_loss_share"), ("indirect_loss_file", "indirect_loss_share")]
    {
        if let Some(node) = take(gearbox, key) {
            let (constant, slope) =
                in_file(&node, &format!("vehicle.gearbox.{key}"), folder, loss_line)?;
            constants.push(constant);
            put(gearbox, &json!({ share: slope }))?;
        }
    }
    if !constants.is_empty() {
        let mean = constants.iter().sum::<f64>() / constants.len() as f64;
        put(gearbox, &json!({ "loss_torque_nm": mean }))?;
    }
    if let Some(node) = take(gearbox, "axle_loss_file") {
        let (constant, slope) =
            in_file(&node, "vehicle.gearbox.axle_loss_file", folder, loss_line)?;
        put(gearbox, &json!({ "axle_loss_torque_nm": constant, "axle_loss_share": slope }))?;
    }
    if let Some(node) = take(gearbox, "retarder_loss_file") {
        let mean = in_file(&node, "vehicle.gearbox.retarder_loss_file", folder, |file| {
            let [loss] = file.numbers(&LOSS_MAP, [Quantity::LossTorque])?;
            Ok(loss.iter().sum::<f64>() / loss.len() as f64)
        })?;
        put(gearbox, &json!({ "retarder_torque_nm": mean }))?;
    }
    Ok(())
}

/// Loss = c + k |T| by least squares over a loss map, both at least 0.
fn loss_line(file: &TableFile) -> Result<(f64, f64), TableError> {
    let columns = [Quantity::InputTorque, Quantity::LossTorque];
    let [torque, loss] = file.numbers(&LOSS_MAP, columns)?;
    let n = torque.len() as f64;
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / n;
    let (x, y) = (mean(&mut torque.iter().map(|t| t.abs())), mean(&mut loss.iter().copied()));
    let xy: f64 = torque.iter().zip(&loss).map(|(t, l)| (t.abs() - x) * (l - y)).sum();
    let xx: f64 = torque.iter().map(|t| (t.abs() - x) * (t.abs() - x)).sum();
    let slope = if xx > 0.0 { (xy / xx).max(0.0) } else { 0.0 };
    Ok(((y - slope * x).max(0.0), slope))
}

/// A table that a key names: its file alone, or `{ file, columns }` with what its columns are.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TableFile {
    file: PathBuf,
    #[serde(default)]
    columns: BTreeMap<String, String>,
}

impl TableFile {
    fn of(node: &Node, key: &str) -> Result<Self, Box<Fault>> {
        if node.get("file").is_none() {
            return Ok(Self { file: text(node, key)?.into(), columns: BTreeMap::new() });
        }
        read_keys(node, key)
    }

    /// Some of its columns, all of which are needed, in SI.
    fn numbers<const N: usize>(
        &self,
        schema: &'static Schema,
        quantities: [Quantity; N],
    ) -> Result<[Vec<f64>; N], TableError> {
        let mappings = Mapping::of_columns(&self.columns)?;
        Table::open(Source::File(&self.file), schema, &mappings)?.numbers(quantities)
    }
}

/// Reads the file that a key names, and names the key's place in what is wrong with it.
fn in_file<T>(
    node: &Node,
    key: &str,
    folder: Option<&Path>,
    read: impl FnOnce(&TableFile) -> Result<T, TableError>,
) -> Result<T, Box<Fault>> {
    let mut file = TableFile::of(node, key)?;
    if let Some(folder) = folder {
        file.file = folder.join(&file.file);
    }
    read(&file).map_err(|error| file_fault(node, &error))
}

/// The value of a key as a struct.
fn read_keys<T: DeserializeOwned>(node: &Node, key: &str) -> Result<T, Box<Fault>> {
    let wrong = |error: toml::de::Error| format!("`{key}`: {}", error.message());
    node.to_toml().try_into().map_err(|error| file_fault(node, &wrong(error)))
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

fn numbers(node: &mut Node, key: &str) -> Vec<f64> {
    let list = node.entries_mut().and_then(|entries| entries.get(key));
    list.and_then(|list| list.to_toml().try_into().ok()).unwrap_or_default()
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
