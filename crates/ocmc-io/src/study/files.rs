//! The files of a study, and the one place that lets them be read.

use super::error::{Cause, Fault, StudyFileError};
use super::fastsim;
use std::path::{Component, Path, PathBuf};

/// Where the files lie that a study names, or that it may name none.
///
/// Every name in a study becomes a path here and nowhere else, so that a program can take studies
/// of strangers: with [`Files::Refused`] nothing is opened, and nobody learns whether a file
/// exists.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Files {
    /// In this folder; vehicles of other programs by this reader.
    In(PathBuf, VehicleReader),
    /// In this folder, and nowhere else: a name that leads out of it is refused, and vehicles of
    /// VECTO, whose files name others, are none.
    Within(PathBuf),
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
    /// Contents of its file, as keys of a vehicle.
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
    /// Files in the folder that the program runs in.
    pub fn here() -> Self {
        Self::In(PathBuf::new(), VehicleReader(|_| None))
    }

    /// The same, with a reader of vehicles of other programs.
    #[must_use]
    pub fn reading(&self, vehicles: VehicleReader) -> Self {
        match self {
            Self::In(folder, _) => Self::In(folder.clone(), vehicles),
            Self::Within(_) | Self::Refused => self.clone(),
        }
    }

    /// Whether the one who asks may hand a study over in standard input.
    pub(super) fn take_standard_input(&self) -> bool {
        !matches!(self, Self::Within(_))
    }

    /// The vehicle of FASTSim or of another program, and the path, where a name is of a file of
    /// one.
    pub(super) fn foreign(&self, name: &str) -> Option<(Result<ForeignVehicle, String>, PathBuf)> {
        let path = self.path("vehicle.base", name).ok()?;
        let of_others = || match self {
            Self::In(_, VehicleReader(read)) => read(&path),
            Self::Within(_) | Self::Refused => None,
        };
        Some((fastsim::read(&path).or_else(of_others)?, path))
    }

    /// Files beside a file; a study that is built in has its own folder nowhere else.
    pub(super) fn beside(&self, file: Option<&Path>) -> Self {
        match (self, file.and_then(Path::parent)) {
            (Self::In(_, vehicles), Some(folder)) => Self::In(folder.to_owned(), *vehicles),
            (Self::In(_, vehicles), None) => Self::here().reading(*vehicles),
            (Self::Within(_) | Self::Refused, _) => self.clone(),
        }
    }

    /// The path of a file that a caller names under a key of its question.
    ///
    /// # Errors
    /// [`StudyFileError`] where no file may be read there.
    pub fn path_of(&self, key: &str, name: &str) -> Result<PathBuf, StudyFileError> {
        Ok(self.path(key, name)?)
    }

    /// Names of the files in the folder, in order; hidden ones and folders are left out.
    ///
    /// # Errors
    /// [`StudyFileError`] where no file may be read, or the folder cannot be.
    pub fn names(&self) -> Result<Vec<String>, StudyFileError> {
        let (Self::In(folder, _) | Self::Within(folder)) = self else {
            return Err(Fault::new(Cause::FileRefused("files".to_owned())).into());
        };
        let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let entries = std::fs::read_dir(here)
            .map_err(|error| Fault::new(Cause::File(format!("`{}`: {error}", here.display()))))?;
        let files = entries.flatten().filter(|entry| entry.path().is_file());
        let names = files.filter_map(|entry| entry.file_name().into_string().ok());
        let mut names: Vec<String> = names.filter(|name| !name.starts_with('.')).collect();
        names.sort();
        Ok(names)
    }

    /// The path of a file that a key names.
    pub(super) fn path(&self, key: &str, name: impl AsRef<Path>) -> Result<PathBuf, Box<Fault>> {
        match self {
            Self::In(folder, _) => Ok(folder.join(name)),
            Self::Within(folder) if is_below(name.as_ref()) => Ok(folder.join(name)),
            Self::Within(_) => Err(Fault::new(Cause::FileOutside(key.to_owned()))),
            Self::Refused => Err(Fault::new(Cause::FileRefused(key.to_owned()))),
        }
    }
}

/// Whether a name stays in the folder that it is looked for in.
fn is_below(name: &Path) -> bool {
    name.components().all(|component| matches!(component, Component::Normal(_)))
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

    #[test]
    fn a_name_that_leads_out_of_a_closed_folder_is_refused() {
        let closed = Files::Within("drop".into());
        assert_eq!(closed.path("study", "a.toml").ok(), Some("drop/a.toml".into()));
        assert_eq!(closed.beside(Some(Path::new("drop/a.toml"))), closed);
        assert_eq!(closed.beside(None), closed);
        for name in ["/etc/passwd", "../a", "b/../../a", "./a", "/"] {
            let error = closed.path("study", name).expect_err("outside").to_string();
            assert!(error.contains("outside") && !error.contains("passwd"), "{error}");
            assert!(closed.foreign(name).is_none());
        }
    }
}
