//! Which factors the spread between cycles comes from.

mod text;

use crate::answer::Answer;
use crate::error::Error;
use crate::progress::Watch;
use crate::watch::watched;
use ocmc_core::fleet::quantity::{RecordQuantity, quantity};
use ocmc_core::fleet::random_effects::{TwoWay, two_way};
use ocmc_core::fleet::run::RunPlan;
use ocmc_core::fleet::sensitivity::{
    FactorGroup, Sensitivity, factor_groups, sensitivity as shares_of,
};
use ocmc_core::random::sampling::Sampling;
use ocmc_io::study::{LoadedStudy, Origin, study_hash};
use serde::Serialize;
use std::time::Instant;

pub use ocmc_core::fleet::sensitivity::SensitivityError;

/// Drivers of a crossed design.
const DRIVERS: u64 = 30;

/// What the variance is of, and to what it is shared out.
#[derive(Clone, Debug)]
pub struct SensitivityRequest<'a> {
    /// The study.
    pub study: &'a LoadedStudy,
    /// The rows of the design: each drives two cycles, and one more for each factor.
    pub plan: RunPlan,
    /// Name of the quantity; the consumption where there is none.
    pub column: Option<String>,
    /// Names of the factors; all where there are none.
    pub factors: Option<Vec<String>>,
    /// A second opinion: so many cycles with each of 30 drivers, and the variance split two ways.
    pub crossed: Option<u64>,
}

/// The shares of the variance.
#[derive(Clone, Debug, Serialize)]
pub struct SensitivityAnswer {
    /// Name of the study.
    pub study: String,
    /// Hash of the resolved study.
    pub study_hash: String,
    /// Where the study comes from.
    #[serde(skip)]
    pub origin: Origin,
    /// Master seed.
    pub seed: u64,
    /// Id of the first cycle.
    pub first_cycle: u64,
    /// The shares.
    #[serde(flatten)]
    pub sensitivity: Sensitivity,
    /// The second opinion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub two_way: Option<TwoWay>,
    /// How long the design took, in s.
    pub wall_s: f64,
    /// Threads that it took.
    pub threads: usize,
}

/// Drives the design and shares the variance out.
///
/// ```
/// use ocmc_api::{RunPlan, SensitivityRequest, go_on, sensitivity, study};
/// let study = study::load("field-truck", &["mission.length_m=5000"])?;
/// let request = SensitivityRequest {
///     study: &study,
///     plan: RunPlan::new(1, 0, 20, None, None),
///     column: None,
///     factors: Some(vec!["road".to_owned(), "driver".to_owned()]),
///     crossed: None,
/// };
/// let answer = sensitivity(&request, &mut go_on)?;
/// assert_eq!(answer.sensitivity.factors[1].factor, "driver");
/// assert_eq!(answer.sensitivity.cycles, 80);
/// # Ok::<(), ocmc_api::Error>(())
/// ```
///
/// # Errors
/// [`Error::UnknownColumn`] and [`Error::UnknownFactor`]; [`Error::Sensitivity`] where too few
/// cycles count, or where a crossed design is asked for of cycles that depend on one another;
/// [`Error::Interrupted`].
pub fn sensitivity(
    request: &SensitivityRequest,
    watch: &mut Watch,
) -> Result<SensitivityAnswer, Error> {
    let SensitivityRequest { study, plan, column, factors, crossed } = request;
    let quantity = quantity_named(column.as_deref())?;
    let groups = groups_named(factors.as_deref())?;
    if crossed.is_some() && study.model.simulation.sampling != Sampling::Independent {
        return Err(SensitivityError::NotIndependent.into());
    }
    let clock = Instant::now();
    let cycles = plan.cycles.saturating_mul(2 + groups.len() as u64);
    let shares =
        watched(cycles, watch, |look| shares_of(&study.study, plan, &groups, quantity, look))??;
    let wall_s = clock.elapsed().as_secs_f64();
    let split = |cycles: u64| {
        let (plan, total) = (RunPlan { cycles, ..*plan }, cycles * DRIVERS);
        watched(total, watch, |look| two_way(&study.study, &plan, DRIVERS, quantity, look))?
            .map_err(Error::from)
    };
    Ok(SensitivityAnswer {
        study: study.model.study.name.clone(),
        study_hash: study_hash(&study.model),
        origin: study.origin.clone(),
        seed: plan.seed,
        first_cycle: plan.first_cycle,
        sensitivity: shares,
        two_way: crossed.map(split).transpose()?,
        wall_s,
        threads: plan.threads,
    })
}

impl Answer for SensitivityAnswer {
    fn text(&self) -> String {
        text::answer(self)
    }
}

/// The quantity of that name, where one is named.
pub(crate) fn quantity_named(
    column: Option<&str>,
) -> Result<Option<&'static RecordQuantity>, Error> {
    let known =
        |name: &str| quantity(name).ok_or_else(|| Error::UnknownColumn { name: name.to_owned() });
    column.map(known).transpose()
}

/// The groups of these names, in the order of the design; all where none are named.
fn groups_named(names: Option<&[String]>) -> Result<Vec<FactorGroup>, Error> {
    let mut groups = factor_groups();
    if let Some(names) = names {
        if let Some(name) = names.iter().find(|name| groups.iter().all(|g| g.name != **name)) {
            return Err(Error::UnknownFactor { name: name.clone() });
        }
        groups.retain(|group| names.iter().any(|name| name == group.name));
    }
    Ok(groups)
}
