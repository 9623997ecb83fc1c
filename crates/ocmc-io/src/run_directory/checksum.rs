//! Checksums of a run directory: whether a file still is what was written.
//!
//! `checksums.sha256` has a line for each file, in the form that `sha256sum -c` reads: those of the
//! chunks while a run lasts, and of all files once it has ended. A line is written before its file
//! takes its place, so that a program that ends in any moment leaves no file without one; of a file
//! that was written twice either line may be the one that holds. The manifest has its own sum in
//! itself: SHA-256 of its text with nothing between the quotes of `manifest_sha256`.

use super::durable::{replace, sync};
use super::error::RunDirectoryError;
use crate::file_error::FileError;
use crate::input_file;
use crate::sha256;
use std::collections::BTreeMap;
use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Name of the file of checksums.
pub const CHECKSUMS: &str = "checksums.sha256";

/// Digits of a sum.
const DIGITS: usize = 64;

/// The checksums of a run directory.
#[derive(Clone, Debug)]
pub(super) struct Checksums {
    directory: PathBuf,
    /// Sum and name, in the order of the lines.
    lines: Vec<(String, String)>,
}

impl Checksums {
    /// None yet: the file is created, or emptied.
    pub(super) fn create(directory: &Path) -> Result<Self, RunDirectoryError> {
        let new = Self { directory: directory.to_owned(), lines: Vec::new() };
        new.write()?;
        Ok(new)
    }

    /// Reads them; none where a directory has no such file.
    pub(super) fn read(directory: &Path) -> Result<Option<Self>, RunDirectoryError> {
        let path = directory.join(CHECKSUMS);
        if path.is_symlink() {
            return Err(damaged(&path, "it is a symbolic link, and what it names is not ours"));
        }
        let text = match input_file::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) if error.kind() == io::ErrorKind::InvalidData => {
                return Err(damaged(&path, "it is no text"));
            }
            Err(error) => return Err(FileError::read(&path)(error).into()),
        };
        // a line without an end was being written when the program ended: its file was not
        let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        let lines = whole.lines().map(|line| {
            let (sum, name) = line.split_once("  ").unwrap_or_default();
            let is_sum = sum.len() == DIGITS && sum.bytes().all(|digit| digit.is_ascii_hexdigit());
            (is_sum && !name.is_empty())
                .then(|| (sum.to_owned(), name.to_owned()))
                .ok_or_else(|| damaged(&path, &format!("`{line}` is no checksum and name")))
        });
        let lines = lines.collect::<Result<_, _>>()?;
        Ok(Some(Self { directory: directory.to_owned(), lines }))
    }

    /// Names of the files, each once.
    pub(super) fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.lines.iter().map(|(_, name)| name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// Adds the sums of files that are about to take their places, with their names, down to the
    /// disk.
    pub(super) fn add(&mut self, lines: Vec<(String, String)>) -> Result<(), RunDirectoryError> {
        let path = self.directory.join(CHECKSUMS);
        let text: Vec<String> =
            lines.iter().map(|(sum, name)| format!("{sum}  {name}\n")).collect();
        let append = || {
            let mut file = OpenOptions::new().append(true).open(&path)?;
            file.write_all(text.concat().as_bytes())?;
            file.sync_all()
        };
        append().map_err(FileError::write(&path))?;
        self.lines.extend(lines);
        Ok(())
    }

    /// Puts one sum in the place of all others of its file. [`Checksums::write`] keeps it.
    pub(super) fn set(&mut self, name: &str, sum: String) {
        self.lines.retain(|(_, other)| other != name);
        self.lines.push((sum, name.to_owned()));
    }

    /// Keeps the sums of some files only. [`Checksums::write`] keeps it.
    pub(super) fn retain(&mut self, keep: impl Fn(&str) -> bool) {
        self.lines.retain(|(_, name)| keep(name));
    }

    /// Replaces the file of sums, in one go, each file in it once: by its last line.
    pub(super) fn write(&self) -> Result<(), RunDirectoryError> {
        let last: BTreeMap<&str, &str> = self.lines.iter().map(|(s, n)| (&n[..], &s[..])).collect();
        let lines = last.into_iter().map(|(name, sum)| format!("{sum}  {name}\n"));
        replace(&self.directory.join(CHECKSUMS), lines.collect::<String>().as_bytes())
    }

    /// Checks a file against its sum.
    ///
    /// # Errors
    /// [`RunDirectoryError::Changed`], and where the file cannot be read.
    pub(super) fn check(&self, name: &str) -> Result<(), RunDirectoryError> {
        let path = self.directory.join(name);
        let sum_of_file = sha256::of_file(&path).map_err(FileError::read(&path))?;
        let mut sums = self.lines.iter().filter(|(_, other)| other == name).peekable();
        if sums.peek().is_none() {
            return Err(RunDirectoryError::without_sum(&self.directory, name));
        }
        if sums.any(|(sum, _)| *sum == sum_of_file) {
            return Ok(());
        }
        Err(RunDirectoryError::Changed(path))
    }
}

/// Notes the sum of a file that was written to a run directory, where that has checksums. The file
/// is on the disk before its sum.
///
/// # Errors
/// Where the checksums or the file cannot be read, or one of them cannot be written.
pub fn note_file(directory: &Path, name: &str) -> Result<(), RunDirectoryError> {
    let Some(mut sums) = Checksums::read(directory)? else { return Ok(()) };
    let path = directory.join(name);
    sums.set(name, sha256::of_file(&path).map_err(FileError::read(&path))?);
    sync(&path)?;
    sync(directory)?;
    sums.write()
}

fn damaged(path: &Path, reason: &str) -> RunDirectoryError {
    RunDirectoryError::Damaged(path.to_owned(), reason.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn either_line_of_a_file_holds_and_a_torn_one_does_not_count() {
        let folder = tempfile::tempdir().expect("a directory");
        let (a, b) = (folder.path().join("a"), folder.path().join("b"));
        let mut sums = Checksums::create(folder.path()).expect("space");
        fs::write(&a, "1").expect("space");
        fs::write(&b, "2").expect("space");
        for file in [&a, &b] {
            let sum = sha256::of_file(file).expect("there");
            sums.add(vec![(sum, "a".to_owned())]).expect("space");
        }
        fs::write(folder.path().join(CHECKSUMS), {
            let text = fs::read_to_string(folder.path().join(CHECKSUMS)).expect("text");
            format!("{text}0123  torn")
        })
        .expect("space");
        let sums = Checksums::read(folder.path()).expect("sums").expect("there");
        assert_eq!(sums.names(), ["a"]);
        sums.check("a").expect("the first line");
        fs::write(&a, "2").expect("space");
        sums.check("a").expect("the second line");
        fs::write(&a, "3").expect("space");
        let error = sums.check("a").expect_err("changed").to_string();
        assert!(error.contains("changed since it was written"), "{error}");
        let error = sums.check("b").expect_err("no sum").to_string();
        assert!(error.contains("no checksum of it"), "{error}");
    }
}
