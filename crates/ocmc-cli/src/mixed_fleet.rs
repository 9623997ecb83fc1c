//! `ocmc` on a study with groups, `[[fleet.group]]`: what a fleet of several kinds of trucks adds
//! up to.

use crate::failure::Failure;
use crate::output::{self, warn};
use crate::progress::{busy, watched};
use ocmc_api::shell_word::shell_word;
use ocmc_api::study::FleetGroup;
use ocmc_api::{CpuLevel, MixedFleetRequest, REPORT, RunFormat, stored_workbook};
use std::collections::BTreeSet;
use std::path::Path;

/// How a fleet is driven, and where its answer goes.
pub(crate) struct FleetRun<'a> {
    /// Master seed.
    pub(crate) seed: u64,
    /// Threads; one for each CPU where there is no number.
    pub(crate) threads: Option<usize>,
    /// Instructions to use.
    pub(crate) level: CpuLevel,
    /// Directory of the runs of its groups.
    pub(crate) out: Option<&'a Path>,
    /// Format of these.
    pub(crate) format: Option<RunFormat>,
    /// Whether runs that are there are finished.
    pub(crate) resume: bool,
    /// No progress and no hints.
    pub(crate) quiet: bool,
    /// The answer as JSON.
    pub(crate) json: bool,
}

/// Refuses options that groups say themselves: each with whether it was given.
pub(crate) fn check_options(groups: &[FleetGroup], given: &[(&str, bool)]) -> Result<(), Failure> {
    let Some((name, _)) = given.iter().find(|(_, given)| *given) else { return Ok(()) };
    Err(Failure::Usage(format!(
        "{name} does not go with this study: the study has groups, `[[fleet.group]]`, which say \
         it; one of them: --set fleet.group={}",
        groups[0].name
    )))
}

/// Drives the groups of a fleet, and prints what they add up to.
pub(crate) fn run_fleet(groups: &[FleetGroup], run: &FleetRun) -> Result<(), Failure> {
    let FleetRun { seed, threads, level, format, resume, quiet, json, .. } = *run;
    // what holds for all groups is said once
    let warnings: BTreeSet<String> =
        groups.iter().flat_map(|group| group.study.warnings()).collect();
    for warning in &warnings {
        warn(warning);
    }
    let records = format.and_then(RunFormat::records).unwrap_or_default();
    let out = run.out.map(|path| (path.to_owned(), records));
    let request = MixedFleetRequest { groups, seed, threads, level, out, resume };
    let answer = watched(quiet, |watch| ocmc_api::mixed_fleet(&request, watch))?;
    output::print(&answer, json)?;
    let Some(path) = run.out else {
        if !quiet && !json {
            output::note(&format!(
                "More: --out DIR keeps each group's run; --set fleet.group={} answers one in full.",
                shell_word(Path::new(&groups[0].name))
            ));
        }
        return Ok(());
    };
    for group in groups.iter().filter(|_| format == Some(RunFormat::Workbook)) {
        let directory = &path.join(&group.name);
        busy(quiet, "writing the workbook", || stored_workbook(directory, None))?;
    }
    if !quiet && !json {
        let shown = path.display();
        output::note(&format!(
            "Written: `{shown}`, a folder of each group's run, and `{REPORT}`, which any browser \
             opens. `ocmc report {}` makes a page of each group.",
            shell_word(path)
        ));
    }
    Ok(())
}
