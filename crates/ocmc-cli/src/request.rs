//! What the arguments mean: the plan of a run, checked against this machine.

use crate::arguments::{AnalysisArguments, RunArguments};
use crate::failure::Failure;
use ocmc_api::{CpuLevel, LAST_CYCLE_ID, RunPlan};

/// The plan of a run.
pub(crate) fn plan(arguments: &RunArguments) -> Result<RunPlan, Failure> {
    let RunArguments { seed, first_cycle, cycles, threads, chunk, .. } = *arguments;
    check_range(first_cycle, cycles)?;
    Ok(RunPlan::new(seed, first_cycle, cycles, threads, chunk))
}

/// The plan of an analysis.
pub(crate) fn analysis(arguments: &AnalysisArguments) -> Result<RunPlan, Failure> {
    let AnalysisArguments { seed, first_cycle, cycles, threads, .. } = *arguments;
    check_range(first_cycle, cycles)?;
    Ok(RunPlan::new(seed, first_cycle, cycles, threads, None))
}

/// Checks that all cycles have an id.
pub(crate) fn check_range(first_cycle: u64, cycles: u64) -> Result<(), Failure> {
    if first_cycle.checked_add(cycles).is_none_or(|end| end > LAST_CYCLE_ID) {
        return Err(usage(&format!(
            "--first-cycle {first_cycle} with --cycles {cycles} goes beyond the largest cycle id; \
             allowed is a sum of at most {LAST_CYCLE_ID}"
        )));
    }
    Ok(())
}

/// The instructions to use.
pub(crate) fn level(arguments: &RunArguments) -> Result<CpuLevel, Failure> {
    let Some(name) = &arguments.cpu_level else {
        return Ok(CpuLevel::best());
    };
    let level = CpuLevel::ALL.into_iter().find(|level| level.name() == name);
    level.filter(|level| level.is_available()).ok_or_else(|| {
        let available = CpuLevel::ALL.into_iter().filter(|level| level.is_available());
        let available: Vec<&str> = available.map(CpuLevel::name).collect();
        usage(&format!("this CPU has no {name}; allowed is one of: {}", available.join(", ")))
    })
}

/// Wrong usage that no single argument shows.
pub(crate) fn usage(message: &str) -> Failure {
    Failure::Usage(message.to_owned())
}
