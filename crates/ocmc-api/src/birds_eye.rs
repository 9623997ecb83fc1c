//! The roads that a study draws, in coarse classes.

use crate::answer::Answer;
use crate::error::Error;
use crate::watch::{Watch, watched};
use ocmc_estimation::fit::operating_cycle::{BirdsEye, birds_eye_of_laws, birds_eye_of_study};
use ocmc_fleet::run::RunPlan;
use ocmc_io::number_text::{grouped, rounded};
use ocmc_io::study::{LoadedStudy, study_hash};
use serde::Serialize;
use serde_json::json;
use std::fmt::Write;

/// Roads to be drawn.
#[derive(Clone, Debug)]
pub struct BirdsEyeRequest<'a> {
    /// The study that draws them.
    pub study: &'a LoadedStudy,
    /// The cycles whose roads they are; none: the mean of all, by the study's laws.
    pub plan: Option<RunPlan>,
}

/// View of the roads from above.
#[derive(Clone, Debug, Serialize)]
pub struct BirdsEyeAnswer {
    /// Name of the study.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Master seed; none without draws.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Id of the first cycle; none without draws.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_cycle: Option<u64>,
    /// Number of cycles; none without draws.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cycles: Option<u64>,
    /// The classes, and what they come from.
    pub birds_eye: BirdsEye,
}

/// Looks at the roads of a study from above: draws them, or follows their laws.
///
/// ```
/// use ocmc_api::{Answer, BirdsEyeRequest, RunPlan, birds_eye, go_on, study};
/// let study = study::load("field-truck", &["mission.length_m=5000"])?;
/// let plan = Some(RunPlan::new(1, 0, 20, None, None));
/// let view = birds_eye(&BirdsEyeRequest { study: &study, plan }, &mut go_on)?;
/// assert_eq!(view.birds_eye.length_m, 100_000.0);
/// assert!(view.text().starts_with("field-truck: 20 operating cycles, 100.0 km\n"));
/// let laws = birds_eye(&BirdsEyeRequest { study: &study, plan: None }, &mut go_on)?;
/// assert_eq!(laws.birds_eye.length_m, 5000.0);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::Interrupted`], and without a plan [`Error::GivenRoads`] where the study drives routes.
pub fn birds_eye(request: &BirdsEyeRequest, watch: &mut Watch) -> Result<BirdsEyeAnswer, Error> {
    let BirdsEyeRequest { study, plan } = request;
    let name = &study.model.study.name;
    let birds_eye = match plan {
        Some(plan) => {
            let ids = plan.first_cycle..plan.first_cycle + plan.cycles;
            watched(plan.cycles, watch, |look| {
                birds_eye_of_study(&study.study, plan.seed, ids, look)
            })?
        }
        None => birds_eye_of_laws(&study.study).ok_or_else(|| Error::GivenRoads(name.clone()))?,
    };
    let plan = plan.as_ref();
    Ok(BirdsEyeAnswer {
        study: name.clone(),
        study_hash: study_hash(&study.model),
        seed: plan.map(|plan| plan.seed),
        first_cycle: plan.map(|plan| plan.first_cycle),
        cycles: plan.map(|plan| plan.cycles),
        birds_eye,
    })
}

impl Answer for BirdsEyeAnswer {
    fn text(&self) -> String {
        let view = &self.birds_eye;
        let km = rounded(view.length_m / 1000.0);
        let extent = self.cycles.map_or_else(
            || format!("by its laws, {km} km a cycle"),
            |cycles| format!("{} operating cycles, {km} km", grouped(cycles)),
        );
        format!("{}: {extent}\n{}", self.study, birds_eye_text(view))
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
