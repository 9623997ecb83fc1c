//! Study files: the built-in ones and those of a user.

pub mod builtin;

use ocmc_core::study::StudyModel;
use serde::Deserialize;

/// The default study.
pub fn default_study() -> Result<StudyModel, toml::de::Error> {
    let mut study: toml::Table = toml::from_str(builtin::FIELD_TRUCK)?;
    let vehicle: toml::Table = toml::from_str(builtin::TRACTOR_40T)?;
    study.insert("vehicle".to_owned(), vehicle.into());
    StudyModel::deserialize(study)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::study::Study;

    #[test]
    fn the_default_study_is_valid() {
        Study::new(default_study().unwrap()).unwrap();
    }
}
