//! Folders of runs: those of the groups of a fleet, each with its own directory.

use super::{MANIFEST, RunDirectoryError, check_free};
use serde::Deserialize;
use std::fs;
use std::path::{Path, PathBuf};

/// Name of the answer of a fleet, beside the runs of its groups.
pub const FLEET: &str = "fleet.json";

/// Name of its page, as of the report of a run.
const PAGE: &str = "report.html";

/// The names in the answer of a fleet.
#[derive(Deserialize)]
struct Groups {
    groups: Vec<Group>,
}

/// The name of a group.
#[derive(Deserialize)]
struct Group {
    group: String,
}

/// Directories of the runs that a folder holds: those of a fleet in the order of its groups,
/// whether they are there or not, and others by their names. None of a folder that is a run itself.
pub fn runs_in(folder: &Path) -> Vec<PathBuf> {
    if folder.join(MANIFEST).exists() {
        return Vec::new();
    }
    let text = fs::read_to_string(folder.join(FLEET)).unwrap_or_default();
    let groups =
        serde_json::from_str(&text).map_or_else(|_| Vec::new(), |Groups { groups }| groups);
    // a name that leads out of the folder is none of a group
    let is_name =
        |name: &String| Path::new(name).file_name().is_some_and(|own| own == name.as_str());
    let names = groups.into_iter().map(|Group { group }| group).filter(is_name);
    let mut runs: Vec<PathBuf> = names.map(|name| folder.join(name)).collect();
    let below = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut others: Vec<PathBuf> =
        below.filter(|path| path.join(MANIFEST).exists() && !runs.contains(path)).collect();
    others.sort();
    runs.append(&mut others);
    runs
}

/// Checks that the runs of a fleet's groups may be written to a folder.
///
/// # Errors
/// [`RunDirectoryError::Exists`] where the folder, or a group of it, holds a run, or the folder
/// another fleet, or a report.
pub fn check_free_of_groups(folder: &Path, groups: &[&str]) -> Result<(), RunDirectoryError> {
    check_free(folder)?;
    for group in groups {
        check_free(&folder.join(group))?;
    }
    let taken = [(FLEET, "the answer of a fleet"), (PAGE, "a report")];
    let Some((name, content)) = taken.into_iter().find(|(name, _)| folder.join(name).exists())
    else {
        return Ok(());
    };
    let (path, what) = (folder.to_owned(), format!("`{name}`, {content}"));
    Err(RunDirectoryError::Exists { path, what, unfinished: false })
}
