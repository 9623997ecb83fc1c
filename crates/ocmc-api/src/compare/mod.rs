//! How studies differ under common random numbers, the first one as the baseline.

mod text;

use crate::answer::Answer;
use crate::error::Error;
use crate::progress::Watch;
use crate::sensitivity::quantity_named;
use crate::watch::watched;
use ocmc_core::fleet::comparison::{Comparison, compare as compare_fleets};
use ocmc_core::fleet::quantity::WHEEL;
use ocmc_core::fleet::run::RunPlan;
use ocmc_core::study::Study;
use ocmc_io::study::{LoadedStudy, study_hash};
use serde::{Serialize, Serializer};
use std::time::Instant;

/// The studies, and what is compared.
#[derive(Clone, Debug)]
pub struct CompareRequest<'a> {
    /// The studies and how the answer calls them, the baseline first; two at least.
    pub studies: Vec<(String, &'a LoadedStudy)>,
    /// The cycles that each of them drives.
    pub plan: RunPlan,
    /// Name of the quantity; the first consumption that all have where there is none.
    pub column: Option<String>,
}

/// The differences.
#[derive(Clone, Debug)]
pub struct CompareAnswer {
    /// One for each study but the baseline.
    pub comparisons: Vec<ComparedStudies>,
    /// Studies that are compared by the work at the wheels, although it was not asked for, because
    /// they burn no fuel.
    pub(crate) without_fuel: Vec<String>,
    pub(crate) plan: RunPlan,
    pub(crate) wall_s: f64,
}

/// How a study B differs from the baseline A.
#[derive(Clone, Debug, Serialize)]
pub struct ComparedStudies {
    /// What A is called.
    pub study_a: String,
    /// Hash of the resolved study A.
    pub study_hash_a: String,
    /// What B is called.
    pub study_b: String,
    /// Hash of the resolved study B.
    pub study_hash_b: String,
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// The difference.
    #[serde(flatten)]
    pub comparison: Comparison,
}

/// Drives the same cycles in all studies and compares them with the first one.
///
/// ```
/// use ocmc_api::{CompareRequest, RunPlan, compare, go_on, study};
/// let empty = study::load("field-truck", &["mission.length_m=5000"])?;
/// let loaded = empty.set(&["mission.payload_kg=20000"])?;
/// let request = CompareRequest {
///     studies: vec![("empty".to_owned(), &empty), ("loaded".to_owned(), &loaded)],
///     plan: RunPlan::new(1, 0, 20, None, None),
///     column: Some("consumption_l_per_100km".to_owned()),
/// };
/// let answer = compare(&request, &mut go_on)?;
/// assert!(answer.comparisons[0].comparison.difference > Some(0.0));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::UnknownColumn`] and [`Error::Interrupted`]; [`Error::NothingToCompare`] where there are
/// not two studies.
pub fn compare(request: &CompareRequest, watch: &mut Watch) -> Result<CompareAnswer, Error> {
    let CompareRequest { studies, plan, column } = request;
    let [(name_a, a), others @ ..] = studies.as_slice() else {
        return Err(Error::NothingToCompare);
    };
    if others.is_empty() {
        return Err(Error::NothingToCompare);
    }
    let quantity = quantity_named(column.as_deref())?;
    let all: Vec<&Study> = studies.iter().map(|(_, loaded)| &loaded.study).collect();
    let clock = Instant::now();
    let cycles = plan.cycles.saturating_mul(all.len() as u64);
    let compared = watched(cycles, watch, |look| compare_fleets(&all, plan, quantity, look))?;
    let wall_s = clock.elapsed().as_secs_f64();
    let by_wheels = compared.iter().all(|comparison| comparison.column == WHEEL);
    let without_fuel = studies.iter().filter(|(_, study)| {
        column.is_none() && by_wheels && study.model.vehicle.electric.is_some()
    });
    let without_fuel = without_fuel.map(|(name, _)| name.clone()).collect();
    let comparisons =
        compared.into_iter().zip(others).map(|(comparison, (name, b))| ComparedStudies {
            study_a: name_a.clone(),
            study_hash_a: study_hash(&a.model),
            study_b: name.clone(),
            study_hash_b: study_hash(&b.model),
            seed: plan.seed,
            first_cycle: plan.first_cycle,
            comparison,
        });
    let comparisons = comparisons.collect();
    Ok(CompareAnswer { comparisons, without_fuel, plan: *plan, wall_s })
}

/// Two studies are one comparison, more are a list.
impl Serialize for CompareAnswer {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.comparisons.as_slice() {
            [one] => one.serialize(serializer),
            several => several.serialize(serializer),
        }
    }
}

impl Answer for CompareAnswer {
    fn text(&self) -> String {
        text::answer(self)
    }
}
