//! A part of a job: a JSON file, and the files that it names.

use super::error::VectoError;
use ocmc_io::table::source::read_text;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// What VECTO writes where there is no file.
const NO_FILE: [&str; 3] = ["", "-", "<NOFILE>"];

/// A JSON file of VECTO: its contents are under `Body`.
#[derive(Deserialize)]
struct Document<T> {
    #[serde(rename = "Body")]
    body: T,
}

/// Reads a part.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> Result<T, VectoError> {
    let text = read_text(path)?;
    let document: Document<T> = serde_json::from_str(&text)
        .map_err(|error| VectoError::Json(path.to_owned(), error.to_string()))?;
    Ok(document.body)
}

/// Whether a name means a file.
pub(super) fn names_file(name: &str) -> bool {
    !NO_FILE.contains(&name.trim())
}

/// The file that another one names: beside it, or below it as the name says; letters of either
/// case, blanks as `_`, and no folder of a machine on which it was written.
pub(super) fn beside(path: &Path, name: &str) -> Result<PathBuf, VectoError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let relative = name.trim().replace('\\', "/");
    let stated = folder.join(&relative);
    if stated.is_file() {
        return Ok(stated);
    }
    let wanted = plain(relative.rsplit('/').next().unwrap_or(&relative));
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut found: Vec<PathBuf> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|file| {
            file.file_name().is_some_and(|have| plain(&have.to_string_lossy()) == wanted)
        })
        .collect();
    found.sort();
    let not_there = || VectoError::NotThere { path: path.to_owned(), name: name.to_owned() };
    found.into_iter().next().ok_or_else(not_there)
}

/// A name without case, with `_` for blanks.
fn plain(name: &str) -> String {
    name.to_lowercase().replace(' ', "_")
}
