//! Studies: the built-in ones, files and dictionaries, read and checked; their vehicles may be jobs
//! of VECTO.

pub use ocmc_core::study::StudyModel;
pub use ocmc_io::study::{
    BuiltIn, Cause, Fault, Files, FleetGroup, Given, LoadedStudy, Opened, Origin, StudyFileError,
    commented, fitted_study, init_text, init_text_of, list, resolved_toml, schema, study_hash,
    text, vehicles,
};

use ocmc_vecto::file::VEHICLES;
use std::path::Path;

/// As [`ocmc_io::study::open`].
///
/// # Errors
/// [`StudyFileError`] says what is wrong, where, and what is allowed.
pub fn open<S: AsRef<str>>(
    given: &Given,
    files: &Files,
    sets: &[S],
) -> Result<LoadedStudy, StudyFileError> {
    ocmc_io::study::open(given, &files.reading(VEHICLES), sets)
}

/// As [`ocmc_io::study::open_all`].
///
/// # Errors
/// As [`open`].
pub fn open_all<S: AsRef<str>>(
    given: &Given,
    files: &Files,
    sets: &[S],
) -> Result<Opened, StudyFileError> {
    ocmc_io::study::open_all(given, &files.reading(VEHICLES), sets)
}

/// As [`ocmc_io::study::load`].
///
/// # Errors
/// As [`open`].
pub fn load<S: AsRef<str>>(name_or_path: &str, sets: &[S]) -> Result<LoadedStudy, StudyFileError> {
    open(&Given::Named(Path::new(name_or_path)), &Files::here(), sets)
}

/// As [`ocmc_io::study::load_text`].
///
/// # Errors
/// As [`open`].
pub fn load_text<S: AsRef<str>>(
    name: &str,
    text: &str,
    sets: &[S],
) -> Result<LoadedStudy, StudyFileError> {
    open(&Given::Text(name, text), &Files::here(), sets)
}

/// As [`ocmc_io::study::load_json`].
///
/// # Errors
/// As [`open`].
pub fn load_json<S: AsRef<str>>(
    dictionary: &serde_json::Value,
    sets: &[S],
) -> Result<LoadedStudy, StudyFileError> {
    open(&Given::Dictionary(dictionary), &Files::here(), sets)
}
