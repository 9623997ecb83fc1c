//! The files of a study, and the one place that lets them be read.

use super::error::{Cause, Fault};
use super::fastsim;
use std::path::{Path, PathBuf};

/// Where the files lie that a study names, or that it may name none.
///
/// Every name in a study becomes a path here and nowhere else, so that a program can take studies
/// of strangers: with [`Files::Refused`] nothing is opened, and nobody learns whether a file
/// exists.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Files {
    /// In this folder; vehicles of other programs by this reader.
    In(PathBuf, VehicleReader),
    /// Nowhere: studies and vehicles are built in or written inline.
    Refused,
}

/// Reads the vehicle of another program; none where the path is of no file of it.
#[derive(Clone, Copy, Debug)]
pub struct VehicleReader(pub fn(&Path) -> Option<Result<ForeignVehicle, String>>);

/// The files of a study are the same, whoever reads them.
impl PartialEq for VehicleReader {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for VehicleReader {}

/// A vehicle of another program.
#[derive(Clone, Debug, PartialEq)]
pub struct ForeignVehicle {
    /// What its file says, as keys of a vehicle.
    pub keys: serde_json::Value,
    /// The built-in vehicle that has the rest.
    pub base: &'static str,
    /// Values of its file that are not used, for people.
    pub notes: Vec<String>,
}

impl Default for Files {
    fn default() -> Self {
        Self::here()
    }
}

impl Files {
    /// Those in the folder that the program runs in.
    pub fn here() -> Self {
        Self::In(PathBuf::new(), VehicleReader(|_| None))
    }

    /// The same, with a reader of vehicles of other programs.
    #[must_use]
    pub fn reading(&self, vehicles: VehicleReader) -> Self {
        match self {
            Self::In(folder, _) => Self::In(folder.clone(), vehicles),
            Self::Refused => Self::Refused,
        }
    }

    /// The vehicle of FASTSim or of another program, and the path, where a name is of a file of one.
    pub(super) fn foreign(&self, name: &str) -> Option<(Result<ForeignVehicle, String>, PathBuf)> {
        let Self::In(folder, VehicleReader(read)) = self else { return None };
        let path = folder.join(name);
        Some((fastsim::read(&path).or_else(|| read(&path))?, path))
    }

    /// Those beside a file; a study that is built in has its own folder nowhere else.
    pub(super) fn beside(&self, file: Option<&Path>) -> Self {
        match (self, file.and_then(Path::parent)) {
            (Self::In(_, vehicles), Some(folder)) => Self::In(folder.to_owned(), *vehicles),
            (Self::In(_, vehicles), None) => Self::here().reading(*vehicles),
            (Self::Refused, _) => Self::Refused,
        }
    }

    /// The path of a file that a key names.
    pub(super) fn path(&self, key: &str, name: impl AsRef<Path>) -> Result<PathBuf, Box<Fault>> {
        match self {
            Self::In(folder, _) => Ok(folder.join(name)),
            Self::Refused => Err(Fault::new(Cause::FileRefused(key.to_owned()))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_lies_beside_the_one_that_names_it_or_is_refused() {
        let here = Files::here();
        let below = here.beside(Some(Path::new("a/b.toml")));
        assert_eq!(here.path("vehicle.base", "c").ok(), Some("c".into()));
        assert_eq!(below.path("vehicle.base", "c").ok(), Some("a/c".into()));
        assert_eq!(below.beside(None), here);
        let refused = Files::Refused.beside(Some(Path::new("a/b.toml")));
        let error = refused.path("vehicle.base", "/etc/passwd").expect_err("refused");
        assert!(error.to_string().starts_with("`vehicle.base` names a file"), "{error}");
        assert!(!error.to_string().contains("passwd"));
    }
}
