//! A part of a job: a JSON file, and the files that it names.

use super::error::VectoError;
use ocmc_io::table::source::read_text;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Texts that VECTO writes where there is no file.
const NO_FILE: [&str; 3] = ["", "-", "<NOFILE>"];

/// A JSON file of VECTO: its contents are under `Body`.
#[derive(Deserialize)]
struct Document {
    #[serde(rename = "Header", default)]
    header: Value,
    #[serde(rename = "Body")]
    body: Value,
}

/// A part before its keys are looked at.
pub(super) struct Part {
    path: PathBuf,
    /// Version of the form of the file.
    pub(super) version: Option<u32>,
    /// Values of its body.
    pub(super) body: Value,
}

impl Part {
    /// Reads a part.
    pub(super) fn read(path: &Path) -> Result<Self, VectoError> {
        let text = read_text(path)?;
        if !text.trim_start_matches(['\u{feff}', ' ', '\t', '\r', '\n']).starts_with('{') {
            let allowed =
                "allowed are files of VECTO 2 and 3: open the job in one of them and save it";
            return Err(VectoError::Unsupported {
                path: path.to_owned(),
                what: "its form",
                found: "no JSON, as of VECTO 1".to_owned(),
                allowed,
            });
        }
        let document: Document =
            serde_json::from_str(&text).map_err(|error| json_error(path, &error))?;
        let version = number(&document.header["FileVersion"]);
        Ok(Self {
            path: path.to_owned(),
            version: version.map(|version| version as u32),
            body: document.body,
        })
    }

    /// Its keys.
    pub(super) fn keys<T: DeserializeOwned>(self) -> Result<T, VectoError> {
        serde_json::from_value(self.body).map_err(|error| json_error(&self.path, &error))
    }

    /// Refuses a part that is not computed here.
    pub(super) fn refused<T>(
        &self,
        what: &'static str,
        found: String,
        allowed: &'static str,
    ) -> Result<T, VectoError> {
        Err(VectoError::Unsupported { path: self.path.clone(), what, found, allowed })
    }
}

fn json_error(path: &Path, error: &serde_json::Error) -> VectoError {
    VectoError::Json(path.to_owned(), error.to_string())
}

/// Reads the keys of a part.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> Result<T, VectoError> {
    Part::read(path)?.keys()
}

/// A number, also in quotation marks; none in an empty text.
pub(super) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::String(text) => text.trim().parse().ok(),
        value => value.as_f64(),
    }
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
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|file| {
            file.file_name().is_some_and(|have| plain(&have.to_string_lossy()) == wanted)
        })
        .collect();
    files.sort();
    let not_there = || VectoError::NotThere { path: path.to_owned(), name: name.to_owned() };
    files.into_iter().next().ok_or_else(not_there)
}

/// A name without case, with `_` for blanks.
fn plain(name: &str) -> String {
    name.to_lowercase().replace(' ', "_")
}
