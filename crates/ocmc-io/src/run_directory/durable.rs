//! Files that are there whole or not at all, whatever happens to the machine.

use super::error::RunDirectoryError;
use crate::file_error::FileError;
use std::fs::{self, File};
use std::io::ErrorKind::PermissionDenied;
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
    sync(path.parent().unwrap_or(Path::new(".")))
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

/// Creates a directory, and those around it that are missing, with their names down to the disk.
pub(super) fn create_directories(path: &Path) -> Result<(), RunDirectoryError> {
    let changed = changed_by_creating(path);
    fs::create_dir_all(path).map_err(FileError::create(path))?;
    changed.into_iter().try_for_each(|directory| match sync(directory) {
        // whoever may put names into a directory need not be allowed to read it, and so to sync it
        Err(RunDirectoryError::File(error)) if error.source.kind() == PermissionDenied => Ok(()),
        synced => synced,
    })
}

/// Directories that get another name in them where a directory is created.
fn changed_by_creating(path: &Path) -> Vec<&Path> {
    let missing = path.ancestors().take_while(|directory| !directory.exists());
    let around = missing.filter_map(Path::parent);
    // a name alone stands in the directory of the program
    around
        .map(|around| if around.as_os_str().is_empty() { Path::new(".") } else { around })
        .collect()
}

/// Makes sure that a file, or the names in a directory, are on the disk.
pub(super) fn sync(path: &Path) -> Result<(), RunDirectoryError> {
    // elsewhere a directory cannot be opened as a file, nor a file synced that may only be read
    if !cfg!(unix) {
        return Ok(());
    }
    let synced = File::open(path).and_then(|opened| opened.sync_all());
    Ok(synced.map_err(FileError::write(path))?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_new_directory_has_its_name_synced() {
        let folder = tempfile::tempdir().expect("a directory");
        let (there, path) = (folder.path(), folder.path().join("runs/a"));
        assert_eq!(changed_by_creating(&path), [there.join("runs").as_path(), there]);
        create_directories(&path).expect("space");
        assert!(path.is_dir() && changed_by_creating(&path).is_empty());
        assert_eq!(changed_by_creating(Path::new("nowhere")), [Path::new(".")]);
    }
}
