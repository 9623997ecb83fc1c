//! What the commands on measured logs share: which column is what, reading, and drives that cannot be used.

use crate::failure::Failure;
use crate::output;
use ocmc_io::log::curves::TripError;
use ocmc_io::log::{LogFile, Need, read};
use ocmc_io::table::{Mapping, Source};
use std::path::Path;

/// Which column is what, as typed.
pub(crate) fn mappings(typed: &[String]) -> Result<Vec<Mapping>, Failure> {
    Ok(typed.iter().map(|text| Mapping::parse(text)).collect::<Result<_, _>>()?)
}

/// Reads logs one after the other, and says what is odd in each.
pub(crate) fn read_logs<'a>(
    paths: impl IntoIterator<Item = &'a Path>,
    mappings: &[Mapping],
    needs: &[Need],
    mut use_file: impl FnMut(&LogFile),
) -> Result<(), Failure> {
    for path in paths {
        let file = read(Source::File(path), mappings, needs)?;
        for warning in file.warnings() {
            output::note(&format!("warning: {warning}"));
        }
        use_file(&file);
    }
    Ok(())
}

/// Fails by the first drive that was left out, where nothing could be used, and names the others.
pub(crate) fn tell_left_out(
    failed: Option<&(String, TripError)>,
    left_out: &[(String, TripError)],
) -> Result<(), Failure> {
    if let Some((place, fault)) = failed {
        return Err(Failure::Drive { place: place.clone(), fault: fault.clone() });
    }
    for (place, fault) in left_out {
        output::note(&format!("warning: {place} is left out: {fault}"));
    }
    Ok(())
}
