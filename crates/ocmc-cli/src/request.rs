//! What the arguments mean: the plan of a run, checked against this machine.

use crate::arguments::{AnalysisArguments, RunArguments};
use crate::failure::Failure;
use ocmc_core::fleet::quantity::{RecordQuantity, quantity};
use ocmc_core::fleet::run::RunPlan;
use ocmc_core::kernel::cpu::CpuLevel;
use ocmc_core::random::LAST_CYCLE_ID;

/// Works out which cycles to run, and on what.
pub(crate) fn plan(arguments: &RunArguments) -> Result<RunPlan, Failure> {
    let (first_cycle, cycles) = (arguments.first_cycle, arguments.cycles);
    check_range(first_cycle, cycles)?;
    plan_of(arguments, arguments.seed, first_cycle, cycles)
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

/// The plan of an analysis, and the quantity that it asks about, where one was named.
pub(crate) fn analysis(
    arguments: &AnalysisArguments,
) -> Result<(RunPlan, Option<&'static RecordQuantity>), Failure> {
    let AnalysisArguments { seed, first_cycle, cycles, threads, .. } = *arguments;
    check_range(first_cycle, cycles)?;
    let quantity = arguments.column.as_deref().and_then(quantity);
    Ok((RunPlan::new(seed, first_cycle, cycles, threads, None), quantity))
}

/// The plan of these cycles, on what the arguments say.
pub(crate) fn plan_of(
    arguments: &RunArguments,
    seed: u64,
    first_cycle: u64,
    cycles: u64,
) -> Result<RunPlan, Failure> {
    let level = level(arguments)?;
    let RunArguments { threads, chunk, .. } = *arguments;
    Ok(RunPlan { level, ..RunPlan::new(seed, first_cycle, cycles, threads, chunk) })
}

fn level(arguments: &RunArguments) -> Result<CpuLevel, Failure> {
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
