//! Points of a study under common random numbers: values of its keys, in a grid or one by one.

mod points;
mod text;

pub use points::SweepPoints;

use crate::answer::Answer;
use crate::compare::column_named;
use crate::error::Error;
use crate::watch::{Watch, watched};
use ocmc_core::study::Study;
use ocmc_fleet::comparison::AdjustedDifference;
use ocmc_fleet::run::RunPlan;
use ocmc_fleet::sweep::{SweptStudy, sweep as sweep_fleets};
use ocmc_io::study::{LoadedStudy, study_hash, value_of};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::HashMap;
use std::time::Instant;

/// Most points of a sweep.
pub const MOST_POINTS: usize = 1000;

/// Reference that the points of a sweep are compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Against {
    /// The first point.
    #[default]
    First,
    /// The study as it is.
    Base,
}

/// The study, and what is set in it.
#[derive(Clone, Debug)]
pub struct SweepRequest<'a> {
    /// The study, and what the answer calls it.
    pub study: (String, &'a LoadedStudy),
    /// Settings, point by point.
    pub points: SweepPoints,
    /// Reference of the points.
    pub against: Against,
    /// The cycles that each point drives.
    pub plan: RunPlan,
    /// Name of the quantity, or of another column of the records that is a number; the first
    /// consumption that all have where there is none.
    pub column: Option<String>,
}

/// Answer of a sweep: what its points take, and how they differ.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct SweepAnswer {
    /// Name of the study.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// Cycles that each point drives.
    pub cycles: u64,
    /// Name of the quantity.
    pub column: String,
    /// The keys that differ between the points.
    pub keys: Vec<String>,
    /// Reference of the points.
    pub against: Against,
    /// The study as it is, where the points are compared with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<SweptPoint>,
    /// The points, in their order.
    pub points: Vec<SweptPoint>,
    /// Whether it is another quantity than what the first one alone is judged by.
    #[serde(skip)]
    is_common: bool,
    #[serde(skip)]
    driven: (RunPlan, f64, u64),
    #[serde(skip)]
    warnings: Vec<String>,
}

/// A point of a sweep. Numbers are in the unit of the column.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct SweptPoint {
    /// The values of the keys; null where a key is left as the study has it.
    pub values: Map<String, Value>,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// The fleet's mean, over the cycles that it completed.
    pub mean: Option<f64>,
    /// 95 % interval of the mean.
    pub ci95: Option<[f64; 2]>,
    /// The mean less that of the reference, over the cycles that both completed; none of the
    /// reference itself.
    pub difference: Option<f64>,
    /// 95 % interval of the difference, of sampling alone.
    pub difference_ci95: Option<[f64; 2]>,
    /// The difference over the mean of the reference.
    pub relative_difference: Option<f64>,
    /// The difference adjusted by what the cycles are known to have on average.
    pub adjusted: Option<AdjustedDifference>,
    /// Cycles that this point and the reference both completed.
    pub pairs: Option<u64>,
    /// Cycles that were not completed.
    pub not_completed: u64,
    /// Share of the cycles that were not completed.
    pub share_not_completed: f64,
}

/// Drives the same cycles at all points, and compares them with the first one, or with the study.
///
/// ```
/// use ocmc_api::{Against, RunPlan, SweepPoints, SweepRequest, go_on, study, sweep};
/// let study = study::load("field-truck", &["mission.length_m=5000"])?;
/// let (_, points) = SweepPoints::of_settings(&["mission.payload_kg=0,10000,20000".to_owned()])?;
/// let plan = RunPlan::new(1, 0, 20, None, None);
/// let study = ("mine".to_owned(), &study);
/// let request = SweepRequest { study, points, against: Against::First, plan, column: None };
/// let answer = sweep(&request, &mut go_on)?;
/// assert_eq!(answer.points[0].difference, None);
/// assert!(answer.points[1].difference > Some(0.0));
/// assert!(answer.points[2].difference > answer.points[1].difference);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// Before anything is driven: [`Error::NothingToSweep`] where there is nothing to compare,
/// [`Error::SweptPoint`] of a point that is no study, [`Error::SamePoints`], [`Error::NoColumn`].
/// [`Error::Interrupted`].
pub fn sweep(request: &SweepRequest, watch: &mut Watch) -> Result<SweepAnswer, Error> {
    let SweepRequest { study: (name, base), points, against, plan, column } = request;
    let has_base = *against == Against::Base;
    if points.set_nothing() || points.len() + usize::from(has_base) < 2 {
        return Err(Error::NothingToSweep);
    }
    let loaded = Loaded::of(base, points)?;
    let named = |named| column_named(named, loaded.studies.iter());
    let quantity = column.as_deref().map(named).transpose()?;
    let studies: Vec<&Study> =
        has_base.then_some(&base.study).into_iter().chain(&loaded.studies).collect();
    let (clock, cycles) = (Instant::now(), plan.cycles.saturating_mul(studies.len() as u64));
    let fleet_sweep =
        watched(cycles, watch, |look| sweep_fleets(&studies, plan, quantity.as_ref(), &mut *look))?;
    let wall_s = clock.elapsed().as_secs_f64();
    let mut swept = fleet_sweep.studies.into_iter();
    let own_hash = study_hash(&base.model);
    let nothing = || points.keys().iter().map(|key| (key.clone(), Value::Null)).collect();
    let base = swept.by_ref().take(usize::from(has_base)).next();
    let base = base.map(|base| SweptPoint::new(nothing(), own_hash.clone(), base, plan));
    let of_points = loaded.values.into_iter().zip(loaded.hashes).zip(swept);
    let of_points =
        of_points.map(|((values, hash), swept)| SweptPoint::new(values, hash, swept, plan));
    Ok(SweepAnswer {
        study: name.clone(),
        study_hash: own_hash,
        seed: plan.seed,
        first_cycle: plan.first_cycle,
        cycles: plan.cycles,
        column: fleet_sweep.column,
        keys: points.keys().to_vec(),
        against: *against,
        base,
        points: of_points.collect(),
        is_common: fleet_sweep.is_common,
        driven: (*plan, wall_s, cycles),
        warnings: loaded.warnings,
    })
}

/// The studies of the points, checked.
struct Loaded {
    studies: Vec<Study>,
    hashes: Vec<String>,
    values: Vec<Map<String, Value>>,
    /// Warnings that the study itself does not give.
    warnings: Vec<String>,
}

impl Loaded {
    fn of(base: &LoadedStudy, points: &SweepPoints) -> Result<Self, Error> {
        let mut known = HashMap::new();
        let given = base.warnings();
        let (studies, hashes, values, warnings) = Default::default();
        let mut loaded = Self { studies, hashes, values, warnings };
        for k in 0..points.len() {
            let name = || format!("point {} of {} ({})", k + 1, points.len(), points.name(k));
            let fault = |source| Error::SweptPoint { point: name(), source };
            let study = base.set(&points.settings(k)).map_err(fault)?;
            let value = |(key, value): (&str, Option<&str>)| {
                let read = |value| value_of(&format!("{key}={value}")).map_err(fault);
                Ok((key.to_owned(), value.map(read).transpose()?.unwrap_or_default()))
            };
            loaded.values.push(points.written(k).map(value).collect::<Result<_, Error>>()?);
            let hash = study_hash(&study.model);
            if let Some(first) = known.insert(hash.clone(), name()) {
                return Err(Error::SamePoints { first, second: name() });
            }
            loaded.hashes.push(hash);
            for warning in study.warnings() {
                if !given.contains(&warning) && !loaded.warnings.contains(&warning) {
                    loaded.warnings.push(warning);
                }
            }
            loaded.studies.push(study.study);
        }
        Ok(loaded)
    }
}

impl SweptPoint {
    fn new(
        values: Map<String, Value>,
        study_hash: String,
        swept: SweptStudy,
        plan: &RunPlan,
    ) -> Self {
        let SweptStudy { mean, failed, comparison } = swept;
        let difference = comparison.as_ref().and_then(|compared| compared.difference);
        let of_reference =
            comparison.as_ref().and_then(|compared| compared.a).filter(|a| *a != 0.0);
        Self {
            values,
            study_hash,
            mean: mean.map(|mean| mean.ratio),
            ci95: mean.and_then(|mean| mean.ci95),
            difference,
            difference_ci95: comparison.as_ref().and_then(|compared| compared.ci95),
            relative_difference: difference.zip(of_reference).map(|(change, a)| change / a),
            adjusted: comparison.as_ref().and_then(|compared| compared.adjusted),
            pairs: comparison.map(|compared| compared.pairs),
            not_completed: failed,
            share_not_completed: failed as f64 / plan.cycles as f64,
        }
    }
}

impl Answer for SweepAnswer {
    fn text(&self) -> String {
        self.lines()
    }

    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }
}
