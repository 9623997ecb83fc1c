//! The gearbox and the axle of a job.

use super::error::VectoError;
use super::part::{beside, names_file};
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
    #[serde(rename = "DownshiftAfterUpshiftDelay", default)]
    opposite_shift_time_s: f64,
    gearbox_type: String,
}

/// The gap of an automated gearbox, in s.
fn one() -> f64 {
    1.0
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
struct GearFile {
    ratio: f64,
    loss_map: LossMap,
    #[serde(default)]
    shift_polygon: String,
}

/// A file, or an efficiency.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
enum LossMap {
    Efficiency(f64),
    File(String),
}

impl GearboxFile {
    fn is_automated(&self) -> bool {
        !self.gearbox_type.eq_ignore_ascii_case("mt")
    }

    pub(super) fn check(&self, path: &Path) -> Result<(), VectoError> {
        let refused = |what, found: String, allowed| {
            Err(VectoError::Unsupported { path: path.to_owned(), what, found, allowed })
        };
        if !["amt", "mt", ""].contains(&self.gearbox_type.to_lowercase().as_str()) {
            let found = format!("`{}`", self.gearbox_type);
            let allowed = "allowed are `AMT` and `MT`: a torque converter is not computed";
            return refused("`GearboxType`", found, allowed);
        }
        if self.gears.len() < 2 {
            let allowed = "allowed are the axle and at least one gear";
            return refused("the number of `Gears`", self.gears.len().to_string(), allowed);
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
            opposite_shift_time_s: self.opposite_shift_time_s,
            // the driver goes by whole seconds
            gap_s: self.traction_gap_s.round().clamp(0.0, 5.0) as u32,
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
        let of = |direct: bool| {
            let is_direct = |gear: &&GearFile| (gear.ratio - 1.0).abs() < SAME_RATIO;
            let such = gears.iter().filter(|gear| is_direct(gear) == direct);
            law(such.map(|gear| &gear.loss_map), path, most_nm)
        };
        let (direct, indirect) = (of(true)?, of(false)?);
        let [axle_nm, _, axle_share] =
            law([&axle.loss_map].into_iter(), path, f64::INFINITY)?.unwrap_or_default();
        let some = indirect.or(direct).unwrap_or_default();
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
