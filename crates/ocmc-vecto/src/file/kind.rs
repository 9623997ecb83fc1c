//! Kinds of jobs: those that are not computed here are refused before their keys are
//! looked at.

use super::error::VectoError;
use super::part::Part;

/// Jobs of one engine and one gearbox.
const ALLOWED: &str = "allowed are trucks with an engine and a gearbox, in JSON (versions 2 to 5)";

/// Keys that only jobs of a kind have, and the kind.
const KEYS: [(&str, &str); 5] = [
    ("DeclarationVehicle", "a verification test (VTP), whose vehicle is XML"),
    ("PrimaryVehicle", "a bus in stages, whose vehicle is XML"),
    ("CompletedVehicle", "a bus in stages, whose vehicle is XML"),
    ("HybridStrategyParams", "a hybrid"),
    ("Padd_electric", "a vehicle with an electric motor"),
];

/// Kinds by the version of the file [F: VECTO 3, reader of jobs].
const VERSIONS: [(u32, &str); 11] = [
    (6, "a single bus, whose vehicle is XML"),
    (7, "a completed bus, whose vehicle is XML"),
    (8, "a parallel hybrid"),
    (9, "a battery-electric vehicle"),
    (10, "a bus in stages, whose vehicle is XML"),
    (11, "a serial hybrid"),
    (12, "a vehicle with an integrated electric powertrain (IEPC)"),
    (13, "a hybrid with an integrated motor (IHPC)"),
    (14, "a fuel-cell hybrid"),
    (15, "a fuel-cell vehicle with an integrated powertrain"),
    (16, "a vehicle with several powertrains"),
];

/// Refuses a job that is no truck with an engine and a gearbox.
pub(super) fn check(job: &Part) -> Result<(), VectoError> {
    if job.body["EngineOnlyMode"] == true {
        let allowed =
            "allowed is `false`: set it to take the whole truck of the job, where it names one";
        return job.refused("`EngineOnlyMode`", "`true`, an engine alone".to_owned(), allowed);
    }
    let has = |key: &str| !job.body[key].is_null();
    let by_version = VERSIONS.iter().find(|(version, _)| job.version == Some(*version));
    let by_key = KEYS.iter().find(|(key, _)| has(key));
    match (by_version.map(|(_, kind)| kind), by_key.map(|(_, kind)| kind)) {
        (Some(kind), _) | (None, Some(kind)) => {
            job.refused("its kind", (*kind).to_owned(), ALLOWED)
        }
        (None, None) if job.version.is_some_and(|version| version > 16) => {
            job.refused("`FileVersion`", format!("{}", job.version.unwrap_or_default()), ALLOWED)
        }
        (None, None) => Ok(()),
    }
}
