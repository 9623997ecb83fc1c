//! `ocmc compare`: studies under common random numbers, the first one as the baseline.

use crate::arguments::CompareArguments;
use crate::failure::Failure;
use crate::progress::watched;
use crate::{output, request};
use ocmc_api::CompareRequest;
use ocmc_api::study::{self, LoadedStudy};

/// Compares the studies and prints the differences.
pub(crate) fn compare(arguments: &CompareArguments) -> Result<(), Failure> {
    let named = named(arguments)?;
    let plan = request::analysis(&arguments.analysis)?;
    let request = CompareRequest {
        studies: named.iter().map(|(name, loaded)| (name.clone(), loaded)).collect(),
        plan,
        column: arguments.analysis.column.clone(),
    };
    let answer = watched(arguments.analysis.quiet, |watch| ocmc_api::compare(&request, watch))?;
    output::print(&answer, arguments.analysis.json)
}

/// The studies that were named; of a single one, the study as it is and with the settings.
fn named(arguments: &CompareArguments) -> Result<Vec<(String, LoadedStudy)>, Failure> {
    let load = |name: &String, sets: &[String]| -> Result<(String, LoadedStudy), Failure> {
        let loaded = study::load(name, sets)?;
        Ok((loaded.origin.to_string(), loaded))
    };
    if let [only] = arguments.studies.as_slice() {
        if arguments.set.is_empty() {
            return Err(request::usage(
                "a study is compared with another one, or with itself under --set: give a second \
                 study, or --set KEY=VALUE",
            ));
        }
        let (a, mut b) = (load(only, &[])?, load(only, &arguments.set)?);
        b.0 = format!("{} with {}", b.0, arguments.set.join(" with "));
        return Ok(vec![a, b]);
    }
    arguments.studies.iter().map(|name| load(name, &arguments.set)).collect()
}
