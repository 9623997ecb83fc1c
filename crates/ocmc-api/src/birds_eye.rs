//! The roads that a study draws, in coarse classes.

use crate::answer::Answer;
use crate::error::Error;
use crate::watch::{Watch, watched};
use ocmc_core::fleet::run::RunPlan;
use ocmc_estimation::fit::operating_cycle::{BirdsEye, birds_eye_of_study};
use ocmc_io::number_text::{grouped, rounded};
use ocmc_io::study::{LoadedStudy, study_hash};
use serde::Serialize;
use serde_json::json;
use std::fmt::Write;

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
        let (cycles, view) = (grouped(self.cycles), &self.birds_eye);
        let km = rounded(view.length_m / 1000.0);
        format!("{}: {cycles} operating cycles, {km} km\n{}", self.study, birds_eye_text(view))
    }
}

/// A class in words.
fn words(class: &serde_json::Value) -> String {
    class.as_str().unwrap_or_default().replace('_', " ")
}

/// The classes and what they come from.
pub(crate) fn birds_eye_text(view: &BirdsEye) -> String {
    let unknown = || "not known".to_owned();
    let hilliness = view.share_below.map_or_else(unknown, |shares| {
        let [three, six, nine] = shares.map(|share| 100.0 * share);
        let class = words(&json!(view.hilliness));
        format!("{class}: below 3, 6, 9 % on {three:.1}, {six:.1}, {nine:.1} %")
    });
    let curves = view.curves_per_km.map_or_else(unknown, |per_km| {
        format!("{}, {per_km:.2} per km", words(&json!(view.curve_density)))
    });
    let mut text = format!(
        "hilliness        {hilliness}\n\
         transport cycle  {}\n\
         stops            {}, {:.2} per km\n\
         curves < 500 m   {curves}\n",
        words(&json!(view.transport_cycle)),
        words(&json!(view.stop_density)),
        view.stops_per_km,
    );
    for (name, share) in &view.road_type_share {
        let _ = writeln!(text, "{name:15}  {:.1} % of the way", 100.0 * share);
    }
    text
}
