//! The part of a study's mean that hangs on judged numbers, before and after.

use super::LearnRequest;
use crate::doubt::{DoubtRequest, doubt};
use crate::error::Error;
use crate::watch::Watch;
use ocmc_fleet::run::RunPlan;
use ocmc_io::study::LoadedStudy;
use serde::Serialize;

/// Cycles at each end of the twelve entries that matter most.
const CYCLES: u64 = 96;
/// Entries that are named.
const NAMED: usize = 3;

/// The part of a study's mean that hangs on judged numbers.
#[derive(Clone, Debug, Serialize)]
pub struct Doubted {
    /// Name of the study.
    pub study: String,
    /// Name of the consumption.
    pub column: String,
    /// Mean of the fleet.
    pub mean: f64,
    /// Root of the sum of squares of the effects of judged numbers on it.
    pub together: f64,
    /// Entries that do most, with their shares of the sum.
    pub largest: Vec<(String, f64)>,
}

impl Doubted {
    pub(super) fn of(
        name: &str,
        study: &LoadedStudy,
        request: &LearnRequest,
        watch: &mut Watch,
    ) -> Result<Self, Error> {
        let plan = RunPlan::new(request.seed, 0, CYCLES, request.threads, None);
        let asked =
            DoubtRequest { study: (name.to_owned(), study), against: None, plan, column: None };
        let doubted = doubt(&asked, watch)?;
        let named = doubted.numbers.iter().take(NAMED);
        Ok(Self {
            study: name.to_owned(),
            column: doubted.column.to_owned(),
            mean: doubted.is.map_or(f64::NAN, |shape| shape.mean),
            together: doubted.together.mean,
            largest: named.map(|entry| (entry.name.clone(), entry.share)).collect(),
        })
    }
}
