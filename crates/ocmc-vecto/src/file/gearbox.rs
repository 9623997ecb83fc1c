//! The gearbox and the axle of a job.

use super::driver::opposite_shift_time_s;
use super::error::VectoError;
use super::part::{beside, names_file, number};
use super::result::Columns;
use super::vehicle::RADPS_PER_RPM;
use crate::driver::{ShiftLine, ShiftPolygon, VectoDriver};
use ocmc_io::loss_law;
use ocmc_io::table::formats::LOSS_MAP;
use ocmc_io::table::{Quantity, Source, Table};
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::Path;

/// Ratios that differ by less are the same.
const SAME_RATIO: f64 = 1e-6;

/// A `.vgbx` file: the axle comes first among its gears.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct GearboxFile {
    gears: Vec<GearFile>,
    tq_reserve: f64,
    start_tq_reserve: f64,
    start_speed: f64,
    start_acc: f64,
    shift_time: f64,
    /// Time of a shift without torque, in s.
    #[serde(rename = "TracInt", default = "one")]
    traction_gap_s: f64,
    /// VECTO 3 does not write this and the next: there they follow from the kind of the gearbox.
    skip_gears: Option<bool>,
    // as VECTO writes it
    #[serde(rename = "EaryShiftUp", alias = "EarlyShiftUp")]
    early_upshift: Option<bool>,
    /// VECTO 3's own files have both spellings.
    #[serde(rename = "DownshiftAfterUpshiftDelay", alias = "DownshiftAferUpshiftDelay")]
    opposite_shift_time_s: Option<f64>,
    #[serde(default)]
    gearbox_type: Value,
}

/// The gap of an automated gearbox, in s.
fn one() -> f64 {
    1.0
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
struct GearFile {
    ratio: f64,
    loss_map: Option<LossMap>,
    /// In place of a map.
    efficiency: Option<LossMap>,
    #[serde(default)]
    shift_polygon: String,
    #[serde(default)]
    max_torque: Value,
    #[serde(default)]
    max_speed: Value,
}

impl GearFile {
    /// Its losses: a file, else an efficiency.
    fn losses(&self) -> Option<&LossMap> {
        let is_named = |losses: &&LossMap| match losses {
            LossMap::Efficiency(_) => true,
            LossMap::File(name) => names_file(name),
        };
        self.loss_map.as_ref().filter(is_named).or(self.efficiency.as_ref().filter(is_named))
    }
}

/// A file, or an efficiency.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
enum LossMap {
    Efficiency(f64),
    File(String),
}

/// Types of gearboxes by the number that stands for them in some files [F: VECTO 3].
const TYPES: [&str; 4] = ["mt", "amt", "at", "custom"];
/// Longest gap of a shift, in s.
const MOST_GAP_S: f64 = 5.0;

impl GearboxFile {
    /// Its type in small letters, also where a number stands for it.
    fn kind(&self) -> String {
        match (&self.gearbox_type, self.gearbox_type.as_u64()) {
            (Value::String(kind), _) => kind.to_lowercase(),
            (_, Some(k)) => TYPES.get(k as usize).map_or(k.to_string(), |kind| (*kind).to_owned()),
            (Value::Null, _) => String::new(),
            (kind, _) => kind.to_string(),
        }
    }

    fn is_automated(&self) -> bool {
        self.kind() != "mt"
    }

    /// Values that are not used.
    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let is_limit = |limit: &Value| number(limit).is_some_and(|limit| limit > 0.0);
        if self.gears.iter().any(|gear| is_limit(&gear.max_torque) || is_limit(&gear.max_speed)) {
            notes.push("`MaxTorque`, `MaxSpeed`: the engine's full load holds in all gears".into());
        }
        if self.traction_gap_s > MOST_GAP_S {
            let gap_s = self.traction_gap_s;
            notes.push(format!("`TracInt` {gap_s}: a gap has {MOST_GAP_S} s at most"));
        }
        notes
    }

    pub(super) fn check(&self, path: &Path) -> Result<(), VectoError> {
        let refused = |what, found: String, allowed| {
            Err(VectoError::Unsupported { path: path.to_owned(), what, found, allowed })
        };
        let kind = self.kind();
        if !["amt", "mt", ""].contains(&kind.as_str()) {
            let quoted = format!("`{}`", kind.to_uppercase());
            let allowed = "allowed are `AMT` and `MT`: a torque converter is not computed";
            return refused("`GearboxType`", quoted, allowed);
        }
        if self.gears.len() < 2 {
            let allowed = "allowed are the axle and at least one gear";
            return refused("the number of `Gears`", self.gears.len().to_string(), allowed);
        }
        if self.gears.iter().any(|gear| gear.losses().is_none()) {
            let allowed = "allowed is a file or an efficiency for the axle and each gear";
            return refused("`LossMap` or `Efficiency`", "missing".to_owned(), allowed);
        }
        Ok(())
    }

    /// The driver with what the gearbox says of him.
    pub(super) fn shifts(
        &self,
        driver: VectoDriver,
        path: &Path,
    ) -> Result<VectoDriver, VectoError> {
        let gears = &self.gears[1..];
        let polygon = |gear: &GearFile| polygon(&beside(path, &gear.shift_polygon)?);
        let named = gears.iter().all(|gear| names_file(&gear.shift_polygon));
        let polygons: Result<_, VectoError> =
            if named { gears.iter().map(polygon).collect() } else { Ok(Vec::new()) };
        Ok(VectoDriver {
            shift_polygons: polygons?,
            torque_reserve: self.tq_reserve / 100.0,
            start_torque_reserve: self.start_tq_reserve / 100.0,
            start_speed_mps: self.start_speed,
            start_acceleration_mps2: self.start_acc,
            shift_time_s: self.shift_time,
            opposite_shift_time_s: self
                .opposite_shift_time_s
                .unwrap_or_else(|| opposite_shift_time_s(&driver)),
            // the driver goes by whole seconds
            gap_s: self.traction_gap_s.round().clamp(0.0, MOST_GAP_S) as u32,
            skip_gears: self.skip_gears.unwrap_or(true),
            // a driver by hand does not shift up early
            early_upshift: self.early_upshift.unwrap_or_else(|| self.is_automated()),
            ..driver
        })
    }

    /// Keys of a study; `most_nm`: highest torque of the engine.
    pub(super) fn keys(&self, path: &Path, most_nm: f64) -> Result<Value, VectoError> {
        let (axle, gears) = self.gears.split_first().unwrap_or((&self.gears[0], &[]));
        let ratio: Vec<f64> = gears.iter().map(|gear| gear.ratio).collect();
        let losses = |direct: bool| {
            let is_direct = |gear: &&GearFile| (gear.ratio - 1.0).abs() < SAME_RATIO;
            let such = gears.iter().filter(|gear| is_direct(gear) == direct);
            law(such.filter_map(GearFile::losses), path, most_nm)
        };
        let (direct, indirect) = (losses(true)?, losses(false)?);
        let [axle_nm, _, axle_share] =
            law(axle.losses().into_iter(), path, f64::INFINITY)?.unwrap_or_default();
        let some = indirect.or(direct).unwrap_or_default();
        let shift = match gears.len() {
            // what a built-in gearbox says of its lower gears
            1 => json!({ "launch_gears": 1, "start_gear": 1, "steep_start_gear": 1 }),
            _ => json!({}),
        };
        // the constant and the growth belong to all gears, those of the indirect ones mostly
        Ok(json!({
            "ratio": ratio,
            "axle_ratio": axle.ratio,
            "loss_torque_nm": some[0],
            "loss_torque_nms": some[1],
            "loss_floor_nm": 0.0,
            "retarder_torque_nms2": 0.0,
            "indirect_loss_share": some[2],
            "direct_loss_share": direct.unwrap_or(some)[2],
            "retarder_torque_nm": 0.0,
            "axle_loss_torque_nm": axle_nm,
            "axle_loss_share": axle_share,
            "shift": shift,
        }))
    }
}

/// The law over the points of these maps up to a torque; none without a map. VECTO's generic maps
/// end with a point beyond the engine's torque at which they bend.
fn law<'a>(
    maps: impl Iterator<Item = &'a LossMap>,
    path: &Path,
    most_nm: f64,
) -> Result<Option<[f64; 3]>, VectoError> {
    let (mut files, mut shares) = (BTreeSet::new(), Vec::new());
    for map in maps {
        match map {
            LossMap::Efficiency(efficiency) => shares.push(1.0 - efficiency),
            // an efficiency may be written as a text
            LossMap::File(name) => match name.trim().parse::<f64>() {
                Ok(efficiency) => shares.push(1.0 - efficiency),
                Err(_) => drop(files.insert(beside(path, name)?)),
            },
        }
    }
    if files.is_empty() {
        let share = shares.iter().sum::<f64>() / shares.len().max(1) as f64;
        return Ok((!shares.is_empty()).then_some([0.0, 0.0, share]));
    }
    let mut points: [Vec<f64>; 3] = Default::default();
    for file in &files {
        let columns = [Quantity::EngineSpeed, Quantity::InputTorque, Quantity::LossTorque];
        let more = Table::open(Source::File(file), &LOSS_MAP, &[])?.numbers(columns)?;
        let used: Vec<bool> = more[1].iter().map(|torque| torque.abs() <= most_nm).collect();
        for (all, more) in points.iter_mut().zip(more) {
            all.extend(more.into_iter().zip(&used).filter(|(_, used)| **used).map(|(x, _)| x));
        }
    }
    Ok(Some(loss_law::of_gear(&points)))
}

/// The lines of a file (`.vgbs`).
fn polygon(path: &Path) -> Result<ShiftPolygon, VectoError> {
    let columns = Columns::read(path)?;
    let torque_nm = columns.numbers("M")?;
    let line = |name| {
        let speed_radps = columns.numbers(name)?.iter().map(|n| n * RADPS_PER_RPM).collect();
        Ok::<_, VectoError>(ShiftLine { torque_nm: torque_nm.clone(), speed_radps })
    };
    Ok(ShiftPolygon { down: line("nDown")?, up: line("nUp")? })
}

/// Lays the losses of a retarder over the keys of a gearbox.
pub(super) fn add_retarder(gearbox: &mut Value, path: &Path, ratio: f64) -> Result<(), VectoError> {
    let columns = [Quantity::EngineSpeed, Quantity::LossTorque];
    let points = Table::open(Source::File(path), &LOSS_MAP, &[])?.numbers(columns)?;
    let [constant_nm, growth_nms2] = loss_law::of_retarder(&points);
    gearbox["retarder_torque_nm"] = json!(constant_nm * ratio);
    gearbox["retarder_torque_nms2"] = json!(growth_nms2 * ratio * ratio * ratio);
    Ok(())
}
