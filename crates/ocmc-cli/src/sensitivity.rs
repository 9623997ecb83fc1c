//! `ocmc sensitivity`: which factors the spread between cycles comes from.

use crate::arguments::SensitivityArguments;
use crate::failure::Failure;
use crate::progress::watched;
use crate::{output, request};
use ocmc_api::{SensitivityRequest, study};

/// Drives the design and prints the shares.
pub(crate) fn sensitivity(arguments: &SensitivityArguments) -> Result<(), Failure> {
    let loaded = study::load(&arguments.study, &arguments.set)?;
    let plan = request::analysis(&arguments.analysis)?;
    if let Some(cycles) = arguments.crossed {
        request::check_range(plan.first_cycle, cycles).map_err(|_| {
            request::usage("--first-cycle with --crossed goes beyond the largest cycle id")
        })?;
    }
    let request = SensitivityRequest {
        study: &loaded,
        plan,
        column: arguments.analysis.column.clone(),
        factors: (!arguments.factor.is_empty()).then(|| arguments.factor.clone()),
        crossed: arguments.crossed,
    };
    let answer = watched(arguments.analysis.quiet, |watch| ocmc_api::sensitivity(&request, watch))?;
    output::print(&answer, arguments.analysis.json)
}
