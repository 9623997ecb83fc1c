//! How far the work on a question is: the caller can watch it, and end it.

use schemars::JsonSchema;
use serde::Serialize;
use std::ops::ControlFlow;

/// How far the work is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Progress {
    /// Unit of the count: `cycles`, `trips`, `events`, `logs` that are read, or cycles on both
    /// sides of uncertain numbers.
    pub what: &'static str,
    /// Units that are done.
    pub done: u64,
    /// Units in total.
    pub total: u64,
}

/// Watches the work: it is called before the work begins, and several times a second. Where it
/// breaks, the question has no answer but [`crate::Error::Interrupted`].
pub type Watch<'a> = dyn FnMut(Progress) -> ControlFlow<()> + 'a;

/// Watches nothing: the work goes on to its end.
///
/// ```
/// use ocmc_api::{BirdsEyeRequest, RunPlan, birds_eye, go_on, study};
/// let study = study::load("field-truck", &["mission.length_m=5000"])?;
/// let plan = Some(RunPlan::new(1, 0, 3, None, None));
/// assert_eq!(birds_eye(&BirdsEyeRequest { study: &study, plan }, &mut go_on)?.cycles, Some(3));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
pub fn go_on(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}
