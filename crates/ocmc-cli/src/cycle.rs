//! `ocmc cycle`: one realised operating cycle, as tracks.

use crate::arguments::CycleArguments;
use crate::failure::Failure;
use crate::table_file;
use ocmc_io::{operating_cycle, study};

/// Draws one operating cycle and writes down its tracks.
pub(crate) fn cycle(arguments: &CycleArguments) -> Result<(), Failure> {
    let target = table_file::target(arguments.out.as_deref())?;
    let loaded = study::load(&arguments.study, &arguments.set)?;
    let (seed, cycle_id) = (arguments.seed, arguments.cycle_id);
    let cycle = loaded.study.sample(seed, cycle_id).cycle;
    let tracks = operating_cycle::tracks(&loaded.study, &cycle);
    table_file::write_tracks(&target, &tracks, || {
        operating_cycle::to_json(cycle_id, seed, &cycle, &tracks)
    })
}
