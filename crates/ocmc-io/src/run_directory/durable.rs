//! Files that are there whole or not at all, whatever happens to the machine.

use super::error::RunDirectoryError;
use crate::file_error::FileError;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Where a file is written before it takes its place.
pub(super) fn temporary(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".tmp");
    PathBuf::from(name)
}

/// Replaces a file in one go: `write` writes its successor, down to the disk, to [`temporary`]. A
/// reader of the file sees the old one or the new one, and after a power cut, too.
pub(super) fn replaced(
    path: &Path,
    write: impl FnOnce() -> Result<(), RunDirectoryError>,
) -> Result<(), RunDirectoryError> {
    let temporary = temporary(path);
    // left by a program that was ended while it wrote
    let _ = fs::remove_file(&temporary);
    let renamed =
        write().and_then(|()| Ok(fs::rename(&temporary, path).map_err(FileError::write(path))?));
    if renamed.is_err() {
        // a remnant would do no harm; what matters is the first error
        let _ = fs::remove_file(&temporary);
    }
    renamed?;
    sync_directory(path.parent().unwrap_or(Path::new(".")))
}

/// Replaces a file by a text, in one go.
pub(super) fn replace(path: &Path, text: &[u8]) -> Result<(), RunDirectoryError> {
    replaced(path, || {
        let write = || {
            let mut file = File::create(temporary(path))?;
            file.write_all(text)?;
            file.sync_all()
        };
        Ok(write().map_err(FileError::write(path))?)
    })
}

/// Makes sure that the names in a directory are on the disk.
pub(super) fn sync_directory(directory: &Path) -> Result<(), RunDirectoryError> {
    // elsewhere a directory cannot be opened as a file
    if !cfg!(unix) {
        return Ok(());
    }
    let synced = File::open(directory).and_then(|opened| opened.sync_all());
    Ok(synced.map_err(FileError::write(directory))?)
}
