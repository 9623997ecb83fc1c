//! The roads that a study draws, in coarse classes.

pub(crate) mod text;

use crate::answer::Answer;
use crate::error::Error;
use crate::progress::Watch;
use crate::watch::watched;
use ocmc_core::fleet::run::RunPlan;
use ocmc_estimation::fit::operating_cycle::{BirdsEye, birds_eye_of_study};
use ocmc_io::study::{LoadedStudy, study_hash};
use serde::Serialize;

/// Which roads.
#[derive(Clone, Debug)]
pub struct BirdsEyeRequest<'a> {
    /// The study that draws them.
    pub study: &'a LoadedStudy,
    /// The cycles whose roads they are.
    pub plan: RunPlan,
}

/// What the roads look like from above.
#[derive(Clone, Debug, Serialize)]
pub struct BirdsEyeAnswer {
    /// Name of the study.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// Number of cycles.
    pub cycles: u64,
    /// The classes, and what they come from.
    pub birds_eye: BirdsEye,
}

/// Draws the roads and looks at them from above.
///
/// ```
/// use ocmc_api::{Answer, BirdsEyeRequest, RunPlan, birds_eye, go_on, study};
/// let study = study::load("field-truck", &["mission.length_m=5000"])?;
/// let plan = RunPlan::new(1, 0, 20, None, None);
/// let view = birds_eye(&BirdsEyeRequest { study: &study, plan }, &mut go_on)?;
/// assert_eq!(view.birds_eye.length_m, 100_000.0);
/// assert!(view.text().starts_with("field-truck: 20 operating cycles, 100.0 km\n"));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Interrupted`].
pub fn birds_eye(request: &BirdsEyeRequest, watch: &mut Watch) -> Result<BirdsEyeAnswer, Error> {
    let BirdsEyeRequest { study, plan } = request;
    let ids = plan.first_cycle..plan.first_cycle + plan.cycles;
    let birds_eye =
        watched(plan.cycles, watch, |look| birds_eye_of_study(&study.study, plan.seed, ids, look))?;
    Ok(BirdsEyeAnswer {
        study: study.model.study.name.clone(),
        study_hash: study_hash(&study.model),
        seed: plan.seed,
        first_cycle: plan.first_cycle,
        cycles: plan.cycles,
        birds_eye,
    })
}

impl Answer for BirdsEyeAnswer {
    fn text(&self) -> String {
        text::answer(self)
    }
}
