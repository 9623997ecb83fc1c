//! Studies: the built-in ones, files and dictionaries, read and checked.

pub use ocmc_core::study::StudyModel;
pub use ocmc_io::study::{
    BuiltIn, Cause, Fault, Files, Given, LoadedStudy, Origin, StudyFileError, commented,
    fitted_study, init_text, init_text_of, list, load, load_json, load_text, open, resolved_toml,
    schema, study_hash, text, vehicles,
};
